//! Points in the volume.
//!
//! **Statement.**
//! 1. Candidates lie in the cells of an octree (in the plane: a quadtree), inside the domain and outside the balls of
//!    subsegments and subfacets.
//! 2. A maximal independent set of them is taken, with all earlier points fixed.
//! 3. Circumcentres of cells that are too large are added until no cell is too large. A circumcentre in one of these
//!    balls is moved off-centre, out of the ball.

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::At;
use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Simplex, dist2};

use super::balls::{Ball, Balls};
use super::barrier::{Barrier, Own};
use super::cell_labels::CellLabels;
use super::error::{GenerationError, Missing};
use super::facets::{Subfeatures, circumcircle};
use super::generator::{CANDIDATES, Candidate, Generator, Rules, SIDE};
use super::machine::{Delaunay, MeshMachine};
use super::missing::MissingParts;
use super::segments::subsegments_of;
use super::subdivision::{Division, divided};
use crate::bvh::{Bounds, Bvh};
use crate::domain::Domain;
use crate::executor::{Evaluator, Part, evaluated, in_sequence};
use crate::mesh::Carrier;
use crate::octree::{Cell, CellKey, Cube, DEEPEST};
use crate::points::candidates::Name;
use crate::space::Space;

/// A cell, and whether it is known to lie completely in the domain.
pub(super) type SampledCell = (CellKey, bool);

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
        cells: &[SampledCell],
    ) -> Result<Filled<P>, GenerationError<M::Error>> {
        self.begin("volume");
        let Own { planes, chains, subfacets } = own;
        let flats = Subfeatures { subsegments: subsegments_of(chains), subfacets };
        let first = self.vertices.len();
        let found = self.volume_candidates(cells).map_err(GenerationError::Machine)?;
        self.sample(found).map_err(GenerationError::Machine)?;
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
            let found = self.coarse_cells(&delaunay, &labels, &flats).map_err(GenerationError::Machine)?;
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
        Err(GenerationError::Missing(Missing::of(self.domain, missing.features(), false)))
    }

    /// Returns `true` if the point lies outside all balls. Counts the visits of their trees.
    pub(super) fn is_open(&self, at: P, visits: &mut Sweep) -> bool {
        let mut hold = |balls: &Balls<P>| balls.hold_counted(at, visits);
        !hold(&self.subsegments) && !hold(&self.subfacets) && !hold(&self.closed)
    }

    /// Returns the candidates in cells of the volume.
    pub(super) fn volume_candidates(&self, cells: &[SampledCell]) -> Result<Vec<Candidate<P>>, M::Error> {
        let cube = root_of(self.domain);
        let places = evaluated(&*self.machine, Part::Candidates, cells, |(key, whole): SampledCell, own| {
            let cell = cube.cell(key);
            let place = |number| {
                let at = Name { cell: key, number }.place(&cell, self.rules.seed);
                let is_free = in_sequence(own, |visits| {
                    self.is_open(at, visits) && (whole || self.domain.is_inside_counted(at, visits))
                });
                is_free.then_some(At(at))
            };
            (0..CANDIDATES).filter_map(place).collect::<Vec<At<P>>>()
        })?;
        self.sized(places.into_iter().flatten().map(|at| (at.0, Carrier::Volume)).collect())
    }

    /// Returns the centres of cells that are too large, and off-centre points instead of the centres in balls.
    pub(super) fn coarse_cells(
        &self,
        delaunay: &Delaunay<P::Cell>,
        labels: &CellLabels,
        flats: &Subfeatures<'_>,
    ) -> Result<Vec<Candidate<P>>, M::Error> {
        let inside: Vec<u32> = (0..delaunay.cells.len() as u32).filter(|&i| labels.is_inside(i)).collect();
        let found = evaluated(&*self.machine, Part::Completion, &inside, |i: u32, own| {
            in_sequence(own, |visits| self.centre_of(&delaunay.cells[i as usize], flats, visits))
        })?;
        let (off_centre, free): (Vec<_>, Vec<_>) =
            found.into_iter().flatten().partition(|(_, off_centre)| *off_centre);
        let sized = |found: Vec<(At<P>, bool)>| {
            self.sized(found.into_iter().map(|(at, _)| (at.0, Carrier::Volume)).collect())
        };
        let mut all = sized(free)?;
        all.extend(self.free(sized(off_centre)?)?);
        Ok(all)
    }

    /// Returns the centre of a cell that is too large. A flag marks an off-centre point.
    fn centre_of(
        &self,
        cell: &P::Cell,
        flats: &Subfeatures<'_>,
        visits: &mut Sweep,
    ) -> Option<(At<P>, bool)> {
        // The rounding must not depend on the order in which a machine returns the vertices.
        let mut cell = *cell;
        cell.as_mut().sort_unstable();
        let mut corners = [P::default(); 4];
        let mut largest = 0.0f64;
        for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
            *corner = self.vertices.points[v as usize];
            largest = largest.max(self.vertices.sizes[v as usize]);
        }
        let centre = circumcentre(&corners[..P::Cell::LEN]);
        let radius = dist2(centre, corners[0]).sqrt();
        if !radius.is_finite() || !self.rules.is_too_large(centre, radius, largest, visits) {
            return None;
        }
        let open = self.is_open(centre, visits);
        let place = if open { Some(centre) } else { self.off_centre(centre, flats, visits) };
        place.filter(|&x| self.domain.is_inside_counted(x, visits)).map(|x| (At(x), !open))
    }
}

/// Returns the root of the tree of cells: a cube around the walls.
pub(super) fn root_of<P: Space>(domain: &Domain<P>) -> Cube<P> {
    let points = domain.points();
    let corners = domain.walls().iter().flat_map(AsRef::as_ref).map(|&v| points[v as usize]);
    Cube::around(&Bounds::of(corners))
}

/// Returns cells whose sides are at most [`SIDE`] times the size, and whether each is known to lie completely in the
/// domain. The cells are built level by level, each level in parallel.
///
/// Returns `None` if there are more than [`CELLS`] per vertex allowed. The mesh would then exceed the limit.
///
/// # Errors
/// Returns the error of the machine if it fails.
pub(super) fn sampling_cells<P: Space, M: Evaluator<P>>(
    domain: &Domain<P>,
    rules: &Rules<'_, P>,
    machine: &M,
) -> Result<Option<Vec<SampledCell>>, M::Error> {
    let most = rules.most.saturating_mul(CELLS);
    let points = domain.points();
    let boxes = domain.walls().iter().map(|w| Bounds::of(w.as_ref().iter().map(|&v| points[v as usize])));
    let (walls, cube) = (Bvh::new(boxes.collect()), root_of(domain));
    let children = |&(key, whole): &SampledCell| {
        (0..1 << P::DIM).map(|i| (key.child::<P>(i), whole)).collect::<Vec<_>>()
    };
    let decide = |(key, whole): SampledCell, own: &mut Cost| {
        let cell = cube.cell(key);
        in_sequence(own, |visits| {
            let Some(whole) = met(domain, &walls, &cell, whole, visits) else { return Division::Drop };
            let size = rules.size.at_counted(cell.centre, visits);
            let is_wide = SIDE * size < cell.side && key.level < DEEPEST;
            if is_wide { Division::Divide((key, whole)) } else { Division::Leaf((key, whole)) }
        })
    };
    divided(machine, (&[(CellKey::ROOT, false)], 1 << P::DIM, most), children, decide)
}

/// Returns whether the domain contains the whole cell, or `None` if the cell lies outside. `whole` is the answer for
/// its parent.
fn met<P: Space>(
    domain: &Domain<P>,
    walls: &Bvh<P>,
    cell: &Cell<P>,
    whole: bool,
    visits: &mut Sweep,
) -> Option<bool> {
    if whole {
        return Some(true);
    }
    let half = P::splat(0.5 * cell.side);
    let mut met = false;
    walls.visit_counted(&Bounds { low: cell.centre - half, high: cell.centre + half }, visits, |_| {
        met = true;
        false
    });
    let whole = !met && domain.is_inside_counted(cell.centre, visits);
    (met || whole).then_some(whole)
}
