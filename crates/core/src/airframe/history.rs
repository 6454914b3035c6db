//! Mass, centre of gravity and inertia over time, from the fuel on board.

use std::sync::Arc;

use thiserror::Error;

use super::MassProperties;
use super::aircraft::Aircraft;
use super::loading::Loading;

/// Mass properties over the samples of a window.
#[derive(Clone, Debug, PartialEq)]
pub enum MassHistory {
    /// The same at every sample.
    Constant(MassProperties),
    /// One per sample; shared, as a window may be long.
    PerSample(Arc<[MassProperties]>),
}

/// How a total fuel mass divides among the tanks.
#[derive(Clone, Debug, PartialEq)]
pub enum FuelSplit {
    /// In proportion to the fuel of each tank in the loading.
    Proportional,
    /// Tanks empty one after the other in this order; tanks not named keep the fuel of the loading.
    InOrder(Vec<Vec<String>>),
}

/// Why there are no mass properties over time.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum HistoryError {
    #[error("{field} has {found} samples, the time vector has {expected}: one value for each time is needed")]
    Length { field: String, found: usize, expected: usize },
    #[error("time at sample {index} is {time_s} s, allowed is a finite time after the sample before it")]
    Time { index: usize, time_s: f64 },
    /// A fuel mass is negative, not a number, or more than the tanks hold or the split can place.
    #[error("{field} at {time_s} s is {fuel_kg} kg, allowed is {lowest_kg} to {highest_kg} kg")]
    Fuel { field: String, time_s: f64, fuel_kg: f64, lowest_kg: f64, highest_kg: f64 },
    #[error("tank '{name}' not found, the tanks are {}", tanks.join(", "))]
    UnknownTank { name: String, tanks: Vec<String> },
}

/// Slack on the fuel a recording may hold beyond the tanks' capacity, kg: rounding of printed capacities.
const CAPACITY_SLACK_KG: f64 = 0.5;

impl MassHistory {
    /// Mass properties at `sample`.
    ///
    /// # Panics
    /// Where the history has a value for each sample and `sample` is beyond the last.
    pub fn at(&self, sample: usize) -> &MassProperties {
        match self {
            Self::Constant(properties) => properties,
            Self::PerSample(history) => &history[sample],
        }
    }

    /// Mass properties at the first sample; `None` for a window without samples.
    pub fn first(&self) -> Option<&MassProperties> {
        match self {
            Self::Constant(properties) => Some(properties),
            Self::PerSample(history) => history.first(),
        }
    }

    /// The history with `change` added at every sample.
    #[must_use]
    pub fn plus(self, change: &MassProperties) -> Self {
        match self {
            Self::Constant(properties) => Self::Constant(properties.plus(change)),
            Self::PerSample(history) => Self::PerSample(history.iter().map(|each| each.plus(change)).collect()),
        }
    }

    /// Mass properties over time from the fuel of each tank: everything else of `loading` stays as it is, and so does the
    /// fuel of tanks not named in `fuel`. Each column of `fuel` is a tank's name and its fuel mass (kg) at `time_s`.
    ///
    /// # Errors
    /// [`HistoryError`] naming column and time.
    pub fn from_tanks(
        aircraft: &Aircraft,
        loading: &Loading,
        time_s: &[f64],
        fuel: &[(String, &[f64])],
    ) -> Result<Self, HistoryError> {
        examine_time(time_s)?;
        for (name, column) in fuel {
            let tank = aircraft.tanks.iter().find(|tank| tank.name == *name);
            let tank = tank.ok_or_else(|| unknown_tank(aircraft, name))?;
            examine_fuel(name, time_s, column, 0.0, tank.capacity_kg)?;
        }
        Ok(Self::over(aircraft, loading, time_s, |sample, state| {
            for (name, column) in fuel {
                set_fuel(state, name, column[sample]);
            }
        }))
    }

    /// Mass properties over time from the total fuel mass (kg) at `time_s`, divided among the tanks by `split`. The fuel of
    /// `loading` is that at the beginning: it sets the proportions, or what the first tanks in order have still to give.
    ///
    /// # Errors
    /// [`HistoryError`] naming column and time; with [`FuelSplit::InOrder`] also where more fuel is gone than the named
    /// tanks held.
    pub fn from_total_fuel(
        aircraft: &Aircraft,
        loading: &Loading,
        time_s: &[f64],
        fuel_kg: &[f64],
        split: &FuelSplit,
    ) -> Result<Self, HistoryError> {
        examine_time(time_s)?;
        let initial: Vec<(&str, f64)> = aircraft
            .tanks
            .iter()
            .map(|tank| (tank.name.as_str(), loading.fuel_kg.get(&tank.name).copied().unwrap_or(0.0).max(0.0)))
            .collect();
        let total: f64 = initial.iter().map(|(_, fuel)| fuel).sum();
        match split {
            FuelSplit::Proportional => {
                let lowest_share = aircraft
                    .tanks
                    .iter()
                    .zip(&initial)
                    .filter(|(_, (_, fuel))| *fuel > 0.0)
                    .map(|(tank, (_, fuel))| tank.capacity_kg * total / fuel)
                    .fold(f64::INFINITY, f64::min);
                let highest = if total > 0.0 { lowest_share } else { 0.0 };
                examine_fuel("fuel mass", time_s, fuel_kg, 0.0, highest)?;
                Ok(Self::over(aircraft, loading, time_s, |sample, state| {
                    for (name, fuel) in &initial {
                        set_fuel(state, name, if total > 0.0 { fuel * fuel_kg[sample] / total } else { 0.0 });
                    }
                }))
            }
            FuelSplit::InOrder(order) => {
                let groups = order
                    .iter()
                    .map(|names| {
                        names
                            .iter()
                            .map(|name| {
                                let tank = initial.iter().find(|(tank, _)| tank == name);
                                tank.copied().ok_or_else(|| unknown_tank(aircraft, name))
                            })
                            .collect::<Result<Vec<_>, _>>()
                    })
                    .collect::<Result<Vec<_>, _>>()?;
                let givable: f64 = groups.iter().flatten().map(|(_, fuel)| fuel).sum();
                examine_fuel("fuel mass", time_s, fuel_kg, total - givable, total)?;
                Ok(Self::over(aircraft, loading, time_s, |sample, state| {
                    let mut gone = total - fuel_kg[sample];
                    for group in &groups {
                        let held: f64 = group.iter().map(|(_, fuel)| fuel).sum();
                        let left = if held > 0.0 { 1.0 - (gone / held).clamp(0.0, 1.0) } else { 1.0 };
                        gone = (gone - held).max(0.0);
                        for (name, fuel) in group {
                            set_fuel(state, name, fuel * left);
                        }
                    }
                }))
            }
        }
    }

    /// Mass properties at each time, after `edit` has put the fuel of that sample into the loading.
    fn over(aircraft: &Aircraft, loading: &Loading, time_s: &[f64], mut edit: impl FnMut(usize, &mut Loading)) -> Self {
        let mut state = loading.clone();
        for tank in &aircraft.tanks {
            state.fuel_kg.entry(tank.name.clone()).or_insert(0.0);
        }
        let at = |sample| {
            edit(sample, &mut state);
            state.mass_properties(aircraft)
        };
        Self::PerSample((0..time_s.len()).map(at).collect())
    }
}

/// Puts a tank's fuel into the loading without allocating; every tank has its entry.
fn set_fuel(state: &mut Loading, name: &str, fuel_kg: f64) {
    if let Some(entry) = state.fuel_kg.get_mut(name) {
        *entry = fuel_kg;
    }
}

fn unknown_tank(aircraft: &Aircraft, name: &str) -> HistoryError {
    let tanks = aircraft.tanks.iter().map(|tank| tank.name.clone()).collect();
    HistoryError::UnknownTank { name: name.to_owned(), tanks }
}

fn examine_time(time_s: &[f64]) -> Result<(), HistoryError> {
    let mut last = f64::NEG_INFINITY;
    for (index, &time_s) in time_s.iter().enumerate() {
        if !time_s.is_finite() || time_s <= last {
            return Err(HistoryError::Time { index, time_s });
        }
        last = time_s;
    }
    Ok(())
}

fn examine_fuel(
    field: &str,
    time_s: &[f64],
    fuel_kg: &[f64],
    lowest_kg: f64,
    highest_kg: f64,
) -> Result<(), HistoryError> {
    if fuel_kg.len() != time_s.len() {
        return Err(HistoryError::Length { field: field.to_owned(), found: fuel_kg.len(), expected: time_s.len() });
    }
    let allowed = lowest_kg - CAPACITY_SLACK_KG..=highest_kg + CAPACITY_SLACK_KG;
    let allowed = allowed.start().max(0.0)..=*allowed.end();
    match fuel_kg.iter().position(|fuel| !allowed.contains(fuel)) {
        Some(index) => Err(HistoryError::Fuel {
            field: field.to_owned(),
            time_s: time_s[index],
            fuel_kg: fuel_kg[index],
            lowest_kg,
            highest_kg,
        }),
        None => Ok(()),
    }
}
