//! Collects the points of a file: checks that they are finite, replaces -0.0, counts dropped points, and bounds memory.

use glam::{DVec2, DVec3};

use super::error::{InputError, Place, WeightError};
use super::points::{CoordinateType, PointFile, ReadOptions};
use super::reading::FileReading;
use super::text::{Line, Source, number};
use super::weights;
use septet_core::model::{HigherPoints, Points};
use septet_geometry::higher::VecN;

/// The points read so far.
pub(super) struct Collector<'a> {
    source: Source<'a>,
    points: Points,
    skip_invalid: bool,
    is_terrain: bool,
    /// The weights, if they are in a column.
    weights: Option<Weights>,
    /// The number of points of the file before the first one that is collected.
    before: u64,
    /// The number of points of the file so far, including dropped ones.
    pub met: u64,
    skipped: usize,
    /// The index in the file of each point, filled when the first point is dropped.
    kept: Vec<u64>,
    pub notes: Vec<String>,
    pub first_id: u64,
    /// The type of the coordinates in a binary file.
    pub coordinate_type: Option<CoordinateType>,
}

/// The weights of a column.
struct Weights {
    values: Vec<f64>,
    are_radii: bool,
}

/// The number that gives the weight of a point, and its place.
pub(super) type WeightNumber = (Place, f64);

/// The words of a point: its coordinates, and the one of its weight, if the weights are in a column.
pub(super) type PointWords<'w, 'b> = (&'w mut dyn Iterator<Item = &'b [u8]>, Option<&'b [u8]>);

/// The largest number of coordinates of a point.
pub(super) const MOST_COORDINATES: usize = 6;

/// Returns no points of a dimension, with room for some. Returns `None` if there is no memory for them.
fn empty(dimension: usize, capacity: usize) -> Option<Points> {
    fn reserved<P>(capacity: usize) -> Option<Vec<P>> {
        let mut points = Vec::new();
        points.try_reserve(capacity).ok()?;
        Some(points)
    }
    Some(match dimension {
        2 => Points::Plane(reserved(capacity)?),
        4 => Points::Higher(HigherPoints::Four(reserved(capacity)?)),
        5 => Points::Higher(HigherPoints::Five(reserved(capacity)?)),
        6 => Points::Higher(HigherPoints::Six(reserved(capacity)?)),
        _ => Points::Space(reserved(capacity)?),
    })
}

/// Returns the point with these coordinates, where -0.0 becomes 0.0.
fn higher<const N: usize>(at: &[f64]) -> VecN<N> {
    VecN(std::array::from_fn(|axis| at[axis] + 0.0))
}

impl<'a> Collector<'a> {
    /// Creates a collector of points with `dimension` coordinates, or fewer if the options request fewer.
    ///
    /// It reserves memory for the `announced` points, but for no more points than `bytes` bytes of the file can hold at
    /// `least` bytes each.
    pub fn new(
        source: Source<'a>,
        options: &ReadOptions,
        (place, dimension): (Place, usize),
        (announced, bytes, least): (u64, usize, usize),
    ) -> Result<Self, InputError> {
        let path = || source.path.to_owned();
        if dimension < 2 {
            return Err(InputError::UnsupportedDimension { path: path(), place, found: dimension as u64 });
        }
        let used = options.dimension.unwrap_or(dimension.min(3));
        if used > dimension && options.terrain {
            return Err(InputError::NoHeights { path: path(), place });
        }
        if used > dimension {
            return Err(InputError::MixedDimension {
                path: path(),
                place,
                expected: used,
                found: dimension,
                row: None,
            });
        }
        if used > 3 && options.weights.is_some() {
            return Err(WeightError::Dimension { path: path(), dimension: used }.into());
        }
        let capacity = usize::try_from(announced).unwrap_or(usize::MAX).min(bytes / least.max(1) + 1);
        let points = empty(used, capacity).ok_or_else(|| {
            let bytes = (capacity as u64).saturating_mul(8 * used as u64);
            InputError::OutOfMemory { path: path(), bytes }
        })?;
        Ok(Collector {
            source,
            points,
            skip_invalid: options.skip_invalid,
            is_terrain: options.terrain,
            weights: options.weight_column().map(|(_, are_radii)| Weights { values: Vec::new(), are_radii }),
            before: 0,
            met: 0,
            skipped: 0,
            kept: Vec::new(),
            notes: Vec::new(),
            first_id: 0,
            coordinate_type: None,
        })
    }

    /// Returns a collector of points that follow `before` points of the file.
    pub fn after(self, before: u64) -> Self {
        Collector { before, met: before, ..self }
    }

    /// Returns the number of coordinates of each point: 2 to 6.
    pub fn dimension(&self) -> usize {
        self.points.dimension()
    }

    /// Returns the number of points that were not dropped.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Adds a point of at least `dimension` coordinates.
    pub fn push(&mut self, place: Place, at: &[f64]) -> Result<(), InputError> {
        self.push_weighted(place, at, None)
    }

    /// Adds a point of at least `dimension` coordinates, with its weight if the weights are in a column.
    pub fn push_weighted(
        &mut self,
        place: Place,
        at: &[f64],
        weight: Option<WeightNumber>,
    ) -> Result<(), InputError> {
        let found = at.len();
        let at = at.get(..self.dimension()).ok_or_else(|| self.mixed(place, found))?;
        if let Some(value) = at.iter().find(|c| !c.is_finite()) {
            if self.skip_invalid {
                self.drop_one();
                return Ok(());
            }
            let (path, index) = (self.source.path.to_owned(), self.met);
            return Err(InputError::NotFinite { path, place, index, value: *value });
        }
        if let (Some(weights), Some((place, number))) = (&mut self.weights, weight) {
            match weights::of_number(number, weights.are_radii) {
                Ok(weight) => weights.values.push(weight),
                Err(_) if self.skip_invalid => {
                    self.drop_one();
                    return Ok(());
                }
                Err(fault) => {
                    let fault = (weights.are_radii, fault);
                    return Err(weights::blame(self.source.path, (place, self.met), number, fault));
                }
            }
        }
        // Adding zero converts -0.0 to 0.0 and leaves other numbers unchanged.
        match &mut self.points {
            Points::Plane(points) => points.push(DVec2::new(at[0] + 0.0, at[1] + 0.0)),
            Points::Space(points) => points.push(DVec3::new(at[0] + 0.0, at[1] + 0.0, at[2] + 0.0)),
            Points::Higher(HigherPoints::Four(points)) => points.push(higher(at)),
            Points::Higher(HigherPoints::Five(points)) => points.push(higher(at)),
            Points::Higher(HigherPoints::Six(points)) => points.push(higher(at)),
        }
        if self.skipped > 0 {
            self.kept.push(self.met);
        }
        self.met += 1;
        Ok(())
    }

    /// Adds the point whose coordinates are the next words. Later words are not read.
    pub fn push_words(
        &mut self,
        line: &Line<'_>,
        words: &mut dyn Iterator<Item = &[u8]>,
    ) -> Result<(), InputError> {
        self.push_parsed(line, (words, None), number)
    }

    /// Adds the point of these words, as `parse` reads them.
    pub fn push_parsed(
        &mut self,
        line: &Line<'_>,
        (words, weight): PointWords<'_, '_>,
        parse: impl Fn(&[u8]) -> Option<f64>,
    ) -> Result<(), InputError> {
        let mut at = [0.0; MOST_COORDINATES];
        let dimension = self.dimension();
        let mut bad = None;
        for (found, slot) in at[..dimension].iter_mut().enumerate() {
            let Some(word) = words.next() else {
                return Err(self.mixed(line.place(), found));
            };
            match parse(word) {
                Some(value) => *slot = value,
                None => bad = bad.or(Some(word)),
            }
        }
        let number = weight.and_then(&parse);
        if number.is_none() {
            bad = bad.or(weight);
        }
        match bad {
            None => self.push_weighted(line.place(), &at[..dimension], number.map(|n| (line.place(), n))),
            Some(word) => self.malformed(line, word),
        }
    }

    /// Drops a row with an unreadable number, or returns an error if the options do not allow this.
    pub fn malformed(&mut self, line: &Line<'_>, word: &[u8]) -> Result<(), InputError> {
        if !self.skip_invalid {
            return Err(self.source.bad_number(line, word).in_row(self.met));
        }
        self.drop_one();
        Ok(())
    }

    fn drop_one(&mut self) {
        if self.skipped == 0 {
            self.kept.extend(self.before..self.met);
        }
        self.skipped += 1;
        self.met += 1;
    }

    /// Returns the error for a row with a different number of coordinates.
    pub fn mixed(&self, place: Place, found: usize) -> InputError {
        InputError::MixedDimension {
            path: self.source.path.to_owned(),
            place,
            expected: self.dimension(),
            found,
            row: Some(self.met),
        }
    }

    /// Checks that all announced points were read.
    pub fn complete(&self, place: Place, announced: u64) -> Result<(), InputError> {
        if self.met < announced {
            return Err(self.source.truncated(place, "points", announced, self.met));
        }
        Ok(())
    }

    /// Returns `true` if there are several points, and all have the same last coordinate.
    pub fn has_constant_end(&self) -> bool {
        let rows = self.points.coordinates().chunks_exact(self.dimension());
        let mut ends = rows.filter_map(|row| row.last());
        ends.next().is_some_and(|first| self.len() > 1 && ends.all(|end| end == first))
    }

    /// Adds a note if the points have three coordinates, every z is 0, and the points are no terrain.
    pub fn note_if_flat(&mut self) {
        if let Points::Space(points) = &self.points
            && !self.is_terrain
            && !points.is_empty()
            && points.iter().all(|p| p.z == 0.0)
        {
            self.notes
                .push("every z is 0, so dimension 2 triangulates the same points in the plane".to_owned());
        }
    }

    /// Returns the points.
    pub fn finish(self) -> PointFile {
        PointFile {
            points: self.points,
            heights: None,
            weights: self.weights.map(|weights| weights.values),
            notes: self.notes,
            rounded: 0,
            skipped: self.skipped,
            source_index: (self.skipped > 0).then_some(self.kept),
            first_id: self.first_id,
            columns: Vec::new(),
            coordinate_type: self.coordinate_type,
            reading: FileReading::of_rows(self.met - self.before),
        }
    }
}
