//! Charts of spectra: density over frequency, both logarithmic.

use doublet_core::prep::Spectrum;
use eframe::egui::Color32;

use super::chart::{Chart, ChartCurve, ChartStyle};

/// Frequencies named under a spectrum, Hz.
const DECADES_HZ: [f64; 6] = [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0];
/// Part of the highest frequency below which numbers stand: a number in the corner would lose its last digits.
const CORNER: f64 = 0.9;

/// Places of the frequency axis with their numbers, from the lowest of some frequencies to the highest.
fn decades(frequency_hz: &[f64]) -> Vec<(f64, String)> {
    let [lowest_hz, highest_hz] = [frequency_hz.first(), frequency_hz.last()].map(|hz| hz.copied().unwrap_or(0.0));
    let inside = DECADES_HZ.iter().filter(|hz| (lowest_hz..CORNER * highest_hz).contains(*hz));
    inside.map(|hz| (hz.log10(), format!("{hz}"))).collect()
}

pub fn density_unit(unit: &str) -> String {
    if unit.is_empty() { "1/Hz".to_owned() } else { format!("({unit})²/Hz") }
}

/// The curve of a spectrum whose signal is drawn `scale` times as large.
pub fn spectrum_curve(name: &str, spectrum: &Spectrum, scale: f64, color: Color32) -> ChartCurve {
    let pairs = spectrum.frequency_hz.iter().zip(&spectrum.density).filter(|(_, density)| **density > 0.0);
    let points = pairs.map(|(hz, density)| [hz.log10(), (scale * scale * density).log10()]);
    ChartCurve::new(name, color, ChartStyle::Line, points.collect())
}

/// The 95 % bounds of white noise of the same power.
pub fn white_bounds(spectrum: &Spectrum, scale: f64, color: Color32) -> Vec<ChartCurve> {
    let ends =
        [spectrum.frequency_hz.first(), spectrum.frequency_hz.last()].map(|hz| hz.map_or(f64::NAN, |hz| hz.log10()));
    let edge = |(density, name): (f64, &str)| {
        let level = (scale * scale * density).log10();
        ChartCurve::new(name, color, ChartStyle::Dashed, vec![[ends[0], level], [ends[1], level]])
    };
    let [low, high] = spectrum.white_band();
    [(low, "95 % of white noise"), (high, "")].map(edge).into()
}

/// A chart for spectra of some frequencies.
pub fn spectrum_chart(name: &str, frequency_hz: &[f64], unit: &str) -> Chart {
    let mut chart = Chart::new(name, "frequency [Hz]", format!("log₁₀ density [{}]", density_unit(unit)));
    chart.places = decades(frequency_hz);
    chart
}
