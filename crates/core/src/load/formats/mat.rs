//! MATLAB level 5 MAT-files: numbers, text, cells and structs, compressed or not, of either byte order.
//!
//! Form: MathWorks, "MAT-File Format", R2023b, chapter 1.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use crate::load::budget::Budget;
use crate::load::contents::one_line;
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::load::pieces::Pieces;

/// Deepest nesting of cells and structs that is followed.
const MAX_DEPTH: usize = 32;
/// Bytes of the header before the first element.
const HEADER_BYTES: usize = 128;

/// Element types.
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

pub(crate) struct Variable {
    pub name: String,
    pub value: Value,
}

/// Fields of a struct; elements of an array share their names.
pub(crate) type Fields = Vec<(Arc<str>, Value)>;

/// What a variable, cell or field holds.
pub(crate) enum Value {
    /// Real numbers column by column; all dimensions after the first count as columns.
    Numbers { rows: usize, columns: usize, values: Arc<[f64]> },
    /// Rows of characters.
    Text(Vec<String>),
    /// Cells in memory order.
    Cells(Vec<Value>),
    /// Fields of each element of a struct array.
    Structs(Vec<Fields>),
    /// A kind that is not read, with its name.
    Unread(&'static str),
}

/// Reads all variables of the file, one after the other.
pub(crate) fn variables(path: &Path, budget: &Budget<'_>) -> Result<Vec<Variable>, LoadError> {
    let mut pieces = budget.pieces()?;
    let big = pieces.get(126, 2) == Some(b"MI");
    let mut variables = Vec::new();
    let mut at = HEADER_BYTES;
    while at < pieces.len() {
        let count = element_bytes(&mut pieces, at, big);
        let Some(bytes) = pieces.get(at, count) else { break };
        let mut file = Cursor { path, bytes, base: at, at: 0, big, budget };
        let element = file.element("a variable")?;
        match element.kind {
            MI_COMPRESSED => {
                let plain = inflate(path, element.data, budget)?;
                let mut inner = Cursor { path, bytes: &plain, base: 0, at: 0, big, budget };
                let element = inner.element("a compressed variable")?;
                if element.kind == MI_MATRIX {
                    variables.extend(file.within(element.data).matrix(0)?);
                }
                budget.give_back(plain.len() as u64);
            }
            MI_MATRIX => variables.extend(file.within(element.data).matrix(0)?),
            kind => {
                let end = at + file.at;
                return Err(file.damaged(format!("element of type {kind} at byte {end} is not a variable")));
            }
        }
        at += file.at;
    }
    pieces.check()?;
    Ok(variables)
}

/// Bytes of the element at a place with its tag and what fills it up to whole words, as far as the file goes.
fn element_bytes(pieces: &mut Pieces<'_>, at: usize, big: bool) -> usize {
    let left = pieces.len() - at;
    let word = |bytes: &[u8], at: usize| {
        let word = *bytes.get(at..)?.first_chunk()?;
        Some(if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    };
    let tag = pieces.get(at, 8.min(left)).and_then(|tag| Some((word(tag, 0)?, word(tag, 4)?)));
    let bytes = match tag {
        Some((kind, size)) if kind >> 16 == 0 => (size as usize).saturating_add(8 + 7),
        _ => 8,
    };
    bytes.min(left)
}

/// Bytes decompressed between two looks at the budget.
const BLOCK: u64 = 1 << 20;

/// Decompresses one variable; its size grows with what is really there, and is taken from the budget.
fn inflate(path: &Path, data: &[u8], budget: &Budget<'_>) -> Result<Vec<u8>, LoadError> {
    let mut plain = Vec::new();
    let mut decoder = flate2::read::ZlibDecoder::new(data);
    loop {
        let read = decoder.by_ref().take(BLOCK).read_to_end(&mut plain).map_err(|cause| {
            let what = format!("a compressed variable does not decompress ({cause})");
            LoadError::Damaged { path: path.to_owned(), format: Format::MatV5, what }
        })?;
        if read == 0 {
            return Ok(plain);
        }
        budget.take(read as u64, || format!("a compressed variable has over {} MB", plain.len() / 1_000_000))?;
    }
}

/// A tagged piece of data.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

/// A place in a file or in a decompressed variable.
struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// Place of the bytes in the file, or in what was decompressed.
    base: usize,
    at: usize,
    big: bool,
    budget: &'a Budget<'a>,
}

impl<'a> Cursor<'a> {
    fn damaged(&self, what: String) -> LoadError {
        LoadError::Damaged { path: self.path.to_owned(), format: Format::MatV5, what }
    }

    fn within<'b>(&self, bytes: &'b [u8]) -> Cursor<'b>
    where
        'a: 'b,
    {
        Cursor { path: self.path, bytes, base: 0, at: 0, big: self.big, budget: self.budget }
    }

    fn take(&mut self, count: usize, what: &'static str) -> Result<&'a [u8], LoadError> {
        let left = self.bytes.len().saturating_sub(self.at);
        if count > left {
            let (path, format, at) = (self.path.to_owned(), Format::MatV5, self.base + self.at);
            return Err(LoadError::Truncated { path, format, at, what, needed: count as u64, left: left as u64 });
        }
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
        Ok(taken)
    }

    fn word(&mut self, what: &'static str) -> Result<u32, LoadError> {
        let bytes = self.take(4, what)?;
        let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
        Ok(if self.big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    }

    /// The next element, of the long form or the short one that holds up to four bytes inside its tag.
    fn element(&mut self, what: &'static str) -> Result<Element<'a>, LoadError> {
        let tag = self.word(what)?;
        if tag >> 16 != 0 {
            let (kind, size) = (tag & 0xffff, (tag >> 16) as usize);
            let data = self.take(4, what)?;
            if size > 4 {
                return Err(self.damaged(format!("short element of {size} bytes at byte {}", self.base + self.at)));
            }
            return Ok(Element { kind, data: &data[..size] });
        }
        let size = self.word(what)? as usize;
        let data = self.take(size, what)?;
        if tag != MI_COMPRESSED {
            self.at = self.bytes.len().min(self.at + (8 - size % 8) % 8);
        }
        Ok(Element { kind: tag, data })
    }

    /// The array that fills this cursor; nothing for an empty cell.
    fn matrix(&mut self, depth: usize) -> Result<Option<Variable>, LoadError> {
        if self.bytes.is_empty() {
            return Ok(None);
        }
        if depth > MAX_DEPTH {
            return Err(self.damaged(format!("cells and structs nest deeper than {MAX_DEPTH}")));
        }
        let flags = self.element("array flags")?;
        let flags = self.within(flags.data).word("array flags")?;
        let dims = self.element("dimensions")?;
        let dims = numbers(&dims, self.big).ok_or_else(|| self.damaged("dimensions are not integers".to_owned()))?;
        let name = self.element("a name")?;
        let name = word_of(name.data);
        let count = dims.iter().try_fold(1_usize, |product, &dim| product.checked_mul(dim as usize));
        let Some(count) = count.filter(|_| dims.len() >= 2 && dims.iter().all(|dim| *dim >= 0.0)) else {
            return Err(self.damaged(format!("variable '{name}' has impossible dimensions {}", shown(&dims))));
        };
        let rows = dims[0] as usize;
        let value = match flags & 0xff {
            1 => Value::Cells(self.children(&name, count, depth)?),
            2 => Value::Structs(self.structs(&name, count, depth)?),
            3 => {
                self.element("a class name")?;
                Value::Structs(self.structs(&name, count, depth)?)
            }
            4 => Value::Text(self.text(rows, count)?),
            5 => Value::Unread("sparse"),
            6..=15 if flags & 0x0800 != 0 => Value::Unread("complex"),
            6..=15 => Value::Numbers { rows, columns: count / rows.max(1), values: self.values(&name, count)? },
            16 => Value::Unread("a function handle"),
            _ => Value::Unread("an object"),
        };
        Ok(Some(Variable { name, value }))
    }

    fn values(&mut self, name: &str, count: usize) -> Result<Arc<[f64]>, LoadError> {
        let data = self.element("numbers")?;
        // Numbers of a byte become numbers of eight.
        let bytes = (data.data.len() as u64).min(count as u64).saturating_mul(size_of::<f64>() as u64);
        self.budget.take(bytes, || format!("variable '{name}' has {count} numbers"))?;
        let values = numbers(&data, self.big)
            .ok_or_else(|| self.damaged(format!("variable '{name}' has numbers of unknown type {}", data.kind)))?;
        if values.len() != count {
            let (is, kind) = (values.len(), self.path.display());
            return Err(
                self.damaged(format!("variable '{name}' of {kind} has {is} numbers, its dimensions give {count}"))
            );
        }
        Ok(values)
    }

    /// Rows of characters, which are stored column by column.
    fn text(&mut self, rows: usize, count: usize) -> Result<Vec<String>, LoadError> {
        let data = self.element("characters")?;
        let codes: Vec<u32> = if data.kind == 16 {
            String::from_utf8_lossy(data.data).chars().map(u32::from).collect()
        } else {
            let codes = numbers(&data, self.big);
            let codes = codes.ok_or_else(|| self.damaged("characters of unknown type".to_owned()))?;
            codes.iter().map(|code| *code as u32).collect()
        };
        if data.kind != 16 && codes.len() != count {
            return Err(self.damaged(format!("text has {} characters, its dimensions give {count}", codes.len())));
        }
        // Without characters there may be any number of rows. Letters of several bytes may be counted otherwise: one row then.
        let letter = |code: &u32| char::from_u32(*code).unwrap_or(char::REPLACEMENT_CHARACTER);
        if codes.len() != count || rows <= 1 || count == 0 {
            return Ok(vec![codes.iter().map(letter).collect()]);
        }
        let row = |row: usize| codes.iter().skip(row).step_by(rows).map(letter).collect();
        Ok((0..rows).map(row).collect())
    }

    fn child(&mut self, depth: usize) -> Result<Value, LoadError> {
        let element = self.element("a cell or field")?;
        if element.kind != MI_MATRIX {
            return Err(self.damaged(format!("cell or field of type {} is not an array", element.kind)));
        }
        let variable = self.within(element.data).matrix(depth + 1)?;
        Ok(variable.map_or(Value::Cells(Vec::new()), |variable| variable.value))
    }

    /// Refuses a count that the bytes left cannot hold, at eight bytes a child.
    fn check_children(&self, name: &str, count: usize) -> Result<(), LoadError> {
        let left = self.bytes.len().saturating_sub(self.at);
        if count > left / 8 {
            return Err(self.damaged(format!("'{name}' claims {count} elements in {left} bytes")));
        }
        Ok(())
    }

    fn children(&mut self, name: &str, count: usize, depth: usize) -> Result<Vec<Value>, LoadError> {
        self.check_children(name, count)?;
        (0..count).map(|_| self.child(depth)).collect()
    }

    fn structs(&mut self, name: &str, count: usize, depth: usize) -> Result<Vec<Fields>, LoadError> {
        let length = self.element("length of field names")?;
        let length = numbers(&length, self.big).and_then(|values| values.first().copied()).unwrap_or(0.0) as usize;
        let names = self.element("field names")?.data;
        if length == 0 && !names.is_empty() {
            return Err(self.damaged(format!("struct '{name}' has field names of no length")));
        }
        let fields: Vec<Arc<str>> = names.chunks_exact(length.max(1)).map(|name| word_of(name).into()).collect();
        if fields.is_empty() {
            return Ok(Vec::new());
        }
        self.check_children(name, count.saturating_mul(fields.len()))?;
        (0..count).map(|_| fields.iter().map(|field| Ok((field.clone(), self.child(depth)?))).collect()).collect()
    }
}

/// The first of some dimensions.
fn shown(dims: &[f64]) -> String {
    const MOST: usize = 8;
    let more = if dims.len() > MOST { format!(" and {} more", dims.len() - MOST) } else { String::new() };
    let first: Vec<_> = dims.iter().take(MOST).map(|dim| format!("{dim:.0}")).collect();
    format!("{}{more}", first.join(" x "))
}

/// A name, up to its end or the first NUL.
fn word_of(bytes: &[u8]) -> String {
    let word: String = bytes.iter().take_while(|&&byte| byte != 0).map(|&byte| char::from(byte)).collect();
    one_line(&word)
}

/// Numbers of an element as f64, whatever type they are stored in; `None` for a type that is no number.
fn numbers(element: &Element<'_>, big: bool) -> Option<Arc<[f64]>> {
    macro_rules! read {
        ($type:ty) => {{
            const SIZE: usize = size_of::<$type>();
            let number =
                |bytes: &[u8; SIZE]| if big { <$type>::from_be_bytes(*bytes) } else { <$type>::from_le_bytes(*bytes) };
            element.data.as_chunks::<SIZE>().0.iter().map(|bytes| number(bytes) as f64).collect()
        }};
    }
    Some(match element.kind {
        1 => read!(i8),
        2 | 16 => read!(u8),
        3 => read!(i16),
        4 | 17 => read!(u16),
        5 => read!(i32),
        6 | 18 => read!(u32),
        7 => read!(f32),
        9 => read!(f64),
        12 => read!(i64),
        13 => read!(u64),
        _ => return None,
    })
}
