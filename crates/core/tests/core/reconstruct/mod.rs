//! Flight path reconstruction against a plain dense filter, a published result and known truth.

mod air_data;
mod behaviour;
mod citation;
mod dense;
mod equality;
mod iterated;
mod judgement;
mod outliers;
mod proposals;
mod realisations;
mod reference;
mod robust;
mod sequential;
mod shifts;
mod smoother;
mod unscented;
