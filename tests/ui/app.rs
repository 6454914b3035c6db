//! The application around the panels: commands, palette, layout, file dialog.

use std::path::PathBuf;

use doublet::app::files::{FileQuestion, Files, Purpose};
use doublet::app::{Document, Workbench};
use doublet::command::{HelpCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use egui::{Key, Modifiers, ThemePreference};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::workbench::Bench;
use crate::{builder, click, overview, picture, widget_harness};

fn workbench<'a>() -> Harness<'a, Workbench> {
    let mut harness = builder(1280.0, 800.0).build_eframe(|cc| {
        overview(Workbench::new(cc, Document::open_demo().expect("a session is shipped")).expect("a thread starts"))
    });
    harness.run_steps(3);
    harness
}

#[test]
fn the_palette_finds_a_command_by_part_of_its_name() {
    let mut harness = workbench();
    assert_eq!(harness.state().state.appearance, ThemePreference::Dark);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::P);
    harness.run_steps(3);
    harness.get_by_label("Command").type_text("theme light");
    harness.run_steps(2);
    picture(&mut harness, "palette");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().state.appearance, ThemePreference::Light);
    assert!(!harness.state().palette.is_open());
    picture(&mut harness, "workbench_light");
}

#[test]
fn a_closed_panel_comes_back_by_its_command() {
    let mut harness = workbench();
    let held = |harness: &Harness<'_, Workbench>| harness.state().state.shown.tree.tiles.find_pane(&Pane::Shortcuts);
    let tile = held(&harness).unwrap();
    harness.state_mut().state.shown.tree.remove_recursively(tile);
    harness.run_steps(2);
    assert_eq!(held(&harness), None);
    harness.state_mut().request(UiCommand::View(ViewCommand::Show(Pane::Shortcuts)));
    harness.run_steps(3);
    assert!(held(&harness).is_some());
    assert!(harness.query_by_label("Time plots").is_some(), "its page is drawn");
}

#[test]
fn the_menu_carries_out_what_it_says() {
    let mut harness = workbench();
    harness.get_by_role_and_label(egui::accesskit::Role::Button, "View").click();
    harness.run_steps(3);
    picture(&mut harness, "menu");
    harness.get_by_role_and_label(egui::accesskit::Role::Button, "Light theme").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.appearance, ThemePreference::Light);
}

/// The program's own dialog for files, and what was chosen in it.
fn asking(question: FileQuestion) -> Harness<'static, (Files, Option<Vec<PathBuf>>)> {
    let state = (Files::without_system(), None);
    let mut harness = widget_harness((800.0, 600.0), true, state, move |ui, (files, chosen)| {
        if chosen.is_none() && !files.is_asking() {
            files.ask(question.clone(), ui.ctx());
        }
        if let Some(paths) = files.show(ui.ctx()) {
            *chosen = Some(paths);
        }
    });
    harness.run_steps(4);
    harness
}

#[test]
fn our_own_file_dialog_walks_folders_and_refuses_what_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("flights");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(inner.join("first.toml"), "").unwrap();
    let question = FileQuestion {
        title: "Open a session".to_owned(),
        purpose: Purpose::Open,
        extensions: vec!["toml".to_owned()],
        folder: folder.path().to_path_buf(),
        name: String::new(),
        places: vec![folder.path().to_path_buf()],
    };
    let mut harness = asking(question);
    click(&mut harness, "File name", 2);
    harness.get_by_label("File name").type_text("nowhere.toml");
    harness.run_steps(2);
    click(&mut harness, "Open", 3);
    assert!(harness.query_by_label_contains("does not exist").is_some());
    assert_eq!(harness.state().1, None);
    click(&mut harness, "flights/", 3);
    click(&mut harness, "first.toml", 3);
    picture(&mut harness, "file_dialog");
    click(&mut harness, "Open", 3);
    let chosen = harness.state().1.clone().expect("a file was chosen").remove(0);
    assert_eq!(chosen.canonicalize().unwrap(), inner.join("first.toml").canonicalize().unwrap());
}

#[test]
fn several_recordings_of_one_flight_are_taken_together_and_other_files_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "b.csv", "c.pid"] {
        std::fs::write(folder.path().join(name), "12345").unwrap();
    }
    let question = FileQuestion {
        title: "A recording".to_owned(),
        purpose: Purpose::Several,
        extensions: vec!["csv".to_owned()],
        folder: folder.path().to_path_buf(),
        name: String::new(),
        places: Vec::new(),
    };
    let mut harness = asking(question);
    assert!(harness.query_by_label("c.pid").is_none());
    assert_eq!(harness.query_all_by_label("5 B").count(), 2, "sizes stand beside the names");
    click(&mut harness, "all files", 3);
    assert!(harness.query_by_label("c.pid").is_some());
    click(&mut harness, "a.csv", 2);
    harness.get_by_label("b.csv").click_modifiers(egui::Modifiers::COMMAND);
    harness.run_steps(2);
    picture(&mut harness, "file_dialog_several");
    click(&mut harness, "Open", 3);
    let names = harness.state().1.clone().expect("files were chosen");
    let names: Vec<_> = names.iter().filter_map(|path| path.file_name()?.to_str()).collect();
    assert_eq!(names, ["a.csv", "b.csv"]);
}

#[test]
fn text_is_made_larger_from_the_menu_and_the_version_is_told() {
    let mut bench = Bench::open();
    let before = bench.harness.ctx.zoom_factor();
    bench.request(UiCommand::View(ViewCommand::Larger));
    assert!((bench.harness.ctx.zoom_factor() - before - 0.1).abs() < 1e-3);
    bench.request(UiCommand::View(ViewCommand::Smaller));
    assert!((bench.harness.ctx.zoom_factor() - before).abs() < 1e-3);
    bench.request(UiCommand::Help(HelpCommand::About));
    assert!(bench.harness.query_by_label_contains(doublet_cli::version()).is_some());
}

#[test]
fn without_a_display_one_line_names_the_command_that_needs_none() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_doublet"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("display") && message.contains("doublet run"), "{message}");
}

#[test]
fn tab_goes_through_the_main_frame_from_the_top_and_stops_nowhere_twice() {
    let mut bench = Bench::open();
    let focused = |bench: &Bench<'_>| {
        let root = bench.harness.root();
        let mut all = vec![root];
        let mut found = None;
        while let Some(node) = all.pop() {
            if node.accesskit_node().is_focused() {
                let node_of = node.accesskit_node();
                found = Some((node_of.label().or(node_of.value()).unwrap_or_default(), node.rect()));
            }
            all.extend(node.children());
        }
        found
    };
    let mut stops: Vec<(String, egui::Rect)> = Vec::new();
    for _ in 0..40 {
        bench.harness.key_press(egui::Key::Tab);
        bench.harness.run_steps(2);
        stops.extend(focused(&bench));
    }
    assert!(stops.len() >= 38, "{}", stops.len());
    // The bar of tabs itself has none; its first tab, where it begins, is the next stop.
    let named = |pair: &[(String, egui::Rect)]| !pair[0].0.is_empty() || pair[0].1.min == pair[1].1.min;
    assert!(stops.windows(2).all(named), "{stops:?}");
    let mut seen = std::collections::BTreeSet::new();
    let again: Vec<_> =
        stops.iter().filter(|(name, rect)| !seen.insert(format!("{name} {:?}", rect.center()))).collect();
    assert!(again.is_empty(), "{again:?}");
    // The menus come first, from left to right; the bar of steps before the panels.
    let first: Vec<f32> = stops.iter().take(4).map(|(_, rect)| rect.left()).collect();
    assert!(first.is_sorted(), "{stops:?}");
    assert!(stops[0].1.top() < 40.0, "{stops:?}");
}
