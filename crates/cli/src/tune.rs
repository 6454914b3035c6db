//! `doublet tune`: filter settings that make the measurements most likely, printed and never applied.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use doublet_core::reconstruct::Measurement;
use doublet_core::reconstruct::tuning::noise::{NoiseMethod, NoiseProposal, NoiseProposalSettings};
use doublet_engine::graph::Cache;
use doublet_engine::report::tuned_noise_table;
use doublet_engine::run::{Control, Scope, Snapshot, run, tune_delay, tune_noise};
use doublet_engine::session::{self, Session};
use doublet_engine::stage::WindowPath;

use crate::progress::Progress;
use crate::text;

/// Memory for intermediate results.
const CACHE_BYTES: usize = 1 << 30;

#[derive(Debug, Args)]
pub struct TuneArguments {
    /// Session file.
    pub session: PathBuf,
    /// Manoeuvres to use, by name [default: all not ignored].
    #[arg(long, alias = "windows", value_name = "NAME,NAME", value_delimiter = ',')]
    pub manoeuvres: Vec<String>,
    /// Method to maximise the likelihood.
    #[arg(long, value_enum, default_value_t = LikelihoodSearch::QuasiNewton)]
    pub method: LikelihoodSearch,
    /// Maximum number of iterations.
    #[arg(long, default_value_t = 60)]
    pub steps: usize,
    /// Estimate one delay of these measurements instead of noise: alpha,beta.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = measurement)]
    pub delay: Vec<Measurement>,
    /// Search range about the present delay, s.
    #[arg(long, value_name = "S", default_value_t = 0.25, requires = "delay", value_parser = range)]
    pub range: f64,
}

/// Method to maximise the likelihood.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum LikelihoodSearch {
    /// Quasi-Newton on the logarithms of the standard deviations.
    QuasiNewton,
    /// Expectation-maximisation: slow, monotonic.
    Em,
}

fn measurement(name: &str) -> Result<Measurement, String> {
    let known = || Measurement::ALL.map(Measurement::name).join(", ");
    Measurement::from_name(name).ok_or_else(|| format!("unknown measurement '{name}': use {}", known()))
}

fn range(text: &str) -> Result<f64, String> {
    let range: f64 = text.parse().map_err(|_| format!("'{text}' is not a number"))?;
    if range > 0.0 && range <= 5.0 { Ok(range) } else { Err("use above 0 up to 5 s".to_owned()) }
}

/// Prints proposed settings.
pub fn tune(arguments: &TuneArguments) -> Result<(), String> {
    let opened = session::open(&arguments.session).map_err(|e| format!("{}: {e}", arguments.session.display()))?;
    let mut session = opened.session;
    choose_windows(&mut session, &arguments.manoeuvres)?;
    let progress = Progress::new();
    let scope =
        Scope { session: &session, folder: &opened.folder, first: None, studies: &[], cause: "tune", generation: 1 };
    let publish = |snapshot: Snapshot| progress.update(snapshot.progress, "reconstructing");
    let control = Control::default();
    let snapshot = run(&scope, &Snapshot::default(), &Cache::new(CACHE_BYTES), &control, &publish);
    let mut paths: Vec<&WindowPath> = Vec::new();
    for (name, results) in &snapshot.windows {
        match (results.path.ready(), results.path.error()) {
            (Some(path), _) => paths.push(path),
            (None, error) => return Err(format!("manoeuvre '{name}': {}", error.unwrap_or("was not reconstructed"))),
        }
    }
    let session = snapshot.settle(&session);
    if !arguments.delay.is_empty() {
        progress.finish();
        let found = tune_delay(&paths, &session.filter, &arguments.delay, arguments.range, &control)?;
        let names = arguments.delay.iter().map(|m| m.name()).collect::<Vec<_>>().join(", ");
        text::line(&format!(
            "delay of {names}: {} s, standard error {} s, set to {} s",
            text::number(found.delay_s, 4),
            text::number(found.standard_error_s, 2),
            text::number(found.present_s, 4)
        ));
        return Ok(());
    }
    let method = match arguments.method {
        LikelihoodSearch::QuasiNewton => NoiseMethod::QuasiNewton,
        LikelihoodSearch::Em => NoiseMethod::ExpectationMaximisation,
    };
    let search = NoiseProposalSettings { method, max_iterations: arguments.steps, ..NoiseProposalSettings::default() };
    let found = tune_noise(&paths, &session.filter, &search, &control, &|at| {
        let part = at.iteration as f32 / search.max_iterations.max(1) as f32;
        progress.update(part, &format!("log-likelihood {:.1}", at.log_likelihood));
    });
    progress.finish();
    print(&found?, paths.len());
    Ok(())
}

/// Leaves only the windows of these names in use.
fn choose_windows(session: &mut Session, names: &[String]) -> Result<(), String> {
    if let Some(unknown) = names.iter().find(|name| session.window(name).is_none()) {
        return Err(format!("manoeuvre '{unknown}' not found in the session"));
    }
    if !names.is_empty() {
        session.windows.retain(|window| names.contains(&window.name));
    }
    Ok(())
}

fn print(found: &NoiseProposal, windows: usize) {
    text::show(&tuned_noise_table(found));
    let gain = found.log_likelihood.last().zip(found.log_likelihood.first()).map_or(0.0, |(last, first)| last - first);
    let outliers: usize = found.outliers.iter().sum();
    text::line(&format!(
        "{windows} manoeuvres, {} steps{}, log-likelihood increased by {}, {outliers} outliers left out; session unchanged",
        found.log_likelihood.len() - 1,
        if found.converged { "" } else { " (not converged: increase --steps)" },
        text::number(gain, 5)
    ));
}
