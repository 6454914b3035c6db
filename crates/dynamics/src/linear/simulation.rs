//! Flight of an identified model from a trim, and the file that takes it elsewhere.

use doublet_core::airframe::{InertiaTensor, MassProperties, ReferenceGeometry};
use doublet_core::model::{Axes, Coefficient, Derivatives, Position, RecordedValues, Term, ThrustTreatment};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::flight::{Equations, INPUTS, InputVector, STATES, StateVector};
use super::{Condition, FlightModel, LinearError, SteadyFlight, ThrustLine, Trim};

/// First key of a flight-model file.
const FORMAT: &str = "doublet flight model";
/// Version of the form this reads and writes.
const VERSION: u32 = 1;

/// Outputs beside the states.
const OUTPUTS: usize = 7;
/// Names and units of the outputs beside the states; `thrust` is the thrust acting.
pub const OUTPUT_NAMES: [(&str, &str); OUTPUTS] = [
    ("airspeed", "m/s"),
    ("alpha", "rad"),
    ("beta", "rad"),
    ("ax", "m/s2"),
    ("ay", "m/s2"),
    ("az", "m/s2"),
    ("thrust", "N"),
];

/// A model, the condition about which its air changes, and where its flight begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// The aircraft.
    pub model: FlightModel,
    /// The condition: gravity, mass, air, rotors.
    pub condition: Condition,
    /// States at the start.
    pub state: [f64; STATES],
    /// Inputs at the start.
    pub input: [f64; INPUTS],
}

impl Simulation {
    /// Flight that begins in a trim.
    pub fn from_trim(model: FlightModel, trim: &Trim) -> Self {
        Self { model, condition: trim.condition, state: trim.state().into(), input: trim.input().into() }
    }

    /// Rates of the states, in their units per second, and the outputs beside the states.
    ///
    /// Equations of motion of a rigid body over a flat Earth in still air (thesis Eq. A.6-A.14), the density that of the condition and
    /// changing with altitude as the standard atmosphere's does.
    ///
    /// # Errors
    /// [`LinearError`] where the condition is none: a mass or density that is not positive, inertia no body has.
    pub fn rates(
        &self,
        state: &[f64; STATES],
        input: &[f64; INPUTS],
    ) -> Result<([f64; STATES], [f64; OUTPUTS]), LinearError> {
        let equations = Equations::new(&self.model, &self.condition)?;
        Ok(evaluate(&equations, state, input))
    }

    /// States after `duration_s` with constant inputs, by classical Runge-Kutta steps of at most `step_s`.
    pub fn advance(
        &self,
        state: &[f64; STATES],
        input: &[f64; INPUTS],
        duration_s: f64,
        step_s: f64,
    ) -> Result<[f64; STATES], LinearError> {
        let equations = Equations::new(&self.model, &self.condition)?;
        let steps = (duration_s / step_s - 1e-9).ceil().max(1.0);
        let h = duration_s / steps;
        let input = InputVector::from(*input);
        let rate = |state: &StateVector| equations.rates(state, &input).0;
        let mut x = StateVector::from(*state);
        let mut done = 0.0;
        while done < steps {
            let k1 = rate(&x);
            let k2 = rate(&(x + k1 * (h / 2.0)));
            let k3 = rate(&(x + k2 * (h / 2.0)));
            let k4 = rate(&(x + k3 * h));
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            done += 1.0;
        }
        Ok(x.into())
    }

    /// The simulation as JSON.
    ///
    /// # Errors
    /// One line when it cannot be written.
    pub fn to_json(&self) -> Result<String, String> {
        serde_json::to_string_pretty(&self.file()).map_err(|error| error.to_string())
    }

    /// The simulation in a file.
    ///
    /// # Errors
    /// One line: what is not understood.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let file: File = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(format!(
                "format \"{}\" version {} is not \"{FORMAT}\" version {VERSION}",
                file.format, file.version
            ));
        }
        file.read()
    }

    fn file(&self) -> File {
        let Self { model, condition, state, input } = self;
        File {
            format: FORMAT.to_owned(),
            version: VERSION,
            derivatives: model.derivatives.entries().iter().map(write_entry).collect(),
            reference: model.reference,
            stability_axes: model.axes == Axes::Stability,
            moment_reference: model.moment_reference,
            thrust: model.thrust,
            engines: model.engines.clone(),
            condition: condition.into(),
            state: *state,
            input: *input,
        }
    }
}

fn write_entry(entry: &doublet_core::model::Derivative) -> Entry {
    Entry { coefficient: entry.coefficient.name().to_owned(), term: entry.term.to_string(), value: entry.value }
}

/// Rates and outputs.
fn evaluate(
    equations: &Equations<'_>,
    state: &[f64; STATES],
    input: &[f64; INPUTS],
) -> ([f64; STATES], [f64; OUTPUTS]) {
    let (rates, force) = equations.rates(&StateVector::from(*state), &InputVector::from(*input));
    let velocity = Vector3::new(state[0], state[1], state[2]);
    let alpha = velocity.z.atan2(velocity.x);
    let beta = velocity.y.atan2(velocity.x.hypot(velocity.z));
    let airspeed = velocity.norm();
    let thrust = equations.condition.thrust_n(input[3], airspeed);
    (rates.into(), [airspeed, alpha, beta, force.x, force.y, force.z, thrust])
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    derivatives: Vec<Entry>,
    reference: ReferenceGeometry,
    stability_axes: bool,
    moment_reference: Option<Position>,
    thrust: ThrustTreatment,
    engines: Vec<ThrustLine>,
    condition: Air,
    state: [f64; STATES],
    input: [f64; INPUTS],
}

#[derive(Deserialize, Serialize)]
struct Entry {
    coefficient: String,
    term: String,
    value: f64,
}

#[derive(Deserialize, Serialize)]
struct Air {
    airspeed_m_s: f64,
    altitude_m: f64,
    density_kg_m3: f64,
    speed_of_sound_m_s: f64,
    gravity_m_s2: f64,
    mass_kg: f64,
    cg_from_datum_m: [f64; 3],
    inertia_kg_m2: [[f64; 3]; 3],
    thrust_slope_n_s_m: f64,
    pressure_rise_pa: f64,
    rotor_momentum_n_m_s: f64,
    /// Flaps, trims and what else the model takes as recorded; none where it takes nothing.
    #[serde(default, skip_serializing_if = "is_zero")]
    recorded: RecordedValues,
}

fn is_zero(recorded: &RecordedValues) -> bool {
    recorded.iter().all(|value| *value == 0.0)
}

impl From<&Condition> for Air {
    fn from(condition: &Condition) -> Self {
        let inertia = condition.mass.inertia.matrix();
        Self {
            airspeed_m_s: condition.airspeed_m_s,
            altitude_m: condition.altitude_m,
            density_kg_m3: condition.density_kg_m3,
            speed_of_sound_m_s: condition.speed_of_sound_m_s,
            gravity_m_s2: condition.gravity_m_s2,
            mass_kg: condition.mass.mass_kg,
            cg_from_datum_m: condition.mass.cg_from_datum_m,
            inertia_kg_m2: std::array::from_fn(|row| std::array::from_fn(|column| inertia[(row, column)])),
            thrust_slope_n_s_m: condition.thrust_slope_n_s_m,
            pressure_rise_pa: condition.pressure_rise_pa,
            rotor_momentum_n_m_s: condition.rotor_momentum_n_m_s,
            recorded: condition.recorded,
        }
    }
}

impl Air {
    fn condition(&self) -> Condition {
        let [[xx, xy, xz], [_, yy, yz], [.., zz]] = self.inertia_kg_m2;
        // Products of inertia enter the matrix with a negative sign.
        let inertia = InertiaTensor { xx, yy, zz, xz: -xz, xy: -xy, yz: -yz };
        Condition {
            airspeed_m_s: self.airspeed_m_s,
            altitude_m: self.altitude_m,
            density_kg_m3: self.density_kg_m3,
            speed_of_sound_m_s: self.speed_of_sound_m_s,
            gravity_m_s2: self.gravity_m_s2,
            gamma_rad: None,
            flight: SteadyFlight::Straight,
            mass: MassProperties { mass_kg: self.mass_kg, cg_from_datum_m: self.cg_from_datum_m, inertia },
            thrust_slope_n_s_m: self.thrust_slope_n_s_m,
            pressure_rise_pa: self.pressure_rise_pa,
            rotor_momentum_n_m_s: self.rotor_momentum_n_m_s,
            recorded: self.recorded,
        }
    }
}

impl File {
    fn read(self) -> Result<Simulation, String> {
        let derivatives = self.derivatives.iter().map(read_entry).collect::<Result<Derivatives, String>>()?;
        let model = FlightModel {
            derivatives,
            reference: self.reference,
            axes: if self.stability_axes { Axes::Stability } else { Axes::Body },
            moment_reference: self.moment_reference,
            thrust: self.thrust,
            engines: self.engines,
        };
        let simulation =
            Simulation { model, condition: self.condition.condition(), state: self.state, input: self.input };
        simulation.rates(&simulation.state, &simulation.input).map_err(|error| error.to_string())?;
        Ok(simulation)
    }
}

fn read_entry(entry: &Entry) -> Result<(Coefficient, Term, f64), String> {
    let Entry { coefficient, term, value } = entry;
    let known = Coefficient::from_name(coefficient).ok_or_else(|| format!("unknown coefficient '{coefficient}'"))?;
    let term = Term::parse(term).map_err(|error| error.to_string())?;
    Ok((known, term, *value))
}
