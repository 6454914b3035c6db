//! MAT-files of level 5.
//!
//! Form: MathWorks, "MAT-File Format", R2023b, chapter 1.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{Names, Values};

/// Types of elements.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of arrays.
const CELL_CLASS: u32 = 1;
const STRUCT_CLASS: u32 = 2;
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;
/// Longest name of a variable or field, without the byte that ends it.
pub(crate) const LONGEST_NAME: usize = 63;

/// What a variable or field holds.
pub(crate) enum Node<'a> {
    /// A column.
    Numbers(&'a [f64]),
    /// A column of time histories.
    Column(&'a Values<'a>),
    /// A matrix by its columns, with the number of its rows.
    Matrix(&'a [f64], usize),
    /// A line.
    Text(&'a str),
    /// A column of cells, each a line.
    Lines(Vec<&'a str>),
    /// A struct.
    Fields(Vec<(String, Node<'a>)>),
}

impl<'a> Node<'a> {
    /// Puts `leaf` at the end of `path`, making structs on the way.
    pub(crate) fn insert(&mut self, path: &str, leaf: Node<'a>) {
        let Self::Fields(fields) = self else { return };
        let (head, rest) = path.split_once('/').map_or((path, None), |(head, rest)| (head, Some(rest)));
        let name = identifier(head);
        match rest {
            None => {
                let mut names = Names::default();
                fields.iter().for_each(|(taken, _)| drop(names.unique(taken.clone(), LONGEST_NAME)));
                fields.push((names.unique(name, LONGEST_NAME), leaf));
            }
            Some(rest) => {
                let known = fields.iter().position(|(other, node)| *other == name && matches!(node, Self::Fields(_)));
                let place = known.unwrap_or_else(|| {
                    fields.push((name, Self::Fields(Vec::new())));
                    fields.len() - 1
                });
                fields[place].1.insert(rest, leaf);
            }
        }
    }
}

/// A name MATLAB takes: letters, digits and `_`, a letter first.
pub(crate) fn identifier(name: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut text: String = name.chars().map(keep).collect();
    if !text.starts_with(|c: char| c.is_ascii_alphabetic()) {
        text.insert(0, 'w');
    }
    text.truncate(LONGEST_NAME);
    text
}

/// Text, no subsystem, version 1.0, little-endian.
pub(crate) fn header() -> [u8; 128] {
    let mut header = [b' '; 128];
    let text = concat!("MATLAB 5.0 MAT-file, written by doublet ", env!("CARGO_PKG_VERSION"));
    header[..text.len()].copy_from_slice(text.as_bytes());
    header[116..124].fill(0);
    header[124..126].copy_from_slice(&0x0100_u16.to_le_bytes());
    header[126..128].copy_from_slice(b"IM");
    header
}

/// A tagged element, padded to eight bytes; `None` when it is too large for its tag.
fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) -> Option<()> {
    out.extend(kind.to_le_bytes());
    out.extend(u32::try_from(data.len()).ok()?.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Some(())
}

/// One array with its tag.
fn matrix(name: &str, node: &Node<'_>) -> Option<Vec<u8>> {
    let (class, rows, columns) = match node {
        Node::Numbers(values) => (DOUBLE_CLASS, values.len(), 1),
        Node::Column(values) => (DOUBLE_CLASS, values.len(), 1),
        Node::Matrix(values, rows) => (DOUBLE_CLASS, *rows, values.len().checked_div(*rows).unwrap_or(0)),
        Node::Lines(lines) => (CELL_CLASS, lines.len(), 1),
        Node::Text(text) => (CHAR_CLASS, 1, text.encode_utf16().count()),
        Node::Fields(_) => (STRUCT_CLASS, 1, 1),
    };
    let mut body = Vec::new();
    element(&mut body, UINT32, &[class.to_le_bytes(), [0; 4]].concat())?;
    let dimensions = [i32::try_from(rows).ok()?.to_le_bytes(), i32::try_from(columns).ok()?.to_le_bytes()];
    element(&mut body, INT32, &dimensions.concat())?;
    element(&mut body, INT8, name.as_bytes())?;
    match node {
        Node::Numbers(values) | Node::Matrix(values, _) => {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            element(&mut body, DOUBLE, &bytes)?;
        }
        Node::Column(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(f64::to_le_bytes).collect();
            element(&mut body, DOUBLE, &bytes)?;
        }
        Node::Text(text) => {
            let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            element(&mut body, UINT16, &bytes)?;
        }
        Node::Lines(lines) => {
            for line in lines {
                body.extend(matrix("", &Node::Text(line))?);
            }
        }
        Node::Fields(fields) => {
            const WIDTH: usize = LONGEST_NAME + 1;
            // The length of the names is a small element: its four bytes lie within the tag.
            body.extend((INT32 | 4 << 16).to_le_bytes());
            body.extend((WIDTH as u32).to_le_bytes());
            let mut names = vec![0; WIDTH * fields.len()];
            for (place, (field, _)) in names.chunks_exact_mut(WIDTH).zip(fields) {
                place[..field.len()].copy_from_slice(field.as_bytes());
            }
            element(&mut body, INT8, &names)?;
            for (_, value) in fields {
                body.extend(matrix("", value)?);
            }
        }
    }
    let mut bytes = Vec::with_capacity(body.len() + 8);
    element(&mut bytes, MATRIX, &body)?;
    Some(bytes)
}

/// Writes a variable; `None` where it is larger than the 2 GB one may have.
pub(crate) fn write_variable(out: &mut impl Write, name: &str, node: &Node<'_>) -> std::io::Result<Option<()>> {
    let Some(variable) = matrix(name, node).filter(|bytes| bytes.len() < i32::MAX as usize) else { return Ok(None) };
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(&variable)?;
    let packed = packed.finish()?;
    // A compressed element is not padded.
    let Ok(length) = u32::try_from(packed.len()) else { return Ok(None) };
    for bytes in [&COMPRESSED.to_le_bytes()[..], &length.to_le_bytes(), &packed] {
        out.write_all(bytes)?;
    }
    Ok(Some(()))
}
