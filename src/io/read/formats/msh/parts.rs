//! The tags of nodes, the lines of a section, versions and kinds of elements.

use std::collections::HashMap;

use crate::read::error::{InputError, Place};
use crate::read::mesh::CellKind;
use crate::read::text::{Line, Lines, Source, integer};

/// Node tags and their zero-based indices, which are the positions of the nodes in their section.
pub(super) struct Tags {
    pub(super) first: i64,
    pub(super) count: u64,
    /// The index of each tag. `None` if the tags are consecutive.
    map: Option<HashMap<i64, u64>>,
}

impl Tags {
    pub(super) fn new(tags: &[i64]) -> Self {
        let first = tags.first().copied().unwrap_or(1);
        let rising = tags.iter().enumerate().all(|(i, tag)| first.checked_add(i as i64) == Some(*tag));
        let map = || tags.iter().enumerate().map(|(i, tag)| (*tag, i as u64)).collect();
        Tags { first, count: tags.len() as u64, map: (!rising).then(map) }
    }

    /// Returns `true` if two nodes have the same tag.
    pub(super) fn doubled(&self) -> bool {
        self.map.as_ref().is_some_and(|map| (map.len() as u64) < self.count)
    }

    #[inline]
    pub(super) fn index(&self, tag: i64) -> Option<u64> {
        match &self.map {
            Some(map) => map.get(&tag).copied(),
            None => {
                tag.checked_sub(self.first).and_then(|i| u64::try_from(i).ok()).filter(|i| *i < self.count)
            }
        }
    }
}

/// Reads a section line by line.
pub(super) struct Section<'a, 'b> {
    pub(super) source: Source<'a>,
    pub(super) lines: &'b mut Lines<'a>,
    pub(super) what: &'static str,
}

impl<'a> Section<'a, '_> {
    /// Returns the next line of the section, or an error if the section ends.
    pub(super) fn line(&mut self, expected: u64, found: u64) -> Result<Line<'a>, InputError> {
        let line = self.lines.next_data().filter(|line| !line.text.trim_ascii().starts_with(b"$"));
        let place = Place::Line(self.lines.number());
        line.ok_or_else(|| self.source.truncated(place, self.what, expected, found))
    }

    pub(super) fn end(&mut self, name: &str, expected: u64, found: u64) -> Result<(), InputError> {
        let place = Place::Line(self.lines.number());
        match self.lines.next_data() {
            Some(line) if line.keyword() == name => {}
            Some(line) => return Err(self.source.surplus(line.place(), self.what, expected)),
            None => {
                return Err(self.source.truncated(place, "lines closing a section", 1, 0));
            }
        }
        if found < expected {
            return Err(self.source.truncated(place, self.what, expected, found));
        }
        Ok(())
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    Two,
    FourOne,
}

/// The advice for other versions.
pub(super) const ADVICE: &str = "save as version 2.2 or 4.1 (gmsh -format msh22 or msh41)";

pub(super) fn tag(source: Source<'_>, line: &Line<'_>, word: Option<&[u8]>) -> Result<i64, InputError> {
    let word = word.ok_or_else(|| source.bad_line(line, "a node tag"))?;
    integer(word).ok_or_else(|| source.bad_word(line, word, "a node tag"))
}

pub(super) fn kind(element: i64) -> CellKind {
    match element {
        1 | 15 => CellKind::Lower,
        2 => CellKind::Triangle,
        4 => CellKind::Tetrahedron,
        _ => CellKind::Other,
    }
}
