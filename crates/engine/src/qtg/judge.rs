//! From tolerances and numbers to rows and verdicts.

use doublet_core::validate::{BandResult, Histories, Signal, TestResult};

use super::units::{band, named, value};
use super::{ChannelRow, ValueRow};
use crate::notation;
use crate::stage::{Quantity, ValueTolerance};

/// Rows of bands.
pub fn channels(result: &TestResult) -> Vec<ChannelRow> {
    let numbered = result.requirements.iter().enumerate();
    let rows = numbered.flat_map(|(index, bands)| {
        bands.iter().map(move |judged| ChannelRow {
            requirement: index + 1,
            parameter: judged.tolerance.signal.name(),
            tolerance: band(&judged.tolerance),
            unit: judged.tolerance.signal.dimension().si_symbol(),
            worst: judged.worst_error,
            worst_ratio: judged.worst_ratio,
            worst_time_s: judged.worst_time_s,
            share_inside: judged.share_inside,
            passed: judged.passed(),
        })
    });
    rows.collect()
}

/// How much of each requirement is used, in words.
pub(crate) fn over_bands(requirements: usize, result: &TestResult) -> String {
    let used: Vec<String> =
        result.requirements.iter().take(requirements).filter_map(|bands| describe_best(bands)).collect();
    used.join(", ")
}

fn describe_best(bands: &[BandResult]) -> Option<String> {
    bands.iter().min_by(|a, b| a.worst_ratio.total_cmp(&b.worst_ratio)).map(|best| {
        let symbol = notation::signal(best.tolerance.signal);
        format!("{symbol} uses {:.0} % of its band", 100.0 * best.worst_ratio)
    })
}

/// Rows of the tolerances of single numbers.
pub fn values(
    requirements: &[Vec<ValueTolerance>],
    flight: &dyn Fn(Quantity) -> Option<f64>,
    model: &dyn Fn(Quantity) -> Option<f64>,
) -> Vec<ValueRow> {
    let numbered = requirements.iter().enumerate();
    let rows = numbered.flat_map(|(index, any)| {
        any.iter().map(move |tolerance| {
            let (flight, model) = (flight(tolerance.quantity), model(tolerance.quantity));
            ValueRow {
                requirement: index + 1,
                parameter: tolerance.quantity.name().to_owned(),
                tolerance: value(tolerance),
                unit: tolerance.quantity.dimension().si_symbol(),
                flight,
                flight_error: None,
                model,
                model_error: None,
                passed: flight.zip(model).map(|(flight, model)| tolerance.holds(flight, model)),
            }
        })
    });
    rows.collect()
}

/// Whether every requirement is met by one of its numbers. Those of which flight or model say nothing are left out; where nothing is
/// left the test is not met.
pub fn met(rows: &[ValueRow], requirements: usize) -> bool {
    let judged: Vec<bool> = (1..=requirements)
        .filter_map(|requirement| {
            let mut outcomes =
                rows.iter().filter(|row| row.requirement == requirement).filter_map(|row| row.passed).peekable();
            outcomes.peek()?;
            Some(outcomes.any(|passed| passed))
        })
        .collect();
    !judged.is_empty() && judged.iter().all(|passed| *passed)
}

/// Whether a requirement has no number that could be judged.
pub fn lacks_data(rows: &[ValueRow]) -> bool {
    let is_judged = |requirement| rows.iter().any(|row| row.requirement == requirement && row.passed.is_some());
    rows.iter().any(|row| !is_judged(row.requirement))
}

/// Which requirements are met, missed or without numbers, in words.
pub(crate) fn over_values(rows: &[ValueRow], requirements: usize) -> String {
    let words = (1..=requirements).map(|requirement| {
        let own_rows: Vec<&ValueRow> = rows.iter().filter(|row| row.requirement == requirement).collect();
        let mut names: Vec<String> = own_rows.iter().map(|row| named(&row.parameter)).collect();
        names.dedup();
        let names = names.join(" or ");
        let judged: Vec<bool> = own_rows.iter().filter_map(|row| row.passed).collect();
        match judged.as_slice() {
            [] => format!("{names} not judged: no data"),
            some if some.contains(&true) => format!("{names} inside"),
            _ => format!("{names} outside"),
        }
    });
    words.collect::<Vec<_>>().join(", ")
}

/// Values some time after the controls came to rest, and whether they moved the flight's way.
pub(crate) fn at_time(
    measured: &Histories,
    simulated: &Histories,
    rest_s: f64,
    at_s: f64,
    trend: bool,
    requirements: &[Vec<ValueTolerance>],
) -> (Vec<ValueRow>, bool) {
    let sample = |time_s: f64| measured.time_s.partition_point(|&time| time < time_s);
    let at = |histories: &Histories, quantity: Quantity, time_s: f64| match quantity {
        Quantity::Signal(signal) => histories.get(signal).get(sample(time_s)).copied(),
        _ => None,
    };
    let flight = |quantity| at(measured, quantity, rest_s + at_s);
    let model = |quantity| at(simulated, quantity, rest_s + at_s);
    let rows = values(requirements, &flight, &model);
    let moved = |histories: &Histories, signal: Signal| {
        let quantity = Quantity::Signal(signal);
        Some(at(histories, quantity, rest_s + at_s)? - at(histories, quantity, rest_s)?)
    };
    let agrees = |tolerance: &ValueTolerance| match tolerance.quantity {
        Quantity::Signal(signal) => moved(measured, signal)
            .zip(moved(simulated, signal))
            .is_none_or(|(flight, model)| flight.signum() == model.signum()),
        _ => true,
    };
    let agrees = !trend || requirements.iter().flatten().all(agrees);
    let rows_with_trend = rows.into_iter().map(|row| ValueRow {
        tolerance: if trend { format!("{} at {at_s:.0} s, and the same trend", row.tolerance) } else { row.tolerance },
        ..row
    });
    (rows_with_trend.collect(), agrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tolerance(quantity: Quantity, absolute: f64) -> ValueTolerance {
        ValueTolerance { quantity, absolute, of_value: 0.0 }
    }

    #[test]
    fn requirements_are_met_by_any_of_their_numbers_and_left_out_where_nothing_is_known() {
        let requirements = vec![
            vec![tolerance(Quantity::HalfOrDouble, 1.0), tolerance(Quantity::DampingRatio, 0.02)],
            vec![tolerance(Quantity::TrimSurface, 0.01)],
        ];
        let flight = |quantity| match quantity {
            Quantity::HalfOrDouble => Some(10.0),
            Quantity::DampingRatio => Some(0.125),
            _ => None,
        };
        let judged = |half: f64, damping: f64| {
            let model = |quantity| match quantity {
                Quantity::HalfOrDouble => Some(half),
                Quantity::DampingRatio => Some(damping),
                _ => Some(0.0),
            };
            let rows = values(&requirements, &flight, &model);
            assert!(lacks_data(&rows) && !lacks_data(&rows[..2]));
            (met(&rows, 2), over_values(&rows, 2))
        };
        let inside = "time to half or double or damping ratio inside, trim surface not judged: no data";
        assert_eq!(judged(11.0, 0.5), (true, inside.to_owned()));
        assert_eq!(judged(12.0, 0.125 + 0.0625), (false, inside.replace("inside", "outside")));
        assert!(judged(12.0, 0.1251).0);
        // Nothing known is nothing met.
        assert!(!met(&values(&requirements[1..], &flight, &|_| None), 1));
    }

    #[test]
    fn a_value_after_a_time_needs_the_trend_of_the_flight() {
        let time_s: Vec<f64> = (0..300).map(|k| f64::from(k) * 0.1).collect();
        let histories = |bank: &dyn Fn(f64) -> f64| {
            let mut columns: [Vec<f64>; Signal::ALL.len()] = std::array::from_fn(|_| vec![0.0; time_s.len()]);
            columns[Signal::BankAngle as usize] = time_s.iter().map(|&t| bank(t)).collect();
            Histories { time_s: time_s.clone(), columns }
        };
        let requirements = vec![vec![tolerance(Quantity::Signal(Signal::BankAngle), 0.03125)]];
        let judged = |flight: &dyn Fn(f64) -> f64, model: &dyn Fn(f64) -> f64| {
            let (rows, agrees) = at_time(&histories(flight), &histories(model), 4.95, 20.0, true, &requirements);
            (met(&rows, 1), agrees)
        };
        // 25 s is 20 s after rest: 0.5 rad and 0.0025 rad/s to either side.
        let flight = |t: f64| 0.5 + 0.0025 * (t - 5.0);
        assert_eq!(judged(&flight, &flight), (true, true));
        assert_eq!(judged(&flight, &|t| 0.5 + 0.004 * (t - 5.0)), (true, true));
        assert_eq!(judged(&flight, &|t| 0.5 + 0.0045 * (t - 5.0)), (false, true));
        assert_eq!(judged(&flight, &|t| 0.5375 - 0.0005 * (t - 5.0)), (true, false));
        // A record that ends before says nothing.
        let (rows, _) = at_time(&histories(&flight), &histories(&flight), 20.0, 20.0, true, &requirements);
        assert!(rows[0].passed.is_none() && !met(&rows, 1));
    }
}
