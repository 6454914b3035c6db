//! Channels of a flight against each other, before any statistics; what is wrong and which key of its channel map mends it.

use doublet_core::compatibility::{
    AccelerometerPlace, Agreement, ChannelFix, Compatibility, CompatibilityRow, Curves, RateErrors, Trace, check,
};
use doublet_core::message;
use doublet_core::message::{Message, detail};
use doublet_core::prep::airborne;
use doublet_core::quantity::Role;
use doublet_core::series::Recording;
use serde::Serialize;

use super::LoadedFlight;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::notation::significant;
use crate::session::{Finding, Fix, Level, Place, RecordingRef, Session};

/// What the channels of a flight say of each other.
#[derive(Clone, Debug, Default)]
pub struct FlightPhysics {
    /// The clock, then mistakes of the channel map, then every relation.
    pub rows: Vec<PhysicsRow>,
    /// Where the accelerometers are by what the ground velocity says.
    pub accelerometer: Option<AccelerometerPlace>,
    /// Mounting of the inertial unit and scale factors of its gyros, by rates against attitude.
    pub rates: Option<RateErrors>,
    /// Median true airspeed while it flies, m/s, where it is recorded.
    pub airspeed_m_s: Option<f64>,
    /// Whether the position down is the altitude turned.
    pub has_down_of_altitude: bool,
}

/// One channel against the others, as `results.json` and `check --json` show it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicsRow {
    /// Role of the channel, or `time`.
    pub channel: String,
    /// Bad if a mistake explains the contradiction, caution if the cause was not found or needs an answer.
    pub level: Level,
    /// Mistake, for example `sign reversed`; empty without one.
    pub hypothesis: String,
    /// Factor on the channel's SI values, or on the seconds as read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Time to add to the stamps of a source, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift_s: Option<f64>,
    /// Slope of the channel on the value predicted by the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Squared correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r2: Option<f64>,
    /// Segments of the flight with enough motion; 0 if not observable.
    pub segments: usize,
    /// One sentence with the values.
    pub evidence: String,
    /// What to change, one sentence; empty without a remedy.
    #[serde(rename = "fix", skip_serializing_if = "String::is_empty")]
    pub fix_text: String,
    /// Whether the channels agree, which is not so where the recording shows nothing.
    #[serde(skip)]
    pub fits: bool,
    /// Roles without which there is nothing to compare.
    #[serde(skip)]
    pub needed: Vec<Role>,
    /// `az: sign reversed (correlation -0.999)`.
    #[serde(skip)]
    pub headline: Message,
    /// The same for [`crate::begin::apply_fix`].
    #[serde(skip)]
    pub change: Option<ChannelFix>,
    /// The channel over what the others say it is, before and after the fix.
    #[serde(skip)]
    pub curves: Option<Curves>,
}

impl Footprint for FlightPhysics {
    fn bytes(&self) -> usize {
        let points = |trace: &Trace| 3 * trace.time_s.len() * size_of::<f64>();
        let curves = self.rows.iter().filter_map(|row| row.curves.as_ref());
        self.rows.len() * 400 + curves.map(|curves| points(&curves.before) + points(&curves.after)).sum::<usize>()
    }
}

impl FlightPhysics {
    /// Rows that say something is wrong or must be asked.
    pub fn contradictions(&self) -> impl Iterator<Item = &PhysicsRow> {
        self.rows.iter().filter(|row| row.level > Level::Good)
    }

    /// The fix of a row as an edit of `flight` of `session`.
    pub(crate) fn fix(&self, session: &Session, flight: &str, row: &PhysicsRow) -> Option<Fix> {
        Fix::channel(session.flight(flight)?, row.change.as_ref()?, self.has_down_of_altitude)
    }

    /// The same as findings about `flight` of `session`.
    pub fn findings(&self, session: &Session, flight: &str) -> Vec<Finding> {
        self.contradictions().map(|row| self.describe(session, flight, row)).collect()
    }

    fn describe(&self, session: &Session, flight: &str, row: &PhysicsRow) -> Finding {
        let place = Place::in_flight(flight, row.channel.as_str());
        let text = message!("{}: {}.", &row.headline, detail(&row.evidence));
        let finding = Finding::new(row.level, "physics", place, text).with_fix_text(row.fix_text.clone());
        let finding = finding.with_setting("Channels", "").with_fix(self.fix(session, flight, row));
        match row.slope {
            Some(slope) if row.hypothesis.is_empty() => finding.with_figure(slope, f64::NAN),
            _ => finding,
        }
    }
}

/// Of a flight of these recordings, on its time line.
impl Stage for FlightPhysics {
    type Params<'a> = &'a [RecordingRef];
    type Inputs<'a> = &'a Keyed<LoadedFlight>;
    type Output = Self;
    const NAME: &'static str = "channels against each other";

    fn run(recordings: &[RecordingRef], loaded: &Keyed<LoadedFlight>, _: &Context<'_>) -> StageResult<Self> {
        let map = |role: Option<Role>| map_of(recordings, &loaded.recording, role);
        // What was treated keeps the recorder it came from.
        let mut recording = loaded.recording.clone();
        for signal in &loaded.treated {
            let source = recording.channels.get(signal.recorded).map(|channel| channel.source.clone());
            let used = recording.roles.get(&signal.role).and_then(|index| recording.channels.get_mut(*index));
            if let (Some(source), Some(used)) = (source, used) {
                used.source = source;
            }
        }
        Ok(compared(&recording, map))
    }
}

/// Compares the channels of a recording whose channel map is called `map`; arrays have none.
pub fn physics_of(recording: &Recording, map: &str) -> FlightPhysics {
    compared(recording, |_| map.to_owned())
}

fn median_airspeed_m_s(recording: &Recording) -> Option<f64> {
    let role = |role: Role| recording.role(role).map(|channel| &channel.series);
    Some(airborne(role(Role::TrueAirspeed)?, role(Role::WeightOnWheels), 1.0)?.least_airspeed_m_s)
}

fn compared(recording: &Recording, map: impl Fn(Option<Role>) -> String) -> FlightPhysics {
    let without_copy = without_copy(recording);
    let Compatibility { rows, accelerometer, rates } = check(without_copy.as_ref().unwrap_or(recording));
    let airspeed_m_s = median_airspeed_m_s(recording);
    let has_down_of_altitude = without_copy.is_some();
    FlightPhysics {
        rows: rows.into_iter().map(|row| describe_row(row, &map)).collect(),
        accelerometer,
        rates,
        airspeed_m_s,
        has_down_of_altitude,
    }
}

fn describe_row(found: CompatibilityRow, map: impl Fn(Option<Role>) -> String) -> PhysicsRow {
    PhysicsRow {
        level: match found.agreement {
            Agreement::Fits | Agreement::Undetermined => Level::Good,
            Agreement::Doubtful => Level::Caution,
            Agreement::Contradicts => Level::Bad,
        },
        fix_text: found.fix.as_ref().map(|fix| sentence(fix, &map(fix.roles().first().copied()))).unwrap_or_default(),
        headline: found.headline(),
        fits: found.agreement == Agreement::Fits,
        needed: found.needed(),
        channel: found.channel,
        hypothesis: found.hypothesis,
        factor: found.factor,
        shift_s: match found.fix {
            Some(ChannelFix::Shift { late_s, .. }) => Some(-late_s),
            _ => None,
        },
        slope: found.slope,
        r2: found.r2,
        segments: found.segments,
        evidence: found.evidence,
        change: found.fix,
        curves: found.curves,
    }
}

/// The recording without a position down that is its altitude turned: both have the same error, and a fix of one alone does not correct it.
fn without_copy(recording: &Recording) -> Option<Recording> {
    let find_series = |role: Role| recording.role(role).map(|channel| &channel.series);
    let (down, altitude) = (find_series(Role::PositionDown)?, find_series(Role::Altitude)?);
    let same = down.values.len() == altitude.values.len()
        && down.values.iter().zip(altitude.values.iter()).all(|(down, up)| (down + up).abs() < 1e-6 || down.is_nan());
    same.then(|| {
        let mut alone = recording.clone();
        alone.roles.remove(&Role::PositionDown);
        alone
    })
}

/// Name of the channel map a role, or the first clock, came by: that of its recording where the flight has several.
fn map_of(recordings: &[RecordingRef], recording: &Recording, role: Option<Role>) -> String {
    let source = role.and_then(|role| recording.role(role)).map(|channel| channel.source.as_str()).unwrap_or_default();
    let of_source = |path: &str| {
        let stem = path.rsplit(['/', '\\']).next().unwrap_or(path);
        let stem = stem.split('.').next().unwrap_or(stem);
        !stem.is_empty() && source.starts_with(stem)
    };
    let entry = recordings.iter().find(|entry| of_source(&entry.path)).or(recordings.first());
    entry.map_or_else(String::new, |entry| entry.channel_map.name().to_owned())
}

/// Change of a channel map, or of arrays where there is none, one sentence.
fn sentence(fix: &ChannelFix, map: &str) -> String {
    let role_of = |role: &Role| match map {
        "" => format!("Channel {}", role.name()),
        map => format!("Channel map {map}, role {}", role.name()),
    };
    match fix {
        ChannelFix::Scale { role, factor, offset, units } => {
            let mut parts = Vec::new();
            if *factor < 0.0 {
                parts.push("reverse the sign".to_owned());
            }
            match units {
                Some((is, was)) => parts.push(format!("set the unit to {is} instead of {was}")),
                None if factor.abs() != 1.0 => parts.push(format!("set the scale to {}", significant(*factor, 4))),
                None => {}
            }
            match role {
                _ if *offset == 0.0 => {}
                Role::AirTemperature => parts.push("set the unit to degC".to_owned()),
                Role::SpecificForceZ => parts.push("restore 1 g by an offset".to_owned()),
                _ => parts.push(format!("set the offset to {:.1} deg ({offset:.4} rad)", offset.to_degrees())),
            }
            let also = if *role == Role::Altitude { " (and role z of the same channel)" } else { "" };
            format!("{}{also}: {}.", role_of(role), parts.join(" and "))
        }
        ChannelFix::Swap { one, other } => match map {
            "" => format!("Exchange channels {} and {}.", one.name(), other.name()),
            map => format!("Channel map {map}: exchange the channels of roles {} and {}.", one.name(), other.name()),
        },
        ChannelFix::Reassign { from, to } => match map {
            "" => format!("Rename channel {} to {}.", from.name(), to.name()),
            map => format!("Channel map {map}: change role {} to {}.", from.name(), to.name()),
        },
        ChannelFix::Clock { factor: _, unit: Some(unit) } => match map {
            "" => format!("Give time in seconds: it is in {unit}."),
            map => format!("Channel map {map}: set the unit of time to {unit}."),
        },
        ChannelFix::Clock { factor, unit: None } => {
            format!("Check the rate of the recorder, or set a clock drift of {:.4}.", factor - 1.0)
        }
        ChannelFix::Shift { source, late_s } => {
            format!("Add {:.2} s to the clock offset of source {source} (panel Preprocess).", -late_s)
        }
        ChannelFix::Travel { role, form, .. } => {
            format!("{}: state the full travel in degrees (unit deg, scale travel / {}).", role_of(role), form.full())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fix_names_the_setting_and_the_value() {
        let degrees =
            ChannelFix::Scale { role: Role::RollRate, factor: -0.0174, offset: 0.0, units: Some(("deg/s", "rad/s")) };
        assert_eq!(
            sentence(&degrees, "mine.toml"),
            "Channel map mine.toml, role p: reverse the sign and set the unit to deg/s instead of rad/s."
        );
        let ticks = ChannelFix::Clock { factor: 1e-3, unit: Some("ms") };
        assert_eq!(sentence(&ticks, "mine.toml"), "Channel map mine.toml: set the unit of time to ms.");
        assert_eq!(sentence(&ticks, ""), "Give time in seconds: it is in ms.");
        let turned = ChannelFix::Scale { role: Role::PitchRate, factor: -1.0, offset: 0.0, units: None };
        assert_eq!(sentence(&turned, ""), "Channel q: reverse the sign.");
    }
}
