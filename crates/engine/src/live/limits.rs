//! Limits that are watched.

use std::collections::BTreeMap;
use std::str::FromStr;

use doublet_core::airframe::FlightEnvelope;
use doublet_core::quantity::{Dimension, Role, Unit};
use serde::Serialize;

use crate::session::Level;

/// Name of the load factor, `-az / g`, among the quantities.
pub(crate) const LOAD_FACTOR: &str = "n_z";

/// Part of a range at its ends in which a value is near its limit.
const NEAR: f64 = 0.1;

/// Bounds of a quantity, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Name of a role, or `n_z`.
    pub quantity: String,
    /// Least value.
    pub low: Option<f64>,
    /// Greatest value.
    pub high: Option<f64>,
}

/// A limit against what was flown since the update before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitReading {
    /// Name of the quantity.
    pub quantity: String,
    /// Least and greatest value, SI.
    pub range: [f64; 2],
    /// Least value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Greatest value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Distance to the nearer bound, negative beyond it, SI.
    pub margin: f64,
    /// Good inside, caution in the last tenth of the range, bad outside.
    pub level: Level,
}

impl LimitReading {
    /// The same, but good while the aircraft is on the ground if it is a limit of flight: there it does not stall, vanes hang loose and
    /// wheels carry load.
    pub(crate) fn silence_on_ground(mut self, is_airborne: bool) -> Self {
        let of_flight =
            [Role::CalibratedAirspeed, Role::TrueAirspeed, Role::AngleOfAttack, Role::Sideslip].map(Role::name);
        if !is_airborne && (self.quantity == LOAD_FACTOR || of_flight.contains(&self.quantity.as_str())) {
            self.level = Level::Good;
        }
        self
    }
}

impl FromStr for Limit {
    type Err = String;

    /// `alpha=:14deg`, `n_z=0.2:3.5`, `airspeed=75kt:150kt`: either bound may be left out; units as in channel maps, SI without.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("'{text}': write QUANTITY=LOW:HIGH, for example airspeed=75kt:150kt or alpha=:14deg");
        let (quantity, range) = text.split_once('=').ok_or_else(form)?;
        let (low, high) = range.split_once(':').ok_or_else(form)?;
        Self::between(text, quantity.trim(), [low, high], form)
    }
}

impl Limit {
    /// Limits as they are written on a card, separated by commas: `alpha < 14 deg, 0.2 < n_z < 3.5, 75 < airspeed < 150 kt`; those of
    /// [`Limit::from_str`] as well, separated by spaces. A bound without a unit has that of the other one.
    pub fn parse_list(text: &str) -> Result<Vec<Self>, String> {
        let items = text.split([',', ';', '\n']).map(str::trim).filter(|item| !item.is_empty());
        let is_card = |item: &str| item.contains(['<', '>', '≤', '≥']);
        let mut limits = Vec::new();
        for item in items {
            if is_card(item) {
                limits.push(Self::parse_inequality(item)?);
            } else {
                limits.extend(item.split_whitespace().map(str::parse).collect::<Result<Vec<Self>, String>>()?);
            }
        }
        Ok(limits)
    }

    /// One limit written by `<` or `>`.
    fn parse_inequality(text: &str) -> Result<Self, String> {
        let form = || format!("'{text}': write for example alpha < 14 deg, n_z > 0.2 or 75 < airspeed < 150 kt");
        let plain = text.replace("<=", "<").replace(">=", ">").replace('≤', "<").replace('≥', ">");
        let is_less = match (plain.contains('<'), plain.contains('>')) {
            (true, false) => true,
            (false, true) => false,
            _ => return Err(form()),
        };
        let mut parts: Vec<&str> = plain.split(['<', '>']).map(str::trim).collect();
        if !is_less {
            parts.reverse();
        }
        // From the least to the greatest.
        let (low, quantity, high) = match parts[..] {
            [low, quantity, high] if find_quantity(quantity).is_some() => (low, quantity, high),
            [quantity, high] if find_quantity(quantity).is_some() => ("", quantity, high),
            [low, quantity] if find_quantity(quantity).is_some() => (low, quantity, ""),
            _ => return Err(form()),
        };
        let unit = |bound: &str| bound[split_number(bound)..].trim().to_owned();
        let (of_low, of_high) = (unit(low), unit(high));
        let complete = |bound: &str, own: &str, other: &str| match (bound.is_empty(), own.is_empty()) {
            (false, true) => format!("{bound} {other}"),
            _ => bound.to_owned(),
        };
        let bounds = [complete(low, &of_low, &of_high), complete(high, &of_high, &of_low)];
        let (name, role) = find_quantity(quantity).ok_or_else(form)?;
        if role.is_some_and(|role| role.dimension() == Dimension::Angle) && of_low.is_empty() && of_high.is_empty() {
            return Err(format!("'{text}': the angle has no unit: write deg or rad"));
        }
        Self::between(text, name, [&bounds[0], &bounds[1]], form)
    }

    /// A limit by both bounds, either empty where there is none.
    fn between(
        text: &str,
        quantity: &str,
        [low, high]: [&str; 2],
        form: impl Fn() -> String + Copy,
    ) -> Result<Self, String> {
        let (quantity, role) = find_quantity(quantity).ok_or_else(|| {
            format!("'{quantity}' is not a known quantity: use {LOAD_FACTOR} or a role of the channel maps, such as airspeed")
        })?;
        let (low, high) = (parse_bound(low, (role, quantity), form)?, parse_bound(high, (role, quantity), form)?);
        match (low, high) {
            (None, None) => Err(form()),
            (Some(low), Some(high)) if low >= high => {
                Err(format!("'{text}': the lower bound is not below the upper one"))
            }
            _ => Ok(Self { quantity: quantity.to_owned(), low, high }),
        }
    }
}

/// The quantity that is called so, with its role where it has one.
fn find_quantity(name: &str) -> Option<(&'static str, Option<Role>)> {
    match name {
        LOAD_FACTOR | "nz" => Some((LOAD_FACTOR, None)),
        name => Role::from_name(name).map(|role| (role.name(), Some(role))),
    }
}

/// Where the number ends that `text` begins with.
fn split_number(text: &str) -> usize {
    text.find(|letter: char| letter.is_alphabetic() && !"eE".contains(letter)).unwrap_or(text.len())
}

/// A bound in SI; none where `text` is empty, `form` what is said of text that is not a number.
fn parse_bound(
    text: &str,
    (role, quantity): (Option<Role>, &str),
    form: impl Fn() -> String,
) -> Result<Option<f64>, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    let (number, unit) = text.split_at(split_number(text));
    let number: f64 = number.trim().parse().map_err(|_| form())?;
    if unit.is_empty() {
        return Ok(Some(number));
    }
    let parsed = Unit::parse(unit.trim()).map_err(|error| error.to_string())?;
    match role {
        Some(role) if role.dimension() == parsed.dimension => Ok(Some(parsed.to_si(number))),
        _ => Err(format!("'{unit}' is not a unit of {quantity}")),
    }
}

impl Limit {
    /// What an aircraft file says is not to be passed: load factors, the stall and the airspeed never to be exceeded.
    pub(crate) fn of_envelope(envelope: &FlightEnvelope) -> Vec<Self> {
        let limit = |quantity: &str, low: Option<f64>, high: Option<f64>| {
            (low.is_some() || high.is_some()).then(|| Self { quantity: quantity.to_owned(), low, high })
        };
        let load_factor = limit(LOAD_FACTOR, envelope.load_factor_low, envelope.load_factor_high);
        let airspeed = limit(Role::CalibratedAirspeed.name(), envelope.stall_m_s, envelope.never_exceed_m_s);
        load_factor.into_iter().chain(airspeed).collect()
    }

    /// Against the least and greatest value of each quantity.
    pub fn read(&self, extremes: &BTreeMap<String, [f64; 2]>) -> Option<LimitReading> {
        let range = *extremes.get(&self.quantity)?;
        let below = self.low.map_or(f64::INFINITY, |low| range[0] - low);
        let above = self.high.map_or(f64::INFINITY, |high| high - range[1]);
        let margin = below.min(above);
        let width = match (self.low, self.high) {
            (Some(low), Some(high)) => high - low,
            (bound, other) => bound.or(other).map_or(0.0, f64::abs),
        };
        let level = match margin {
            margin if margin < 0.0 => Level::Bad,
            margin if margin < NEAR * width => Level::Caution,
            _ => Level::Good,
        };
        let Self { quantity, low, high } = self.clone();
        Some(LimitReading { quantity, range, low, high, margin, level })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn envelope_limits_load_factor_and_calibrated_airspeed_as_far_as_it_states_them() {
        let envelope = FlightEnvelope {
            stall_m_s: Some(36.0),
            never_exceed_m_s: Some(92.6),
            load_factor_high: Some(3.8),
            ..FlightEnvelope::default()
        };
        let found: Vec<_> =
            Limit::of_envelope(&envelope).into_iter().map(|own| (own.quantity, own.low, own.high)).collect();
        let expected =
            [("n_z".to_owned(), None, Some(3.8)), ("calibrated_airspeed".to_owned(), Some(36.0), Some(92.6))];
        assert_eq!(found, expected);
        assert_eq!(Limit::of_envelope(&FlightEnvelope::default()), []);
    }

    #[test]
    fn limits_are_read_as_they_stand_on_a_card() {
        let kt = 1852.0 / 3600.0;
        let found = Limit::parse_list("alpha < 14 deg, 0.2 <= nz < 3.5; 150 kt > airspeed > 75, p=:1 q=-1:1").unwrap();
        let expected = [
            ("alpha", None, Some(14_f64.to_radians())),
            ("n_z", Some(0.2), Some(3.5)),
            ("airspeed", Some(75.0 * kt), Some(150.0 * kt)),
            ("p", None, Some(1.0)),
            ("q", Some(-1.0), Some(1.0)),
        ];
        assert_eq!(found.len(), expected.len());
        for (limit, (quantity, low, high)) in found.iter().zip(expected) {
            let near = |a: Option<f64>, b: Option<f64>| a.unwrap_or(f64::MAX) - b.unwrap_or(f64::MAX);
            assert_eq!(limit.quantity, quantity);
            assert!(near(limit.low, low).abs() < 1e-12 && near(limit.high, high).abs() < 1e-12, "{limit:?}");
        }
        for wrong in
            ["alpha < 14", "alpha < 14 kt", "14 < 15 deg", "alpha < < 3 deg", "lift < 2", "3 < n_z < 2", "<", "alpha <"]
        {
            assert!(Limit::parse_list(wrong).is_err(), "{wrong}");
        }
        assert_eq!(Limit::parse_list(" "), Ok(Vec::new()));
    }

    #[test]
    fn limits_are_read_with_units_and_judged_by_their_margin() {
        let limit: Limit = "alpha=-4deg:14deg".parse().unwrap();
        assert!((limit.high.unwrap() - 14_f64.to_radians()).abs() < 1e-15);
        let at = |low: f64, high: f64| BTreeMap::from([("alpha".to_owned(), [low.to_radians(), high.to_radians()])]);
        let level = |low, high| limit.read(&at(low, high)).unwrap().level;
        assert_eq!(
            [level(0.0, 10.0), level(0.0, 13.0), level(0.0, 15.0), level(-5.0, 0.0)],
            [Level::Good, Level::Caution, Level::Bad, Level::Bad]
        );
        assert_eq!(limit.read(&BTreeMap::new()), None);
        let stall: Limit = "calibrated_airspeed=36:92".parse().unwrap();
        let taxiing = BTreeMap::from([("calibrated_airspeed".to_owned(), [3.0, 9.0])]);
        let level = |is_airborne| stall.read(&taxiing).unwrap().silence_on_ground(is_airborne).level;
        assert_eq!([level(false), level(true)], [Level::Good, Level::Bad]);
        assert_eq!("n_z=0.2:".parse::<Limit>().unwrap().low, Some(0.2));
        assert!(("airspeed=:150kt".parse::<Limit>().unwrap().high.unwrap() - 77.1667).abs() < 1e-3);
        for bad in
            ["", "alpha", "alpha=1", "alpha=:", "alpha=2:1", "alpha=x:2", "colour=1:2", "alpha=1kt:2kt", "n_z=1deg:2"]
        {
            assert!(bad.parse::<Limit>().is_err(), "{bad}");
        }
    }
}
