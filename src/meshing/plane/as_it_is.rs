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

use super::constrained::{Constrained, NONE};
use super::refine::Refiner;
use crate::domain::{Domain, Feature};
use crate::generate::{
    CellLabels, Delaunay, GeneratedMesh, GenerationError, MeshMachine, Missing, Rules, StageCounts,
    Subsegment, Vertices,
};
use crate::mesh::{Carrier, OUTSIDE};
use crate::space::ascending;

/// The constrained triangulation of a domain.
pub(super) struct Start {
    pub(super) made: Constrained,
    /// The ends of all segments.
    pub(super) chains: Vec<[u32; 2]>,
    /// The cells on the left and on the right of each segment.
    beside: Vec<[Option<u32>; 2]>,
    labels: CellLabels,
}

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
/// the operations of its sequential part. See [`super::refine`] for the angles that it guarantees.
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
    let points = made.points().len() as u64;
    vec![stage("triangulation", points, points), stage("segments", chains.len() as u64, 0)]
}

impl Start {
    fn of<M: MeshMachine<DVec2>>(
        domain: &Domain<DVec2>,
        machine: &mut M,
    ) -> Result<Self, GenerationError<M::Error>> {
        let points: Vec<DVec2> = domain.corners.iter().map(|&v| domain.points()[v as usize]).collect();
        machine.stage("triangulation");
        let delaunay = machine.delaunay(&points).map_err(GenerationError::Machine)?;
        machine.stage("segments");
        let mut made = Constrained::new(points, delaunay);
        let chains = chains(domain);
        let mut crossed = Vec::new();
        for (number, ends) in chains.iter().enumerate() {
            if made.constrain(ends[0], ends[1]).is_err() {
                crossed.push((Feature::Segment(number as u32), 1));
            }
        }
        if !crossed.is_empty() {
            return Err(GenerationError::Missing(Missing::of(domain, crossed, false)));
        }
        let beside: Vec<[Option<u32>; 2]> = chains.iter().map(|&[a, b]| made.beside(a, b)).collect();
        let labels = labels(domain, &made, &beside);
        Ok(Start { made, chains, beside, labels })
    }

    /// Returns the cells inside the domain, sorted, each with its smallest vertex first, and their components. The order does
    /// not depend on the machine.
    pub(super) fn into_inside(self) -> (Constrained, Vec<u32>) {
        let Start { made, labels, .. } = self;
        let mut rows: Vec<([u32; 3], u32, usize)> = Vec::new();
        for (number, corners) in (0u32..).zip(made.cells()).filter(|(number, _)| labels.is_inside(*number)) {
            let first = (1..3).fold(0, |k, i| if corners[i] < corners[k] { i } else { k });
            let mut row = *corners;
            row.rotate_left(first);
            rows.push((row, number, first));
        }
        rows.sort_unstable();
        let mut place = vec![NONE; made.cells().len()];
        for (new, (_, old, _)) in (0u32..).zip(&rows) {
            place[*old as usize] = new;
        }
        let cells = rows.iter().map(|row| row.0).collect();
        let across = |&(_, old, first): &([u32; 3], u32, usize)| {
            [0, 1, 2].map(|i| made.across(old, (i + first) % 3).map_or(NONE, |c| place[c as usize]))
        };
        let mark = |&(_, old, first): &([u32; 3], u32, usize)| {
            (0..3).map(|i| u8::from(made.is_constrained(old, (i + first) % 3)) << i).sum()
        };
        let delaunay = Delaunay { cells, neighbours: rows.iter().map(across).collect() };
        let marks = rows.iter().map(mark).collect();
        let components = rows.iter().map(|row| labels.of[row.1 as usize]).collect();
        let work = made.work();
        let mut inside = Constrained::new(made.points().to_vec(), delaunay);
        (inside.marks, inside.work) = (marks, work);
        (inside, components)
    }
}

/// Returns the ends of all segments as positions among the corners.
fn chains(domain: &Domain<DVec2>) -> Vec<[u32; 2]> {
    let mut position = vec![0; domain.points().len()];
    for (number, &v) in (0u32..).zip(&domain.corners) {
        position[v as usize] = number;
    }
    domain.segments.iter().map(|s| s.ends().map(|v| position[v as usize])).collect()
}

/// Returns the component of each cell.
fn labels(domain: &Domain<DVec2>, made: &Constrained, beside: &[[Option<u32>; 2]]) -> CellLabels {
    let label = |component: u32| {
        if domain.components[component as usize].inside { component } else { CellLabels::OUT }
    };
    let mut seeds = Vec::with_capacity(2 * beside.len());
    for (segment, cells) in domain.segments.iter().zip(beside) {
        // Walls are the parts of segments, and ascend by their ends.
        let ends = ascending(segment.ends());
        let Ok(wall) = domain.walls().binary_search(&ends) else { continue };
        let mut sides = domain.sides.components_at(wall as u32);
        if domain.walls()[wall] != segment.ends() {
            sides.reverse();
        }
        seeds.extend(cells.iter().zip(sides).filter_map(|(cell, side)| Some(((*cell)?, label(side)))));
    }
    CellLabels { of: made.flood(seeds, CellLabels::OUT) }
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
