//! Least squares of the manoeuvres of a card of steady flight: sideslips, turns, accelerations.

use doublet_core::model::{Coefficient, ThrustTreatment, specific_force_at_cg};
use doublet_core::statistics::{median, median_step};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use serde::Serialize;

use super::campaign::PlannedPoint;
use crate::session::{Manoeuvre, Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{WindowAero, deflection};

/// A slope, or a constant, by least squares over the manoeuvres of a card.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlopeRow {
    pub name: &'static str,
    pub unit: &'static str,
    pub value: f64,
    pub standard_error: f64,
    pub model: Option<f64>,
    pub samples: usize,
}

/// What a card of steady flight is flown for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Steady {
    /// Rudder, aileron and bank over sideslip.
    Sideslip,
    /// Elevator over load factor.
    Turn,
    /// Drag over the square of the lift.
    Acceleration,
}

impl Steady {
    /// By the words of a kind of input.
    pub(super) fn of_kind(kind: &str) -> Option<Self> {
        let kind = kind.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| kind.contains(word));
        match () {
            () if has(&["sideslip"]) => Some(Self::Sideslip),
            () if has(&["turn", "manoeuvring", "pull-up"]) => Some(Self::Turn),
            () if has(&["acceleration", "deceleration"]) => Some(Self::Acceleration),
            () => None,
        }
    }
}

/// Whether the airspeed of a kind of manoeuvre is that of its entry only.
pub(super) fn is_acceleration(kind: &str) -> bool {
    Steady::of_kind(kind) == Some(Steady::Acceleration)
}

type Flown<'a> = (&'a Manoeuvre, &'a WindowAero);

/// Slopes of the manoeuvres found for a card; none where the card is not of steady flight or none was flown.
pub(super) fn evaluate(point: &PlannedPoint, session: &Session, snapshot: &Snapshot) -> Vec<SlopeRow> {
    let Some(kind) = Steady::of_kind(&point.kind) else { return Vec::new() };
    let flown = point.windows.iter().filter_map(|name| {
        let results = snapshot.windows.get(name)?;
        Some((session.window(name)?, &**results.aero.ready()?))
    });
    let flown: Vec<Flown<'_>> = flown.collect();
    let gravity = snapshot.gravity_m_s2(session);
    let model = Model::measure(&flown, snapshot, gravity);
    match kind {
        Steady::Sideslip => sideslip(&flown, gravity, model.as_ref()),
        Steady::Turn => turn(&flown, gravity, model.as_ref()),
        Steady::Acceleration => acceleration(&flown),
    }
}

/// Values of a column over a window at the times of its data.
type Column<'a> = &'a dyn Fn(&Flown<'_>) -> Option<Vec<f64>>;

fn sideslip(flown: &[Flown<'_>], gravity_m_s2: f64, model: Option<&Model>) -> Vec<SlopeRow> {
    let beta: Column<'_> = &|(_, aero)| Some(aero.data.beta_rad.to_vec());
    let bank: Column<'_> = &|(_, aero)| straight_bank(aero, gravity_m_s2);
    let surface = |surface| move |(_, aero): &Flown<'_>| Some(deflection(surface, aero)?.to_vec());
    let predicted = model.and_then(Model::sideslip);
    let place = |index: usize| predicted.and_then(|values| values.get(index).copied());
    let rows = [
        slope("rudder per sideslip", "", flown, beta, &surface(Surface::Rudder), place(0)),
        slope("aileron per sideslip", "", flown, beta, &surface(Surface::Aileron), place(1)),
        slope("bank per sideslip", "", flown, beta, bank, place(2)),
    ];
    rows.into_iter().flatten().collect()
}

fn turn(flown: &[Flown<'_>], gravity_m_s2: f64, model: Option<&Model>) -> Vec<SlopeRow> {
    let mut all: Vec<f64> = flown.iter().flat_map(|(_, aero)| pressure_pa(aero)).collect();
    let Some(median_pa) = median(&mut all) else { return Vec::new() };
    let load: Column<'_> = &|(_, aero)| load_at_pressure(aero, gravity_m_s2, median_pa);
    let elevator: Column<'_> = &|(_, aero)| Some(deflection(Surface::Elevator, aero)?.to_vec());
    let alpha: Column<'_> = &|(_, aero)| Some(aero.data.alpha_rad.to_vec());
    let predicted = model.and_then(Model::turn);
    let rows = [
        slope("elevator per load factor", "rad", flown, load, elevator, predicted.map(|found| found[1])),
        slope("angle of attack per load factor", "rad", flown, load, alpha, predicted.map(|found| found[0])),
    ];
    rows.into_iter().flatten().collect()
}

/// The drag polar; none where the coefficients contain the thrust.
fn acceleration(flown: &[Flown<'_>]) -> Vec<SlopeRow> {
    if flown.iter().any(|(_, aero)| aero.settings.thrust == ThrustTreatment::Included) {
        return Vec::new();
    }
    let polar = |(_, aero): &Flown<'_>| {
        let at = |coefficient: Coefficient| aero.coefficients.get(coefficient);
        Some((at(Coefficient::CD).to_vec(), at(Coefficient::CL).iter().map(|lift| lift * lift).collect::<Vec<f64>>()))
    };
    let square: Column<'_> = &|window| polar(window).map(|(_, square)| square);
    let drag: Column<'_> = &|window| polar(window).map(|(drag, _)| drag);
    let (x, y) = columns(flown, square, drag);
    // One constant for all: the drag without lift.
    let rows: Vec<(usize, f64)> = x.iter().flatten().map(|value| (0, *value)).collect();
    let Some(found) = least_squares(&rows, &y.concat()) else { return Vec::new() };
    let samples = rows.len();
    let row = |name, (value, standard_error)| SlopeRow { name, unit: "", value, standard_error, model: None, samples };
    vec![row("drag coefficient without lift", found[0]), row("drag per lift squared", found[1])]
}

fn load_factor(aero: &WindowAero, gravity_m_s2: f64) -> Option<Vec<f64>> {
    let [_, _, z] = specific_force_at_cg(&aero.data, &aero.settings).ok()?;
    Some(z.iter().map(|z| -z / gravity_m_s2).collect())
}

/// Bank at which the flight would be straight: gravity then holds the side force, `sin(bank) = -ay / g`.
fn straight_bank(aero: &WindowAero, gravity_m_s2: f64) -> Option<Vec<f64>> {
    let [_, side, _] = specific_force_at_cg(&aero.data, &aero.settings).ok()?;
    Some(side.iter().map(|side| (-side / gravity_m_s2).clamp(-1.0, 1.0).asin()).collect())
}

/// Load factor at the median dynamic pressure of all manoeuvres: the lift of a turn follows from both.
fn load_at_pressure(aero: &WindowAero, gravity_m_s2: f64, median_pa: f64) -> Option<Vec<f64>> {
    let load = load_factor(aero, gravity_m_s2)?;
    let pressure_pa = pressure_pa(aero);
    Some(load.iter().zip(pressure_pa).map(|(load, own)| load * median_pa / own).collect())
}

fn pressure_pa(aero: &WindowAero) -> Vec<f64> {
    let pairs = aero.data.density_kg_m3.iter().zip(&*aero.data.airspeed_m_s);
    pairs.map(|(density, airspeed)| 0.5 * density * airspeed * airspeed).collect()
}

/// Two columns of every window that has both, as means over [`MEAN_S`].
fn columns(flown: &[Flown<'_>], x: Column<'_>, y: Column<'_>) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let pairs = flown.iter().filter_map(|window| {
        let step_s = median_step(&window.1.data.time_s)?;
        let samples = (MEAN_S / step_s).round().max(1.0) as usize;
        let (x, y) = (x(window)?, y(window)?);
        (x.len() == y.len()).then(|| (means(&x, samples), means(&y, samples)))
    });
    pairs.unzip()
}

/// The columns where the variable is held: its change from the value before to the one behind is below a tenth of its range.
fn steady_parts((x, y): (Vec<Vec<f64>>, Vec<Vec<f64>>)) -> impl Iterator<Item = (Vec<f64>, Vec<f64>)> {
    /// Part of the range.
    const HELD: f64 = 0.1;
    x.into_iter().zip(y).map(|(x, y)| {
        let (low, high) =
            x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let held = |k: usize| {
            let change = x[(k + 1).min(x.len() - 1)] - x[k.saturating_sub(1)];
            change.abs() <= HELD * (high - low)
        };
        (0..x.len()).filter(|k| held(*k)).map(|k| (x[k], y[k])).unzip()
    })
}

/// Time over which samples become one value, s: in steady flight nothing changes faster, and gusts and the noise of the variable, which would
/// make a slope too small, are averaged.
const MEAN_S: f64 = 2.0;

/// Means of so many samples each; what is left at the end is left out.
fn means(values: &[f64], samples: usize) -> Vec<f64> {
    values.chunks_exact(samples).map(|part| part.iter().sum::<f64>() / samples as f64).collect()
}

/// Slope of `y` over `x` with a constant of its own in every window.
fn slope(
    name: &'static str,
    unit: &'static str,
    flown: &[Flown<'_>],
    x: Column<'_>,
    y: Column<'_>,
    model: Option<f64>,
) -> Option<SlopeRow> {
    let (x, y): (Vec<_>, Vec<_>) = steady_parts(columns(flown, x, y)).unzip();
    let rows: Vec<(usize, f64)> =
        x.iter().enumerate().flat_map(|(index, values)| values.iter().map(move |value| (index, *value))).collect();
    let (value, standard_error) = least_squares(&rows, &y.concat())?.last().copied()?;
    Some(SlopeRow { name, unit, value, standard_error, model, samples: rows.len() })
}

/// Least squares of `y` by a constant per window and one slope: the constants, then the slope, each with its standard error. Residuals of
/// steady flight are correlated in time: errors are those of white residuals times `sqrt((1 + r) / (1 - r))`, `r` their lag-one correlation.
fn least_squares(rows: &[(usize, f64)], y: &[f64]) -> Option<Vec<(f64, f64)>> {
    /// Largest correlation that is taken: beyond it a record holds one independent value.
    const MOST: f64 = 0.9999;
    /// Least sum of squares of the variable about its means, as a part of that about zero: below it is rounding.
    const LEAST_MOTION: f64 = 1e-12;
    let constants = rows.iter().map(|(window, _)| window + 1).max()?;
    let (samples, parameters) = (rows.len(), constants + 1);
    if samples <= parameters || samples != y.len() {
        return None;
    }
    let x = DMatrix::from_fn(samples, parameters, |row, column| {
        let (window, value) = rows[row];
        if column < constants { f64::from(u8::from(column == window)) } else { value }
    });
    let y = DVector::from_column_slice(y);
    let information = x.transpose() * &x;
    let inverse = information.clone().cholesky()?.inverse();
    if inverse[(constants, constants)] * information[(constants, constants)] * LEAST_MOTION > 1.0 {
        return None;
    }
    let estimate = &inverse * (x.transpose() * &y);
    let residual = &y - &x * &estimate;
    let variance = residual.norm_squared() / (samples - parameters) as f64;
    let lagged: f64 = residual.iter().zip(residual.iter().skip(1)).map(|(a, b)| a * b).sum();
    let correlation = (lagged / residual.norm_squared()).clamp(0.0, MOST);
    let inflation = if correlation.is_finite() { ((1.0 + correlation) / (1.0 - correlation)).sqrt() } else { 1.0 };
    let error = |index: usize| (variance * inverse[(index, index)]).sqrt() * inflation;
    let found: Vec<(f64, f64)> = (0..parameters).map(|index| (estimate[index], error(index))).collect();
    found.iter().all(|(value, error)| value.is_finite() && error.is_finite()).then_some(found)
}

/// The identified derivatives with the mean condition of the manoeuvres.
struct Model<'a> {
    snapshot: &'a Snapshot,
    airspeed_m_s: f64,
    pressure_area_n: f64,
    weight_n: f64,
    pitch_rate_length_m: f64,
    load_factor: f64,
    gravity_m_s2: f64,
}

impl<'a> Model<'a> {
    fn measure(flown: &[Flown<'_>], snapshot: &'a Snapshot, gravity_m_s2: f64) -> Option<Self> {
        let (_, first) = flown.first()?;
        let all = |value: &dyn Fn(&WindowAero) -> Vec<f64>| -> Option<f64> {
            median(&mut flown.iter().flat_map(|(_, aero)| value(aero)).collect::<Vec<f64>>())
        };
        let airspeed_m_s = all(&|aero| aero.data.airspeed_m_s.to_vec())?;
        let density = all(&|aero| aero.data.density_kg_m3.to_vec())?;
        let reference = &first.settings.reference;
        Some(Self {
            snapshot,
            airspeed_m_s,
            pressure_area_n: 0.5 * density * airspeed_m_s * airspeed_m_s * reference.area_m2,
            weight_n: first.data.mass.first()?.mass_kg * gravity_m_s2,
            pitch_rate_length_m: reference.pitch_rate_length_m,
            load_factor: all(&|aero| load_factor(aero, gravity_m_s2).unwrap_or_default())?,
            gravity_m_s2,
        })
    }

    fn derivative(&self, name: &str) -> Option<f64> {
        derivative(self.snapshot, name)
    }

    /// Rudder, aileron and bank per sideslip without rolling and yawing moment.
    fn sideslip(&self) -> Option<[f64; 3]> {
        let of = |name: &str| self.derivative(name);
        let [rudder, aileron] = straight_deflections(self.snapshot)?;
        let side =
            of("CY_beta")? + of("CY_delta_r").unwrap_or(0.0) * rudder + of("CY_delta_a").unwrap_or(0.0) * aileron;
        Some([rudder, aileron, -self.pressure_area_n * side / self.weight_n])
    }

    /// Angle of attack and elevator per load factor in a turn at constant airspeed.
    fn turn(&self) -> Option<[f64; 2]> {
        let of = |name: &str| self.derivative(name);
        let controls =
            Matrix2::new(of("CZ_alpha")?, of("CZ_delta_e").unwrap_or(0.0), of("Cm_alpha")?, of("Cm_delta_e")?);
        let turning = self.gravity_m_s2 / self.airspeed_m_s * (1.0 + self.load_factor.powi(-2));
        let rate = turning * self.pitch_rate_length_m / self.airspeed_m_s;
        let force = self.weight_n / self.pressure_area_n + of("CZ_q").unwrap_or(0.0) * rate;
        let moment = of("Cm_q").unwrap_or(0.0) * rate;
        Some((controls.try_inverse()? * -Vector2::new(force, moment)).into())
    }
}

/// An identified derivative.
fn derivative(snapshot: &Snapshot, name: &str) -> Option<f64> {
    let pooled = snapshot.pooled.ready()?;
    pooled.fits.iter().find_map(|fit| Some(fit.fit.as_ref().ok()?.parameter(name)?.0))
}

/// Rudder and aileron per sideslip at which the identified model has neither rolling nor yawing moment.
pub(super) fn straight_deflections(snapshot: &Snapshot) -> Option<[f64; 2]> {
    let of = |name: &str| derivative(snapshot, name);
    let controls =
        Matrix2::new(of("Cl_delta_r")?, of("Cl_delta_a")?, of("Cn_delta_r")?, of("Cn_delta_a").unwrap_or(0.0));
    Some((controls.try_inverse()? * -Vector2::new(of("Cl_beta")?, of("Cn_beta")?)).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_over_windows_with_constants_of_their_own_is_that_of_the_line() {
        // y = 0.2 + 3 x and y = -0.7 + 3 x with residuals of alternating sign, which are not correlated.
        let mut rows = Vec::new();
        let mut y = Vec::new();
        for (window, constant) in [(0, 0.2), (1, -0.7)] {
            for k in 0..100 {
                let x = 0.01 * f64::from(k);
                let noise = if k % 2 == 0 { 0.01 } else { -0.01 };
                rows.push((window, x));
                y.push(constant + 3.0 * x + noise);
            }
        }
        let found = least_squares(&rows, &y).unwrap();
        assert!((found[2].0 - 3.0).abs() < 1e-3 && (found[0].0 - 0.2).abs() < 3e-3 && (found[1].0 + 0.7).abs() < 3e-3);
        // Deviation over the root of the sum of squares about the means: 0.01 / sqrt(2 * 100 * 0.083325).
        let expected = 0.01 * (200.0_f64 / 197.0).sqrt() / (2.0_f64 * 100.0 * 0.083_325).sqrt();
        assert!((found[2].1 / expected - 1.0).abs() < 1e-3, "{} for {expected}", found[2].1);
        assert_eq!(least_squares(&rows[..2], &y[..2]), None);
        assert_eq!(means(&[1.0, 3.0, 5.0, 9.0, 7.0], 2), [2.0, 7.0]);
        // Without motion there is no slope.
        let still: Vec<(usize, f64)> = (0..50).map(|_| (0, 1.0)).collect();
        assert_eq!(least_squares(&still, &[0.0; 50]), None);
    }

    #[test]
    fn cards_of_steady_flight_are_known_by_their_kind() {
        assert!(Steady::of_kind("Steady sideslip") == Some(Steady::Sideslip));
        assert!(Steady::of_kind("wind-up turn") == Some(Steady::Turn));
        assert!(Steady::of_kind("level acceleration") == Some(Steady::Acceleration));
        assert!(Steady::of_kind("doublet").is_none());
    }
}
