//! Version 2 meant the standard gravity where none was stated.

use doublet_core::atmos::STANDARD_GRAVITY_M_S2;
use toml::{Table, Value};

/// Writes in the gravity that was left out.
pub(crate) fn to_v3(session: &mut Table) {
    let filter = session.entry("filter").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(filter) = filter {
        filter.entry("gravity_m_s2").or_insert(STANDARD_GRAVITY_M_S2.into());
    }
}
