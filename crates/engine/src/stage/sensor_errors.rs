//! Constant errors of the sensors over all windows.

use doublet_core::estimate::{SensorErrorFit, SensorErrorWindow, sensor_errors};
use doublet_core::reconstruct::FilterSettings;

use super::window_samples::Samples;
use crate::graph::{Context, Footprint, Keyed, Stage, StageError, StageResult};
use crate::session::{Manoeuvre, SensorErrors};

/// Errors of the sensors, as far as the session asks for them.
#[derive(Clone, Debug)]
pub struct EstimatedSensorErrors(pub SensorErrorFit);

impl Footprint for EstimatedSensorErrors {
    fn bytes(&self) -> usize {
        let fit = &self.0.fit;
        8 * fit.outputs.len() * (1 + fit.sensitivities.len()) + 4096
    }
}

/// Of windows in the order of the session.
impl Stage for EstimatedSensorErrors {
    type Params<'a> = (&'a SensorErrors, &'a FilterSettings);
    type Inputs<'a> = &'a [(&'a Manoeuvre, &'a Keyed<Samples>)];
    type Output = Self;
    const NAME: &'static str = "errors of the sensors";

    fn run((errors, filter): Self::Params<'_>, windows: Self::Inputs<'_>, context: &Context<'_>) -> StageResult<Self> {
        if errors.is_empty() {
            return Err(StageError::NotApplicable);
        }
        if windows.is_empty() {
            return Err("no manoeuvre has samples to estimate them from".into());
        }
        let windows: Vec<SensorErrorWindow<'_>> = windows
            .iter()
            .map(|&(manoeuvre, samples)| SensorErrorWindow { label: manoeuvre.name.clone(), data: &samples.data })
            .collect();
        let found = sensor_errors(&windows, &errors.settings(filter), &|| !context.control().is_cancelled());
        context.checkpoint()?;
        found.map(Self).map_err(|error| error.to_string().into())
    }
}
