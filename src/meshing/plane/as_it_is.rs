//! The triangulation of a domain in the plane: without new points, or refined.
//!
//! **Statement.** The vertices of the triangulation as it is are the corners of the domain. Every segment is an edge. The
//! cells of a component are those that its segments bound, so holes and the outside have none.
//!
//! *Proof.* Every component inside the domain has a segment on its boundary, and segments separate components. The flood
//! from both sides of all segments therefore reaches each cell of the component, and no other one. Vertices outside
//! the domain change nothing, because segments hide them from its cells.

use glam::DVec2;
use septet_geometry::point::dist2;

use super::constrained::Constrained;
use super::refine::Refiner;
use super::start::Start;
use crate::domain::Domain;
use crate::generate::{
    CellLabels, GeneratedMesh, GenerationError, MeshMachine, Rules, StageCounts, Subsegment, Vertices,
};
use crate::mesh::{Carrier, OUTSIDE};

/// Returns the constrained Delaunay triangulation of a domain whose segments have no inner vertices, and the operations
/// of its sequential part, which inserts the segments. The size at a vertex is the length of its shortest edge.
///
/// # Errors
/// Returns the error of the machine, or the segments that cross others, which a checked domain does not have.
pub fn as_it_is<M: MeshMachine<DVec2>>(
    domain: &Domain<DVec2>,
    machine: &mut M,
) -> Result<(GeneratedMesh<DVec2>, u64), GenerationError<M::Error>> {
    let Start { made, chains, beside, labels } = Start::of(domain, machine)?;
    let faces = (0u32..).zip(&chains).zip(&beside);
    let faces = faces.map(|((segment, &ends), cells)| (segment, ends, cells.map(|c| c.unwrap_or(OUTSIDE))));
    let faces = faces.collect();
    let stages = first_stages(&made, &chains);
    let work = made.work();
    let carriers = (0..domain.corners.len() as u32).map(Carrier::Corner).collect();
    let vertices = Vertices { points: made.points().to_vec(), sizes: shortest_edges(&made), carriers };
    let subsegments = (0u32..).zip(chains).collect();
    let delaunay = made.into_delaunay();
    Ok((GeneratedMesh { vertices, delaunay, labels, faces, subsegments, stages }, work))
}

/// Returns the triangulation of a domain, refined to a least angle in degrees and to the sizes of the rules. Also returns
/// the operations of its sequential part. See `refine` for the angles that it guarantees.
///
/// # Errors
/// Returns the errors of [`as_it_is`], or [`GenerationError::TooMany`].
pub fn refined<M: MeshMachine<DVec2>>(
    domain: &Domain<DVec2>,
    rules: Rules<'_, DVec2>,
    degrees: f64,
    machine: &mut M,
) -> Result<(GeneratedMesh<DVec2>, u64), GenerationError<M::Error>> {
    let start = Start::of(domain, machine)?;
    let mut stages = first_stages(&start.made, &start.chains);
    machine.stage("refinement");
    let corners = start.made.points().len();
    let mut refiner = Refiner::new(domain, rules, start, degrees);
    refiner.run()?;
    let faces = refiner.faces(OUTSIDE);
    let subsegments: Vec<Subsegment> = faces.iter().map(|&(segment, ends, _)| (segment, ends)).collect();
    let Refiner { made, components, carriers, .. } = refiner;
    let added = (made.points().len() - corners) as u64;
    stages.push(StageCounts {
        name: "refinement",
        candidates: added,
        points: added,
        ..StageCounts::default()
    });
    let work = made.work();
    let points = made.points().to_vec();
    let sizes = points.iter().map(|&p| rules.size.at(p)).collect();
    let vertices = Vertices { points, sizes, carriers };
    let (delaunay, labels) = (made.into_delaunay(), CellLabels { of: components });
    Ok((GeneratedMesh { vertices, delaunay, labels, faces, subsegments, stages }, work))
}

/// Returns the counts of the stages before refinement.
fn first_stages(made: &Constrained, chains: &[[u32; 2]]) -> Vec<StageCounts> {
    let stage = |name, candidates, points| StageCounts { name, candidates, points, ..StageCounts::default() };
    // All vertices are corners, which no stage places.
    vec![stage("triangulation", made.points().len() as u64, 0), stage("segments", chains.len() as u64, 0)]
}

/// Returns the length of the shortest edge at each vertex, or 1 without edges.
fn shortest_edges(made: &Constrained) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; made.points().len()];
    for cell in made.cells() {
        for [a, b] in [[cell[0], cell[1]], [cell[1], cell[2]], [cell[2], cell[0]]] {
            let length = dist2(made.points()[a as usize], made.points()[b as usize]);
            for v in [a, b] {
                least[v as usize] = least[v as usize].min(length);
            }
        }
    }
    least.iter().map(|&l| if l.is_finite() { l.sqrt() } else { 1.0 }).collect()
}
