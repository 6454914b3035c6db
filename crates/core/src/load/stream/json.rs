//! Lines of JSON.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::{Map, Value};

use crate::load::names::stated_unit::split_unit;

use crate::load::row::{StreamChannel, StreamRow};

/// Most sources and most channels of one that are told apart.
const MOST_SOURCES: usize = 100;
const MOST_CHANNELS: usize = 1000;

/// Decodes lines of JSON: an object of numbers by channel, objects within it as `outer.inner`, lists as `name[0]`; `source` (or
/// `topic`) with a text names the source, which is `stream` otherwise. A channel that a line leaves out has no value there.
#[derive(Debug, Default)]
pub struct JsonDecoder {
    sources: BTreeMap<String, Known>,
    /// Lines that are no JSON object, or beyond the channels that are told apart.
    pub refused: usize,
}

/// Channels of a source by their keys, in order of their first appearance.
#[derive(Debug)]
struct Known {
    name: Arc<str>,
    keys: BTreeMap<String, usize>,
    channels: Arc<[StreamChannel]>,
}

impl JsonDecoder {
    /// The row that a line holds.
    pub fn decode(&mut self, line: &str) -> Option<StreamRow> {
        let found = match serde_json::from_str::<Value>(line) {
            Ok(Value::Object(object)) => self.row(&object),
            _ => None,
        };
        self.refused += usize::from(found.is_none());
        found
    }

    fn row(&mut self, object: &Map<String, Value>) -> Option<StreamRow> {
        let named = ["source", "topic"].iter().find_map(|key| object.get(*key)?.as_str());
        let source = named.unwrap_or("stream");
        let mut numbers = Vec::new();
        for (key, value) in object {
            flatten(key, value, &mut numbers);
        }
        if numbers.is_empty() || (self.sources.len() >= MOST_SOURCES && !self.sources.contains_key(source)) {
            return None;
        }
        let known = self.sources.entry(source.to_owned()).or_insert_with(|| Known {
            name: source.into(),
            keys: BTreeMap::new(),
            channels: Arc::default(),
        });
        let news: Vec<&String> =
            numbers.iter().map(|(key, _)| key).filter(|key| !known.keys.contains_key(*key)).collect();
        if !news.is_empty() {
            let mut channels = known.channels.to_vec();
            for key in news.into_iter().take(MOST_CHANNELS.saturating_sub(channels.len())) {
                known.keys.insert(key.clone(), channels.len());
                let (name, unit) = split_unit(key);
                channels.push(StreamChannel { name, unit });
            }
            known.channels = channels.into();
        }
        let mut values = vec![f64::NAN; known.channels.len()];
        for (key, value) in numbers {
            if let Some(&at) = known.keys.get(&key) {
                values[at] = value;
            }
        }
        Some(StreamRow { source: Arc::clone(&known.name), channels: Arc::clone(&known.channels), values })
    }
}

/// Numbers of a value by their keys.
fn flatten(key: &str, value: &Value, numbers: &mut Vec<(String, f64)>) {
    match value {
        Value::Number(number) => numbers.push((key.to_owned(), number.as_f64().unwrap_or(f64::NAN))),
        Value::Bool(flag) => numbers.push((key.to_owned(), f64::from(u8::from(*flag)))),
        Value::Null => numbers.push((key.to_owned(), f64::NAN)),
        Value::Object(inner) => {
            inner.iter().for_each(|(name, value)| flatten(&format!("{key}.{name}"), value, numbers))
        }
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(index, value)| flatten(&format!("{key}[{index}]"), value, numbers));
        }
        Value::String(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_different_channels_share_one_source() {
        let mut decoder = JsonDecoder::default();
        let first = decoder.decode(r#"{"time": 1.5, "imu": {"p": 0.1, "a": [1, 2]}, "alpha [deg]": 3}"#).unwrap();
        let names: Vec<&str> = first.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names.len(), 5);
        assert!(names.contains(&"imu.p") && names.contains(&"imu.a[1]") && names.contains(&"alpha"));
        let second = decoder.decode(r#"{"time": 1.6, "beta": null, "on": true, "note": "x"}"#).unwrap();
        assert_eq!((second.channels.len(), second.values.iter().filter(|value| value.is_finite()).count()), (7, 2));
        assert_eq!(&*decoder.decode(r#"{"source": "gps", "v": 1}"#).unwrap().source, "gps");
        for bad in ["", "[1]", "{", r#"{"a": "b"}"#, "\u{0}"] {
            assert_eq!(decoder.decode(bad), None);
        }
        assert_eq!(decoder.refused, 5);
    }
}
