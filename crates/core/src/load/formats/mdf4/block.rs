//! Blocks of a file and the links between them.

use std::collections::HashSet;

use crate::load::contents::one_line;
use crate::load::pieces::Pieces;

/// Bytes of a block before its links.
const BLOCK_HEAD: usize = 24;
/// Bytes of a text that are looked at, and letters of a name or unit.
const MOST_TEXT: usize = 1 << 16;
const MOST_LETTERS: usize = 1000;
/// Links and bytes of its data that are kept of a block; no block needs more but a list of blocks, a text and a conversion.
const LINKS: usize = 8;
const DATA: usize = 96;

/// A block: two letters of its name, the first of its links, the first of its data and where they lie.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) id: [u8; 2],
    links: [u64; LINKS],
    pub(super) links_at: usize,
    pub(super) link_count: usize,
    data: [u8; DATA],
    pub(super) data_at: usize,
    pub(super) data_bytes: usize,
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

impl Block {
    /// The block at a place of the file; `None` where none fits.
    pub(super) fn at(file: &mut Pieces<'_>, place: u64) -> Option<Self> {
        let start = usize::try_from(place).ok().filter(|start| *start > 0)?;
        let head = file.get(start, BLOCK_HEAD)?;
        let length = usize::try_from(u64_at(head, 8)?).ok()?;
        let link_count = usize::try_from(u64_at(head, 16)?).ok()?;
        let id = *head.strip_prefix(b"##")?.first_chunk()?;
        let links_at = start + BLOCK_HEAD;
        let data_at = links_at.checked_add(link_count.checked_mul(8)?)?;
        let end = start.checked_add(length).filter(|end| *end <= file.len())?;
        let data_bytes = end.checked_sub(data_at)?;
        let (mut links, mut data) = ([0; LINKS], [0; DATA]);
        let known = file.get(links_at, 8 * link_count.min(LINKS))?;
        links.iter_mut().enumerate().for_each(|(index, link)| *link = u64_at(known, 8 * index).unwrap_or(0));
        let known = file.get(data_at, data_bytes.min(DATA))?;
        data[..known.len()].copy_from_slice(known);
        Some(Self { id, links, links_at, link_count, data, data_at, data_bytes })
    }

    /// The first of its data.
    pub(super) fn data(&self) -> &[u8] {
        &self.data[..self.data_bytes.min(DATA)]
    }

    /// The place a link leads to; 0 where it leads nowhere.
    pub(super) fn link(&self, index: usize) -> u64 {
        self.links.get(index).copied().unwrap_or(0)
    }

    /// The block a link leads to, where it is one of the kind `id`.
    pub(super) fn follow(&self, file: &mut Pieces<'_>, index: usize, id: &[u8]) -> Option<Self> {
        Self::at(file, self.link(index)).filter(|block| block.id == id)
    }

    /// Text that a link leads to; of XML what stands in its first element of text.
    pub(super) fn text(&self, file: &mut Pieces<'_>, index: usize) -> Option<String> {
        let block = Self::at(file, self.link(index))?;
        let data = file.get(block.data_at, block.data_bytes.min(MOST_TEXT))?;
        let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
        let text = String::from_utf8_lossy(&data[..end]);
        let plain = match &block.id {
            b"TX" => &text,
            b"MD" => text.split_once("<TX>")?.1.split_once("</TX>")?.0,
            _ => return None,
        };
        Some(one_line(plain.trim()).chars().take(MOST_LETTERS).collect())
    }
}

/// Places of the blocks of a list that `first` begins, linked by their link 0; what is wrong where it leads to one of the blocks `visited`.
pub(super) fn chain(
    file: &mut Pieces<'_>,
    first: u64,
    id: &'static [u8],
    most: usize,
    visited: &mut HashSet<u64>,
) -> Result<Vec<u64>, String> {
    let (mut places, mut place) = (Vec::new(), first);
    while let Some(block) = Block::at(file, place).filter(|block| block.id == id && places.len() < most) {
        if !visited.insert(place) {
            return Err(circle(place));
        }
        places.push(place);
        place = block.link(0);
    }
    Ok(places)
}

/// What is wrong with links that come a second time to the block at `place`.
pub(super) fn circle(place: u64) -> String {
    format!("several links lead to the block at byte {place}")
}
