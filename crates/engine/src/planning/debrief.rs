//! A designed flight after it was flown: what was promised, what was obtained, what is true.

use std::collections::BTreeMap;

use doublet_core::statistics::NORMAL_95;
use serde::{Deserialize, Serialize};

use crate::date;
use crate::graph::StageResult;
use crate::notation::significant;
use crate::report::document::{Block, Document, Section};
use crate::report::{Cell, Column, Table, TableOf};
use crate::snapshot::Snapshot;
use crate::study::{Estimate, estimates};

/// What a design promised, of its `design.json`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Promise {
    /// Kind of the input.
    pub kind: String,
    /// Time of all manoeuvres, s.
    pub time_s: f64,
    /// Derivatives.
    pub predicted: Vec<PromisedError>,
}

/// A derivative with its promised error.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PromisedError {
    pub name: String,
    /// Corrected standard error; none where the input does not move what it needs.
    pub corrected: Option<f64>,
    /// The same with what path and sensors cost; none in designs of earlier versions.
    #[serde(default)]
    pub promised: Option<f64>,
}

/// A derivative over all flights of a design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DebriefRow {
    pub name: String,
    pub promised: f64,
    pub promised_noise: f64,
    pub estimate: f64,
    pub obtained: f64,
    pub obtained_noise: f64,
    pub over_promised: f64,
    pub noise_over_promised: f64,
    pub truth: Option<f64>,
    pub off: Option<f64>,
    pub inside: Option<usize>,
    pub inside_noise: Option<usize>,
}

/// What flights of a design gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Debrief {
    pub kind: String,
    pub time_s: f64,
    pub flights: usize,
    pub derivatives: Vec<DebriefRow>,
    pub median_over_promised: f64,
    pub median_noise_over_promised: f64,
    pub inside_percent: Option<f64>,
    pub inside_noise_percent: Option<f64>,
    pub rms_off: Option<f64>,
}

impl Promise {
    /// Reads `design.json`.
    pub fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}

/// True derivatives of a `truth.toml`.
pub fn true_derivatives(text: &str) -> Result<BTreeMap<String, f64>, String> {
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| error.to_string())?;
    let derivatives = table.get("derivatives").and_then(toml::Value::as_table).into_iter().flatten();
    Ok(derivatives.filter_map(|(name, value)| Some((name.clone(), value.as_float()?))).collect())
}

/// Compares flights of a design, each run as its session, with the promise and with the truth of each flight where it is known.
pub fn debrief(promise: &Promise, flights: &[(Snapshot, Option<BTreeMap<String, f64>>)]) -> StageResult<Debrief> {
    let found = flights.iter().map(|(snapshot, truth)| {
        let pooled = snapshot.pooled.ready().ok_or("the flight has no pooled fit: check its findings")?;
        let all = estimates(pooled, |fit| &fit.corrected_errors)?;
        let noise = estimates(pooled, |fit| &fit.noise_errors)?;
        let one = |((name, value, _, error), (.., noise)): (Estimate, Estimate)| {
            let truth = truth.as_ref().and_then(|truth| truth.get(&name).copied());
            (name, Obtained { value, error, noise, truth })
        };
        Ok(all.into_iter().zip(noise).map(one).collect())
    });
    let found: Vec<BTreeMap<String, Obtained>> = found.collect::<StageResult<_>>()?;
    let mut derivatives = Vec::new();
    let (mut all_off, mut all_inside_noise) = (Vec::new(), 0);
    for own in &promise.predicted {
        let Some(promised) = own.promised.or(own.corrected) else { continue };
        let rows: Option<Vec<Obtained>> = found.iter().map(|flight| flight.get(&own.name).copied()).collect();
        let rows = rows.ok_or_else(|| format!("{} was promised and is not in every flight", own.name))?;
        let off: Option<Vec<f64>> = rows.iter().map(|row| Some(row.miss()? / row.error)).collect();
        let off_noise: Option<Vec<f64>> = rows.iter().map(|row| Some(row.miss()? / row.noise)).collect();
        let inside_noise = off_noise.as_deref().map(count_inside);
        all_off.extend(off.iter().flatten());
        all_inside_noise += inside_noise.unwrap_or(0);
        let promised_noise = own.corrected.unwrap_or(promised);
        let obtained = root_mean_square(rows.iter().map(|row| row.error));
        let obtained_noise = root_mean_square(rows.iter().map(|row| row.noise));
        derivatives.push(DebriefRow {
            name: own.name.clone(),
            promised,
            promised_noise,
            estimate: rows.iter().map(|row| row.value).sum::<f64>() / rows.len() as f64,
            obtained,
            obtained_noise,
            over_promised: obtained / promised,
            noise_over_promised: obtained_noise / promised_noise,
            truth: rows.first().and_then(|row| row.truth),
            inside: off.as_deref().map(count_inside),
            inside_noise,
            off: off.map(|off| root_mean_square(off.into_iter())),
        });
    }
    let ratio = |value: &dyn Fn(&DebriefRow) -> f64| {
        let mut ratios: Vec<f64> = derivatives.iter().map(value).collect();
        doublet_core::statistics::median(&mut ratios).ok_or("the design promised no error")
    };
    let percent = |inside: usize| (!all_off.is_empty()).then(|| 100.0 * inside as f64 / all_off.len() as f64);
    Ok(Debrief {
        kind: promise.kind.clone(),
        time_s: promise.time_s,
        flights: flights.len(),
        median_over_promised: ratio(&|row| row.over_promised)?,
        median_noise_over_promised: ratio(&|row| row.noise_over_promised)?,
        inside_percent: percent(count_inside(&all_off)),
        inside_noise_percent: percent(all_inside_noise),
        rms_off: (!all_off.is_empty()).then(|| root_mean_square(all_off.iter().copied())),
        derivatives,
    })
}

/// A derivative of one flight.
#[derive(Clone, Copy)]
struct Obtained {
    value: f64,
    /// Corrected standard error, and the part of it that is noise.
    error: f64,
    noise: f64,
    truth: Option<f64>,
}

impl Obtained {
    /// Estimate less truth.
    fn miss(&self) -> Option<f64> {
        Some(self.value - self.truth?)
    }
}

fn count_inside(off: &[f64]) -> usize {
    off.iter().filter(|z| z.abs() <= NORMAL_95).count()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / count).sqrt()
}

/// Lays a debrief out as a page: what was promised, obtained and is true.
pub fn debrief_document(title: &str, found: &Debrief) -> Document {
    let fact = |name: &str, text: String| (name.to_owned(), text);
    let mut facts = vec![
        fact("Input", format!("{}, {} s of manoeuvres", found.kind, significant(found.time_s, 4))),
        fact("Flights", found.flights.to_string()),
        fact("Obtained over promised error", format!("{} (median)", significant(found.median_over_promised, 3))),
        fact(
            "Noise of the fits over promised",
            format!("{} (median)", significant(found.median_noise_over_promised, 3)),
        ),
    ];
    facts.extend(
        found
            .inside_percent
            .map(|percent| fact("Truth inside the 95 % intervals", format!("{} %", significant(percent, 3)))),
    );
    let noise = found.inside_noise_percent;
    facts
        .extend(noise.map(|percent| fact("Inside those of the noise alone", format!("{} %", significant(percent, 3)))));
    facts.extend(found.rms_off.map(|off| fact("Rms error", format!("{} standard errors", significant(off, 3)))));
    Document {
        title: "Debrief: promised, obtained, true".to_owned(),
        subtitle: title.to_owned(),
        date: date::today(),
        cover: vec![Block::Facts(facts)],
        sections: vec![Section::plain("derivatives", "Derivatives", false, vec![Block::Table(debrief_table(found))])],
        ..Document::default()
    }
}

/// Derivatives: promised against obtained errors, and the truth where it is known.
pub fn debrief_table(found: &Debrief) -> Table {
    let caption = "Corrected standard errors, root mean square over the flights, and their part by the noise of the fits; estimates are means. Truth is known of simulated flights only.";
    let inside = |inside: Option<usize>| match inside {
        Some(inside) => Cell::text(format!("{inside} of {}", found.flights)),
        None => Cell::Empty,
    };
    TableOf::new("debrief", caption, &found.derivatives)
        .symbol("name", "Derivative", |row| &row.name)
        .number("promised", "Promised error", "", 2, |row| row.promised)
        .number("obtained", "Obtained error", "", 2, |row| row.obtained)
        .number("over_promised", "Obtained over promised", "", 3, |row| row.over_promised)
        .number("promised_noise", "Promised noise", "", 2, |row| row.promised_noise)
        .number("noise_over_promised", "Obtained over promised noise", "", 3, |row| row.noise_over_promised)
        .number("estimate", "Estimate", "", 4, |row| row.estimate)
        .maybe("truth", "Truth", "", 4, |row| row.truth)
        .maybe("off", "Rms error in std errors", "", 3, |row| row.off)
        .column(Column::new("inside", "Truth inside 95 %"), |row| inside(row.inside))
        .column(Column::new("inside_noise", "Inside noise 95 %"), |row| inside(row.inside_noise))
        .done()
}
