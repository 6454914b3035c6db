//! Which doublet this is: version, commit and the vector instructions it uses on this machine.

use std::sync::LazyLock;

use doublet_core::reconstruct::instructions;
use doublet_report::COMMIT;

/// `0.1.0 (commit 1a2b3c4d5e, AVX-512)`.
pub fn version() -> &'static str {
    static VERSION: LazyLock<String> =
        LazyLock::new(|| format!("{} (commit {}, {})", env!("CARGO_PKG_VERSION"), COMMIT, instructions()));
    &VERSION
}
