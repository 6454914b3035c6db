//! The identified model as files other programs take: JSBSim and DAVE-ML with the points they are checked at, linear models.

mod checks;
mod daveml;
mod daveml_reader;
mod fmu;
mod jsbsim;
mod linear;
mod model;
mod xml;

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::date;
use crate::keep::{Earlier, Put, PutError, Staging};

pub use crate::study::{IdentifiedCoefficient, Parameter};
pub use daveml_reader::{CheckResult, DaveMl, DaveMlError};
pub use fmu::{LIBRARY_VARIABLE, write_fmu};
pub use linear::{LinearFormat, linear_json, write_linear};
pub use model::{IdentifiedModel, Ranges};

/// A form the model can leave in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// JSBSim: an `aerodynamics` file and a minimal aircraft around it.
    JsbSim,
    /// DAVE-ML 2.0 (ANSI/AIAA S-119) with check cases.
    DaveMl,
}

impl Format {
    doublet_core::named_variants! {
        /// Name on the command line.
        pub name: JsbSim "jsbsim", DaveMl "daveml"
    }
}

/// Why the model cannot leave the program.
#[derive(Debug, Error)]
pub enum ExportError {
    /// There is no model, or not a whole one.
    #[error("{0}")]
    NoModel(String),
    /// A term the format has no counterpart for.
    #[error("{format} cannot express '{term}' of {coefficient}: {reason}")]
    Term { format: &'static str, term: String, coefficient: &'static str, reason: &'static str },
    /// The files could not be put in place.
    #[error(transparent)]
    Put(#[from] PutError),
    /// A file could not be written.
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
    #[error("{path}: linear models are written as .mat, .json or .csv: give one of these endings")]
    Ending { path: String },
    /// XML could not be formed.
    #[error("XML: {0}")]
    Xml(String),
    /// A written file does not give its own check points.
    #[error("{path}: {reason}; nothing was written")]
    Check { path: String, reason: String },
}

/// Mark of every file written here, looked for before one is replaced.
const MARK: &str = "written by doublet";
/// Difference at which a written file counts as wrong, as a part of the sum of its terms' magnitudes, at least of 1.
const CHECK_TOLERANCE: f64 = 1e-12;

/// Writes `model` into `folder` in the given formats and returns the files: `NAME/NAME.xml` and
/// `NAME/NAME_aerodynamics.xml` for JSBSim (`folder` is then an aircraft path of JSBSim), `NAME.dml` for DAVE-ML, and
/// `NAME_check_points.csv` beside them, all in one step. A DAVE-ML file is read back and must give its own check cases before anything
/// is written. Files of an earlier export are replaced; others never are.
///
/// # Errors
/// [`ExportError`]; nothing is written when a format refuses a term.
pub fn write(model: &IdentifiedModel, formats: &[Format], folder: &Path) -> Result<Put, ExportError> {
    let name = &model.name;
    let date = date::today();
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for format in formats {
        match format {
            Format::JsbSim => {
                let aircraft = PathBuf::from(name);
                files.push((aircraft.join(format!("{name}_aerodynamics.xml")), jsbsim::aerodynamics(model)?));
                files.push((aircraft.join(format!("{name}.xml")), jsbsim::aircraft(model, &date)?));
            }
            Format::DaveMl => {
                let path = format!("{name}.dml");
                let text = daveml::write(model, &date)?;
                verify(&folder.join(&path), &text)?;
                files.push((path.into(), text));
            }
        }
    }
    files.push((format!("{name}_check_points.csv").into(), checks::table(model)));
    let staging = Staging::new(folder)?;
    for (name, text) in &files {
        let path = staging.path().join(name);
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| std::fs::write(&path, text));
        written.map_err(|source| ExportError::File { path: folder.join(name).display().to_string(), source })?;
    }
    // Files of a version that kept no list of them are known by their mark.
    let is_marked = |path: &Path| std::fs::read_to_string(path).is_ok_and(|text| text.contains(MARK));
    Ok(staging.put(&format!("model {name}"), Earlier::Kept, &is_marked)?)
}

/// Reads a DAVE-ML file back and evaluates its check cases.
fn verify(path: &Path, text: &str) -> Result<(), ExportError> {
    let wrong = |reason: String| ExportError::Check { path: path.display().to_string(), reason };
    let read = DaveMl::parse(text).map_err(|error| wrong(error.to_string()))?;
    let results = read.check().map_err(|error| wrong(error.to_string()))?;
    match results.iter().find(|result| !result.passed()) {
        Some(result) => Err(wrong(format!(
            "check case '{}': {} is {:e}, not {:e}",
            result.case, result.signal, result.found, result.expected
        ))),
        None if results.is_empty() => Err(wrong("it has no check cases".to_owned())),
        None => Ok(()),
    }
}
