//! Version 5 kept structures beside the experiments: a second one, and others by name.

use doublet_core::model::Coefficient;
use toml::{Table, Value};

/// What an experiment of the second structure is called.
const SECOND: &str = "Structure B";

/// Makes every structure an experiment: the configuration of the session with that structure and what is known of its terms.
pub(crate) fn to_v6(session: &mut Table) {
    let second = session.remove("second_model").into_iter().map(|model| (SECOND.to_owned(), model));
    let kept = session.remove("kept_model").and_then(|kept| kept.as_array().cloned()).unwrap_or_default();
    let kept = kept.into_iter().filter_map(|mut kept| {
        let kept = kept.as_table_mut()?;
        Some((kept.remove("name")?.as_str()?.to_owned(), kept.remove("model")?))
    });
    let structures: Vec<(String, Value)> = second.chain(kept).collect();
    if structures.is_empty() {
        return;
    }
    let known = constraints(session).cloned().unwrap_or_default();
    if let (Some(model), false) = (session.get("model").cloned(), known.is_empty())
        && let Some(own) = constraints(session)
    {
        *own = of_model(&known, &model);
    }
    let experiments = session.entry("experiment").or_insert_with(|| Value::Array(Vec::new()));
    let Some(experiments) = experiments.as_array_mut() else { return };
    for (name, model) in structures {
        let is_taken = |name: &str| experiments.iter().any(|one| one.get("name").and_then(Value::as_str) == Some(name));
        let numbered = (2..).map(|number| format!("{name} {number}"));
        let name = std::iter::once(name.clone()).chain(numbered).find(|name| !is_taken(name)).unwrap_or(name.clone());
        let unset = Coefficient::ALL.map(Coefficient::name).into_iter().filter(|name| model.get(name).is_none());
        let unset: Vec<Value> = unset.map(|name| format!("model.{name}").into()).collect();
        let mut experiment = Table::from_iter([("name".to_owned(), name.into()), ("unset".to_owned(), unset.into())]);
        if !known.is_empty() {
            let own = Table::from_iter([("constraint".to_owned(), of_model(&known, &model).into())]);
            experiment.insert("estimation".to_owned(), own.into());
        }
        experiment.insert("model".to_owned(), model);
        experiments.push(experiment.into());
    }
}

/// What is known of derivatives.
fn constraints(session: &mut Table) -> Option<&mut Vec<Value>> {
    session.get_mut("estimation")?.get_mut("constraint")?.as_array_mut()
}

/// Those of terms that a structure has.
fn of_model(constraints: &[Value], model: &Value) -> Vec<Value> {
    let is_of_model = |known: &&Value| {
        let terms = known.get("coefficient").and_then(Value::as_str).and_then(|name| model.get(name)?.as_array());
        terms.zip(known.get("term")).is_some_and(|(terms, term)| terms.contains(term))
    };
    constraints.iter().filter(is_of_model).cloned().collect()
}
