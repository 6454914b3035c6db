//! Candidates that are refused: an edit like any other, and none of what is accepted; the menus of candidates and of manoeuvres.

use doublet::app::Document;
use doublet::command::{EditCommand, FileCommand, MarkCommand, UiCommand};
use doublet::panels::Pane;
use doublet_core::series::TimeRange;
use doublet_engine::session::{self, Edit, Manoeuvre, WindowEdit};
use egui::vec2;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::manoeuvres::bench;
use crate::workbench::Bench;
use crate::{picture, secondary_click};

/// A time inside the doublet that is found but not in the session, s.
const IN_DOUBLET_S: f64 = 45.0;

/// What was found and the session lacks.
fn found(bench: &Bench<'_>) -> Vec<Manoeuvre> {
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let missing = found.into_iter().filter(|one| one.covering_window(bench.session()).is_none());
    missing.map(|one| one.manoeuvre).collect()
}

fn undo_label<'b>(bench: &'b Bench<'_>) -> Option<&'b str> {
    bench.harness.state().document.history.undo_label()
}

#[test]
fn a_refused_candidate_is_not_accepted_with_all_is_saved_and_comes_back_by_undo() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    let open = found(&bench);
    bench.request(UiCommand::Mark(MarkCommand::Refuse));
    assert_eq!(undo_label(&bench), Some(format!("refuse candidate {}", open[0].name).as_str()));
    let refused = bench.session().clone();
    assert_eq!(refused.refused.len(), 1);
    let left = open.len() - 1;
    let header = format!("not in the session: {left}, refused: 1");
    bench.choose_containing(&header);
    assert!(bench.harness.query_by_label("1 refused").is_some());
    assert!(bench.harness.query_by_label(&format!("accept {}", open[0].name)).is_none(), "it is not in the list");
    picture(&mut bench.harness, "refused");
    if left > 0 {
        bench.click(&format!("Accept all {left}"));
    }
    assert_eq!(bench.session().windows.len(), 1 + left);
    assert!(bench.session().windows.iter().all(|window| !refused.has_refused(window)), "none of them was refused");
    // What is saved opens with it, and another session does not have it.
    bench.request(UiCommand::File(FileCommand::Save));
    let path = bench.harness.state().document.path.clone().expect("it has a file");
    assert_eq!(session::open(&path).expect("it opens").session.refused, refused.refused);
    assert!(Document::open_demo().expect("a session is shipped").session().refused.is_empty());
    (0..=left.min(1)).for_each(|_| bench.request(UiCommand::Edit(EditCommand::Undo)));
    assert!(bench.session().refused.is_empty() && bench.session().windows.len() == 1);
    assert!(bench.harness.query_by_label("1 refused").is_none());
    bench.request(UiCommand::Edit(EditCommand::Redo));
    assert_eq!(bench.session(), &refused);
    bench.click("Offer again");
    assert!(bench.session().refused.is_empty());
    assert_eq!(found(&bench).len(), open.len());
}

#[test]
fn the_map_refuses_in_one_step_of_undo() {
    let mut bench = bench();
    bench.show(Pane::ManoeuvreMap);
    // The status line names the candidate too, but not at its beginning.
    let marks = |bench: &Bench<'_>| {
        let all = bench.harness.query_all_by_label_contains("candidate ");
        let marks = all.filter(|node| node.accesskit_node().label().is_some_and(|text| text.starts_with("candidate ")));
        marks.map(|mark| mark.rect().center()).collect::<Vec<_>>()
    };
    let candidate = marks(&bench);
    secondary_click(&mut bench.harness, candidate[0]);
    bench.press("Refuse");
    assert_eq!(bench.session().refused.len(), 1);
    assert_eq!(marks(&bench).len() + 1, candidate.len(), "its mark is gone");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(bench.session().refused.is_empty());
    assert_eq!(marks(&bench), candidate);
}

#[test]
fn the_menu_of_a_plot_accepts_or_refuses_the_candidate_under_the_pointer() {
    let mut bench = bench();
    let at = bench.at_s(IN_DOUBLET_S) + vec2(0.0, 70.0);
    secondary_click(&mut bench.harness, at);
    picture(&mut bench.harness, "candidate_menu");
    bench.choose_containing("Refuse candidate");
    let refused = bench.session().refused.clone();
    assert!(refused[0].start_s <= IN_DOUBLET_S && IN_DOUBLET_S <= refused[0].end_s, "{refused:?}");
    secondary_click(&mut bench.harness, at);
    assert!(bench.harness.query_by_label_contains("Accept candidate").is_none(), "there is none any more");
    bench.harness.key_press(egui::Key::Escape);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    secondary_click(&mut bench.harness, at);
    bench.choose_containing("Accept candidate");
    assert!(bench.session().windows[1].window.contains(IN_DOUBLET_S));
}

#[test]
fn rows_and_pictures_of_manoeuvres_have_the_menu_of_the_list() {
    let mut bench = bench();
    for (pane, row) in [(Pane::Summary, "Flight path, first:"), (Pane::Gallery, "picture first:")] {
        bench.show(pane);
        let at = bench.harness.get_by_label_contains(row).rect().center();
        secondary_click(&mut bench.harness, at);
        for entry in ["Use", "Surface", "Zoom to manoeuvre", "Open in", "Rename manoeuvre"] {
            assert!(bench.harness.query_all_by_label_contains(entry).next().is_some(), "{pane:?}: {entry}");
        }
        picture(&mut bench.harness, &format!("manoeuvre_menu_{pane:?}"));
        bench.choose_containing("Remove manoeuvre");
        assert!(bench.session().windows.is_empty(), "{pane:?}");
        bench.request(UiCommand::Edit(EditCommand::Undo));
        assert_eq!(bench.session().windows.len(), 1);
    }
}

#[test]
fn the_shortcuts_name_the_way_to_exclude_without_alt() {
    let mut bench = bench();
    bench.show(Pane::Shortcuts);
    assert!(bench.harness.query_by_label("A, B, then E").is_some());
    bench.request(UiCommand::Mark(MarkCommand::Exclude));
    let text = bench.harness.state().message.as_ref().expect("it is said").text.clone();
    assert!(text.contains("keys A and B") && text.contains("press E"), "{text}");
}

#[test]
fn a_manoeuvre_added_later_stands_where_it_was_flown_and_is_stepped_to_in_that_order() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    let first = bench.first();
    let early = TimeRange { start_s: 0.25 * first.start_s, end_s: 0.75 * first.start_s };
    let early = Manoeuvre::new("early".to_owned(), "flight".to_owned(), early);
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Add(early)));
    bench.settle();
    let names: Vec<&str> = bench.session().windows.iter().map(|window| window.name.as_str()).collect();
    assert_eq!(names, ["first", "early"], "the session has them as they were added");
    let [early, first] = ["early", "first"].map(|name| bench.harness.get_by_label(&format!("name of {name}")).rect());
    assert!(early.bottom() <= first.top(), "{early:?} {first:?}");
    bench.choose("name of early");
    bench.request(UiCommand::Edit(EditCommand::NextWindow));
    assert_eq!(bench.harness.state().state.selection.window.as_deref(), Some("first"));
}
