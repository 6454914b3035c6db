//! Weighing of an aircraft on scales under its wheels.

mod file;

pub use file::{Weighed, WeighingFile};

use doublet_core::airframe::Aircraft;
use doublet_core::airframe::weighing::{WeighingResult, WheelReactions, centre_of_gravity};

/// Readings of the scales at one pitch attitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaleReadings {
    /// Angle of the line through the wheels' contact points, nose up, rad.
    pub ground_pitch_rad: f64,
    /// Pitch of body x above the horizontal, rad.
    pub aircraft_pitch_rad: f64,
    /// Under the nose wheel, the right and the left main wheel, kg.
    pub wheels_kg: [f64; 3],
}

/// Mass and centre of gravity by the readings that hold a load (thesis Eq. 5.4 to 5.6).
pub fn weigh(aircraft: &Aircraft, readings: &[ScaleReadings]) -> Result<WeighingResult, String> {
    let wheels =
        aircraft.wheels.as_ref().ok_or("the aircraft file states no wheels: add [wheels] with their places")?;
    let loaded = readings.iter().filter(|row| row.wheels_kg.iter().sum::<f64>() > 0.0);
    let rows: Vec<WheelReactions> = loaded
        .map(|row| WheelReactions {
            ground_pitch_rad: row.ground_pitch_rad,
            aircraft_pitch_rad: row.aircraft_pitch_rad,
            nose_kg: row.wheels_kg[0],
            main_right_kg: row.wheels_kg[1],
            main_left_kg: row.wheels_kg[2],
        })
        .collect();
    centre_of_gravity(&rows, wheels).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use doublet_core::load::aircraft;

    #[test]
    fn readings_made_for_a_centre_of_gravity_give_it_back() {
        let text = builtin::text("aircraft", "c337f").unwrap();
        let aircraft = aircraft::parse(text).unwrap();
        let wheels = aircraft.wheels.unwrap();
        // At rest the moments about the datum balance: l_n F_n + l_m F_m = F (x + z tan(pitch)).
        let (mass_kg, x_m, y_m, z_m) = (1400.0, 3.52, 0.02, 1.61);
        let rows = [-4.0_f64, 0.0, 5.0].map(|pitch_deg| {
            let pitch = pitch_deg.to_radians();
            let arm = x_m + z_m * pitch.tan();
            let main = mass_kg * (arm - wheels.nose_x_m) / (wheels.main_x_m - wheels.nose_x_m);
            let apart = mass_kg * y_m / wheels.main_y_m;
            let wheels_kg = [mass_kg - main, 0.5 * (main + apart), 0.5 * (main - apart)];
            ScaleReadings { ground_pitch_rad: pitch, aircraft_pitch_rad: pitch, wheels_kg }
        });
        let empty = ScaleReadings::default();
        let found = weigh(&aircraft, &[rows[0], empty, rows[1], rows[2]]).unwrap();
        for (value, truth) in [(found.mass_kg, mass_kg), (found.x_m, x_m), (found.z_m, z_m), (found.level_y_m, y_m)] {
            assert!((value - truth).abs() < 1e-9 * truth.abs().max(1.0), "{value} is not {truth}");
        }
        assert!(weigh(&aircraft, &rows[..1]).unwrap_err().contains("at least 2"));
        let without = doublet_core::airframe::Aircraft { wheels: None, ..aircraft };
        assert!(weigh(&without, &rows).unwrap_err().contains("[wheels]"));
    }
}
