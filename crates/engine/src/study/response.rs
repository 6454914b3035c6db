//! Frequency responses between signals of a session's windows, or between columns of a table.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::path::Path;

use doublet_core::load::{LoadError, inspect};
use doublet_core::prep::{Interpolation, did_you_mean, resample};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, State};
use doublet_core::series::{Recording, gap_threshold_s};
use doublet_core::statistics::median_step;
use doublet_dynamics::frequency::{
    FrequencyError, FrequencyRecord, FrequencyResponse, SpectralSettings, logarithmic_grid, responses,
};
use thiserror::Error;

use super::table::{Columns, TableError};
use crate::graph::StageError;
use crate::session::PathSource;
use crate::stage::{WindowAero, WindowPath, states_of, values_at};

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRequest {
    /// Inputs: each response is the one with the others held.
    pub inputs: Vec<String>,
    pub output: String,
    /// Lowest and highest frequency, rad/s; those the windows and the sampling allow without it, 20 rad/s at most.
    pub band_rad_s: Option<[f64; 2]>,
    /// Lengths of the windows, s; chosen by the records where there are none.
    pub windows_s: Vec<f64>,
    /// Part by which windows overlap.
    pub overlap: f64,
    /// Number of frequencies.
    pub points: usize,
}

impl Default for ResponseRequest {
    /// Fifty frequencies by windows that overlap by four fifths.
    fn default() -> Self {
        Self {
            inputs: Vec::new(),
            output: String::new(),
            band_rad_s: None,
            windows_s: Vec::new(),
            overlap: 0.8,
            points: 50,
        }
    }
}

/// Responses, and what they were made of.
#[derive(Clone, Debug)]
pub struct ResponseStudy {
    /// Inputs and output as they were asked for.
    pub inputs: Vec<String>,
    pub output: String,
    /// Windows, or stretches of the table, with the seconds each gave.
    pub records: Vec<(String, f64)>,
    /// Windows and stretches left out, each with the reason.
    pub left_out: Vec<String>,
    /// Lowest and highest frequency asked for, rad/s; the spectra begin at two cycles of their longest window.
    pub band_rad_s: [f64; 2],
    /// Frequencies and windows of the spectra.
    pub settings: SpectralSettings,
    /// One for each input.
    pub responses: Vec<FrequencyResponse>,
    pub(super) samples: Vec<FrequencyRecord>,
}

impl ResponseStudy {
    /// Samples of all signals of all records.
    pub(super) fn sample_count(&self) -> usize {
        let count = |record: &FrequencyRecord| record.output.len() * (record.inputs.len() + 1);
        self.samples.iter().map(count).sum()
    }
}

/// One window of a session.
#[derive(Clone, Copy, Debug)]
pub struct ResponseWindow<'a> {
    pub name: &'a str,
    /// Recording of its flight.
    pub recording: &'a Recording,
    pub path: &'a WindowPath,
    /// Which of the paths is used.
    pub source: PathSource,
    /// Its coefficients, where it has them: their rates and specific forces are without bias.
    pub aero: Option<&'a WindowAero>,
}

/// Why there is no response.
#[derive(Debug, Error)]
pub enum ResponseError {
    /// The numerics refuse.
    #[error(transparent)]
    Frequency(#[from] FrequencyError),
    /// The table is not understood.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The file is not understood.
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error("{file}: '{column}' has no time vector of its length: give the interval of the rows (--dt)")]
    NoTime { file: String, column: String },
    /// No signal is called so.
    #[error("no signal is called '{name}': {hint}")]
    NoSignal { name: String, hint: String },
    #[error("'{name}' is given twice: inputs and output must differ")]
    Twice { name: String },
    /// No window gives samples.
    #[error("no manoeuvre gives samples: {reasons}")]
    NoWindow { reasons: String },
}

/// Shortest record, samples.
const SHORTEST: usize = 16;
/// Highest frequency of a band nobody stated, rad/s: rigid-body motion ends before it.
const HIGHEST_RAD_S: f64 = 20.0;

/// Responses over windows of a session: signals are states of the path (`phi`, `theta` ...), rates, specific forces and flow angles as the
/// coefficients have them, and recorded channels by their role (`delta_e` ...).
pub fn session_responses(
    windows: &[ResponseWindow<'_>],
    request: &ResponseRequest,
    for_fit: bool,
) -> Result<ResponseStudy, ResponseError> {
    check_names(request, |name| {
        let known: Vec<&str> =
            State::ALL.into_iter().map(State::name).chain(Role::ALL.into_iter().map(Role::name)).collect();
        if known.contains(&name) {
            return Ok(());
        }
        let hint = did_you_mean(
            name,
            known.into_iter(),
            "use delta_e, delta_a, delta_r, p, q, r, alpha, beta, phi, theta or another role",
        );
        Err(ResponseError::NoSignal { name: name.to_owned(), hint })
    })?;
    let (mut records, mut left_out) = (Vec::new(), Vec::new());
    for window in windows {
        let time_s = window.time_s();
        let names = request.inputs.iter().chain([&request.output]);
        match names.map(|name| window.signal(name, time_s)).collect::<Result<Vec<_>, _>>() {
            Ok(columns) => {
                let (time_s, columns) = window.outside_excluded(time_s, columns);
                even_records(window.name, &time_s, &columns, &mut records, &mut left_out);
            }
            Err(error) => left_out.push(format!("{}: {error}", window.name)),
        }
    }
    study(records, left_out, request, for_fit)
}

impl ResponseWindow<'_> {
    fn time_s(&self) -> &[f64] {
        self.aero.map_or(&self.path.data.inputs.time_s, |aero| &aero.data.time_s)
    }

    /// Times and columns without excluded stretches, which part the window into records.
    fn outside_excluded<'t>(&self, time_s: &'t [f64], columns: Vec<Vec<f64>>) -> (Cow<'t, [f64]>, Vec<Vec<f64>>) {
        let Some(left) = self.aero.and_then(WindowAero::left) else { return (Cow::Borrowed(time_s), columns) };
        let pick = |column: &[f64]| left.iter().map(|&sample| column[sample]).collect::<Vec<f64>>();
        (Cow::Owned(pick(time_s)), columns.iter().map(|column| pick(column)).collect())
    }

    /// Values of a state or role at `time_s`, SI.
    fn signal(&self, name: &str, time_s: &[f64]) -> Result<Vec<f64>, StageError> {
        let first = self.path.data.inputs.time_s.len().saturating_sub(time_s.len());
        if let Some(state) = State::from_name(name) {
            return Ok(states_of(&self.path.reconstruction, self.source)?[state as usize][first..].to_vec());
        }
        let role = Role::from_name(name).ok_or_else(|| format!("no signal is called '{name}'"))?;
        if let Some(values) = self.aero.and_then(|aero| coefficient_signal(aero, role)) {
            return Ok(values);
        }
        if let Some(input) = Input::ALL.into_iter().find(|input| input.role() == role) {
            return Ok(self.path.data.inputs.columns[input as usize][first..].to_vec());
        }
        let recorded = values_at(self.recording, role, time_s)?;
        Ok(recorded.ok_or_else(|| format!("{name} was not recorded"))?.to_vec())
    }
}

/// A column the coefficients are formed from.
fn coefficient_signal(aero: &WindowAero, role: Role) -> Option<Vec<f64>> {
    let data = &aero.data;
    let [p, q, r] = &data.rates_rad_s;
    let [x, y, z] = &data.specific_force_m_s2;
    let column: &[f64] = match role {
        Role::RollRate => p,
        Role::PitchRate => q,
        Role::YawRate => r,
        Role::SpecificForceX => x,
        Role::SpecificForceY => y,
        Role::SpecificForceZ => z,
        Role::TrueAirspeed => &data.airspeed_m_s,
        Role::AngleOfAttack => &data.alpha_rad,
        Role::Sideslip => &data.beta_rad,
        role => data.controls.get(&role)?,
    };
    (column.len() == data.time_s.len()).then(|| column.to_vec())
}

/// Responses between columns of a table, or expressions of them, as they stand in the file: no unit is converted but that of time. Rows
/// without a value, and pauses of the time, part it into records.
pub fn table_responses(
    path: &Path,
    dt_s: Option<f64>,
    request: &ResponseRequest,
    for_fit: bool,
) -> Result<ResponseStudy, ResponseError> {
    let probe = inspect(path)?;
    let columns = Columns::from_probe(&probe);
    check_names(request, |_| Ok(()))?;
    let output = columns.evaluate(&request.output)?;
    let mut values = Vec::new();
    for name in &request.inputs {
        let column = columns.evaluate(name)?;
        if column.len() != output.len() {
            let (name, output_name) = (name.clone(), request.output.clone());
            let (found, expected) = (column.len(), output.len());
            return Err(TableError::Length { name, found, output: output_name, expected }.into());
        }
        values.push(column);
    }
    let time_s = match dt_s {
        Some(dt_s) => (0..output.len()).map(|row| dt_s * row as f64).collect(),
        None => columns.time_s(&probe, output.len()).ok_or_else(|| ResponseError::NoTime {
            file: path.display().to_string(),
            column: request.output.clone(),
        })?,
    };
    values.push(output);
    let rows: Vec<usize> = (0..time_s.len())
        .filter(|&row| time_s[row].is_finite() && values.iter().all(|values| values[row].is_finite()))
        .collect();
    let picked = |values: &[f64]| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
    let (time_s, values) = (picked(&time_s), values.iter().map(|values| picked(values)).collect::<Vec<_>>());
    let (mut records, mut left_out) = (Vec::new(), Vec::new());
    even_records("table", &time_s, &values, &mut records, &mut left_out);
    study(records, left_out, request, for_fit)
}

/// Refuses a name that stands twice, and those `check` refuses.
fn check_names(
    request: &ResponseRequest,
    check: impl Fn(&str) -> Result<(), ResponseError>,
) -> Result<(), ResponseError> {
    let names: Vec<&String> = request.inputs.iter().chain([&request.output]).collect();
    for (index, name) in names.iter().enumerate() {
        check(name)?;
        if names[..index].contains(name) {
            return Err(ResponseError::Twice { name: (*name).clone() });
        }
    }
    Ok(())
}

/// Evenly sampled records of the stretches of `time_s` without a pause; the output is the last of the columns.
fn even_records(
    name: &str,
    time_s: &[f64],
    columns: &[Vec<f64>],
    records: &mut Vec<(String, FrequencyRecord)>,
    left_out: &mut Vec<String>,
) {
    /// Largest deviation of an interval from the step that counts as even, as a part of it.
    const EVEN: f64 = 0.01;
    let step_s = median_step(time_s).filter(|step| *step > 0.0);
    let Some(step_s) = step_s else {
        left_out.push(format!("{name}: {} samples, or time that does not rise", time_s.len()));
        return;
    };
    let gap_s = gap_threshold_s(time_s);
    let breaks = (1..time_s.len()).filter(|&k| !(0.0..=gap_s).contains(&(time_s[k] - time_s[k - 1])));
    let mut edges: Vec<usize> = std::iter::once(0).chain(breaks).collect();
    edges.push(time_s.len());
    let is_one = edges.len() == 2;
    for pair in edges.windows(2) {
        let time = &time_s[pair[0]..pair[1]];
        let name = if is_one { name.to_owned() } else { format!("{name} from {:.2} s", time[0]) };
        if time.len() < SHORTEST || time.windows(2).any(|pair| pair[1] <= pair[0]) {
            left_out.push(format!("{name}: {} rising samples are too few ({SHORTEST})", time.len()));
            continue;
        }
        let is_even = time.windows(2).all(|pair| (pair[1] - pair[0] - step_s).abs() <= EVEN * step_s);
        let count = ((time[time.len() - 1] - time[0]) / step_s + 1e-9).floor() as usize + 1;
        let at: Vec<f64> = (0..count).map(|k| (time[0] + step_s * k as f64).min(time[time.len() - 1])).collect();
        let column = |column: &Vec<f64>| {
            let own = &column[pair[0]..pair[1]];
            if is_even { Ok(own.to_vec()) } else { resample(time, own, &at, Interpolation::Linear) }
        };
        match columns.iter().map(column).collect::<Result<Vec<_>, _>>() {
            Ok(mut values) => {
                let output = values.pop().unwrap_or_default();
                records.push((name, FrequencyRecord { step_s, inputs: values, output }));
            }
            Err(error) => left_out.push(format!("{name}: {error}")),
        }
    }
}

/// Spectra of the records by what was asked for, or by what they allow.
fn study(
    records: Vec<(String, FrequencyRecord)>,
    left_out: Vec<String>,
    request: &ResponseRequest,
    for_fit: bool,
) -> Result<ResponseStudy, ResponseError> {
    if records.is_empty() {
        let reasons = if left_out.is_empty() { "no manoeuvre in use".to_owned() } else { left_out.join("; ") };
        return Err(ResponseError::NoWindow { reasons });
    }
    let seconds = records.iter().map(|(name, record)| (name.clone(), record.length_s())).collect();
    let samples: Vec<FrequencyRecord> = records.into_iter().map(|(_, record)| record).collect();
    let windows_s =
        if request.windows_s.is_empty() { choose_windows(&samples, request) } else { request.windows_s.clone() };
    let longest_s = windows_s.iter().copied().fold(0.0, f64::max);
    let nyquist = samples.iter().map(|record| 0.5 * TAU / record.step_s).fold(f64::INFINITY, f64::min);
    let band = request.band_rad_s.unwrap_or([2.0 * TAU / longest_s, (0.5 * nyquist).min(HIGHEST_RAD_S)]);
    let [low, high] = band;
    if !(low > 0.0 && low < high && high.is_finite()) {
        let allowed = format!("the band goes from above 0 to {high:.4} rad/s");
        return Err(FrequencyError::Setting { setting: "lowest frequency", value: low, allowed }.into());
    }
    let omega_rad_s = logarithmic_grid(low, high, request.points.max(2));
    let settings = SpectralSettings { omega_rad_s, windows_s, overlap: request.overlap, for_fit };
    let responses = responses(&samples, &settings)?;
    let (inputs, output) = (request.inputs.clone(), request.output.clone());
    Ok(ResponseStudy { inputs, output, records: seconds, left_out, band_rad_s: band, settings, responses, samples })
}

/// Window lengths for records: the longest a quarter of all records together, as long as the longest record at most and two cycles of the
/// lowest frequency at least, if a record is that long; four more down to a quarter of it.
fn choose_windows(records: &[FrequencyRecord], request: &ResponseRequest) -> Vec<f64> {
    const LENGTHS: i32 = 5;
    let total_s: f64 = records.iter().map(FrequencyRecord::length_s).sum();
    let longest_record_s = records.iter().map(FrequencyRecord::length_s).fold(0.0, f64::max);
    let cycles_s = request.band_rad_s.map_or(0.0, |[low, _]| 2.0 * TAU / low);
    let longest_s = (0.25 * total_s).max(cycles_s).min(longest_record_s);
    (0..LENGTHS).map(|k| longest_s * 0.25f64.powf(f64::from(k) / f64::from(LENGTHS - 1))).collect()
}

impl Columns<'_> {
    /// Time of the rows of a table, s: the clock that as many channels as possible of that length have.
    fn time_s(&self, probe: &doublet_core::load::Probe, rows: usize) -> Option<Vec<f64>> {
        let source = probe.sources.iter().find(|source| source.clocks.iter().any(|clock| clock.samples == rows))?;
        let clock = source.clocks.iter().find(|clock| clock.samples == rows)?;
        let stamps = source.channels.iter().find(|channel| channel.name == clock.channel);
        match stamps {
            Some(channel) => Some(channel.values().iter().map(|value| value * clock.unit.scale).collect()),
            None if clock.rate_hz > 0.0 => {
                Some((0..rows).map(|row| clock.start_s + row as f64 / clock.rate_hz).collect())
            }
            None => None,
        }
    }
}
