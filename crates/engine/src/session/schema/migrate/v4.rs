//! Version 4 called a manoeuvre a window.

use toml::{Table, Value};

/// Renames the keys and choices of windows, in the session and in its experiments.
pub(crate) fn to_v5(session: &mut Table) {
    rename(session);
    let experiments = session.get_mut("experiment").and_then(Value::as_array_mut);
    experiments.into_iter().flatten().filter_map(Value::as_table_mut).for_each(|experiment| {
        rename(experiment);
        let unset = experiment.get_mut("unset").and_then(Value::as_array_mut);
        choose(unset.into_iter().flatten(), "sensor_errors.per_window", "sensor_errors.per_manoeuvre");
    });
}

fn rename(table: &mut Table) {
    if let Some(windows) = table.remove("window") {
        table.insert("manoeuvre".to_owned(), windows);
    }
    if let Some(Value::Table(errors)) = table.get_mut("sensor_errors")
        && let Some(own) = errors.remove("per_window")
    {
        errors.insert("per_manoeuvre".to_owned(), own);
    }
    if let Some(Value::Table(estimation)) = table.get_mut("estimation") {
        choose(estimation.get_mut("constants").into_iter(), "per_window", "per_manoeuvre");
        choose(estimation.get_mut("predict_with").into_iter(), "window_means", "manoeuvre_means");
    }
}

/// Renames a choice where it was made.
fn choose<'a>(values: impl Iterator<Item = &'a mut Value>, old: &str, new: &str) {
    values.filter(|value| value.as_str() == Some(old)).for_each(|value| *value = new.into());
}
