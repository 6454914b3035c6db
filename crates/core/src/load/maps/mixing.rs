//! Surfaces that work in two axes at once: what their two recorded deflections are in those of the conventions.

use serde::Deserialize;
use toml::Spanned;

use crate::quantity::Role;

/// Two surfaces that share their work, both deflections positive trailing edge down unless a sign says otherwise.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MixingTable {
    pub source: Option<String>,
    pub left: String,
    pub right: String,
    pub unit: Option<Spanned<String>>,
    pub left_sign: Option<Spanned<f64>>,
    pub right_sign: Option<Spanned<f64>>,
    #[serde(default)]
    pub optional: bool,
}

/// A role, and the weights of the left and the right deflection in it.
pub(crate) type Share = (Role, [f64; 2]);

/// Kinds of surfaces and the roles they play.
///
/// In the conventions elevator and flap are positive trailing edge down, aileron right aileron down, rudder trailing edge left. The
/// panels of a V-tail are turned about x by their dihedral: the left one with its trailing edge down pushes the tail up and to the right,
/// as a rudder with its trailing edge left does.
const KINDS: [(&str, [Share; 2]); 4] = [
    ("elevons", [(Role::Elevator, [0.5, 0.5]), (Role::Aileron, [-0.5, 0.5])]),
    ("tailerons", [(Role::Elevator, [0.5, 0.5]), (Role::Aileron, [-0.5, 0.5])]),
    ("flaperons", [(Role::Flap, [0.5, 0.5]), (Role::Aileron, [-0.5, 0.5])]),
    ("v_tail", [(Role::Elevator, [0.5, 0.5]), (Role::Rudder, [0.5, -0.5])]),
];

pub(crate) fn kinds() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|(name, _)| *name)
}

/// The roles surfaces of a kind play.
pub(crate) fn shares(kind: &str) -> Option<&'static [Share; 2]> {
    KINDS.iter().find(|(name, _)| *name == kind).map(|(_, shares)| shares)
}
