//! Unsaved work of a program that ended is offered, and a session open elsewhere is said to be.

use std::path::{Path, PathBuf};

use doublet::app::{Document, Workbench};
use doublet::command::{FileCommand, UiCommand};
use doublet_engine::session::{self, Edit};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::{builder, click, picture};

struct Desk {
    _folder: tempfile::TempDir,
    session: PathBuf,
    autosaves: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let desk = Self { session: root.join("flight.toml"), autosaves: root.join("autosave"), _folder: folder };
        let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
        session.title = "as saved".to_owned();
        session::save(&session, &desk.session).unwrap();
        desk
    }

    /// A program that ended with unsaved work.
    fn crash(&self, title: &str) {
        let mut document = Document::open(&self.session).unwrap();
        document.keep_in(&self.autosaves).unwrap();
        document.history.apply(&Edit::Title(title.to_owned())).unwrap();
        document.autosave_now().unwrap();
    }

    fn workbench<'a>(&self, path: Option<&Path>) -> Harness<'a, Workbench> {
        let (path, autosaves) = (path.map(Path::to_path_buf), self.autosaves.clone());
        let mut harness = builder(1280.0, 800.0).build_eframe(move |cc| {
            let document = path.as_deref().map_or_else(Document::open_demo, Document::open).expect("the session opens");
            Workbench::new(cc, document).expect("a thread starts").keeping_work_in(autosaves)
        });
        harness.run_steps(3);
        harness
    }

    fn kept(&self) -> usize {
        std::fs::read_dir(&self.autosaves).unwrap().filter(|e| !hidden(&e.as_ref().unwrap().path())).count()
    }
}

fn hidden(path: &Path) -> bool {
    path.file_name().unwrap().to_string_lossy().starts_with('.')
}

#[test]
fn unsaved_work_is_offered_at_the_start_and_recovered() {
    let desk = Desk::new();
    desk.crash("afternoon of marking");
    let mut harness = desk.workbench(None);
    assert!(harness.state().is_offering_work());
    click(&mut harness, "Show what differs", 3);
    assert!(harness.query_by_label_contains("afternoon of marking").is_some(), "the new title is shown");
    assert!(harness.query_all_by_label_contains("as saved").count() > 0, "beside the old one");
    picture(&mut harness, "recovery");
    click(&mut harness, "Recover", 3);
    let document = &harness.state().document;
    assert_eq!(document.session().title, "afternoon of marking");
    assert_eq!(document.path.as_deref(), Some(desk.session.as_path()));
    assert!(document.history.is_modified() && !harness.state().is_offering_work());
    harness.state_mut().undo();
    assert_eq!(harness.state().document.session().title, "as saved");
    harness.state_mut().redo();
    harness.state_mut().request(UiCommand::File(FileCommand::Save));
    harness.run_steps(3);
    assert_eq!(session::open(&desk.session).unwrap().session.title, "afternoon of marking");
    drop(harness);
    assert_eq!(desk.kept(), 0, "nothing is left to recover");
}

#[test]
fn unsaved_work_is_discarded_or_left_as_the_user_says() {
    let desk = Desk::new();
    desk.crash("left");
    let mut harness = desk.workbench(None);
    click(&mut harness, "Ask again at the next start", 3);
    assert!(!harness.state().is_offering_work());
    assert_eq!(desk.kept(), 1);
    drop(harness);
    let mut harness = desk.workbench(None);
    click(&mut harness, "Discard", 3);
    assert!(!harness.state().is_offering_work());
    assert_eq!(desk.kept(), 0);
    assert_eq!(session::open(&desk.session).unwrap().session.title, "as saved");
}

#[test]
fn edits_in_the_window_are_kept_aside_and_given_up_with_the_session() {
    let desk = Desk::new();
    let mut harness = desk.workbench(Some(&desk.session));
    assert!(!harness.state().is_offering_work());
    harness.state_mut().apply(&Edit::Title("typed".to_owned()));
    harness.run_steps(1);
    harness.state_mut().document.autosave_now().unwrap();
    assert_eq!(desk.kept(), 1);
    harness.state_mut().request(UiCommand::File(FileCommand::OpenShipped));
    harness.run_steps(3);
    assert!(harness.state().is_guarding(), "changes would be lost");
    click(&mut harness, "Discard", 3);
    assert_eq!(desk.kept(), 0);
    assert_eq!(harness.state().document.path, None);
}

#[test]
fn a_session_open_elsewhere_is_said_to_be_and_not_overwritten() {
    let desk = Desk::new();
    let first = desk.workbench(Some(&desk.session));
    let mut second = desk.workbench(Some(&desk.session));
    assert!(first.state().document.held_by().is_none());
    let message = second.state().message.clone().expect("it says so").text;
    assert!(
        message.contains("flight.toml is open in another doublet") && message.contains("another name"),
        "{message}"
    );
    picture(&mut second, "open_elsewhere");
    second.state_mut().apply(&Edit::Title("second".to_owned()));
    second.state_mut().files = doublet::app::files::Files::without_system();
    second.state_mut().request(UiCommand::File(FileCommand::Save));
    second.run_steps(3);
    assert!(second.state().files.is_asking(), "for another name");
    assert_eq!(session::open(&desk.session).unwrap().session.title, "as saved");
}

#[test]
fn a_session_changed_on_disk_is_asked_about_and_theirs_can_be_taken() {
    let desk = Desk::new();
    let mut harness = desk.workbench(Some(&desk.session));
    harness.state_mut().apply(&Edit::Title("mine".to_owned()));
    let text = std::fs::read_to_string(&desk.session).unwrap();
    std::fs::write(&desk.session, text.replace("as saved", "by an editor")).unwrap();
    harness.state_mut().request(UiCommand::File(FileCommand::Save));
    harness.run_steps(3);
    assert!(harness.state().is_asking_about_change());
    click(&mut harness, "Show", 3);
    harness.get_by_label("title: mine here, by an editor on disk");
    picture(&mut harness, "changed_on_disk");
    click(&mut harness, "Take theirs", 3);
    assert!(!harness.state().is_asking_about_change());
    assert_eq!(harness.state().document.session().title, "by an editor");
    assert_eq!(session::open(&desk.session).unwrap().session.title, "by an editor");
}

#[test]
fn a_window_that_is_come_back_to_asks_about_a_session_changed_on_disk() {
    let desk = Desk::new();
    let mut harness = desk.workbench(Some(&desk.session));
    let come_back = |harness: &mut Harness<'_, Workbench>| {
        harness.event(egui::Event::WindowFocused(false));
        harness.run_steps(2);
        harness.event(egui::Event::WindowFocused(true));
        harness.run_steps(3);
    };
    come_back(&mut harness);
    assert!(!harness.state().is_asking_about_change(), "nothing has changed");
    let text = std::fs::read_to_string(&desk.session).unwrap();
    std::fs::write(&desk.session, text.replace("as saved", "by an editor")).unwrap();
    come_back(&mut harness);
    assert!(harness.state().is_asking_about_change());
    click(&mut harness, "Stay", 3);
    come_back(&mut harness);
    assert!(!harness.state().is_asking_about_change(), "that version was answered");
    std::fs::write(&desk.session, text.replace("as saved", "again by an editor")).unwrap();
    come_back(&mut harness);
    click(&mut harness, "Show", 3);
    harness.get_by_label("title: as saved here, again by an editor on disk");
    click(&mut harness, "Take theirs", 3);
    assert_eq!(harness.state().document.session().title, "again by an editor");
    come_back(&mut harness);
    assert!(!harness.state().is_asking_about_change(), "theirs is what is open");
}

#[test]
fn a_window_that_cannot_keep_work_says_so_until_it_can() {
    let desk = Desk::new();
    std::fs::write(&desk.autosaves, "in the way").unwrap();
    let mut harness = desk.workbench(Some(&desk.session));
    for title in ["one", "two"] {
        harness.get_by_label_contains("Autosave failed");
        harness.state_mut().apply(&Edit::Title(title.to_owned()));
        harness.run_steps(3);
    }
    harness.get_by_label_contains("Autosave failed");
    std::fs::remove_file(&desk.autosaves).unwrap();
    std::thread::sleep(std::time::Duration::from_secs(3));
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Autosave failed").is_none());
}
