//! Values that a recorder repeats because the sensor is slower than it, used once.

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::prep::{HeldSamples, held_samples};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Input;
use doublet_core::series::{Channel, Recording};
use rayon::prelude::*;

use super::signals::{SOURCE, TreatedSignal};
use crate::session::{Finding, Level, Place};

/// Takes the first sample of every hold of each role as the measurement. The recorded channels stay; the roles move to what is used.
///
/// The filter is driven at every stamp of the inertial samples: between the first samples of their holds these follow straight lines.
pub(crate) fn use_held_once(recording: &mut Recording, flight: &str) -> (Vec<TreatedSignal>, Vec<Finding>) {
    let roles: Vec<(Role, usize)> = recording.roles.iter().map(|(role, at)| (*role, *at)).collect();
    let held = |(role, at): (Role, usize)| Some((role, at, held_samples(&recording.channels[at].series)?));
    let held: Vec<(Role, usize, HeldSamples)> = roles.into_par_iter().filter_map(held).collect();
    let (mut treated, mut findings) = (Vec::new(), Vec::new());
    for (role, recorded, held) in held {
        let channel = &recording.channels[recorded];
        let drives = Input::ALL.into_iter().any(|input| input.role() == role);
        let series = if drives { held.joined(&channel.series.time_s) } else { held.own.clone() };
        let (name, unit) = (role.name().to_owned(), channel.unit.clone());
        let (text, finding) = describe(flight, role, channel, &held, drives);
        let samples = [channel.series.values.len(), series.values.len()];
        treated.push(TreatedSignal {
            role,
            recorded,
            steps: vec![text.to_string()],
            samples,
            stretches: 1,
            max_gap_s: None,
        });
        recording.warnings.push(message!("{}: {}", role.name(), text));
        findings.push(finding);
        recording.roles.insert(role, recording.channels.len());
        recording.channels.push(Channel { source: SOURCE.to_owned(), name, unit, series });
    }
    (treated, findings)
}

/// What was found of a channel and done about it.
fn describe(flight: &str, role: Role, channel: &Channel, held: &HeldSamples, drives: bool) -> (Message, Finding) {
    let (own, all) = (held.own.values.len(), held.samples);
    let (percent, rate_hz) = (100.0 * (1.0 - own as f64 / all as f64), held.rate_hz());
    let done = if drives { "interpolated linearly" } else { "used once" };
    let text = message!(
        "{} of {} samples are repeats ({:.0} %, {:.1} samples per value); the other {} ({:.3} Hz) are {}",
        all - own,
        all,
        percent,
        held.period,
        own,
        rate_hz,
        done
    );
    // What drives the filter is no longer what was recorded.
    let level = if drives { Level::Caution } else { Level::Good };
    let place = Place::in_flight(flight, format!("{} ({})", role.name(), channel.full_name()));
    let finding = Finding::new(level, "held-samples", place, text.clone())
        .with_figure(rate_hz, f64::NAN)
        .with_fix_text("record the sensor at its own rate, or use every sample")
        .with_setting("Preprocess", "flight.signals.held_samples");
    (text, finding)
}
