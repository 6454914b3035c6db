//! The manoeuvres: list, pictures, map, candidates.

pub(super) mod gallery;
pub(super) mod manoeuvre_list;
pub(super) mod manoeuvre_map;
pub(super) mod proposals;
pub(super) mod window_filter;
