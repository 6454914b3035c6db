//! Time histories as data, and the files they are written to.

mod collect;
mod csv;
mod hdf5;
mod mat;
pub(crate) mod mat_file;
#[cfg(feature = "parquet")]
mod parquet;

use std::borrow::Cow;
use std::path::Path;

use doublet_core::reconstruct::Deviations;

pub use collect::{collect, recordings};

use super::{ReportError, file_error};
use crate::graph::Control;

#[cfg(not(feature = "parquet"))]
mod parquet {
    /// Says that this build has no writer.
    pub fn write(_: &super::History<'_>, path: &std::path::Path) -> Result<(), super::ReportError> {
        let reason = format!(
            "{}: this build of doublet cannot write Parquet; build it with the feature parquet, or use csv",
            path.display()
        );
        Err(super::ReportError::Form { what: "a Parquet file", reason })
    }
}

/// Columns on one time base.
#[derive(Clone, Debug)]
pub struct History<'a> {
    /// Window or flight, as a path.
    pub group: String,
    /// What it holds, one word; with the group the name of its file where every history is a file of its own.
    pub kind: String,
    /// Where its time goes below the group, in files that hold everything.
    pub time_paths: Vec<String>,
    pub time_s: Cow<'a, [f64]>,
    /// Columns, each as long as the time.
    pub columns: Vec<HistoryColumn<'a>>,
}

#[derive(Clone, Debug)]
pub struct HistoryColumn<'a> {
    /// Path below the group.
    pub path: String,
    pub unit: String,
    /// One line.
    pub description: String,
    pub values: Values<'a>,
}

/// Values of a column; not a number where there is none. What follows from what a snapshot holds is formed while it is written.
#[derive(Clone, Debug)]
pub enum Values<'a> {
    Numbers(Cow<'a, [f64]>),
    Deviations(&'a Deviations),
    /// The first less the second, sample by sample.
    Difference(&'a [f64], &'a [f64]),
}

impl Values<'_> {
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Deviations(values) => values.len(),
            Self::Difference(values, less) => values.len().min(less.len()),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value at `row`, where there is one.
    pub fn get(&self, row: usize) -> Option<f64> {
        match self {
            Self::Numbers(values) => values.get(row).copied(),
            Self::Deviations(values) => values.get(row),
            Self::Difference(values, less) => Some(values.get(row)? - less.get(row)?),
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).filter_map(|row| self.get(row))
    }

    /// The same values, borrowed.
    fn borrowed(&self) -> Values<'_> {
        match self {
            Self::Numbers(values) => Values::Numbers(Cow::Borrowed(values)),
            Self::Deviations(values) => Values::Deviations(values),
            Self::Difference(values, less) => Values::Difference(values, less),
        }
    }

    /// All values in one piece.
    pub fn all(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Numbers(values) => Cow::Borrowed(values),
            Self::Deviations(_) | Self::Difference(..) => Cow::Owned(self.iter().collect()),
        }
    }
}

impl<'a> HistoryColumn<'a> {
    /// A column of values that live in a snapshot.
    fn new(path: String, unit: &str, description: &str, values: &'a [f64]) -> Self {
        let (unit, description) = (unit.to_owned(), description.to_owned());
        Self { path, unit, description, values: Values::Numbers(Cow::Borrowed(values)) }
    }
}

/// A form of time histories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HistoryFormat {
    /// One HDF5 file.
    Hdf5,
    /// One MAT-file of level 5, a struct per window.
    Mat,
    /// A folder of comma-separated files, units in the second row.
    Csv,
    /// A folder of Parquet files, units in their metadata.
    Parquet,
}

impl HistoryFormat {
    doublet_core::named_variants! {
        /// Name on the command line.
        pub name: Hdf5 "hdf5", Mat "mat", Csv "csv", Parquet "parquet"
    }
}

/// Writes `histories` in one form into `folder`.
pub fn write(
    histories: &[History<'_>],
    title: &str,
    format: HistoryFormat,
    folder: &Path,
    control: &Control,
) -> Result<(), ReportError> {
    match format {
        HistoryFormat::Hdf5 => hdf5::write(histories, title, &folder.join("histories.h5")),
        HistoryFormat::Mat => mat::write(histories, &folder.join("histories.mat"), control),
        HistoryFormat::Csv => each(histories, &folder.join("histories_csv"), "csv", control, csv::write),
        HistoryFormat::Parquet => {
            each(histories, &folder.join("histories_parquet"), "parquet", control, parquet::write)
        }
    }
}

/// Writes every history into a file of its own.
fn each(
    histories: &[History<'_>],
    folder: &Path,
    ending: &str,
    control: &Control,
    write: impl Fn(&History<'_>, &Path) -> Result<(), ReportError>,
) -> Result<(), ReportError> {
    std::fs::create_dir_all(folder).map_err(file_error(folder))?;
    let mut names = Names::default();
    for history in histories {
        control.checkpoint().map_err(|_| ReportError::Cancelled)?;
        let name = names.unique(file_name(&format!("{} {}", history.group, history.kind)), 200);
        write(history, &folder.join(format!("{name}.{ending}")))?;
    }
    Ok(())
}

/// Letters, digits, `-` and `.`; everything else becomes `_`.
fn file_name(text: &str) -> String {
    let keep = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '.') { c } else { '_' };
    text.chars().map(keep).collect::<String>().trim_start_matches('.').to_owned()
}

/// Names that must differ.
#[derive(Default)]
struct Names(std::collections::BTreeSet<String>);

impl Names {
    /// `name`, or the first of `name_2`, `name_3` and so on that nobody has, at most `length` bytes long.
    fn unique(&mut self, name: String, length: usize) -> String {
        let cut = |text: &str, room: usize| {
            let end = (0..=room.min(text.len())).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
            text[..end].to_owned()
        };
        let mut candidate = cut(&name, length);
        let mut number = 2;
        while !self.0.insert(candidate.clone()) {
            let suffix = format!("_{number}");
            candidate = cut(&name, length - suffix.len()) + &suffix;
            number += 1;
        }
        candidate
    }
}

#[cfg(test)]
mod tests;
