//! Rates and attitude of one segment, integrated for the kinematic relation.

use nalgebra::SVector;

use super::{ANGLES, LARGEST_DELAY_S, RATES, Row, TERMS, UNKNOWNS};
use crate::compatibility::motion::Motion;
use crate::prep::{between_samples, stretches, unwrapped, white_noise_deviation};
use crate::quantity::Role;
use crate::series::{Recording, Series, TimeRange};
use crate::statistics::median_step;

/// Lag over which angles change, s, and the longest one of an attitude that is recorded less often.
const LAG_S: f64 = 0.6;
const LONGEST_LAG_S: f64 = 2.5;
/// Times this near to each other are the same, s.
const TOLERANCE_S: f64 = 1e-6;
/// Rates are averaged over at least this, s; slower than the second they are not integrated.
const FINEST_STEP_S: f64 = 0.02;
const COARSEST_STEP_S: f64 = 0.11;
/// Pitch angle beyond which Euler angles are near their singularity, rad.
const STEEPEST_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// Longest flight that is used as a whole, s; of a longer one the segments that move most.
const LONGEST_FLIGHT_S: f64 = 900.0;
/// Rows that share their errors, s.
const BLOCK_S: f64 = 10.0;

/// Regressors `E_i w` and `E_i` of each angle `i` at one instant.
type Terms = [SVector<f64, TERMS>; 3];

/// Rates and attitudes of one segment.
pub(super) struct Segment {
    time_s: Vec<f64>,
    rates: Vec<[f64; 3]>,
    /// Variance of the noise of the rates times their step, rad²/s.
    noise: [f64; 3],
    angles: [Series; 3],
    max_gap_s: Option<f64>,
}

impl Segment {
    pub(super) fn of_motion(recording: &Recording, motion: &Motion) -> Option<Vec<Self>> {
        let find = |role: Role| recording.role(role).map(|channel| channel.series.finite());
        let [p, q, r] = RATES.map(find);
        let rates = [p?, q?, r?];
        let [phi, theta, psi] = ANGLES.map(find);
        let angles = [phi?, theta?, psi?];
        let step_s = median_step(&rates[0].time_s).filter(|step_s| *step_s > 0.0 && *step_s < COARSEST_STEP_S)?;
        let deviation = |rate: &Series| white_noise_deviation(rate, false).unwrap_or(0.0);
        let noise = [0, 1, 2].map(|axis| step_s * deviation(&rates[axis]).powi(2));
        let one = |range: &std::ops::Range<usize>| {
            let times = motion.time_s.get(range.clone())?;
            Self::new(&rates, &angles, (*times.first()?, *times.last()?), (step_s, noise, recording.max_gap_s))
        };
        match motion.time_s.len() as f64 * motion.step_s > LONGEST_FLIGHT_S {
            true => Some(motion.segments.iter().filter_map(one).collect()),
            false => Some(stretches(&motion.time_s, 1.5 * motion.step_s).iter().filter_map(one).collect()),
        }
    }

    fn new(
        rates: &[Series; 3],
        angles: &[Series; 3],
        (start_s, end_s): (f64, f64),
        (step_s, noise, max_gap_s): (f64, [f64; 3], Option<f64>),
    ) -> Option<Self> {
        let cut = |series: &Series, spare_s: f64| {
            let range = TimeRange { start_s: start_s - spare_s, end_s: end_s + spare_s }.indices(&series.time_s);
            Series { time_s: series.time_s[range.clone()].into(), values: series.values[range].into() }
        };
        let times = cut(&rates[0], 0.0).time_s;
        let [p, q, r] = [0, 1, 2].map(|axis| between_samples(&cut(&rates[axis], 1.0), &times, max_gap_s, false));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few samples of one step")]
        let size = ((FINEST_STEP_S / step_s + TOLERANCE_S) as usize).max(1);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let bins = (0..times.len() / size).map(|bin| bin * size..(bin + 1) * size);
        let (time_s, rates) =
            bins.map(|bin| (mean(&times[bin.clone()]), [&p, &q, &r].map(|rate| mean(&rate[bin.clone()])))).unzip();
        let angles = angles.each_ref().map(|angle| {
            let Series { time_s, values } = cut(angle, LARGEST_DELAY_S);
            Series { time_s, values: unwrapped(&values).into() }
        });
        Some(Self { time_s, rates, noise, angles, max_gap_s }).filter(|segment| segment.time_s.len() > 3)
    }

    /// Regressors at every step with bank and pitch taken earlier; none near the singularity and in gaps.
    fn terms(&self, delay_s: [f64; 3]) -> Vec<Option<Terms>> {
        let [phi, theta] = [0, 1].map(|angle| {
            let at_s: Vec<f64> = self.time_s.iter().map(|time_s| time_s + delay_s[angle]).collect();
            between_samples(&self.angles[angle], &at_s, self.max_gap_s, false)
        });
        let angles = phi.iter().zip(&theta).zip(&self.rates);
        angles.map(|((phi, theta), rates)| Self::form_terms(*phi, *theta, rates)).collect()
    }

    fn form_terms(phi: f64, theta: f64, rates: &[f64; 3]) -> Option<Terms> {
        let is_usable = phi.is_finite() && theta.abs() < STEEPEST_RAD && rates.iter().all(|rate| rate.is_finite());
        let ((sin, cos), tan, secant) = (phi.sin_cos(), theta.tan(), 1.0 / theta.cos());
        let rows = [[1.0, tan * sin, tan * cos], [0.0, cos, -sin], [0.0, secant * sin, secant * cos]];
        let terms = |row: [f64; 3]| SVector::from_fn(|k, _| if k < 9 { row[k / 3] * rates[k % 3] } else { row[k - 9] });
        is_usable.then(|| rows.map(terms))
    }

    /// Adds the rows of every angle, between its own samples, `overlap` of them per lag.
    pub(super) fn add_rows(&self, delay_s: [f64; 3], (first_block, overlap): (usize, f64), rows: &mut Vec<Row>) {
        let terms = self.terms(delay_s);
        for (angle, (series, delay_s)) in self.angles.iter().zip(delay_s).enumerate() {
            let (integral, pauses) = self.integral(&terms, angle);
            let at = |time_s: f64| self.at(&terms, (&integral, &pauses), angle, time_s - delay_s);
            let mut next_s = f64::NEG_INFINITY;
            for (index, start_s) in series.time_s.iter().enumerate().filter(|(_, time_s)| time_s.is_finite()) {
                if *start_s < next_s {
                    continue;
                }
                let after = series.time_s.iter().skip(index).position(|end_s| *end_s > start_s + LAG_S - TOLERANCE_S);
                let Some(last) = after.map(|after| index + after) else { break };
                next_s = start_s + LAG_S / overlap - TOLERANCE_S;
                let lag_s = series.time_s[last] - start_s;
                let Some((from, to)) = at(*start_s).zip(at(series.time_s[last])).filter(|_| lag_s < LONGEST_LAG_S)
                else {
                    continue;
                };
                let mut terms = SVector::<f64, UNKNOWNS>::zeros();
                (0..TERMS).for_each(|k| terms[k] = to.0[k] - from.0[k]);
                terms[TERMS + angle] = from.1 - to.1;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "blocks of a segment")]
                let block = first_block + ((start_s - delay_s - self.time_s[0]).max(0.0) / BLOCK_S) as usize;
                let change = series.values[last] - series.values[index];
                if from.2 == to.2 {
                    rows.push(Row { angle, block, change, terms, noise: self.noise.map(|noise| noise / lag_s) });
                }
            }
        }
    }

    /// Integral of the regressors of an angle up to each step, by the trapezoid with end correction, and the pauses so far.
    fn integral(&self, terms: &[Option<Terms>], angle: usize) -> (Vec<SVector<f64, TERMS>>, Vec<usize>) {
        let at = |k: Option<usize>| terms.get(k?)?.as_ref().map(|terms| terms[angle]);
        let (mut sum, mut pauses) = (SVector::<f64, TERMS>::zeros(), 0);
        let mut found = (vec![sum], vec![0]);
        for k in 0..terms.len().saturating_sub(1) {
            let step_s = self.time_s[k + 1] - self.time_s[k];
            match at(Some(k)).zip(at(Some(k + 1))) {
                Some((one, other)) => {
                    sum += 0.5 * step_s * (one + other);
                    // Derivatives by central differences on even steps.
                    if let Some((before, after)) = at(k.checked_sub(1)).zip(at(Some(k + 2))) {
                        sum += step_s / 24.0 * (one + other - before - after);
                    }
                }
                None => pauses += 1,
            }
            found.0.push(sum);
            found.1.push(pauses);
        }
        found
    }

    /// Integral, slope of the angle (rad/s) and pauses at a time, by a cubic between two steps.
    fn at(
        &self,
        terms: &[Option<Terms>],
        (integral, pauses): (&[SVector<f64, TERMS>], &[usize]),
        angle: usize,
        time_s: f64,
    ) -> Option<(SVector<f64, TERMS>, f64, usize)> {
        let after = self.time_s.partition_point(|time| *time <= time_s).min(self.time_s.len() - 1);
        let before = after.checked_sub(1)?;
        let (one, other) = (terms[before].as_ref()?[angle], terms[after].as_ref()?[angle]);
        let step_s = self.time_s[after] - self.time_s[before];
        let part = (time_s - self.time_s[before]) / step_s;
        if !(-TOLERANCE_S..=1.0 + TOLERANCE_S).contains(&part) {
            return None;
        }
        let (square, cube) = (part * part, part * part * part);
        let sum = integral[before]
            + (integral[after] - integral[before]) * (3.0 * square - 2.0 * cube)
            + step_s * (one * (cube - 2.0 * square + part) + other * (cube - square));
        let slope = |terms: &SVector<f64, TERMS>| terms[0] + terms[4] + terms[8];
        Some((sum, slope(&one) + part * (slope(&other) - slope(&one)), pauses[after]))
    }
}
