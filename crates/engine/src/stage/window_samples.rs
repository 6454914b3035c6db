//! Samples of one window as the filter gets them.

use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::quantity::{Role, in_words};
use doublet_core::reconstruct::{
    FilterData, INPUTS, Input, InputSeries, MEASUREMENTS, Measurement, MeasurementSeries, STATES, State,
};
use doublet_core::series::{Recording, Series, TimeRange};

use super::aircraft::AircraftData;
use super::memory::fit_in_memory;
use super::placement::{move_accelerometer, move_antenna, move_vanes};
use super::recording::LoadedFlight;
use super::samples::{gaps, span, values_at};
use crate::graph::{Context, Footprint, Key, KeyBuilder, Keyed, Stage, StageResult};
use crate::session::{PathSource, Preparation};

/// Samples of one window, ready for the filter.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Inertial samples and measurements.
    pub data: Arc<FilterData>,
    /// Identity of these and of what is carried along, by every number.
    pub content: Key,
    /// Parts that are left out.
    pub excluded: Arc<[TimeRange]>,
    /// Truth of each state over the window, where the recording carries it.
    pub(super) truth: Arc<[Option<Series>; STATES]>,
    /// Findings on the way.
    pub warnings: Vec<Message>,
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
    type Params<'a> = ((TimeRange, &'a [TimeRange]), &'a Preparation);
    type Inputs<'a> = (&'a Keyed<LoadedFlight>, Option<&'a Keyed<AircraftData>>);
    type Output = Self;
    const NAME: &'static str = "samples";

    fn run((window, preparation): Self::Params<'_>, inputs: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let (flight, aircraft) = inputs;
        samples(&flight.recording, window, aircraft.map(|aircraft| &**aircraft), preparation)
    }
}

/// What is wrong with a recording of rates and forces only, before the names of what would do.
pub const NO_PATH_MEASUREMENT: &str = "No flight-path measurement besides rates and forces: record at least one of";

/// Shortest window the filter is run on, samples.
const MIN_SAMPLES: usize = 10;

/// Takes the samples of one window for the filter, without measurements in the parts `excluded`. Without an aircraft every sensor is
/// taken to be at the centre of gravity.
pub fn samples(
    recording: &Recording,
    (window, excluded): (TimeRange, &[TimeRange]),
    aircraft: Option<&AircraftData>,
    preparation: &Preparation,
) -> StageResult<Samples> {
    let mut warnings: Vec<_> = partly_outside(recording, window).into_iter().map(|(text, _)| text).collect();
    let mut inputs = input_series(recording, window, preparation.path, &mut warnings)?;
    fit_in_memory(inputs.time_s.len())?;
    leaves_enough(&inputs.time_s, excluded)?;
    let mut measurements = measurement_series(recording, (window, excluded), &inputs.time_s, &mut warnings);
    if measurements.iter().all(|series| series.time_s.is_empty()) {
        let names = Measurement::ALL.map(Measurement::name).join(", ");
        return Err(format!("{NO_PATH_MEASUREMENT} {names}").into());
    }
    if let Some(aircraft) = aircraft {
        let moved = move_sensors(&mut inputs, &mut measurements, aircraft, preparation)?;
        warnings.extend(moved);
    }
    let (start_s, end_s) = span(&inputs.time_s);
    let within = |truth: &Series| truth.within(TimeRange { start_s, end_s });
    let truth: Arc<[Option<Series>; STATES]> =
        State::ALL.map(|state| recording.truth.get(state.name()).map(within)).into();
    let mut data = FilterData { inputs, measurements };
    preparation.known_errors.correct(&mut data);
    let content = content(&data, (&truth, &warnings), excluded);
    Ok(Samples { content, data: data.into(), excluded: excluded.into(), truth, warnings })
}

/// Whether `time_s` lies in one of `parts`.
pub(super) fn is_in(parts: &[TimeRange], time_s: f64) -> bool {
    parts.iter().any(|part| part.contains(time_s))
}

/// Refuses excluded parts that leave too few samples.
fn leaves_enough(time_s: &[f64], excluded: &[TimeRange]) -> StageResult<()> {
    let left = time_s.iter().filter(|time_s| !is_in(excluded, **time_s)).take(MIN_SAMPLES).count();
    if left >= MIN_SAMPLES {
        return Ok(());
    }
    let text = format!(
        "{left} of {} inertial samples left after exclusions (minimum {MIN_SAMPLES}): shorten the excluded parts",
        time_s.len()
    );
    Err(text.into())
}

/// Longest part of a window that may lie outside the inertial samples without a word, s: recorders of one flight start and end apart.
const OUTSIDE_S: f64 = 0.5;

/// What to say of a window of which a part lies outside the inertial samples, and the part inside.
pub fn partly_outside(recording: &Recording, window: TimeRange) -> Option<(Message, TimeRange)> {
    let (first, last) = span(&recording.role(Input::RollRate.role())?.series.time_s);
    let TimeRange { start_s, end_s } = window;
    let outside_s = (first - start_s).max(end_s - last);
    let overlaps = start_s < last && end_s > first;
    (overlaps && outside_s > OUTSIDE_S).then(|| {
        let text = message!(
            "the manoeuvre lasts from {} s to {} s, inertial samples only from {:.2} s to {:.2} s",
            start_s,
            end_s,
            first,
            last
        );
        (text, TimeRange { start_s: start_s.max(first), end_s: end_s.min(last) })
    })
}

/// Moves inertial samples and measurements to the centre of gravity, as far as the session asks for it; what could not be moved is said.
fn move_sensors(
    inputs: &mut InputSeries,
    measurements: &mut [MeasurementSeries; MEASUREMENTS],
    aircraft: &AircraftData,
    preparation: &Preparation,
) -> StageResult<Vec<Message>> {
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
fn content(
    data: &FilterData,
    (truth, warnings): (&[Option<Series>; STATES], &[Message]),
    excluded: &[TimeRange],
) -> Key {
    let mut key = KeyBuilder::new("samples of a manoeuvre").column(&data.inputs.time_s);
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
    let key = key.with(warnings);
    if excluded.is_empty() { key } else { key.with(excluded) }.finish()
}

/// Inertial samples on the clock of the first rate there is. The filter is driven by all of them; a path as measured goes without those
/// that the recording does not have, which are zero.
fn input_series(
    recording: &Recording,
    window: TimeRange,
    source: PathSource,
    warnings: &mut Vec<Message>,
) -> StageResult<InputSeries> {
    let missing: Vec<_> =
        Input::ALL.into_iter().filter(|input| recording.role(input.role()).is_none()).map(Input::name).collect();
    if !missing.is_empty() && source == PathSource::Measured {
        warnings.push(message!("not recorded and assumed zero: {}", missing.join(", ")));
    } else if !missing.is_empty() {
        return Err(
            format!("the recording has no {}, which the filter needs: map the channels", missing.join(", ")).into()
        );
    }
    let rates = [Input::RollRate, Input::PitchRate, Input::YawRate];
    let base = rates.into_iter().find_map(|rate| recording.role(rate.role()));
    let Some(base) = base else { return Err("the recording has no p, q or r".into()) };
    let time_s = base.series.within(window).finite().time_s;
    if time_s.len() < MIN_SAMPLES {
        let (first, last) = span(&base.series.time_s);
        let not_finite = window.indices(&base.series.time_s).len() - time_s.len();
        let lost = match not_finite {
            0 => String::new(),
            count => format!(" ({count} samples of {} are not finite)", base.name),
        };
        return Err(format!(
            "{} inertial samples between {} s and {} s{lost}, minimum {MIN_SAMPLES}: the recording spans {first:.2} s to {last:.2} s",
            time_s.len(),
            window.start_s,
            window.end_s
        ).into());
    }
    if let Some((at, length)) = gaps(recording, &time_s).into_iter().next() {
        return Err(format!(
            "the inertial samples have a gap of {length:.2} s at {at:.2} s: end the manoeuvre before it"
        )
        .into());
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
            warnings.push(message!(
                "{} is recorded by {}; resampled to the clock of {}",
                input.name(),
                &channel.source,
                &base.source
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
        "{name} is {value} at {time_s:.3} s, which is impossible: check its channel and unit in the channel map"
    );
    Err(text.into())
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
    (window, excluded): (TimeRange, &[TimeRange]),
    inputs_s: &Arc<[f64]>,
    warnings: &mut Vec<Message>,
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
        let Series { time_s, values } = channel.series.within(window).finite();
        for (at, length) in gaps(recording, &time_s) {
            warnings.push(message!(
                "{} has a gap of {:.2} s at {:.2} s; not interpolated",
                measurement.name(),
                length,
                at
            ));
        }
        let (time_s, values) = outside(excluded, time_s, values);
        let values = if sign == 1.0 { values } else { values.iter().map(|value| sign * value).collect() };
        MeasurementSeries { time_s: shared(time_s), values }
    })
}

/// The samples outside the parts.
fn outside(parts: &[TimeRange], time_s: Arc<[f64]>, values: Arc<[f64]>) -> (Arc<[f64]>, Arc<[f64]>) {
    if !time_s.iter().any(|time_s| is_in(parts, *time_s)) {
        return (time_s, values);
    }
    let samples = time_s.iter().zip(values.iter()).filter(|(time_s, _)| !is_in(parts, **time_s));
    let (time_s, values): (Vec<f64>, Vec<f64>) = samples.map(|(&time_s, &value)| (time_s, value)).unzip();
    (time_s.into(), values.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_and_warnings_of_a_window_are_part_of_its_identity() {
        let data = FilterData {
            inputs: InputSeries { time_s: Arc::default(), columns: Default::default() },
            measurements: Default::default(),
        };
        let none = [const { None }; STATES];
        let mut known = none.clone();
        known[3] = Some(Series { time_s: [0.0, 1.0].into(), values: [2.0, 3.0].into() });
        let alone = content(&data, (&none, &[]), &[]);
        assert_eq!(alone, content(&data, (&none, &[]), &[]));
        assert_ne!(alone, content(&data, (&known, &[]), &[]));
        assert_ne!(alone, content(&data, (&none, &["another source".into()]), &[]));
        assert_ne!(alone, content(&data, (&none, &[]), &[TimeRange { start_s: 1.0, end_s: 2.0 }]));
    }
}
