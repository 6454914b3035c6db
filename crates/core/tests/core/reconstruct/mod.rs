//! Flight path reconstruction against a plain dense filter, a published result and known truth.

#[cfg(test)]
mod against_truth;
#[cfg(test)]
mod air_data;
#[cfg(test)]
mod behaviour;
#[cfg(test)]
mod citation;
#[cfg(test)]
mod dense;
#[cfg(test)]
mod equality;
#[cfg(test)]
mod iterated;
#[cfg(test)]
mod judgement;
#[cfg(test)]
mod outliers;
#[cfg(test)]
mod proposals;
#[cfg(test)]
mod realisations;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod robust;
#[cfg(test)]
mod sequential;
#[cfg(test)]
mod shifts;
mod smoother;
#[cfg(test)]
mod unscented;
