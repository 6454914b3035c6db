//! The flight path as measured, without a filter.

use std::sync::Arc;

use crate::message;
use crate::prep::{Interpolation, resample};
use crate::reconstruct::data::{FilterData, MeasurementSeries, Reconstruction};
use crate::reconstruct::deviations::Deviations;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::model::layout::{Measurement, STATES, State};

/// States taken over from a measurement as they are.
const TAKEN_OVER: [(Measurement, State); 6] = [
    (Measurement::PositionNorth, State::PositionNorth),
    (Measurement::PositionEast, State::PositionEast),
    (Measurement::PositionDown, State::PositionDown),
    (Measurement::BankAngle, State::BankAngle),
    (Measurement::PitchAngle, State::PitchAngle),
    (Measurement::HeadingAngle, State::HeadingAngle),
];

/// The path that the measurements say, at the inertial samples: no filter, no biases, no wind, no deviations.
///
/// `u = V cos(beta) cos(alpha)`, `v = V sin(beta)`, `w = V cos(beta) sin(alpha)`; positions and Euler angles as measured. Measurements are
/// put on the inertial clock by straight lines; their first and last values hold beyond them. What is not measured is zero, which a
/// warning says.
///
/// # Errors
/// [`ReconstructError::NotMeasured`] without airspeed or angle of attack; [`ReconstructError::TooFewSamples`],
/// [`ReconstructError::UnorderedTime`].
pub fn measured_path(data: &FilterData) -> Result<Reconstruction, ReconstructError> {
    let time_s = Arc::clone(&data.inputs.time_s);
    let samples = time_s.len();
    if samples < 2 {
        return Err(ReconstructError::TooFewSamples { samples });
    }
    let mut missing = Vec::new();
    let mut column = |measurement: Measurement| {
        let found = at_samples(measurement, &data.measurements[measurement as usize], &time_s)?;
        Ok::<_, ReconstructError>(found.unwrap_or_else(|| {
            missing.push(measurement.name());
            vec![0.0; samples]
        }))
    };
    let mut states: [Vec<f64>; STATES] = std::array::from_fn(|_| vec![0.0; samples]);
    for (measurement, state) in TAKEN_OVER {
        states[state as usize] = column(measurement)?;
    }
    let beta_rad = column(Measurement::Sideslip)?;
    let airspeed_m_s = column(Measurement::Airspeed)?;
    let alpha_rad = column(Measurement::AngleOfAttack)?;
    let needed = [Measurement::Airspeed, Measurement::AngleOfAttack].map(Measurement::name);
    if let Some(measurement) = needed.into_iter().find(|name| missing.contains(name)) {
        return Err(ReconstructError::NotMeasured { measurement });
    }
    for k in 0..samples {
        let ahead = airspeed_m_s[k] * beta_rad[k].cos();
        states[State::VelocityU as usize][k] = ahead * alpha_rad[k].cos();
        states[State::VelocityV as usize][k] = airspeed_m_s[k] * beta_rad[k].sin();
        states[State::VelocityW as usize][k] = ahead * alpha_rad[k].sin();
    }
    let nothing = || vec![f64::NAN; samples];
    let mut warnings = vec![message!("path as measured: no filter, no biases removed")];
    if !missing.is_empty() {
        warnings.push(message!("not measured and assumed zero: {}", missing.join(", ")));
    }
    Ok(Reconstruction {
        states,
        deviations: std::array::from_fn(|_| Deviations::constant(0.0, samples)),
        update_time_s: Arc::clone(&time_s),
        time_s,
        innovations: std::array::from_fn(|_| Vec::new()),
        innovation_deviations: std::array::from_fn(|_| Vec::new().into()),
        nis: nothing(),
        nis_degrees: vec![0; samples],
        log_likelihood: f64::NAN,
        air_data: None,
        final_covariance: nalgebra::SMatrix::zeros(),
        smoothed: None,
        max_iterations_used: 0,
        outliers: Default::default(),
        warnings,
    })
}

/// Values of a measurement at the inertial samples; `None` where it has none.
fn at_samples(
    measurement: Measurement,
    series: &MeasurementSeries,
    time_s: &[f64],
) -> Result<Option<Vec<f64>>, ReconstructError> {
    let finite = series.time_s.iter().zip(series.values.iter()).filter(|(_, value)| value.is_finite());
    let (own_s, values): (Vec<f64>, Vec<f64>) = finite.map(|(time, value)| (*time, *value)).unzip();
    let (Some(&first), Some(&last)) = (own_s.first(), own_s.last()) else { return Ok(None) };
    if own_s.len() == 1 {
        return Ok(Some(vec![values[0]; time_s.len()]));
    }
    let unordered = own_s.windows(2).position(|pair| pair[0] >= pair[1]);
    let wanted: Vec<f64> = time_s.iter().map(|time| time.clamp(first, last)).collect();
    resample(&own_s, &values, &wanted, Interpolation::Linear).map(Some).map_err(|_| {
        let sample = unordered.unwrap_or(0);
        ReconstructError::UnorderedTime { channel: measurement.name(), time_s: own_s[sample], sample }
    })
}
