//! Coefficients and derivatives from recordings, against published answers and a simulator.

mod attas;
mod citation;
mod moments;

use doublet_core::load::ChannelMap;

/// The channel map shipped under this name.
fn shipped_map(name: &str) -> ChannelMap {
    let (_, text) = ChannelMap::shipped().iter().find(|(shipped, _)| *shipped == name).unwrap();
    ChannelMap::parse(text).unwrap()
}
