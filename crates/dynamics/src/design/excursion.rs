//! How far the aircraft goes from its trim, and how far it may.

use super::fly::FlownInput;
use super::signal::CONTROLS;
use crate::linear::Trim;

/// A quantity whose excursion is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Angle of attack, rad.
    Alpha,
    /// Angle of sideslip, rad.
    Beta,
    /// Load factor, specific force along body z over gravity, positive upwards.
    LoadFactor,
    /// Roll rate, rad/s.
    RollRate,
    /// True airspeed, m/s.
    Airspeed,
    /// Altitude, m: that of the trim and what is gained or lost since the start of the window, wherever that was.
    Altitude,
    /// Bank angle, rad.
    Bank,
}

impl Quantity {
    doublet_core::named_variants! {
        /// Name in files and tables.
        pub name: Alpha "alpha", Beta "beta", LoadFactor "n_z", RollRate "p", Airspeed "V", Altitude "h", Bank "phi"
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Alpha | Self::Beta | Self::Bank => "rad",
            Self::LoadFactor => "-",
            Self::RollRate => "rad/s",
            Self::Airspeed => "m/s",
            Self::Altitude => "m",
        }
    }

    /// Its values over a flight about a trim.
    pub fn values<'a>(self, flown: &'a FlownInput, trim: &'a Trim) -> impl Iterator<Item = f64> + 'a {
        let gravity_m_s2 = trim.condition.gravity_m_s2;
        let lift_m = trim.condition.altitude_m - flown.states.first().map_or(0.0, |state| state[11]);
        (0..flown.time_s.len()).map(move |k| match self {
            Self::Alpha => flown.air[k][1],
            Self::Beta => flown.air[k][2],
            Self::LoadFactor => -flown.specific_force_m_s2[k][2] / gravity_m_s2,
            Self::RollRate => flown.states[k][3],
            Self::Airspeed => flown.air[k][0],
            Self::Altitude => flown.states[k][11] + lift_m,
            Self::Bank => flown.states[k][6],
        })
    }

    /// Its value in a trim.
    pub fn at_trim(self, trim: &Trim) -> f64 {
        match self {
            Self::Alpha => trim.alpha_rad,
            Self::Beta => 0.0,
            Self::LoadFactor => -trim.specific_force_m_s2[2] / trim.condition.gravity_m_s2,
            Self::RollRate => trim.rates_rad_s[0],
            Self::Airspeed => trim.condition.airspeed_m_s,
            Self::Altitude => trim.condition.altitude_m,
            Self::Bank => trim.euler_rad[0],
        }
    }
}

/// A limit of one quantity and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Quantity.
    pub quantity: Quantity,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Where it comes from.
    pub source: String,
}

/// What the input and the motion may be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// Limits of the motion.
    pub motion: Vec<Limit>,
    /// Largest input of each control from the trim to either side, rad or N.
    pub peaks: [f64; CONTROLS],
    /// Fastest input of each control, rad/s or N/s.
    pub rates: [f64; CONTROLS],
}

impl Limits {
    /// The part of the room between trim and limits that a flight uses: one where it just reaches a limit. A quantity without room of
    /// its own counts as soon as it moves.
    pub fn usage(&self, flown: &FlownInput, trim: &Trim) -> f64 {
        self.motion.iter().map(|limit| Self::part_used(limit, flown, trim)).fold(0.0, f64::max)
    }

    fn part_used(limit: &Limit, flown: &FlownInput, trim: &Trim) -> f64 {
        let about = limit.quantity.at_trim(trim);
        limit.quantity.values(flown, trim).fold(0.0, |worst: f64, value| {
            let room = if value >= about { limit.high - about } else { about - limit.low };
            worst.max((value - about).abs() / room.max(1e-9))
        })
    }
}

/// How far one quantity goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Excursion {
    /// Quantity.
    pub quantity: Quantity,
    /// Value in the trim.
    pub trim: f64,
    /// Least and greatest value of the flight without disturbance.
    pub nominal: (f64, f64),
    /// Least and greatest value to expect: means of the extremes over the flights with disturbance, three of their standard deviations
    /// further out.
    pub expected: (f64, f64),
}

/// Excursions of a design: `nominal` are its manoeuvres flown as designed, `disturbed` all its manoeuvres once per sample.
pub fn excursions(nominal: &[FlownInput], disturbed: &[Vec<FlownInput>], trim: &Trim) -> Vec<Excursion> {
    Quantity::ALL
        .into_iter()
        .map(|quantity| {
            let extremes = |flights: &[FlownInput]| {
                let values = flights.iter().flat_map(|flown| quantity.values(flown, trim));
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
            };
            let nominal = extremes(nominal);
            let each: Vec<(f64, f64)> = disturbed.iter().map(|flights| extremes(flights)).collect();
            let low = beyond(each.iter().map(|pair| pair.0), -3.0).unwrap_or(nominal.0).min(nominal.0);
            let high = beyond(each.iter().map(|pair| pair.1), 3.0).unwrap_or(nominal.1).max(nominal.1);
            Excursion { quantity, trim: quantity.at_trim(trim), nominal, expected: (low, high) }
        })
        .collect()
}

/// Mean plus so many standard deviations; none of fewer than two values.
fn beyond(values: impl Iterator<Item = f64> + Clone, deviations: f64) -> Option<f64> {
    let count = values.clone().count();
    if count < 2 {
        return None;
    }
    let mean = values.clone().sum::<f64>() / count as f64;
    let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
    Some(mean + deviations * variance.sqrt())
}
