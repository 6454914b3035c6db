//! Tolerance files: which test applies to which window, and how far a simulation may be off.

use doublet_core::quantity::Unit;
use doublet_core::validate::{Signal, Tolerance, ToleranceTest};
use serde::Deserialize;

use crate::builtin;
use crate::graph::{StageError, StageResult};
use crate::session::{Manoeuvre, Surface};

/// The tolerances that come with the program.
const BUILTIN: &str = "part60";

/// A tolerance file.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerances {
    /// Name of the rule.
    pub name: String,
    tests: Vec<Applicable>,
}

/// A test and the windows it is for.
#[derive(Clone, Debug, PartialEq)]
struct Applicable {
    surface: Option<Surface>,
    kinds: Vec<String>,
    test: ToleranceTest,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    name: String,
    test: Vec<TestTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TestTable {
    id: String,
    name: String,
    surface: Option<String>,
    #[serde(default)]
    kinds: Vec<String>,
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

impl Tolerances {
    /// Those that come with the program.
    ///
    /// # Errors
    /// One line; never for a program as built.
    pub fn builtin() -> StageResult<Self> {
        let text =
            builtin::text("tolerances", BUILTIN).ok_or_else(|| format!("no tolerances are called '{BUILTIN}'"))?;
        Self::parse(text)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// One line that names the test and what is wrong with it.
    pub fn parse(text: &str) -> StageResult<Self> {
        let file: FileTable = toml::from_str(text).map_err(|error| error.to_string().replace('\n', " "))?;
        let tests = file.test.into_iter().map(applicable).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { name: file.name, tests })
    }

    /// Tests that apply to a window.
    pub fn tests(&self, window: &Manoeuvre) -> Vec<&ToleranceTest> {
        let kind = window.kind.to_lowercase();
        let applies = |entry: &&Applicable| {
            (entry.surface.is_some() && entry.surface == window.surface)
                || entry.kinds.iter().any(|word| kind.contains(word.as_str()))
        };
        self.tests.iter().filter(applies).map(|entry| &entry.test).collect()
    }
}

fn applicable(table: TestTable) -> StageResult<Applicable> {
    let id = table.id.clone();
    let wrong = |what: StageError| what.at(format!("test '{id}'"));
    let surface = |name: &String| {
        let found = Surface::ALL.into_iter().find(|surface| surface.name() == name);
        found.ok_or_else(|| wrong(format!("'{name}' is not a surface: elevator, aileron or rudder").into()))
    };
    if table.surface.is_none() && table.kinds.is_empty() {
        return Err(wrong("it applies to nothing: give a surface or kinds".into()));
    }
    if table.require.is_empty() || table.require.iter().any(|require| require.any.is_empty()) {
        return Err(wrong("a requirement has no tolerance".into()));
    }
    let requirement = |require: &RequireTable| require.any.iter().map(|t| tolerance(t).map_err(&wrong)).collect();
    Ok(Applicable {
        surface: table.surface.as_ref().map(surface).transpose()?,
        kinds: table.kinds.iter().map(|kind| kind.to_lowercase()).collect(),
        test: ToleranceTest {
            requirements: table.require.iter().map(requirement).collect::<Result<_, _>>()?,
            id: table.id,
            name: table.name,
        },
    })
}

fn tolerance(table: &ToleranceTable) -> StageResult<Tolerance> {
    let names = || Signal::ALL.map(Signal::name).join(", ");
    let signal = Signal::from_name(&table.signal)
        .ok_or_else(|| format!("'{}' is not a signal: one of {}", table.signal, names()))?;
    let absolute = match &table.unit {
        Some(unit) => {
            let unit = Unit::parse(unit)?;
            if unit.dimension != signal.dimension() {
                return Err(format!("'{}' is not a unit of {}", unit.symbol, table.signal).into());
            }
            unit.to_si(table.absolute)
        }
        None if table.absolute == 0.0 => 0.0,
        None => return Err(format!("the absolute tolerance of {} has no unit", table.signal).into()),
    };
    let parts = [absolute, table.percent / 100.0, table.percent_of_peak / 100.0];
    if parts.iter().any(|part| !(*part >= 0.0 && part.is_finite())) || parts.iter().all(|part| *part == 0.0) {
        return Err(format!("the tolerance of {} must be positive", table.signal).into());
    }
    let [absolute, of_value, of_peak] = parts;
    Ok(Tolerance { signal, absolute, of_value, of_peak })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_tolerances_are_those_of_the_rule() {
        let tolerances = Tolerances::builtin().unwrap();
        let short_period = tolerances.tests.iter().find(|entry| entry.test.id == "2.c.10").unwrap();
        assert_eq!(short_period.surface, Some(Surface::Elevator));
        let [pitch, acceleration] = short_period.test.requirements.as_slice() else { panic!("two requirements") };
        assert!((pitch[0].absolute - 1.5_f64.to_radians()).abs() < 1e-12);
        assert!((pitch[1].absolute - 2.0_f64.to_radians()).abs() < 1e-12);
        assert!((acceleration[0].absolute - 0.980_665).abs() < 1e-12);
        let roll = tolerances.tests.iter().find(|entry| entry.test.id == "2.d.2").unwrap();
        assert!((roll.test.requirements[0][0].of_value - 0.1).abs() < 1e-12);
    }

    #[test]
    fn file_rejects_what_no_test_can_use() {
        let file = |inside: &str| format!("name = \"x\"\n[[test]]\nid = \"1\"\nname = \"one\"\n{inside}\n");
        for (inside, part) in [
            ("surface = \"flap\"\nrequire = [{ any = [{ signal = \"p\", percent = 1.0 }] }]", "'flap'"),
            ("require = [{ any = [{ signal = \"p\", percent = 1.0 }] }]", "applies to nothing"),
            ("surface = \"rudder\"\nrequire = []", "no tolerance"),
            ("surface = \"rudder\"\nrequire = [{ any = [{ signal = \"n\", percent = 1.0 }] }]", "'n'"),
            ("surface = \"rudder\"\nrequire = [{ any = [{ signal = \"p\", absolute = 1.0 }] }]", "no unit"),
            ("surface = \"rudder\"\nrequire = [{ any = [{ signal = \"p\", absolute = 1.0, unit = \"kt\" }] }]", "kt"),
            ("surface = \"rudder\"\nrequire = [{ any = [{ signal = \"p\", percent = -1.0 }] }]", "positive"),
        ] {
            let message = Tolerances::parse(&file(inside)).unwrap_err().to_string();
            assert!(message.contains("'1'") && message.contains(part) && !message.contains('\n'), "{message}");
        }
    }
}
