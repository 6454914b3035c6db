//! `doublet linear`, `modes` and `qualities`: how the identified aircraft flies about a trim.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use doublet_dynamics::modes::{LocusParameter, LocusPoint, Mode, locus};
use doublet_engine::export::{linear_json, write_linear};
use doublet_engine::report::{
    Cell, Column, DynamicsRow, QualitiesRow, TableOf, criterion_table, dynamics_row, level_table, matrix_tables,
    measured_table, mode_table,
};
use doublet_engine::session;
use doublet_engine::study::dynamics::{CATEGORIES, CLASSES, Standard, window_key};
use doublet_engine::study::{DynamicsRequest, DynamicsStudy, Study};
use serde_json::{Value, json};

use crate::output_path::output_path;
use crate::run::{check_written, computed};
use crate::text::{self, number};

/// The trim of a command.
#[derive(Debug, Args)]
pub struct TrimArguments {
    /// Session file.
    pub session: PathBuf,
    /// True airspeed, m/s [default: median of identification manoeuvres].
    #[arg(long, value_name = "M_S")]
    airspeed: Option<f64>,
    /// Altitude, m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    altitude: Option<f64>,
    /// Flight-path angle, deg [default: level].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// Load factor of a steady turn, or of a pull-up (--pull-up).
    #[arg(long, value_name = "N")]
    load_factor: Option<f64>,
    /// Use the load factor for a wings-level pull-up.
    #[arg(long, requires = "load_factor")]
    pull_up: bool,
    /// Mass, kg; the inertia is unchanged.
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Centre of gravity along the datum's x axis, m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    cg: Option<f64>,
    /// Total fuel on board, kg.
    #[arg(long, value_name = "KG")]
    fuel: Option<f64>,
    /// Use the conditions of this manoeuvre.
    #[arg(long, alias = "window", value_name = "NAME")]
    manoeuvre: Option<String>,
    /// Random draws of the derivatives for sampled intervals and probabilities.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    samples: u32,
    /// Random seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Args)]
pub struct LinearArguments {
    /// The trim.
    #[command(flatten)]
    trim: TrimArguments,
    /// File to write, .mat, .json or .csv.
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ModesArguments {
    /// The trim.
    #[command(flatten)]
    trim: TrimArguments,
    /// Root locus over a derivative, cg (m), mass (kg), airspeed (m/s) or altitude (m).
    #[arg(long, value_name = "NAME=FROM:TO:STEPS", value_parser = locus_range)]
    locus: Option<(String, f64, f64, usize)>,
}

/// Classes as they are asked for: `II` is `II-L`.
pub const CLASS_NAMES: [&str; 6] = ["I", "II", "II-L", "II-C", "III", "IV"];

/// Class, category and limits of flying qualities.
#[derive(Args, Clone, Debug, Default)]
pub struct JudgedArguments {
    /// Aircraft class: I, II, II-L, II-C, III or IV [default: by mass].
    #[arg(long, value_parser = PossibleValuesParser::new(CLASS_NAMES))]
    class: Option<String>,
    /// Flight phase category: A, B or C [default: B].
    #[arg(long, value_parser = PossibleValuesParser::new(CATEGORIES))]
    category: Option<String>,
    /// Delay from stick to surfaces, s, for bandwidth and pilot-loop criteria.
    #[arg(long, value_name = "S", value_parser = delay)]
    stick_delay: Option<f64>,
    /// Available aileron deflection from trim, deg, for roll performance.
    #[arg(long, value_name = "DEG", value_parser = deflection)]
    aileron: Option<f64>,
    /// Limits that judge [default: mil_f_8785c].
    #[arg(long, value_parser = PossibleValuesParser::new(Standard::ALL.map(Standard::name)))]
    limits: Option<String>,
}

impl JudgedArguments {
    /// `request` with these.
    #[must_use]
    pub fn added_to(&self, request: DynamicsRequest) -> DynamicsRequest {
        let place = |known: &[&str], name: Option<&str>| known.iter().position(|known| Some(*known) == name);
        let standard = Standard::ALL.into_iter().find(|standard| self.limits.as_deref() == Some(standard.name()));
        let class = self.class.as_deref().map(|class| if class == "II" { "II-L" } else { class });
        DynamicsRequest {
            standard: standard.unwrap_or(request.standard),
            class: place(&CLASSES, class),
            category: place(&CATEGORIES, self.category.as_deref()),
            stick_delay_s: self.stick_delay,
            aileron_rad: self.aileron.map(f64::to_radians),
            ..request
        }
    }
}

#[derive(Debug, Args)]
pub struct QualitiesArguments {
    /// The trim.
    #[command(flatten)]
    trim: TrimArguments,
    /// Class, category and limits.
    #[command(flatten)]
    judged: JudgedArguments,
}

fn delay(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=5.0).contains(value));
    value.ok_or_else(|| "give a delay from 0 to 5 s".to_owned())
}

fn deflection(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && *value <= 90.0);
    value.ok_or_else(|| "give a deflection above 0 and up to 90 deg".to_owned())
}

fn locus_range(text: &str) -> Result<(String, f64, f64, usize), String> {
    let wrong = || format!("'{text}' is not a range: write NAME=FROM:TO:STEPS, for example Cm_alpha=-1.2:-0.2:11");
    let (name, range) = text.split_once('=').ok_or_else(wrong)?;
    let parts: Vec<&str> = range.split(':').collect();
    let [from, to, steps] = parts.as_slice() else { return Err(wrong()) };
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
    let steps = steps.parse::<usize>().ok().filter(|steps| (1..=10_000).contains(steps)).ok_or_else(wrong)?;
    Ok((name.to_owned(), number(from)?, number(to)?, steps))
}

/// Computes the study of a trim.
pub fn study(trim: &TrimArguments, judged: &JudgedArguments) -> Result<std::sync::Arc<DynamicsStudy>, String> {
    let request = DynamicsRequest {
        airspeed_m_s: trim.airspeed,
        altitude_m: trim.altitude,
        gamma_rad: trim.gamma.map(f64::to_radians),
        load_factor: trim.load_factor,
        pull_up: trim.pull_up,
        mass_kg: trim.mass,
        cg_x_m: trim.cg,
        fuel_kg: trim.fuel,
        window: trim.manoeuvre.as_deref().map(|name| window(&trim.session, name)).transpose()?,
        samples: trim.samples as usize,
        seed: trim.seed,
        ..DynamicsRequest::default()
    };
    let (_, snapshot) = computed(&trim.session, &[Study::Dynamics(judged.added_to(request))])?;
    let study = snapshot.studies.dynamics.ready().cloned();
    study.ok_or_else(|| "no model: the session needs an aircraft and an identification manoeuvre".to_owned())
}

/// Key of a window in use.
fn window(path: &Path, name: &str) -> Result<u64, String> {
    let opened = session::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let used = || opened.session.active_windows().map(|window| window.name.as_str());
    if used().any(|known| known == name) {
        return Ok(window_key(name));
    }
    Err(format!("manoeuvre '{name}' is not in use: use one of {}", used().collect::<Vec<_>>().join(", ")))
}

/// Prints or writes the linear models about a trim.
pub fn linear(arguments: &LinearArguments) -> Result<(), String> {
    if let Some(out) = &arguments.out {
        check_written(out, &arguments.trim.session)?;
    }
    let study = study(&arguments.trim, &JudgedArguments::default())?;
    let row = dynamics_row(&study);
    let mut written = None;
    if let Some(out) = &arguments.out {
        written = Some((write_linear(&row, out).map_err(|error| error.to_string())?, out));
    }
    text::json(&linear_json(&row, arguments.out.as_deref().unwrap_or(Path::new("linear.json"))))?;
    print_trim(&row);
    for (name, model) in row.systems.iter().filter(|(_, model)| model.states.len() <= 4) {
        for table in matrix_tables(name, name, model) {
            text::line("");
            text::line(&table.caption);
            text::show(&table);
        }
    }
    print_notes(&row);
    if let Some((format, out)) = written {
        text::line("");
        text::line(&format!("linear models in {}", out.display()));
        for (tool, line) in format.load_lines(&out.display().to_string()) {
            text::line(&format!("{tool}: {line}"));
        }
    }
    Ok(())
}

/// Prints the modes about a trim, or over a parameter.
pub fn modes(arguments: &ModesArguments) -> Result<(), String> {
    let study = study(&arguments.trim, &JudgedArguments::default())?;
    if let Some((name, from, to, steps)) = &arguments.locus {
        let share = |step: usize| step as f64 / (steps - 1).max(1) as f64;
        let values: Vec<f64> = (0..*steps).map(|step| from + (to - from) * share(step)).collect();
        let parameter = LocusParameter::parse(name);
        let points = locus(&study.model, &study.condition, &parameter, &values).map_err(|error| error.to_string())?;
        return print_locus(name, &parameter, &points);
    }
    let row = dynamics_row(&study);
    text::json(&json!({
        "trim": row.trim, "windows": row.windows, "modes": row.modes, "measured": row.measured, "samples": row.samples,
        "seed": row.seed, "notes": row.notes,
    }))?;
    print_modes(&row);
    print_measured(&row);
    Ok(())
}

fn print_locus(name: &str, parameter: &LocusParameter, points: &[LocusPoint]) -> Result<(), String> {
    let described: Vec<Value> = points.iter().map(describe_point).collect();
    text::json(&json!({ "parameter": name, "unit": parameter.unit(), "points": described }))?;
    let rows = points.iter().flat_map(|point| match &point.modes {
        Ok(modes) => modes.iter().map(|mode| (point.value, Ok(mode))).collect(),
        Err(error) => vec![(point.value, Err(error.to_string()))],
    });
    let figure =
        |of: fn(&Mode) -> f64| move |row: &(f64, Result<&Mode, String>)| row.1.as_ref().ok().map(|mode| of(mode));
    let table = TableOf::new("locus", "Root locus.", rows)
        .column(Column::number("value", name, "", 5), |row| Cell::Number(row.0))
        .text("mode", "Mode", |row| row.1.as_ref().map_or_else(String::as_str, |mode| mode.name))
        .maybe("real", "Real", "1/s", 4, figure(|mode| mode.real_1_s))
        .maybe("imaginary", "Imaginary", "rad/s", 4, figure(|mode| mode.imaginary_rad_s))
        .maybe("frequency", "Frequency", "rad/s", 4, figure(Mode::frequency_rad_s))
        .maybe("damping", "Damping", "", 4, figure(Mode::damping));
    text::show(&table.done());
    Ok(())
}

fn describe_point(point: &LocusPoint) -> Value {
    match &point.modes {
        Ok(modes) => json!({ "value": point.value, "modes": modes.iter().map(describe_mode).collect::<Vec<_>>() }),
        Err(error) => json!({ "value": point.value, "error": error.to_string() }),
    }
}

fn describe_mode(mode: &Mode) -> Value {
    json!({
        "name": mode.name, "real_1_s": mode.real_1_s, "imaginary_rad_s": mode.imaginary_rad_s,
        "frequency_rad_s": mode.frequency_rad_s(), "damping": mode.damping(),
    })
}

/// Prints the levels of the flying qualities about a trim.
pub fn qualities(arguments: &QualitiesArguments) -> Result<(), String> {
    let study = study(&arguments.trim, &arguments.judged)?;
    let row = dynamics_row(&study);
    let found = &row.qualities;
    text::json(&json!({
        "trim": row.trim, "windows": row.windows, "qualities": found, "samples": row.samples, "seed": row.seed,
        "notes": row.notes,
    }))?;
    print_trim(&row);
    print_qualities(found);
    print_notes(&row);
    Ok(())
}

/// Prints the level of every criterion with its probability, the worst, and the criteria that are not judged.
pub fn print_qualities(found: &QualitiesRow) {
    text::line("");
    text::line(&format!("{} ({}), {}", found.standard, found.date, found.airplane_from));
    text::show(&level_table(found));
    let worst = found.level.unwrap_or("not judged");
    let share = found.level.and_then(|level| {
        let place = LEVELS.iter().position(|known| *known == level)?;
        found.probabilities.map(|shares| format!(" with {:.0} %", 100.0 * shares[place]))
    });
    text::line(&format!("worst: {worst}{} ({})", share.unwrap_or_default(), found.extent()));
    text::line(&found.note);
    text::line("");
    text::line("not judged:");
    text::show(&criterion_table(found).only("needed", |needed| *needed != Cell::text("judged")));
}

/// Names of the levels, the best first.
const LEVELS: [&str; 4] = ["Level 1", "Level 2", "Level 3", "worse than Level 3"];

/// Prints the trim, the modes and what is to be known of them.
pub fn print_modes(row: &DynamicsRow) {
    print_trim(row);
    text::line("");
    text::show(&mode_table(&row.modes));
    text::line(&format!("± are standard errors by linearisation; {} samples, seed {}", row.samples, row.seed));
    print_notes(row);
}

/// Prints the modes measured in the free responses of the windows.
fn print_measured(row: &DynamicsRow) {
    if row.measured.is_empty() {
        return;
    }
    text::line("");
    text::line("measured in the free response at the end of each manoeuvre, without the model");
    text::show(&measured_table(&row.measured));
}

fn print_trim(row: &DynamicsRow) {
    let trim = &row.trim;
    let degrees = |value: f64| number(value.to_degrees(), 4);
    text::line(&format!(
        "trim at {} m/s and {} m, flight path {} deg, load factor {}, {} kg, centre of gravity at {} m: alpha {} deg, pitch {} deg, bank {} deg, \
         aileron {} deg, elevator {} deg, rudder {} deg, thrust {} N",
        number(trim.airspeed_m_s, 4),
        number(trim.altitude_m, 5),
        degrees(trim.gamma_rad),
        number(trim.load_factor, 4),
        number(trim.mass_kg, 5),
        number(trim.cg_from_datum_m[0], 4),
        degrees(trim.alpha_rad),
        degrees(trim.theta_rad),
        degrees(trim.phi_rad),
        degrees(trim.delta_a_rad),
        degrees(trim.delta_e_rad),
        degrees(trim.delta_r_rad),
        number(trim.thrust_n, 4),
    ));
    text::line(&format!("other conditions: median of {} manoeuvres", row.windows.len()));
}

fn print_notes(row: &DynamicsRow) {
    row.notes.iter().for_each(|note| text::line(&format!("note: {note}")));
}
