//! Centre of gravity from wheel reactions at several pitch attitudes.

use thiserror::Error;

use super::aircraft::{FixedItem, WheelStations};

/// Wheel reactions at one attitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelReactions {
    /// Angle between the level ground and the line through the wheels' contact points, nose up, rad.
    pub ground_pitch_rad: f64,
    /// Pitch of body x above the horizontal as an inclinometer reads it, rad.
    pub aircraft_pitch_rad: f64,
    /// Reading under the nose wheel, kg.
    pub nose_kg: f64,
    /// Reading under the right main wheel, kg.
    pub main_right_kg: f64,
    /// Reading under the left main wheel, kg.
    pub main_left_kg: f64,
}

impl WheelReactions {
    /// Sum of the three readings, kg.
    pub fn total_kg(&self) -> f64 {
        self.nose_kg + self.main_right_kg + self.main_left_kg
    }

    /// Mean moment arm `(l_n F_n + l_m F_m) / F`, m from the datum: the left side of thesis Eq. 5.5.
    fn arm_m(&self, wheels: &WheelStations) -> f64 {
        (wheels.nose_x_m * self.nose_kg + wheels.main_x_m * (self.main_right_kg + self.main_left_kg)) / self.total_kg()
    }

    /// Lateral centre of gravity, m from the plane of symmetry, to the right.
    fn lateral_m(&self, wheels: &WheelStations) -> f64 {
        wheels.main_y_m * (self.main_right_kg - self.main_left_kg) / self.total_kg()
    }
}

/// Centre of gravity that follows from a series of weighings. Positions in datum axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeighingResult {
    /// Mean of the total readings, kg.
    pub mass_kg: f64,
    /// Largest total reading less the smallest, kg.
    pub mass_spread_kg: f64,
    /// x of the regression, m.
    pub x_m: f64,
    /// Standard error of `x_m`, m; `None` for two attitudes, which leave no residual.
    pub x_error_m: Option<f64>,
    /// z of the regression, above the line through the contact points, m.
    pub z_ground_m: f64,
    /// Standard error of `z_ground_m`, m; `None` for two attitudes.
    pub z_error_m: Option<f64>,
    /// z in datum axes, `z_ground_m` corrected for the deflection of the struts, m.
    pub z_m: f64,
    /// Mean difference between aircraft and ground pitch, rad.
    pub strut_pitch_rad: f64,
    /// Coefficient of determination of the regression.
    pub r_squared: f64,
    /// Correlation coefficient of arm and tangent of pitch; thesis Table 5.6 prints its magnitude as R2.
    pub correlation: f64,
    /// x at the attitude nearest to level ground, m: fuel has moved least there.
    pub level_x_m: f64,
    /// y at that attitude, m.
    pub level_y_m: f64,
}

/// Why a series of weighings gives no centre of gravity.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum WeighingError {
    #[error("weighings at different pitch attitudes: {count}; the height of the centre of gravity needs at least 2")]
    TooFew { count: usize },
    /// A reading or angle that cannot be.
    #[error("weighing {index}: {field} is {value}, allowed is {allowed}")]
    OutOfRange { index: usize, field: &'static str, value: f64, allowed: &'static str },
    #[error("ground pitch spans {spread_rad} rad over the weighings, at least {SMALLEST_SPREAD_RAD} rad are needed")]
    NoSpread { spread_rad: f64 },
    #[error("the items to take off weigh {items_kg} kg of {mass_kg} kg weighed: nothing is left")]
    NothingLeft { items_kg: f64, mass_kg: f64 },
}

/// Smallest spread of ground pitch accepted, rad: the resolution of an inclinometer, 0.1 deg.
const SMALLEST_SPREAD_RAD: f64 = 0.001_745;

/// Centre of gravity from wheel reactions at two or more pitch attitudes.
///
/// The moments about the datum (thesis Eq. 5.4) divided by `F cos(theta)` are the line
/// `(l_n F_n + l_m F_m) / F = x_cg + z_cg tan(theta)` (Eq. 5.5), fitted by least squares over the attitudes. The struts
/// deflect, so the contact points turn against the body by `d = mean(theta_ac - theta_g)`, and
/// `z = z_ground - (l_m - x) tan(d)` (Eq. 5.6). Valid for a rigid aircraft whose fuel stays in place.
///
/// # Errors
/// [`WeighingError`] for fewer than two attitudes, a reading that is negative or not finite, an empty scale, or no spread of pitch.
pub fn centre_of_gravity(
    weighings: &[WheelReactions],
    wheels: &WheelStations,
) -> Result<WeighingResult, WeighingError> {
    examine(weighings)?;
    let count = weighings.len() as f64;
    let mean = |value: &dyn Fn(&WheelReactions) -> f64| weighings.iter().map(value).sum::<f64>() / count;
    let tangent = |point: &WheelReactions| point.ground_pitch_rad.tan();
    let arm = |point: &WheelReactions| point.arm_m(wheels);
    let (mean_tangent, mean_arm) = (mean(&tangent), mean(&arm));
    let sum = |value: &dyn Fn(f64, f64) -> f64| {
        weighings.iter().map(|point| value(tangent(point) - mean_tangent, arm(point) - mean_arm)).sum::<f64>()
    };
    let (s_tt, s_ta, s_aa) = (sum(&|t, _| t * t), sum(&|t, a| t * a), sum(&|_, a| a * a));
    let z_ground_m = s_ta / s_tt;
    let x_m = mean_arm - z_ground_m * mean_tangent;
    let residual = sum(&|t, a| (a - z_ground_m * t).powi(2));
    let variance = (weighings.len() > 2).then(|| residual / (count - 2.0));
    let strut_pitch_rad = mean(&|point| point.aircraft_pitch_rad - point.ground_pitch_rad);
    let total =
        |choose: fn(f64, f64) -> f64, start: f64| weighings.iter().map(WheelReactions::total_kg).fold(start, choose);
    let level = weighings.iter().fold(&weighings[0], |best, point| {
        if point.ground_pitch_rad.abs() < best.ground_pitch_rad.abs() { point } else { best }
    });
    Ok(WeighingResult {
        mass_kg: mean(&WheelReactions::total_kg),
        mass_spread_kg: total(f64::max, f64::NEG_INFINITY) - total(f64::min, f64::INFINITY),
        x_m,
        x_error_m: variance.map(|v| (v * (1.0 / count + mean_tangent * mean_tangent / s_tt)).sqrt()),
        z_ground_m,
        z_error_m: variance.map(|v| (v / s_tt).sqrt()),
        z_m: z_ground_m - (wheels.main_x_m - x_m) * strut_pitch_rad.tan(),
        strut_pitch_rad,
        r_squared: if s_aa > 0.0 { 1.0 - residual / s_aa } else { 1.0 },
        correlation: if s_aa > 0.0 { s_ta / (s_tt * s_aa).sqrt() } else { 0.0 },
        level_x_m: level.arm_m(wheels),
        level_y_m: level.lateral_m(wheels),
    })
}

fn examine(weighings: &[WheelReactions]) -> Result<(), WeighingError> {
    if weighings.len() < 2 {
        return Err(WeighingError::TooFew { count: weighings.len() });
    }
    for (row, point) in weighings.iter().enumerate() {
        let out_of_range =
            |field, value, allowed| Err(WeighingError::OutOfRange { index: row + 1, field, value, allowed });
        for (field, value) in
            [("ground_pitch_rad", point.ground_pitch_rad), ("aircraft_pitch_rad", point.aircraft_pitch_rad)]
        {
            if !(-1.0..=1.0).contains(&value) {
                return out_of_range(field, value, "-1 to 1 rad");
            }
        }
        let readings =
            [("nose_kg", point.nose_kg), ("main_right_kg", point.main_right_kg), ("main_left_kg", point.main_left_kg)];
        for (field, value) in readings {
            if !(0.0..=1e6).contains(&value) {
                return out_of_range(field, value, "0 to 1e6 kg");
            }
        }
        if point.total_kg() <= 0.0 {
            return out_of_range("total", point.total_kg(), "above 0 kg");
        }
    }
    let pitches = weighings.iter().map(|point| point.ground_pitch_rad);
    let spread_rad = pitches.clone().fold(f64::NEG_INFINITY, f64::max) - pitches.fold(f64::INFINITY, f64::min);
    if spread_rad < SMALLEST_SPREAD_RAD { Err(WeighingError::NoSpread { spread_rad }) } else { Ok(()) }
}

/// Mass and centre of gravity of what is left of a weighed aircraft when `items` are taken off:
/// `m = M - sum m_i`, `r = (M r_M - sum m_i r_i) / m` (thesis Eq. 5.3 solved for one part).
///
/// # Errors
/// [`WeighingError::NothingLeft`] where the items weigh as much as the aircraft.
pub fn without_items(weighed: &FixedItem, items: &[FixedItem]) -> Result<FixedItem, WeighingError> {
    let items_kg: f64 = items.iter().map(|item| item.mass_kg).sum();
    let mass_kg = weighed.mass_kg - items_kg;
    if mass_kg.is_nan() || mass_kg <= 0.0 {
        return Err(WeighingError::NothingLeft { items_kg, mass_kg: weighed.mass_kg });
    }
    let mut moment = weighed.cg_from_datum_m.map(|x| x * weighed.mass_kg);
    for item in items {
        for (sum, x) in moment.iter_mut().zip(item.cg_from_datum_m) {
            *sum -= item.mass_kg * x;
        }
    }
    Ok(FixedItem { name: weighed.name.clone(), mass_kg, cg_from_datum_m: moment.map(|sum| sum / mass_kg) })
}
