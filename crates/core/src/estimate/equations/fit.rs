//! Parameters of equations of motion.

use std::ops::Range;

use nalgebra::DMatrix;

use super::model::{Expressions, Sides};
use super::shooting::{Flight, Piece, Shooting, fly_pieces, free, integrate, lanes};
use super::{EquationFault, EquationModel, EquationPoints, EquationRecord};
use crate::estimate::flight_output_error::{corrected_covariance, roots_of_diagonal};
use crate::estimate::output_error::output_error_in_lanes;
use crate::estimate::{EstimateError, OutputErrorFit, OutputErrorSettings, OutputParameter, output_error};
use crate::prep::{Differentiation, MatchedSmoothing, differentiate};

/// How parameters are estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquationSettings {
    /// Half width of the local quadratic that differentiates the measured states for equation error, s; all else is smoothed alike.
    pub half_width_s: f64,
    /// Length of the pieces, each with initial states of its own, that output error integrates a record in, s; none for each record
    /// from its beginning.
    pub piece_s: Option<f64>,
    /// When the iteration ends.
    pub search: OutputErrorSettings,
}

impl Default for EquationSettings {
    fn default() -> Self {
        let search = OutputErrorSettings { tolerance: 1e-5, ..OutputErrorSettings::default() };
        Self { half_width_s: 0.1, piece_s: None, search }
    }
}

/// Estimates of one method.
#[derive(Clone, Debug)]
pub struct EquationFit {
    /// The estimation: parameters first, then initial states, `alpha start[label]`.
    pub fit: OutputErrorFit,
    /// Number of parameters among them.
    pub parameters: usize,
    /// Covariance of all estimates corrected for correlated residuals.
    pub corrected_covariance: DMatrix<f64>,
    /// Square roots of its diagonal.
    pub corrected_errors: Vec<f64>,
    /// What is compared: names of the columns of the fit.
    pub compared: Vec<String>,
    /// Time of every row, s.
    pub time_s: Vec<f64>,
    /// Rows of each record.
    pub rows: Vec<Range<usize>>,
}

/// Equation error (Klein and Morelli 2006, chapter 5): slopes of the measured states against the right-hand sides at the measured
/// states, `f(z, u, theta)`, both sides seen through the smoothing that differentiation carries with it ([`MatchedSmoothing`]), and
/// outputs that are no state against `h(z, u, theta)`. Nothing is integrated, so that it matters nothing whether the motion is stable.
/// Every equation is weighted by its own residual.
///
/// # Errors
/// [`EquationFault`]: a state that no output is, a record that does not fit, parameters the data cannot tell apart.
pub fn equation_error_of(
    model: &EquationModel,
    records: &[EquationRecord],
    settings: &EquationSettings,
) -> Result<EquationFit, EquationFault> {
    check(model, records)?;
    let measured_by = |(state, output): (usize, &Option<usize>)| {
        output.ok_or_else(|| EquationFault::NotMeasured { state: model.states[state].clone() })
    };
    let of_state = model.output_of_state.iter().enumerate().map(measured_by).collect::<Result<Vec<_>, _>>()?;
    let others: Vec<usize> = (0..model.outputs.len()).filter(|output| !of_state.contains(output)).collect();
    let columns = of_state.len() + others.len();
    let (mut slopes, mut smoothings, mut rows, mut time_s) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for record in records {
        let fault = |error| EquationFault::Slopes { record: record.label.clone(), error };
        let step = (record.time_s[record.time_s.len() - 1] - record.time_s[0]) / (record.time_s.len() - 1) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to a small positive range"
        )]
        let half_width = (settings.half_width_s / step).round().clamp(1.0, 1000.0) as usize;
        let method = Differentiation::LocalPolynomial { degree: 2, half_width };
        let smoothing = MatchedSmoothing::new(&record.time_s, method).map_err(fault)?;
        let inside = smoothing.reach()..record.time_s.len() - smoothing.reach();
        let mut own: Vec<Vec<f64>> = Vec::with_capacity(columns);
        for &output in &of_state {
            let slope = differentiate(&record.time_s, &record.outputs[output], method).map_err(fault)?;
            own.push(slope[inside.clone()].to_vec());
        }
        own.extend(others.iter().map(|&output| smoothing.apply(&record.outputs[output])));
        let start = time_s.len();
        time_s.extend_from_slice(&record.time_s[inside]);
        rows.push(start..time_s.len());
        slopes.push(own);
        smoothings.push(smoothing);
    }
    let mut measured = DMatrix::zeros(time_s.len(), columns);
    for (range, own) in rows.iter().zip(&slopes) {
        for (column, values) in own.iter().enumerate() {
            measured.view_mut((range.start, column), (range.len(), 1)).copy_from_slice(values);
        }
    }
    let parameters: Vec<OutputParameter> = model.parameters.iter().map(|(name, start)| free(name, *start)).collect();
    let fit = output_error(&parameters, &measured, &settings.search, |theta| {
        let mut sides = DMatrix::zeros(time_s.len(), columns);
        for ((record, smoothing), range) in records.iter().zip(&smoothings).zip(&rows) {
            let raw = right_hand_sides(model, record, (&of_state, &others), theta);
            for (column, values) in raw.iter().enumerate() {
                sides.view_mut((range.start, column), (range.len(), 1)).copy_from_slice(&smoothing.apply(values));
            }
        }
        Ok::<_, EstimateError>(sides)
    })?;
    let slope = |state: &String| format!("{state}'");
    let compared = model.states.iter().map(slope).chain(others.iter().map(|&output| model.outputs[output].clone()));
    finish(model, fit, &measured, compared.collect(), (time_s, rows))
}

/// Right-hand sides at the measured states, then the outputs that are no state.
fn right_hand_sides(
    model: &EquationModel,
    record: &EquationRecord,
    (of_state, others): (&[usize], &[usize]),
    theta: &[f64],
) -> Vec<Vec<f64>> {
    let states: Vec<&[f64]> = of_state.iter().map(|&output| record.outputs[output].as_slice()).collect();
    let inputs: Vec<&[f64]> = record.inputs.iter().map(Vec::as_slice).collect();
    let parameters: Vec<&[f64]> = theta.iter().map(std::slice::from_ref).collect();
    let points =
        EquationPoints { count: record.time_s.len(), states: &states, inputs: &inputs, parameters: &parameters };
    let mut sides = model.rates(points);
    if !others.is_empty() {
        let mut shown = model.shown(points);
        sides.extend(others.iter().map(|&output| std::mem::take(&mut shown[output])));
    }
    sides
}

/// Output error: the equations are integrated by the classical Runge-Kutta scheme, inputs linear between samples, until the outputs
/// follow the measured ones. With [`EquationSettings::piece_s`] every record is integrated in pieces with initial states of their own
/// (multiple shooting: Bock, in: Ebert et al., Modelling of Chemical Reaction Systems, 1981), so that an unstable motion grows over a
/// piece only; what the initial states then cost in certainty is in the errors. Of methods for unstable aircraft see Jategaonkar,
/// Flight Vehicle System Identification, chapter 9.
///
/// `start` are values to begin with, for example of [`equation_error_of`]; none for those of the model.
///
/// # Errors
/// [`EquationFault`]: a record that does not fit, parameters the data cannot tell apart, an iteration that does not settle.
pub fn output_error_of(
    model: &EquationModel,
    records: &[EquationRecord],
    settings: &EquationSettings,
    start: Option<&[f64]>,
) -> Result<EquationFit, EquationFault> {
    check(model, records)?;
    let Shooting { pieces, parameters, measured, time_s, rows } =
        Shooting::new(model, records, settings.piece_s, start);
    let lanes = lanes(model, &measured);
    let mut known: Vec<Option<(Vec<f64>, DMatrix<f64>)>> = pieces.iter().map(|_| None).collect();
    let fit = output_error_in_lanes(&parameters, &measured, &settings.search, lanes, |several| {
        let outputs = match &model.sides {
            Sides::Expressions(sides) => {
                several.iter().map(|theta| fly_changed((model, sides), records, &pieces, theta, &mut known)).collect()
            }
            Sides::Function(_) => {
                let all: Vec<_> = several.iter().map(|theta| (theta.as_slice(), None)).collect();
                fly_pieces(model, records, &pieces, &all)
            }
        };
        outputs.into_iter().map(Ok::<_, EstimateError>).collect()
    })?;
    finish(model, fit, &measured, model.outputs.clone(), (time_s, rows))
}

/// Outputs of all pieces. Initial states of one piece leave the others as they were: these are known.
fn fly_changed(
    (model, sides): (&EquationModel, &Expressions),
    records: &[EquationRecord],
    pieces: &[Piece],
    theta: &[f64],
    known: &mut [Option<(Vec<f64>, DMatrix<f64>)>],
) -> DMatrix<f64> {
    let rows = pieces.iter().map(|piece| piece.samples.len()).sum();
    let mut all = DMatrix::zeros(rows, model.outputs.len());
    for (piece, known) in pieces.iter().zip(known) {
        let flight = Flight::new(model, records, piece, theta, None);
        let own = [flight.theta, flight.initial].concat();
        if !known.as_ref().is_some_and(|(before, _)| *before == own) {
            *known = Some((own, integrate(sides, &flight)));
        }
        if let Some((_, flown)) = known {
            all.rows_mut(piece.first_row, flown.nrows()).copy_from(flown);
        }
    }
    all
}

/// The fit with errors corrected for correlated residuals.
pub(super) fn finish(
    model: &EquationModel,
    fit: OutputErrorFit,
    measured: &DMatrix<f64>,
    compared: Vec<String>,
    (time_s, rows): (Vec<f64>, Vec<Range<usize>>),
) -> Result<EquationFit, EquationFault> {
    let corrected_covariance = corrected_covariance(&fit, measured, &rows)?;
    let corrected_errors = roots_of_diagonal(&corrected_covariance);
    let parameters = model.parameters.len();
    Ok(EquationFit { fit, parameters, corrected_covariance, corrected_errors, compared, time_s, rows })
}

/// Refuses records that do not fit the model.
pub(super) fn check(model: &EquationModel, records: &[EquationRecord]) -> Result<(), EquationFault> {
    const FEWEST: usize = 5;
    for record in records {
        let samples = record.time_s.len();
        let fault =
            |what, found, expected| EquationFault::Columns { record: record.label.clone(), what, found, expected };
        if samples < FEWEST {
            return Err(fault("samples", samples, FEWEST));
        }
        if record.inputs.len() != model.inputs.len() {
            return Err(fault("inputs", record.inputs.len(), model.inputs.len()));
        }
        if record.outputs.len() != model.outputs.len() {
            return Err(fault("outputs", record.outputs.len(), model.outputs.len()));
        }
        if let Some(column) = record.inputs.iter().chain(&record.outputs).find(|column| column.len() != samples) {
            return Err(fault("samples of a column", column.len(), samples));
        }
        for (input, column) in model.inputs.iter().zip(&record.inputs) {
            if let Some(k) = column.iter().position(|value| !value.is_finite()) {
                let (record, input, time_s) = (record.label.clone(), input.clone(), record.time_s[k]);
                return Err(EquationFault::Input { record, input, time_s });
            }
        }
    }
    if records.is_empty() { Err(EstimateError::NoParameters.into()) } else { Ok(()) }
}
