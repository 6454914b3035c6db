//! What is known at one moment of a flight.

use std::collections::BTreeMap;

use serde::Serialize;

use super::limits::LimitReading;
use crate::session::Level;

/// What is known at one moment of a flight; SI and radians.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LiveUpdate {
    /// Time to which the filter went, s.
    pub time_s: f64,
    /// Latest inertial sample that arrived less that time, with the age of that sample by the clock of a live stream, s.
    pub lag_s: f64,
    /// Samples and what became of them.
    pub counts: Counts,
    /// Quantities of the motion at that time, by name of role, and `n_z`.
    pub state: BTreeMap<String, f64>,
    /// Mean normalised innovation squared per measurement since the update before: one where noise is as stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nis_per_measurement: Option<f64>,
    /// Whether the aircraft flies, so that samples enter the regression.
    pub is_airborne: bool,
    /// Derivatives as estimated so far.
    pub derivatives: Vec<LiveDerivative>,
    /// The two regressors of one coefficient that are most alike.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correlation: Option<CorrelationLamp>,
    /// Limits against what was flown since the update before.
    pub limits: Vec<LimitReading>,
    /// Whether every derivative is known as well as asked for.
    pub is_enough: bool,
    /// What is new since the update before, a line each: what is missing, left out or lost.
    pub findings: Vec<String>,
    /// What needs attention now, in every update as long as it does: no data, a recording that has stopped.
    pub alarms: Vec<String>,
}

/// Samples and what became of them, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Inertial samples the filter took.
    pub samples: u64,
    /// Inertial samples that never came, by the usual interval, pauses included.
    pub lost: u64,
    /// Rows that came after the filter had passed their time, and were left out.
    pub late: u64,
    /// Rows that came again, and were left out.
    pub doubled: u64,
    /// Rows that came after a later one of their source, and were put in order.
    pub reordered: u64,
    /// Rows with a stamp far from those around it, or without one, which were left out.
    pub stray: u64,
    /// Inertial samples that came and that the filter passed over where it began anew.
    pub skipped: u64,
    /// Pauses after which the filter began anew.
    pub restarts: u64,
    /// Times that a clock of the stream began anew.
    pub clock_restarts: u64,
}

impl std::fmt::Display for Counts {
    fn fmt(&self, text: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { samples, lost, late, doubled, reordered, stray, skipped, restarts, clock_restarts } = self;
        write!(
            text,
            "{samples} samples, {lost} lost, {late} late, {reordered} reordered, {doubled} duplicate, {stray} stray, \
             {skipped} skipped; restarts: filter {restarts}, clock {clock_restarts}"
        )
    }
}

/// A derivative as estimated so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LiveDerivative {
    pub name: String,
    /// Estimate of the regression in the frequency domain; none where its regressor does not move.
    pub estimate: Option<f64>,
    /// Its standard error, with that of the estimate in time and what the two differ by.
    pub standard_error: Option<f64>,
    /// Standard error over estimate, per cent.
    pub relative_error_percent: Option<f64>,
    /// Relative error asked for, per cent.
    pub goal_percent: f64,
    /// Good where the goal is met, caution within twice the goal, bad beyond; no better than caution where the fit of its coefficient is
    /// not whole or its derivatives in frequency and time contradict each other.
    pub level: Level,
    /// Estimate by recursive least squares in time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_domain: Option<TimeDomain>,
}

/// An estimate by recursive least squares in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeDomain {
    pub estimate: f64,
    /// Standard error, corrected for correlated residuals.
    pub standard_error: f64,
}

/// Two regressors that move alike.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrelationLamp {
    /// Coefficient that has both.
    pub coefficient: String,
    pub regressors: [String; 2],
    /// Their correlation over the frequencies of the regression.
    pub correlation: f64,
    /// Caution above 0.6, bad above 0.9 in magnitude.
    pub level: Level,
}
