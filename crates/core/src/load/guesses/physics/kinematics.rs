//! Hypotheses of attitude and rates: triples of angles whose change, by Euler's kinematics, makes the rates that others record.

use super::coarse;
use super::fit::{line, snap};
use super::windows::{Column, Windows};

/// Units of angles and rates with radians in each.
pub const ANGLES: [(&str, f64); 2] = [("rad", 1.0), ("deg", 57.295_779_513_082_32)];
pub const RATES: [(&str, f64); 2] = [("rad/s", 1.0), ("deg/s", 57.295_779_513_082_32)];
/// Largest magnitudes of angles in radians and degrees.
const LARGEST_RAD: f64 = 6.4;
const LARGEST_DEG: f64 = 361.0;
/// Largest rate in rad/s.
const LARGEST_RATE: f64 = 12.0;
/// Largest ratio of the slope of one triple to that of its unit, either way.
pub const RATIO: f64 = 1.25;
/// Least squared correlation of a seed and of a rate with the one that the attitude makes.
const SEED_R2: f64 = 0.15;
const RATE_R2: f64 = 0.8;
/// Least squared correlation of rates with the plain change of bank and pitch where no heading is recorded.
const PLAIN_R2: [f64; 2] = [0.3, 0.1];
/// Factors between units of one quantity: of angles, speeds, lengths, accelerations and pressures.
const FACTORS: [((), f64); 15] = [
    ((), 1.0),
    ((), ANGLES[1].1),
    ((), 1.0 / ANGLES[1].1),
    ((), 3.280_84),
    ((), 0.3048),
    ((), 1.943_844),
    ((), 0.514_444),
    ((), 3.6),
    ((), 1.0 / 3.6),
    ((), 9.806_65),
    ((), 1.0 / 9.806_65),
    ((), 1000.0),
    ((), 1e-3),
    ((), 100.0),
    ((), 0.01),
];
/// Largest relative difference of the levels of two records of one quantity.
const LEVEL: f64 = 0.01;
/// Squared correlation from which two channels are one.
const COPY_R2: f64 = 0.999_99;
/// Most seeds and hypotheses.
const MOST_SEEDS: usize = 30;
/// Squared correlation and ratio of a channel that is the derivative of another in a simulation: hardly an angle and its rate.
const DERIVATIVE_R2: f64 = 0.999_95;
const DERIVATIVE_RATIO: f64 = 1.002;
/// Columns whose neighbours are looked at too.
const MOST_WITH_NEIGHBOURS: usize = 12;
const MOST_PARTNERS: usize = 5;
const MOST_RATES: usize = 40;
const MOST_TRIPLES: usize = 24;
const MOST_HYPOTHESES: usize = 5;
/// Score of a hypothesis that needs no other kind, and how far below the best one may be.
const LEAST_SCORE: f64 = 60.0;
/// Least score of a hypothesis without a heading.
const LEAST_PLAIN: f64 = 300.0;
const SPREAD: f64 = 30.0;
/// Least score of a hypothesis at all.
const LEAST_AT_ALL: f64 = 70.0;
/// Most that turning the axes may take from the likelihood of a rate: more is of a channel that is the derivative of another.
const MOST_LOSS: f64 = 25.0;
/// Largest means of bank and pitch, rad.
const MEAN_BANK: f64 = 0.9;
const MEAN_PITCH: f64 = 0.7;
/// Largest noise that one more decimal of fit is worth, as a part of the variance.
pub const FLOOR: f64 = 1e-5;
/// Cost of a turned sign, as the logarithm of its odds.
pub const TURNED: f64 = 6.0;
/// Weight of a fit that the plain change of the angle gives as well.
const PLAIN: f64 = 0.3;
/// Least squared correlation of a yaw rate with the bank where no heading is recorded.
const TURNING_R2: f64 = 0.3;
/// Squared correlation of a channel with the change of another that leaves no room for the turning of an aircraft.
const SAME_R2: f64 = 0.999_5;
/// Cost of a yaw rate in the place of a heading.
const NO_HEADING: f64 = 20.0;

/// A channel with its unit and sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    pub column: usize,
    pub unit: &'static str,
    /// Value in SI of one as recorded, with its sign.
    pub factor: f64,
    pub r2: f64,
}

/// Attitude and rates that fit each other.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Bank, pitch, heading.
    pub angles: [Option<Taken>; 3],
    /// Roll, pitch, yaw rate.
    pub rates: [Option<Taken>; 3],
    pub score: f64,
}

impl Motion {
    /// The same in axes of the body turned by half a turn about x.
    pub fn about_x(&self) -> Self {
        let turn = |taken: Option<Taken>| taken.map(|taken| Taken { factor: -taken.factor, ..taken });
        let [phi, theta, psi] = self.angles;
        let [p, q, r] = self.rates;
        Self { angles: [phi, turn(theta), turn(psi)], rates: [p, turn(q), turn(r)], score: self.score }
    }

    /// Rates of the body that the attitude makes, rad/s.
    pub fn body_rates(&self, windows: &Windows) -> [Vec<f64>; 3] {
        let pair = |taken: Taken| (taken.column, taken.factor);
        let yawing = self.rates[2].filter(|_| self.angles[2].is_none()).map(pair);
        body_rates(windows, self.angles.map(|angle| angle.map(pair)), yawing)
    }
}

/// Logarithm of the likelihood that a slope is that of a unit, against any within the ratio that is looked at: the slope of noisy channels
/// is taken between that of either on the other.
pub fn slope_likelihood(slope: f64, factor: f64, r2: f64) -> f64 {
    /// Calibration error of a rate, and the part of the noise that the slope may be wrong by.
    const ERROR: f64 = 0.02;
    const OF_NOISE: f64 = 0.6;
    let apart = (slope.abs() / factor / r2.max(0.1).sqrt()).ln();
    let sigma = ERROR + OF_NOISE * (1.0 - r2);
    (2.0 * RATIO.ln() / (sigma * std::f64::consts::TAU.sqrt())).ln() - 0.5 * (apart / sigma).powi(2)
}

/// Logarithm of the likelihood of a fit over a number of independent windows.
pub fn log_likelihood(r2: f64, independent: f64) -> f64 {
    -0.5 * independent.clamp(10.0, 120.0) * (1.0 - r2 + FLOOR).ln()
}

/// What the turning of the axes explains beyond the plain change of each angle: nothing of a channel that is the derivative of another.
fn coupling(windows: &Windows, angles: [Option<(usize, f64)>; 3], rates: &[Option<Taken>; 3]) -> Option<f64> {
    let pairs = angles.iter().zip(rates).filter_map(|(angle, rate)| Some(((*angle)?, (*rate)?)));
    let gain = |((angle, _), rate): ((usize, f64), Taken)| {
        let (_, plain) = line(&windows.columns[rate.column].mean, &windows.columns[angle].slope)?;
        Some(log_likelihood(rate.r2, windows.independent) - log_likelihood(plain, windows.independent))
    };
    let gains: Vec<f64> = pairs.filter_map(gain).collect();
    gains.iter().all(|gain| *gain > -MOST_LOSS).then(|| gains.iter().sum())
}

/// Whether a column can be an angle.
fn is_angle(column: &Column) -> bool {
    column.varies() && (column.largest <= LARGEST_DEG || column.turn.is_some())
}

/// Columns that are an earlier one, or one in another unit.
pub fn find_copies(windows: &Windows) -> Vec<Option<usize>> {
    let columns = &windows.columns;
    let is_copy = |i: usize, j: usize| {
        columns[i].varies()
            && columns[j].varies()
            && line(&columns[i].slope, &columns[j].slope).is_some_and(|(slope, r2)| {
                let level = columns[i].range[1] / columns[j].range[1];
                r2 > COPY_R2 && (level / slope - 1.0).abs() < LEVEL && snap(slope, &FACTORS, 1.0 + LEVEL).is_some()
            })
    };
    let mut copies: Vec<Option<usize>> = Vec::with_capacity(columns.len());
    for i in 0..columns.len() {
        let first = (0..i).find(|&j| copies[j].is_none() && is_copy(i, j));
        copies.push(first);
    }
    copies
}

/// Columns that may be angles, and those that may be rates, the likeliest first.
fn seeds(windows: &Windows, free: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let columns = &windows.columns;
    let ratios = [((), 1.0), ((), ANGLES[1].1), ((), 1.0 / ANGLES[1].1)];
    let pair = |i: usize, j: usize| {
        let (slope, r2) = line(&columns[j].mean, &columns[i].slope)?;
        // Slope of the rate on the angle's change, which turning makes smaller.
        snap(slope, &ratios, 2.0).or_else(|| snap(slope / r2.max(0.3), &ratios, 2.0))?;
        let is_derivative = r2 > DERIVATIVE_R2 && snap(slope, &ratios, DERIVATIVE_RATIO).is_some();
        // A derivative that nothing turns comes last.
        (r2 > SEED_R2).then_some(if is_derivative { 0.5 * SEED_R2 } else { r2 })
    };
    let mut angles: Vec<(usize, f64)> = Vec::new();
    let mut rates: Vec<(usize, f64)> = Vec::new();
    for &i in free.iter().filter(|i| is_angle(&columns[**i])) {
        let mut partners: Vec<(usize, f64)> =
            free.iter().filter(|j| **j != i).filter_map(|&j| Some((j, pair(i, j)?))).collect();
        partners.sort_by(|a, b| b.1.total_cmp(&a.1));
        partners.truncate(MOST_PARTNERS);
        let is_wrapped = columns[i].turn.is_some();
        if let Some(best) = partners.first().map(|partner| partner.1).or(is_wrapped.then_some(0.0)) {
            angles.push((i, best + if is_wrapped { 1.0 } else { 0.0 }));
        }
        for (j, r2) in partners {
            match rates.iter_mut().find(|rate| rate.0 == j) {
                Some(rate) => rate.1 = rate.1.max(r2),
                None => rates.push((j, r2)),
            }
        }
    }
    let likeliest = |mut all: Vec<(usize, f64)>, most: usize| -> Vec<usize> {
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.into_iter().map(|(i, _)| i).take(most).collect()
    };
    let is_free = |i: &usize| free.contains(i);
    let angles =
        with_neighbours(&likeliest(angles, MOST_SEEDS), MOST_WITH_NEIGHBOURS, |i| is_free(&i) && is_angle(&columns[i]));
    let rates = with_neighbours(&likeliest(rates, MOST_RATES), MOST_RATES / 2, |i| is_free(&i));
    (angles, rates)
}

/// Columns with those that stand beside the first of them: channels of one vector are recorded side by side.
fn with_neighbours(likeliest: &[usize], most: usize, can_be: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut all = likeliest.to_vec();
    for &i in likeliest.iter().take(most) {
        for j in i.saturating_sub(2)..=i + 2 {
            if !all.contains(&j) && can_be(j) {
                all.push(j);
            }
        }
    }
    all
}

/// Rates of the body that angles in SI and their changes make; without a heading that of no turn.
fn body_rates(windows: &Windows, angles: [Option<(usize, f64)>; 3], yawing: Option<(usize, f64)>) -> [Vec<f64>; 3] {
    let at = |angle: Option<(usize, f64)>, k: usize| {
        angle.map_or((0.0, 0.0), |(i, factor)| {
            (factor * windows.columns[i].mean[k], factor * windows.columns[i].slope[k])
        })
    };
    let mut rates: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(windows.count));
    for k in 0..windows.count {
        let [(phi, roll), (theta, pitch), (_, yaw)] = angles.map(|angle| at(angle, k));
        let ((sp, cp), (st, ct)) = (phi.sin_cos(), theta.sin_cos());
        let yaw = yawing.map_or(yaw, |(i, factor)| (factor * windows.columns[i].mean[k] + pitch * sp) / (cp * ct));
        rates[0].push(roll - yaw * st);
        rates[1].push(pitch * cp + yaw * sp * ct);
        rates[2].push(yaw * cp * ct - pitch * sp);
    }
    rates
}

/// The column that records a rate best.
fn find_rate(
    windows: &Windows,
    wanted: &[f64],
    among: &[usize],
    angles: [Option<usize>; 3],
    unit: Option<&'static str>,
) -> Option<(Taken, f64)> {
    let fits = |&j: &usize| {
        let (slope, r2) = line(&windows.columns[j].mean, wanted)?;
        let name = snap(slope, &RATES, RATIO).filter(|name| unit.is_none_or(|unit| unit == *name))?;
        let scale = RATES.iter().find(|(other, _)| *other == name)?.1;
        let is_possible = windows.columns[j].largest / scale < LARGEST_RATE;
        let likelihood = slope_likelihood(slope, scale, r2);
        let taken = Taken { column: j, unit: name, factor: slope.signum() / scale, r2 };
        (is_possible && r2 > RATE_R2).then_some((taken, likelihood))
    };
    among.iter().filter(|j| !angles.contains(&Some(**j))).filter_map(fits).max_by(|a, b| a.0.r2.total_cmp(&b.0.r2))
}

/// Bank, pitch and heading, or the yaw rate in the place of a heading.
type Triple = ([Option<usize>; 3], Option<usize>);

/// The least squared correlation of rates.
fn found_least(rates: &[Option<Taken>; 3]) -> f64 {
    rates.iter().flatten().map(|rate| rate.r2).fold(1.0, f64::min)
}

/// The motion of a triple of angles in one unit.
fn motion(
    windows: &Windows,
    (triple, yawing): Triple,
    unit: usize,
    signs: [f64; 3],
    among: &[usize],
) -> Option<Motion> {
    let (name, scale) = ANGLES[unit];
    let scaled: [Option<(usize, f64)>; 3] = std::array::from_fn(|i| triple[i].map(|column| (column, signs[i] / scale)));
    // A yaw rate in the place of a heading shares the unit of the angles: what cannot be said of it by itself.
    let yaw = yawing.map(|column| Taken { column, unit: RATES[unit].0, factor: 1.0 / scale, r2: 0.0 });
    let wanted = body_rates(windows, scaled, yaw.map(|taken| (taken.column, taken.factor)));
    let mut found: [Option<(Taken, f64)>; 3] = std::array::from_fn(|i| match yaw {
        Some(_) if i == 2 => None,
        Some(yaw) => find_rate(windows, &wanted[i], among, triple, Some(yaw.unit)),
        None => find_rate(windows, &wanted[i], among, triple, None),
    });
    let best = found.iter().flatten().max_by(|a, b| a.0.r2.total_cmp(&b.0.r2))?;
    // Rates of one recorder share their unit.
    let first = best.0.unit;
    for i in 0..3 {
        if found[i].is_some_and(|(rate, _)| rate.unit != first) {
            found[i] = find_rate(windows, &wanted[i], among, triple, Some(first));
        }
    }
    let slopes: f64 = found.iter().flatten().map(|(_, likelihood)| likelihood).sum();
    let mut rates = found.map(|found| found.map(|(rate, _)| rate));
    if let Some(yaw) = yaw {
        rates[2] = Some(Taken { r2: found_least(&rates), ..yaw });
    }
    for i in 0..3 {
        for j in 0..i {
            if let (Some(a), Some(b)) = (rates[i], rates[j])
                && a.column == b.column
            {
                let worse = if a.r2 < b.r2 { i } else { j };
                rates[worse] = None;
            }
        }
    }
    let score: f64 = rates
        .iter()
        .flatten()
        .map(|rate| PLAIN * log_likelihood(rate.r2, windows.independent) - if rate.factor < 0.0 { TURNED } else { 0.0 })
        .sum();
    let score = score + slopes + coupling(windows, scaled, &rates)?;
    let flips = signs.iter().filter(|sign| **sign < 0.0).count() as f64;
    let angles = std::array::from_fn(|i| {
        scaled[i].map(|(column, factor)| Taken { column, unit: name, factor, r2: rates[i].map_or(0.0, |rate| rate.r2) })
    });
    let cost = TURNED * flips + if yaw.is_some() { NO_HEADING } else { 0.0 };
    (rates.iter().flatten().count() == 3).then_some(Motion { angles, rates, score: score - cost })
}

/// Columns that may be the yaw rate of a bank where no heading is recorded: those most like it.
fn turning(windows: &Windows, phi: usize) -> Vec<usize> {
    let others = (0..windows.columns.len()).filter(|i| *i != phi && windows.columns[*i].varies());
    let r2 = |i: usize| Some((i, line(&windows.columns[i].mean, &windows.columns[phi].mean)?.1));
    let mut all: Vec<(usize, f64)> = others.filter_map(r2).filter(|(_, r2)| *r2 > TURNING_R2).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.into_iter().map(|(i, _)| i).take(5).collect()
}

/// The best hypotheses of attitude and rates.
pub fn hypotheses(windows: &Windows) -> Vec<Motion> {
    let copies = &windows.copies;
    let free: Vec<usize> =
        (0..windows.columns.len()).filter(|i| windows.columns[*i].varies() && copies[*i].is_none()).collect();
    let (angles, rates) = seeds(windows, &free);
    let fits = |unit: usize, i: usize| {
        let limit = if unit == 0 { LARGEST_RAD } else { LARGEST_DEG };
        let column = &windows.columns[i];
        column.turn.map_or(column.largest <= limit, |turn| (turn > 7.0) == (unit == 1))
    };
    let of_unit = [0, 1].map(|unit| angles.iter().copied().filter(|i| fits(unit, *i)).collect::<Vec<usize>>());
    let is_within = |i: usize, unit: usize, limit: f64| {
        let finite = windows.columns[i].mean.iter().filter(|value| value.is_finite());
        let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        (sum / count / ANGLES[unit].1).abs() < limit
    };
    let can_bank = |i: usize, unit: usize| is_within(i, unit, MEAN_BANK);
    let can_pitch = |i: usize, unit: usize| windows.columns[i].turn.is_none() && is_within(i, unit, MEAN_PITCH);
    let triples = coarse::triples(
        windows,
        of_unit.each_ref().map(|all| all.as_slice()),
        &rates,
        [&can_bank, &can_pitch],
        MOST_TRIPLES,
    );
    let signs = [[1.0, 1.0, 1.0], [1.0, 1.0, -1.0]];
    // Of the eight choices of sign these two are different: the others are mirror images.
    let refine = |triple: &coarse::Triple| {
        let columns = triple.columns.map(Some);
        signs.map(|signs| motion(windows, (columns, None), triple.unit, signs, &free))
    };
    let mut refined: Vec<Motion> = triples.iter().flat_map(refine).flatten().collect();
    let best = |all: &[Motion]| all.iter().map(|motion| motion.score).fold(f64::NEG_INFINITY, f64::max);
    if best(&refined) < LEAST_SCORE {
        refined.extend(without_heading(windows, &of_unit, &free));
    }
    refined.sort_by(|a, b| b.score.total_cmp(&a.score));
    let least = refined.first().map_or(0.0, |motion| motion.score - SPREAD);
    refined.retain(|motion| motion.score > least.max(LEAST_AT_ALL));
    refined.truncate(MOST_HYPOTHESES);
    if let Some(best) = refined.first_mut() {
        *best = exchange(windows, best.clone(), &rates, &free);
    }
    refined
}

/// The best hypothesis with any other angle in the place of one that fits better: those that were not likely enough at the start.
fn exchange(windows: &Windows, motion: Motion, rates: &[usize], free: &[usize]) -> Motion {
    let [Some(phi), Some(theta), Some(psi)] = motion.angles else { return motion };
    let Some(unit) = ANGLES.iter().position(|(name, _)| *name == phi.unit) else { return motion };
    let limit = if unit == 0 { LARGEST_RAD } else { LARGEST_DEG };
    let signs = [phi, theta, psi].map(|angle| angle.factor.signum());
    let among: Vec<usize> =
        rates.iter().copied().chain(motion.rates.iter().flatten().map(|rate| rate.column)).collect();
    let mut best = motion;
    for axis in 0..2 {
        for &other in free.iter().filter(|i| is_angle(&windows.columns[**i]) && windows.columns[**i].largest <= limit) {
            let mut columns = best.angles.map(|angle| angle.map(|angle| angle.column));
            if columns.contains(&Some(other)) {
                continue;
            }
            columns[axis] = Some(other);
            if let Some(found) =
                self::motion(windows, (columns, None), unit, signs, &among).filter(|m| m.score > best.score)
            {
                best = found;
            }
        }
    }
    best
}

/// Whether roll and pitch rate are the change of bank and pitch for the most part.
fn is_plain(windows: &Windows, motion: &Motion) -> bool {
    motion.score > LEAST_PLAIN
        && (0..2).all(|axis| {
            motion.rates[axis].zip(motion.angles[axis]).is_some_and(|(rate, angle)| {
                line(&windows.columns[rate.column].mean, &windows.columns[angle.column].slope)
                    .is_some_and(|(_, r2)| r2 > PLAIN_R2[axis] && r2 < SAME_R2)
            })
        })
}

/// Hypotheses with a yaw rate in the place of a heading.
fn without_heading(windows: &Windows, of_unit: &[Vec<usize>; 2], free: &[usize]) -> Vec<Motion> {
    let mut all = Vec::new();
    for (unit, angles) in of_unit.iter().enumerate() {
        let angles = &angles[..angles.len().min(MOST_SEEDS / 2)];
        for &phi in angles {
            let turning = turning(windows, phi);
            for theta in angles.iter().copied().filter(|i| *i != phi && windows.columns[*i].turn.is_none()) {
                let yawing = turning.iter().filter(|i| **i != theta);
                let triples = yawing.map(|yaw| ([Some(phi), Some(theta), None], Some(*yaw)));
                let found = triples.filter_map(|triple| motion(windows, triple, unit, [1.0; 3], free));
                all.extend(found.filter(|motion| is_plain(windows, motion)));
            }
        }
    }
    all
}
