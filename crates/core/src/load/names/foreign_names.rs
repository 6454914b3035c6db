//! German, French, Spanish, Portuguese, Italian and Dutch names of channels, and what some of them need beside them to have one reading.

use std::sync::LazyLock;

use crate::load::names::role_names::{RoleNames, is_known, read_names};
use crate::load::names::stated_unit::stem_and_unit;
use crate::load::names::words::{join_words, plain_letters};
use crate::quantity::Role;

/// Names a role goes by in other languages than English as [`crate::load::names::words::join_words`] writes them, best first.
pub(crate) static FOREIGN_NAMES: LazyLock<Vec<RoleNames>> =
    LazyLock::new(|| read_names(include_str!("../../../../../assets/channel_names/foreign.txt")));

/// Airspeeds that do not say whether they are true or indicated.
pub(crate) const AIRSPEEDS_OF_NO_KIND: [&str; 4] =
    ["eigengeschwindigkeit", "fluggeschw", "fluggeschwindigkeit", "vitesseair"];

/// What a name needs to have one reading.
#[derive(Clone, Copy)]
pub(crate) enum Need {
    /// A unit that the role has.
    Unit,
    /// The same; or, to be an angle, that the rate about its axis is another channel.
    UnitOrRate(Role),
    /// One of these units.
    OneOf(&'static [&'static str]),
    /// Another channel with a French name of a control.
    FrenchControl,
    /// All of these names: the controls by their letters of LN 9300 or of French tests.
    AllOf(&'static [&'static str]),
    /// A unit that the role has, or without one another channel of one of these names, unless it is this role.
    UnitUnless(Role, &'static [&'static str]),
    /// An accent: without one the word is English too, and the temperature that of any sensor.
    Accent,
    /// A unit that the role has, or another channel of one of these names.
    UnitOrBeside(&'static [&'static str]),
    /// All of the names beside it that a role needs.
    ByRole(&'static [(Role, &'static [&'static str])]),
}

/// Names that have more than one reading by themselves.
pub(crate) const NEEDS: &[(&str, Need)] = &[
    ("long", Need::UnitUnless(Role::Longitude, &["latg", "vrtg"])),
    ("roulis", Need::UnitOrRate(Role::RollRate)),
    ("rollen", Need::UnitOrRate(Role::RollRate)),
    ("tangage", Need::UnitOrRate(Role::PitchRate)),
    ("nicken", Need::UnitOrRate(Role::PitchRate)),
    ("lacet", Need::UnitOrRate(Role::YawRate)),
    ("gieren", Need::UnitOrRate(Role::YawRate)),
    ("kraftstoff", Need::Unit),
    ("treibstoff", Need::Unit),
    ("carburant", Need::Unit),
    ("kraftstoffdurchfluss", Need::Unit),
    ("kraftstoffverbrauch", Need::Unit),
    ("debitcarburant", Need::Unit),
    ("consommationcarburant", Need::Unit),
    ("leistung", Need::Unit),
    ("puissance", Need::Unit),
    ("palonnier", Need::Unit),
    // Down in the conventions, up on every instrument that shows feet per minute.
    ("vz", Need::OneOf(&["ft/min"])),
    // Without a unit: an angle of the stick, a level, a course, the bow or rudder of a ship.
    ("rolamento", Need::UnitOrRate(Role::RollRate)),
    ("arfagem", Need::UnitOrRate(Role::PitchRate)),
    ("rollio", Need::UnitOrRate(Role::RollRate)),
    ("beccheggio", Need::UnitOrRate(Role::PitchRate)),
    ("quota", Need::Unit),
    ("koers", Need::Unit),
    ("proa", Need::Unit),
    ("prua", Need::Unit),
    ("leme", Need::Unit),
    ("timone", Need::Unit),
    // Vitesse vraie or vitesse verticale.
    ("vv", Need::OneOf(&["kt", "km/h"])),
    ("direction", Need::FrenchControl),
    // Vitesse conventionnelle, vitesse propre.
    ("vc", Need::OneOf(&["kt", "km/h"])),
    ("vp", Need::OneOf(&["kt", "km/h"])),
    // A pressure, unless it is in feet or metres.
    ("baro", Need::UnitUnless(Role::StaticPressure, &[])),
    ("temperature", Need::Accent),
    ("xi", Need::AllOf(&GREEK_CONTROLS)),
    ("eta", Need::AllOf(&GREEK_CONTROLS)),
    ("zeta", Need::AllOf(&GREEK_CONTROLS)),
    ("dl", Need::AllOf(&DELTA_CONTROLS)),
    ("dm", Need::AllOf(&DELTA_CONTROLS)),
    ("dn", Need::AllOf(&DELTA_CONTROLS)),
    // In g it is the load factor.
    ("load", Need::Unit),
    // Elevator beside the other controls, elevation beside fixes.
    ("ele", Need::ByRole(&[(Role::Elevator, &["ail", "rud"]), (Role::GpsAltitude, &["lat", "lon"])])),
    // Width and length of anything.
    ("breite", Need::UnitOrBeside(&["lange", "laenge"])),
    ("lange", Need::UnitOrBeside(&["breite"])),
    ("laenge", Need::UnitOrBeside(&["breite"])),
];

/// French names of controls that are nothing else.
pub(crate) const FRENCH_CONTROLS: [&str; 2] = ["profondeur", "gauchissement"];

/// Aileron, elevator and rudder after the moments L, M, N that they make.
const DELTA_CONTROLS: [&str; 3] = ["dl", "dm", "dn"];

/// Aileron, elevator and rudder in LN 9300.
const GREEK_CONTROLS: [&str; 3] = ["xi", "eta", "zeta"];

/// Whether a channel of this name is made for a role.
pub(crate) fn is_role_name(name: &str) -> bool {
    let (stem, _) = stem_and_unit(name);
    let (plain, words) = (plain_letters(stem), join_words(stem));
    is_known(&plain) || FOREIGN_NAMES.iter().any(|(_, names)| names.contains(&words.as_str()))
}

/// Letters of the shortest name that may stand at the end of a longer one.
const LEAST_ENDING: usize = 7;
/// Words before a name that make another quantity of it: a rate, a force, a trim tab, the wind.
const OTHER_QUANTITIES: [&str; 16] = [
    "angul", "winkel", "dreh", "vitesse", "velocidad", "taux", "trim", "compens", "tab", "kraft", "effort", "moment",
    "servo", "wind", "vent", "viento",
];

/// Whether a channel's name ends on `name`, behind words that leave it what it is: `imurollrate`.
pub(crate) fn ends_on(words: &str, name: &str) -> bool {
    let before = words.strip_suffix(name).filter(|_| name.len() >= LEAST_ENDING);
    let has_need = NEEDS.iter().any(|(known, _)| *known == name);
    before.is_some_and(|before| !has_need && !OTHER_QUANTITIES.iter().any(|other| before.contains(other)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_join_words_writes() {
        let text = include_str!("../../../../../assets/channel_names/foreign.txt");
        assert_eq!(
            FOREIGN_NAMES.len(),
            text.lines().filter(|line| !line.starts_with(['#', ' '])).count(),
            "every line begins with a role"
        );
        for (role, names) in &*FOREIGN_NAMES {
            for name in *names {
                assert_eq!(join_words(name), *name, "{}", role.name());
            }
        }
        for (name, _) in NEEDS {
            assert!(is_known(name) || FOREIGN_NAMES.iter().any(|(_, names)| names.contains(name)), "{name}");
        }
    }

    #[test]
    fn a_name_may_stand_behind_where_it_was_measured_and_not_behind_what_makes_it_another_quantity() {
        assert!(ends_on("imurollrate", "rollrate") && ends_on("ahrsnickwinkel", "nickwinkel"));
        assert!(!ends_on("winkelbeschleunigungx", "beschleunigungx") && !ends_on("effortprofondeur", "profondeur"));
        assert!(!ends_on("radarhohe", "hohe") && !ends_on("roulis", "roulis"));
    }
}
