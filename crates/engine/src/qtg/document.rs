//! The qualification test guide as a document: cover, device, revisions, references, glossary, methods, results, a page per test.

use super::conditions::NOT_GIVEN;
use super::file::{DEVICE, ENGINEERING_DATA};
use super::units::{dimension_of, named, shown, shown_as, unit, with_error};
use super::{Constants, Qualification, QualificationTest, TestFile, ValueRow};
use crate::notation::significant;
use crate::report::document::{Block, Document, Section, Style};
use crate::report::{Cell, Column, Table};
use crate::session::Session;
use crate::snapshot::Snapshot;

/// Lays a guide out.
pub fn document(session: &Session, snapshot: &Snapshot, file: &TestFile, found: &Qualification) -> Document {
    let mut sections = vec![
        section("device", "Device and aeroplane", device(file, found)),
        section("revisions", "Log of revisions and effective pages", revisions(file, found)),
        section("references", "References", references(session, snapshot, file, found)),
        section("glossary", "Glossary of terms, symbols and signs", vec![Block::Table(glossary())]),
        section("methods", "Statements and methods", methods(file, found)),
        section("results", "Results", vec![tally(found), Block::Table(results(found))]),
        section("index", "Index of the rule", vec![Block::Table(index(found))]),
    ];
    // Tests follow each other, each on one page where it fits.
    for section in &mut sections {
        section.on_new_page = section.name == "results";
    }
    sections.extend(found.tests.iter().map(|test| page(test, &found.date)));
    Document {
        title: if found.title.is_empty() { "Qualification test guide".to_owned() } else { found.title.clone() },
        subtitle: found.aircraft.clone(),
        date: found.date.clone(),
        notice: notice(found),
        cover: cover(file, found),
        signatures: ["Sponsor: prepared", "Sponsor: approved", "Authority"].map(str::to_owned).into(),
        style: Style { is_compact: true, ..Style::default() },
        sections,
    }
}

fn section(name: &str, title: &str, blocks: Vec<Block>) -> Section {
    Section {
        name: name.to_owned(),
        title: title.to_owned(),
        is_numbered: true,
        on_new_page: false,
        is_appendix: false,
        blocks,
    }
}

/// What every page is a product of.
fn notice(found: &Qualification) -> String {
    format!("Product of the model of {} identified from flight, not of a training device.", found.aircraft)
}

fn facts(facts: impl IntoIterator<Item = (&'static str, String)>) -> Block {
    Block::Facts(facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
}

fn tally(found: &Qualification) -> Block {
    let worst = found.tests.iter().map(QualificationTest::level).max().unwrap_or_default();
    Block::Outcome(worst, found.tally())
}

fn given<'a>(file: &'a TestFile, key: &str) -> &'a str {
    file.device.get(key).map_or(NOT_GIVEN, String::as_str)
}

fn revision(file: &TestFile) -> String {
    let last = file.revisions.last();
    last.map_or(NOT_GIVEN.to_owned(), |last| {
        if last.date.is_empty() { last.number.clone() } else { format!("{} of {}", last.number, last.date) }
    })
}

fn cover(file: &TestFile, found: &Qualification) -> Vec<Block> {
    let edition = if found.edition.is_empty() { String::new() } else { format!(", edition of {}", found.edition) };
    vec![
        facts([
            ("Document", "Qualification test guide: objective tests".to_owned()),
            ("Sponsor", given(file, "sponsor").to_owned()),
            ("Aeroplane", given(file, "aeroplane").to_owned()),
            ("Device", given(file, "device").to_owned()),
            ("Rule", format!("{}{edition}", found.rule)),
            ("Certainty of its numbers", certainty(found)),
            ("Constants of the model", constants(file.constants).to_owned()),
            ("Revision", revision(file)),
            ("Date of the results", found.date.clone()),
            ("Program", found.app.clone()),
            ("Session SHA-256", found.session_sha256.clone()),
        ]),
        tally(found),
        facts([("Failed", listed(found, Some(false))), ("Not judged", listed(found, None))]),
        Block::Paragraph(format!(
            "Results in this guide are those of the mathematical model of {} that was identified from flight by {}. They were computed without a training device. They do not show the behaviour of a device with controls, instruments, visual or motion system, and are not an approval. Repeat the tests on any device built on this model.",
            found.aircraft, found.app
        )),
    ]
}

/// How sure the numbers of the rule are.
fn certainty(found: &Qualification) -> String {
    if found.certainty.is_empty() { NOT_GIVEN.to_owned() } else { found.certainty.clone() }
}

/// Where the constants of the flown model are from, in words.
fn constants(constants: Constants) -> &'static str {
    match constants {
        Constants::Identification => "those of the identification; time histories start from the trim of the model",
        Constants::Refit => "refitted to each manoeuvre; time histories start from the reconstructed state",
    }
}

/// Every test of the rule with what there is of it.
fn index(found: &Qualification) -> Table {
    let columns = [
        ("paragraph", "Paragraph"),
        ("name", "Test of the rule"),
        ("condition", "Condition"),
        ("certainty", "Tolerance"),
        ("status", "Result"),
        ("tests", "Tests here, or reason"),
    ];
    let rows = found.index.iter().map(|row| {
        let tests = row.tests.join(", ");
        let last = [tests.as_str(), &row.reason].into_iter().filter(|part| !part.is_empty());
        let last = last.collect::<Vec<_>>().join(": ");
        let parts = [
            row.paragraph.as_str(),
            &row.name,
            &row.condition,
            row.certainty.unwrap_or_default(),
            row.status.label(),
            &last,
        ];
        parts.map(Cell::text).into()
    });
    Table {
        name: "index".to_owned(),
        caption: format!("Tests of {} in the order of their numbers.", found.rule),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: rows.collect(),
    }
}

/// Numbers of the tests that ended so.
fn listed(found: &Qualification, passed: Option<bool>) -> String {
    let tests = found.tests.iter().filter(|test| test.passed == passed);
    let tests: Vec<String> = tests.map(|test| format!("{} {}", test.id, test.title)).collect();
    if tests.is_empty() { "none".to_owned() } else { tests.join("; ") }
}

fn device(file: &TestFile, found: &Qualification) -> Vec<Block> {
    let rows = DEVICE.iter().map(|(key, words)| match *key {
        "aerodynamic_data" if !file.device.contains_key(*key) => {
            (*words, format!("identified from flight by {}, session {}", found.app, found.session_sha256))
        }
        _ => (*words, given(file, key).to_owned()),
    });
    vec![facts(rows)]
}

fn revisions(file: &TestFile, found: &Qualification) -> Vec<Block> {
    let text = |text: &str| Cell::text(if text.is_empty() { NOT_GIVEN } else { text });
    let rows = file.revisions.iter().map(|revision| {
        [&revision.number, &revision.date, &revision.pages, &revision.change].map(|part| text(part)).into()
    });
    let table = Table {
        name: "revisions".to_owned(),
        caption: "Revisions of this guide.".to_owned(),
        columns: [("number", "Revision"), ("date", "Date"), ("pages", "Pages"), ("change", "Change")]
            .map(|(key, heading)| Column::new(key, heading))
            .into(),
        rows: rows.collect(),
    };
    let log = if table.rows.is_empty() { Block::Paragraph(NOT_GIVEN.to_owned()) } else { Block::Table(table) };
    let effective = format!(
        "Effective pages: all pages, numbered at the foot, are of revision {} with results of {}.",
        revision(file),
        found.date
    );
    vec![log, Block::Paragraph(effective)]
}

fn references(session: &Session, snapshot: &Snapshot, file: &TestFile, found: &Qualification) -> Vec<Block> {
    let source = if file.rule.source.is_empty() { NOT_GIVEN } else { &file.rule.source };
    let mut lines = vec![format!("Rule: {} ({source}).", found.rule)];
    lines.extend(file.references.iter().cloned());
    let rows = session.flights.iter().flat_map(|flight| {
        let loaded = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready());
        let hashes = loaded.map(|loaded| loaded.hashes.clone()).unwrap_or_default();
        let hash = move |index: usize| hashes.get(index).cloned().unwrap_or_else(|| NOT_GIVEN.to_owned());
        let recordings = flight.recordings.iter().enumerate();
        recordings
            .map(move |(index, entry)| vec![Cell::text(&flight.name), Cell::text(&entry.path), Cell::text(hash(index))])
    });
    let table = Table {
        name: "validation_data".to_owned(),
        caption: "Validation data: complete flight recordings as read. The part used by each test is copied to a file named on its page."
            .to_owned(),
        columns: [("flight", "Flight"), ("recording", "Recording"), ("sha256", "SHA-256")]
            .map(|(key, heading)| Column::new(key, heading))
            .into(),
        rows: rows.collect(),
    };
    vec![Block::List(lines), Block::Table(table)]
}

/// Symbol, meaning, unit of the pages and positive sense.
const GLOSSARY: [[&str; 4]; 19] = [
    ["V", "true airspeed", "kt", "forward"],
    ["h", "altitude, in plots above the local origin", "ft", "up"],
    ["α", "angle of attack, atan(w/u)", "deg", "air from below"],
    ["β", "angle of sideslip, asin(v/V)", "deg", "air from the right"],
    ["φ", "bank angle", "deg", "right wing down"],
    ["θ", "pitch angle", "deg", "nose up"],
    ["ψ", "heading", "deg", "clockwise from north"],
    ["p", "roll rate, body axes", "deg/s", "right wing going down"],
    ["q", "pitch rate, body axes", "deg/s", "nose going up"],
    ["r", "yaw rate, body axes", "deg/s", "nose going right"],
    ["n", "normal acceleration: specific force along body z, sign reversed", "g", "up"],
    ["ax, ay", "specific forces along body x and y", "g", "forward, right"],
    ["elevator", "deflection of the elevator", "deg", "trailing edge down: negative pitch rate"],
    ["aileron", "deflection of the right aileron", "deg", "right aileron down: negative roll rate"],
    ["rudder", "deflection of the rudder", "deg", "trailing edge left: negative yaw rate"],
    ["period", "of the damped free response, 2π/ω", "s", ""],
    ["damping ratio", "ζ of the free response", "", "damped"],
    ["time to half or double", "ln 2 over the decay of the free response", "s", "to half; negative to double"],
    ["peak lag", "from the peaks of bank to those of sideslip", "s", "sideslip later"],
];

fn glossary() -> Table {
    let columns = [("symbol", "Symbol or term"), ("meaning", "Meaning"), ("unit", "Unit"), ("sense", "Positive")];
    Table {
        name: "glossary".to_owned(),
        caption: "Axes are those of the body: x forward, y right, z down from the centre of gravity.".to_owned(),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: GLOSSARY.iter().map(|row| row.map(Cell::text).into()).collect(),
    }
}

fn methods(file: &TestFile, found: &Qualification) -> Vec<Block> {
    let mut lines = vec![
        "Product under test: the identified model, simulated by the program. This guide makes no statement of compliance of a \
         device."
            .to_owned(),
        "Recording: the session and the recordings under References define the instruments and their calibration. The flight shown on \
         every page is the path reconstructed from them (Kalman filter and smoother), with estimated biases removed."
            .to_owned(),
        time_histories(file.constants).to_owned(),
        "Snapshots test trims, drag and thrust, with the constants of the identification. A test passes if one tolerance of each \
         requirement holds throughout; where two are given, the less restrictive applies."
            .to_owned(),
        format!("Percentages of bands are {}; of single numbers, of the flight's value.", found.percent),
        "Period and damping: a damped oscillation with a drift is fitted to flight and model from the end of the input; \
         standard errors are corrected for the correlation of the residuals."
            .to_owned(),
        "A test without a recording, or with a shorter record than the rule requires, neither passes nor fails."
            .to_owned(),
    ];
    if found.engineering_data {
        let percent = 100.0 * ENGINEERING_DATA;
        lines.push(format!(
            "The reference is an engineering simulation: {percent:.0} % of every tolerance of the rule applies."
        ));
    }
    for (signal, largest) in &file.reading.normal_range {
        let (unit, factor) = unit(signal.dimension());
        let largest = significant(largest * factor, 4);
        lines.push(format!("Normal operating range of {}: up to {largest} {unit}.", named(signal.name())));
    }
    vec![Block::List(lines)]
}

/// How time histories are computed.
fn time_histories(constants: Constants) -> &'static str {
    match constants {
        Constants::Identification => {
            "Time histories: the model is trimmed at the mean airspeed, flight path and turn rate of the steady flight before the input, \
             with the constants of the identification. Its elevator, aileron, thrust, angles and bank follow. It then runs with six \
             degrees of freedom; deflections and thrust change as recorded, the wind is constant."
        }
        Constants::Refit => {
            "Time histories: the model starts from the reconstructed state and runs with six degrees of freedom, driven by the inputs \
             named on the page. The constant of each coefficient is set for zero mean residual, so that they test derivatives alone."
        }
    }
}

fn results(found: &Qualification) -> Table {
    let columns = [("id", "Test"), ("title", "Title"), ("window", "Manoeuvre"), ("kind", "Kind"), ("result", "Result")];
    let rows = found.tests.iter().map(|test| {
        let window = test.window.as_deref().unwrap_or("none");
        [test.id.as_str(), &test.title, window, test.kind, test.outcome.label()].map(Cell::text).into()
    });
    Table {
        name: "results".to_owned(),
        caption: format!("Tests of this guide and their results on {}.", found.date),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: rows.collect(),
    }
}

/// The box to sign: the automatic test, and a line for the manual one on a device.
fn result_box(test: &QualificationTest, date: &str) -> Table {
    let columns = [
        ("test", "Test"),
        ("result", "Result"),
        ("date", "Date"),
        ("evaluated", "Evaluated by"),
        ("approved", "Approved by"),
    ];
    let blank = || Cell::text("\u{a0}".repeat(24));
    let automatic = [format!("{} automatic", test.id), test.outcome.label().to_owned(), date.to_owned()];
    let manual = [format!("{} manual, on the device", test.id), "not run".to_owned(), String::new()];
    let rows = [automatic, manual].map(|row| row.map(Cell::text).into_iter().chain([blank(), blank()]).collect());
    Table {
        name: "result_box".to_owned(),
        caption: "Result.".to_owned(),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: rows.into(),
    }
}

fn page(test: &QualificationTest, date: &str) -> Section {
    let mut blocks = vec![Block::Outcome(test.level(), format!("{}: {}", test.outcome.label(), test.reason))];
    blocks.extend(test.window.is_some().then(|| Block::Table(result_box(test, date))));
    blocks.push(Block::Facts(test.page.facts.clone()));
    if !test.page.initial.is_empty() {
        blocks.push(Block::Heading("Initial conditions".to_owned()));
        blocks.push(Block::Facts(test.page.initial.clone()));
    }
    if !test.channels.is_empty() || !test.values.is_empty() {
        blocks.push(Block::Heading("Tolerances and result".to_owned()));
    }
    blocks.extend((!test.channels.is_empty()).then(|| Block::Table(bands(test))));
    let values = "Numbers of flight and model. One number of each requirement must be inside.";
    blocks.extend((!test.values.is_empty()).then(|| Block::Table(numbers("values", values, &test.values))));
    let oscillation = "Free response after the input, for information: no tolerance applies.";
    blocks.extend(
        (!test.oscillation.is_empty()).then(|| Block::Table(numbers("oscillation", oscillation, &test.oscillation))),
    );
    blocks.extend(test.page.figure.clone().map(Block::Figure));
    Section {
        name: test.section(),
        title: format!("{} {}", test.id, test.title),
        is_numbered: false,
        on_new_page: false,
        is_appendix: false,
        blocks,
    }
}

fn bands(test: &QualificationTest) -> Table {
    let columns = [
        ("requirement", "Requirement"),
        ("parameter", "Parameter"),
        ("tolerance", "Tolerance"),
        ("worst", "Worst model less flight"),
        ("at", "At"),
        ("used", "Band used"),
        ("inside", "Inside"),
        ("result", "Result"),
    ];
    let rows = test.channels.iter().map(|row| {
        let result = if row.passed { "inside" } else { "outside" };
        vec![
            Cell::Count(row.requirement),
            Cell::text(named(row.parameter)),
            Cell::text(&row.tolerance),
            Cell::text(shown(row.worst, dimension_of(row.parameter))),
            Cell::text(format!("{:.2} s", row.worst_time_s)),
            Cell::text(format!("{:.0} %", 100.0 * row.worst_ratio)),
            Cell::text(format!("{:.1} %", 100.0 * row.share_inside)),
            Cell::text(result),
        ]
    });
    Table {
        name: "bands".to_owned(),
        caption: "Bands over the record. One band of each requirement must hold throughout.".to_owned(),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: rows.collect(),
    }
}

fn numbers(name: &str, caption: &str, values: &[ValueRow]) -> Table {
    let judged = values.iter().any(|row| row.requirement > 0);
    let all = [
        ("requirement", "Requirement"),
        ("parameter", "Parameter"),
        ("tolerance", "Tolerance"),
        ("flight", "In flight"),
        ("model", "By the model"),
        ("difference", "Model less flight"),
        ("result", "Result"),
    ];
    let rows = values.iter().map(|row| {
        let dimension = dimension_of(&row.parameter);
        let number = |value: Option<f64>, error: Option<f64>| match (value, error) {
            (Some(value), Some(error)) => with_error(value, error, dimension),
            (value, _) => value
                .filter(|value| value.is_finite())
                .map_or(NOT_GIVEN.to_owned(), |value| shown_as(value, &row.parameter)),
        };
        let difference = row.flight.zip(row.model).map(|(flight, model)| model - flight);
        let result = match row.passed {
            Some(true) => "inside",
            Some(false) => "outside",
            None => NOT_GIVEN,
        };
        vec![
            Cell::Count(row.requirement),
            Cell::text(named(&row.parameter)),
            Cell::text(&row.tolerance),
            Cell::text(number(row.flight, row.flight_error)),
            Cell::text(number(row.model, row.model_error)),
            Cell::text(number(difference, None)),
            Cell::text(result),
        ]
    });
    let table = Table {
        name: name.to_owned(),
        caption: caption.to_owned(),
        columns: all.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: rows.collect(),
    };
    if judged { table } else { table.select(&["parameter", "flight", "model", "difference"]) }
}
