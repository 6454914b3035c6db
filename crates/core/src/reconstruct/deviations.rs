//! Standard deviations over a window.

use std::ops::Range;

/// A column of standard deviations: in single precision over a window of more than [`LONG_WINDOW`](crate::series::LONG_WINDOW) samples,
/// where they are a fourth of what it takes. Seven digits are more than is known of any of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Deviations {
    /// Of a short window.
    Double(Vec<f64>),
    /// Of a long one.
    Single(Vec<f32>),
}

impl Deviations {
    /// An empty column with room for `samples`.
    pub(crate) fn with_capacity(samples: usize) -> Self {
        match samples > crate::series::LONG_WINDOW {
            true => Self::Single(Vec::with_capacity(samples)),
            false => Self::Double(Vec::with_capacity(samples)),
        }
    }

    /// `samples` times `value`.
    pub fn constant(value: f64, samples: usize) -> Self {
        let mut column = Self::with_capacity(samples);
        column.extend(std::iter::repeat_n(value, samples));
        column
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Double(values) => values.len(),
            Self::Single(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value at `index`, which must be there.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Self::Double(values) => values[index],
            Self::Single(values) => f64::from(values[index]),
        }
    }

    /// Value at `index`, where there is one.
    pub fn get(&self, index: usize) -> Option<f64> {
        (index < self.len()).then(|| self.at(index))
    }

    /// The last value.
    pub fn last(&self) -> Option<f64> {
        self.get(self.len().checked_sub(1)?)
    }

    /// All values.
    pub fn iter(&self) -> DeviationsIter<'_> {
        DeviationsIter { column: self, left: 0..self.len() }
    }

    /// All values in double precision.
    pub fn to_vec(&self) -> Vec<f64> {
        self.iter().collect()
    }

    /// Appends values.
    pub(crate) fn extend(&mut self, added: impl Iterator<Item = f64>) {
        match self {
            Self::Double(values) => values.extend(added),
            Self::Single(values) => values.extend(added.map(|value| value as f32)),
        }
    }

    /// Puts `value` at `index`, which must be there.
    pub fn set(&mut self, index: usize, value: f64) {
        match self {
            Self::Double(values) => values[index] = value,
            Self::Single(values) => values[index] = value as f32,
        }
    }
}

impl From<Vec<f64>> for Deviations {
    fn from(values: Vec<f64>) -> Self {
        Self::Double(values)
    }
}

impl<'a> IntoIterator for &'a Deviations {
    type Item = f64;
    type IntoIter = DeviationsIter<'a>;

    fn into_iter(self) -> DeviationsIter<'a> {
        self.iter()
    }
}

/// Values of [`Deviations`].
#[derive(Clone, Debug)]
pub struct DeviationsIter<'a> {
    column: &'a Deviations,
    left: Range<usize>,
}

impl Iterator for DeviationsIter<'_> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        self.left.next().map(|index| self.column.at(index))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.left.size_hint()
    }
}

impl ExactSizeIterator for DeviationsIter<'_> {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::LONG_WINDOW;

    #[test]
    fn long_columns_keep_seven_digits_and_short_ones_all() {
        let value = |k: usize| 1e-3 + (k as f64).sqrt();
        for (samples, rounding) in [(LONG_WINDOW, 0.0), (LONG_WINDOW + 1, 6e-8)] {
            let mut column = Deviations::with_capacity(samples);
            column.extend((0..samples).map(value));
            column.set(3, f64::NAN);
            assert_eq!((column.len(), column.iter().len()), (samples, samples));
            assert!(column.at(3).is_nan() && column.get(samples).is_none());
            let exact = |(k, found): (usize, f64)| k == 3 || (found / value(k) - 1.0).abs() <= rounding;
            assert!(column.iter().enumerate().all(exact), "{samples}");
            assert_eq!(column.last(), Some(column.at(samples - 1)));
        }
        assert_eq!(Deviations::constant(0.5, 2), Deviations::from(vec![0.5, 0.5]));
        assert!(Deviations::with_capacity(5).is_empty() && Deviations::with_capacity(5).last().is_none());
    }
}
