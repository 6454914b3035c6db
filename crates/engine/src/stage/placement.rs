//! Measurements moved from where the sensors are to the centre of gravity, each at its own times.

use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::prep::{
    FlowVane, Interpolation, acceleration_at_cg, differentiate, flow_angles_at_cg, resample, satellite_fix_at_cg,
};
use doublet_core::reconstruct::{Input, InputSeries, MEASUREMENTS, Measurement, MeasurementSeries};

use super::samples::short_differentiation;
use crate::graph::StageResult;
use crate::session::Preparation;

pub type Measurements = [MeasurementSeries; MEASUREMENTS];

const RATES: [Input; 3] = [Input::RollRate, Input::PitchRate, Input::YawRate];
const ATTITUDE: [Measurement; 3] = [Measurement::BankAngle, Measurement::PitchAngle, Measurement::HeadingAngle];

/// Moves the specific forces from `position_m` to the centre of gravity.
pub(crate) fn move_accelerometer(
    inputs: &mut InputSeries,
    position_m: [f64; 3],
    preparation: &Preparation,
) -> StageResult<()> {
    let method = short_differentiation(preparation, &inputs.time_s);
    let mut angular: [Vec<f64>; 3] = Default::default();
    for (column, rate) in angular.iter_mut().zip(RATES) {
        *column = differentiate(&inputs.time_s, &inputs.columns[rate as usize], method)
            .map_err(|error| format!("{}: {error}", rate.name()))?;
    }
    let forces = [Input::SpecificForceX, Input::SpecificForceY, Input::SpecificForceZ];
    let mut at_cg: [Vec<f64>; 3] = forces.map(|force| Vec::with_capacity(inputs.columns[force as usize].len()));
    for sample in 0..inputs.time_s.len() {
        let at = |input: Input| inputs.columns[input as usize][sample];
        let moved = acceleration_at_cg(
            position_m,
            forces.map(at),
            RATES.map(at),
            [angular[0][sample], angular[1][sample], angular[2][sample]],
        );
        at_cg.iter_mut().zip(moved).for_each(|(column, value)| column.push(value));
    }
    for (force, column) in forces.into_iter().zip(at_cg) {
        inputs.columns[force as usize] = column.into();
    }
    Ok(())
}

/// `series` at `time_s` by straight lines, its first and last value beyond its ends; `None` without samples.
fn at_times(series_time_s: &[f64], values: &[f64], time_s: &[f64]) -> Option<Vec<f64>> {
    let (&first, &last) = (series_time_s.first()?, series_time_s.last()?);
    let clamped: Vec<f64> = time_s.iter().map(|time| time.clamp(first, last)).collect();
    if series_time_s.len() == 1 {
        return Some(vec![values[0]; time_s.len()]);
    }
    resample(series_time_s, values, &clamped, Interpolation::Linear).ok()
}

/// Body rates at `time_s`.
fn rates_at(inputs: &InputSeries, time_s: &[f64]) -> Option<[Vec<f64>; 3]> {
    let [p, q, r] = RATES.map(|rate| at_times(&inputs.time_s, &inputs.columns[rate as usize], time_s));
    Some([p?, q?, r?])
}

fn measured_at(measurements: &Measurements, measurement: Measurement, time_s: &[f64]) -> Option<Vec<f64>> {
    let series = &measurements[measurement as usize];
    at_times(&series.time_s, &series.values, time_s)
}

/// Moves angle of attack and sideslip from their vanes at `positions_m` to the centre of gravity, each at its own times. Says so where it cannot.
pub(crate) fn move_vanes(
    measurements: &mut Measurements,
    inputs: &InputSeries,
    positions_m: [[f64; 3]; 2],
) -> Option<Message> {
    let recorded = measurements.clone();
    for (angle, position_m) in [Measurement::AngleOfAttack, Measurement::Sideslip].into_iter().zip(positions_m) {
        let vane = FlowVane::at(position_m);
        let time_s = &recorded[angle as usize].time_s;
        if time_s.is_empty() {
            continue;
        }
        let (Some(airspeed), Some(alpha), Some(rates)) = (
            measured_at(&recorded, Measurement::Airspeed, time_s),
            measured_at(&recorded, Measurement::AngleOfAttack, time_s),
            rates_at(inputs, time_s),
        ) else {
            return Some(message!(
                "{} not moved to the centre of gravity: airspeed and alpha are needed",
                angle.name()
            ));
        };
        let beta = measured_at(&recorded, Measurement::Sideslip, time_s).unwrap_or_else(|| vec![0.0; time_s.len()]);
        for (k, value) in Arc::make_mut(&mut measurements[angle as usize].values).iter_mut().enumerate() {
            let rates = [rates[0][k], rates[1][k], rates[2][k]];
            let (_, moved_alpha, moved_beta) = flow_angles_at_cg(&vane, airspeed[k], alpha[k], beta[k], rates);
            *value = if angle == Measurement::Sideslip { moved_beta } else { moved_alpha };
        }
    }
    None
}

/// Moves position and ground velocity from the antenna at `position_m` to the centre of gravity, with the measured attitude
/// and rates at their times. Says so where it cannot.
pub(crate) fn move_antenna(
    measurements: &mut Measurements,
    inputs: &InputSeries,
    position_m: [f64; 3],
) -> Option<Message> {
    let recorded = measurements.clone();
    let position = [Measurement::PositionNorth, Measurement::PositionEast, Measurement::PositionDown];
    let velocity = [Measurement::VelocityNorth, Measurement::VelocityEast, Measurement::VelocityDown];
    for (group, is_velocity) in [(position, false), (velocity, true)] {
        for (axis, measurement) in group.into_iter().enumerate() {
            let time_s = &recorded[measurement as usize].time_s;
            if time_s.is_empty() {
                continue;
            }
            let attitude = ATTITUDE.map(|angle| measured_at(&recorded, angle, time_s));
            let ([Some(phi), Some(theta), Some(psi)], Some(rates)) = (attitude, rates_at(inputs, time_s)) else {
                return Some(message!("{} not moved to the centre of gravity: attitude is needed", measurement.name()));
            };
            for (k, value) in Arc::make_mut(&mut measurements[measurement as usize].values).iter_mut().enumerate() {
                let rates = [rates[0][k], rates[1][k], rates[2][k]];
                let arm = satellite_fix_at_cg(position_m, [phi[k], theta[k], psi[k]], rates, [0.0; 3], [0.0; 3]);
                *value += if is_velocity { arm.1[axis] } else { arm.0[axis] };
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use doublet_core::prep::{accelerometer_at, flow_angles_at_vanes};

    use super::*;

    /// Linear interpolation of a turn whose rates change slowly, m/s and rad.
    const INTERPOLATED: f64 = 2e-4;

    /// A steady turn with a slow pitching motion; air data at 20 Hz, position and velocity at 4 Hz, attitude at 50 Hz.
    fn turn() -> (InputSeries, Measurements) {
        let inputs_s: Vec<f64> = (0..=500).map(|k| f64::from(k) * 0.01).collect();
        let q = |t: f64| 0.05 * (0.7 * t).sin();
        let row = |t: f64| [0.0, 0.0, -9.8, 0.01, q(t), 0.12];
        let columns = std::array::from_fn(|column| inputs_s.iter().map(|t| row(*t)[column]).collect());
        let inputs = InputSeries { time_s: inputs_s.clone().into(), columns };
        let series = |step: usize, value: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = inputs_s.iter().copied().step_by(step).collect();
            let values = time_s.iter().map(|t| value(*t)).collect();
            MeasurementSeries { time_s: time_s.into(), values }
        };
        let mut measurements = Measurements::default();
        for (m, step, value) in [
            (Measurement::PositionNorth, 25, 60.0),
            (Measurement::PositionEast, 25, 10.0),
            (Measurement::PositionDown, 25, -900.0),
            (Measurement::VelocityNorth, 25, 60.0),
            (Measurement::VelocityEast, 25, 3.0),
            (Measurement::VelocityDown, 25, -1.0),
            (Measurement::BankAngle, 2, 0.4),
            (Measurement::PitchAngle, 2, 0.05),
            (Measurement::Airspeed, 5, 60.0),
            (Measurement::AngleOfAttack, 5, 0.08),
            (Measurement::Sideslip, 10, -0.03),
        ] {
            measurements[m as usize] = series(step, &|_| value);
        }
        measurements[Measurement::HeadingAngle as usize] = series(2, &|t| 0.12 * t);
        (inputs, measurements)
    }

    #[test]
    fn sensors_away_from_the_centre_of_gravity_come_back_to_it_each_at_its_own_times() {
        let (inputs, at_cg) = turn();
        let mut measured = at_cg.clone();
        let (vane, antenna) = ([3.0, -5.0, 0.4], [-2.0, 1.0, -1.5]);
        let rates = |t: f64| [0.01, 0.05 * (0.7 * t).sin(), 0.12];
        for (angle, take) in [(Measurement::AngleOfAttack, 0), (Measurement::Sideslip, 1)] {
            let series = &mut measured[angle as usize];
            for (time, value) in series.time_s.iter().zip(Arc::make_mut(&mut series.values)) {
                let (_, alpha, beta) = flow_angles_at_vanes(&FlowVane::at(vane), 60.0, 0.08, -0.03, rates(*time));
                *value = [alpha, beta][take];
            }
        }
        for m in 0..6 {
            let series = &mut measured[m];
            for (time, value) in series.time_s.iter().zip(Arc::make_mut(&mut series.values)) {
                let back = satellite_fix_at_cg(antenna, [0.4, 0.05, 0.12 * time], rates(*time), [0.0; 3], [0.0; 3]);
                *value -= if m < 3 { back.0[m] } else { back.1[m - 3] };
            }
        }
        let moved_by = |m: Measurement, found: &Measurements| -> f64 {
            let pairs = found[m as usize].values.iter().zip(at_cg[m as usize].values.iter());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(
            moved_by(Measurement::AngleOfAttack, &measured) > 0.003
                && moved_by(Measurement::VelocityEast, &measured) > 0.1
        );
        assert_eq!(move_vanes(&mut measured, &inputs, [vane; 2]), None);
        assert_eq!(move_antenna(&mut measured, &inputs, antenna), None);
        for m in Measurement::ALL {
            let off = moved_by(m, &measured);
            assert!(off < INTERPOLATED, "{}: {off}", m.name());
        }
        let mut blind = at_cg.clone();
        blind[Measurement::HeadingAngle as usize] = MeasurementSeries::default();
        assert!(move_antenna(&mut blind, &inputs, antenna).is_some_and(|line| line.to_string().contains("attitude")));

        // the accelerometer of a body that only spins up feels its lever arm and nothing else
        let mut arm = inputs.clone();
        let step = 0.01;
        for k in 0..arm.time_s.len() {
            let t = k as f64 * step;
            let moved = accelerometer_at(vane, [0.0, 0.0, -9.8], rates(t), [0.0, 0.035 * (0.7 * t).cos(), 0.0]);
            (0..3).for_each(|axis| Arc::make_mut(&mut arm.columns[axis])[k] = moved[axis]);
        }
        move_accelerometer(&mut arm, vane, &Preparation::default()).unwrap();
        // half a window of the local quadratic at each end is extrapolated
        for k in 20..480 {
            assert!((arm.columns[2][k] + 9.8).abs() < 10.0 * INTERPOLATED, "{k} {}", arm.columns[2][k]);
        }
    }
}
