//! The application: owns the state; `logic` changes it, `draw` shows it.

mod draw;
pub mod files;
mod logic;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui;

use crate::command::{CommandInfo, CommandPalette, UiCommand, ui_command};
use crate::panels::{Pane, Panel};
use crate::theme;
use crate::ui_state::UiState;

/// The workbench.
pub struct Workbench {
    /// Layout, zoom, theme.
    pub state: UiState,
    /// Finds commands by name.
    pub palette: CommandPalette,
    panels: BTreeMap<Pane, Box<dyn Panel>>,
    table: Vec<CommandInfo>,
    commands: Vec<UiCommand>,
}

impl Workbench {
    /// Sets fonts and themes up and takes the stored layout.
    pub fn new(cc: &eframe::CreationContext<'_>) -> Self {
        theme::install(&cc.egui_ctx);
        let state = UiState::load(cc.storage);
        cc.egui_ctx.set_theme(state.appearance);
        Self {
            state,
            palette: CommandPalette::default(),
            panels: Pane::ALL.iter().map(|&pane| (pane, pane.build())).collect(),
            table: ui_command::table(),
            commands: Vec::new(),
        }
    }

    /// Asks for `command` before the next frame.
    pub fn request(&mut self, command: UiCommand) {
        self.commands.push(command);
    }
}

impl eframe::App for Workbench {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        logic::run(self, ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        draw::draw(self, ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.state.save(storage);
    }
}

/// Opens the window and runs until it is closed.
///
/// # Errors
/// One line that says why no window can be opened and what to do without one.
pub fn run(_session: Option<PathBuf>) -> Result<(), String> {
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
                Ok(Box::new(Workbench::new(cc)))
            }),
        )
    }));
    let advice = "doublet needs a display for its window; without one use `doublet run SESSION --out DIR`";
    match outcome {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => {
            let text = error.to_string();
            Err(format!(
                "{advice} ({})",
                text.lines().last().and_then(|line| line.rsplit(": ").next()).unwrap_or_default()
            ))
        }
        Err(panic) if started.load(Ordering::Relaxed) => std::panic::resume_unwind(panic),
        Err(_) => Err(format!("{advice} (a library of the display is missing, often libxkbcommon-x11)")),
    }
}
