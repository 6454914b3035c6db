//! `doublet debrief`: flights of a design against what the design promised, and against the truth where it is known.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::keep::Put;
use doublet_engine::planning::{
    self, Debrief, FLIGHT_FOLDER, Promise, debrief_document, debrief_table, true_derivatives, with_recordings_in,
};
use doublet_engine::run::{Control, Snapshot};
use doublet_report::{DocumentSet, ReportFormat};

use crate::arguments::{REPORTS, report_format};
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{compute_session, named, open_to_run};
use crate::text::{self, number};

/// File of the truth of a simulated flight.
const TRUTH: &str = "truth.toml";

#[derive(Debug, Args)]
pub struct DebriefArguments {
    /// Folder of the design: design.json and design_session.toml.
    pub design: PathBuf,
    /// Folder with the recordings of a flight. Repeatable [default: flight].
    #[arg(long, value_name = "DIR")]
    flight: Vec<PathBuf>,
    /// Session of the flight [default: design_session.toml].
    #[arg(long, value_name = "FILE", conflicts_with = "flight")]
    session: Option<PathBuf>,
    /// Folder for the debrief as a page.
    #[arg(long, value_name = "DIR", value_parser = output_path())]
    out: Option<PathBuf>,
    /// Formats of the page.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = REPORTS, value_parser = report_format())]
    format: Vec<String>,
}

/// Runs the flights of a design and prints what was promised, obtained and is true.
pub fn debrief(arguments: &DebriefArguments) -> Result<(), String> {
    let place = arguments.design.join("design.json");
    let named = |path: &Path, error: String| format!("{}: {error}", path.display());
    let promise = Promise::parse(&read(&place)?).map_err(|error| named(&place, error))?;
    let path = arguments.session.clone().unwrap_or_else(|| arguments.design.join("design_session.toml"));
    let opened = open_to_run(&path)?;
    let mut folders = arguments.flight.clone();
    if folders.is_empty() {
        folders.push(opened.folder.join(FLIGHT_FOLDER));
    }
    let progress = Progress::new();
    let mut found: Vec<(Snapshot, Option<BTreeMap<String, f64>>)> = Vec::new();
    for folder in &folders {
        let session = if arguments.flight.is_empty() {
            opened.session.clone()
        } else {
            let absolute = std::path::absolute(folder).map_err(|error| named(folder, error.to_string()))?;
            with_recordings_in(&opened.session, &absolute.to_string_lossy())
        };
        let snapshot = compute_session(&session, &opened.folder, &[], &progress, 1.0);
        let snapshot = snapshot.map_err(|error| named(folder, error))?;
        let truth = folder.join(TRUTH);
        let truth = truth.is_file().then(|| true_derivatives(&read(&truth)?).map_err(|error| named(&truth, error)));
        found.push((snapshot, truth.transpose()?));
    }
    progress.finish();
    let debrief = planning::debrief(&promise, &found).map_err(|error| error.to_string())?;
    let written = arguments.out.as_ref().map(|folder| write(arguments, folder, &opened.session.title, &debrief));
    let written = written.transpose()?;
    text::json(&debrief)?;
    print(&debrief);
    if let Some(put) = written {
        put.notes().for_each(|note| text::line(&note));
        text::line(&format!("page in {}", put.folder.display()));
    }
    Ok(())
}

/// Writes the page and the numbers beside it.
fn write(arguments: &DebriefArguments, folder: &Path, title: &str, found: &Debrief) -> Result<Put, String> {
    let numbers = serde_json::to_string_pretty(found).map_err(|error| error.to_string())?;
    let beside = [("debrief.json".to_owned(), numbers.into_bytes())];
    let formats = named(&ReportFormat::ALL, &arguments.format, |format| format.name());
    let set = DocumentSet { folder, name: "debrief", formats: &formats, beside: &beside };
    set.write(&debrief_document(title, found), "debrief", &Control::default(), &|_| {})
}

fn read(path: &Path) -> Result<String, String> {
    doublet_core::load::read_text(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn print(found: &Debrief) {
    let Debrief { kind, time_s, flights, .. } = found;
    text::line(&format!("{kind}, {} s of manoeuvres, flights: {flights}", number(*time_s, 4)));
    text::show(&debrief_table(found));
    let [over, noise] = [found.median_over_promised, found.median_noise_over_promised].map(|ratio| number(ratio, 3));
    text::line(&format!("obtained over promised: median {over}; noise of the fits alone {noise}"));
    if let (Some(inside), Some(noise), Some(off)) = (found.inside_percent, found.inside_noise_percent, found.rms_off) {
        let off = number(off, 3);
        text::line(&format!("truth inside the 95 % intervals: {inside:.1} %; rms error {off} std errors"));
        text::line(&format!("truth inside the intervals of the noise alone: {noise:.1} %"));
    }
}
