//! What a derivative depends on that no flight shows wrong: mass, inertia, the scale of a deflection, the position of the accelerometers.

use doublet_core::model::{Coefficient, Term, Variable};
use nalgebra::Vector3;
use serde::Serialize;

use super::StatedQuantity;
use crate::session::{Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::CoefficientFit;

/// Step of a position, m.
const STEP_M: f64 = 0.1;

/// Change of a derivative with one stated value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dependence {
    /// Stated value, for example `Iyy`, `elevator deflection` or `accelerometer position, forward`.
    pub on: String,
    /// Source of the value: `aircraft file`, `recording`, `assumed at the centre of gravity`.
    pub source: &'static str,
    /// Step of the value: `1 %` or `0.1 m`.
    pub step: &'static str,
    /// Change of the derivative for this step, per cent.
    pub change_percent: f64,
    /// Axis of the position of the accelerometers; none of another value.
    #[serde(skip)]
    pub axis: Option<&'static str>,
}

impl std::fmt::Display for Dependence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { on, source, step, change_percent, .. } = self;
        write!(f, "{on} ({source}): {step} more changes it by {change_percent:+.1} %")
    }
}

/// What a pooled derivative depends on: the mass or inertia to which it is proportional, the deflection to which it is inversely
/// proportional, and for forces, derivatives to rates aside, the position of the accelerometers.
pub fn dependences(session: &Session, snapshot: &Snapshot, fit: &CoefficientFit, name: &str) -> Vec<Dependence> {
    let stated = super::stated_quantity(snapshot, fit).map(
        |StatedQuantity { quantity, source, percent_per_percent, .. }| Dependence {
            on: quantity.to_owned(),
            source,
            step: "1 %",
            change_percent: percent_per_percent,
            axis: None,
        },
    );
    let terms = session.structure.terms(fit.coefficient).unwrap_or_default();
    let term = terms.iter().find(|term| term.derivative_name(fit.coefficient) == name);
    let powers = term.into_iter().flat_map(|term| term.factors());
    let deflection = powers.filter_map(|(variable, power)| {
        let surface = Surface::ALL.into_iter().find(|surface| surface.variable() == *variable)?;
        let (on, change_percent) = (format!("{} deflection", surface.name()), -f64::from(*power));
        Some(Dependence { on, source: "recording", step: "1 %", change_percent, axis: None })
    });
    let moved = term.filter(|term| !term.is_constant() && !has_rate(term));
    let position = moved.and_then(|term| accelerometer_position(session, snapshot, fit, term));
    stated.into_iter().chain(deflection).chain(position).collect()
}

/// Whether a term has an angular rate. The position of the accelerometers also changes the flight path, which moves derivatives to rates by
/// as much: CZ_q of a light aircraft by 22 %, where the angular acceleration alone gives 40 %.
fn has_rate(term: &Term) -> bool {
    let rates = [Variable::RollRate, Variable::PitchRate, Variable::YawRate, Variable::HalfPitchRate];
    term.factors().iter().any(|(variable, _)| rates.contains(variable))
}

/// Change of a force derivative with the stated position of the accelerometers, along the axis where it is largest.
///
/// A position stated `d` too far along an axis leaves `omega_dot x d` in the specific force. The angular acceleration per unit of a term is
/// `q S J^-1 [b Cl, c Cm, b Cn]` with the moment derivatives of the same term, so that the dynamic pressure cancels:
/// `dC = -m (J^-1 [b Cl, c Cm, b Cn]) x d`.
fn accelerometer_position(
    session: &Session,
    snapshot: &Snapshot,
    fit: &CoefficientFit,
    term: &Term,
) -> Option<Dependence> {
    const DIRECTIONS: [&str; 3] = ["forward", "right", "down"];
    let component = match fit.coefficient {
        Coefficient::CX => 0,
        Coefficient::CY => 1,
        Coefficient::CZ => 2,
        _ => return None,
    };
    let estimate_of = |fit: &CoefficientFit| {
        let (found, name) = (fit.fit.as_ref().ok()?, term.derivative_name(fit.coefficient));
        found.names.iter().position(|own| *own == name).map(|at| found.estimates[at])
    };
    let estimate = estimate_of(fit).filter(|estimate| *estimate != 0.0)?;
    let pooled = snapshot.pooled.ready()?;
    let moment = |coefficient: Coefficient| estimate_of(pooled.fits.iter().find(|fit| fit.coefficient == coefficient)?);
    let moments = [Coefficient::Cl, Coefficient::Cm, Coefficient::Cn].map(moment);
    if moments.iter().all(Option::is_none) {
        return None;
    }
    let mass = super::mean_mass(snapshot, fit)?;
    let aircraft = &snapshot.aircraft.ready()?.aircraft;
    let reference = &aircraft.reference;
    let lengths = [reference.lateral_moment_length_m, reference.chord_m, reference.lateral_moment_length_m];
    let moments = Vector3::from_fn(|at, _| lengths[at] * moments[at].unwrap_or(0.0));
    let turning = mass.inertia.matrix().try_inverse()? * moments;
    let changes = std::array::from_fn::<f64, 3, _>(|along| {
        let step = Vector3::ith(along, STEP_M);
        -mass.mass_kg * turning.cross(&step)[component]
    });
    let along = (0..3).max_by(|a, b| changes[*a].abs().total_cmp(&changes[*b].abs()))?;
    let change_percent = 100.0 * changes[along] / estimate;
    let is_stated = session.preparation.correct_accelerometer && aircraft.sensors.accelerometer_from_datum_m.is_some();
    let source = if is_stated { "aircraft file" } else { "assumed at the centre of gravity" };
    let (axis, step) = (DIRECTIONS[along], "0.1 m");
    let on = format!("accelerometer position, {axis}");
    Some(Dependence { on, source, step, change_percent, axis: Some(axis) })
}
