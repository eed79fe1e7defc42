//! The sites of a periodic box and their images near it.

use std::ops::Range;

use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::point::{Point, Position, Vector};
use septet_geometry::range::Digits;
use septet_geometry::site::Weighted;
use septet_workers::config::cores::{map, map_blocks};

use super::lattice::Lattice;
use super::team::Team;
use crate::error::{Error, PeriodicError, incomplete};
use crate::result::periodic::{Steps, Vertex};

/// The first width of the cover beyond the box, in distances of evenly spaced sites, in the plane and in space. The largest
/// void of 1e6 random sites near a face has about half this diameter.
const WIDTH: [f64; 2] = [5.0, 3.5];

/// Number of rows whose images one core finds in turn.
const CHUNK: usize = 1 << 14;

/// A factor that covers the rounding of the cover.
const SURE: f64 = 1.0 - 1e-9;

/// The sites of a box. The *base* site of a row is its image in the half-open box.
#[derive(Debug)]
pub(super) struct Sites<P: Position> {
    pub(super) lattice: Lattice,
    /// The base sites of the rows of this process.
    bases: Vec<Weighted<P>>,
    /// The numbers of lengths from these rows to their base sites. Empty if they are 0.
    steps: Vec<Steps>,
    /// The number of the first row of this process.
    first: u64,
    /// Number of rows of all processes.
    count: u64,
    weights: Weights,
}

/// The base sites of all processes, followed by images of them: the rows of the machine.
#[derive(Debug)]
pub(super) struct Images<P: Position> {
    /// The sites that this process holds as rows of the machine.
    pub(super) sites: Vec<Weighted<P>>,
    /// The numbers of the rows that each process holds.
    blocks: Vec<Range<u64>>,
    /// The row of each image after the base sites, and the number of lengths from the base site to it, packed.
    of: Vec<u64>,
    base: u64,
}

impl<P: Position> Sites<P> {
    /// Finds the base sites of the rows of all processes. `first` is the number of the first row of this process.
    ///
    /// # Errors
    /// Fails on all processes with the first row outside of the box, and the number of others, or with a row that is too far
    /// away.
    pub(super) fn of(
        lattice: Lattice,
        (rows, first): (Vec<Weighted<P>>, u64),
        team: &mut Team<'_, '_>,
    ) -> Result<Self, Error> {
        let (low, high) = lattice.digits(&rows).ends();
        let all = team.all(vec![low as u32 as u64, high as u32 as u64, rows.len() as u64])?;
        let digits = all.iter().map(|words| Digits::new((words[0] as i32, words[1] as i32)));
        let count = all.iter().map(|words| words[2]).sum();
        let digits = digits.fold(Digits::NONE, Digits::join);
        let exponent = digits.scaling().map_err(|bits| PeriodicError::Spread { bits })?;
        let (lattice, rows) = lattice.scaled(rows, exponent);
        let (bases, steps) = moved(&lattice, rows, first, team)?;
        let weights = Weights::of(&bases, team)?;
        Ok(Sites { lattice, bases, steps, first, count, weights })
    }

    /// Returns the numbers of lengths from all rows to their base sites, on the first process. Empty if they are 0.
    ///
    /// # Errors
    /// Fails if a process is gone.
    pub(super) fn all_steps(&self, team: &mut Team<'_, '_>) -> Result<Vec<Steps>, Error> {
        let are_zero = team.all(vec![u64::from(self.steps.is_empty())])?.concat();
        if are_zero.iter().all(|&is_zero| is_zero == 1) {
            return Ok(Vec::new());
        }
        let steps = |at: usize| self.steps.get(at).copied().unwrap_or_default();
        let words = (0..self.bases.len()).flat_map(|at| steps(at).map(|steps| steps as u32 as u64));
        let words = team.on_first(words.collect())?;
        Ok(words.chunks_exact(3).map(|steps| [0, 1, 2].map(|axis| steps[axis] as i32)).collect())
    }

    /// Returns the number of rows of all processes.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Returns the first width of the cover: a few distances of evenly spaced sites, larger if some weights are.
    pub(super) fn first_width(&self) -> f64 {
        let axes = self.lattice.axes();
        if !self.lattice.is_closed(P::DIM) {
            return f64::INFINITY;
        }
        let volume: f64 = axes.map(|axis| self.lattice.lengths[axis]).product();
        let spacing = (volume / self.count as f64).powf(1.0 / P::DIM as f64);
        let width = WIDTH[P::DIM - 2] * (spacing * spacing + self.weights.excess).sqrt();
        if width > 0.0 { width } else { f64::INFINITY }
    }

    /// Returns `true` if a cover of this width contains all images with numbers of lengths from -1 to 1.
    pub(super) fn has_all(&self, width: f64) -> bool {
        let is_wide = |axis: usize| width >= self.lattice.lengths[axis];
        // A width that is no number is too large.
        self.lattice.axes().all(is_wide) || width.is_nan()
    }

    /// Returns the base sites, and their images within `width` of the box; all images if the cover has all.
    ///
    /// # Errors
    /// Fails if a process is gone.
    pub(super) fn images(&self, width: f64, team: &mut Team<'_, '_>) -> Result<Images<P>, Error> {
        let width = if self.has_all(width) { None } else { Some(width) };
        let all = numbers(self.bases.len());
        let chunks: Vec<&[u32]> = all.chunks(CHUNK).collect();
        let found = map(&chunks, |rows| {
            let mut of = Vec::new();
            for &row in *rows {
                let site = self.bases[row as usize];
                if is_finite(site) {
                    let row = (self.first as u32).saturating_add(row);
                    each_steps(self.ranges(site, width), |steps| of.push(Vertex { row, steps }.pack()));
                }
            }
            of
        });
        let own = found.concat();
        let image = |word: &u64| {
            let Vertex { row, steps } = Vertex::unpack(*word);
            self.lattice.image(self.bases[(u64::from(row) - self.first) as usize], steps)
        };
        let sites = map(&own, image);
        let of = team.all(own)?;
        let before: usize = of.iter().take(team.processes.process() as usize).map(Vec::len).sum();
        let of = of.concat();
        let blocks = team.blocks(self.count + of.len() as u64);
        let mut held = team.moved(&self.bases, self.first, &blocks)?;
        held.reserve_exact(sites.len());
        held.extend(team.moved(&sites, self.count + before as u64, &blocks)?);
        Ok(Images { sites: held, blocks, of, base: self.count })
    }

    /// Returns the numbers of lengths to the images of a base site within the width of the box, along each axis.
    fn ranges(&self, site: Weighted<P>, width: Option<f64>) -> [[i32; 2]; 3] {
        let mut ranges = [[0, 0]; 3];
        for axis in self.lattice.axes() {
            let (x, low, length) =
                (site.position().coord(axis), self.lattice.origin[axis], self.lattice.lengths[axis]);
            let reaches = |distance: f64| width.is_none_or(|width| distance <= width);
            ranges[axis] = [-i32::from(reaches(low + length - x)), i32::from(reaches(x - low))];
        }
        ranges
    }

    /// Returns `true` if the conflict region of a cell may leave the cover of this width.
    pub(super) fn leaves_cover(&self, corners: &[Weighted<P>], width: f64) -> bool {
        let ConflictRegion::Ball { centre, radius } = ConflictRegion::of_cell(corners, self.weights.heaviest)
        else {
            return true;
        };
        let leaves = |axis: usize| {
            let (low, length) = (self.lattice.origin[axis], self.lattice.lengths[axis]);
            let width = width.min(length) * SURE - 1e-9 * low.abs() - 4.0 * f64::EPSILON * length;
            let (from, to) = (centre.coord(axis) - radius, centre.coord(axis) + radius);
            let is_inside = from > low - width && to < low + length + width;
            !is_inside
        };
        self.lattice.axes().any(leaves)
    }
}

/// Returns the numbers of rows. The machine refuses more rows than it can number.
fn numbers(rows: usize) -> Vec<u32> {
    (0..u32::try_from(rows).unwrap_or(u32::MAX)).collect()
}

/// Calls `f` with the combinations of numbers of lengths, except for zeros only.
fn each_steps([x, y, z]: [[i32; 2]; 3], mut f: impl FnMut(Steps)) {
    for i in x[0]..=x[1] {
        for j in y[0]..=y[1] {
            for k in z[0]..=z[1] {
                if [i, j, k] != [0; 3] {
                    f([i, j, k]);
                }
            }
        }
    }
}

fn is_finite<P: Point>(site: P) -> bool {
    septet_geometry::range::not_finite(&site).is_none()
}

/// The weights of the sites of all processes.
#[derive(Clone, Copy, Debug)]
struct Weights {
    heaviest: f64,
    /// The heaviest weight less the mean, rounded.
    excess: f64,
}

impl Weights {
    /// Finds the weights. The sum for the mean is one of integers, because it must not depend on the order of the sites.
    fn of<P: Position>(sites: &[Weighted<P>], team: &mut Team<'_, '_>) -> Result<Self, Error> {
        const STEPS: f64 = (1u64 << 20) as f64;
        let weights = || sites.iter().map(Point::weight).filter(|weight| weight.is_finite());
        let ends = [weights().fold(f64::NEG_INFINITY, f64::max), -weights().fold(f64::INFINITY, f64::min)];
        let ends = team.all(ends.map(f64::to_bits).to_vec())?;
        let [heaviest, lightest] = [0, 1]
            .map(|end| ends.iter().map(|ends| f64::from_bits(ends[end])).fold(f64::NEG_INFINITY, f64::max));
        let span = heaviest + lightest;
        let part = |weight: f64| ((heaviest - weight) / span * STEPS) as u64;
        let sum = if span > 0.0 { weights().map(part).sum() } else { 0 };
        let sums = team.all(vec![sum, weights().count() as u64])?;
        let [sum, count] = [0, 1].map(|at| sums.iter().map(|sums| sums[at]).sum::<u64>() as f64);
        Ok(Weights { heaviest, excess: if sum > 0.0 { sum / STEPS / count * span } else { 0.0 } })
    }
}

/// The rows of a block that are not their own base sites, and those that have none.
struct Found<P: Position> {
    moved: Vec<(u32, Weighted<P>, Steps)>,
    error: Option<PeriodicError>,
    outside: u64,
}

impl<P: Position> Found<P> {
    fn of(lattice: &Lattice, rows: &[Weighted<P>], block: Range<usize>, first: u64) -> Self {
        let mut found = Found { moved: Vec::new(), error: None, outside: 0 };
        for at in block {
            let row = rows[at];
            match lattice.base(row, first as usize + at) {
                _ if !is_finite(row) => {}
                Ok((_, [0, 0, 0])) => {}
                Ok((base, steps)) => found.moved.push((at as u32, base, steps)),
                Err(error) => {
                    found.outside += u64::from(matches!(error, PeriodicError::Outside { .. }));
                    found.error.get_or_insert(error);
                }
            }
        }
        found
    }
}

/// Moves rows to their base sites. Also returns the numbers of lengths to them, or nothing if they are 0.
///
/// # Errors
/// Fails on all processes if one of them has a row without a base site.
fn moved<P: Position>(
    lattice: &Lattice,
    mut rows: Vec<Weighted<P>>,
    first: u64,
    team: &mut Team<'_, '_>,
) -> Result<(Vec<Weighted<P>>, Vec<Steps>), Error> {
    let found = map_blocks(rows.len(), CHUNK, |block| Found::of(lattice, &rows, block, first));
    let outside = found.iter().map(|found| found.outside).sum();
    agree(found.iter().find_map(|found| found.error.as_ref()), outside, team)?;
    let mut all = Vec::new();
    for (at, base, steps) in found.into_iter().flat_map(|found| found.moved) {
        all.resize(rows.len(), [0; 3]);
        (rows[at as usize], all[at as usize]) = (base, steps);
    }
    Ok((rows, all))
}

/// Fails on all processes with the error of the first one that has one. `outside` is the number of rows of this process outside
/// of the box.
fn agree(own: Option<&PeriodicError>, outside: u64, team: &mut Team<'_, '_>) -> Result<(), Error> {
    let words = match own {
        Some(&PeriodicError::Outside { index, value, low, high, .. }) => {
            vec![outside, index as u64, value.to_bits(), low.to_bits(), high.to_bits()]
        }
        Some(&PeriodicError::Far { index, value, length }) => {
            vec![outside, index as u64, value.to_bits(), length.to_bits()]
        }
        _ => vec![outside],
    };
    let all = team.all(words)?;
    let outside: u64 = all.iter().map(|words| words[0]).sum();
    let number = |word: u64| f64::from_bits(word);
    let first = all.iter().find_map(|words| match words[1..] {
        [index, value, low, high] => Some(PeriodicError::Outside {
            index: index as usize,
            value: number(value),
            low: number(low),
            high: number(high),
            others: outside as usize - 1,
        }),
        [index, value, length] => {
            Some(PeriodicError::Far { index: index as usize, value: number(value), length: number(length) })
        }
        _ => None,
    });
    first.map_or(Ok(()), |error| Err(error.into()))
}

impl<P: Position> Images<P> {
    /// Returns the number of images besides the base sites.
    pub(super) fn count(&self) -> u64 {
        self.of.len() as u64
    }

    /// Returns the number of rows of the machine: base sites and images.
    pub(super) fn rows(&self) -> u64 {
        self.base + self.count()
    }

    /// Returns the number of the first row that a process holds.
    pub(super) fn first(&self, process: u32) -> u64 {
        self.blocks[process as usize].start
    }

    /// Returns `true` if a site is a base site.
    pub(super) fn is_base(&self, site: u64) -> bool {
        site < self.base
    }

    /// Returns the row of a site, and the number of lengths from its base site to it.
    pub(super) fn of(&self, site: u64) -> Vertex {
        match site.checked_sub(self.base) {
            Some(image) => Vertex::unpack(self.of[image as usize]),
            None => Vertex { row: site as u32, steps: [0; 3] },
        }
    }

    /// Returns the sites with these numbers, from the processes that hold them.
    ///
    /// # Errors
    /// Fails if a process is gone, or if a number is not that of a site.
    pub(super) fn fetch(&self, ids: &[u64], team: &mut Team<'_, '_>) -> Result<Vec<Weighted<P>>, Error> {
        if self.blocks.len() == 1 {
            return Ok(map(ids, |&id| self.sites[id as usize]));
        }
        let holder = |id: u64| self.blocks.partition_point(|block| block.end <= id);
        let mut wanted = vec![Vec::new(); self.blocks.len()];
        for &id in ids {
            let holder = holder(id);
            wanted.get_mut(holder).ok_or_else(|| incomplete(format!("there is no site {id}")))?.push(id);
        }
        let first = self.blocks[team.processes.process() as usize].start;
        let site = |&id: &u64| Some(*self.sites.get(usize::try_from(id.checked_sub(first)?).ok()?)?);
        let answers = team.scatter(wanted)?.into_iter().map(|ids| ids.iter().map(site).collect());
        let answers: Option<Vec<Vec<Weighted<P>>>> = answers.collect();
        let answers =
            answers.ok_or_else(|| incomplete("a process asks for another process's site".to_string()))?;
        let mut answers: Vec<_> = team.scatter(answers)?.into_iter().map(Vec::into_iter).collect();
        let next = |&id: &u64| answers.get_mut(holder(id))?.next();
        let found: Option<Vec<_>> = ids.iter().map(next).collect();
        found.ok_or_else(|| incomplete("a site was not sent".to_string()))
    }
}
