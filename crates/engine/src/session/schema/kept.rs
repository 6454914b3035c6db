//! Structures kept by name, as they are saved.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{SessionError, model_table, structure_from};
use crate::session::KeptStructure;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptTable {
    name: String,
    model: BTreeMap<String, Vec<String>>,
}

pub(super) fn kept_from(table: KeptTable) -> Result<KeptStructure, SessionError> {
    let structure = structure_from(&format!("kept_model '{}'", table.name), &table.model)?;
    Ok(KeptStructure { name: table.name, structure })
}

pub(super) fn kept_table(kept: &KeptStructure) -> KeptTable {
    KeptTable { name: kept.name.clone(), model: model_table(&kept.structure) }
}
