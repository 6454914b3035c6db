//! How a command ended, and the exit code that says so.

use doublet_engine::verdict::Level;

/// How a command ended that did what it was asked for; one that could not ends in one line of error and exit code 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing found is bad: exit code 0.
    Done,
    /// Something found is bad: exit code 3.
    Bad,
}

impl From<()> for Outcome {
    fn from((): ()) -> Self {
        Self::Done
    }
}

impl From<Level> for Outcome {
    fn from(level: Level) -> Self {
        if level == Level::Bad { Self::Bad } else { Self::Done }
    }
}

impl Outcome {
    /// Exit code that says so.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Bad => 3,
        }
    }
}
