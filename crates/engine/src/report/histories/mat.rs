//! Time histories as one MAT-file of level 5: a struct per window or flight, fields by path, and the unit of each in the struct
//! `units` beside them.

use std::io::Write;
use std::path::Path;

use super::mat_file::{LONGEST_NAME, Node, header, identifier, write_variable};
use super::{History, Names};
use crate::graph::Control;
use crate::report::{ReportError, file_error};

/// Writes one variable per group.
pub fn write(histories: &[History<'_>], path: &Path, control: &Control) -> Result<(), ReportError> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path).map_err(file_error(path))?);
    file.write_all(&header()).map_err(file_error(path))?;
    let mut groups: Vec<&str> = Vec::new();
    for history in histories {
        if !groups.contains(&history.group.as_str()) {
            groups.push(&history.group);
        }
    }
    let mut names = Names::default();
    for group in groups {
        control.checkpoint().map_err(|_| ReportError::Cancelled)?;
        let (mut fields, mut units) = (Node::Fields(Vec::new()), Node::Fields(Vec::new()));
        for history in histories.iter().filter(|history| history.group == group) {
            for time in &history.time_paths {
                fields.insert(time, Node::Numbers(&history.time_s));
                units.insert(time, Node::Text("s"));
            }
            for column in &history.columns {
                fields.insert(&column.path, Node::Column(&column.values));
                units.insert(&column.path, Node::Text(&column.unit));
            }
        }
        fields.insert("units", units);
        let name = names.unique(identifier(group.rsplit('/').next().unwrap_or(group)), LONGEST_NAME);
        let too_large = || ReportError::Form {
            what: "histories.mat",
            reason: format!("{group} is larger than the 2 GB a variable of this form may have: write HDF5"),
        };
        write_variable(&mut file, &name, &fields).map_err(file_error(path))?.ok_or_else(too_large)?;
    }
    file.flush().map_err(file_error(path))
}
