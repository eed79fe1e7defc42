//! The constrained Delaunay triangulation of a domain in space.
//!
//! **Statement.** [`constrain`] returns cells whose faces tile all facets and whose edges tile all segments. Its
//! vertices are those of the input, and points on edges of the input where an edge cannot be kept otherwise. Its steps
//! are
//! 1. the Delaunay triangulation of the vertices and of the corners of a box around them, by the [`MeshMachine`];
//! 2. `segments`: edges of the input that are missing are recovered by exchanges of cells, or divided at exact points
//!    on them;
//! 3. `facets`: cells that a missing triangle of a facet crosses are replaced (`wrap`);
//! 4. the components of cells, by the sides of the walls ([`crate::sides`]);
//! 5. `rounding`: points become doubles, and no cell becomes flat or inverted;
//! 6. points on edges are removed where the cells allow it (`refine`), because the order of the steps before may have
//!    added more than are needed. Refinement follows if it is requested.
//!
//! *Why it exists.* Without exchanges, all edges of the input consist of edges of the perturbed Delaunay triangulation
//! after step 2. Then the constrained triangulation exists without further points (Shewchuk 2008). Steps 1 to 4 use
//! exact signs of exact points (`points`), so no case is degenerate except for ties, which the perturbation of the
//! geometry crate breaks. Only step 5 can fail, and then names the features of its cells.
//!
//! *Why points are exact until the end.* A mesh may have doubles near a facet: to lie on it is a property of carriers,
//! and [`crate::conformity`] admits a small distance. But the proof of step 3 needs facets that are planar and edges
//! that are straight. A point `a + t (b - a)` with a double t is a whole multiple of a power of two, so exact signs need
//! no division.
//!
//! **Source.** Si (2015), Diazzi, Panozzo, Vaxman and Attene (2023), Shewchuk (2008).
//!
//! **Departures.** The first attempt exchanges cells, so that few points are added. Its cells are Delaunay except near
//! nearly cospherical points, and the theorem does not apply. If it fails, the second attempt has no exchanges. If a patch
//! cannot be recovered, a subsegment at its missing triangles is halved, and all patches are recovered again. In the
//! second attempt, the theorem makes this rare.
//!
//! **Work and depth.** One triangulation by the machine; the rest is sequential.

mod cells;
mod facets;
mod layout;
mod planar;
mod points;
mod recovered;
mod refine;
mod result;
mod rounding;
mod segments;
mod wrap;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::predicates::Sign;

use crate::bvh::Bounds;
use crate::domain::{Domain, Feature};
use crate::generate::{GeneratedMesh, GenerationError, MeshMachine, Missing, Rules, StageCounts};
use crate::space::Space;

use cells::Cells;
use facets::{Kept, Patches};
use layout::Layout;
use points::Points;
use recovered::Recovered;
use refine::{Limits, Stopped, collapsed, refine};
use segments::{Limit, Subsegments};

/// The name of the stage that recovers edges and facets.
const RECOVERY: &str = "recovery";

/// The number of corners of the box.
const BOX: usize = 8;

/// The number of times that all patches are recovered again.
const ATTEMPTS: u32 = 24;

/// The largest number of points for each vertex and edge of the input.
const POINTS_PER_EDGE: usize = 8;

/// A failure of a step: the features that cannot be kept, with the numbers of missing parts.
type Lost = BTreeMap<Feature, u32>;

/// The state of a recovery.
struct Recovery<'a> {
    layout: Layout,
    points: Points,
    cells: Cells,
    subs: Subsegments,
    limit: Limit<'a>,
}

/// Computes the constrained triangulation of a domain as it is: without sizes and without quality.
///
/// # Errors
/// Returns [`GenerationError::Unsupported`] in the plane. Returns another [`GenerationError`] if the machine fails, or
/// if features cannot be kept.
pub fn constrain<P: Space, M: MeshMachine<P>>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &mut M,
) -> Result<GeneratedMesh<P>, GenerationError<M::Error>> {
    let made = recover(domain, rules, machine)?;
    let (mesh, removed) = collapsed(&made);
    Ok(GeneratedMesh { stages: recovered_stages(made.stages, removed), ..mesh })
}

/// Computes the constrained triangulation, and what it keeps.
fn recover<P: Space, M: MeshMachine<P>>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &mut M,
) -> Result<Recovered, GenerationError<M::Error>> {
    if P::DIM != 3 {
        return Err(GenerationError::Unsupported(
            "only domains in space have a constrained tetrahedralization",
        ));
    }
    let missing =
        |lost: Lost| GenerationError::Missing(Missing::of(domain, lost.into_iter().collect(), false));
    machine.stage("triangulation");
    let layout = Layout::new(domain);
    let points = boxed(&layout);
    let sent: Vec<P> = points.at.iter().map(|p| P::from_coords(&p.to_array())).collect();
    let made = machine.delaunay(&sent).map_err(GenerationError::Machine)?;
    let rows = made.cells.iter().map(|c| [0, 1, 2, 3].map(|i| c.as_ref()[i]));
    let cells = Cells::new(points.len(), rows);
    let first = StageCounts {
        name: "triangulation",
        candidates: points.len() as u64,
        points: (layout.points.len() - domain.corners.len()) as u64,
        ..StageCounts::default()
    };

    machine.stage(RECOVERY);
    let most = points.len() + POINTS_PER_EDGE * (layout.parts.len() + 64);
    let most = most.min(usize::try_from(rules.most).unwrap_or(usize::MAX));
    let is_cancelled = || machine.cancelled().is_some();
    let limit = Limit { points: most, is_cancelled: &is_cancelled };
    let attempt = |exchanges| {
        let subs = Subsegments::new(&points, &layout.parts, exchanges);
        let (points, cells) = (points.clone(), cells.clone());
        let mut recovery = Recovery { layout: layout.clone(), points, cells, subs, limit };
        recovery.segments()?;
        let (kept, missing) = recovery.facets(exchanges)?;
        let mut made = recovery.rounded(domain, &kept)?;
        let stage =
            |name, candidates, points| StageCounts { name, candidates, points, ..StageCounts::default() };
        let recovered = stage(RECOVERY, missing, recovery.added());
        let rounded = stage("rounding", made.rounded, 0);
        made.stages = vec![first, recovered, rounded];
        Ok(made)
    };
    let made = attempt(true).or_else(|_: Lost| attempt(false));
    if let Some(error) = machine.cancelled() {
        return Err(GenerationError::Machine(error));
    }
    let made = made.map_err(missing)?;
    // The attempts round as well; this stage has only their counts.
    machine.stage("rounding");
    Ok(made)
}

/// Computes the constrained triangulation of a domain, and refines it. Also returns the cells that refinement visited.
///
/// # Errors
/// Returns the errors of [`constrain`], and [`GenerationError::TooMany`] if the mesh needs too many vertices.
pub fn constrain_and_refine<P: Space, M: MeshMachine<P>>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    wish: Wish,
    machine: &mut M,
) -> Result<(GeneratedMesh<P>, u64), GenerationError<M::Error>> {
    let made = recover(domain, rules, machine)?;
    machine.stage("refinement");
    let frame = &domain.simplices.frame;
    let snapped = |p: DVec3| layout::space(frame.snapped(P::from_coords(&p.to_array())));
    let size = |p: DVec3| rules.size.at(P::from_coords(&p.to_array()));
    let is_cancelled = || machine.cancelled().is_some();
    let limits = Limits {
        ratio: wish.ratio,
        size: &size,
        snapped: &snapped,
        divides: wish.divides,
        most: rules.most,
        is_cancelled: &is_cancelled,
    };
    let stopped = |_: Stopped| {
        machine.cancelled().map_or(GenerationError::TooMany(rules.most), GenerationError::Machine)
    };
    let (mut mesh, done) = refine(&made, &limits).map_err(stopped)?;
    mesh.stages = recovered_stages(made.stages, done.removed);
    mesh.stages.push(StageCounts {
        name: "refinement",
        candidates: done.bad,
        points: done.points,
        ..StageCounts::default()
    });
    Ok((mesh, done.visits))
}

/// Returns the stages of recovery, without the points that were removed afterwards.
fn recovered_stages(mut stages: Vec<StageCounts>, removed: u64) -> Vec<StageCounts> {
    for stage in stages.iter_mut().filter(|s| s.name == RECOVERY) {
        stage.points -= removed;
    }
    stages
}

/// What refinement must reach, and what it may divide.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// The largest ratio of circumradius and shortest edge.
    pub ratio: f64,
    /// Whether edges and facets of the input may be divided.
    pub divides: bool,
}

/// Returns the vertices, and the corners of a box around them.
fn boxed(layout: &Layout) -> Points {
    let bounds = Bounds::of(layout.points.iter().copied());
    let extent = bounds.extent().max_element();
    // The power of two above the extent keeps the digits of the corners few.
    let room = f64::from_bits(extent.to_bits() & (0x7ff << 52)) * 2.0;
    let (low, high) = (bounds.low - DVec3::splat(room), bounds.high + DVec3::splat(room));
    let corner = |i: usize| {
        let side = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(side(0), side(1), side(2))
    };
    let mut planes = layout.planes();
    planes.extend(vec![Vec::new(); BOX]);
    Points::new(layout.points.iter().copied().chain((0..BOX).map(corner)).collect(), planes)
}

impl Recovery<'_> {
    /// Returns the number of points that were added.
    fn added(&self) -> u64 {
        (self.points.len() - self.points.given()) as u64
    }

    fn lost(&self, part: u32) -> Lost {
        self.layout.parts[part as usize].carrier.feature().map(|f| (f, 1)).into_iter().collect()
    }

    fn segments(&mut self) -> Result<(), Lost> {
        let Recovery { layout, points, cells, subs, limit } = self;
        subs.recover((points, cells), &layout.parts, *limit).map_err(|part| self.lost(part))
    }

    /// Recovers all patches. Returns their faces, and the number of triangles that were missing.
    fn facets(&mut self, exchanges: bool) -> Result<(Kept, u64), Lost> {
        let mut attempt = 0;
        loop {
            let chains = self.subs.chains(self.layout.parts.len());
            let mut cells = self.cells.clone();
            let Recovery { layout, points, subs, .. } = &*self;
            let mut patches = Patches { points, cells: &mut cells, subs, kept: Kept::new(), missing: 0 };
            let mut failed = None;
            for (p, patch) in (0u32..).zip(&layout.patches) {
                if (self.limit.is_cancelled)() {
                    return Err(Lost::new());
                }
                let on: Vec<&[u32]> = patch.parts.iter().map(|&i| chains[i as usize].as_slice()).collect();
                let apex = apex(points, patch.triangles[0]);
                let triangles = planar::triangulate(
                    points,
                    &patch.triangles,
                    &on,
                    apex,
                    &patches.edges_between(&on, exchanges),
                );
                if let Err(region) = patches.recover(p, &triangles) {
                    failed = Some((patch, region));
                    break;
                }
            }
            let Some((patch, region)) = failed else {
                let found = (patches.kept, patches.missing);
                self.cells = cells;
                return Ok(found);
            };
            attempt += 1;
            let lost: Lost = [(Feature::Facet(patch.facet), 1)].into();
            let longest =
                self.longest(patch, &region, &chains).filter(|_| attempt <= ATTEMPTS).ok_or(lost)?;
            let Recovery { layout, points, cells, subs, limit } = self;
            let halved = subs.halve((points, cells), &layout.parts, longest, *limit);
            halved.map_err(|part| self.lost(part))?;
        }
    }

    /// Returns the longest subsegment at some triangles of a patch, or else of the patch.
    fn longest(&self, patch: &layout::Patch, region: &[[u32; 3]], chains: &[Vec<u32>]) -> Option<[u32; 2]> {
        let length = |e: &[u32; 2]| {
            let [a, b] = e.map(|v| self.points.at[v as usize]);
            a.distance_squared(b)
        };
        let near = region.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let near = near.filter(|&e| self.subs.has(e)).max_by(|a, b| length(a).total_cmp(&length(b)));
        let edges = patch.parts.iter().flat_map(|&p| chains[p as usize].windows(2)).map(|w| [w[0], w[1]]);
        near.or_else(|| edges.max_by(|a, b| length(a).total_cmp(&length(b))))
    }
}

/// Returns a corner of the box outside the plane of a triangle.
fn apex(points: &Points, [a, b, c]: [u32; 3]) -> u32 {
    let first = (points.given() - BOX) as u32;
    let outside = |v: &u32| points.orientation([a, b, c, *v]) != Sign::Zero;
    (first..points.given() as u32).find(outside).unwrap_or(first)
}
