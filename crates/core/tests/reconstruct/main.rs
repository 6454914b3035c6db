//! Flight path reconstruction against a plain dense filter, a published result and known truth.

mod citation;
mod dense;
mod reference;
#[path = "../common/shared.rs"]
mod shared;
