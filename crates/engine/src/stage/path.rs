//! Step 1: the flight path of one window.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::consistency::{Consistency, Disagreement, consistency, filter_smoother_disagreement};
use doublet_core::reconstruct::{
    Deviations, FilterData, FilterSettings, MEASUREMENTS, Measurement, MeasurementSeries, Reconstruction, STATES,
    State, measured_path, reconstruct_many,
};
use doublet_core::series::Series;
use rayon::prelude::*;

use super::observability::{Observability, assess_observability};
use super::truth::{TruthError, truth_errors};
use super::window_samples::Samples;
use crate::graph::{Context, Control, Footprint, Keyed, Stage, StageError, StageResult};
use crate::session::PathSource;

/// What the filter was given and what it made of it.
#[derive(Clone, Debug)]
pub struct WindowPath {
    /// Inertial samples and measurements, moved to the centre of gravity where asked, without the outliers of the reconstruction.
    pub data: Arc<FilterData>,
    /// Filtered path.
    pub reconstruction: Reconstruction,
    /// The same columns, once they were asked for.
    series: OnceLock<PathSeries>,
    /// Truth of each state over the window, where the recording carries it.
    known: Arc<[Option<Series>; STATES]>,
    /// Measurements the recording does not have in this window.
    pub missing: Vec<Measurement>,
    /// What reconstructed it; none where it is as measured.
    filter: Option<FilterSettings>,
    /// What the samples alone gave reason to say.
    of_samples: Vec<Message>,
    /// How far it may be believed, once that was asked for.
    pub assessment: OnceLock<PathAssessment>,
}

/// How far a reconstructed path may be believed.
#[derive(Clone, Debug)]
pub struct PathAssessment {
    /// Innovations against their predicted deviations; none where there are none.
    pub consistency: Option<Consistency>,
    /// Errors of the filtered path, where the recording carries the truth.
    pub truth: BTreeMap<State, TruthError>,
    /// States the window tells nothing or little of.
    pub observability: Observability,
    /// Findings, one line each: gaps, resampled channels, the filter's own.
    pub warnings: Vec<Message>,
}

/// Measurements that tell the horizontal wind.
const OVER_GROUND: [Measurement; 4] =
    [Measurement::PositionNorth, Measurement::PositionEast, Measurement::VelocityNorth, Measurement::VelocityEast];

impl Footprint for WindowPath {
    fn bytes(&self) -> usize {
        let columns = 4 * STATES + 2 * MEASUREMENTS + 2;
        self.reconstruction.time_s.len() * columns * 8
    }
}

impl WindowPath {
    /// What `reconstruction` made of the samples of a window.
    pub fn new(
        samples: &Samples,
        reconstruction: Reconstruction,
        (filter, source): (&FilterSettings, PathSource),
    ) -> Self {
        let Samples { data, truth, warnings, .. } = samples;
        let is_missing = |measurement: &Measurement| data.measurements[*measurement as usize].time_s.is_empty();
        Self {
            missing: Measurement::ALL.into_iter().filter(is_missing).collect(),
            filter: Some(filter).filter(|_| source != PathSource::Measured).cloned(),
            of_samples: warnings.clone(),
            assessment: OnceLock::new(),
            series: OnceLock::new(),
            known: Arc::clone(truth),
            data: match reconstruction.outliers.iter().all(Vec::is_empty) {
                true => Arc::clone(data),
                false => Arc::new(data.without(&reconstruction.outliers)),
            },
            reconstruction,
        }
    }

    /// How far it may be believed, formed when it is first asked for: derivatives do not wait for it.
    pub fn assessment(&self) -> &PathAssessment {
        self.assessment.get_or_init(|| {
            let Self { data, reconstruction, .. } = self;
            let filter = self.filter.as_ref();
            let observability =
                filter.map(|filter| assess_observability(data, reconstruction, filter)).unwrap_or_default();
            let mut warnings = self.of_samples.clone();
            warnings.extend(reconstruction.warnings.iter().cloned());
            warnings
                .extend(Measurement::ALL.into_iter().filter_map(|measurement| left_out(reconstruction, measurement)));
            warnings.extend(observability.lines());
            warnings.extend(contradiction(reconstruction));
            PathAssessment {
                consistency: filter.and_then(|_| consistency(reconstruction, f64::NEG_INFINITY)),
                truth: truth_errors(&self.known, reconstruction),
                observability,
                warnings,
            }
        })
    }

    /// The assessment, where it was formed.
    pub fn assessed(&self) -> Option<&PathAssessment> {
        self.assessment.get()
    }

    /// Whether velocity over ground or position is measured, without which the wind stays what it was taken for.
    pub fn tells_wind(&self) -> bool {
        !OVER_GROUND.iter().all(|measurement| self.missing.contains(measurement))
    }

    /// Samples of a measurement, and what their time stamps are late, s; none where the window has none.
    pub fn recorded(&self, measurement: Measurement) -> Option<(&MeasurementSeries, f64)> {
        let series = &self.data.measurements[measurement as usize];
        let delay_s = self.filter.as_ref().map_or(0.0, |filter| filter.measurement_delay_s[measurement as usize]);
        (!series.time_s.is_empty()).then_some((series, delay_s))
    }

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
    /// Those left out as outliers.
    pub outliers: [Series; MEASUREMENTS],
    /// What the smoothed states say each measurement was, at their samples; the filtered ones where nothing is smoothed.
    pub reconstructed: [Series; MEASUREMENTS],
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
    pub states: [Series; STATES],
    /// Standard deviation of each, at its samples.
    pub deviations: [Arc<[f64]>; STATES],
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

/// Reconstructs the flight paths of windows, side by side.
///
/// The error of a window is one line: where and how the filter failed; or that it was cancelled.
pub fn paths(
    samples: &[&Samples],
    by: (&FilterSettings, PathSource),
    control: &Control,
) -> Vec<Result<WindowPath, StageError>> {
    let data: Vec<_> = samples.iter().map(|samples| &*samples.data).collect();
    let found = reconstructions(&data, by, control);
    samples.par_iter().zip(found).map(|(samples, found)| Ok(WindowPath::new(samples, found?, by))).collect()
}

/// Reconstructs windows side by side, smoothed where `source` is the smoothed path; as measured, without a filter, where it is that.
///
/// The error of a window is one line: a setting outside its range, where and how the filter failed; or that it was cancelled.
pub fn reconstructions(
    data: &[&FilterData],
    (filter, source): (&FilterSettings, PathSource),
    control: &Control,
) -> Vec<Result<Reconstruction, StageError>> {
    if source == PathSource::Measured {
        return data.iter().map(|data| Ok(measured_path(data)?)).collect();
    }
    let smooth = source == PathSource::Smoothed;
    match (FilterSettings { smooth, ..filter.clone() }).check() {
        Err(errors) => {
            let error = errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
            data.iter().map(|_| Err(error.clone().into())).collect()
        }
        Ok(settings) => {
            let mut watch = |_| if control.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
            reconstruct_many(data, &settings, &mut watch).into_iter().map(|found| Ok(found?)).collect()
        }
    }
}

/// One line about the outliers of a measurement.
fn left_out(reconstruction: &Reconstruction, measurement: Measurement) -> Option<Message> {
    let outliers = &reconstruction.outliers[measurement as usize];
    let first = outliers.first()?;
    let samples = message!("{} {}", outliers.len(), if outliers.len() == 1 { "sample" } else { "samples" });
    Some(message!("{} of {} rejected as outliers, the first at {:.2} s", samples, measurement.name(), first.time_s))
}

/// One line where filter and smoother contradict each other, with the worst states.
fn contradiction(reconstruction: &Reconstruction) -> Option<Message> {
    const NAMED: usize = 3;
    let found = filter_smoother_disagreement(reconstruction);
    let words = |state: &Disagreement| {
        let (name, inside) = (state.state.name(), 100.0 * state.inside);
        message!("{} ({:.0} % within the limit, largest {:.1})", name, inside, state.largest)
    };
    let more = found.len().saturating_sub(NAMED);
    let more = if more > 0 { message!(" and {} more", more) } else { Message::default() };
    (!found.is_empty()).then(|| {
        message!(
            "filter and smoother differ by over three standard deviations in {}{}: check process noise, random walks and \
             unmodelled sensor errors",
            Message::join(found.iter().take(NAMED).map(words), ", "),
            more
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
        deviations: smoothed.deviations.each_ref().map(|column| column.iter().collect()),
    });
    let path = smoothed.as_ref().map_or(&states, |smoothed| &smoothed.states);
    let columns = measurements_of(&path.each_ref().map(|state| Arc::clone(&state.values)));
    let reconstructed =
        columns.map(|values| Series { time_s: Arc::clone(&reconstruction.time_s), values: values.into() });
    PathSeries {
        deviations: reconstruction.deviations.each_ref().map(|column| column.iter().collect()),
        smoothed,
        truth: std::array::from_fn(|at| {
            known[at].as_ref().map(|truth| on_turn_of(&states[at], State::ALL[at].dimension(), truth))
        }),
        measured: std::array::from_fn(|at| {
            let MeasurementSeries { time_s, values } = &data.measurements[at];
            let measured = Series { time_s: Arc::clone(time_s), values: Arc::clone(values) };
            on_turn_of(&reconstructed[at], Measurement::ALL[at].dimension(), &measured)
        }),
        outliers: std::array::from_fn(|at| {
            let (time_s, values) = reconstruction.outliers[at]
                .iter()
                .map(|outlier| (outlier.time_s, outlier.value))
                .unzip::<_, _, Vec<_>, Vec<_>>();
            let outliers = Series { time_s: time_s.into(), values: values.into() };
            on_turn_of(&reconstructed[at], Measurement::ALL[at].dimension(), &outliers)
        }),
        innovations: reconstruction.innovations.each_ref().map(updates),
        innovation_deviations: reconstruction.innovation_deviations.each_ref().map(hold_last),
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
fn hold_last(column: &Deviations) -> Arc<[f64]> {
    let mut last = column.iter().find(|value| value.is_finite()).unwrap_or(f64::NAN);
    let hold = |value: f64| {
        if value.is_finite() {
            last = value;
        }
        last
    };
    column.iter().map(hold).collect()
}

/// Measurements of filtered or smoothed states, a column each (thesis Eq. 3.8): positions and angles are states, ground velocity is
/// airspeed turned to the local frame plus wind, airspeed and flow angles follow from the body components.
pub(crate) fn measurements_of<C: AsRef<[f64]>>(states: &[C; STATES]) -> [Vec<f64>; MEASUREMENTS] {
    let state_values = |state: State| states[state as usize].as_ref();
    let at = |state: State, k: usize| state_values(state)[k];
    let body = |k: usize| [State::VelocityU, State::VelocityV, State::VelocityW].map(|state| at(state, k));
    let column = |value: &dyn Fn(usize) -> f64| (0..states[0].as_ref().len()).map(value).collect();
    Measurement::ALL.map(|measurement| match measurement {
        Measurement::PositionNorth => state_values(State::PositionNorth).to_vec(),
        Measurement::PositionEast => state_values(State::PositionEast).to_vec(),
        Measurement::PositionDown => state_values(State::PositionDown).to_vec(),
        Measurement::VelocityNorth => column(&|k| ground_velocity(|state| at(state, k))[0]),
        Measurement::VelocityEast => column(&|k| ground_velocity(|state| at(state, k))[1]),
        Measurement::VelocityDown => column(&|k| ground_velocity(|state| at(state, k))[2]),
        Measurement::BankAngle => state_values(State::BankAngle).to_vec(),
        Measurement::PitchAngle => state_values(State::PitchAngle).to_vec(),
        Measurement::HeadingAngle => state_values(State::HeadingAngle).to_vec(),
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
    use super::{Dimension, Series, TAU, on_turn_of};

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
}
