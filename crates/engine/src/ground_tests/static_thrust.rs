//! Static thrust from the pull on a cable, beside the thrust of the engine charts and propeller maps.

use std::path::Path;

use doublet_core::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2, density_kg_m3};
use doublet_core::propulsion::{Ambient, EngineInput, Powerplant};
use serde::{Deserialize, Serialize};

use super::{interval_95, within};
use crate::toml_file;

/// Value of the `format` key.
const FORMAT: &str = "doublet static thrust";
/// Version of the form.
const VERSION: u32 = 1;
/// Pressure of an inch of mercury, Pa.
const IN_HG_PA: f64 = 3386.389;
/// Temperature of 0 degC, K.
const ZERO_C_K: f64 = 273.15;

/// A static thrust test as its file states it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticThrustFile {
    format: String,
    version: u32,
    /// Aircraft with its engines: a file, or `builtin:` and a name.
    pub aircraft: String,
    /// Mass, kg: of a slope only.
    #[serde(default)]
    mass_kg: f64,
    /// Slope of the ground, uphill in the direction of the thrust, deg.
    #[serde(default)]
    slope_deg: f64,
    /// Angle of the cable to the ground, deg.
    #[serde(default)]
    cable_deg: f64,
    /// Angle of the thrust to the ground, nose up, deg.
    #[serde(default)]
    thrust_deg: f64,
    /// Bound of the rolling friction to either side, N.
    #[serde(default)]
    friction_n: f64,
    #[serde(rename = "reading")]
    readings: Vec<Reading>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reading {
    /// Pull on the cable, N.
    force_n: f64,
    /// Its standard error, N.
    force_error_n: f64,
    /// Speed of each engine, rev/min.
    engine_speed_rpm: Vec<f64>,
    /// Manifold pressure of each engine, inHg.
    manifold_pressure_inhg: Vec<f64>,
    static_pressure_pa: f64,
    /// Air temperature, degC.
    air_temperature_c: f64,
    /// Wind against the thrust, m/s.
    #[serde(default)]
    headwind_m_s: f64,
}

/// One reading evaluated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PulledReading {
    /// Thrust of all engines by the pull, N.
    pub thrust_n: f64,
    /// Its standard error by the force, N.
    pub standard_error_n: f64,
    /// Thrust of all engines by their models, N.
    pub model_n: f64,
    /// Measured over model.
    pub ratio: f64,
    /// Thrust over density, square of the speed and fourth power of the diameter of all propellers.
    pub thrust_coefficient: f64,
    /// Air density, kg/m³.
    pub density_kg_m3: f64,
    /// Inputs beyond a chart or a map.
    pub off_range: Vec<String>,
}

/// What a static thrust test gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pulled {
    pub readings: Vec<PulledReading>,
    /// Factor of the thrust of the models, by weighted least squares through the origin.
    pub factor: f64,
    /// Its standard error: scatter and force, and friction, which all readings share.
    pub factor_error: f64,
    /// 95 % interval of the factor.
    pub factor_interval: [f64; 2],
    /// Whether the interval contains one.
    pub model_agrees: bool,
    /// Square root of the mean square of the residuals, N.
    pub residual_n: f64,
    /// Error of the thrust by friction, which all readings share, N.
    pub friction_error_n: f64,
}

impl StaticThrustFile {
    /// Reads a file.
    pub fn open(path: &Path) -> Result<Self, String> {
        toml_file::open(path, Self::parse)
    }

    /// Reads the text of a file.
    pub fn parse(text: &str) -> Result<Self, String> {
        let file: Self = toml_file::parse(text, (FORMAT, VERSION), |file: &Self| (&file.format, file.version))?;
        if file.readings.is_empty() {
            return Err("it has no [[reading]]: add one".to_owned());
        }
        Ok(file)
    }

    /// Thrust of every reading beside that of the models, and the factor between them.
    pub fn evaluate(&self, powerplant: &Powerplant) -> Result<Pulled, String> {
        within("slope_deg", self.slope_deg, (-10.0, 10.0), "deg")?;
        within("cable_deg", self.cable_deg, (-60.0, 60.0), "deg")?;
        within("thrust_deg", self.thrust_deg, (-30.0, 30.0), "deg")?;
        within("friction_n", self.friction_n, (0.0, 1e6), "N")?;
        within("mass_kg", self.mass_kg, (0.0, 1e6), "kg")?;
        if self.slope_deg != 0.0 && self.mass_kg == 0.0 {
            return Err("a slope needs mass_kg".to_owned());
        }
        let read = |(place, reading): (usize, &Reading)| {
            self.reading(reading, powerplant).map_err(|error| format!("reading {}: {error}", place + 1))
        };
        let readings = self.readings.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
        // A bound to either side is a uniform distribution of its width over the root of twelve.
        let friction_error_n = self.friction_n / 3f64.sqrt() / self.thrust_deg.to_radians().cos();
        let weight = |row: &PulledReading| row.standard_error_n.powi(-2);
        let over = |of: &dyn Fn(&PulledReading) -> f64| readings.iter().map(|row| weight(row) * of(row)).sum::<f64>();
        let square = over(&|row| row.model_n * row.model_n);
        let factor = over(&|row| row.model_n * row.thrust_n) / square;
        let residuals = readings.iter().map(|row| row.thrust_n - factor * row.model_n);
        let free = readings.len().saturating_sub(1);
        // Scatter beyond that of the force enlarges the error; less of it does not reduce it.
        let chi_squared = over(&|row| (row.thrust_n - factor * row.model_n).powi(2));
        let scatter = if free > 0 { (chi_squared / free as f64).max(1.0) } else { 1.0 };
        let common = friction_error_n * over(&|row| row.model_n) / square;
        let factor_error = (scatter / square + common * common).sqrt();
        let factor_interval = interval_95(factor, factor_error);
        Ok(Pulled {
            factor,
            factor_error,
            factor_interval,
            model_agrees: (factor_interval[0]..=factor_interval[1]).contains(&1.0),
            residual_n: (residuals.map(|own| own * own).sum::<f64>() / readings.len() as f64).sqrt(),
            friction_error_n,
            readings,
        })
    }

    fn reading(&self, reading: &Reading, powerplant: &Powerplant) -> Result<PulledReading, String> {
        within("force_n", reading.force_n, (1.0, 1e7), "N")?;
        within("force_error_n", reading.force_error_n, (1e-3, 1e6), "N")?;
        within("static_pressure_pa", reading.static_pressure_pa, (4e4, 1.1e5), "Pa")?;
        within("air_temperature_c", reading.air_temperature_c, (-60.0, 60.0), "degC")?;
        within("headwind_m_s", reading.headwind_m_s, (0.0, 20.0), "m/s")?;
        let count = powerplant.engines.len();
        for (key, values) in [
            ("engine_speed_rpm", &reading.engine_speed_rpm),
            ("manifold_pressure_inhg", &reading.manifold_pressure_inhg),
        ] {
            if values.len() != count {
                return Err(format!("{key} has {} values, the aircraft {count} engines", values.len()));
            }
        }
        let air_temperature_k = reading.air_temperature_c + ZERO_C_K;
        let density_kg_m3 =
            density_kg_m3(reading.static_pressure_pa, air_temperature_k).map_err(|error| error.to_string())?;
        let pressure_altitude_m =
            Atmosphere::STANDARD.altitude_m(reading.static_pressure_pa).map_err(|error| error.to_string())?;
        let ambient =
            Ambient { airspeed_m_s: reading.headwind_m_s, pressure_altitude_m, air_temperature_k, density_kg_m3 };
        let (mut model_n, mut disc, mut off_range) = (0.0, 0.0, Vec::new());
        for (place, engine) in powerplant.engines.iter().enumerate() {
            let name = &engine.station.name;
            let model = engine.model.as_ref().ok_or_else(|| format!("engine {name} has no chart and propeller map"))?;
            let speed_rev_s =
                within("engine_speed_rpm", reading.engine_speed_rpm[place], (0.0, 1e5), "rev/min")? / 60.0;
            let pressure_inhg =
                within("manifold_pressure_inhg", reading.manifold_pressure_inhg[place], (0.1, 100.0), "inHg")?;
            let input = EngineInput {
                speed_rad_s: speed_rev_s * std::f64::consts::TAU,
                manifold_pressure_pa: pressure_inhg * IN_HG_PA,
            };
            let state = model.state(input, &ambient);
            model_n += state.thrust_n * engine.station.incidence_rad.cos();
            disc += speed_rev_s.powi(2) * model.propeller.diameter_m().powi(4);
            off_range.extend(state.off_range.iter().map(|found| format!("engine {name}: {found}")));
        }
        if !(model_n.is_finite() && model_n > 0.0) {
            return Err(format!("the models give a thrust of {model_n:.0} N"));
        }
        let cosine = self.thrust_deg.to_radians().cos();
        let cable = self.cable_deg.to_radians().cos();
        let weight_n = self.mass_kg * STANDARD_GRAVITY_M_S2 * self.slope_deg.to_radians().sin();
        let thrust_n = (reading.force_n * cable + weight_n) / cosine;
        Ok(PulledReading {
            thrust_n,
            standard_error_n: reading.force_error_n * cable / cosine,
            model_n,
            ratio: thrust_n / model_n,
            thrust_coefficient: thrust_n / (density_kg_m3 * disc),
            density_kg_m3,
            off_range,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Context;
    use crate::stage::load_aircraft;

    const HEAD: &str = "format = \"doublet static thrust\"\nversion = 1\naircraft = \"builtin:c337f\"\n";

    fn powerplant() -> Powerplant {
        load_aircraft(&Context::new(Path::new(".")), "builtin:c337f").unwrap().powerplant.clone()
    }

    fn reading(force_n: f64, rpm: f64, inhg: f64) -> String {
        format!(
            "[[reading]]\nforce_n = {force_n:?}\nforce_error_n = 20.0\nengine_speed_rpm = [{rpm:?}, {rpm:?}]\n\
             manifold_pressure_inhg = [{inhg:?}, {inhg:?}]\nstatic_pressure_pa = 101325.0\nair_temperature_c = 23.5\n"
        )
    }

    #[test]
    fn pull_made_from_the_models_gives_their_factor_back_with_its_error() {
        let powerplant = powerplant();
        let settings = [(2500.0, 24.0), (2600.0, 25.5), (2700.0, 27.0), (2750.0, 27.5)];
        let evaluate = |text: String| StaticThrustFile::parse(&text).unwrap().evaluate(&powerplant).unwrap();
        let plain: String = settings.iter().map(|(rpm, inhg)| reading(5000.0, *rpm, *inhg)).collect();
        let models: Vec<f64> = evaluate(HEAD.to_owned() + &plain).readings.iter().map(|row| row.model_n).collect();
        // 0.93 of the model, the cable 8 deg off the ground, 1 deg uphill, the thrust 2 deg nose up: F = (T cos 2 - m g sin 1) / cos 8.
        let deg = |degrees: f64| degrees.to_radians();
        let weight = 1500.0 * STANDARD_GRAVITY_M_S2 * deg(1.0).sin();
        let made: String = settings
            .iter()
            .zip(&models)
            .map(|((rpm, inhg), model)| reading((0.93 * model * deg(2.0).cos() - weight) / deg(8.0).cos(), *rpm, *inhg))
            .collect();
        let angles = "mass_kg = 1500.0\nslope_deg = 1.0\ncable_deg = 8.0\nthrust_deg = 2.0\nfriction_n = 100.0\n";
        let found = evaluate(HEAD.to_owned() + angles + &made);
        assert!((found.factor - 0.93).abs() < 1e-12 && !found.model_agrees && found.residual_n < 1e-6, "{found:?}");
        // By hand: force alone, and friction of 100 / sqrt(3) N common to all readings.
        let square: f64 = models.iter().map(|own| own * own).sum();
        let force = 20.0 * deg(8.0).cos() / deg(2.0).cos() / square.sqrt();
        let friction = 100.0 / 3f64.sqrt() / deg(2.0).cos() * models.iter().sum::<f64>() / square;
        assert!((found.factor_error / force.hypot(friction) - 1.0).abs() < 1e-9, "{}", found.factor_error);
        // C_T of both propellers of 1.92 m at 2700 rev/min.
        let row = &found.readings[2];
        let expected = row.thrust_n / (row.density_kg_m3 * 2.0 * 45f64.powi(2) * 1.92f64.powi(4));
        assert!((row.thrust_coefficient / expected - 1.0).abs() < 1e-12, "{} for {expected}", row.thrust_coefficient);
        assert!((row.density_kg_m3 - 101_325.0 / (287.053 * 296.65)).abs() < 1e-4);
    }

    #[test]
    fn tests_that_cannot_be_are_refused() {
        let refused =
            |text: String| StaticThrustFile::parse(&text).and_then(|file| file.evaluate(&powerplant()).map(|_| ()));
        let of = |text: String| refused(text).unwrap_err();
        assert!(of(HEAD.to_owned() + "reading = []").contains("no [[reading]]"));
        assert!(of(HEAD.to_owned() + "slope_deg = 1.0\n" + &reading(5000.0, 2600.0, 26.0)).contains("mass_kg"));
        let one = reading(5000.0, 2600.0, 26.0).replace("[2600.0, 2600.0]", "[2600.0]");
        assert!(of(HEAD.to_owned() + &one).contains("1 values, the aircraft 2 engines"));
        assert!(of(HEAD.to_owned() + &reading(-1.0, 2600.0, 26.0)).contains("reading 1: force_n is -1"));
    }
}
