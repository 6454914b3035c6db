//! Saved form of what is on board.

use std::collections::BTreeMap;

use doublet_core::airframe::{FixedItem, Loading};
use serde::{Deserialize, Serialize};

/// What is on board.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadingTable {
    fuel_kg: BTreeMap<String, f64>,
    seats_kg: BTreeMap<String, f64>,
    luggage_kg: BTreeMap<String, f64>,
    #[serde(rename = "item", skip_serializing_if = "Vec::is_empty")]
    items: Vec<ItemTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ItemTable {
    name: String,
    mass_kg: f64,
    cg_from_datum_m: [f64; 3],
}

/// The loading a table states.
pub fn loading_from(table: LoadingTable) -> Loading {
    let item =
        |item: ItemTable| FixedItem { name: item.name, mass_kg: item.mass_kg, cg_from_datum_m: item.cg_from_datum_m };
    Loading {
        fuel_kg: table.fuel_kg,
        seats_kg: table.seats_kg,
        luggage_kg: table.luggage_kg,
        added_items: table.items.into_iter().map(item).collect(),
    }
}

/// The table of a loading.
pub fn loading_table(loading: &Loading) -> LoadingTable {
    let item = |item: &FixedItem| ItemTable {
        name: item.name.clone(),
        mass_kg: item.mass_kg,
        cg_from_datum_m: item.cg_from_datum_m,
    };
    LoadingTable {
        fuel_kg: loading.fuel_kg.clone(),
        seats_kg: loading.seats_kg.clone(),
        luggage_kg: loading.luggage_kg.clone(),
        items: loading.added_items.iter().map(item).collect(),
    }
}
