//! Lines on the terminal and tables in monospace, or both as one JSON document.

use std::borrow::Cow;
use std::io::{ErrorKind, Write};
use std::sync::{Mutex, PoisonError};

use doublet_engine::notation::{format_number, is_direction_mark};
use doublet_engine::report::{Cell, Column, Table};
use doublet_engine::verdict::Verdict;
use serde::Serialize;
use serde_json::{Value, json};

/// Longest line of a message, in characters: what a file holds may be quoted in it.
const LONGEST_LINE: usize = 2000;

/// Layout of the document that is made of lines and tables.
const VERSION: u32 = 1;

/// What a command said, to be printed as one JSON document.
#[derive(Default)]
struct Collected {
    lines: Vec<String>,
    tables: Vec<Value>,
    /// Whether the command printed a document of its own.
    has_document: bool,
}

static COLLECTED: Mutex<Option<Collected>> = Mutex::new(None);

/// Why standard output did not take everything, where it did not.
static OUTPUT_ERROR: Mutex<Option<std::io::Error>> = Mutex::new(None);

/// Does `work` with what is collected; `None` where lines go to the terminal.
fn collected<R>(work: impl FnOnce(&mut Collected) -> R) -> Option<R> {
    COLLECTED.lock().unwrap_or_else(PoisonError::into_inner).as_mut().map(work)
}

/// From now on lines and tables are collected, for [`finish`] to print.
pub fn collect() {
    *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner) = Some(Collected::default());
}

/// Whether one JSON document is wanted.
pub fn is_json() -> bool {
    collected(|_| ()).is_some()
}

/// Prints what was collected, unless the command printed a document of its own: `version`, `lines[]` and `tables[]`, each `columns[]`
/// and `rows[][]` with numbers as printed, of a table of the engine as computed.
pub fn finish() -> Result<(), String> {
    let collected = COLLECTED.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(Collected { lines, tables, has_document: false }) = collected {
        document(&json!({ "version": VERSION, "lines": lines, "tables": tables }).to_string());
    }
    let failed = OUTPUT_ERROR.lock().unwrap_or_else(PoisonError::into_inner).take();
    failed.map_or(Ok(()), |error| Err(format!("the output is incomplete: {error}: write it to another place")))
}

/// Writes to standard output. A closed pipe is not an error; [`finish`] returns any other.
pub fn write_out(bytes: &[u8]) {
    let mut output = std::io::stdout().lock();
    let Err(error) = output.write_all(bytes).and_then(|()| output.flush()) else { return };
    if error.kind() != ErrorKind::BrokenPipe {
        OUTPUT_ERROR.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

fn cell(text: &str) -> Value {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite()).and_then(serde_json::Number::from_f64);
    number.map_or_else(|| Value::from(text.trim()), Value::Number)
}

/// Writes a verdict: its level, then its findings.
pub fn verdict(verdict: &Verdict) {
    line(&format!("verdict: {}", verdict.level.name()));
    verdict.reasons.iter().for_each(|finding| line(&format!("  {}: {finding}", finding.level.name())));
}

/// Writes a line to standard output, or several; long ones are cut.
pub fn line(text: &str) {
    if collected(|all| all.lines.extend(text.split('\n').map(str::to_owned))).is_some() {
        return;
    }
    for line in text.split('\n') {
        write_out(format!("{}\n", cut(&harmless(line))).as_bytes());
    }
}

/// Writes a document, such as JSON or CSV, as it is.
pub fn document(text: &str) {
    collected(|all| all.has_document = true);
    write_out(format!("{text}\n").as_bytes());
}

/// Prints `found` as the document of the command where one JSON document is wanted; what is printed otherwise is then left out.
pub fn json(found: &impl Serialize) -> Result<(), String> {
    if is_json() {
        document(&serde_json::to_string_pretty(found).map_err(|error| error.to_string())?);
    }
    Ok(())
}

/// As [`json`](fn@json); otherwise writes `text` as it is.
pub fn json_or(found: &impl Serialize, text: &str) -> Result<(), String> {
    if !is_json() {
        document(text);
    }
    json(found)
}

/// Writes a line to standard error, or several; long ones are cut.
pub fn error_line(text: &str) {
    for line in text.lines() {
        let _ = writeln!(std::io::stderr(), "{}", cut(&harmless(line)));
    }
}

/// Text without what a terminal obeys: control characters, and marks that turn the direction of writing.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let obeyed = |letter: char| (letter.is_control() && !matches!(letter, '\n' | '\t')) || is_direction_mark(letter);
    if text.contains(obeyed) { Cow::Owned(text.replace(obeyed, "\u{fffd}")) } else { Cow::Borrowed(text) }
}

/// The beginning and the end of a line that is too long.
fn cut(line: &str) -> Cow<'_, str> {
    let count = line.chars().count();
    if count <= LONGEST_LINE {
        return Cow::Borrowed(line);
    }
    let start: String = line.chars().take(LONGEST_LINE / 2).collect();
    let end: String = line.chars().skip(count - LONGEST_LINE / 2).collect();
    Cow::Owned(format!("{start} [{} characters] {end}", count - LONGEST_LINE))
}

/// Prints rows under a header in columns as wide as their widest entry, the first column to the left, the others to the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) {
    let columns = || header.iter().map(|name| name.trim()).collect::<Vec<_>>();
    let cells = || rows.iter().map(|row| row.iter().map(|text| cell(text)).collect::<Vec<_>>()).collect::<Vec<_>>();
    if collected(|all| all.tables.push(json!({ "columns": columns(), "rows": cells() }))).is_some() {
        return;
    }
    let mut widths: Vec<usize> = header.iter().map(|cell| cell.chars().count()).collect();
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    print_row(header, &widths);
    for row in rows {
        print_row(&row.iter().map(String::as_str).collect::<Vec<_>>(), &widths);
    }
}

fn print_row(cells: &[&str], widths: &[usize]) {
    let mut text = String::new();
    for (column, (cell, width)) in cells.iter().zip(widths).enumerate() {
        let padding = " ".repeat(width.saturating_sub(cell.chars().count()));
        if column == 0 {
            text.push_str(cell);
            text.push_str(&padding);
        } else {
            text.push_str("  ");
            text.push_str(&padding);
            text.push_str(cell);
        }
    }
    line(text.trim_end());
}

/// Prints a table of the engine under its headings, derivatives by their plain names; as JSON under its keys, with every digit.
pub fn show(table: &Table) {
    let columns = || table.columns.iter().map(|column| column.key.as_str()).collect::<Vec<_>>();
    let rows = || table.rows.iter().map(|row| row.iter().map(json_value).collect::<Vec<_>>()).collect::<Vec<_>>();
    if collected(|all| all.tables.push(json!({ "columns": columns(), "rows": rows() }))).is_some() {
        return;
    }
    let titles: Vec<String> = table.columns.iter().map(Column::title).collect();
    let rows = table.rows.iter().map(|row| row.iter().zip(&table.columns).map(readable).collect());
    self::table(&titles.iter().map(String::as_str).collect::<Vec<_>>(), &rows.collect::<Vec<_>>());
}

/// Prints tables, each behind an empty line.
pub fn show_all(tables: &[Table]) {
    for table in tables {
        line("");
        show(table);
    }
}

fn readable((cell, column): (&Cell, &Column)) -> String {
    match cell {
        Cell::Symbol(name) => name.clone(),
        Cell::Number(value) => number(*value, column.digits),
        cell => cell.readable(column.digits),
    }
}

fn json_value(cell: &Cell) -> Value {
    match cell {
        Cell::Empty => Value::Null,
        Cell::Text(text) | Cell::Symbol(text) => Value::from(text.as_str()),
        Cell::Count(count) => Value::from(*count),
        Cell::Number(number) | Cell::Measured { value: number, .. } => Value::from(*number),
        Cell::Flag(flag) => Value::from(*flag),
    }
}

/// Prints rows of a name and a description, the descriptions in one column.
pub fn list(rows: &[Vec<String>]) {
    let width = rows.iter().filter_map(|row| row.first()).map(|name| name.chars().count()).max().unwrap_or(0);
    for row in rows {
        let mut cells = row.iter();
        let name = cells.next().map_or("", String::as_str);
        let text = cells.map(String::as_str).collect::<Vec<_>>().join("  ");
        line(format!("{name:width$}  {text}").trim_end());
    }
}

/// The text in one line of at most `width` characters: cut behind a word, which three dots show.
pub fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let kept: String = text.chars().take(width.saturating_sub(1)).collect();
    let end = kept.rfind(' ').unwrap_or(kept.len());
    format!("{}…", kept[..end].trim_end_matches([' ', ',', ';', ':']))
}

/// The text in lines of at most `width` characters, broken between words, all but the first indented.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    const INDENT: &str = "    ";
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(last) = lines.last_mut() else { break };
        let is_empty = last.trim().is_empty();
        if !is_empty && last.chars().count() + 1 + word.chars().count() > width {
            lines.push(format!("{INDENT}{word}"));
        } else {
            last.push_str(if is_empty { "" } else { " " });
            last.push_str(word);
        }
    }
    lines
}

/// A number with `digits` significant digits, without needless zeros or exponents.
pub fn number(value: f64, digits: usize) -> String {
    format_number(value, digits, -5..7).unwrap_or_else(|| "-".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{LONGEST_LINE, cut, harmless, number, shortened, wrapped};

    #[test]
    fn long_lines_are_cut_behind_a_word_or_broken_between_words() {
        let text = "manoeuvre 'a': the airspeed, 40 m/s, is too low";
        assert_eq!(shortened(text, 80), text);
        assert_eq!(shortened(text, 29), "manoeuvre 'a': the…");
        assert_eq!(wrapped(text, 80), [text]);
        assert_eq!(wrapped(text, 29), ["manoeuvre 'a': the airspeed,", "    40 m/s, is too low"]);
        assert_eq!(shortened("ä".repeat(9).as_str(), 4), "äää…");
        assert_eq!(wrapped("", 4), [""]);
    }

    #[test]
    fn nothing_of_a_file_reaches_the_terminal_as_a_command() {
        assert_eq!(harmless("a\u{1b}[31mred\u{9b}2J\u{202e}gnp.exe\r\n\tb"), "a�[31mred�2J�gnp.exe�\n\tb");
        assert_eq!(harmless("ψ = 3°, α\n"), "ψ = 3°, α\n");
        let long = format!("file.mat: {}; copy it again", "0.0, ".repeat(10_000));
        let shown = cut(&long);
        assert!(shown.chars().count() < LONGEST_LINE + 40 && shown.starts_with("file.mat") && shown.ends_with("again"));
    }

    #[test]
    fn numbers_keep_their_significant_digits() {
        assert_eq!(number(5.225_68, 6), "5.22568");
        assert_eq!(number(-0.004_911_45, 6), "-0.00491145");
        assert_eq!(number(1.5e-9, 3), "1.50e-9");
        assert_eq!(number(17_631.0, 5), "17631");
        assert_eq!(number(9.9996, 4), "10.00");
        assert_eq!(number(9_999_999.6, 7), "1.000000e7");
        assert_eq!(number(f64::NAN, 5), "-");
    }
}
