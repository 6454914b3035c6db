//! Delay of the vane of the angle of attack in gusts, by the lift that follows it.
//!
//! The innovations of a filter determine this delay in steady air. In gusts they do not: the specific force it is driven by answers the gusts
//! it takes for independent of it, which shifts the most likely delay by some 0.02 s. Lift answers them at once, which shows the delay.

use nalgebra::{DMatrix, DVector};

use crate::prep::{Differentiation, Smoothing, differentiate, smooth};
use crate::reconstruct::data::{FilterData, MeasurementSeries};
use crate::reconstruct::model::layout::{Input, Measurement};
use crate::series::value_at;
use crate::statistics::{median_step, student_widening};

/// Half width and degree of the polynomials that smooth force and rate and give their slopes, s.
const HALF_WIDTH_S: f64 = 0.06;
const DEGREE: usize = 2;
/// Half width of the mean of the airspeed, s.
const AIRSPEED_HALF_WIDTH_S: f64 = 0.25;
/// Samples that share their errors, s, and how many such blocks there are at least.
const BLOCK_S: f64 = 2.5;
const LEAST_BLOCKS: usize = 8;
/// Steps of Gauss and Newton, and the change below which no further one is taken, s.
const STEPS: usize = 12;
const CONVERGED_S: f64 = 1e-4;
/// Largest delay looked for, s.
const LARGEST_S: f64 = 0.3;
/// Part of the motion of the vane that force and rates leave at most: beyond, the lift is another one than is assumed.
const UNEXPLAINED: f64 = 0.5;
/// Part of the slope of the vane that is none of force and rates themselves at least: in steady air these follow each other.
const OWN_SLOPE: f64 = 0.4;
/// Standard error that the lift's own lag leaves, s: it builds up over a chord or two.
const LIFT_LAG_S: f64 = 0.003;
/// Columns of the regression but the slope: specific force, rate, slope of the rate.
const TERMS: usize = 3;

/// A delay of the flow angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowDelay {
    /// Delay, s: what the time stamps are late.
    pub delay_s: f64,
    /// Its standard error, s.
    pub standard_error_s: f64,
}

/// The delay `d` of the angle of attack over windows by `alpha(t) = a_w + b f_z/V^2 + c q/V + e q'/V^2`, the terms at `t - d`, by steps of Gauss
/// and Newton. The lift is linear in the angle of attack, the pitch rate and the elevator, the latter in what remains of the pitching
/// acceleration; `a_w` is of each window. The error is that of blocks of samples.
///
/// `None` where the recording does not determine it: without vane or airspeed, where the terms do not explain the vane, and in steady air,
/// where its slope follows from the pitch rate.
pub fn estimate_flow_delay(data: &[&FilterData]) -> Option<FlowDelay> {
    let windows: Vec<Window> = data.iter().filter_map(|data| Window::new(data)).collect();
    let mut delay_s = 0.0;
    for _ in 0..STEPS {
        let equations = Equations::new(&windows, delay_s)?;
        let step_s = equations.delay_s()?;
        delay_s += step_s;
        if delay_s.is_nan() || delay_s.abs() >= LARGEST_S {
            return None;
        }
        if step_s.abs() < CONVERGED_S {
            if !equations.is_determined() {
                return None;
            }
            let error_s = equations.error_s()?;
            return Some(FlowDelay { delay_s, standard_error_s: error_s.hypot(LIFT_LAG_S) });
        }
    }
    None
}

/// One window: the vane at its times, the terms at those of the inertial samples.
struct Window {
    vane: MeasurementSeries,
    time_s: Vec<f64>,
    /// Columns of the terms, and their slopes.
    terms: [Vec<f64>; TERMS],
    slopes: [Vec<f64>; TERMS],
}

impl Window {
    fn new(data: &FilterData) -> Option<Self> {
        let vane = &data.measurements[Measurement::AngleOfAttack as usize];
        let airspeed = &data.measurements[Measurement::Airspeed as usize];
        let time_s: &[f64] = &data.inputs.time_s;
        let step_s = median_step(time_s)?;
        let half_width = |length_s: f64| samples(length_s / step_s).max(DEGREE);
        let polynomial = half_width(HALF_WIDTH_S);
        let smoothing = Smoothing::LocalPolynomial { degree: DEGREE, half_width: polynomial };
        let differentiation = Differentiation::LocalPolynomial { degree: DEGREE, half_width: polynomial };
        let slope = |values: &[f64]| differentiate(time_s, values, differentiation).ok();
        let width = 2 * samples(AIRSPEED_HALF_WIDTH_S / median_step(&airspeed.time_s)?) + 1;
        let airspeed_m_s = smooth(&airspeed.time_s, &airspeed.values, Smoothing::MovingAverage { width }).ok()?;
        let within = |at: &f64| at.clamp(airspeed.time_s[0], airspeed.time_s[airspeed.time_s.len() - 1]);
        let airspeed_m_s = |at: &f64| value_at(&airspeed.time_s, &airspeed_m_s, f64::INFINITY, within(at));
        let airspeed_m_s: Vec<f64> = time_s.iter().map(airspeed_m_s).collect::<Option<_>>()?;
        let over = |values: &[f64], power: i32| -> Vec<f64> {
            values.iter().zip(&airspeed_m_s).map(|(value, airspeed_m_s)| value / airspeed_m_s.powi(power)).collect()
        };
        let force = smooth(time_s, &data.inputs.columns[Input::SpecificForceZ as usize], smoothing).ok()?;
        let rate = &data.inputs.columns[Input::PitchRate as usize];
        let terms = [over(&force, 2), over(&smooth(time_s, rate, smoothing).ok()?, 1), over(&slope(rate)?, 2)];
        let slopes = [slope(&terms[0])?, slope(&terms[1])?, slope(&terms[2])?];
        Some(Self { vane: vane.clone(), time_s: time_s.to_vec(), terms, slopes })
    }

    /// Rows of the regression for a delay: time, vane, terms and their slopes.
    fn rows(&self, delay_s: f64) -> Vec<(f64, f64, [f64; 2 * TERMS])> {
        let at = |column: &[f64], at_s: f64| value_at(&self.time_s, column, f64::INFINITY, at_s);
        let row = |(&time_s, &vane): (&f64, &f64)| {
            let mut row = [0.0; 2 * TERMS];
            for (value, column) in row.iter_mut().zip(self.terms.iter().chain(&self.slopes)) {
                *value = at(column, time_s - delay_s)?;
            }
            vane.is_finite().then_some((time_s, vane, row))
        };
        self.vane.time_s.iter().zip(&*self.vane.values).filter_map(row).collect()
    }
}

fn samples(count: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number of samples")]
    let count = count.round().clamp(0.0, 1e4) as usize;
    count
}

/// Least squares of the vane on the terms and on the slope of their sum, each less its mean over its window.
struct Equations {
    x: DMatrix<f64>,
    z: DVector<f64>,
    /// First rows of the blocks.
    blocks: Vec<usize>,
    /// Part of the vane's motion that the terms leave, by its norm.
    unexplained: f64,
    /// Part of its slope that is none of the terms, by its square.
    own_slope: f64,
}

impl Equations {
    fn new(windows: &[Window], delay_s: f64) -> Option<Self> {
        let (mut rows, mut vane, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for window in windows {
            let mut own = window.rows(delay_s);
            let count = own.len() as f64;
            let mean_vane = own.iter().map(|(_, vane, _)| vane).sum::<f64>() / count;
            let means: [f64; 2 * TERMS] =
                std::array::from_fn(|k| own.iter().map(|(.., row)| row[k]).sum::<f64>() / count);
            let mut block_s = f64::NEG_INFINITY;
            for (time_s, value, row) in &mut own {
                if *time_s - block_s > BLOCK_S {
                    block_s = *time_s;
                    blocks.push(rows.len());
                }
                row.iter_mut().zip(means).for_each(|(value, mean)| *value -= mean);
                rows.push(*row);
                vane.push(*value - mean_vane);
            }
        }
        if blocks.len() < LEAST_BLOCKS {
            return None;
        }
        let terms = DMatrix::from_fn(rows.len(), TERMS, |row, column| rows[row][column]);
        let z = DVector::from_vec(vane);
        let estimate = solve(&terms, &z)?;
        let unexplained = (&z - &terms * &estimate).norm() / z.norm();
        let slopes = DMatrix::from_fn(rows.len(), TERMS, |row, column| rows[row][TERMS + column]);
        // A vane that is late by d shows d times the slope too little.
        let slope = -slopes * estimate;
        let own = &slope - &terms * solve(&terms, &slope)?;
        let own_slope = own.norm_squared() / slope.norm_squared();
        let mut x = terms.insert_column(TERMS, 0.0);
        x.set_column(TERMS, &slope);
        Some(Self { x, z, blocks, unexplained, own_slope })
    }

    /// Whether the terms explain the vane and leave it a slope of its own.
    fn is_determined(&self) -> bool {
        self.unexplained < UNEXPLAINED && self.own_slope > OWN_SLOPE
    }

    /// Delay beside the one the terms are taken at, s.
    fn delay_s(&self) -> Option<f64> {
        Some(solve(&self.x, &self.z)?[TERMS])
    }

    /// Standard error of the delay from the scatter of the blocks' gradients, s.
    fn error_s(&self) -> Option<f64> {
        let left = &self.z - &self.x * solve(&self.x, &self.z)?;
        let inverse = self.x.tr_mul(&self.x).cholesky()?.inverse();
        let ends = self.blocks.iter().skip(1).copied().chain([self.z.len()]);
        let variance: f64 = self
            .blocks
            .iter()
            .zip(ends)
            .map(|(&start, end)| {
                let gradient = self.x.rows(start, end - start).tr_mul(&left.rows(start, end - start));
                inverse.row(TERMS).transpose().dot(&gradient).powi(2)
            })
            .sum();
        Some(student_widening(self.blocks.len())? * variance.sqrt())
    }
}

/// `(X' X)^-1 X' z`; none where the columns depend on each other.
fn solve(x: &DMatrix<f64>, z: &DVector<f64>) -> Option<DVector<f64>> {
    let scale: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    let mut scaled = x.clone();
    for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
        column.unscale_mut(*scale);
    }
    let found = scaled.tr_mul(&scaled).cholesky()?.solve(&scaled.tr_mul(z));
    Some(DVector::from_iterator(scale.len(), found.iter().zip(&scale).map(|(value, scale)| value / scale)))
}
