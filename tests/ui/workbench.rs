//! The workbench on a session: opened, changed, undone, saved and opened again, with the numbers that must result.

use std::path::Path;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use doublet::app::files::Files;
use doublet::app::{Document, Workbench};
use doublet::command::{EditCommand, FileCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::estimate::Fit;
use doublet_core::model::Coefficient;
use doublet_core::reconstruct::{Input, State};
use doublet_core::series::TimeRange;
use doublet_engine::graph::Cache;
use doublet_engine::report::document::SectionKind;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, Place, WindowRole};
use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use tempfile::TempDir;

use crate::recording::{self, CM, STEP_S};
use crate::{builder, click, double_click, drag, overview, picture};

/// Longest wait for results.
const PATIENCE: Duration = Duration::from_secs(240);
/// Largest error of an estimate against the truth, relative: the recording is rounded to nine digits, the filter smooths
/// the angle of attack over its noise.
const TRUTH_TOLERANCE: f64 = 0.02;

/// Rounding of a sum of masses, kg.
const MASS_TOLERANCE_KG: f64 = 1e-6;

/// What the tests of the shipped flight computed: each begins with it.
static SHIPPED: LazyLock<Arc<Cache>> = LazyLock::new(|| Arc::new(Cache::new(1 << 30)));

/// The workbench on a flight in a folder of its own.
pub struct Bench<'a> {
    pub harness: Harness<'a, Workbench>,
    pub folder: TempDir,
}

impl Bench<'_> {
    pub fn open() -> Self {
        Self::open_changed(|_| {})
    }

    /// Opens the small flight after `change` did something to its folder.
    pub fn open_changed(change: impl FnOnce(&Path)) -> Self {
        let folder = tempfile::tempdir().expect("there is room for a folder");
        let path = recording::write(folder.path());
        change(folder.path());
        let mut harness = builder(1500.0, 950.0).build_eframe(move |cc| {
            let document = Document::open(&path).expect("the session opens");
            let mut app = overview(Workbench::new(cc, document).expect("a thread starts"));
            app.files = Files::without_system();
            app
        });
        harness.run_steps(2);
        let mut bench = Self { harness, folder };
        bench.settle();
        bench
    }

    /// Draws frames until everything is computed.
    pub fn settle(&mut self) {
        let started = Instant::now();
        self.harness.run_steps(2);
        while self.harness.state().is_busy() || self.harness.state().is_looking() || self.harness.state().is_exporting()
        {
            assert!(started.elapsed() < PATIENCE, "results come in time");
            std::thread::sleep(Duration::from_millis(5));
            self.harness.step();
        }
        self.harness.run_steps(2);
    }

    pub fn request(&mut self, command: UiCommand) {
        self.harness.state_mut().request(command);
        self.settle();
    }

    pub fn show(&mut self, pane: Pane) {
        self.request(UiCommand::View(ViewCommand::Show(pane)));
    }

    pub fn snapshot(&self) -> &Snapshot {
        self.harness.state().snapshot()
    }

    /// The estimate of Cm over all windows.
    pub fn cm(&self) -> Fit {
        assert_eq!(self.snapshot().failures(), [], "nothing fails");
        let pooled = self.snapshot().pooled.ready().expect("the estimate is up to date");
        let fit = pooled.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).expect("Cm is modelled");
        fit.fit.clone().expect("Cm is estimated")
    }

    /// The shipped flight, computed.
    pub fn shipped() -> Self {
        Self::shipped_in(1500.0, 950.0)
    }

    /// The shipped flight in a window of this size.
    pub fn shipped_in(width: f32, height: f32) -> Self {
        let mut harness = builder(width, height).build_eframe(|cc| {
            let document = Document::open_demo().expect("a session is shipped");
            let app = Workbench::with_cache(cc, document, Arc::clone(&SHIPPED)).expect("a thread starts");
            let mut app = overview(app);
            app.files = Files::without_system();
            app
        });
        harness.run_steps(2);
        let mut bench = Self { harness, folder: tempfile::tempdir().expect("there is room for a folder") };
        bench.settle();
        bench
    }

    pub fn session(&self) -> &session::Session {
        self.harness.state().document.session()
    }

    /// Brings a widget into view and clicks it.
    pub fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).scroll_to_me();
        self.harness.run_steps(3);
        self.choose(label);
    }

    /// Everything computed without a window for a changed session.
    pub fn alone(&self, change: impl FnOnce(&mut session::Session)) -> Snapshot {
        let mut session = self.session().clone();
        change(&mut session);
        let (session, folder) = (&session, self.folder.path());
        let scope = Scope { session, folder, first: None, studies: &[], cause: "", generation: 1 };
        run(&scope, &Snapshot::default(), &Cache::new(1 << 20), &Control::default(), &|_| {})
    }

    /// Clicks the widget called `label`.
    pub fn choose(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.settle();
    }

    /// Opens the list called `list` and chooses `entry` of it.
    pub fn choose_of(&mut self, list: &str, entry: &str) {
        self.harness.get_by_role_and_label(egui::accesskit::Role::ComboBox, list).click();
        self.harness.run_steps(3);
        let is_entry = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == egui::accesskit::Role::Button;
        self.harness.get_all_by_label(entry).rfind(is_entry).expect("the list has it").click();
        self.settle();
    }

    /// Clicks the widget whose label contains `part`.
    pub fn choose_containing(&mut self, part: &str) {
        self.harness.get_by_label_contains(part).click();
        self.settle();
    }

    /// Clicks the only button called `label`.
    pub fn push(&mut self, label: &str) {
        self.harness.get_by_role_and_label(egui::accesskit::Role::Button, label).click();
        self.settle();
    }

    /// Clicks the first button called `label` where other widgets have that label too.
    pub fn press(&mut self, label: &str) {
        let is_button = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == egui::accesskit::Role::Button;
        let button = self.harness.get_all_by_label(label).find(is_button);
        button.expect("there is a button of that name").click();
        self.settle();
    }

    /// Double clicks a text that is typed in place, types over it, and ends that by `key`.
    pub fn retype(&mut self, name: &str, text: &str, key: Key) {
        self.harness.get_by_label(name).scroll_to_me();
        self.harness.run_steps(3);
        let at = self.harness.get_by_label(name).rect().center();
        double_click(&mut self.harness, at);
        self.harness.get_by_label(name).type_text(text);
        self.harness.run_steps(1);
        self.harness.key_press(key);
        self.settle();
    }

    /// Types into the field called `name`, over what it holds, and confirms.
    pub fn enter(&mut self, name: &str, text: &str) {
        // A window's edge in the lane, and the text before a field, may bear the same name as the field.
        let field = |harness: &Harness<'_, Workbench>, act: &dyn Fn(&egui_kittest::Node<'_>)| {
            use egui::accesskit::Role;
            let is_field =
                |node: &egui_kittest::Node<'_>| !matches!(node.accesskit_node().role(), Role::Button | Role::Label);
            act(&harness.get_all_by_label(name).find(is_field).expect("there is a field"));
        };
        field(&self.harness, &|node| node.scroll_to_me());
        self.harness.run_steps(3);
        field(&self.harness, &|node| node.click());
        self.harness.run_steps(3);
        self.harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        self.harness.run_steps(1);
        field(&self.harness, &|node| node.type_text(text));
        self.harness.run_steps(1);
        self.harness.key_press(Key::Enter);
        self.settle();
    }
}

#[test]
fn opened_session_shows_the_derivatives_the_flight_was_made_with() {
    let mut bench = Bench::open();
    bench.show(Pane::Derivatives);
    let fit = bench.cm();
    for (name, truth) in ["Cm_alpha", "Cm_q", "Cm_delta_e"].into_iter().zip(&CM[1..]) {
        let (estimate, _) = fit.parameter(name).expect("the term is in the model");
        assert!((estimate / truth - 1.0).abs() < TRUTH_TOLERANCE, "{name} is {estimate}, not {truth}");
    }
    assert!(fit.quality.r_squared > 0.999);
    assert!(bench.harness.query_by_label_contains("Cmδe").is_some(), "the table names it in Greek");
    picture(&mut bench.harness, "workbench_session");
}

#[test]
fn changed_process_noise_gives_what_a_run_without_a_window_gives_and_undo_takes_it_back() {
    let mut bench = Bench::open();
    let deviation = |bench: &Bench<'_>| {
        let path = bench.snapshot().windows["first"].path.ready().expect("the path is up to date").clone();
        path.reconstruction.deviations[State::PitchAngle as usize].last().expect("the path has samples")
    };
    let (before, estimate) = (deviation(&bench), bench.cm());
    bench.show(Pane::Noise);
    bench.enter("Q q", "0.5");
    let typed = bench.session().filter.process_noise[Input::PitchRate as usize];
    assert!((typed - 0.5_f64.to_radians()).abs() < 1e-12, "{typed}");
    assert!(deviation(&bench) > 1.5 * before, "more noise, less certainty: {} and {before}", deviation(&bench));
    let alone = bench.alone(|_| {});
    let alone = alone.pooled.ready().expect("the run without a window ends").fits[0].fit.clone();
    assert_eq!(alone.expect("Cm is estimated").estimates, bench.cm().estimates);
    assert_ne!(estimate.estimates, bench.cm().estimates);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.cm().estimates, estimate.estimates);
    assert_eq!(deviation(&bench), before);
}

#[test]
fn window_drawn_on_the_lane_and_dragged_at_its_edge_is_computed_over_its_samples() {
    let mut bench = Bench::open();
    let body = bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "first").rect();
    let at_s = |time_s: f32| {
        let per_s = body.width() / 20.0;
        egui::pos2(body.left() + per_s * (time_s - 5.0), body.center().y)
    };
    drag(&mut bench.harness, at_s(30.0), at_s(45.0), 6);
    bench.settle();
    let window = bench.session().windows[1].clone();
    assert_eq!(window.role, WindowRole::Identification);
    assert!((window.window.start_s - 30.0).abs() < 0.2 && (window.window.end_s - 45.0).abs() < 0.2, "{window:?}");
    let samples = |bench: &Bench<'_>, name: &str| {
        bench.snapshot().windows[name].path.ready().expect("the path is up to date").data.inputs.time_s.len()
    };
    let expected = |window: &session::Manoeuvre| {
        (window.window.end_s / STEP_S + 1e-6).floor() as usize - (window.window.start_s / STEP_S - 1e-6).ceil() as usize
            + 1
    };
    assert_eq!(samples(&bench, &window.name), expected(&window));
    assert_eq!(bench.cm().samples(), samples(&bench, "first") + samples(&bench, &window.name));
    drag(&mut bench.harness, at_s(45.0), at_s(55.0), 6);
    bench.settle();
    let dragged = bench.session().windows[1].clone();
    assert!((dragged.window.end_s - 55.0).abs() < 0.2, "{dragged:?}");
    assert_eq!(samples(&bench, &dragged.name), expected(&dragged));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().windows[1], window, "the drag is one step");
}

/// Leaves the elevator out of the small flight from 40 s on.
fn lose_elevator(folder: &Path) {
    let path = folder.join("flight.csv");
    let text = std::fs::read_to_string(&path).expect("the recording is there");
    let keep = |line: &str| {
        let late = line.split(',').next().and_then(|time| time.parse::<f64>().ok()).is_some_and(|time| time > 40.0);
        let kept = line.rsplit_once(',').filter(|_| late).map(|(kept, _)| format!("{kept},"));
        kept.unwrap_or_else(|| line.to_owned()) + "\n"
    };
    std::fs::write(&path, text.lines().map(keep).collect::<String>()).expect("the recording can be written");
}

#[test]
fn window_without_recorded_controls_says_so_in_its_row_and_the_others_keep_their_results() {
    let mut bench = Bench::open_changed(lose_elevator);
    bench.show(Pane::Manoeuvres);
    let alone = bench.cm();
    let second = session::Manoeuvre {
        name: "without elevator".to_owned(),
        window: TimeRange { start_s: 46.0, end_s: 58.0 },
        ..bench.session().windows[0].clone()
    };
    bench.harness.state_mut().apply(&session::Edit::Window(session::WindowEdit::Add(second)));
    bench.settle();
    let failures = bench.snapshot().failures();
    assert_eq!(failures.len(), 1, "{failures:?}");
    assert_eq!(failures[0].0, Place::manoeuvre("without elevator"));
    let shown = bench.harness.get_by_label(&failures[0].1).rect();
    let row = bench.harness.get_by_label("name of without elevator").rect();
    assert!(
        shown.top() >= row.bottom() - 2.0 && shown.right() < 1500.0,
        "the reason is below its row: {shown:?}, {row:?}"
    );
    let pooled = bench.snapshot().pooled.ready().expect("the estimate is up to date").fits[0].fit.clone();
    assert_eq!(pooled.expect("Cm is estimated").estimates, alone.estimates);
    assert!(bench.snapshot().windows["first"].fits.ready().is_some(), "the other manoeuvre keeps its results");
    picture(&mut bench.harness, "reason");
}

#[test]
fn ticked_term_joins_the_model_and_a_term_without_information_is_said() {
    let mut bench = Bench::open();
    bench.show(Pane::Model);
    bench.choose("Cm alpha_dot*c/V");
    let fit = bench.cm();
    assert_eq!(fit.names, ["Cm_0", "Cm_alpha", "Cm_q", "Cm_delta_e", "Cm_alpha_dot"]);
    let (estimate, _) = fit.parameter("Cm_q").expect("it is in the model");
    assert!((estimate / CM[2] - 1.0).abs() < 5.0 * TRUTH_TOLERANCE, "{estimate}");
    bench.choose("Cm beta");
    let pooled = bench.snapshot().pooled.ready().expect("the run ends").clone();
    let cm = &pooled.fits[0];
    assert_eq!(cm.fit.as_ref().expect("the other terms are estimated").names, fit.names);
    assert_eq!(cm.dropped.iter().map(|term| term.derivative.as_str()).collect::<Vec<_>>(), ["Cm_beta"]);
    bench.show(Pane::Derivatives);
    assert!(bench.harness.query_all_by_label_contains("dropped Cm_beta").next().is_some(), "the panel says so");
    bench.show(Pane::Model);
    bench.choose("Cm beta");
    click(&mut bench.harness, "term to add", 2);
    bench.harness.get_by_label("term to add").type_text("alpha*q");
    bench.harness.run_steps(1);
    click(&mut bench.harness, "Add row", 8);
    bench.choose("Cm alpha*qc/V");
    assert!(bench.cm().parameter("Cm_alpha_q").is_some());
}

#[test]
fn saved_session_opens_again_with_the_same_numbers_and_results_are_written() {
    let mut bench = Bench::open();
    bench.show(Pane::Noise);
    bench.enter("R alpha", "0.25");
    let (estimates, edited) = (bench.cm().estimates, bench.session().clone());
    assert!(bench.harness.state().document.history.is_modified());
    bench.request(UiCommand::File(FileCommand::Save));
    assert!(!bench.harness.state().document.history.is_modified());
    let path = bench.folder.path().join("session.toml");
    assert_eq!(session::open(&path).expect("the file opens").session, edited);
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    bench.request(UiCommand::File(FileCommand::OpenRecent(0)));
    assert_eq!(bench.session(), &edited);
    assert_eq!(bench.cm().estimates, estimates);
    let out = bench.folder.path().join("results");
    bench.request(UiCommand::File(FileCommand::Export));
    bench.choose("Save");
    let text = std::fs::read_to_string(out.join("results.json")).expect("the results are written");
    assert!(text.contains(&format!("{}", estimates[1])), "the estimate is in the results to its last digit");
}

#[test]
fn saving_elsewhere_keeps_paths_meaning_the_same_files() {
    let mut bench = Bench::open();
    let estimates = bench.cm().estimates;
    let inner = bench.folder.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder can be made");
    bench.request(UiCommand::File(FileCommand::SaveAs));
    bench.enter_file("inner/moved.toml");
    assert_eq!(bench.session().flights[0].recordings[0].path, "../flight.csv");
    bench.request(UiCommand::Run(doublet::command::RunCommand::Again));
    assert_eq!(bench.cm().estimates, estimates);
}

#[test]
fn unsaved_changes_are_asked_about_before_they_are_lost() {
    let mut bench = Bench::open();
    bench.request(UiCommand::Edit(EditCommand::RemoveWindow));
    assert!(bench.session().windows.is_empty());
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    assert!(bench.harness.state().is_guarding());
    picture(&mut bench.harness, "guard");
    bench.choose("Stay");
    assert_eq!(bench.session().title, "Test flight");
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    bench.choose("Discard");
    assert_ne!(bench.session().title, "Test flight");
}

#[test]
fn every_panel_draws_in_both_themes() {
    let mut bench = Bench::open();
    for theme in [egui::ThemePreference::Dark, egui::ThemePreference::Light] {
        bench.request(UiCommand::View(ViewCommand::Appearance(theme)));
        for &pane in Pane::ALL {
            bench.show(pane);
            let tile = bench.harness.state().state.shown.tree.tiles.find_pane(&pane).expect("the panel is open");
            assert!(bench.harness.state().state.shown.tree.is_visible_in_layout(tile), "{}", pane.title());
            picture(&mut bench.harness, &format!("{}_{theme:?}", pane.title().replace(' ', "_")));
        }
    }
}

#[test]
fn match_panel_shows_measured_and_simulated_motion_with_a_verdict() {
    let mut bench = Bench::open();
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    bench.show(Pane::Match);
    let choose = |bench: &mut Bench<'_>, window: &str| {
        let app = bench.harness.state_mut();
        let session = app.document.session().clone();
        doublet::panels::choose(&mut app.state, &session, window);
        bench.settle();
    };
    choose(&mut bench, "11 aileron 3-2-1-1");
    assert_eq!(bench.snapshot().failures(), [], "nothing fails");
    assert!(bench.harness.query_by_label_contains("2.d.2 roll response").is_some(), "the test of an aileron manoeuvre");
    assert!(bench.harness.query_by_label("pass").is_some(), "the identified model passes");
    let proof = bench.snapshot().proof.ready().expect("the proof is up to date").clone();
    let replay =
        proof.window("11 aileron 3-2-1-1").expect("it is a validation manoeuvre").clone().expect("it is flown");
    let used = 100.0 * replay.tests[0].requirements[0][0].worst_ratio;
    assert!(bench.harness.query_by_label(&format!("p {used:.0} %")).is_some(), "the part of the tolerance used");
    picture(&mut bench.harness, "match_bands");
    bench.choose("Theil");
    assert!(bench.harness.query_by_label("Covariance").is_some());
    bench.choose("All tests");
    assert!(bench.harness.query_all_by_label("pass").count() >= proof.windows.len(), "a verdict per manoeuvre");
    picture(&mut bench.harness, "match_tests");
    bench.harness.get_by_label("Bands").click();
    choose(&mut bench, "12 rudder 3-2-1-1");
    assert!(bench.harness.query_by_label_contains("The model simulates validation manoeuvres").is_some());
}

#[test]
fn missing_recording_is_said_in_one_line_and_nothing_else_breaks() {
    let mut bench = Bench::open();
    std::fs::remove_file(bench.folder.path().join("flight.csv")).expect("the file is there");
    bench.request(UiCommand::Run(doublet::command::RunCommand::Again));
    let failures = bench.snapshot().failures();
    assert!(
        failures.iter().any(|(_, error)| error.contains("flight.csv") && error.lines().count() == 1),
        "{failures:?}"
    );
    assert!(bench.harness.query_all_by_label_contains("flight.csv").next().is_some(), "the manoeuvre says so");
}

impl Bench<'_> {
    /// Types a file into the dialog and confirms.
    pub fn enter_file(&mut self, name: &str) {
        click(&mut self.harness, "File name", 2);
        self.harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        self.harness.run_steps(1);
        self.harness.get_by_label("File name").type_text(name);
        self.harness.run_steps(2);
        self.choose("Save");
    }
}

#[test]
fn cancelled_run_leaves_the_last_results_and_computes_again_when_asked() {
    let mut bench = Bench::open();
    let estimates = bench.cm().estimates;
    bench.show(Pane::Noise);
    let noise = session::Edit::noise(session::NoiseChannel::Input(Input::PitchRate), 0.01);
    bench.harness.state_mut().apply(&noise);
    bench.harness.step();
    bench.request(UiCommand::Run(doublet::command::RunCommand::Cancel));
    assert!(bench.snapshot().pooled.latest().is_some(), "what was there stays visible");
    bench.request(UiCommand::Run(doublet::command::RunCommand::Again));
    assert_ne!(bench.cm().estimates, estimates);
    assert!(bench.snapshot().failures().is_empty());
}

#[test]
fn passenger_who_stays_behind_moves_mass_and_derivatives_of_the_shipped_flight() {
    let mut bench = Bench::shipped();
    let mass_kg =
        |bench: &Bench<'_>| bench.snapshot().loaded.ready().expect("the aircraft is loaded").properties.mass_kg;
    let (full_kg, before, loading) = (mass_kg(&bench), bench.cm(), bench.session().loading.clone());
    bench.show(Pane::Loading);
    let seat = "passenger right";
    let slider = bench.harness.get_by_role_and_label(egui::accesskit::Role::Slider, &format!("Seats {seat}")).rect();
    drag(&mut bench.harness, slider.center(), slider.left_center() + egui::vec2(2.0, 0.0), 4);
    bench.settle();
    let aircraft = bench.snapshot().aircraft.ready().expect("the aircraft is read").clone();
    let standard_kg = aircraft.aircraft.standard_loading.seats_kg[seat];
    let now_kg = bench.session().loading.as_ref().expect("the loading is the session's own").seats_kg[seat];
    assert!(now_kg < 0.2 * standard_kg, "{now_kg} of {standard_kg} kg");
    assert!((full_kg - mass_kg(&bench) - (standard_kg - now_kg)).abs() < MASS_TOLERANCE_KG);
    let slope = |fit: &Fit| fit.parameter("Cm_alpha").expect("it is in the model").0;
    assert_ne!(slope(&bench.cm()), slope(&before));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().loading, loading, "the drag is one step");
    assert_eq!(slope(&bench.cm()), slope(&before));
}

#[test]
fn report_panel_shows_its_sections_and_writes_the_ticked_ones() {
    let mut bench = Bench::open();
    bench.show(Pane::Report);
    assert!(bench.harness.query_all_by_label("Flights").next().is_some(), "the overview names the flights");
    for kind in SectionKind::ALL {
        // A panel may be named like a section: the one beside its tick is meant.
        bench.harness.get_by_label(&format!("report {}", kind.name())).scroll_to_me();
        bench.harness.run_steps(3);
        let tick = bench.harness.get_by_label(&format!("report {}", kind.name())).rect();
        let beside = |node: &egui_kittest::Node<'_>| (node.rect().center().y - tick.center().y).abs() < 4.0;
        bench.harness.get_all_by_label(kind.title()).find(beside).expect("the section can be chosen").click();
        bench.settle();
        picture(&mut bench.harness, &format!("report_{}", kind.name()));
        if ![SectionKind::Derivatives, SectionKind::Fits].contains(&kind) {
            bench.choose(&format!("report {}", kind.name()));
        }
    }
    bench.choose("PDF");
    let estimate = bench.cm().estimates[1];
    bench.choose("Write report…");
    bench.choose("Save");
    let out = bench.folder.path().join("report");
    let html = std::fs::read_to_string(out.join("session.html")).expect("the report is written");
    let appendices = html.matches("<section id=\"appendix-").count();
    assert_eq!(html.matches("<section").count(), 2 + appendices, "as many sections as are ticked");
    assert_eq!(appendices, 2, "one appendix for each");
    assert!(html.contains(&format!("value=\"{estimate}\"")), "the estimate is in the report to its last digit");
    assert!(!out.join("session.pdf").exists(), "a form that is not ticked is not written");
}
