//! Lengths of Fourier transforms.

/// Smallest length not below `samples` whose only prime factors are 2 and 3.
pub(super) fn transform_length(samples: usize) -> usize {
    let mut best = samples.next_power_of_two();
    let mut threes = 3;
    while threes < best {
        let length = threes * samples.div_ceil(threes).next_power_of_two();
        best = best.min(length);
        threes *= 3;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_length_is_smooth_and_long_enough() {
        assert_eq!(transform_length(2750), 4 * 729);
        assert_eq!(transform_length(1000), 1024);
        assert_eq!(transform_length(1), 1);
    }
}
