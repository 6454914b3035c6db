//! `doublet compare`: the experiments of a session side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::model::Coefficient;
use doublet_engine::compare::{CoefficientOutcome, ExperimentRow};
use doublet_engine::graph::{Cache, Context};
use doublet_engine::run::{ExperimentRows, Slot, experiment_rows};
use doublet_engine::session::{
    self, Edit, Experiment, ExperimentEdit, Place, Session, cross_experiments, filter_experiments,
    manoeuvre_experiments, noise_experiments, structure_experiments,
};
use doublet_engine::verdict::list_failures;
use serde_json::json;

use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{CACHE_BYTES, open_to_run, print_error, rebase};
use crate::text;

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Session file.
    pub session: PathBuf,
    /// Add experiments: filters, noise, manoeuvres, a coefficient; two crossed by *.
    #[arg(long, value_name = "FAMILY,FAMILY", value_delimiter = ',')]
    pub with: Vec<Family>,
    /// Write the session with the added experiments to this file.
    #[arg(long, short, value_name = "FILE", requires = "with", value_parser = output_path())]
    pub output: Option<PathBuf>,
}

/// Experiments that are usual.
#[derive(Clone, Debug)]
pub enum Family {
    /// Every filter with the smoothed, the filtered and the measured path.
    Filters,
    /// Half and twice the noise of the measurements.
    Noise,
    /// Every second manoeuvre.
    Manoeuvres,
    /// The structure without each term of a coefficient.
    Terms(Coefficient),
    /// Each of the first with the manoeuvres of each of the second.
    Crossed(Box<[Self; 2]>),
}

impl std::str::FromStr for Family {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((first, second)) = text.split_once('*') {
            return Ok(Self::Crossed(Box::new([first.parse()?, second.parse()?])));
        }
        match text {
            "filters" => Ok(Self::Filters),
            "noise" => Ok(Self::Noise),
            "manoeuvres" => Ok(Self::Manoeuvres),
            name => Coefficient::from_name(name).map(Self::Terms).ok_or_else(|| {
                let all = Coefficient::ALL.map(Coefficient::name).join(", ");
                format!("'{name}' is not a family: use filters, noise, manoeuvres or a coefficient ({all})")
            }),
        }
    }
}

impl Family {
    fn experiments(&self, session: &Session) -> Vec<Experiment> {
        match self {
            Self::Manoeuvres => manoeuvre_experiments(session),
            Self::Crossed(both) => {
                let [first, second] = &**both;
                cross_experiments(&first.experiments(session), &second.experiments(session))
            }
            Self::Filters => filter_experiments(session),
            Self::Noise => noise_experiments(session),
            Self::Terms(coefficient) => structure_experiments(session, *coefficient),
        }
    }
}

/// Computes every experiment and prints a row each.
pub fn compare(arguments: &CompareArguments) -> Result<(), String> {
    let opened = open_to_run(&arguments.session)?;
    if let Some(target) = &arguments.output {
        session::check_output(&opened.session, &opened.folder, target)?;
    }
    let add = |session: Session, family: &Family| {
        let added = ExperimentEdit::Add(family.experiments(&session));
        Edit::Experiment(added).apply(&session).map_err(|error| error.to_string())
    };
    let session = arguments.with.iter().try_fold(opened.session, add)?;
    if session.experiments.is_empty() {
        return Err("the session has no experiments: save some in the panel Experiments, or add --with filters".into());
    }
    let progress = Progress::new();
    let cache = Cache::new(CACHE_BYTES);
    let context = Context::new(&opened.folder).with_cache(&cache);
    let total = session.experiments.len() as f32 + 1.0;
    let show = |rows: &ExperimentRows| {
        let part = |slot: &Slot<ExperimentRow>| match slot {
            Slot::Running { progress, .. } => *progress,
            _ => 1.0,
        };
        let done: f32 = rows.0.iter().map(|(_, slot)| part(slot)).sum();
        progress.update(done / total, "computing experiments");
    };
    let mut rows = ExperimentRows::default();
    let computed = experiment_rows(&session, &mut rows, &context, &show);
    progress.finish();
    computed.map_err(|error| error.to_string())?;
    print(&rows)?;
    let Some(target) = &arguments.output else { return Ok(()) };
    let session = rebase(&session, &opened.folder, target.parent().unwrap_or(Path::new("")))?;
    session::save(&session, target).map_err(|error| error.to_string())?;
    text::line(&format!("written to {}", target.display()));
    Ok(())
}

fn print(rows: &ExperimentRows) -> Result<(), String> {
    let ready: Vec<&ExperimentRow> = rows.0.iter().filter_map(|(_, slot)| slot.ready()).map(AsRef::as_ref).collect();
    let failed: Vec<_> = rows.0.iter().filter_map(|(name, slot)| Some((name, slot.error()?))).collect();
    let failures: Vec<_> =
        failed.iter().map(|(name, error)| (Place::from(name.as_str()), (*error).to_owned())).collect();
    let failures = list_failures(&failures);
    if ready.is_empty() && !failures.is_empty() {
        return Err(failures.join("\nerror: "));
    }
    failures.iter().for_each(|failure| print_error(failure));
    if text::is_json() {
        let failed: Vec<_> = failed.iter().map(|(name, error)| json!({ "name": name, "error": error })).collect();
        let all = json!({ "experiments": ready, "failed": failed });
        return text::json(&all);
    }
    let header =
        ["experiment", "verdict", "good", "caution", "bad", "NIS", "dAIC", "validation error", "settings that differ"];
    text::table(&header, &ready.iter().map(|row| overview(row)).collect::<Vec<_>>());
    for coefficient in Coefficient::ALL {
        let name = coefficient.name();
        let own: Vec<_> = ready.iter().filter_map(|row| Some((*row, row.outcome.coefficient(name)?))).collect();
        if !own.is_empty() {
            print_coefficient(name, &own);
        }
    }
    text::line("95 % intervals from corrected standard errors. dAIC is shown only for fits of the same samples.");
    Ok(())
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| text::number(value, digits))
}

fn overview(row: &ExperimentRow) -> Vec<String> {
    let outcome = &row.outcome;
    let verdict = outcome.verdict;
    let counts = [verdict.good, verdict.caution, verdict.bad].map(|count| count.to_string());
    let differing = match row.differences.as_slice() {
        [] => "none".to_owned(),
        [one] => one.setting.clone(),
        [first, rest @ ..] => format!("{} and {} more", first.setting, rest.len()),
    };
    let mut cells = vec![row.name.clone(), verdict.level.name().to_owned()];
    cells.extend(counts);
    cells.extend([number(outcome.nis, 3), number(row.delta_akaike, 4), number(outcome.validation_error, 3), differing]);
    cells
}

/// The fits and derivatives of one coefficient, a row per experiment.
fn print_coefficient(name: &str, rows: &[(&ExperimentRow, &CoefficientOutcome)]) {
    let mut names: Vec<&str> = Vec::new();
    for derivative in rows.iter().flat_map(|(_, outcome)| &outcome.derivatives) {
        if !names.contains(&derivative.name.as_str()) {
            names.push(&derivative.name);
        }
    }
    let cells = rows.iter().map(|(row, outcome)| {
        let fit = outcome.fit.as_ref();
        let figures = [
            fit.map(|fit| fit.r_squared),
            fit.and_then(|fit| fit.honest_r_squared),
            fit.and_then(|fit| fit.delta_akaike),
        ];
        std::iter::once(row.name.clone())
            .chain(figures.into_iter().map(|value| number(value, 4)))
            .chain(names.iter().map(|name| describe_interval(outcome, name)))
            .collect()
    });
    let mut header = vec![name, "R2", "honest R2", "dAIC"];
    header.extend(&names);
    text::line("");
    text::table(&header, &cells.collect::<Vec<Vec<String>>>());
}

fn describe_interval(outcome: &CoefficientOutcome, name: &str) -> String {
    let found = outcome.derivatives.iter().find(|derivative| derivative.name == name);
    found.map_or("-".to_owned(), |found| {
        let half = found.interval.high - found.interval.estimate;
        format!("{} ± {}", text::number(found.interval.estimate, 4), text::number(half, 2))
    })
}
