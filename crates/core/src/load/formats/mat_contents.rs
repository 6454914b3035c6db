//! Variables of a MAT-file as sources and channels.

use std::path::Path;
use std::sync::Arc;

use crate::load::budget::Budget;
use crate::load::contents::{ChannelInfo, Source};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::formats::mat::{Fields, Value, variables};
use crate::load::names::stated_unit::{bare, split_unit};
use crate::message;
use crate::message::{Message, quoted};

/// Most columns a matrix may have and still count as channels.
pub(crate) const MAX_COLUMNS: usize = 4096;

/// Sources of a MAT v5 file, and warnings: variables at the top are one source named after the file, every struct is one.
///
/// Three layouts of flight test are known by their form. A matrix whose columns are named by a text of as many rows, or by as many cells
/// of text, beside it or in a struct beside it has its columns called so; a second such text whose name says `unit` has their units.
/// SIDPAC's `fdata` of 90 columns keeps its own: their order is fixed. A struct of one row of numbers and its units (FTIS: `data`,
/// `units`, `description`) is a channel of the struct it belongs to. A struct of `time` and `signals` (Simulink: `values`, `label`) is
/// a source.
pub(crate) fn sources(path: &Path, budget: &Budget<'_>) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let mut tree = Tree { sources: vec![Source::new(stem(path))], warnings: Vec::new() };
    // An array without a name is the store of objects that the format keeps at its end.
    let named = variables(path, budget)?.into_iter().filter(|variable| !variable.name.is_empty());
    let variables = named.map(|variable| (variable.name.into(), variable.value)).collect();
    tree.add_all(0, "", variables);
    let Tree { mut sources, warnings } = tree;
    sources.retain(|source| !source.channels.is_empty() || !source.notes.is_empty());
    Ok((sources, warnings))
}

struct Tree {
    sources: Vec<Source>,
    warnings: Vec<Message>,
}

/// Names and units of the columns of a matrix; a column may have no name.
type Labels = Vec<(String, Option<String>)>;

/// SIDPAC's table of flight data, and its columns.
const SIDPAC_TABLE: (&str, usize) = ("fdata", 90);

impl Tree {
    /// Adds values that stand side by side.
    fn add_all(&mut self, at: usize, path: &str, values: Fields) {
        let texts = texts_of(&values);
        for (name, value) in values {
            let labels = match &value {
                Value::Numbers { rows, columns, .. } if (&*name, *columns) != SIDPAC_TABLE => {
                    labels(&texts, *(rows.min(columns)))
                }
                _ => None,
            };
            match (labels, value) {
                (Some(labels), Value::Numbers { rows, columns, values }) => {
                    for (index, ((label, unit), values)) in
                        labels.into_iter().zip(split(rows, columns, values)).enumerate()
                    {
                        let label = if label.is_empty() { format!("{name}[{index}]") } else { label };
                        self.sources[at].channels.push(ChannelInfo::shared(label, unit, values));
                    }
                }
                (_, value) => self.add(at, path, &name, value),
            }
        }
    }

    /// Adds `value` called `name` to source `at`, which is called `path` when it is a struct.
    fn add(&mut self, at: usize, path: &str, name: &str, value: Value) {
        let full = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match value {
            Value::Numbers { rows, columns, values } => {
                let channels = rows.min(columns);
                if channels > MAX_COLUMNS {
                    self.warnings.push(message!(
                        "{} is {} x {}, not a set of channels; it is left out",
                        quoted(&full),
                        rows,
                        columns
                    ));
                } else if !values.is_empty() {
                    self.sources[at].push_columns(name, None, split(rows, columns, values));
                }
            }
            Value::Text(rows) => self.sources[at].notes.push((name.to_owned(), rows.concat())),
            Value::Cells(cells) => {
                for (index, cell) in cells.into_iter().enumerate() {
                    self.add(at, path, &format!("{name}{{{}}}", index + 1), cell);
                }
            }
            Value::Structs(mut elements) => {
                if let [fields] = &mut elements[..]
                    && let Some((unit, values)) = single_channel(fields)
                {
                    self.sources[at].channels.push(ChannelInfo::shared(name, unit, values));
                    return;
                }
                if let [fields] = &elements[..]
                    && let Some(source) = simulink_source(&full, name, fields)
                {
                    self.sources.push(source);
                    return;
                }
                let single = elements.len() == 1;
                for (index, fields) in elements.into_iter().enumerate() {
                    let path = if single { full.clone() } else { format!("{full}({})", index + 1) };
                    let at = self.sources.len();
                    self.sources.push(Source::new(path.clone()));
                    self.add_all(at, &path, fields);
                }
            }
            Value::Unread(kind) => {
                let fix_text = "save it as a full, real array";
                self.warnings.push(message!("{} is {} and is not read; {}", quoted(&full), kind, fix_text));
            }
        }
    }
}

/// The texts among values that stand side by side, and those in a struct among them.
fn texts_of(values: &Fields) -> Vec<(String, Vec<String>)> {
    let text = |(name, value): &(Arc<str>, Value)| Some((name.to_string(), rows_of_text(value)?));
    let within = values.iter().filter_map(|(_, value)| match value {
        Value::Structs(elements) if elements.len() == 1 => Some(elements[0].iter().filter_map(text)),
        _ => None,
    });
    values.iter().filter_map(text).chain(within.flatten()).collect()
}

/// The source of a struct that Simulink writes of one block: `time`, and `signals` with `values` and `label`.
fn simulink_source(path: &str, name: &str, fields: &Fields) -> Option<Source> {
    let field = |fields: &'_ Fields, wanted: &str| fields.iter().position(|(name, _)| &**name == wanted);
    let Value::Numbers { values: time, .. } = &fields[field(fields, "time")?].1 else { return None };
    let Value::Structs(signals) = &fields[field(fields, "signals")?].1 else { return None };
    let mut source = Source::new(path);
    source.push_columns("time", Some("s"), vec![Arc::clone(time)]);
    for (index, signal) in signals.iter().enumerate() {
        let Value::Numbers { rows, columns, values } = &signal[field(signal, "values")?].1 else { return None };
        let label = field(signal, "label").and_then(|at| rows_of_text(&signal[at].1)).unwrap_or_default().concat();
        let (label, unit) = split_unit(&label);
        let columns = split(*rows, *columns, Arc::clone(values));
        let words: Vec<&str> = label.split([' ', ',']).filter(|word| !word.is_empty()).collect();
        if words.len() == columns.len() && words.len() > 1 {
            for (word, values) in words.into_iter().zip(columns) {
                source.push_columns(word, unit.as_deref(), vec![values]);
            }
        } else if !label.is_empty() {
            source.push_columns(&label, unit.as_deref(), columns);
        } else if signals.len() == 1 {
            source.push_columns(name, None, columns);
        } else {
            source.push_columns(&format!("{name}({})", index + 1), None, columns);
        }
    }
    Some(source)
}

/// Rows of a text, or of cells of one row each, trimmed; nothing of anything else.
fn rows_of_text(value: &Value) -> Option<Vec<String>> {
    let trimmed = |row: &String| row.trim_matches([' ', '\0']).to_owned();
    match value {
        Value::Text(rows) => Some(rows.iter().map(trimmed).collect()),
        Value::Cells(cells) => {
            let row = |cell: &Value| match cell {
                Value::Text(rows) => Some(trimmed(&rows.concat())),
                Value::Cells(none) if none.is_empty() => Some(String::new()),
                _ => None,
            };
            cells.iter().map(row).collect()
        }
        _ => None,
    }
}

/// Names of the `columns` of a matrix, where exactly one text beside it has as many rows, none of them twice, and their units.
fn labels(texts: &[(String, Vec<String>)], columns: usize) -> Option<Labels> {
    if columns < 2 {
        return None;
    }
    let fitting = texts.iter().filter(|(_, rows)| rows.len() == columns);
    let (units, names): (Vec<_>, Vec<_>) = fitting.partition(|(name, _)| name.to_lowercase().contains("unit"));
    let [(_, names)] = names[..] else { return None };
    let split: Labels = names.iter().map(|name| split_unit(name)).collect();
    let is_name = |(index, (name, _)): (usize, &(String, Option<String>))| {
        name.is_empty() || split[..index].iter().all(|(other, _)| other != name)
    };
    if !split.iter().enumerate().all(is_name) || split.iter().all(|(name, _)| name.is_empty()) {
        return None;
    }
    let units = if let [(_, units)] = units[..] { Some(units) } else { None };
    let unit = |k: usize| units.map(|units| bare(&units[k])).filter(|unit| !unit.is_empty());
    Some(split.into_iter().enumerate().map(|(k, (name, own))| (name, unit(k).or(own))).collect())
}

/// Unit and samples of a struct that is one channel: a row or column of numbers, its units as text, and else text only.
fn single_channel(fields: &mut Fields) -> Option<(Option<String>, Arc<[f64]>)> {
    let text = |(name, value): &(Arc<str>, Value)| Some((name.to_lowercase(), rows_of_text(value)?.concat()));
    let (numbers, others): (Vec<_>, Vec<_>) =
        fields.iter().enumerate().partition(|(_, (_, value))| matches!(value, Value::Numbers { .. }));
    let [(place, (_, Value::Numbers { rows, columns, values }))] = numbers[..] else { return None };
    let texts: Vec<(String, String)> = others.iter().map(|(_, field)| text(field)).collect::<Option<_>>()?;
    let (_, unit) = texts.iter().find(|(name, _)| name == "unit" || name == "units")?;
    if values.len() < 2 || *rows.min(columns) != 1 {
        return None;
    }
    let unit = Some(bare(unit)).filter(|unit| !unit.is_empty());
    let Value::Numbers { values, .. } = fields.swap_remove(place).1 else { return None };
    Some((unit, values))
}

/// Channels of a matrix given column by column: time runs along the longer side.
fn split(rows: usize, columns: usize, values: Arc<[f64]>) -> Vec<Arc<[f64]>> {
    if columns == 1 || rows == 1 {
        return vec![values];
    }
    if rows >= columns {
        return values.chunks_exact(rows).map(Arc::from).collect();
    }
    (0..rows).map(|row| values.iter().skip(row).step_by(rows).copied().collect()).collect()
}
