//! `.node` files: points of `TetGen` and Triangle.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::text::{Lines, Source, integer, number};

/// Reads a header `count dimension [attributes [marker]]`, then rows `id x y [z] …`. Ids are consecutive and start at
/// 0 or 1.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    const HEADER: &str = "the header `points dimension attributes marker`";
    let mut lines = Lines::new(source.data);
    let header = lines.next_data().ok_or_else(|| source.truncated(Place::Line(1), "header line", 1, 0))?;
    let mut words = header.words();
    let announced = source.count(&header, words.next(), HEADER)?;
    let dimension = source.count(&header, words.next(), HEADER)?;
    let attributes = words.next().map_or(Ok(0), |w| source.count(&header, Some(w), HEADER))?;
    let marker = words.next().map_or(Ok(0), |w| source.count(&header, Some(w), HEADER))?;
    if !(2..=3).contains(&dimension) {
        let (path, place) = (source.path.to_owned(), header.place());
        return Err(InputError::UnsupportedDimension { path, place, found: dimension });
    }
    let dimension = dimension as usize;
    let size = (announced, lines.rest().len(), 2 + 2 * dimension);
    let mut points = Collector::new(source, options, (header.place(), dimension), size)?;
    while let Some(line) = lines.next_data() {
        if points.met == announced {
            return Err(source.surplus(line.place(), "points", announced));
        }
        let mut words = line.words();
        let word = words.next().unwrap_or_default();
        let id = integer(word).and_then(|id| u64::try_from(id).ok());
        if points.met == 0 && matches!(id, Some(0 | 1)) {
            points.first_id = id.unwrap_or(0);
        }
        let expected_id = points.first_id + points.met;
        if id != Some(expected_id) {
            let expected = if points.met == 0 {
                "the point id 0 or 1".to_owned()
            } else {
                format!("the point id {expected_id}")
            };
            return Err(source.bad_word(&line, word, expected));
        }
        if line.words().count() <= dimension {
            let found = line.words().count() - 1;
            return Err(points.mixed(line.place(), found));
        }
        points.push_words(&line, &mut words)?;
    }
    points.complete(Place::Line(lines.number()), announced)?;
    if attributes > 0 || marker > 0 {
        let kinds = [(attributes, "attribute"), (marker, "boundary marker")];
        let counted = |(n, kind): (u64, &str)| format!("{n} {kind}{}", if n == 1 { "" } else { "s" });
        let ignored: Vec<String> = kinds.into_iter().filter(|(n, _)| *n > 0).map(counted).collect();
        let verb = if attributes + marker == 1 { "is" } else { "are" };
        points.notes.push(format!("{} per point {verb} ignored", ignored.join(" and ")));
    }
    Ok(points.finish())
}

/// Returns `true` if the first lines are those of a `.node` file: a header, then rows of an id and as many numbers as
/// the header announces. Ids are consecutive and start at 0 or 1.
///
/// A line of fewer than four numbers may also be the first row of a table, or the header of a list of cells. It is a
/// header of points if it announces the exact number of rows, and a row has a number that is not an integer.
pub(super) fn is_node(data: &[u8]) -> bool {
    const ROWS: i64 = 8;
    let mut lines = Lines::new(data);
    let Some(first) = lines.next_data() else { return false };
    // A longer line is not a header.
    let words: Vec<Option<i64>> = first.words().take(5).map(integer).collect();
    let Some(header) = words.into_iter().collect::<Option<Vec<i64>>>() else { return false };
    if !(2..=4).contains(&header.len()) {
        return false;
    }
    let field = |i: usize| header.get(i).copied().unwrap_or(0);
    let (points, dimension, attributes, marker) = (field(0), field(1), field(2), field(3));
    if points < 1 || !(2..=3).contains(&dimension) || attributes < 0 || !(0..=1).contains(&marker) {
        return false;
    }
    let width = attributes.saturating_add(1 + dimension + marker);
    let (mut rows, mut first_id, mut has_fraction) = (0, 0, false);
    while rows < points.min(ROWS)
        && let Some(line) = lines.next_data()
    {
        let id = line.words().next().and_then(integer).unwrap_or(-1);
        if rows == 0 {
            first_id = id;
        }
        let is_numeric = line.words().all(|word| number(word).is_some());
        if !matches!(first_id, 0 | 1)
            || id != first_id + rows
            || !is_numeric
            || line.words().count() as i64 != width
        {
            return false;
        }
        has_fraction |= line.words().any(|word| integer(word).is_none());
        rows += 1;
    }
    if header.len() == 4 {
        return rows > 0;
    }
    has_fraction && rows + std::iter::from_fn(|| lines.next_data()).count() as i64 == points
}
