//! Wing panels and the mean aerodynamic chord.

use serde::Deserialize;

/// A wing panel of constant taper. Stations are in datum axes, m.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "names say it")]
pub struct WingPanel {
    pub name: String,
    pub root_y_m: f64,
    /// Distance along y from root to tip.
    pub semispan_m: f64,
    pub root_chord_m: f64,
    /// Tip chord over root chord.
    pub taper: f64,
    pub root_leading_edge_x_m: f64,
    pub tip_leading_edge_x_m: f64,
}

/// A mean aerodynamic chord and where it lies. Stations are in datum axes, m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanChord {
    /// x of its leading edge.
    pub leading_edge_x_m: f64,
    /// y at which the wing has it.
    pub y_m: f64,
    /// Its length.
    pub chord_m: f64,
}

impl WingPanel {
    /// Area, m²: `(b/2) c_r (1 + taper) / 2`.
    pub fn area_m2(&self) -> f64 {
        self.semispan_m * self.root_chord_m * (1.0 + self.taper) / 2.0
    }

    /// Mean aerodynamic chord of this panel.
    ///
    /// `c = 2/3 c_r (1 + t + t^2) / (1 + t)`, `x = x_r + (x_t - x_r) k`, `y = y_r + (b/2) k` with `k = (1 + 2 t) / (3 + 3 t)`
    /// and taper t (thesis Eq. 5.1-5.2).
    pub fn mean_chord(&self) -> MeanChord {
        let t = self.taper;
        let k = (1.0 + 2.0 * t) / (3.0 + 3.0 * t);
        MeanChord {
            leading_edge_x_m: self.root_leading_edge_x_m + (self.tip_leading_edge_x_m - self.root_leading_edge_x_m) * k,
            y_m: self.root_y_m + self.semispan_m * k,
            chord_m: 2.0 / 3.0 * self.root_chord_m * (1.0 + t + t * t) / (1.0 + t),
        }
    }
}

impl MeanChord {
    /// Position along this chord of a station x (m from the datum), as a fraction: 0 at the leading edge, 1 at the
    /// trailing edge.
    pub fn fraction(&self, x_from_datum_m: f64) -> f64 {
        (x_from_datum_m - self.leading_edge_x_m) / self.chord_m
    }
}

/// Mean aerodynamic chord of a wing of any number of panels: the mean of the panels' weighted by area (thesis Eq. 5.1).
///
/// Exact for panels of constant taper, as `2/S` times the integral of `c^2`, `x c` and `y c` over the half span. `None` for
/// no panels or an area that is not positive.
pub fn mean_aerodynamic_chord(panels: &[WingPanel]) -> Option<MeanChord> {
    let area: f64 = panels.iter().map(WingPanel::area_m2).sum();
    if area.is_nan() || area <= 0.0 {
        return None;
    }
    let mut mean = MeanChord { leading_edge_x_m: 0.0, y_m: 0.0, chord_m: 0.0 };
    for panel in panels {
        let weight = panel.area_m2() / area;
        let chord = panel.mean_chord();
        mean.leading_edge_x_m += weight * chord.leading_edge_x_m;
        mean.y_m += weight * chord.y_m;
        mean.chord_m += weight * chord.chord_m;
    }
    Some(mean)
}
