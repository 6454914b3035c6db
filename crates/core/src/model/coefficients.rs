//! Coefficients from forces and moments.

use std::borrow::Cow;
use std::sync::Arc;

use super::data::{AeroData, Axes, CoefficientSettings, Engine, Gyroscopic, ThrustTreatment};
use super::{Coefficient, ModelError};
use crate::airframe::{InertiaTensor, MassHistory};
use crate::prep::{MatchedSmoothing, acceleration_at_cg, differentiate};

/// Columns of all eight coefficients over one window; all of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Time, s.
    pub time_s: Arc<[f64]>,
    /// One column per [`Coefficient`], in the order of [`Coefficient::ALL`]; shared, as a window may be long.
    pub columns: [Arc<[f64]>; 8],
}

impl Coefficients {
    /// Column of `coefficient`.
    pub fn get(&self, coefficient: Coefficient) -> &[f64] {
        &self.columns[coefficient as usize]
    }

    /// Those of the rows `left`, counted from `first`; `None` for all.
    fn with_rows(self, left: Option<&[usize]>, first: usize) -> Self {
        let Some(left) = left else { return self };
        let pick = |column: &Arc<[f64]>| left.iter().map(|row| column[row - first]).collect();
        Self { time_s: pick(&self.time_s), columns: self.columns.each_ref().map(pick) }
    }
}

/// Dimensionless forces and moments (thesis Eq. 3.23-3.24, A.13).
///
/// With `q_dyn = rho V^2 / 2`: `[CX CY CZ] = (m a - T) / (q_dyn S)`; moments about the centre of gravity
/// `L = Ixx p' - Ixz (r' + p q) + (Izz - Iyy) q r - Ixy (q' - p r) - Iyz (q^2 - r^2)`,
/// `M = Iyy q' + (Ixx - Izz) p r + Ixz (p^2 - r^2) - Ixy (p' + q r) - Iyz (r' - p q) + h r`,
/// `N = Izz r' + (Iyy - Ixx) p q + Ixz (q r - p') - Ixy (p^2 - q^2) - Iyz (q' + p r) - h q` (thesis Eq. A.11; Eq. 3.24 has
/// `Ixy = Iyz = 0`), less the moment of the thrust, moved to the moment reference
/// at `d` from the centre of gravity by `- d x F`; then `Cl = L / (q_dyn S b)`, `Cm = M / (q_dyn S c)`,
/// `Cn = N / (q_dyn S b)`. `CL = -CZ cos(alpha) + CX sin(alpha)`, `CD = -CX cos(alpha) - CZ sin(alpha)`. Thrust and `h`
/// enter as the settings say; `F` is the force that stays in the coefficients, so that a thrust left in keeps its own
/// moment about the reference. The specific force is moved from the accelerometers to the centre of gravity (thesis Eq. 4.10).
///
/// Samples of excluded stretches have no row.
///
/// With matched smoothing the angular acceleration `D w` is that of smoothed rates, and all that does not contain it is smoothed
/// alike: `C = G C(w' = 0) + (C(w' = D w) - C(w' = 0))`, the coefficients being linear in it.
///
/// # Errors
/// Columns of unequal length, values that are not finite, airspeed, density, mass or reference lengths that are not
/// positive, engines missing although asked for, too few samples to differentiate, and for matched smoothing a step that is not
/// constant.
pub fn coefficients(data: &AeroData, settings: &CoefficientSettings) -> Result<Coefficients, ModelError> {
    data.check()?;
    check_settings(data, settings)?;
    let acceleration = angular_acceleration(data, settings)?;
    let columns = columns(data, settings, |k| acceleration.each_ref().map(|column| column[k]));
    let Some(smoothing) = matched_smoothing(data, settings)? else {
        let (time_s, columns) = (Arc::clone(&data.time_s), columns.map(Arc::from));
        let left = settings.rows_left(&data.time_s, 0..data.time_s.len(), 0);
        return Ok(Coefficients { time_s, columns }.with_rows(left.as_deref(), 0));
    };
    let steady = self::columns(data, settings, |_| [0.0; 3]);
    let rows = smoothing.reach()..data.time_s.len() - smoothing.reach();
    let matched = |with: &[f64], without: &[f64]| {
        let moving = with[rows.clone()].iter().zip(&without[rows.clone()]).map(|(with, without)| with - without);
        smoothing.apply(without).into_iter().zip(moving).map(|(steady, moving)| steady + moving).collect()
    };
    let all = Coefficients {
        columns: std::array::from_fn(|c| matched(&columns[c], &steady[c])),
        time_s: data.time_s[rows.clone()].into(),
    };
    let left = settings.rows_left(&data.time_s, rows.clone(), smoothing.reach());
    Ok(all.with_rows(left.as_deref(), rows.start))
}

/// The smoothing the settings ask for over this window.
pub(super) fn matched_smoothing(
    data: &AeroData,
    settings: &CoefficientSettings,
) -> Result<Option<MatchedSmoothing>, ModelError> {
    if !settings.matched || data.angular_acceleration_rad_s2.is_some() {
        return Ok(None);
    }
    MatchedSmoothing::new(&data.time_s, settings.differentiation)
        .map(Some)
        .map_err(|source| ModelError::Signal { column: "time".to_owned(), source })
}

/// Columns of the eight coefficients for the angular acceleration `acceleration(sample)`.
fn columns(data: &AeroData, settings: &CoefficientSettings, acceleration: impl Fn(usize) -> [f64; 3]) -> [Vec<f64>; 8] {
    let samples = data.time_s.len();
    let mut columns: [Vec<f64>; 8] = std::array::from_fn(|_| Vec::with_capacity(samples));
    for k in 0..samples {
        let rates = data.rates_rad_s.each_ref().map(|column| column[k]);
        let values = sample(data, settings, k, rates, acceleration(k));
        for (column, value) in columns.iter_mut().zip(values) {
            column.push(value);
        }
    }
    columns
}

/// Specific force at the centre of gravity of each sample, m/s², moved there from the accelerometers (thesis Eq. 4.10) with the
/// angular acceleration the settings ask for.
pub fn specific_force_at_cg(data: &AeroData, settings: &CoefficientSettings) -> Result<[Vec<f64>; 3], ModelError> {
    data.check()?;
    let acceleration = angular_acceleration(data, settings)?;
    let at = |columns: &[Vec<f64>; 3], k: usize| columns.each_ref().map(|column| column[k]);
    let moved: Vec<[f64; 3]> = (0..data.time_s.len())
        .map(|k| specific_force(data, k, at(&data.rates_rad_s, k), at(&acceleration, k)))
        .collect();
    Ok(std::array::from_fn(|axis| moved.iter().map(|force| force[axis]).collect()))
}

/// Specific force at the centre of gravity at sample `k`, m/s².
fn specific_force(data: &AeroData, k: usize, rates: [f64; 3], acceleration: [f64; 3]) -> [f64; 3] {
    let measured = data.specific_force_m_s2.each_ref().map(|column| column[k]);
    match data.accelerometer {
        Some(place) => {
            let arm = place.body_from_cg_m(data.mass.at(k).cg_from_datum_m);
            acceleration_at_cg(arm, measured, rates, acceleration)
        }
        None => measured,
    }
}

/// The eight coefficients at sample `k`.
fn sample(
    data: &AeroData,
    settings: &CoefficientSettings,
    k: usize,
    rates: [f64; 3],
    acceleration: [f64; 3],
) -> [f64; 8] {
    let loaded = data.mass.at(k);
    let reference = &settings.reference;
    let alpha = data.alpha_rad[k];
    let (sin, cos) = alpha.sin_cos();

    let specific_force = specific_force(data, k, rates, acceleration);
    let mut force = specific_force.map(|component| loaded.mass_kg * component);
    let mut moment = inertial_moment(&loaded.inertia, rates, acceleration);
    let h = angular_momentum(&data.engines, settings.gyroscopic, k);
    moment[1] += h * rates[2];
    moment[2] -= h * rates[1];
    if settings.thrust != ThrustTreatment::Included {
        for engine in &data.engines {
            let thrust = engine.direction_body.map(|component| component * engine.thrust_n[k]);
            force = subtract(force, thrust);
            if settings.thrust == ThrustTreatment::Removed {
                let arm = engine.position.body_from_cg_m(loaded.cg_from_datum_m);
                moment = subtract(moment, cross(arm, thrust));
            }
        }
    }
    if let Some(point) = settings.moment_reference {
        moment = subtract(moment, cross(point.body_from_cg_m(loaded.cg_from_datum_m), force));
    }
    if settings.axes == Axes::Stability {
        moment = [moment[0] * cos + moment[2] * sin, moment[1], moment[2] * cos - moment[0] * sin];
    }

    let force_scale = 0.5 * data.density_kg_m3[k] * data.airspeed_m_s[k].powi(2) * reference.area_m2;
    let [cx, cy, cz] = force.map(|component| component / force_scale);
    let span_scale = force_scale * reference.lateral_moment_length_m;
    [
        cx,
        cy,
        cz,
        moment[0] / span_scale,
        moment[1] / (force_scale * reference.chord_m),
        moment[2] / span_scale,
        -cx * cos - cz * sin,
        -cz * cos + cx * sin,
    ]
}

/// Moment about the centre of gravity that the motion of a rigid body requires, `I w' + w x I w` (thesis Eq. A.11), N m; for a
/// symmetric loading, `Ixy = Iyz = 0`, thesis Eq. A.13.
fn inertial_moment(inertia: &InertiaTensor, [p, q, r]: [f64; 3], [p_dot, q_dot, r_dot]: [f64; 3]) -> [f64; 3] {
    let InertiaTensor { xx, yy, zz, xz, xy, yz } = *inertia;
    [
        xx * p_dot - xz * (r_dot + p * q) + (zz - yy) * q * r - xy * (q_dot - p * r) - yz * (q * q - r * r),
        yy * q_dot + (xx - zz) * p * r + xz * (p * p - r * r) - xy * (p_dot + q * r) - yz * (r_dot - p * q),
        zz * r_dot + (yy - xx) * p * q + xz * (q * r - p_dot) - xy * (p * p - q * q) - yz * (q_dot + p * r),
    ]
}

/// Angular momentum of the propellers along body x at sample `k`, kg m²/s; an engine whose speed is not known there has none.
pub fn angular_momentum(engines: &[Engine], gyroscopic: Gyroscopic, k: usize) -> f64 {
    let momentum = |engine: &Engine| engine.rotor_inertia_kg_m2 * engine.speed_rad_s.get(k).copied().unwrap_or(0.0);
    match gyroscopic {
        Gyroscopic::Ignored => 0.0,
        Gyroscopic::Signed => engines.iter().map(momentum).sum(),
        Gyroscopic::Summed => engines.iter().map(|engine| momentum(engine).abs()).sum(),
    }
}

/// Angular acceleration as given, or from the rates.
fn angular_acceleration<'a>(
    data: &'a AeroData,
    settings: &CoefficientSettings,
) -> Result<Cow<'a, [Vec<f64>; 3]>, ModelError> {
    if let Some(given) = &data.angular_acceleration_rad_s2 {
        return Ok(Cow::Borrowed(given));
    }
    let mut derived: [Vec<f64>; 3] = Default::default();
    for (axis, name) in ["p", "q", "r"].into_iter().enumerate() {
        derived[axis] = differentiate(&data.time_s, &data.rates_rad_s[axis], settings.differentiation)
            .map_err(|source| ModelError::Signal { column: name.to_owned(), source })?;
    }
    Ok(Cow::Owned(derived))
}

/// Checks what the settings ask of the data.
fn check_settings(data: &AeroData, settings: &CoefficientSettings) -> Result<(), ModelError> {
    let reference = &settings.reference;
    let start = data.time_s.first().copied().unwrap_or(0.0);
    for (quantity, value) in [
        ("reference area", reference.area_m2),
        ("length of Cl and Cn", reference.lateral_moment_length_m),
        ("chord", reference.chord_m),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(ModelError::NotPositive { quantity, time_s: start, value });
        }
    }
    if data.engines.is_empty() && settings.thrust != ThrustTreatment::Included {
        return Err(ModelError::NoEngine { setting: "thrust taken out of the coefficients" });
    }
    if settings.gyroscopic != Gyroscopic::Ignored {
        if data.engines.is_empty() {
            return Err(ModelError::NoEngine { setting: "the gyroscopic moment" });
        }
        for engine in &data.engines {
            if engine.speed_rad_s.len() != data.time_s.len() {
                return Err(ModelError::ColumnLength {
                    column: "propeller speed".to_owned(),
                    expected: data.time_s.len(),
                    found: engine.speed_rad_s.len(),
                });
            }
        }
    }
    Ok(())
}

/// Cross product.
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Difference `a - b`.
fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

impl AeroData {
    /// Checks that all columns have the length of time, are finite, and that airspeed, density, mass and moments of
    /// inertia are positive.
    ///
    /// # Errors
    /// The first column that fails, with time and value.
    pub fn check(&self) -> Result<(), ModelError> {
        for (name, column) in self.columns() {
            if column.len() != self.time_s.len() {
                return Err(ModelError::ColumnLength {
                    column: name.to_owned(),
                    expected: self.time_s.len(),
                    found: column.len(),
                });
            }
            if let Some(k) = column.iter().position(|value| !value.is_finite()) {
                return Err(ModelError::NotFinite { column: name.to_owned(), time_s: self.time_s[k] });
            }
        }
        for (quantity, column) in [("airspeed", &self.airspeed_m_s), ("air density", &self.density_kg_m3)] {
            if let Some(k) = column.iter().position(|&value| value <= 0.0) {
                return Err(ModelError::NotPositive { quantity, time_s: self.time_s[k], value: column[k] });
            }
        }
        if let MassHistory::PerSample(history) = &self.mass
            && history.len() != self.time_s.len()
        {
            return Err(ModelError::ColumnLength {
                column: "mass properties".to_owned(),
                expected: self.time_s.len(),
                found: history.len(),
            });
        }
        for (k, &time_s) in self.time_s.iter().enumerate() {
            let loaded = self.mass.at(k);
            for (quantity, value) in [
                ("mass", loaded.mass_kg),
                ("Ixx", loaded.inertia.xx),
                ("Iyy", loaded.inertia.yy),
                ("Izz", loaded.inertia.zz),
            ] {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(ModelError::NotPositive { quantity, time_s, value });
                }
            }
        }
        Ok(())
    }

    /// All columns there are, with their names.
    fn columns(&self) -> Vec<(&'static str, &[f64])> {
        let mut columns: Vec<(&'static str, &[f64])> = vec![
            ("time", &self.time_s),
            ("airspeed", &self.airspeed_m_s),
            ("alpha", &self.alpha_rad),
            ("beta", &self.beta_rad),
            ("air density", &self.density_kg_m3),
        ];
        for (name, column) in ["p", "q", "r"].into_iter().zip(&self.rates_rad_s) {
            columns.push((name, column));
        }
        for (name, column) in ["ax", "ay", "az"].into_iter().zip(&self.specific_force_m_s2) {
            columns.push((name, column));
        }
        for (name, column) in
            ["p_dot", "q_dot", "r_dot"].into_iter().zip(self.angular_acceleration_rad_s2.iter().flatten())
        {
            columns.push((name, column));
        }
        columns.extend(self.controls.iter().map(|(role, column)| (role.name(), &**column)));
        columns.extend(self.engines.iter().map(|engine| ("thrust", &*engine.thrust_n)));
        for (name, column) in
            [("dpt/q", &self.propeller_pressure), ("altitude", &self.altitude_m), ("Mach number", &self.mach)]
        {
            if let Some(column) = column {
                columns.push((name, column));
            }
        }
        columns
    }
}
