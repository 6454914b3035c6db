//! A weighing as a file: readings of the scales, what was on board, and the empty aircraft that follows.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::airframe::weighing::{WeighingResult, without_items};
use doublet_core::airframe::{Aircraft, FixedItem, FuelBookkeeping};
use serde::{Deserialize, Serialize};

use super::{ScaleReadings, weigh};
use crate::aircraft::{AircraftChanges, ChangedValue};
use crate::toml_file;

/// Value of the `format` key.
const FORMAT: &str = "doublet weighing";
/// Version of the form.
const VERSION: u32 = 1;

/// A weighing as its file states it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeighingFile {
    format: String,
    version: u32,
    /// Aircraft with its wheels and tanks: a file, or `builtin:` and a name.
    pub aircraft: String,
    /// Fuel on board, kg, by tank.
    #[serde(default)]
    pub fuel_kg: BTreeMap<String, f64>,
    /// What else is taken off.
    #[serde(default, rename = "item")]
    pub items: Vec<FixedItem>,
    /// Readings at each attitude.
    #[serde(rename = "reading")]
    readings: Vec<Reading>,
}

/// Readings at one attitude in the units of the instruments.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reading {
    /// Angle of the line through the wheels' contact points, nose up, deg.
    ground_pitch_deg: f64,
    /// Pitch of body x above the horizontal, deg.
    aircraft_pitch_deg: f64,
    nose_kg: f64,
    main_right_kg: f64,
    main_left_kg: f64,
}

/// What a weighing gives; positions in datum axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weighed {
    pub attitudes: usize,
    /// Mean of the totals, kg.
    pub mass_kg: f64,
    /// Largest total less the smallest, kg.
    pub mass_spread_kg: f64,
    /// Centre of gravity as weighed, m: x and z of the regression, y at the attitude nearest to level.
    pub cg_datum_m: [f64; 3],
    /// Standard errors of x and z, m; none for two attitudes.
    pub x_error_m: Option<f64>,
    /// See `x_error_m`.
    pub z_error_m: Option<f64>,
    /// Height above the line through the contact points, m.
    pub z_ground_m: f64,
    /// x at the attitude nearest to level, m.
    pub level_x_m: f64,
    /// Mean difference between aircraft and ground pitch, rad.
    pub strut_pitch_rad: f64,
    /// Coefficient of determination of the regression.
    pub r_squared: f64,
    /// Fuel and items taken off, kg.
    pub taken_off_kg: f64,
    pub empty_mass_kg: f64,
    /// Centre of gravity of the empty aircraft, m.
    pub empty_cg_datum_m: [f64; 3],
    /// Empty mass that the aircraft file states, kg.
    pub stated_mass_kg: f64,
    /// Centre of gravity that the aircraft file states, m.
    pub stated_cg_datum_m: [f64; 3],
}

impl WeighingFile {
    /// Reads a file.
    pub fn open(path: &Path) -> Result<Self, String> {
        toml_file::open(path, Self::parse)
    }

    /// Reads the text of a file.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml_file::parse(text, (FORMAT, VERSION), |file: &Self| (&file.format, file.version))
    }

    /// Mass and centre of gravity as weighed and of the empty aircraft.
    pub fn evaluate(&self, aircraft: &Aircraft) -> Result<Weighed, String> {
        let readings: Vec<ScaleReadings> = self.readings.iter().map(Reading::si).collect();
        let found = weigh(aircraft, &readings)?;
        let WeighingResult { mass_kg, x_m, z_m, level_y_m, .. } = found;
        let cg_datum_m = [x_m, level_y_m, z_m];
        let items: Vec<FixedItem> = self.fuel(aircraft)?.into_iter().chain(self.items.iter().cloned()).collect();
        if let Some(item) = items.iter().find(|item| !(0.0..=1e6).contains(&item.mass_kg)) {
            return Err(format!("{} is {} kg, allowed is 0 to 1000000 kg", item.name, item.mass_kg));
        }
        let weighed = FixedItem { name: aircraft.name.clone(), mass_kg, cg_from_datum_m: cg_datum_m };
        let empty = without_items(&weighed, &items).map_err(|error| error.to_string())?;
        Ok(Weighed {
            attitudes: readings.len(),
            mass_kg,
            mass_spread_kg: found.mass_spread_kg,
            cg_datum_m,
            x_error_m: found.x_error_m,
            z_error_m: found.z_error_m,
            z_ground_m: found.z_ground_m,
            level_x_m: found.level_x_m,
            strut_pitch_rad: found.strut_pitch_rad,
            r_squared: found.r_squared,
            taken_off_kg: items.iter().map(|item| item.mass_kg).sum(),
            empty_mass_kg: empty.mass_kg,
            empty_cg_datum_m: empty.cg_from_datum_m,
            stated_mass_kg: aircraft.empty.mass_kg,
            stated_cg_datum_m: aircraft.empty.cg_from_datum_m,
        })
    }

    /// Fuel as items in the places of the tanks; what counts in the empty mass stays on board.
    fn fuel(&self, aircraft: &Aircraft) -> Result<Vec<FixedItem>, String> {
        self.fuel_kg.iter().map(|(name, &fuel_kg)| Self::fuel_item(aircraft, name, fuel_kg)).collect()
    }

    fn fuel_item(aircraft: &Aircraft, name: &str, fuel_kg: f64) -> Result<FixedItem, String> {
        let tank = aircraft.tanks.iter().find(|tank| tank.name == name);
        let tank = tank.ok_or_else(|| {
            let known: Vec<&str> = aircraft.tanks.iter().map(|tank| tank.name.as_str()).collect();
            format!("fuel_kg: the aircraft has no tank '{name}': use one of {}", known.join(", "))
        })?;
        let mass_kg = match aircraft.fuel_bookkeeping {
            FuelBookkeeping::AddAll => fuel_kg,
            FuelBookkeeping::AddUsable => (fuel_kg - tank.unusable_kg).max(0.0),
        };
        Ok(FixedItem { name: format!("fuel {name}"), mass_kg, cg_from_datum_m: tank.cg_from_datum_m })
    }
}

impl Reading {
    fn si(&self) -> ScaleReadings {
        ScaleReadings {
            ground_pitch_rad: self.ground_pitch_deg.to_radians(),
            aircraft_pitch_rad: self.aircraft_pitch_deg.to_radians(),
            wheels_kg: [self.nose_kg, self.main_right_kg, self.main_left_kg],
        }
    }
}

impl Weighed {
    /// Sets mass and centre of gravity of the empty aircraft in the changes of a session.
    pub fn apply(&self, changes: &mut AircraftChanges) {
        changes.set("mass.mass_kg", ChangedValue::Number(self.empty_mass_kg));
        changes.set("mass.cg_datum_m", ChangedValue::Triple(self.empty_cg_datum_m));
    }
}

#[cfg(test)]
mod tests {
    use doublet_core::load::aircraft;

    use super::*;
    use crate::builtin;

    /// Thesis Tables 5.4 and 5.5: ground pitch, aircraft pitch (deg), nose, right and left wheel (kg).
    const LOW: [[f64; 5]; 3] =
        [[0.0, 0.7, 168.0, 707.0, 710.0], [2.6, 6.0, 88.0, 749.0, 751.0], [7.2, 11.5, 14.0, 784.0, 787.0]];
    const FULL: [[f64; 5]; 4] = [
        [0.0, 1.6, 158.0, 804.0, 791.0],
        [2.6, 6.9, 78.0, 841.0, 831.0],
        [1.3, 5.4, 103.0, 827.0, 819.0],
        [4.9, 9.3, 38.0, 858.0, 852.0],
    ];

    fn file(rows: &[[f64; 5]], fuel: [f64; 4]) -> String {
        let [right, left, aux_right, aux_left] = fuel;
        let mut text = format!(
            "format = \"doublet weighing\"\nversion = 1\naircraft = \"builtin:c337f\"\n[fuel_kg]\n\"main right\" = {right:?}\n\
             \"main left\" = {left:?}\n\"auxiliary right\" = {aux_right:?}\n\"auxiliary left\" = {aux_left:?}\n"
        );
        for [ground, body, nose, right, left] in rows {
            text += &format!(
                "[[reading]]\nground_pitch_deg = {ground:?}\naircraft_pitch_deg = {body:?}\nnose_kg = {nose:?}\n\
                 main_right_kg = {right:?}\nmain_left_kg = {left:?}\n"
            );
        }
        text
    }

    fn c337f() -> Aircraft {
        aircraft::parse(builtin::text("aircraft", "c337f").unwrap()).unwrap()
    }

    /// Printed: Tables 5.3 to 5.8. The thesis prints z to 1 cm from pitches rounded to 0.1 deg, which move it by 3 cm.
    #[test]
    fn printed_weighings_of_the_thesis_are_found_again() {
        for (rows, fuel, mass_kg, x_m, z_m, empty_kg, empty_z_m) in [
            (&LOW[..], [73.4, 76.5, 30.2, 29.2], 1586.0, 3.60, 1.78, 1376.7, 1.74),
            (&FULL[..], [132.5, 132.5, 54.1, 54.1], 1750.0, 3.64, 1.79, 1376.8, 1.73),
        ] {
            let found = WeighingFile::parse(&file(rows, fuel)).unwrap().evaluate(&c337f()).unwrap();
            assert!((found.mass_kg - mass_kg).abs() < 0.5, "{}", found.mass_kg);
            assert!((found.cg_datum_m[0] - x_m).abs() < 0.006, "{:?}", found.cg_datum_m);
            assert!((found.cg_datum_m[2] - z_m).abs() < 0.035, "{:?}", found.cg_datum_m);
            assert!((found.empty_mass_kg - empty_kg).abs() < 0.6, "{}", found.empty_mass_kg);
            assert!((found.empty_cg_datum_m[2] - empty_z_m).abs() < 0.04, "{:?}", found.empty_cg_datum_m);
            let mut changes = AircraftChanges::default();
            found.apply(&mut changes);
            assert_eq!(changes.get("mass.mass_kg"), Some(&ChangedValue::Number(found.empty_mass_kg)));
        }
    }

    #[test]
    fn files_that_cannot_be_are_refused() {
        let text = file(&LOW, [73.4, 76.5, 30.2, 29.2]);
        for (from, to) in [
            ("\"main right\"", "\"main front\""),
            ("main left\" = 76.5", "main left\" = 9000.0"),
            ("nose_kg = 168.0", "nose_kg = -1.0"),
        ] {
            assert!(WeighingFile::parse(&text.replacen(from, to, 1)).unwrap().evaluate(&c337f()).is_err(), "{to}");
        }
        assert!(WeighingFile::parse(&text.replace("version = 1", "version = 2")).is_err());
        assert!(WeighingFile::parse(&text.replace("nose_kg", "noise_kg")).is_err());
    }
}
