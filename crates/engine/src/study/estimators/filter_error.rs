//! Filter error: output error whose states noise drives as well, from the estimates of output error.

use doublet_core::estimate::{OutputErrorSettings, ProcessNoise, flight_filter_error};

use super::output_error::{OutputErrorFlight, checked, first, line_of};
use super::{CheckedDerivative, MethodEstimates, PartEstimates, WindowEstimation};
use crate::graph::StageResult;

/// Every motion of the manoeuvre.
pub(super) fn estimate(estimation: &WindowEstimation<'_>) -> Vec<PartEstimates> {
    estimation.by_motion(filtered)
}

/// The derivatives, and the process noise among the others.
fn filtered(flight: &OutputErrorFlight<'_>) -> StageResult<MethodEstimates> {
    let windows = [flight.flight_window(flight.recorded())];
    let least: Vec<f64> = flight.axis.outputs().iter().map(|&output| flight.least_noise(output)).collect();
    let begin = (&*flight.found.fit.estimates, &*least);
    let settings = OutputErrorSettings::default();
    let go_on = || !flight.context.control().is_cancelled();
    let filter = flight_filter_error(flight.axis, (&windows, &flight.freedom), begin, &settings, &go_on);
    let filter = filter.map_err(line_of)?;
    let derivatives: Vec<_> = checked(&filter.estimate).take(flight.freedom.shared.len()).collect();
    let covariance = first(&filter.estimate.corrected_covariance, derivatives.len());
    let others = filter.process_noise.iter().map(noise_row).collect();
    Ok(MethodEstimates { derivatives, covariance, others, flight: None })
}

/// The noise that drives a state, per root second; zero without an error where the data show none.
fn noise_row(noise: &ProcessNoise) -> CheckedDerivative {
    let (estimate, standard_error) =
        if noise.is_none { (0.0, f64::NAN) } else { (noise.intensity, noise.intensity * noise.log_error) };
    CheckedDerivative { name: format!("process noise of {}", noise.state), estimate, standard_error }
}
