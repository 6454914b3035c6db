//! What the names of channels say: words, units and the names that recorders give a role.

pub(crate) mod foreign_names;
pub(crate) mod role_names;
pub(crate) mod stated_unit;
pub(crate) mod tokens;
pub(crate) mod words;
