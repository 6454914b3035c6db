//! Settings of a session in the words of the field: names and values as the panels write them.

use doublet_engine::compare::SettingDifference;

use crate::notation;

/// What a key of the session file, or one of its values, is called.
fn words(key: &str) -> Option<&'static str> {
    include_str!("setting_words.txt").lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "))
}

/// The setting as it is called in the panels.
pub fn setting_words(setting: &str) -> String {
    if let Some(words) = words(setting) {
        return words.to_owned();
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
        let words = words(key).filter(|words| words.ends_with(" of"))?;
        Some(format!("{words} {name}"))
    });
    quantity.unwrap_or_else(|| spaced(setting))
}

/// One of the values of a setting, in degrees where it is an angle.
pub fn value_words(difference: &SettingDifference, value: Option<&str>) -> String {
    let Some(value) = value else { return "not set".to_owned() };
    let Ok(number) = value.parse::<f64>() else {
        let is_terms = difference.setting.starts_with("model.");
        let shown = || if is_terms { notation::term(value) } else { notation::raise_powers(value) };
        return words(value).map_or_else(shown, str::to_owned);
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
