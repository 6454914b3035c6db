//! What derivatives of an aeroplane may be: ranges as data, brought to the form the session's derivatives have.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use doublet_core::airframe::ReferenceGeometry;
use doublet_core::model::{Axes, Coefficient, RECORDED, Term, Variable};
use doublet_core::quantity::{Dimension, Role};
use doublet_core::toml_error;
use serde::Deserialize;

use super::judge::Evidence;
use crate::builtin;
use crate::session::{PlausibleRange, Session};
use crate::snapshot::Snapshot;
use crate::stage::{CoefficientFit, WindowAero};

/// The ranges that come with the program.
const BUILTIN: &str = "conventional";

/// Lift slope of an aeroplane over that of its wing alone: body and tail add, a swept wing has less, the speed of sound more.
const LIFT_SLOPE: [f64; 2] = [0.6, 1.6];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    #[serde(rename = "format")]
    _format: String,
    name: String,
    #[serde(rename = "source")]
    _source: String,
    other: PlausibleRange,
    range: BTreeMap<String, PlausibleRange>,
}

static TABLE: LazyLock<Result<FileTable, String>> = LazyLock::new(|| {
    let text = builtin::text("plausible", BUILTIN).ok_or_else(|| format!("plausible ranges '{BUILTIN}' not found"))?;
    toml::from_str(text).map_err(|error| toml_error::one_line(text, &error))
});

/// A range in the form of a derivative of the session.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) sign_certain: bool,
    /// Where it comes from, and whether that is the session.
    pub(super) source: &'static str,
    pub(super) is_stated: bool,
}

/// How far a value is outside its range.
pub(super) struct Outside {
    /// Distance to the nearer end.
    pub(super) beyond: f64,
    /// The same in widths of the range.
    pub(super) widths: f64,
    /// Whether it has the wrong sign where the sign is certain.
    pub(super) wrong_sign: bool,
}

impl Range {
    /// How far `value` is outside; none inside.
    pub(super) fn outside(&self, value: f64) -> Option<Outside> {
        let beyond = (self.low - value).max(value - self.high);
        if beyond <= 0.0 {
            return None;
        }
        let wrong_sign = self.sign_certain && value * (self.low + self.high) < 0.0;
        Some(Outside { beyond, widths: beyond / (self.high - self.low).max(f64::MIN_POSITIVE), wrong_sign })
    }
}

/// An interval, or the sum of several.
#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    const ZERO: Self = Self { low: 0.0, high: 0.0 };

    fn times(self, factor: f64) -> Self {
        let (a, b) = (self.low * factor, self.high * factor);
        Self { low: a.min(b), high: a.max(b) }
    }

    fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }
}

/// The ranges of a session: those that come with the program, in the form its derivatives have, unless it states its own.
pub(super) struct Plausible {
    own: BTreeMap<String, PlausibleRange>,
    geometry: Option<ReferenceGeometry>,
}

impl Plausible {
    pub(super) fn new(session: &Session, snapshot: &Snapshot) -> Self {
        let aircraft = snapshot.aircraft.ready();
        Self { own: session.plausible.clone(), geometry: aircraft.map(|loaded| loaded.aircraft.reference) }
    }

    /// Range of the derivative `name` of a fit; none for a constant, for a term that is a product and for an aircraft not known.
    pub(super) fn range(&self, name: &str, fit: &CoefficientFit, evidence: Evidence<'_>) -> Option<Range> {
        if let Some(&PlausibleRange { low, high, sign_certain }) = self.own.get(name) {
            return Some(Range { low, high, sign_certain, source: "stated in the session", is_stated: true });
        }
        let terms = evidence.session.structure.terms(fit.coefficient)?;
        let term = terms.iter().find(|term| term.derivative_name(fit.coefficient) == name)?;
        let aero = fit.windows.iter().find_map(|(window, _)| evidence.snapshot.windows.get(window)?.aero.ready())?;
        let geometry = self.geometry.as_ref()?;
        Form { geometry, aero }.range(fit.coefficient, term)
    }
}

/// The form the derivatives of a session have.
struct Form<'a> {
    geometry: &'a ReferenceGeometry,
    aero: &'a WindowAero,
}

impl Form<'_> {
    fn range(&self, coefficient: Coefficient, term: &Term) -> Option<Range> {
        let table = TABLE.as_ref().ok()?;
        let &[(variable, power)] = term.factors() else { return None };
        let stated = table.range.get(&canonical(coefficient, variable, power));
        let interval = match (power, stated) {
            (1, _) => self.along_axes(coefficient, variable)?,
            (_, Some(range)) => Interval { low: range.low, high: range.high },
            (_, None) => return None,
        };
        let interval = match (coefficient, variable, power) {
            (Coefficient::CZ | Coefficient::CL, Variable::Alpha, 1) => self.lift_slope(coefficient, interval),
            _ => interval,
        };
        let Interval { low, high } = interval.times(self.scale(coefficient, variable, power));
        let sign_certain = stated.is_some_and(|range| range.sign_certain) && low * high >= 0.0;
        Some(Range { low, high, sign_certain, source: &table.name, is_stated: false })
    }

    /// The range of a lift slope about that of a wing of this aspect ratio in incompressible flow, `2 pi A / (2 + sqrt(4 + A^2))`
    /// (Helmbold), where that is inside the range of all aeroplanes: mass, area and airspeed in a wrong unit leave it.
    fn lift_slope(&self, coefficient: Coefficient, all: Interval) -> Interval {
        let aspect = self.geometry.span_m.powi(2) / self.geometry.area_m2;
        let slope = std::f64::consts::TAU * aspect / (2.0 + (4.0 + aspect * aspect).sqrt());
        let sign = if coefficient == Coefficient::CZ { -1.0 } else { 1.0 };
        let wing = Interval { low: LIFT_SLOPE[0] * slope, high: LIFT_SLOPE[1] * slope }.times(sign);
        let (low, high) = (all.low.max(wing.low), all.high.min(wing.high));
        if low < high { Interval { low, high } } else { all }
    }

    /// Factor from the form of the file to that of the session: lengths of moments and rates.
    fn scale(&self, coefficient: Coefficient, variable: Variable, power: i32) -> f64 {
        let ReferenceGeometry {
            span_m,
            chord_m,
            lateral_moment_length_m,
            lateral_rate_length_m,
            pitch_rate_length_m,
            ..
        } = *self.geometry;
        let moment = match coefficient {
            Coefficient::Cl | Coefficient::Cn => span_m / lateral_moment_length_m,
            _ => 1.0,
        };
        let rate = match variable {
            Variable::RollRate | Variable::YawRate | Variable::BetaDot => 0.5 * span_m / lateral_rate_length_m,
            Variable::PitchRate | Variable::AlphaDot => chord_m / pitch_rate_length_m,
            Variable::HalfPitchRate => 2.0,
            _ => 1.0,
        };
        moment * rate.powi(power)
    }

    /// Derivative in the axes of the session: in stability axes `Cl`, `Cn`, `p` and `r` are turned about y by the mean angle of attack.
    fn along_axes(&self, coefficient: Coefficient, variable: Variable) -> Option<Interval> {
        let alpha = &self.aero.data.alpha_rad;
        let turned = self.aero.settings.axes == Axes::Stability;
        let (sin, cos) = if turned { (alpha.iter().sum::<f64>() / alpha.len() as f64).sin_cos() } else { (0.0, 1.0) };
        let coefficients = match coefficient {
            Coefficient::Cl => vec![(Coefficient::Cl, cos), (Coefficient::Cn, sin)],
            Coefficient::Cn => vec![(Coefficient::Cn, cos), (Coefficient::Cl, -sin)],
            other => vec![(other, 1.0)],
        };
        let variables = match variable {
            Variable::RollRate => vec![(Variable::RollRate, cos), (Variable::YawRate, sin)],
            Variable::YawRate => vec![(Variable::YawRate, cos), (Variable::RollRate, -sin)],
            other => vec![(other, 1.0)],
        };
        let mut sum = Interval::ZERO;
        for &(coefficient, share) in coefficients.iter().filter(|(_, share)| *share != 0.0) {
            for &(variable, part) in variables.iter().filter(|(_, part)| *part != 0.0) {
                sum = sum.plus(self.about_reference(coefficient, variable)?.times(share * part));
            }
        }
        Some(sum)
    }

    /// Derivative about the moment reference of the session: at `d` from the centre of gravity the moment is less by `d x F`.
    fn about_reference(&self, coefficient: Coefficient, variable: Variable) -> Option<Interval> {
        let about_cg = stated(coefficient, variable)?;
        let Some([x, _, z]) = self.reference_from_cg_m() else { return Some(about_cg) };
        let ReferenceGeometry { span_m, chord_m, .. } = *self.geometry;
        let force = |force: Coefficient, arm: f64| match stated(force, variable) {
            Some(range) if arm != 0.0 => range.times(arm),
            _ => Interval::ZERO,
        };
        let moved = match coefficient {
            Coefficient::Cl => force(Coefficient::CY, z / span_m),
            Coefficient::Cm => force(Coefficient::CX, -z / chord_m).plus(force(Coefficient::CZ, x / chord_m)),
            Coefficient::Cn => force(Coefficient::CY, -x / span_m),
            _ => Interval::ZERO,
        };
        Some(about_cg.plus(moved))
    }

    /// The moment reference from the centre of gravity in body axes, m; none where it is the centre of gravity.
    fn reference_from_cg_m(&self) -> Option<[f64; 3]> {
        let position = self.aero.settings.moment_reference.as_ref()?;
        Some(position.body_from_cg_m(self.aero.data.mass.first()?.cg_from_datum_m))
    }
}

/// Name of a derivative in the file.
fn canonical(coefficient: Coefficient, variable: Variable, power: i32) -> String {
    let variable = if variable == Variable::HalfPitchRate { Variable::PitchRate } else { variable };
    Term::product([(variable, power)]).derivative_name(coefficient)
}

/// Range of a derivative by one variable as the file states it.
fn stated(coefficient: Coefficient, variable: Variable) -> Option<Interval> {
    // What is not a small number by itself has a derivative of any size.
    let any = |(known, role): &(Variable, Role)| *known == variable && role.dimension() == Dimension::Dimensionless;
    let large = [Variable::Airspeed, Variable::Altitude, Variable::Mach, Variable::PropellerPressure];
    if large.contains(&variable) || RECORDED.iter().any(any) {
        return None;
    }
    let table = TABLE.as_ref().ok()?;
    let range = table.range.get(&canonical(coefficient, variable, 1)).unwrap_or(&table.other);
    Some(Interval { low: range.low, high: range.high })
}
