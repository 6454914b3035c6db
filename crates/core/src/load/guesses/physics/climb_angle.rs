//! Height, airspeed and flow angles together, where nothing else shows an airspeed: `h_dot / V = cos(alpha) cos(beta) sin(theta) - (sin(beta)
//! sin(phi) + sin(alpha) cos(beta) cos(phi)) cos(theta)` (Stevens and Lewis, Aircraft Control and Simulation, section 3.6).

use super::air::{self, average_by, can_be_flow};
use super::air_data::average;
use super::assignment::Assignment;
use super::fit::line;
use super::kinematics::{ANGLES, Taken};
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;

/// Most channels of a recording that is searched so.
const MOST_COLUMNS: usize = 60;
/// Pairs of units of height and speed, with how many of each make one of SI.
const UNITS: [(&str, f64, &str, f64); 6] = [
    ("m", 1.0, "m/s", 1.0),
    ("ft", 3.280_84, "ft/s", 3.280_84),
    ("ft", 3.280_84, "m/s", 1.0),
    ("m", 1.0, "kt", 1.943_844),
    ("ft", 3.280_84, "kt", 1.943_844),
    ("m", 1.0, "km/h", 3.6),
];
/// Largest ratio of a slope to that of the units, either way, and largest offset of the sine of the climb angle.
const RATIO: f64 = 1.02;
const OFFSET: f64 = 0.01;
/// Least squared correlation of a triple worth a sideslip, and of all together; how many triples are.
const TRIPLE_R2: f64 = 0.5;
const LEAST_R2: f64 = 0.99;
const MOST_TRIPLES: usize = 24;
/// Largest ratio of the turn of the flight path to that of the bank, either way.
const TURN_RATIO: f64 = 3.0;
/// Heights that are flown at, as recorded, and largest flow angle, rad.
const HEIGHTS: std::ops::Range<f64> = -500.0..80_000.0;
const LARGEST_FLOW: f64 = 1.3;

/// Columns of a height and an airspeed with flow angles.
#[derive(Clone, Copy)]
struct Found {
    height: usize,
    speed: usize,
    alpha: (usize, &'static str, f64),
    beta: Option<(usize, &'static str, f64)>,
    slope: f64,
    r2: f64,
}

/// Sine of the climb angle by attitude and flow angles.
fn climb_angle_sine(whole: &Assignment<'_>, alpha: (usize, &str, f64), beta: Option<(usize, &str, f64)>) -> Vec<f64> {
    let angle = |(column, _, size): (usize, &str, f64), k: usize| whole.column(column).mean[k] / size;
    whole.each(|k| {
        let ((sa, ca), (sb, cb)) = (angle(alpha, k).sin_cos(), beta.map_or(0.0, |beta| angle(beta, k)).sin_cos());
        let ((sp, cp), (st, ct)) = (whole.phi[k].sin_cos(), whole.theta[k].sin_cos());
        ca * cb * st - (sb * sp + sa * cb * cp) * ct
    })
}

/// Finds them where the airspeed is open.
pub fn complete(whole: &mut Assignment<'_>) {
    let free = whole.free();
    if whole.airspeed.is_some() || whole.alpha.is_some() || free.len() > MOST_COLUMNS {
        return;
    }
    let angles: Vec<(usize, &'static str, f64)> = free
        .iter()
        .filter(|i| can_be_flow(whole, **i))
        .flat_map(|i| ANGLES.map(|(unit, size)| (*i, unit, size)))
        .filter(|(i, _, size)| whole.column(*i).largest / size < LARGEST_FLOW)
        .collect();
    let sines: Vec<Vec<f64>> = angles.iter().map(|angle| climb_angle_sine(whole, *angle, None)).collect();
    let mut triples: Vec<Found> = Vec::new();
    for &speed in free.iter().filter(|i| air::can_be_speed(whole, **i)) {
        for &height in free.iter().filter(|i| **i != speed) {
            let (of_speed, of_height) = (whole.column(speed), whole.column(height));
            if !of_height.range.iter().all(|value| HEIGHTS.contains(value)) {
                continue;
            }
            let climb = whole.each(|k| of_height.slope[k] / of_speed.mean[k]);
            for (alpha, sine) in angles.iter().zip(&sines).filter(|(alpha, _)| ![speed, height].contains(&alpha.0)) {
                let Some((slope, r2)) = line(&climb, sine).filter(|(_, r2)| *r2 > TRIPLE_R2) else { continue };
                triples.push(Found { height, speed, alpha: *alpha, beta: None, slope, r2 });
            }
        }
    }
    triples.sort_by(|a, b| b.r2.total_cmp(&a.r2));
    triples.truncate(MOST_TRIPLES);
    let with_sideslip: Vec<Found> = triples.iter().flat_map(|triple| with_sideslip(whole, *triple, &angles)).collect();
    triples.extend(with_sideslip);
    triples.sort_by(|a, b| b.r2.total_cmp(&a.r2));
    let best =
        triples.iter().filter(|found| found.r2 > LEAST_R2).find_map(|found| Some((*found, units(whole, found)?)));
    if let Some((found, units)) = best {
        take(whole, &found, units);
    }
}

/// A triple with each sideslip that makes it fit better.
fn with_sideslip(whole: &Assignment<'_>, triple: Found, angles: &[(usize, &'static str, f64)]) -> Vec<Found> {
    let climb = whole.each(|k| whole.column(triple.height).slope[k] / whole.column(triple.speed).mean[k]);
    let others = angles.iter().filter(|beta| ![triple.height, triple.speed, triple.alpha.0].contains(&beta.0));
    let fits = |beta: &(usize, &'static str, f64)| {
        let (slope, r2) = line(&climb, &climb_angle_sine(whole, triple.alpha, Some(*beta)))?;
        (1.0 - r2 < 0.5 * (1.0 - triple.r2)).then_some(Found { beta: Some(*beta), slope, r2, ..triple })
    };
    others.filter_map(fits).collect()
}

/// Units of height and speed by their ratio, and by the turn that the bank makes: `V (r - p alpha) = g cos(theta) sin(phi)`.
fn units(whole: &Assignment<'_>, found: &Found) -> Option<(&'static str, f64, &'static str, f64)> {
    let sine = climb_angle_sine(whole, found.alpha, found.beta);
    let speed = &whole.column(found.speed).mean;
    let climb = whole.each(|k| whole.column(found.height).slope[k] / speed[k]);
    if (average(&climb) - found.slope * average(&sine)).abs() > OFFSET * found.slope {
        return None;
    }
    let (column, _, size) = found.alpha;
    let bank = whole.each(|k| STANDARD_GRAVITY_M_S2 * whole.theta[k].cos() * whole.phi[k].sin());
    let turn = whole.each(|k| speed[k] * (whole.r[k] - whole.p[k] * whole.column(column).mean[k] / size));
    let product: Vec<f64> = bank.iter().zip(&turn).map(|(a, b)| a * b).collect();
    let ratio = average(&product) / average_by(&bank, |bank| bank * bank);
    let apart = |scale: f64| (ratio / scale).ln().abs();
    let fits = |unit: &(&str, f64, &str, f64)| (found.slope / (unit.1 / unit.3)).ln().abs() < RATIO.ln();
    let all = UNITS.into_iter().filter(fits).filter(|unit| apart(unit.3) < TURN_RATIO.ln());
    all.min_by(|a, b| apart(a.3).total_cmp(&apart(b.3)))
}

/// Gives the roles.
fn take(
    whole: &mut Assignment<'_>,
    found: &Found,
    (length, high, velocity, fast): (&'static str, f64, &'static str, f64),
) {
    let taken = |column: usize, unit: &'static str, size: f64| Taken { column, unit, factor: 1.0 / size, r2: found.r2 };
    let relation = "the climb angle of airspeed, attitude and flow angles";
    let height = taken(found.height, length, high);
    whole.height = Some([whole.mean_of(height), whole.slope_of(height)]);
    whole.take(Role::Altitude, height, relation);
    air::take_speed(whole, taken(found.speed, velocity, fast), relation);
    let alpha = taken(found.alpha.0, found.alpha.1, found.alpha.2);
    whole.alpha = Some([whole.mean_of(alpha), whole.slope_of(alpha)]);
    whole.take(Role::AngleOfAttack, alpha, relation);
    if let Some((column, unit, size)) = found.beta {
        let beta = taken(column, unit, size);
        whole.beta = Some([whole.mean_of(beta), whole.slope_of(beta)]);
        whole.take(Role::Sideslip, beta, relation);
    }
}
