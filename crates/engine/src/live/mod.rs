//! A flight while it is flown: rows as they arrive, the filter step by step, equation error by recursion, lamps, limits, recording.
//!
//! `source` gives rows, `columns` keeps their channels in one order, `arrivals` leaves out doubled and stray ones by the `clock` of each source, the channel map makes samples of roles of them, `pace` holds them until their time, `pipeline` orders them in time and
//! computes, `airborne` decides flight or ground, `silence` gives alarms where nothing comes, `age` is that of the newest sample, `news` leaves out findings already stated, `record` keeps the rows, a `source_file` each source, and a session of them. `watch` ties these together.

mod age;
mod airborne;
mod arrivals;
mod clock;
mod columns;
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
mod source_file;
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
