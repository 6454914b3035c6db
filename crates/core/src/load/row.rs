//! A row of values.

use std::sync::Arc;

/// One channel of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamChannel {
    /// Name.
    pub name: String,
    /// Unit, where the stream states one.
    pub unit: Option<String>,
}

/// Values of all channels of a source at one moment, as they arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamRow {
    /// Source: file, topic or message.
    pub source: Arc<str>,
    /// Its channels.
    pub channels: Arc<[StreamChannel]>,
    /// One value per channel; not a number where there is none.
    pub values: Vec<f64>,
}
