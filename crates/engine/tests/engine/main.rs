//! Tests of the engine, in one program: `cargo test -p doublet-engine --test engine SUBJECT` runs those of one subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests are not marked as tests"
)]

use std::path::Path;

use doublet_engine::graph::Cache;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::Session;

#[path = "../../../core/tests/common/flight.rs"]
mod flight;
#[path = "../../../core/tests/common/mavlink.rs"]
mod mavlink;
#[path = "../../../core/tests/common/shared.rs"]
mod shared;

mod aircraft;
mod batch;
mod calibrate;
mod coefficients;
mod compare;
mod delays;
mod equivalent;
mod estimates;
mod excluded;
mod export;
mod fix_edits;
mod fixes;
mod folders;
mod hostile;
mod indication;
mod live;
mod live_faults;
mod live_silence;
mod looked_at;
mod maps;
mod mass;
mod never_lost;
mod output_error;
mod physics;
mod planning;
mod proof_of_match;
mod report_figure;
mod session;
mod signals;
mod stages;
mod strangers_signals;
mod thesis;
mod verdict;
mod verdict_causes;
mod verdict_shipped;

/// All that a session asks for whose relative paths start at `folder`.
fn compute(session: &Session, folder: &Path) -> Snapshot {
    let scope = Scope { session, folder, first: None, studies: &[], cause: "test", generation: 1 };
    run(&scope, &Snapshot::default(), &Cache::new(1 << 30), &Control::default(), &|_| {})
}
