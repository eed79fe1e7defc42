//! Data of nodes: the section `$NodeData` of a text file.

use super::parts::{Section, Tags, tag};
use crate::read::error::InputError;
use crate::read::text::{Lines, Source, number};

/// Numbers of a list of nodes.
pub struct NodeData {
    /// The first string of the section.
    pub name: String,
    /// The number of each node in the order of the file, NaN for a node without one.
    pub values: Vec<f64>,
}

/// Reads the section after its first line. Returns `None` if the data are not one number for each node.
pub fn read<'a>(
    source: Source<'a>,
    lines: &mut Lines<'a>,
    tags: &Tags,
) -> Result<Option<NodeData>, InputError> {
    let mut section = Section { source, lines, what: "entries of $NodeData" };
    let mut name = String::new();
    let mut integers = Vec::new();
    // Strings, real numbers and integers, each with their number.
    for kind in 0..3 {
        let head = section.line(1, 0)?;
        let count = source.count(&head, head.words().next(), "the number of entries")?;
        for found in 0..count {
            let line = section.line(count, found)?;
            match kind {
                0 if found == 0 => {
                    let text = String::from_utf8_lossy(line.text.trim_ascii()).into_owned();
                    text.trim_matches('"').clone_into(&mut name);
                }
                2 => integers.push(source.count(&line, line.words().next(), "a whole number")?),
                _ => {}
            }
        }
    }
    let [_, components, rows, ..] = integers[..] else { return Ok(None) };
    let mut values = vec![f64::NAN; usize::try_from(tags.count).unwrap_or(0)];
    for found in 0..rows {
        let line = section.line(rows, found)?;
        let mut words = line.words();
        let tag = tag(source, &line, words.next())?;
        let word = words.next().ok_or_else(|| source.bad_line(&line, "a node and its number"))?;
        let value = number(word).ok_or_else(|| source.bad_number(&line, word))?;
        let index = tags.index(tag).ok_or_else(|| source.bad_line(&line, "the tag of a node above"))?;
        if let Some(slot) = values.get_mut(index as usize) {
            *slot = value;
        }
    }
    section.end("$endnodedata", rows, rows)?;
    Ok((components == 1).then_some(NodeData { name, values }))
}
