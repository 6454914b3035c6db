//! Ticks of axes and their labels.

/// Height of the labels under an axis.
pub const UNDER: f64 = 10.0;
/// Height of the name under the last axis of a column.
pub const TITLE_UNDER: f64 = 10.0;

/// A stretch of values, and where ticks lie in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    pub values: Vec<f64>,
    /// Distance between them.
    pub step: f64,
    /// Labels are values over this power of ten.
    pub exponent: i32,
}

/// First digits of round steps.
pub const ROUND: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// The smallest of `digits` times a power of ten that is not less than `least`.
pub fn step_of(digits: &[f64], least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    digits.iter().map(|m| m * decade).find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(least)
}

/// The multiples of `step` from `low` to `high`, a thousand at most.
pub fn multiples([low, high]: [f64; 2], step: f64) -> Vec<f64> {
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let count = (last - first).clamp(-1.0, 1000.0) as i64 + 1;
    (0..count).map(|k| (first + k as f64) * step).collect()
}

/// Text of a tick: as many decimals as ticks `step` apart need.
pub fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    let text = if is_zero { text.replace('-', "") } else { text };
    text.replace('-', "\u{2212}")
}

/// About `most` ticks from `low` to `high`, powers of ten times 1, 2 or 5 apart; two at least, for one tells no scale.
pub fn ticks([low, high]: [f64; 2], most: usize) -> Ticks {
    let mut step = step_of(&ROUND, (high - low) / most.max(1) as f64);
    let mut values = multiples([low, high], step);
    if values.len() < 2 {
        step = step_of(&ROUND, 0.4 * step);
        values = multiples([low, high], step);
    }
    let largest = low.abs().max(high.abs());
    let exponent = if (1e-2..1e5).contains(&largest) { 0 } else { 3 * (largest.log10() / 3.0).floor() as i32 };
    Ticks { values, step, exponent }
}

impl Ticks {
    /// Text of a tick, over the power of ten.
    pub fn label(&self, value: f64) -> String {
        let scale = 10f64.powi(self.exponent);
        tick_label(value / scale, self.step / scale)
    }

    /// What the labels are to be multiplied by, to put behind the name of the axis; empty for one.
    pub fn factor(&self) -> String {
        if self.exponent == 0 {
            return String::new();
        }
        let exponent = self.exponent.to_string();
        let digits = exponent.chars().map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        });
        format!(" ×10{}", digits.collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_few_and_inside() {
        for (range, most) in [([0.0, 219.99], 5), ([-1.2, 1.2], 4), ([5000.0, 5000.5], 3), ([1e-5, 3e-5], 4)] {
            let found = ticks(range, most);
            assert!((1..=most + 1).contains(&found.values.len()), "{found:?}");
            let digits = found.step / 10f64.powf(found.step.log10().floor());
            assert!([1.0, 2.0, 5.0].iter().any(|m| (digits - m).abs() < 1e-6), "{found:?}");
            assert!(found.values.iter().all(|v| (range[0] - 1e-9..=range[1] + 1e-9).contains(v)), "{found:?}");
        }
    }

    #[test]
    fn labels_read_back_to_their_ticks() {
        for range in [[-3e-4, 2e-4], [0.0, 7e6], [-0.05, 0.05], [12.0, 14.0]] {
            let found = ticks(range, 4);
            for &value in &found.values {
                let text = found.label(value).replace('\u{2212}', "-");
                let back = text.parse::<f64>().unwrap() * 10f64.powi(found.exponent);
                assert!((back - value).abs() < 1e-6 * found.step, "{value} is written {text}");
            }
        }
        assert_eq!(ticks([-3e-4, 2e-4], 4).factor(), " ×10⁻⁶");
    }
}
