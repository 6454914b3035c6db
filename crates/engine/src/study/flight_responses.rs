//! Frequency responses of the rates to the controls over a session's windows, with their low-order equivalent systems.

use doublet_dynamics::frequency::{Delay, Form, state_space_response};
use nalgebra::Complex;

use super::dynamics::{Standard, airplane_by_default, joined_limits};
use super::equivalent::{EquivalentStudy, equivalent_study};
use super::equivalent_levels::EquivalentLevels;
use super::mode_comparison::{ModeComparison, compare_modes};
use super::response::{ResponseRequest, ResponseStudy, ResponseWindow, session_responses};
use super::{DynamicsRequest, DynamicsStudy, StudyInput};
use crate::graph::{Context, Footprint, Stage, StageError, StageResult};
use crate::session::Surface;

/// Of one control: the response of the rate it is there for, over the windows in which it alone moves.
#[derive(Clone, Debug)]
pub struct SurfaceResponse {
    /// Control.
    pub surface: Surface,
    /// Response, or why there is none.
    pub response: StageResult<ResponseStudy>,
    /// Its equivalent system, or why there is none.
    pub system: StageResult<EquivalentStudy>,
    /// Response of the identified model about the trim of the windows, at the same frequencies; empty where there is none.
    pub model: Vec<Complex<f64>>,
    /// Modes of the identified model beside those by the equivalent system and by the free responses; empty without a model.
    pub modes: Vec<ModeComparison>,
    /// Levels by the equivalent system, for each standard; empty without a system or without a mass of the aircraft.
    pub levels: Vec<(Standard, EquivalentLevels)>,
}

/// Responses of every control that moves in some window by itself.
#[derive(Clone, Debug, Default)]
pub struct FlightResponses {
    /// In the order elevator, aileron, rudder.
    pub surfaces: Vec<SurfaceResponse>,
}

impl FlightResponses {
    /// Modes by the manoeuvres of all controls.
    pub fn compared_modes(&self) -> impl Iterator<Item = &ModeComparison> {
        self.surfaces.iter().flat_map(|surface| &surface.modes)
    }
}

impl Footprint for FlightResponses {
    fn bytes(&self) -> usize {
        let samples = self.surfaces.iter().filter_map(|surface| surface.response.as_ref().ok());
        samples.map(|study| 64 * 1024 + 16 * study.sample_count()).sum()
    }
}

/// The form each control's response has in the literature.
fn form(surface: Surface) -> Form {
    match surface {
        Surface::Elevator => Form::ShortPeriod,
        // Roll rate holds the Dutch roll beside the roll mode.
        Surface::Aileron => Form::Orders { numerator: 2, denominator: 3 },
        Surface::Rudder => Form::Yaw,
    }
}

impl Stage for FlightResponses {
    type Params<'a> = ();
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "frequency responses";

    fn run((): (), input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let mut surfaces = Vec::new();
        // Without a trim or with one motion alone there is no model to compare with, which its own study says.
        let dynamics = match context.get::<DynamicsStudy>(DynamicsRequest::default(), input) {
            Err(StageError::Cancelled) => return Err(StageError::Cancelled),
            found => found.ok(),
        };
        let airplane = match &dynamics {
            Some(study) => Some((study.airplane.clone(), study.airplane_from.clone())),
            None => airplane_by_default(input)?,
        };
        let limits = Standard::ALL.map(|standard| Ok::<_, StageError>((standard, joined_limits(standard)?)));
        let limits = limits.into_iter().collect::<Result<Vec<_>, _>>()?;
        for surface in Surface::ALL {
            context.checkpoint()?;
            let own = input.windows.iter().filter(|window| window.manoeuvre.surface == Some(surface));
            let windows: Vec<ResponseWindow<'_>> = own
                .map(|window| ResponseWindow {
                    name: &window.manoeuvre.name,
                    recording: &window.flight.recording,
                    path: &window.path,
                    source: input.settings.preparation.path,
                    aero: Some(&window.aero),
                })
                .collect();
            if windows.is_empty() {
                continue;
            }
            let request = ResponseRequest {
                inputs: vec![surface.role().name().to_owned()],
                output: surface.rate().name().to_owned(),
                ..ResponseRequest::default()
            };
            let response = session_responses(&windows, &request, true).map_err(|error| error.to_string().into());
            let fitted = |study: &ResponseStudy| {
                equivalent_study(study, 0, (form(surface), Delay::Free), None).map_err(|error| error.to_string().into())
            };
            let of_model = |study: &ResponseStudy| {
                let omega: Vec<f64> = study.responses.first()?.points.iter().map(|point| point.omega_rad_s).collect();
                let linear = dynamics.as_ref()?.modes.linearised.motion();
                state_space_response(&linear, &study.inputs[0], &study.output, &omega)
            };
            let model = response.as_ref().ok().and_then(of_model).unwrap_or_default();
            let system = response.as_ref().map_err(Clone::clone).and_then(fitted);
            let compared = |study: &DynamicsStudy| {
                compare_modes(surface, system.as_ref().ok(), (&study.measured, &study.modes.modes))
            };
            let modes = dynamics.as_deref().map(compared).unwrap_or_default();
            let levels = match (&system, &airplane) {
                (Ok(system), Some((airplane, from))) => limits
                    .iter()
                    .map(|(standard, limits)| {
                        let output = surface.rate().name();
                        (*standard, EquivalentLevels::judge(system, output, limits, (airplane, from)))
                    })
                    .collect(),
                _ => Vec::new(),
            };
            surfaces.push(SurfaceResponse { surface, response, system, model, modes, levels });
        }
        if surfaces.is_empty() {
            return Err("no manoeuvre in use moves one control alone: state the surface of a manoeuvre".into());
        }
        Ok(Self { surfaces })
    }
}
