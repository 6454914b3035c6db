//! The study of linear model, modes and flying qualities as rows: section `dynamics` of `results.json` and output of the commands.

use std::collections::BTreeMap;

use doublet_dynamics::linear::{Part, Quantity, SIGNS, StateSpace};
use doublet_dynamics::modes::{Figure, MeasuredMode, ModeEstimate, phasors};
use doublet_dynamics::propagate::Interval;
use doublet_dynamics::qualities::{Judgement, LevelShares, Measure, Measures, Quality, QualityLevel, measure_interval};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::study::DynamicsStudy;
use crate::study::dynamics::{MapPoint, MeasuredWindow};

/// How the identified aircraft flies at one trim.
#[derive(Clone, Debug, Serialize)]
pub struct DynamicsRow {
    /// Manoeuvres whose median conditions are the defaults.
    pub windows: Vec<String>,
    pub trim: TrimRow,
    /// Meaning of the signs.
    pub signs: &'static str,
    /// Linear models of the parts of the motion.
    pub systems: BTreeMap<&'static str, LinearRow>,
    /// Natural modes, fastest first.
    pub modes: Vec<ModeRow>,
    /// Modes measured in the free responses of the manoeuvres.
    pub measured: Vec<MeasuredRow>,
    /// Draws of the derivatives behind the sampled intervals and the probabilities.
    pub samples: usize,
    pub seed: u64,
    /// Levels of flying qualities.
    pub qualities: QualitiesRow,
    pub notes: Vec<String>,
}

/// A steady flight.
#[derive(Clone, Debug, Serialize)]
pub struct TrimRow {
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    pub density_kg_m3: f64,
    pub gravity_m_s2: f64,
    pub gamma_rad: f64,
    pub load_factor: f64,
    pub alpha_rad: f64,
    pub phi_rad: f64,
    pub theta_rad: f64,
    pub p_rad_s: f64,
    pub q_rad_s: f64,
    pub r_rad_s: f64,
    pub delta_a_rad: f64,
    pub delta_e_rad: f64,
    pub delta_r_rad: f64,
    pub thrust_n: f64,
    pub thrust_slope_n_s_m: f64,
    pub mass_kg: f64,
    pub cg_from_datum_m: [f64; 3],
    pub ixx_kg_m2: f64,
    pub iyy_kg_m2: f64,
    pub izz_kg_m2: f64,
    pub ixz_kg_m2: f64,
}

/// A linear model; matrices row by row.
#[derive(Clone, Debug, Serialize)]
#[expect(non_snake_case, reason = "keys as every tool for control calls them")]
pub struct LinearRow {
    pub states: Vec<String>,
    pub state_units: Vec<String>,
    pub inputs: Vec<String>,
    pub input_units: Vec<String>,
    pub outputs: Vec<String>,
    pub output_units: Vec<String>,
    pub A: Vec<Vec<f64>>,
    pub B: Vec<Vec<f64>>,
    pub C: Vec<Vec<f64>>,
    pub D: Vec<Vec<f64>>,
    pub A_standard_error: Vec<Vec<f64>>,
    pub B_standard_error: Vec<Vec<f64>>,
    /// Covariance of the entries of `[A B]`, column by column; of models of up to four states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

/// A 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct IntervalRow {
    pub standard_error: f64,
    pub low: f64,
    pub high: f64,
}

/// Intervals of a figure of a mode.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FigureRow {
    /// By the slopes of the eigenvalue over the derivatives.
    pub delta: Option<IntervalRow>,
    /// By quantiles of samples.
    pub sampled: Option<IntervalRow>,
}

/// A natural mode.
#[derive(Clone, Debug, Serialize)]
pub struct ModeRow {
    pub name: &'static str,
    /// Why its values are not judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_judged: Option<&'static str>,
    /// Undamped natural frequency.
    pub frequency_rad_s: f64,
    /// Damping ratio; 1 or -1 for an aperiodic mode.
    pub damping: f64,
    /// Real part of the eigenvalue.
    pub real_1_s: f64,
    /// Imaginary part, not negative.
    pub imaginary_rad_s: f64,
    /// Time to half the amplitude, of a stable mode.
    pub time_to_half_s: Option<f64>,
    /// Time to double the amplitude, of an unstable mode.
    pub time_to_double_s: Option<f64>,
    /// Period of the damped oscillation.
    pub period_s: Option<f64>,
    /// Intervals by the keys above.
    pub intervals: BTreeMap<&'static str, FigureRow>,
    /// Share of the samples in which it oscillates.
    pub oscillating_share: f64,
    /// Share of the samples in which it is stable.
    pub stable_share: f64,
    /// Variance of the real and of the imaginary part, and their covariance.
    pub covariance: [f64; 3],
    /// Share of each state in it.
    pub participation: BTreeMap<String, f64>,
    /// Magnitude and phase, rad, of each state, the one with the largest share being one.
    pub phasors: BTreeMap<String, [f64; 2]>,
}

/// A mode measured in the free response of a window.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredRow {
    /// Manoeuvre.
    pub window: String,
    /// Start of the free response.
    pub start_s: f64,
    /// Its end.
    pub end_s: f64,
    /// Nearest mode of the model.
    pub name: Option<&'static str>,
    /// Undamped natural frequency.
    pub frequency_rad_s: Option<f64>,
    /// Damping ratio.
    pub damping: Option<f64>,
    /// Real part of the eigenvalue.
    pub real_1_s: Option<f64>,
    /// Its standard error by the fit.
    pub real_standard_error: Option<f64>,
    /// Imaginary part.
    pub imaginary_rad_s: Option<f64>,
    /// Its standard error by the fit.
    pub imaginary_standard_error: Option<f64>,
    /// Why the measurement failed.
    pub error: Option<String>,
}

/// Levels of flying qualities.
#[derive(Clone, Debug, Serialize)]
pub struct QualitiesRow {
    pub standard: String,
    pub date: String,
    /// Class of the aircraft.
    pub class: &'static str,
    /// Category of the flight phase.
    pub category: &'static str,
    /// Source of class and category.
    pub airplane_from: String,
    /// Delay from stick to surfaces, if stated.
    pub stick_delay_s: Option<f64>,
    /// Aileron deflection available from the trim, if stated.
    pub aileron_rad: Option<f64>,
    /// Worst level of the criteria judged.
    pub level: Option<&'static str>,
    /// Probability of each level: Level 1, 2, 3, worse.
    pub probabilities: Option<[f64; 4]>,
    pub criteria: Vec<QualityRow>,
    /// Note on the definitions.
    pub note: String,
    /// Levels at every condition that was flown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub map: Vec<LevelMapRow>,
}

/// Levels of the model trimmed at a condition that was flown.
#[derive(Clone, Debug, Serialize)]
pub struct LevelMapRow {
    /// True airspeed.
    pub airspeed_m_s: f64,
    /// Altitude.
    pub altitude_m: f64,
    /// Mass.
    pub mass_kg: f64,
    /// Manoeuvres flown there.
    pub windows: Vec<String>,
    /// Worst level of the criteria that count.
    pub level: Option<&'static str>,
    /// Level of each criterion that is judged and counts.
    pub criteria: BTreeMap<String, &'static str>,
}

/// One criterion.
#[derive(Clone, Debug, Serialize)]
pub struct QualityRow {
    pub criterion: String,
    /// Its level, or `not judged`.
    pub level: &'static str,
    /// Standard with its date.
    pub standard: String,
    /// Paragraph, figure and page.
    pub source: String,
    /// Judged values.
    pub values: BTreeMap<&'static str, Option<f64>>,
    /// Their 95 % intervals, by samples.
    pub intervals: BTreeMap<&'static str, IntervalRow>,
    /// Limits missed for Level 1, or why it is not judged.
    pub reasons: Vec<String>,
    /// What is needed to judge it, where it is not judged.
    pub needed: Option<String>,
    /// Whether it counts: unverified limits and guidance do not.
    pub counts: bool,
    /// Whether its limits are guidance for design.
    pub guidance: bool,
    /// Probability of each level: Level 1, 2, 3, worse.
    pub probabilities: Option<[f64; 4]>,
}

impl QualitiesRow {
    /// How many criteria are judged, in words.
    pub fn extent(&self) -> String {
        let judged = self.criteria.iter().filter(|row| row.is_judged() && row.counts).count();
        format!("{judged} of {} criteria judged and counted", self.criteria.len())
    }
}

impl QualityRow {
    /// Whether it has a level.
    pub fn is_judged(&self) -> bool {
        self.needed.is_none()
    }

    /// Its level; in brackets with the reason where it does not count.
    pub fn level_text(&self) -> String {
        match (self.counts || !self.is_judged(), self.guidance) {
            (true, _) => self.level.to_owned(),
            (false, true) => format!("({}, guidance)", self.level),
            (false, false) => format!("({}, unverified limits)", self.level),
        }
    }

    /// Probability of its level, 0 to 1.
    pub fn probability(&self) -> Option<f64> {
        let place = QualityLevel::ALL.into_iter().position(|level| level.name() == self.level)?;
        self.probabilities.map(|shares| shares[place])
    }

    /// Its values with units and 95 % intervals, `number` being how a number is written.
    pub fn value_texts(&self, number: impl Fn(f64) -> String) -> Vec<String> {
        let text = |(key, value): (&&'static str, &Option<f64>)| {
            let measure = Measure::ALL.iter().find(|measure| measure.key() == *key);
            let (name, unit) = measure.map_or((*key, "-"), |measure| (measure.text(), measure.unit()));
            let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
            let value = value.map_or_else(|| "infinite".to_owned(), |value| format!("{}{unit}", number(value)));
            let ends = self.intervals.get(key).map(|row| format!(" [{}, {}]", number(row.low), number(row.high)));
            format!("{name} {value}{}", ends.unwrap_or_default())
        };
        self.values.iter().map(text).collect()
    }
}

pub fn dynamics_row(study: &DynamicsStudy) -> DynamicsRow {
    let linearised = &study.modes.linearised;
    let parts = Part::ALL.into_iter().filter(|part| part.within(linearised.trim.motion));
    DynamicsRow {
        windows: study.windows.clone(),
        trim: trim_row(study),
        signs: SIGNS,
        systems: parts.map(|part| (part.name(), linear_row(study, part))).collect(),
        modes: mode_rows(study),
        measured: study.measured.iter().flat_map(measured_rows).collect(),
        samples: study.modes.samples.len(),
        seed: study.request.seed,
        qualities: qualities_row(study),
        notes: study.notes.clone(),
    }
}

/// Natural modes of a study, fastest first.
pub fn mode_rows(study: &DynamicsStudy) -> Vec<ModeRow> {
    let motion = study.modes.linearised.motion();
    study.modes.modes.iter().map(|estimate| mode_row(estimate, &motion, study.speed_not_judged)).collect()
}

fn trim_row(study: &DynamicsStudy) -> TrimRow {
    let trim = &study.modes.linearised.trim;
    let (condition, mass) = (&trim.condition, &trim.condition.mass);
    let ([phi, theta, _], [p, q, r], [aileron, elevator, rudder]) =
        (trim.euler_rad, trim.rates_rad_s, trim.controls_rad);
    TrimRow {
        airspeed_m_s: condition.airspeed_m_s,
        altitude_m: condition.altitude_m,
        density_kg_m3: condition.density_kg_m3,
        gravity_m_s2: condition.gravity_m_s2,
        gamma_rad: trim.gamma_rad,
        load_factor: trim.load_factor(),
        alpha_rad: trim.alpha_rad,
        phi_rad: phi,
        theta_rad: theta,
        p_rad_s: p,
        q_rad_s: q,
        r_rad_s: r,
        delta_a_rad: aileron,
        delta_e_rad: elevator,
        delta_r_rad: rudder,
        thrust_n: trim.thrust_n,
        thrust_slope_n_s_m: condition.thrust_slope_n_s_m,
        mass_kg: mass.mass_kg,
        cg_from_datum_m: mass.cg_from_datum_m,
        ixx_kg_m2: mass.inertia.xx,
        iyy_kg_m2: mass.inertia.yy,
        izz_kg_m2: mass.inertia.zz,
        ixz_kg_m2: mass.inertia.xz,
    }
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn linear_row(study: &DynamicsStudy, part: Part) -> LinearRow {
    /// Most states of a model whose covariance is written out.
    const STATES: usize = 4;
    let model = study.modes.linearised.part(part);
    let covariance = study.modes.sensitivities.covariance(&study.model, part);
    let (n, m) = (model.a.nrows(), model.b.ncols());
    let error =
        |place: usize| if place < covariance.nrows() { covariance[(place, place)].max(0.0).sqrt() } else { 0.0 };
    let names = |of: &[Quantity]| of.iter().map(|quantity| quantity.name.clone()).collect();
    let units = |of: &[Quantity]| of.iter().map(|quantity| quantity.unit.clone()).collect();
    LinearRow {
        states: names(&model.states),
        state_units: units(&model.states),
        inputs: names(&model.inputs),
        input_units: units(&model.inputs),
        outputs: names(&model.outputs),
        output_units: units(&model.outputs),
        A_standard_error: rows(&DMatrix::from_fn(n, n, |i, j| error(j * n + i))),
        B_standard_error: rows(&DMatrix::from_fn(n, m, |i, j| error((n + j) * n + i))),
        covariance: if n <= STATES { rows(&covariance) } else { Vec::new() },
        A: rows(&model.a),
        B: rows(&model.b),
        C: rows(&model.c),
        D: rows(&model.d),
    }
}

fn interval(interval: Interval) -> IntervalRow {
    let Interval { standard_error, low, high } = interval;
    IntervalRow { standard_error, low, high }
}

/// Key of a figure of a mode.
fn figure_key(figure: Figure, stable: bool) -> &'static str {
    match figure {
        Figure::Real => "real_1_s",
        Figure::Imaginary => "imaginary_rad_s",
        Figure::Frequency => "frequency_rad_s",
        Figure::Damping => "damping",
        Figure::Time if stable => "time_to_half_s",
        Figure::Time => "time_to_double_s",
        Figure::Period => "period_s",
    }
}

fn mode_row(estimate: &ModeEstimate, motion: &StateSpace, speed_not_judged: Option<&'static str>) -> ModeRow {
    let mode = &estimate.mode;
    let stable = mode.is_stable();
    let largest = mode.participation.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index);
    let phasors = phasors(mode, largest);
    let name = |index: usize| motion.states.get(index).map(|state| state.name.clone()).unwrap_or_default();
    ModeRow {
        name: mode.name,
        not_judged: speed_not_judged.filter(|_| mode.name.ends_with("phugoid")),
        frequency_rad_s: mode.frequency_rad_s(),
        damping: mode.damping(),
        real_1_s: mode.real_1_s,
        imaginary_rad_s: mode.imaginary_rad_s,
        time_to_half_s: mode.time_to_half_s(),
        time_to_double_s: mode.time_to_double_s(),
        period_s: mode.period_s(),
        intervals: estimate
            .figures
            .iter()
            .map(|found| {
                let row = FigureRow { delta: found.delta.map(interval), sampled: found.sampled.map(interval) };
                (figure_key(found.figure, stable), row)
            })
            .collect(),
        oscillating_share: estimate.oscillating,
        stable_share: estimate.stable,
        covariance: estimate.covariance,
        participation: mode.participation.iter().enumerate().map(|(index, share)| (name(index), *share)).collect(),
        phasors: phasors.iter().enumerate().map(|(index, value)| (name(index), [value.norm(), value.arg()])).collect(),
    }
}

fn measured_rows(found: &MeasuredWindow) -> Vec<MeasuredRow> {
    match &found.modes {
        Ok(modes) => modes.iter().map(|mode| measured_row(found, Some(mode), None)).collect(),
        Err(error) => vec![measured_row(found, None, Some(error.clone()))],
    }
}

fn measured_row(
    found: &MeasuredWindow,
    mode: Option<&(Option<&'static str>, MeasuredMode)>,
    error: Option<String>,
) -> MeasuredRow {
    let [start_s, end_s] = found.span_s;
    let finite_value =
        |value: &dyn Fn(&MeasuredMode) -> f64| mode.map(|(_, mode)| value(mode)).filter(|value| value.is_finite());
    MeasuredRow {
        window: found.window.clone(),
        start_s,
        end_s,
        name: mode.and_then(|(name, _)| *name),
        frequency_rad_s: finite_value(&MeasuredMode::frequency_rad_s),
        damping: finite_value(&MeasuredMode::damping),
        real_1_s: finite_value(&|mode| mode.real_1_s),
        real_standard_error: finite_value(&|mode| mode.real_error),
        imaginary_rad_s: finite_value(&|mode| mode.imaginary_rad_s),
        imaginary_standard_error: finite_value(&|mode| mode.imaginary_error),
        error,
    }
}

/// Levels of flying qualities of a study.
pub fn qualities_row(study: &DynamicsStudy) -> QualitiesRow {
    let Judgement { qualities, level } = &study.judgement;
    QualitiesRow {
        standard: study.limits.name.clone(),
        date: study.limits.date.to_string(),
        class: study.airplane.class,
        category: study.airplane.category,
        airplane_from: study.airplane_from.clone(),
        level: level.map(QualityLevel::name),
        probabilities: probabilities(&study.shares, "all"),
        criteria: qualities
            .iter()
            .map(|quality| quality_row(quality, &study.shares, &study.sampled, study.speed_not_judged))
            .collect(),
        stick_delay_s: study.request.stick_delay_s,
        aileron_rad: study.request.aileron_rad,
        note: study.limits.note.clone(),
        map: study.map.iter().map(level_map_row).collect(),
    }
}

fn level_map_row(point: &MapPoint) -> LevelMapRow {
    let counted = point.judgement.qualities.iter().filter(|quality| quality.counts);
    LevelMapRow {
        airspeed_m_s: point.airspeed_m_s,
        altitude_m: point.altitude_m,
        mass_kg: point.mass_kg,
        windows: point.windows.clone(),
        level: point.judgement.level.map(QualityLevel::name),
        criteria: counted.filter_map(|quality| Some((quality.criterion.clone(), quality.level?.name()))).collect(),
    }
}

/// Probability of each level of a criterion.
pub(super) fn probabilities(shares: &[LevelShares], criterion: &str) -> Option<[f64; 4]> {
    shares.iter().find(|row| row.criterion == criterion && row.judged > 0).map(|row| row.shares)
}

/// A criterion with the probabilities of its levels; `speed_not_judged` says why what depends on the thrust is not judged.
pub(super) fn quality_row(
    quality: &Quality,
    shares: &[LevelShares],
    samples: &[Measures],
    speed_not_judged: Option<&'static str>,
) -> QualityRow {
    let is_unjudged = quality.level.is_none() && quality.measures.iter().any(|measure| measure.is_of_speed());
    let unjudged = speed_not_judged.filter(|_| is_unjudged).map(str::to_owned);
    let value = |(measure, value): &(Measure, f64)| (measure.key(), value.is_finite().then_some(*value));
    QualityRow {
        criterion: quality.criterion.clone(),
        level: quality.level.map_or("not judged", QualityLevel::name),
        values: quality.values.iter().map(value).collect(),
        intervals: quality
            .values
            .iter()
            .filter_map(|(measure, _)| Some((measure.key(), interval(measure_interval(samples, *measure)?))))
            .collect(),
        standard: quality.standard.clone(),
        source: quality.source.clone(),
        reasons: quality.reasons.iter().map(ToString::to_string).chain(unjudged).collect(),
        needed: quality.needed.clone(),
        counts: quality.counts,
        guidance: quality.is_guidance,
        probabilities: probabilities(shares, &quality.criterion),
    }
}
