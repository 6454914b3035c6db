//! The filter over samples as they come: the same steps as those of a whole window.

use crate::message::Message;
use crate::reconstruct::collect::step_error;
use crate::reconstruct::data::FilterData;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::events::{Event, Schedule, check};
use crate::reconstruct::filter::backend::{Backend, Lanes};
use crate::reconstruct::filter::ekf::Ekf;
use crate::reconstruct::filter::initial::initial_state;
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{BLOCK, StepInputs, StepOutputs};
use crate::reconstruct::filter::ukf::Ukf;
use crate::reconstruct::model::layout::STATES;
use crate::reconstruct::packed::lanes::Two;
use crate::reconstruct::packed::step::Estimate;
use crate::reconstruct::settings::{Method, ValidSettings};

/// The estimate at one inertial sample.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredSample {
    /// Time, s.
    pub time_s: f64,
    /// State, SI.
    pub states: [f64; STATES],
    /// Its standard deviation, SI.
    pub deviations: [f64; STATES],
    /// Normalised innovation squared of what was measured since the sample before; zero of none.
    pub nis: f64,
    /// Number of these measurements.
    pub nis_degrees: usize,
}

/// A filter that goes on where it stopped: extended, iterated or unscented, without a smoother.
pub struct SequentialFilter {
    settings: ValidSettings,
    form: Form,
    /// What the initial state assumed, one line each.
    pub warnings: Vec<Message>,
}

/// Forms of the filter.
enum Form {
    /// In 3 x 3 blocks, one window in the first of two lanes.
    Packed(Box<Estimate<Two>>),
    /// Over whole matrices, with sensor errors among the states.
    Dense(Box<Ekf>),
    Unscented(Box<Ukf>),
}

impl SequentialFilter {
    /// A filter before the first inertial sample of `first`, whose measurements give the initial state as those of a window do.
    ///
    /// # Errors
    /// Data that cannot be filtered.
    pub fn new(first: &FilterData, settings: &ValidSettings) -> Result<Self, ReconstructError> {
        check(first)?;
        let mut warnings = Vec::new();
        let x = [initial_state(first, settings, &mut warnings)];
        let has_sensor_errors = settings.air_data_deviation.iter().any(|deviation| *deviation > 0.0);
        let form = match settings.method {
            Method::Ukf { .. } => Form::Unscented(Box::new(Backend::new(&x, settings))),
            _ if has_sensor_errors => Form::Dense(Box::new(Backend::new(&x, settings))),
            _ => Form::Packed(Box::new(Backend::new(&x, settings))),
        };
        Ok(Self { settings: settings.clone(), form, warnings })
    }

    /// Goes on from the first inertial sample of `data`, where the filter stands, to its last: the estimates at all samples but the first.
    /// Measurements at or before the first sample take no part, nor does a delay of measurements: their times are those at which
    /// they were true.
    ///
    /// # Errors
    /// Data that cannot be filtered, and divergence; the filter is then of no more use.
    pub fn advance(&mut self, data: &FilterData) -> Result<Vec<FilteredSample>, ReconstructError> {
        check(data)?;
        match &mut self.form {
            Form::Packed(filter) => advance::<Estimate<Two>>(filter, data, &self.settings),
            Form::Dense(filter) => advance::<Ekf>(filter, data, &self.settings),
            Form::Unscented(filter) => advance::<Ukf>(filter, data, &self.settings),
        }
    }
}

/// The steps between the samples of `data`, in the first lane.
fn advance<B: Backend>(
    filter: &mut B,
    data: &FilterData,
    settings: &ValidSettings,
) -> Result<Vec<FilteredSample>, ReconstructError> {
    let parameters = FilterParameters::<B::Number>::new(settings, false);
    let mut schedule = Schedule::new(data, settings.hold);
    let mut outputs = vec![StepOutputs::default(); BLOCK];
    let mut events: Vec<Event> = Vec::with_capacity(BLOCK);
    let mut found = Vec::with_capacity(data.inputs.time_s.len());
    let (mut nis, mut nis_degrees) = (0.0, 0);
    loop {
        let mut inputs = vec![StepInputs::uniform(Lanes::<B>::default()); BLOCK];
        events.clear();
        schedule.fill(0, &mut inputs, &mut events);
        if events.is_empty() {
            return Ok(found);
        }
        filter.filter(&parameters, &inputs[..events.len()], &mut outputs);
        for (event, outputs) in events.iter().zip(&outputs) {
            if let Some(error) = step_error(event.time_s, 0, outputs) {
                return Err(error);
            }
            if event.degrees > 0 {
                nis += outputs.nis.as_ref()[0];
                nis_degrees += usize::from(event.degrees);
            }
            if event.is_sample {
                let states = outputs.state.each_ref().map(|lanes| lanes.as_ref()[0]);
                let deviations = outputs.deviation.each_ref().map(|lanes| lanes.as_ref()[0]);
                found.push(FilteredSample { time_s: event.time_s, states, deviations, nis, nis_degrees });
                (nis, nis_degrees) = (0.0, 0);
            }
        }
    }
}
