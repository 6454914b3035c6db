//! What the workbench remembers about its own looks: layout, zoom, theme. Never part of a session.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use doublet_engine::report::document::SectionKind;
use doublet_report::ReportFormat;
use eframe::egui::{Id, ThemePreference};
use egui_tiles::{Linear, LinearDir, Tile, Tiles, Tree};
use serde::{Deserialize, Serialize};

use crate::notation::Units;
use crate::panels::Pane;
use crate::widgets::time_view::TimeView;

/// Where it lies in the application's storage.
const STORAGE_KEY: &str = "doublet_ui";
/// Version of the stored form; another one is left alone and the first layout shown.
const VERSION: u32 = 4;
/// How many sessions are remembered.
const RECENT: usize = 8;

/// The windows whose estimates are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// One estimate from all identification windows.
    #[default]
    All,
    /// The chosen window alone.
    Chosen,
    /// Every window by itself, side by side.
    Each,
    /// Estimates of single windows over all of them and by kind of input.
    Over,
    /// The estimate of every window with its interval, one derivative at a time.
    Intervals,
    /// The two structures of the session beside each other.
    Structures,
}

/// What the user looks at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Flight shown.
    pub flight: Option<String>,
    /// Window chosen.
    pub window: Option<String>,
    /// Derivative highlighted, for example `Cm_q`.
    pub derivative: Option<String>,
    /// Estimates shown.
    pub scope: Scope,
    /// Tables show the constant of every window.
    pub constants: bool,
}

/// What a report is to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportChoice {
    /// Sections it is to go without.
    pub left_out: BTreeSet<SectionKind>,
    /// Forms it is written in.
    pub formats: Vec<ReportFormat>,
    /// Section on screen.
    pub shown: SectionKind,
}

impl Default for ReportChoice {
    fn default() -> Self {
        Self {
            left_out: BTreeSet::new(),
            formats: ReportFormat::ALL.into_iter().filter(|format| format.is_in_this_build()).collect(),
            shown: SectionKind::Overview,
        }
    }
}

/// Layout, zoom and theme.
#[derive(Serialize, Deserialize)]
pub struct UiState {
    version: u32,
    /// Where the panels are.
    pub layout: Tree<Pane>,
    /// Part of the flight on screen.
    pub time: TimeView,
    /// Session that stretch is of; `None` for one without a file.
    pub session: Option<PathBuf>,
    /// Part of the chosen window on screen.
    #[serde(skip)]
    pub window_time: TimeView,
    /// What the user looks at.
    #[serde(skip)]
    pub selection: Selection,
    /// Window whose name the table of windows shall let be typed.
    #[serde(skip)]
    pub renaming: Option<String>,
    /// What a report is to hold.
    #[serde(skip)]
    pub report: ReportChoice,
    /// Channels in the plots of the flight, one list per plot; `None` for the usual ones.
    pub flight_plots: Option<Vec<Vec<String>>>,
    /// Sessions opened last, newest first.
    pub recent: Vec<PathBuf>,
    /// Dark, light or as the system.
    pub appearance: ThemePreference,
    /// Units shown.
    pub units: Units,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            version: VERSION,
            layout: default_layout(),
            time: TimeView::default(),
            session: None,
            window_time: TimeView::default(),
            selection: Selection::default(),
            renaming: None,
            report: ReportChoice::default(),
            flight_plots: None,
            recent: Vec::new(),
            appearance: ThemePreference::Dark,
            units: Units::default(),
        }
    }
}

impl UiState {
    /// What was stored last; the first layout when nothing was, or by another version.
    pub fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        let stored: Option<Self> = storage.and_then(|storage| eframe::get_value(storage, STORAGE_KEY));
        stored.filter(|state| state.version == VERSION && state.layout.root().is_some()).unwrap_or_default()
    }

    /// Puts `path` at the head of the sessions opened last.
    pub fn remember(&mut self, path: &Path) {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    /// Stores it.
    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, STORAGE_KEY, self);
    }
}

/// Where the panels are at first: the flight and what became of its windows on the left, settings and results on the right.
pub fn default_layout() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let children = panes.iter().map(|&pane| tiles.insert_pane(pane)).collect();
        tiles.insert_tab_tile(children)
    };
    let flight = tabs(&[Pane::Flight, Pane::GroundTrack, Pane::CrossPlot]);
    let plots =
        tabs(&[Pane::Reconstruction, Pane::Innovations, Pane::Fits, Pane::Match, Pane::Propulsion, Pane::Dynamics]);
    let settings = tabs(&[Pane::Manoeuvres, Pane::Preprocess, Pane::Noise, Pane::Model, Pane::Loading]);
    let results = tabs(&[
        Pane::Summary,
        Pane::Derivatives,
        Pane::Correlation,
        Pane::Sensitivity,
        Pane::Report,
        Pane::Log,
        Pane::Shortcuts,
    ]);
    let left = Linear::new_binary(LinearDir::Vertical, [flight, plots], 0.5);
    let left = tiles.insert_container(left);
    let right = Linear::new_binary(LinearDir::Vertical, [settings, results], 0.48);
    let right = tiles.insert_container(right);
    let all = Linear::new_binary(LinearDir::Horizontal, [left, right], 0.58);
    let root = tiles.insert_container(all);
    Tree::new(Id::unique("workbench"), root, tiles)
}

/// Makes `pane` visible, opening it beside the others where it was closed.
pub fn bring_to_front(layout: &mut Tree<Pane>, pane: Pane) {
    if layout.tiles.find_pane(&pane).is_none() {
        let new = layout.tiles.insert_pane(pane);
        match layout.root().and_then(|root| layout.tiles.get_mut(root)) {
            Some(Tile::Container(container)) => container.add_child(new),
            _ => *layout = default_layout(),
        }
    }
    layout.make_active(|_, tile| matches!(tile, Tile::Pane(held) if *held == pane));
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use eframe::Storage;

    use super::*;
    use crate::widgets::time_view::TimeRange;

    /// Storage in memory.
    #[derive(Default)]
    struct Memory(HashMap<String, String>);

    impl Storage for Memory {
        fn get_string(&self, key: &str) -> Option<String> {
            self.0.get(key).cloned()
        }

        fn set_string(&mut self, key: &str, value: String) {
            self.0.insert(key.to_owned(), value);
        }

        fn remove_string(&mut self, key: &str) {
            self.0.remove(key);
        }

        fn flush(&mut self) {}
    }

    #[test]
    fn stored_looks_come_back_and_those_of_another_version_do_not() {
        let mut time = TimeView::new(TimeRange::new(0.0, 5400.0));
        time.zoom_to(TimeRange::new(100.0, 160.0));
        time.markers_s = [Some(120.0), None];
        let mut state = UiState { time, appearance: ThemePreference::Light, ..UiState::default() };
        let mut memory = Memory::default();
        state.save(&mut memory);
        let back = UiState::load(Some(&memory));
        assert_eq!(back.time.range(), state.time.range());
        assert_eq!(back.time.markers_s, state.time.markers_s);
        assert_eq!(back.appearance, ThemePreference::Light);
        assert_eq!(back.layout, state.layout);
        state.version = VERSION + 1;
        state.save(&mut memory);
        assert_eq!(UiState::load(Some(&memory)).appearance, UiState::default().appearance);
        memory.set_string(STORAGE_KEY, "(not what it was".to_owned());
        assert_eq!(UiState::load(Some(&memory)).appearance, UiState::default().appearance);
        assert_eq!(UiState::load(None).version, VERSION);
    }

    #[test]
    fn closed_panel_comes_back_to_the_front() {
        let mut layout = default_layout();
        let closed = layout.tiles.find_pane(&Pane::Shortcuts).unwrap();
        layout.remove_recursively(closed);
        bring_to_front(&mut layout, Pane::Shortcuts);
        let shown = layout.tiles.find_pane(&Pane::Shortcuts).unwrap();
        assert!(layout.is_visible_in_layout(shown));
    }
}
