//! `doublet diff`: two sessions or two runs side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::compare::{
    DerivativeDifference, Estimates, Interval, SettingDifference, differences, estimates_of, read_estimates, settings,
};
use doublet_engine::report::{self, Cell, Column, Table, TableOf};
use doublet_engine::session::{self, Session};

use crate::{run, text};

#[derive(Debug, Args)]
pub struct DiffArguments {
    /// Session (will be run) or folder of results.
    pub first: PathBuf,
    /// Session or folder to compare with.
    pub second: PathBuf,
    /// Compare settings only, without a run.
    #[arg(long)]
    pub settings: bool,
    /// Print CSV.
    #[arg(long, conflicts_with = "json")]
    pub csv: bool,
}

/// What is said below the table of derivatives.
const CAVEAT: &str = "z: difference over its combined corrected standard error; p: probability of such a z without a difference. \
                      Both assume independent runs; if the runs share data, a difference is more significant than p.";

/// One side of the comparison; what a folder of results does not hold is absent.
struct Side {
    session: Option<Session>,
    estimates: Option<Estimates>,
}

/// Compares and prints.
pub fn diff(arguments: &DiffArguments) -> Result<(), String> {
    let side = |path| Side::open(path, arguments.settings);
    let (first, second) = (side(&arguments.first)?, side(&arguments.second)?);
    let differing = match (&first.session, &second.session) {
        (Some(first), Some(second)) => Some(settings(first, second).map_err(|error| error.to_string())?),
        _ => None,
    };
    let derivatives = match (&first.estimates, &second.estimates) {
        (Some(first), Some(second)) => Some(differences(first, second)),
        _ => None,
    };
    text::json(&serde_json::json!({ "settings": differing, "derivatives": derivatives, "note": CAVEAT }))?;
    if arguments.csv {
        csv(differing.as_deref().unwrap_or_default(), derivatives.as_deref().unwrap_or_default())?;
    } else {
        print_settings(differing.as_deref());
        derivatives.as_deref().into_iter().for_each(print_derivatives);
    }
    Ok(())
}

impl Side {
    fn open(path: &Path, settings_only: bool) -> Result<Self, String> {
        if path.is_dir() {
            let session = path.join("session.toml");
            let session = session.is_file().then(|| session::open(&session)).transpose();
            let session = session.map_err(|error| format!("{}: {error}", path.display()))?;
            let estimates = if settings_only { None } else { Some(read_estimates(path)?) };
            return Ok(Self { session: session.map(|opened| opened.session), estimates });
        }
        if settings_only {
            let opened = session::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok(Self { session: Some(opened.session), estimates: None });
        }
        let (session, snapshot) = run::computed(path, &[])?;
        let estimates = estimates_of(&report::build(&session, &snapshot))?;
        Ok(Self { session: Some(session), estimates: Some(estimates) })
    }
}

fn print_settings(differing: Option<&[SettingDifference]>) {
    match differing {
        None => text::line("settings are not compared: a folder of results has no session.toml"),
        Some([]) => text::line("no setting differs"),
        Some(rows) => {
            let table = TableOf::new("settings", "Settings that differ.", rows)
                .text("setting", "setting", |row| &row.setting)
                .text("unit", "unit", |row| &row.unit)
                .optional("first", "first", |row| row.first.as_deref())
                .optional("second", "second", |row| row.second.as_deref());
            text::show(&table.done());
        }
    }
}

fn print_derivatives(rows: &[DerivativeDifference]) {
    let half = |interval: Option<Interval>| interval.map(|it| it.high - it.estimate);
    let table = TableOf::new("derivatives", "Derivatives side by side.", rows)
        .symbol("derivative", "derivative", |row| &row.name)
        .maybe("first", "first", "", 5, |row| Some(row.first?.estimate))
        .maybe("first_half", "± 95 %", "", 2, |row| half(row.first))
        .maybe("second", "second", "", 5, |row| Some(row.second?.estimate))
        .maybe("second_half", "± 95 %", "", 2, |row| half(row.second))
        .maybe("z", "z", "", 3, |row| row.z)
        .maybe("p", "p", "", 3, |row| row.p);
    text::line("");
    text::show(&table.done());
    text::line(CAVEAT);
}

/// Columns of the CSV.
const COLUMNS: [&str; 11] =
    ["kind", "name", "unit", "first", "first_low", "first_high", "second", "second_low", "second_high", "z", "p"];

/// One table for both: settings first, then derivatives.
fn csv(differing: &[SettingDifference], derivatives: &[DerivativeDifference]) -> Result<(), String> {
    let word = |value: &Option<String>| value.as_ref().map_or(Cell::Empty, Cell::text);
    let settings = differing.iter().map(|row| {
        let [first, second] = [&row.first, &row.second].map(word);
        let words = [Cell::text("setting"), Cell::text(&row.setting), Cell::text(&row.unit), first];
        let rest = [Cell::Empty, Cell::Empty, second, Cell::Empty, Cell::Empty, Cell::Empty, Cell::Empty];
        words.into_iter().chain(rest).collect()
    });
    let derivatives = derivatives.iter().map(|row| {
        let three = |it: Option<Interval>| [it.map(|it| it.estimate), it.map(|it| it.low), it.map(|it| it.high)];
        let numbers = three(row.first).into_iter().chain(three(row.second)).chain([row.z, row.p]);
        let words = [Cell::text("derivative"), Cell::text(&row.name), Cell::Empty];
        words.into_iter().chain(numbers.map(|number| number.map_or(Cell::Empty, Cell::Number))).collect()
    });
    let (name, caption) = ("diff".to_owned(), String::new());
    let columns = COLUMNS.map(|key| Column::new(key, "")).into();
    let table = Table { name, caption, columns, rows: settings.chain(derivatives).collect() };
    let bytes = report::csv(&table).map_err(|error| error.to_string())?;
    text::document(String::from_utf8_lossy(&bytes).trim_end());
    Ok(())
}
