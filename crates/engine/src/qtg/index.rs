//! Every test of the rule with what the guide has of it.

use serde::Serialize;

use super::QualificationTest;
use crate::stage::{Certainty, ObjectiveTest, Tolerances};

/// What a guide has of a test of the rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IndexStatus {
    /// Every record that the rule asks for is there and passes in full.
    Passed,
    /// Records pass, and something the rule asks for is not there.
    Partly,
    /// A record fails.
    Failed,
    /// There is a record, none of it could be judged.
    NotJudged,
    /// There is no record: a card is written.
    Missing,
    /// There is no record, and no card can be written.
    Withheld,
    /// Outside the model, or the aeroplane lacks what is tested.
    Outside,
}

impl IndexStatus {
    doublet_core::variant_texts! {
        /// What the index says.
        pub label:
            Passed "pass", Partly "partly passed", Failed "FAIL", NotJudged "not judged",
            Missing "missing: card written", Withheld "missing: no card", Outside "outside the model",
    }

    /// Whether a record is still to be flown.
    pub fn needs_card(self) -> bool {
        matches!(self, Self::Partly | Self::NotJudged | Self::Missing)
    }
}

/// One test of the rule.
#[derive(Clone, Debug, Serialize)]
pub struct IndexRow {
    /// Number in the rule.
    pub id: String,
    /// Paragraph as the rule prints it.
    pub paragraph: String,
    pub name: String,
    /// Flight condition the rule asks for.
    pub condition: String,
    /// How sure its tolerance is; none of a test outside the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certainty: Option<&'static str>,
    /// What the guide has of it.
    pub status: IndexStatus,
    /// Tests of the guide that serve it.
    pub tests: Vec<String>,
    /// Why it does not pass in full; empty where it does.
    pub reason: String,
    /// Flight conditions of the rule that no record that passes states; empty where none passes or states one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions_open: Vec<String>,
}

/// How sure the tolerance of a test is, as a name and in words: what was read without a part of the entry is read in part.
pub(super) fn certainty(rule: &ObjectiveTest) -> (&'static str, &'static str) {
    match rule.certainty {
        Certainty::Read if !rule.missing.is_empty() => ("read in part", "read in the rule in part"),
        certainty => (certainty.name(), certainty.words()),
    }
}

/// The index of a rule, in the order of its numbers.
pub(super) fn index(rule: &Tolerances, tests: &[QualificationTest]) -> Vec<IndexRow> {
    let of_rule = rule.tests.iter().map(|test| {
        let own: Vec<&QualificationTest> = tests.iter().filter(|own| own.rule_id == test.id).collect();
        let (status, reason) = status(test, &own);
        let passed = own.iter().filter(|own| own.passed == Some(true) && !own.model_changed).copied();
        IndexRow {
            id: test.id.clone(),
            paragraph: test.paragraph.clone(),
            name: test.name.clone(),
            condition: test.condition.clone(),
            certainty: Some(certainty(test).0),
            status,
            tests: own.iter().map(|own| own.id.clone()).collect(),
            reason,
            conditions_open: conditions_open(test, passed),
        }
    });
    let outside = rule.outside.iter().map(|test| IndexRow {
        id: test.id.clone(),
        paragraph: test.id.clone(),
        name: test.name.clone(),
        condition: String::new(),
        certainty: None,
        status: IndexStatus::Outside,
        tests: Vec::new(),
        reason: test.reason.clone(),
        conditions_open: Vec::new(),
    });
    let mut rows: Vec<IndexRow> = of_rule.chain(outside).collect();
    rows.sort_by_key(|row| place(&row.id));
    rows
}

/// What the guide has of a test, and why not all of it. A test with a model that was changed on purpose shows that a wrong model fails: it does
/// not count.
fn status(rule: &ObjectiveTest, own: &[&QualificationTest]) -> (IndexStatus, String) {
    let counted: Vec<&QualificationTest> = own.iter().filter(|test| !test.model_changed).copied().collect();
    let is_flown = counted.iter().any(|test| test.window.is_some());
    let of = |passed: Option<bool>| counted.iter().filter(move |test| test.passed == passed);
    let failed: Vec<&str> = of(Some(false)).map(|test| test.id.as_str()).collect();
    if !failed.is_empty() {
        return (IndexStatus::Failed, format!("{} outside the tolerance", failed.join(", ")));
    }
    if of(Some(true)).next().is_none() {
        let reasons: Vec<&str> = counted.iter().map(|test| test.reason.as_str()).collect();
        return match is_flown {
            true => (IndexStatus::NotJudged, reasons.join("; ")),
            false => (IndexStatus::Missing, "no manoeuvre of the session serves it".to_owned()),
        };
    }
    let mut reasons: Vec<String> = Vec::new();
    reasons.extend(of(None).map(|test| format!("{} {}", test.id, test.outcome.label().to_lowercase())));
    reasons.extend(not_judged(of(Some(true)).copied()));
    reasons.extend(of(Some(true)).filter_map(|test| Some(format!("{}: {}", test.id, test.departure.as_ref()?))));
    reasons.extend(conditions_not_flown(rule, of(Some(true)).copied()));
    let missed = own.iter().filter(|test| test.model_changed && test.passed == Some(true));
    reasons.extend(missed.map(|test| format!("{} has to fail and passes", test.id)));
    reasons.extend((!rule.missing.is_empty()).then(|| format!("not read in the rule: {}", rule.missing)));
    let status = if reasons.is_empty() { IndexStatus::Passed } else { IndexStatus::Partly };
    (status, reasons.join("; "))
}

/// Requirements of which no number could be judged, by their parameters.
fn not_judged<'t>(tests: impl Iterator<Item = &'t QualificationTest>) -> Option<String> {
    let mut names: Vec<&str> = Vec::new();
    for test in tests {
        let requirements = test.values.iter().map(|row| row.requirement).max().unwrap_or(0);
        for requirement in 1..=requirements {
            let mut rows = test.values.iter().filter(|row| row.requirement == requirement).peekable();
            let first = rows.peek().map(|row| row.parameter.as_str());
            if rows.all(|row| row.passed.is_none()) {
                names.extend(first.filter(|name| !names.contains(name)));
            }
        }
    }
    (!names.is_empty()).then(|| format!("{} not judged: no data", names.join(", ")))
}

/// Flight conditions of the rule that no judged record states, or that none is stated.
fn conditions_not_flown<'t>(
    rule: &ObjectiveTest,
    tests: impl Iterator<Item = &'t QualificationTest> + Clone,
) -> Option<String> {
    if !rule.condition.is_empty() && tests.clone().all(|test| test.condition.is_none()) {
        return Some("flight condition of the records not stated".to_owned());
    }
    let open = conditions_open(rule, tests);
    (!open.is_empty()).then(|| format!("not flown: {}", open.join(", ")))
}

/// Flight conditions of the rule that no judged record states; empty where no record states any.
fn conditions_open<'t>(rule: &ObjectiveTest, tests: impl Iterator<Item = &'t QualificationTest>) -> Vec<String> {
    let stated: Vec<&str> = tests.filter_map(|test| test.condition.as_deref()).collect();
    if stated.is_empty() {
        return Vec::new();
    }
    let asked = rule.condition.split([',', ';']).map(|part| part.trim().trim_start_matches("and "));
    let asked = asked.filter(|part| !part.is_empty() && !part.starts_with("whichever"));
    let is_flown = |part: &&str| part.split(" or ").any(|one| stated.iter().any(|stated| stated.contains(one.trim())));
    asked.filter(|part| !is_flown(part)).map(str::to_owned).collect()
}

/// Parts of the first number of an id, to sort by: `2.c.10` behind `2.c.9`.
fn place(id: &str) -> Vec<(u32, String)> {
    let first = id.split([',', ' ']).next().unwrap_or_default();
    let part = |part: &str| part.parse::<u32>().map_or_else(|_| (0, part.to_owned()), |number| (number, String::new()));
    first.split('.').map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Outcome, Page, ValueRow};
    use super::*;

    fn test(id: &str, rule_id: &str, outcome: Outcome, condition: &str) -> QualificationTest {
        QualificationTest {
            id: id.to_owned(),
            rule_id: rule_id.to_owned(),
            title: String::new(),
            certainty: "read",
            kind: "snapshot",
            condition: (!condition.is_empty()).then(|| condition.to_owned()),
            model_changed: false,
            departure: None,
            window: Some("w".to_owned()),
            passed: outcome.passed(),
            outcome,
            reason: "too short".to_owned(),
            channels: Vec::new(),
            values: Vec::new(),
            oscillation: Vec::new(),
            data: None,
            page: Page::default(),
        }
    }

    fn row(tests: &[QualificationTest], id: &str) -> (IndexStatus, String) {
        let rows = index(&Tolerances::builtin().unwrap(), tests);
        rows.into_iter().find(|row| row.id == id).map(|row| (row.status, row.reason)).unwrap()
    }

    #[test]
    fn every_number_of_the_rule_is_in_the_index_in_order() {
        let rule = Tolerances::builtin().unwrap();
        let rows = index(&rule, &[]);
        assert_eq!(rows.len(), rule.tests.len() + rule.outside.len());
        let order: Vec<&str> = rows.iter().map(|row| row.id.as_str()).collect();
        let at = |id: &str| order.iter().position(|own| *own == id).unwrap();
        assert!(
            at("1.a") == 0 && at("1.b.8") < at("1.c.1") && at("2.c.9") < at("2.c.10") && at("2.d.8") < at("3, 4, 5")
        );
        assert!(rows.iter().all(|row| [IndexStatus::Missing, IndexStatus::Outside].contains(&row.status)));
        assert!(rows.iter().all(|row| !row.reason.is_empty()));
    }

    #[test]
    fn a_test_made_to_fail_does_not_fail_the_rule_and_must_not_pass() {
        let mut tests = vec![
            test("2.d.2-1", "2.d.2", Outcome::Passed, "cruise"),
            test("2.d.2-2", "2.d.2", Outcome::Passed, "approach"),
            test("2.d.2-3", "2.d.2", Outcome::Failed, "cruise"),
        ];
        assert_eq!(row(&tests, "2.d.2"), (IndexStatus::Failed, "2.d.2-3 outside the tolerance".to_owned()));
        tests[2].model_changed = true;
        assert_eq!(row(&tests, "2.d.2"), (IndexStatus::Passed, String::new()));
        tests[2].passed = Some(true);
        assert_eq!(row(&tests, "2.d.2"), (IndexStatus::Partly, "2.d.2-3 has to fail and passes".to_owned()));
        // Cruise, and one of approach and landing.
        tests.remove(1);
        tests.pop();
        assert_eq!(row(&tests, "2.d.2"), (IndexStatus::Partly, "not flown: approach or landing".to_owned()));
        tests[0].condition = None;
        assert!(row(&tests, "2.d.2").1.contains("flight condition of the records not stated"));
    }

    fn value(requirement: usize, parameter: &str, passed: Option<bool>) -> ValueRow {
        ValueRow {
            requirement,
            parameter: parameter.to_owned(),
            tolerance: String::new(),
            unit: "rad",
            flight: None,
            flight_error: None,
            model: None,
            model_error: None,
            passed,
        }
    }

    #[test]
    fn what_a_pass_rests_on_is_stated() {
        let mut trim = test("2.c.5-1", "2.c.5", Outcome::Passed, "cruise");
        trim.values = vec![
            value(1, "elevator", Some(true)),
            value(2, "trim surface", None),
            value(3, "period", None),
            value(3, "damping ratio", Some(true)),
        ];
        let second = test("2.c.5-2", "2.c.5", Outcome::NotComputed, "cruise");
        let (status, reason) = row(&[trim, second], "2.c.5");
        assert_eq!(status, IndexStatus::Partly);
        for part in
            ["2.c.5-2 not computed", "trim surface not judged: no data", "not flown: approach, landing", "page 61"]
        {
            assert!(reason.contains(part), "{part}: {reason}");
        }
        assert!(!reason.contains("damping") && !reason.contains("period not"), "{reason}");
        // A departure from the rule is part of the result.
        let mut dutch_roll = test("2.d.7", "2.d.7", Outcome::Passed, "cruise, approach");
        assert_eq!(row(std::slice::from_ref(&dutch_roll), "2.d.7").0, IndexStatus::Passed);
        dutch_roll.departure = Some("the record has 1.5 cycles of the free response (6 required)".to_owned());
        let (status, reason) = row(&[dutch_roll], "2.d.7");
        assert_eq!(status, IndexStatus::Partly);
        assert!(reason.contains("1.5 cycles"), "{reason}");
    }

    #[test]
    fn a_tolerance_of_which_a_part_was_not_read_is_not_read() {
        let rule = Tolerances::builtin().unwrap();
        let of = |id: &str| certainty(rule.test(id).unwrap()).0;
        // The reference has verified = "part" for the first two, true for the next three, false or another table for the last two.
        let found = ["1.b.8", "2.c.5", "1.c.2", "1.d.4", "1.d.5", "1.c.1", "2.c.6"].map(of);
        let second = "second-hand";
        assert_eq!(found, ["read in part", "read in part", "read", "read", "read", second, second]);
    }
}
