//! A flight watched against the limits of its campaign.

use std::path::Path;

use super::Campaign;
use crate::live::{Opening, Watched, open};

/// Finds what is to be watched, and by which limits.
pub fn open_flight(opening: &Opening) -> Result<Watched, String> {
    let mut watched = open(opening)?;
    if let Some(name) = &opening.campaign {
        watched.settings.limit(&Campaign::open(Path::new(name))?.limits);
    }
    Ok(watched)
}
