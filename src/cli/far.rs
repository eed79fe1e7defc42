//! The note on points that are far from all others. They are often values for missing data.

use septet_core::model::{HigherPoints, Points};
use septet_geometry::incremental::FarPoints;
use septet_geometry::point::Point;
use septet_io::read::{ListedFile, SharedPoints};
use septet_protocol::wire::Processes;

use super::errors::Failure;
use super::text::{counted, place_of};

/// The far points of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Far {
    /// Their number.
    count: u64,
    /// The row of the first one in the input.
    first: u64,
    /// The largest distance from the middle, over the median distance.
    ratio: f64,
}

impl Far {
    /// Finds the far points of a whole input. `rows` are the rows of the points, if some rows were dropped.
    pub fn of(points: &Points, rows: Option<&[u64]>) -> Option<Self> {
        let found = match points {
            Points::Plane(points) => FarPoints::of(points),
            Points::Space(points) => FarPoints::of(points),
            Points::Higher(HigherPoints::Four(points)) => FarPoints::of(points),
            Points::Higher(HigherPoints::Five(points)) => FarPoints::of(points),
            Points::Higher(HigherPoints::Six(points)) => FarPoints::of(points),
        };
        found.map(|far| Far::new(&far, |position| rows.map_or(position, |rows| rows[position as usize])))
    }

    /// Finds the far points of an input of which each process has a block. All processes find the same as one process.
    ///
    /// # Errors
    /// Fails if the processes lose each other.
    pub fn of_blocks(held: &SharedPoints, processes: &mut Processes<'_>) -> Result<Option<Self>, Failure> {
        let own = match &held.points {
            Points::Plane(points) => of_block(points, held, processes)?,
            Points::Space(points) => of_block(points, held, processes)?,
            Points::Higher(HigherPoints::Four(points)) => of_block(points, held, processes)?,
            Points::Higher(HigherPoints::Five(points)) => of_block(points, held, processes)?,
            Points::Higher(HigherPoints::Six(points)) => of_block(points, held, processes)?,
        };
        let own = own.map_or((0, 0, 0.0), |far| (far.count, far.first, far.ratio));
        let found = processes.all_gather(&own)?.into_iter().filter(|(count, ..)| *count > 0);
        let far = found.map(|(count, first, ratio)| Far { count, first, ratio }).reduce(|a, b| Far {
            count: a.count + b.count,
            first: a.first.min(b.first),
            ratio: a.ratio.max(b.ratio),
        });
        Ok(far.filter(|far| far.count <= FarPoints::most(held.rows)))
    }

    fn new(found: &FarPoints, row: impl Fn(u64) -> u64) -> Self {
        let FarPoints { positions, ratio } = found;
        Far { count: positions.len() as u64, first: row(u64::from(positions[0])), ratio: *ratio }
    }

    /// Returns the note. `files` are the files of a list.
    pub fn describe(&self, files: &[ListedFile]) -> String {
        let Far { count, first, ratio } = *self;
        let (are, which) = if count == 1 { ("is", "it is") } else { ("are", "the first is") };
        // Without a distance to compare with, there is only infinity.
        let distance = if ratio.is_finite() {
            format!("up to {ratio:.0e} times as far as the median point")
        } else {
            "far from all others".to_owned()
        };
        let place = if files.len() > 1 { place_of(files, first).unwrap_or_default() } else { String::new() };
        format!("note: {} {are} {distance}; {which} point {first} (from 0{place})", counted(count, "point"))
    }
}

/// Finds the far points of the block of this process.
fn of_block<P: Point>(
    block: &[P],
    held: &SharedPoints,
    processes: &mut Processes<'_>,
) -> Result<Option<Far>, Failure> {
    let own = FarPoints::sample(block, held.first, held.rows);
    let own: Vec<f64> = own.iter().flat_map(|p| (0..P::DIM).map(|axis| p.coord(axis))).collect();
    let all = processes.all_gather(&own)?.concat();
    let sample: Vec<P> = all.chunks_exact(P::DIM).map(P::from_coords).collect();
    let row = |position: u64| {
        held.source_index.as_ref().map_or(held.first + position, |rows| rows[position as usize])
    };
    Ok(FarPoints::judged(block, &sample, held.rows).map(|far| Far::new(&far, row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_points_are_described_without_infinity() {
        let listed = |path: &str, first_row, rows| ListedFile { path: path.into(), first_row, rows };
        let files = [listed("a.xyz", 0, 5), listed("b.xyz", 5, 5)];
        let far = |ratio| Far { count: 1, first: 7, ratio };
        assert_eq!(
            far(f64::INFINITY).describe(&files),
            "note: 1 point is far from all others; it is point 7 (from 0; point 7 is row 2 of b.xyz)"
        );
        assert_eq!(
            far(3e6).describe(&[]),
            "note: 1 point is up to 3e6 times as far as the median point; it is point 7 (from 0)"
        );
    }
}
