//! `doublet diff`: two sessions or two runs side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::compare::{
    DerivativeDifference, Estimates, Interval, SettingDifference, differences, estimates_of, read_estimates, settings,
};
use doublet_engine::report;
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
    /// Print JSON.
    #[arg(long, conflicts_with = "csv")]
    pub json: bool,
    /// Print CSV.
    #[arg(long)]
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
///
/// # Errors
/// One line per thing that is wrong with either.
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
    if arguments.json {
        let all = serde_json::json!({ "settings": differing, "derivatives": derivatives, "note": CAVEAT });
        text::document(&serde_json::to_string_pretty(&all).map_err(|error| error.to_string())?);
    } else if arguments.csv {
        csv(differing.as_deref().unwrap_or_default(), derivatives.as_deref().unwrap_or_default());
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
            let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "-".to_owned());
            let rows: Vec<_> = rows
                .iter()
                .map(|row| vec![row.setting.clone(), row.unit.clone(), value(&row.first), value(&row.second)])
                .collect();
            text::table(&["setting", "unit", "first", "second"], &rows);
        }
    }
}

fn print_derivatives(rows: &[DerivativeDifference]) {
    let interval = |interval: &Option<Interval>| match interval {
        Some(it) => [text::number(it.estimate, 5), format!("± {}", text::number(it.high - it.estimate, 2))],
        None => ["-".to_owned(), String::new()],
    };
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| text::number(value, 3));
    let cells = rows.iter().map(|row| {
        let ([first, first_half], [second, second_half]) = (interval(&row.first), interval(&row.second));
        vec![row.name.clone(), first, first_half, second, second_half, number(row.z), number(row.p)]
    });
    text::line("");
    text::table(&["derivative", "first", "95 %", "second", "95 %", "z", "p"], &cells.collect::<Vec<_>>());
    text::line(CAVEAT);
}

/// One table for both: settings first, then derivatives.
fn csv(differing: &[SettingDifference], derivatives: &[DerivativeDifference]) {
    let quoted = |cell: &str| {
        if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
    };
    let print =
        |cells: Vec<String>| text::document(&cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(","));
    let header =
        ["kind", "name", "unit", "first", "first_low", "first_high", "second", "second_low", "second_high", "z", "p"];
    print(header.map(str::to_owned).to_vec());
    let none = String::new;
    for row in differing {
        let [first, second] = [&row.first, &row.second].map(|value| value.clone().unwrap_or_default());
        let (setting, unit) = (row.setting.clone(), row.unit.clone());
        print(vec!["setting".into(), setting, unit, first, none(), none(), second, none(), none(), none(), none()]);
    }
    let number = |value: Option<f64>| value.filter(|value| value.is_finite()).map_or_else(none, |v| v.to_string());
    for row in derivatives {
        let three = |it: Option<Interval>| [it.map(|it| it.estimate), it.map(|it| it.low), it.map(|it| it.high)];
        let mut cells = vec!["derivative".to_owned(), row.name.clone(), none()];
        cells.extend(three(row.first).into_iter().chain(three(row.second)).chain([row.z, row.p]).map(number));
        print(cells);
    }
}
