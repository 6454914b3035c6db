//! Every test of the rule with what the guide has of it.

use serde::Serialize;

use super::QualificationTest;
use crate::stage::Tolerances;

/// What a guide has of a test of the rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IndexStatus {
    /// Every judged record passes.
    Passed,
    /// A record fails.
    Failed,
    /// There is a record, none of it could be judged.
    NotJudged,
    /// There is no record: a card is written.
    Missing,
    /// The model cannot be asked.
    Outside,
}

impl IndexStatus {
    /// What the index says.
    pub fn label(self) -> &'static str {
        match self {
            Self::Passed => "pass",
            Self::Failed => "FAIL",
            Self::NotJudged => "not judged",
            Self::Missing => "missing: card written",
            Self::Outside => "outside the model",
        }
    }
}

/// One test of the rule.
#[derive(Clone, Debug, Serialize)]
pub struct IndexRow {
    /// Number in the rule.
    pub id: String,
    /// Paragraph as the rule prints it.
    pub paragraph: String,
    /// Name.
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
    /// Why there is none; empty where there is one.
    pub reason: String,
}

/// The index of a rule, in the order of its numbers.
pub(super) fn index(rule: &Tolerances, tests: &[QualificationTest]) -> Vec<IndexRow> {
    let of_rule = rule.tests.iter().map(|test| {
        let own: Vec<&QualificationTest> = tests.iter().filter(|own| own.rule_id == test.id).collect();
        let has = |passed: Option<bool>| own.iter().any(|own| own.passed == passed);
        let flown = own.iter().any(|own| own.window.is_some());
        let status = match (has(Some(false)), has(Some(true)), flown) {
            (true, ..) => IndexStatus::Failed,
            (_, true, _) => IndexStatus::Passed,
            (_, _, true) => IndexStatus::NotJudged,
            _ => IndexStatus::Missing,
        };
        IndexRow {
            id: test.id.clone(),
            paragraph: test.paragraph.clone(),
            name: test.name.clone(),
            condition: test.condition.clone(),
            certainty: Some(test.certainty.name()),
            status,
            tests: own.iter().map(|own| own.id.clone()).collect(),
            reason: match status {
                IndexStatus::Missing => "no manoeuvre of the session serves it".to_owned(),
                IndexStatus::NotJudged => own.iter().map(|own| own.reason.as_str()).collect::<Vec<_>>().join("; "),
                _ => String::new(),
            },
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
    });
    let mut rows: Vec<IndexRow> = of_rule.chain(outside).collect();
    rows.sort_by_key(|row| place(&row.id));
    rows
}

/// Parts of the first number of an id, to sort by: `2.c.10` behind `2.c.9`.
fn place(id: &str) -> Vec<(u32, String)> {
    let first = id.split([',', ' ']).next().unwrap_or_default();
    let part = |part: &str| part.parse::<u32>().map_or_else(|_| (0, part.to_owned()), |number| (number, String::new()));
    first.split('.').map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
