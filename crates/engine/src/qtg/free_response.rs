//! Period and damping of the free response of flight and model.

use doublet_core::validate::{Histories, Signal};
use doublet_dynamics::modes::measured::{Oscillation, Read, ReadError, read};

use super::ValueRow;
use crate::stage::Quantity;

/// One number of flight and model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub quantity: Quantity,
    pub flight: Option<Read>,
    pub model: Option<Read>,
}

/// The free response of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeResponse {
    /// Period, damping, time to half or double and, where asked for, the lag of two signals.
    pub pairs: Vec<Pair>,
    /// Cycles in the record, by the flight's period; none where it cannot be read.
    pub cycles: Option<f64>,
    /// Why flight or model tell no oscillation, one line each.
    pub unread: Vec<String>,
}

/// Reads `signal` of flight and model between two times, and the lag from the peaks of the first signal of `lag` to those of the second.
pub(crate) fn free_response(
    measured: &Histories,
    simulated: &Histories,
    span_s: [f64; 2],
    signal: Signal,
    lag: Option<[Signal; 2]>,
) -> FreeResponse {
    let flight = part(measured, span_s, signal);
    let model = part(simulated, span_s, signal);
    let ok = |found: &Result<Oscillation, ReadError>, of: fn(&Oscillation) -> Read| found.as_ref().ok().map(of);
    let pair = |quantity, of| Pair { quantity, flight: ok(&flight, of), model: ok(&model, of) };
    let mut pairs = vec![
        pair(Quantity::Period, Oscillation::period_s),
        pair(Quantity::DampingRatio, Oscillation::damping_ratio),
        pair(Quantity::HalfOrDouble, Oscillation::half_s),
    ];
    pairs.extend(lag.map(|signals| Pair {
        quantity: Quantity::PeakLag,
        flight: read_lag(measured, span_s, &flight, signals),
        model: read_lag(simulated, span_s, &model, signals),
    }));
    let unread = [("flight", &flight), ("model", &model)];
    let unread = unread.iter().filter_map(|(whose, found)| Some(format!("{whose}: {}", found.as_ref().err()?)));
    FreeResponse { pairs, cycles: flight.as_ref().ok().map(|oscillation| oscillation.cycles), unread: unread.collect() }
}

fn read_lag(
    histories: &Histories,
    span_s: [f64; 2],
    found: &Result<Oscillation, ReadError>,
    [first, second]: [Signal; 2],
) -> Option<Read> {
    let oscillation = found.as_ref().ok()?;
    let (time_s, first) = between(histories, span_s, first);
    let (_, second) = between(histories, span_s, second);
    let value = oscillation.lag_s(time_s, first, second).ok()?;
    Some(Read { value, standard_error: f64::NAN })
}

/// Samples between two times.
fn between(histories: &Histories, [from_s, to_s]: [f64; 2], signal: Signal) -> (&[f64], &[f64]) {
    let place = |time_s: f64| histories.time_s.partition_point(|&time| time < time_s);
    let range = place(from_s)..place(to_s).max(place(from_s));
    (histories.time_s.get(range.clone()).unwrap_or_default(), histories.get(signal).get(range).unwrap_or_default())
}

fn part(histories: &Histories, span_s: [f64; 2], signal: Signal) -> Result<Oscillation, ReadError> {
    let (time_s, values) = between(histories, span_s, signal);
    read(time_s, values)
}

/// Rows of the numbers, judged by nothing.
pub fn rows(response: &FreeResponse) -> Vec<ValueRow> {
    let error = |read: Option<Read>| read.map(|read| read.standard_error).filter(|error| error.is_finite());
    response
        .pairs
        .iter()
        .filter(|pair| pair.flight.is_some() || pair.model.is_some())
        .map(|pair| ValueRow {
            requirement: 0,
            parameter: pair.quantity.name().to_owned(),
            tolerance: String::new(),
            unit: pair.quantity.dimension().si_symbol(),
            flight: pair.flight.map(|read| read.value),
            flight_error: error(pair.flight),
            model: pair.model.map(|read| read.value),
            model_error: error(pair.model),
            passed: None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Histories whose yaw rate, bank and sideslip are damped cosines of one period, the sideslip later than the bank.
    fn histories(period_s: f64, damping: f64, lag_s: f64) -> Histories {
        let frequency = std::f64::consts::TAU / period_s;
        let decay = damping * frequency / (1.0 - damping * damping).sqrt();
        let time_s: Vec<f64> = (0..1000).map(|k| 50.0 + f64::from(k) * 0.02).collect();
        let mut columns: [Vec<f64>; Signal::ALL.len()] = std::array::from_fn(|_| vec![0.0; time_s.len()]);
        let mut set = |signal: Signal, lag_s: f64| {
            let value = |t: f64| 0.1 * (-decay * (t - 50.0)).exp() * (frequency * (t - 50.0 - lag_s)).cos();
            columns[signal as usize] = time_s.iter().map(|&t| value(t)).collect();
        };
        set(Signal::YawRate, 0.0);
        set(Signal::BankAngle, 0.0);
        set(Signal::Sideslip, lag_s);
        Histories { time_s, columns }
    }

    #[test]
    fn both_are_read_from_the_end_of_the_input_on() {
        let (flight, model) = (histories(4.5, 0.14, 0.8), histories(4.7, 0.12, 0.9));
        let lag = Some([Signal::BankAngle, Signal::Sideslip]);
        let found = free_response(&flight, &model, [55.0, 69.0], Signal::YawRate, lag);
        assert!(found.unread.is_empty());
        assert!((found.cycles.unwrap() - (69.0 - 55.0) / 4.5).abs() < 0.01);
        let expected = [(4.5, 4.7), (0.14, 0.12), (f64::NAN, f64::NAN), (0.8, 0.9)];
        for (pair, (flight, model)) in found.pairs.iter().zip(expected).filter(|(_, (value, _))| value.is_finite()) {
            let (f, m) = (pair.flight.unwrap().value, pair.model.unwrap().value);
            assert!((f - flight).abs() < 1e-5 && (m - model).abs() < 1e-5, "{pair:?}");
        }
        // A model that does not oscillate is said not to.
        let mut still = model;
        still.columns[Signal::YawRate as usize].fill(0.0);
        let found = free_response(&flight, &still, [55.0, 69.0], Signal::YawRate, None);
        assert_eq!(found.unread.len(), 1);
        assert!(found.unread[0].starts_with("model: ") && found.pairs.iter().all(|pair| pair.model.is_none()));
        assert_eq!(rows(&found).len(), 3);
    }
}
