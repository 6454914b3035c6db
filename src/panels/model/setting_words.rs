//! Settings of a session in the words of the field: names and values as the panels write them.

use doublet_engine::compare::SettingDifference;

use crate::notation;

/// Settings by the keys of the session file; the name of a quantity follows those that end in "of".
const WORDS: [(&str, &str); 46] = [
    ("filter.method", "Filter"),
    ("filter.max_iterations", "Filter iterations"),
    ("filter.tolerance", "Tolerance of the iterations"),
    ("filter.hold", "Input hold"),
    ("filter.linearisation", "Linearisation"),
    ("filter.gravity_m_s2", "Gravity"),
    ("filter.gusts", "Source of the random walk of the wind"),
    ("filter.delays", "Source of the measurement delays"),
    ("filter.spread", "Spread of the sigma points"),
    ("filter.smoother_passes", "Smoother passes"),
    ("filter.outlier_limit", "Outliers beyond, standard deviations"),
    ("filter.robust_limit", "Less weight beyond, standard deviations"),
    ("filter.process_noise", "Process noise of"),
    ("filter.measurement_noise", "Measurement noise of"),
    ("filter.initial_deviation", "Initial standard deviation of"),
    ("filter.initial_state", "Initial value of"),
    ("filter.random_walk", "Random walk of"),
    ("filter.air_data_deviation", "Initial standard deviation of"),
    ("filter.measurement_delay_s", "Delay of"),
    ("preparation.path", "Flight path"),
    ("preparation.differentiation", "Differentiation"),
    ("preparation.differentiation_half_width_s", "Half width of the differentiation"),
    ("preparation.matched_smoothing", "Same smoothing for all signals"),
    ("preparation.actuator_lag_s", "Actuator lag"),
    ("preparation.settle_s", "Settling time left out"),
    ("preparation.origin_altitude_m", "Altitude of the origin"),
    ("preparation.correct_accelerometer", "Accelerometer position corrected"),
    ("preparation.correct_vanes", "Vane position corrected"),
    ("preparation.correct_antenna", "Antenna position corrected"),
    ("preparation.remove_thrust", "Thrust removed"),
    ("preparation.axes", "Axes"),
    ("preparation.moment_reference", "Moments about"),
    ("preparation.gyroscopic", "Gyroscopic moments of the propellers"),
    ("preparation.angular_acceleration", "Angular acceleration"),
    ("sensor_errors.method", "Method of the sensor errors"),
    ("sensor_errors.free", "Sensor errors estimated"),
    ("sensor_errors.per_manoeuvre", "Sensor errors by manoeuvre"),
    ("sensor_errors.outputs", "Measurements for the sensor errors"),
    ("sensor_errors.wind", "Wind with the sensor errors"),
    ("sensor_errors.random_walk", "Random walk of"),
    ("sensor_errors.known", "Known sensor error of"),
    ("estimation.by_surface", "Fit by surface"),
    ("estimation.constants", "Constants"),
    ("estimation.predict_with", "Predictions by"),
    ("estimation.weights", "Weights of the residuals"),
    ("model", "Terms of"),
];
/// Values that have a name of their own.
const VALUES: [(&str, &str); 10] = [
    ("true", "yes"),
    ("false", "no"),
    ("ekf", "extended"),
    ("iekf", "iterated"),
    ("ukf", "unscented"),
    ("first_order", "linear"),
    ("zero_order", "held"),
    ("per_manoeuvre", "per manoeuvre"),
    ("pooled", "pooled estimate"),
    ("manoeuvre_means", "means of single manoeuvres"),
];

/// The setting as it is called in the panels.
pub fn setting_words(setting: &str) -> String {
    if let Some((_, words)) = WORDS.iter().find(|(key, _)| *key == setting) {
        return (*words).to_owned();
    }
    if let Some((name, what)) = setting.strip_prefix("manoeuvre '").and_then(|rest| rest.rsplit_once("'.")) {
        return match what {
            "role" => format!("Use of {name}"),
            "start_s" => format!("Start of {name}"),
            "end_s" => format!("End of {name}"),
            _ => format!("{} of {name}", spaced(what)),
        };
    }
    if let Some((control, what)) =
        setting.strip_prefix("preparation.control_lag.").and_then(|rest| rest.split_once('.'))
    {
        return format!("{} of {control}", if what == "delay_s" { "Delay" } else { "Lag" });
    }
    let quantity = setting.rsplit_once('.').and_then(|(key, name)| {
        let (_, words) = WORDS.iter().find(|(known, words)| *known == key && words.ends_with(" of"))?;
        Some(format!("{words} {name}"))
    });
    quantity.unwrap_or_else(|| spaced(setting))
}

/// One of the values of a setting, in degrees where it is an angle.
pub fn value_words(difference: &SettingDifference, value: Option<&str>) -> String {
    let Some(value) = value else { return "not set".to_owned() };
    let Ok(number) = value.parse::<f64>() else {
        let named = VALUES.iter().find(|(key, _)| *key == value);
        return named.map_or_else(|| value.replace("^2", "²"), |(_, words)| (*words).to_owned());
    };
    let (number, unit) = match difference.unit.strip_prefix("rad") {
        Some(per) => (number.to_degrees(), format!("deg{per}")),
        None => (number, difference.unit.clone()),
    };
    format!("{} {unit}", notation::number(number)).trim_end().to_owned()
}

/// Keys as words.
fn spaced(keys: &str) -> String {
    let words = keys.replace('.', ", ").replace('_', " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
