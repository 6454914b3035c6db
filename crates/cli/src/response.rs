//! `doublet response` and `doublet loes`: frequency responses of a session or a table, and low-order equivalent systems of them.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use doublet_dynamics::frequency::{Delay, EquivalentSystem, FittedParameter, Form};
use doublet_dynamics::qualities::{Airplane, Limits};
use doublet_engine::report::document::{Block, BodeModel, Document, Figure, bode_figure};
use doublet_engine::report::{self, QualitiesRow, equivalent_levels, parameter_table, response_rows, response_table};
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::{Manoeuvre, Session, Surface};
use doublet_engine::study::dynamics::{self, CATEGORIES};
use doublet_engine::study::{
    EquivalentStudy, FitMethod, ResponseRequest, ResponseStudy, ResponseWindow, equivalent_study, session_responses,
    table_responses,
};
use doublet_engine::{builtin, keep};
use serde_json::{Value, json};

use crate::arguments::{not_negative, positive};
use crate::dynamics::{CLASS_NAMES, print_qualities};
use crate::outcome::Outcome;
use crate::output_path::output_path;
use crate::run::{check_written, computed};
use crate::text;

#[derive(Debug, Args)]
pub struct ResponseArguments {
    /// Session (.toml), or a table: text, or any recording, unconverted.
    pub source: PathBuf,
    /// Inputs, comma-separated: roles, columns or expressions. Responses are conditioned on the others.
    #[arg(long, value_name = "NAME,NAME", required = true, allow_hyphen_values = true)]
    pub input: String,
    /// Output role, column or expression: p, q, r, ay, alpha, beta ...
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    pub output: String,
    /// Manoeuvres of the session [default: all not ignored].
    #[arg(long, alias = "windows", value_name = "NAME,NAME", value_delimiter = ',')]
    pub manoeuvres: Vec<String>,
    /// Lowest and highest frequency, rad/s.
    #[arg(long, value_name = "LOW..HIGH", value_parser = band)]
    pub band: Option<[f64; 2]>,
    /// Lengths of the spectral windows, s [default: five that the records allow].
    #[arg(long, value_name = "S,S", value_delimiter = ',', value_parser = positive)]
    pub window_length: Vec<f64>,
    /// Overlap of the spectral windows, fraction.
    #[arg(long, default_value_t = ResponseRequest::default().overlap)]
    pub overlap: f64,
    /// Number of frequencies, evenly spaced on a logarithmic scale.
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u16).range(2..=400))]
    pub points: u16,
    /// Row interval, s, of a table without time.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub dt: Option<f64>,
    /// CSV file for the responses.
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    pub out: Option<PathBuf>,
    /// Bode plot, .svg or .pdf (one page per input).
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    pub figure: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct LoesArguments {
    /// Input, output and band.
    #[command(flatten)]
    pub response: ResponseArguments,
    /// Form: short-period, roll, yaw, or orders such as 1/2.
    #[arg(long, value_name = "FORM", value_parser = form)]
    pub form: Form,
    /// Fit the records (output error) or the response [default: both].
    #[arg(long, value_enum)]
    pub method: Option<LoesMethod>,
    /// Known delay, s [default: estimated].
    #[arg(long, value_name = "S", value_parser = not_negative)]
    pub delay: Option<f64>,
    /// Limits to judge the system: a shipped name or a file.
    #[arg(long, requires = "class")]
    pub limits: Option<String>,
    /// Aircraft class of the limits: I, II, II-L, II-C, III or IV.
    #[arg(long, requires = "limits", value_parser = PossibleValuesParser::new(CLASS_NAMES))]
    pub class: Option<String>,
    /// Flight phase category of the limits: A, B or C [default: B].
    #[arg(long, requires = "limits", value_parser = PossibleValuesParser::new(CATEGORIES))]
    pub category: Option<String>,
}

/// Data a form is fitted to.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum LoesMethod {
    /// Fourier transforms of the records, by maximum likelihood.
    OutputError,
    /// The response, weighted by coherence.
    Coherence,
}

fn form(text: &str) -> Result<Form, String> {
    Form::parse(text).map_err(|error| error.to_string())
}

/// Reads `LOW..HIGH`.
fn band(text: &str) -> Result<[f64; 2], String> {
    let wrong = || format!("'{text}' is not a band: write it as LOW..HIGH in rad/s, for example 0.3..10");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let (low, high): (f64, f64) = low.trim().parse().ok().zip(high.trim().parse().ok()).ok_or_else(wrong)?;
    if low > 0.0 && low < high && high.is_finite() { Ok([low, high]) } else { Err(wrong()) }
}

/// Prints the responses of an output to its inputs.
pub fn response(arguments: &ResponseArguments) -> Result<(), String> {
    let study = studied(arguments, false)?;
    if let Some(out) = &arguments.out {
        write_rows(out, &study)?;
    }
    draw(arguments, &study, &[])?;
    text::json(&describe(&study))?;
    print_study(&study);
    print_responses(&study);
    Ok(())
}

/// Prints the low-order equivalent system of each response.
pub fn loes(arguments: &LoesArguments) -> Result<Outcome, String> {
    let study = studied(&arguments.response, true)?;
    let delay = arguments.delay.map_or(Delay::Free, Delay::Fixed);
    let method = arguments.method.map(|method| match method {
        LoesMethod::OutputError => FitMethod::OutputError,
        LoesMethod::Coherence => FitMethod::Coherence,
    });
    let fitted =
        |input| equivalent_study(&study, input, (arguments.form, delay), method).map_err(|error| error.to_string());
    let limits = limits(arguments)?;
    let fits = (0..study.inputs.len()).map(fitted).collect::<Result<Vec<_>, _>>()?;
    let levels =
        |fit: &EquivalentStudy| Some(equivalent_levels(fit, &study.output, &limits.as_ref()?.0, &limits.as_ref()?.1));
    if let Some(out) = &arguments.response.out {
        write_rows(out, &study)?;
    }
    draw(&arguments.response, &study, &fits)?;
    if text::is_json() {
        let mut document = describe(&study);
        let systems: Vec<Value> = fits.iter().map(|fit| describe_fit(&study, fit, levels(fit))).collect();
        if let ([Value::Object(system)], Value::Object(members)) = (&systems[..], &mut document) {
            members.extend(system.clone());
        }
        document["systems"] = Value::Array(systems);
        text::json(&document)?;
    } else {
        print_study(&study);
        for fit in &fits {
            print_fit(&study, fit);
            levels(fit).iter().for_each(print_qualities);
        }
    }
    let worst = fits.iter().map(|fit| fit.verdict.level).max().unwrap_or_default();
    Ok(worst.into())
}

/// Limits asked for, shipped or from a file, and the aircraft they are for.
fn limits(arguments: &LoesArguments) -> Result<Option<(Limits, Airplane)>, String> {
    let Some((name, class)) = arguments.limits.as_ref().zip(arguments.class.as_ref()) else { return Ok(None) };
    let limits = match std::fs::read_to_string(name) {
        Ok(text) => Limits::parse(&text).map_err(|error| format!("{name}: {error}"))?,
        Err(_) => dynamics::limits(name).map_err(|error| error.to_string())?,
    };
    let category = arguments.category.as_deref().unwrap_or(dynamics::USUAL_CATEGORY);
    let airplane = Airplane::new(class, category).map_err(|error| error.to_string())?;
    limits.check(&airplane).map_err(|error| error.to_string())?;
    Ok(Some((limits, airplane)))
}

fn studied(arguments: &ResponseArguments, for_fit: bool) -> Result<ResponseStudy, String> {
    for written in arguments.out.iter().chain(&arguments.figure) {
        check_written(written, &arguments.source)?;
    }
    let inputs = crate::regress::split_terms(&arguments.input).map_err(|error| error.replace("--terms", "--input"))?;
    let request = ResponseRequest {
        inputs,
        output: arguments.output.trim().to_owned(),
        band_rad_s: arguments.band,
        windows_s: arguments.window_length.clone(),
        overlap: arguments.overlap,
        points: usize::from(arguments.points),
    };
    let is_shipped = arguments.source.to_str().is_some_and(|name| name.starts_with(builtin::PREFIX));
    if !is_shipped && arguments.source.extension().is_none_or(|extension| extension != "toml") {
        if !arguments.manoeuvres.is_empty() {
            return Err("--manoeuvres: not for a table, only for a session (.toml)".to_owned());
        }
        return table_responses(&arguments.source, arguments.dt, &request, for_fit).map_err(|error| error.to_string());
    }
    let (session, snapshot) = computed(&arguments.source, &[])?;
    let windows = windows_of(&session, &snapshot, &arguments.manoeuvres, &request.inputs)?;
    session_responses(&windows, &request, for_fit).map_err(|error| error.to_string())
}

/// Windows of a session that have a path: those named, or those in use in which an input moves.
fn windows_of<'a>(
    session: &'a Session,
    snapshot: &'a Snapshot,
    names: &[String],
    inputs: &[String],
) -> Result<Vec<ResponseWindow<'a>>, String> {
    if let Some(name) = names.iter().find(|name| !session.windows.iter().any(|window| window.name == **name)) {
        let known: Vec<&str> = session.windows.iter().map(|window| window.name.as_str()).collect();
        return Err(format!("manoeuvre '{name}' not found: use one of {}", known.join(", ")));
    }
    // Without names, manoeuvres of another surface alone do not excite the input.
    let moved: Vec<Surface> =
        Surface::ALL.into_iter().filter(|surface| inputs.contains(&surface.role().name().to_owned())).collect();
    let excites =
        |window: &Manoeuvre| moved.is_empty() || window.surface.is_none_or(|surface| moved.contains(&surface));
    let is_wanted = |window: &&Manoeuvre| if names.is_empty() { excites(window) } else { names.contains(&window.name) };
    let used = session.active_windows().filter(is_wanted);
    let found = used.filter_map(|window| {
        let results = snapshot.windows.get(&window.name)?;
        Some(ResponseWindow {
            name: &window.name,
            recording: &snapshot.flights.get(&window.flight)?.ready()?.recording,
            path: results.path.ready()?,
            source: session.preparation.path,
            aero: results.aero.ready().map(|aero| &**aero),
        })
    });
    Ok(found.collect())
}

fn write(path: &Path, contents: &[u8]) -> Result<(), String> {
    keep::replace(path, contents)
        .map_err(|error| format!("{}: {error}; name a file that can be written", path.display()))
}

/// Writes the Bode plot where one is asked for.
fn draw(arguments: &ResponseArguments, study: &ResponseStudy, fits: &[EquivalentStudy]) -> Result<(), String> {
    let Some(path) = &arguments.figure else { return Ok(()) };
    let figure = |input: usize| {
        let fit = fits.iter().find(|fit| fit.input == input);
        let label = |fit: &EquivalentStudy| format!("{} equivalent system", fit.fit.form);
        let pair = |fit: &&EquivalentStudy| BodeModel::pair(&label(fit), &fit.fit.model, &study.responses[input]);
        let models: Vec<BodeModel> = fit.iter().flat_map(pair).collect();
        bode_figure(study, input, &models)
    };
    let figures: Vec<Figure> = (0..study.inputs.len()).filter_map(figure).collect();
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match (extension, figures.first()) {
        ("svg", Some(first)) => write(path, doublet_report::svg::svg(first, "f").as_bytes()),
        ("pdf", _) => {
            let document = Document {
                title: format!("Frequency response of {} to {}", study.output, study.inputs.join(", ")),
                subtitle: arguments.source.display().to_string(),
                date: doublet_engine::date::today(),
                cover: figures.into_iter().map(Block::Figure).collect(),
                ..Document::default()
            };
            write(path, &doublet_report::pdf(&document, &Control::default(), &|_| {})?)
        }
        _ => Err(format!("--figure {}: name it .svg or .pdf", path.display())),
    }
}

fn describe(study: &ResponseStudy) -> Value {
    let records = study.records.iter().map(|(name, length)| json!({ "name": name, "length_s": length }));
    let constants = study.responses.first().map(|response| response.overlap_constants.clone()).unwrap_or_default();
    json!({
        "version": 1,
        "program": doublet_engine::PROGRAM,
        "inputs": study.inputs,
        "output": study.output,
        "records": records.collect::<Vec<Value>>(),
        "left_out": study.left_out,
        "window_lengths_s": study.settings.windows_s,
        "overlap": study.settings.overlap,
        "overlap_constants": constants,
        "response": response_rows(study),
    })
}

fn describe_parameters(parameters: &[FittedParameter]) -> Vec<Value> {
    parameters.iter().map(describe_parameter).collect()
}

fn describe_parameter(parameter: &FittedParameter) -> Value {
    json!({
        "name": parameter.name,
        "value": parameter.value,
        "standard_error": parameter.standard_error,
        "low": parameter.low,
        "high": parameter.high,
    })
}

fn describe_fit(study: &ResponseStudy, found: &EquivalentStudy, qualities: Option<QualitiesRow>) -> Value {
    let complex =
        |roots: Vec<nalgebra::Complex<f64>>| -> Vec<[f64; 2]> { roots.iter().map(|root| [root.re, root.im]).collect() };
    let fit: &EquivalentSystem = &found.fit;
    let mismatch = &found.mismatch;
    let correlation: Vec<Vec<f64>> = fit.correlation.row_iter().map(|row| row.iter().copied().collect()).collect();
    let other = found.other.as_ref().map(|(method, other)| {
        json!({
            "method": method.name(),
            "parameters": other.as_ref().ok().map(|other| describe_parameters(&other.parameters)),
            "error": other.as_ref().err().map(ToString::to_string),
        })
    });
    json!({
        "input": study.inputs[found.input],
        "form": fit.form.to_string(),
        "method": found.method.name(),
        "parameters": describe_parameters(&fit.parameters),
        "derived": describe_parameters(&found.derived),
        "other": other,
        "parameter_correlation": correlation,
        "zeros": complex(fit.model.zeros()),
        "poles": complex(fit.model.poles()),
        "is_delay_at_zero": fit.is_delay_at_zero,
        "frequencies": fit.frequencies,
        "verdict": found.verdict,
        "qualities": qualities,
        "error_ratio": fit.error_ratio,
        "cost": mismatch.cost,
        "mismatch_db": mismatch.rms_db,
        "mismatch_deg": mismatch.rms_phase_rad.to_degrees(),
        "unresolved": mismatch.unresolved,
        "worst_db": { "value": mismatch.worst_db.0, "frequency_rad_s": mismatch.worst_db.1 },
        "worst_deg": { "value": mismatch.worst_phase_rad.0.to_degrees(), "frequency_rad_s": mismatch.worst_phase_rad.1 },
        "gain_margin": found.margins.gain.map(|(at, margin)| json!({ "db": margin, "frequency_rad_s": at })),
        "phase_margin": found.margins.phase.map(|(at, margin)| json!({ "deg": margin.to_degrees(), "frequency_rad_s": at })),
    })
}

/// Writes the responses as CSV.
fn write_rows(path: &Path, study: &ResponseStudy) -> Result<(), String> {
    let table = response_table(&response_rows(study)).ok_or("no response to write")?;
    let bytes = report::csv(&table).map_err(|error| format!("{}: {error}", path.display()))?;
    write(path, &bytes)
}

fn print_study(study: &ResponseStudy) {
    let total: f64 = study.records.iter().map(|(_, length)| length).sum();
    let records = if study.records.len() == 1 { "record" } else { "records" };
    let (output, inputs) = (&study.output, study.inputs.join(", "));
    text::line(&format!("{output} over {inputs}: {} {records}, {} s", study.records.len(), text::number(total, 4)));
    let constants = study.responses.first().map(|response| response.overlap_constants.as_slice()).unwrap_or_default();
    let numbers = |values: &[f64]| values.iter().map(|value| text::number(*value, 3)).collect::<Vec<_>>().join(", ");
    text::line(&format!(
        "windows of {} s, overlapping by {}; overlap constants {}",
        numbers(&study.settings.windows_s),
        text::number(study.settings.overlap, 3),
        numbers(constants)
    ));
    study.left_out.iter().for_each(|line| text::line(&format!("left out: {line}")));
}

/// Columns that fit on a terminal; the last of several inputs alone.
const COLUMNS: [&str; 7] =
    ["frequency_rad_s", "gain_db", "gain_sd_db", "phase_deg", "phase_sd_deg", "coherence", "multiple_coherence"];

fn print_responses(study: &ResponseStudy) {
    let rows = response_rows(study);
    let shown = if study.inputs.len() > 1 { &COLUMNS[..] } else { &COLUMNS[..6] };
    for input in &study.inputs {
        text::line("");
        text::line(&format!("{} / {input}", study.output));
        let own: Vec<_> = rows.iter().filter(|row| row.input == *input).cloned().collect();
        response_table(&own).into_iter().for_each(|table| text::show(&table.select(shown)));
    }
}

fn print_fit(study: &ResponseStudy, found: &EquivalentStudy) {
    let fit = &found.fit;
    text::line("");
    text::line(&format!(
        "{} / {}, {} by {}: {} frequencies",
        study.output,
        study.inputs[found.input],
        fit.form,
        found.method.name(),
        fit.frequencies
    ));
    text::show(&parameter_table(found));
    if fit.is_delay_at_zero {
        let end = fit.parameter("tau").map_or(f64::NAN, |delay| delay.high);
        let interval = if end.is_finite() {
            format!("one-sided 95 % interval up to {} s", text::number(end, 5))
        } else {
            "no interval".to_owned()
        };
        text::line(&format!("tau is at its bound 0: {interval}"));
    }
    let mismatch = &found.mismatch;
    text::line(&format!(
        "cost {}, mismatch {} dB and {} deg",
        text::number(mismatch.cost, 3),
        text::number(mismatch.rms_db, 3),
        text::number(mismatch.rms_phase_rad.to_degrees(), 3)
    ));
    if mismatch.unresolved > 0 {
        text::line(&format!("{} points beside a resonance narrower than the windows are omitted", mismatch.unresolved));
    }
    text::verdict(&found.verdict);
    if let Some((method, Err(error))) = &found.other {
        text::line(&format!("{}: {error}", method.name()));
    }
}
