//! What a session shows of its instruments, for the errors of a flight still to come.

use std::collections::BTreeMap;

use doublet_core::quantity::InstrumentError;
use nalgebra::{DMatrix, DVector};

use super::control_delays::{ControlDelay, PRIOR_DEVIATION_S, instrument_error};
use super::path_errors::PathErrors;

/// The instruments as a session shows them.
#[derive(Debug)]
pub struct Instruments<'a> {
    errors: &'a PathErrors,
    /// Root of the mean square of each constant error: what was found, with what is not known of it.
    accuracy: BTreeMap<InstrumentError, f64>,
}

/// Whether a calibration, and with it an earlier flight, says what the error is in the next flight. Clocks, and the delays with them, are found
/// anew in each.
fn is_kept(error: InstrumentError) -> bool {
    use InstrumentError::{AlphaOffset, AlphaScale, BetaOffset, BetaScale};
    matches!(error, AlphaOffset | AlphaScale | BetaOffset | BetaScale)
}

impl<'a> Instruments<'a> {
    pub(super) fn new(errors: &'a PathErrors) -> Self {
        let found = errors.found.estimates.iter().zip(errors.found.deviations());
        let constant = errors.kinds.iter().zip(found);
        let constant = constant.map(|(kind, (value, deviation))| (kind.instrument_error(), value.hypot(deviation)));
        let control = errors.controls.iter();
        let control = control.map(|own| (instrument_error(own.surface), own.delay_s.hypot(own.standard_error_s)));
        let within = |(error, value): (InstrumentError, f64)| (error, value.min(error.greatest_deviation()));
        Self { errors, accuracy: constant.chain(control).filter(|(_, value)| *value > 0.0).map(within).collect() }
    }

    /// Standard deviations of the errors of the instruments.
    pub fn accuracy(&self) -> &BTreeMap<InstrumentError, f64> {
        &self.accuracy
    }

    /// Those of them that the session of the next flight states: offsets and scales.
    pub fn stated(accuracy: &BTreeMap<InstrumentError, f64>) -> BTreeMap<InstrumentError, f64> {
        accuracy.iter().filter(|(error, _)| is_kept(**error)).map(|(error, value)| (*error, *value)).collect()
    }

    /// Variance of a derivative that a flight will state: that of the errors `next` of its undisturbed motion, or one with `more` times the
    /// information of the session and its slopes where there are none. Its instruments have errors `e` of these standard deviations,
    /// `S = diag(a^2)`, and its session states them. With `A` the information of that flight and `P` what it knows beforehand, its errors are
    /// `e' = B A (e + noise)` with covariance `B = (A + P^-1)^-1`, so the expected mean square `B + e' e''` is `B + B A S A B + B A B`: `S` where
    /// `P` is `S`, however long it flies. Where innovations scatter more than predicted,
    /// the parts without `S` are larger by that.
    pub fn variance(&self, derivative: &str, next: Option<&PathErrors>, more: f64) -> f64 {
        let PathErrors { kinds, found, controls, .. } = self.errors;
        let next = next.filter(|next| next.kinds == *kinds);
        let flown = next.unwrap_or(self.errors);
        let constant = flown.slopes.get(derivative).map_or(0.0, |slopes| {
            let slopes = DVector::from_column_slice(slopes);
            let of_kinds = |value: &dyn Fn(usize) -> f64| {
                DMatrix::from_diagonal(&DVector::from_iterator(kinds.len(), (0..kinds.len()).map(value)))
            };
            let accuracy = |k: usize| self.accuracy.get(&kinds[k].instrument_error()).copied().unwrap_or(0.0);
            let prior = |k: usize| match is_kept(kinds[k].instrument_error()) && accuracy(k) > 0.0 {
                true => accuracy(k),
                false => kinds[k].prior_deviation(),
            };
            let instruments = of_kinds(&|k| accuracy(k).powi(2));
            let information = if next.is_some() { 1.0 } else { more } * &flown.found.information;
            let Some(factor) = (&information + of_kinds(&|k| prior(k).powi(-2))).cholesky() else { return 0.0 };
            // Of the estimates of that flight: B s and A B s.
            let known = factor.solve(&slopes);
            let moved = &information * &known;
            let by = |covariance: &DMatrix<f64>| slopes.dot(&(covariance * &slopes));
            let scatter = by(&found.scattered) / by(&found.predicted);
            let scatter = if scatter > 1.0 { scatter } else { 1.0 };
            scatter * (slopes.dot(&known) + known.dot(&moved)) + moved.dot(&(instruments * &moved))
        });
        let slope = |own: &ControlDelay| {
            let same = flown.controls.iter().find(|other| other.surface == own.surface);
            same.map_or(0.0, |same| same.slope(derivative))
        };
        let control = controls.iter().map(|own| {
            let accuracy = self.accuracy.get(&instrument_error(own.surface)).copied().unwrap_or(0.0);
            let information = more * own.information;
            let variance = (information + PRIOR_DEVIATION_S.powi(-2)).recip();
            let taken = variance * information;
            slope(own).powi(2) * (variance + taken * variance + (taken * accuracy).powi(2))
        });
        constant + control.sum::<f64>()
    }
}
