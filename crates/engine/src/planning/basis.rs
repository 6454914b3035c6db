//! What the design of the next inputs starts from: the identified model, the noise its fits left, limits and disturbances as flown.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::MassProperties;
use doublet_core::estimate::Coloured;
use doublet_core::model::{Coefficient, Term, specific_force_at_cg};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Reconstruction, State};
use doublet_core::simulate::Dryden;
use doublet_core::statistics::median_step;
use doublet_dynamics::design::{Basis, CONTROLS, KnownCoefficient, Limit, Limits, Quantity, Start};
use doublet_dynamics::linear::{Condition, UncertainModel};

use crate::graph::{Context, StageResult};
use crate::session::{Estimation, ResidualWeights, Session, Settings, Surface, WindowRole};
use crate::snapshot::Snapshot;
use crate::stage::{AeroWindow, WindowAero, applies, pooled_regressions};
use crate::study::StudyInput;
use crate::study::dynamics::level_model;

/// The surfaces of a design, in the order of its deflections; the throttle follows them.
const SURFACES: [(Surface, Role); 3] =
    [(Surface::Aileron, Role::Aileron), (Surface::Elevator, Role::Elevator), (Surface::Rudder, Role::Rudder)];

/// Draws of the derivatives over which a search takes the mean cost, beside the estimate.
pub const SEARCH_SAMPLES: usize = 2;

/// What is asked for in the place of what was flown.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignOptions {
    /// Largest deflection of every surface from the trim, rad; that of the windows unless given.
    pub peak_rad: Option<f64>,
    /// Fastest deflection, rad/s.
    pub rate_rad_s: f64,
    /// Largest change of the thrust by an input of the throttle, N; a fifth of that of the trim unless given.
    pub peak_thrust_n: Option<f64>,
    /// Limits in the place of those flown.
    pub limits: Vec<(Quantity, f64, f64)>,
    /// Standard deviation of the gusts, m/s; that of the filter's random walk of the wind unless given.
    pub gust_m_s: Option<f64>,
}

impl Default for DesignOptions {
    /// Limits as flown; deflections no faster than a hand at ease, 60 deg/s.
    fn default() -> Self {
        Self { peak_rad: None, rate_rad_s: 60f64.to_radians(), peak_thrust_n: None, limits: Vec::new(), gust_m_s: None }
    }
}

/// A window with the path its coefficients were formed from.
pub type FlownWindow<'a> = (AeroWindow<'a>, &'a Reconstruction);

/// What a design starts from, of a session that was run with the study of its dynamics.
pub fn design_basis(session: &Session, snapshot: &Snapshot, options: &DesignOptions) -> StageResult<Basis> {
    let study = snapshot.studies.dynamics.ready();
    let study =
        study.ok_or("no model to design with: the session needs an aircraft and an identification manoeuvre")?;
    let windows: Vec<FlownWindow<'_>> = snapshot
        .aero(session)
        .into_iter()
        .filter_map(|(window, aero)| {
            let path = snapshot.windows.get(&window.name)?.path.ready()?;
            Some(((window, aero), &path.reconstruction))
        })
        .collect();
    basis(session.settings(), &windows, (&study.model, &study.condition), options)
}

/// What a design starts from, of everything a study looks at: the model trimmed at the median condition of the identification windows.
pub fn basis_of(input: &StudyInput<'_>, options: &DesignOptions, context: &Context<'_>) -> StageResult<Basis> {
    let (model, condition) = level_model(input, context)?;
    let windows = input.windows.iter();
    let windows = windows.map(|window| ((window.manoeuvre, window.aero.shared().clone()), &window.path.reconstruction));
    basis(input.settings, &windows.collect::<Vec<_>>(), (&model, &condition), options)
}

/// The estimation without the whitening of its residuals: a design predicts ordinary least squares of the inputs it makes.
fn as_measured(estimation: &Estimation) -> Estimation {
    match estimation.weights {
        ResidualWeights::Autoregression(_) => Estimation { weights: ResidualWeights::Equal, ..estimation.clone() },
        _ => estimation.clone(),
    }
}

/// [`design_basis`] of windows, a model and a condition.
pub fn basis(
    settings: Settings<'_>,
    windows: &[FlownWindow<'_>],
    (model, condition): (&UncertainModel, &Condition),
    options: &DesignOptions,
) -> StageResult<Basis> {
    let aero: Vec<AeroWindow<'_>> = windows.iter().map(|(window, _)| (window.0, window.1.clone())).collect();
    let first = aero.iter().find(|(window, _)| window.role == WindowRole::Identification);
    let (_, first) = first.ok_or("no model to design with: no identification manoeuvre has coefficients")?;
    let step_s = median_step(&first.data.time_s).ok_or("the manoeuvres have too few samples")?;
    let mut coefficients = Vec::new();
    for regression in pooled_regressions(&aero, settings.structure, &as_measured(settings.estimation)) {
        // A coefficient without a fit is not designed for; its failure is told where it is fitted.
        let Ok(regression) = regression else { continue };
        let coefficient = regression.coefficient;
        let pooled = regression.pooled;
        let Ok(fit) = pooled.fit() else { continue };
        let noise = fit.residual_noise(&pooled.windows, &Coloured::default());
        let noise = noise.map_err(|error| format!("{}: {error}", coefficient.name()))?;
        let all = settings.structure.terms(coefficient).unwrap_or_default();
        let named = |name: &String| all.iter().find(|term| term.derivative_name(coefficient) == *name).cloned();
        let terms: Vec<Term> = pooled.names.iter().filter_map(named).collect();
        coefficients.push(KnownCoefficient {
            coefficient,
            terms,
            per_window: pooled.per_window,
            constraints: pooled.constraints,
            noise,
            flown: pooled.windows,
            tells: tells(coefficient, settings.estimation),
        });
    }
    if coefficients.is_empty() {
        return Err("no model to design with: no coefficient has a pooled fit".into());
    }
    let walks = [State::WindNorth, State::WindEast, State::WindDown].map(|s| settings.filter.random_walk[s as usize]);
    let walk = (walks.iter().map(|walk| walk * walk).sum::<f64>() / 3.0).sqrt();
    let gust_m_s = options.gust_m_s.unwrap_or_else(|| Dryden::deviation_of_walk(walk, condition.airspeed_m_s));
    let flown: Vec<Motion> =
        windows.iter().filter_map(|window| Motion::measure(window, condition.gravity_m_s2)).collect();
    Ok(Basis {
        model: model.clone(),
        condition: *condition,
        coefficients,
        settings: first.settings.clone(),
        step_s,
        gust_m_s,
        starts: starts(&flown, model, condition),
        limits: limits(&flown, model, condition, options)?,
    })
}

/// Whether a manoeuvre of one control alone is for a coefficient: the throttle moves the aircraft as the elevator does.
pub(super) fn tells(coefficient: Coefficient, estimation: &Estimation) -> [bool; CONTROLS] {
    let [aileron, elevator, rudder] = SURFACES.map(|(surface, _)| applies(coefficient, Some(surface), estimation));
    [aileron, elevator, rudder, elevator]
}

/// Motion of a window: each quantity less its mean over the first half second, that mean, and the deflections alike.
struct Motion {
    first: BTreeMap<Quantity, f64>,
    range: BTreeMap<Quantity, (f64, f64)>,
    rates_rad_s: [f64; 3],
    pitch_less_alpha_rad: Option<f64>,
    peaks_rad: [f64; 3],
    controls_rad: [f64; 3],
    thrust_n: Option<f64>,
    mass: MassProperties,
}

impl Motion {
    fn first(&self, quantity: Quantity, other: f64) -> f64 {
        self.first.get(&quantity).copied().unwrap_or(other)
    }

    fn measure((window, path): &FlownWindow<'_>, gravity_m_s2: f64) -> Option<Self> {
        let aero: &WindowAero = &window.1;
        let data = &aero.data;
        let samples = data.time_s.len();
        let step_s = median_step(&data.time_s)?;
        let settled = ((0.5 / step_s).round() as usize).clamp(1, samples);
        let mean = |values: &[f64]| values.iter().take(settled).sum::<f64>() / settled as f64;
        let state = |state: State| -> Option<Arc<[f64]>> {
            let states = path.smoothed.as_ref().map_or(&path.states, |smoothed| &smoothed.states);
            let offset = path.time_s.partition_point(|time| *time < data.time_s[0] - 0.5 * step_s);
            let values = states[state as usize].get(offset..offset + samples)?;
            Some(values.into())
        };
        let force = specific_force_at_cg(data, &aero.settings).ok()?;
        let columns = [
            (Quantity::Alpha, Some(Arc::clone(&data.alpha_rad))),
            (Quantity::Beta, Some(Arc::clone(&data.beta_rad))),
            (Quantity::LoadFactor, Some(force[2].iter().map(|z| -z / gravity_m_s2).collect())),
            (Quantity::RollRate, Some(data.rates_rad_s[0].as_slice().into())),
            (Quantity::Airspeed, Some(Arc::clone(&data.airspeed_m_s))),
            (
                Quantity::Altitude,
                data.altitude_m.clone().or_else(|| state(State::PositionDown).map(|down| negated(&down))),
            ),
            (Quantity::Bank, state(State::BankAngle)),
        ];
        let (mut first, mut range) = (BTreeMap::new(), BTreeMap::new());
        for (quantity, values) in columns {
            let Some(values) = values else { continue };
            let about = mean(&values);
            let ends = values.iter().map(|value| value - about);
            let ends = ends.fold((0.0, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
            first.insert(quantity, about);
            range.insert(quantity, ends);
        }
        let peak = |role: Role| {
            let values = data.controls.get(&role).map_or(&[][..], |values| &**values);
            let about = mean(values);
            values.iter().map(|value| (value - about).abs()).fold(0.0, f64::max)
        };
        Some(Self {
            rates_rad_s: data.rates_rad_s.each_ref().map(|rates| mean(rates)),
            pitch_less_alpha_rad: state(State::PitchAngle).map(|theta| mean(&theta) - first[&Quantity::Alpha]),
            peaks_rad: SURFACES.map(|(_, role)| peak(role)),
            controls_rad: SURFACES.map(|(_, role)| data.controls.get(&role).map_or(0.0, |values| mean(values))),
            thrust_n: (!data.engines.is_empty())
                .then(|| data.engines.iter().map(|engine| mean(&engine.thrust_n)).sum::<f64>()),
            mass: *data.mass.first()?,
            first,
            range,
        })
    }
}

fn negated(values: &[f64]) -> Arc<[f64]> {
    values.iter().map(|value| -value).collect()
}

/// How the windows near the condition began, or all of them where none was near, airspeed and altitude then those of the condition: the
/// trim of the model there, and what the window had beside it. Angle of attack, sideslip, bank, path, deflections and thrust are taken about
/// their means over the windows, which are errors of the trim rather than of the hand.
fn starts(flown: &[Motion], model: &UncertainModel, condition: &Condition) -> Vec<Start> {
    /// How far from the condition a window still counts: part of the airspeed, and m.
    const NEAR: (f64, f64) = (0.05, 100.0);
    let speed = |motion: &Motion| motion.first(Quantity::Airspeed, condition.airspeed_m_s);
    let altitude = |motion: &Motion| motion.first(Quantity::Altitude, condition.altitude_m);
    let near = |motion: &&Motion| {
        (speed(motion) / condition.airspeed_m_s - 1.0).abs() < NEAR.0
            && (altitude(motion) - condition.altitude_m).abs() < NEAR.1
    };
    let mut used: Vec<&Motion> = flown.iter().filter(near).collect();
    let is_near = !used.is_empty();
    if !is_near {
        used = flown.iter().collect();
    }
    let mut starts: Vec<Start> = used.iter().filter_map(|motion| start_of(motion, model, condition)).collect();
    let count = starts.len().max(1) as f64;
    for state in [1, 2, 6] {
        let mean = starts.iter().map(|start| start.state[state]).sum::<f64>() / count;
        starts.iter_mut().for_each(|start| start.state[state] -= mean);
    }
    let climb = starts.iter().map(|start| start.path_rad).sum::<f64>() / count;
    starts.iter_mut().for_each(|start| start.path_rad -= climb);
    for surface in 0..3 {
        let mean = starts.iter().map(|start| start.controls_rad[surface]).sum::<f64>() / count;
        starts.iter_mut().for_each(|start| start.controls_rad[surface] -= mean);
    }
    let thrust_n = starts.iter().filter_map(|start| start.thrust_n).sum::<f64>() / count;
    starts.iter_mut().for_each(|start| start.thrust_n = start.thrust_n.map(|own| own - thrust_n));
    for start in &mut starts {
        // The pitch angle goes with the angle of attack.
        start.state[7] += start.state[2] / condition.airspeed_m_s;
        if !is_near {
            (start.airspeed_m_s, start.altitude_m) = (0.0, 0.0);
        }
    }
    starts
}

fn start_of(motion: &Motion, model: &UncertainModel, condition: &Condition) -> Option<Start> {
    let mut there = condition.at_altitude(motion.first(Quantity::Altitude, condition.altitude_m));
    there.airspeed_m_s = motion.first(Quantity::Airspeed, condition.airspeed_m_s);
    there.mass = motion.mass;
    let trim = doublet_dynamics::linear::trim(&model.model, &there).ok()?;
    let [p, q, r] = motion.rates_rad_s;
    let alpha = motion.first(Quantity::Alpha, trim.alpha_rad);
    let (beta, phi) = (motion.first(Quantity::Beta, 0.0), motion.first(Quantity::Bank, 0.0));
    let path = motion.pitch_less_alpha_rad.unwrap_or(0.0);
    let w = there.airspeed_m_s * (alpha - trim.alpha_rad);
    Some(Start {
        airspeed_m_s: there.airspeed_m_s - condition.airspeed_m_s,
        altitude_m: there.altitude_m - condition.altitude_m,
        path_rad: path,
        state: [0.0, there.airspeed_m_s * beta, w, p, q, r, phi, 0.0, 0.0, 0.0, 0.0, 0.0],
        controls_rad: [0, 1, 2].map(|surface| motion.controls_rad[surface] - trim.controls_rad[surface]),
        thrust_n: motion.thrust_n.filter(|_| model.model.has_thrust()).map(|thrust_n| thrust_n - trim.thrust_n),
    })
}

/// Limits about the trim: the motion and deflections that the windows had about their starts, where nothing else is asked for.
fn limits(
    flown: &[Motion],
    model: &UncertainModel,
    condition: &Condition,
    options: &DesignOptions,
) -> StageResult<Limits> {
    /// Part of the largest peak below which a surface counts as never moved.
    const MOVED: f64 = 0.05;
    let trim = doublet_dynamics::linear::trim(&model.model, condition).map_err(|error| error.to_string())?;
    let mut motion = Vec::new();
    for quantity in Quantity::ALL {
        let about = quantity.at_trim(&trim);
        let asked = options.limits.iter().find(|(asked, ..)| *asked == quantity);
        let ranges = flown.iter().filter_map(|motion| motion.range.get(&quantity));
        let (low, high) = ranges.fold((0.0, 0.0), |(low, high): (f64, f64), own| (low.min(own.0), high.max(own.1)));
        match asked {
            Some((_, low, high)) => {
                motion.push(Limit { quantity, low: *low, high: *high, source: "asked for".to_owned() });
            }
            None if low < 0.0 && high > 0.0 => {
                motion.push(Limit { quantity, low: about + low, high: about + high, source: "as flown".to_owned() })
            }
            None => {}
        }
    }
    let peak = |surface: usize| flown.iter().map(|motion| motion.peaks_rad[surface]).fold(0.0, f64::max);
    let largest = (0..SURFACES.len()).map(peak).fold(0.0, f64::max);
    let own = |surface: usize| if peak(surface) < MOVED * largest { largest } else { peak(surface) };
    /// Part of the thrust of the trim that an input of the throttle changes, and the time of the change, s.
    const THRUST: (f64, f64) = (0.2, 1.0);
    let thrust_n = options.peak_thrust_n.unwrap_or(THRUST.0 * trim.thrust_n.abs());
    let [aileron, elevator, rudder] = [0, 1, 2].map(|surface| options.peak_rad.unwrap_or_else(|| own(surface)));
    let rate = options.rate_rad_s;
    Ok(Limits { motion, peaks: [aileron, elevator, rudder, thrust_n], rates: [rate, rate, rate, thrust_n / THRUST.1] })
}
