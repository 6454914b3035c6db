//! Rows of what an analysis was made with: session, loading, reference geometry, noise.

use doublet_core::airframe::Aircraft;
use serde::Serialize;

use super::results::ReferenceRow;
use crate::keep::hash_bytes;
use crate::session::{self, Preparation, Session};

/// A file beside the recordings.
#[derive(Clone, Debug, Serialize)]
pub struct FileRow {
    /// `aircraft` or `instruments`.
    pub kind: &'static str,
    /// Flight; empty if it is of all flights.
    pub flight: String,
    /// Path as in the session.
    pub path: String,
    /// SHA-256 of the file, without changes that the session makes.
    pub sha256: String,
}

/// SHA-256 of the session in its saved form, in hexadecimal digits; empty for one that has none.
pub fn session_sha256(session: &Session) -> String {
    session::print(session).map(|text| hash_bytes(text.as_bytes())).unwrap_or_default()
}

/// Lengths and area of the coefficients.
pub fn reference(aircraft: &Aircraft, preparation: &Preparation) -> ReferenceRow {
    ReferenceRow {
        geometry: aircraft.reference,
        moment_reference_from_datum_m: preparation
            .moment_reference
            .from_datum_m(aircraft.moment_reference_from_datum_m),
    }
}
