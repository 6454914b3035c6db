//! Derivatives of a listing in the project's axes and normalisation.

use nalgebra::Vector3;
use thiserror::Error;

use super::{AileronTable, DatcomListing};
use crate::airframe::frames::stability_from_body;

/// Axes of the derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DatcomAxes {
    /// `CX CY CZ Cl Cm Cn` in body axes.
    #[default]
    Body,
    /// `CD CY CL Cl Cm Cn` in stability axes, as listed.
    Stability,
}

/// Deflection a pair of ailerons with unequal travel is described by; right aileron down positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AileronMeasure {
    /// The one that goes down, as the thesis measures them (4.1.3).
    #[default]
    DownGoing,
    /// Half the difference of right and left.
    HalfDifference,
}

/// How [`DatcomListing::derivatives`] expresses its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionOptions {
    /// Axes.
    pub axes: DatcomAxes,
    /// Length of pitch rate and rate of angle of attack over the chord: 1 for `q c / V`, 0.5 for `q c / (2 V)`, as listed and as
    /// thesis Table E.1 gives them.
    pub pitch_rate_chords: f64,
    /// Length of roll and yaw rate over the span: 0.5 for `p b / (2 V)`, as listed.
    pub lateral_rate_spans: f64,
    /// Aileron deflection.
    pub aileron: AileronMeasure,
}

impl Default for PredictionOptions {
    fn default() -> Self {
        Self {
            axes: DatcomAxes::default(),
            pitch_rate_chords: 1.0,
            lateral_rate_spans: 0.5,
            aileron: AileronMeasure::default(),
        }
    }
}

/// One predicted derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedDerivative {
    /// Name, for example `Cm_q`.
    pub name: &'static str,
    /// Value; angles in rad.
    pub value: f64,
}

/// A predicted derivative beside an identified one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DerivativeComparison {
    /// Name.
    pub name: &'static str,
    /// Value of the listing.
    pub predicted: f64,
    /// Value identified from flight.
    pub identified: f64,
}

impl DerivativeComparison {
    /// Whether both have one sign.
    pub fn same_sign(&self) -> bool {
        self.predicted * self.identified > 0.0
    }

    /// Predicted over identified.
    pub fn ratio(&self) -> f64 {
        self.predicted / self.identified
    }
}

/// An angle of attack outside the listing.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("angle of attack is {alpha_rad} rad, the listing covers {low_rad} to {high_rad} rad")]
pub struct AlphaOutsideError {
    /// Value given, rad.
    pub alpha_rad: f64,
    /// Lowest angle listed, rad.
    pub low_rad: f64,
    /// Highest angle listed, rad.
    pub high_rad: f64,
}

/// Slopes of lift and drag to one variable.
#[derive(Clone, Copy)]
struct LiftDrag {
    cl: f64,
    cd: f64,
}

impl DatcomListing {
    /// Stability and control derivatives at `alpha_rad`, linear between the listed angles, about the deck's moment
    /// reference point. What the program does not predict (`NDM`) is left out.
    ///
    /// Listed values are in stability axes and against `q c / (2 V)`. Against `q c / V` they are halved; thesis
    /// Table E.1 prints them unhalved beside its own `q c / V` values. Into body axes:
    /// `CX = CL sin(alpha) - CD cos(alpha)`, `CZ = -CL cos(alpha) - CD sin(alpha)` and their derivatives (that to alpha
    /// also turns the axes), `Cl = Cl_s cos(alpha) - Cn_s sin(alpha)`, `Cn = Cl_s sin(alpha) + Cn_s cos(alpha)`; the
    /// roll and yaw rates of body axes need all of `CLP CNP CNR CLR` and are given when these are listed. Elevator and
    /// aileron derivatives are slopes between the deflections next to neutral; drag to alpha is the slope between
    /// neighbouring angles. Positive deflections are those of `docs/conventions.md`.
    ///
    /// # Errors
    /// [`AlphaOutsideError`] for an angle the listing does not cover.
    pub fn derivatives(
        &self,
        alpha_rad: f64,
        options: &PredictionOptions,
    ) -> Result<Vec<PredictedDerivative>, AlphaOutsideError> {
        let (low_rad, high_rad) = match (self.alpha_rad.first(), self.alpha_rad.last()) {
            (Some(&low), Some(&high)) => (low, high),
            _ => (f64::NAN, f64::NAN),
        };
        if !(low_rad..=high_rad).contains(&alpha_rad) {
            return Err(AlphaOutsideError { alpha_rad, low_rad, high_rad });
        }
        let mut found = Vec::new();
        self.longitudinal(alpha_rad, options, &mut found);
        self.lateral(alpha_rad, options, &mut found);
        found.retain(|derivative| derivative.value.is_finite());
        Ok(found)
    }

    /// Angle of attack at which the listed lift is that of level flight, rad: on the straight line between the first two
    /// listed angles whose lift is either side of it. `None` where the listing has no level-flight lift or never reaches it.
    pub fn level_flight_alpha_rad(&self) -> Option<f64> {
        let lift = self.level_flight_cl?;
        let pairs = self.alpha_rad.windows(2).zip(self.statics.cl.windows(2));
        pairs.filter(|(_, cl)| (cl[0]..=cl[1]).contains(&lift)).find_map(|(alpha, cl)| {
            let weight = (lift - cl[0]) / (cl[1] - cl[0]);
            weight.is_finite().then(|| alpha[0] + weight * (alpha[1] - alpha[0]))
        })
    }

    /// Derivatives of forces in the plane of symmetry and of pitch.
    fn longitudinal(&self, alpha: f64, options: &PredictionOptions, found: &mut Vec<PredictedDerivative>) {
        let at = |column: &[f64]| self.at(alpha, column);
        let mut push = |name, value| found.push(PredictedDerivative { name, value });
        let statics = &self.statics;
        let slope = LiftDrag { cl: at(&statics.cl_alpha), cd: self.slope_at(alpha, &statics.cd) };
        match options.axes {
            DatcomAxes::Stability => {
                push("CD_alpha", slope.cd);
                push("CL_alpha", slope.cl);
            }
            DatcomAxes::Body => {
                // Turning the axes adds the coefficient itself, a quarter turn on: CX' = -CZ, CZ' = CX.
                let [cx, cz] = body(alpha, LiftDrag { cl: at(&statics.cl), cd: at(&statics.cd) });
                let [cx_alpha, cz_alpha] = body(alpha, slope);
                push("CX_alpha", cx_alpha - cz);
                push("CZ_alpha", cz_alpha + cx);
            }
        }
        push("Cm_alpha", at(&statics.cm_alpha));

        // Listed against q c/(2 V) and p b/(2 V).
        let rate = 0.5 / options.pitch_rate_chords;
        let mut forces = |names: [&'static str; 4], slope: LiftDrag| match options.axes {
            DatcomAxes::Stability => {
                push(names[0], slope.cd);
                push(names[1], slope.cl);
            }
            DatcomAxes::Body => {
                let [cx, cz] = body(alpha, slope);
                push(names[2], cx);
                push(names[3], cz);
            }
        };
        let no_drag = if options.axes == DatcomAxes::Body { 0.0 } else { f64::NAN };
        if let Some(dynamic) = &self.dynamic {
            let lift = |column: &[f64]| LiftDrag { cl: rate * at(column), cd: no_drag };
            forces(["CD_q", "CL_q", "CX_q", "CZ_q"], lift(&dynamic.cl_q));
            let names = ["CD_alpha_dot", "CL_alpha_dot", "CX_alpha_dot", "CZ_alpha_dot"];
            forces(names, lift(&dynamic.cl_alpha_dot));
        }
        if let Some(elevator) = &self.elevator {
            let about_neutral = |column: &[f64]| neutral_slope(&elevator.deflection_rad, column);
            let induced: Vec<f64> = (0..elevator.deflection_rad.len())
                .map(|k| {
                    let column: Vec<f64> = elevator.cd_induced.iter().map(|row| row[k]).collect();
                    if column.is_empty() { 0.0 } else { at(&column) }
                })
                .collect();
            let cd = about_neutral(&elevator.cd_min) + about_neutral(&induced);
            let names = ["CD_delta_e", "CL_delta_e", "CX_delta_e", "CZ_delta_e"];
            forces(names, LiftDrag { cl: about_neutral(&elevator.cl), cd });
            push("Cm_delta_e", about_neutral(&elevator.cm));
        }
        if let Some(dynamic) = &self.dynamic {
            push("Cm_q", rate * at(&dynamic.cm_q));
            push("Cm_alpha_dot", rate * at(&dynamic.cm_alpha_dot));
        }
    }

    /// Derivatives of side force, roll and yaw.
    fn lateral(&self, alpha: f64, options: &PredictionOptions, found: &mut Vec<PredictedDerivative>) {
        let at = |column: &[f64]| self.at(alpha, column);
        let mut push = |name, value| found.push(PredictedDerivative { name, value });
        // Components along the axes asked for of a vector (x: roll, z: yaw) given in stability axes.
        let body_from_stability = match options.axes {
            DatcomAxes::Stability => stability_from_body(0.0),
            DatcomAxes::Body => stability_from_body(alpha).inverse(),
        };
        let turned = |roll: f64, yaw: f64| {
            let moment = body_from_stability * Vector3::new(roll, 0.0, yaw);
            (moment.x, moment.z)
        };
        let statics = &self.statics;
        push("CY_beta", at(&statics.cy_beta));
        let (roll, yaw) = turned(at(&statics.cl_beta), at(&statics.cn_beta));
        push("Cl_beta", roll);
        push("Cn_beta", yaw);
        if let Some(dynamic) = &self.dynamic {
            let rate = 0.5 / options.lateral_rate_spans;
            // Rows of moments and columns of rates turn alike: D_b = R D_s R'.
            let columns = [(&dynamic.cl_p, &dynamic.cn_p), (&dynamic.cl_r, &dynamic.cn_r)]
                .map(|(roll, yaw)| turned(at(roll), at(yaw)));
            let (roll_p, roll_r) = turned(columns[0].0, columns[1].0);
            let (yaw_p, yaw_r) = turned(columns[0].1, columns[1].1);
            for (name, value) in [("Cl_p", roll_p), ("Cl_r", roll_r), ("Cn_p", yaw_p), ("Cn_r", yaw_r)] {
                push(name, rate * value);
            }
            if options.axes == DatcomAxes::Stability {
                push("CY_p", rate * at(&dynamic.cy_p));
            }
        }
        if let Some(aileron) = &self.aileron {
            let deflection = aileron.deflection_rad(options.aileron);
            let yaw: Vec<f64> = (0..deflection.len())
                .map(|k| at(&aileron.yaw.iter().map(|row| row[k]).collect::<Vec<f64>>()))
                .collect();
            let (roll_s, yaw_s) = (neutral_slope(&deflection, &aileron.roll), neutral_slope(&deflection, &yaw));
            if yaw_s.is_nan() && options.axes == DatcomAxes::Stability {
                push("Cl_delta_a", roll_s);
            } else {
                let (roll, yaw) = turned(roll_s, yaw_s);
                push("Cl_delta_a", roll);
                push("Cn_delta_a", yaw);
            }
        }
    }

    /// `column` at `alpha`, linear between the listed angles; not a number where it has none.
    fn at(&self, alpha: f64, column: &[f64]) -> f64 {
        let Some((lower, weight)) = self.interval(alpha).filter(|_| column.len() == self.alpha_rad.len()) else {
            return f64::NAN;
        };
        // The neighbour without weight may be one the program could not predict.
        if weight == 0.0 {
            column[lower]
        } else if weight == 1.0 {
            column[lower + 1]
        } else {
            column[lower] + weight * (column[lower + 1] - column[lower])
        }
    }

    /// Slope of `column` to alpha, 1/rad: between the angles either side, interpolated like the column itself.
    fn slope_at(&self, alpha: f64, column: &[f64]) -> f64 {
        let a = &self.alpha_rad;
        let slopes: Vec<f64> = (0..a.len())
            .map(|k| {
                let (low, high) = (k.saturating_sub(1), (k + 1).min(a.len() - 1));
                (column[high] - column[low]) / (a[high] - a[low])
            })
            .collect();
        self.at(alpha, &slopes)
    }

    /// Lower of the two listed angles around `alpha` and the weight of the upper.
    fn interval(&self, alpha: f64) -> Option<(usize, f64)> {
        let a = &self.alpha_rad;
        let last = a.len().checked_sub(2)?;
        let lower = a.partition_point(|&listed| listed <= alpha).saturating_sub(1).min(last);
        Some((lower, (alpha - a[lower]) / (a[lower + 1] - a[lower])))
    }
}

impl AileronTable {
    /// Deflection of each row by `measure`, right aileron down positive, rad.
    fn deflection_rad(&self, measure: AileronMeasure) -> Vec<f64> {
        let deflection = |(&left, &right): (&f64, &f64)| match measure {
            AileronMeasure::HalfDifference => 0.5 * (right - left),
            AileronMeasure::DownGoing if right > left => right,
            AileronMeasure::DownGoing => -left,
        };
        self.left_rad.iter().zip(&self.right_rad).map(deflection).collect()
    }
}

/// Predicted and identified derivatives of one name side by side, in the order of `predicted`.
///
/// Both must be in the same axes and normalisation: those of the default [`PredictionOptions`] are the project's.
pub fn beside(predicted: &[PredictedDerivative], identified: &[(&str, f64)]) -> Vec<DerivativeComparison> {
    predicted
        .iter()
        .filter_map(|p| {
            let (_, value) = identified.iter().find(|(name, _)| *name == p.name)?;
            Some(DerivativeComparison { name: p.name, predicted: p.value, identified: *value })
        })
        .collect()
}

/// `[CX, CZ]` of lift and drag.
fn body(alpha: f64, stability: LiftDrag) -> [f64; 2] {
    let (sin, cos) = alpha.sin_cos();
    [stability.cl * sin - stability.cd * cos, -stability.cl * cos - stability.cd * sin]
}

/// Slope of `column` between the deflections next to neutral on either side; not a number without both.
fn neutral_slope(deflection: &[f64], column: &[f64]) -> f64 {
    let nearest = |sign: f64| {
        (0..deflection.len().min(column.len()))
            .filter(|&k| sign * deflection[k] > 0.0)
            .min_by(|&a, &b| deflection[a].abs().total_cmp(&deflection[b].abs()))
    };
    match (nearest(-1.0), nearest(1.0)) {
        (Some(low), Some(high)) => (column[high] - column[low]) / (deflection[high] - deflection[low]),
        _ => f64::NAN,
    }
}
