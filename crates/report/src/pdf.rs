//! A report as PDF or as drawings of its pages: a fixed Typst source that reads the contents as JSON and the figures as SVG, all from memory.

use std::collections::HashMap;
use std::sync::LazyLock;

use doublet_engine::builtin;
use doublet_engine::notation::{self, is_direction_mark};
use doublet_engine::report::document::{Block, Document, Logo, Section};
use doublet_engine::report::{Cell, Table, alignments};
use doublet_engine::run::Control;
use serde_json::{Value, json};
use typst::diag::{FileError, FileResult, SourceDiagnostic};
use typst::foundations::{Bytes, Datetime, Duration, Smart};
use typst::syntax::{FileId, RootedPath, Source, VirtualPath, VirtualRoot};
use typst::text::{Font, FontBook};
use typst::utils::LazyHash;
use typst::{Library, World};
use typst_layout::PagedDocument;
use typst_pdf::PdfOptions;
use typst_svg::SvgOptions;

use crate::library::library;
use crate::svg::svg;
use crate::{PROGRAM, figures};

/// The typeset source.
const TEMPLATE: &str = include_str!("report.typ");
/// Fonts of the text, and of the figures and what the text's lack.
const FONT_FILES: [&str; 4] =
    ["LibertinusSerif-Regular.otf", "LibertinusSerif-Bold.otf", "LibertinusSerif-Italic.otf", "DejaVuSans.ttf"];

/// The whole file. The same contents give the same bytes.
pub fn pdf(document: &Document, control: &Control, progress: &dyn Fn(f32)) -> Result<Vec<u8>, String> {
    let pages = typeset(document, control, progress)?;
    // Tags of every cell and label would double the file; who needs the structure has the HTML.
    let options = PdfOptions { creator: Smart::Custom(Some(PROGRAM.into())), tagged: false, ..PdfOptions::default() };
    let bytes = typst_pdf::pdf(&pages, &options).map_err(|errors| failure(&errors))?;
    // What the typesetter remembers of this report would only help to set the same one again.
    typst::comemo::evict(0);
    Ok(bytes)
}

/// A page as it is printed.
#[derive(Clone, Debug)]
pub struct Page {
    /// Width and height, points of 1/72 inch.
    pub size_pt: [f32; 2],
    /// The drawing as SVG.
    pub svg: String,
}

/// The same pages as drawings.
pub fn pages(document: &Document, control: &Control, progress: &dyn Fn(f32)) -> Result<Vec<Page>, String> {
    let typeset = typeset(document, control, progress)?;
    let pages = typeset.pages().iter().map(draw_page).collect();
    typst::comemo::evict(0);
    Ok(pages)
}

fn draw_page(page: &typst_layout::Page) -> Page {
    let size = page.frame.size();
    let size_pt = [size.x.to_pt() as f32, size.y.to_pt() as f32];
    Page { size_pt, svg: typst_svg::svg(page, &SvgOptions::default()) }
}

/// What the typesetter refuses, in one line.
fn failure(errors: &[SourceDiagnostic]) -> String {
    let lines: Vec<String> = errors.iter().map(|error| error.message.to_string()).collect();
    format!("the report cannot be typeset: {}", lines.join("; "))
}

fn typeset(document: &Document, control: &Control, progress: &dyn Fn(f32)) -> Result<PagedDocument, String> {
    let checkpoint = || control.checkpoint().map_err(|_| "cancelled: no report was written".to_owned());
    let mut world = Memory::new(TEMPLATE)?;
    let mut files = Vec::new();
    for (index, figure) in figures(document).enumerate() {
        checkpoint()?;
        files.push((figure_file(index), svg(figure, "c").into_bytes()));
    }
    if let Some(logo) = &document.style.logo {
        files.push((logo_file(logo), logo.bytes.clone()));
    }
    files.push(("report.json".to_owned(), contents(document).to_string().replace(is_direction_mark, "").into_bytes()));
    for (name, bytes) in files {
        world.files.insert(file_id(&name)?, Bytes::new(bytes));
    }
    progress(0.1);
    let pages = typst::compile(&world).output.map_err(|errors| failure(&errors))?;
    progress(0.7);
    checkpoint()?;
    Ok(pages)
}

/// File of the figure at a place in the document.
fn figure_file(index: usize) -> String {
    format!("figure-{index}.svg")
}

fn logo_file(logo: &Logo) -> String {
    format!("logo.{}", logo.ending)
}

/// The contents as the source reads them.
fn contents(document: &Document) -> Value {
    let mut figures = 0;
    let cover: Vec<Value> = document.cover.iter().map(|block| block_value(block, &mut figures)).collect();
    let numbered = document.sections.iter().zip(document.numbers());
    let sections: Vec<Value> =
        numbered.map(|(section, number)| section_value(section, &number, &mut figures)).collect();
    json!({
        "title": document.title,
        "subtitle": document.subtitle,
        "app": PROGRAM,
        "date": document.date,
        "notice": document.notice,
        "signatures": document.signatures,
        "header": document.style.header,
        "footer": document.style.footer,
        "accent": document.style.accent,
        "compact": document.style.is_compact,
        "logo": document.style.logo.as_ref().map(logo_file).unwrap_or_default(),
        "cover": cover,
        "sections": sections,
    })
}

fn section_value(section: &Section, number: &str, figures: &mut usize) -> Value {
    let blocks: Vec<Value> = section.blocks.iter().map(|block| block_value(block, figures)).collect();
    json!({
        "title": section.title,
        "number": number,
        "is_appendix": section.is_appendix,
        "on_new_page": section.on_new_page,
        "blocks": blocks,
    })
}

fn block_value(block: &Block, figures: &mut usize) -> Value {
    match block {
        Block::Heading(text) => json!({ "kind": "heading", "text": text }),
        Block::Paragraph(text) => json!({ "kind": "paragraph", "text": breakable(text) }),
        Block::Facts(facts) => {
            let facts: Vec<_> = facts.iter().map(|(name, text)| [name.clone(), breakable(text)]).collect();
            json!({ "kind": "facts", "facts": facts })
        }
        Block::List(lines) => {
            json!({ "kind": "list", "lines": lines.iter().map(|line| breakable(line)).collect::<Vec<_>>() })
        }
        Block::Outcome(level, text) => json!({ "kind": "outcome", "level": level.name(), "text": breakable(text) }),
        Block::Table(table) => table_value(table),
        Block::Lines(count) => json!({ "kind": "lines", "count": count }),
        Block::Figure(figure) => {
            let file = figure_file(*figures);
            *figures += 1;
            json!({ "kind": "figure", "file": file, "caption": figure.caption })
        }
    }
}

fn table_value(table: &Table) -> Value {
    let rows = table.rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns).map(|(cell, column)| match cell {
            Cell::Symbol(name) => {
                let (letter, subscript, suffix) = notation::derivative_parts(name);
                json!({ "letter": letter, "subscript": subscript, "suffix": suffix })
            }
            _ => Value::String(breakable(&cell.readable(column.digits))),
        });
        Value::Array(cells.collect())
    });
    json!({
        "kind": "table",
        "caption": table.caption,
        "columns": table.columns.iter().map(|column| column.title()).collect::<Vec<_>>(),
        "right": alignments(table).collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
    })
}

/// The text with places to break it within words longer than a line of a table holds.
fn breakable(text: &str) -> String {
    /// Longest part of a word that is kept whole.
    const LONGEST: usize = 16;
    let mut result = String::with_capacity(text.len());
    let mut run = 0;
    for character in text.chars() {
        run = if character.is_whitespace() { 0 } else { run + 1 };
        result.push(character);
        if run == LONGEST || (run > 4 && matches!(character, '/' | '_')) {
            result.push('\u{200b}');
            run = 0;
        }
    }
    result
}

fn file_id(name: &str) -> Result<FileId, String> {
    let path = VirtualPath::new(name).map_err(|_| format!("{name} is not a file name"))?;
    Ok(RootedPath::new(VirtualRoot::Project, path).intern())
}

/// Fonts of every report.
struct Fonts {
    book: LazyHash<FontBook>,
    fonts: Vec<Font>,
}

static FONTS: LazyLock<Fonts> = LazyLock::new(|| {
    let fonts: Vec<Font> =
        FONT_FILES.into_iter().flat_map(|name| Font::iter(Bytes::new(builtin::font(name)))).collect();
    Fonts { book: LazyHash::new(FontBook::from_fonts(&fonts)), fonts }
});

/// Everything the typesetter may see: one source, some files, some fonts; no disk, no network, no clock.
struct Memory {
    library: LazyHash<Library>,
    source: Source,
    files: HashMap<FileId, Bytes>,
}

impl Memory {
    fn new(source: &str) -> Result<Self, String> {
        Ok(Self {
            library: LazyHash::new(library()),
            source: Source::new(file_id("report.typ")?, source.to_owned()),
            files: HashMap::new(),
        })
    }
}

impl World for Memory {
    fn library(&self) -> &LazyHash<Library> {
        &self.library
    }

    fn book(&self) -> &LazyHash<FontBook> {
        &FONTS.book
    }

    fn main(&self) -> FileId {
        self.source.id()
    }

    fn source(&self, id: FileId) -> FileResult<Source> {
        if id == self.source.id() { Ok(self.source.clone()) } else { Err(FileError::NotSource) }
    }

    fn file(&self, id: FileId) -> FileResult<Bytes> {
        self.files.get(&id).cloned().ok_or(FileError::AccessDenied)
    }

    fn font(&self, index: usize) -> Option<Font> {
        FONTS.fonts.get(index).cloned()
    }

    fn today(&self, _: Option<Duration>) -> Option<Datetime> {
        None
    }
}
