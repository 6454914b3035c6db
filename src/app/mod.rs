//! The application: owns the state; `logic` changes it, `draw` shows it.

mod analysis;
mod annotate;
mod begin;
mod changed;
mod dispatch;
mod draw;
mod fault;
pub mod files;
pub mod help;
mod history;
mod logic;
mod mark_commands;
mod pending;
mod public;
mod recovery;
mod second;
mod start;
mod step_bar;
mod timeline;
mod tour;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use doublet_engine::autosave::state_folder;
use doublet_engine::compare::PRESENT;
pub use doublet_engine::document::Document;
use doublet_engine::graph::Cache;
use doublet_engine::keep::Put;
use doublet_engine::report::Reference;
use doublet_engine::run::{CACHE_BYTES, Engine, Job, Request, Snapshot};
use doublet_engine::session::Session;
use doublet_engine::study::Study;
use eframe::egui;

pub use pending::{Asked, Pending};
pub use step_bar::{Mark, mark};

use crate::command::{CommandInfo, CommandPalette, UiCommand, ui_command};
use crate::panels::{EditRequest, GuardedPanel, Pane};
use crate::theme;
use crate::ui_state::UiState;
use crate::widgets::figure::FigureRequest;
use begin::Beginning;
use files::Files;
use recovery::Recovery;

/// Something to tell the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// One line.
    pub text: String,
    /// Something went wrong.
    pub is_error: bool,
    /// It says that manoeuvres share time.
    pub is_overlap: bool,
    /// File or folder that was written and can be opened.
    pub written: Option<std::path::PathBuf>,
}

pub struct Workbench {
    /// Layout, zoom, theme.
    pub state: UiState,
    /// Finds commands by name.
    pub palette: CommandPalette,
    /// The session being worked on.
    pub document: Document,
    /// Asks for files.
    pub files: Files,
    /// Derivatives from elsewhere, marked beside the estimates.
    pub references: Vec<Reference>,
    /// The last thing that was said, until it is closed.
    pub message: Option<Message>,
    engine: Engine,
    snapshot: Arc<Snapshot>,
    requested: Option<Arc<Session>>,
    /// Generation of the run that was requested last, unless it was cancelled.
    awaited: u64,
    /// Whether the next run is the first of a document.
    fresh: bool,
    cause: String,
    /// What a run computes beside the derivatives, until one has done so.
    studies: Vec<Study>,
    asked: Option<Asked>,
    guarded: Option<Pending>,
    changed: Option<changed::Question>,
    /// SHA-256 of the version on disk that was answered with "Stay".
    stayed_with: Option<String>,
    exporting: Option<Job<Put>>,
    /// What the desktop is asked to open.
    opening: Option<(std::path::PathBuf, std::thread::JoinHandle<std::io::Result<()>>)>,
    recovery: Recovery,
    beginning: Beginning,
    leaving: bool,
    /// The panic of a frame, until the window is drawn again.
    fault: Option<String>,
    /// When the message on screen was first drawn, s.
    said_at_s: Option<f64>,
    /// Whether the start page was asked for.
    start_shown: bool,
    start: start::StartPage,
    timeline: timeline::Timeline,
    /// Stop of the tour.
    tour: Option<usize>,
    /// Name being typed for the layout on screen.
    naming: Option<String>,
    /// The session a report is being written of, and the one it was written of last.
    writing: Option<Arc<Session>>,
    written: Option<Arc<Session>>,
    /// Generation whose verdict the thumbnail of the session shows.
    pictured: u64,
    /// Whether a field had the keyboard at the end of the last frame.
    typing: bool,
    title: String,
    hovered_s: Option<f64>,
    /// Panel under the pointer.
    pointed: Option<Pane>,
    /// The manual in its window.
    pub help: help::Help,
    panels: BTreeMap<Pane, GuardedPanel>,
    table: Vec<CommandInfo>,
    commands: Vec<UiCommand>,
    edits: Vec<EditRequest>,
    figures: Vec<FigureRequest>,
    figure: Option<doublet_engine::report::document::Figure>,
    /// Windows with curves seen otherwise.
    analyses: analysis::Analyses,
    /// Whether the list of edits is on screen.
    history_shown: bool,
    /// Manoeuvres chosen so far, the last at the end, and whether an edit was undone or redone since the choice was checked.
    chosen_before: Vec<String>,
    undone: bool,
    /// Whether the experiments of the session are computed until all are there, on screen or not.
    compares: bool,
    /// The session beside this one.
    second: Option<second::Second>,
}

/// What caused the first run of a document.
const OPENED: &str = "first run";

/// A document that is computed while its window is still being made.
struct Opening {
    document: Document,
    engine: Engine,
    /// Generation of the first run.
    awaited: u64,
    /// What is asked for a frame when something is published, once there is a window.
    shown: Arc<OnceLock<egui::Context>>,
}

impl Opening {
    fn new(document: Document, cache: Arc<Cache>) -> std::io::Result<Self> {
        let shown = Arc::<OnceLock<egui::Context>>::default();
        let window = Arc::clone(&shown);
        let engine = Engine::start(cache, move || {
            if let Some(ctx) = window.get() {
                ctx.request_repaint();
            }
        })?;
        let session = Arc::clone(document.history.present());
        let awaited = engine.request(Request {
            first: session.windows.first().map(|window| window.name.clone()),
            session,
            folder: document.folder.clone(),
            studies: Vec::new(),
            cause: OPENED.to_owned(),
            fresh: true,
        });
        Ok(Self { document, engine, awaited, shown })
    }
}

impl Workbench {
    /// Starts computing, sets fonts and themes up and takes the stored layout.
    pub fn new(cc: &eframe::CreationContext<'_>, document: Document) -> std::io::Result<Self> {
        Self::with_cache(cc, document, Arc::new(Cache::new(CACHE_BYTES)))
    }

    /// The same with a cache that other workbenches may share.
    pub fn with_cache(
        cc: &eframe::CreationContext<'_>,
        document: Document,
        cache: Arc<Cache>,
    ) -> std::io::Result<Self> {
        Ok(Self::open(cc, Opening::new(document, cache)?))
    }

    /// Sets fonts and themes up and takes the stored layout, for what is being computed already.
    fn open(cc: &eframe::CreationContext<'_>, opening: Opening) -> Self {
        let Opening { document, engine, awaited, shown: window } = opening;
        theme::install(&cc.egui_ctx);
        let state = UiState::load(cc.storage);
        cc.egui_ctx.set_theme(state.appearance);
        // What was published before is read by the first frame.
        let _ = window.set(cc.egui_ctx.clone());
        let requested = Some(Arc::clone(document.history.present()));
        let mut app = Self {
            state,
            palette: CommandPalette::default(),
            document,
            files: Files::default(),
            references: Vec::new(),
            message: None,
            engine,
            snapshot: Arc::default(),
            requested,
            awaited,
            fresh: false,
            cause: OPENED.to_owned(),
            studies: Vec::new(),
            asked: None,
            guarded: None,
            changed: None,
            stayed_with: None,
            exporting: None,
            opening: None,
            recovery: Recovery::default(),
            beginning: Beginning::default(),
            leaving: false,
            fault: None,
            said_at_s: None,
            start_shown: false,
            start: start::StartPage::default(),
            timeline: timeline::Timeline::default(),
            tour: None,
            naming: None,
            writing: None,
            written: None,
            pictured: 0,
            typing: false,
            title: String::new(),
            hovered_s: None,
            pointed: None,
            help: help::Help::default(),
            panels: Pane::ALL.iter().map(|&pane| (pane, GuardedPanel::new(pane))).collect(),
            table: ui_command::table(),
            commands: Vec::new(),
            edits: Vec::new(),
            figures: Vec::new(),
            figure: None,
            analyses: analysis::Analyses::default(),
            history_shown: false,
            chosen_before: Vec::new(),
            undone: false,
            compares: false,
            second: None,
        };
        // The zoom is kept over a restart on the same session.
        let shown = std::mem::take(&mut app.state.time);
        app.look_at_all();
        if app.state.session == app.document.path {
            app.state.time = shown;
        }
        app
    }

    /// Asks for `command` before the next frame.
    pub fn request(&mut self, command: UiCommand) {
        self.commands.push(command);
    }

    /// Everything computed so far.
    pub fn snapshot(&self) -> &Arc<Snapshot> {
        &self.snapshot
    }

    /// Whether what is shown is not yet what follows from the session.
    pub fn is_busy(&self) -> bool {
        self.engine.is_busy()
            || self.snapshot.busy
            || self.snapshot.generation < self.awaited
            || !self.requested.as_ref().is_some_and(|requested| Arc::ptr_eq(requested, self.document.history.present()))
    }

    /// Whether a closer look at the results is still to come.
    pub fn is_looking(&self) -> bool {
        self.engine.has_details_due()
    }

    /// Whether experiments that were asked for are still to be computed: they go on when their panel is left, not during a drag.
    fn has_open_experiments(&self) -> bool {
        let rows = &self.snapshot.inquiries.experiments;
        let is_open = |name: &str| rows.row(name).is_none_or(|slot| slot.ready().is_none() && slot.error().is_none());
        let experiments = &self.document.session().experiments;
        let any = is_open(PRESENT) || experiments.iter().any(|experiment| is_open(&experiment.name));
        self.compares && !experiments.is_empty() && any && !self.document.history.is_open()
    }

    /// Whether results are being written.
    pub fn is_exporting(&self) -> bool {
        self.exporting.is_some()
    }

    /// Whether the question for unsaved changes is open.
    pub fn is_guarding(&self) -> bool {
        self.guarded.is_some()
    }

    /// Whether a question or a dialog is open, to which the keys belong.
    fn is_asking(&self) -> bool {
        let own = self.guarded.is_some() || self.changed.is_some();
        own || self.files.is_asking()
            || self.is_offering_work()
            || self.is_beginning()
            || self.naming.is_some()
            || self.state.annotating.is_some()
            || self.state.noting.is_some()
    }

    /// Shows one line in the status bar.
    pub fn set_message(&mut self, text: impl Into<String>) {
        self.said_at_s = None;
        self.message = Some(Message { text: text.into(), is_error: false, is_overlap: false, written: None });
    }

    /// Says what went wrong.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: true, is_overlap: false, written: None });
    }

    /// Closes what was said to be wrong.
    fn forget_error(&mut self) {
        if self.message.as_ref().is_some_and(|message| message.is_error) {
            self.message = None;
        }
    }

    pub fn show_start_page(&mut self) {
        self.keep_thumbnail();
        self.leave_beginning();
        self.start_shown = true;
    }

    /// Goes back to the session from the start page.
    pub fn leave_start_page(&mut self) {
        self.leave_beginning();
        self.start_shown = false;
    }

    /// Asks for a name for the layout on screen.
    pub fn name_layout(&mut self) {
        self.naming = Some(String::new());
    }

    /// Draws that question.
    fn ask_layout_name(&mut self, ctx: &egui::Context) {
        let Some(mut name) = self.naming.take() else { return };
        let (mut kept, mut given_up) = (false, false);
        egui::Modal::new(egui::Id::unique("name of a layout")).show(ctx, |ui| {
            ui.set_width(300.0);
            ui.heading("Keep this layout");
            let field =
                ui.add(egui::TextEdit::singleline(&mut name).hint_text("Its name").desired_width(f32::INFINITY));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("name of the layout"));
            let confirmed = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            field.request_focus();
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                let named = !name.trim().is_empty();
                kept = (ui.add_enabled(named, egui::Button::new("Keep")).clicked() || confirmed) && named;
                given_up = ui.button("Cancel").clicked() || ui.input(|input| input.key_pressed(egui::Key::Escape));
            });
        });
        if kept {
            self.state.keep_layout(name.trim());
            self.set_message(format!("Layout saved as {} (menu Layout)", name.trim()));
        } else if !given_up {
            self.naming = Some(name);
        }
    }

    /// Keeps a picture of the session for the start page once its verdict is there.
    fn follow_verdict(&mut self) {
        if self.snapshot.generation != self.pictured && self.snapshot.verdicts.ready().is_some() {
            self.pictured = self.snapshot.generation;
            self.keep_thumbnail();
        }
    }

    /// Shows a document that was just opened: all of it, with nothing of the one before.
    fn enter(&mut self) {
        self.leave_start_page();
        self.fresh = true;
        self.studies.clear();
        self.chosen_before.clear();
        self.compares = false;
        OPENED.clone_into(&mut self.cause);
        self.look_at_all();
        self.compute();
        self.keep_document();
    }

    /// Looks at the whole of a document, its first window chosen.
    fn look_at_all(&mut self) {
        self.state.selection = Default::default();
        self.state.time = Default::default();
        self.state.window_time = Default::default();
        if let Some(path) = self.document.path.clone() {
            self.state.remember(&path);
        }
        let session = Arc::clone(self.document.history.present());
        if let Some(first) = session.windows.first() {
            crate::panels::choose(&mut self.state, &session, &first.name);
        }
    }

    /// Asks the engine for everything that follows from the session.
    fn compute(&mut self) {
        let session = Arc::clone(self.document.history.present());
        self.requested = Some(Arc::clone(&session));
        self.awaited = self.engine.request(Request {
            session,
            folder: self.document.folder.clone(),
            first: self.state.selection.window.clone(),
            studies: self.studies.clone(),
            cause: self.cause.clone(),
            fresh: std::mem::take(&mut self.fresh),
        });
    }
}

impl eframe::App for Workbench {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.step(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.draw(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.state.session.clone_from(&self.document.path);
        self.state.save(storage);
    }
}

/// Opens the window and runs until it is closed.
pub fn run(session: Option<&Path>) -> Result<(), String> {
    let document = match session {
        Some(path) => Document::open(path)?,
        None => Workbench::nothing_open(),
    };
    // The window takes as long to make as reading the recordings does.
    let opening = Opening::new(document, Arc::new(Cache::new(CACHE_BYTES))).map_err(|error| error.to_string())?;
    let started = Arc::new(AtomicBool::new(false));
    let usual = std::panic::take_hook();
    let quiet = Arc::clone(&started);
    // Before the first frame a panic means a missing display library: it becomes the one line below.
    std::panic::set_hook(Box::new(move |info| {
        if quiet.load(Ordering::Relaxed) {
            usual(info);
        }
    }));
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("doublet")
            .with_app_id("doublet")
            .with_inner_size([1480.0, 920.0])
            .with_min_inner_size([800.0, 500.0]),
        system_font_fallback: false,
        ..Default::default()
    };
    let running = Arc::clone(&started);
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        eframe::run_native(
            "doublet",
            options,
            Box::new(move |cc| {
                running.store(true, Ordering::Relaxed);
                Ok(Box::new(Workbench::open(cc, opening).keeping_work_in(state_folder())))
            }),
        )
    }));
    match outcome {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => {
            let text = error.to_string();
            Err(no_window(
                text.lines().last().and_then(|line| line.rsplit(": ").next()).unwrap_or_default(),
                has_display(),
            ))
        }
        Err(panic) if started.load(Ordering::Relaxed) => std::panic::resume_unwind(panic),
        Err(_) => Err(no_window("a library of the display is missing", has_display())),
    }
}

/// What a window needs at run time, as Debian names it.
const DEBIAN_PACKAGES: &str = "libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 libegl1 libgl1-mesa-dri";

/// Whether the environment names a display.
fn has_display() -> bool {
    ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

/// Why there is no window and what to do, in one line.
fn no_window(cause: &str, has_display: bool) -> String {
    let missing = if has_display {
        format!("no window could be opened ({cause}): on Debian run `apt-get install {DEBIAN_PACKAGES}`")
    } else {
        format!("doublet needs a display: DISPLAY and WAYLAND_DISPLAY are not set ({cause})")
    };
    format!("{missing}; without a window use `doublet run SESSION --out DIR`")
}
