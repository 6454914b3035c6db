//! The workbench as a user meets it: clicked, typed and dragged without a display, drawn on the processor.

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests fail the test that calls them"
)]

mod aircraft;
mod allocations;
mod app;
mod begin;
mod candidates;
mod compare;
mod details;
mod dialogs;
mod excluded;
mod faults;
mod figures;
mod gestures;
mod help;
mod identified;
mod live;
mod manoeuvre_map;
mod manoeuvres;
mod marking;
mod misfit;
mod must_show;
mod painted;
mod panels;
mod plots;
mod preprocess;
mod propulsion;
mod public;
mod rasteriser;
mod recorders;
mod recording;
mod recovery;
mod replay;
mod report_pages;
mod second;
mod sensors;
mod soak;
mod speed;
mod steps;
mod studies;
mod summary;
mod traps;
mod widgets;
mod workbench;

use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, HarnessBuilder};
use image::RgbaImage;
use rasteriser::Rasteriser;

/// Folder for pictures of what the tests see; none are written without it.
const PICTURES: &str = "DOUBLET_UI_PICTURES";

/// Time from frame to frame, s: short enough for two clicks to be a double click.
const FRAME_S: f32 = 0.05;

/// A harness of our renderer with the workbench's fonts and theme.
fn builder<State>(width: f32, height: f32) -> HarnessBuilder<State> {
    Harness::builder().with_size(egui::vec2(width, height)).with_step_dt(FRAME_S).renderer(Rasteriser::default())
}

/// A harness around widgets, with the workbench's fonts and theme.
fn widget_harness<'a, State>(
    size: (f32, f32),
    dark: bool,
    state: State,
    show: impl FnMut(&mut egui::Ui, &mut State) + 'a,
) -> Harness<'a, State> {
    builder(size.0, size.1)
        .with_context_setup(doublet::theme::install)
        .with_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light })
        .build_ui_state(show, state)
}

/// The workbench with flight, plots, settings and results at once.
fn overview(mut app: doublet::app::Workbench) -> doublet::app::Workbench {
    app.state.show_layout(doublet::layouts::LayoutKey::Overview);
    // Without optimisation the typesetter takes longer than all else of a test.
    app.state.report.as_pages = false;
    app
}

/// What is on screen; also written to the folder of [`PICTURES`] where that is set.
fn picture<State>(harness: &mut Harness<'_, State>, name: &str) -> RgbaImage {
    let image = harness.render().expect("the picture is drawn");
    if let Some(folder) = std::env::var_os(PICTURES) {
        let folder = std::path::PathBuf::from(folder);
        std::fs::create_dir_all(&folder).expect("the folder of pictures can be made");
        image.save(folder.join(format!("{name}.png"))).expect("the picture can be written");
    }
    image
}

/// Clicks with the secondary button.
fn secondary_click<State>(harness: &mut Harness<'_, State>, pos: egui::Pos2) {
    harness.hover_at(pos);
    harness.step();
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Secondary, egui::Modifiers::NONE);
        harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
        harness.step();
    }
    harness.run_steps(3);
}

/// Clicks twice, fast enough for a double click.
fn double_click<State>(harness: &mut Harness<'_, State>, pos: egui::Pos2) {
    harness.hover_at(pos);
    harness.step();
    for pressed in [true, false, true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
        harness.step();
    }
    harness.run_steps(3);
}

/// Text put into the clipboard in the last frame.
fn copied<State>(harness: &Harness<'_, State>) -> Option<String> {
    harness.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

/// Clicks the widget called `label` and draws `frames` frames.
fn click<State>(harness: &mut Harness<'_, State>, label: &str, frames: usize) {
    harness.get_by_label(label).click();
    harness.run_steps(frames);
}

/// What "Copy data" in the menu at `pos` puts into the clipboard.
fn copied_data<State>(harness: &mut Harness<'_, State>, pos: egui::Pos2) -> String {
    secondary_click(harness, pos);
    click(harness, "Copy data", 1);
    copied(harness).expect("the data are in the clipboard")
}

/// Presses at `from`, moves to `to` in `steps` frames, and releases there.
fn drag<State>(harness: &mut Harness<'_, State>, from: egui::Pos2, to: egui::Pos2, steps: usize) {
    hold(harness, from, to, steps);
    harness.drop_at(to);
    harness.run_steps(2);
}

/// Drags with the secondary button, in eight frames.
fn secondary_drag<State>(harness: &mut Harness<'_, State>, from: egui::Pos2, to: egui::Pos2) {
    let button = |pos, pressed| {
        let (button, modifiers) = (egui::PointerButton::Secondary, egui::Modifiers::NONE);
        egui::Event::PointerButton { pos, button, pressed, modifiers }
    };
    harness.hover_at(from);
    harness.step();
    harness.event(button(from, true));
    harness.step();
    for step in 1..=8 {
        harness.hover_at(from + (to - from) * (step as f32 / 8.0));
        harness.step();
    }
    harness.event(button(to, false));
    harness.run_steps(2);
}

/// Presses at `from` and moves to `to` in `steps` frames without a release.
fn hold<State>(harness: &mut Harness<'_, State>, from: egui::Pos2, to: egui::Pos2, steps: usize) {
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for step in 1..=steps {
        harness.hover_at(from + (to - from) * (step as f32 / steps as f32));
        harness.step();
    }
}
