//! Smoothing and resampling of the signals that play a role, as the session asks.

use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::quoted;
use doublet_core::prep::{Interpolation, Resampling, Smoothing, Treatment, position_from_velocity, stretches, treat};
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, Series, gap_threshold_s};

use crate::graph::StageResult;
use crate::session::{SignalRule, SignalSetting};

/// Source of treated signals in the list of channels.
pub(crate) const SOURCE: &str = "prepared";

/// What was done to the signal of one role.
#[derive(Clone, Debug, PartialEq)]
pub struct TreatedSignal {
    pub role: Role,
    /// Channel it was recorded in, an index into the recording's channels.
    pub recorded: usize,
    /// What was done, in words.
    pub steps: Vec<String>,
    /// Samples as recorded and as treated.
    pub samples: [usize; 2],
    /// Stretches between gaps.
    pub stretches: usize,
    /// Longest interval that is bridged, s, where the session states one.
    pub max_gap_s: Option<f64>,
}

/// Treats every signal a rule names. The recorded channels stay; the roles move to the treated ones.
pub(crate) fn treat_signals(recording: &mut Recording, setting: &SignalSetting) -> StageResult<Vec<TreatedSignal>> {
    recording.max_gap_s = setting.max_gap_s;
    let mut done = Vec::new();
    let mut clocks: Vec<Arc<[f64]>> = Vec::new();
    for rule in &setting.rules {
        for &role in &rule.roles {
            let Some(&recorded) = recording.roles.get(&role) else { continue };
            let channel = &recording.channels[recorded];
            let treatment = treatment(rule, role, setting.max_gap_s);
            let (name, source) = (quoted(&channel.name), channel.source.as_str());
            let place = message!("signal of {} (channel {} of {})", role.name(), name, source);
            let treated = treat(&channel.series, &treatment).map_err(|error| format!("{place}: {error}"))?;
            if treated.short > 0 {
                let (short, all) = (treated.short, treated.stretches);
                let fate = if rule.resampling.is_some() { "partly treated or left out" } else { "left as recorded" };
                let warning = message!("{}: {} of {} segments between gaps are too short, {}", place, short, all, fate);
                recording.warnings.push(warning);
            }
            let samples = [channel.series.values.len(), treated.series.values.len()];
            let unit = channel.unit.clone();
            // Signals of one recorder share their stamps.
            let time_s = match clocks.iter().find(|clock| **clock == treated.series.time_s) {
                Some(clock) => Arc::clone(clock),
                None => {
                    clocks.push(Arc::clone(&treated.series.time_s));
                    treated.series.time_s
                }
            };
            recording.roles.insert(role, recording.channels.len());
            recording.channels.push(Channel {
                source: SOURCE.to_owned(),
                name: role.name().to_owned(),
                unit,
                series: Series { time_s, values: treated.series.values },
            });
            let (stretches, max_gap_s) = (treated.stretches, setting.max_gap_s);
            done.push(TreatedSignal { role, recorded, steps: steps(rule), samples, stretches, max_gap_s });
        }
    }
    if setting.position_from_velocity {
        done.extend(position(recording, setting.max_gap_s)?);
    }
    Ok(done)
}

/// Adds the position north and east of the first sample as the trapezoids of the ground velocity (thesis section 4.4.3); it begins
/// anew after every gap. A position that is recorded is kept, and said.
fn position(recording: &mut Recording, max_gap_s: Option<f64>) -> StageResult<Vec<TreatedSignal>> {
    let axes = [(Role::PositionNorth, Role::VelocityNorth), (Role::PositionEast, Role::VelocityEast)];
    if let Some((role, channel)) = axes.iter().find_map(|(role, _)| Some((role, recording.role(*role)?))) {
        let kept = message!(
            "{} is recorded in {}; the recorded channel is used, not the integrated velocity",
            role.name(),
            &channel.source
        );
        recording.warnings.push(kept);
        return Ok(Vec::new());
    }
    let [north, east] = [velocity(recording, Role::VelocityNorth)?, velocity(recording, Role::VelocityEast)?];
    if north.time_s != east.time_s {
        return Err(
            "position from velocity: v_north and v_east have different time stamps: resample both to one rate".into()
        );
    }
    // A sample that is no number is no sample: the trapezoid spans from its neighbour to the next, up to the longest gap.
    let known = |k: &usize| north.values[*k].is_finite() && east.values[*k].is_finite();
    let column = |values: &[f64]| (0..values.len()).filter(known).map(|k| values[k]).collect::<Vec<f64>>();
    let (time_s, north, east) = (column(&north.time_s), column(&north.values), column(&east.values));
    let ranges = stretches(&time_s, max_gap_s.unwrap_or_else(|| gap_threshold_s(&time_s)));
    let mut columns: [Vec<f64>; 2] = Default::default();
    for range in &ranges {
        let piece = position_from_velocity(&time_s[range.clone()], &north[range.clone()], &east[range.clone()])
            .map_err(|error| format!("position from velocity: {error}"))?;
        columns.iter_mut().zip(piece).for_each(|(column, piece)| column.extend(piece));
    }
    if ranges.len() > 1 {
        let gaps = ranges.len() - 1;
        recording
            .warnings
            .push(message!("x and y restart after {} gaps of the velocity: mark manoeuvres between the gaps", gaps));
    }
    let shared: Arc<[f64]> = time_s.into();
    let mut done = Vec::new();
    for ((role, from), values) in axes.into_iter().zip(columns) {
        let Some(&recorded) = recording.roles.get(&from) else { continue };
        recording.roles.insert(role, recording.channels.len());
        recording.channels.push(Channel {
            source: SOURCE.to_owned(),
            name: role.name().to_owned(),
            unit: role.dimension().si_symbol().to_owned(),
            series: Series { time_s: Arc::clone(&shared), values: values.into() },
        });
        done.push(TreatedSignal {
            role,
            recorded,
            steps: vec![format!("trapezoids of {}", from.name())],
            samples: [recording.channels[recorded].series.values.len(), shared.len()],
            stretches: ranges.len(),
            max_gap_s,
        });
    }
    Ok(done)
}

fn velocity(recording: &Recording, role: Role) -> StageResult<Series> {
    let channel = recording.role(role);
    channel.map(|channel| channel.series.clone()).ok_or_else(|| {
        format!("position from velocity: {} is not recorded: map its channel, or switch it off", role.name()).into()
    })
}

fn treatment(rule: &SignalRule, role: Role, max_gap_s: Option<f64>) -> Treatment {
    let average = rule.moving_average.map(|width| Smoothing::MovingAverage { width });
    let polynomial =
        rule.polynomial.map(|(degree, width)| Smoothing::LocalPolynomial { degree, half_width: width / 2 });
    Treatment {
        smoothing: average.into_iter().chain(polynomial).collect(),
        resampling: rule.resampling,
        max_gap_s,
        wraps: wraps(role),
    }
}

/// Whether a role is an angle that jumps by whole turns.
pub fn wraps(role: Role) -> bool {
    matches!(role, Role::BankAngle | Role::HeadingAngle | Role::Longitude)
}

/// The steps of a rule in words.
fn steps(rule: &SignalRule) -> Vec<String> {
    let average = rule.moving_average.map(|width| format!("moving average of {width}"));
    let polynomial =
        rule.polynomial.map(|(degree, width)| format!("polynomial of degree {degree} over {width} samples"));
    let resampling = rule.resampling.map(|Resampling { rate_hz, interpolation }| {
        let by = match interpolation {
            Interpolation::Linear => "straight lines",
            Interpolation::QuadraticSpline => "quadratic spline",
        };
        format!("{by} to {rate_hz} Hz")
    });
    average.into_iter().chain(polynomial).chain(resampling).collect()
}
