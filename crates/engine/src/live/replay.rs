//! A recording that was made, as rows in the order of their time.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::load::stream::{StreamChannel, StreamRow};
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series};

/// Channel of the time in every source.
const TIME: &str = "time";
/// Rows given at once.
const ROWS: usize = 500;

/// The roles of a recording, those with the same stamps as one source, in SI.
#[derive(Debug)]
pub struct Replay {
    groups: Vec<Group>,
    /// Text of the channel map by which the rows give the roles again.
    pub map: String,
}

/// Channels with the same stamps.
#[derive(Debug)]
struct Group {
    source: Arc<str>,
    channels: Arc<[StreamChannel]>,
    series: Vec<Series>,
    next: usize,
}

impl Group {
    fn next_s(&self) -> Option<f64> {
        self.series.first()?.time_s.get(self.next).copied()
    }
}

impl Replay {
    /// Of all roles of `recording`.
    pub fn new(recording: &Recording) -> Self {
        let mut found: Vec<(String, Vec<(Role, Series)>)> = Vec::new();
        for (&role, &index) in &recording.roles {
            let Some(channel) = recording.channels.get(index) else { continue };
            let same = found.iter_mut().find(|(_, group)| {
                group.iter().any(|(_, series)| {
                    Arc::ptr_eq(&series.time_s, &channel.series.time_s) || series.time_s == channel.series.time_s
                })
            });
            match same {
                Some((_, group)) => group.push((role, channel.series.clone())),
                None => found.push((channel.source.clone(), vec![(role, channel.series.clone())])),
            }
        }
        let mut names: BTreeMap<String, usize> = BTreeMap::new();
        let mut map = String::from(
            "format = \"doublet channel map\"\nversion = 1\nname = \"live\"\ndescription = \"Roles of the replay, in SI\"\n\n\
             [[time]]\nsource = \"*\"\nchannel = \"time\"\nunit = \"s\"\n",
        );
        let mut groups = Vec::new();
        for (source, roles) in found {
            let plain: String =
                source.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect();
            let count = names.entry(plain.clone()).or_default();
            *count += 1;
            let source = if *count > 1 { format!("{plain}_{count}") } else { plain };
            let channel = |name: &str, unit: &str| StreamChannel { name: name.to_owned(), unit: Some(unit.to_owned()) };
            let mut channels = vec![channel(TIME, "s")];
            let mut series = Vec::new();
            for (role, own) in roles {
                let (name, unit) = (role.name(), role.dimension().si_symbol());
                map.push_str(&format!(
                    "\n[roles.{name}]\nsource = \"{source}\"\nchannel = \"{name}\"\nunit = \"{unit}\"\n"
                ));
                channels.push(channel(name, unit));
                series.push(own);
            }
            groups.push(Group { source: source.into(), channels: channels.into(), series, next: 0 });
        }
        Self { groups, map }
    }

    /// Adds the next rows; whether there were any.
    pub fn poll(&mut self, rows: &mut Vec<StreamRow>) -> bool {
        for given in 0..ROWS {
            let next = self.groups.iter_mut().filter_map(|group| Some((group.next_s()?, group)));
            let Some((time_s, group)) = next.min_by(|(a, _), (b, _)| a.total_cmp(b)) else { return given > 0 };
            let values = group.series.iter().map(|series| series.values.get(group.next).copied().unwrap_or(f64::NAN));
            let values = std::iter::once(time_s).chain(values).collect();
            rows.push(StreamRow { source: Arc::clone(&group.source), channels: Arc::clone(&group.channels), values });
            group.next += 1;
        }
        true
    }
}
