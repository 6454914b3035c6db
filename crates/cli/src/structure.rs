//! `doublet structure`: terms the data ask for, found stepwise or by orthogonal functions, with every step; nothing is changed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use doublet_core::estimate::{OrthogonalSettings, Stacked, StepwiseSettings, orthogonal, stacked, stepwise};
use doublet_core::model::{Coefficient, Structure, Term, Variable};
use doublet_engine::stage::{Regression, pooled_regressions};

use crate::run::{self, computed};
use crate::text;

/// Candidates of the symmetric and of the asymmetric coefficients, beside the terms of the session.
const SYMMETRIC: [&str; 6] = ["alpha", "alpha^2", "alpha_dot", "qc/V", "delta_e", "alpha*delta_e"];
const ASYMMETRIC: [&str; 6] = ["beta", "beta_dot", "pb/2V", "rb/2V", "delta_a", "delta_r"];

#[derive(Debug, Args)]
pub struct StructureArguments {
    /// Session file.
    pub session: PathBuf,
    /// Search method.
    #[arg(long, value_enum, default_value_t = TermSearch::Stepwise)]
    pub method: TermSearch,
    /// Candidate terms [default: usual variables, alpha^2 and alpha*delta_e].
    #[arg(long, value_name = "TERM,TERM", value_delimiter = ',', value_parser = term)]
    pub terms: Vec<Term>,
}

/// Search method.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum TermSearch {
    /// Stepwise, by partial correlation and partial F.
    Stepwise,
    /// Orthogonal functions, to the least predicted squared error.
    Orthogonal,
}

fn term(text: &str) -> Result<Term, String> {
    Term::parse(text).map_err(|error| error.to_string())
}

/// Prints every step of the search and the terms it ends with.
pub fn structure(arguments: &StructureArguments) -> Result<(), String> {
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let windows = snapshot.aero(&session);
    let mut done = 0;
    for (coefficient, own) in &session.structure.models {
        let asymmetric = matches!(coefficient, Coefficient::CY | Coefficient::Cl | Coefficient::Cn);
        let usual = if asymmetric { ASYMMETRIC } else { SYMMETRIC };
        let usual = usual.into_iter().filter_map(|text| Term::parse(text).ok());
        let offered: Vec<Term> = if arguments.terms.is_empty() { usual.collect() } else { arguments.terms.clone() };
        let variables = |term: &Term| term.factors().iter().map(|(variable, _)| *variable).collect::<Vec<_>>();
        let known = |term: &Term| {
            windows.iter().all(|(_, aero)| variables(term).iter().all(|&v| aero.variables.get(v).is_some()))
        };
        let candidates = candidates(own, offered.into_iter().filter(known));
        let only = Structure { models: vec![(*coefficient, candidates.clone())] };
        for regression in pooled_regressions(&windows, &only, &session.estimation) {
            let Ok(Regression { pooled, .. }) = regression.inspect_err(|error| run::print_error(&error.to_string()))
            else {
                continue;
            };
            done += 1;
            let all = stacked(&pooled.names, &pooled.per_window, &pooled.windows).map_err(|error| error.to_string())?;
            text::line(&format!("{} over {} manoeuvres", coefficient.name(), pooled.windows.len()));
            let selected = search(arguments.method, *coefficient, &all)?;
            let has = |term: &&Term| term.is_constant() || selected.contains(&term.derivative_name(*coefficient));
            let kept: Vec<String> = candidates.iter().filter(has).map(|term| format!("\"{term}\"")).collect();
            text::line(&format!("{} = [{}]\n", coefficient.name(), kept.join(", ")));
        }
    }
    run::some_done(done)
}

/// The session's own terms and those offered that are another variable: the session's form of a term, `qc/2V` or `qc/V`, stands
/// for both.
fn candidates(own: &[Term], offered: impl Iterator<Item = Term>) -> Vec<Term> {
    let plain = |term: &Term| {
        let half = |variable| if variable == Variable::HalfPitchRate { Variable::PitchRate } else { variable };
        term.factors().iter().map(|&(variable, power)| (half(variable), power)).collect::<Vec<_>>()
    };
    let mut candidates = own.to_vec();
    for term in offered {
        if candidates.iter().all(|other| plain(other) != plain(&term)) {
            candidates.push(term);
        }
    }
    candidates
}

/// Searches, prints the steps and gives the names of the chosen parameters; constants are always in the model.
fn search(method: TermSearch, coefficient: Coefficient, all: &Stacked) -> Result<Vec<String>, String> {
    let constant = format!("{}_0", coefficient.name());
    let is_constant = |name: &str| name.split('[').next() == Some(&constant);
    let forced: Vec<usize> = (0..all.names.len()).filter(|&k| is_constant(&all.names[k])).collect();
    let number = |value: f64| text::number(value, 4);
    let selected = match method {
        TermSearch::Stepwise => {
            let found = stepwise(&all.names, &all.x, &all.z, &forced, &StepwiseSettings::default())
                .map_err(|error| format!("{}: {error}", coefficient.name()))?;
            let rows = found.log.iter().map(|step| {
                let values = [step.partial_correlation, step.partial_f, step.r_squared, step.press];
                let words = [format!("{:?}", step.action), step.name.clone()];
                words.into_iter().chain(values.map(number)).chain([number(step.predicted_squared_error)]).collect()
            });
            let header = ["  step", "term", "correlation", "partial F", "R2", "PRESS", "PSE"];
            text::table(&header, &rows.collect::<Vec<_>>());
            found.selected
        }
        TermSearch::Orthogonal => {
            let found = orthogonal(&all.names, &all.x, &all.z, &forced, &OrthogonalSettings::default())
                .map_err(|error| format!("{}: {error}", coefficient.name()))?;
            let rows = found.log.iter().map(|step| {
                let words = [if step.kept { "Kept" } else { "Refused" }.to_owned(), step.name.clone()];
                let values = [step.gain, step.r_squared, step.predicted_squared_error];
                words.into_iter().chain(values.map(number)).collect()
            });
            text::table(&["  step", "term", "gain", "R2", "PSE"], &rows.collect::<Vec<_>>());
            found.selected
        }
    };
    Ok(selected.into_iter().map(|index| all.names[index].clone()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn session_keeps_its_own_form_of_a_term() {
        let terms = |names: &[&str]| -> Vec<Term> { names.iter().filter_map(|name| Term::parse(name).ok()).collect() };
        let (own, offered) = (terms(&["1", "alpha", "qc/2V"]), terms(&["alpha", "qc/V", "delta_e"]));
        let found = candidates(&own, offered.into_iter());
        assert_eq!(found, terms(&["1", "alpha", "qc/2V", "delta_e"]));
    }
}
