//! Evenly sampled records of inputs and one output.

use super::FrequencyError;

/// One manoeuvre or record: inputs and output at the same evenly spaced instants.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyRecord {
    /// Time step, s.
    pub step_s: f64,
    /// Inputs, each with as many samples as the output.
    pub inputs: Vec<Vec<f64>>,
    /// Output.
    pub output: Vec<f64>,
}

impl FrequencyRecord {
    /// Length, s: samples times step.
    pub fn length_s(&self) -> f64 {
        self.output.len() as f64 * self.step_s
    }

    /// Input or output by number, the output behind the inputs.
    pub(super) fn signal(&self, index: usize) -> &[f64] {
        self.inputs.get(index).unwrap_or(&self.output)
    }
}

/// Largest value of a signal: cross-spectra are squared, which overflows beyond `1e77`.
const LARGEST: f64 = 1e60;

/// Number of inputs of the records.
///
/// # Errors
/// Records without samples, of different inputs, lengths or not finite values.
pub(super) fn check(records: &[FrequencyRecord]) -> Result<usize, FrequencyError> {
    let Some(first) = records.first() else { return Err(FrequencyError::NoRecord) };
    for (index, record) in records.iter().enumerate() {
        let fault = |what: String| Err(FrequencyError::Record { record: index + 1, what });
        if record.inputs.is_empty() || record.inputs.len() != first.inputs.len() {
            return fault(format!(
                "{} inputs, {} in the first: give each the same",
                record.inputs.len(),
                first.inputs.len()
            ));
        }
        if let Some(input) = record.inputs.iter().find(|input| input.len() != record.output.len()) {
            return fault(format!("an input has {} samples, the output {}", input.len(), record.output.len()));
        }
        if !(record.step_s > 0.0 && record.step_s.is_finite()) {
            return fault(format!("a time step of {} s: it is above 0 s", record.step_s));
        }
        let signals = record.inputs.iter().chain([&record.output]);
        if signals.flatten().any(|value| !value.is_finite()) {
            return fault("a value is not finite: leave out that part".to_owned());
        }
        let signals = record.inputs.iter().chain([&record.output]);
        if let Some(value) = signals.flatten().find(|value| value.abs() > LARGEST) {
            return fault(format!("a value of {value:e} is above {LARGEST:e}: use a larger unit"));
        }
        if record.output.len() < 2 {
            return fault(format!("{} samples", record.output.len()));
        }
    }
    Ok(first.inputs.len())
}

/// `count` angular frequencies from `low` to `high`, rad/s, each the same factor above the one before.
pub fn logarithmic_grid(low: f64, high: f64, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|k| low * (high / low).powf(k as f64 / last)).collect()
}
