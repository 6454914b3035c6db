//! Variables of a MAT-file as sources and channels.

use std::path::Path;

use super::LoadError;
use super::contents::Source;
use super::finish::stem;
use super::mat::{Value, variables};

/// Most columns a matrix may have and still count as channels.
pub(super) const MAX_COLUMNS: usize = 4096;

/// Sources of a MAT v5 file, and warnings: variables at the top are one source named after the file, every struct is one.
pub(super) fn sources(path: &Path, contents: &[u8]) -> Result<(Vec<Source>, Vec<String>), LoadError> {
    let mut tree = Tree { sources: vec![Source::new(stem(path))], warnings: Vec::new() };
    for variable in variables(path, contents)? {
        // An array without a name is the store of objects that the format keeps at its end.
        if !variable.name.is_empty() {
            tree.add(0, "", &variable.name, variable.value);
        }
    }
    let Tree { mut sources, warnings } = tree;
    sources.retain(|source| !source.channels.is_empty() || !source.notes.is_empty());
    Ok((sources, warnings))
}

struct Tree {
    sources: Vec<Source>,
    warnings: Vec<String>,
}

impl Tree {
    /// Adds `value` called `name` to source `at`, which is called `path` when it is a struct.
    fn add(&mut self, at: usize, path: &str, name: &str, value: Value) {
        let full = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match value {
            Value::Numbers { rows, columns, values } => {
                let channels = rows.min(columns);
                if channels > MAX_COLUMNS {
                    self.warnings
                        .push(format!("'{full}' is {rows} x {columns} and is no set of channels; it is left out"));
                } else if !values.is_empty() {
                    self.sources[at].push_columns(name, None, split(rows, columns, values));
                }
            }
            Value::Text(text) => self.sources[at].notes.push((name.to_owned(), text)),
            Value::Cells(cells) => {
                for (index, cell) in cells.into_iter().enumerate() {
                    self.add(at, path, &format!("{name}{{{}}}", index + 1), cell);
                }
            }
            Value::Structs(elements) => {
                let single = elements.len() == 1;
                for (index, fields) in elements.into_iter().enumerate() {
                    let path = if single { full.clone() } else { format!("{full}({})", index + 1) };
                    let at = self.sources.len();
                    self.sources.push(Source::new(path.clone()));
                    for (name, value) in fields {
                        self.add(at, &path, &name, value);
                    }
                }
            }
            Value::Unread(kind) => {
                let cure = "save it as a full, real array to have it";
                self.warnings.push(format!("'{full}' is {kind} and is not read; {cure}"));
            }
        }
    }
}

/// Channels of a matrix given column by column: time runs along the longer side.
fn split(rows: usize, columns: usize, values: Vec<f64>) -> Vec<Vec<f64>> {
    if columns == 1 || rows == 1 {
        return vec![values];
    }
    if rows >= columns {
        return values.chunks_exact(rows).map(<[f64]>::to_vec).collect();
    }
    (0..rows).map(|row| values.iter().skip(row).step_by(rows).copied().collect()).collect()
}
