//! A sweep: settings of a session and the values each is to have, every combination a run.

use doublet_core::schema::{Refused, schema_of};
use doublet_core::toml_error;
use serde::Deserialize;
use toml::{Table, Value};

use crate::session::{Session, from_table, to_table};

/// Value of the `format` key of a sweep file.
pub const FORMAT: &str = "doublet sweep";
const VERSION: u32 = 1;
/// Most runs of one sweep: a slip of the pen does not fill memory.
const MOST: usize = 50_000;

/// A sweep as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    #[serde(rename = "format")]
    _format: String,
    version: u32,
    /// Session file, relative to the sweep.
    pub session: String,
    #[serde(rename = "vary")]
    varied: Vec<Varied>,
}

/// A setting and its values.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Varied {
    setting: String,
    values: Vec<Value>,
}

/// A step on the way to a setting: a key, or the entry of a list by its name.
enum Step<'a> {
    Key(&'a str),
    Named(&'a str, &'a str),
}

/// Settings a combination has, by name, and the session with them or why there is none.
pub(crate) type Combination = (Vec<(String, String)>, Result<Session, String>);

impl Sweep {
    /// JSON Schema of sweeps.
    pub fn schema() -> Result<serde_json::Value, Refused> {
        schema_of::<Self>(FORMAT)
    }

    /// Reads a sweep from its text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let sweep: Self = toml::from_str(text).map_err(|error| toml_error::one_line(text, &error))?;
        if sweep.version > VERSION {
            return Err(format!("sweep version {} is newer than this program understands ({VERSION})", sweep.version));
        }
        for varied in &sweep.varied {
            steps(&varied.setting)?;
            if varied.values.is_empty() {
                return Err(format!("'{}' has no values", varied.setting));
            }
        }
        let runs = sweep.varied.iter().try_fold(1_usize, |runs, varied| runs.checked_mul(varied.values.len()));
        match runs {
            Some(runs) if runs <= MOST => Ok(sweep),
            _ => Err(format!("the sweep has more than {MOST} combinations: split it")),
        }
    }

    /// Refuses a setting that the session cannot have with any of its values.
    pub fn check(&self, base: &Session) -> Result<(), String> {
        for varied in &self.varied {
            let mut tried =
                varied.values.iter().map(|value| changed(base, [(varied.setting.as_str(), value)].into_iter()));
            if let Some(Err(error)) = tried.next()
                && tried.all(|other| other.is_err())
            {
                return Err(format!("setting '{}': {}", varied.setting, error));
            }
        }
        Ok(())
    }

    /// Every combination: the settings it has, and the session with them or why there is none. The last setting varies fastest.
    pub fn sessions(&self, base: &Session) -> Vec<Combination> {
        let mut combinations: Vec<Vec<&Value>> = vec![Vec::new()];
        for varied in &self.varied {
            combinations = combinations
                .iter()
                .flat_map(|chosen| varied.values.iter().map(|value| [chosen.as_slice(), &[value]].concat()))
                .collect();
        }
        let one = |values: Vec<&Value>| {
            let settings = self.varied.iter().map(|varied| varied.setting.as_str()).zip(values);
            let named = settings.clone().map(|(setting, value)| (setting.to_owned(), plain(value))).collect();
            (named, changed(base, settings))
        };
        combinations.into_iter().map(one).collect()
    }
}

/// A value as text, without the quotes of text.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The session with settings changed in its saved form, which is then read as any other.
fn changed<'a>(base: &Session, settings: impl Iterator<Item = (&'a str, &'a Value)>) -> Result<Session, String> {
    let mut table = to_table(base).map_err(|error| error.to_string())?;
    for (setting, value) in settings {
        set(&mut table, &steps(setting)?, value).ok_or_else(|| format!("the session has no setting '{setting}'"))?;
    }
    from_table(table).map_err(|error| error.to_string())
}

/// Steps of a name as `doublet diff` prints it: keys with dots between them, `manoeuvre 'e1'` for the entry of a list.
fn steps(setting: &str) -> Result<Vec<Step<'_>>, String> {
    let mut steps = Vec::new();
    let mut rest = setting;
    while !rest.is_empty() {
        let end = rest.find(['.', '\'']).unwrap_or(rest.len());
        let (key, after) = rest.split_at(end);
        if let Some(quoted) = after.strip_prefix('\'') {
            let (name, after) = quoted.split_once('\'').ok_or_else(|| format!("'{setting}' has an open quote"))?;
            // Older sweeps call a manoeuvre a window.
            let list = if key.trim() == "window" { "manoeuvre" } else { key.trim() };
            steps.push(Step::Named(list, name));
            rest = after.strip_prefix('.').unwrap_or(after);
        } else {
            steps.push(Step::Key(key.trim()));
            rest = after.strip_prefix('.').unwrap_or(after);
        }
    }
    match steps.last() {
        Some(Step::Key(key)) if !key.is_empty() => Ok(steps),
        _ => Err(format!("'{setting}' names no setting: write it as `doublet diff` does")),
    }
}

/// Puts `value` where `steps` lead; `None` where they lead nowhere. Whether the last key exists is for the session to say.
fn set(table: &mut Table, steps: &[Step<'_>], value: &Value) -> Option<()> {
    match steps {
        [] => None,
        [Step::Key(key)] => {
            table.insert((*key).to_owned(), value.clone());
            Some(())
        }
        [Step::Key(key), rest @ ..] => {
            let next = table.entry(*key).or_insert_with(|| Value::Table(Table::new()));
            set(next.as_table_mut()?, rest, value)
        }
        [Step::Named(list, name), rest @ ..] => {
            let entries = table.get_mut(*list)?.as_array_mut()?.iter_mut().filter_map(Value::as_table_mut);
            let mut named = entries.filter(|entry| crate::compare::entry_name(entry) == Some(name));
            set(named.next()?, rest, value)
        }
    }
}
