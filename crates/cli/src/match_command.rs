//! `doublet match`: validation manoeuvres flown again by the identified model, against tolerances.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use doublet_core::load::read_text;
use doublet_engine::report::{ProofRow, proof_rows, proof_tables};
use doublet_engine::stage::{PercentRule, Reading, Tolerances};

use crate::run::computed;
use crate::text;

#[derive(Debug, Args)]
pub struct MatchArguments {
    /// Session file.
    pub session: PathBuf,
    /// Tolerance file [default: 14 CFR Part 60].
    #[arg(long, value_name = "FILE")]
    pub tolerances: Option<PathBuf>,
    /// Percentages refer to the largest value (range) or to each sample.
    #[arg(long, value_name = "OF", default_value = "range", value_parser = percent_rules())]
    pub percent: String,
}

/// Computes the session and prints which tests pass.
pub fn match_command(arguments: &MatchArguments) -> Result<(), String> {
    let rule = PercentRule::from_name(&arguments.percent).unwrap_or_default();
    let reading = Reading { percent: rule, ..Reading::default() };
    let read = |path: &Path| {
        let text = read_text(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Tolerances::parse_by(&text, &reading).map_err(|error| format!("{}: {error}", path.display()))
    };
    let tolerances = match &arguments.tolerances {
        Some(path) => read(path)?,
        None => Tolerances::builtin_by(&reading)?,
    };
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let proof = snapshot.proof.ready().ok_or("nothing was simulated")?;
    let rows = proof_rows(&proof.judge_by(&session, &tolerances));
    if rows.windows.is_empty() {
        return Err("no validation manoeuvre: mark one as validation".to_owned());
    }
    if text::is_json() {
        text::json(&rows)?;
    }
    print(&rows, rule);
    let tests = || rows.windows.iter().flat_map(|window| &window.tests);
    let failed = tests().filter(|test| !test.passed).count();
    let unflown = rows.windows.iter().filter(|window| window.error.is_some()).count();
    match (failed, unflown) {
        (0, 0) => Ok(()),
        (0, _) => Err(format!("{unflown} of {} manoeuvres could not be simulated", rows.windows.len())),
        _ => Err(format!("{failed} of {} tests fail", tests().count())),
    }
}

fn print(rows: &ProofRow, rule: PercentRule) {
    text::line(&format!("tolerances: {}; percentages {}", rows.tolerances, rule.reference_description()));
    for window in &rows.windows {
        match &window.error {
            Some(error) => text::line(&format!("{}: not simulated: {error}", window.window)),
            None if window.tests.is_empty() => {
                text::line(&format!("{}: no test applies: state its surface or kind of input", window.window));
            }
            None => {}
        }
    }
    text::show_all(&proof_tables(rows));
}

/// Names of the rules for percentages.
fn percent_rules() -> PossibleValuesParser {
    PercentRule::ALL.map(PercentRule::name).into()
}
