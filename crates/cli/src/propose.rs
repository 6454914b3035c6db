//! `doublet propose`: windows and noise that the recordings themselves suggest.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use doublet_engine::graph::{Context, Keyed};
use doublet_engine::keep::Lock;
use doublet_engine::report::{manoeuvre_table, onset_table, steady_noise_table};
use doublet_engine::session::{self, Edit, NoiseEdit, Opened, Session, WindowEdit};
use doublet_engine::stage::{self, FlightNoise, FlightProposals, LoadedFlight, NoiseFlight};

use crate::text;

#[derive(Debug, Args)]
pub struct ProposeArguments {
    /// Kind of proposal.
    #[command(subcommand)]
    pub what: What,
}

/// Kind of proposal.
#[derive(Debug, Subcommand)]
pub enum What {
    /// Manoeuvres, from the control deflections.
    #[command(alias = "windows")]
    Manoeuvres(Target),
    /// Steady parts, for estimating noise.
    Steady(Target),
    /// Clock shifts of the control sensors, from the first response.
    Onsets(Target),
    /// Standard deviations for Q and R, from steady parts.
    Noise(Target),
}

/// Session and whether to change it.
#[derive(Debug, Args)]
pub struct Target {
    /// Session file.
    pub session: PathBuf,
    /// Save the proposals to the session; the old file becomes *.bak.
    #[arg(long)]
    pub apply: bool,
    /// Lowest dynamic pressure, as a fraction of the flight's median.
    #[arg(long, value_name = "SHARE", default_value_t = stage::LEAST_PRESSURE_SHARE)]
    pub least_dynamic_pressure: f64,
}

/// Prints proposals and, where asked, puts them into the session.
pub fn propose(arguments: &ProposeArguments) -> Result<(), String> {
    let (What::Manoeuvres(target) | What::Steady(target) | What::Onsets(target) | What::Noise(target)) =
        &arguments.what;
    let _lock = if target.apply { Lock::lock_for_writing(&target.session)? } else { None };
    let opened = session::open(&target.session).map_err(|e| format!("{}: {e}", target.session.display()))?;
    let mut changed = opened.session.clone();
    let mut read = Vec::with_capacity(opened.session.flights.len());
    for flight in &opened.session.flights {
        let name = flight.name.as_str();
        let loaded = load(&opened, flight)?;
        let proposals = stage::proposals_above(name, &loaded, target.least_dynamic_pressure);
        proposals.findings.iter().for_each(|finding| text::line(&format!("{name}: {finding}")));
        let edit = match &arguments.what {
            What::Manoeuvres(_) => windows(&changed, name, &proposals),
            What::Steady(_) => steady(name, &proposals),
            What::Onsets(_) => {
                onsets(name, &loaded, &proposals);
                continue;
            }
            What::Noise(_) => {
                read.push((name, loaded, proposals));
                continue;
            }
        };
        changed = edit.apply(&changed).map_err(|error| error.to_string())?;
    }
    if let What::Noise(_) = &arguments.what {
        let flights = read.iter().map(|(name, loaded, proposals)| NoiseFlight { name, loaded, proposals });
        let found = stage::noise(&flights.collect::<Vec<_>>(), &opened.session.steady);
        for ((name, ..), noise) in read.iter().zip(&found) {
            let how = if noise.marked { "marked" } else { "found" };
            text::line(&format!("{name}: {} steady parts {how}", noise.windows.len()));
        }
        if let Some(noise) = found.first() {
            changed = noise_table(&changed, noise).apply(&changed).map_err(|error| error.to_string())?;
        }
    }
    if !target.apply {
        return Ok(());
    }
    if changed == opened.session {
        text::line("nothing to change");
        return Ok(());
    }
    session::save(&changed, &opened.path).map_err(|error| error.to_string())?;
    text::line(&format!("written to {}", opened.path.display()));
    Ok(())
}

fn load(opened: &Opened, flight: &session::Flight) -> Result<Keyed<LoadedFlight>, String> {
    Context::new(&opened.folder)
        .get::<LoadedFlight>(&flight.as_read(), ())
        .map_err(|error| format!("flight '{}': {error}", flight.name))
}

fn onsets(flight: &str, loaded: &LoadedFlight, proposals: &FlightProposals) {
    let shifts = stage::onset_shifts(loaded, proposals);
    text::line(&format!(
        "{flight}: shift of the control sensors by the first response (add it to shift_s of their clock)"
    ));
    text::show(&onset_table(&shifts));
    if let Some((mean, error)) = stage::mean_shift(&shifts) {
        let (mean, error) = (text::number(mean, 3), text::number(error, 2));
        text::line(&format!("  all: {mean} s, standard error {error} s; includes the lag of the actuator"));
    }
}

fn windows(session: &Session, flight: &str, proposals: &FlightProposals) -> Edit {
    text::line(&format!("{flight}: {} manoeuvres", proposals.windows.len()));
    text::show(&manoeuvre_table(session, proposals));
    Edit::Window(WindowEdit::AddAll(stage::open_windows(session, proposals)))
}

fn steady(flight: &str, proposals: &FlightProposals) -> Edit {
    text::line(&format!("{flight}: {} steady parts", proposals.steady.len()));
    for steady in &proposals.steady {
        let roles: Vec<_> = steady.roles.iter().map(|role| role.name()).collect();
        let roles = if roles.is_empty() { "all".to_owned() } else { roles.join(", ") };
        text::line(&format!(
            "  {} s to {} s: {roles}",
            text::number(steady.window.start_s, 6),
            text::number(steady.window.end_s, 6)
        ));
    }
    Edit::Noise(NoiseEdit::Steady { flight: flight.to_owned(), windows: proposals.steady.clone() })
}

fn noise_table(session: &Session, noise: &FlightNoise) -> Edit {
    text::line("noise over the steady parts of all flights");
    text::show(&steady_noise_table(session, noise));
    Edit::Noise(NoiseEdit::Set { entries: stage::open_entries(session, noise), reason: String::new() })
}
