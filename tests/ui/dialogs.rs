//! Every dialog and every window over the panels, with long contents, on the smallest screens: nothing is cut at a side, the whole of it is on
//! screen, and what is to be pressed can be reached.

use doublet::app::help::Topic;
use doublet::app::{Asked, Pending};
use doublet::command::{EditCommand, FileCommand, HelpCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::series::TimeRange;
use doublet_engine::session::{Annotation, Edit, WindowEdit};
use doublet_engine::trace::TraceView;
use egui::{Key, Rect, vec2};
use egui_kittest::kittest::NodeT;

use crate::painted::{faults_from, texts_of};
use crate::picture;
use crate::workbench::Bench;

/// The smallest laptop, and the same at one and a half times the size of text, points.
const SIZES: [[f32; 2]; 2] = [[1280.0, 720.0], [854.0, 500.0]];
/// A name as people give them.
const LONG: &str =
    "Elevator 3-2-1-1 at flight level 95, flaps 15 degrees, gear down, second attempt after the gust, pilot B";

/// A dialog: its name, a text that it begins with, and what opens it.
type Dialog = (&'static str, &'static str, fn(&mut Bench<'_>));

fn ask(bench: &mut Bench<'_>, asked: Asked) {
    let ctx = bench.harness.ctx.clone();
    bench.harness.state_mut().ask(asked, &ctx);
}

const DIALOGS: [Dialog; 15] = [
    ("open", "Open a session", |bench| ask(bench, Asked::Open)),
    ("save", "Save the session", |bench| ask(bench, Asked::Save(None))),
    ("second", "Open a second session", |bench| ask(bench, Asked::OpenBeside)),
    ("layout", "Keep this layout", |bench| bench.request(UiCommand::View(ViewCommand::KeepLayout))),
    ("note", "Note on", |bench| {
        bench.harness.state_mut().state.noting = Some((LONG.to_owned(), LONG.repeat(4)));
    }),
    ("annotation", "At 12.5", |bench| {
        let annotation = Annotation { flight: "flight".to_owned(), time_s: 12.5, text: LONG.repeat(3) };
        bench.harness.state_mut().state.annotating = Some((annotation, None));
    }),
    ("unsaved", "Save the changes", |bench| {
        let ctx = bench.harness.ctx.clone();
        bench.harness.state_mut().leave(Pending::Quit, &ctx);
    }),
    ("palette", "", |bench| {
        bench.request(UiCommand::Help(HelpCommand::Palette));
        bench.harness.event(egui::Event::Text("man".to_owned()));
    }),
    ("history", "History", |bench| bench.request(UiCommand::Edit(EditCommand::History))),
    ("manual", "", |bench| bench.harness.state_mut().help.open(Topic::Contents)),
    ("page", "", |bench| bench.harness.state_mut().help.open(Topic::Page("noise".to_owned(), None))),
    ("glossary", "", |bench| bench.request(UiCommand::Help(HelpCommand::Glossary))),
    ("about", "", |bench| bench.request(UiCommand::Help(HelpCommand::About))),
    ("error", "", |bench| bench.harness.state_mut().complain(format!("{LONG}: {}", LONG.repeat(3)))),
    ("spectrum", "Spectrum of", |bench| {
        let loaded = bench.snapshot().flights["flight"].ready().expect("it is read").clone();
        let series = loaded.recording.channels[0].series.clone();
        let range = TimeRange { start_s: 5.0, end_s: 25.0 };
        let (name, unit) = (LONG.to_owned(), "m/s²".to_owned());
        let request = doublet::ui_state::TraceRequest {
            name,
            unit,
            scale: 1.0,
            series,
            range,
            view: TraceView::Spectrum,
            over: None,
        };
        bench.harness.state_mut().state.analysis = Some(request);
    }),
];

/// The small flight under long names, with files of long names beside it, and something to save.
fn long_named<'a>() -> Bench<'a> {
    let mut bench = Bench::open_changed(|folder| {
        for number in 0..30 {
            let name = format!("{} {number}.toml", LONG.replace([',', ' '], "_"));
            std::fs::write(folder.join(name), "").expect("there is room");
        }
    });
    let rename = WindowEdit::Rename { from: "first".to_owned(), to: LONG.to_owned() };
    for edit in [Edit::Title(LONG.to_owned()), Edit::Window(rename)] {
        bench.harness.state_mut().apply(&edit);
    }
    bench.settle();
    bench
}

fn close(bench: &mut Bench<'_>) {
    for _ in 0..3 {
        bench.harness.key_press(Key::Escape);
        bench.harness.run_steps(3);
    }
    let state = bench.harness.state_mut();
    (state.message, state.state.noting, state.state.annotating) = (None, None, None);
    state.help.close();
    bench.settle();
}

#[test]
#[ignore = "opens thirty dialogs: run alone"]
fn no_text_is_cut_in_any_dialog_with_long_contents() {
    let mut all = Vec::new();
    for [width, height] in SIZES {
        let mut bench = long_named();
        bench.show(Pane::Flight);
        bench.harness.set_size(vec2(width, height));
        bench.harness.run_steps(4);
        let before = faults_from(&bench, "");
        for (name, first, open) in DIALOGS {
            open(&mut bench);
            for _ in 0..8 {
                std::thread::sleep(std::time::Duration::from_millis(10));
                bench.harness.step();
            }
            let name = format!("dialog_{name}_{width}");
            // Drawing takes longer than all else, and nothing of it is looked at here.
            if std::env::var_os(crate::PICTURES).is_some() {
                picture(&mut bench.harness, &name);
            }
            if !first.is_empty() && !texts_of(&bench).any(|text| text.starts_with(first)) {
                all.push(format!("{name}: it does not open"));
            }
            // A dialog may move what is cut behind it.
            let words = |fault: &String| fault.split(" at [").next().unwrap_or_default().to_owned();
            let is_new = |fault: &String| !before.iter().any(|known| words(known) == words(fault));
            let found = faults_from(&bench, first).into_iter().filter(is_new);
            all.extend(found.map(|fault| format!("{name}: {fault}")));
            let screen = Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height));
            let out = bench.harness.root().children_recursive().filter(|node| {
                let node = node.accesskit_node();
                node.role() == egui::accesskit::Role::Window
            });
            all.extend(
                out.filter(|node| !screen.expand(2.0).contains_rect(node.rect()))
                    .map(|node| format!("{name}: a window reaches beyond the screen, {:?}", node.rect())),
            );
            if name.starts_with("dialog_history") {
                bench.request(UiCommand::Edit(EditCommand::History));
            }
            close(&mut bench);
        }
        bench.request(UiCommand::File(FileCommand::CloseBeside));
    }
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}
