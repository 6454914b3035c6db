//! Parquet tables: one source, whose units stand in the Arrow schema that writers of tables leave beside it.

#[cfg(feature = "parquet")]
mod arrow_schema;
#[cfg(feature = "parquet")]
mod columns;
#[cfg(feature = "parquet")]
mod sizes;

#[cfg(feature = "parquet")]
pub(crate) use columns::sources;

#[cfg(not(feature = "parquet"))]
use crate::load::budget::Budget;
#[cfg(not(feature = "parquet"))]
use crate::load::contents::Source;
#[cfg(not(feature = "parquet"))]
use crate::load::error::LoadError;

/// Refuses the file in a build that cannot read it.
#[cfg(not(feature = "parquet"))]
pub(crate) fn sources(
    path: &std::path::Path,
    _budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<crate::message::Message>), LoadError> {
    Err(LoadError::Unsupported {
        path: path.to_owned(),
        what: "a Parquet table".to_owned(),
        fix: "build with the feature \"parquet\", or give CSV",
    })
}
