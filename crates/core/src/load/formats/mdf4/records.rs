//! Records of a data group, read part by part into the numbers of its channels.

use std::collections::HashMap;
use std::io::Read;

use super::block::{Block, u32_at, u64_at};
use super::group::{DataBlock, DataGroup};
use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::contents::{ChannelInfo, Source};
use crate::load::error::LoadError;
use crate::load::pieces::Pieces;

/// Bytes of records that are read at a time, at most.
const PART: usize = 1 << 20;

/// Gives the records of a data group to `add` part by part; the inner error says what is wrong with them.
pub(super) fn read_records(
    file: &mut Pieces<'_>,
    blocks: &[DataBlock],
    budget: &Budget<'_>,
    add: &mut impl FnMut(&[u8]) -> Result<(), LoadError>,
) -> Result<Result<(), String>, LoadError> {
    for DataBlock { place, is_compressed, .. } in blocks {
        let Some(block) = Block::at(file, *place) else { continue };
        if !is_compressed {
            for first in (0..block.data_bytes).step_by(PART) {
                let bytes = PART.min(block.data_bytes - first);
                let Some(part) = file.get(block.data_at + first, bytes) else { return Ok(Ok(())) };
                add(part)?;
            }
            continue;
        }
        match unpack(file, &block, budget)? {
            Ok(plain) => {
                add(&plain)?;
                budget.give_back(plain.len() as u64);
            }
            Err(what) => return Ok(Err(what)),
        }
    }
    Ok(Ok(()))
}

/// What a compressed block holds.
fn unpack(file: &mut Pieces<'_>, block: &Block, budget: &Budget<'_>) -> Result<Result<Vec<u8>, String>, LoadError> {
    let head = block.data();
    let (Some(&kind), Some(width), Some(length)) = (head.get(2), u32_at(head, 4), u64_at(head, 8)) else {
        return Ok(Err("a compressed block ends too early".to_owned()));
    };
    if kind > 1 {
        return Ok(Err(format!(
            "compression {kind} of a block is not read: only deflate (0) and transposed deflate (1) are"
        )));
    }
    budget.take(length, || "records".to_owned())?;
    let mut plain = Vec::new();
    let packed = file.get(block.data_at + 24.min(block.data_bytes), block.data_bytes.saturating_sub(24));
    let inflated = flate2::read::ZlibDecoder::new(packed.unwrap_or_default()).take(length).read_to_end(&mut plain);
    if inflated.is_err() || plain.len() as u64 != length {
        return Ok(Err("a compressed block is damaged: copy the file again".to_owned()));
    }
    let width = width as usize;
    if kind == 0 || width <= 1 {
        return Ok(Ok(plain));
    }
    // Whole rows were written column by column; what is left over follows as it is.
    let rows = plain.len() / width;
    budget.check(length, || "records".to_owned())?;
    let mut joined: Vec<u8> = (0..rows * width).map(|at| plain[at % width * rows + at / width]).collect();
    joined.extend_from_slice(&plain[rows * width..]);
    Ok(Ok(joined))
}

/// The numbers of the groups of a data group, whose records come part by part.
pub(super) struct Numbers<'g> {
    group: &'g DataGroup,
    by_id: HashMap<u64, usize>,
    values: Vec<Vec<Vec<f64>>>,
    /// Beginning of a record whose end is still to come.
    begun: Vec<u8>,
    /// Bytes still to come of a record that is passed over.
    passed_over: usize,
    /// Bytes after what is not a record, from which on nothing is known.
    behind: Option<usize>,
}

impl<'g> Numbers<'g> {
    pub(super) fn new(group: &'g DataGroup) -> Self {
        // Of two groups with one number the first counts.
        let by_id = group.groups.iter().enumerate().rev().map(|(index, group)| (group.id, index)).collect();
        let values = group.groups.iter().map(|group| vec![Vec::new(); group.fields.len()]).collect();
        Self { group, by_id, values, begun: Vec::new(), passed_over: 0, behind: None }
    }

    /// Adds what the records in the next bytes hold.
    pub(super) fn add(&mut self, bytes: &[u8], budget: &Budget<'_>) -> Result<(), LoadError> {
        if let Some(behind) = &mut self.behind {
            *behind += bytes.len();
            return Ok(());
        }
        let skipped = self.passed_over.min(bytes.len());
        self.passed_over -= skipped;
        let mut joined = std::mem::take(&mut self.begun);
        joined.extend_from_slice(&bytes[skipped..]);
        let mut at = 0;
        while let Some((start, index)) = self.next(&joined, at) {
            let Some(group) = index.and_then(|index| self.group.groups.get(index)) else {
                self.behind = Some(joined.len() - at);
                return Ok(());
            };
            if group.is_variable {
                let Some(length) = u32_at(&joined, start) else { break };
                let end = start.saturating_add(4).saturating_add(length as usize);
                self.passed_over = end.saturating_sub(joined.len());
                at = end.min(joined.len());
                continue;
            }
            let Some(record) = joined.get(start..start.saturating_add(group.record_bytes)) else { break };
            if record.is_empty() {
                self.behind = Some(joined.len() - at);
                return Ok(());
            }
            budget.take(NUMBER_BYTES * group.fields.len() as u64, || "the numbers of its records".to_owned())?;
            let values = &mut self.values[index.unwrap_or(0)];
            for (field, values) in group.fields.iter().zip(values) {
                values.push(field.value(record, group.data_bytes, values.len()));
            }
            at = start + record.len();
        }
        joined.drain(..at);
        self.begun = joined;
        budget.check(self.begun.len() as u64, || "a record".to_owned())
    }

    /// Where the record at a place begins behind its number, and its group; `None` where the number is not all there.
    fn next(&self, bytes: &[u8], at: usize) -> Option<(usize, Option<usize>)> {
        let id_bytes = self.group.id_bytes;
        let known = bytes.get(at..at + id_bytes)?;
        let mut id = [0; 8];
        id.get_mut(..id_bytes)?.copy_from_slice(known);
        let index = if id_bytes == 0 { Some(0) } else { self.by_id.get(&u64::from_le_bytes(id)).copied() };
        Some((at + id_bytes, index))
    }

    /// Bytes at the end that are not a whole record.
    pub(super) fn left(&self) -> usize {
        self.behind.unwrap_or(self.begun.len())
    }

    /// A source per group.
    pub(super) fn into_sources(self) -> impl Iterator<Item = Source> {
        let sources = self.group.groups.iter().zip(self.values).map(|(group, values)| {
            let mut source = Source::new(group.name.clone());
            for (field, values) in group.fields.iter().zip(values).filter(|(_, values)| !values.is_empty()) {
                let name = if field.is_master() { "time".to_owned() } else { field.name.clone() };
                let unit = field.unit.clone().or_else(|| field.is_master().then(|| "s".to_owned()));
                source.channels.push(ChannelInfo::new(name, unit, values));
            }
            source
        });
        sources.filter(|source| !source.channels.is_empty())
    }
}
