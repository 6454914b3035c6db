//! `doublet fidelity`: the estimates of the shipped flight beside its truth, as a document.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::report::{self, FitRow, PredictionAgreement, Results};
use doublet_engine::session::Session;
use doublet_engine::study::Coverage;
use doublet_engine::{builtin, session};

use crate::coverage;
use crate::coverage::CoverageArguments;
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::compute_session;
use crate::text::{self, number};
use crate::thesis::{self, Run};

#[derive(Debug, Args)]
pub struct FidelityArguments {
    /// Document whose tables are rewritten below its marker line.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
    /// Flights of the coverage study.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
}

/// What comes before the part this command writes; everything behind it is replaced, up to [`END`] where there is one.
const MARKER: &str = "<!-- doublet fidelity writes all that follows -->\n";
/// What comes behind it.
const END: &str = "<!-- end of what doublet fidelity writes -->\n";

/// Identifies the shipped flight both ways, flies the coverage study, and writes the tables behind the marker of the document.
pub fn fidelity(arguments: &FidelityArguments) -> Result<(), String> {
    let place = arguments.out.display();
    let document = doublet_core::load::read_text(&arguments.out).map_err(|error| format!("{place}: {error}"))?;
    let kept = document.find(MARKER).map(|start| &document[..start + MARKER.len()]);
    let kept =
        kept.ok_or_else(|| format!("{place} has no line '{}': put it where the tables belong", MARKER.trim()))?;
    let after = document.find(END).map(|end| format!("\n{}", &document[end..])).unwrap_or_default();
    let truth = truth()?;
    let mut tables = String::new();
    pooled(&mut tables, &run("demo", Session::clone)?.results, &truth).map_err(|error| error.to_string())?;
    let study = CoverageArguments {
        session: None,
        scenario: coverage::SCENARIO.to_owned(),
        gusts: None,
        realisations: arguments.realisations,
        seed: 1,
        recorded: false,
        verdict: false,
        modes: false,
        design: None,
        known: 0,
        surfaces: Vec::new(),
        time: 0.0,
    };
    covered(&mut tables, &coverage::computed(&study)?).map_err(|error| error.to_string())?;
    let treated = run("demo_thesis", Session::clone)?;
    let early = run("demo_thesis", thesis::early_sensors)?;
    by_manoeuvre(&mut tables, &treated.results, &truth).map_err(|error| error.to_string())?;
    thesis::weaknesses(&mut tables, &treated, &early).map_err(|error| error.to_string())?;
    std::fs::write(&arguments.out, format!("{kept}\n{tables}{after}")).map_err(|error| format!("{place}: {error}"))?;
    text::line(&format!("tables in {place}"));
    Ok(())
}

/// Derivatives of the shipped flight's truth.
fn truth() -> Result<BTreeMap<String, f64>, String> {
    let text = builtin::text("flights", "flights/demo/truth.toml").ok_or("the shipped flight has no truth")?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| error.to_string())?;
    let derivatives = table.get("derivatives").and_then(toml::Value::as_table).into_iter().flatten();
    Ok(derivatives.filter_map(|(name, value)| Some((name.clone(), value.as_float()?))).collect())
}

/// A session that comes with the program, changed and run.
fn run(name: &str, change: impl Fn(&Session) -> Session) -> Result<Run, String> {
    let text = builtin::session(name).ok_or_else(|| format!("no session '{name}' comes with the program"))?;
    let session = change(&session::parse(text).map_err(|error| format!("{name}: {error}"))?);
    let progress = Progress::new();
    let snapshot = compute_session(&session, Path::new("."), &[], &progress, 1.0);
    progress.finish();
    let snapshot = snapshot?;
    Ok(Run { results: report::build(&session, &snapshot), session, snapshot })
}

/// Pooled derivatives beside the truth, and how well they predict what they did not see.
fn pooled(out: &mut String, results: &Results, truth: &BTreeMap<String, f64>) -> std::fmt::Result {
    writeln!(out, "## Shipped flight, shipped settings\n")?;
    writeln!(out, "| derivative | truth | estimate | standard error | corrected | error in corrected errors |")?;
    writeln!(out, "|---|---|---|---|---|---|")?;
    let (mut within, mut count) = (0, 0);
    for row in results.pooled.iter().flat_map(|fit| &fit.derivatives) {
        let Some(value) = truth.get(&row.name) else { continue };
        let off = (row.estimate - value) / row.corrected_standard_error;
        within += usize::from(off.abs() < 2.0);
        count += 1;
        let (estimate, plain) = (number(row.estimate, 4), number(row.standard_error, 2));
        let corrected = number(row.corrected_standard_error, 2);
        writeln!(out, "| {} | {} | {estimate} | {plain} | {corrected} | {off:+.2} |", row.name, number(*value, 4))?;
    }
    writeln!(out, "\n{within} of {count} within two corrected standard errors.\n")?;
    writeln!(
        out,
        "Validation manoeuvres: R2 of the prediction compared with the observed coefficient, both smoothed alike by the"
    )?;
    writeln!(
        out,
        "differentiation of the rates (`preparation.differentiation_half_width_s`): with the constants of the"
    )?;
    writeln!(
        out,
        "identification (their mean over its manoeuvres), and with the constant fitted to the manoeuvre predicted.\n"
    )?;
    writeln!(out, "| manoeuvre | coefficient | R2, identified constants | R2, own constant |\n|---|---|---|---|")?;
    for row in results.predictions.iter().filter(|row| row.role == "validation") {
        let PredictionAgreement { r_squared_identified_constants: identified, r_squared_own_constant: own, .. } =
            row.agreement;
        writeln!(out, "| {} | {} | {identified:.4} | {own:.4} |", row.window, row.coefficient)?;
    }
    Ok(())
}

fn covered(out: &mut String, study: &Coverage) -> std::fmt::Result {
    writeln!(out, "\n## Coverage of the intervals\n")?;
    writeln!(
        out,
        "{} flights of {} manoeuvres, each with its own gusts, pilot and noise: per cent of the 95 % intervals that contain the truth.\n",
        study.realisations, study.manoeuvres
    )?;
    writeln!(
        out,
        "| derivative | truth | mean | scatter | bias/scatter | corrected error | conventional % | corrected % |"
    )?;
    writeln!(out, "|---|---|---|---|---|---|---|---|")?;
    for row in &study.derivatives {
        let [truth, mean] = [row.truth, row.mean].map(|value| number(value, 4));
        let [scatter, corrected] = [row.scatter, row.corrected_error].map(|value| number(value, 3));
        let (plain, coloured) = (100.0 * row.conventional, 100.0 * row.corrected);
        let (name, bias) = (&row.name, row.bias);
        writeln!(
            out,
            "| {name} | {truth} | {mean} | {scatter} | {bias:+.2} | {corrected} | {plain:.1} | {coloured:.1} |"
        )?;
    }
    Ok(())
}

/// Derivatives from every manoeuvre alone, as thesis Tables 6.3-6.9: least, mean, greatest, scatter.
fn by_manoeuvre(out: &mut String, results: &Results, truth: &BTreeMap<String, f64>) -> std::fmt::Result {
    writeln!(out, "\n## Shipped flight treated as in the thesis\n")?;
    writeln!(
        out,
        "Every manoeuvre separately (`sessions/demo_thesis.toml`), over identification manoeuvres; thrust is inside CX and Cm.\n"
    )?;
    writeln!(
        out,
        "| derivative | truth | least | mean | greatest | scatter | mean R2 |\n|---|---|---|---|---|---|---|"
    )?;
    let mut rows: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    let windows = results.windows.iter().filter(|window| window.role == "identification");
    let fits: Vec<&FitRow> = windows.flat_map(|window| &window.fits).filter(|fit| fit.error.is_none()).collect();
    for (fit, row) in fits.iter().flat_map(|fit| fit.derivatives.iter().map(move |row| (fit, row))) {
        match rows.iter_mut().find(|(name, _)| *name == row.name) {
            Some((_, found)) => found.push((row.estimate, fit.r_squared)),
            None => rows.push((&row.name, vec![(row.estimate, fit.r_squared)])),
        }
    }
    rows.sort_by_key(|(name, _)| {
        results.pooled.iter().position(|fit| name.starts_with(&format!("{}_", fit.coefficient)))
    });
    for (name, found) in rows {
        let count = found.len() as f64;
        let mean = found.iter().map(|(value, _)| value).sum::<f64>() / count;
        let scatter = (found.iter().map(|(value, _)| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
        let least = found.iter().map(|(value, _)| *value).fold(f64::INFINITY, f64::min);
        let greatest = found.iter().map(|(value, _)| *value).fold(f64::NEG_INFINITY, f64::max);
        let r_squared = found.iter().map(|(_, r_squared)| r_squared).sum::<f64>() / count;
        let truth = truth.get(name).map_or_else(|| "-".to_owned(), |value| number(*value, 4));
        let [least, mean, greatest] = [least, mean, greatest].map(|value| number(value, 4));
        writeln!(
            out,
            "| {name} | {truth} | {least} | {mean} | {greatest} | {} | {r_squared:.3} |",
            number(scatter, 2)
        )?;
    }
    Ok(())
}
