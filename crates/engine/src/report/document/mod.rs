//! The contents of a report as data: sections of paragraphs, tables and figures, the same for every form it is written in.

mod bode;
mod checks;
mod conclusions;
mod condition;
mod conditions;
mod cover;
mod derivatives;
mod display;
mod dynamics;
mod experiments;
mod figure;
mod findings;
mod fits;
mod instrumentation;
mod kinds;
mod level_map;
mod mass;
mod path;
mod prior;
mod proof;
mod purpose;
mod responses;
mod sensitivity;
mod setup;
mod style;
mod tracks;

pub use bode::{BodeModel, bode_figure};
pub use figure::{Axis, Colour, DRAWN_COLUMNS, Figure, LineStyle, Mark, Matrix, Panel, Plot};
pub(crate) use figure::{line, points};
pub use kinds::SectionKind;
pub use level_map::level_map;
pub(crate) use proof::replay_panel;
pub use responses::surface_figure;
pub use sensitivity::{sensitivity_tables, widest_table};
pub use style::{Logo, Style, UnitSystem};

use std::collections::BTreeSet;

use super::results::{Results, WindowRow};
use super::table::Table;
use crate::prior::PriorStudy;
use crate::session::{Level, Session};
use crate::snapshot::Snapshot;

/// A report.
#[derive(Clone, Debug, Default)]
pub struct Document {
    pub title: String,
    /// Aircraft.
    pub subtitle: String,
    /// Day it was made, `YYYY-MM-DD`.
    pub date: String,
    /// What stands at the foot of every page; empty for nothing.
    pub notice: String,
    /// What stands on the first page, above the signatures.
    pub cover: Vec<Block>,
    /// Who signs the first page.
    pub signatures: Vec<String>,
    /// How it looks.
    pub style: Style,
    /// Sections that were asked for.
    pub sections: Vec<Section>,
}

impl Document {
    /// What is before each heading: the number of a section, the letter of an appendix, nothing before a plain one.
    pub fn numbers(&self) -> Vec<String> {
        let (mut sections, mut appendices) = (0, 0);
        let number = |section: &Section| {
            if !section.is_appendix {
                sections += 1;
                return if section.is_numbered { sections.to_string() } else { String::new() };
            }
            appendices += 1;
            letters(appendices)
        };
        self.sections.iter().map(number).collect()
    }

    /// Leaves the appendices out.
    pub fn drop_appendices(&mut self) {
        self.sections.retain(|section| !section.is_appendix);
    }
}

/// A, B, ... Z, AA, AB, ...
fn letters(mut place: usize) -> String {
    let mut found = Vec::new();
    while place > 0 {
        found.push(char::from(b'A' + ((place - 1) % 26) as u8));
        place = (place - 1) / 26;
    }
    found.iter().rev().collect()
}

#[derive(Clone, Debug)]
pub struct Section {
    /// Name, unique in the document, for links.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Whether it has a number before its heading.
    pub is_numbered: bool,
    /// Whether it begins a page.
    pub on_new_page: bool,
    /// Whether it is an appendix: a letter instead of a number.
    pub is_appendix: bool,
    /// What it holds, in order.
    pub blocks: Vec<Block>,
}

impl Section {
    /// A section without a number.
    pub fn plain(name: &str, title: &str, on_new_page: bool, blocks: Vec<Block>) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            is_numbered: false,
            on_new_page,
            is_appendix: false,
            blocks,
        }
    }
}

/// A part of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Heading of a part.
    Heading(String),
    Paragraph(String),
    /// Short answers to short questions.
    Facts(Vec<(String, String)>),
    /// Lines, each of its own.
    List(Vec<String>),
    /// What came out, in one line, and how good that is.
    Outcome(Level, String),
    Table(Table),
    Figure(Figure),
    /// So many empty lines, to be written on by hand.
    Lines(usize),
}

/// A part of the report: what its reader needs, and the long tables and histories behind it.
#[derive(Default)]
struct Parts {
    body: Vec<Block>,
    appendix: Vec<Block>,
}

impl From<Vec<Block>> for Parts {
    fn from(body: Vec<Block>) -> Self {
        Self { body, appendix: Vec::new() }
    }
}

/// The report on a run: the numbers of `results`, the histories of `snapshot`. Sections are in the order asked for, those without contents
/// left out.
pub fn build(
    session: &Session,
    snapshot: &Snapshot,
    results: &Results,
    sections: &[SectionKind],
    prior: Option<&PriorStudy>,
) -> Document {
    let contents = Contents { session, snapshot, results, prior };
    let mut wanted: Vec<SectionKind> = Vec::new();
    for kind in sections {
        if !wanted.contains(kind) {
            wanted.push(*kind);
        }
    }
    let (mut body, mut appendices) = (Vec::new(), Vec::new());
    for kind in wanted {
        let parts = parts(kind, &contents);
        body.extend(section(kind, parts.body, false));
        appendices.extend(section(kind, parts.appendix, true));
    }
    body.extend(appendices);
    Document {
        date: crate::date::today(),
        cover: cover::cover(&contents).into_iter().map(display::shown).collect(),
        signatures: ["Prepared", "Checked", "Approved"].map(str::to_owned).into(),
        title: if session.title.is_empty() { "Flight test report".to_owned() } else { session.title.clone() },
        subtitle: results.aircraft.clone(),
        sections: body,
        ..Document::default()
    }
}

/// A section of the body or the appendix; none without contents.
fn section(kind: SectionKind, blocks: Vec<Block>, is_appendix: bool) -> Option<Section> {
    let named = |name: &str| if is_appendix { format!("appendix-{name}") } else { name.to_owned() };
    (!blocks.is_empty()).then(|| Section {
        name: named(kind.name()),
        title: if is_appendix { kind.appendix_title() } else { kind.title() }.to_owned(),
        is_numbered: true,
        on_new_page: false,
        is_appendix,
        blocks: blocks.into_iter().map(display::shown).collect(),
    })
}

fn parts(kind: SectionKind, contents: &Contents<'_>) -> Parts {
    match kind {
        SectionKind::Purpose => purpose::purpose(contents).into(),
        SectionKind::Overview => setup::overview(contents),
        SectionKind::Aircraft => setup::aircraft(contents),
        SectionKind::Channels => instrumentation::channels(contents),
        SectionKind::Windows => setup::windows(contents),
        SectionKind::Filter => path::filter(contents),
        SectionKind::Path => tracks::tracks(contents),
        SectionKind::WindAndBias => path::wind_and_bias(contents).into(),
        SectionKind::Innovations => path::innovations(contents),
        SectionKind::Model => derivatives::model(contents).into(),
        SectionKind::Derivatives => derivatives::derivatives(contents),
        SectionKind::Fits => fits::fits(contents),
        SectionKind::Validation => fits::validation(contents),
        SectionKind::Match => proof::proof_of_match(contents),
        SectionKind::Prior => contents.prior.map(PriorStudy::blocks).unwrap_or_default().into(),
        SectionKind::Checks => checks::checks(contents),
        SectionKind::Experiments => experiments::experiments(contents),
        SectionKind::Sensitivity => sensitivity::sensitivity(contents),
        SectionKind::Condition => condition::condition(contents),
        SectionKind::Responses => responses::responses(contents),
        SectionKind::Dynamics => dynamics::dynamics(contents),
        SectionKind::Engines => setup::engines(contents),
        SectionKind::Conclusions => conclusions::conclusions(contents).into(),
        SectionKind::Warnings => findings::warnings(contents),
    }
}

/// Notes of the author and figures of their choice; none without either.
pub fn chosen(session: &Session) -> Option<Section> {
    let notes = session.report_notes.lines().filter(|line| !line.trim().is_empty()).map(paragraph);
    let figures = session.report_figures.iter().enumerate().map(|(at, chosen)| match chosen.figure() {
        // The name is unique in the document, whatever else is drawn.
        Ok(figure) => Block::Figure(Figure { name: format!("chosen_{}_{}", at + 1, figure.name), ..figure }),
        Err(line) => paragraph(&format!("{}: {line}", chosen.caption)),
    });
    let blocks: Vec<Block> = notes.chain(figures).map(display::shown).collect();
    let (name, title) = ("chosen".to_owned(), "Notes and chosen figures".to_owned());
    (!blocks.is_empty()).then_some(Section {
        name,
        title,
        is_numbered: true,
        on_new_page: false,
        is_appendix: false,
        blocks,
    })
}

/// What sections are made from.
struct Contents<'a> {
    session: &'a Session,
    snapshot: &'a Snapshot,
    results: &'a Results,
    prior: Option<&'a PriorStudy>,
}

/// Number of each window in figures: the one its name begins with where all begin with a different one, else its place in the table
/// of windows.
fn numbers_of(windows: &[WindowRow]) -> Vec<f64> {
    let own = |window: &WindowRow| window.name.split_whitespace().next()?.parse::<u16>().ok();
    let own: Option<Vec<u16>> = windows.iter().map(own).collect();
    match own.filter(|own| own.iter().collect::<BTreeSet<_>>().len() == own.len()) {
        Some(own) => own.into_iter().map(f64::from).collect(),
        None => (1..=windows.len()).map(|place| place as f64).collect(),
    }
}

fn paragraph(text: &str) -> Block {
    Block::Paragraph(text.to_owned())
}

/// A table, or a line that says why there is none.
fn table_or(table: Table, missing: &str) -> Block {
    if table.rows.is_empty() { paragraph(missing) } else { Block::Table(table) }
}
