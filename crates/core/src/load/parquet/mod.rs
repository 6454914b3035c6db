//! Parquet tables: one source, whose units stand in the Arrow schema that writers of tables leave beside it.

#[cfg(feature = "parquet")]
mod arrow_schema;
#[cfg(feature = "parquet")]
mod columns;

#[cfg(feature = "parquet")]
pub(super) use columns::sources;

#[cfg(not(feature = "parquet"))]
use super::{LoadError, contents::Source};

/// First and last bytes of a file.
pub(super) const SIGNATURE: &[u8] = b"PAR1";

/// Refuses the file in a build that cannot read it.
#[cfg(not(feature = "parquet"))]
pub(super) fn sources(path: &std::path::Path, _contents: Vec<u8>) -> Result<(Vec<Source>, Vec<String>), LoadError> {
    Err(LoadError::Unsupported {
        path: path.to_owned(),
        what: "a Parquet table".to_owned(),
        cure: "build with the feature \"parquet\", or give CSV",
    })
}
