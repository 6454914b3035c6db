//! Fixes that follow from the session and its results, for findings that know no value to set.

use doublet_core::compatibility::ChannelFix;
use doublet_core::estimate::EstimateError;
use doublet_core::model::{Coefficient, Term, is_constant_name};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{AirState, Input, Measurement};

use super::judge::Evidence;
use crate::graph::StageError;
use crate::session::{
    AngularAcceleration, DelaySource, EXPRESSION_SOURCE, Edit, EstimationEdit, FilterEdit, Fix, Flight, GustSource,
    PathSource, Preparation, Session, Surface,
};
use crate::snapshot::Snapshot;
use crate::stage::{ANGULAR_ACCELERATIONS, CoefficientFit, LoadedFlight, significance};

/// Standard deviations before the flight of a flow angle's offset, rad, and of the airspeed's scale error.
const OFFSET_RAD: f64 = 2.0_f64.to_radians();
const SCALE: f64 = 0.05;

/// Passes of a smoother that is iterated.
const PASSES: usize = 3;

/// Removes a coefficient from the model; none where it is the only one.
pub(super) fn without_coefficient(session: &Session, coefficient: Coefficient) -> Option<Fix> {
    let terms = session.structure.terms(coefficient)?;
    let edits = terms.iter().flat_map(|term| Fix::set_term(coefficient, term, false).edits).collect();
    let label = format!("remove {} from the model", coefficient.name());
    (session.structure.models.len() > 1).then_some(Fix { label, edits })
}

/// Removes the term of the derivative called `name`; none of the constant, and none where the model would have no other term.
pub(super) fn without_term(session: &Session, coefficient: Coefficient, name: &str) -> Option<Fix> {
    let terms = session.structure.terms(coefficient)?;
    let is_moving = |term: &&Term| !term.is_constant();
    let term = terms.iter().filter(is_moving).find(|term| term.derivative_name(coefficient) == name)?;
    (terms.iter().filter(is_moving).count() > 1).then(|| Fix::set_term(coefficient, term, false))
}

/// Removes the terms whose regressors depend on those before them.
pub(super) fn without_dependent(session: &Session, coefficient: Coefficient, error: &StageError) -> Option<Fix> {
    let StageError::Estimate(EstimateError::RankDeficient { dependent, .. }) = error else { return None };
    let fixes: Vec<Fix> = dependent.iter().filter_map(|one| without_term(session, coefficient, &one.name)).collect();
    Fix::join(&fixes.iter().collect::<Vec<_>>())
}

/// Removes the term of the parameter `index` where no other derivative of the fit is determined less: one step of backward elimination.
pub(super) fn without_least_determined(session: &Session, fit: &CoefficientFit, index: usize) -> Option<Fix> {
    let estimate = fit.fit.as_ref().ok()?;
    let relative = |index: usize| significance(estimate, &fit.corrected_errors, index).0;
    let others = (0..estimate.parameters()).filter(|other| !is_constant_name(&estimate.names[*other]));
    let is_least = others.map(relative).filter(|other| !other.is_nan()).all(|other| other <= relative(index));
    is_least.then(|| without_term(session, fit.coefficient, &estimate.names[index])).flatten()
}

/// Reverses the sign of the deflection that the derivative `name` is to, in the flights of a fit; none where the channels of a flight show that
/// its sign is right.
pub(super) fn reverse_control(evidence: Evidence<'_>, fit: &CoefficientFit, name: &str) -> Option<Fix> {
    let terms = evidence.session.structure.terms(fit.coefficient)?;
    let term = terms.iter().find(|term| term.derivative_name(fit.coefficient) == name)?;
    let [(variable, 1)] = *term.factors() else { return None };
    let role = Surface::ALL.into_iter().find(|surface| surface.variable() == variable)?.role();
    let is_used = |flight: &&Flight| {
        let mut windows = fit.windows.iter().filter_map(|(window, _)| evidence.session.window(window));
        windows.by_ref().map(|window| &window.flight).any(|name| *name == flight.name)
    };
    let flights: Vec<&Flight> = evidence.session.flights.iter().filter(is_used).collect();
    let is_right = |flight: &&Flight| {
        let physics = evidence.snapshot.physics.get(&flight.name).and_then(|slot| slot.ready());
        physics.is_some_and(|physics| physics.rows.iter().any(|row| row.channel == role.name() && row.fits))
    };
    let reversed = ChannelFix::Scale { role, factor: -1.0, offset: 0.0, units: None };
    if flights.iter().any(is_right) {
        return None;
    }
    in_flights(flights, &reversed)
}

/// Adds an offset to a channel in every flight that records it, rad or SI.
pub(super) fn add_offset(session: &Session, snapshot: &Snapshot, role: Role, offset: f64) -> Option<Fix> {
    let flights = session.flights.iter().filter(|flight| {
        let loaded = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready());
        loaded.is_some_and(|loaded| loaded.recording.role(role).is_some())
    });
    in_flights(flights.collect(), &ChannelFix::Scale { role, factor: 1.0, offset, units: None })
}

/// The fix of a channel in all these flights; none where one of them cannot have it.
fn in_flights(flights: Vec<&Flight>, fix: &ChannelFix) -> Option<Fix> {
    let fixes: Vec<Fix> = flights.into_iter().map(|flight| Fix::channel(flight, fix, false)).collect::<Option<_>>()?;
    let label = fixes.first()?.label.clone();
    Some(Fix { label, edits: fixes.into_iter().flat_map(|fix| fix.edits).collect() })
}

/// Has the filter estimate the offset of a flow angle or the scale error of the airspeed, where it does not.
pub(super) fn estimate_offset(session: &Session, measurement: Measurement) -> Option<Fix> {
    let (state, deviation) = match measurement {
        Measurement::AngleOfAttack => (AirState::AlphaOffset, OFFSET_RAD),
        Measurement::Sideslip => (AirState::BetaOffset, OFFSET_RAD),
        Measurement::Airspeed => (AirState::AirspeedScale, SCALE),
        _ => return None,
    };
    let edit = Edit::Filter(FilterEdit::AirDataDeviation(state, deviation));
    let is_estimated = session.filter.air_data_deviation[state as usize] > 0.0;
    (!is_estimated).then(|| Fix::new(format!("estimate the {}", state.description()), edit))
}

/// Has the delays of the measurements estimated, where the session states them.
pub(super) fn estimate_delays(session: &Session) -> Option<Fix> {
    let fix = Fix::new("estimate the measurement delays", Edit::Filter(FilterEdit::Delays(DelaySource::Estimated)));
    (session.delays == DelaySource::Stated && session.preparation.path != PathSource::Measured).then_some(fix)
}

/// Has the gusts estimated, where the session states the random walk of the wind.
pub(super) fn estimate_gusts(session: &Session) -> Option<Fix> {
    let fix = Fix::new("estimate the gusts", Edit::Filter(FilterEdit::Gusts(GustSource::Estimated)));
    (session.gusts == GustSource::Stated && session.preparation.path != PathSource::Measured).then_some(fix)
}

/// Iterates the smoother, where it runs once.
pub(super) fn iterate_smoother(session: &Session) -> Option<Fix> {
    let fix = Fix::new(format!("use {PASSES} smoother passes"), Edit::Filter(FilterEdit::SmootherPasses(PASSES)));
    (session.filter.smoother_passes == 1 && session.preparation.path == PathSource::Smoothed).then_some(fix)
}

/// Shifts the recorder of inertial sensors whose stamps are late, in all flights; none where it records anything else, which is on time.
pub(super) fn shift_inertial(session: &Session, snapshot: &Snapshot, inputs: &[Input], late_s: f64) -> Option<Fix> {
    let flights = session.flights.iter();
    let fixes: Vec<Fix> =
        flights.map(|flight| shift_flight(flight, snapshot, inputs, late_s)).collect::<Option<_>>()?;
    Fix::join(&fixes.iter().collect::<Vec<_>>())
}

fn shift_flight(flight: &Flight, snapshot: &Snapshot, inputs: &[Input], late_s: f64) -> Option<Fix> {
    let loaded = snapshot.flights.get(&flight.name)?.ready()?;
    let source = source(loaded, inputs.first()?.role()).filter(|source| !source.is_empty())?;
    let is_of_source = |role: Role| self::source(loaded, role) == Some(source);
    let is_alone = loaded.recording.roles.keys().all(|role| !is_of_source(*role) || is_inertial(*role));
    let is_all = inputs.iter().all(|input| is_of_source(input.role()));
    let fix = ChannelFix::Shift { source: source.to_owned(), late_s };
    (is_alone && is_all && source != EXPRESSION_SOURCE).then(|| Fix::channel(flight, &fix, false)).flatten()
}

/// The source that a role was recorded by, before any treatment.
fn source(loaded: &LoadedFlight, role: Role) -> Option<&str> {
    let treated = loaded.treated.iter().find(|signal| signal.role == role).map(|signal| signal.recorded);
    let index = treated.or(loaded.recording.roles.get(&role).copied())?;
    loaded.recording.channels.get(index).map(|channel| channel.source.as_str())
}

fn is_inertial(role: Role) -> bool {
    Input::ALL.into_iter().any(|input| input.role() == role)
        || ANGULAR_ACCELERATIONS.into_iter().any(|(acceleration, _)| acceleration == role)
}

/// Uses the recorded angular accelerations of a flight that has them.
pub(super) fn recorded_acceleration(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<Fix> {
    let recording = &snapshot.flights.get(flight)?.ready()?.recording;
    let is_recorded = ANGULAR_ACCELERATIONS.into_iter().all(|(role, _)| recording.role(role).is_some());
    let angular_acceleration = AngularAcceleration::Recorded;
    if !is_recorded || session.preparation.angular_acceleration == angular_acceleration {
        return None;
    }
    let preparation = Preparation { angular_acceleration, ..session.preparation.clone() };
    let edit = Edit::Estimation(EstimationEdit::Preparation(preparation));
    Some(Fix::new("use the recorded angular accelerations", edit))
}
