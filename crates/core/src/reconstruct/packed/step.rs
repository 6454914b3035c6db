//! One step of the packed filter: prediction, then the measurements in two pairs of triples.
//!
//! It computes what `filter::ekf` specifies, P in blocks and S in pairs of triples. With `S = L L'` (Cholesky) the whitened columns
//! `W = P H' L'^-1` and the whitened innovation `L^-1 nu` replace the gain `K = W L^-1`: `x + K nu` is `x + W (L^-1 nu)`, and
//! Joseph's update with the optimal gain is `P - W W'`. Of the specification,
//!
//! | here | there |
//! |---|---|
//! | `Transition`, `Covariance::propagate` | Phi, `Phi P Phi' + N` |
//! | `MaskedJacobian` | the rows of H of ground velocity and air data |
//! | `InnovationFactor` | L, of six of the rows of S |
//! | `by_ground`, `by_air` | columns of `P H'` |
//! | `whitened`, `white` | W, `L^-1 nu` |
//!
//! Position and attitude are linear in the state and enter once. Ground velocity and air data are iterated, which takes
//! only the nine states they depend on (velocity, attitude, wind); the other nine follow once at the end. The result
//! is that of a joint update with all twelve measurements.

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::model::kinematics::{Trig, ned_from_body};
use crate::reconstruct::model::layout::{
    ACC, AIR, ATT, ATTITUDE, GROUND, GROUPS, GYR, POS, POSITION, TRIPLES, VEL, WIND,
};
use crate::reconstruct::model::measurement::{MeasurementModel, residual};
use crate::reconstruct::model::transition::Transition;
use crate::reconstruct::numeric::mat3::{
    Factor, Mat3, add_product, add_product_transposed, add_times, product, scaled_columns, scaled_rows,
    subtract_product_transposed, subtract_times, transposed, zeros,
};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::{Vec3, difference};
use crate::reconstruct::packed::covariance::{Covariance, at};

/// Groups of states that ground velocity and air data depend on.
const ITERATED: [usize; 3] = [VEL, ATT, WIND];

/// State and covariance.
#[derive(Clone, Copy)]
pub struct Estimate<T> {
    /// State x, group by group.
    pub x: [Vec3<T>; GROUPS],
    pub p: Covariance<T>,
}

/// The prediction that measurements are compared with.
#[derive(Clone, Copy)]
pub struct Prediction<T> {
    /// State.
    pub x: [Vec3<T>; GROUPS],
    /// Sines and cosines of its attitude.
    pub trig: Trig<T>,
    /// Ground velocity and air data there.
    pub model: MeasurementModel<T>,
    /// Squares of the changes of velocity, attitude and wind below which the iteration ends.
    pub limits: [Vec3<T>; 3],
}

/// The parts of a step, each compiled once for the instructions of a vector by `dispatch`.
pub(crate) trait StepParts: Real {
    /// [`crate::reconstruct::model::transition::predict_state`].
    fn predict_state(
        x: &mut [Vec3<Self>; GROUPS],
        step: &StepInputs<Self>,
        parameters: &FilterParameters<Self>,
    ) -> (Transition<Self>, Trig<Self>);

    /// [`Covariance::propagate`].
    fn propagate(p: &mut Covariance<Self>, phi: &Transition<Self>, noise: &[Vec3<Self>; 2]);

    /// [`Estimate::update_linear`].
    fn update_linear(
        estimate: &mut Estimate<Self>,
        step: &StepInputs<Self>,
        parameters: &FilterParameters<Self>,
        update: &mut Update<Self>,
    );

    /// [`Estimate::update_iterated`].
    fn update_iterated(
        estimate: &mut Estimate<Self>,
        step: &StepInputs<Self>,
        prediction: &Prediction<Self>,
        parameters: &FilterParameters<Self>,
        update: &mut Update<Self>,
    );
}

impl<T: StepParts> Estimate<T> {
    /// Prediction over one step; returns the transition and sines and cosines of the predicted attitude.
    #[inline(always)]
    pub fn predict(&mut self, step: &StepInputs<T>, parameters: &FilterParameters<T>) -> (Transition<T>, Trig<T>) {
        let (phi, trig) = T::predict_state(&mut self.x, step, parameters);
        let mut noise = parameters.noise.process;
        for s in 0..2 {
            for i in 0..3 {
                noise[s][i] = noise[s][i] * step.noise_scale;
            }
        }
        T::propagate(&mut self.p, &phi, &noise);
        self.p.add_diagonal(&parameters.noise.random_walk, step.dt);
        let wind = &parameters.noise.random_walk[WIND];
        if (wind[0] + wind[1] + wind[2]).any_above(T::zero()) {
            self.p.add_wind_change(wind, step.dt, &ned_from_body(&trig));
        }
        (phi, trig)
    }

    /// Update with what was measured at the end of the step; `trig` belongs to the predicted attitude.
    #[inline(always)]
    pub fn update(&mut self, step: &StepInputs<T>, trig: &Trig<T>, parameters: &FilterParameters<T>) -> Update<T> {
        let model = MeasurementModel::new(&self.x[VEL], trig, &self.x[WIND]);
        let prediction = Prediction { x: self.x, trig: *trig, model, limits: self.limits(parameters) };
        let mut update = self.innovations(&model, step, parameters);
        if parameters.robust_limit > 0.0 {
            update.weigh(parameters.robust_limit);
        }
        if any_present(&step.present[POSITION]) || any_present(&step.present[ATTITUDE]) {
            T::update_linear(self, step, parameters, &mut update);
        }
        if any_present(&step.present[GROUND]) || any_present(&step.present[AIR]) {
            T::update_iterated(self, step, &prediction, parameters, &mut update);
        }
        update
    }
}

impl<T: Real> Estimate<T> {
    /// Innovations at the predicted state and their variances, the diagonal of `H P H' + R`.
    #[inline(always)]
    pub fn innovations(
        &self,
        model: &MeasurementModel<T>,
        step: &StepInputs<T>,
        parameters: &FilterParameters<T>,
    ) -> Update<T> {
        let expected = [self.x[POS], model.ground, self.x[ATT], model.air];
        let mut innovation = step.measured;
        let mut variance = parameters.noise.measurement;
        for m in 0..TRIPLES {
            for i in 0..3 {
                innovation[m][i] = residual(m, i, step.measured[m][i], expected[m][i]) * step.present[m][i];
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
        Update {
            innovation,
            innovation_variance: variance,
            noise: parameters.noise.measurement,
            nis: T::zero(),
            det_ratio: one,
            iterations: one,
            smallest_pivot: T::splat(f64::INFINITY),
        }
    }

    /// Squares of the changes of velocity, attitude and wind below which the iteration ends.
    #[inline(always)]
    fn limits(&self, parameters: &FilterParameters<T>) -> [Vec3<T>; 3] {
        let mut limits = [self.p.variances(VEL), self.p.variances(ATT), self.p.variances(WIND)];
        for g in 0..3 {
            for i in 0..3 {
                limits[g][i] = limits[g][i] * parameters.tolerance_squared;
            }
        }
        limits
    }

    /// Position and attitude, whose measurement matrix is the identity on their groups.
    #[inline(always)]
    pub(crate) fn update_linear(
        &mut self,
        step: &StepInputs<T>,
        parameters: &FilterParameters<T>,
        update: &mut Update<T>,
    ) {
        let (pos, att) = (&step.present[POSITION], &step.present[ATTITUDE]);
        let cross = scaled_columns(&scaled_rows(&self.p.blocks[at(ATT, POS)], att), pos);
        let factor = InnovationFactor::new(
            &masked_covariance(&self.p.blocks[at(POS, POS)], pos, &update.noise[POSITION]),
            &cross,
            &masked_covariance(&self.p.blocks[at(ATT, ATT)], att, &update.noise[ATTITUDE]),
        );
        let white = factor.whiten(&update.innovation[POSITION], &update.innovation[ATTITUDE]);
        let mut whitened = [[zeros(); 2]; GROUPS];
        for g in 0..GROUPS {
            let by_pos = scaled_columns(&self.p.block(g, POS), pos);
            let by_att = scaled_columns(&self.p.block(g, ATT), att);
            whitened[g] = factor.whiten_rows(&by_pos, &by_att);
            self.x[g] = corrected(&self.x[g], &whitened[g], &white);
        }
        self.p.subtract_square(&whitened);
        update.nis = update.nis + squared_norm(&white);
        update.smallest_pivot = update.smallest_pivot.lesser(factor.pivot());
        update.det_ratio = update.det_ratio * factor.det_ratio(step, parameters, [POSITION, ATTITUDE]);
    }

    /// Ground velocity and air data, relinearised until the estimate stays put (Jazwinski 1970, section 8.3).
    #[inline(always)]
    pub(crate) fn update_iterated(
        &mut self,
        step: &StepInputs<T>,
        prediction: &Prediction<T>,
        parameters: &FilterParameters<T>,
        update: &mut Update<T>,
    ) {
        let Prediction { x: predicted, limits, .. } = prediction;
        let mut point = [predicted[VEL], predicted[ATT], predicted[WIND]];
        let mut model = prediction.model;
        let mut iteration = 1;
        loop {
            let h = MaskedJacobian::new(&model, &step.present[GROUND], &step.present[AIR]);
            // P H' and the factor of S = H P H' + R over the nine states
            let mut by_ground = [zeros(); 3];
            let mut by_air = [zeros(); 3];
            for g in 0..3 {
                (by_ground[g], by_air[g]) = h.covariance_with(&self.p, ITERATED[g]);
            }
            let factor = h.innovation_factor(&by_ground, &by_air, step, &update.noise);
            let (ground, air) = self.residual_about(&point, &model, &h, step);
            let white = factor.whiten(&ground, &air);
            if iteration == 1 {
                update.nis = update.nis + squared_norm(&white);
                update.det_ratio = update.det_ratio * factor.det_ratio(step, parameters, [GROUND, AIR]);
            }
            update.smallest_pivot = update.smallest_pivot.lesser(factor.pivot());

            let mut whitened = [[zeros(); 2]; GROUPS];
            let mut next = point;
            let mut excess = T::splat(-1.0);
            for g in 0..3 {
                whitened[ITERATED[g]] = factor.whiten_rows(&by_ground[g], &by_air[g]);
                next[g] = corrected(&self.x[ITERATED[g]], &whitened[ITERATED[g]], &white);
                for i in 0..3 {
                    let change = next[g][i] - point[g][i];
                    let over = change.mul_add(change, -limits[g][i]);
                    excess = over.select_above(excess, over, excess);
                }
            }
            if iteration >= parameters.max_iterations || !excess.any_above(T::zero()) {
                for g in [POS, ACC, GYR] {
                    let (by_ground, by_air) = h.covariance_with(&self.p, g);
                    whitened[g] = factor.whiten_rows(&by_ground, &by_air);
                    self.x[g] = corrected(&self.x[g], &whitened[g], &white);
                }
                for g in 0..3 {
                    self.x[ITERATED[g]] = next[g];
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
            let trig = prediction.trig.turned(&predicted[ATT], &point[1]);
            model = MeasurementModel::new(&point[0], &trig, &point[2]);
            update.iterations = update.iterations + excess.select_above(zero, T::splat(1.0), zero);
            iteration += 1;
        }
    }

    /// Residuals `z - h(c) - H (x - c)` of ground velocity and air data about the point c.
    #[inline(always)]
    fn residual_about(
        &self,
        point: &[Vec3<T>; 3],
        model: &MeasurementModel<T>,
        h: &MaskedJacobian<T>,
        step: &StepInputs<T>,
    ) -> (Vec3<T>, Vec3<T>) {
        let mut offset = *point;
        for g in 0..3 {
            offset[g] = difference(&self.x[ITERATED[g]], &point[g]);
        }
        let mut ground = step.measured[GROUND];
        let mut air = step.measured[AIR];
        for i in 0..3 {
            ground[i] = (ground[i] - model.ground[i] - offset[2][i]) * step.present[GROUND][i];
            air[i] = residual(AIR, i, air[i], model.air[i]) * step.present[AIR][i];
        }
        ground = subtract_times(&subtract_times(&ground, &h.ground_vel, &offset[0]), &h.ground_att, &offset[1]);
        (ground, subtract_times(&air, &h.air_vel, &offset[0]))
    }
}

/// Rows of the measurement matrix H of ground velocity and air data, zero where nothing was measured.
struct MaskedJacobian<T> {
    present: Vec3<T>,
    ground_vel: Mat3<T>,
    ground_att: Mat3<T>,
    air_vel: Mat3<T>,
}

impl<T: Real> MaskedJacobian<T> {
    #[inline(always)]
    fn new(model: &MeasurementModel<T>, ground: &Vec3<T>, air: &Vec3<T>) -> Self {
        Self {
            present: *ground,
            ground_vel: scaled_rows(&model.ground_vel, ground),
            ground_att: scaled_rows(&model.ground_att, ground),
            air_vel: scaled_rows(&model.air_vel, air),
        }
    }

    /// Rows of `P H'` of group `g`: by ground velocity, by air data.
    #[inline(always)]
    fn covariance_with(&self, p: &Covariance<T>, g: usize) -> (Mat3<T>, Mat3<T>) {
        let vel = p.block(g, VEL);
        let by_ground = scaled_columns(&p.block(g, WIND), &self.present);
        let by_ground = add_product_transposed(&by_ground, &vel, &self.ground_vel);
        let by_ground = add_product_transposed(&by_ground, &p.block(g, ATT), &self.ground_att);
        (by_ground, add_product_transposed(&zeros(), &vel, &self.air_vel))
    }

    /// Factor of `S = H P H' + R`, from the rows of `P H'` of velocity, attitude and wind.
    #[inline(always)]
    fn innovation_factor(
        &self,
        by_ground: &[Mat3<T>; 3],
        by_air: &[Mat3<T>; 3],
        step: &StepInputs<T>,
        noise: &[Vec3<T>; TRIPLES],
    ) -> InnovationFactor<T> {
        let ground = add_product(&scaled_rows(&by_ground[2], &self.present), &self.ground_vel, &by_ground[0]);
        let ground = add_product(&ground, &self.ground_att, &by_ground[1]);
        InnovationFactor::new(
            &with_noise(&ground, &step.present[GROUND], &noise[GROUND]),
            &product(&self.air_vel, &by_ground[0]),
            &with_noise(&product(&self.air_vel, &by_air[0]), &step.present[AIR], &noise[AIR]),
        )
    }
}

/// Cholesky factor of the covariance of six innovations, in 3 x 3 blocks.
struct InnovationFactor<T> {
    first: Factor<T>,
    /// Block below the first factor.
    below: Mat3<T>,
    second: Factor<T>,
}

impl<T: Real> InnovationFactor<T> {
    /// Of [[s11, s21'], [s21, s22]].
    #[inline(always)]
    fn new(s11: &Mat3<T>, s21: &Mat3<T>, s22: &Mat3<T>) -> Self {
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
    fn det_ratio(&self, step: &StepInputs<T>, parameters: &FilterParameters<T>, triples: [usize; 2]) -> T {
        let one = T::splat(1.0);
        let mut ratio = one;
        for t in 0..2 {
            let factor = if t == 0 { &self.first } else { &self.second };
            let m = triples[t];
            for i in 0..3 {
                let noise = step.present[m][i].select_above(T::zero(), parameters.noise.measurement[m][i], one);
                let root = factor.inverse_diagonal[i];
                ratio = ratio * (noise * root * root);
            }
        }
        ratio
    }

    #[inline(always)]
    fn whiten_rows(&self, by_first: &Mat3<T>, by_second: &Mat3<T>) -> [Mat3<T>; 2] {
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
fn corrected<T: Real>(x: &Vec3<T>, whitened: &[Mat3<T>; 2], white: &[Vec3<T>; 2]) -> Vec3<T> {
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

/// `M s M + R`, and the identity in the rows of what is absent.
#[inline(always)]
fn masked_covariance<T: Real>(s: &Mat3<T>, present: &Vec3<T>, noise: &Vec3<T>) -> Mat3<T> {
    with_noise(&scaled_columns(&scaled_rows(s, present), present), present, noise)
}

/// `s + R`, and one on the diagonal of what is absent.
#[inline(always)]
fn with_noise<T: Real>(s: &Mat3<T>, present: &Vec3<T>, noise: &Vec3<T>) -> Mat3<T> {
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
