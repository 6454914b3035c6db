//! Linear models of an identified aircraft about a trim, their parts and their errors.

use doublet_core::replay::MotionAxis;
use nalgebra::DMatrix;

use super::flight::{Equations, INPUT_NAMES, INPUTS, InputVector, STATE_NAMES, STATES, StateVector};
use super::state_space::{Quantity, StateSpace, state};
use super::{Condition, FlightModel, LinearError, Trim, analytic, trim};

/// Names and units of the outputs beside the states.
const AIR_OUTPUTS: [(&str, &str); 6] =
    [("V", "m/s"), ("alpha", "rad"), ("beta", "rad"), ("ax", "m/s^2"), ("ay", "m/s^2"), ("az", "m/s^2")];

/// How the slopes are formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Chain rule over the terms of the model.
    Analytic,
    /// Central differences of the equations of motion.
    Differences,
}

/// A part of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All twelve states.
    Full,
    /// Without heading, position and altitude: `u v w p q r phi theta`.
    Motion,
    /// `u w q theta`.
    Longitudinal,
    /// `V alpha q theta`.
    LongitudinalAir,
    /// `v p r phi`.
    Lateral,
    /// `beta p r phi`.
    LateralAir,
    /// `w q` at constant speed.
    ShortPeriod,
    /// `p` alone.
    Roll,
}

impl Part {
    doublet_core::named_variants! {
        /// Name, also that of the variable in files.
        pub name:
            Full "full", Motion "motion", Longitudinal "longitudinal", LongitudinalAir "longitudinal_air",
            Lateral "lateral", LateralAir "lateral_air", ShortPeriod "short_period", Roll "roll",
    }

    /// States in body velocities.
    fn states(self) -> &'static [&'static str] {
        match self {
            Self::Full => &STATE_NAMES,
            Self::Motion => &["u", "v", "w", "p", "q", "r", "phi", "theta"],
            Self::Longitudinal | Self::LongitudinalAir => &["u", "w", "q", "theta"],
            Self::Lateral | Self::LateralAir => &["v", "p", "r", "phi"],
            Self::ShortPeriod => &["w", "q"],
            Self::Roll => &["p"],
        }
    }

    fn shown_states(self) -> &'static [&'static str] {
        match self {
            Self::LongitudinalAir => &["V", "alpha", "q", "theta"],
            Self::LateralAir => &["beta", "p", "r", "phi"],
            _ => self.states(),
        }
    }

    fn inputs(self) -> &'static [&'static str] {
        match self {
            Self::Full | Self::Motion => &["delta_a", "delta_e", "delta_r", "thrust"],
            Self::Longitudinal | Self::LongitudinalAir => &["delta_e", "thrust"],
            Self::Lateral | Self::LateralAir => &["delta_a", "delta_r"],
            Self::ShortPeriod => &["delta_e"],
            Self::Roll => &["delta_a"],
        }
    }

    /// Outputs beside the states.
    fn air_outputs(self) -> &'static [&'static str] {
        match self {
            Self::Full | Self::Motion => &["V", "alpha", "beta", "ax", "ay", "az"],
            Self::Longitudinal => &["V", "alpha", "ax", "az"],
            Self::LongitudinalAir => &["ax", "az"],
            Self::Lateral => &["beta", "ay"],
            Self::LateralAir => &["ay"],
            Self::ShortPeriod => &["alpha", "az"],
            Self::Roll => &[],
        }
    }

    /// Whether a model that can fly `motion` has this part.
    pub fn within(self, motion: MotionAxis) -> bool {
        let longitudinal = matches!(self, Self::Longitudinal | Self::LongitudinalAir | Self::ShortPeriod);
        longitudinal || motion == MotionAxis::Both
    }
}

/// A linear model of the whole motion about a trim.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearised {
    /// The trim.
    pub trim: Trim,
    /// Twelve states; outputs are the states, then airspeed, flow angles and the specific force at the centre of gravity.
    pub full: StateSpace,
}

/// Trims and linearises.
pub fn linearise(model: &FlightModel, condition: &Condition, method: Method) -> Result<Linearised, LinearError> {
    let trim = trim(model, condition)?;
    linearise_at(model, &trim, method)
}

/// Linearises about a trim that is known.
pub fn linearise_at(model: &FlightModel, trim: &Trim, method: Method) -> Result<Linearised, LinearError> {
    let equations = Equations::new(model, &trim.condition)?;
    let (point, input) = (trim.state(), trim.input());
    let slopes = match method {
        Method::Analytic => analytic::slopes(&equations, &point, &input)?,
        Method::Differences => differences(&equations, &point, &input),
    };
    let a = DMatrix::from_fn(STATES, STATES, |i, j| slopes[(i, j)]);
    let b = DMatrix::from_fn(STATES, INPUTS, |i, j| slopes[(i, STATES + j)]);
    let mut full = StateSpace::of_states("full", &STATE_NAMES, &INPUT_NAMES, a, b);
    add_air_outputs(&mut full, &equations, &point);
    Ok(Linearised { trim: trim.clone(), full })
}

/// Central differences of the equations of motion.
fn differences(equations: &Equations<'_>, state: &StateVector, input: &InputVector) -> analytic::Slopes {
    /// Steps of the states and inputs: m/s, rad/s, rad, m, rad, N.
    const STEPS: [f64; STATES + INPUTS] =
        [1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1.0, 1.0, 1.0, 1e-5, 1e-5, 1e-5, 1.0];
    let mut slopes = analytic::Slopes::zeros();
    for (column, step) in STEPS.into_iter().enumerate() {
        let rates = |step: f64| rates_beside(equations, (*state, *input), column, step);
        let slope: StateVector = (rates(step) - rates(-step)) / (2.0 * step);
        slopes.set_column(column, &slope);
    }
    slopes
}

fn rates_beside(
    equations: &Equations<'_>,
    (mut state, mut input): (StateVector, InputVector),
    column: usize,
    step: f64,
) -> StateVector {
    if column < STATES {
        state[column] += step;
    } else {
        input[column - STATES] += step;
    }
    equations.rates(&state, &input).0
}

/// Appends airspeed, flow angles and specific force. The specific force is the acceleration less gravity plus `w x V`.
fn add_air_outputs(full: &mut StateSpace, equations: &Equations<'_>, point: &StateVector) {
    let (u, v, w) = (point[0], point[1], point[2]);
    let (airspeed, in_plane) = ((u * u + v * v + w * w).sqrt(), u * u + w * w);
    let mut c = DMatrix::zeros(STATES + AIR_OUTPUTS.len(), STATES);
    let mut d = DMatrix::zeros(STATES + AIR_OUTPUTS.len(), INPUTS);
    c.view_mut((0, 0), (STATES, STATES)).fill_with_identity();
    for (column, velocity) in [u, v, w].into_iter().enumerate() {
        c[(STATES, column)] = velocity / airspeed;
    }
    c[(STATES + 1, 0)] = -w / in_plane;
    c[(STATES + 1, 2)] = u / in_plane;
    c[(STATES + 2, 1)] = in_plane.sqrt() / (airspeed * airspeed);
    let [p, q, r] = [point[3], point[4], point[5]];
    let [(sin_phi, cos_phi), (sin_theta, cos_theta)] = [point[6], point[7]].map(f64::sin_cos);
    let g = equations.condition.gravity_m_s2;
    // Of `w x V` less gravity in body axes, over `u v w p q r phi theta`.
    let kinematic: [[f64; 8]; 3] = [
        [0.0, -r, q, 0.0, w, -v, 0.0, g * cos_theta],
        [r, 0.0, -p, -w, 0.0, u, -g * cos_phi * cos_theta, g * sin_phi * sin_theta],
        [-q, p, 0.0, v, -u, 0.0, g * sin_phi * cos_theta, g * cos_phi * sin_theta],
    ];
    for (axis, row) in kinematic.iter().enumerate() {
        for column in 0..STATES {
            c[(STATES + 3 + axis, column)] = full.a[(axis, column)] + row.get(column).copied().unwrap_or(0.0);
        }
        for column in 0..INPUTS {
            d[(STATES + 3 + axis, column)] = full.b[(axis, column)];
        }
    }
    full.outputs.extend(AIR_OUTPUTS.iter().map(|(name, unit)| Quantity::new(name, unit)));
    (full.c, full.d) = (c, d);
}

impl Linearised {
    /// A part of the motion, the states of the rest held at the trim.
    pub fn part(&self, part: Part) -> StateSpace {
        let outputs: Vec<&str> = part.states().iter().chain(part.air_outputs()).copied().collect();
        let body = self.full.part(part.name(), part.states(), part.inputs(), &outputs);
        if part.states() == part.shown_states() {
            return body;
        }
        // Airspeed and flow angles in the place of the velocities: rows of the outputs of the whole motion.
        let shown: Vec<Quantity> = part.shown_states().iter().map(|name| state(name)).collect();
        let row = |name: &str| self.full.output(name);
        let transform = DMatrix::from_fn(shown.len(), shown.len(), |i, j| {
            let column = self.full.state(part.states()[j]);
            row(&shown[i].name).zip(column).map_or(0.0, |(row, column)| self.full.c[(row, column)])
        });
        let air = self.full.part(
            part.name(),
            part.states(),
            part.inputs(),
            &[part.shown_states(), part.air_outputs()].concat(),
        );
        air.transformed(shown, &transform).unwrap_or(body)
    }

    /// The parts this model has.
    pub fn parts(&self) -> impl Iterator<Item = StateSpace> + '_ {
        Part::ALL.into_iter().filter(|part| part.within(self.trim.motion)).map(|part| self.part(part))
    }

    /// What of the motion modes are looked for in: all of it but heading, position and altitude, or the longitudinal part where no
    /// more is modelled.
    pub fn motion(&self) -> StateSpace {
        self.part(if self.trim.motion == MotionAxis::Both { Part::Motion } else { Part::Longitudinal })
    }
}
