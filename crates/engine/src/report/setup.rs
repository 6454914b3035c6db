//! Rows of what an analysis was made with: session, loading, reference geometry, noise.

use doublet_core::airframe::Aircraft;
use sha2::{Digest, Sha256};

use super::results::ReferenceRow;
use crate::session::{self, Preparation, Session};

/// SHA-256 of the session in its saved form, in hexadecimal digits; empty for one that has none.
pub fn session_sha256(session: &Session) -> String {
    let digits = |text: String| Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect();
    session::print(session).map(digits).unwrap_or_default()
}

/// Lengths and area of the coefficients.
pub fn reference(aircraft: &Aircraft, preparation: &Preparation) -> ReferenceRow {
    let reference = &aircraft.reference;
    ReferenceRow {
        area_m2: reference.area_m2,
        span_m: reference.span_m,
        chord_m: reference.chord_m,
        lateral_moment_length_m: reference.lateral_moment_length_m,
        lateral_rate_length_m: reference.lateral_rate_length_m,
        pitch_rate_length_m: reference.pitch_rate_length_m,
        moment_reference_from_datum_m: preparation
            .moment_reference
            .from_datum_m(aircraft.moment_reference_from_datum_m),
    }
}
