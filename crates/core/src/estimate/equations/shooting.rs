//! Records integrated from initial states that are estimated with the parameters.

use std::ops::Range;

use nalgebra::DMatrix;

use super::model::{Expressions, Sides};
use super::{EquationModel, EquationRecord};
use crate::estimate::OutputParameter;

/// A run of samples integrated from initial states of its own.
pub(super) struct Piece {
    pub(super) record: usize,
    pub(super) samples: Range<usize>,
    label: String,
    /// First of its rows among all.
    pub(super) first_row: usize,
    /// First of its initial states among the parameters.
    first_initial: usize,
}

/// What is integrated and compared: the pieces, the parameters with the initial states of each piece, and the measured outputs.
pub(super) struct Shooting {
    pub(super) pieces: Vec<Piece>,
    /// Parameters of the model, then the initial states, piece by piece.
    pub(super) parameters: Vec<OutputParameter>,
    /// Samples of all records by outputs.
    pub(super) measured: DMatrix<f64>,
    /// Time of every row, s.
    pub(super) time_s: Vec<f64>,
    pub(super) rows: Vec<Range<usize>>,
}

impl Shooting {
    /// Pieces of about `piece_s`, or whole records; parameters begin at `start` where it has them.
    pub(super) fn new(
        model: &EquationModel,
        records: &[EquationRecord],
        piece_s: Option<f64>,
        start: Option<&[f64]>,
    ) -> Self {
        let pieces = pieces(records, piece_s, model);
        let given = |(k, (name, value)): (usize, &(String, f64))| {
            free(name, start.and_then(|start| start.get(k)).copied().unwrap_or(*value))
        };
        let mut parameters: Vec<OutputParameter> = model.parameters.iter().enumerate().map(given).collect();
        for piece in &pieces {
            for (state, name) in model.states.iter().enumerate() {
                // From rest nothing would tell what the motion depends on.
                let value = model.output_of_state[state]
                    .map_or(SCALE, |output| beginning(&records[piece.record].outputs[output][piece.samples.clone()]));
                parameters.push(free(&format!("{name} start[{}]", piece.label), value));
            }
        }
        let total = records.iter().map(|record| record.time_s.len()).sum();
        let mut measured = DMatrix::zeros(total, model.outputs.len());
        let (mut time_s, mut rows) = (Vec::with_capacity(total), Vec::new());
        for record in records {
            let first = time_s.len();
            time_s.extend_from_slice(&record.time_s);
            rows.push(first..time_s.len());
            for (column, values) in record.outputs.iter().enumerate() {
                measured.view_mut((first, column), (values.len(), 1)).copy_from_slice(values);
            }
        }
        Self { pieces, parameters, measured, time_s, rows }
    }
}

/// Smallest change of a parameter or initial state that matters.
pub(super) const SCALE: f64 = 1e-2;

pub(super) fn free(name: &str, start: f64) -> OutputParameter {
    OutputParameter { name: name.to_owned(), start, scale: SCALE, bounds: (f64::NEG_INFINITY, f64::INFINITY) }
}

/// Records cut in pieces of about `piece_s`, none shorter than leaves something of every state to estimate.
fn pieces(records: &[EquationRecord], piece_s: Option<f64>, model: &EquationModel) -> Vec<Piece> {
    let states = model.states.len();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut first_row = 0;
    for (index, record) in records.iter().enumerate() {
        let samples = record.time_s.len();
        let length_s = record.time_s[samples - 1] - record.time_s[0];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive count, clamped")]
        let wanted = piece_s.map_or(1, |piece_s| (length_s / piece_s).round().clamp(1.0, 1e4) as usize);
        let count = wanted.min(samples / (2 * states + 2)).max(1);
        for piece in 0..count {
            let range = piece * samples / count..(piece + 1) * samples / count;
            let label = if count == 1 { record.label.clone() } else { format!("{}:{}", record.label, piece + 1) };
            let first_initial = model.parameters.len() + states * pieces.len();
            pieces.push(Piece {
                record: index,
                first_row: first_row + range.start,
                first_initial,
                samples: range,
                label,
            });
        }
        first_row += samples;
    }
    pieces
}

/// Value at the first sample, by a straight line through the first few finite ones.
fn beginning(values: &[f64]) -> f64 {
    const SAMPLES: usize = 9;
    let points: Vec<(f64, f64)> = values
        .iter()
        .enumerate()
        .filter(|(_, value)| value.is_finite())
        .take(SAMPLES)
        .map(|(k, value)| (k as f64, *value))
        .collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count.max(1.0);
    let (middle, value) = (mean(|point| point.0), mean(|point| point.1));
    let squares: f64 = points.iter().map(|(k, _)| (k - middle).powi(2)).sum();
    let slope: f64 =
        points.iter().map(|(k, v)| (k - middle) * (v - value)).sum::<f64>() / squares.max(f64::MIN_POSITIVE);
    value - slope * middle
}

/// A piece that is flown with a set of parameters.
pub(super) struct Flight<'a> {
    record: &'a EquationRecord,
    pub(super) samples: &'a Range<usize>,
    pub(super) theta: &'a [f64],
    pub(super) initial: &'a [f64],
    gain: Option<&'a DMatrix<f64>>,
}

impl<'a> Flight<'a> {
    /// `theta` are the parameters of the model, then all initial states. With a gain `K` the states are corrected at every sample, `x <- x + K (z -
    /// h(x))`, so that each output is predicted from the measurements before it; what was not measured corrects nothing.
    pub(super) fn new(
        model: &EquationModel,
        records: &'a [EquationRecord],
        piece: &'a Piece,
        theta: &'a [f64],
        gain: Option<&'a DMatrix<f64>>,
    ) -> Self {
        let initial = &theta[piece.first_initial..piece.first_initial + model.states.len()];
        let (record, samples) = (&records[piece.record], &piece.samples);
        Self { record, samples, theta: &theta[..model.parameters.len()], initial, gain }
    }

    pub(super) fn inputs(&self, sample: usize) -> Vec<f64> {
        self.record.inputs.iter().map(|column| column[sample]).collect()
    }

    /// Time from a sample to the next, s.
    pub(super) fn step_s(&self, sample: usize) -> f64 {
        self.record.time_s[sample + 1] - self.record.time_s[sample]
    }

    /// Corrects the states by the outputs measured at a sample, where there is a gain.
    pub(super) fn correct(&self, sample: usize, predicted: &[f64], x: &mut [f64]) {
        let Some(gain) = self.gain else { return };
        for (column, predicted) in predicted.iter().enumerate() {
            let innovation = self.record.outputs[column][sample] - predicted;
            if innovation.is_finite() {
                x.iter_mut().zip(gain.column(column).iter()).for_each(|(value, gain)| *value += gain * innovation);
            }
        }
    }
}

/// Sets of parameters that are flown at once: a function takes many points for the time of one.
pub(super) fn lanes(model: &EquationModel, measured: &DMatrix<f64>) -> usize {
    /// Most values of the outputs of all sets: 128 MB.
    const MOST: usize = 1 << 24;
    match model.sides {
        Sides::Expressions(_) => 1,
        Sides::Function(_) => (MOST / measured.len().max(1)).max(1),
    }
}

/// Outputs of all pieces, one below the other, for each set of parameters with its gain.
pub(super) fn fly_pieces(
    model: &EquationModel,
    records: &[EquationRecord],
    pieces: &[Piece],
    several: &[(&[f64], Option<&DMatrix<f64>>)],
) -> Vec<DMatrix<f64>> {
    let mut flights = Vec::with_capacity(several.len() * pieces.len());
    for &(theta, gain) in several {
        flights.extend(pieces.iter().map(|piece| Flight::new(model, records, piece, theta, gain)));
    }
    let flown = match &model.sides {
        Sides::Expressions(sides) => flights.iter().map(|flight| integrate(sides, flight)).collect(),
        Sides::Function(_) => super::together::fly(model, &flights),
    };
    flown.chunks(pieces.len().max(1)).map(|own| stack_pieces(pieces, model.outputs.len(), own)).collect()
}

fn stack_pieces(pieces: &[Piece], outputs: usize, own: &[DMatrix<f64>]) -> DMatrix<f64> {
    let rows = pieces.iter().map(|piece| piece.samples.len()).sum();
    let mut all = DMatrix::zeros(rows, outputs);
    for (piece, flown) in pieces.iter().zip(own) {
        all.rows_mut(piece.first_row, flown.nrows()).copy_from(flown);
    }
    all
}

/// Outputs of a flight by expressions.
pub(super) fn integrate(sides: &Expressions, flight: &Flight<'_>) -> DMatrix<f64> {
    let (states, outputs, samples) = (flight.initial.len(), flight.record.outputs.len(), flight.samples);
    let mut x = flight.initial.to_vec();
    let mut stack = Vec::new();
    let mut slopes = vec![vec![0.0; states]; 4];
    let mut trial = vec![0.0; states];
    let mut shown = vec![0.0; outputs];
    let mut all = DMatrix::zeros(samples.len(), outputs);
    let mut now = flight.inputs(samples.start);
    for (row, k) in samples.clone().enumerate() {
        sides.shown((&x, &now, flight.theta), &mut stack, &mut shown);
        shown.iter().enumerate().for_each(|(column, value)| all[(row, column)] = *value);
        flight.correct(k, &shown, &mut x);
        if k + 1 == samples.end {
            break;
        }
        let next = flight.inputs(k + 1);
        let middle = middle(&now, &next);
        let h = flight.step_s(k);
        for (stage, (u, part)) in [(&now, 0.0), (&middle, 0.5), (&middle, 0.5), (&next, 1.0)].into_iter().enumerate() {
            for state in 0..states {
                let before = if stage == 0 { 0.0 } else { slopes[stage - 1][state] };
                trial[state] = x[state] + part * h * before;
            }
            sides.rates((&trial, u, flight.theta), &mut stack, &mut slopes[stage]);
        }
        for (state, value) in x.iter_mut().enumerate() {
            let [k1, k2, k3, k4] = [0, 1, 2, 3].map(|stage| slopes[stage][state]);
            *value += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        now = next;
    }
    all
}

/// Inputs half way between two samples.
pub(super) fn middle(now: &[f64], next: &[f64]) -> Vec<f64> {
    now.iter().zip(next).map(|(a, b)| 0.5 * (a + b)).collect()
}
