//! Points in the volume.
//!
//! **Statement.**
//! 1. Candidates lie in the cells of an octree (in the plane: a quadtree), inside the domain and outside the balls of
//!    subsegments and subfacets.
//! 2. A maximal independent set of them is taken, with all earlier points fixed.
//! 3. Circumcentres of cells that are too large are added until no cell is too large. A circumcentre in one of these
//!    balls is moved off-centre, out of the ball.

use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Simplex, dist2};

use super::balls::{Ball, Balls};
use super::barrier::{Barrier, Own};
use super::cell_labels::CellLabels;
use super::facets::{Subfeatures, circumcircle};
use super::generator::{CANDIDATES, Candidate, Generator, Rules, SIDE};
use super::machine::{Delaunay, MeshMachine};
use super::missing::MissingParts;
use super::segments::subsegments_of;
use super::{GenerationError, Missing};
use crate::bvh::{Bounds, Bvh};
use crate::domain::Domain;
use crate::mesh::Carrier;
use crate::octree::{Cell, CellKey, Cube, DEEPEST};
use crate::points::candidates::Name;
use crate::points::conflicts::Site;
use crate::space::Space;

/// Cells, and whether each is known to lie completely in the domain.
pub(super) type Sampled<P> = Vec<(Cell<P>, bool)>;

/// The number of cells per item of a parallel map.
const CHUNK: usize = 1024;

/// The number of cells between two checks of the limit.
const SEVERAL: usize = 1 << 20;

/// The maximum number of cells per vertex. Sides are at least 0.7 times the size, so there are at most 3 cells per
/// volume `f^d`. There is at least one vertex for every two such volumes.
pub(super) const CELLS: u64 = 6;

/// The maximum number of times that a ball is widened by a fifth until it contains a point.
const MOST_WIDENINGS: u32 = 40;

/// The triangulation of all points.
pub(super) struct Filled<P: Space> {
    pub(super) delaunay: Delaunay<P::Cell>,
    pub(super) labels: CellLabels,
    pub(super) barrier: Barrier<P::Facet>,
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Places the points of the volume. Returns the final triangulation and the component of each cell.
    pub(super) fn volume(
        &mut self,
        own: Own<'_>,
        cells: &[(Cell<P>, bool)],
    ) -> Result<Filled<P>, GenerationError<M::Error>> {
        self.begin("volume");
        let Own { planes, chains, subfacets } = own;
        let flats = Subfeatures { subsegments: subsegments_of(chains), subfacets };
        let first = self.vertices.len();
        let found = self.machine.map(cells, |(cell, whole)| self.candidates_of(cell, *whole));
        self.sample(found.into_iter().flatten().collect()).map_err(GenerationError::Machine)?;
        loop {
            if self.vertices.len() as u64 > self.rules.most {
                return Err(GenerationError::TooMany(self.rules.most));
            }
            let delaunay = self.machine.delaunay(&self.vertices.points).map_err(GenerationError::Machine)?;
            let missing = self.missing(&delaunay, planes, chains, subfacets);
            if !missing.is_empty() {
                self.clear(first, &missing)?;
                continue;
            }
            let barrier = self.barrier(own, &delaunay);
            let labels = self.labels(&delaunay, &barrier);
            let numbers: Vec<u32> = (0..delaunay.cells.len() as u32).collect();
            let chunks: Vec<&[u32]> = numbers.chunks(4096).collect();
            let found = self.machine.map(&chunks, |chunk| self.centres_of(chunk, &delaunay, &labels, &flats));
            let (off_centre, mut found): (Vec<_>, Vec<_>) =
                found.into_iter().flatten().partition(|(_, off_centre)| *off_centre);
            found.extend(self.free(off_centre));
            let found = found.into_iter().map(|(site, _)| (site, Carrier::Volume)).collect();
            if self.complete(found, true).map_err(GenerationError::Machine)? == 0 {
                return Ok(Filled { delaunay, labels, barrier });
            }
        }
    }

    /// Removes the points of the volume that displaced subsegments and subfacets from the triangulation. The points
    /// are removed from widened balls around the missing simplices. Only simplices whose smallest balls contain a
    /// vertex can be affected. The balls are widened by a fifth until they contain a point, and no further points are
    /// placed in them.
    fn clear(&mut self, first: usize, missing: &MissingParts) -> Result<(), GenerationError<M::Error>> {
        let at = |v: u32| self.vertices.points[v as usize];
        let subsegments = missing.subsegments.iter().map(|&(_, [a, b])| {
            let (p, q) = (at(a), at(b));
            Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) }
        });
        let subfacets = missing.subfacets.iter().map(|(_, t)| {
            let [a, b, c] = t.map(at);
            circumcircle(a, b, c)
        });
        let mut balls: Vec<Ball<P>> = subsegments.chain(subfacets).collect();
        let before = self.closed.all().to_vec();
        for ball in &mut balls {
            let same = before.iter().filter(|c| c.centre == ball.centre).map(|c| c.radius2);
            ball.radius2 = same.fold(ball.radius2, f64::max);
        }
        // Points of the volume must be the cause, because nothing was missing without them.
        for _ in 0..MOST_WIDENINGS {
            for ball in &mut balls {
                ball.radius2 *= 1.44;
            }
            self.closed = Balls::new(before.iter().chain(&balls).copied().collect());
            let count = self.vertices.len();
            let kept: Vec<bool> =
                (0..count).map(|v| v < first || !self.closed.hold(self.vertices.points[v])).collect();
            self.vertices.keep(&kept);
            if self.vertices.len() < count {
                return Ok(());
            }
        }
        Err(GenerationError::Missing(Missing { features: missing.features() }))
    }

    /// Returns `true` if the point lies outside all balls.
    pub(super) fn is_open(&self, at: P) -> bool {
        !self.subsegments.hold(at) && !self.subfacets.hold(at) && !self.closed.hold(at)
    }

    pub(super) fn candidates_of(&self, cell: &Cell<P>, whole: bool) -> Vec<Candidate<P>> {
        let names =
            (0..CANDIDATES).map(|number| Name { cell: cell.key, number }.place(cell, self.rules.seed));
        let free = names.filter(|&at| self.is_open(at) && (whole || self.domain.is_inside(at)));
        free.map(|at| (self.rules.site(at), Carrier::Volume)).collect()
    }

    /// Returns the centres of cells that are too large. A flag marks off-centre points.
    fn centres_of(
        &self,
        cells: &[u32],
        delaunay: &Delaunay<P::Cell>,
        labels: &CellLabels,
        flats: &Subfeatures<'_>,
    ) -> Vec<(Site<P>, bool)> {
        let mut found = Vec::new();
        for &i in cells.iter().filter(|&&i| labels.is_inside(i)) {
            // The rounding must not depend on the order in which a machine returns the vertices.
            let mut cell = delaunay.cells[i as usize];
            cell.as_mut().sort_unstable();
            let mut corners = [P::default(); 4];
            let mut largest = 0.0f64;
            for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
                *corner = self.vertices.points[v as usize];
                largest = largest.max(self.vertices.sizes[v as usize]);
            }
            let centre = circumcentre(&corners[..P::Cell::LEN]);
            let radius = dist2(centre, corners[0]).sqrt();
            if !radius.is_finite() || !self.rules.is_too_large(centre, radius, largest) {
                continue;
            }
            let open = self.is_open(centre);
            let place = if open { Some(centre) } else { self.off_centre(centre, flats) };
            let inside = place.filter(|&x| self.domain.is_inside(x));
            found.extend(inside.map(|x| (self.rules.site(x), !open)));
        }
        found
    }
}

/// Returns cells whose sides are at most [`SIDE`] times the size, and whether each is known to lie completely in the
/// domain. The cells are built level by level, each level in parallel.
///
/// Returns `None` if there are more than [`CELLS`] per vertex allowed. The mesh would then exceed the limit.
pub(super) fn sampling_cells<P: Space, M: MeshMachine<P> + Sync>(
    domain: &Domain<P>,
    rules: &Rules<'_, P>,
    machine: &M,
) -> Option<Sampled<P>> {
    let most = rules.most.saturating_mul(CELLS);
    let points = domain.points();
    let boxes = domain.walls().iter().map(|w| Bounds::of(w.as_ref().iter().map(|&v| points[v as usize])));
    let walls = Bvh::new(boxes.collect());
    let cube = Cube::around(&walls.bounds());
    let (mut found, mut open) = (Vec::new(), vec![(CellKey::ROOT, false)]);
    while !open.is_empty() {
        let level = std::mem::take(&mut open);
        for several in level.chunks(SEVERAL) {
            let chunks: Vec<&[(CellKey, bool)]> = several.chunks(CHUNK).collect();
            for (small, divided) in machine.map(&chunks, |chunk| sorted(domain, rules, &walls, &cube, chunk))
            {
                found.extend(small);
                open.extend(divided);
            }
            if (found.len() + open.len()) as u64 > most {
                return None;
            }
        }
    }
    Some(found)
}

/// Separates the cells that are small enough from the children of the other cells.
fn sorted<P: Space>(
    domain: &Domain<P>,
    rules: &Rules<'_, P>,
    walls: &Bvh<P>,
    cube: &Cube<P>,
    cells: &[(CellKey, bool)],
) -> (Sampled<P>, Vec<(CellKey, bool)>) {
    let (mut small, mut divided) = (Vec::new(), Vec::new());
    for &(key, whole) in cells {
        let cell = cube.cell(key);
        let Some(whole) = met(domain, walls, &cell, whole) else { continue };
        if SIDE * (rules.size)(cell.centre) < cell.side && key.level < DEEPEST {
            divided.extend((0..1 << P::DIM).map(|i| (key.child::<P>(i), whole)));
        } else {
            small.push((cell, whole));
        }
    }
    (small, divided)
}

/// Returns whether the domain contains the whole cell, or `None` if the cell lies outside. `whole` is the answer for
/// its parent.
fn met<P: Space>(domain: &Domain<P>, walls: &Bvh<P>, cell: &Cell<P>, whole: bool) -> Option<bool> {
    if whole {
        return Some(true);
    }
    let half = P::splat(0.5 * cell.side);
    let mut met = false;
    walls.visit(&Bounds { low: cell.centre - half, high: cell.centre + half }, |_| {
        met = true;
        false
    });
    let whole = !met && domain.is_inside(cell.centre);
    (met || whole).then_some(whole)
}
