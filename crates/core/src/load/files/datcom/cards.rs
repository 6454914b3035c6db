//! Tables of a fixed-column listing: headings located by their labels, values by the column they stand under.

use super::ListingError;

/// Column centres of a heading, one per label.
pub(super) struct Heading(Vec<f64>);

impl Heading {
    /// The heading in `line` when it holds all `labels` in this order.
    pub(super) fn find(line: &str, labels: &[&str]) -> Option<Self> {
        let mut centres = Vec::with_capacity(labels.len());
        let mut from = 0;
        for label in labels {
            let start = from + line.get(from..)?.find(label)?;
            from = start + label.len();
            let column = line[..start].chars().count() as f64;
            centres.push(column + 0.5 * label.chars().count() as f64);
        }
        Some(Self(centres))
    }
}

/// Words of `line` with the centre of the columns they occupy.
fn words_with_centres(line: &str) -> impl Iterator<Item = (f64, &str)> {
    let mut from = 0;
    line.split_whitespace().map(move |word| {
        // A word of split_whitespace lies at or behind the end of the one before it.
        let start = line[from..].find(word).map_or(from, |offset| from + offset);
        from = start + word.len();
        (line[..start].chars().count() as f64 + 0.5 * word.chars().count() as f64, word)
    })
}

/// A number of the listing; `NDM` and `NA` stand for none.
fn value(word: &str) -> Option<f64> {
    if matches!(word, "NDM" | "NA") {
        return Some(f64::NAN);
    }
    word.parse().ok().filter(|v: &f64| v.is_finite())
}

/// The lines of a listing with their carriage control read away.
pub(super) struct Lines<'a> {
    lines: Vec<&'a str>,
}

impl<'a> Lines<'a> {
    /// Splits `text`.
    pub(super) fn new(text: &'a str) -> Self {
        Self { lines: text.lines().collect() }
    }

    /// Number of lines.
    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    /// Line `index`, counted from 0.
    pub(super) fn get(&self, index: usize) -> Option<&'a str> {
        self.lines.get(index).copied()
    }

    /// Rows of numbers below the heading in line `index`: blank lines and lone carriage controls before the first row
    /// are skipped, the first other line that does not start with a number ends the table.
    fn rows(&self, index: usize) -> impl Iterator<Item = (usize, &'a str)> {
        let first = self.lines[index + 1..]
            .iter()
            .position(|line| !matches!(line.trim(), "" | "0" | "ALPHA" | "0ALPHA"))
            .map_or(self.lines.len(), |offset| index + 1 + offset);
        self.lines[first..]
            .iter()
            .enumerate()
            .take_while(|(_, line)| {
                line.starts_with(' ') && line.split_whitespace().next().is_some_and(|word| value(word).is_some())
            })
            .map(move |(offset, line)| (first + offset, *line))
    }

    /// Columns of the table under `heading` in line `index`; not a number where a row leaves a column blank.
    ///
    /// The first `needed` columns must be in every row.
    pub(super) fn table(
        &self,
        index: usize,
        heading: &Heading,
        needed: usize,
        table: &'static str,
    ) -> Result<Vec<Vec<f64>>, ListingError> {
        let mut columns = vec![Vec::new(); heading.0.len()];
        for (row, line) in self.rows(index) {
            let refuse = |reason: String| ListingError::Row { line: row + 1, table, reason };
            let mut values = vec![None; heading.0.len()];
            for (centre, word) in words_with_centres(line) {
                let distance = |column: &usize| (heading.0[*column] - centre).abs();
                let nearest = (0..heading.0.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
                let number = value(word).ok_or_else(|| refuse(format!("'{}' is not a number", short(word))))?;
                match nearest.map(|column| &mut values[column]) {
                    Some(slot @ None) => *slot = Some(number),
                    _ => return Err(refuse(format!("two values under one heading at '{}'", short(word)))),
                }
            }
            if let Some(column) = values[..needed].iter().position(Option::is_none) {
                return Err(refuse(format!("column {} is blank", column + 1)));
            }
            for (column, number) in columns.iter_mut().zip(values) {
                column.push(number.unwrap_or(f64::NAN));
            }
        }
        match columns.first() {
            Some(first) if !first.is_empty() => Ok(columns),
            _ => Err(ListingError::Row { line: index + 1, table, reason: "no rows follow the heading".to_owned() }),
        }
    }

    /// Heading values behind the `=` of line `index`, and the rows below it: first column and the rest.
    #[expect(clippy::type_complexity, reason = "heading, first column, matrix")]
    pub(super) fn matrix(
        &self,
        index: usize,
        table: &'static str,
    ) -> Result<(Vec<f64>, Vec<f64>, Vec<Vec<f64>>), ListingError> {
        let heading = self.lines[index].split_once('=').map_or("", |(_, values)| values);
        let heading = numbers(heading, index, table)?;
        let (mut first, mut matrix) = (Vec::new(), Vec::new());
        for (row, line) in self.rows(index) {
            let mut values = numbers(line, row, table)?;
            if values.len() != heading.len() + 1 {
                let reason = format!("{} values, but the heading states {}", values.len(), heading.len() + 1);
                return Err(ListingError::Row { line: row + 1, table, reason });
            }
            first.push(values.remove(0));
            matrix.push(values);
        }
        Ok((heading, first, matrix))
    }
}

/// All numbers of `text`.
pub(super) fn numbers(text: &str, index: usize, table: &'static str) -> Result<Vec<f64>, ListingError> {
    text.split_whitespace()
        .map(|word| {
            let reason = || format!("'{}' is not a number", short(word));
            value(word).ok_or_else(|| ListingError::Row { line: index + 1, table, reason: reason() })
        })
        .collect()
}

/// The start of a word, for messages.
fn short(word: &str) -> String {
    const LENGTH: usize = 24;
    let mut text: String = word.chars().take(LENGTH).map(|c| if c.is_control() { '?' } else { c }).collect();
    if word.chars().count() > LENGTH {
        text.push_str("...");
    }
    text
}
