//! A signal in a cell of a table: its shape over its whole length, over its own range.

use doublet_core::series::{Decimated, Pyramid, Series, decimate};
use eframe::egui::{Color32, Rect, Stroke, Ui, pos2};

/// A place of the shape, from 0 to 1 along and up.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place(f64, f64);

impl From<[f64; 2]> for Place {
    fn from([along, up]: [f64; 2]) -> Self {
        Self(along, up)
    }
}

/// The shape of a signal, thinned out once.
#[derive(Debug, Default)]
pub struct Sparkline {
    line: Decimated<Place>,
    ends_s: (f64, f64),
}

impl Sparkline {
    /// The shape of `series` in `columns`.
    pub fn new(series: &Series, columns: usize) -> Self {
        let count = series.time_s.len().min(series.values.len());
        let (time_s, values) = (&series.time_s[..count], &series.values[..count]);
        let mut line = Decimated::default();
        let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else { return Self::default() };
        decimate(&Pyramid::new(time_s, values), time_s, values, 1.0, (first, last), columns.max(2), &mut line);
        Self { line, ends_s: (first, last) }
    }

    /// Gaps in it.
    pub fn breaks(&self) -> usize {
        self.line.segments.len().saturating_sub(1)
    }

    /// Draws it into `rect`.
    pub fn paint(&self, ui: &Ui, rect: Rect, color: Color32) {
        let Some((low, high)) = self.line.extent else { return };
        let (length_s, size) = ((self.ends_s.1 - self.ends_s.0).max(1e-9), (high - low).max(1e-300));
        let flat = high - low < 1e-12 * high.abs().max(1e-12);
        for segment in self.line.lines() {
            let at = |place: &Place| {
                let along = ((place.0 - self.ends_s.0) / length_s) as f32;
                let up = if flat { 0.5 } else { ((place.1 - low) / size) as f32 };
                pos2(rect.left() + along * rect.width(), rect.bottom() - up * rect.height())
            };
            ui.painter().line(segment.iter().map(at).collect::<Vec<_>>(), Stroke::new(1.0, color));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_keeps_the_extremes_of_its_signal() {
        let time_s = (0..10_000).map(|k| f64::from(k) * 0.01).collect();
        let values = (0..10_000).map(|k| if k == 4321 { 7.5 } else { (f64::from(k) * 0.01).sin() }).collect();
        let shape = Sparkline::new(&Series { time_s, values }, 60);
        let (low, high) = shape.line.extent.unwrap();
        assert!((low + 1.0).abs() < 1e-3 && high == 7.5);
        assert!(shape.line.points.len() <= 4 * 60, "{}", shape.line.points.len());
        assert!(Sparkline::new(&Series { time_s: [].into(), values: [].into() }, 60).line.points.is_empty());
    }
}
