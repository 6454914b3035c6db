//! `doublet propose`: windows and noise that the recordings themselves suggest.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use doublet_core::align::{OnsetSettings, onset_alignment};
use doublet_core::prep::{Differentiation, differentiate};
use doublet_core::quantity::Role;
use doublet_core::series::{Series, TimeRange};
use doublet_engine::graph::{Context, Keyed};
use doublet_engine::keep::Lock;
use doublet_engine::session::{self, Edit, NoiseChannel, NoiseEdit, Opened, Session, Surface, WindowEdit};
use doublet_engine::stage::{self, FlightNoise, FlightProposals, LoadedFlight, NoiseFlight};

use crate::text;

/// Arguments of `propose`.
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
///
/// # Errors
/// One line when the session or a recording cannot be read, or the session cannot be written.
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

/// Shift each manoeuvre asks for so that the angular acceleration answers its control at once (thesis 4.4.3), and their mean.
fn onsets(flight: &str, loaded: &LoadedFlight, proposals: &FlightProposals) {
    /// Steady flight before the onset and response after it that are looked at, s.
    const AROUND_S: [f64; 2] = [1.0, 2.5];
    let series = |role: Role| loaded.recording.role(role).map(|channel| &channel.series);
    let motion = [Role::RollRate, Role::PitchRate, Role::YawRate, Role::BankAngle, Role::PitchAngle];
    let method = Differentiation::LocalPolynomial { degree: 2, half_width: 2 };
    let answers = Surface::ALL.map(|surface| {
        let (control, rate) = (series(surface.role())?, series(surface.rate())?);
        let slope = differentiate(&rate.time_s, &rate.values, method).map_err(|error| error.to_string());
        let response = slope.map(|slope| Series { time_s: rate.time_s.clone(), values: slope.into() });
        Some((surface, control, response))
    });
    let (mut rows, mut sum, mut weights) = (Vec::new(), 0.0, 0.0);
    for proposal in &proposals.windows {
        let moved = |(surface, ..): &&(Surface, &Series, _)| Some(*surface) == proposal.manoeuvre.surface;
        let Some((_, control, response)) = answers.iter().flatten().find(moved) else { continue };
        let window = TimeRange { start_s: proposal.onset_s - AROUND_S[0], end_s: proposal.onset_s + AROUND_S[1] };
        let found = response.as_ref().map_err(Clone::clone).and_then(|response| {
            let companions: Vec<&Series> =
                motion.into_iter().filter_map(series).filter(|other| other.time_s == response.time_s).collect();
            onset_alignment(control, response, &companions, window, &OnsetSettings::default())
                .map_err(|error| error.to_string())
        });
        let cells = match found {
            Ok(found) => {
                let weight = found.shift_sd_s.powi(-2);
                (sum, weights) = (sum + weight * found.shift_s, weights + weight);
                [found.shift_s, found.shift_sd_s, found.share].map(|value| text::number(value, 3)).to_vec()
            }
            Err(error) => {
                text::line(&format!("  {}: {error}", proposal.manoeuvre.name));
                continue;
            }
        };
        rows.push([vec![format!("  {}", proposal.manoeuvre.name)], cells].concat());
    }
    text::line(&format!(
        "{flight}: shift of the control sensors by the first response (add it to shift_s of their clock)"
    ));
    text::table(&["  manoeuvre", "shift s", "std error s", "share"], &rows);
    if weights > 0.0 {
        let (mean, error) = (text::number(sum / weights, 3), text::number(weights.powf(-0.5), 2));
        text::line(&format!("  all: {mean} s, standard error {error} s; includes the lag of the actuator"));
    }
}

fn windows(session: &Session, flight: &str, proposals: &FlightProposals) -> Edit {
    text::line(&format!("{flight}: {} manoeuvres", proposals.windows.len()));
    let rows = proposals.windows.iter().map(|proposal| {
        let window = proposal.manoeuvre.window;
        vec![
            format!("  {}", proposal.manoeuvre.name),
            text::number(window.start_s, 6),
            text::number(window.end_s, 6),
            text::number(proposal.onset_s, 6),
            text::number(proposal.amplitude_rad.to_degrees(), 3),
            text::number(proposal.base_time_s, 3),
            format!("{:.2}", proposal.confidence),
            match proposal.covering_window(session) {
                Some(window) => window.name.clone(),
                None if session.has_refused(&proposal.manoeuvre) => "refused".to_owned(),
                None => "-".to_owned(),
            },
        ]
    });
    let header = ["  manoeuvre", "from s", "to s", "onset s", "deg", "base s", "confidence", "in the session as"];
    text::table(&header, &rows.collect::<Vec<_>>());
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
    let rows = noise.rows.iter().map(|row| {
        let statistics = |value: &dyn Fn(&doublet_core::prep::NoiseStatistics) -> String| {
            row.statistics.as_ref().map_or_else(|| "-".to_owned(), value)
        };
        vec![
            format!("  {}", row.channel.name()),
            text::number(row.channel.std(session), 3),
            row.proposed().map_or_else(|| "-".to_owned(), |proposed| text::number(proposed, 3)),
            statistics(&|found| text::number(found.std, 3)),
            statistics(&|found| text::number(found.difference_std, 3)),
            statistics(&|found| text::number(found.resolution, 3)),
            statistics(&|found| found.samples.to_string()),
            statistics(&|found| format!("{:.2}", found.lag_one)),
            statistics(&|found| format!("{:.3}", found.whiteness)),
            origin(session, row.channel).unwrap_or_else(|| row.origin()),
        ]
    });
    let header = [
        "  entry",
        "session",
        "proposed",
        "std deviation",
        "of differences",
        "step",
        "samples",
        "lag one",
        "whiteness",
        "from",
    ];
    text::table(&header, &rows.collect::<Vec<_>>());
    Edit::Noise(NoiseEdit::Set { entries: stage::open_entries(session, noise), reason: String::new() })
}

fn origin(session: &Session, channel: NoiseChannel) -> Option<String> {
    session.noise_reasons.get(channel.name()).map(|reason| format!("kept as set: {reason}"))
}
