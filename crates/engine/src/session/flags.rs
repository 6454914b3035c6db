//! What is either so or not so of a window, and changes no result.

use serde::{Deserialize, Serialize};

/// The flags of a window, each a key of its own in the session's file, left out where it is not set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowFlags {
    /// Its edges are not dragged; they may still be typed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub locked: bool,
}

/// One of the flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowFlag {
    /// [`WindowFlags::locked`].
    Locked,
}

impl WindowFlag {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Locked => "lock",
        }
    }

    /// What setting it does to a window, or taking it back.
    pub fn verb(self, on: bool) -> &'static str {
        match (self, on) {
            (Self::Locked, true) => "lock",
            (Self::Locked, false) => "unlock",
        }
    }

    /// The flag among those of a window.
    pub fn among(self, flags: &mut WindowFlags) -> &mut bool {
        match self {
            Self::Locked => &mut flags.locked,
        }
    }
}
