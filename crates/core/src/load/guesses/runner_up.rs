//! Runners-up: the channels that would play the roles of a guess if those chosen did not.

use crate::load::guesses::by_words::named_by_any;
use crate::load::guesses::candidates::Candidate;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap, NameFit, RunnerUp};

/// Lists for every row of a guess by words the free channel whose name fits its role next best.
pub(crate) fn add_runners_up(map: &mut ManualChannelMap, free: &[Candidate<'_>]) {
    let is_used = |candidate: &Candidate<'_>| map.rows.iter().any(|(_, row)| row.from == candidate.from);
    let is_left_out = |candidate: &Candidate<'_>| map.all_left_out().any(|(from, _)| *from == candidate.from);
    let taken: Vec<usize> = (0..free.len()).filter(|i| is_used(&free[*i]) || is_left_out(&free[*i])).collect();
    let found = map.rows.iter().filter_map(|(role, row)| {
        let (index, fit) = named_by_any(*role, map, free, &taken)?;
        Some((*role, RunnerUp { from: free[index].from.clone(), reason: compare(row, fit) }))
    });
    map.runners_up = found.collect();
}

/// Why a row is preferred to a channel whose name fits so.
fn compare(row: &ManualChannel, fit: NameFit) -> String {
    let chosen = &row.from.channel;
    match (row.by, row.fit) {
        (By::Recorder, _) => format!("the recorder's documentation names '{chosen}'"),
        (By::Axes, _) => format!("'{chosen}' is one of three axes"),
        (_, Some(own)) if own < fit => {
            format!("only the {} fits; of '{chosen}' the {}", fit.description(), own.description())
        }
        (_, Some(own)) if own == fit => format!("name fits as well; '{chosen}' has the more usual name or comes first"),
        _ => format!("other channels agree with '{chosen}'"),
    }
}
