//! The aircraft as data: everything its file states.

use serde::{Deserialize, Serialize};

use super::envelope::Envelope;
use super::flight_envelope::{FlightEnvelope, SEA_LEVEL_KG_M3};
use super::geometry::{MeanChord, WingPanel};
use super::inertia::{InertiaModel, OwnInertia};
use super::loading::Loading;
use super::statistics::{ComponentFraction, GyrationRadii};

/// An aircraft. Positions are in datum axes (x aft, y right, z up), m; inertias in body axes.
///
/// Values are unchecked until [`Aircraft::check`] has passed.
#[derive(Clone, Debug, PartialEq)]
pub struct Aircraft {
    /// Name as shown and reported.
    pub name: String,
    /// Where the numbers come from, and what is not known; one line each.
    pub notes: Vec<String>,
    /// What the coefficients are made with.
    pub reference: ReferenceGeometry,
    /// Where the origin of the datum axes lies, in words.
    pub datum: String,
    /// Mean aerodynamic chord as stated; computed from `wing_panels` where absent.
    pub stated_mean_chord: Option<MeanChord>,
    /// Panels of one half of the wing, from the root outwards.
    pub wing_panels: Vec<WingPanel>,
    /// Mass and centre of gravity of the aircraft with nothing in `tanks`, `seats` and `luggage`.
    pub empty: FixedItem,
    /// Items always on board beside `empty`.
    pub fixed_items: Vec<FixedItem>,
    /// Limits on mass.
    pub limits: MassLimits,
    /// Stall without flaps and power, where it is known.
    pub stall: Option<Stall>,
    /// Limits of flight.
    pub flight_envelope: FlightEnvelope,
    /// Fuel tanks.
    pub tanks: Vec<Tank>,
    /// What a tank's mass means.
    pub fuel_bookkeeping: FuelBookkeeping,
    /// Seats.
    pub seats: Vec<Station>,
    /// Luggage bays.
    pub luggage: Vec<Station>,
    /// Limits of the centre of gravity over mass.
    pub envelope: Option<Envelope>,
    /// Inertia of `empty`.
    pub inertia: InertiaModel,
    /// Loading a new session starts from.
    pub standard_loading: Loading,
    /// Ground contact of the wheels, for weighing.
    pub wheels: Option<WheelStations>,
    /// Positions of the sensors.
    pub sensors: SensorStations,
    /// Engines, in the order of their channels.
    pub engines: Vec<EngineStation>,
    /// Point about which moment coefficients are given, where it is not the centre of gravity; m.
    pub moment_reference_from_datum_m: Option<[f64; 3]>,
    /// Statistical mass fractions of the component groups (thesis Tables 5.10-5.11).
    pub component_fractions: Vec<ComponentFraction>,
    /// Statistical radii of gyration (thesis Table 5.13).
    pub gyration_radii: Option<GyrationRadii>,
}

/// Reference geometry of the coefficients and of the rates without dimension.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct ReferenceGeometry {
    /// Reference area S, m².
    pub area_m2: f64,
    /// Span b from tip to tip, m.
    pub span_m: f64,
    /// Reference chord c, the length in `Cm`, m.
    pub chord_m: f64,
    /// Length in `Cl` and `Cn`, m: the span unless the file states another.
    pub lateral_moment_length_m: f64,
    /// Length L in `p L / V`, `r L / V` and `beta_dot L / V`, m: half the span, hence `p b / (2 V)`, unless the file states
    /// another.
    pub lateral_rate_length_m: f64,
    /// Length L in `q L / V` and `alpha_dot L / V`, m: the chord unless the file states another.
    pub pitch_rate_length_m: f64,
}

impl ReferenceGeometry {
    /// Reference geometry with the conventions of `docs/conventions.md`: `Cl`, `Cn` by span, `pb/2V`, `rb/2V`, `qc/V`.
    pub const fn conventional(area_m2: f64, span_m: f64, chord_m: f64) -> Self {
        Self {
            area_m2,
            span_m,
            chord_m,
            lateral_moment_length_m: span_m,
            lateral_rate_length_m: span_m / 2.0,
            pitch_rate_length_m: chord_m,
        }
    }

    /// How roll, pitch and yaw rate are made dimensionless, in words: `p b/2V, q c/V, r b/2V` unless the file says otherwise.
    pub fn rate_normalisation(&self) -> String {
        let form = |symbol: char, share: f64| {
            if share == 1.0 { format!("{symbol}/V") } else { format!("{symbol}/{share}V") }
        };
        let lateral = form('b', self.lateral_rate_divisor());
        format!("p {lateral}, q {}, r {lateral}", form('c', self.pitch_rate_divisor()))
    }

    /// The n of `p b / (n V)`, b being the length in `Cl` and `Cn`; printed lengths leave their rounding in the quotient.
    pub fn lateral_rate_divisor(&self) -> f64 {
        (1e3 * self.lateral_moment_length_m / self.lateral_rate_length_m).round() / 1e3
    }

    /// The n of `q c / (n V)`; printed lengths leave their rounding in the quotient.
    pub fn pitch_rate_divisor(&self) -> f64 {
        (1e3 * self.chord_m / self.pitch_rate_length_m).round() / 1e3
    }

    /// Aspect ratio `b^2 / S`.
    pub fn aspect_ratio(&self) -> f64 {
        self.span_m * self.span_m / self.area_m2
    }
}

/// A mass at a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedItem {
    /// Name.
    pub name: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of gravity, m from the datum.
    pub cg_from_datum_m: [f64; 3],
}

crate::hash_fields!(FixedItem { name; mass_kg, cg_from_datum_m });

/// Limits on the mass of the aircraft, kg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MassLimits {
    /// Maximum take-off mass, kg.
    pub max_takeoff_kg: Option<f64>,
    /// Maximum landing mass, kg.
    pub max_landing_kg: Option<f64>,
}

/// Stall without flaps and power, unaccelerated.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stall {
    /// Calibrated airspeed, m/s.
    #[serde(rename = "airspeed_m_s")]
    pub calibrated_airspeed_m_s: f64,
    /// Mass it is stated for, kg.
    pub mass_kg: f64,
}

impl Stall {
    /// Lift coefficient there, `2 m g / (rho_0 V^2 S)`, with standard gravity and the density of the standard atmosphere at sea level.
    pub fn max_lift_coefficient(&self, area_m2: f64) -> f64 {
        /// Standard gravity, m/s².
        const GRAVITY_M_S2: f64 = 9.806_65;
        2.0 * self.mass_kg * GRAVITY_M_S2 / (SEA_LEVEL_KG_M3 * self.calibrated_airspeed_m_s.powi(2) * area_m2)
    }
}

/// A fuel tank.
#[derive(Clone, Debug, PartialEq)]
pub struct Tank {
    /// Name, unique among the tanks.
    pub name: String,
    /// Fuel it holds when full, kg.
    pub capacity_kg: f64,
    /// Part of the capacity that cannot be used and is also counted in the empty mass, kg.
    pub unusable_kg: f64,
    /// Centre of gravity of the fuel, m from the datum; taken as independent of the level.
    pub cg_from_datum_m: [f64; 3],
    /// Inertia of the fuel about its own centre of gravity.
    pub inertia: OwnInertia,
}

/// What the fuel mass of a tank means where the empty mass includes unusable fuel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FuelBookkeeping {
    /// All of a tank's fuel is added to the empty mass: the unusable fuel counts twice, as in the thesis.
    #[default]
    AddAll,
    /// Only what exceeds the unusable fuel is added to the empty mass.
    AddUsable,
}

/// A seat or a luggage bay.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// Name, unique among the seats or bays.
    pub name: String,
    /// Largest mass, kg, where one is stated.
    pub capacity_kg: Option<f64>,
    /// Centre of gravity of the load, m from the datum.
    pub cg_from_datum_m: [f64; 3],
    /// Inertia of the load about its own centre of gravity.
    pub inertia: OwnInertia,
}

/// Ground contact of a nose wheel and two main wheels, m from the datum.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelStations {
    /// Nose wheel, x.
    pub nose_x_m: f64,
    /// Main wheels, x.
    pub main_x_m: f64,
    /// Right main wheel, y; the left one stands at its negative.
    pub main_y_m: f64,
}

/// Positions of the sensors, m from the datum; `None` where not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorStations {
    /// Accelerometers.
    #[serde(rename = "accelerometer_datum_m")]
    pub accelerometer_from_datum_m: Option<[f64; 3]>,
    /// Angle-of-attack vane or boom.
    #[serde(rename = "alpha_vane_datum_m")]
    pub alpha_vane_from_datum_m: Option<[f64; 3]>,
    /// Sideslip vane or boom.
    #[serde(rename = "beta_vane_datum_m")]
    pub beta_vane_from_datum_m: Option<[f64; 3]>,
    /// Antenna of the satellite navigation receiver.
    #[serde(rename = "antenna_datum_m")]
    pub antenna_from_datum_m: Option<[f64; 3]>,
}

/// Where an engine's thrust acts.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineStation {
    /// Name.
    pub name: String,
    /// Point of action, m from the datum.
    pub position_from_datum_m: [f64; 3],
    /// Angle of the thrust line above body x, rad.
    pub incidence_rad: f64,
}

impl Aircraft {
    /// Mean aerodynamic chord as stated, or from the wing panels; `None` where the file has neither.
    pub fn mean_chord(&self) -> Option<MeanChord> {
        self.stated_mean_chord.or_else(|| super::geometry::mean_aerodynamic_chord(&self.wing_panels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalisation_of_rates_is_stated_in_words() {
        let mut reference = ReferenceGeometry::conventional(18.7, 11.68, 1.68);
        assert_eq!(reference.rate_normalisation(), "p b/2V, q c/V, r b/2V");
        reference.pitch_rate_length_m = 0.84;
        reference.lateral_rate_length_m = 11.68;
        assert_eq!(reference.rate_normalisation(), "p b/V, q c/2V, r b/V");
    }
}
