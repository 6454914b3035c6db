//! Tables of a report in the units its readers think in, with the symbols they know.

use doublet_core::statistics::NORMAL_95;

use super::Block;
use crate::notation;
use crate::report::table::{Cell, Table};
use crate::session::NoiseChannel;

/// Columns whose numbers are in the unit another column of the row states, by the name of the table.
const BY_ROW: [(&str, &[&str]); 6] = [
    ("engines", &["value"]),
    ("noise", &["used", "proposed", "deviation"]),
    ("wind_and_bias", &["mean", "standard_deviation", "minimum", "maximum"]),
    ("match", &["worst_error"]),
    ("sensors", &["minimum", "maximum", "accuracy", "noise", "bias"]),
    ("quantities", &["value", "step"]),
];

/// The block with angles in degrees and angular rates in degrees per second where it is a table, and entries of noise by their symbols.
pub fn shown(block: Block) -> Block {
    match block {
        Block::Table(table) => {
            let table = without_empty_columns(with_powers(with_symbols(in_degrees(table))));
            Block::Table(to_errors(table))
        }
        Block::Paragraph(text) => Block::Paragraph(with_minus(&text)),
        Block::List(lines) => Block::List(lines.iter().map(|line| with_minus(line)).collect()),
        Block::Facts(facts) => Block::Facts(facts.into_iter().map(|(name, text)| (name, with_minus(&text))).collect()),
        other => other,
    }
}

/// Negative numbers with a minus: a hyphen at the beginning of a number that begins a word.
fn with_minus(text: &str) -> String {
    let characters: Vec<char> = text.chars().collect();
    let begins = |at: usize| at == 0 || matches!(characters[at - 1], ' ' | '(' | '[' | '±');
    let is_number = |at: usize| characters.get(at + 1).is_some_and(char::is_ascii_digit);
    let minus = |(at, character): (usize, &char)| match character {
        '-' if begins(at) && is_number(at) => '\u{2212}',
        other => *other,
    };
    characters.iter().enumerate().map(minus).collect()
}

/// The columns in which at least one row has something; all of a table without rows.
fn without_empty_columns(table: Table) -> Table {
    if table.rows.is_empty() {
        return table;
    }
    let has_contents = |index: usize| table.rows.iter().any(|row| !is_empty(&row[index]));
    let filled: Vec<bool> = (0..table.columns.len()).map(has_contents).collect();
    let columns = table.columns.into_iter().zip(&filled).filter(|(_, filled)| **filled).map(|(column, _)| column);
    let of_row = |row: Vec<Cell>| -> Vec<Cell> {
        row.into_iter().zip(&filled).filter(|(_, filled)| **filled).map(|(cell, _)| cell).collect()
    };
    Table {
        name: table.name,
        caption: table.caption,
        columns: columns.collect(),
        rows: table.rows.into_iter().map(of_row).collect(),
    }
}

/// Columns of estimates: their digits follow the error of their row.
const ESTIMATES: [&str; 5] = ["estimate", "value", "pooled", "low", "high"];
/// Columns with the error of a row, the one that holds most first.
const ERRORS: [&str; 3] = ["corrected_standard_error", "standard_error", "error"];

/// Estimates with as many digits as their errors leave: those of their own column, of their row, or of the interval of the row.
fn to_errors(mut table: Table) -> Table {
    let place = |key: &str| table.columns.iter().position(|column| column.key == key);
    let of_row = ERRORS.iter().find_map(|key| place(key));
    let interval = place("low").zip(place("high")).filter(|_| place("estimate").or(place("value")).is_some());
    let own_error = |key: &str| {
        let keys = [format!("{key}_error"), format!("{key}_standard_error"), key.replace("_error", "_standard_error")];
        keys.iter().filter(|other| *other != key).find_map(|key| place(key))
    };
    let columns: Vec<(usize, Option<usize>)> = (0..table.columns.len())
        .filter_map(|index| {
            let key = table.columns[index].key.as_str();
            let own = own_error(key);
            (own.is_some() || ESTIMATES.contains(&key)).then_some((index, own.or(of_row)))
        })
        .collect();
    for row in &mut table.rows {
        let half = interval.and_then(|(low, high)| Some(0.5 * (number(&row[high])? - number(&row[low])?) / NORMAL_95));
        let errors: Vec<Option<f64>> =
            columns.iter().map(|(_, error)| error.and_then(|error| number(&row[error])).or(half)).collect();
        for ((index, _), error) in columns.iter().zip(errors) {
            if let (Some(value), Some(error)) = (number(&row[*index]), error) {
                row[*index] = Cell::Measured { value, error };
            }
        }
    }
    table
}

fn number(cell: &Cell) -> Option<f64> {
    if let Cell::Number(value) = cell { Some(*value) } else { None }
}

fn is_empty(cell: &Cell) -> bool {
    match cell {
        Cell::Empty => true,
        Cell::Text(text) => text.is_empty(),
        Cell::Number(value) => value.is_nan(),
        _ => false,
    }
}

/// Powers in the column of units as they are printed.
fn with_powers(mut table: Table) -> Table {
    let Some(unit) = table.columns.iter().position(|column| column.key == "unit") else { return table };
    for row in &mut table.rows {
        if let Cell::Text(text) = &mut row[unit] {
            *text = notation::raise_powers(text).replace("kg m2", "kg m²");
        }
    }
    table
}

fn with_symbols(mut table: Table) -> Table {
    let entries = table.columns.iter().position(|column| table.name == "noise" && column.key == "entry");
    for row in table.rows.iter_mut().filter(|_| entries.is_some()) {
        let cell = &mut row[entries.unwrap_or_default()];
        let Cell::Text(name) = cell else { continue };
        if let Some(channel) = NoiseChannel::from_name(name) {
            *cell = Cell::text(notation::role(channel.role()));
        }
    }
    table
}

fn in_degrees(mut table: Table) -> Table {
    for (index, column) in table.columns.iter_mut().enumerate() {
        let Some((unit, factor)) = notation::shown(column.unit).filter(|_| !is_frequency(&column.key)) else {
            continue;
        };
        column.unit = unit;
        table.rows.iter_mut().for_each(|row| scale(&mut row[index], factor));
    }
    let place = |key: &str| table.columns.iter().position(|column| column.key == key);
    let Some(unit) = place("unit") else { return table };
    let values = BY_ROW.iter().find(|(name, _)| *name == table.name).map_or(&[][..], |(_, keys)| keys);
    let values: Vec<usize> = values.iter().filter_map(|key| place(key)).collect();
    if values.is_empty() {
        return table;
    }
    for row in &mut table.rows {
        let Cell::Text(si) = &row[unit] else { continue };
        let Some((shown, factor)) = notation::shown(si) else { continue };
        row[unit] = Cell::text(shown);
        values.iter().for_each(|&index| scale(&mut row[index], factor));
    }
    table
}

/// Whether a column is of natural frequencies, which are read in rad/s.
fn is_frequency(key: &str) -> bool {
    key.starts_with("frequency")
}

fn scale(cell: &mut Cell, factor: f64) {
    if let Cell::Number(value) = cell {
        *value *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table::Column;

    #[test]
    fn estimates_have_the_digits_their_errors_leave() {
        let columns = ["estimate", "low", "high", "standard_error", "damping", "damping_error", "speed"];
        let table = |keys: &[&str], numbers: &[f64]| Table {
            name: String::new(),
            caption: String::new(),
            columns: keys.iter().map(|key| Column::number(key, key, "", 4)).collect(),
            rows: vec![numbers.iter().map(|value| Cell::Number(*value)).collect()],
        };
        let read = |table: Table| -> Vec<String> {
            let Block::Table(table) = shown(Block::Table(table)) else { panic!("a table") };
            table.rows[0].iter().zip(&table.columns).map(|(cell, column)| cell.readable(column.digits)).collect()
        };
        let found = read(table(&columns, &[-0.100_72, -0.102_0, -0.099_47, 0.000_64, 0.4188, 0.032, 46.331]));
        assert_eq!(found, ["−0.10072", "−0.10200", "−0.09947", "6.400e−4", "0.419", "0.03200", "46.33"]);
        // Without a column of errors the interval gives them; limits without an estimate are left as they are.
        assert_eq!(read(table(&columns[..3], &[0.2221, -0.03847, 0.4826])), ["0.22", "−0.04", "0.48"]);
        assert_eq!(read(table(&columns[1..3], &[-0.03847, 0.4826])), ["−0.03847", "0.4826"]);
    }

    #[test]
    fn negative_numbers_of_sentences_have_a_minus_and_nothing_else_has() {
        for (text, expected) in [
            ("all together -0.095 ± 0.015", "all together \u{2212}0.095 ± 0.015"),
            ("(-3 to -1)", "(\u{2212}3 to \u{2212}1)"),
            ("2026-11-30, manoeuvre 3-2-1-1, --json - 4", "2026-11-30, manoeuvre 3-2-1-1, --json - 4"),
        ] {
            assert_eq!(with_minus(text), expected);
        }
    }

    #[test]
    fn angles_of_columns_and_of_rows_are_in_degrees_and_nothing_else_changes() {
        let table = Table {
            name: "wind_and_bias".into(),
            caption: String::new(),
            columns: vec![
                Column::new("unit", "Unit"),
                Column::number("mean", "Mean", "", 3),
                Column::number("bank", "Bank", "rad", 3),
                Column::number("other", "Other", "", 3),
            ],
            rows: vec![
                vec![Cell::text("rad/s"), Cell::Number(0.5), Cell::Number(1.0), Cell::Number(2.0)],
                vec![Cell::text("m/s^2"), Cell::Number(0.5), Cell::Empty, Cell::Number(2.0)],
            ],
        };
        let found = in_degrees(table);
        assert_eq!(found.columns[2].unit, "deg");
        let number = |value: f64| Cell::Number(value);
        let degrees = 180.0 / std::f64::consts::PI;
        assert_eq!(found.rows[0], [Cell::text("deg/s"), number(0.5 * degrees), number(degrees), number(2.0)]);
        assert_eq!(found.rows[1], [Cell::text("m/s²"), number(0.5), Cell::Empty, number(2.0)]);
        // A column without contents is left out.
        assert_eq!(without_empty_columns(found.clone()).columns.len(), 4);
        let second = Table { rows: found.rows[1..].to_vec(), ..found.clone() };
        let keys: Vec<String> = without_empty_columns(second).columns.into_iter().map(|column| column.key).collect();
        assert_eq!(keys, ["unit", "mean", "other"]);
        // A unit column of a table that states no values in it is left as it is.
        let channels = Table { name: "channels".into(), ..found };
        assert_eq!(in_degrees(channels.clone()).rows, channels.rows);
    }
}
