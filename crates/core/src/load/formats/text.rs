//! Text recordings: delimited or in columns, one table per file, or a folder with one file per channel.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::clocks::find_clocks::find_clocks;
use crate::load::clocks::stamp::{Stamp, read_digits};
use crate::load::clocks::time_names::is_time_name;
use crate::load::contents::{ChannelInfo, Probe, Source, one_line};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::format::Format;
use crate::load::formats::finish::finish;
use crate::load::formats::tall::Tall;
use crate::load::formats::text_layout::{Separator, TextLayout, number, opens_quote};
use crate::load::formats::{clock_columns, flysight, topics, vbox, xplane_fdr};
use crate::message;
use crate::message::{Message, quoted};
use crate::statistics::extent;

/// Part of the filled cells of a column that must be numbers for it to be a channel.
const NUMERIC_SHARE: f64 = 0.5;
/// Rows of a wrong width that are tolerated, and the part of all rows beyond that.
const MIN_ODD_ROWS: usize = 10;
const ODD_ROW_SHARE: f64 = 0.1;
/// Bytes in which a text file holds no NUL.
const TEXT_BYTES: usize = 8192;

/// What programs write as the unit of seconds since 1970.
const UNIX_TIMES: [&str; 3] = ["unix time", "unix", "epoch"];

/// What a file is read as: its format, its sources and what was noticed.
pub(crate) type Contents = (Format, Vec<Source>, Vec<Message>);

/// The sources of a text file.
pub(crate) fn sources(path: &Path, contents: &[u8], budget: &Budget<'_>) -> Result<Contents, LoadError> {
    let reason = |reason: &str| LoadError::NotRecognised { path: path.to_owned(), reason: reason.to_owned() };
    let contents = &*from_utf16(contents);
    if contents.iter().take(TEXT_BYTES).any(|&byte| byte == 0) {
        return Err(reason("binary data of an unknown kind"));
    }
    let contents = &*with_line_feeds(contents);
    if flysight::has_signature(contents) {
        return tables_of(path, contents, budget);
    }
    if let Some((layout, rows)) = xplane_fdr::split(contents) {
        let (mut source, mut warnings) = (with_notes(xplane_fdr::SOURCE, &layout), Vec::new());
        read_table((path, budget), (&layout, &rows), &mut source, &mut warnings)?;
        return Ok((layout.format(), vec![source], warnings));
    }
    let layout = TextLayout::find(contents).ok_or_else(|| reason("text without a table of numbers"))?;
    if let Some(tall) = Tall::find(&layout) {
        let sources = tall.read((path, budget), &layout, &contents[layout.data_at..])?;
        return Ok((layout.format(), sources, Vec::new()));
    }
    let mut warnings = Vec::new();
    let mut source = with_notes(stem(path), &layout);
    read_table((path, budget), (&layout, &contents[layout.data_at..]), &mut source, &mut warnings)?;
    vbox::settle(&mut source);
    Ok((layout.format(), topics::split(source), warnings))
}

/// An empty source with the lines before the header of its table.
fn with_notes(name: impl Into<String>, layout: &TextLayout) -> Source {
    let notes = layout.notes.iter().enumerate().map(|(line, text)| (format!("line {}", line + 1), text.clone()));
    Source { notes: notes.collect(), ..Source::new(name) }
}

/// The text in UTF-8 of a file that its byte order mark calls UTF-16; any other file as it is.
fn from_utf16(contents: &[u8]) -> Cow<'_, [u8]> {
    let unit: fn([u8; 2]) -> u16 = match contents {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return Cow::Borrowed(contents),
    };
    let units = contents[2..].as_chunks::<2>().0.iter().map(|bytes| unit(*bytes));
    let text: String = char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Cow::Owned(text.into_bytes())
}

/// Lines that end in a carriage return alone are lines too.
fn with_line_feeds(contents: &[u8]) -> Cow<'_, [u8]> {
    if contents.contains(&b'\n') || !contents.contains(&b'\r') {
        return Cow::Borrowed(contents);
    }
    Cow::Owned(contents.iter().map(|&byte| if byte == b'\r' { b'\n' } else { byte }).collect())
}

/// Columns of whole lines that follow the header of a text laid out so.
pub(crate) fn columns_of(path: &Path, layout: &TextLayout, lines: &[u8]) -> Result<Vec<Vec<f64>>, LoadError> {
    let budget = Budget::for_file(path, layout.format());
    let mut table = Table::new((path, &budget), layout);
    table.read(lines.strip_suffix(b"\n").unwrap_or(lines))?;
    Ok(table.columns.into_iter().map(|column| column.values).collect())
}

/// Reads the rows of one table into the channels of its source.
fn read_table(
    (path, budget): (&Path, &Budget<'_>),
    (layout, lines): (&TextLayout, &[u8]),
    source: &mut Source,
    warnings: &mut Vec<Message>,
) -> Result<(), LoadError> {
    let mut table = Table::new((path, budget), layout);
    table.read(lines)?;
    table.into_channels(source, warnings);
    clock_columns::join(source, pass_midnight);
    Ok(())
}

/// A source per table of a text whose rows are headed by the names of their tables.
fn tables_of(path: &Path, contents: &[u8], budget: &Budget<'_>) -> Result<Contents, LoadError> {
    let (tables, notes) = flysight::split_tables(contents);
    let (mut sources, mut warnings) = (Vec::new(), Vec::new());
    for (name, layout, lines) in tables {
        let mut source = Source { notes: notes.clone(), ..Source::new(name) };
        read_table((path, budget), (&layout, &lines), &mut source, &mut warnings)?;
        sources.push(source);
    }
    Ok((Format::DelimitedText, sources, warnings))
}

/// A folder of one file per channel: one source named after the folder, channels named after the files.
pub(crate) fn probe_folder(path: &Path) -> Result<Probe, LoadError> {
    let open = |cause| LoadError::Open { path: path.to_owned(), cause };
    let mut files: Vec<PathBuf> = std::fs::read_dir(path)
        .map_err(open)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .map_err(open)?;
    let is_text = |file: &PathBuf| {
        let extension = file.extension().map(|extension| extension.to_ascii_lowercase());
        extension.is_some_and(|extension| extension == "csv" || extension == "txt") && file.is_file()
    };
    files.retain(is_text);
    files.sort();
    if files.is_empty() {
        return Err(LoadError::Empty { path: path.to_owned(), what: "a folder without .csv or .txt files" });
    }
    // The files of a folder share what one recording may take.
    let budget = Budget::for_file(path, Format::Folder);
    let mut warnings = Vec::new();
    let mut found: Vec<Source> = Vec::new();
    let mut folder = Source::new(path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()));
    for file in files {
        let contents = Budget::for_file(&file, Format::Folder).read_whole()?;
        match sources(&file, &contents, &budget) {
            Ok((_, sources, found_warnings)) => {
                warnings.extend(found_warnings.into_iter().map(|warning| message!("{}: {}", stem(&file), warning)));
                for mut source in sources {
                    join_row(&mut source);
                    if let [channel] = &mut source.channels[..] {
                        channel.name = stem(&file);
                        folder.channels.append(&mut source.channels);
                    } else {
                        found.push(source);
                    }
                }
            }
            Err(error @ LoadError::TooLarge { .. }) => return Err(error),
            Err(error) => warnings.push(message!("left out {}", error.to_string())),
        }
    }
    if !folder.channels.is_empty() {
        found.insert(0, folder);
    }
    found.iter_mut().for_each(|source| find_clocks(source, |_, _| {}));
    finish(Probe { path: path.to_owned(), format: Format::Folder, sources: found, warnings })
}

/// Makes one channel of a file that is one row of numbers without names, as the vectors of a folder can be written.
fn join_row(source: &mut Source) {
    let is_row = source.channels.len() > 1
        && source.channels.iter().all(|channel| channel.samples == 1 && channel.column().is_some());
    if is_row {
        let values = source.channels.iter().flat_map(|channel| channel.values().iter().copied()).collect();
        source.channels = vec![ChannelInfo::new("column", None, values)];
    }
}

/// Columns being filled.
struct Table<'l> {
    path: &'l Path,
    budget: &'l Budget<'l>,
    layout: &'l TextLayout,
    columns: Vec<Column>,
    line: usize,
    rows: usize,
    odd_rows: usize,
    first_odd: Option<(usize, usize)>,
    empty_rows: usize,
}

/// One column being filled.
#[derive(Default)]
struct Column {
    values: Vec<f64>,
    filled: usize,
    words: usize,
    first_word: Option<(usize, String)>,
    /// Cells that are times of day, and those that are times with a date.
    times_of_day: usize,
    dated: usize,
}

impl<'l> Table<'l> {
    fn new((path, budget): (&'l Path, &'l Budget<'l>), layout: &'l TextLayout) -> Self {
        let columns = (0..layout.columns).map(|_| Column::default()).collect();
        let line = layout.data_line;
        Self { path, budget, layout, columns, line, rows: 0, odd_rows: 0, first_odd: None, empty_rows: 0 }
    }

    fn read(&mut self, data: &[u8]) -> Result<(), LoadError> {
        match self.layout.separator {
            Separator::Byte(byte) if memchr_quote(data) => self.read_quoted(data, byte),
            Separator::Byte(byte) => {
                for line in data.split(|&letter| letter == b'\n') {
                    self.row(line.split(|&letter| letter == byte))?;
                }
                Ok(())
            }
            Separator::Blanks => {
                for line in data.split(|&letter| letter == b'\n') {
                    self.row(line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty()))?;
                }
                Ok(())
            }
        }
    }

    /// Quoted cells may hold separators.
    fn read_quoted(&mut self, data: &[u8], separator: u8) -> Result<(), LoadError> {
        // A recording may have been cut off inside its last line.
        let mut lines = data.trim_ascii_end().split(|&letter| letter == b'\n');
        let open = lines.position(opens_quote).filter(|_| opens_quote(data) && lines.next().is_some());
        if let Some(at) = open {
            let what = format!("line {} has a quote that is not closed", self.line + at);
            return Err(LoadError::Damaged { path: self.path.to_owned(), format: Format::DelimitedText, what });
        }
        let mut reader =
            csv::ReaderBuilder::new().delimiter(separator).has_headers(false).flexible(true).from_reader(data);
        let mut record = csv::ByteRecord::new();
        let fail = |error: csv::Error| LoadError::Damaged {
            path: self.path.to_owned(),
            format: Format::DelimitedText,
            what: error.to_string(),
        };
        while reader.read_byte_record(&mut record).map_err(fail)? {
            self.row(record.iter())?;
        }
        Ok(())
    }

    fn row<'a>(&mut self, cells: impl Iterator<Item = &'a [u8]>) -> Result<(), LoadError> {
        let mut count = 0;
        let mut is_empty = true;
        for cell in cells {
            let cell = cell.trim_ascii();
            is_empty &= cell.is_empty();
            if let Some(column) = self.columns.get_mut(count) {
                column.push(cell, self.layout.decimal_comma, self.line);
            }
            count += 1;
        }
        self.line += 1;
        if is_empty {
            self.columns.iter_mut().for_each(|column| column.values.truncate(self.rows));
            self.empty_rows += usize::from(count > 1);
            return Ok(());
        }
        let is_open = self.layout.has_open_end && count > self.columns.len();
        if count != self.columns.len() && !is_open {
            self.odd_rows += 1;
            self.first_odd.get_or_insert((self.line - 1, count));
            self.columns.iter_mut().for_each(|column| column.values.resize(self.rows + 1, f64::NAN));
        }
        self.rows += 1;
        self.budget
            .take(NUMBER_BYTES * self.columns.len() as u64, || format!("its table has over {} rows", self.rows))?;
        let (line, cells) = self.first_odd.unwrap_or_default();
        if self.odd_rows > MIN_ODD_ROWS && self.odd_rows as f64 > ODD_ROW_SHARE * self.rows as f64 {
            let wanted = self.columns.len();
            let what = format!(
                "line {line} has {cells} cells, expected {wanted}; {} more lines have the same fault",
                self.odd_rows - 1
            );
            return Err(LoadError::Damaged { path: self.path.to_owned(), format: self.layout.format(), what });
        }
        Ok(())
    }

    fn into_channels(self, source: &mut Source, warnings: &mut Vec<Message>) {
        if let Some((line, cells)) = self.first_odd {
            let (wanted, count) = (self.columns.len(), self.odd_rows);
            warnings.push(message!(
                "line {} has {} cells where {} are expected ({} such lines); missing ones are NaN",
                line,
                cells,
                wanted,
                count
            ));
        }
        if self.empty_rows > 0 {
            warnings.push(message!("{} lines without a value are left out", self.empty_rows));
        }
        let single = self.columns.len() == 1;
        for (index, column) in self.columns.into_iter().enumerate() {
            let given = self.layout.names.get(index).filter(|name| !name.is_empty());
            let plain = if single { "column".to_owned() } else { format!("column[{index}]") };
            let mut name = given.cloned().unwrap_or(plain);
            if column.filled == 0 && given.is_none() {
                continue;
            }
            if (column.filled - column.words) as f64 <= NUMERIC_SHARE * column.filled as f64 && column.filled > 0 {
                let word = column.first_word.map(|(_, word)| word).unwrap_or_default();
                if is_time_name(&name) || word.contains(':') {
                    source.unread_time.get_or_insert_with(|| (name.clone(), one_line(&word)));
                }
                source.notes.push((name, format!("text, for example '{word}'")));
                continue;
            }
            warnings.extend(column.describe_words(&name));
            if source.has_channel(&name) {
                let unique = format!("{name} (column {})", index + 1);
                warnings.push(message!(
                    "two columns are called {}; the later one is listed as {}",
                    quoted(&name),
                    quoted(&unique)
                ));
                name = unique;
            }
            let mut unit = self.layout.units.get(index).cloned().flatten();
            let stamps = column.times_of_day + column.dated;
            let is_time_of_day = stamps > 0 && stamps + column.words == column.filled;
            let mut values = column.values;
            if let Some((mark, count, largest)) = take_marks(&mut values) {
                warnings.push(message!(
                    "{}: {} cells are {}, all others within +-{:.4}: they count as missing",
                    quoted(&name),
                    count,
                    mark,
                    largest
                ));
            }
            let may_be_digits = !is_time_of_day && is_time_name(&name);
            if may_be_digits && unit.as_deref().is_some_and(|unit| UNIX_TIMES.contains(&unit.to_lowercase().as_str())) {
                unit = Some("s".to_owned());
            }
            let states_none = unit.as_deref().is_none_or(|unit| unit.to_lowercase().starts_with("hhmmss"));
            let is_digits = may_be_digits && states_none && read_digits(&mut values);
            if is_digits {
                warnings.push(message!("{} is written as hhmmss: it is read as times of day", quoted(&name)));
            }
            let is_time_of_day = is_time_of_day || is_digits;
            if is_time_of_day {
                unit = Some("s".to_owned());
                let midnights = if column.dated > 0 { 0 } else { pass_midnight(&mut values) };
                if midnights > 0 {
                    warnings.push(message!("{} passes midnight: a day is added to the times after it", quoted(&name)));
                }
            }
            if index == 0 && !single {
                source.first_column = Some(source.channels.len());
            }
            source.channels.push(ChannelInfo { is_time_of_day, ..ChannelInfo::new(name, unit, values) });
        }
    }
}

impl Column {
    /// Which cells of the column `name` are not numbers; none where all are.
    fn describe_words(&self, name: &str) -> Option<Message> {
        let (line, word) = self.first_word.as_ref()?;
        Some(message!(
            "{}: {} cells are not numbers and count as missing, the first {} in line {}",
            quoted(name),
            self.words,
            quoted(word),
            *line
        ))
    }

    fn push(&mut self, cell: &[u8], decimal_comma: bool, line: usize) {
        if cell.is_empty() {
            self.values.push(f64::NAN);
            return;
        }
        self.filled += 1;
        match Stamp::parse(cell) {
            Some(Stamp::OfDay(_)) => self.times_of_day += 1,
            Some(Stamp::Dated(_)) => self.dated += 1,
            None => {}
        }
        let value = number(cell, decimal_comma).unwrap_or_else(|| {
            self.words += 1;
            self.first_word.get_or_insert_with(|| (line, String::from_utf8_lossy(cell).chars().take(40).collect()));
            f64::NAN
        });
        self.values.push(value);
    }
}

/// Lets times of day (s) increase past midnight; how often it is passed.
fn pass_midnight(values: &mut [f64]) -> usize {
    const DAY_S: f64 = 86_400.0;
    let (mut midnights, mut before) = (0, f64::NAN);
    for value in values {
        midnights += usize::from(before - *value > 0.5 * DAY_S);
        if value.is_finite() {
            before = *value;
        }
        *value += DAY_S * midnights as f64;
    }
    midnights
}

fn memchr_quote(data: &[u8]) -> bool {
    data.contains(&b'"')
}

/// Numbers that recorders write where there is no value, without their sign.
const MARKS: [f64; 15] = [
    999.0, 999.9, 9999.0, 9999.9, 32_767.0, 32_768.0, 65_535.0, 99_999.0, 999_999.0, 9_999_999.0, 2_147_483_647.0,
    2_147_483_648.0, 1e20, 1e30, 3.402_823_5e38,
];
/// How many times larger than all other values such a number is, or how many times their range it is away from them.
const MARK_TIMES: f64 = 10.0;
/// Relative rounding of such a number.
const MARK_ROUNDING: f64 = 1e-7;

/// Turns the cells into NaN that hold a mark of no value; the mark, how many there were and the largest of the others.
fn take_marks(values: &mut [f64]) -> Option<(f64, usize, f64)> {
    let is_mark = |value: f64| MARKS.iter().any(|mark| (value.abs() - mark).abs() <= MARK_ROUNDING * mark);
    let [least, greatest] = extent(&*values)?;
    let mark = [greatest, least].into_iter().filter(|end| is_mark(*end)).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let others: Vec<f64> = values.iter().copied().filter(|value| *value != mark).collect();
    let [least, greatest] = extent(&others)?;
    let largest = greatest.max(-least);
    let away = (least - mark).max(mark - greatest);
    let is_apart = greatest > least && away >= MARK_TIMES * (greatest - least);
    if largest == 0.0 || !(is_apart || mark.abs() >= MARK_TIMES * largest) {
        return None;
    }
    let marked = values.iter_mut().filter(|value| **value == mark);
    let count = marked.map(|value| *value = f64::NAN).count();
    Some((mark, count, largest))
}
