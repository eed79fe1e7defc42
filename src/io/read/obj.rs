//! Wavefront `.obj` files: the `v` lines.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::text::{Lines, Source};

/// Reads the lines `v x y z …`. Colours and weights on them are ignored, as are all other lines.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let mut points = Collector::new(source, options, (Place::Whole, 3), (0, 0, 1))?;
    let mut lines = Lines::new(source.data);
    let mut extra = false;
    while let Some(line) = lines.next_data() {
        let mut words = line.words();
        if words.next() != Some(b"v".as_slice()) {
            continue;
        }
        points.push_words(&line, &mut words)?;
        extra |= words.next().is_some() && points.dimension() == 3;
    }
    if extra {
        points.notes.push("colours or weights after the coordinates are ignored".to_owned());
    }
    points.note_if_flat();
    Ok(points.finish())
}
