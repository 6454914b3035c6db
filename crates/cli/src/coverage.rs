//! `doublet coverage`: how often the intervals of the derivatives hold the truth.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use doublet_core::simulate::Scenario;
use doublet_dynamics::design::{Criterion, DesignKind, Request};
use doublet_engine::builtin;
use doublet_engine::graph::{Context, StageError};
use doublet_engine::planning::{DesignCoverage, design_coverage, design_coverage_tables};
use doublet_engine::recorded_coverage::recorded_coverage;
use doublet_engine::report::{case_table, coverage_table, mode_coverage_table};
use doublet_engine::run::Control;
use doublet_engine::session::{self, GustSource, Session};
use doublet_engine::study::{self, Coverage};
use doublet_engine::verdict::{self, JudgedFlights, Level};

use crate::arguments::not_negative;
use crate::progress::Progress;
use crate::text;

#[derive(Debug, Args)]
pub struct CoverageArguments {
    /// Session whose settings identify the flights [default: the shipped one].
    pub session: Option<PathBuf>,
    /// Scenario to simulate: a shipped name, or a file of `doublet design`.
    #[arg(long, default_value = SCENARIO)]
    pub scenario: String,
    /// Override the standard deviation of the gusts, m/s.
    #[arg(long, value_name = "M_S", value_parser = not_negative)]
    pub gusts: Option<f64>,
    /// Number of flights.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
    /// Seed of the first flight; each next flight adds one.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Simulate the recorders and their clocks too.
    #[arg(long, conflicts_with_all = ["verdict", "modes", "design"])]
    pub recorded: bool,
    /// Print the false-alarm rate on fault-free flights instead.
    #[arg(long)]
    pub verdict: bool,
    /// Print the coverage of the mode intervals instead.
    #[arg(long, conflicts_with = "verdict")]
    pub modes: bool,
    /// Design and simulate an input of this kind; compare predictions with results.
    #[arg(long, value_name = "KIND", conflicts_with_all = ["verdict", "modes"], value_parser = crate::design::kind)]
    pub design: Option<DesignKind>,
    /// Number of flights analysed before the design.
    #[arg(long, requires = "design", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub known: u32,
    /// Surfaces of that design.
    #[arg(long, value_name = "SURFACE,...", value_delimiter = ',', requires = "design", default_value = "aileron,elevator,rudder", value_parser = PossibleValuesParser::new(crate::design::SURFACES))]
    pub surfaces: Vec<String>,
    /// Total time of the designed manoeuvres, s.
    #[arg(long, value_name = "S", requires = "design", default_value_t = 120.0)]
    pub time: f64,
}

#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Session for the settings [default: shipped one, gusts by likelihood].
    pub session: Option<PathBuf>,
    /// Scenario to simulate.
    #[arg(long, default_value = SCENARIO)]
    pub scenario: String,
    /// Flights of each case.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub realisations: u64,
    /// Seed of the first flight; each next flight adds one.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Scenario flown unless another is asked for.
pub const SCENARIO: &str = "coverage";

/// Flies the scenario, identifies every flight and prints a row per derivative.
pub fn coverage(arguments: &CoverageArguments) -> Result<(), String> {
    if arguments.verdict {
        print_judged(arguments, &studied(arguments, verdict::judged_flights)?);
        return Ok(());
    }
    if arguments.modes {
        print_modes(arguments, &studied(arguments, study::mode_coverage)?);
        return Ok(());
    }
    if let Some(kind) = arguments.design {
        let request = Request {
            surfaces: crate::design::places(&arguments.surfaces),
            time_s: arguments.time,
            kind,
            criterion: Criterion::A,
            rounds: 0,
            search_samples: 0,
            samples: 40,
            usage: 0.9,
            seed: 1,
            with_flown: false,
        };
        let known = arguments.known as usize;
        let fly = |session: &Session, scenario: &Scenario, (count, seed): (usize, u64), context: &Context<'_>| {
            design_coverage(session, scenario, &request, (known, count, seed), context)
        };
        print_design(arguments, &studied(arguments, fly)?);
        return Ok(());
    }
    let found = computed(arguments)?;
    text::line(&format!(
        "{} flights of scenario '{}', {} manoeuvres each: fraction of the 95 % intervals that contain the truth",
        found.realisations, arguments.scenario, found.manoeuvres
    ));
    text::show(&coverage_table(&found));
    let mean = |part: fn(&study::DerivativeCoverage) -> f64| {
        100.0 * found.derivatives.iter().map(part).sum::<f64>() / found.derivatives.len() as f64
    };
    let [conventional, corrected] = [mean(|row| row.conventional), mean(|row| row.corrected)];
    text::line(&format!("all derivatives: conventional {conventional:.1} %, corrected {corrected:.1} %"));
    Ok(())
}

/// Flies sound flights, flights in gusts and flights with one fault each and prints how the levels fit the truth.
pub fn calibrate(arguments: &CalibrateArguments) -> Result<(), String> {
    let scenario = crate::simulate::open(&arguments.scenario)?;
    let flights = (arguments.realisations, arguments.seed);
    let found = fly_many((&arguments.session, scenario), flights, |session, scenario, flights, context| {
        // The shipped session states the gusts of its own flight.
        let gusts = if arguments.session.is_none() { GustSource::Estimated } else { session.gusts };
        verdict::calibrate_levels(&Session { gusts, ..session.clone() }, scenario, flights, context)
    })?;
    text::json(&found)?;
    text::show(&case_table(&found));
    Ok(())
}

/// What a design promised beside what its flights gave.
fn print_design(arguments: &CoverageArguments, found: &DesignCoverage) {
    text::line(&format!(
        "{} flights of {} on {}, {} s, designed from {} of scenario '{}': predicted errors over the scatter of the estimates",
        found.realisations,
        found.kind,
        arguments.surfaces.join(", "),
        text::number(arguments.time, 4),
        arguments.known,
        arguments.scenario
    ));
    let [errors, excursions] = design_coverage_tables(found);
    text::show(&errors);
    text::show(&excursions);
    text::line(&format!("all excursions within limits in {:.1} % of the flights", 100.0 * found.inside));
    text::line(&format!(
        "largest scatter {} % of the true derivative",
        text::number(100.0 * found.worst_relative_error, 3)
    ));
    for (first, second, correlation) in &found.correlations {
        text::line(&format!("{first} and {second}: correlation {correlation:+.2}"));
    }
}

/// How often the intervals of the modes hold the truth.
fn print_modes(arguments: &CoverageArguments, found: &study::ModeCoverage) {
    text::line(&format!(
        "{} flights of scenario '{}', {} manoeuvres each: fraction of the 95 % mode intervals that contain the true mode at the same trim",
        found.realisations, arguments.scenario, found.manoeuvres
    ));
    text::show(&mode_coverage_table(found));
}

/// How often flights with which nothing is wrong are judged to be less than good, and why.
fn print_judged(arguments: &CoverageArguments, found: &JudgedFlights) {
    let part = |count: usize| format!("{:.1} %", 100.0 * count as f64 / found.flights as f64);
    let [good, caution, bad] = found.sessions.map(part);
    text::line(&format!(
        "{} flights of scenario '{}', {} manoeuvres each: session good {good}, caution {caution}, bad {bad}; a bad anywhere {}",
        found.flights,
        arguments.scenario,
        found.manoeuvres,
        part(found.bad_anywhere)
    ));
    let row = |((level, code), count): (&(Level, &'static str), &usize)| {
        let example = found.examples.get(&(*level, *code));
        let example = example.map_or(String::new(), |(seed, finding)| format!("seed {seed}: {finding}"));
        vec![format!("{} {code}", level.name()), format!("{}  {example}", part(*count))]
    };
    text::list(&found.codes.iter().rev().map(row).collect::<Vec<_>>());
}

/// The study of coverage the arguments ask for.
pub fn computed(arguments: &CoverageArguments) -> Result<Coverage, String> {
    match arguments.recorded {
        true => studied(arguments, recorded_coverage),
        false => studied(arguments, study::coverage),
    }
}

/// Flies a scenario many times over and looks at the flights.
fn studied<T>(
    arguments: &CoverageArguments,
    study: impl Fn(&Session, &Scenario, (usize, u64), &Context<'_>) -> Result<T, StageError>,
) -> Result<T, String> {
    let mut scenario = crate::simulate::open(&arguments.scenario)?;
    if let Some(gusts) = arguments.gusts {
        scenario.gust_m_s = gusts;
    }
    fly_many((&arguments.session, scenario), (arguments.realisations, arguments.seed), study)
}

/// Flies a scenario many times over by the settings of a session, the shipped one without any.
fn fly_many<T>(
    (session, scenario): (&Option<PathBuf>, Scenario),
    (realisations, seed): (u64, u64),
    study: impl Fn(&Session, &Scenario, (usize, u64), &Context<'_>) -> Result<T, StageError>,
) -> Result<T, String> {
    let (session, folder) = match session {
        Some(path) => {
            let opened = session::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
            (opened.session, opened.folder)
        }
        None => {
            let text = builtin::session("demo").ok_or("shipped session not found")?;
            (session::parse(text).map_err(|error| error.to_string())?, Path::new(".").to_path_buf())
        }
    };
    let count = usize::try_from(realisations).map_err(|_| "too many realisations".to_owned())?;
    let progress = Progress::new();
    let control = Control::default();
    let show = |part: f32| progress.update(part, "flying and identifying");
    let context = Context::new(&folder).with_control(&control, &show);
    let found = study(&session, &scenario, (count, seed), &context);
    progress.finish();
    found.map_err(|error| match error {
        StageError::Cancelled => "stopped".to_owned(),
        error => error.to_string(),
    })
}
