//! Findings about controls that act earlier or later than they were recorded: a clock of their own, a command in the place of the surface.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::model::{Coefficient, Term, Variable, regressors};
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::{Series, TimeRange};
use doublet_core::statistics::median;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::fit::{Used, moving_terms, used_windows};
use super::judge::Evidence;
use super::{Finding, Level, effect, remedies, spoilt, stalls};
use crate::session::{Fix, Manoeuvre, Surface};
use crate::snapshot::{Snapshot, WindowVerdict};
use crate::stage::{ConstantError, SensorDelay, WindowAero};

/// Range of delays looked at, s, and their least step; the greatest step of a first look, in which no pulse of a pilot passes unseen.
const RANGE_S: f64 = 0.6;
const STEP_S: f64 = 0.01;
const COARSE_S: f64 = 0.04;
/// Least delay that is told, samples of the control and s: a step between two samples is known to half the time between them.
const SAMPLES: f64 = 0.4;
const LEAST_S: f64 = 0.015;
/// Part of the residual's sum of squares that is left with the delay, at most.
const LEFT: f64 = 0.7;
/// The same of a delay that was found otherwise.
const CONFIRMED_LEFT: f64 = 0.9;
/// Change of the derivative of the control or of the damping, part of its value with the delay.
const CHANGE_CAUTION: f64 = 0.1;
const CHANGE_BAD: f64 = 0.25;

/// A control is late because of the gyros up to this many times the lead of the attitude ahead of the rates.
const OF_GYROS: f64 = 1.5;
/// Least time, s, by which flow angles or attitude must lead the inertial sensors to be a finding: no sensor is early.
const AHEAD_S: f64 = 0.010;
/// Standard errors beyond which ground velocity leads the specific forces. Those errors are large where the forces are late: the path
/// follows the forces, and the innovations are too large everywhere.
const GROUND_ERRORS: f64 = 2.5;

/// A control, the moment that tells its time, the force it moves as well, the coefficients it moves little, and the rates that damp them.
#[derive(Clone, Copy)]
struct TimedControl {
    surface: Surface,
    moment: Coefficient,
    force: Option<Coefficient>,
    little: &'static [Coefficient],
    damping: &'static [Variable],
}

const CONTROLS: [TimedControl; 3] = [
    TimedControl {
        surface: Surface::Aileron,
        moment: Coefficient::Cl,
        force: None,
        little: &[Coefficient::Cn, Coefficient::CY],
        damping: &[Variable::RollRate],
    },
    TimedControl {
        surface: Surface::Elevator,
        moment: Coefficient::Cm,
        force: Some(Coefficient::CZ),
        little: &[Coefficient::CX],
        damping: &[Variable::PitchRate, Variable::HalfPitchRate],
    },
    TimedControl {
        surface: Surface::Rudder,
        moment: Coefficient::Cn,
        force: Some(Coefficient::CY),
        little: &[Coefficient::Cl],
        damping: &[Variable::YawRate],
    },
];

impl TimedControl {
    /// Worst level of a delay for a coefficient; none for one that the control does not move.
    fn worst(self, coefficient: Coefficient) -> Option<Level> {
        let is_main = coefficient == self.moment || self.force == Some(coefficient);
        let is_little = self.little.contains(&coefficient);
        (is_main || is_little).then_some(if is_main { Level::Bad } else { Level::Caution })
    }
}

/// A control that explains its moment much better at another time than at that of its recording.
#[derive(Clone, Copy, Debug)]
pub(super) struct ControlDelay {
    pub(super) surface: Surface,
    moment: Coefficient,
    delay_s: f64,
    /// Mean interval of its samples, s.
    sample_s: f64,
    /// Part of the residual's sum of squares that is left with the delay.
    left: f64,
}

/// The delays of all controls, by the pooled fits of their moments; none of windows whose path is bad: gusts that the vanes feel before
/// the controls answer them look like one.
pub(super) fn delays(evidence: Evidence<'_>, verdicts: &BTreeMap<String, WindowVerdict>) -> Vec<ControlDelay> {
    let Evidence { session, snapshot, .. } = evidence;
    let unstalled = unstalled(evidence);
    let is_bad =
        |used: &&Used<'_>| verdicts.get(&used.manoeuvre.name).is_some_and(|window| window.verdict.level == Level::Bad);
    let fits = snapshot.pooled.ready().map(|pooled| pooled.fits.as_slice()).unwrap_or_default();
    let one = |&TimedControl { surface, moment, .. }: &TimedControl| {
        let fit = fits.iter().find(|fit| fit.coefficient == moment)?;
        let (terms, mut used) = (moving_terms(session, fit), used_windows(session, snapshot, fit));
        for used in &mut used {
            used.aero = unstalled.get(used.manoeuvre.name.as_str()).unwrap_or(used.aero);
        }
        if 2 * used.iter().filter(is_bad).count() > used.len() {
            return None;
        }
        let terms = split(&terms, surface)?;
        let shifted = Shifted::new(moment, &terms, &used, Sides::Alike)?;
        let sample_s = used.iter().filter_map(|used| interval_s(snapshot, surface, used.manoeuvre)).fold(0.0, f64::max);
        let (delay_s, best) = shifted.best(shifted.step_s.max(STEP_S))?;
        let left = best.squares / shifted.at(0.0)?.squares;
        let is_late = delay_s.abs() > (SAMPLES * sample_s).max(LEAST_S) && left <= LEFT;
        (is_late && !sides_explain(moment, &terms, &used, &best)).then_some(ControlDelay {
            surface,
            moment,
            delay_s,
            sample_s,
            left,
        })
    };
    // Gyros behind a filter are late, and every control seems late by as much: `find_late_inertial` names the gyros.
    let (kind, measurement) = (ConstantError::AttitudeDelay, Measurement::BankAngle);
    let gyros_late_s = find_lead(evidence, kind, measurement, SensorDelay::SIGNIFICANT).unwrap_or(0.0);
    let is_own = |late: &ControlDelay| !(0.0..=OF_GYROS * gyros_late_s).contains(&late.delay_s);
    CONTROLS.par_iter().filter_map(one).filter(is_own).collect()
}

/// The manoeuvres in which a recorder stalls, without these blocks: a held motion looks like a late one.
fn unstalled(evidence: Evidence<'_>) -> BTreeMap<&str, WindowAero> {
    let stalled = evidence.windows().filter(|window| stalls::inside(evidence, window).next().is_some());
    let one = |window: &'_ Manoeuvre| {
        let aero = evidence.snapshot.windows.get(&window.name)?.aero.ready()?;
        effect::outside(aero, spoilt::excluded(evidence, window)?)
    };
    stalled.filter_map(|window| Some((window.name.as_str(), one(window)?))).collect()
}

/// Whether a delay of a control matters to the pooled fit of its moment: the part of the squares of the residual that it leaves, and the
/// change of the derivative by the control or the damping. It does not where different effects to either side explain the moment as well.
pub(super) fn matters(evidence: Evidence<'_>, surface: Surface, delay_s: f64) -> Option<bool> {
    let TimedControl { moment, damping, .. } = CONTROLS.into_iter().find(|control| control.surface == surface)?;
    let fits = &evidence.snapshot.pooled.ready()?.fits;
    let fit = fits.iter().find(|fit| fit.coefficient == moment)?;
    let terms = moving_terms(evidence.session, fit);
    let used = used_windows(evidence.session, evidence.snapshot, fit);
    let terms = split(&terms, surface)?;
    let shifted = Shifted::new(moment, &terms, &used, Sides::Alike)?;
    let (now, then) = (shifted.at(0.0)?, shifted.at(delay_s)?);
    let (_, change) = largest_change(&terms, damping, &now, &then);
    let is_needed = then.squares <= CONFIRMED_LEFT * now.squares && change > CHANGE_CAUTION;
    Some(is_needed && !sides_explain(moment, &terms, &used, &then))
}

/// Whether a control that acts more to one side than to the other explains the moment as well as the delay of `late`: the sum of squared
/// residuals is no larger. So it is with a pair of ailerons of which one is recorded, where the linkage moves one further than the other.
fn sides_explain(moment: Coefficient, terms: &Terms, used: &[Used<'_>], late: &Estimates) -> bool {
    let sided = Shifted::new(moment, terms, used, Sides::Apart).and_then(|fit| fit.at(0.0));
    sided.is_some_and(|sided| sided.squares <= late.squares)
}

/// The term of the control or of the damping whose derivative changes most, as it is and as it becomes, and that change as a part of what
/// it becomes.
fn largest_change<'a>(
    terms: &'a Terms,
    damping: &[Variable],
    now: &Estimates,
    then: &Estimates,
) -> ((&'a Term, f64, f64), f64) {
    let change = |(_, was, is): &(&Term, f64, f64)| ((was - is) / is).abs();
    let damped = |term: &Term| damping.iter().any(|variable| is_one(term, *variable));
    let of_control = (&terms.control, now.control, then.control);
    let of_damping = terms.others.iter().position(damped);
    let of_damping = of_damping.map(|index| (&terms.others[index], now.others[index], then.others[index]));
    let largest = match of_damping {
        Some(of_damping) if change(&of_damping) > change(&of_control) => of_damping,
        _ => of_control,
    };
    (largest, change(&largest))
}

/// What the delays of controls do to the derivatives of `coefficient` by them and by the rates that damp: the worst of the controls.
pub(super) fn findings(
    evidence: Evidence<'_>,
    coefficient: Coefficient,
    terms: &[Term],
    used: &[Used<'_>],
) -> Option<Finding> {
    let of_control = |control: TimedControl| {
        let worst = control.worst(coefficient)?;
        let delay = evidence.delays.iter().find(|delay| delay.surface == control.surface)?;
        let terms = split(terms, control.surface)?;
        let fit = Shifted::new(coefficient, &terms, used, Sides::Alike)?;
        let (now, then) = (fit.at(0.0)?, fit.at(delay.delay_s)?);
        let ((term, was, is), change) = largest_change(&terms, control.damping, &now, &then);
        let level = match change {
            changed if changed > CHANGE_BAD => Level::Bad,
            changed if changed > CHANGE_CAUTION => Level::Caution,
            _ => return None,
        };
        let changed = message!("{} becomes {:.4} (was {:.4})", term.derivative_name(coefficient), is, was);
        Some(finding(evidence, delay, level.min(worst), changed))
    };
    CONTROLS.into_iter().filter_map(of_control).max_by_key(|finding| finding.level)
}

/// Attitude ahead of the rates, for moments and forces; for a force also flow angles or ground velocity ahead of the specific forces, or a
/// force that follows its regressors late. The inertial sensors are recorded late or filtered, and the coefficient lacks what that takes.
pub(super) fn find_late_inertial(evidence: Evidence<'_>, coefficient: Coefficient) -> Option<Finding> {
    let is_moment = matches!(coefficient, Coefficient::Cl | Coefficient::Cm | Coefficient::Cn);
    let lead = |kind, measurement| find_lead(evidence, kind, measurement, SensorDelay::SIGNIFICANT);
    let ground = || {
        let lead = find_lead(evidence, ConstantError::GroundDelay, Measurement::VelocityNorth, GROUND_ERRORS);
        let ahead_s = lead.filter(|_| !is_moment)?;
        Some((ahead_s, "accelerometers", "Ground velocity leads the specific forces"))
    };
    // The rates are regressors of a force, and flow angles follow them: where the gyros are late, forces and flow angles seem to be early.
    let attitude = || {
        let ahead_s = lead(ConstantError::AttitudeDelay, Measurement::BankAngle)?;
        Some((ahead_s, "gyros", "Attitude angles lead the rates"))
    };
    let flow = || {
        let ahead_s = lead(ConstantError::FlowDelay, Measurement::AngleOfAttack).filter(|_| !is_moment)?;
        Some((ahead_s, "accelerometers", "Flow angles lead the specific forces"))
    };
    let force = || {
        let late = evidence.late_force.filter(|late| !is_moment && late.delay_s > AHEAD_S)?;
        Some((late.delay_s, "accelerometers", late.text))
    };
    let (late_s, sensors, text) = ground().or_else(attitude).or_else(flow).or_else(force)?;
    let text = message!("{} by {:.3} s (limit {:.3} s).", text, late_s, AHEAD_S);
    let finding = Finding::new(Level::Caution, "timing", sensors, text).with_figure(late_s, AHEAD_S);
    let fix_text = format!("Record the {sensors} without a filter; check their clock.");
    let inputs = if sensors == "gyros" { &Input::ALL[3..] } else { &Input::ALL[..3] };
    let fix = remedies::shift_inertial(evidence.session, evidence.snapshot, inputs, late_s);
    Some(finding.with_fix_text(fix_text).with_setting("Preprocess", "flight.clock").with_fix(fix))
}

/// Time by which measurements lead the inertial sensors, s, where it is beyond so many standard errors and beyond the limit.
fn find_lead(evidence: Evidence<'_>, kind: ConstantError, measurement: Measurement, errors: f64) -> Option<f64> {
    let mut delays = evidence.snapshot.delays_and_gusts.delays.iter().flat_map(|delays| &delays.0);
    let found = delays.find(|delay| delay.kind == kind && delay.is_beyond(errors))?;
    let ahead_s = -(evidence.session.filter.measurement_delay_s[measurement as usize] + found.delay_s);
    (ahead_s > AHEAD_S).then_some(ahead_s)
}

fn finding(evidence: Evidence<'_>, delay: &ControlDelay, level: Level, changed: Message) -> Finding {
    let ControlDelay { surface, moment, delay_s, sample_s, left } = *delay;
    let name = surface.name();
    let text = message!(
        "{} delay must change by {:+.3} s: this leaves {:.0} % of the {} residual; {}.",
        name,
        delay_s,
        100.0 * left,
        moment.name(),
        changed
    );
    let finding = Finding::new(level, "timing", name, text).with_figure(delay_s, SAMPLES * sample_s);
    let stated_s = evidence.session.preparation.control_lags.get(surface).delay_s;
    let why = if delay_s.abs() < sample_s {
        "Record it faster"
    } else if delay_s < 0.0 {
        "Check the clock of its recorder"
    } else {
        "Record the surface, not the command; check its clock"
    };
    let fix_text = format!("{why}, or apply a delay of {:.3} s.", stated_s + delay_s);
    let finding =
        finding.with_fix_text(fix_text).with_setting("Model", format!("preparation.control_lag.{name}.delay_s"));
    let fix = Fix::control_delay(evidence.session, surface, stated_s + delay_s);
    finding.with_value(format!("{:.3}", stated_s + delay_s)).with_fix(fix)
}

/// Whether a term is this variable alone.
pub(super) fn is_one(term: &Term, variable: Variable) -> bool {
    matches!(*term.factors(), [(one, 1)] if one == variable)
}

/// The term of a control, and the others.
struct Terms {
    control: Term,
    others: Vec<Term>,
}

fn split(terms: &[Term], surface: Surface) -> Option<Terms> {
    let control = terms.iter().find(|term| is_one(term, surface.variable()))?.clone();
    let others = terms.iter().filter(|term| **term != control).cloned().collect();
    Some(Terms { control, others })
}

/// Mean interval of the samples of a control in a window, s.
fn interval_s(snapshot: &Snapshot, surface: Surface, window: &Manoeuvre) -> Option<f64> {
    let recording = &snapshot.flights.get(&window.flight)?.ready()?.recording;
    mean_interval_s(&recording.role(surface.role())?.series, window.window)
}

fn mean_interval_s(series: &Series, window: TimeRange) -> Option<f64> {
    let time_s = &series.time_s[window.indices(&series.time_s)];
    (time_s.len() > 1).then(|| (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64)
}

/// A window's control on its time, about its mean, with its slope behind every sample.
struct Control {
    time_s: Arc<[f64]>,
    values: DVector<f64>,
    slopes: Vec<f64>,
}

impl Control {
    fn new(time_s: Arc<[f64]>, values: &[f64]) -> Self {
        let values = centred(values);
        let slope = |k: usize| (values[k] - values[k - 1]) / (time_s[k] - time_s[k - 1]);
        let slopes = (1..time_s.len()).map(slope).collect();
        Self { time_s, values, slopes }
    }

    /// The control as it would act `delay_s` late; before its first sample and behind its last as there.
    fn late(&self, delay_s: f64) -> DVector<f64> {
        let (time_s, last) = (&self.time_s, self.time_s.len() - 1);
        let mut next = 1;
        let at = |time: &f64| {
            let time = (time - delay_s).clamp(time_s[0], time_s[last]);
            while next < last && time_s[next] <= time {
                next += 1;
            }
            self.values[next - 1] + self.slopes[next - 1] * (time - time_s[next - 1])
        };
        DVector::from_iterator(time_s.len(), time_s.iter().map(at))
    }
}

/// How the two sides of a control act.
#[derive(Clone, Copy, PartialEq)]
enum Sides {
    /// By one derivative.
    Alike,
    /// Each by its own.
    Apart,
}

/// Least squares of a moment with a constant per window, the control at any delay.
struct Shifted {
    controls: Vec<Control>,
    /// Other regressors and the moment, each about its mean in every window.
    others: Vec<DMatrix<f64>>,
    moments: Vec<DVector<f64>>,
    normal: Cholesky<f64, Dyn>,
    projected: DVector<f64>,
    squares: f64,
    step_s: f64,
}

/// Estimates at one delay.
struct Estimates {
    control: f64,
    others: DVector<f64>,
    /// Sum of squares of the residual.
    squares: f64,
}

impl Shifted {
    fn new(
        coefficient: Coefficient,
        Terms { control, others }: &Terms,
        used: &[Used<'_>],
        sides: Sides,
    ) -> Option<Self> {
        let (mut controls, mut columns, mut moments) = (Vec::new(), Vec::new(), Vec::new());
        let (mut spans_s, mut samples) = (0.0, 0_usize);
        for Used { aero, .. } in used {
            let time_s = Arc::clone(&aero.coefficients.time_s);
            if time_s.len() < 2 {
                return None;
            }
            spans_s += aero.covered_s();
            samples += time_s.len() - 1;
            let column: DMatrix<f64> = regressors(std::slice::from_ref(control), &aero.variables).ok()?;
            let mut of_others: DMatrix<f64> = regressors(others, &aero.variables).ok()?;
            if sides == Sides::Apart {
                let trim = median(&mut column.as_slice().to_vec())?;
                let size = column.map(|deflection| (deflection - trim).abs());
                of_others = of_others.insert_column(others.len(), 0.0);
                of_others.set_column(others.len(), &size.column(0));
            }
            controls.push(Control::new(time_s, column.as_slice()));
            columns.push(about_mean(of_others));
            moments.push(centred(aero.coefficients.get(coefficient)));
        }
        let count = columns.first()?.ncols();
        let mut normal = DMatrix::zeros(count, count);
        let mut projected = DVector::zeros(count);
        for (columns, moment) in columns.iter().zip(&moments) {
            normal += columns.tr_mul(columns);
            projected += columns.tr_mul(moment);
        }
        let squares = moments.iter().map(DVector::norm_squared).sum();
        let step_s = spans_s / samples.max(1) as f64;
        Some(Self { controls, others: columns, moments, normal: normal.cholesky()?, projected, squares, step_s })
    }

    /// The fit with the control `delay_s` late; none where the control does what the others do.
    fn at(&self, delay_s: f64) -> Option<Estimates> {
        let mut with_others = DVector::zeros(self.projected.len());
        let (mut square, mut with_moment) = (0.0, 0.0);
        for ((control, columns), moment) in self.controls.iter().zip(&self.others).zip(&self.moments) {
            let late = control.late(delay_s);
            // What is about its mean does not see that of the control.
            with_others.gemv_tr(1.0, columns, &late, 1.0);
            square += late.norm_squared() - late.sum() * late.mean();
            with_moment += late.dot(moment);
        }
        let own = square - with_others.dot(&self.normal.solve(&with_others));
        if own <= 1e-6 * square {
            return None;
        }
        let without = self.normal.solve(&self.projected);
        let left = with_moment - with_others.dot(&without);
        let control = left / own;
        let others = self.normal.solve(&(&self.projected - control * &with_others));
        let squares = self.squares - self.projected.dot(&without) - left * control;
        Some(Estimates { control, others, squares: squares.max(f64::MIN_POSITIVE) })
    }

    /// The delay that leaves least, at the tip of the parabola through it and its neighbours.
    fn best(&self, step_s: f64) -> Option<(f64, Estimates)> {
        let most = (RANGE_S / step_s).round() as i32;
        let coarse = ((COARSE_S / step_s) as i32).max(1);
        let left = |step: i32| match step.abs() <= most {
            true => self.at(f64::from(step) * step_s).map_or(f64::INFINITY, |found| found.squares),
            false => f64::INFINITY,
        };
        let least_of = |steps: &mut dyn Iterator<Item = i32>| {
            steps.map(|step| (step, left(step))).min_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        let (near, _) = least_of(&mut (-most..=most).step_by(coarse as usize))?;
        let (least, squares) = least_of(&mut (near - coarse + 1..near + coarse))?;
        let (before, after) = (left(least - 1), left(least + 1));
        let bend = before - 2.0 * squares + after;
        let tip = if bend > 0.0 && bend.is_finite() { 0.5 * (before - after) / bend } else { 0.0 };
        let delay_s = (f64::from(least) + tip) * step_s;
        Some((delay_s, self.at(delay_s)?))
    }
}

fn centred(values: &[f64]) -> DVector<f64> {
    let values = DVector::from_column_slice(values);
    let mean = values.mean();
    values.add_scalar(-mean)
}

fn about_mean(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    columns
}
