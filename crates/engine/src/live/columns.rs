//! Channels of a source in one order: a file that is written anew may have others, or the same in another order.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::load::stream::{StreamChannel, StreamRow};

/// Channels of all sources.
#[derive(Debug, Default)]
pub(super) struct Columns {
    sources: BTreeMap<Arc<str>, Known>,
}

/// Channels of one source.
#[derive(Debug)]
struct Known {
    /// All of them, in the order of their first row.
    channels: Arc<[StreamChannel]>,
    /// Those of the latest row.
    latest: Arc<[StreamChannel]>,
    /// Places of the latest among all; none where they are the first of all.
    places: Option<Vec<usize>>,
}

impl Known {
    fn learn(&mut self, latest: &Arc<[StreamChannel]>) {
        self.latest = Arc::clone(latest);
        self.places = None;
        if latest.starts_with(&self.channels) {
            self.channels = Arc::clone(latest);
            return;
        }
        let mut channels = self.channels.to_vec();
        let mut place = |channel: &StreamChannel| {
            channels.iter().position(|known| known == channel).unwrap_or_else(|| {
                channels.push(channel.clone());
                channels.len() - 1
            })
        };
        self.places = Some(latest.iter().map(&mut place).collect());
        self.channels = channels.into();
    }
}

impl Columns {
    /// The row with all channels that its source had so far, those it lacks without a value.
    pub(super) fn align(&mut self, row: StreamRow) -> StreamRow {
        let known = self.sources.entry(Arc::clone(&row.source)).or_insert_with(|| {
            let channels = || Arc::clone(&row.channels);
            Known { channels: channels(), latest: channels(), places: None }
        });
        if !Arc::ptr_eq(&known.latest, &row.channels) {
            known.learn(&row.channels);
        }
        let Some(places) = &known.places else { return row };
        let mut values = vec![f64::NAN; known.channels.len()];
        for (place, value) in places.iter().zip(&row.values) {
            values[*place] = *value;
        }
        StreamRow { values, channels: Arc::clone(&known.channels), source: row.source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aligned(columns: &mut Columns, names: &[&str], values: &[f64]) -> (usize, Vec<f64>) {
        let channel = |name: &&str| StreamChannel { name: (*name).to_owned(), unit: None };
        let channels = names.iter().map(channel).collect::<Vec<_>>().into();
        let row = columns.align(StreamRow { source: "log".into(), channels, values: values.to_vec() });
        (row.channels.len(), row.values)
    }

    #[test]
    fn values_stay_with_the_names_of_their_channels() {
        let mut columns = Columns::default();
        assert_eq!(aligned(&mut columns, &["time", "p"], &[0.0, 1.0]), (2, vec![0.0, 1.0]));
        assert_eq!(aligned(&mut columns, &["time", "p", "q"], &[0.0, 1.0, 2.0]), (3, vec![0.0, 1.0, 2.0]));
        let (count, values) = aligned(&mut columns, &["q", "r", "time"], &[2.0, 3.0, 0.5]);
        assert!(count == 4 && values[1].is_nan(), "{values:?}");
        assert_eq!([values[0], values[2], values[3]], [0.5, 2.0, 3.0]);
    }
}
