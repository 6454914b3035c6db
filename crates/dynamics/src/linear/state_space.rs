//! A linear model with the names and units of its states, inputs and outputs.

use doublet_core::motion::MotionState;
use nalgebra::DMatrix;

/// A state, input or output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name, for example `q` or `delta_e`.
    pub name: String,
    /// Unit.
    pub unit: String,
}

impl Quantity {
    /// A quantity called `name`, in `unit`.
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }
}

/// What every sign in a linear model of an aircraft means (`docs/conventions.md`).
pub const SIGNS: &str = "perturbations from the trim; body axes x forward, y right, z down; aileron: right one down is positive \
                         (negative roll rate); elevator: trailing edge down (negative pitch rate); rudder: trailing edge left \
                         (negative yaw rate); thrust: sum of the engines";

/// `x' = A x + B u`, `y = C x + D u` of perturbations from a trim.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct StateSpace {
    /// What motion it is, for example `longitudinal`.
    pub name: String,
    pub states: Vec<Quantity>,
    pub inputs: Vec<Quantity>,
    pub outputs: Vec<Quantity>,
    /// System matrix.
    pub a: DMatrix<f64>,
    /// Input matrix.
    pub b: DMatrix<f64>,
    /// Output matrix.
    pub c: DMatrix<f64>,
    /// Feedthrough.
    pub d: DMatrix<f64>,
}

/// Names, units and meanings of the states a motion may have.
const STATES: [(&str, &str, MotionState); 15] = [
    ("u", "m/s", MotionState::Speed),
    ("v", "m/s", MotionState::Sideslip),
    ("w", "m/s", MotionState::Heave),
    ("p", "rad/s", MotionState::RollRate),
    ("q", "rad/s", MotionState::PitchRate),
    ("r", "rad/s", MotionState::YawRate),
    ("phi", "rad", MotionState::Bank),
    ("theta", "rad", MotionState::Pitch),
    ("psi", "rad", MotionState::Heading),
    ("north", "m", MotionState::Position),
    ("east", "m", MotionState::Position),
    ("h", "m", MotionState::Altitude),
    ("V", "m/s", MotionState::Speed),
    ("alpha", "rad", MotionState::Heave),
    ("beta", "rad", MotionState::Sideslip),
];

/// SI unit of a state called `name`; empty of one that is not known.
pub fn state_unit(name: &str) -> &'static str {
    STATES.iter().find(|(known, ..)| *known == name).map_or("", |(_, unit, _)| unit)
}

/// The quantity a state called `name` is.
pub(super) fn state(name: &str) -> Quantity {
    Quantity::new(name, state_unit(name))
}

impl StateSpace {
    /// A model whose outputs are its states.
    pub fn of_states(name: &str, states: &[&str], inputs: &[(&str, &str)], a: DMatrix<f64>, b: DMatrix<f64>) -> Self {
        let states: Vec<Quantity> = states.iter().map(|name| state(name)).collect();
        let (n, m) = (states.len(), inputs.len());
        Self {
            name: name.to_owned(),
            outputs: states.clone(),
            states,
            inputs: inputs.iter().map(|(name, unit)| Quantity::new(name, unit)).collect(),
            a,
            b,
            c: DMatrix::identity(n, n),
            d: DMatrix::zeros(n, m),
        }
    }

    /// Index of a state.
    pub fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|state| state.name == name)
    }

    /// Index of an input.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|input| input.name == name)
    }

    /// Index of an output.
    pub fn output(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|output| output.name == name)
    }

    /// What each state is; none where one is unknown.
    pub fn meanings(&self) -> Option<Vec<MotionState>> {
        let meaning =
            |state: &Quantity| STATES.iter().find(|(name, ..)| *name == state.name).map(|(.., meaning)| *meaning);
        self.states.iter().map(meaning).collect()
    }

    /// The same with only the states, inputs and outputs named, in that order; those that are not there are left out. States left out
    /// stay at their trim.
    #[must_use]
    pub fn part(&self, name: &str, states: &[&str], inputs: &[&str], outputs: &[&str]) -> Self {
        let rows: Vec<usize> = states.iter().filter_map(|name| self.state(name)).collect();
        let columns: Vec<usize> = inputs.iter().filter_map(|name| self.input(name)).collect();
        let seen: Vec<usize> = outputs.iter().filter_map(|name| self.output(name)).collect();
        let pick = |matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| matrix[(rows[i], columns[j])])
        };
        let named = |of: &[Quantity], indices: &[usize]| indices.iter().map(|&index| of[index].clone()).collect();
        Self {
            name: name.to_owned(),
            states: named(&self.states, &rows),
            inputs: named(&self.inputs, &columns),
            outputs: named(&self.outputs, &seen),
            a: pick(&self.a, &rows, &rows),
            b: pick(&self.b, &rows, &columns),
            c: pick(&self.c, &seen, &rows),
            d: pick(&self.d, &seen, &columns),
        }
    }

    /// The same motion in other states, `x' = T x`; `None` where `T` cannot be inverted.
    #[must_use]
    pub fn transformed(&self, states: Vec<Quantity>, transform: &DMatrix<f64>) -> Option<Self> {
        let inverse = transform.clone().try_inverse()?;
        Some(Self {
            states,
            a: transform * &self.a * &inverse,
            b: transform * &self.b,
            c: &self.c * &inverse,
            ..self.clone()
        })
    }
}
