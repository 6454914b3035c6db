//! Many flights integrated in step, so that a function is called once for all of them.

use nalgebra::DMatrix;

use super::shooting::Flight;
use super::{EquationModel, EquationPoints};

/// Values by flight and, in each, by state, input or output.
type Rows = Vec<Vec<f64>>;

/// Outputs of every flight, by the scheme of [`super::shooting::integrate`].
pub(super) fn fly(model: &EquationModel, flights: &[Flight<'_>]) -> Vec<DMatrix<f64>> {
    let mut all: Vec<DMatrix<f64>> =
        flights.iter().map(|flight| DMatrix::zeros(flight.samples.len(), model.outputs.len())).collect();
    let mut x: Rows = flights.iter().map(|flight| flight.initial.to_vec()).collect();
    let longest = flights.iter().map(|flight| flight.samples.len()).max().unwrap_or(0);
    let mut flying: Vec<usize> = (0..flights.len()).collect();
    for row in 0..longest {
        flying.retain(|&index| row < flights[index].samples.len());
        let sample = |index: usize| flights[index].samples.start + row;
        let now: Rows = flying.iter().map(|&index| flights[index].inputs(sample(index))).collect();
        let states: Rows = flying.iter().map(|&index| x[index].clone()).collect();
        let lanes = Lanes { model, flights, flying: &flying };
        let shown = lanes.evaluate(EquationModel::shown, &states, &now);
        for (&index, shown) in flying.iter().zip(&shown) {
            shown.iter().enumerate().for_each(|(column, value)| all[index][(row, column)] = *value);
            flights[index].correct(sample(index), shown, &mut x[index]);
        }
        flying.retain(|&index| row + 1 < flights[index].samples.len());
        if !flying.is_empty() {
            Lanes { model, flights, flying: &flying }.step(row, &mut x);
        }
    }
    all
}

/// The flights that go on.
struct Lanes<'a> {
    model: &'a EquationModel,
    flights: &'a [Flight<'a>],
    flying: &'a [usize],
}

impl Lanes<'_> {
    /// Takes the states to the next sample.
    fn step(&self, row: usize, x: &mut [Vec<f64>]) {
        let inputs = |ahead: usize| -> Rows {
            let own = |&index: &usize| self.flights[index].inputs(self.flights[index].samples.start + row + ahead);
            self.flying.iter().map(own).collect()
        };
        let (now, next) = (inputs(0), inputs(1));
        let middle: Rows = now.iter().zip(&next).map(|(now, next)| super::shooting::middle(now, next)).collect();
        let step = |&index: &usize| self.flights[index].step_s(self.flights[index].samples.start + row);
        let steps: Vec<f64> = self.flying.iter().map(step).collect();
        let mut slopes: Vec<Rows> = Vec::with_capacity(4);
        for (u, part) in [(&now, 0.0), (&middle, 0.5), (&middle, 0.5), (&next, 1.0)] {
            let moved = |(lane, &index): (usize, &usize)| -> Vec<f64> {
                let before = |state: usize| slopes.last().map_or(0.0, |slopes| slopes[lane][state]);
                let value = |(state, value): (usize, &f64)| value + part * steps[lane] * before(state);
                x[index].iter().enumerate().map(value).collect()
            };
            let trial: Rows = self.flying.iter().enumerate().map(moved).collect();
            slopes.push(self.evaluate(EquationModel::rates, &trial, u));
        }
        for (lane, &index) in self.flying.iter().enumerate() {
            for (state, value) in x[index].iter_mut().enumerate() {
                let slope = |stage: usize| slopes[stage][lane][state];
                *value += steps[lane] / 6.0 * (slope(0) + 2.0 * slope(1) + 2.0 * slope(2) + slope(3));
            }
        }
    }

    /// Right-hand sides of every flight at its states and inputs.
    fn evaluate(
        &self,
        sides: fn(&EquationModel, EquationPoints<'_>) -> Vec<Vec<f64>>,
        states: &Rows,
        inputs: &Rows,
    ) -> Rows {
        let first = self.flying.first().map_or(&[][..], |&index| self.flights[index].theta);
        let are_same = self.flying.iter().all(|&index| self.flights[index].theta == first);
        let parameters: Rows = if are_same {
            first.iter().map(|value| vec![*value]).collect()
        } else {
            let column = |at: usize| self.flying.iter().map(|&index| self.flights[index].theta[at]).collect();
            (0..first.len()).map(column).collect()
        };
        let (states, inputs) = (transposed(states), transposed(inputs));
        let [states, inputs, parameters] =
            [&states, &inputs, &parameters].map(|columns| columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let count = self.flying.len();
        let found =
            sides(self.model, EquationPoints { count, states: &states, inputs: &inputs, parameters: &parameters });
        transposed(&found)
    }
}

/// Rows as columns.
fn transposed(rows: &Rows) -> Rows {
    let length = rows.first().map_or(0, Vec::len);
    (0..length).map(|column| rows.iter().map(|row| row[column]).collect()).collect()
}
