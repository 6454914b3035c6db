//! Measured channels beside the reconstructed path, and the biases over time (thesis Figs. 6.1 to 6.5, B.1 to B.20).

use std::sync::Arc;

use doublet_core::reconstruct::{Measurement, State};
use doublet_core::series::Series;

use super::figure::line;
use super::{Axis, Block, Colour, Contents, Figure, LineStyle, Mark, Panel, Parts, Plot, paragraph};
use crate::notation::{self, significant};
use crate::session::Manoeuvre;
use crate::stage::WindowPath;

/// States that are biases of sensors.
const BIASES: [State; 6] = [State::BiasAx, State::BiasAy, State::BiasAz, State::BiasP, State::BiasQ, State::BiasR];

/// The manoeuvre whose innovations are the largest in the body, the others in the appendix.
pub fn tracks(contents: &Contents<'_>) -> Parts {
    let paths: Vec<(&Manoeuvre, &WindowPath)> = contents
        .session
        .active_windows()
        .filter_map(|window| Some((window, &**contents.snapshot.windows.get(&window.name)?.path.ready()?)))
        .collect();
    let ratio = |path: &WindowPath| path.assessment().consistency.as_ref().map_or(0.0, |found| found.nis_ratio);
    let Some(worst) = paths.iter().max_by(|a, b| ratio(a.1).total_cmp(&ratio(b.1))) else { return Parts::default() };
    let (window, path) = *worst;
    let (name, times) = (&window.name, significant(ratio(path), 3));
    let mut body = vec![paragraph(&match paths.len() {
        1 => format!(
            "The innovations of {name} are {times} times their predicted mean square. The appendix has its biases."
        ),
        _ => format!(
            "Manoeuvre {name} has the largest innovations: {times} times their predicted mean square. The appendix has its biases and all \
             other manoeuvres."
        ),
    })];
    body.extend(with_residuals(window, path).map(Block::Figure));
    let others = paths.iter().filter(|(other, _)| other.name != window.name);
    let others = others.filter_map(|(window, path)| compact(window, path));
    Parts { body, appendix: biases(window, path).into_iter().chain(others).map(Block::Figure).collect() }
}

/// Measurements over the path, each with what is left of it.
fn with_residuals(window: &Manoeuvre, path: &WindowPath) -> Option<Figure> {
    let panels = Measurement::ALL.into_iter().filter_map(|measurement| {
        let channel = channel(measurement, path)?;
        let (unit, scale) = notation::unit(measurement.dimension());
        let series = path.series();
        let left = residual(&series.measured[measurement as usize], &series.reconstructed[measurement as usize]);
        let label = format!("residual of {}", notation::measurement(measurement));
        let marks = vec![line("measured less reconstructed", 1, &left, scale)];
        Some([channel, Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, unit), marks })])
    });
    let panels: Vec<Panel> = panels.flatten().collect();
    (!panels.is_empty()).then(|| {
        Figure::new(
            format!("path {}", window.name),
            format!("Manoeuvre {}: measured channels, reconstructed path, and residuals.", window.name),
            (4, 15.0),
            panels,
        )
        .with_excluded(&window.excluded)
    })
}

/// Biases of the inertial sensors over time.
fn biases(window: &Manoeuvre, path: &WindowPath) -> Option<Figure> {
    let panels = bias_panels(path);
    (!panels.is_empty()).then(|| {
        Figure::new(
            format!("biases {}", window.name),
            format!("Manoeuvre {}: biases of the inertial sensors over time, with their ±2σ band.", window.name),
            (3, 20.0),
            panels,
        )
    })
}

/// Channels and biases of one manoeuvre in little room.
fn compact(window: &Manoeuvre, path: &WindowPath) -> Option<Figure> {
    let channels = Measurement::ALL.into_iter().filter_map(|measurement| channel(measurement, path));
    let panels: Vec<Panel> = channels.chain(bias_panels(path)).collect();
    (!panels.is_empty()).then(|| {
        Figure::new(
            format!("path {}", window.name),
            format!("Manoeuvre {}: measured and reconstructed channels, and biases with their ±2σ band.", window.name),
            (5, 13.0),
            panels,
        )
        .with_excluded(&window.excluded)
    })
}

/// A measurement and what the path makes of it.
fn channel(measurement: Measurement, path: &WindowPath) -> Option<Panel> {
    let series = path.series();
    let (measured, reconstructed) =
        (&series.measured[measurement as usize], &series.reconstructed[measurement as usize]);
    if measured.values.is_empty() || reconstructed.values.is_empty() {
        return None;
    }
    let (unit, scale) = notation::unit(measurement.dimension());
    let dots = Mark::Line {
        label: "measured".into(),
        colour: Colour::by_index(7),
        style: LineStyle::Dots,
        series: measured.clone(),
        scale,
    };
    let marks = vec![dots, line("reconstructed", 0, reconstructed, scale)];
    let label = notation::measurement(measurement);
    Some(Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, unit), marks }))
}

/// Biases that have an uncertainty, smoothed where the path is.
fn bias_panels(path: &WindowPath) -> Vec<Panel> {
    BIASES.into_iter().filter_map(|state| bias_panel(path, state)).collect()
}

fn bias_panel(path: &WindowPath, state: State) -> Option<Panel> {
    let series = path.series();
    let (states, deviations) = match &series.smoothed {
        Some(smoothed) => (&smoothed.states, &smoothed.deviations),
        None => (&series.states, &series.deviations),
    };
    let (found, deviation) = (&states[state as usize], &deviations[state as usize]);
    if deviation.iter().all(|deviation| *deviation == 0.0) {
        return None;
    }
    let (unit, scale) = notation::unit(state.dimension());
    let band = Mark::Band {
        label: "±2σ".into(),
        colour: Colour::by_index(1),
        centre: found.clone(),
        half_width: deviation.iter().map(|deviation| 2.0 * deviation).collect(),
        scale,
    };
    let mut marks = vec![band, line("bias", 0, found, scale)];
    marks.extend(series.truth[state as usize].as_ref().map(|truth| Mark::Line {
        label: "true".into(),
        colour: Colour::by_index(2),
        style: LineStyle::Dashed,
        series: truth.clone(),
        scale,
    }));
    let label = state.name().replace('_', " ");
    Some(Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, unit), marks }))
}

/// Measured less reconstructed, at the times of the measurement within the path.
fn residual(measured: &Series, reconstructed: &Series) -> Series {
    let pairs = measured.time_s.iter().zip(&*measured.values);
    let left: Vec<(f64, f64)> =
        pairs.filter_map(|(&time, value)| Some((time, value - interpolate(reconstructed, time)?))).collect();
    Series {
        time_s: left.iter().map(|(time, _)| *time).collect::<Vec<_>>().into(),
        values: left.iter().map(|(_, value)| *value).collect::<Arc<[f64]>>(),
    }
}

fn interpolate(series: &Series, time_s: f64) -> Option<f64> {
    let (times, values) = (&series.time_s, &series.values);
    let after = times.partition_point(|&time| time < time_s);
    if times.get(after) == Some(&time_s) {
        return values.get(after).copied();
    }
    let before = after.checked_sub(1)?;
    let (from, to) = (*times.get(before)?, *times.get(after)?);
    let (low, high) = (*values.get(before)?, *values.get(after)?);
    Some(low + (high - low) * (time_s - from) / (to - from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_is_taken_at_the_times_of_the_measurement_and_only_within_the_path() {
        let series = |time_s: &[f64], values: &[f64]| Series { time_s: time_s.into(), values: values.into() };
        let path = series(&[0.0, 1.0, 2.0], &[0.0, 10.0, 30.0]);
        let left = residual(&series(&[-0.5, 0.0, 0.5, 1.75, 2.0, 2.5], &[9.0, 1.0, 4.0, 26.0, 30.0, 9.0]), &path);
        assert_eq!(&*left.time_s, [0.0, 0.5, 1.75, 2.0]);
        assert_eq!(&*left.values, [1.0, -1.0, 1.0, 0.0]);
    }
}
