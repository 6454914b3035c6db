//! The contents of a report as data: sections of paragraphs, tables and figures, the same for every form it is written in.

mod bode;
mod checks;
mod cover;
mod derivatives;
mod display;
mod dynamics;
mod figure;
mod findings;
mod fits;
mod path;
mod proof;
mod responses;
mod sensitivity;
mod setup;

pub use bode::{BodeModel, bode_figure};
pub use figure::{Axis, Colour, DRAWN_COLUMNS, Figure, LineStyle, Mark, Matrix, Panel, Plot};
pub(crate) use figure::{line, points};
pub(crate) use proof::replay_panel;
pub use responses::surface_figure;

use std::collections::BTreeSet;

use super::results::{Results, WindowRow};
use super::table::Table;
use crate::run::Snapshot;
use crate::session::Session;
use crate::study::{DynamicsRequest, Study};
use crate::verdict::Level;

/// A report.
#[derive(Clone, Debug)]
pub struct Document {
    /// Title of the session.
    pub title: String,
    /// Aircraft.
    pub subtitle: String,
    /// Program and its version.
    pub app: String,
    /// Day it was made, `YYYY-MM-DD`.
    pub date: String,
    /// What stands at the foot of every page; empty for nothing.
    pub notice: String,
    /// What stands on the first page, above the signatures.
    pub cover: Vec<Block>,
    /// Who signs the first page.
    pub signatures: Vec<String>,
    /// Sections that were asked for.
    pub sections: Vec<Section>,
}

/// One section.
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
    /// What it holds, in order.
    pub blocks: Vec<Block>,
}

impl Section {
    /// A section without a number.
    pub fn plain(name: &str, title: &str, on_new_page: bool, blocks: Vec<Block>) -> Self {
        Self { name: name.to_owned(), title: title.to_owned(), is_numbered: false, on_new_page, blocks }
    }
}

/// A part of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Heading of a part.
    Heading(String),
    /// A paragraph.
    Paragraph(String),
    /// Short answers to short questions.
    Facts(Vec<(String, String)>),
    /// Lines, each of its own.
    List(Vec<String>),
    /// What came out, in one line, and how good that is.
    Outcome(Level, String),
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// So many empty lines, to be written on by hand.
    Lines(usize),
}

/// The sections there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SectionKind {
    /// What was analysed, with what, by which program.
    Overview,
    /// Reference geometry, loading, mass properties.
    Aircraft,
    /// Channels by role, and clocks.
    Channels,
    /// Manoeuvre windows.
    Windows,
    /// Settings of the filter and its consistency.
    Filter,
    /// Wind and biases.
    WindAndBias,
    /// Innovations.
    Innovations,
    /// Structure of the model and correlation of its parameters.
    Model,
    /// Derivatives.
    Derivatives,
    /// Fits and residuals of every manoeuvre.
    Fits,
    /// Prediction of the validation windows.
    Validation,
    /// Validation windows flown again by the model.
    Match,
    /// Windows again by output error.
    Checks,
    /// Derivatives against what they were computed with.
    Sensitivity,
    /// Frequency responses and low-order equivalent systems.
    Responses,
    /// Linear model, modes and levels of flying qualities.
    Dynamics,
    /// Modelled engines against their monitors.
    Engines,
    /// Everything found on the way.
    Warnings,
}

impl SectionKind {
    /// All of them, in their order.
    pub const ALL: [Self; 18] = [
        Self::Overview,
        Self::Aircraft,
        Self::Channels,
        Self::Windows,
        Self::Filter,
        Self::WindAndBias,
        Self::Innovations,
        Self::Model,
        Self::Derivatives,
        Self::Fits,
        Self::Validation,
        Self::Match,
        Self::Checks,
        Self::Sensitivity,
        Self::Responses,
        Self::Dynamics,
        Self::Engines,
        Self::Warnings,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Overview => "overview",
            Self::Aircraft => "aircraft",
            Self::Channels => "channels",
            Self::Windows => "windows",
            Self::Filter => "filter",
            Self::WindAndBias => "wind-and-bias",
            Self::Innovations => "innovations",
            Self::Model => "model",
            Self::Derivatives => "derivatives",
            Self::Fits => "fits",
            Self::Validation => "validation",
            Self::Match => "match",
            Self::Checks => "checks",
            Self::Sensitivity => "sensitivity",
            Self::Responses => "responses",
            Self::Dynamics => "dynamics",
            Self::Engines => "engines",
            Self::Warnings => "warnings",
        }
    }

    /// The study it shows, which takes longer than the rest and has to be asked for.
    pub fn study(self) -> Option<Study> {
        match self {
            Self::Checks => Some(Study::Checks { axis: None }),
            Self::Sensitivity => Some(Study::Sensitivity),
            Self::Responses => Some(Study::Responses),
            Self::Dynamics => Some(Study::Dynamics(DynamicsRequest::default())),
            _ => None,
        }
    }

    /// Heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Overview => "Overview",
            Self::Aircraft => "Aircraft and loading",
            Self::Channels => "Channels and clocks",
            Self::Windows => "Manoeuvres",
            Self::Filter => "Filter settings and consistency",
            Self::WindAndBias => "Wind and biases",
            Self::Innovations => "Innovations",
            Self::Model => "Model structure and correlation",
            Self::Derivatives => "Aerodynamic and control derivatives",
            Self::Fits => "Fits and residuals",
            Self::Validation => "Validation",
            Self::Match => "Proof of match",
            Self::Checks => "Independent checks",
            Self::Sensitivity => "Sensitivity",
            Self::Responses => "Frequency responses",
            Self::Dynamics => "Linear model, modes and flying qualities",
            Self::Engines => "Engines",
            Self::Warnings => "Findings",
        }
    }
}

/// The report on a run: the numbers of `results`, the histories of `snapshot`.
pub fn build(session: &Session, snapshot: &Snapshot, results: &Results, sections: &[SectionKind]) -> Document {
    let contents = Contents { session, snapshot, results };
    let wanted = SectionKind::ALL.into_iter().filter(|kind| sections.contains(kind));
    let sections = wanted.map(|kind| {
        let blocks = match kind {
            SectionKind::Overview => setup::overview(&contents),
            SectionKind::Aircraft => setup::aircraft(&contents),
            SectionKind::Channels => setup::channels(&contents),
            SectionKind::Windows => setup::windows(&contents),
            SectionKind::Filter => path::filter(&contents),
            SectionKind::WindAndBias => path::wind_and_bias(&contents),
            SectionKind::Innovations => path::innovations(&contents),
            SectionKind::Model => derivatives::model(&contents),
            SectionKind::Derivatives => derivatives::derivatives(&contents),
            SectionKind::Fits => fits::fits(&contents),
            SectionKind::Validation => fits::validation(&contents),
            SectionKind::Match => proof::proof_of_match(&contents),
            SectionKind::Checks => checks::checks(&contents),
            SectionKind::Sensitivity => sensitivity::sensitivity(&contents),
            SectionKind::Responses => responses::responses(&contents),
            SectionKind::Dynamics => dynamics::dynamics(&contents),
            SectionKind::Engines => setup::engines(&contents),
            SectionKind::Warnings => findings::warnings(&contents),
        };
        Section {
            name: kind.name().to_owned(),
            title: kind.title().to_owned(),
            is_numbered: true,
            on_new_page: false,
            blocks: blocks.into_iter().map(display::shown).collect(),
        }
    });
    Document {
        date: crate::date::today(),
        notice: String::new(),
        cover: cover::cover(&contents),
        signatures: ["Prepared", "Checked", "Approved"].map(str::to_owned).into(),
        title: if session.title.is_empty() { "Flight test report".to_owned() } else { session.title.clone() },
        subtitle: results.aircraft.clone(),
        app: results.app.clone(),
        sections: sections.collect(),
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
    (!blocks.is_empty()).then_some(Section { name, title, is_numbered: true, on_new_page: false, blocks })
}

/// What sections are made from.
struct Contents<'a> {
    session: &'a Session,
    snapshot: &'a Snapshot,
    results: &'a Results,
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

/// A paragraph.
fn paragraph(text: &str) -> Block {
    Block::Paragraph(text.to_owned())
}

/// A table, or a line that says why there is none.
fn table_or(table: Table, missing: &str) -> Block {
    if table.rows.is_empty() { paragraph(missing) } else { Block::Table(table) }
}
