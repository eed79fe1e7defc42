//! Points in the volume, for cells whose faces on the boundary are kept.
//!
//! **Statement.** Candidates and circumcentres are placed as in [`super::volume`], by independent sets. No point on the
//! boundary is added, so balls of subsegments and subfacets protect nothing: a point of the volume keeps a distance of
//! [`APART`] times its size from the walls instead. A circumcentre is placed if no vertex conflicts with it. The
//! points are therefore f-spaced, and there are finitely many. Away from the boundary, circumradii are at most the size
//! where cells are Delaunay. Near the boundary, no bound holds, because it may have triangles of any shape.
//!
//! **Work and depth.** As in [`super::volume`]. Points are inserted one after the other.

use septet_geometry::point::dist2;

use super::cell_labels::CellLabels;
use super::error::GenerationError;
use super::facets::Subfeatures;
use super::generator::{Candidate, Generator, Rules, StageCounts};
use super::machine::{Delaunay, MeshMachine};
use super::vertices::Vertices;
use super::volume::sampling_cells;
use crate::bvh::{Bounds, Bvh};
use crate::distance::closest_on_triangle;
use crate::domain::Domain;
use crate::space::Space;

/// The least distance of a point of the volume from the walls, relative to its size.
const APART: f64 = 0.35;

/// Cells in which points of the volume are inserted.
pub trait Interior<P: Space> {
    /// Returns the cells of the domain. Vertices are numbered in the order in which they were inserted.
    fn cells(&self) -> Vec<P::Cell>;

    /// Inserts points in this order, and returns whether each became a vertex.
    fn insert(&mut self, points: &[P]) -> Vec<bool>;
}

/// Inserts points of the volume. Returns all vertices and the counts of the stage.
///
/// # Errors
/// Returns a [`GenerationError`] if the machine fails, or if the mesh needs too many vertices.
pub fn refine_inside<P: Space, M: MeshMachine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &mut M,
    vertices: Vertices<P>,
    inside: &mut impl Interior<P>,
) -> Result<(Vertices<P>, StageCounts), GenerationError<M::Error>> {
    let cells = sampling_cells(domain, &rules, &*machine).map_err(GenerationError::Machine)?;
    let cells = cells.ok_or(GenerationError::TooMany(rules.most))?;
    let walls = Walls::new(domain);
    let mut generator = Generator::new(domain, rules, machine);
    generator.vertices = vertices;
    generator.begin("volume");
    let mut found = generator.volume_candidates(&cells).map_err(GenerationError::Machine)?;
    walls.retain(&mut found);
    let mut first = generator.vertices.len();
    generator.sample(found).map_err(GenerationError::Machine)?;
    let none = Subfeatures { subsegments: Vec::new(), subfacets: &Vec::new() };
    loop {
        if generator.vertices.len() as u64 > rules.most {
            return Err(GenerationError::TooMany(rules.most));
        }
        let mut kept = vec![true; first];
        kept.extend(inside.insert(&generator.vertices.points[first..]));
        generator.vertices.keep(&kept);
        if generator.vertices.len() == first {
            break;
        }
        first = generator.vertices.len();
        let delaunay = Delaunay { cells: inside.cells(), neighbours: Vec::new() };
        let labels = CellLabels { of: vec![0; delaunay.cells.len()] };
        let found = generator.coarse_cells(&delaunay, &labels, &none);
        let mut found = found.map_err(GenerationError::Machine)?;
        walls.retain(&mut found);
        if generator.complete(found, false).map_err(GenerationError::Machine)? == 0 {
            break;
        }
    }
    let stage = generator.stages.pop().unwrap_or_default();
    Ok((generator.vertices, stage))
}

/// The walls of a domain, with a tree.
struct Walls<P: Space> {
    corners: Vec<[P; 3]>,
    tree: Bvh<P>,
}

impl<P: Space> Walls<P> {
    fn new(domain: &Domain<P>) -> Self {
        let at = |v: u32| domain.points()[v as usize];
        let corners: Vec<[P; 3]> = domain.triangles().into_iter().map(|t| t.map(at)).collect();
        let tree = Bvh::new(corners.iter().map(|t| Bounds::of(*t)).collect());
        Walls { corners, tree }
    }

    /// Keeps the candidates that are far enough from all walls.
    fn retain(&self, found: &mut Vec<Candidate<P>>) {
        found.retain(|(site, _)| {
            let distance2 = |t: u32| {
                let [a, b, c] = self.corners[t as usize];
                dist2(closest_on_triangle(a, b, c, site.at), site.at)
            };
            let mut nearest = f64::INFINITY;
            self.tree.nearest(site.at, distance2, |_, d2| {
                nearest = d2;
                false
            });
            nearest >= (APART * site.size) * (APART * site.size)
        });
    }
}
