//! The Delaunay triangulation by the simplest algorithm, which shares no code with the kernel. The exact predicates
//! alone test every cell against every point, and sorting finds the boundary of a cavity.

use crate::complex::INFINITE;
use crate::point::Point;
use crate::predicates::Sign;
use crate::predicates::orientation;
use crate::predicates::raises_dimension;
use std::collections::BTreeMap;

use super::*;

type Corners = Vec<u32>;

/// The finite cells in ascending order, with sorted vertices. Empty if the points span no cell.
pub(super) fn cells<P: Point>(points: &[P]) -> Vec<Corners> {
    let Some(first) = first_cell(points) else { return Vec::new() };
    let mut cells = vec![first.clone()];
    for slot in 0..=P::DIM {
        let mut outer = replaced(&first, slot, INFINITE);
        outer.swap((slot + 1) % (P::DIM + 1), (slot + 2) % (P::DIM + 1));
        cells.push(outer);
    }
    for q in (0..points.len() as u32).filter(|q| !first.contains(q)) {
        add(points, &mut cells, q);
    }
    cells.retain(|cell| !cell.contains(&INFINITE));
    for cell in &mut cells {
        cell.sort_unstable();
    }
    cells.sort_unstable();
    cells
}

fn replaced(cell: &[u32], slot: usize, by: u32) -> Corners {
    let mut cell = cell.to_vec();
    cell[slot] = by;
    cell
}

fn first_cell<P: Point>(points: &[P]) -> Option<Corners> {
    let mut cell: Corners = Vec::new();
    for q in 0..points.len() as u32 {
        let basis: Vec<P> = cell.iter().map(|&v| points[v as usize]).collect();
        if cell.len() <= P::DIM && raises_dimension(&basis, points[q as usize]) {
            cell.push(q);
        }
    }
    if cell.len() <= P::DIM {
        return None;
    }
    if orientation(&corners(points, &cell)) == Sign::Negative {
        cell.swap(0, 1);
    }
    Some(cell)
}

fn corners<P: Point>(points: &[P], cell: &[u32]) -> Vec<P> {
    cell.iter().map(|&v| points[v as usize]).collect()
}

fn add<P: Point>(points: &[P], cells: &mut Vec<Corners>, q: u32) {
    let inside: Vec<bool> = cells.iter().map(|cell| is_in_conflict(points, cells, cell, q)).collect();
    // A boundary facet belongs to exactly one removed cell.
    let mut boundary: BTreeMap<Corners, (usize, Corners)> = BTreeMap::new();
    for (cell, _) in cells.iter().zip(&inside).filter(|(_, inside)| **inside) {
        for slot in 0..=P::DIM {
            let mut facet = cell.clone();
            facet.remove(slot);
            facet.sort_unstable();
            let entry = boundary.entry(facet).or_insert((0, replaced(cell, slot, q)));
            entry.0 += 1;
        }
    }
    let mut at = 0;
    cells.retain(|_| {
        at += 1;
        !inside[at - 1]
    });
    cells.extend(boundary.into_values().filter(|(count, _)| *count == 1).map(|(_, cell)| cell));
}

fn is_in_conflict<P: Point>(points: &[P], cells: &[Corners], cell: &[u32], q: u32) -> bool {
    let Some(slot) = cell.iter().position(|&v| v == INFINITE) else {
        return in_sphere(&corners(points, cell), points[q as usize]);
    };
    match orientation(&corners(points, &replaced(cell, slot, q))) {
        Sign::Positive => true,
        Sign::Negative => false,
        Sign::Zero => {
            let shares = |other: &&Corners| {
                !other.contains(&INFINITE) && cell.iter().all(|&v| v == INFINITE || other.contains(&v))
            };
            let finite = cells.iter().find(shares).expect("every hull facet has a finite cell");
            in_sphere(&corners(points, finite), points[q as usize])
        }
    }
}
