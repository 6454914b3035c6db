//! Version 3 took the random walk of the wind and the delays of the measurements as stated.

use toml::{Table, Value};

/// Writes in that neither is estimated.
pub(crate) fn to_v4(session: &mut Table) {
    let filter = session.entry("filter").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(filter) = filter {
        filter.entry("gusts").or_insert("stated".into());
        filter.entry("delays").or_insert("stated".into());
    }
}
