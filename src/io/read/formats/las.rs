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
mod chunks;
#[cfg(feature = "las")]
mod head;

#[cfg(feature = "las")]
mod scan {
    use std::io::Cursor;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use las::Reader;

    use super::chunks;
    use super::head::Head;
    use crate::read::collect::Collector;
    use crate::read::error::{InputError, Place};
    use crate::read::points::{CoordinateType, PointFile, ReadOptions};
    use crate::read::text::Source;

    /// The least number of bytes of a compressed point.
    const LEAST: usize = 1;

    /// The largest number of bytes of points that are decoded at a time.
    const BATCH: usize = 1 << 21;

    /// The help for a scan that the crate cannot read.
    const ADVICE: &str = "check the file with `lasinfo`, or convert it with PDAL";

    /// Reads the points. The crate can panic in a damaged file, which is then refused.
    pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
        let head = Head::of(source)?;
        catch_unwind(AssertUnwindSafe(|| decode(source, options, &head)))
            .unwrap_or_else(|_| Err(source.unsupported(Place::Whole, "a damaged laser scan", ADVICE)))
    }

    fn decode(source: Source<'_>, options: &ReadOptions, head: &Head) -> Result<PointFile, InputError> {
        let damaged = |met: u64, error: las::Error| {
            let what = format!("a damaged or unknown laser scan, from point {met} on ({error}),");
            source.unsupported(Place::Whole, what, ADVICE)
        };
        if head.is_compressed {
            chunks::check(source, head)?;
        }
        let data = head.without_extended_records(source.data);
        let mut reader = Reader::new(Cursor::new(data)).map_err(|error| damaged(0, error))?;
        let announced = reader.header().number_of_points();
        let least = if head.is_compressed { LEAST } else { head.length };
        let size = (announced, source.data.len(), least);
        let mut points = Collector::new(source, options, (Place::Whole, 3), size)?;
        points.coordinate_type = Some(CoordinateType::Integer);
        let most = (BATCH / head.length).max(1) as u64;
        loop {
            let wanted = most.min(announced.saturating_sub(points.met));
            let batch = reader.read_points(wanted).map_err(|error| damaged(points.met, error))?;
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

#[cfg(all(test, feature = "las"))]
mod tests {
    use std::path::Path;

    use super::*;

    fn folder() -> &'static Path {
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reports/made"))
    }

    /// Reads a scan of the reports with some bytes replaced.
    fn altered(name: &str, at: usize, bytes: &[u8]) -> Result<PointFile, InputError> {
        let mut data = std::fs::read(folder().join(name)).unwrap();
        data[at..at + bytes.len()].copy_from_slice(bytes);
        read(Source { path: Path::new(name), data: &data }, &ReadOptions::default())
    }

    #[test]
    fn announced_sizes_are_checked() {
        let message = |found: Result<PointFile, InputError>| found.unwrap_err().to_string();
        let all = altered("laspy-12.las", 0, b"LASF").unwrap().points.len();
        assert_eq!(altered("laspy-14.laz", 0, b"LASF").unwrap().points.len(), all);
        let fewer = message(altered("laspy-12.las", 107, &[7, 0, 0, 0]));
        assert!(fewer.contains("more than the 7 points announced"), "{fewer}");
        let many = message(altered("laspy-12.las", 107, &[0xff; 4]));
        assert!(many.contains("4294967295 points announced"), "{many}");
        let many = message(altered("laspy-14.las", 247, &[0, 0, 0, 0, 0, 0, 0, 0x80]));
        assert!(many.contains("points announced"), "{many}");
        let wide = message(altered("laspy-12.las", 105, &[0xff; 2]));
        assert!(wide.contains("points announced"), "{wide}");
        // Records behind the points are not read, whatever their number is.
        assert_eq!(altered("laspy-14.las", 235, &[0xff; 12]).unwrap().points.len(), all);
        assert!(altered("laspy-14.laz", 100, &[0xff; 4]).is_err());
        assert!(altered("laspy-14.laz", 105, &[0xff; 2]).is_err());
    }

    #[test]
    fn layers_fit_their_chunk() {
        // The points begin at byte 469: the position of the table, a point of 30 bytes, the number of points, nine sizes.
        let sizes = 469 + 8 + 30 + 4;
        for layer in 0..9 {
            let found = altered("laspy-14.laz", sizes + 4 * layer, &[0xff; 4]).unwrap_err().to_string();
            assert!(found.contains("chunk 1 has layers of 42949"), "{found}");
        }
        let longer = altered("laspy-14.laz", sizes, &[0x40]).unwrap_err().to_string();
        assert!(longer.contains("chunk 1 has layers"), "{longer}");
    }

    #[test]
    fn chunks_fit_their_file() {
        let table = |position: u64| altered("laspy-14.laz", 469, &position.to_le_bytes());
        for position in [0, 469, 470, 476, 620, 627, u64::MAX / 2, u64::MAX] {
            let found = table(position).unwrap_err().to_string();
            assert!(found.contains("a damaged table of chunks"), "{position}: {found}");
        }
        let stated = std::fs::read(folder().join("laspy-14.laz")).unwrap();
        let at = usize::from(stated[469]) + 256 * usize::from(stated[470]);
        // The number of chunks, and the compressed size of the first one.
        for (at, bytes) in [(at + 4, [0xff; 4]), (at + 4, [0; 4]), (at + 8, [0xff; 4])] {
            let found = altered("laspy-14.laz", at, &bytes).unwrap_err().to_string();
            assert!(found.contains("a damaged table of chunks"), "{at}: {found}");
        }
    }
}
