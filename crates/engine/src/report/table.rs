//! Tables as data: what every form of table is written from.

use serde::Serialize;

use crate::notation::{format_by_error, significant};

#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of its file, without ending.
    pub name: String,
    /// What it shows, one sentence.
    pub caption: String,
    /// Columns, from left to right.
    pub columns: Vec<Column>,
    /// Rows, each with one cell per column.
    pub rows: Vec<Vec<Cell>>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name in files that programs read.
    pub key: String,
    /// Heading in tables that people read.
    pub heading: String,
    /// Unit of its numbers; empty where they have none or several.
    pub unit: &'static str,
    /// Significant digits people read.
    pub digits: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// There is nothing to say.
    Empty,
    /// Words.
    Text(String),
    /// Name of a coefficient or derivative, for example `Cm_delta_e`.
    Symbol(String),
    /// A whole number.
    Count(usize),
    /// A number; not finite where it does not exist.
    Number(f64),
    /// A number that is read to the second digit of its standard error.
    Measured {
        value: f64,
        /// Its standard error.
        error: f64,
    },
    /// Yes or no.
    Flag(bool),
}

impl Column {
    /// A column of words or whole numbers.
    pub fn new(key: &str, heading: &str) -> Self {
        Self { key: key.to_owned(), heading: heading.to_owned(), unit: "", digits: 5 }
    }

    /// A column of numbers in `unit`, read to `digits`.
    pub fn number(key: &str, heading: &str, unit: &'static str, digits: usize) -> Self {
        Self { unit, digits, ..Self::new(key, heading) }
    }

    /// Heading with the unit.
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.heading.clone() } else { format!("{} [{}]", self.heading, self.unit) }
    }
}

impl Cell {
    /// A number that may be missing.
    pub(crate) fn maybe(value: Option<f64>) -> Self {
        value.map_or(Self::Empty, Self::Number)
    }

    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// Whether it is a quantity, to be set to the right.
    pub fn is_quantity(&self) -> bool {
        matches!(self, Self::Count(_) | Self::Number(_) | Self::Measured { .. })
    }

    /// What people read in a column of `digits` significant digits.
    pub fn readable(&self, digits: usize) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) => text.clone(),
            Self::Symbol(name) => crate::notation::derivative(name),
            Self::Count(count) => count.to_string(),
            Self::Number(value) => significant(*value, digits),
            Self::Measured { value, error } => format_by_error(*value, *error),
            Self::Flag(true) => "yes".to_owned(),
            Self::Flag(false) => "no".to_owned(),
        }
    }
}

impl Table {
    /// The rows of which `keep` is true of the cell in the column `key`.
    #[must_use]
    pub fn only(mut self, key: &str, keep: impl Fn(&Cell) -> bool) -> Self {
        if let Some(index) = self.columns.iter().position(|column| column.key == key) {
            self.rows.retain(|row| row.get(index).is_some_and(&keep));
        }
        self
    }

    /// The columns called `keys`, in that order.
    #[must_use]
    pub fn select(self, keys: &[&str]) -> Self {
        let places: Vec<usize> =
            keys.iter().filter_map(|key| self.columns.iter().position(|column| column.key == *key)).collect();
        Self {
            columns: places.iter().map(|&place| self.columns[place].clone()).collect(),
            rows: self.rows.iter().map(|row| places.iter().map(|&place| row[place].clone()).collect()).collect(),
            ..self
        }
    }

    /// The same table with another caption.
    #[must_use]
    pub(crate) fn captioned(self, caption: impl Into<String>) -> Self {
        Self { caption: caption.into(), ..self }
    }
}

/// `value` to so many significant digits.
pub(super) fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// Ends of the keys of numbers with a unit, longest first.
const UNITS: [(&str, &str); 8] = [
    ("_rad_s", "rad/s"),
    ("_percent", "%"),
    ("_kg_m3", "kg/m³"),
    ("_m_s", "m/s"),
    ("_deg", "deg"),
    ("_db", "dB"),
    ("_rad", "rad"),
    ("_s", "s"),
];

/// The column of a key: its words, and the unit it ends on.
fn column(key: &str) -> Column {
    let split = UNITS.into_iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, unit)));
    let (name, unit) = split.unwrap_or((key, ""));
    Column::number(key, &name.replace('_', " "), unit, 4)
}

/// Rows under the names of their fields; none where there are no rows.
pub(super) fn table(name: &str, caption: &str, rows: &[impl Serialize]) -> Option<Table> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).ok()?;
    }
    let bytes = writer.into_inner().ok()?;
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let keys: Vec<String> = reader.headers().ok()?.iter().map(str::to_owned).collect();
    let cell = |(key, text): (&String, &str)| match (key.as_str(), text.parse::<f64>()) {
        (_, _) if text.is_empty() => Cell::Empty,
        ("derivative" | "coefficient", _) => Cell::Symbol(text.to_owned()),
        ("first_count" | "second_count" | "manoeuvres" | "realisations", Ok(count)) => Cell::Count(count as usize),
        ("window" | "quantity" | "seed", _) | (_, Err(_)) => Cell::text(text),
        (_, Ok(value)) => Cell::Number(value),
    };
    let rows: Vec<Vec<Cell>> =
        reader.records().map_while(Result::ok).map(|row| keys.iter().zip(row.iter()).map(cell).collect()).collect();
    let columns = keys.iter().map(|key| column(key)).collect();
    (!rows.is_empty()).then(|| Table { name: name.to_owned(), caption: caption.to_owned(), columns, rows })
}

/// A table of one row per item of a list, made column by column: what heads a column and what stands in it are one thing.
pub struct TableOf<R> {
    table: Table,
    items: Vec<R>,
}

impl<R> TableOf<R> {
    /// A table without columns.
    pub fn new(name: &str, caption: impl Into<String>, items: impl IntoIterator<Item = R>) -> Self {
        let items: Vec<R> = items.into_iter().collect();
        let rows = vec![Vec::new(); items.len()];
        Self { table: Table { name: name.to_owned(), caption: caption.into(), columns: Vec::new(), rows }, items }
    }

    /// The finished table.
    pub fn done(self) -> Table {
        self.table
    }

    /// The table, further columns only if `holds`.
    pub fn when(self, holds: bool, further: impl FnOnce(Self) -> Self) -> Self {
        if holds { further(self) } else { self }
    }

    /// Adds a column.
    pub fn column(mut self, column: Column, cell: impl Fn(&R) -> Cell) -> Self {
        self.table.columns.push(column);
        self.table.rows.iter_mut().zip(&self.items).for_each(|(row, item)| row.push(cell(item)));
        self
    }

    /// Adds a column of text.
    pub fn text(self, key: &str, heading: &str, text: impl Fn(&R) -> &str) -> Self {
        self.column(Column::new(key, heading), |item| Cell::text(text(item)))
    }

    /// Adds a column of text that some items have.
    pub fn optional(self, key: &str, heading: &str, text: impl Fn(&R) -> Option<&str>) -> Self {
        self.column(Column::new(key, heading), |item| text(item).map_or(Cell::Empty, Cell::text))
    }

    /// Adds a column of symbols.
    pub fn symbol(self, key: &str, heading: &str, symbol: impl Fn(&R) -> &str) -> Self {
        self.column(Column::new(key, heading), |item| Cell::Symbol(symbol(item).to_owned()))
    }

    /// Adds a column of counts.
    pub fn count(self, key: &str, heading: &str, count: impl Fn(&R) -> usize) -> Self {
        self.column(Column::new(key, heading), |item| Cell::Count(count(item)))
    }

    /// Adds a column of numbers in `unit`, with `digits` significant digits on paper.
    pub fn number(self, key: &str, heading: &str, unit: &'static str, digits: usize, of: impl Fn(&R) -> f64) -> Self {
        self.column(Column::number(key, heading, unit, digits), |item| Cell::Number(of(item)))
    }

    /// As [`Self::number`], of items that may have none.
    pub fn maybe(
        self,
        key: &str,
        heading: &str,
        unit: &'static str,
        digits: usize,
        of: impl Fn(&R) -> Option<f64>,
    ) -> Self {
        self.column(Column::number(key, heading, unit, digits), |item| Cell::maybe(of(item)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_table_are_taken_by_name() {
        let table = Table {
            name: "t".into(),
            caption: String::new(),
            columns: vec![Column::new("a", "A"), Column::new("b", "B")],
            rows: vec![vec![Cell::Count(1), Cell::Flag(true)], vec![Cell::Count(2), Cell::Flag(false)]],
        };
        let part = table.only("b", |cell| *cell == Cell::Flag(false)).select(&["b", "a"]);
        assert_eq!(part.rows, [[Cell::Flag(false), Cell::Count(2)]]);
        assert_eq!(part.columns[0].key, "b");
    }
}
