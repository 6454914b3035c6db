//! The noise of each measurement by the innovations: of one manoeuvre, and of all manoeuvres together.

use std::sync::OnceLock;

use doublet_core::message;
use doublet_core::message::written;
use doublet_core::reconstruct::consistency::ChannelConsistency;
use doublet_core::reconstruct::{MEASUREMENTS, Measurement};
use doublet_core::statistics::median;

use super::{Finding, Level};
use crate::notation::significant;
use crate::session::{Edit, Fix, Manoeuvre, NoiseChannel, Session};
use crate::snapshot::Snapshot;
use crate::stage::{NoiseAdvice, WindowPath, channel_advice, noise_of_all};

/// Mean NIS over its expectation beyond which no noise of a sensor is meant: a channel or the model is wrong.
pub(super) const NOISE_EXPLAINS: f64 = 10.0;

/// Innovations of a measurement over their prediction, median of the manoeuvres, below which its noise is set far too high; and the
/// measurements whose coefficients lose precision by it. The NIS of all measurements together hides one of them.
const FAR_TOO_HIGH: f64 = 0.2;
const OF_FLOW: [Measurement; 3] = [Measurement::Airspeed, Measurement::AngleOfAttack, Measurement::Sideslip];

/// Noise of the measurements of a session; that of all manoeuvres is computed once, when it is first asked for.
pub(super) struct MeasurementNoise<'a> {
    session: &'a Session,
    snapshot: &'a Snapshot,
    pooled: [OnceLock<Option<f64>>; MEASUREMENTS],
}

impl<'a> MeasurementNoise<'a> {
    pub(super) fn new(session: &'a Session, snapshot: &'a Snapshot) -> Self {
        Self { session, snapshot, pooled: Default::default() }
    }

    /// Standard deviation in use, SI.
    pub(super) fn used(&self, measurement: Measurement) -> f64 {
        self.session.filter.measurement_noise[measurement as usize]
    }

    /// Advice on the noise of a measurement by its innovations in one manoeuvre.
    pub(super) fn advise(&self, manoeuvre: &Manoeuvre, channel: &ChannelConsistency) -> Option<NoiseAdvice> {
        let path = self.snapshot.windows.get(&manoeuvre.name)?.path.ready()?;
        let noise = self.snapshot.noise.get(&manoeuvre.flight).and_then(|slot| slot.ready());
        channel_advice(path, channel, self.used(channel.measurement), noise.map(|noise| &**noise))
    }

    /// Standard deviation of a measurement by its innovations in all manoeuvres, SI; none where they are not noise.
    pub(super) fn pooled(&self, measurement: Measurement) -> Option<f64> {
        *self.pooled[measurement as usize].get_or_init(|| {
            let path = |manoeuvre: &Manoeuvre| self.snapshot.windows.get(&manoeuvre.name)?.path.ready();
            let paths = self.session.active_windows().filter_map(path).map(|path| -> &WindowPath { path });
            noise_of_all(paths, measurement, self.used(measurement))
        })
    }

    /// Sets the noise of a measurement by its innovations in all manoeuvres; none where they are not noise.
    pub(super) fn fix(&self, measurement: Measurement) -> Option<Fix> {
        let std = self.pooled(measurement)?;
        let (name, ratio) = (measurement.name(), std / self.used(measurement));
        if ratio.is_nan() || ratio * ratio > NOISE_EXPLAINS {
            return None;
        }
        let label = format!("multiply the noise of {name} by {} (all manoeuvres)", significant(ratio, 2));
        Some(Fix::new(label, Edit::noise(NoiseChannel::Measurement(measurement), std)))
    }
}

/// A hint for each measurement of the flow whose noise is set far too high. Estimates stay within their errors, which are larger than they
/// need be: no reason for a caution.
pub(super) fn find_far_too_high(noise: &MeasurementNoise<'_>) -> Vec<(Measurement, Finding)> {
    let hint = |measurement: Measurement| {
        let ratio = |manoeuvre: &Manoeuvre| {
            let path = noise.snapshot.windows.get(&manoeuvre.name)?.path.ready()?;
            let channels = &path.assessment().consistency.as_ref()?.channels;
            Some(channels.iter().find(|channel| channel.measurement == measurement)?.deviation_ratio)
        };
        let mut ratios: Vec<f64> = noise.session.active_windows().filter_map(ratio).collect();
        let ratio = median(&mut ratios).filter(|ratio| *ratio < FAR_TOO_HIGH)?;
        let name = measurement.name();
        let found = written(ratio, significant(ratio, 2));
        let text =
            message!("{} innovations are {} of predicted (limit {}): noise set too high.", name, found, FAR_TOO_HIGH);
        let finding = Finding::new(Level::Good, "innovation-advice", "session", text).with_figure(ratio, FAR_TOO_HIGH);
        let finding = finding.with_fix_text(format!("Set the noise of {name} by its innovations."));
        let finding = finding.with_setting("Noise and filter", format!("filter.measurement_noise.{name}"));
        Some((measurement, finding.with_fix(noise.fix(measurement))))
    };
    OF_FLOW.into_iter().filter_map(hint).collect()
}
