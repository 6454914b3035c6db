//! Limits of the centre of gravity over mass.

use serde::Deserialize;

/// Forward and aft limit of the centre of gravity at one mass.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvelopeRow {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Forward limit, x from the datum, m.
    pub forward_x_m: f64,
    /// Aft limit, x from the datum, m.
    pub aft_x_m: f64,
}

/// Limits of the centre of gravity: rows of increasing mass, straight in between.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// Rows, lightest first.
    pub rows: Vec<EnvelopeRow>,
}

/// A side of the envelope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvelopeSide {
    /// Forward limit of the centre of gravity.
    Forward,
    /// Aft limit of the centre of gravity.
    Aft,
}

impl std::fmt::Display for EnvelopeSide {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Forward => "forward",
            Self::Aft => "aft",
        })
    }
}

/// Where a loading lies in the envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvelopeMargin {
    /// Distance of the centre of gravity behind the forward limit, m; negative outside.
    pub forward_m: f64,
    /// Distance of the centre of gravity ahead of the aft limit, m; negative outside.
    pub aft_m: f64,
    /// Mass up to the heaviest row, kg; negative outside.
    pub heavy_kg: f64,
    /// Mass above the lightest row, kg; negative outside.
    pub light_kg: f64,
    /// Nearer of the two limits.
    pub side: EnvelopeSide,
    /// Corner of that side nearest in mass: its mass (kg) and x from the datum (m).
    pub corner: (f64, f64),
}

impl EnvelopeMargin {
    /// Whether the loading lies inside the envelope, its edge included.
    pub fn inside(&self) -> bool {
        self.nearest_m() >= 0.0 && self.heavy_kg >= 0.0 && self.light_kg >= 0.0
    }

    /// Distance to the nearer limit of the centre of gravity, m; negative outside.
    pub fn nearest_m(&self) -> f64 {
        self.forward_m.min(self.aft_m)
    }
}

impl Envelope {
    /// Forward and aft limit at a mass (kg), x from the datum, m: straight between rows, held beyond the first and the last.
    /// `None` without rows.
    pub(crate) fn limits_at(&self, mass_kg: f64) -> Option<(f64, f64)> {
        let (first, last) = (self.rows.first()?, self.rows.last()?);
        let upper = self.rows.partition_point(|row| row.mass_kg < mass_kg);
        if upper == 0 {
            return Some((first.forward_x_m, first.aft_x_m));
        }
        let Some(above) = self.rows.get(upper) else {
            return Some((last.forward_x_m, last.aft_x_m));
        };
        let below = &self.rows[upper - 1];
        let t = (mass_kg - below.mass_kg) / (above.mass_kg - below.mass_kg);
        let between = |a: f64, b: f64| a + t * (b - a);
        Some((between(below.forward_x_m, above.forward_x_m), between(below.aft_x_m, above.aft_x_m)))
    }

    /// Margins of a mass (kg) with its centre of gravity at x (m from the datum); `None` without rows.
    pub fn margin(&self, mass_kg: f64, x_from_datum_m: f64) -> Option<EnvelopeMargin> {
        let (forward, aft) = self.limits_at(mass_kg)?;
        let (forward_m, aft_m) = (x_from_datum_m - forward, aft - x_from_datum_m);
        let side = if forward_m <= aft_m { EnvelopeSide::Forward } else { EnvelopeSide::Aft };
        let nearest =
            self.rows.iter().min_by(|a, b| (a.mass_kg - mass_kg).abs().total_cmp(&(b.mass_kg - mass_kg).abs()))?;
        let corner_x = match side {
            EnvelopeSide::Forward => nearest.forward_x_m,
            EnvelopeSide::Aft => nearest.aft_x_m,
        };
        Some(EnvelopeMargin {
            forward_m,
            aft_m,
            heavy_kg: self.rows.last()?.mass_kg - mass_kg,
            light_kg: mass_kg - self.rows.first()?.mass_kg,
            side,
            corner: (nearest.mass_kg, corner_x),
        })
    }

    /// Outline as (x from the datum in m, mass in kg), down the forward limit's heaviest corner and round: for drawing.
    pub fn outline(&self) -> Vec<(f64, f64)> {
        let forward = self.rows.iter().rev().map(|row| (row.forward_x_m, row.mass_kg));
        let aft = self.rows.iter().map(|row| (row.aft_x_m, row.mass_kg));
        forward.chain(aft).collect()
    }
}
