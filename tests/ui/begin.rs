//! A user's own recording: dropped on the window, its channels given roles, made into a session, saved and opened again.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use doublet::command::{FileCommand, UiCommand, ViewCommand};
use doublet_core::model::Coefficient;
use doublet_core::quantity::Role;
use doublet_engine::session::{self, MapRef, Surface};
use egui::accesskit::Role as Kind;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::click;
use crate::painted::faults;
use crate::picture;
use crate::recording::{LENGTH_S, STEP_S};
use crate::workbench::Bench;

/// Longest wait for a recording to be read.
const PATIENCE: Duration = Duration::from_secs(120);

/// A file let go over the window.
#[derive(Debug)]
pub struct Dropped(pub PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// The small flight as another recorder would write it: other names, the pitch rate in degrees under a name nobody knows, the
/// accelerometer upwards in g.
fn foreign(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(folder.join("flight.csv")).expect("the flight is there");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("it has a header").split(',').collect();
    let renamed = names.iter().map(|name| match *name {
        "ax" => "AccX [m/s^2]",
        "az" => "Nz",
        "q" => "channel 17",
        "alpha" => "AoA [deg]",
        "delta_e" => "elevator_rad",
        other => other,
    });
    let mut out = renamed.collect::<Vec<_>>().join(",");
    for line in lines {
        let cells = line.split(',').zip(&names).map(|(cell, name)| {
            let value: f64 = cell.parse().expect("every cell is a number");
            match *name {
                "az" => (-value / 9.806_65).to_string(),
                "q" | "alpha" => value.to_degrees().to_string(),
                _ => cell.to_owned(),
            }
        });
        out.push('\n');
        out.push_str(&cells.collect::<Vec<_>>().join(","));
    }
    let path = folder.join("foreign.csv");
    std::fs::write(&path, out).expect("the recording can be written");
    path
}

impl Bench<'_> {
    /// The dialog of a new session on the foreign recording, its pitch rate mapped by hand.
    fn with_mapped_recording() -> Self {
        let mut bench = Self::open();
        let path = foreign(bench.folder.path());
        bench.drop_file(path);
        bench.wait_for("Create session");
        bench.step("Channels");
        bench.choose_entry("channel of q", "channel 17");
        bench.choose_entry("unit of q", "deg/s");
        bench.wait_for("shape of q");
        bench
    }

    /// Goes to a step of the page.
    pub fn step(&mut self, title: &str) {
        let label = format!("new session step {title}: ");
        self.harness.get_by_label_contains(&label).click();
        self.harness.run_steps(4);
    }

    pub fn drop_file(&mut self, path: PathBuf) {
        self.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path)));
        self.harness.run_steps(2);
    }

    /// Draws frames until something called `label` is there.
    pub fn wait_for(&mut self, label: &str) {
        self.wait_until(label, |bench| bench.harness.query_all_by_label(label).next().is_some());
    }

    pub fn wait_until(&mut self, what: &str, is_there: impl Fn(&Self) -> bool) {
        let started = Instant::now();
        while !is_there(self) {
            assert!(started.elapsed() < PATIENCE, "'{what}' comes up: {:?}", self.harness.state().message);
            std::thread::sleep(Duration::from_millis(5));
            self.harness.step();
        }
        self.harness.run_steps(2);
    }

    /// Draws frames until the session is made and computed.
    pub fn wait_until_made(&mut self) {
        let started = Instant::now();
        self.harness.run_steps(2);
        while self.harness.state().is_beginning() {
            assert!(started.elapsed() < PATIENCE, "the session is made");
            std::thread::sleep(Duration::from_millis(5));
            self.harness.step();
        }
        self.settle();
    }

    /// Opens the list called `combo` and chooses `entry` of it.
    pub fn choose_entry(&mut self, combo: &str, entry: &str) {
        self.harness.get_by_role_and_label(Kind::ComboBox, combo).scroll_to_me();
        self.harness.run_steps(3);
        self.harness.get_by_role_and_label(Kind::ComboBox, combo).click();
        self.harness.run_steps(3);
        let is_entry = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Kind::Button;
        let row = self.harness.get_all_by_label(entry).rfind(is_entry).expect("the list has it");
        row.scroll_to_me();
        row.click();
        self.harness.run_steps(3);
    }
}

#[test]
fn dropped_recording_becomes_a_session_whose_numbers_are_in_si_and_come_back() {
    let mut bench = Bench::open();
    let path = foreign(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    bench.step("Channels");
    assert!(
        bench.harness.query_by_label_contains("needed for the flight path: q").is_some(),
        "the pitch rate is missing"
    );
    let create = |bench: &Bench<'_>| {
        let button = bench.harness.get_by_label("Create session");
        !button.accesskit_node().is_disabled()
    };
    assert!(!create(&bench), "no aircraft is assumed");
    assert!(bench.harness.query_by_label_contains("First: choose the aircraft").is_some(), "which is said");
    picture(&mut bench.harness, "new_session_open");
    bench.choose_entry("channel of q", "channel 17");
    bench.choose_entry("unit of q", "deg/s");
    assert!(bench.harness.query_by_label_contains("needed for the flight path").is_none());
    let reasons = |word: &str| bench.harness.query_all_by_label(word).count();
    let evidence = bench.harness.query_all_by_label_contains("by its").count();
    assert!(evidence >= 5 && reasons("by hand") == 1, "the evidence of each row stands beside it");
    bench.step("Recording and aircraft");
    click(&mut bench.harness, "Aircraft file…", 4);
    let aircraft = bench.folder.path().join("aircraft.toml");
    bench.harness.get_by_label("File name").type_text(&aircraft.display().to_string());
    bench.harness.run_steps(2);
    bench.harness.key_press(egui::Key::Enter);
    bench.harness.run_steps(4);
    assert!(create(&bench), "nothing is open any more");
    picture(&mut bench.harness, "new_session");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    picture(&mut bench.harness, "new_session_made");
    check(&bench);
    let made = bench.session().clone();
    assert!(matches!(made.flights[0].recordings[0].channel_map, MapRef::Own(_)), "the map is the session's own");
    let file = bench.folder.path().join("mine.toml");
    bench.harness.state_mut().document.save(&file).expect("it is saved");
    let opened = session::open(&file).expect("it opens again").session;
    assert_eq!(opened.windows, made.windows);
    bench.drop_file(file);
    bench.settle();
    check(&bench);
}

#[test]
fn further_file_leaves_what_was_chosen_and_a_broken_one_is_said() {
    let mut bench = Bench::with_mapped_recording();
    bench.step("Recording and aircraft");
    bench.choose_entry("aircraft", "none: flight path only");
    let seconds = (0..(LENGTH_S / STEP_S) as u32).map(|k| f64::from(k) * STEP_S);
    let rows: String = seconds.map(|t| format!("{t},{}\n", 1000.0 + t)).collect();
    let chosen = |bench: &mut Bench<'_>| {
        bench.step("Channels");
        assert!(bench.harness.query_all_by_label("5.73").next().is_some(), "the pitch rate is mapped by hand");
        bench.step("Recording and aircraft");
        let aircraft = bench.harness.get_by_role_and_label(Kind::ComboBox, "aircraft");
        assert_eq!(aircraft.accesskit_node().value().as_deref(), Some("none: flight path only"));
    };
    for (name, text) in [("more.csv", format!("time,engine_rpm\n{rows}")), ("letter.csv", "dear sir,\n".to_owned())] {
        let path = bench.folder.path().join(name);
        std::fs::write(&path, text).expect("it can be written");
        click(&mut bench.harness, "Add a file…", 4);
        bench.harness.get_by_label("File name").type_text(&path.display().to_string());
        bench.harness.run_steps(2);
        bench.harness.key_press(egui::Key::Enter);
        bench.wait_until(name, |bench| {
            let is_there = |part: &str| bench.harness.query_all_by_label_contains(part).next().is_some();
            !is_there("File name") && is_there("new session step Channels: ") && is_there(name)
        });
        chosen(&mut bench);
    }
}

#[test]
fn recording_without_an_aircraft_gives_its_flight_path() {
    let mut bench = Bench::with_mapped_recording();
    // q = 0.04 * 1.3 + 0.02 * 2.4 rad/s at the start, in the unit of the channel.
    assert!(bench.harness.query_all_by_label("5.73").next().is_some(), "the first value is in degrees per second");
    bench.step("Recording and aircraft");
    bench.choose_entry("aircraft", "none: flight path only");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    assert_eq!(bench.session().aircraft, None);
    let window = &bench.snapshot().windows[&bench.session().windows[0].name];
    assert!(window.path.ready().is_some(), "{:?}", bench.snapshot().failures());
    assert!(bench.snapshot().pooled.ready().is_none_or(|pooled| pooled.fits.is_empty()));
}

#[test]
fn pulse_of_a_servo_becomes_a_deflection_by_the_travel_that_is_said() {
    let mut bench = Bench::open();
    let path = foreign(bench.folder.path());
    let text = std::fs::read_to_string(&path).expect("it was written");
    let mut lines = text.lines();
    let head = lines.next().expect("it has a header").replace("elevator_rad", "servo 2");
    let column = head.split(',').position(|name| name == "servo 2").expect("the elevator is recorded");
    let pulse = |cell: &str| 1500.0 - cell.parse::<f64>().expect("a number").to_degrees() / 0.07;
    let pulses = lines.map(|line| {
        let cell = |(at, cell): (usize, &str)| if at == column { pulse(cell).to_string() } else { cell.to_owned() };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",")
    });
    let all: Vec<String> = std::iter::once(head.clone()).chain(pulses).collect();
    std::fs::write(&path, all.join("\n")).expect("it can be written");
    bench.drop_file(path);
    bench.wait_for("Create session");
    bench.step("Channels");
    bench.choose_entry("channel of q", "channel 17");
    bench.choose_entry("unit of q", "deg/s");
    // The list is narrowed by what is typed, and Return takes what is left.
    bench.harness.get_by_role_and_label(Kind::ComboBox, "channel of delta_e").click();
    bench.harness.run_steps(4);
    bench.harness.get_by_label("part of the channel's name for delta_e").type_text("RVO");
    bench.harness.run_steps(3);
    assert!(bench.harness.query_all_by_label("AccX [m/s^2]").count() <= 1, "only what fits is listed");
    bench.harness.key_press(egui::Key::Enter);
    bench.harness.run_steps(4);
    click(&mut bench.harness, "travel of delta_e", 6);
    picture(&mut bench.harness, "new_session_travel");
    for (name, value) in
        [("recorded at neutral", "1500"), ("recorded at another position", "2000"), ("deflection there", "-35")]
    {
        bench.enter(&format!("{name} of delta_e"), value);
    }
    assert!(bench.harness.query_by_label("deflection there of delta_e").is_none(), "Return in the last field ends it");
    bench.step("Recording and aircraft");
    bench.choose_entry("aircraft", "none: flight path only");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    let flight = bench.snapshot().flights["foreign"].ready().expect("the recording is read").clone();
    let found = flight.recording.role(Role::Elevator).expect("the elevator is mapped").series.values.clone();
    let first = text.lines().nth(1).and_then(|line| line.split(',').nth(column)).expect("it has a sample");
    let expected: f64 = first.parse().expect("a number");
    assert!((found[0] - expected).abs() < 1e-9, "{} rad for {expected}", found[0]);
}

#[test]
fn contradiction_of_a_channel_is_named_and_fixed_by_one_click() {
    let mut bench = Bench::with_mapped_recording();
    bench.harness.get_by_label("sign of az").scroll_to_me();
    bench.harness.run_steps(3);
    click(&mut bench.harness, "sign of az", 2);
    bench.step("Check");
    bench.wait_for("apply the fix of az");
    for when in ["as read", "with the fix"] {
        let name = format!("curves of az {when}");
        let curves = bench.harness.get_by_label(&name).rect();
        let button = bench.harness.get_by_label("apply the fix of az").rect();
        assert!(curves.width() > 100.0 && curves.height() > 40.0, "{name}: {curves:?}");
        assert!(
            curves.top() < button.bottom() && curves.left() > button.right(),
            "beside the button: {curves:?} {button:?}"
        );
    }
    picture(&mut bench.harness, "new_session_contradiction");
    // A unit that nothing states is confirmed by a click, and not asked for again.
    click(&mut bench.harness, "confirm the unit of p", 3);
    assert!(bench.harness.query_by_label("confirm the unit of p").is_none());
    assert!(bench.harness.query_by_label("confirm the unit of r").is_some());
    click(&mut bench.harness, "apply the fix of az", 3);
    let started = Instant::now();
    while bench.harness.query_all_by_label("apply the fix of az").next().is_some() {
        assert!(started.elapsed() < PATIENCE, "the contradiction is gone");
        std::thread::sleep(Duration::from_millis(5));
        bench.harness.step();
    }
    assert!(bench.harness.query_by_label_contains("az: sign reversed").is_none());
}

/// What the recording must have become.
fn check(bench: &Bench<'_>) {
    let flight = bench.snapshot().flights["foreign"].ready().expect("the recording is read").clone();
    let values = |role: Role| flight.recording.role(role).map(|channel| channel.series.values.clone());
    let samples = (LENGTH_S / STEP_S).round() as usize + 1;
    for role in [Role::SpecificForceX, Role::SpecificForceZ, Role::PitchRate, Role::AngleOfAttack, Role::Elevator] {
        let found = values(role).expect("the role is there");
        assert_eq!(found.len(), samples, "{}", role.name());
    }
    // q = 0.04 * 1.3 + 0.02 * 2.4 at the start, alpha = 0.06.
    assert!((values(Role::PitchRate).expect("q")[0] - 0.1).abs() < 1e-9);
    assert!((values(Role::AngleOfAttack).expect("alpha")[0] - 0.06).abs() < 1e-9);
    assert!(values(Role::SpecificForceZ).expect("az")[0] < -5.0, "level flight has az = -g");
    assert!(bench.session().aircraft.as_ref().is_some_and(|path| path.ends_with("aircraft.toml")));
    let cm = bench.snapshot().pooled.ready().expect("derivatives follow");
    let cm = cm.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).expect("Cm is modelled");
    assert!(cm.fit.as_ref().is_ok_and(|fit| fit.quality.r_squared > 0.98), "{:?}", cm.fit);
}

#[test]
fn recording_of_a_known_recorder_gets_its_map_and_the_manoeuvres_of_its_controls() {
    let mut bench = Bench::open();
    let demo = doublet_engine::builtin::on_disk("flights/demo").expect("the demonstration flight is there");
    let files: Vec<PathBuf> =
        std::fs::read_dir(demo).expect("it has files").map(|e| e.expect("a file").path()).collect();
    let bus = files.into_iter().find(|path| path.to_string_lossy().contains("bus")).expect("there is the data bus");
    bench.drop_file(bus);
    bench.wait_for("Create session");
    picture(&mut bench.harness, "new_session_known");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    let session = bench.session();
    assert_eq!(session.flights.len(), 1);
    assert!(!session.windows.is_empty());
    assert!(session.windows.iter().all(|window| window.surface.is_none_or(|s| Surface::ALL.contains(&s))));
}

#[test]
fn file_that_is_no_recording_is_refused_in_one_line() {
    let mut bench = Bench::open();
    let path = bench.folder.path().join("letter.csv");
    std::fs::write(&path, "dear sir,\nthere are no numbers here\n").expect("it can be written");
    bench.drop_file(path);
    let started = Instant::now();
    while bench.harness.state().is_beginning() && started.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(5));
        bench.harness.step();
    }
    let message = bench.harness.state().message.clone().expect("something is said");
    assert!(
        message.is_error && message.text.contains("letter.csv") && message.text.lines().count() == 1,
        "{message:?}"
    );
    assert_eq!(bench.session().title, "Test flight", "the session stays");
}

/// A recording of the foreign flight with forty more channels of long names that nobody knows.
fn unmapped(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(foreign(folder)).expect("it was written");
    let more: Vec<String> = (1..=40).map(|at| format!("Messstelle {at:02} hinten links oben [counts]")).collect();
    let mut lines = text.lines();
    let mut out = format!("{},{}", lines.next().expect("it has a header"), more.join(","));
    for (row, line) in lines.enumerate() {
        out.push_str(&format!("\n{line}"));
        (0..more.len()).for_each(|at| out.push_str(&format!(",{}", (row * (at + 3)) % 977)));
    }
    let path = folder.join("unmapped recording.csv");
    std::fs::write(&path, out).expect("it can be written");
    path
}

#[test]
fn page_with_a_long_unmapped_table_fits_a_laptop() {
    let mut bench = Bench::open();
    bench.harness.set_size(egui::vec2(1280.0, 720.0));
    let path = unmapped(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    click(&mut bench.harness, "Describe aircraft…", 4);
    bench.step("Channels");
    let combo = bench.harness.get_by_role_and_label(Kind::ComboBox, "channel of q");
    combo.scroll_to_me();
    bench.harness.run_steps(3);
    bench.harness.get_by_role_and_label(Kind::ComboBox, "channel of q").click();
    bench.harness.run_steps(3);
    bench.harness.get_by_label("part of the channel's name for q").type_text("Messstelle 07");
    bench.harness.run_steps(2);
    bench.harness.key_press(egui::Key::Enter);
    bench.harness.run_steps(3);
    bench.choose_entry("unit of q", "deg/s");
    bench.wait_for("shape of q");
    let certain = bench.harness.query_all_by_label_contains("%, by its name").count();
    let asked = bench.harness.query_all_by_label_contains("%, unit?").count();
    assert!(certain > 0 && asked > 0, "confidence of the guessed roles: {certain}, {asked}");
    let mut all = Vec::new();
    for theme in [egui::ThemePreference::Dark, egui::ThemePreference::Light] {
        bench.request(UiCommand::View(ViewCommand::Appearance(theme)));
        for page in ["Recording and aircraft", "Channels", "Check"] {
            bench.step(page);
            bench.harness.hover_at(egui::pos2(640.0, 717.0));
            bench.harness.run_steps(4);
            picture(&mut bench.harness, &format!("begin_{page}_{theme:?}"));
            let found = faults(&bench);
            all.extend(found.into_iter().map(|fault| format!("{page}, {theme:?}: {fault}")));
            let create = bench.harness.get_by_label("Create session").rect();
            assert!(create.right() < 1280.0 && create.bottom() < 720.0, "{page}: {create:?}");
        }
    }
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}

#[test]
fn draft_of_a_new_session_is_kept_when_left_and_escape_asks_before_it_is_lost() {
    let mut bench = Bench::with_mapped_recording();
    let escape = |bench: &mut Bench<'_>| {
        bench.harness.key_press(egui::Key::Escape);
        bench.harness.run_steps(4);
    };
    let is_asked = |bench: &Bench<'_>| bench.harness.query_by_label("Cancel the new session?").is_some();
    escape(&mut bench);
    assert!(is_asked(&bench), "what was chosen by hand is not dropped without a question");
    picture(&mut bench.harness, "begin_asks");
    escape(&mut bench);
    assert!(!is_asked(&bench) && bench.harness.state().is_beginning(), "Escape goes on");
    bench.choose("Leave, keep the draft");
    assert!(!bench.harness.state().is_beginning());
    assert_eq!(bench.harness.state().draft_name(), Some("foreign"));
    bench.request(UiCommand::File(FileCommand::ContinueNew));
    bench.step("Channels");
    let channel = bench.harness.get_by_role_and_label(Kind::ComboBox, "channel of q");
    assert_eq!(channel.accesskit_node().value().as_deref(), Some("channel 17"));
    click(&mut bench.harness, "Cancel", 4);
    assert!(is_asked(&bench));
    bench.choose("Discard the draft");
    assert!(!bench.harness.state().is_beginning() && bench.harness.state().draft_name().is_none());
}

#[test]
fn described_aircraft_is_saved_under_its_own_name_beside_the_recording() {
    let mut bench = Bench::shipped();
    crate::recording::write(bench.folder.path());
    let path = foreign(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    click(&mut bench.harness, "Describe aircraft…", 4);
    bench.enter("name of the aircraft", "Trainer II");
    click(&mut bench.harness, "Save the aircraft…", 4);
    let name = bench.harness.get_by_label("File name").accesskit_node().value();
    assert_eq!(name.as_deref(), Some("Trainer_II.toml"));
    let folder = bench.folder.path().canonicalize().expect("it is there").display().to_string();
    assert!(bench.harness.query_by_label(&folder).is_some(), "where the recording is");
}

#[test]
fn numbers_of_an_aircraft_that_are_not_typed_are_named_as_guesses() {
    let mut bench = Bench::open();
    let path = foreign(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    click(&mut bench.harness, "Describe aircraft…", 4);
    let guessed = |bench: &Bench<'_>, name: &str| {
        let line = bench.harness.query_by_label_contains("Guesses, not values");
        line.is_some_and(|line| line.accesskit_node().value().unwrap_or_default().contains(name))
    };
    assert!(guessed(&bench, "Span") && guessed(&bench, "Ixz") && !guessed(&bench, "Length"));
    picture(&mut bench.harness, "begin_guesses");
    bench.enter("Span", "11,7");
    assert!(!guessed(&bench, "Span") && guessed(&bench, "Mean chord"));
    bench.enter("Span", "eleven");
    assert!(bench.harness.query_by_label_contains("'eleven'").is_some(), "what is no number is said");
}

/// The foreign recording with an elevator whose values can be degrees or per cent, without a unit.
fn without_unit(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(foreign(folder)).expect("it was written");
    let mut lines = text.lines();
    let head = lines.next().expect("it has a header");
    let at = head.split(',').position(|name| name == "elevator_rad").expect("it has an elevator");
    let rows = lines.map(|line| {
        let cells = line.split(',').enumerate().map(|(column, cell)| match cell.parse::<f64>() {
            Ok(value) if column == at => (300.0 * value.to_degrees()).clamp(-80.0, 80.0).to_string(),
            _ => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",")
    });
    let head = head.replace("elevator_rad", "elevator");
    let path = folder.join("two units.csv");
    std::fs::write(&path, std::iter::once(head).chain(rows).collect::<Vec<_>>().join("\n")).expect("it can be written");
    path
}

#[test]
fn a_session_is_created_once_the_unit_of_a_control_is_confirmed() {
    let mut bench = Bench::open();
    let path = without_unit(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    bench.choose_entry("aircraft", "none: flight path only");
    let is_open = |bench: &Bench<'_>| !bench.harness.get_by_label("Create session").accesskit_node().is_disabled();
    assert!(!is_open(&bench), "degrees or per cent is not known");
    bench.step("Check");
    picture(&mut bench.harness, "begin_unit");
    bench.harness.get_by_label("confirm the unit of delta_e").click();
    bench.harness.run_steps(3);
    assert!(is_open(&bench));
}

#[test]
fn a_missing_inertial_channel_is_named_beside_create_and_all_units_are_confirmed_at_once() {
    let mut bench = Bench::open();
    let path = foreign(bench.folder.path());
    bench.drop_file(path);
    bench.wait_for("Create session");
    bench.choose_entry("aircraft", "none: flight path only");
    let missing =
        |bench: &Bench<'_>| bench.harness.query_all_by_label("missing, needed for the flight path: q").count();
    let before = missing(&bench);
    bench.step("Channels");
    bench.choose_entry("channel of q", "channel 17");
    assert_eq!([before, missing(&bench)], [1, 0], "beside Create");
    bench.step("Check");
    assert!(bench.harness.query_all_by_label_contains("confirm the unit of").count() > 1);
    picture(&mut bench.harness, "begin_units");
    bench.harness.get_by_label_contains("Confirm all").click();
    bench.harness.run_steps(3);
    assert_eq!(bench.harness.query_all_by_label_contains("confirm the unit of").count(), 0);
}
