//! Which of several channels of one quantity is the record of it: processing puts what it derives behind what was recorded, and the
//! components of a vector stand side by side.

use super::Found;
use super::fit::line;
use super::windows::Windows;
use crate::quantity::Role;

/// Vectors whose components stand side by side.
const VECTORS: [[Role; 3]; 3] = [
    [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown],
    [Role::RollRate, Role::PitchRate, Role::YawRate],
    [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle],
];
/// Least R2 of two channels of one quantity: of two components of a vector, and of the third.
const ALIKE_R2: f64 = 0.99;
const THIRD_R2: f64 = 0.85;
/// Slopes of one such channel over the other.
const SLOPES: std::ops::Range<f64> = 0.9..1.1;

/// Gives the components of a vector the earliest columns, side by side, that record the same quantities as those found.
pub fn prefer_recorded(found: &mut [Found], windows: &Windows) {
    for vector in VECTORS {
        let places = vector.map(|role| found.iter().position(|one| one.role == role));
        let Some(first) = (0..windows.columns.len()).find(|first| is_record(found, windows, *first, places)) else {
            continue;
        };
        for (column, place) in (first..).zip(places) {
            if let Some(one) = place.map(|place| &mut found[place]).filter(|one| one.column != column) {
                one.runner_up = Some((one.column, "follows the recorded channel".to_owned()));
                one.column = column;
            }
        }
    }
}

/// Whether columns side by side record what was found at these places.
fn is_record(found: &[Found], windows: &Windows, first: usize, places: [Option<usize>; 3]) -> bool {
    let (mut alike, mut all) = (0, true);
    for (column, place) in (first..).zip(places) {
        let Some(place) = place else { continue };
        let r2 = r2_of_alike(windows, column, found[place].column);
        let is_other = found.iter().enumerate().any(|(at, one)| one.column == column && at != place);
        all &= r2 > THIRD_R2 && !is_other;
        alike += usize::from(r2 > ALIKE_R2);
    }
    all && alike >= 2
}

/// R2 of two channels that record one quantity in one unit; zero of others.
fn r2_of_alike(windows: &Windows, first: usize, second: usize) -> f64 {
    let columns = [first, second].map(|at| windows.columns.get(at).filter(|column| column.varies()));
    let [Some(first), Some(second)] = columns else { return 0.0 };
    line(&first.mean, &second.mean).filter(|(slope, _)| SLOPES.contains(slope)).map_or(0.0, |(_, r2)| r2)
}

#[cfg(test)]
mod tests {
    use super::super::windows::Column;
    use super::*;

    /// Windows whose last three columns are smooth velocities, and what was found of them.
    fn derived(recorded: [f64; 3]) -> (Windows, Vec<Found>) {
        let smooth = |axis: usize, k: usize| (0.1 * k as f64 + axis as f64).sin() * 10.0;
        let noise = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let column = |axis: usize, part: f64| Column {
            mean: (0..100).map(|k| smooth(axis, k) + part * noise(k)).collect(),
            ..Column::default()
        };
        let columns = recorded.into_iter().chain([0.0; 3]).enumerate().map(|(at, part)| column(at % 3, part)).collect();
        let found = |(at, role): (usize, Role)| Found {
            role,
            column: 3 + at,
            unit: Some("m/s"),
            turned: false,
            offset: 0.0,
            evidence: String::new(),
            share: 1.0,
            runner_up: None,
        };
        (Windows { columns, ..Windows::default() }, VECTORS[0].into_iter().enumerate().map(found).collect())
    }

    #[test]
    fn velocity_that_was_recorded_comes_before_one_that_was_derived() {
        let (windows, mut found) = derived([0.1, 0.2, 2.0]);
        prefer_recorded(&mut found, &windows);
        assert_eq!(found.iter().map(|one| one.column).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(found[0].runner_up.as_ref().map(|(column, _)| *column), Some(3));
        // One component alone may be alike by chance.
        let (windows, mut found) = derived([0.1, 5.0, 5.0]);
        prefer_recorded(&mut found, &windows);
        assert_eq!(found.iter().map(|one| one.column).collect::<Vec<_>>(), [3, 4, 5]);
    }
}
