//! Step 1: the flight path of one window.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use doublet_core::prep::Differentiation;
use doublet_core::quantity::{Dimension, Role, in_words};
use doublet_core::reconstruct::consistency::{Consistency, Disagreement, consistency, filter_smoother_disagreement};
use doublet_core::reconstruct::{
    FilterData, FilterSettings, INPUTS, Input, InputSeries, MEASUREMENTS, Measurement, MeasurementSeries,
    Reconstruction, STATES, State, measured_path, reconstruct_many,
};
use doublet_core::series::{Recording, Series, TimeRange};
use rayon::prelude::*;

use super::aircraft::AircraftData;
use super::observability::{Observability, assess_observability};
use super::placement::{move_accelerometer, move_antenna, move_vanes};
use super::recording::LoadedFlight;
use super::samples::{finite_samples, fit_in_memory, gaps, values_at};
use super::truth::{TruthError, truth_errors};
use crate::graph::{Context, Control, Footprint, Key, KeyBuilder, Keyed, Stage, StageError, StageResult};
use crate::session::{PathSource, Preparation};

/// What the filter was given and what it made of it.
#[derive(Clone, Debug)]
pub struct WindowPath {
    /// Inertial samples and measurements, moved to the centre of gravity where asked.
    pub data: Arc<FilterData>,
    /// Filtered path.
    pub reconstruction: Reconstruction,
    /// The same columns, once they were asked for.
    series: OnceLock<PathSeries>,
    /// Truth of each state over the window, where the recording carries it.
    known: Arc<[Option<Series>; STATES]>,
    /// Innovations against their predicted deviations; none where there are none.
    pub consistency: Option<Consistency>,
    /// Errors of the filtered path, where the recording carries the truth.
    pub truth: BTreeMap<State, TruthError>,
    /// Measurements the recording does not have in this window.
    pub missing: Vec<Measurement>,
    /// States the window tells nothing or little of.
    pub observability: Observability,
    /// Findings, one line each: gaps, resampled channels, the filter's own.
    pub warnings: Vec<String>,
}

impl Footprint for WindowPath {
    fn bytes(&self) -> usize {
        let columns = 4 * STATES + 2 * MEASUREMENTS + 2;
        self.reconstruction.time_s.len() * columns * 8
    }
}

impl WindowPath {
    /// The columns to draw.
    pub fn series(&self) -> &PathSeries {
        self.series.get_or_init(|| path_series(&self.known, &self.data, &self.reconstruction))
    }
}

/// Columns of a reconstruction to draw, each with its time, all shared.
#[derive(Clone, Debug)]
pub struct PathSeries {
    /// Filtered states.
    pub states: [Series; STATES],
    /// Standard deviation of each filtered state, at its samples.
    pub deviations: [Arc<[f64]>; STATES],
    /// Smoothed path, where the session asks for it.
    pub smoothed: Option<SmoothedSeries>,
    /// Truth of each state, where the recording carries it.
    pub truth: [Option<Series>; STATES],
    /// Measurements as the filter got them; empty where there are none.
    pub measured: [Series; MEASUREMENTS],
    /// What the smoothed states say each measurement was, at their samples; the filtered ones where nothing is smoothed.
    pub reconstructed: [Series; MEASUREMENTS],
    /// Innovations.
    pub innovations: [Series; MEASUREMENTS],
    /// Predicted standard deviation of each innovation, held from one of its samples to the next.
    pub innovation_deviations: [Arc<[f64]>; MEASUREMENTS],
    /// Zero at the samples of the innovations: what they are expected to scatter about.
    pub innovation_zero: Series,
    /// Normalised innovation squared.
    pub nis: Series,
}

/// Smoothed states and their standard deviations.
#[derive(Clone, Debug)]
pub struct SmoothedSeries {
    /// Smoothed states.
    pub states: [Series; STATES],
    /// Standard deviation of each, at its samples.
    pub deviations: [Arc<[f64]>; STATES],
}

/// Samples of one window, ready for the filter.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Inertial samples and measurements.
    pub data: Arc<FilterData>,
    /// Identity of these and of what is carried along, by every number.
    pub content: Key,
    /// Truth of each state over the window, where the recording carries it.
    truth: Arc<[Option<Series>; STATES]>,
    /// Findings on the way.
    pub warnings: Vec<String>,
}

impl Footprint for Samples {
    fn bytes(&self) -> usize {
        self.data.inputs.time_s.len() * (1 + INPUTS + 2 * MEASUREMENTS) * 8
    }

    fn content(&self) -> Option<Key> {
        Some(self.content)
    }
}

impl Stage for Samples {
    type Params<'a> = (TimeRange, &'a Preparation);
    type Inputs<'a> = (&'a Keyed<LoadedFlight>, Option<&'a Keyed<AircraftData>>);
    type Output = Self;
    const NAME: &'static str = "samples";

    fn run((window, preparation): Self::Params<'_>, inputs: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let (flight, aircraft) = inputs;
        samples(&flight.recording, window, aircraft.map(|aircraft| &**aircraft), preparation)
    }
}

/// Of one window; many run side by side by [`paths`].
impl Stage for WindowPath {
    type Params<'a> = (&'a FilterSettings, PathSource);
    type Inputs<'a> = &'a Keyed<Samples>;
    type Output = Self;
    const NAME: &'static str = "path";

    fn run(settings: Self::Params<'_>, samples: &Keyed<Samples>, context: &Context<'_>) -> StageResult<Self> {
        let found = paths(&[samples], settings, context.control());
        found.into_iter().next().unwrap_or(Err(StageError::NotApplicable))
    }
}

/// Shortest window the filter is run on, samples.
const MIN_SAMPLES: usize = 10;

/// Takes the samples of one window for the filter. Without an aircraft every sensor is taken to be at the centre of gravity.
///
/// # Errors
/// One line: a missing inertial channel, a window without samples, a gap that cannot be bridged.
pub fn samples(
    recording: &Recording,
    window: TimeRange,
    aircraft: Option<&AircraftData>,
    preparation: &Preparation,
) -> StageResult<Samples> {
    let mut warnings: Vec<_> = partly_outside(recording, window).into_iter().collect();
    let mut inputs = input_series(recording, window, preparation.path, &mut warnings)?;
    fit_in_memory(inputs.time_s.len())?;
    let mut measurements = measurement_series(recording, window, &inputs.time_s, &mut warnings);
    if let Some(aircraft) = aircraft {
        let moved = move_sensors(&mut inputs, &mut measurements, aircraft, preparation)?;
        warnings.extend(moved);
    }
    let (start_s, end_s) = span(&inputs.time_s);
    let within = |truth: &Series| {
        let range = TimeRange { start_s, end_s }.indices(&truth.time_s);
        Series { time_s: truth.time_s[range.clone()].into(), values: truth.values[range].into() }
    };
    let truth: Arc<[Option<Series>; STATES]> =
        State::ALL.map(|state| recording.truth.get(state.name()).map(within)).into();
    let mut data = FilterData { inputs, measurements };
    preparation.known_errors.correct(&mut data);
    Ok(Samples { content: content(&data, &truth, &warnings), data: data.into(), truth, warnings })
}

/// Longest part of a window that may lie outside the inertial samples without a word, s: recorders of one flight start and end apart.
const OUTSIDE_S: f64 = 0.5;

/// What to say of a window of which a part lies outside the inertial samples.
pub fn partly_outside(recording: &Recording, window: TimeRange) -> Option<String> {
    let (first, last) = span(&recording.role(Input::RollRate.role())?.series.time_s);
    let TimeRange { start_s, end_s } = window;
    let outside_s = (first - start_s).max(end_s - last);
    let overlaps = start_s < last && end_s > first;
    (overlaps && outside_s > OUTSIDE_S).then(|| {
        format!("the window goes from {start_s} s to {end_s} s, the inertial samples from {first:.2} s to {last:.2} s: the rest of it is left out")
    })
}

/// Moves inertial samples and measurements to the centre of gravity, as far as the session asks for it; what could not be moved is said.
fn move_sensors(
    inputs: &mut InputSeries,
    measurements: &mut [MeasurementSeries; MEASUREMENTS],
    aircraft: &AircraftData,
    preparation: &Preparation,
) -> StageResult<Vec<String>> {
    let mut warnings = Vec::new();
    let cg_from_datum_m = aircraft.mass.cg_from_datum_m;
    if preparation.correct_accelerometer
        && let Some(sensor) = aircraft.accelerometer
    {
        move_accelerometer(inputs, sensor.body_from_cg_m(cg_from_datum_m), preparation)?;
    }
    if preparation.correct_vanes
        && let Some(vanes) = aircraft.vanes
    {
        warnings.extend(move_vanes(measurements, inputs, vanes.map(|vane| vane.body_from_cg_m(cg_from_datum_m))));
    }
    if preparation.correct_antenna
        && let Some(antenna) = aircraft.antenna
    {
        warnings.extend(move_antenna(measurements, inputs, antenna.body_from_cg_m(cg_from_datum_m)));
    }
    Ok(warnings)
}

/// Identity of the samples of a window and of what its path carries with them: what changes none of it leaves the path as it is.
fn content(data: &FilterData, truth: &[Option<Series>; STATES], warnings: &[String]) -> Key {
    let mut key = KeyBuilder::new("samples of a window").column(&data.inputs.time_s);
    for column in &data.inputs.columns {
        key = key.column(column);
    }
    for series in &data.measurements {
        key = key.column(&series.time_s).column(&series.values);
    }
    for series in truth {
        key = match series {
            Some(series) => key.column(&series.time_s).column(&series.values),
            None => key.with("no truth"),
        };
    }
    key.with(warnings).finish()
}

/// Inertial samples on the clock of the first rate there is. The filter is driven by all of them; a path as measured goes without those
/// that the recording does not have, which are zero.
fn input_series(
    recording: &Recording,
    window: TimeRange,
    source: PathSource,
    warnings: &mut Vec<String>,
) -> StageResult<InputSeries> {
    let missing: Vec<_> =
        Input::ALL.into_iter().filter(|input| recording.role(input.role()).is_none()).map(Input::name).collect();
    if !missing.is_empty() && source == PathSource::Measured {
        warnings.push(format!("not recorded and taken for zero: {}", missing.join(", ")));
    } else if !missing.is_empty() {
        return Err(format!(
            "the recording has no {}: name the channels in the channel map, the filter is driven by them",
            missing.join(", ")
        )
        .into());
    }
    let rates = [Input::RollRate, Input::PitchRate, Input::YawRate];
    let base = rates.into_iter().find_map(|rate| recording.role(rate.role()));
    let Some(base) = base else { return Err("the recording has none of p, q and r".into()) };
    let time_s = finite_samples(base, window, 0.0).time_s;
    if time_s.len() < MIN_SAMPLES {
        let (first, last) = span(&base.series.time_s);
        let not_finite = window.indices(&base.series.time_s).len() - time_s.len();
        let lost = match not_finite {
            0 => String::new(),
            count => format!(" ({count} samples of {} are not finite)", base.name),
        };
        return Err(format!(
            "{} inertial samples between {} s and {} s{lost}, at least {MIN_SAMPLES} are needed: the recording spans {first:.2} s to {last:.2} s",
            time_s.len(),
            window.start_s,
            window.end_s
        ).into());
    }
    if let Some((at, length)) = gaps(recording, &time_s).into_iter().next() {
        return Err(
            format!("the inertial samples pause for {length:.2} s at {at:.2} s: end the window before it").into()
        );
    }
    let mut columns: [Arc<[f64]>; INPUTS] = Default::default();
    for input in Input::ALL {
        let Some(values) = values_at(recording, input.role(), &time_s)? else {
            columns[input as usize] = vec![0.0; time_s.len()].into();
            continue;
        };
        within_reason(input, &time_s, &values)?;
        if let Some(channel) = recording.role(input.role())
            && channel.source != base.source
        {
            warnings.push(format!(
                "{} comes from {}, put on the clock of {}",
                input.name(),
                channel.source,
                base.source
            ));
        }
        columns[input as usize] = values;
    }
    Ok(InputSeries { time_s, columns })
}

/// Refuses what no sensor gives before it spreads: the accelerometers are moved by the square of the rates.
fn within_reason(input: Input, time_s: &[f64], values: &[f64]) -> StageResult<()> {
    /// Largest sample of an accelerometer or a gyro, m/s² or rad/s.
    const LARGEST: f64 = 1e6;
    let Some((time_s, value)) = time_s.iter().zip(values).find(|(_, value)| value.abs() > LARGEST) else {
        return Ok(());
    };
    let (name, value) = (input.name(), in_words(*value));
    let text = format!(
        "{name} is {value} at {time_s} s, which no aircraft does: look at its channel and at its unit in the channel map"
    );
    Err(text.into())
}

fn span(time_s: &[f64]) -> (f64, f64) {
    (time_s.first().copied().unwrap_or(f64::NAN), time_s.last().copied().unwrap_or(f64::NAN))
}

/// What tells a measurement of the filter, found by its role, and the sign its values get. Without a position the altitude tells the
/// height: that of the satellites before that of the pressure, whose scale is right in the standard atmosphere only.
pub fn measured_by<T>(measurement: Measurement, by_role: impl Fn(Role) -> Option<T>) -> Option<(T, f64)> {
    let own = by_role(measurement.role()).map(|found| (found, 1.0));
    let height = || Some((by_role(Role::GpsAltitude).or_else(|| by_role(Role::Altitude))?, -1.0));
    if measurement == Measurement::PositionDown { own.or_else(height) } else { own }
}

/// Measurements of the window at their own times, which share a column where they are the same.
fn measurement_series(
    recording: &Recording,
    window: TimeRange,
    inputs_s: &Arc<[f64]>,
    warnings: &mut Vec<String>,
) -> [MeasurementSeries; MEASUREMENTS] {
    let mut clocks = vec![Arc::clone(inputs_s)];
    let mut shared = |time_s: Arc<[f64]>| match clocks.iter().find(|clock| **clock == time_s) {
        Some(clock) => Arc::clone(clock),
        None => {
            clocks.push(Arc::clone(&time_s));
            time_s
        }
    };
    Measurement::ALL.map(|measurement| {
        let Some((channel, sign)) = measured_by(measurement, |role| recording.role(role)) else {
            return MeasurementSeries::default();
        };
        let Series { time_s, values } = finite_samples(channel, window, 0.0);
        for (at, length) in gaps(recording, &time_s) {
            warnings.push(format!(
                "{} pauses for {length:.2} s at {at:.2} s; nothing was put in its place",
                measurement.name()
            ));
        }
        let values = if sign == 1.0 { values } else { values.iter().map(|value| sign * value).collect() };
        MeasurementSeries { time_s: shared(time_s), values }
    })
}

/// Longest half width of the differentiation that moves the accelerometers for the filter, s. The filter averages noise by
/// itself, and nothing gives it back what smoothing takes away.
const LONGEST_FOR_FILTER_S: f64 = 0.06;

/// The differentiation the session asks for, shortened for the filter.
pub(crate) fn short_differentiation(preparation: &Preparation, time_s: &[f64]) -> Differentiation {
    let half_width_s = preparation.differentiation_half_width_s.map(|half_width| half_width.min(LONGEST_FOR_FILTER_S));
    local_quadratic(half_width_s, time_s)
}

/// The differentiation the session asks for, in samples of `time_s`.
pub fn differentiation(preparation: &Preparation, time_s: &[f64]) -> Differentiation {
    local_quadratic(preparation.differentiation_half_width_s, time_s)
}

/// Local quadratic of a half width in samples of `time_s`; without one the central difference of order four.
fn local_quadratic(half_width_s: Option<f64>, time_s: &[f64]) -> Differentiation {
    let Some(half_width_s) = half_width_s else { return Differentiation::Central4 };
    let (first, last) = span(time_s);
    let step = (last - first) / (time_s.len().max(2) - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a small positive range")]
    let half_width = (half_width_s / step).round().clamp(1.0, 1000.0) as usize;
    Differentiation::LocalPolynomial { degree: 2, half_width }
}

/// Reconstructs the flight paths of windows, side by side.
///
/// The error of a window is one line: where and how the filter failed; or that it was cancelled.
pub fn paths(
    samples: &[&Samples],
    (filter, source): (&FilterSettings, PathSource),
    control: &Control,
) -> Vec<Result<WindowPath, StageError>> {
    if source == PathSource::Measured {
        let path = |samples: &&Samples| Ok(window_path(samples, measured_path(&samples.data)?, None));
        return samples.iter().map(path).collect();
    }
    let data: Vec<_> = samples.iter().map(|samples| &*samples.data).collect();
    match reconstructions(&data, (filter, source), control) {
        Err(error) => samples.iter().map(|_| Err(error.clone())).collect(),
        Ok(found) => {
            let windows = samples.par_iter().zip(found);
            windows.map(|(samples, result)| Ok(window_path(samples, result?, Some(filter)))).collect()
        }
    }
}

/// Reconstructs windows side by side, smoothed where `source` is the smoothed path.
///
/// # Errors
/// One line for settings outside their range; of each window where and how the filter failed, or that it was cancelled.
pub fn reconstructions(
    data: &[&FilterData],
    (filter, source): (&FilterSettings, PathSource),
    control: &Control,
) -> StageResult<Vec<Result<Reconstruction, StageError>>> {
    let smooth = source == PathSource::Smoothed;
    let settings = (FilterSettings { smooth, ..filter.clone() })
        .check()
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
    let mut watch = |_| if control.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    Ok(reconstruct_many(data, &settings, &mut watch).into_iter().map(|found| Ok(found?)).collect())
}

/// The path of a window; `filter` reconstructed it, none where it is as measured.
fn window_path(samples: &Samples, reconstruction: Reconstruction, filter: Option<&FilterSettings>) -> WindowPath {
    let Samples { data, truth, warnings, .. } = samples;
    let mut warnings = warnings.clone();
    warnings.extend(reconstruction.warnings.iter().cloned());
    let observability = filter.map(|filter| assess_observability(data, &reconstruction, filter)).unwrap_or_default();
    warnings.extend(observability.lines());
    warnings.extend(contradiction(&reconstruction));
    let is_missing = |measurement: &Measurement| data.measurements[*measurement as usize].time_s.is_empty();
    WindowPath {
        missing: Measurement::ALL.into_iter().filter(is_missing).collect(),
        consistency: filter.and_then(|_| consistency(&reconstruction, f64::NEG_INFINITY)),
        truth: truth_errors(truth, &reconstruction),
        series: OnceLock::new(),
        known: Arc::clone(truth),
        data: Arc::clone(data),
        reconstruction,
        observability,
        warnings,
    }
}

/// One line where filter and smoother contradict each other, with the worst states.
fn contradiction(reconstruction: &Reconstruction) -> Option<String> {
    const NAMED: usize = 3;
    let found = filter_smoother_disagreement(reconstruction);
    let words = |state: &Disagreement| {
        let (name, inside) = (state.state.name(), 100.0 * state.inside);
        format!("{name} (within for {inside:.0} % of the samples, up to {:.1})", state.largest)
    };
    let named: Vec<String> = found.iter().take(NAMED).map(words).collect();
    let more = found.len() - named.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!named.is_empty()).then(|| {
        format!(
            "filter and smoother disagree beyond three deviations of their difference in {}{more}: look at process noise, random \
             walks, initial deviations, and sensors the model does not describe",
            named.join(", ")
        )
    })
}

fn path_series(known: &[Option<Series>; STATES], data: &FilterData, reconstruction: &Reconstruction) -> PathSeries {
    let shared = |column: &Vec<f64>| Arc::<[f64]>::from(column.as_slice());
    let at = |time_s: &Arc<[f64]>, column: &Vec<f64>| Series { time_s: Arc::clone(time_s), values: shared(column) };
    let series = |column: &Vec<f64>| at(&reconstruction.time_s, column);
    let updates = |column: &Vec<f64>| match column.is_empty() {
        true => Series { time_s: Arc::default(), values: Arc::default() },
        false => at(&reconstruction.update_time_s, column),
    };
    let states = reconstruction.states.each_ref().map(series);
    let smoothed = reconstruction.smoothed.as_ref().map(|smoothed| SmoothedSeries {
        states: smoothed.states.each_ref().map(series),
        deviations: smoothed.deviations.each_ref().map(shared),
    });
    let reconstructed = measurements_of(smoothed.as_ref().map_or(&states, |smoothed| &smoothed.states));
    PathSeries {
        deviations: reconstruction.deviations.each_ref().map(shared),
        smoothed,
        truth: std::array::from_fn(|at| {
            known[at].as_ref().map(|truth| on_turn_of(&states[at], State::ALL[at].dimension(), truth))
        }),
        measured: std::array::from_fn(|at| {
            let MeasurementSeries { time_s, values } = &data.measurements[at];
            let measured = Series { time_s: Arc::clone(time_s), values: Arc::clone(values) };
            on_turn_of(&reconstructed[at], Measurement::ALL[at].dimension(), &measured)
        }),
        innovations: reconstruction.innovations.each_ref().map(updates),
        innovation_deviations: reconstruction.innovation_deviations.each_ref().map(|column| hold_last(column)),
        innovation_zero: updates(&vec![0.0; reconstruction.update_time_s.len()]),
        nis: updates(&reconstruction.nis),
        reconstructed,
        states,
    }
}

/// Angles as they are, each moved by whole turns to where it is nearest to `reference`: the same direction, drawn in the same place.
/// What is no angle stays.
fn on_turn_of(reference: &Series, dimension: Dimension, series: &Series) -> Series {
    if dimension != Dimension::Angle || reference.values.is_empty() {
        return series.clone();
    }
    let nearest = |(&time_s, &value): (&f64, &f64)| {
        let after = reference.time_s.partition_point(|&t| t < time_s).min(reference.values.len() - 1);
        value + TAU * ((reference.values[after] - value) / TAU).round()
    };
    Series { values: series.time_s.iter().zip(series.values.iter()).map(nearest).collect(), ..series.clone() }
}

/// `column` with the last finite value in place of what is not a number; before the first finite value that one.
fn hold_last(column: &[f64]) -> Arc<[f64]> {
    let mut last = column.iter().copied().find(|value| value.is_finite()).unwrap_or(f64::NAN);
    let hold = |&value: &f64| {
        if value.is_finite() {
            last = value;
        }
        last
    };
    column.iter().map(hold).collect()
}

/// Measurements of filtered or smoothed states (thesis Eq. 3.8): positions and angles are states, ground velocity is airspeed turned to
/// the local frame plus wind, airspeed and flow angles follow from the body components.
fn measurements_of(states: &[Series; STATES]) -> [Series; MEASUREMENTS] {
    let time_s = &states[0].time_s;
    let at = |state: State, k: usize| states[state as usize].values[k];
    let body = |k: usize| [State::VelocityU, State::VelocityV, State::VelocityW].map(|state| at(state, k));
    let column = |value: &dyn Fn(usize) -> f64| Series {
        time_s: Arc::clone(time_s),
        values: (0..time_s.len()).map(value).collect(),
    };
    Measurement::ALL.map(|measurement| match measurement {
        Measurement::PositionNorth => states[State::PositionNorth as usize].clone(),
        Measurement::PositionEast => states[State::PositionEast as usize].clone(),
        Measurement::PositionDown => states[State::PositionDown as usize].clone(),
        Measurement::VelocityNorth => column(&|k| ground_velocity(|state| at(state, k))[0]),
        Measurement::VelocityEast => column(&|k| ground_velocity(|state| at(state, k))[1]),
        Measurement::VelocityDown => column(&|k| ground_velocity(|state| at(state, k))[2]),
        Measurement::BankAngle => states[State::BankAngle as usize].clone(),
        Measurement::PitchAngle => states[State::PitchAngle as usize].clone(),
        Measurement::HeadingAngle => states[State::HeadingAngle as usize].clone(),
        Measurement::Airspeed => column(&|k| {
            let [u, v, w] = body(k);
            u.hypot(v).hypot(w)
        }),
        Measurement::AngleOfAttack => column(&|k| {
            let [u, _, w] = body(k);
            w.atan2(u)
        }),
        Measurement::Sideslip => column(&|k| {
            let [u, v, w] = body(k);
            v.atan2(u.hypot(w))
        }),
    })
}

/// Velocity over ground in the local frame, m/s: airspeed by body components turned by yaw, pitch, roll, plus wind.
fn ground_velocity(x: impl Fn(State) -> f64) -> [f64; 3] {
    let (u, v, w) = (x(State::VelocityU), x(State::VelocityV), x(State::VelocityW));
    let (sin_phi, cos_phi) = x(State::BankAngle).sin_cos();
    let (sin_theta, cos_theta) = x(State::PitchAngle).sin_cos();
    let (sin_psi, cos_psi) = x(State::HeadingAngle).sin_cos();
    let lift = v * sin_phi + w * cos_phi;
    let level = u * cos_theta + lift * sin_theta;
    let across = v * cos_phi - w * sin_phi;
    [
        level * cos_psi - across * sin_psi + x(State::WindNorth),
        level * sin_psi + across * cos_psi + x(State::WindEast),
        lift * cos_theta - u * sin_theta + x(State::WindDown),
    ]
}

#[cfg(test)]
mod tests {
    use super::{Dimension, FilterData, InputSeries, STATES, Series, TAU, content, on_turn_of};

    fn series(time_s: &[f64], values: &[f64]) -> Series {
        Series { time_s: time_s.into(), values: values.into() }
    }

    #[test]
    fn angles_are_drawn_on_the_turn_of_the_reference_sample_by_sample() {
        // Turning right through north: the reference goes on past 360 degrees, the record starts again at -180 and at 0.
        let reference = series(&[0.0, 1.0, 2.0, 3.0], &[3.0, 3.4, 6.1, 6.5]);
        let record = series(&[0.5, 2.0, 3.0, 9.0], &[3.3 - TAU, 6.0 - TAU, 6.4 - TAU, 0.3]);
        let drawn = on_turn_of(&reference, Dimension::Angle, &record);
        for (value, expected) in drawn.values.iter().zip([3.3, 6.0, 6.4, 0.3 + TAU]) {
            assert!((value - expected).abs() < 1e-12, "{value}, {expected}");
        }
        assert_eq!(drawn.time_s, record.time_s);
        let lengths = on_turn_of(&reference, Dimension::Length, &record);
        assert_eq!(lengths.values, record.values, "what is no angle stays");
    }

    #[test]
    fn truth_and_warnings_of_a_window_are_part_of_its_identity() {
        let data = FilterData {
            inputs: InputSeries { time_s: Vec::new().into(), columns: Default::default() },
            measurements: Default::default(),
        };
        let none = [const { None }; STATES];
        let mut known = none.clone();
        known[3] = Some(series(&[0.0, 1.0], &[2.0, 3.0]));
        let alone = content(&data, &none, &[]);
        assert_eq!(alone, content(&data, &none, &[]));
        assert_ne!(alone, content(&data, &known, &[]));
        assert_ne!(alone, content(&data, &none, &["another source".to_owned()]));
    }
}
