//! Sessions of older versions, brought to the present one step at a time. Each step is a file of its own.

mod v1;
mod v2;
mod v3;
mod v4;
mod v5;

use toml::Table;

/// A step to the next version.
type Step = fn(&mut Table);

/// The step that leaves each version, the first from version 1.
const STEPS: [Step; 5] = [v1::to_v2, v2::to_v3, v3::to_v4, v4::to_v5, v5::to_v6];

/// Version this program writes: one more than the last step leaves.
pub const VERSION: u32 = STEPS.len() as u32 + 1;

/// Brings a session of `version` to [`VERSION`]. A file that names no version is one of the first.
pub(crate) fn to_present(session: &mut Table, version: u32) {
    for step in STEPS.iter().skip((version.max(1) - 1) as usize) {
        step(session);
    }
}
