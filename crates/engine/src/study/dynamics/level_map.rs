//! Levels of flying qualities at every condition that was flown.

use doublet_dynamics::linear::{FlightModel, Linearised, Method, linearise};
use doublet_dynamics::qualities::{Airplane, Judgement, Limits, Measures, judge};

use super::StudyInput;
use super::trim::Flown;
use crate::stage::{StudyWindow, measure_condition};

/// How near manoeuvres of one condition are: airspeed, m/s, and altitude, m.
const NEAR: [f64; 2] = [3.0, 150.0];

/// The levels at one condition.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// True airspeed of the trim, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    pub mass_kg: f64,
    /// Manoeuvres flown there.
    pub windows: Vec<String>,
    /// Levels of the model trimmed there.
    pub judgement: Judgement,
}

/// The identified model trimmed in level flight at the median condition of each group of manoeuvres that lie near each other, the slowest
/// first; a group without a trim is left out.
pub(super) fn level_map(
    input: &StudyInput<'_>,
    model: &FlightModel,
    judged_by: (&Limits, &Airplane),
    measured: &dyn Fn(&Linearised) -> Measures,
) -> Vec<MapPoint> {
    let mut points: Vec<MapPoint> =
        groups(input).iter().filter_map(|group| judge_group(group, input, model, judged_by, measured)).collect();
    points.sort_by(|a, b| a.airspeed_m_s.total_cmp(&b.airspeed_m_s));
    points
}

/// Levels of the model at the median condition of a group; none without a trim.
fn judge_group(
    group: &[&StudyWindow<'_>],
    input: &StudyInput<'_>,
    model: &FlightModel,
    (limits, airplane): (&Limits, &Airplane),
    measured: &dyn Fn(&Linearised) -> Measures,
) -> Option<MapPoint> {
    let flown = Flown::new(group.iter().map(|window| &*window.aero));
    let engines = &input.aircraft.loaded.powerplant.engines;
    let gravity = input.settings.filter.gravity_m_s2;
    let condition = if model.has_thrust() {
        flown.level_condition(model, engines, gravity).ok()?
    } else {
        flown.condition(gravity, None).ok()?
    };
    let linearised = linearise(model, &condition, Method::Analytic).ok()?;
    Some(MapPoint {
        airspeed_m_s: condition.airspeed_m_s,
        altitude_m: condition.altitude_m,
        mass_kg: condition.mass.mass_kg,
        windows: group.iter().map(|window| window.manoeuvre.name.clone()).collect(),
        judgement: judge(limits, airplane, &measured(&linearised)),
    })
}

/// Manoeuvres by condition: each joins the first group whose first manoeuvre is near.
fn groups<'a, 'b>(input: &'a StudyInput<'b>) -> Vec<Vec<&'a StudyWindow<'b>>> {
    let mut groups: Vec<([f64; 2], Vec<&StudyWindow<'b>>)> = Vec::new();
    for window in input.windows {
        let Some(found) = measure_condition(&window.aero) else { continue };
        let place = [found.airspeed_m_s, found.altitude_m.unwrap_or(0.0)];
        let near = |other: &[f64; 2]| (0..2).all(|axis| (other[axis] - place[axis]).abs() <= NEAR[axis]);
        match groups.iter_mut().find(|(other, _)| near(other)) {
            Some((_, own)) => own.push(window),
            None => groups.push((place, vec![window])),
        }
    }
    groups.into_iter().map(|(_, own)| own).collect()
}
