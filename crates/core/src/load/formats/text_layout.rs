//! How a text file is laid out: separator, decimal sign, header, units row, first line of numbers.

use crate::load::clocks::stamp::Stamp;
use crate::load::format::Format;
use crate::load::names::foreign_names::is_role_name;
use crate::load::names::stated_unit::{bare, split_unit};
use crate::quantity::Unit;

/// Lines at the end of the sample that decide the separator: numbers are there if anywhere.
const DECIDING_LINES: usize = 40;
/// Bytes at the start of the file that are looked at.
const SAMPLE_BYTES: usize = 64 * 1024;
/// Part of the filled cells of a line that must be numbers for it to count as data.
const NUMERIC_SHARE: f64 = 0.5;

/// Most line ends of a quoted cell in a header.
const MAX_CELL_LINES: usize = 8;

/// How the cells of a line are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separator {
    /// One byte between cells.
    Byte(u8),
    /// Any run of blanks.
    Blanks,
}

#[derive(Clone, Debug)]
pub(crate) struct TextLayout {
    pub separator: Separator,
    /// Whether `,` is the decimal sign.
    pub decimal_comma: bool,
    /// Names and units of the columns; no names where the file has no header.
    pub names: Vec<String>,
    pub units: Vec<Option<String>>,
    pub columns: usize,
    /// Rows may have more cells than columns: words of a list that the last column begins.
    pub has_open_end: bool,
    /// Offset of the first line of numbers, and its number from 1.
    pub data_at: usize,
    pub data_line: usize,
    /// Lines before the header.
    pub notes: Vec<String>,
}

impl TextLayout {
    /// Format that this layout is reported as.
    pub fn format(&self) -> Format {
        match self.separator {
            Separator::Byte(_) => Format::DelimitedText,
            Separator::Blanks => Format::TextColumns,
        }
    }

    /// Finds the layout of `contents`; `None` if there are no lines of numbers.
    pub fn find(contents: &[u8]) -> Option<Self> {
        let sample = &contents[..contents.len().min(SAMPLE_BYTES)];
        let whole = sample.len() == contents.len();
        let end = if whole { sample.len() } else { sample.iter().rposition(|&byte| byte == b'\n')? };
        let lines: Vec<&[u8]> = sample[..end].split(|&byte| byte == b'\n').collect();
        let filled: Vec<&[u8]> = lines.iter().copied().filter(|line| !line.trim_ascii().is_empty()).collect();
        let deciding = &filled[filled.len().saturating_sub(DECIDING_LINES.min(filled.len().div_ceil(2)))..];
        let open_of = |&(separator, comma): &(Separator, bool)| {
            open_width(&filled, deciding, (separator, comma)).map(|width| (separator, comma, width))
        };
        let decided = decide(deciding).or_else(|| DELIMITED.iter().find_map(open_of));
        let (separator, decimal_comma, width) = decided?;
        let open = open_width(&filled, deciding, (separator, decimal_comma));
        let (columns, has_open_end) = (open.unwrap_or(width), open.is_some());
        let mut at = 0;
        let mut before: Vec<Vec<String>> = Vec::new();
        let mut index = 0;
        while let Some(line) = lines.get(index) {
            let joined = quoted_lines(&lines[index..], separator);
            let cells = match joined {
                1 => cells(line, separator),
                _ => cells(&lines[index..index + joined].join(&b' '), separator),
            };
            let is_wide_enough = cells.len() == columns || (has_open_end && cells.len() > columns);
            let numbers_columns = || before.iter().all(|row| row.len() != columns) && is_numbering(&cells);
            if is_wide_enough && is_data(&cells, decimal_comma) && !numbers_columns() {
                before.iter_mut().for_each(|row| widen(row, separator, columns));
                before.iter_mut().for_each(|row| drop_end(row, columns));
                let (names, units, notes) = header(&before, separator, columns);
                let data_line = index + 1;
                let data_at = at;
                return Some(Self {
                    separator,
                    decimal_comma,
                    names,
                    units,
                    columns,
                    has_open_end,
                    data_at,
                    data_line,
                    notes,
                });
            }
            before.push(cells);
            at += lines[index..index + joined].iter().map(|line| line.len() + 1).sum::<usize>();
            index += joined;
        }
        None
    }
}

/// Gives a row of names as many cells as the rows of numbers have, where it parts them by commas and those by blanks, or where one word
/// stands for date and time or for week and second (tables of RTKLIB).
fn widen(row: &mut Vec<String>, separator: Separator, columns: usize) {
    const DATE_AND_TIME: [&str; 3] = ["GPST", "UTC", "JST"];
    if separator != Separator::Blanks || row.len() == columns {
        return;
    }
    if row.len() + 1 == columns && row.first().is_some_and(|name| DATE_AND_TIME.contains(&name.as_str())) {
        row.insert(0, "date or week".to_owned());
        return;
    }
    let joined = row.join(" ");
    let named: Vec<String> = joined.split(',').map(|cell| cell.trim().to_owned()).collect();
    if named.len() == columns && named.iter().all(|cell| !cell.is_empty()) {
        *row = named;
    }
}

/// Takes from a row of names the cells to which the rows of numbers have none: the name of the comments (LabVIEW), and empty ones
/// behind a last separator.
fn drop_end(row: &mut Vec<String>, columns: usize) {
    if row.len() == columns + 1 && row.last().is_some_and(|last| last.eq_ignore_ascii_case("comment")) {
        row.pop();
    }
    if row.len() > columns && row[columns..].iter().all(String::is_empty) {
        row.truncate(columns);
    }
}

/// The width of the first line where it names the columns of rows of different widths, of which none is shorter: the rows end on a list
/// of words.
fn open_width(filled: &[&[u8]], deciding: &[&[u8]], (separator, comma): (Separator, bool)) -> Option<usize> {
    const LEAST_NAMES: usize = 4;
    let is_number = |cell: &String| number(cell.as_bytes(), comma).is_some();
    let names = cells(filled.first()?, separator);
    if separator == Separator::Blanks
        || names.len() < LEAST_NAMES
        || names.iter().any(|cell| cell.is_empty() || is_number(cell))
    {
        return None;
    }
    let rows: Vec<Vec<String>> = deciding.iter().map(|line| cells(line, separator)).collect();
    let is_open = |row: &Vec<String>| {
        let (named, rest) = row.split_at_checked(names.len()).unwrap_or_default();
        is_data(named, comma) && !rest.iter().any(is_number)
    };
    let is_uneven = rows.iter().any(|row| row.len() > names.len());
    (is_uneven && rows.iter().all(is_open)).then_some(names.len())
}

/// Whether the cells are 1, 2, 3 ... or 0, 1, 2 ...: numbers of the columns in the place of their names.
fn is_numbering(cells: &[String]) -> bool {
    const LEAST_COLUMNS: usize = 4;
    let counts = |first: usize| cells.iter().enumerate().all(|(column, cell)| *cell == (column + first).to_string());
    cells.len() >= LEAST_COLUMNS && (counts(0) || counts(1))
}

/// How many of the first `lines` are one row because a quoted cell of the first has line ends.
fn quoted_lines(lines: &[&[u8]], separator: Separator) -> usize {
    if matches!(separator, Separator::Blanks) || !lines.first().is_some_and(|line| opens_quote(line)) {
        return 1;
    }
    let closing = lines.iter().skip(1).take(MAX_CELL_LINES).position(|line| opens_quote(line));
    closing.map_or(1, |after| after + 2)
}

/// Whether a quote of the line is still open at its end, or it closes one of a line before.
pub(crate) fn opens_quote(line: &[u8]) -> bool {
    line.iter().filter(|&&byte| byte == b'"').count() % 2 == 1
}

/// Separators of one byte, and whether the comma is the decimal sign beside them.
const DELIMITED: [(Separator, bool); 6] = [
    (Separator::Byte(b';'), false),
    (Separator::Byte(b';'), true),
    (Separator::Byte(b'\t'), false),
    (Separator::Byte(b'\t'), true),
    (Separator::Byte(b','), false),
    (Separator::Byte(b'|'), false),
];

/// Separator, decimal comma and number of columns that make the most of `lines`.
fn decide(lines: &[&[u8]]) -> Option<(Separator, bool, usize)> {
    let blanks = [(Separator::Blanks, false), (Separator::Blanks, true)];
    let candidates: Vec<_> = DELIMITED.into_iter().chain(blanks).collect();
    let scored =
        candidates.iter().filter_map(|candidate| Some((score_layout(lines, candidate.0, candidate.1)?, candidate)));
    // The first of the best: an earlier candidate wins a tie.
    let best = scored.rev().max_by_key(|((numbers, _), _)| *numbers)?;
    let ((_, width), &(separator, comma)) = best;
    Some((separator, comma, width))
}

/// Numbers that are read by this layout and its number of columns, where it makes data of at least half of the lines.
fn score_layout(lines: &[&[u8]], separator: Separator, comma: bool) -> Option<(usize, usize)> {
    let rows: Vec<Vec<String>> = lines.iter().map(|line| cells(line, separator)).collect();
    let mut counts: Vec<usize> = rows.iter().map(Vec::len).collect();
    counts.sort_unstable();
    // The most frequent width; a last line that was cut off does not decide.
    let width = counts.iter().copied().max_by_key(|width| counts.iter().filter(|other| *other == width).count())?;
    let data = rows.iter().filter(|cells| cells.len() == width && is_data(cells, comma)).count();
    let is_number = |cell: &&String| number(cell.as_bytes(), comma).is_some() && !has_other_mark(cell, comma);
    let numbers = rows.iter().flatten().filter(is_number).count();
    (data > 0 && 2 * data >= rows.len()).then_some((numbers, width))
}

/// Whether a cell is a time whose seconds have the mark that numbers do not: it does not tell the mark of numbers.
fn has_other_mark(cell: &str, decimal_comma: bool) -> bool {
    let other = if decimal_comma { '.' } else { ',' };
    cell.rsplit_once(':').is_some_and(|(_, seconds)| seconds.contains(other))
}

/// Whether most filled cells of a line are numbers.
fn is_data(cells: &[String], decimal_comma: bool) -> bool {
    let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
    let numbers = cells.iter().filter(|cell| number(cell.as_bytes(), decimal_comma).is_some()).count();
    numbers > 0 && numbers as f64 >= NUMERIC_SHARE * filled as f64
}

/// Cells of a line, without quotes and blanks around them.
fn cells(line: &[u8], separator: Separator) -> Vec<String> {
    let line = decoded(line);
    match separator {
        Separator::Blanks => line
            .trim_start_matches(['#', '%'])
            .split_whitespace()
            .map(|cell| cell.trim_matches('"').to_owned())
            .collect(),
        Separator::Byte(byte) => {
            let mut cells = vec![String::new()];
            let mut quoted = false;
            // A quote that nothing closes is a letter.
            let quotes = !opens_quote(line.as_bytes());
            for letter in line.trim_end_matches('\r').chars() {
                match letter {
                    '"' if quotes => quoted = !quoted,
                    letter if letter == char::from(byte) && !quoted => cells.push(String::new()),
                    letter => {
                        if let Some(cell) = cells.last_mut() {
                            cell.push(letter);
                        }
                    }
                }
            }
            cells.iter().map(|cell| cell.trim().to_owned()).collect()
        }
    }
}

/// Text of a line: UTF-8, or else Latin-1, in which recorders write the degree sign.
fn decoded(line: &[u8]) -> String {
    match std::str::from_utf8(line) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => line.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Names, units and metadata out of the lines before the numbers.
fn header(
    before: &[Vec<String>],
    separator: Separator,
    columns: usize,
) -> (Vec<String>, Vec<Option<String>>, Vec<String>) {
    let is_row = |cells: &&Vec<String>| {
        cells.len() == columns && cells.iter().any(|cell| !cell.is_empty()) && !is_aggregation(cells)
    };
    // Loggers of Campbell Scientific (TOA5) write the units between names and kinds of aggregation.
    let has_aggregation = before.iter().any(|cells| is_aggregation(cells));
    let mut rows: Vec<usize> = (0..before.len()).filter(|&line| is_row(&&before[line])).rev().take(3).collect();
    let filled = |line: usize| before[line].iter().filter(|cell| !cell.is_empty()).count();
    let known = |line: usize| before[line].iter().filter(|cell| !cell.is_empty() && is_unit(cell)).count();
    if let [last, above, names] = rows[..] {
        let is_of_units = |line: usize| known(line) > columns / 4 && 2 * known(line) >= filled(line);
        let roles = |line: usize| before[line].iter().filter(|cell| is_role_name(&split_unit(cell).0)).count();
        if is_of_units(above) && 2 * known(last) < filled(last) && filled(names) == columns {
            // Below names and units stand sensors (RaceChrono) or descriptions: what names the roles is the names.
            rows = if roles(last) > roles(names) { vec![above, last] } else { vec![above, names] };
        } else if is_of_units(last) && filled(names) == columns && roles(names) > roles(above) {
            rows = vec![last, names];
        }
    }
    rows.truncate(2);
    let mut units = vec![None; columns];
    if let [last, above] = rows[..] {
        let is_comment = before[above].first().is_some_and(|cell| cell.starts_with('#'));
        // A row of names may hold a letter that is also a unit (t, m, g); the row below names has units in most cells.
        let as_units = |line: usize| {
            let cells = before[line].iter().map(|cell| cell.trim_start_matches('#').trim());
            cells.map(|cell| (!cell.is_empty()).then(|| bare(cell))).collect()
        };
        let is_of_units = has_aggregation || 2 * known(last) >= filled(last).max(1);
        if is_of_units && filled(above) >= filled(last) {
            units = as_units(last);
            rows.remove(0);
        } else if is_comment && 3 * known(above) >= filled(above) && known(above) > known(last) {
            // Avionics of Garmin write the units as a comment above the names.
            units = as_units(above);
        } else if 2 * known(above) > filled(above) && 2 * known(last) < filled(last) {
            // LabVIEW writes them behind their label, above the names.
            let unit = |cell: &String| is_unit(cell).then(|| bare(cell)).filter(|unit| !unit.is_empty());
            units = before[above].iter().map(unit).collect();
        } else if known(last) == 0 {
            // Others write them in brackets behind the names in full, above the names in short.
            let own: Vec<_> = before[above].iter().map(|cell| in_brackets(cell)).collect();
            if 3 * own.iter().flatten().count() >= filled(above) {
                units = own;
            }
        }
    }
    let Some(&at) = rows.first() else {
        return (Vec::new(), units, notes(before, before.len(), separator));
    };
    let mut names = Vec::with_capacity(columns);
    for (cell, unit) in before[at].iter().zip(&mut units) {
        let cell = cell.trim_start_matches(['#', '%']).trim();
        let (name, own) = if separator == X_PLANE { (cell.to_owned(), x_plane_unit(cell)) } else { split_unit(cell) };
        if unit.is_none() {
            *unit = own;
        }
        names.push(name);
    }
    (names, units, notes(before, at, separator))
}

fn is_unit(cell: &str) -> bool {
    let is_bracketed = (cell.starts_with('(') && cell.ends_with(')')) || (cell.starts_with('[') && cell.ends_with(']'));
    cell.is_empty() || cell == "-" || is_bracketed || Unit::parse(cell).is_ok_and(|unit| unit.symbol != "-")
}

/// Whether a line says how each value was aggregated.
fn is_aggregation(cells: &[String]) -> bool {
    const KINDS: [&str; 7] = ["Smp", "Avg", "Max", "Min", "Std", "Tot", "WVc"];
    let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
    filled.peek().is_some() && filled.all(|cell| KINDS.contains(&cell.as_str()))
}

fn notes(before: &[Vec<String>], end: usize, separator: Separator) -> Vec<String> {
    let between = if separator == Separator::Blanks { " " } else { ", " };
    let text =
        |cells: &Vec<String>| cells.iter().filter(|cell| !cell.is_empty()).cloned().collect::<Vec<_>>().join(between);
    before[..end].iter().map(text).filter(|line| !line.is_empty()).collect()
}

/// What stands in round brackets at the end of a cell.
fn in_brackets(cell: &str) -> Option<String> {
    let (name, inside) = cell.strip_suffix(')')?.rsplit_once('(')?;
    (!name.trim().is_empty() && !inside.trim().is_empty()).then(|| inside.trim().to_owned())
}

/// Separator of the tables that X-Plane writes.
const X_PLANE: Separator = Separator::Byte(b'|');

/// Unit of a column of X-Plane, `Vtrue,_ktas`: several columns may differ by what follows the comma alone, so it stays in the name.
fn x_plane_unit(name: &str) -> Option<String> {
    let (quantity, unit) = name.rsplit_once(',')?;
    match (quantity.trim_matches('_'), unit.trim_matches('_')) {
        ("zulu" | "local" | "hobbs", "time") => Some("h".to_owned()),
        (_, "time") => Some("s".to_owned()),
        (_, unit) => Unit::parse(unit).is_ok().then(|| unit.to_owned()),
    }
}

/// The number in a cell: decimal point or comma, exponents with E or D, `nan` and `inf`, or the seconds of a time ([`Stamp`]).
pub(crate) fn number(cell: &[u8], decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim_ascii();
    let cell = cell.strip_prefix(b"+").unwrap_or(cell);
    let first = *cell.first()?;
    if let (false, Ok(value)) = (decimal_comma, fast_float2::parse(cell)) {
        return Some(value);
    }
    if !(first.is_ascii_digit() || matches!(first, b'-' | b'.' | b',')) || cell.len() > 64 {
        return if decimal_comma { fast_float2::parse(cell).ok() } else { None };
    }
    if let Some(stamp) = Stamp::parse(cell) {
        return Some(stamp.seconds());
    }
    let mut plain = [0_u8; 64];
    for (to, &from) in plain.iter_mut().zip(cell) {
        *to = match from {
            b',' if decimal_comma => b'.',
            b'.' if decimal_comma => return None,
            b'D' | b'd' => b'E',
            other => other,
        };
    }
    fast_float2::parse(&plain[..cell.len()]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_understood_in_every_spelling() {
        for (cell, comma, value) in [
            ("1.5", false, 1.5),
            (" -1.5e-3 ", false, -1.5e-3),
            ("+2", false, 2.0),
            ("1.5D+02", false, 150.0),
            ("1,5", true, 1.5),
            ("-3,25E1", true, -32.5),
            ("01:02:03.5", false, 3723.5),
            ("01:02:03.5", true, 3723.5),
            ("01:02:03,5", false, 3723.5),
            ("1970-01-02 01:02:03.5", true, 90_123.5),
        ] {
            assert_eq!(number(cell.as_bytes(), comma), Some(value), "{cell}");
        }
        assert!(number(b"NaN", false).unwrap().is_nan());
        for cell in ["", "abc", "12 kt", "1.2.3", "2024-05-01"] {
            assert_eq!(number(cell.as_bytes(), false), None, "{cell}");
        }
    }

    #[test]
    fn times_do_not_tell_the_mark_of_numbers() {
        for (line, comma) in [
            ("10:23:11.000;1,5;2,5", true),
            ("10:23:11,000;1.5;2.5", false),
            ("10:23:11,000;1;2", true),
            ("10:23:11.000;1;2", false),
            ("12.05.2026 10:23:11,000;1;2", true),
        ] {
            let layout = TextLayout::find(format!("t;a;b\n{line}\n{line}\n{line}\n").as_bytes()).unwrap();
            assert_eq!((layout.decimal_comma, layout.columns), (comma, 3), "{line}");
        }
    }

    #[test]
    fn layout_finds_metadata_header_and_units_row() {
        let text = b"Recorder;ABC 12\nDate;2024-05-01\n\ntime;alpha;V\ns;deg;kt\n0,0;1,5;90\n0,1;;91\n0,2;1,7;92\n";
        let layout = TextLayout::find(text).unwrap();
        assert_eq!((layout.separator, layout.decimal_comma, layout.columns), (Separator::Byte(b';'), true, 3));
        assert_eq!(layout.names, ["time", "alpha", "V"]);
        assert_eq!(layout.units.iter().flatten().collect::<Vec<_>>(), ["s", "deg", "kt"]);
        assert_eq!(layout.data_line, 6);
        assert_eq!(layout.notes.len(), 2);
    }

    #[test]
    fn a_first_row_that_numbers_the_columns_is_their_names() {
        let layout = |head: &str| TextLayout::find(format!("{head}0.1,2.5,3,4\n0.2,2.6,3,4\n").as_bytes()).unwrap();
        assert_eq!(
            (layout("1,2,3,4\n").names, layout("1,2,3,4\n").data_line),
            (vec!["1".to_owned(), "2".to_owned(), "3".to_owned(), "4".to_owned()], 2)
        );
        assert_eq!(layout("0,1,2,3\n").data_line, 2);
        assert_eq!(layout("1,2,3,5\n").data_line, 1);
        let named = layout("a,b,c,d\n1,2,3,4\n");
        assert_eq!((named.names[0].as_str(), named.data_line), ("a", 2));
    }

    #[test]
    fn a_row_of_names_may_be_parted_otherwise_than_the_numbers() {
        let names = |text: &str| TextLayout::find(text.as_bytes()).unwrap().names;
        let row = "2024/05/12 10:22:40.000 52.1 4.3 600.0 1\n";
        let rtklib = format!("% (x=1)\n%  GPST   latitude(deg) longitude(deg) height(m) Q\n{row}{row}{row}");
        assert_eq!(names(&rtklib), ["date or week", "GPST", "latitude", "longitude", "height", "Q"]);
        let office = "Date: 2024\nTIME, EAST VELOCITY, ROLL\n\n 1.5 2.5 3.5\n 1.6 2.5 3.5\n 1.7 2.5 3.5\n";
        assert_eq!(names(office), ["TIME", "EAST VELOCITY", "ROLL"]);
    }

    #[test]
    fn a_header_may_end_on_a_comma_and_rows_on_a_list_of_words() {
        let row = "0.1,2.5,-9.8\n";
        let layout = TextLayout::find(format!("t, roll, az,\n{row}{row}{row}").as_bytes()).unwrap();
        assert_eq!((layout.names.as_slice(), layout.has_open_end), (&["t", "roll", "az"].map(String::from)[..], false));
        let open =
            "t,roll,pitch,alerts\n0.1,2.5,1.5,\n0.2,2.6,1.5,STALL,YAW\n0.3,2.7,1.5,STALL\n0.4,2.7,1.5,STALL,ROLL,OIL\n";
        let layout = TextLayout::find(open.as_bytes()).unwrap();
        assert_eq!((layout.names.len(), layout.columns, layout.has_open_end, layout.data_line), (4, 4, true, 2));
        let probe = crate::load::probe_of(&open.replace(",1.5,", ",1.5,STALL,"));
        assert_eq!(probe.sources[0].channels[2].values(), [1.5; 4]);
        assert!(probe.warnings.is_empty(), "{:?}", probe.warnings);
        let longer = TextLayout::find(b"t,roll,pitch,yaw\n0.1,2,3,4,5\n0.2,2,3,4,5\n0.3,2,3,4,5\n").unwrap();
        assert_eq!((longer.columns, longer.has_open_end), (5, false));
    }

    #[test]
    fn a_row_of_sensors_below_the_units_is_left_out() {
        let row = "1.0,0.1,50.0,181.0,1.5,2.5\n1.1,0.2,50.0,181.0,1.5,2.5\n1.2,0.3,50.0,181.0,1.5,2.5\n";
        let text =
            format!("time,elapsed,speed,bearing,x_rate,y_rate\ns,s,m/s,deg,deg/s,deg/s\n,,100: gps,100: gps,,\n{row}");
        let layout = TextLayout::find(text.as_bytes()).unwrap();
        assert_eq!(layout.names, ["time", "elapsed", "speed", "bearing", "x_rate", "y_rate"]);
        assert_eq!(layout.units.iter().flatten().collect::<Vec<_>>(), ["s", "s", "m/s", "deg", "deg/s", "deg/s"]);
    }

    #[test]
    fn of_two_rows_of_names_the_one_that_names_roles_counts() {
        let rows = "0.0,1.5,90\n0.1,1.6,91\n0.2,1.7,92\n";
        for head in [
            "time,roll,TAS\ns,deg,kt\nTime since start,Bank of the IRU,Speed of the ADC\n",
            "T,P0301,P0601\ns,deg,kt\ntime,roll,TAS\n",
            "time,roll,TAS\nT,P0301,P0601\ns,deg,kt\n",
            "T,P0301,P0601\ntime,roll,TAS\ns,deg,kt\n",
        ] {
            let layout = TextLayout::find(format!("{head}{rows}").as_bytes()).unwrap();
            assert_eq!(layout.names, ["time", "roll", "TAS"], "{head}");
            assert_eq!(layout.units.iter().flatten().collect::<Vec<_>>(), ["s", "deg", "kt"], "{head}");
        }
    }

    #[test]
    fn layout_reads_units_in_the_header_and_columns_without_one() {
        let layout = TextLayout::find(b"# t[s]  alpha(deg)  n(1)\n 0 1 2\n 1 2 3\n 2 3 4\n").unwrap();
        assert_eq!(
            (layout.separator, layout.names.as_slice()),
            (Separator::Blanks, &["t", "alpha", "n(1)"].map(String::from)[..])
        );
        assert_eq!(layout.units[1].as_deref(), Some("deg"));
        let bare = TextLayout::find(b"0,1\n1,2\n2,3\n").unwrap();
        assert!(bare.names.is_empty());
        assert_eq!((bare.columns, bare.data_line), (2, 1));
    }

    #[test]
    fn layout_reads_the_header_of_a_measurement_file() {
        let text = "Separator\tTab\n***End_of_Header***\nChannels\t2\nY_Unit_Label\tdeg\tkt\nX_Dimension\tTime\n\
            ***End_of_Header***\nX_Value\tRoll\tTAS\tComment\n0.00\t1.5\t90.1\n0.02\t1.6\t90.2\n0.04\t1.7\t90.3\n";
        let layout = TextLayout::find(text.as_bytes()).unwrap();
        assert_eq!(layout.names, ["X_Value", "Roll", "TAS"]);
        assert_eq!(layout.units, [None, Some("deg".to_owned()), Some("kt".to_owned())]);
    }

    #[test]
    fn layout_reads_tables_of_avionics_and_of_a_flight_simulator() {
        let garmin = b"#airframe_info, log_version=\"1.00\"\n#yyy-mm-dd, hh:mm:ss, ident, deg C, kt, ft msl, rpm\n\
            Lcl Date, Lcl Time, Wpt, OAT, IAS, AltMSL, E1 RPM\n2026-05-14, 16:30:00, , 5.1, 95.0, 5000.0, 2200\n\
            2026-05-14, 16:30:01, , 5.1, 95.5, 5000.0, 2200\n2026-05-14, 16:30:02, , 5.1, 96.0, 5000.0, 2200\n";
        let layout = TextLayout::find(garmin).unwrap();
        assert_eq!(layout.names[3..], ["OAT", "IAS", "AltMSL", "E1 RPM"]);
        let units: Vec<&str> = layout.units.iter().map(|unit| unit.as_deref().unwrap_or("")).collect();
        assert_eq!(units[3..], ["deg C", "kt", "ft msl", "rpm"]);
        let commented = TextLayout::find(b"#ms, deg, kt\nstamp,alpha,V\n0,1,90\n20,2,91\n40,3,92\n").unwrap();
        assert_eq!(commented.units.iter().flatten().collect::<Vec<_>>(), ["ms", "deg", "kt"]);
        let simulator = b"\n _totl,_time | Vtrue,_ktas | Vtrue,_ktgs |____Q,rad/s |\n 1.0 | 90.0 | 91.0 | 0.1 |\n\
            1.1 | 90.0 | 91.0 | 0.2 |\n 1.2 | 90.0 | 91.0 | 0.3 |\n";
        let layout = TextLayout::find(simulator).unwrap();
        assert_eq!(layout.names[..4], ["_totl,_time", "Vtrue,_ktas", "Vtrue,_ktgs", "____Q,rad/s"]);
        let units: Vec<&str> = layout.units[..4].iter().flatten().map(String::as_str).collect();
        assert_eq!(units, ["s", "ktas", "ktgs", "rad/s"]);
    }
}
