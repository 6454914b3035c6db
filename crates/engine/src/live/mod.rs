//! A flight while it is flown: rows as they arrive, the filter step by step, equation error by recursion, lamps, limits, recording.
//!
//! `source` gives rows, `arrivals` leaves out doubled and stray ones, the channel map makes samples of roles of them, `pace` holds them until their time, `pipeline` orders them in time and
//! computes, `airborne` decides flight or ground, `silence` gives alarms where nothing comes, `news` leaves out findings already stated, `record` keeps the rows and a session of them. `watch` ties these together.

mod airborne;
mod arrivals;
mod estimates;
mod limits;
mod news;
mod open;
mod order;
mod pace;
mod pipeline;
mod record;
mod recorded_file;
mod replay;
mod settings;
mod silence;
mod source;
mod update;
mod watch;

pub use limits::{Limit, LimitReading};
pub use open::{Feed, Opening, Watched, open};
pub use pipeline::LivePipeline;
pub use record::Recorded;
pub use replay::Replay;
pub use settings::{Goal, LiveSettings};
pub use source::{LineFormat, Polled, Source};
pub use update::{CorrelationLamp, Counts, LiveDerivative, LiveUpdate, TimeDomain};
pub use watch::{LiveWatch, Step};
