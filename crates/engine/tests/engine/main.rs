//! Tests of the engine, in one program: `cargo test -p doublet-engine --test engine SUBJECT` runs those of one subject.

#[path = "../../../core/tests/common/flight.rs"]
mod flight;
#[path = "../../../core/tests/common/mavlink.rs"]
mod mavlink;
#[path = "../../../core/tests/common/shared.rs"]
#[allow(clippy::print_stdout, reason = "says why a test is skipped")]
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
