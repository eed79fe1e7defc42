//! The constrained triangulation of a domain in the plane, and its cells inside the domain.

use glam::DVec2;

use super::constrained::{Constrained, NONE};
use crate::domain::{Domain, Feature};
use crate::generate::{CellLabels, Delaunay, GenerationError, MeshMachine, Missing};
use crate::space::ascending;

/// The constrained triangulation of a domain.
pub(super) struct Start {
    pub(super) made: Constrained,
    /// The ends of all segments.
    pub(super) chains: Vec<[u32; 2]>,
    /// The cells on the left and on the right of each segment.
    pub(super) beside: Vec<[Option<u32>; 2]>,
    pub(super) labels: CellLabels,
}

impl Start {
    /// Triangulates the corners of a domain and inserts its segments.
    ///
    /// # Errors
    /// Returns the error of the machine, or the segments that cross others.
    pub(super) fn of<M: MeshMachine<DVec2>>(
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
