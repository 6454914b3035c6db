//! What constant errors of the sensors, delays of the deflections and the choice of the differentiation give to the pooled derivatives.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::estimate::{ConstantErrors, InnovationEvidence, constant_errors};
use doublet_core::prep::Differentiation;
use doublet_core::quantity::InstrumentError;
use doublet_core::reconstruct::{
    FilterData, FilterSettings, MEASUREMENTS, Measurement, Method, Reconstruction, State, lane_groups,
};
use rayon::prelude::*;

use super::aero::{WindowAero, aero_along, states_of};
use super::control_delays::{ControlDelay, control_delays};
use super::fit::{AeroWindow, PooledFits, VaneScale, pooled_regressions};
use super::next_errors::Instruments;
use super::path::{WindowPath, measurements_of, reconstructions};
use crate::graph::{Context, Control, Footprint, Keyed, Stage, StageError, StageResult};
use crate::session::{InstrumentAccuracy, Manoeuvre, PathSource, Settings};

/// Most samples of all windows together for which errors of the path, and what findings change, are formed: each takes a further path.
pub(crate) const MOST_SAMPLES: usize = 60_000;

/// Random walk of the wind below which the air is still, m/s per square root of a second: 0.1 m/s after a second.
const STILL_AIR_WALK: f64 = 0.1;

/// An error of a sensor that is the same in all windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantError {
    /// Offset of the recorded angle of attack.
    AlphaOffset,
    /// Offset of the recorded sideslip.
    BetaOffset,
    /// Delay of horizontal position and of velocity over ground.
    GroundDelay,
    /// Delay of the altitude, which is often of another sensor.
    AltitudeDelay,
    /// Delay of both flow angles.
    FlowDelay,
    AirspeedDelay,
    AttitudeDelay,
    /// Scale error of the recorded angle of attack, upwash included.
    AlphaScale,
    /// Scale error of the recorded sideslip, sidewash included.
    BetaScale,
}

impl ConstantError {
    pub const OFFSETS_AND_DELAYS: [Self; 7] = [
        Self::AlphaOffset,
        Self::BetaOffset,
        Self::GroundDelay,
        Self::AltitudeDelay,
        Self::FlowDelay,
        Self::AirspeedDelay,
        Self::AttitudeDelay,
    ];
    /// Scale errors of the flow angles. In gusts the forces follow the flow angles, and the innovations do not determine them.
    pub const SCALES: [Self; 2] = [Self::AlphaScale, Self::BetaScale];

    doublet_core::variant_texts! {
        /// Name in results.
        pub name:
            AlphaOffset "alpha offset", BetaOffset "beta offset", GroundDelay "delay of position and velocity",
            AltitudeDelay "delay of the altitude", FlowDelay "delay of alpha and beta",
            AirspeedDelay "delay of the airspeed", AttitudeDelay "delay of the attitude", AlphaScale "alpha scale",
            BetaScale "beta scale",
    }

    /// Measurements it belongs to.
    pub fn measurements(self) -> &'static [Measurement] {
        use Measurement::{
            Airspeed, AngleOfAttack, BankAngle, HeadingAngle, PitchAngle, PositionDown, PositionEast, PositionNorth,
            Sideslip, VelocityDown, VelocityEast, VelocityNorth,
        };
        match self {
            Self::AlphaOffset | Self::AlphaScale => &[AngleOfAttack],
            Self::BetaOffset | Self::BetaScale => &[Sideslip],
            Self::GroundDelay => &[PositionNorth, PositionEast, VelocityNorth, VelocityEast, VelocityDown],
            Self::AltitudeDelay => &[PositionDown],
            Self::FlowDelay => &[AngleOfAttack, Sideslip],
            Self::AirspeedDelay => &[Airspeed],
            Self::AttitudeDelay => &[BankAngle, PitchAngle, HeadingAngle],
        }
    }

    pub(super) fn is_delay(self) -> bool {
        !matches!(self, Self::AlphaOffset | Self::BetaOffset) && !self.is_scale()
    }

    fn is_scale(self) -> bool {
        Self::SCALES.contains(&self)
    }

    /// Whether some window measures what it belongs to.
    pub(super) fn is_in(self, windows: &[&FilterData]) -> bool {
        let is_measured =
            |m: &Measurement| windows.iter().any(|data| !data.measurements[*m as usize].time_s.is_empty());
        self.measurements().iter().any(is_measured)
    }

    /// Step by which it is varied, rad, s or 1: large beside rounding, small enough for the path to follow in proportion.
    pub(super) fn step(self) -> f64 {
        if self.is_delay() || self.is_scale() { 0.02 } else { 0.1_f64.to_radians() }
    }

    /// What is known of it before any flight, rad, s or 1: a vane is set within half a degree and calibrated within some 5 %, and
    /// recorders deliver attitude, flow angles and airspeed within some 0.05 s, satellite receivers within 0.1 s.
    pub(super) fn prior_deviation(self) -> f64 {
        match self {
            Self::AlphaOffset | Self::BetaOffset => 0.5_f64.to_radians(),
            Self::GroundDelay | Self::AltitudeDelay => 0.1,
            Self::FlowDelay | Self::AirspeedDelay | Self::AttitudeDelay | Self::AlphaScale | Self::BetaScale => 0.05,
        }
    }

    /// The error of the instruments it is.
    pub fn instrument_error(self) -> InstrumentError {
        match self {
            Self::AlphaOffset => InstrumentError::AlphaOffset,
            Self::BetaOffset => InstrumentError::BetaOffset,
            Self::GroundDelay => InstrumentError::GroundDelay,
            Self::AltitudeDelay => InstrumentError::AltitudeDelay,
            Self::FlowDelay => InstrumentError::FlowDelay,
            Self::AirspeedDelay => InstrumentError::AirspeedDelay,
            Self::AttitudeDelay => InstrumentError::AttitudeDelay,
            Self::AlphaScale => InstrumentError::AlphaScale,
            Self::BetaScale => InstrumentError::BetaScale,
        }
    }

    /// What a session states of it, or what is usual.
    pub fn deviation_by(self, accuracy: &InstrumentAccuracy) -> f64 {
        accuracy.0.get(&self.instrument_error()).copied().unwrap_or_else(|| self.prior_deviation())
    }

    /// The measurements of a window freed of an error of one step, by the path at their samples.
    pub(super) fn free(self, data: &FilterData, path: &[PathAtSamples; MEASUREMENTS]) -> FilterData {
        self.free_of(self.step(), data, path)
    }

    /// The measurements of a window freed of an error of this size.
    fn free_of(self, size: f64, data: &FilterData, path: &[PathAtSamples; MEASUREMENTS]) -> FilterData {
        let mut data = data.clone();
        for &measurement in self.measurements() {
            let series = &mut data.measurements[measurement as usize];
            let path = &path[measurement as usize];
            series.values = if self.is_delay() {
                // A sample that is late by the step shows what was before it.
                series.values.iter().zip(&path.slopes).map(|(value, slope)| value + size * slope).collect()
            } else if self.is_scale() {
                // By the path, not by the sample: the noise of the sample would make every scale too large.
                series.values.iter().zip(&path.values).map(|(value, path)| value - size * path).collect()
            } else {
                series.values.iter().map(|value| value - size).collect()
            };
        }
        data
    }
}

/// What the path says at the samples of a measurement.
pub(super) struct PathAtSamples {
    /// Its value, unit of the measurement.
    values: Vec<f64>,
    /// Its rate of change, per second.
    slopes: Vec<f64>,
}

/// Errors of the pooled derivatives that come from the path rather than from the residuals.
#[derive(Clone, Debug)]
pub struct PathErrors {
    /// Constant errors of the sensors looked at.
    pub kinds: Vec<ConstantError>,
    /// What the innovations of all windows say of them.
    pub found: ConstantErrors,
    /// By derivative: how it moves when the samples are freed of each error, per rad or s.
    pub slopes: BTreeMap<String, Vec<f64>>,
    /// Delays of the deflections by the residuals.
    pub controls: Vec<ControlDelay>,
    /// By derivative: change with half and with double the half width of the differentiation.
    pub half_width: BTreeMap<String, [f64; 2]>,
    /// Scale errors of the recorded flow angles; none where gusts explain the measurements better.
    pub vane_scales: Vec<VaneScale>,
}

impl Footprint for PathErrors {
    fn bytes(&self) -> usize {
        (self.slopes.len() * (1 + self.controls.len()) + self.half_width.len()) * 160 + 512
    }
}

impl PathErrors {
    /// Variance of a derivative from constant errors of the sensors and delays of the deflections, and from the choice of the half
    /// width: the range from half to double is taken for four deviations.
    pub fn variances(&self, derivative: &str) -> (f64, f64) {
        let sensors = self.slopes.get(derivative).map_or(0.0, |slopes| self.found.mean_square(slopes));
        let sensors = sensors + self.controls.iter().map(|control| control.mean_square(derivative)).sum::<f64>();
        let choice = self.half_width.get(derivative).map_or(0.0, |[half, double]| {
            let range = half.max(*double).max(0.0) - half.min(*double).min(0.0);
            (0.25 * range).powi(2)
        });
        (sensors, choice)
    }

    /// What the session shows of the instruments, for a flight still to come.
    pub fn instruments(&self) -> Instruments<'_> {
        Instruments::new(self)
    }

    /// The fits with these errors in their corrected standard errors.
    pub fn widen(self: &Arc<Self>, pooled: &PooledFits) -> PooledFits {
        let mut pooled = pooled.clone();
        pooled.vane_scales.clone_from(&self.vane_scales);
        pooled.path_errors = Some(Arc::clone(self));
        for fit in &mut pooled.fits {
            let Ok(found) = &fit.fit else { continue };
            for (name, error) in found.names.iter().zip(&mut fit.corrected_errors) {
                let (sensors, choice) = self.variances(name);
                *error = (*error * *error + sensors + choice).sqrt();
            }
        }
        pooled
    }
}

/// A window as the errors see it: what its filter was given and found, and its coefficients.
pub type ErrorWindow<'a> = (&'a Manoeuvre, (&'a FilterData, &'a Reconstruction), &'a Arc<WindowAero>);

impl Stage for PathErrors {
    type Params<'a> = Settings<'a>;
    type Inputs<'a> = &'a [(&'a Manoeuvre, &'a Keyed<WindowPath>, &'a Keyed<WindowAero>)];
    type Output = Self;
    const NAME: &'static str = "errors of the path";

    fn run(settings: Settings<'_>, windows: Self::Inputs<'_>, context: &Context<'_>) -> StageResult<Self> {
        let windows: Vec<ErrorWindow<'_>> = windows
            .iter()
            .map(|(manoeuvre, path, aero)| (*manoeuvre, (&*path.data, &path.reconstruction), aero.shared()))
            .collect();
        path_errors(&windows, settings, context.control())
    }
}

/// The pooled fits with the errors of the path in their corrected standard errors.
#[derive(Clone, Copy, Debug)]
pub struct WidenedFits;

impl Stage for WidenedFits {
    type Params<'a> = ();
    type Inputs<'a> = (&'a Keyed<PooledFits>, &'a Keyed<PathErrors>);
    type Output = PooledFits;
    const NAME: &'static str = "errors of the pooled estimate";

    fn run(_: (), (pooled, errors): Self::Inputs<'_>, _: &Context<'_>) -> StageResult<PooledFits> {
        Ok(errors.shared().widen(pooled))
    }
}

/// Forms the errors of the path of the pooled derivatives: each constant error is taken off the samples of all windows in turn, which
/// then go through both steps again. The innovations say how large it is, the derivatives what it does.
///
/// # Errors
/// [`StageError::NotApplicable`] for a path without a packed filter and for more samples than that is worth; or that it was stopped.
pub fn path_errors(windows: &[ErrorWindow<'_>], settings: Settings<'_>, control: &Control) -> StageResult<PathErrors> {
    let Settings { filter, preparation, structure, estimation } = settings;
    let samples: usize = windows.iter().map(|(_, (data, _), _)| data.inputs.time_s.len()).sum();
    if windows.is_empty() || samples > MOST_SAMPLES || !is_packed(filter, preparation.path) {
        return Err(StageError::NotApplicable);
    }
    let at_samples = windows
        .par_iter()
        .map(|(_, (data, path), _)| path_at_samples(data, path, (filter, preparation.path)))
        .collect::<StageResult<Vec<_>>>()?;
    let estimates = |aero: &mut dyn Iterator<Item = Arc<WindowAero>>| -> BTreeMap<String, f64> {
        let windows: Vec<AeroWindow<'_>> = windows.iter().map(|(manoeuvre, ..)| *manoeuvre).zip(aero).collect();
        let fits = pooled_regressions(&windows, structure, estimation).into_iter().flatten();
        let fits =
            fits.filter_map(|regression| Some((regression.pooled.shared().count(), regression.pooled.fit().ok()?)));
        fits.flat_map(|(shared, fit)| fit.fit.names.into_iter().zip(fit.fit.estimates).take(shared)).collect()
    };
    let nominal = estimates(&mut windows.iter().map(|(.., aero)| Arc::clone(aero)));
    let all: Vec<&FilterData> = windows.iter().map(|(_, (data, _), _)| *data).collect();
    let scales = ConstantError::SCALES.into_iter().filter(|_| !has_gusts(filter));
    let kinds = ConstantError::OFFSETS_AND_DELAYS.into_iter().chain(scales);
    let kinds: Vec<ConstantError> = kinds.filter(|kind| kind.is_in(&all)).collect();
    let mut freed: Vec<(ConstantError, Vec<Reconstruction>, BTreeMap<String, f64>)> = Vec::with_capacity(kinds.len());
    for &kind in &kinds {
        let data: Vec<FilterData> =
            windows.iter().zip(&at_samples).map(|((_, (data, _), _), path)| kind.free(data, path)).collect();
        let paths = side_by_side(&data.iter().collect::<Vec<_>>(), (filter, preparation.path), control)?;
        let one = |((window, data), path): ((&ErrorWindow<'_>, &FilterData), &Reconstruction)| {
            aero_along(window.2, window.1, (data, path), preparation).map(Arc::new)
        };
        let aero: Vec<_> = windows.par_iter().zip(&data).zip(&paths).map(one).collect::<StageResult<_>>()?;
        let found = estimates(&mut aero.into_iter());
        freed.push((kind, paths, found));
    }
    let evidence: Vec<InnovationEvidence> = windows
        .iter()
        .enumerate()
        .map(|(index, (_, (_, nominal), _))| {
            let freed: Vec<_> = freed.iter().map(|(kind, paths, _)| (&paths[index], kind.step())).collect();
            InnovationEvidence::new(nominal, &freed)
        })
        .collect();
    let priors: Vec<f64> = kinds.iter().map(|kind| kind.deviation_by(&preparation.accuracy)).collect();
    let found = constant_errors(&evidence, &priors)?;
    let slope = |name: &String, value: &f64| -> Vec<f64> {
        freed
            .iter()
            .map(|(kind, _, moved)| moved.get(name).map_or(0.0, |moved| (moved - value) / kind.step()))
            .collect()
    };
    let slopes = nominal.iter().map(|(name, value)| (name.clone(), slope(name, value))).collect();
    let other = [0.5, 2.0].map(|factor| {
        let aero: Vec<_> = windows.par_iter().map(|(.., aero)| with_half_width(aero, factor)).collect();
        let aero: Option<Vec<Arc<WindowAero>>> = aero.into_iter().collect();
        aero.map(|aero| estimates(&mut aero.into_iter())).unwrap_or_default()
    });
    let change =
        |name: &String, value: &f64| other.each_ref().map(|moved| moved.get(name).map_or(0.0, |moved| moved - value));
    let aero: Vec<AeroWindow<'_>> = windows.iter().map(|(window, _, aero)| (*window, Arc::clone(aero))).collect();
    let controls = control_delays(&aero, (structure, estimation), &preparation.accuracy);
    let half_width = nominal.iter().map(|(name, value)| (name.clone(), change(name, value))).collect();
    let vane_scales = match has_gusts(filter) {
        true => scales_in_still_air(windows, settings, control)?,
        false => scales_of(&kinds, &found),
    };
    Ok(PathErrors { kinds, found, slopes, controls, half_width, vane_scales })
}

/// Whether the wind of the path changes within a window.
fn has_gusts(filter: &FilterSettings) -> bool {
    let wind = [State::WindNorth, State::WindEast, State::WindDown];
    wind.into_iter().any(|state| filter.random_walk[state as usize] > STILL_AIR_WALK)
}

/// Scale errors among constant errors.
fn scales_of(kinds: &[ConstantError], found: &ConstantErrors) -> Vec<VaneScale> {
    let all = kinds.iter().zip(found.estimates.iter().zip(&found.cautious_deviations));
    let of_vane = |(kind, (&value, &standard_error)): (&ConstantError, (&f64, &f64))| {
        kind.is_scale().then(|| VaneScale { measurement: kind.measurements()[0], value, standard_error })
    };
    all.filter_map(of_vane).collect()
}

/// Scale errors of the flow angles with a constant wind, where they explain the measurements better than the gusts of `filter` do: the
/// likelihood of all windows decides, that of the samples freed of offsets, delay and scale errors in still air against that in gusts.
fn scales_in_still_air(
    windows: &[ErrorWindow<'_>],
    Settings { filter, preparation, .. }: Settings<'_>,
    control: &Control,
) -> StageResult<Vec<VaneScale>> {
    use ConstantError::{AlphaOffset, AlphaScale, BetaOffset, BetaScale, FlowDelay};
    let mut still = filter.clone();
    for state in [State::WindNorth, State::WindEast, State::WindDown] {
        still.random_walk[state as usize] = 0.0;
    }
    let data: Vec<&FilterData> = windows.iter().map(|(_, (data, _), _)| *data).collect();
    let kinds = [AlphaOffset, BetaOffset, FlowDelay, AlphaScale, BetaScale];
    let kinds: Vec<ConstantError> = kinds.into_iter().filter(|kind| kind.is_in(&data)).collect();
    if !kinds.iter().any(|kind| kind.is_scale()) {
        return Ok(Vec::new());
    }
    let by = (&still, preparation.path);
    let (scales, corrected) = step_in_still_air((&data, &kinds), &preparation.accuracy, by, control)?;
    let filtered = (&still, PathSource::Filtered);
    let paths = side_by_side(&corrected.iter().collect::<Vec<_>>(), filtered, control)?;
    let in_gusts: f64 = windows.iter().map(|(_, (_, path), _)| path.log_likelihood).sum();
    let in_still_air: f64 = paths.iter().map(|path| path.log_likelihood).sum();
    // Density of the samples as recorded: each of a vane is divided by 1 + scale.
    let of_density = |scale: &VaneScale| {
        let samples = data.iter().map(|data| data.measurements[scale.measurement as usize].values.len());
        scale.value.ln_1p() * samples.sum::<usize>() as f64
    };
    let is_better = in_still_air - scales.iter().map(of_density).sum::<f64>() > in_gusts;
    Ok(if is_better { scales } else { Vec::new() })
}

/// One step of Gauss and Newton in still air: the scale errors of the samples, and the samples freed of all errors found.
fn step_in_still_air(
    (data, kinds): (&[&FilterData], &[ConstantError]),
    accuracy: &InstrumentAccuracy,
    by: (&FilterSettings, PathSource),
    control: &Control,
) -> StageResult<(Vec<VaneScale>, Vec<FilterData>)> {
    let nominal = side_by_side(data, by, control)?;
    let at_samples = paths_at_samples(data, &nominal, by)?;
    let freed = filter_freed(data, &at_samples, kinds, by.0, control)?;
    let evidence = nominal.iter().enumerate().map(|(index, nominal)| {
        let freed: Vec<_> = kinds.iter().zip(&freed).map(|(kind, paths)| (&paths[index], kind.step())).collect();
        InnovationEvidence::new(nominal, &freed)
    });
    let priors: Vec<f64> = kinds.iter().map(|kind| kind.deviation_by(accuracy)).collect();
    let found = constant_errors(&evidence.collect::<Vec<_>>(), &priors)?;
    let without = |(data, path): (&&FilterData, &[PathAtSamples; MEASUREMENTS])| {
        let errors = kinds.iter().zip(&found.estimates);
        errors.fold((*data).clone(), |data, (kind, size)| kind.free_of(*size, &data, path))
    };
    let corrected = data.iter().zip(&at_samples).map(without).collect();
    Ok((scales_of(kinds, &found), corrected))
}

/// Filtered paths of windows freed of a step of each error in turn.
pub(super) fn filter_freed(
    data: &[&FilterData],
    at_samples: &[[PathAtSamples; MEASUREMENTS]],
    kinds: &[ConstantError],
    settings: &FilterSettings,
    control: &Control,
) -> StageResult<Vec<Vec<Reconstruction>>> {
    let one = |kind: &ConstantError| {
        let freed: Vec<FilterData> = data.iter().zip(at_samples).map(|(data, path)| kind.free(data, path)).collect();
        side_by_side(&freed.iter().collect::<Vec<_>>(), (settings, PathSource::Filtered), control)
    };
    kinds.iter().map(one).collect()
}

/// [`path_at_samples`] of windows.
pub(super) fn paths_at_samples(
    data: &[&FilterData],
    paths: &[Reconstruction],
    by: (&FilterSettings, PathSource),
) -> StageResult<Vec<[PathAtSamples; MEASUREMENTS]>> {
    data.par_iter().zip(paths).map(|(data, path)| path_at_samples(data, path, by)).collect()
}

/// Whether the filter runs in its packed form; over whole matrices a path takes 20 to 50 times as long.
fn is_packed(filter: &FilterSettings, source: PathSource) -> bool {
    source != PathSource::Measured
        && !matches!(filter.method, Method::Ukf { .. })
        && filter.smoother_passes <= 1
        && filter.air_data_deviation.iter().all(|deviation| *deviation == 0.0)
}

/// Reconstructs windows side by side, on all cores.
pub(super) fn side_by_side(
    data: &[&FilterData],
    by: (&FilterSettings, PathSource),
    control: &Control,
) -> StageResult<Vec<Reconstruction>> {
    let groups = lane_groups(data, rayon::current_num_threads());
    let one = |group: &Vec<usize>| {
        let data: Vec<&FilterData> = group.iter().map(|&index| data[index]).collect();
        reconstructions(&data, by, control)
    };
    let found: Vec<_> = groups.par_iter().map(one).collect();
    let mut paths: Vec<Option<Reconstruction>> = data.iter().map(|_| None).collect();
    for (index, path) in groups.into_iter().flatten().zip(found.into_iter().flatten()) {
        paths[index] = Some(path?);
    }
    paths.into_iter().map(|path| path.ok_or(StageError::NotApplicable)).collect()
}

/// The path at the samples of each measurement, at the times they show.
fn path_at_samples(
    data: &FilterData,
    path: &Reconstruction,
    (filter, source): (&FilterSettings, PathSource),
) -> StageResult<[PathAtSamples; MEASUREMENTS]> {
    let columns = measurements_of(states_of(path, source)?);
    let time_s = &path.time_s;
    Ok(std::array::from_fn(|index| {
        let delay_s = filter.measurement_delay_s[index];
        let column = &columns[index];
        let at = |time: &f64| {
            let after = time_s.partition_point(|at| *at < time - delay_s).clamp(1, time_s.len().max(2) - 1);
            let (from, to) = (after.saturating_sub(2), (after + 1).min(time_s.len() - 1));
            let slope = if to > from { (column[to] - column[from]) / (time_s[to] - time_s[from]) } else { 0.0 };
            (column[from] + slope * (time - delay_s - time_s[from]), slope)
        };
        let (values, slopes) = data.measurements[index].time_s.iter().map(at).unzip();
        PathAtSamples { values, slopes }
    }))
}

/// The coefficients of a window with another half width of the differentiation; none where they cannot be formed so or do not depend on
/// it.
fn with_half_width(aero: &WindowAero, factor: f64) -> Option<Arc<WindowAero>> {
    let Differentiation::LocalPolynomial { degree, half_width } = aero.settings.differentiation else { return None };
    if aero.data.angular_acceleration_rad_s2.is_some() {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "half and double of a few samples")]
    let half_width = ((half_width as f64 * factor).round() as usize).max(1);
    let mut settings = aero.settings.clone();
    settings.differentiation = Differentiation::LocalPolynomial { degree, half_width };
    WindowAero::form(aero.data.clone(), settings, aero.air_density).ok().map(Arc::new)
}
