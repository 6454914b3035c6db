//! The windows of a session formed without a suspect cause: along another path, with a channel changed or left out, with the
//! accelerometers at another place.

use std::sync::Arc;

use doublet_core::compatibility::ChannelFix;
use doublet_core::model::{AeroData, CoefficientSettings, Position};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{FilterData, Input, Measurement, MeasurementSeries, Reconstruction, measured_path};
use doublet_core::series::TimeRange;
use rayon::prelude::*;

use super::super::judge::Evidence;
use super::super::spoilt;
use crate::graph::{Control, StageResult};
use crate::session::{Manoeuvre, PathSource, Session, WindowRole};
use crate::snapshot::Snapshot;
use crate::stage::{self, AeroWindow, PhysicsRow, WindowAero, WindowPath};

/// A manoeuvre that fits are made of.
#[derive(Clone, Copy)]
pub(super) struct Used<'a> {
    pub(super) manoeuvre: &'a Manoeuvre,
    path: &'a WindowPath,
    aero: &'a Arc<WindowAero>,
}

impl<'a> Used<'a> {
    /// The manoeuvre, where it is one of identification and was computed.
    pub(super) fn new(snapshot: &'a Snapshot, manoeuvre: &'a Manoeuvre) -> Option<Self> {
        let results = snapshot.windows.get(&manoeuvre.name).filter(|_| manoeuvre.role == WindowRole::Identification)?;
        Some(Self { manoeuvre, path: results.path.ready()?, aero: results.aero.ready()? })
    }

    /// Samples of its coefficients.
    pub(super) fn samples(self) -> usize {
        self.aero.data.time_s.len()
    }

    /// As it was computed.
    pub(super) fn as_computed(self) -> AeroWindow<'a> {
        (self.manoeuvre, Arc::clone(self.aero))
    }

    /// What its filter was given, and what it found.
    fn nominal(self) -> (&'a FilterData, &'a Reconstruction) {
        (&self.path.data, &self.path.reconstruction)
    }

    fn formed(self, aero: WindowAero) -> AeroWindow<'a> {
        (self.manoeuvre, Arc::new(aero))
    }
}

/// The windows with the path taken from another source; none where one of them does not have it.
pub(super) fn along<'a>(session: &Session, used: &[Used<'a>], source: PathSource) -> Option<Vec<AeroWindow<'a>>> {
    used.par_iter().map(|used| form_along(session, used, source)).collect()
}

fn form_along<'a>(session: &Session, used: &Used<'a>, source: PathSource) -> Option<AeroWindow<'a>> {
    let data = &*used.path.data;
    let measured;
    let path: &Reconstruction = match source {
        PathSource::Measured => {
            measured = measured_path(data).ok()?;
            &measured
        }
        _ => &used.path.reconstruction,
    };
    let by = (&session.preparation, source);
    Some(used.formed(stage::aero_along_from(used.aero, used.nominal(), (data, path), by).ok()?))
}

/// The windows of `flight` with what a row says of its channel changed, or without the channel where it says nothing; none where
/// that cannot be formed.
pub(super) fn corrected<'a>(
    session: &Session,
    used: &[Used<'a>],
    flight: &str,
    row: &PhysicsRow,
) -> Option<Vec<AeroWindow<'a>>> {
    let role = Role::from_name(&row.channel)?;
    if used.iter().all(|used| used.manoeuvre.flight != flight) {
        return None;
    }
    let change = |data: &FilterData| match &row.change {
        Some(fix) => changed(data, fix),
        None => without(data, role),
    };
    form_again(session, (used, flight), &change, &|used, along| {
        stage::aero_along(used.aero, used.nominal(), along, &session.preparation).ok()
    })
}

/// The windows of `flight` with the accelerometers at `found_m` instead of `taken_m` from the centre of gravity, body axes, m: in
/// the path and in the forces.
pub(super) fn moved<'a>(
    session: &Session,
    used: &[Used<'a>],
    flight: &str,
    [found_m, taken_m]: [[f64; 3]; 2],
) -> Option<Vec<AeroWindow<'a>>> {
    let displacement_m = std::array::from_fn(|axis| found_m[axis] - taken_m[axis]);
    let change = |data: &FilterData| {
        let mut data = data.clone();
        // The correction is linear in the place: what was moved already is moved on.
        stage::move_accelerometer(&mut data.inputs, displacement_m, &session.preparation).ok()?;
        Some(data)
    };
    form_again(session, (used, flight), &change, &|used, (_, path)| {
        let along = (&*used.path.data, path);
        let WindowAero { data, settings, air_density, .. } =
            stage::aero_along(used.aero, used.nominal(), along, &session.preparation).ok()?;
        let data = AeroData { accelerometer: Some(Position::BodyFromCg(found_m)), ..data };
        WindowAero::form(data, settings, air_density).ok()
    })
}

/// The windows without their spoilt samples; none where no window has any. A window that has no others is left out.
pub(super) fn without_spoilt<'a>(evidence: Evidence<'_>, used: &[Used<'a>]) -> Option<Vec<AeroWindow<'a>>> {
    let excluded: Vec<_> = used.par_iter().map(|used| spoilt::excluded(evidence, used.manoeuvre)).collect();
    let one = |(used, excluded): (&Used<'a>, Option<Vec<TimeRange>>)| match excluded {
        None => Some(used.as_computed()),
        Some(excluded) => Some(used.formed(outside(used.aero, excluded)?)),
    };
    excluded.iter().any(Option::is_some).then(|| used.iter().zip(excluded).filter_map(one).collect())
}

/// A window with these parts excluded from its coefficients; none where nothing is left.
pub(in crate::verdict) fn outside(aero: &WindowAero, excluded: Vec<TimeRange>) -> Option<WindowAero> {
    let settings = CoefficientSettings { excluded, ..aero.settings.clone() };
    WindowAero::form(aero.data.clone(), settings, aero.air_density).ok()
}

/// Forms a window along the path of its changed samples.
type Form<'f, 'a> = dyn Fn(&Used<'a>, (&FilterData, &Reconstruction)) -> Option<WindowAero> + 'f;

/// The windows of `flight` formed along the paths of their changed samples, then the others as computed; none where one of them cannot be.
fn form_again<'a>(
    session: &Session,
    (used, flight): (&[Used<'a>], &str),
    change: &dyn Fn(&FilterData) -> Option<FilterData>,
    form: &Form<'_, 'a>,
) -> Option<Vec<AeroWindow<'a>>> {
    let (of_flight, others): (Vec<Used<'a>>, Vec<Used<'a>>) =
        used.iter().copied().partition(|used| used.manoeuvre.flight == flight);
    let data: Vec<FilterData> = of_flight.iter().map(|used| change(&used.path.data)).collect::<Option<_>>()?;
    let mut formed = Vec::with_capacity(used.len());
    for ((used, data), path) in of_flight.iter().zip(&data).zip(reconstructed(session, &data)) {
        formed.push(used.formed(form(used, (data, &path.ok()?))?));
    }
    formed.extend(others.iter().map(|used| used.as_computed()));
    Some(formed)
}

/// The paths of `data` with the filter of the session.
fn reconstructed(session: &Session, data: &[FilterData]) -> Vec<StageResult<Reconstruction>> {
    let by = (&session.filter, session.preparation.path);
    stage::reconstructions(&data.iter().collect::<Vec<_>>(), by, &Control::default())
}

/// Samples with a change of the channel map; none where it is not one of inertial channels or measurements.
fn changed(data: &FilterData, fix: &ChannelFix) -> Option<FilterData> {
    let mut data = data.clone();
    match *fix {
        ChannelFix::Scale { role, factor, offset, .. } => {
            let values = values_of(&mut data, role)?;
            *values = values.iter().map(|value| factor * value + offset).collect();
        }
        ChannelFix::Swap { one, other } => {
            let (first, second) = (values_of(&mut data, one)?.clone(), values_of(&mut data, other)?.clone());
            if first.len() != second.len() {
                return None;
            }
            *values_of(&mut data, one)? = second;
            *values_of(&mut data, other)? = first;
        }
        ChannelFix::Reassign { .. }
        | ChannelFix::Clock { .. }
        | ChannelFix::Shift { .. }
        | ChannelFix::Travel { .. } => return None,
    }
    Some(data)
}

/// Samples without a measurement; none where the channel is none.
fn without(data: &FilterData, role: Role) -> Option<FilterData> {
    let measurement = Measurement::ALL.into_iter().find(|measurement| measurement.role() == role)?;
    let mut data = data.clone();
    data.measurements[measurement as usize] = MeasurementSeries::default();
    Some(data)
}

fn values_of(data: &mut FilterData, role: Role) -> Option<&mut Arc<[f64]>> {
    if let Some(input) = Input::ALL.into_iter().find(|input| input.role() == role) {
        return Some(&mut data.inputs.columns[input as usize]);
    }
    let measurement = Measurement::ALL.into_iter().find(|measurement| measurement.role() == role)?;
    Some(&mut data.measurements[measurement as usize].values).filter(|values| !values.is_empty())
}
