//! Lines of text as the loader knows them, a piece at a time.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::load::formats::text::columns_of;
use crate::load::formats::text_layout::TextLayout;

use crate::load::row::{StreamChannel, StreamRow};

/// Lines of numbers that settle how a text is laid out.
const SETTLING_LINES: usize = 5;
/// Bytes after which a text without a table of numbers is given up.
const MOST_HEAD_BYTES: usize = 64 * 1024;
/// Longest line, bytes.
const MOST_LINE_BYTES: usize = 1 << 20;

/// Decodes lines of text: separator, header and units are found as in a whole file. A line that has not ended is held back.
#[derive(Debug)]
pub struct TextDecoder {
    name: Arc<str>,
    path: PathBuf,
    layout: Option<TextLayout>,
    channels: Arc<[StreamChannel]>,
    pending: Vec<u8>,
    /// Bytes in which no layout was found.
    tried: usize,
    /// Bytes that could not be understood: lines of another shape than the rest, or text without a table.
    pub refused_bytes: usize,
}

impl TextDecoder {
    /// For the text of a source called `name`.
    pub fn new(name: &str) -> Self {
        let (name, path) = (Arc::from(name), Path::new(name).to_path_buf());
        Self { name, path, layout: None, channels: Arc::default(), pending: Vec::new(), tried: 0, refused_bytes: 0 }
    }

    /// Takes in what arrived and adds the rows that ended in it.
    pub fn push(&mut self, bytes: &[u8], rows: &mut Vec<StreamRow>) {
        self.pending.extend_from_slice(bytes);
        let Some(end) = self.pending.iter().rposition(|byte| *byte == b'\n').map(|at| at + 1) else {
            if self.pending.len() > MOST_LINE_BYTES {
                self.refuse();
            }
            return;
        };
        if self.layout.is_none() {
            // Looked for again only where there is a good part more to look at.
            if 4 * end < 5 * self.tried {
                return;
            }
            match self.find_layout(end, SETTLING_LINES) {
                Some(start) => self.decode(start, end, rows),
                None if self.pending.len() > MOST_HEAD_BYTES => self.refuse(),
                None => self.tried = end,
            }
            return;
        }
        self.decode(0, end, rows);
    }

    /// The text has ended: fewer lines are enough to settle how it is laid out. A last line without an end stays out.
    pub fn finish(&mut self, rows: &mut Vec<StreamRow>) {
        let Some(end) = self.pending.iter().rposition(|byte| *byte == b'\n').map(|at| at + 1) else { return };
        if self.layout.is_none()
            && let Some(start) = self.find_layout(end, 1)
        {
            self.decode(start, end, rows);
        }
    }

    fn refuse(&mut self) {
        self.refused_bytes += self.pending.len();
        self.pending.clear();
        self.tried = 0;
    }

    /// Looks for the layout in the first `end` bytes, with at least so many lines of numbers; where these begin.
    fn find_layout(&mut self, end: usize, least_lines: usize) -> Option<usize> {
        let head = &self.pending[..end];
        let layout = TextLayout::find(head)?;
        let data = head.get(layout.data_at..)?;
        if data.iter().filter(|byte| **byte == b'\n').count() < least_lines {
            return None;
        }
        let mut channels: Vec<StreamChannel> = Vec::with_capacity(layout.columns);
        for index in 0..layout.columns {
            let given = layout.names.get(index).filter(|name| !name.is_empty()).cloned();
            let mut name = given.unwrap_or_else(|| format!("column[{index}]"));
            if channels.iter().any(|channel| channel.name == name) {
                name = format!("{name} (column {})", index + 1);
            }
            channels.push(StreamChannel { name, unit: layout.units.get(index).cloned().flatten() });
        }
        let start = layout.data_at;
        self.channels = channels.into();
        self.layout = Some(layout);
        Some(start)
    }

    /// Decodes the lines from `start` to `end` and forgets them.
    fn decode(&mut self, start: usize, end: usize, rows: &mut Vec<StreamRow>) {
        let Some(layout) = &self.layout else { return };
        match columns_of(&self.path, layout, &self.pending[start..end]) {
            Ok(columns) => {
                for k in 0..columns.first().map_or(0, Vec::len) {
                    let values = columns.iter().map(|column| column.get(k).copied().unwrap_or(f64::NAN)).collect();
                    let (source, channels) = (Arc::clone(&self.name), Arc::clone(&self.channels));
                    rows.push(StreamRow { source, channels, values });
                }
            }
            Err(_) => self.refused_bytes += end - start,
        }
        self.pending.drain(..end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_same_whatever_the_pieces_the_text_comes_in() {
        let mut text = String::from("recorder 7\ntime;alpha\ns;deg\n");
        for k in 0..40 {
            text.push_str(&format!("0,{k:02};{k}\n"));
        }
        text.push_str("0,40;4");
        let decode = |piece: usize| {
            let (mut decoder, mut rows) = (TextDecoder::new("log"), Vec::new());
            text.as_bytes().chunks(piece).for_each(|bytes| decoder.push(bytes, &mut rows));
            decoder.finish(&mut rows);
            rows
        };
        let whole = decode(text.len());
        assert_eq!(whole.len(), 40, "the line that has not ended is held back");
        assert_eq!((whole[3].values.as_slice(), whole[3].channels[1].unit.as_deref()), (&[0.03, 3.0][..], Some("deg")));
        for piece in [1, 2, 7, 64] {
            assert_eq!(decode(piece), whole, "in pieces of {piece}");
        }
    }
}
