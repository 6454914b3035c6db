//! Forces and moments of a model at one instant.

use nalgebra::{Matrix3, Vector3};

use super::sample::Sample;
use crate::airframe::ReferenceGeometry;
use crate::model::{Axes, Derivatives, RECORDED, Variable, VariableValues};
use crate::motion::Airflow;

/// Change of the rates of the flow angles, without dimension, at which their equation counts as solved.
const RATE_TOLERANCE: f64 = 1e-13;
/// Passes over that equation; a pass shrinks the error by the virtual mass over the mass, a per cent or so.
const MAX_PASSES: usize = 12;

/// Motion at one instant, as far as forces and moments hang on it.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Velocity relative to the air in body axes, m/s.
    pub velocity_body_m_s: Vector3<f64>,
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: Vector3<f64>,
    /// Rotation from local Earth to body axes.
    pub body_from_ned: Matrix3<f64>,
    /// Altitude, m.
    pub altitude_m: f64,
}

/// What acts at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Loads {
    /// Flow.
    pub air: Airflow,
    /// Coefficients `CX CY CZ Cl Cm Cn`, in the axes and about the reference of the model.
    pub coefficients: [f64; 6],
    /// At the centre of gravity in body axes, m/s².
    pub specific_force_m_s2: Vector3<f64>,
    /// About the centre of gravity in body axes, N m.
    pub moment_n_m: Vector3<f64>,
}

/// Forces and moments of a model: what its coefficients are in the motion and the conditions of one instant.
#[derive(Clone, Copy, Debug)]
pub struct Forces<'a> {
    model: &'a Derivatives,
    reference: ReferenceGeometry,
    axes: Axes,
    gravity_m_s2: f64,
    unsteady: bool,
}

impl<'a> Forces<'a> {
    /// Of `model`, whose coefficients are those of `reference` and whose moments and rates are along `axes`.
    pub fn new(model: &'a Derivatives, reference: ReferenceGeometry, axes: Axes, gravity_m_s2: f64) -> Self {
        let unsteady = model.term_of(Variable::AlphaDot).is_some() || model.term_of(Variable::BetaDot).is_some();
        Self { model, reference, axes, gravity_m_s2, unsteady }
    }

    /// Reference area and lengths.
    pub fn reference(&self) -> &ReferenceGeometry {
        &self.reference
    }

    /// Forces and moments of the model; `recorded_m_s2` has the specific force along the axes the model is not asked about.
    pub fn loads(&self, instant: &Instant, sample: &Sample, recorded_m_s2: [Option<f64>; 3]) -> Loads {
        let velocity = instant.velocity_body_m_s;
        let air = Airflow::new(velocity, sample.density_kg_m3);
        let mut values = self.variables(instant, &air, sample);
        let mut coefficients = self.coefficients(&values, sample);
        if self.unsteady {
            let gravity_body = instant.body_from_ned.column(2) * self.gravity_m_s2;
            for _ in 0..MAX_PASSES {
                let aerodynamic = self.aerodynamic_force(&coefficients, &air, sample, recorded_m_s2);
                let force = (aerodynamic + sample.thrust_force_n) / sample.mass_kg;
                let acceleration = force + gravity_body - instant.rates_rad_s.cross(&velocity);
                let before = [values[Variable::AlphaDot as usize], values[Variable::BetaDot as usize]];
                self.set_flow_rates(&mut values, &air, &acceleration);
                let change = (values[Variable::AlphaDot as usize] - before[0])
                    .abs()
                    .max((values[Variable::BetaDot as usize] - before[1]).abs());
                coefficients = self.coefficients(&values, sample);
                if change < RATE_TOLERANCE {
                    break;
                }
            }
        }
        let aerodynamic_n = self.aerodynamic_force(&coefficients, &air, sample, recorded_m_s2);
        Loads {
            air,
            coefficients,
            specific_force_m_s2: (aerodynamic_n + sample.thrust_force_n) / sample.mass_kg,
            moment_n_m: self.moment(&coefficients, &aerodynamic_n, &air, sample),
        }
    }

    /// Coefficients of the model and what disturbs them.
    fn coefficients(&self, values: &VariableValues, sample: &Sample) -> [f64; 6] {
        let modelled = self.model.body_coefficients(values);
        std::array::from_fn(|i| modelled[i] + sample.disturbance[i])
    }

    /// Force of the coefficients, or what the recorded specific force leaves for it, N.
    fn aerodynamic_force(
        &self,
        [cx, cy, cz, ..]: &[f64; 6],
        air: &Airflow,
        sample: &Sample,
        recorded_m_s2: [Option<f64>; 3],
    ) -> Vector3<f64> {
        let mut force = Vector3::new(*cx, *cy, *cz) * (air.dynamic_pressure_pa * self.reference.area_m2);
        for (axis, recorded) in recorded_m_s2.into_iter().enumerate() {
            if let Some(specific) = recorded {
                force[axis] = specific * sample.mass_kg - sample.thrust_force_n[axis];
            }
        }
        force
    }

    /// Moment about the centre of gravity in body axes, N m.
    fn moment(
        &self,
        coefficients: &[f64; 6],
        aerodynamic_n: &Vector3<f64>,
        air: &Airflow,
        sample: &Sample,
    ) -> Vector3<f64> {
        let reference = &self.reference;
        let [.., cl, cm, cn] = *coefficients;
        let scale = air.dynamic_pressure_pa * reference.area_m2;
        let lateral = scale * reference.lateral_moment_length_m;
        let (l, m, n) = (lateral * cl, scale * reference.chord_m * cm, lateral * cn);
        let about_reference = match self.axes {
            Axes::Body => Vector3::new(l, m, n),
            Axes::Stability => {
                let (sin, cos) = libm::sincos(air.alpha_rad);
                Vector3::new(l * cos - n * sin, m, l * sin + n * cos)
            }
        };
        let transfer = sample.reference_arm_m.cross(aerodynamic_n);
        about_reference + transfer + sample.thrust_moment_n_m
    }

    /// All variables but the rates of the flow angles, which stay zero.
    pub fn variables(&self, instant: &Instant, air: &Airflow, sample: &Sample) -> VariableValues {
        let reference = &self.reference;
        let airspeed = air.airspeed_m_s;
        let [mut p, q, mut r] = <[f64; 3]>::from(instant.rates_rad_s);
        if self.axes == Axes::Stability {
            let (sin, cos) = libm::sincos(air.alpha_rad);
            (p, r) = (p * cos + r * sin, r * cos - p * sin);
        }
        let lateral = reference.lateral_rate_length_m / airspeed;
        let mut values = [0.0; Variable::ALL.len()];
        let mut set = |variable: Variable, value: f64| values[variable as usize] = value;
        set(Variable::Alpha, air.alpha_rad);
        set(Variable::Beta, air.beta_rad);
        set(Variable::RollRate, p * lateral);
        set(Variable::PitchRate, q * (reference.pitch_rate_length_m / airspeed));
        set(Variable::HalfPitchRate, q * (reference.chord_m / 2.0 / airspeed));
        set(Variable::YawRate, r * lateral);
        let [aileron, elevator, rudder] = sample.controls_rad;
        set(Variable::Aileron, aileron);
        set(Variable::Elevator, elevator);
        set(Variable::Rudder, rudder);
        RECORDED.iter().zip(sample.recorded).for_each(|((variable, _), value)| set(*variable, value));
        set(Variable::PropellerPressure, sample.pressure_rise_pa / air.dynamic_pressure_pa);
        set(Variable::ThrustCoefficient, sample.thrust_n / (air.dynamic_pressure_pa * reference.area_m2));
        set(Variable::Airspeed, airspeed);
        set(Variable::Altitude, instant.altitude_m);
        set(Variable::Mach, airspeed / sample.speed_of_sound_m_s);
        values
    }

    /// Rates of the flow angles from the acceleration relative to the air in body axes:
    /// `alpha' = (u w' - w u') / (u^2 + w^2)`, `beta' = (v' V - v V') / (V sqrt(u^2 + w^2))`.
    fn set_flow_rates(&self, values: &mut VariableValues, air: &Airflow, acceleration: &Vector3<f64>) {
        let reference = &self.reference;
        let (velocity, airspeed) = (air.velocity_body_m_s, air.airspeed_m_s);
        let in_plane = velocity.x * velocity.x + velocity.z * velocity.z;
        let alpha_rate = (velocity.x * acceleration.z - velocity.z * acceleration.x) / in_plane;
        let airspeed_rate = velocity.dot(acceleration) / airspeed;
        let beta_rate = (acceleration.y * airspeed - velocity.y * airspeed_rate) / (airspeed * in_plane.sqrt());
        values[Variable::AlphaDot as usize] = alpha_rate * (reference.pitch_rate_length_m / airspeed);
        values[Variable::BetaDot as usize] = beta_rate * (reference.lateral_rate_length_m / airspeed);
    }
}
