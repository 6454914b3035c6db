//! The form of tolerance files.

use std::collections::BTreeMap;

use doublet_core::quantity::{Dimension, Unit};
use doublet_core::toml_error;
use doublet_core::validate::{Signal, Tolerance, ToleranceTest};
use serde::Deserialize;

use super::{
    Certainty, Judgement, ObjectiveTest, OutsideTest, PercentRule, Quantity, Reading, RecordDemand, Tolerances,
    ValueTolerance,
};
use crate::builtin;
use crate::graph::{StageError, StageResult};
use crate::session::Surface;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    name: String,
    #[serde(default)]
    edition: String,
    #[serde(default)]
    source: String,
    based_on: Option<String>,
    certainty: Option<String>,
    #[serde(default)]
    certainty_note: String,
    #[serde(default)]
    paragraphs: BTreeMap<String, String>,
    #[serde(default)]
    test: Vec<TestTable>,
    #[serde(default)]
    outside: Vec<OutsideTest>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TestTable {
    id: String,
    name: String,
    kind: Option<String>,
    surface: Option<String>,
    #[serde(default)]
    kinds: Vec<String>,
    #[serde(default)]
    condition: String,
    #[serde(default)]
    objective: String,
    #[serde(default)]
    procedure: String,
    paragraph: Option<String>,
    certainty: Option<String>,
    #[serde(default)]
    page: String,
    #[serde(default)]
    missing: String,
    #[serde(default)]
    before_s: f64,
    #[serde(default)]
    after_s: f64,
    #[serde(default)]
    least_s: f64,
    #[serde(default)]
    cycles: f64,
    read: Option<String>,
    lag: Option<[String; 2]>,
    at_s: Option<f64>,
    #[serde(default)]
    trend: bool,
    require: Vec<RequireTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequireTable {
    any: Vec<ToleranceTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToleranceTable {
    signal: String,
    #[serde(default)]
    absolute: f64,
    unit: Option<String>,
    #[serde(default)]
    percent: f64,
    #[serde(default)]
    percent_of_peak: f64,
}

/// Reads the text of a file.
pub fn parse(text: &str, reading: &Reading) -> StageResult<Tolerances> {
    let file: FileTable = toml::from_str(text).map_err(|error| toml_error::one_line(text, &error))?;
    let certainty = file.certainty.as_deref().map(certainty).transpose()?;
    let mut tolerances = match &file.based_on {
        Some(name) => based_on(name, reading)?,
        None => Tolerances::default(),
    };
    // What another edition has is not read in this one.
    for test in &mut tolerances.tests {
        test.certainty = certainty.unwrap_or(test.certainty);
        if certainty.is_some_and(|certainty| certainty != Certainty::Read) {
            test.page.clear();
        }
    }
    for table in file.test {
        let id = table.id.clone();
        let test = objective_test(table, reading, certainty).map_err(|what| what.at(format!("test '{id}'")))?;
        match tolerances.tests.iter_mut().find(|known| known.id == id) {
            Some(known) => *known = test,
            None => tolerances.tests.push(test),
        }
    }
    for (id, paragraph) in file.paragraphs {
        let known = tolerances.tests.iter_mut().find(|test| test.id == id);
        known.ok_or_else(|| format!("paragraphs: '{id}' is not a test of the file"))?.paragraph = paragraph;
    }
    if tolerances.tests.is_empty() {
        return Err("it has no test: add one".into());
    }
    if !file.outside.is_empty() {
        tolerances.outside = file.outside;
    }
    Ok(Tolerances {
        name: file.name,
        edition: file.edition,
        source: file.source,
        certainty_note: file.certainty_note,
        ..tolerances
    })
}

/// The shipped rule that a file changes.
fn based_on(name: &str, reading: &Reading) -> StageResult<Tolerances> {
    let text = builtin::text("tolerances", name);
    let text = text.ok_or_else(|| format!("based_on: shipped tolerances '{name}' not found"))?;
    if toml::from_str::<FileTable>(text).is_ok_and(|base| base.based_on.is_some()) {
        return Err(format!("based_on: '{name}' is itself based on another file").into());
    }
    parse(text, reading)
}

fn certainty(name: &str) -> StageResult<Certainty> {
    let found = Certainty::from_name(name);
    Ok(found.ok_or_else(|| format!("certainty '{name}' must be read, second-hand or unverified"))?)
}

fn objective_test(table: TestTable, reading: &Reading, of_rule: Option<Certainty>) -> StageResult<ObjectiveTest> {
    let surface = |name: &String| -> StageResult<Surface> {
        let found = Surface::from_name(name);
        Ok(found.ok_or_else(|| format!("surface '{name}' must be elevator, aileron or rudder"))?)
    };
    if table.surface.is_none() && table.kinds.is_empty() {
        return Err("surface and kinds are missing: state one of them".into());
    }
    if table.require.is_empty() || table.require.iter().any(|require| require.any.is_empty()) {
        return Err("a requirement has no tolerance".into());
    }
    let record =
        RecordDemand { before_s: table.before_s, after_s: table.after_s, least_s: table.least_s, cycles: table.cycles };
    let demands = [record.before_s, record.after_s, record.least_s, record.cycles];
    if demands.iter().any(|demand| !(*demand >= 0.0 && demand.is_finite())) {
        return Err("before_s, after_s, least_s and cycles must not be negative".into());
    }
    Ok(ObjectiveTest {
        surface: table.surface.as_ref().map(surface).transpose()?,
        kinds: table.kinds.iter().map(|kind| kind.to_lowercase()).collect(),
        read: table.read.as_deref().map(signal).transpose()?,
        judgement: judgement(&table, reading)?,
        record,
        certainty: match &table.certainty {
            Some(name) => certainty(name)?,
            None => of_rule.unwrap_or_default(),
        },
        paragraph: table.paragraph.unwrap_or_else(|| table.id.clone()),
        id: table.id,
        name: table.name,
        condition: table.condition,
        objective: table.objective,
        procedure: table.procedure,
        page: table.page,
        missing: table.missing,
    })
}

fn judgement(table: &TestTable, reading: &Reading) -> StageResult<Judgement> {
    let bands = || -> StageResult<ToleranceTest> {
        let requirement = |require: &RequireTable| require.any.iter().map(|entry| band(entry, reading)).collect();
        let requirements = table.require.iter().map(requirement).collect::<StageResult<_>>()?;
        Ok(ToleranceTest { id: table.id.clone(), name: table.name.clone(), requirements })
    };
    let values = || -> StageResult<Vec<Vec<ValueTolerance>>> {
        let requirement = |require: &RequireTable| require.any.iter().map(value).collect();
        table.require.iter().map(requirement).collect()
    };
    let kind = table.kind.as_deref().unwrap_or("time history");
    if kind != "value" && (table.at_s.is_some() || table.trend) {
        return Err("at_s and trend belong to kind = \"value\"".into());
    }
    if kind != "period and damping" && table.lag.is_some() {
        return Err("lag belongs to kind = \"period and damping\"".into());
    }
    match kind {
        "time history" => Ok(Judgement::History(bands()?)),
        "snapshot" => Ok(Judgement::Snapshot(values()?)),
        "trim change" => Ok(Judgement::TrimChange(values()?)),
        "value" => {
            let at_s = table.at_s.filter(|at_s| *at_s > 0.0 && at_s.is_finite());
            let at_s = at_s.ok_or("a test of a value needs at_s, the time after the controls came to rest")?;
            Ok(Judgement::Value { at_s, trend: table.trend, requirements: values()?, bands: bands()? })
        }
        "period and damping" => {
            if table.read.is_none() {
                return Err("a test of period and damping needs read, the signal they are read from".into());
            }
            let lag = |[first, second]: &[String; 2]| -> StageResult<_> { Ok([signal(first)?, signal(second)?]) };
            Ok(Judgement::FreeResponse { lag: table.lag.as_ref().map(lag).transpose()?, requirements: values()? })
        }
        other => {
            let kinds = "time history, snapshot, trim change, value, period and damping";
            Err(format!("'{other}' is not a kind of test: one of {kinds}").into())
        }
    }
}

fn signal(name: &str) -> StageResult<Signal> {
    let names = || Signal::ALL.map(Signal::name).join(", ");
    Ok(Signal::from_name(name).ok_or_else(|| format!("'{name}' is not a signal: one of {}", names()))?)
}

fn band(table: &ToleranceTable, reading: &Reading) -> StageResult<Tolerance> {
    let signal = signal(&table.signal)?;
    let mut absolute = absolute(table, signal.dimension())?;
    let (percent, mut of_peak) = (table.percent / 100.0, table.percent_of_peak / 100.0);
    check(table, &[absolute, percent, of_peak])?;
    let mut of_value = 0.0;
    match (reading.percent, reading.normal_range.get(&signal)) {
        (PercentRule::Sample, _) => of_value = percent,
        (PercentRule::NormalRange, Some(range)) => absolute = absolute.max(percent * range.abs()),
        (PercentRule::NormalRange, None) => of_peak = of_peak.max(percent),
    }
    Ok(Tolerance { signal, absolute, of_value, of_peak })
}

fn value(table: &ToleranceTable) -> StageResult<ValueTolerance> {
    let names = || Quantity::all().map(Quantity::name).collect::<Vec<_>>().join(", ");
    let quantity = Quantity::from_name(&table.signal)
        .ok_or_else(|| format!("'{}' is not a quantity: one of {}", table.signal, names()))?;
    let (absolute, of_value) = (absolute(table, quantity.dimension())?, table.percent / 100.0);
    if table.percent_of_peak != 0.0 {
        return Err(format!("{} is one number: give percent, not percent_of_peak", table.signal).into());
    }
    check(table, &[absolute, of_value])?;
    Ok(ValueTolerance { quantity, absolute, of_value })
}

/// The fixed part in SI.
fn absolute(table: &ToleranceTable, dimension: Dimension) -> StageResult<f64> {
    match &table.unit {
        Some(unit) => {
            let unit = Unit::parse(unit)?;
            if unit.dimension != dimension {
                return Err(format!("'{}' is not a unit of {}", unit.symbol, table.signal).into());
            }
            Ok(unit.to_si(table.absolute))
        }
        None if table.absolute == 0.0 || dimension == Dimension::Dimensionless => Ok(table.absolute),
        None => Err(StageError::from(format!("the absolute tolerance of {} has no unit", table.signal))),
    }
}

fn check(table: &ToleranceTable, parts: &[f64]) -> StageResult<()> {
    if parts.iter().any(|part| !(*part >= 0.0 && part.is_finite())) || parts.iter().all(|part| *part == 0.0) {
        return Err(format!("the tolerance of {} must be positive", table.signal).into());
    }
    Ok(())
}
