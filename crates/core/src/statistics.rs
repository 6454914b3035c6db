//! Order statistics, sums of squares and autocorrelation.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Median of the absolute values of a normal variable, in deviations of it.
pub const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// Half width of the 95 % interval of a normal variable, in deviations of it.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Element `rank` (from 0) of `values` in ascending order; `values` are reordered. `None` where there are not as many.
pub fn ranked(values: &mut [f64], rank: usize) -> Option<f64> {
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// Median, the upper one of an even number; `values` are reordered. `None` of none.
pub fn median(values: &mut [f64]) -> Option<f64> {
    ranked(values, values.len() / 2)
}

/// Least and greatest of the finite values; `None` of none.
pub fn extent<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<[f64; 2]> {
    let finite = values.into_iter().copied().filter(|value| value.is_finite());
    finite.fold(None, |ends: Option<[f64; 2]>, value| {
        Some(ends.map_or([value; 2], |[least, greatest]| [least.min(value), greatest.max(value)]))
    })
}

/// Sum of the squares of `values` about their mean; zero of none.
pub fn squares_about_mean(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

/// Factor on a standard error from the scatter of `count` values with which two of them hold 95 %: half the quantile of Student's
/// distribution with `count - 1` degrees of freedom. `None` below two values.
pub fn student_widening(count: usize) -> Option<f64> {
    let freedom = count.checked_sub(1)?;
    Some(0.5 * StudentsT::new(0.0, 1.0, freedom as f64).ok()?.inverse_cdf(0.975))
}

/// Samples per second of an increasing time vector between its gaps: by the mean of the intervals up to one and a half times their median.
/// `None` with fewer than two samples.
pub fn sample_rate_hz(time: &[f64]) -> Option<f64> {
    let usual = 1.5 * median_step(time)?;
    let steps = time.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step <= usual);
    let (sum, count) = steps.fold((0.0, 0_usize), |(sum, count), step| (sum + step, count + 1));
    (sum > 0.0).then(|| count as f64 / sum)
}

/// Median interval of an increasing time vector; `None` with fewer than two samples.
pub fn median_step(time: &[f64]) -> Option<f64> {
    median(&mut time.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>())
}

/// Quantile of values in ascending order, straight between them; not a number of none.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = share * last as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// Autocorrelation at lags 1 to `lags`: `rho(k) = sum (v_i - m)(v_(i+k) - m) / sum (v_i - m)^2`; zero of what does not vary. One
/// pass for each lag; for many lags of long records see [`crate::estimate::autocorrelation`], which goes by Fourier transforms.
pub fn autocorrelation(values: &[f64], lags: usize) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let power: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    if power <= 0.0 {
        return vec![0.0; lags];
    }
    let lagged = |lag: usize| values.iter().zip(&values[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    (1..=lags.min(values.len().saturating_sub(1))).map(|lag| lagged(lag) / power).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_of_samples_is_that_between_the_gaps() {
        // 30 Hz in whole milliseconds, twice, an hour apart.
        let stretch = |start_s: f64| (0..301).map(move |k| start_s + (f64::from(k) / 0.03).round() / 1e3);
        let time: Vec<f64> = stretch(0.0).chain(stretch(3600.0)).collect();
        assert!((sample_rate_hz(&time).unwrap() - 30.0).abs() < 1e-9);
        assert_eq!(sample_rate_hz(&[1.0]), None);
    }

    #[test]
    fn order_statistics_match_sorted_values() {
        let values = [3.0, -1.0, 7.0, 2.0];
        let rank = |rank: usize| ranked(&mut values.clone(), rank);
        assert_eq!([rank(0), rank(1), rank(3), rank(4)], [Some(-1.0), Some(2.0), Some(7.0), None]);
        assert_eq!((median(&mut values.clone()), median(&mut [])), (Some(3.0), None));
        assert_eq!((median_step(&[0.0, 1.0, 2.0, 9.0]), median_step(&[4.0])), (Some(1.0), None));
        assert_eq!(quantile(&[0.0, 1.0, 2.0, 4.0], 0.5), 1.5);
    }

    #[test]
    fn autocorrelation_of_an_alternating_signal_alternates() {
        // 1, -1, 1, -1: sums of products over the four squares.
        assert_eq!(autocorrelation(&[1.0, -1.0, 1.0, -1.0], 2), [-0.75, 0.5]);
        assert_eq!(autocorrelation(&[2.0; 5], 3), [0.0; 3]);
    }
}
