//! Chemical files: a count, a comment, then rows of an element and three numbers.

use super::collect::Collector;
use super::error::{InputError, Place, WeightError};
use super::points::{PointFile, ReadOptions};
use super::reading::OtherLines;
use super::text::{Line, Lines, Source, Words, excerpt, integer, number};
use super::weights::numbered;

/// A chemical file.
#[derive(Clone, Copy)]
pub(super) struct Chemistry {
    /// The number of atoms.
    count: u64,
    /// The number of fields before the coordinates.
    before: usize,
    /// The number of fields of the first atom.
    width: usize,
}

impl Chemistry {
    /// Recognises a chemical file by its first lines.
    ///
    /// If the second line has as many numbers as the third line has words, it is a point, and the file is a table
    /// with a count. If it is that number of words, it is the dimension of a table. The first word of an atom is a text, or a
    /// whole number from 1 to 118. A file with chosen columns, or of a dimension above 3, is a table.
    pub fn of(source: Source<'_>, options: &ReadOptions) -> Option<Self> {
        if options.columns.is_some() || options.dimension.is_some_and(|dimension| dimension > 3) {
            return None;
        }
        let mut lines = Lines::new(source.data);
        let mut words = lines.next()?.words();
        let count = integer(words.next()?).and_then(|n| u64::try_from(n).ok())?;
        if words.next().is_some() {
            return None;
        }
        let comment = lines.next();
        let before = comment.and_then(|line| before_coordinates(line.text));
        let atom = lines.find(|line| line.words().next().is_some());
        let width = atom.map_or(0, |atom| atom.words().count());
        let file = Chemistry { count, before: before.unwrap_or(1), width };
        let Some(atom) = atom else {
            return (count == 0).then_some(file);
        };
        let is_point = comment.is_some_and(|line| {
            line.words().count() == width && line.words().all(|word| number(word).is_some())
        });
        let is_atom = width >= file.before + 3
            && file.coordinates(&atom).all(|w| number(w).is_some())
            && (before.is_some() || atom.words().next().is_some_and(is_element));
        let is_dimension = comment.is_some_and(|line| {
            line.words().count() == 1 && line.words().next().and_then(integer) == Some(width as i64)
        });
        (is_atom && !is_point && !is_dimension).then_some(file)
    }

    fn coordinates<'a>(&self, atom: &Line<'a>) -> std::iter::Take<std::iter::Skip<Words<'a>>> {
        atom.words().skip(self.before).take(3)
    }

    /// Returns the position of the column of weights, which is given by its number.
    fn weight(&self, source: Source<'_>, name: &str) -> Result<usize, InputError> {
        let is_coordinate = |position: &usize| (self.before..self.before + 3).contains(position);
        let (width, shown) = (self.width, excerpt(name.as_bytes()));
        let problem = match numbered(name, width) {
            None if width == 0 => return Ok(0),
            None => format!("column {shown} is not one of 1 to {width}"),
            Some(position) if is_coordinate(&position) => {
                format!("column {shown} is a coordinate, and cannot be the weights")
            }
            Some(position) => return Ok(position),
        };
        let (path, problem) = (source.path.to_owned(), problem.into());
        Err(WeightError::Column { path, place: Place::Line(1), problem, names: Vec::new() }.into())
    }

    /// Reads the atoms.
    pub fn read(&self, source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
        let size = (self.count, source.data.len(), 8);
        let mut points = Collector::new(source, options, (Place::Line(1), 3), size)?;
        let weight = options.weight_column().map(|(name, _)| self.weight(source, name)).transpose()?;
        let mut lines = Lines::new(source.data);
        for line in lines.by_ref().skip(2).filter(|line| line.words().next().is_some()) {
            if points.met == self.count {
                return Err(source.surplus(line.place(), "atoms", self.count));
            }
            let word = weight.map(|position| line.words().nth(position).unwrap_or_default());
            points.push_parsed(&line, (&mut self.coordinates(&line), word), number)?;
        }
        if points.met < self.count {
            return Err(source.truncated(Place::Line(lines.number()), "atoms", self.count, points.met));
        }
        let note =
            "read as a chemical file: a count, a comment, then one atom per line; elements are ignored";
        points.notes.push(note.to_owned());
        let mut file = points.finish();
        file.reading.lines = OtherLines { counts: 1, comments: 1, ..OtherLines::default() };
        Ok(file)
    }
}

/// Whether the first word of an atom is an element: a text, or a number of an element.
fn is_element(word: &[u8]) -> bool {
    number(word).is_none() || integer(word).is_some_and(|number| (1..=118).contains(&number))
}

/// Returns the number of fields before the positions, as the comment of an extended file names them:
/// `Properties=species:S:1:pos:R:3`.
fn before_coordinates(comment: &[u8]) -> Option<usize> {
    let comment = String::from_utf8_lossy(comment);
    let (_, properties) = comment.split_once("Properties=")?;
    let properties = properties.trim_start_matches('"');
    let end = properties.find(|c: char| c.is_whitespace() || c == '"').unwrap_or(properties.len());
    let parts: Vec<&str> = properties[..end].split(':').collect();
    let mut before = 0_usize;
    for property in parts.chunks_exact(3) {
        let columns: usize = property[2].parse().ok()?;
        if property[0] == "pos" && columns == 3 {
            return Some(before);
        }
        before = before.checked_add(columns).filter(|before| *before < 1000)?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_name_the_columns() {
        for (comment, before) in [
            ("Lattice=\"5 0 0\" Properties=species:S:1:pos:R:3:forces:R:3", Some(1)),
            ("Properties=\"id:I:1:forces:R:3:pos:R:3\" pbc=T", Some(4)),
            ("Properties=pos:R:3", Some(0)),
            ("Properties=species:S:1", None),
            ("Properties=a:R:99999999999999999999:pos:R:3", None),
            ("water", None),
        ] {
            assert_eq!(before_coordinates(comment.as_bytes()), before, "{comment}");
        }
    }

    #[test]
    fn elements_are_texts_or_their_numbers() {
        for (word, yes) in [
            ("O", true),
            ("Si1", true),
            ("8", true),
            ("118", true),
            ("0", false),
            ("0.5", false),
            ("119", false),
        ] {
            assert_eq!(is_element(word.as_bytes()), yes, "{word}");
        }
    }
}
