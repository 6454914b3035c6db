//! Bode plots: gain, phase and coherence over the logarithm of frequency.

use doublet_core::statistics::NORMAL_95;
use doublet_dynamics::frequency::{FrequencyResponse, ResponsePoint, TransferFunction};

use nalgebra::Complex;

use super::figure::{points, points_with_bars};
use super::{Axis, Figure, LineStyle, Mark, Panel, Plot};
use crate::notation;
use crate::study::ResponseStudy;

/// A model drawn over a response.
#[derive(Clone, Debug)]
pub struct BodeModel {
    /// What it is, for the legend.
    pub label: String,
    /// Angular frequencies, rad/s, gains, dB, and phases, deg, without jumps.
    pub points: Vec<[f64; 3]>,
}

impl BodeModel {
    /// A transfer function at the frequencies of a response, and what the windows of the response show of it, which it is to be compared with.
    pub fn pair(label: &str, model: &TransferFunction, response: &FrequencyResponse) -> [Self; 2] {
        let turn = if model.gain < 0.0 { 180.0 } else { 0.0 };
        let points = |seen: bool| model_points(model, response, turn, seen);
        let through = format!("{label}, through the windows");
        [Self::aligned(label, points(false), response), Self::aligned(&through, points(true), response)]
    }

    /// Values of a response at the frequencies of another.
    pub(crate) fn of_values(label: &str, values: &[Complex<f64>], response: &FrequencyResponse) -> Self {
        let mut last = None;
        let point = |(found, value): (&ResponsePoint, &Complex<f64>)| {
            let phase = value.arg().to_degrees();
            let phase = phase - 360.0 * last.map_or(0.0, |last: f64| ((phase - last) / 360.0).round());
            last = Some(phase);
            [found.omega_rad_s, 20.0 * value.norm().log10(), phase]
        };
        Self::aligned(label, response.points.iter().zip(values).map(point).collect(), response)
    }

    /// Points of any model, whole turns of the phase such that they lie on the response.
    pub fn aligned(label: &str, mut points: Vec<[f64; 3]>, response: &FrequencyResponse) -> Self {
        let phases = response.phases_rad();
        let measured = response.points.iter().zip(&phases).filter(|(point, _)| point.is_value());
        let apart: Vec<f64> = measured
            .filter_map(|(point, phase)| {
                let nearest = points
                    .iter()
                    .min_by(|a, b| (a[0] - point.omega_rad_s).abs().total_cmp(&(b[0] - point.omega_rad_s).abs()))?;
                Some(phase.to_degrees() - nearest[2])
            })
            .collect();
        let turns = (apart.iter().sum::<f64>() / apart.len().max(1) as f64 / 360.0).round();
        points.iter_mut().for_each(|point| point[2] += 360.0 * turns);
        Self { label: label.to_owned(), points }
    }
}

fn model_points(model: &TransferFunction, response: &FrequencyResponse, turn: f64, seen: bool) -> Vec<[f64; 3]> {
    let point = |found: &ResponsePoint| {
        let omega = found.omega_rad_s;
        let exact = model.at(omega);
        let shown = if seen { found.through_windows(|omega| model.at(omega)) } else { exact };
        let phase = model.phase_rad(omega) + (shown / exact).arg();
        [omega, 20.0 * shown.norm().log10(), phase.to_degrees() + turn]
    };
    response.points.iter().map(point).collect()
}

/// The response of a study to one input with its error bars, models over it, and its coherences.
pub fn bode_figure(study: &ResponseStudy, input: usize, models: &[BodeModel]) -> Option<Figure> {
    let response = study.responses.get(input)?;
    let (name, output) = (study.inputs.get(input)?, &study.output);
    let place = |omega: f64| omega.log10();
    let phases = response.phases_rad();
    let value = |index: usize| response.points[index].is_value();
    let measured = |ordinate: &dyn Fn(usize) -> [f64; 2]| {
        let points = (0..response.points.len()).filter(|&index| value(index)).map(|index| {
            let [at, deviation] = ordinate(index);
            [place(response.points[index].omega_rad_s), at, NORMAL_95 * deviation]
        });
        points_with_bars("measured, with 95 % bars", points)
    };
    let of_models = |ordinate: usize| {
        models.iter().enumerate().map(move |(index, model)| {
            let style = if index == 0 { LineStyle::Solid } else { LineStyle::Dashed };
            let curve = model.points.iter().map(|point| [point[0].log10(), point[ordinate]]);
            points(model.label.clone(), index + 1, style, curve)
        })
    };
    let gains = measured(&|index| [response.points[index].gain_db(), response.points[index].gain_sd_db()]);
    let angles = measured(&|index| [phases[index].to_degrees(), response.points[index].relative_sd.to_degrees()]);
    let coherence = |label: &'static str, colour: usize, style: LineStyle, of: &dyn Fn(usize) -> f64| {
        let curve = (0..response.points.len()).map(|index| [place(response.points[index].omega_rad_s), of(index)]);
        points(label, colour, style, curve)
    };
    let mut coherences = vec![coherence("coherence", 0, LineStyle::Solid, &|index| response.points[index].coherence)];
    if study.inputs.len() > 1 {
        let multiple = |index: usize| response.points[index].multiple_coherence;
        coherences.push(coherence("multiple coherence", 7, LineStyle::Dashed, &multiple));
    }
    let axis = frequency_axis(response);
    let panel = |y: Axis, marks: Vec<Mark>| Panel::Plot(Plot { x: axis.clone(), y, marks });
    let with = |first: Mark, ordinate: usize| std::iter::once(first).chain(of_models(ordinate)).collect();
    let zero_to_one = Axis { range: Some([0.0, 1.0]), ..Axis::new("coherence", "") };
    Some(Figure::new(
        format!("response-{output}-{name}"),
        format!(
            "Frequency response of {} to {}: gain, phase and coherence.",
            notation::role_symbol(output),
            notation::role_symbol(name)
        ),
        (1, 40.0),
        vec![
            panel(Axis::new("gain", "dB"), with(gains, 1)),
            panel(Axis::new("phase", "deg"), with(angles, 2)),
            panel(zero_to_one, coherences),
        ],
    ))
}

/// The logarithm of frequency with its round values.
fn frequency_axis(response: &FrequencyResponse) -> Axis {
    let ends = [response.points.first(), response.points.last()];
    let [low, high] = ends.map(|point| point.map_or(1.0, |point| point.omega_rad_s));
    let room = 1.05;
    let (low, high) = (low / room, (high * room).max(low * room * 1.01));
    let mut places = Vec::new();
    for exponent in low.log10().floor() as i32..=high.log10().ceil() as i32 {
        for digit in [1.0, 2.0, 3.0, 5.0] {
            let value = digit * 10f64.powi(exponent);
            if (low..=high).contains(&value) {
                places.push((value.log10(), format!("{value}")));
            }
        }
    }
    Axis { range: Some([low.log10(), high.log10()]), places, ..Axis::new("frequency", "rad/s") }
}
