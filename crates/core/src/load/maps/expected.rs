//! Whether a recording holds what a channel map is for: its values against the ranges the map states.
//!
//! Names and numbers of columns alone tell little: any matrix of 45 columns has the shape of one recorder's.

use crate::load::maps::map::ChannelMap;
use crate::load::maps::plan::{Assignment, Plan};
use crate::statistics::{median, ranked};

/// Per cent of the magnitudes below the one that counts as the largest: single wild points say nothing of the unit.
const LARGEST_PERCENT: usize = 99;

/// What the values of `plan` speak against its being a plan of a recording that `map` is for, one line per role: a median or a largest
/// magnitude outside the range the map states. Values that were not read yet say nothing.
pub fn mismatches(plan: &Plan, map: &ChannelMap) -> Vec<String> {
    let mut found = Vec::new();
    for (role, assignment) in &plan.roles {
        let Some(entry) = map.roles.get(role) else { continue };
        let mut values = in_unit_of_map(plan, assignment);
        let Some(median) = median(&mut values) else { continue };
        values.iter_mut().for_each(|value| *value = value.abs());
        let last = (values.len() - 1) * LARGEST_PERCENT / 100;
        let Some(largest) = ranked(&mut values, last) else { continue };
        let judged = [("median", median, entry.median), ("largest magnitude", largest, entry.largest)];
        for (name, value, range) in judged {
            let Some([low, high]) = range.filter(|[low, high]| !(*low..=*high).contains(&value)) else { continue };
            let (role, unit) = (role.name(), &assignment.unit.symbol);
            found.push(format!(
                "{role} ({}): {name} {value:.3} {unit} is outside {low} to {high} {unit} of the map",
                assignment.description
            ));
        }
    }
    found
}

/// Finite values of an assignment as the map states its ranges: in its unit, offset added, by its sign and scale.
fn in_unit_of_map(plan: &Plan, assignment: &Assignment) -> Vec<f64> {
    let mut all = Vec::new();
    for terms in &assignment.parts {
        let columns = terms
            .iter()
            .map(|&(at, weight)| (plan.probes[at.probe].sources[at.source].channels[at.channel].values(), weight));
        let columns: Vec<(&[f64], f64)> = columns.collect();
        let samples = columns.iter().map(|(values, _)| values.len()).min().unwrap_or(0);
        let raw = |k: usize| columns.iter().map(|(values, weight)| weight * values[k]).sum::<f64>();
        all.extend((0..samples).map(|k| assignment.factor * (raw(k) + assignment.offset)).filter(|v| v.is_finite()));
    }
    all
}
