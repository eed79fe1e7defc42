//! `.node` files: points of `TetGen` and Triangle.

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::text::{Lines, Source, integer};

/// Reads a header `count dimension [attributes [marker]]`, then rows `id x y [z] …`. Ids are consecutive and start at
/// 0 or 1. The first attribute of a terrain in the plane is z.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
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
    // Triangle has no third coordinate, so the first attribute of a terrain is its height.
    let has_height = options.terrain && dimension == 2 && attributes > 0;
    let dimension = dimension as usize + usize::from(has_height);
    let attributes = attributes - u64::from(has_height);
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
            return Err(source.bad_word(&line, word, expected).in_row(points.met));
        }
        // Of all coordinates of the file, `push_words` finds a missing one itself.
        if points.dimension() < dimension && line.words().count() <= dimension {
            let found = line.words().count() - 1;
            return Err(points.mixed(line.place(), found));
        }
        points.push_words(&line, &mut words)?;
    }
    points.complete(Place::Line(lines.number()), announced)?;
    if has_height {
        points.notes.push("the first attribute is taken as z".to_owned());
    }
    if attributes > 0 || marker > 0 {
        let kinds = [(attributes, "attribute"), (marker, "boundary marker")];
        let counted = |(n, kind): (u64, &str)| format!("{n} {kind}{}", if n == 1 { "" } else { "s" });
        let ignored: Vec<String> = kinds.into_iter().filter(|(n, _)| *n > 0).map(counted).collect();
        let verb = if attributes + marker == 1 { "is" } else { "are" };
        points.notes.push(format!("{} per point {verb} ignored", ignored.join(" and ")));
    }
    Ok(points.finish())
}
