//! Constant errors of the instruments of a simulated flight, drawn from the accuracies its scenario states.

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::instruments::Quantity;
use crate::quantity::InstrumentError;

/// Values by error, SI: standard deviations of a scenario, or what one flight has of them.
pub type InstrumentErrors = BTreeMap<InstrumentError, f64>;

/// What a stream reads of a quantity in place of its value `x(t)`: `(1 + scale) x(t - delay) + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuantityError {
    pub(super) quantity: Quantity,
    pub(super) offset: f64,
    pub(super) scale: f64,
    pub(super) delay_s: f64,
}

/// Offset, scale and delay of a quantity, as far as it has them.
type Own = [Option<InstrumentError>; 3];

const ALPHA: Own =
    [Some(InstrumentError::AlphaOffset), Some(InstrumentError::AlphaScale), Some(InstrumentError::FlowDelay)];
const BETA: Own =
    [Some(InstrumentError::BetaOffset), Some(InstrumentError::BetaScale), Some(InstrumentError::FlowDelay)];

/// That has a delay alone.
const fn delayed(error: InstrumentError) -> Own {
    [None, None, Some(error)]
}

/// The values of these errors, zero for those that it does not have.
fn values_of(own: Own, errors: &InstrumentErrors) -> [f64; 3] {
    own.map(|error| error.and_then(|error| errors.get(&error)).copied().unwrap_or(0.0))
}

/// The recorders of the flight-test installation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recorder {
    Bus,
    Monitor,
    Pod,
    ControlSensors,
}

/// Independent normal errors of these standard deviations.
pub(super) fn draw(accuracies: &InstrumentErrors, rng: &mut ChaCha8Rng) -> InstrumentErrors {
    accuracies.iter().map(|(error, deviation)| (*error, deviation * rng.sample::<f64, _>(StandardNormal))).collect()
}

/// What the streams of a recorder read in error.
pub(super) fn quantity_errors(recorder: Recorder, errors: &InstrumentErrors) -> Vec<QuantityError> {
    use InstrumentError as E;
    use Quantity as Q;
    let rows: Vec<(Quantity, Own)> = match recorder {
        Recorder::Bus => vec![
            (Q::Bank, delayed(E::AttitudeDelay)),
            (Q::Pitch, delayed(E::AttitudeDelay)),
            (Q::HeadingUnwrapped, delayed(E::AttitudeDelay)),
            (Q::TrueAirspeed, delayed(E::AirspeedDelay)),
            (Q::CalibratedAirspeed, delayed(E::AirspeedDelay)),
            (Q::VelocityNorth, delayed(E::GroundDelay)),
            (Q::VelocityEast, delayed(E::GroundDelay)),
            (Q::VelocityUp, delayed(E::GroundDelay)),
            (Q::GpsAltitude, delayed(E::AltitudeDelay)),
        ],
        Recorder::Monitor => Vec::new(),
        Recorder::Pod => vec![(Q::Alpha, ALPHA), (Q::Beta, BETA)],
        Recorder::ControlSensors => vec![
            (Q::Yoke, delayed(E::AileronDelay)),
            (Q::ColumnDrum, delayed(E::ElevatorDelay)),
            (Q::RightPedalDrum, delayed(E::RudderDelay)),
            (Q::LeftPedalDrum, delayed(E::RudderDelay)),
        ],
    };
    rows.into_iter()
        .map(|(quantity, own)| {
            let [offset, scale, delay_s] = values_of(own, errors);
            QuantityError { quantity, offset, scale, delay_s }
        })
        .filter(|error| [error.offset, error.scale, error.delay_s] != [0.0; 3])
        .collect()
}

/// Offset, scale and delay of a column of the truth as the recorders give it.
pub(super) fn column_errors(column: &str, errors: &InstrumentErrors) -> [f64; 3] {
    use InstrumentError as E;
    let own = match column {
        "alpha" => ALPHA,
        "beta" => BETA,
        "airspeed" => delayed(E::AirspeedDelay),
        "phi" | "theta" | "psi" => delayed(E::AttitudeDelay),
        "x" | "y" | "v_north" | "v_east" | "v_down" => delayed(E::GroundDelay),
        "z" => delayed(E::AltitudeDelay),
        "delta_a" => delayed(E::AileronDelay),
        "delta_e" => delayed(E::ElevatorDelay),
        "delta_r" => delayed(E::RudderDelay),
        _ => [None; 3],
    };
    values_of(own, errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Flight, run, scenario};

    /// Seeds of flights; the second draws a recorder that is late by 0.09 s.
    const SEED: u64 = 3;
    const LATE: u64 = 5;
    /// Sideslip of the pod is written to 0.01 deg; noise is the same in flights of one seed.
    const RESOLUTION_DEG: f64 = 0.011;
    /// Four standard deviations of the noise of the pod's sideslip.
    const BAND_DEG: f64 = 0.28;

    fn fly(accuracies: &str, seed: u64) -> Flight {
        let text = format!(
            "format = \"doublet scenario\"\nversion = 1\naircraft = \"c337f\"\nairspeed_m_s = 46.3\naltitude_m = 1200.0\nrest_s = 1.0\n\
             {accuracies}\n[[manoeuvre]]\nname = \"01\"\nduration_s = 6.0\ntime_s = [1.0, 1.1, 2.0, 2.1]\nrudder_rad = [0.0, 0.05, 0.05, 0.0]\n"
        );
        run(&scenario::parse(&text).unwrap(), seed, &mut |_| true).unwrap()
    }

    #[test]
    fn drawn_errors_act_on_what_the_recorders_write_and_a_seed_draws_them_again() {
        let (without, with) = (fly("", SEED), fly("[sensor_accuracy]\nbeta_offset_rad = 0.01\nbeta_scale = 0.2", SEED));
        assert!(without.instrument_errors.is_empty());
        assert_eq!(
            with.instrument_errors,
            fly("[sensor_accuracy]\nbeta_offset_rad = 0.01\nbeta_scale = 0.2", SEED).instrument_errors
        );
        let value = |error| with.instrument_errors[&error];
        let (offset, scale) = (value(InstrumentError::BetaOffset), value(InstrumentError::BetaScale));
        assert!(offset != 0.0 && offset.abs() < 0.05 && scale != 0.0 && scale.abs() < 1.0, "{offset} {scale}");
        let beta = |flight: &Flight| flight.pod.values[1].clone();
        let bias_deg = crate::simulate::boxes::SIDESLIP_OFFSET_RAD.to_degrees();
        let (shown, own) = (beta(&with), beta(&without));
        let moved = own.iter().map(|own| (scale * (f64::from(*own) - bias_deg)).abs()).fold(0.0, f64::max);
        assert!(moved > 4.0 * BAND_DEG * scale.abs(), "moved by {moved} deg");
        for (shown, own) in shown.iter().zip(&own) {
            let expected = scale * (f64::from(*own) - bias_deg) + offset.to_degrees();
            let found = f64::from(shown - own);
            assert!((found - expected).abs() < BAND_DEG * scale.abs() + RESOLUTION_DEG, "{found} for {expected}");
        }
    }

    #[test]
    fn a_late_recorder_writes_what_was_before() {
        let late = fly("[sensor_accuracy]\nattitude_delay_s = 0.1", LATE);
        let (delay_s, exact) = (late.instrument_errors[&InstrumentError::AttitudeDelay], fly("", LATE));
        let [own, shown] = [&exact, &late].map(|flight| flight.bus[0].values[6].clone());
        // Bank and its rate by the truth: the noise is the same in both.
        let rate_deg_s = |time_s: f64| {
            let truth = &exact.truth;
            let at = truth.time_s.partition_point(|time| *time < time_s).min(truth.time_s.len() - 1);
            f64::from(truth.column("p").unwrap()[at]).to_degrees()
        };
        let pairs = exact.bus[0].time_s.iter().zip(own.iter().zip(&shown));
        let worst = pairs.map(|(time_s, (own, shown))| {
            (f64::from(shown - own) + delay_s * rate_deg_s(time_s - 0.5 * delay_s)).abs()
        });
        let worst = worst.fold(0.0, f64::max);
        let moved = exact.bus[0].time_s.iter().map(|time_s| (delay_s * rate_deg_s(*time_s)).abs()).fold(0.0, f64::max);
        assert!(moved > 0.05 && worst < 0.05 + 0.25 * moved, "moved by {moved} deg, {worst} deg off");
    }

    #[test]
    fn deviations_without_sense_are_refused() {
        let text = "format = \"doublet scenario\"\nversion = 1\naircraft = \"c337f\"\nairspeed_m_s = 46.3\naltitude_m = 1200.0\n[sensor_accuracy]\n";
        for line in ["alpha_scale = -0.1", "flow_delay_s = 0.2", "gamma_scale = 0.1"] {
            assert!(scenario::parse(&format!("{text}{line}\n")).is_err(), "{line}");
        }
    }
}
