//! Surfaces in pairs: of a left and a right deflection recorded in two channels, the role is their mean, or half their difference.

use crate::load::guesses::candidates::{Candidate, LEFT, RIGHT};
use crate::load::guesses::motion::fit_line;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap, OtherSide};
use crate::quantity::Role;

/// Roles of surfaces that are recorded in pairs.
const PAIRED: [Role; 2] = [Role::Aileron, Role::Elevator];
/// Letters for the two sides.
const LETTERS: [(&str, &str); 2] = [("l", "r"), ("lh", "rh")];
/// Least correlation, either way, of two deflections that one control moves, and their largest ratio.
const CORRELATION: f64 = 0.9;
const RATIO: f64 = 2.0;

/// Gives the rows of surfaces the channel of their other side.
pub(crate) fn add_other_sides(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], taken: &mut Vec<usize>) {
    for role in PAIRED {
        let Some(row) = map.row(role).filter(|row| row.by == By::Name).cloned() else { continue };
        let Some(one) = candidates.iter().find(|candidate| candidate.from == row.from) else { continue };
        let is_other = |(index, other): &(usize, &Candidate<'_>)| !taken.contains(index) && are_sides(one, other);
        let Some((index, other)) = candidates.iter().enumerate().find(is_other) else { continue };
        let sign = match compare(one.channel.values(), other.channel.values()) {
            Some((correlation, ratio)) if correlation.abs() > CORRELATION && ratio.ln().abs() < RATIO.ln() => {
                correlation.signum()
            }
            _ => continue,
        };
        // Elevators that move against each other are ailerons too.
        if role == Role::Elevator && sign < 0.0 {
            continue;
        }
        taken.push(index);
        let other_side = Some(OtherSide { channel: other.from.channel.clone(), sign });
        map.set(role, Some(ManualChannel { other_side, ..row }));
    }
}

/// Whether the names of two channels of one source and clock differ in the side alone.
fn are_sides(one: &Candidate<'_>, other: &Candidate<'_>) -> bool {
    let is_beside = one.from.source == other.from.source
        && one.channel.clock == other.channel.clock
        && one.unit == other.unit
        && one.tokens.len() == other.tokens.len();
    let mut apart = one.tokens.iter().zip(&other.tokens).filter(|(one, other)| one != other);
    is_beside && apart.next().is_some_and(|(one, other)| are_opposite(one, other)) && apart.next().is_none()
}

/// Whether two words are the same but for the side that they name.
fn are_opposite(one: &str, other: &str) -> bool {
    let words = LEFT.into_iter().zip(RIGHT);
    let mut sides = words.chain(LETTERS).flat_map(|(left, right)| [(left, right), (right, left)]);
    sides.any(|(side, opposite)| {
        let is_end = |stem: &str| other.strip_suffix(opposite) == Some(stem);
        let is_start = |stem: &str| side.len() > 1 && other.strip_prefix(opposite) == Some(stem);
        one.strip_suffix(side).is_some_and(is_end) || one.strip_prefix(side).is_some_and(is_start)
    })
}

/// Correlation of two channels sample by sample, and the ratio of their deviations.
fn compare(one: &[f64], other: &[f64]) -> Option<(f64, f64)> {
    let pairs: Vec<(f64, f64)> = other.iter().copied().zip(one.iter().copied()).collect();
    let (slope, correlation) = fit_line(&pairs)?;
    Some((correlation, slope / correlation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::maps::map::ChannelMap;
    use crate::load::maps::plan::plan;
    use crate::load::maps::read::read;
    use crate::load::probe_of;

    /// A recording with two ailerons and two elevators; the left aileron is `left` times the right one.
    fn recorded([left_name, right_name]: [&str; 2], left: f64) -> String {
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            let (right, pitch) = (4.0 * (1.3 * t).sin() + 0.5, 2.0 * (0.9 * t).cos() - 1.0);
            format!("{t},{:.4},{right:.4},{pitch:.4},{:.4}\n", left * right, pitch + 0.2)
        };
        format!("time,{left_name},{right_name},elev_l_deg,elev_r_deg\n{}", (0..500).map(row).collect::<String>())
    }

    #[test]
    fn the_deflection_of_a_pair_is_half_the_difference_or_the_mean() {
        for (names, left) in [
            (["ail_l_deg", "ail_r_deg"], -0.8),
            (["ail_l_deg", "ail_r_deg"], 0.8),
            (["AILL [deg]", "AILR [deg]"], -0.8),
            (["Left Aileron (deg)", "Right Aileron (deg)"], -0.8),
            (["Querruder links [deg]", "Querruder rechts [deg]"], -0.8),
        ] {
            let probe = probe_of(&recorded(names, left));
            let map = guess(std::slice::from_ref(&probe));
            let read = read(&plan(&probe, &ChannelMap::parse(&map.text().unwrap()).unwrap())).unwrap();
            let of = |role: Role| read.role(role).unwrap().series.values.clone();
            let (aileron, elevator) = (of(Role::Aileron), of(Role::Elevator));
            for k in [3_u32, 100, 444] {
                let t = 0.02 * f64::from(k);
                let right = 4.0 * (1.3 * t).sin() + 0.5;
                let wanted = 0.5 * (right + left.abs() * right);
                assert!((aileron[k as usize].to_degrees() - wanted).abs() < 1e-3, "{names:?} {left}");
                let pitch = 2.0 * (0.9 * t).cos() - 0.9;
                assert!((elevator[k as usize].to_degrees() - pitch).abs() < 1e-3, "{names:?}");
            }
        }
    }

    #[test]
    fn deflections_that_do_not_move_together_are_no_pair() {
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            format!("{t},{:.4},{:.4}\n", 4.0 * (1.3 * t).sin(), 4.0 * (2.9 * t).cos())
        };
        let text = format!("time,ail_l_deg,ail_r_deg\n{}", (0..500).map(row).collect::<String>());
        let map = guess(&[probe_of(&text)]);
        assert!(map.row(Role::Aileron).is_some_and(|row| row.other_side.is_none()));
    }
}
