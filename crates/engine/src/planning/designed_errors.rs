//! What constant errors of the instruments do to a designed flight: its undisturbed motion goes through both steps of the analysis.
//!
//! The slopes of the derivatives depend on the input: a delay of the flow angles or of a deflection does more to a multisine than to a doublet.

use std::sync::Arc;

use doublet_core::prep::{Interpolation, resample};
use doublet_core::reconstruct::{
    FilterData, InputSeries, MEASUREMENTS, MeasurementSeries, Reconstruction, STATES, State,
};
use doublet_core::series::TimeRange;
use doublet_core::statistics::median_step;
use doublet_dynamics::design::{Designed, FlownInput, PlannedManoeuvre, designed_settings, window_data};

use crate::graph::Control;
use crate::session::{Manoeuvre, Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{
    ErrorWindow, PathErrors, WindowAero, aero_along, measurements_of, path_errors, reconstructions, with_gravity,
};

/// Errors of path and sensors of the flight as designed, recorded at the rates of the session; `with_flown` together with the manoeuvres of the
/// session. None where they cannot be formed.
pub(super) fn designed_errors(
    (session, snapshot): (&Session, &Snapshot),
    designed: &Designed,
    with_flown: bool,
    control: &Control,
) -> Option<PathErrors> {
    let used = snapshot.gravity.as_ref().map_or_else(|| session.clone(), |used| with_gravity(session, used));
    let settings = used.settings();
    let known: Vec<ErrorWindow<'_>> = session
        .active_windows()
        .filter_map(|manoeuvre| {
            let results = snapshot.windows.get(&manoeuvre.name)?;
            let path = results.path.ready()?;
            Some((manoeuvre, (&*path.data, &path.reconstruction), results.aero.ready()?))
        })
        .collect();
    let &(_, (recorded, _), first) = known.first()?;
    let sampled: Vec<FilterData> = designed
        .flown
        .iter()
        .map(|flown| record(flown, recorded, &settings.filter.measurement_delay_s))
        .collect::<Option<_>>()?;
    let all: Vec<&FilterData> = sampled.iter().collect();
    let paths = reconstructions(&all, (settings.filter, settings.preparation.path), control);
    let paths: Vec<Reconstruction> = paths.into_iter().collect::<Result<_, _>>().ok()?;
    let aero = designed.flown.iter().zip(sampled.iter().zip(&paths)).map(|(flown, (data, path))| {
        let columns = window_data(flown, &designed.plant);
        let exact = WindowAero::form(columns, designed_settings(&first.settings), first.air_density)?;
        aero_along(&exact, (data, path), (data, path), settings.preparation).map(Arc::new)
    });
    let aero: Vec<Arc<WindowAero>> = aero.collect::<Result<_, _>>().ok()?;
    let manoeuvres: Vec<Manoeuvre> = designed.manoeuvres.iter().enumerate().map(window_of).collect();
    let planned = manoeuvres.iter().zip(sampled.iter().zip(&paths)).zip(&aero);
    let mut windows: Vec<ErrorWindow<'_>> =
        planned.map(|((manoeuvre, (data, path)), aero)| (manoeuvre, (data, path), aero)).collect();
    if with_flown {
        windows.extend(known);
    }
    path_errors(&windows, settings, control).ok()
}

/// Window of a planned manoeuvre. The throttle moves the aircraft as the elevator does.
fn window_of((index, planned): (usize, &PlannedManoeuvre)) -> Manoeuvre {
    const SURFACES: [Surface; 4] = [Surface::Aileron, Surface::Elevator, Surface::Rudder, Surface::Elevator];
    let window = TimeRange { start_s: 0.0, end_s: planned.duration_s };
    let surface = match planned.surfaces.as_slice() {
        [one] => SURFACES.get(*one).copied(),
        _ => None,
    };
    Manoeuvre { surface, ..Manoeuvre::new(format!("{} {}", index + 1, planned.name), String::new(), window) }
}

/// A flight without gusts as the recorders of a window would show it: each measurement at its rate there, as late as the filter expects it.
fn record(flown: &FlownInput, recorded: &FilterData, delays_s: &[f64; MEASUREMENTS]) -> Option<FilterData> {
    let time_s: Arc<[f64]> = flown.time_s.as_slice().into();
    let column = |value: &dyn Fn(usize) -> f64| (0..time_s.len()).map(value).collect::<Vec<f64>>();
    let [u, v, w, north, east, height] = [0, 1, 2, 9, 10, 11].map(|index| column(&|k| flown.states[k][index]));
    let [phi, theta, psi] = [6, 7, 8].map(|index| column(&|k| flown.states[k][index]));
    let mut states: [Vec<f64>; STATES] = std::array::from_fn(|_| vec![0.0; time_s.len()]);
    let values = [
        (State::PositionNorth, north),
        (State::PositionEast, east),
        (State::PositionDown, height.iter().map(|height| -height).collect()),
        (State::VelocityU, u),
        (State::VelocityV, v),
        (State::VelocityW, w),
        (State::BankAngle, phi),
        (State::PitchAngle, theta),
        (State::HeadingAngle, psi),
    ];
    for (state, values) in values {
        states[state as usize] = values;
    }
    let shown = measurements_of(&states);
    let mut measurements: [MeasurementSeries; MEASUREMENTS] = Default::default();
    for (index, series) in measurements.iter_mut().enumerate() {
        let like = &recorded.measurements[index];
        if !like.time_s.is_empty() {
            *series = at_rate((&time_s, &shown[index]), median_step(&like.time_s)?, delays_s[index])?;
        }
    }
    let [ax, ay, az] = [0, 1, 2].map(|axis| column(&|k| flown.specific_force_m_s2[k][axis]).into());
    let [p, q, r] = [3, 4, 5].map(|state| column(&|k| flown.states[k][state]).into());
    Some(FilterData { inputs: InputSeries { time_s, columns: [ax, ay, az, p, q, r] }, measurements })
}

/// A column at even intervals, straight lines between its samples, with stamps that are late.
fn at_rate((time_s, values): (&[f64], &[f64]), step_s: f64, delay_s: f64) -> Option<MeasurementSeries> {
    let (first_s, last_s) = (time_s[0], time_s[time_s.len() - 1]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of samples")]
    let count = ((last_s - first_s) / step_s) as usize + 1;
    let times: Vec<f64> = (0..count).map(|k| (first_s + step_s * k as f64).min(last_s)).collect();
    let values = resample(time_s, values, &times, Interpolation::Linear).ok()?;
    Some(MeasurementSeries { values: values.into(), time_s: times.iter().map(|time| time + delay_s).collect() })
}
