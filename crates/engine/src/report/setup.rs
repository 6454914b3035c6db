//! Rows of what an analysis was made with: session, loading, reference geometry, noise.

use doublet_core::airframe::Aircraft;

use super::results::ReferenceRow;
use crate::keep::hash_bytes;
use crate::session::{self, Preparation, Session};

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
