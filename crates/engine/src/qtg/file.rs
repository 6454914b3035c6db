//! Test files: which windows of a session serve which objective tests, and what the guide says of sponsor, device and revisions.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::load::read_text;
use doublet_core::quantity::Unit;
use doublet_core::validate::Signal;
use serde::Deserialize;

use crate::graph::StageResult;
use crate::stage::{Judgement, PercentRule, Reading, Tolerances};
use crate::{builtin, toml_file};

/// Value of the `format` key.
const FORMAT: &str = "doublet qualification tests";
/// Version of the form.
const VERSION: u32 = 1;

/// What the device page asks for: key in the file and words on the page.
pub const DEVICE: [(&str, &str); 12] = [
    ("sponsor", "Sponsor"),
    ("aeroplane", "Aeroplane model and series"),
    ("aerodynamic_data", "Source of the basic aerodynamic model"),
    ("engine_data", "Engine model and data revision"),
    ("flight_control_data", "Flight control data revision"),
    ("flight_management", "Flight management system and revision"),
    ("device", "Device model and manufacturer"),
    ("manufactured", "Date of manufacture"),
    ("computer", "Computer"),
    ("visual_system", "Visual system"),
    ("motion_system", "Motion system"),
    ("configuration", "Configuration of the aeroplane"),
];

/// What is moved in flight, as keys of its greatest airspeed.
pub const EQUIPMENT: [&str; 3] = ["flaps_m_s", "gear_m_s", "spoilers_m_s"];

#[derive(Clone, Debug, PartialEq)]
pub struct TestFile {
    /// Title of the guide.
    pub title: String,
    pub rule: Tolerances,
    /// What percentages of its bands are of.
    pub reading: Reading,
    /// Whether the reference comes from an engineering simulation, so that 40 % of every tolerance applies.
    pub is_engineering_data: bool,
    /// Constants and start of the flown model.
    pub constants: Constants,
    /// Calibrated airspeed up to which flaps, gear and spoilers may be moved, m/s, by the keys `flaps_m_s`, `gear_m_s` and `spoilers_m_s`;
    /// zero of what the aeroplane does not have.
    pub equipment: BTreeMap<String, f64>,
    /// Device page by the keys of [`DEVICE`].
    pub device: BTreeMap<String, String>,
    /// Log of revisions.
    pub revisions: Vec<Revision>,
    /// Documents referred to.
    pub references: Vec<String>,
    /// Tests in their order.
    pub tests: Vec<TestEntry>,
}

/// Constants of the coefficients, and where the flown model starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Constants {
    /// Those of the identification, from the trim of the model.
    #[default]
    Identification,
    /// Refitted to each manoeuvre, from the reconstructed state in the reconstructed wind.
    Refit,
}

impl Constants {
    doublet_core::named_variants! {
        /// Name on the command line and in files.
        pub name: Identification "identification", Refit "refit"
    }
}

/// One line of the log of revisions.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Revision {
    pub number: String,
    /// Day.
    #[serde(default)]
    pub date: String,
    #[serde(default)]
    pub pages: String,
    /// What changed.
    #[serde(default)]
    pub change: String,
}

/// One test of the guide.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestEntry {
    /// Number in the rule.
    pub id: String,
    /// Windows that serve it, a page each; none for every validation window the rule's test applies to.
    #[serde(default)]
    pub windows: Vec<String>,
    /// Word the kind of input of such a window must have.
    pub kind: Option<String>,
    /// Title; that of the rule where there is none.
    pub title: Option<String>,
    /// Objective; that of the rule where there is none.
    pub objective: Option<String>,
    /// Manual procedure; that of the rule where there is none.
    pub procedure: Option<String>,
    /// Flight condition of its records in the words of the rule: cruise, approach.
    pub condition: Option<String>,
    /// Configuration of the aeroplane; that of the device page where there is none.
    pub configuration: Option<String>,
    /// Why the test is judged though the record is shorter than the rule asks for.
    pub deviation: Option<String>,
    /// What else there is to say.
    pub note: Option<String>,
    /// Steady flight a snapshot is taken from, s after the start of the window.
    pub from_s: Option<f64>,
    /// Its end.
    pub to_s: Option<f64>,
    /// Window of the trim from which a trim change is counted.
    pub trim: Option<String>,
    /// Derivatives of the model that are changed for this test, with their factors.
    #[serde(default)]
    pub scale: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    format: String,
    version: u32,
    title: String,
    rule: Option<String>,
    percent: Option<String>,
    constants: Option<String>,
    #[serde(default)]
    engineering_data: bool,
    #[serde(default)]
    normal_range: BTreeMap<String, RangeTable>,
    #[serde(default)]
    equipment: BTreeMap<String, f64>,
    #[serde(default)]
    device: BTreeMap<String, String>,
    #[serde(default)]
    revision: Vec<Revision>,
    #[serde(default)]
    references: Vec<String>,
    #[serde(default)]
    test: Vec<TestEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeTable {
    value: f64,
    unit: String,
}

/// Part of every tolerance that applies where the reference is an engineering simulation.
pub const ENGINEERING_DATA: f64 = 0.4;

impl TestFile {
    /// Reads a file, or one that comes with the program: `builtin:qtg/demo`.
    pub fn open(path: &Path) -> Result<Self, String> {
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = match path.to_str().and_then(|name| name.strip_prefix(builtin::PREFIX)) {
            Some(name) => {
                let text = builtin::text("qtg", name).or_else(|| builtin::text("qtg", &format!("{name}.toml")));
                text.ok_or_else(|| named(&"no tests of this name come with the program"))?.to_owned()
            }
            None => read_text(path).map_err(|error| named(&error))?,
        };
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::parse(&text, &folder).map_err(|error| named(&error))
    }

    /// Reads the text of a file; the path of its rule starts from `folder`.
    pub fn parse(text: &str, folder: &Path) -> StageResult<Self> {
        let file = toml_file::parse(text, (FORMAT, VERSION), |file: &FileTable| (&file.format, file.version))?;
        let reading = Reading { percent: percent(file.percent.as_deref())?, normal_range: ranges(&file.normal_range)? };
        let rule = rule(file.rule.as_deref(), &reading, folder)?;
        let rule = if file.engineering_data { rule.scaled(ENGINEERING_DATA) } else { rule };
        for key in file.device.keys() {
            if !DEVICE.iter().any(|(known, _)| known == key) {
                let known = DEVICE.map(|(known, _)| known).join(", ");
                return Err(format!("device: '{key}' is not one of {known}").into());
            }
        }
        for (key, value) in &file.equipment {
            if !EQUIPMENT.contains(&key.as_str()) {
                return Err(format!("equipment: '{key}' is not one of {}", EQUIPMENT.join(", ")).into());
            }
            if !(0.0..=1000.0).contains(value) {
                return Err(format!("equipment.{key} is {value}, allowed is 0 to 1000 m/s").into());
            }
        }
        if file.test.is_empty() {
            return Err("it has no test: add one".into());
        }
        for (index, entry) in file.test.iter().enumerate() {
            check(entry, &rule).map_err(|error| error.at(format!("test {} ('{}')", index + 1, entry.id)))?;
        }
        Ok(Self {
            title: file.title,
            rule,
            reading,
            is_engineering_data: file.engineering_data,
            constants: constants(file.constants.as_deref())?,
            equipment: file.equipment,
            device: file.device,
            revisions: file.revision,
            references: file.references,
            tests: file.test,
        })
    }
}

fn percent(name: Option<&str>) -> StageResult<PercentRule> {
    let Some(name) = name else { return Ok(PercentRule::default()) };
    let found = PercentRule::from_name(name);
    Ok(found.ok_or_else(|| format!("percent: '{name}' is neither range nor sample"))?)
}

fn constants(name: Option<&str>) -> StageResult<Constants> {
    let Some(name) = name else { return Ok(Constants::default()) };
    Ok(Constants::from_name(name).ok_or_else(|| format!("constants: '{name}' is neither identification nor refit"))?)
}

fn ranges(tables: &BTreeMap<String, RangeTable>) -> StageResult<BTreeMap<Signal, f64>> {
    let range = |(name, table): (&String, &RangeTable)| {
        parse_range(name, table).map_err(|error| error.at(format!("normal_range.{name}")))
    };
    tables.iter().map(range).collect()
}

fn parse_range(name: &str, table: &RangeTable) -> StageResult<(Signal, f64)> {
    let names = || Signal::ALL.map(Signal::name).join(", ");
    let signal = Signal::from_name(name).ok_or_else(|| format!("it is not a signal: one of {}", names()))?;
    let unit = Unit::parse(&table.unit)?;
    if unit.dimension != signal.dimension() {
        return Err(format!("'{}' is not a unit of it", unit.symbol).into());
    }
    let largest = unit.to_si(table.value);
    if !(largest > 0.0 && largest.is_finite()) {
        return Err("the largest value must be positive".into());
    }
    Ok((signal, largest))
}

fn rule(name: Option<&str>, reading: &Reading, folder: &Path) -> StageResult<Tolerances> {
    let Some(name) = name else { return Tolerances::builtin_by(reading) };
    let wrong = |error: &dyn std::fmt::Display| format!("rule: {name}: {error}");
    let text = match name.strip_prefix(builtin::PREFIX) {
        Some(name) => builtin::text("tolerances", name)
            .ok_or_else(|| wrong(&format!("not shipped; there are {}", builtin::names("tolerances").join(", "))))?
            .to_owned(),
        None => read_text(&folder.join(name)).map_err(|error| wrong(&error))?,
    };
    Ok(Tolerances::parse_by(&text, reading).map_err(|error| wrong(&error))?)
}

fn check(entry: &TestEntry, rule: &Tolerances) -> StageResult<()> {
    let Some(test) = rule.test(&entry.id) else {
        let known = rule.tests.iter().map(|test| test.id.as_str()).collect::<Vec<_>>().join(", ");
        return Err(format!("id: {} has no such test: one of {known}", rule.name).into());
    };
    let is_change = matches!(test.judgement, Judgement::TrimChange(_));
    if is_change != entry.trim.is_some() {
        let line = if is_change {
            "trim is missing: name the manoeuvre from whose trim the changes are counted"
        } else {
            "trim belongs to a test of kind \"trim change\""
        };
        return Err(line.into());
    }
    let (from_s, to_s) = (entry.from_s.unwrap_or(0.0), entry.to_s.unwrap_or(f64::MAX));
    if !(from_s >= 0.0 && to_s > from_s) {
        return Err("from_s and to_s: give two times from the start of the window, the second later".into());
    }
    match entry.scale.iter().find(|(_, factor)| !factor.is_finite()) {
        Some((name, _)) => Err(format!("scale.{name} is not a number").into()),
        None => Ok(()),
    }
}
