//! Points of laser scans: `.las` and `.laz`, by the crate `las`, which the feature `las` adds.
//!
//! A coordinate is `offset + scale * integer` in doubles, as the format defines it.

use crate::read::error::InputError;
#[cfg(not(feature = "las"))]
use crate::read::error::Place;
use crate::read::points::{PointFile, ReadOptions};
use crate::read::text::Source;

/// Refuses the file, because the crate is missing.
#[cfg(not(feature = "las"))]
pub fn read(source: Source<'_>, _: &ReadOptions) -> Result<PointFile, InputError> {
    let what = "a laser scan (septet was built without the feature `las`)";
    Err(source.unsupported(Place::Whole, what, "build it with the feature, or convert the file to .ply"))
}

/// Reads all points. Other values of them are ignored.
#[cfg(feature = "las")]
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    scan::read(source, options)
}

#[cfg(feature = "las")]
mod scan {
    use std::io::Cursor;

    use las::Reader;

    use crate::read::collect::Collector;
    use crate::read::error::{InputError, Place};
    use crate::read::points::{CoordinateType, PointFile, ReadOptions};
    use crate::read::text::Source;

    /// The least number of bytes of a compressed point.
    const LEAST: usize = 1;

    /// The number of points that are decoded at a time.
    const BATCH: u64 = 1 << 16;

    pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
        let damaged = |error: las::Error| {
            let advice = "check the file with `lasinfo`, or convert it with PDAL";
            source.unsupported(Place::Whole, format!("a damaged or unknown laser scan ({error})"), advice)
        };
        let mut reader = Reader::new(Cursor::new(source.data.to_vec())).map_err(damaged)?;
        let announced = reader.header().number_of_points();
        let size = (announced, source.data.len(), LEAST);
        let mut points = Collector::new(source, options, (Place::Whole, 3), size)?;
        points.coordinate_type = Some(CoordinateType::Integer);
        loop {
            let batch =
                reader.read_points(BATCH.min(announced.saturating_sub(points.met))).map_err(damaged)?;
            if batch.is_empty() {
                break;
            }
            for ((x, y), z) in batch.x().zip(batch.y()).zip(batch.z()) {
                points.push(Place::Whole, &[x, y, z])?;
            }
        }
        points.complete(Place::Whole, announced)?;
        points.notes.push("values besides the coordinates are ignored".to_owned());
        Ok(points.finish())
    }
}
