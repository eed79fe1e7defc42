//! The numbers of a triangulation: counts, hull, extent, degrees and the quality of its cells.
//!
//! **Statement.** All numbers are functions of the points and their triangulation. They depend neither on the order of the
//! cells nor on the workers, threads and processes that hold them: counts are integers, sums are exact until they are rounded
//! once, and a cell is measured with its vertices in canonical order. The volume is the exact sum of the rounded measures of
//! the cells, and the surface that of the hull facets.
//!
//! The edges at a vertex follow from the cells `t` and the hull facets `b` at it, because the link of a vertex is a disk or a
//! sphere. In the plane, a vertex has `t` edges, and one more on the hull. In space, Euler's formula of the link gives
//! `2 + t / 2` edges, and `1 + (t + b) / 2` on the hull.
//!
//! **Work and depth.** O(1) per cell. Blocks of cells are measured in parallel.

use glam::{DVec2, DVec3};
use septet_geometry::point::Point;
use septet_meshing::quality::histogram::Histogram;
use septet_meshing::quality::shapes::{Shape, Shapes};
use septet_meshing::space::Space;
use septet_meshing::sum::ExactSum;
use septet_workers::config::cores::{map_blocks, sort_rows, threads};

use crate::result::share::{Neighbour, WorkerShare};

/// The fewest cells for each unit of parallel work.
const BLOCK: usize = 1 << 14;

/// The numbers of a triangulation. Lengths, areas and volumes have the unit of the coordinates. Angles are in degrees.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Stats {
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Number of vertices.
    pub points: u64,
    /// Number of points that coincide with a point of smaller index. They are not vertices.
    pub duplicates: u64,
    /// Number of edges.
    pub edges: u64,
    /// Number of facets: edges in the plane, triangles in space.
    pub facets: u64,
    /// Number of triangles or tetrahedra.
    pub cells: u64,
    /// Number of connected parts: 1, or 0 without cells.
    pub components: u64,
    /// Number of facets on the convex hull.
    pub hull_facets: u64,
    /// Number of edges on the convex hull.
    pub hull_edges: u64,
    /// Number of vertices on the convex hull, including those inside its faces.
    pub hull_vertices: u64,
    /// The least and the largest coordinate on each axis. Empty if there are no points.
    pub extent: Vec<[f64; 2]>,
    /// The area of the hull in the plane, or its volume in space: the sum of the rounded measures of all cells, rounded once.
    pub volume: f64,
    /// The length of the boundary in the plane, or its area in space.
    pub surface: f64,
    /// The number of edges at each vertex.
    pub degrees: Histogram,
    /// The shapes of the cells: radius-edge ratios, angles, slivers and measures.
    pub shapes: Shapes,
}

/// The bins of the degrees: one for each degree below 64.
pub(crate) fn degrees() -> Histogram {
    Histogram::new(0.0, 64.0, 64)
}

/// The measures of some cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured {
    /// The shapes of the cells.
    pub shapes: Shapes,
    /// The measure of their hull facets.
    pub surface: ExactSum,
    /// Number of hull facets.
    pub hull_facets: u64,
}

impl Measured {
    /// Adds other cells.
    pub fn merge(&mut self, other: &Measured) {
        self.shapes.merge(&other.shapes);
        self.surface.merge(&other.surface);
        self.hull_facets += other.hull_facets;
    }

    /// Appends the measures to words, to be sent.
    pub fn append_to(&self, words: &mut Vec<u64>) {
        self.shapes.append_to(words);
        words.extend(self.surface.to_words());
        words.push(self.hull_facets);
    }

    /// Takes measures from words. Returns `None` if there are too few.
    pub fn read_from(words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let shapes = Shapes::read_from(words)?;
        let surface = ExactSum::from_words(words)?;
        Some(Measured { shapes, surface, hull_facets: words.next()? })
    }

    fn add_facet<P: Point>(&mut self, corners: &[P]) {
        let Some(measure) = facet_measure(corners) else { return };
        self.surface.add(measure);
        self.hull_facets += 1;
    }
}

/// Returns the length or area of a facet, rounded. Its differences are divided by a power of two near the largest one, which
/// leaves room for products.
fn facet_measure<P: Point>(corners: &[P]) -> Option<f64> {
    let (first, others) = corners.split_first()?;
    let coordinates = others.iter().flat_map(|&p| (0..P::DIM).map(move |i| (p - *first).coord(i).abs()));
    let unit = power_below(coordinates.fold(0.0, f64::max));
    let near = |p: P| (p - *first) * (1.0 / unit);
    match *others {
        [b, c] => Some((P::hull_normal(&[near(b), near(c)]) * 0.5).norm2().sqrt() * unit * unit),
        [b] => Some(near(b).norm2().sqrt() * unit),
        _ => None,
    }
}

/// Returns the largest normal power of two up to `x`, or the least one. Returns 1 if `x` is zero or not finite.
fn power_below(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return 1.0;
    }
    f64::from_bits(x.to_bits() & (0x7ff << 52)).max(f64::MIN_POSITIVE)
}

/// A vertex of a cell, with its input index first.
type Corner<P> = (u64, P);

/// A share of a triangulation, with the places of its points.
pub(crate) struct PlacedShare<'a> {
    pub share: &'a WorkerShare,
    /// The coordinates of the points of the share, or of all points of the input.
    pub coordinates: &'a [f64],
    /// Whether `coordinates` are those of the share.
    pub is_own: bool,
    /// Number of coordinates of a point.
    pub space: usize,
}

impl PlacedShare<'_> {
    /// Measures all cells, and the hull facets among their facets if they have neighbours.
    pub fn measure(&self) -> Measured {
        if self.space == 2 { self.blocks::<DVec2>() } else { self.blocks::<DVec3>() }
    }

    fn blocks<P: Space>(&self) -> Measured {
        let cells = self.share.cell_count();
        let size = cells.div_ceil(2 * threads()).max(BLOCK);
        let parts = map_blocks(cells, size, |cells| {
            let mut measured = Measured::default();
            cells.for_each(|cell| self.cell::<P>(cell, &mut measured));
            measured
        });
        let mut all = Measured::default();
        for part in &parts {
            all.merge(part);
        }
        all
    }

    fn cell<P: Space>(&self, cell: usize, measured: &mut Measured) {
        let row = self.share.cell(cell);
        let mut corners = [(0, P::default()); 4];
        for (corner, &vertex) in corners.iter_mut().zip(row) {
            *corner = (self.share.ids[vertex as usize], self.place(vertex));
        }
        let corners = &mut corners[..row.len()];
        for slot in 0..row.len() {
            if self.share.neighbour(cell, slot) == Some(Neighbour::Hull) {
                let mut facet: Vec<Corner<P>> = corners.to_vec();
                facet.swap_remove(slot);
                facet.sort_by_key(|corner| corner.0);
                let places: Vec<P> = facet.iter().map(|corner| corner.1).collect();
                measured.add_facet(&places);
            }
        }
        // The measures take the absolute value, so the order need not keep the orientation.
        corners.sort_by_key(|corner| corner.0);
        let mut places = [P::default(); 4];
        places.iter_mut().zip(&*corners).for_each(|(place, corner)| *place = corner.1);
        measured.shapes.add(&Shape::of(&places[..row.len()]));
    }

    /// Returns the place of a point of the share.
    fn place<P: Point>(&self, vertex: u32) -> P {
        let at = if self.is_own { vertex as usize } else { self.share.ids[vertex as usize] as usize };
        let mut place = P::default();
        for (i, &x) in self.coordinates[at * self.space..][..self.space].iter().enumerate() {
            place.set_coord(i, x);
        }
        place
    }

    /// Returns for each point of the share the number of cells of the share at it, plus `2^32` times the number of hull facets.
    pub fn incidences(&self) -> Vec<u64> {
        let mut at = vec![0; self.share.ids.len()];
        for cell in 0..self.share.cell_count() {
            let row = self.share.cell(cell);
            for &vertex in row {
                at[vertex as usize] += 1;
            }
            for slot in 0..row.len() {
                if self.share.neighbour(cell, slot) == Some(Neighbour::Hull) {
                    let facet = row.iter().enumerate().filter(|(i, _)| *i != slot);
                    facet.for_each(|(_, &vertex)| at[vertex as usize] += HULL_FACET);
                }
            }
        }
        at
    }
}

/// The weight of a hull facet among the incidences of a vertex.
pub(crate) const HULL_FACET: u64 = 1 << 32;

/// Returns the number of edges at a vertex with these incidences.
pub(crate) fn degree(space: usize, incidences: u64) -> u64 {
    let (cells, hull) = (incidences % HULL_FACET, incidences / HULL_FACET);
    match (space, hull) {
        (2, 0) => cells,
        (2, _) => cells + 1,
        (_, 0) => 2 + cells / 2,
        (_, hull) => 1 + u64::midpoint(cells, hull),
    }
}

/// The hull facets of cells without neighbours: those that belong to one cell only. Returns their measures, and the rows of their
/// vertices.
pub(crate) fn hull_of(shares: &[PlacedShare<'_>]) -> (Measured, Vec<u64>) {
    match shares.first().map(|share| share.space) {
        None => (Measured::default(), Vec::new()),
        Some(2) => unpaired::<DVec2>(shares),
        Some(_) => unpaired::<DVec3>(shares),
    }
}

fn unpaired<P: Space>(shares: &[PlacedShare<'_>]) -> (Measured, Vec<u64>) {
    let mut rows = Vec::new();
    for placed in shares {
        for cell in 0..placed.share.cell_count() {
            let ids: Vec<u64> = placed.share.cell_ids(cell).collect();
            for slot in 0..ids.len() {
                let start = rows.len();
                rows.extend(ids.iter().enumerate().filter(|(i, _)| *i != slot).map(|(_, id)| *id));
                rows[start..].sort_unstable();
            }
        }
    }
    sort_rows(&mut rows, P::DIM);
    let (mut measured, mut hull) = (Measured::default(), Vec::new());
    // A process that has all points finds them by their indices.
    let coordinates = shares.first().map_or(&[][..], |share| share.coordinates);
    let place = |&id: &u64| {
        let mut place = P::default();
        (0..P::DIM).for_each(|i| place.set_coord(i, coordinates[id as usize * P::DIM + i]));
        place
    };
    for group in rows.chunks_exact(P::DIM).collect::<Vec<_>>().chunk_by(|a, b| a == b) {
        if let [facet] = group {
            measured.add_facet(&facet.iter().map(place).collect::<Vec<P>>());
            hull.extend_from_slice(facet);
        }
    }
    (measured, hull)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_of_any_size_have_measures() {
        let close = |found: Option<f64>, wanted: f64| {
            let found = found.unwrap();
            assert!((found / wanted - 1.0).abs() < 1e-14, "{found} {wanted}");
        };
        for size in [1e-300, 1e-170, 1.0, 1e156, 1e300] {
            let edge = [DVec2::new(-size, size), DVec2::new(2.0 * size, 5.0 * size)];
            close(facet_measure(&edge), 5.0 * size);
        }
        for size in [1e-150, 1e-90, 1.0, 1e90, 1e153] {
            let triangle = [DVec3::ZERO, DVec3::new(3.0 * size, 0.0, 0.0), DVec3::new(size, 0.0, 4.0 * size)];
            close(facet_measure(&triangle), 6.0 * size * size);
        }
        assert_eq!(facet_measure(&[DVec2::ONE, DVec2::ONE]), Some(0.0));
        assert_eq!(facet_measure(&[DVec2::ZERO, DVec2::new(0.0, 5e-324)]), Some(5e-324));
    }
}
