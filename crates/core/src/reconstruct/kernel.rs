//! One step of the filter: prediction, then the measurements in two pairs of triples.
//!
//! Position and attitude are linear in the state and enter once. Ground velocity and air data are iterated, which takes
//! only the nine states they depend on (velocity, attitude, wind); the other nine follow once at the end. The result
//! is that of a joint update with all twelve measurements.

use super::blocks::{
    Block, Factor, Vec3, add_product, add_product_transposed, add_times, difference, product, scaled_columns,
    scaled_rows, subtract_product_transposed, subtract_times, transposed, zeros,
};
use super::covariance::{ACC, ATT, Covariance, GROUPS, GYR, POS, VEL, WIND, at};
use super::kinematics::{KinematicsJacobian, Observation, Trig};
use super::lanes::Lanes;
use super::real::Real;
use super::transition::{Constants, Inputs, Motion, Transition, integrate};

/// Triples of measurements in the order of the measurement layout.
pub const POSITION: usize = 0;
/// Ground velocity.
pub const GROUND: usize = 1;
/// Attitude.
pub const ATTITUDE: usize = 2;
/// Airspeed, angle of attack, sideslip.
pub const AIR: usize = 3;

/// State and covariance.
#[derive(Clone, Copy)]
pub struct Estimate<T> {
    /// State, group by group.
    pub x: [Vec3<T>; GROUPS],
    /// Covariance.
    pub p: Covariance<T>,
}

/// What drives one step.
#[derive(Clone, Copy)]
pub struct Step<T> {
    /// Length, s.
    pub dt: T,
    /// Ratio of the sampling interval to `dt`: white noise held for part of an interval has that much more variance.
    pub noise_scale: T,
    /// Inertial measurements.
    pub inputs: Inputs<T>,
    /// Measurements; any finite number where there is none.
    pub z: [Vec3<T>; 4],
    /// 1 where there is a measurement, 0 elsewhere.
    pub present: [Vec3<T>; 4],
}

/// Settings in the kernel's form.
#[derive(Clone, Copy)]
pub struct Tuning<T> {
    /// Gravity, m/s^2.
    pub gravity: T,
    /// Variances of specific force and angular rate.
    pub process: [Vec3<T>; 2],
    /// Variances of the measurements.
    pub measurement: [Vec3<T>; 4],
    /// Variance rates of the random walks.
    pub random_walk: [Vec3<T>; GROUPS],
    /// Square of the largest change, in standard deviations, at which the iteration ends.
    pub tolerance_squared: T,
    /// Limit on linearisations; 1 is the extended Kalman filter.
    pub max_iterations: usize,
    /// Linearise the transition at the predicted state instead of the prior one.
    pub at_predicted: bool,
    /// Tell the noises that the smoother sees.
    pub see_noise: bool,
}

/// What a step tells besides the estimate.
#[derive(Clone, Copy)]
pub struct Telling<T> {
    /// Innovations, zero where nothing was measured.
    pub innovation: [Vec3<T>; 4],
    /// Their predicted variances.
    pub variance: [Vec3<T>; 4],
    /// Normalised innovation squared.
    pub nis: T,
    /// Smallest pivot met: not positive where the innovation covariance was not positive definite.
    pub pivot: T,
    /// Number of linearisations.
    pub iterations: T,
    /// Share of the noise in the innovations, `det R / det S` over what was measured; `ln |S|` follows from it.
    pub noise_share: T,
}

/// The prediction that a measurement is compared with.
#[derive(Clone, Copy)]
pub struct Predicted<T> {
    /// State.
    pub x: [Vec3<T>; GROUPS],
    /// Squares of the changes of velocity, attitude and wind below which the iteration ends.
    pub limits: [Vec3<T>; 3],
}

impl<T: Lanes> Estimate<T> {
    /// Prediction over one step; returns the transition and sines and cosines of the predicted attitude.
    #[inline(always)]
    pub fn predict(&mut self, step: &Step<T>, tuning: &Tuning<T>) -> (Transition<T>, Trig<T>) {
        let (phi, trig) = T::predict_state(&mut self.x, step, tuning);
        let mut noise = tuning.process;
        for s in 0..2 {
            for i in 0..3 {
                noise[s][i] = noise[s][i] * step.noise_scale;
            }
        }
        T::propagate(&mut self.p, &phi, &noise);
        self.p.add_diagonal(&tuning.random_walk, step.dt);
        (phi, trig)
    }

    /// Update with what was measured at the end of the step; `trig` belongs to the predicted attitude.
    #[inline(always)]
    pub fn update(&mut self, step: &Step<T>, trig: &Trig<T>, tuning: &Tuning<T>) -> Telling<T> {
        let before = Predicted { x: self.x, limits: self.limits(tuning) };
        let model = Observation::new(&before.x[VEL], trig, &before.x[WIND]);
        let mut telling = self.innovations(&model, step, tuning);
        if any_present(&step.present[POSITION]) || any_present(&step.present[ATTITUDE]) {
            T::update_linear(self, step, tuning, &mut telling);
        }
        if any_present(&step.present[GROUND]) || any_present(&step.present[AIR]) {
            T::update_iterated(self, &model, trig, step, &before, tuning, &mut telling);
        }
        telling
    }
}

impl<T: Real> Estimate<T> {
    /// Innovations at the predicted state and their variances, the diagonal of `H P H' + R`.
    #[inline(always)]
    pub fn innovations(&self, model: &Observation<T>, step: &Step<T>, tuning: &Tuning<T>) -> Telling<T> {
        let expected = [self.x[POS], model.ground, self.x[ATT], model.air];
        let mut innovation = step.z;
        let mut variance = tuning.measurement;
        for m in 0..4 {
            for i in 0..3 {
                innovation[m][i] = difference_of(m, i, step.z[m][i], expected[m][i]) * step.present[m][i];
            }
        }
        let (pos, att) = (self.p.variances(POS), self.p.variances(ATT));
        let vel_vel = self.p.blocks[at(VEL, VEL)];
        let by_vel = add_product(&self.p.blocks[at(WIND, VEL)], &model.ground_vel, &vel_vel);
        let by_vel = add_product(&by_vel, &model.ground_att, &self.p.blocks[at(ATT, VEL)]);
        let by_att = add_product(&self.p.blocks[at(WIND, ATT)], &model.ground_att, &self.p.blocks[at(ATT, ATT)]);
        let by_att = add_product(&by_att, &model.ground_vel, &transposed(&self.p.blocks[at(ATT, VEL)]));
        let by_air = product(&model.air_vel, &vel_vel);
        for i in 0..3 {
            variance[POSITION][i] = variance[POSITION][i] + pos[i];
            variance[ATTITUDE][i] = variance[ATTITUDE][i] + att[i];
            // by wind: row i of [C D I] times column i of the wind's covariance
            let mut ground = self.p.blocks[at(WIND, WIND)][i][i] + variance[GROUND][i];
            let mut air = variance[AIR][i];
            for k in 0..3 {
                ground = model.ground_vel[i][k].mul_add(self.p.blocks[at(WIND, VEL)][i][k], ground);
                ground = model.ground_att[i][k].mul_add(self.p.blocks[at(WIND, ATT)][i][k], ground);
                ground = by_vel[i][k].mul_add(model.ground_vel[i][k], ground);
                ground = by_att[i][k].mul_add(model.ground_att[i][k], ground);
                air = by_air[i][k].mul_add(model.air_vel[i][k], air);
            }
            variance[GROUND][i] = ground;
            variance[AIR][i] = air;
        }
        let one = T::splat(1.0);
        let pivot = T::splat(f64::INFINITY);
        Telling { innovation, variance, nis: T::zero(), pivot, iterations: one, noise_share: one }
    }

    /// Squares of the changes of velocity, attitude and wind below which the iteration ends.
    #[inline(always)]
    fn limits(&self, tuning: &Tuning<T>) -> [Vec3<T>; 3] {
        let mut limits = [self.p.variances(VEL), self.p.variances(ATT), self.p.variances(WIND)];
        for g in 0..3 {
            for i in 0..3 {
                limits[g][i] = limits[g][i] * tuning.tolerance_squared;
            }
        }
        limits
    }

    /// Position and attitude, whose measurement matrix is the identity on their groups.
    #[inline(always)]
    pub fn update_linear(&mut self, step: &Step<T>, tuning: &Tuning<T>, telling: &mut Telling<T>) {
        let (pos, att) = (&step.present[POSITION], &step.present[ATTITUDE]);
        let cross = scaled_columns(&scaled_rows(&self.p.blocks[at(ATT, POS)], att), pos);
        let pair = Pair::new(
            &masked_covariance(&self.p.blocks[at(POS, POS)], pos, &tuning.measurement[POSITION]),
            &cross,
            &masked_covariance(&self.p.blocks[at(ATT, ATT)], att, &tuning.measurement[ATTITUDE]),
        );
        let white = pair.whiten(&telling.innovation[POSITION], &telling.innovation[ATTITUDE]);
        let mut whitened = [[zeros(); 2]; GROUPS];
        for g in 0..GROUPS {
            let by_pos = scaled_columns(&self.p.block(g, POS), pos);
            let by_att = scaled_columns(&self.p.block(g, ATT), att);
            whitened[g] = pair.whiten_rows(&by_pos, &by_att);
            self.x[g] = corrected(&self.x[g], &whitened[g], &white);
        }
        self.p.subtract_square(&whitened);
        telling.nis = telling.nis + squared_norm(&white);
        telling.pivot = telling.pivot.lesser(pair.pivot());
        telling.noise_share = telling.noise_share * pair.noise_share(step, tuning, [POSITION, ATTITUDE]);
    }

    /// Ground velocity and air data, relinearised until the estimate stays put (Jazwinski 1970, section 8.3).
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn update_iterated(
        &mut self,
        model: &Observation<T>,
        trig: &Trig<T>,
        step: &Step<T>,
        before: &Predicted<T>,
        tuning: &Tuning<T>,
        telling: &mut Telling<T>,
    ) {
        let groups = [VEL, ATT, WIND];
        let Predicted { x: predicted, limits } = before;
        let mut point = [predicted[VEL], predicted[ATT], predicted[WIND]];
        let mut model = *model;
        let mut iteration = 1;
        loop {
            let h = Masked::new(&model, &step.present[GROUND], &step.present[AIR]);
            // B = P H' and S = H B + R over the nine states
            let mut by_ground = [zeros(); 3];
            let mut by_air = [zeros(); 3];
            for g in 0..3 {
                (by_ground[g], by_air[g]) = h.covariance_with(&self.p, groups[g]);
            }
            let ground = add_product(&scaled_rows(&by_ground[2], &h.present), &h.ground_vel, &by_ground[0]);
            let ground = add_product(&ground, &h.ground_att, &by_ground[1]);
            let pair = Pair::new(
                &with_noise(&ground, &step.present[GROUND], &tuning.measurement[GROUND]),
                &product(&h.air_vel, &by_ground[0]),
                &with_noise(&product(&h.air_vel, &by_air[0]), &step.present[AIR], &tuning.measurement[AIR]),
            );

            // residual z - h(point) - H (x - point)
            let mut ahead = point;
            for g in 0..3 {
                ahead[g] = difference(&self.x[groups[g]], &point[g]);
            }
            let mut ground = step.z[GROUND];
            let mut air = step.z[AIR];
            for i in 0..3 {
                ground[i] = (ground[i] - model.ground[i] - ahead[2][i]) * step.present[GROUND][i];
                air[i] = difference_of(AIR, i, air[i], model.air[i]) * step.present[AIR][i];
            }
            ground = subtract_times(&subtract_times(&ground, &h.ground_vel, &ahead[0]), &h.ground_att, &ahead[1]);
            air = subtract_times(&air, &h.air_vel, &ahead[0]);
            let white = pair.whiten(&ground, &air);
            if iteration == 1 {
                telling.nis = telling.nis + squared_norm(&white);
                telling.noise_share = telling.noise_share * pair.noise_share(step, tuning, [GROUND, AIR]);
            }
            telling.pivot = telling.pivot.lesser(pair.pivot());

            let mut whitened = [[zeros(); 2]; GROUPS];
            let mut next = point;
            let mut excess = T::splat(-1.0);
            for g in 0..3 {
                whitened[groups[g]] = pair.whiten_rows(&by_ground[g], &by_air[g]);
                next[g] = corrected(&self.x[groups[g]], &whitened[groups[g]], &white);
                for i in 0..3 {
                    let change = next[g][i] - point[g][i];
                    let over = change.mul_add(change, -limits[g][i]);
                    excess = over.select_above(excess, over, excess);
                }
            }
            if iteration >= tuning.max_iterations || !excess.any_above(T::zero()) {
                for g in [POS, ACC, GYR] {
                    let (by_ground, by_air) = h.covariance_with(&self.p, g);
                    whitened[g] = pair.whiten_rows(&by_ground, &by_air);
                    self.x[g] = corrected(&self.x[g], &whitened[g], &white);
                }
                for g in 0..3 {
                    self.x[groups[g]] = next[g];
                }
                self.p.subtract_square(&whitened);
                return;
            }

            // lanes that have arrived keep their point, so that their result does not depend on the others
            let zero = T::zero();
            for g in 0..3 {
                for i in 0..3 {
                    point[g][i] = excess.select_above(zero, next[g][i], point[g][i]);
                }
            }
            model = Observation::new(&point[0], &trig.turned(&predicted[ATT], &point[1]), &point[2]);
            telling.iterations = telling.iterations + excess.select_above(zero, T::splat(1.0), zero);
            iteration += 1;
        }
    }
}

/// Predicts the state over one step; returns the transition and sines and cosines of the predicted attitude.
#[inline(always)]
pub fn predict_state<T: Real>(
    x: &mut [Vec3<T>; GROUPS],
    step: &Step<T>,
    tuning: &Tuning<T>,
) -> (Transition<T>, Trig<T>) {
    let prior = Motion { pos: x[POS], vel: x[VEL], att: x[ATT] };
    let trig = Trig::new(&prior.att);
    let constants = Constants { bias_acc: x[ACC], bias_gyr: x[GYR], wind: x[WIND], gravity: tuning.gravity };
    let predicted = integrate(&prior, &trig, &constants, &step.inputs, step.dt);
    let predicted_trig = trig.turned(&prior.att, &predicted.att);

    let rate = difference(&step.inputs.middle()[1], &x[GYR]);
    let (vel, at_trig) = if tuning.at_predicted { (predicted.vel, predicted_trig) } else { (prior.vel, trig) };
    let phi = Transition::new(&KinematicsJacobian::new(&vel, &at_trig, &rate, tuning.gravity), step.dt);
    (x[POS], x[VEL], x[ATT]) = (predicted.pos, predicted.vel, predicted.att);
    (phi, predicted_trig)
}

/// Rows of the measurement matrix H of ground velocity and air data, zero where nothing was measured.
struct Masked<T> {
    present: Vec3<T>,
    ground_vel: Block<T>,
    ground_att: Block<T>,
    air_vel: Block<T>,
}

impl<T: Real> Masked<T> {
    #[inline(always)]
    fn new(model: &Observation<T>, ground: &Vec3<T>, air: &Vec3<T>) -> Self {
        Self {
            present: *ground,
            ground_vel: scaled_rows(&model.ground_vel, ground),
            ground_att: scaled_rows(&model.ground_att, ground),
            air_vel: scaled_rows(&model.air_vel, air),
        }
    }

    /// Rows of `P H'` of group `g`: by ground velocity, by air data.
    #[inline(always)]
    fn covariance_with(&self, p: &Covariance<T>, g: usize) -> (Block<T>, Block<T>) {
        let vel = p.block(g, VEL);
        let by_ground = scaled_columns(&p.block(g, WIND), &self.present);
        let by_ground = add_product_transposed(&by_ground, &vel, &self.ground_vel);
        let by_ground = add_product_transposed(&by_ground, &p.block(g, ATT), &self.ground_att);
        (by_ground, add_product_transposed(&zeros(), &vel, &self.air_vel))
    }
}

/// Cholesky factor of the covariance of six innovations, in 3 x 3 blocks.
struct Pair<T> {
    first: Factor<T>,
    /// Block below the first factor.
    below: Block<T>,
    second: Factor<T>,
}

impl<T: Real> Pair<T> {
    /// Of [[s11, s21'], [s21, s22]].
    #[inline(always)]
    fn new(s11: &Block<T>, s21: &Block<T>, s22: &Block<T>) -> Self {
        let first = Factor::new(s11);
        let below = first.whiten_rows(s21);
        let second = Factor::new(&subtract_product_transposed(s22, &below, &below));
        Self { first, below, second }
    }

    #[inline(always)]
    fn pivot(&self) -> T {
        self.first.pivot.lesser(self.second.pivot)
    }

    /// `det R / det S` over what was measured of the two triples.
    #[inline(always)]
    fn noise_share(&self, step: &Step<T>, tuning: &Tuning<T>, triples: [usize; 2]) -> T {
        let one = T::splat(1.0);
        let mut share = one;
        for t in 0..2 {
            let factor = if t == 0 { &self.first } else { &self.second };
            let m = triples[t];
            for i in 0..3 {
                let noise = step.present[m][i].select_above(T::zero(), tuning.measurement[m][i], one);
                let root = factor.inverse_diagonal[i];
                share = share * (noise * root * root);
            }
        }
        share
    }

    #[inline(always)]
    fn whiten_rows(&self, by_first: &Block<T>, by_second: &Block<T>) -> [Block<T>; 2] {
        let first = self.first.whiten_rows(by_first);
        [first, self.second.whiten_rows(&subtract_product_transposed(by_second, &first, &self.below))]
    }

    #[inline(always)]
    fn whiten(&self, first: &Vec3<T>, second: &Vec3<T>) -> [Vec3<T>; 2] {
        let first = self.first.whiten(first);
        [first, self.second.whiten(&subtract_times(second, &self.below, &first))]
    }
}

/// `x + W white`.
#[inline(always)]
fn corrected<T: Real>(x: &Vec3<T>, whitened: &[Block<T>; 2], white: &[Vec3<T>; 2]) -> Vec3<T> {
    add_times(&add_times(x, &whitened[0], &white[0]), &whitened[1], &white[1])
}

#[inline(always)]
fn squared_norm<T: Real>(white: &[Vec3<T>; 2]) -> T {
    let mut norm = T::zero();
    for triple in 0..2 {
        for i in 0..3 {
            norm = white[triple][i].mul_add(white[triple][i], norm);
        }
    }
    norm
}

/// Measured less expected, angles brought into half a turn.
#[inline(always)]
pub fn difference_of<T: Real>(triple: usize, i: usize, measured: T, expected: T) -> T {
    let difference = measured - expected;
    if triple == ATTITUDE || (triple == AIR && i > 0) { difference.wrapped() } else { difference }
}

/// `M s M + R`, and the identity in the rows of what is absent.
#[inline(always)]
fn masked_covariance<T: Real>(s: &Block<T>, present: &Vec3<T>, noise: &Vec3<T>) -> Block<T> {
    with_noise(&scaled_columns(&scaled_rows(s, present), present), present, noise)
}

/// `s + R`, and one on the diagonal of what is absent.
#[inline(always)]
fn with_noise<T: Real>(s: &Block<T>, present: &Vec3<T>, noise: &Vec3<T>) -> Block<T> {
    let mut s = *s;
    for i in 0..3 {
        s[i][i] = s[i][i] + present[i].select_above(T::zero(), noise[i], T::splat(1.0));
    }
    s
}

#[inline(always)]
fn any_present<T: Real>(present: &Vec3<T>) -> bool {
    (present[0] + present[1] + present[2]).any_above(T::zero())
}
