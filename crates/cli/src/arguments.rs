//! Arguments of reports, and numbers as arguments.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use doublet_engine::report::document::SectionKind;
use doublet_report::ReportFormat;

use crate::dynamics::JudgedArguments;
use crate::output_path::output_path;

/// Forms of a report that this build writes.
pub const REPORTS: &str = if cfg!(feature = "pdf") { "html,pdf" } else { "html" };

#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the report, named after the session file.
    #[arg(long, default_value = ".", value_parser = output_path())]
    pub out: PathBuf,
    /// Formats.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = REPORTS, value_parser = report_format())]
    pub format: Vec<String>,
    /// Sections in their order [default: all].
    #[arg(long, value_name = "SECTION,SECTION", value_delimiter = ',', value_parser = section())]
    pub sections: Vec<String>,
    /// House style: logo, header, footer, colour, units, sections, signatures.
    #[arg(long, value_name = "FILE")]
    pub style: Option<PathBuf>,
    /// Leave out the appendices.
    #[arg(long)]
    pub no_appendix: bool,
    /// Earlier estimate to compare with, as for `prior`.
    #[arg(long, value_name = "FILE")]
    pub prior: Option<PathBuf>,
    /// Class, category and controls, as for `qualities`.
    #[command(flatten)]
    pub judged: JudgedArguments,
}

pub fn report_format() -> PossibleValuesParser {
    ReportFormat::ALL.map(ReportFormat::name).into()
}

/// Names of report sections.
fn section() -> PossibleValuesParser {
    SectionKind::ALL.map(SectionKind::name).into()
}

/// A number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| format!("'{text}' must be a number above zero"))
}

/// A number from zero up.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| format!("'{text}' must be a number, zero or more"))
}
