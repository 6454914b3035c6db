//! White noise of a series from its second differences, for a flight that is never still.

use std::f64::consts::{PI, TAU};

use crate::series::Series;
use crate::statistics::{median, median_step};

/// Second differences of a block.
const BLOCK: usize = 64;
/// Blocks below which nothing is said.
const LEAST_BLOCKS: usize = 5;
/// Part of successive samples that are equal from which a channel holds its samples.
const HELD: f64 = 0.5;
/// Part by which the spacing of the samples of one difference may be off the usual one.
const UNEVEN: f64 = 0.2;

/// Standard deviation of the white noise of `series`. With the second differences `d_m = x(k + m) - 2 x(k) + x(k - m)` white noise
/// sigma and a random walk of variance q a sample give `E[d_1^2] = 6 sigma^2 + 2 q`, `E[d_2^2] = 6 sigma^2 + 4 q`, and a smooth motion
/// little at either, so that `sigma^2 = (2 E[d_1^2] - E[d_2^2]) / 6`; the median over blocks leaves manoeuvres out. Changes of an angle
/// are taken within half a turn. `None` where samples are held, blocks are too few, or the motion between samples hides the noise.
pub fn white_noise_deviation(series: &Series, is_angle: bool) -> Option<f64> {
    let finite = series.finite();
    let (time, values) = (&finite.time_s, &finite.values);
    let usual = median_step(time)?;
    let equal = values.windows(2).filter(|pair| pair[0] == pair[1]).count();
    if equal as f64 > HELD * (time.len() - 1) as f64 {
        return None;
    }
    let change = |from: usize, to: usize| {
        let change = values[to] - values[from];
        if is_angle { (change + PI).rem_euclid(TAU) - PI } else { change }
    };
    let is_even = |k: usize| (time[k + 2] - time[k - 2] - 4.0 * usual).abs() < UNEVEN * usual;
    let square = |k: usize, m: usize| (change(k, k + m) + change(k, k - m)).powi(2);
    let last = values.len().checked_sub(2)?;
    let squares: Vec<[f64; 2]> = (2..last).filter(|k| is_even(*k)).map(|k| [square(k, 1), square(k, 2)]).collect();
    let of_block = |block: &[[f64; 2]]| {
        let mean = |i: usize| block.iter().map(|squares| squares[i]).sum::<f64>() / block.len() as f64;
        (2.0 * mean(0) - mean(1)) / 6.0
    };
    let mut variances: Vec<f64> = squares.chunks_exact(BLOCK).map(of_block).collect();
    if variances.len() < LEAST_BLOCKS {
        return None;
    }
    let variance = median(&mut variances)?;
    (variance > 0.0).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;

    /// White noise of 0.3 beside a random walk and a motion of 0.3 Hz: found within 5 %, where successive differences give twice as much.
    #[test]
    fn white_noise_is_found_beside_a_random_walk_and_a_motion() {
        use rand::RngExt;

        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut normal = || (0..12).map(|_| random.random_range(0.0..1.0)).sum::<f64>() - 6.0;
        let mut walk = 0.0;
        let time_s: Vec<f64> = (0..10_000).map(|k| 0.02 * f64::from(k)).collect();
        let mut values = Vec::new();
        for time in &time_s {
            walk += 0.3 * normal();
            values.push(5.0 * (TAU * 0.3 * time).sin() + walk + 0.3 * normal());
        }
        let series = Series { time_s: time_s.into(), values: values.into() };
        let found = white_noise_deviation(&series, false).unwrap();
        assert!((found / 0.3 - 1.0).abs() < 0.05, "{found}");
    }
}
