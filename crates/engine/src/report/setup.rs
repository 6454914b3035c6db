//! Rows of what an analysis was made with: session, loading, reference geometry, noise.

use doublet_core::airframe::{Aircraft, Loading};
use sha2::{Digest, Sha256};

use super::results::{ItemRow, MassRow, ReferenceRow};
use crate::run::Snapshot;
use crate::session::{self, Preparation, Session};
use crate::stage;

/// SHA-256 of the session in its saved form, in hexadecimal digits; empty for one that has none.
pub fn session_sha256(session: &Session) -> String {
    let digits = |text: String| Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect();
    session::print(session).map(digits).unwrap_or_default()
}

/// The loading with its mass properties, once the aircraft is read.
pub fn mass_properties(session: &Session, snapshot: &Snapshot) -> Option<MassRow> {
    let (aircraft, loaded) = (&snapshot.aircraft.ready()?.aircraft, snapshot.loaded.ready()?);
    let properties = &loaded.properties;
    Some(MassRow {
        mass_kg: properties.mass_kg,
        cg_from_datum_m: properties.cg_from_datum_m,
        mean_chord_fraction: loaded.mean_chord_fraction,
        envelope_margin_m: loaded.envelope.map(|margin| margin.nearest_m()),
        ixx_kg_m2: properties.inertia.xx,
        iyy_kg_m2: properties.inertia.yy,
        izz_kg_m2: properties.inertia.zz,
        ixz_kg_m2: properties.inertia.xz,
        items: items(&stage::loading_on_board(aircraft, session.loading.as_ref())),
    })
}

fn items(loading: &Loading) -> Vec<ItemRow> {
    let places = [("fuel", &loading.fuel_kg), ("seat", &loading.seats_kg), ("luggage", &loading.luggage_kg)];
    let of_places = places.into_iter().flat_map(|(kind, masses)| {
        masses.iter().map(move |(place, &mass_kg)| ItemRow { kind, place: place.clone(), mass_kg })
    });
    let added = loading.added_items.iter().map(|item| ItemRow {
        kind: "item",
        place: item.name.clone(),
        mass_kg: item.mass_kg,
    });
    of_places.chain(added).collect()
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
