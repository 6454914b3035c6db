//! What is either so or not so of a window, and changes no result.

/// The flags of a window, each a key of its own in the session's file, left out where it is not set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WindowFlags {
    /// Its edges are not dragged; they may still be typed.
    pub locked: bool,
    /// Somebody looked at it and takes it as it stands.
    pub confirmed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowFlag {
    Locked,
    Confirmed,
}

impl WindowFlag {
    doublet_core::variant_texts! {
        /// The word for it.
        pub name: Locked "lock", Confirmed "confirmation"
    }

    /// What setting it does to a window, or taking it back.
    pub fn verb(self, on: bool) -> &'static str {
        match (self, on) {
            (Self::Locked, true) => "lock",
            (Self::Locked, false) => "unlock",
            (Self::Confirmed, true) => "confirm",
            (Self::Confirmed, false) => "undo confirmation of",
        }
    }

    /// The flag among those of a window.
    pub fn among(self, flags: &mut WindowFlags) -> &mut bool {
        match self {
            Self::Locked => &mut flags.locked,
            Self::Confirmed => &mut flags.confirmed,
        }
    }
}
