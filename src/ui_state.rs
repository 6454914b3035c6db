//! What the workbench remembers about its own looks: layout, zoom, theme. Never part of a session.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use doublet_core::series::Series;
use doublet_engine::report::document::{Logo, SectionKind, Style, UnitSystem};
use doublet_engine::session::{Annotation, Manoeuvre, Session};
use doublet_engine::trace::TraceView;
use doublet_report::ReportFormat;
use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};

use crate::command::FileField;
use crate::layouts::{Arranged, LayoutKey};
use crate::notation::Units;
use crate::pane::Pane;
use crate::step::Step;
use crate::widgets::time_view::{TimeRange, TimeView};

/// Where it lies in the application's storage.
const STORAGE_KEY: &str = "doublet_ui";
/// Version of the stored form; another one is left alone and the first layout shown.
const VERSION: u32 = 5;
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
}

/// A candidate by its flight and the bits of its start, s.
pub type CandidateKey = (String, u64);

/// What a candidate is known by.
pub fn key_of(candidate: &Manoeuvre) -> CandidateKey {
    (candidate.flight.clone(), candidate.window.start_s.to_bits())
}

/// What the user looks at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Flight shown.
    pub flight: Option<String>,
    /// Window chosen.
    pub window: Option<String>,
    /// Windows selected beside the chosen one: what is done to several is done to these too.
    pub others: BTreeSet<String>,
    /// Candidates selected.
    pub candidates: BTreeSet<CandidateKey>,
    /// Derivative highlighted, for example `Cm_q`.
    pub derivative: Option<String>,
    /// Estimates shown.
    pub scope: Scope,
    /// Tables show the constant of every window.
    pub constants: bool,
}

impl Selection {
    /// Whether the window `name` is the chosen one or selected beside it.
    pub fn is_selected(&self, name: &str) -> bool {
        self.window.as_deref() == Some(name) || self.others.contains(name)
    }

    /// Whether a candidate is selected.
    pub fn has_candidate(&self, candidate: &Manoeuvre) -> bool {
        self.candidates.contains(&key_of(candidate))
    }

    /// The windows of `session` that are selected, in its order.
    pub fn windows<'a>(&'a self, session: &'a Session) -> impl Iterator<Item = &'a Manoeuvre> {
        session.windows.iter().filter(|window| self.is_selected(&window.name))
    }
}

/// What a report is to hold.
#[derive(Clone, Debug)]
pub struct ReportChoice {
    /// Sections it is to go without.
    pub left_out: BTreeSet<SectionKind>,
    /// Forms it is written in.
    pub formats: Vec<ReportFormat>,
    /// Section on screen.
    pub shown: SectionKind,
    /// Whether the printed pages are on screen in place of a section.
    pub as_pages: bool,
}

impl Default for ReportChoice {
    fn default() -> Self {
        Self {
            left_out: BTreeSet::new(),
            formats: ReportFormat::ALL.into_iter().filter(|format| format.is_in_this_build()).collect(),
            shown: SectionKind::Overview,
            as_pages: ReportFormat::Pdf.is_in_this_build(),
        }
    }
}

/// House style of reports: the same for all sessions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HouseStyle {
    /// Words at the head of every page.
    pub header: String,
    /// Words at the foot of every page.
    pub footer: String,
    /// Colour of headings; that of the program unless chosen.
    pub accent: Option<[u8; 3]>,
    /// File of the logo; empty for none.
    pub logo: String,
    /// Airspeeds in kt and altitudes in ft, not in m/s and m.
    pub in_knots_and_feet: bool,
    /// Who signs, a line each; empty for the usual ones.
    pub signatures: String,
    /// Names of the sections that come first, in their order; the others follow.
    pub order: Vec<String>,
}

impl HouseStyle {
    /// All sections in their order.
    pub fn sections(&self) -> Vec<SectionKind> {
        let named = |name: &String| SectionKind::from_name(name);
        let mut order: Vec<SectionKind> = self.order.iter().filter_map(named).collect();
        let others: Vec<SectionKind> = SectionKind::ALL.into_iter().filter(|kind| !order.contains(kind)).collect();
        order.extend(others);
        order
    }

    /// Puts a section before the one ahead of it.
    pub fn move_up(&mut self, kind: SectionKind) {
        let mut order = self.sections();
        if let Some(at) = order.iter().position(|own| *own == kind).filter(|at| *at > 0) {
            order.swap(at - 1, at);
        }
        self.order = order.into_iter().map(|kind| kind.name().to_owned()).collect();
    }

    /// The style of a report.
    pub fn style(&self) -> Result<Style, String> {
        let usual = Style::default();
        let lines = self.signatures.lines().map(str::trim).filter(|line| !line.is_empty());
        Ok(Style {
            header: self.header.clone(),
            footer: self.footer.clone(),
            accent: self.accent.map_or(usual.accent, |[red, green, blue]| format!("#{red:02x}{green:02x}{blue:02x}")),
            logo: (!self.logo.is_empty()).then(|| Logo::open(Path::new(&self.logo))).transpose()?,
            units: if self.in_knots_and_feet { UnitSystem::Aviation } else { UnitSystem::Si },
            sections: Vec::new(),
            signatures: lines.map(str::to_owned).collect(),
            is_compact: false,
        })
    }
}

/// A curve that is to be seen otherwise.
#[derive(Clone, Debug)]
pub struct TraceRequest {
    /// Name of the curve.
    pub name: String,
    /// Unit it is drawn in.
    pub unit: String,
    /// Factor from SI to that unit.
    pub scale: f64,
    /// Samples, SI.
    pub series: Series,
    /// Part on screen.
    pub range: TimeRange,
    /// How it is seen.
    pub view: TraceView,
    /// Name, unit and factor of the curve it is drawn over.
    pub over: Option<(String, String, f64)>,
}

/// Layout, zoom and theme.
#[derive(Serialize, Deserialize)]
pub struct UiState {
    version: u32,
    /// Where the panels are.
    pub shown: Arranged,
    /// The layouts that were on screen before, and those kept under a name.
    pub kept: Vec<Arranged>,
    /// What each of the sessions opened last looked like.
    pub thumbnails: BTreeMap<PathBuf, Thumbnail>,
    /// Part of the flight on screen.
    pub time: TimeView,
    /// Session that part is of; `None` for one without a file.
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
    /// The note being written, by the name of its manoeuvre.
    #[serde(skip)]
    pub noting: Option<(String, String)>,
    /// Time the menu was opened on from which the next command comes, s.
    #[serde(skip)]
    pub at_s: Option<f64>,
    /// Start of the candidate that is asked about first, s.
    #[serde(skip)]
    pub candidate_s: Option<f64>,
    /// An instruments file with what was fitted, to be written.
    #[serde(skip)]
    pub instruments: Option<String>,
    /// Name and file text of an aircraft that was described, to be written.
    #[serde(skip)]
    pub described_aircraft: Option<(String, String)>,
    /// What a dialog has chosen for a field of a panel, until the panel takes it.
    #[serde(skip)]
    pub picked: Option<(FileField, PathBuf)>,
    /// The annotation being written, and the one it takes the place of.
    #[serde(skip)]
    pub annotating: Option<(Annotation, Option<Annotation>)>,
    /// What a report is to hold.
    #[serde(skip)]
    pub report: ReportChoice,
    /// How reports look.
    #[serde(default)]
    pub house: HouseStyle,
    /// The analysis of a curve that is asked for.
    #[serde(skip)]
    pub analysis: Option<TraceRequest>,
    /// Channels in the plots of the flight, one list per plot; `None` for the usual ones.
    pub flight_plots: Option<Vec<Vec<String>>>,
    /// Experiments drawn over the session in the plots, by name.
    #[serde(default)]
    pub overlaid: Vec<String>,
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
            shown: Arranged::new(LayoutKey::Step(Step::Results)),
            kept: Vec::new(),
            thumbnails: BTreeMap::new(),
            time: TimeView::default(),
            session: None,
            window_time: TimeView::default(),
            selection: Selection::default(),
            renaming: None,
            instruments: None,
            described_aircraft: None,
            picked: None,
            annotating: None,
            noting: None,
            at_s: None,
            candidate_s: None,
            report: ReportChoice::default(),
            house: HouseStyle::default(),
            analysis: None,
            flight_plots: None,
            overlaid: Vec::new(),
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
        stored.filter(|state| state.version == VERSION && state.shown.tree.root().is_some()).unwrap_or_default()
    }

    /// Puts `path` at the head of the sessions opened last.
    pub fn remember(&mut self, path: &Path) {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
        self.thumbnails.retain(|path, _| self.recent.contains(path));
    }

    /// The candidate that is asked about, of those on screen in the order of time.
    pub fn candidate_of<'a>(&self, mut shown: impl Iterator<Item = &'a Manoeuvre>) -> Option<&'a Manoeuvre> {
        let first = shown.next()?;
        let from_s = self.candidate_s.unwrap_or(f64::NEG_INFINITY);
        if first.window.start_s >= from_s {
            Some(first)
        } else {
            shown.find(|one| one.window.start_s >= from_s).or(Some(first))
        }
    }

    /// Puts the layout `key` on screen; the one before is kept as it is.
    pub fn show_layout(&mut self, key: LayoutKey) {
        if self.shown.key == key {
            return;
        }
        let at = self.kept.iter().position(|kept| kept.key == key);
        let next = at.map_or_else(|| Arranged::new(key), |at| self.kept.remove(at));
        self.kept.push(std::mem::replace(&mut self.shown, next));
    }

    /// Makes `pane` visible: in the layout on screen where that has it, in that of its step otherwise. A layout that is not a step's
    /// takes it in.
    pub fn show_pane(&mut self, pane: Pane) {
        let is_step = matches!(self.shown.key, LayoutKey::Step(_));
        if let Some(step) = Step::of_pane(pane).filter(|_| is_step && !self.shown.holds(pane)) {
            self.show_layout(LayoutKey::Step(step));
        }
        self.shown.bring_to_front(pane);
    }

    /// Names of the layouts kept under one, in their order.
    pub fn layout_names(&self) -> Vec<&str> {
        let all = self.kept.iter().chain([&self.shown]);
        let named =
            all.filter_map(|kept| if let LayoutKey::Named(name) = &kept.key { Some(name.as_str()) } else { None });
        let mut names: Vec<&str> = named.collect();
        names.sort_unstable();
        names
    }

    /// Keeps the layout on screen under `name`, and shows that from now on.
    pub fn keep_layout(&mut self, name: &str) {
        let key = LayoutKey::Named(name.to_owned());
        let kept = Arranged { key: key.clone(), touched: true, ..self.shown.clone() };
        self.kept.retain(|other| other.key != key);
        if self.shown.key != key {
            self.kept.push(std::mem::replace(&mut self.shown, kept));
        }
    }

    /// Forgets the layout kept under `name`.
    pub fn forget_layout(&mut self, name: &str) {
        let key = LayoutKey::Named(name.to_owned());
        if self.shown.key == key {
            self.show_layout(LayoutKey::Overview);
        }
        self.kept.retain(|kept| kept.key != key);
    }

    /// Stores it.
    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, STORAGE_KEY, self);
    }
}

/// What a session looked like when it was open last: its altitude over its time and its windows, each from 0 to 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thumbnail {
    pub title: String,
    /// Its verdict in one line.
    pub verdict: String,
    /// Day it was open last, `YYYY-MM-DD`; empty where that is not known.
    #[serde(default)]
    pub opened: String,
    /// Altitude over time, from the first sample to the last and from the lowest to the highest.
    pub altitude: Vec<[f32; 2]>,
    /// Start and end of its windows over the same time.
    pub windows: Vec<[f32; 2]>,
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use eframe::Storage;

    use super::*;

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
        assert_eq!(back.shown, state.shown);
        state.version = VERSION + 1;
        state.save(&mut memory);
        assert_eq!(UiState::load(Some(&memory)).appearance, UiState::default().appearance);
        memory.set_string(STORAGE_KEY, "(not what it was".to_owned());
        assert_eq!(UiState::load(Some(&memory)).appearance, UiState::default().appearance);
        assert_eq!(UiState::load(None).version, VERSION);
    }

    #[test]
    fn panel_is_shown_where_it_is_at_home_and_the_layout_before_comes_back_as_it_was() {
        let mut state = UiState::default();
        state.show_pane(Pane::Derivatives);
        assert_eq!(state.shown.key, LayoutKey::Step(Step::Results), "the layout on screen has it");
        let left = state.shown.clone();
        state.show_pane(Pane::Noise);
        assert_eq!(state.shown.key, LayoutKey::Step(Step::Filter));
        state.show_layout(LayoutKey::Step(Step::Results));
        assert_eq!(state.shown, left);
        state.show_layout(LayoutKey::Overview);
        state.show_pane(Pane::Shortcuts);
        assert_eq!(state.shown.key, LayoutKey::Overview, "a layout that is not a step's takes it in");
        assert!(state.shown.holds(Pane::Shortcuts));
    }

    #[test]
    fn named_layouts_are_kept_shown_and_forgotten() {
        let mut state = UiState::default();
        let before = state.shown.clone();
        state.keep_layout("mine");
        assert_eq!(state.layout_names(), ["mine"]);
        state.shown.bring_to_front(Pane::Log);
        state.show_layout(LayoutKey::Step(Step::Results));
        assert_eq!(state.shown, before, "the step's own is untouched");
        let mut memory = Memory::default();
        state.save(&mut memory);
        let mut back = UiState::load(Some(&memory));
        back.show_layout(LayoutKey::Named("mine".to_owned()));
        assert!(back.shown.holds(Pane::Log));
        back.forget_layout("mine");
        assert_eq!(back.layout_names(), [""; 0]);
        assert_eq!(back.shown.key, LayoutKey::Overview);
    }
}
