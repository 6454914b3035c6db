//! What acts on the aircraft at one sample, whatever its motion.

use nalgebra::Vector3;

use super::ReplayError;
use crate::model::{
    AeroData, CoefficientSettings, RECORDED, RecordedValues, ThrustTreatment, Variable, Variables, angular_momentum,
};
use crate::motion::FactoredInertia;

/// Controls, air, engines and loading at one instant.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "names say it")]
pub struct Sample {
    /// Aileron, elevator, rudder after their lags, rad; zero where not recorded.
    pub controls_rad: [f64; 3],
    /// Flaps, trims and what else the model takes as recorded; zero where it is not.
    pub recorded: RecordedValues,
    /// Air density, kg/m³.
    pub density_kg_m3: f64,
    /// Speed of sound, m/s; infinite where not recorded.
    pub speed_of_sound_m_s: f64,
    pub wind_ned_m_s: Vector3<f64>,
    /// Sum of the thrusts, N.
    pub thrust_n: f64,
    pub thrust_force_n: Vector3<f64>,
    /// Moment of the thrust about the centre of gravity, N m.
    pub thrust_moment_n_m: Vector3<f64>,
    /// Total-pressure rise through the propellers, Pa.
    pub pressure_rise_pa: f64,
    /// Angular momentum of the rotors, kg m²/s.
    pub rotor_momentum_n_m_s: Vector3<f64>,
    /// Moment reference from the centre of gravity in body axes, m.
    pub reference_arm_m: Vector3<f64>,
    pub mass_kg: f64,
    /// Inertia about the centre of gravity.
    pub inertia: FactoredInertia,
    /// Added to the coefficients `CX CY CZ Cl Cm Cn` of the model.
    pub disturbance: [f64; 6],
}

impl Sample {
    /// Sample `k` of a window that was checked.
    pub(super) fn new(
        data: &AeroData,
        settings: &CoefficientSettings,
        variables: &Variables,
        wind_ned_m_s: &[Vec<f64>; 3],
        k: usize,
    ) -> Result<Self, ReplayError> {
        let loaded = data.mass.at(k);
        let (airspeed, density) = (data.airspeed_m_s[k], data.density_kg_m3[k]);
        let control = |variable| variables.get(variable).map_or(0.0, |column| column[k]);
        let (mut thrust_force_n, mut thrust_moment_n_m) = (Vector3::zeros(), Vector3::zeros());
        for engine in &data.engines {
            let force = Vector3::from(engine.direction_body) * engine.thrust_n[k];
            thrust_force_n += force;
            let arm = Vector3::from(engine.position.body_from_cg_m(loaded.cg_from_datum_m));
            thrust_moment_n_m += arm.cross(&force);
        }
        match settings.thrust {
            ThrustTreatment::Included => (thrust_force_n, thrust_moment_n_m) = Default::default(),
            ThrustTreatment::ForceRemoved => thrust_moment_n_m = Vector3::zeros(),
            ThrustTreatment::Removed => {}
        }
        let rotors = angular_momentum(&data.engines, settings.gyroscopic, k);
        let arm = settings.moment_reference.map_or([0.0; 3], |point| point.body_from_cg_m(loaded.cg_from_datum_m));
        let mach = data.mach.as_ref().map_or(0.0, |mach| mach[k]);
        let pressure_over_q = data.propeller_pressure.as_ref().map_or(0.0, |rise| rise[k]);
        Ok(Self {
            controls_rad: [Variable::Aileron, Variable::Elevator, Variable::Rudder].map(control),
            recorded: RECORDED.map(|(variable, _)| control(variable)),
            density_kg_m3: density,
            speed_of_sound_m_s: if mach > 0.0 { airspeed / mach } else { f64::INFINITY },
            wind_ned_m_s: Vector3::from(wind_ned_m_s.each_ref().map(|column| column[k])),
            thrust_n: data.engines.iter().map(|engine| engine.thrust_n[k]).sum(),
            thrust_force_n,
            thrust_moment_n_m,
            pressure_rise_pa: pressure_over_q * 0.5 * density * airspeed * airspeed,
            rotor_momentum_n_m_s: Vector3::new(rotors, 0.0, 0.0),
            reference_arm_m: Vector3::from(arm),
            mass_kg: loaded.mass_kg,
            inertia: FactoredInertia::new(&loaded.inertia).ok_or(ReplayError::Inertia { time_s: data.time_s[k] })?,
            disturbance: [0.0; 6],
        })
    }

    /// Between this sample and the next: linear, with the inertia of this one, which hardly changes over a step.
    pub(super) fn towards(&self, next: &Self, fraction: f64) -> Self {
        let between = |a: f64, b: f64| a + (b - a) * fraction;
        Self {
            controls_rad: std::array::from_fn(|i| between(self.controls_rad[i], next.controls_rad[i])),
            recorded: std::array::from_fn(|i| between(self.recorded[i], next.recorded[i])),
            density_kg_m3: between(self.density_kg_m3, next.density_kg_m3),
            speed_of_sound_m_s: if self.speed_of_sound_m_s.is_finite() && next.speed_of_sound_m_s.is_finite() {
                between(self.speed_of_sound_m_s, next.speed_of_sound_m_s)
            } else {
                f64::INFINITY
            },
            wind_ned_m_s: self.wind_ned_m_s.lerp(&next.wind_ned_m_s, fraction),
            thrust_n: between(self.thrust_n, next.thrust_n),
            thrust_force_n: self.thrust_force_n.lerp(&next.thrust_force_n, fraction),
            thrust_moment_n_m: self.thrust_moment_n_m.lerp(&next.thrust_moment_n_m, fraction),
            pressure_rise_pa: between(self.pressure_rise_pa, next.pressure_rise_pa),
            rotor_momentum_n_m_s: self.rotor_momentum_n_m_s.lerp(&next.rotor_momentum_n_m_s, fraction),
            reference_arm_m: self.reference_arm_m.lerp(&next.reference_arm_m, fraction),
            mass_kg: between(self.mass_kg, next.mass_kg),
            inertia: self.inertia,
            disturbance: std::array::from_fn(|i| between(self.disturbance[i], next.disturbance[i])),
        }
    }
}
