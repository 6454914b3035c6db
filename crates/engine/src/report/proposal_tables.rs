//! Tables of what the recordings propose: manoeuvres, noise over steady parts and by likelihood, shifts of the control sensors.

use doublet_core::prep::NoiseStatistics;
use doublet_core::reconstruct::tuning::noise::{NoiseProposal, ProposedDeviation};
use doublet_core::reconstruct::{Input, Measurement};

use super::table::{Cell, Column, Table, TableOf};
use crate::notation::significant;
use crate::session::Session;
use crate::stage::{FlightNoise, FlightProposals, NoiseRow, OnsetShift, WindowProposal};

/// Manoeuvres proposed, beside those of the session that cover them.
pub fn manoeuvre_table(session: &Session, proposals: &FlightProposals) -> Table {
    let known = |proposal: &WindowProposal| match proposal.covering_window(session) {
        Some(window) => Cell::text(&window.name),
        None if session.has_refused(&proposal.manoeuvre) => Cell::text("refused"),
        None => Cell::Empty,
    };
    TableOf::new("proposed_manoeuvres", "Manoeuvres found in the control deflections.", &proposals.windows)
        .text("name", "Manoeuvre", |row| &row.manoeuvre.name)
        .number("start_s", "Start", "s", 6, |row| row.manoeuvre.window.start_s)
        .number("end_s", "End", "s", 6, |row| row.manoeuvre.window.end_s)
        .number("onset_s", "Onset", "s", 6, |row| row.onset_s)
        .number("amplitude_deg", "Amplitude", "deg", 3, |row| row.amplitude_rad.to_degrees())
        .number("base_time_s", "Base time", "s", 3, |row| row.base_time_s)
        .number("confidence", "Confidence", "", 2, |row| row.confidence)
        .column(Column::new("window", "In the session as"), |row| known(row))
        .done()
}

/// Noise of every entry over the steady parts, with what is proposed for it and why.
pub fn steady_noise_table(session: &Session, noise: &FlightNoise) -> Table {
    let set =
        |row: &NoiseRow| session.noise_reasons.get(row.channel.name()).map(|reason| format!("kept as set: {reason}"));
    let of = |value: fn(&NoiseStatistics) -> f64| move |row: &&NoiseRow| row.statistics.as_ref().map(value);
    TableOf::new("steady_noise", "Noise over the steady parts of all flights.", &noise.rows)
        .text("entry", "Entry", |row| row.channel.name())
        .number("used", "Session", "", 3, |row| row.channel.std(session))
        .maybe("proposed", "Proposed", "", 3, |row| row.proposed())
        .maybe("deviation", "Std deviation", "", 3, of(|found| found.std))
        .maybe("difference_deviation", "Of differences", "", 3, of(|found| found.difference_std))
        .maybe("step", "Step", "", 3, of(|found| found.resolution))
        .column(Column::new("samples", "Samples"), |row| {
            row.statistics.as_ref().map_or(Cell::Empty, |found| Cell::Count(found.samples))
        })
        .maybe("lag_one", "Lag one", "", 2, of(|found| found.lag_one))
        .maybe("whiteness", "Whiteness", "", 3, of(|found| found.whiteness))
        .column(Column::new("origin", "From"), |row| Cell::text(set(row).unwrap_or_else(|| row.origin())))
        .done()
}

/// Standard deviations by maximum likelihood beside those set.
pub fn tuned_noise_table(found: &NoiseProposal) -> Table {
    let inputs = Input::ALL.into_iter().map(|entry| (entry.name(), entry.dimension(), &found.process[entry as usize]));
    let measurements =
        Measurement::ALL.into_iter().map(|entry| (entry.name(), entry.dimension(), &found.measurement[entry as usize]));
    let rows = inputs.chain(measurements).filter_map(|(name, dimension, own)| Some((name, dimension, own.as_ref()?)));
    TableOf::new("tuned_noise", "Standard deviations by maximum likelihood, SI.", rows)
        .text("noise", "Noise", |row| row.0)
        .text("unit", "Unit", |row| row.1.si_symbol())
        .number("set", "Set", "", 4, |row| row.2.present)
        .maybe("proposed", "Proposed", "", 4, |row| (!row.2.at_bound).then_some(row.2.proposed))
        .column(Column::new("error", "Std error"), |row| Cell::text(describe_error(row.2)))
        .done()
}

fn describe_error(proposed: &ProposedDeviation) -> String {
    match proposed.log_standard_error.map(f64::exp) {
        _ if proposed.at_bound => "not determined: the likelihood has no maximum here, settings unchanged".to_owned(),
        Some(factor) if factor < 2.0 => format!("{} %", significant(100.0 * (factor - 1.0), 2)),
        Some(factor) => format!("factor {}", significant(factor, 3)),
        None => "not determined".to_owned(),
    }
}

/// Shifts of the control sensors by the first response to each manoeuvre.
pub fn onset_table(shifts: &[OnsetShift]) -> Table {
    TableOf::new("onsets", "Shift of the control sensors by the first response.", shifts)
        .text("manoeuvre", "Manoeuvre", |row| &row.manoeuvre)
        .maybe("shift_s", "Shift", "s", 3, |row| Some(row.found.as_ref().ok()?.shift_s))
        .maybe("standard_error_s", "Std error", "s", 3, |row| Some(row.found.as_ref().ok()?.shift_sd_s))
        .maybe("share", "Share", "", 3, |row| Some(row.found.as_ref().ok()?.share))
        .column(Column::new("error", ""), |row| {
            row.found.as_ref().err().map_or(Cell::Empty, |error| Cell::text(error.to_string()))
        })
        .done()
}
