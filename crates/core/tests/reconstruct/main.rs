//! Flight path reconstruction against a plain dense filter, a published result and known truth.

#[cfg(test)]
mod behaviour;
#[cfg(test)]
mod citation;
#[cfg(test)]
mod dense;
#[cfg(test)]
mod judgement;
#[cfg(test)]
mod reference;
#[cfg(test)]
#[path = "../common/shared.rs"]
mod shared;
#[cfg(test)]
mod smoother;
