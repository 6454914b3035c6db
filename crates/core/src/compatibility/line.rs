//! A straight line between two noisy channels, robust against odd samples.

use crate::statistics::{MEDIAN_OF_NORMAL, median};

/// Residuals beyond this many robust deviations count less (Huber).
const HUBER: f64 = 1.5;
/// Residuals beyond this many do not count at all.
const WILD: f64 = 6.0;
/// Least robust deviation, as a part of the deviation of `y`: where hardly anything moves, the manoeuvre is no outlier.
const LEAST_SCALE: f64 = 0.1;
/// Passes of reweighting; the weights settle in three or four.
const PASSES: usize = 6;
/// Fewest pairs a line is fitted to.
pub(super) const FEWEST_PAIRS: usize = 8;

/// `y = slope x + offset` by least squares reweighted after Huber, and how well it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Slope of the reduced major axis, `sign(r) sy / sx`: neither channel is without noise.
    pub slope: f64,
    /// Point it passes through: the means of `x` and `y`, or the origin.
    centre: (f64, f64),
    /// Squared correlation; about zero through the origin.
    pub r2: f64,
    /// Variance of `y - x` about its mean over the mean of both variances: 0 for equality, 4 for opposite signs.
    pub disagreement: f64,
    /// Standard deviation of `x`; root mean square through the origin.
    pub spread_x: f64,
    /// The same of `y`.
    pub spread_y: f64,
    /// Pairs it is fitted to.
    pub pairs: usize,
}

impl Line {
    /// `y` at `x = 0`.
    pub(super) fn intercept(&self) -> f64 {
        self.centre.1 - self.slope * self.centre.0
    }

    /// The line through pairs by ordinary least squares, every pair alike; `None` as for [`Line::through`].
    pub(super) fn of_all(pairs: &[(f64, f64)]) -> Option<Self> {
        if pairs.len() < FEWEST_PAIRS { None } else { Self::weighted(pairs, &vec![1.0; pairs.len()], false) }
    }

    /// The line through pairs `(x, y)`; `None` for fewer than [`FEWEST_PAIRS`] or an `x` that does not move at all.
    pub(super) fn through(pairs: &[(f64, f64)], origin: bool) -> Option<Self> {
        if pairs.len() < FEWEST_PAIRS {
            return None;
        }
        let mut weights = vec![1.0; pairs.len()];
        let mut line = Self::weighted(pairs, &weights, origin)?;
        let least = LEAST_SCALE * line.spread_y;
        for _ in 0..PASSES {
            // About the regression of y on x, which wild values of y turn less than the reduced major axis.
            let regression = line.slope * line.r2.sqrt();
            let (mx, my) = line.centre;
            let mut sizes: Vec<f64> = pairs.iter().map(|(x, y)| (y - my - regression * (x - mx)).abs()).collect();
            let residuals = sizes.clone();
            let scale = (median(&mut sizes)? / MEDIAN_OF_NORMAL).max(least);
            if scale <= f64::MIN_POSITIVE {
                break;
            }
            for (weight, size) in weights.iter_mut().zip(residuals) {
                *weight = if size > WILD * scale { 0.0 } else { (HUBER * scale / size).min(1.0) };
            }
            line = Self::weighted(pairs, &weights, origin)?;
        }
        Some(line)
    }

    fn weighted(pairs: &[(f64, f64)], weights: &[f64], origin: bool) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| {
            pairs.iter().zip(weights).map(|(pair, weight)| weight * of(pair)).sum::<f64>() / total
        };
        let (mx, my) = if origin { (0.0, 0.0) } else { (mean(&|pair| pair.0), mean(&|pair| pair.1)) };
        let (xx, yy) = (mean(&|pair| (pair.0 - mx).powi(2)), mean(&|pair| (pair.1 - my).powi(2)));
        let xy = mean(&|pair| (pair.0 - mx) * (pair.1 - my));
        if !(xx > 0.0 && xx.is_finite() && yy.is_finite()) {
            return None;
        }
        let slope = (yy / xx).sqrt().copysign(xy);
        Some(Self {
            slope,
            centre: (mx, my),
            r2: if yy > 0.0 { xy * xy / (xx * yy) } else { 0.0 },
            disagreement: (xx + yy - 2.0 * xy) / (0.5 * (xx + yy)),
            spread_x: xx.sqrt(),
            spread_y: yy.sqrt(),
            pairs: pairs.len(),
        })
    }
}

/// Numbers of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Figures {
    /// Slope of the channel on what the others say; the gain of a response; the largest value of a size.
    pub slope: f64,
    /// Squared correlation.
    pub r2: f64,
    /// Disagreement as in [`Line`].
    pub disagreement: f64,
    /// Segments that tell.
    pub segments: usize,
    /// Whether the prediction itself varies enough for a slope other than one to be none by chance.
    pub predicted: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(of: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..100).map(|k| f64::from(k) * 0.1).map(|t| (t.sin(), of(t.sin()))).collect()
    }

    #[test]
    fn line_keeps_its_slope_when_a_tenth_of_the_samples_is_wild() {
        let mut pairs = pairs(|x| -57.3 * x + 2.0);
        for k in (0..100).step_by(10) {
            pairs[k].1 += 1000.0;
        }
        let line = Line::through(&pairs, false).unwrap();
        approx::assert_relative_eq!(line.slope, -57.3, max_relative = 0.05);
        assert!(line.r2 > 0.8, "{line:?}");
    }

    #[test]
    fn opposite_channels_disagree_by_four_and_equal_ones_by_nothing() {
        approx::assert_relative_eq!(Line::through(&pairs(|x| -x), false).unwrap().disagreement, 4.0, epsilon = 1e-12);
        approx::assert_abs_diff_eq!(
            Line::through(&pairs(|x| x + 3.0), false).unwrap().disagreement,
            0.0,
            epsilon = 1e-12
        );
        // Through the origin an offset is a disagreement.
        assert!(Line::through(&pairs(|x| x + 3.0), true).unwrap().disagreement > 1.0);
        assert_eq!(Line::through(&pairs(|_| 1.0)[..7], false), None);
        let dead = Line::through(&pairs(|_| 1.0), false).unwrap();
        assert_eq!((dead.slope, dead.r2), (0.0, 0.0), "a channel that rests follows nothing");
    }
}
