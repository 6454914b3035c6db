//! Panels: each draws one aspect of the session and asks for changes by commands.

mod shortcuts;

use eframe::egui;
use serde::{Deserialize, Serialize};

use crate::command::{CommandInfo, UiCommand};
use crate::widgets::time_view::TimeView;

/// The panels there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Pane {
    /// Every command with its keys.
    Shortcuts,
}

impl Pane {
    /// Every panel, in the order menus show them.
    pub const ALL: &'static [Self] = &[Self::Shortcuts];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Shortcuts => "Shortcuts",
        }
    }

    /// Makes the panel.
    pub fn build(self) -> Box<dyn Panel> {
        match self {
            Self::Shortcuts => Box::new(shortcuts::Shortcuts),
        }
    }
}

/// What a panel may look at and what it may ask for.
pub struct PanelContext<'a> {
    /// Stretch of time on screen, cursor and markers: shared by every panel with a time axis.
    pub time: &'a mut TimeView,
    /// The table of commands.
    pub table: &'a [CommandInfo],
    /// Commands to carry out before the next frame.
    pub commands: &'a mut Vec<UiCommand>,
}

/// One panel.
pub trait Panel {
    /// Draws it.
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut egui::Ui);
}
