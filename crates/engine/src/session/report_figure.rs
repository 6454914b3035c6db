//! Figures of the author's choice for the report, as they were when they were chosen.

use std::io::{Read, Write};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::Session;
use super::edit::EditError;

/// Longest caption, characters.
const LONGEST: usize = 1000;
/// Longest drawing that is read, bytes: a figure of eight lanes with ten lines each has two million.
const MOST_BYTES: u64 = 32 << 20;

/// A figure with the author's words on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportFigure {
    /// What it shows.
    pub caption: String,
    /// The figure, thinned to what can be told apart on paper: TOML, deflated, base64.
    drawing: Arc<str>,
}

impl ReportFigure {
    /// A drawing as it is now.
    pub(crate) fn pack(caption: &str, drawing: &impl Serialize) -> Result<Self, String> {
        let broken = |error: &dyn std::fmt::Display| format!("the figure '{caption}' cannot be kept: {error}");
        let text = toml::to_string(drawing).map_err(|error| broken(&error))?;
        let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
        let packed =
            packed.write_all(text.as_bytes()).and_then(|()| packed.finish()).map_err(|error| broken(&error))?;
        Ok(Self { caption: caption.to_owned(), drawing: STANDARD.encode(packed).into() })
    }

    /// The drawing.
    pub(crate) fn unpack<T: DeserializeOwned>(&self) -> Result<T, String> {
        let broken =
            |error: &dyn std::fmt::Display| format!("its drawing cannot be read ({error}): choose the plot again");
        let packed = STANDARD.decode(self.drawing.as_bytes()).map_err(|error| broken(&error))?;
        let mut text = String::new();
        let unpacked = DeflateDecoder::new(packed.as_slice()).take(MOST_BYTES).read_to_string(&mut text);
        unpacked.map_err(|error| broken(&error))?;
        toml::from_str(&text).map_err(|error| broken(&error.message()))
    }
}

/// A change of the figures of the report.
#[derive(Clone, Debug, PartialEq)]
pub enum ReportFigureEdit {
    /// Adds one behind the others.
    Add(ReportFigure),
    /// Says something else of the one at this place.
    Caption(usize, String),
    /// Leaves the one at this place out.
    Remove(usize),
}

impl ReportFigureEdit {
    pub(super) fn label(&self) -> &'static str {
        match self {
            Self::Add(_) => "add a figure to the report",
            Self::Caption(..) => "change the caption of a report figure",
            Self::Remove(_) => "remove a figure from the report",
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let all = &mut session.report_figures;
        let none = || EditError::Name("the report has no such figure".to_owned());
        match self {
            Self::Add(new) => all.push(new.clone()),
            Self::Caption(at, caption) if caption.chars().count() <= LONGEST => {
                all.get_mut(*at).ok_or_else(none)?.caption.clone_from(caption);
            }
            Self::Caption(..) => {
                return Err(EditError::Name(format!("the caption must have at most {LONGEST} characters")));
            }
            Self::Remove(at) if *at < all.len() => drop(all.remove(*at)),
            Self::Remove(_) => return Err(none()),
        }
        Ok(())
    }
}
