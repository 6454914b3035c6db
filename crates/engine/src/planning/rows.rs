//! A design as rows: output of the command.

use std::collections::BTreeMap;

use doublet_core::model::regressors;
use doublet_core::quantity::InstrumentError;
use doublet_dynamics::design::{
    Basis, CONTROLS, Criterion, DesignKind, Designed, Limit, PlannedManoeuvre, Request, SURFACE_NAMES, THROTTLE,
    design, relative_peak_factor, window_variables,
};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::graph::StageResult;
use crate::notation::{self, significant};

/// A design and what it promises.
#[derive(Clone, Debug, Default, Serialize)]
pub struct DesignRow {
    /// Kind of input.
    pub kind: &'static str,
    /// Surfaces moved.
    pub surfaces: Vec<&'static str>,
    /// Time of all windows together, s.
    pub time_s: f64,
    /// What was made small.
    pub criterion: &'static str,
    /// Cost by every criterion.
    pub costs: BTreeMap<&'static str, f64>,
    pub trim: BTreeMap<&'static str, f64>,
    /// Standard deviation of the gusts, m/s.
    pub gust_m_s: f64,
    /// Standard deviations of constant errors of the instruments, as the session shows them.
    pub sensor_accuracy: BTreeMap<InstrumentError, f64>,
    /// Band of the modes that the surfaces excite, Hz.
    pub band_hz: [f64; 2],
    /// Derivatives with the errors to expect.
    pub predicted: Vec<PredictedRow>,
    /// How far the aircraft goes.
    pub excursions: Vec<ExcursionRow>,
    pub manoeuvres: Vec<ManoeuvreRow>,
    /// Nodes of the input, straight lines between them.
    pub signal: Vec<SignalRow>,
    /// Correlations of regressors.
    pub correlations: Vec<CorrelationRow>,
    /// Draws of the derivatives with gusts and a start of their own.
    pub samples: usize,
    /// Draws without a trim or whose flight ended.
    pub failed_samples: usize,
    pub seed: u64,
    /// The same by other kinds of input.
    pub comparison: Vec<ComparedKind>,
    /// What is to be known of it.
    pub notes: Vec<String>,
}

/// A derivative with the errors to expect.
#[derive(Clone, Debug, Serialize)]
pub struct PredictedRow {
    pub name: String,
    pub estimate: f64,
    pub standard_error: Option<f64>,
    pub corrected: Option<f64>,
    pub relative_error_percent: Option<f64>,
    pub corrected_high: Option<f64>,
    pub present: f64,
    pub path_error: Option<f64>,
    pub promised: Option<f64>,
    /// Mean square of the scatter between the manoeuvres over the variance by noise.
    #[serde(skip)]
    pub scatter_share: f64,
}

/// How far one quantity goes.
#[derive(Clone, Debug, Serialize)]
pub struct ExcursionRow {
    pub name: &'static str,
    pub unit: &'static str,
    pub trim: f64,
    pub nominal_low: f64,
    pub nominal_high: f64,
    pub low: f64,
    pub high: f64,
    pub limit_low: Option<f64>,
    pub limit_high: Option<f64>,
    pub limit_source: Option<String>,
    pub margin: Option<f64>,
}

impl ExcursionRow {
    /// Its name as people read it.
    pub fn title(&self) -> &str {
        notation::role_symbol(self.name)
    }

    /// Whether its extreme is beyond a limit.
    pub fn is_beyond_limit(&self) -> bool {
        self.margin.is_some_and(|margin| margin < 0.0)
    }

    /// By how much its extreme is beyond the limit; none where it is within or has none.
    pub fn warning(&self) -> Option<String> {
        let (unit, factor) = notation::shown(self.unit).unwrap_or((self.unit, 1.0));
        let beyond = significant(-factor * self.margin.filter(|_| self.is_beyond_limit())?, 2);
        let source = self.limit_source.as_deref().unwrap_or("limit");
        Some(format!("do not fly unchanged: {} is expected {beyond} {unit} beyond its limit ({source})", self.title()))
    }
}

/// A window.
#[derive(Clone, Debug, Serialize)]
pub struct ManoeuvreRow {
    pub number: usize,
    pub name: String,
    pub surfaces: Vec<&'static str>,
    pub duration_s: f64,
    pub peak_rad: BTreeMap<&'static str, f64>,
    pub rate_rad_s: BTreeMap<&'static str, f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_thrust_n: Option<f64>,
    pub relative_peak_factor: BTreeMap<&'static str, f64>,
}

/// A node of the input: time since the start of the window, deflections and thrust about the trim.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SignalRow {
    pub manoeuvre: usize,
    pub time_s: f64,
    pub aileron: f64,
    pub elevator: f64,
    pub rudder: f64,
    pub thrust_n: f64,
}

/// Correlation of two regressors over the windows, each less its mean there.
#[derive(Clone, Debug, Serialize)]
pub struct CorrelationRow {
    pub first: String,
    pub second: String,
    pub correlation: f64,
}

/// Another kind of input, within the same limits and time.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedKind {
    pub kind: &'static str,
    pub costs: BTreeMap<&'static str, f64>,
    pub worst: Option<String>,
    pub worst_relative_error_percent: Option<f64>,
    pub error: Option<String>,
}

pub fn design_row(basis: &Basis, request: &Request, designed: &Designed) -> DesignRow {
    let trim = &designed.plant.trim;
    let condition = &trim.condition;
    let own_limit = |quantity| basis.limits.motion.iter().find(|limit| limit.quantity == quantity);
    DesignRow {
        kind: designed.kind.name(),
        surfaces: names(&request.surfaces),
        time_s: designed.manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s).sum(),
        criterion: request.criterion.name(),
        costs: costs(designed.costs),
        trim: BTreeMap::from([
            ("airspeed_m_s", condition.airspeed_m_s),
            ("altitude_m", condition.altitude_m),
            ("mass_kg", condition.mass.mass_kg),
            ("alpha_rad", trim.alpha_rad),
            ("theta_rad", trim.euler_rad[1]),
            ("phi_rad", trim.euler_rad[0]),
            ("aileron_rad", trim.controls_rad[0]),
            ("elevator_rad", trim.controls_rad[1]),
            ("rudder_rad", trim.controls_rad[2]),
        ]),
        gust_m_s: basis.gust_m_s,
        sensor_accuracy: BTreeMap::new(),
        band_hz: designed.band_hz,
        predicted: predicted(designed),
        excursions: designed.excursions.iter().map(|own| excursion(own, own_limit(own.quantity))).collect(),
        manoeuvres: manoeuvres(designed),
        signal: signal(designed),
        correlations: correlations(basis, designed),
        samples: request.samples,
        failed_samples: designed.failed_samples,
        seed: request.seed,
        comparison: Vec::new(),
        notes: Vec::new(),
    }
}

pub(super) fn names(surfaces: &[usize]) -> Vec<&'static str> {
    surfaces.iter().filter_map(|&surface| SURFACE_NAMES.get(surface).copied()).collect()
}

fn costs(costs: [f64; 3]) -> BTreeMap<&'static str, f64> {
    Criterion::ALL.iter().map(|criterion| criterion.name()).zip(costs).collect()
}

/// Designs an input and says what it promises, with `compare` beside every other kind within the same limits and time. `goes_on` is asked
/// before each kind.
pub fn designed_rows(
    basis: &Basis,
    request: &Request,
    compare: bool,
    goes_on: &dyn Fn() -> StageResult<()>,
) -> StageResult<(DesignRow, Designed)> {
    let designed = design(basis, request).map_err(|error| error.to_string())?;
    let mut row = design_row(basis, request, &designed);
    for kind in DesignKind::ALL.into_iter().filter(|_| compare) {
        goes_on()?;
        if kind == request.kind {
            row.comparison.push(compared(kind.name(), Ok(&designed)));
            continue;
        }
        let other = design(basis, &Request { kind, samples: 0, ..request.clone() });
        row.comparison.push(compared(kind.name(), other.as_ref().map_err(ToString::to_string)));
    }
    if row.failed_samples > 0 {
        row.notes.push(format!("{} of {} draws have no trim or left the flight", row.failed_samples, row.samples));
    }
    row.notes.extend(row.excursions.iter().filter_map(ExcursionRow::warning));
    Ok((row, designed))
}

/// A design of another kind, or why there is none, for the comparison.
fn compared(kind: &'static str, found: Result<&Designed, String>) -> ComparedKind {
    match found {
        Ok(designed) => {
            let rows = designed.prediction.derivatives.iter().zip(designed.prediction.relative_errors());
            let worst = rows.max_by(|a, b| a.1.total_cmp(&b.1));
            ComparedKind {
                kind,
                costs: costs(designed.costs),
                worst: worst.map(|(derivative, _)| derivative.name.clone()),
                worst_relative_error_percent: worst.map(|(_, error)| 100.0 * error).filter(|error| error.is_finite()),
                error: None,
            }
        }
        Err(error) => ComparedKind {
            kind,
            costs: BTreeMap::new(),
            worst: None,
            worst_relative_error_percent: None,
            error: Some(error),
        },
    }
}

fn predicted(designed: &Designed) -> Vec<PredictedRow> {
    let rows = designed.prediction.derivatives.iter().zip(&designed.high_errors);
    rows.map(|(derivative, high)| PredictedRow {
        name: derivative.name.clone(),
        estimate: derivative.estimate,
        standard_error: derivative.standard_error,
        corrected: derivative.corrected,
        relative_error_percent: derivative.corrected.map(|error| 100.0 * error / derivative.estimate.abs()),
        corrected_high: *high,
        present: derivative.present,
        path_error: None,
        promised: None,
        scatter_share: derivative.scatter_share,
    })
    .collect()
}

fn excursion(own: &doublet_dynamics::design::Excursion, limit: Option<&Limit>) -> ExcursionRow {
    let (low, high) = own.expected;
    ExcursionRow {
        name: own.quantity.name(),
        unit: own.quantity.unit(),
        trim: own.trim,
        nominal_low: own.nominal.0,
        nominal_high: own.nominal.1,
        low,
        high,
        limit_low: limit.map(|limit| limit.low),
        limit_high: limit.map(|limit| limit.high),
        limit_source: limit.map(|limit| limit.source.clone()),
        margin: limit.map(|limit| (low - limit.low).min(limit.high - high)),
    }
}

fn manoeuvres(designed: &Designed) -> Vec<ManoeuvreRow> {
    let planned = designed.manoeuvres.iter().enumerate();
    planned.map(|(index, manoeuvre)| describe_manoeuvre(index, manoeuvre)).collect()
}

fn describe_manoeuvre(index: usize, manoeuvre: &PlannedManoeuvre) -> ManoeuvreRow {
    let moved = |values: [f64; CONTROLS]| {
        let surfaces = manoeuvre.surfaces.iter().filter(|&&control| control != THROTTLE);
        surfaces.map(|&surface| (SURFACE_NAMES[surface], values[surface])).collect()
    };
    ManoeuvreRow {
        number: index + 1,
        name: manoeuvre.name.clone(),
        surfaces: names(&manoeuvre.surfaces),
        duration_s: manoeuvre.duration_s,
        peak_rad: moved(manoeuvre.input.peaks()),
        rate_rad_s: moved(manoeuvre.input.rates()),
        peak_thrust_n: manoeuvre.surfaces.contains(&THROTTLE).then(|| manoeuvre.input.peaks()[THROTTLE]),
        relative_peak_factor: manoeuvre
            .surfaces
            .iter()
            .map(|&surface| (SURFACE_NAMES[surface], measure_peak_factor(manoeuvre, surface)))
            .collect(),
    }
}

fn measure_peak_factor(manoeuvre: &PlannedManoeuvre, surface: usize) -> f64 {
    // Even samples over the input itself, run-in and rest left out.
    let start_s = manoeuvre.input.times_s().first().copied().unwrap_or(0.0);
    let length_s = manoeuvre.input.end_s() - start_s;
    let samples: Vec<f64> =
        (0..4000).map(|k| manoeuvre.input.at(start_s + length_s * f64::from(k) / 4000.0)[surface]).collect();
    relative_peak_factor(&samples)
}

fn signal(designed: &Designed) -> Vec<SignalRow> {
    let all = designed.manoeuvres.iter().enumerate().flat_map(|(index, manoeuvre)| {
        let ends = [(0.0, [0.0; CONTROLS])].into_iter().chain(manoeuvre.input.nodes());
        let ends = ends.chain([(manoeuvre.duration_s, [0.0; CONTROLS])]);
        ends.map(move |(time_s, [aileron, elevator, rudder, thrust_n])| SignalRow {
            manoeuvre: index + 1,
            time_s,
            aileron,
            elevator,
            rudder,
            thrust_n,
        })
        .collect::<Vec<_>>()
    });
    all.collect()
}

/// Correlations of all pairs of regressors of a coefficient, each pair once.
fn correlations(basis: &Basis, designed: &Designed) -> Vec<CorrelationRow> {
    let mut rows: Vec<CorrelationRow> = Vec::new();
    let variables: Vec<_> = designed
        .flown
        .iter()
        .filter_map(|flown| window_variables(flown, &designed.plant, &basis.settings).ok())
        .collect();
    for known in &basis.coefficients {
        let terms: Vec<_> = known.terms.iter().filter(|term| !term.is_constant()).cloned().collect();
        let windows: Vec<_> = variables.iter().filter_map(|own| regressors(&terms, own).ok()).collect();
        let columns: Vec<Vec<f64>> = (0..terms.len()).map(|column| centre_column(&windows, column)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for first in 0..terms.len() {
            for second in first + 1..terms.len() {
                let names = (terms[first].to_string(), terms[second].to_string());
                if rows.iter().any(|row| row.first == names.0 && row.second == names.1) {
                    continue;
                }
                let scale = (dot(&columns[first], &columns[first]) * dot(&columns[second], &columns[second])).sqrt();
                if scale > 0.0 {
                    let correlation = dot(&columns[first], &columns[second]) / scale;
                    rows.push(CorrelationRow { first: names.0, second: names.1, correlation });
                }
            }
        }
    }
    rows
}

/// A column over all windows, about its mean in each.
fn centre_column(windows: &[DMatrix<f64>], column: usize) -> Vec<f64> {
    windows
        .iter()
        .flat_map(|x| {
            let mean = x.column(column).mean();
            x.column(column).iter().map(move |value| value - mean).collect::<Vec<_>>()
        })
        .collect()
}
