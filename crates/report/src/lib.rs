//! Reports: the contents of [`doublet_engine::report::document`] as self-contained HTML and as PDF.
//!
//! A crate of its own, because the typesetter takes longer to build than everything else.

mod html;
#[cfg(feature = "pdf")]
mod library;
#[cfg(feature = "pdf")]
mod pdf;
pub mod svg;

use std::path::{Path, PathBuf};

use doublet_engine::keep::{Earlier, Put, Staging};
use doublet_engine::prior::PriorStudy;
use doublet_engine::report as results;
use doublet_engine::report::document::{self, Document, SectionKind, Style};
#[cfg(feature = "pdf")]
use doublet_engine::report::document::{Block, Figure};
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::Session;

pub use html::html;
#[cfg(feature = "pdf")]
pub use pdf::{Page, pages, pdf};

/// The program with the commit it was built from, as every document states it.
pub const PROGRAM: &str = concat!("doublet ", env!("CARGO_PKG_VERSION"), " (", env!("DOUBLET_BUILD"), ")");
/// The commit of the source, ten digits of it.
pub const COMMIT: &str = env!("DOUBLET_COMMIT");

/// A page as it is printed.
#[cfg(not(feature = "pdf"))]
#[derive(Clone, Debug)]
pub struct Page {
    /// Width and height, points of 1/72 inch.
    pub size_pt: [f32; 2],
    /// The drawing as SVG.
    pub svg: String,
}

/// Says that this build has no typesetter.
#[cfg(not(feature = "pdf"))]
pub fn pages(_: &Document, _: &Control, _: &dyn Fn(f32)) -> Result<Vec<Page>, String> {
    Err("this build of doublet has no typesetter: build it with the feature pdf to see pages".to_owned())
}

/// Says that this build has no typesetter.
#[cfg(not(feature = "pdf"))]
pub fn pdf(_: &Document, _: &Control, _: &dyn Fn(f32)) -> Result<Vec<u8>, String> {
    Err("this build of doublet cannot write PDF: build it with the feature pdf, or use html".to_owned())
}

/// A form of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportFormat {
    /// One file that needs no other.
    Html,
    /// A4 pages.
    Pdf,
}

impl ReportFormat {
    /// Whether this build of the program writes it.
    pub fn is_in_this_build(self) -> bool {
        self == Self::Html || cfg!(feature = "pdf")
    }

    doublet_core::named_variants! {
        /// Name on the command line, and the ending of the file.
        pub name: Html "html", Pdf "pdf"
    }
}

/// What a report is to hold and where it goes.
#[derive(Clone, Debug, Default)]
pub struct Order {
    /// Folder; made where it does not exist.
    pub folder: PathBuf,
    /// Name of the files, without ending.
    pub name: String,
    /// Forms.
    pub formats: Vec<ReportFormat>,
    pub sections: Vec<SectionKind>,
    /// Whether the appendices are left out.
    pub without_appendix: bool,
    /// The flight beside an earlier estimate.
    pub prior: Option<PriorStudy>,
    /// House style.
    pub style: Style,
}

/// Writes the report on a run, all forms of it in one step; what else the folder holds stays. `progress` is told the part done, 0 to 1.
pub fn write(
    session: &Session,
    snapshot: &Snapshot,
    order: &Order,
    control: &Control,
    progress: &dyn Fn(f32),
) -> Result<Put, String> {
    let checkpoint = || control.checkpoint().map_err(|_| "cancelled: no report was written".to_owned());
    let document = assemble(session, snapshot, order);
    progress(0.1);
    checkpoint()?;
    let inner = |part: f32| progress(0.1 + 0.9 * part);
    let set = DocumentSet { folder: &order.folder, name: &order.name, formats: &order.formats, beside: &[] };
    set.write(&document, &format!("report {}", order.name), control, &inner)
}

/// What the report on a run contains.
pub fn assemble(session: &Session, snapshot: &Snapshot, order: &Order) -> Document {
    let found = results::Results { app: PROGRAM.to_owned(), ..results::build(session, snapshot) };
    let mut document = document::build(session, snapshot, &found, &order.sections, order.prior.as_ref());
    if order.without_appendix {
        document.drop_appendices();
    }
    document.sections.splice(0..0, document::chosen(session));
    order.style.apply(&mut document);
    document
}

/// Where a document goes, in which forms, and what lies beside it.
#[derive(Clone, Copy, Debug)]
pub struct DocumentSet<'a> {
    /// Folder; made where it does not exist.
    pub folder: &'a Path,
    /// Name of the files of the document, without ending.
    pub name: &'a str,
    /// Forms.
    pub formats: &'a [ReportFormat],
    /// Further files: name and contents.
    pub beside: &'a [(String, Vec<u8>)],
}

impl DocumentSet<'_> {
    /// Writes the document and what lies beside it in one step as the set called `set`; what else the folder holds stays. `progress` is
    /// told the part done, 0 to 1.
    pub fn write(
        &self,
        document: &Document,
        set: &str,
        control: &Control,
        progress: &dyn Fn(f32),
    ) -> Result<Put, String> {
        let staging = Staging::new(self.folder).map_err(|error| error.to_string())?;
        let put = |name: &str, contents: &[u8]| {
            std::fs::write(staging.path().join(name), contents)
                .map_err(|error| format!("{}: {error}", self.folder.join(name).display()))
        };
        for (index, &format) in self.formats.iter().enumerate() {
            let share = 1.0 / self.formats.len() as f32;
            let inner = |part: f32| progress(share * (index as f32 + part));
            let contents = match format {
                ReportFormat::Html => html(document).into_bytes(),
                ReportFormat::Pdf => pdf(document, control, &inner)?,
            };
            control.checkpoint().map_err(|_| "cancelled: no report was written".to_owned())?;
            put(&format!("{}.{}", self.name, format.name()), &contents)?;
            inner(1.0);
        }
        self.beside.iter().try_for_each(|(name, contents)| put(name, contents))?;
        staging.put(set, Earlier::Kept, &is_report).map_err(|error| error.to_string())
    }
}

/// Whether a file is a report of a version that kept no list of its files: it names the program that made it.
fn is_report(path: &Path) -> bool {
    let contains = |bytes: Vec<u8>| bytes.windows(MAKER.len()).any(|part| part == MAKER);
    std::fs::read(path).is_ok_and(contains)
}

/// Start of the name of the program in the forms' own data.
const MAKER: &[u8] = b"doublet ";

/// Figures of a document in their order.
#[cfg(feature = "pdf")]
fn figures(document: &Document) -> impl Iterator<Item = &Figure> {
    let blocks = document.cover.iter().chain(document.sections.iter().flat_map(|section| &section.blocks));
    blocks.filter_map(|block| if let Block::Figure(figure) = block { Some(figure) } else { None })
}
