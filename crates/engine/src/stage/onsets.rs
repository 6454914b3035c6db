//! Clock shifts of the control sensors, by the first response to each manoeuvre (thesis 4.4.3).

use doublet_core::align::{OnsetAlignment, OnsetSettings, onset_alignment};
use doublet_core::prep::{Differentiation, differentiate};
use doublet_core::quantity::Role;
use doublet_core::series::{Series, TimeRange};

use super::{FlightProposals, LoadedFlight, WindowProposal};
use crate::graph::{StageError, StageResult};
use crate::session::Surface;

/// Steady flight before the onset and response after it that are looked at, s.
const AROUND_S: [f64; 2] = [1.0, 2.5];
/// Measured motion fitted beside the control.
const MOTION: [Role; 5] = [Role::RollRate, Role::PitchRate, Role::YawRate, Role::BankAngle, Role::PitchAngle];

/// Shift of a control sensor by one manoeuvre, or why none was found.
#[derive(Clone, Debug)]
pub struct OnsetShift {
    pub manoeuvre: String,
    pub found: StageResult<OnsetAlignment>,
}

/// Shift for each proposed manoeuvre with which the angular acceleration answers its control at once.
pub fn onset_shifts(loaded: &LoadedFlight, proposals: &FlightProposals) -> Vec<OnsetShift> {
    let answers: Vec<Answer<'_>> = Surface::ALL.into_iter().filter_map(|surface| answer(loaded, surface)).collect();
    let shift = |proposal: &WindowProposal| {
        let moved = |answer: &&Answer<'_>| Some(answer.surface) == proposal.manoeuvre.surface;
        let found = answers.iter().find(moved)?.align(loaded, proposal.onset_s);
        Some(OnsetShift { manoeuvre: proposal.manoeuvre.name.clone(), found })
    };
    proposals.windows.iter().filter_map(shift).collect()
}

/// Mean of the shifts, weighted by their variances, and its standard error, s.
pub fn mean_shift(shifts: &[OnsetShift]) -> Option<(f64, f64)> {
    let (mut sum, mut weights) = (0.0, 0.0);
    for found in shifts.iter().filter_map(|shift| shift.found.as_ref().ok()) {
        let weight = found.shift_sd_s.powi(-2);
        (sum, weights) = (sum + weight * found.shift_s, weights + weight);
    }
    (weights > 0.0).then(|| (sum / weights, weights.powf(-0.5)))
}

/// A control and the angular acceleration that answers it.
struct Answer<'a> {
    surface: Surface,
    control: &'a Series,
    response: StageResult<Series>,
}

fn series(loaded: &LoadedFlight, role: Role) -> Option<&Series> {
    loaded.recording.role(role).map(|channel| &channel.series)
}

fn answer(loaded: &LoadedFlight, surface: Surface) -> Option<Answer<'_>> {
    let (control, rate) = (series(loaded, surface.role())?, series(loaded, surface.rate())?);
    let method = Differentiation::LocalPolynomial { degree: 2, half_width: 2 };
    let slope = differentiate(&rate.time_s, &rate.values, method).map_err(StageError::from);
    let response = slope.map(|slope| Series { time_s: rate.time_s.clone(), values: slope.into() });
    Some(Answer { surface, control, response })
}

impl Answer<'_> {
    fn align(&self, loaded: &LoadedFlight, onset_s: f64) -> StageResult<OnsetAlignment> {
        let response = self.response.as_ref().map_err(Clone::clone)?;
        let window = TimeRange { start_s: onset_s - AROUND_S[0], end_s: onset_s + AROUND_S[1] };
        let motion = MOTION.into_iter().filter_map(|role| series(loaded, role));
        let companions: Vec<&Series> = motion.filter(|other| other.time_s == response.time_s).collect();
        Ok(onset_alignment(self.control, response, &companions, window, &OnsetSettings::default())?)
    }
}
