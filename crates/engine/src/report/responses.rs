//! Frequency responses and equivalent systems as flat rows.

use doublet_dynamics::frequency::FittedParameter;
use serde::Serialize;

use super::studies::where_finite;
use super::table::{Table, TableOf, table};
use crate::study::{EquivalentStudy, FlightResponses, ModeComparison, ResponseStudy};

/// A frequency response at one frequency; gain and phase are missing where the coherence does not make them a value.
#[derive(Clone, Debug, Serialize)]
pub struct ResponseRow {
    pub input: String,
    pub output: String,
    /// Angular frequency, rad/s.
    pub frequency_rad_s: f64,
    /// Gain, dB.
    #[serde(serialize_with = "where_finite")]
    pub gain_db: f64,
    /// Phase without jumps, deg.
    #[serde(serialize_with = "where_finite")]
    pub phase_deg: f64,
    /// Coherence conditioned on the other inputs.
    #[serde(serialize_with = "where_finite")]
    pub coherence: f64,
    /// Coherence regardless of the other inputs.
    #[serde(serialize_with = "where_finite")]
    pub ordinary_coherence: f64,
    /// Coherence with all inputs together.
    #[serde(serialize_with = "where_finite")]
    pub multiple_coherence: f64,
    /// Standard deviation of the gain, dB.
    #[serde(serialize_with = "where_finite")]
    pub gain_sd_db: f64,
    /// Standard deviation of the phase, deg.
    #[serde(serialize_with = "where_finite")]
    pub phase_sd_deg: f64,
    /// Effective number of averages.
    #[serde(serialize_with = "where_finite")]
    pub averages: f64,
}

/// A parameter of an equivalent system, or what follows from it.
#[derive(Clone, Debug, Serialize)]
pub struct SystemRow {
    pub input: String,
    pub output: String,
    pub form: String,
    /// Data of the fit.
    pub method: &'static str,
    /// Name of the parameter.
    pub name: String,
    /// Value, SI.
    #[serde(serialize_with = "where_finite")]
    pub value: f64,
    #[serde(serialize_with = "where_finite")]
    pub standard_error: f64,
    /// Lower end of the 95 % interval.
    #[serde(serialize_with = "where_finite")]
    pub low: f64,
    /// Upper end.
    #[serde(serialize_with = "where_finite")]
    pub high: f64,
    /// Cost of the mismatch of the system and the response: a caution above 50, bad above 100.
    #[serde(serialize_with = "where_finite")]
    pub cost: f64,
    /// Level of the verdict on the system.
    pub verdict: &'static str,
    /// Why the system is missing.
    pub error: Option<String>,
}

/// A quantity of a natural mode by the equivalent system of a response, by the free responses and by the identified model, each with its 95 %
/// interval where it gives one.
#[derive(Clone, Debug, Serialize)]
pub struct ModeComparisonRow {
    /// Natural mode.
    pub mode: &'static str,
    /// `frequency`, `damping` or `time constant`.
    pub quantity: &'static str,
    pub unit: &'static str,
    /// Control of the manoeuvres.
    pub surface: &'static str,
    /// Value by the equivalent system; none where it is rejected or missing.
    pub response: Option<f64>,
    /// Lower end of its interval.
    pub response_low: Option<f64>,
    /// Upper end.
    pub response_high: Option<f64>,
    /// Value by the free responses behind the inputs.
    pub free: Option<f64>,
    /// Lower end of its interval.
    pub free_low: Option<f64>,
    /// Upper end.
    pub free_high: Option<f64>,
    /// Value by the identified model.
    pub model: f64,
    /// Lower end of its interval.
    pub model_low: f64,
    /// Upper end.
    pub model_high: f64,
    /// Pairs of the three whose intervals do not overlap; empty for none.
    pub contradictions: String,
}

impl From<&ModeComparison> for ModeComparisonRow {
    fn from(found: &ModeComparison) -> Self {
        let ModeComparison { surface, mode, quantity, response, free, model, .. } = found;
        let pairs: Vec<String> = found.contradictions().iter().map(|pair| pair.join(" and ")).collect();
        Self {
            mode,
            quantity: quantity.name(),
            unit: quantity.unit(),
            surface: surface.name(),
            response: response.map(|found| found.value),
            response_low: response.map(|found| found.low),
            response_high: response.map(|found| found.high),
            free: free.map(|found| found.value),
            free_low: free.map(|found| found.low),
            free_high: free.map(|found| found.high),
            model: model.value,
            model_low: model.low,
            model_high: model.high,
            contradictions: pairs.join("; "),
        }
    }
}

/// Natural modes by the three ways, a row per quantity and control.
pub fn mode_comparison_table(rows: &[ModeComparisonRow]) -> Table {
    let caption = "Natural modes by the equivalent system of the response, by the free responses behind the inputs (weighted mean of the manoeuvres) and by the identified model, with 95 % intervals. Intervals that do not overlap contradict each other.";
    TableOf::new("mode_comparison", caption, rows)
        .text("mode", "Mode", |row| row.mode)
        .text("quantity", "Quantity", |row| row.quantity)
        .text("unit", "Unit", |row| row.unit)
        .text("surface", "Manoeuvres", |row| row.surface)
        .maybe("response", "Response", "", 3, |row| row.response)
        .maybe("response_low", "95 % from", "", 3, |row| row.response_low)
        .maybe("response_high", "to", "", 3, |row| row.response_high)
        .maybe("free", "Free", "", 3, |row| row.free)
        .maybe("free_low", "95 % from", "", 3, |row| row.free_low)
        .maybe("free_high", "to", "", 3, |row| row.free_high)
        .number("model", "Model", "", 3, |row| row.model)
        .number("model_low", "95 % from", "", 3, |row| row.model_low)
        .number("model_high", "to", "", 3, |row| row.model_high)
        .optional("contradictions", "Contradict", |row| {
            (!row.contradictions.is_empty()).then_some(row.contradictions.as_str())
        })
        .done()
}

pub fn response_rows(study: &ResponseStudy) -> Vec<ResponseRow> {
    let mut rows = Vec::new();
    for response in &study.responses {
        for (point, phase) in response.points.iter().zip(response.phases_rad()) {
            let where_value = |value: f64| if point.is_value() { value } else { f64::NAN };
            rows.push(ResponseRow {
                input: study.inputs.get(response.input).cloned().unwrap_or_default(),
                output: study.output.clone(),
                frequency_rad_s: point.omega_rad_s,
                gain_db: where_value(point.gain_db()),
                phase_deg: where_value(phase.to_degrees()),
                coherence: point.coherence,
                ordinary_coherence: point.ordinary_coherence,
                multiple_coherence: point.multiple_coherence,
                gain_sd_db: point.gain_sd_db(),
                phase_sd_deg: point.relative_sd.to_degrees(),
                averages: point.averages,
            });
        }
    }
    rows
}

/// A frequency response, one row per frequency.
pub fn response_table(rows: &[ResponseRow]) -> Option<Table> {
    table("responses", "Frequency responses of the rates to the controls.", rows)
}

/// Parameters of an equivalent system and what follows from them, beside those by the other method.
pub fn parameter_table(found: &EquivalentStudy) -> Table {
    let other = |row: &FittedParameter| found.other.as_ref()?.1.as_ref().ok()?.parameter(&row.name);
    let method = found.other.as_ref().map_or("", |(method, _)| method.name());
    let caption = "Parameters of the low-order equivalent system, SI and rad.";
    TableOf::new("equivalent_system", caption, found.fit.parameters.iter().chain(&found.derived))
        .text("name", "Parameter", |row| &row.name)
        .number("value", "Value", "", 5, |row| row.value)
        .number("standard_error", "Std error", "", 3, |row| row.standard_error)
        .number("low", "Low", "", 5, |row| row.low)
        .number("high", "High", "", 5, |row| row.high)
        .when(!method.is_empty(), |table| {
            table.maybe("other_value", method, "", 5, |row| Some(other(row)?.value)).maybe(
                "other_standard_error",
                "Std error",
                "",
                3,
                |row| Some(other(row)?.standard_error),
            )
        })
        .done()
}

fn system_rows(study: &ResponseStudy, system: &EquivalentStudy) -> Vec<SystemRow> {
    let parameters = system.fit.parameters.iter().chain(&system.derived);
    parameters.map(|parameter| system_row(study, system, parameter)).collect()
}

fn system_row(study: &ResponseStudy, system: &EquivalentStudy, parameter: &FittedParameter) -> SystemRow {
    SystemRow {
        input: study.inputs.get(system.input).cloned().unwrap_or_default(),
        output: study.output.clone(),
        form: system.fit.form.to_string(),
        method: system.method.name(),
        name: parameter.name.clone(),
        value: parameter.value,
        standard_error: parameter.standard_error,
        low: parameter.low,
        high: parameter.high,
        cost: system.mismatch.cost,
        verdict: system.verdict.level.name(),
        error: None,
    }
}

/// Rows of the responses of a session: points, then parameters.
pub(super) fn flight_rows(found: &FlightResponses) -> (Vec<ResponseRow>, Vec<SystemRow>) {
    let (mut points, mut systems) = (Vec::new(), Vec::new());
    for surface in &found.surfaces {
        if let Ok(study) = &surface.response {
            points.extend(response_rows(study));
        }
        match (&surface.response, &surface.system) {
            (Ok(study), Ok(system)) => systems.extend(system_rows(study, system)),
            (_, Err(error)) | (Err(error), _) => systems.push(SystemRow {
                input: surface.surface.role().name().to_owned(),
                output: surface.surface.rate().name().to_owned(),
                form: String::new(),
                method: "",
                name: String::new(),
                value: f64::NAN,
                standard_error: f64::NAN,
                low: f64::NAN,
                high: f64::NAN,
                cost: f64::NAN,
                verdict: "",
                error: Some(error.to_string()),
            }),
        }
    }
    (points, systems)
}
