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
    pub over_promised: f64,
    pub truth: Option<f64>,
    pub off: Option<f64>,
    pub inside: Option<usize>,
}

/// What flights of a design gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Debrief {
    pub kind: String,
    pub time_s: f64,
    pub flights: usize,
    pub derivatives: Vec<DebriefRow>,
    pub median_over_promised: f64,
    pub inside_percent: Option<f64>,
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
        Ok((estimates((**pooled).clone(), |fit| &fit.corrected_errors)?, truth))
    });
    let found: Vec<_> = found.collect::<StageResult<_>>()?;
    let mut derivatives = Vec::new();
    let mut all_off = Vec::new();
    for own in &promise.predicted {
        let Some(promised) = own.promised.or(own.corrected) else { continue };
        let of_flight = |(estimates, truth): &(Vec<Estimate>, &Option<BTreeMap<String, f64>>)| {
            let (name, estimate, _, error) = estimates.iter().find(|estimate| estimate.0 == own.name)?.clone();
            let truth = truth.as_ref().and_then(|truth| truth.get(&name).copied());
            Some((estimate, error, truth))
        };
        let rows: Option<Vec<(f64, f64, Option<f64>)>> = found.iter().map(of_flight).collect();
        let rows = rows.ok_or_else(|| format!("{} was promised and is not in every flight", own.name))?;
        let count = rows.len() as f64;
        let obtained = (rows.iter().map(|row| row.1 * row.1).sum::<f64>() / count).sqrt();
        let off: Option<Vec<f64>> =
            rows.iter().map(|(estimate, error, truth)| Some((estimate - (*truth)?) / error)).collect();
        all_off.extend(off.iter().flatten());
        let rms = |off: &Vec<f64>| (off.iter().map(|z| z * z).sum::<f64>() / count).sqrt();
        derivatives.push(DebriefRow {
            name: own.name.clone(),
            promised,
            promised_noise: own.corrected.unwrap_or(promised),
            estimate: rows.iter().map(|row| row.0).sum::<f64>() / count,
            obtained,
            over_promised: obtained / promised,
            truth: rows.first().and_then(|row| row.2),
            inside: off.as_ref().map(|off| off.iter().filter(|z| z.abs() <= NORMAL_95).count()),
            off: off.as_ref().map(rms),
        });
    }
    let mut ratios: Vec<f64> = derivatives.iter().map(|row| row.over_promised).collect();
    let number = all_off.len() as f64;
    let known = !all_off.is_empty();
    Ok(Debrief {
        kind: promise.kind.clone(),
        time_s: promise.time_s,
        flights: flights.len(),
        median_over_promised: doublet_core::statistics::median(&mut ratios).ok_or("the design promised no error")?,
        inside_percent: known
            .then(|| 100.0 * all_off.iter().filter(|z: &&f64| z.abs() <= NORMAL_95).count() as f64 / number),
        rms_off: known.then(|| (all_off.iter().map(|z: &f64| z * z).sum::<f64>() / number).sqrt()),
        derivatives,
    })
}

/// Lays a debrief out as a page: what was promised, obtained and is true.
pub fn debrief_document(title: &str, found: &Debrief) -> Document {
    let fact = |name: &str, text: String| (name.to_owned(), text);
    let mut facts = vec![
        fact("Input", format!("{}, {} s of manoeuvres", found.kind, significant(found.time_s, 4))),
        fact("Flights", found.flights.to_string()),
        fact("Obtained over promised error", format!("{} (median)", significant(found.median_over_promised, 3))),
    ];
    facts.extend(
        found
            .inside_percent
            .map(|percent| fact("Truth inside the 95 % intervals", format!("{} %", significant(percent, 3)))),
    );
    facts.extend(found.rms_off.map(|off| fact("Rms error", format!("{} standard errors", significant(off, 3)))));
    Document {
        title: "Debrief: promised, obtained, true".to_owned(),
        subtitle: title.to_owned(),
        app: crate::PROGRAM.to_owned(),
        date: date::today(),
        cover: vec![Block::Facts(facts)],
        sections: vec![Section::plain("derivatives", "Derivatives", false, vec![Block::Table(debrief_table(found))])],
        ..Document::default()
    }
}

/// Derivatives: promised against obtained errors, and the truth where it is known.
pub fn debrief_table(found: &Debrief) -> Table {
    let caption = "Corrected standard errors, root mean square over the flights; estimates are means. Truth is known of simulated flights only.";
    TableOf::new("debrief", caption, &found.derivatives)
        .symbol("name", "Derivative", |row| &row.name)
        .number("promised", "Promised error", "", 2, |row| row.promised)
        .number("obtained", "Obtained error", "", 2, |row| row.obtained)
        .number("over_promised", "Obtained over promised", "", 3, |row| row.over_promised)
        .number("estimate", "Estimate", "", 4, |row| row.estimate)
        .maybe("truth", "Truth", "", 4, |row| row.truth)
        .maybe("off", "Rms error in std errors", "", 3, |row| row.off)
        .column(Column::new("inside", "Truth inside 95 %"), |row| match row.inside {
            Some(inside) => Cell::text(format!("{inside} of {}", found.flights)),
            None => Cell::Empty,
        })
        .done()
}
