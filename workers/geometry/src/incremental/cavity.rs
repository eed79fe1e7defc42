//! One insertion: the cells in conflict are dug out, and the point is joined to the border.
//!
//! **Work.** One comparison with a sphere for each cell of the cavity and each facet of its border; one
//! record written for each facet. The cavity's slots are filled first.

use super::Incremental;
use super::cells::Cell;
use super::read::corners;
use super::ridges::{Ridges, ridge};
use super::sphere::{KEPT, NO_SPHERE, Query, REMOVED};
use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex};
use crate::predicates::{conflicts_infinite, in_sphere};

/// What one insertion needs; kept from one to the next.
#[derive(Clone, Debug)]
pub(super) struct Scratch<P: Point> {
    /// The cells in conflict.
    cavity: Vec<u32>,
    /// The facets of the border: the code of the cell outside, then the vertices so that a point inside
    /// and they make a positive cell.
    border: Vec<P::Cell>,
    /// The cells that the exact predicates found free of conflict.
    kept: Vec<u32>,
    /// The vertices of the border, from 1 on.
    around: Vec<Around<P>>,
    ridges: Ridges,
}

/// A vertex of the border.
#[derive(Clone, Copy, Debug, Default)]
struct Around<P> {
    /// The vector from the new vertex, in the coordinates of the spheres; not a number for infinity.
    rel: P,
    length2: f64,
    vertex: u32,
    /// The first facet that it is in.
    facet: u32,
}

impl<P: Point> Default for Scratch<P> {
    fn default() -> Self {
        Scratch {
            cavity: Vec::new(),
            border: Vec::new(),
            kept: Vec::new(),
            around: Vec::new(),
            ridges: Ridges::default(),
        }
    }
}

/// In the incidence table, the mark of a vertex that has a number in the present border.
const NUMBERED: u32 = 1 << 31;

/// The facet of a positive cell opposite `slot`, so that it and the vertex there, first, are a positive
/// cell.
#[inline]
fn facet_slots(corners: usize, slot: usize) -> [usize; 3] {
    match (corners, slot) {
        (3, 0) => [1, 2, 0],
        (3, 1) => [2, 0, 0],
        (3, _) => [0, 1, 0],
        (_, 0) => [1, 2, 3],
        (_, 1) => [0, 3, 2],
        (_, 2) => [0, 1, 3],
        _ => [0, 2, 1],
    }
}

/// Does `q` conflict with a cell? Exact.
pub(super) fn conflicts<P: Point>(slots: &[Cell<P::Cell>], points: &[P], cell: u32, q: P) -> bool {
    let n = P::Cell::LEN;
    let vertices = &slots[cell as usize].vertices;
    let this = corners(points, vertices);
    match vertices.as_ref().iter().position(|&v| v == INFINITE) {
        None => in_sphere(&this[..n], q),
        Some(slot) => {
            let inner = slots[cell as usize].neighbours.as_ref()[slot] >> 2;
            let finite = corners(points, &slots[inner as usize].vertices);
            conflicts_infinite(&this[..n], slot, &finite[..n], q)
        }
    }
}

/// What the spheres left open. A cell found free of conflict is marked, so that it is asked once.
#[cold]
fn conflicts_once<P: Point>(
    slots: &mut [Cell<P::Cell>],
    points: &[P],
    kept: &mut Vec<u32>,
    cell: u32,
    q: P,
) -> bool {
    if slots[cell as usize].radius() & KEPT != 0 {
        return false;
    }
    let inside = conflicts(slots, points, cell, q);
    if !inside {
        *slots[cell as usize].radius_mut() |= KEPT;
        kept.push(cell);
    }
    inside
}

impl<P: Point> Incremental<P> {
    /// Adds the vertex `vertex`, which conflicts with the cell `seed`.
    pub(super) fn replace(&mut self, vertex: u32, query: &Query<P>, seed: u32) {
        let q = self.points[vertex as usize];
        self.dig(q, query, seed);
        self.allocate();
        self.number(q);
        self.fill(vertex, query);
    }

    /// Finds the cells in conflict with `q`, a connected set, and its border.
    fn dig(&mut self, q: P, query: &Query<P>, seed: u32) {
        let (slots, points) = (&mut self.cells.slots[..], &self.points[..]);
        let Scratch { cavity, border, kept, .. } = &mut self.scratch;
        cavity.clear();
        border.clear();
        cavity.push(seed);
        *slots[seed as usize].radius_mut() |= REMOVED;
        let mut head = 0;
        while head < cavity.len() {
            let Cell { neighbours, vertices, .. } = slots[cavity[head] as usize];
            head += 1;
            for slot in 0..P::Cell::LEN {
                let code = neighbours.as_ref()[slot];
                let next = &mut slots[(code >> 2) as usize];
                if next.is_removed() {
                    continue;
                }
                let power = query.power(next);
                let inside = if power.is_inside() {
                    true
                } else if power.is_outside() {
                    false
                } else {
                    conflicts_once(slots, points, kept, code >> 2, q)
                };
                if inside {
                    *slots[(code >> 2) as usize].radius_mut() |= REMOVED;
                    cavity.push(code >> 2);
                } else {
                    let mut facet = P::Cell::splat(code);
                    let from = facet_slots(P::Cell::LEN, slot);
                    for i in 0..P::DIM {
                        facet.as_mut()[i + 1] = vertices.as_ref()[from[i]];
                    }
                    border.push(facet);
                }
            }
        }
        for cell in kept.drain(..) {
            *slots[cell as usize].radius_mut() &= !KEPT;
        }
    }

    /// Numbers the new cells: slots of the cavity, free ones, new ones.
    fn allocate(&mut self) {
        let Scratch { cavity, border, .. } = &self.scratch;
        let cells = &mut self.cells;
        cells.created.clear();
        let reused = cavity.len().min(border.len());
        cells.created.extend_from_slice(&cavity[..reused]);
        cells.free.extend_from_slice(&cavity[reused..]);
        while cells.created.len() < border.len() {
            let Some(slot) = cells.free.pop() else { break };
            cells.created.push(slot);
        }
        let more = border.len() - cells.created.len();
        let slots = cells.slots.len();
        cells.created.extend((slots..slots + more).map(|slot| slot as u32));
        let empty = Cell {
            sphere: P::Cell::splat(NO_SPHERE),
            neighbours: P::Cell::splat(NONE),
            vertices: P::Cell::splat(INFINITE),
        };
        cells.slots.resize(slots + more, empty);
    }

    /// Numbers the vertices of the border, puts the numbers in their places and enters the ridges.
    fn number(&mut self, q: P) {
        let Scratch { border, around, ridges, .. } = &mut self.scratch;
        around.clear();
        around.push(Around::default());
        for (k, facet) in (0u32..).zip(border.iter_mut()) {
            let mut numbers = [0; 3];
            for i in 0..P::DIM {
                let vertex = facet.as_ref()[i + 1];
                let known = &mut self.incident[vertex.wrapping_add(1) as usize];
                if *known & NUMBERED == 0 {
                    *known = NUMBERED | around.len() as u32;
                    let to = self.points.get(vertex as usize).copied().unwrap_or(P::splat(f64::NAN));
                    let rel = self.frame.between(q, to);
                    around.push(Around { rel, length2: rel.norm2(), vertex, facet: k });
                }
                numbers[i] = *known & !NUMBERED;
                facet.as_mut()[i + 1] = numbers[i];
            }
            for i in 0..P::DIM {
                ridges.enter(ridge(numbers, i), k << 2 | (i as u32 + 1));
            }
        }
    }

    /// Writes the new cells.
    fn fill(&mut self, vertex: u32, query: &Query<P>) {
        if !Ridges::is_small(self.scratch.around.len()) {
            self.pair_large();
        }
        let Scratch { border, around, ridges, .. } = &self.scratch;
        let small = Ridges::is_small(around.len());
        let created = &self.cells.created[..];
        let slots = &mut self.cells.slots[..];
        for ((k, facet), &cell) in (0u32..).zip(border).zip(created) {
            let numbers = numbers_of::<P>(facet);
            let outer = facet.as_ref()[0];
            let mut neighbours = P::Cell::splat(outer);
            let mut vertices = P::Cell::splat(vertex);
            let mut rel = [P::default(); 3];
            let mut lengths2 = 1.0;
            for i in 0..P::DIM {
                let code = k << 2 | (i as u32 + 1);
                let mate = if small { ridges.mate(ridge(numbers, i)) } else { ridges.paired(code) };
                neighbours.as_mut()[i + 1] = created[(mate >> 2) as usize] << 2 | mate & 3;
                let end = &around[numbers[i] as usize];
                vertices.as_mut()[i + 1] = end.vertex;
                rel[i] = end.rel;
                lengths2 *= end.length2;
            }
            slots[(outer >> 2) as usize].neighbours.as_mut()[(outer & 3) as usize] = cell << 2;
            let sphere = query.sphere(&rel[..P::DIM], lengths2);
            slots[cell as usize] = Cell { sphere, neighbours, vertices };
        }
        for end in &around[1..] {
            self.incident[end.vertex.wrapping_add(1) as usize] = created[end.facet as usize];
        }
        self.incident[vertex as usize + 1] = created[0];
        self.last = created[0];
    }

    #[cold]
    fn pair_large(&mut self) {
        let Scratch { border, ridges, .. } = &mut self.scratch;
        let all = (0u32..).zip(border.iter()).flat_map(|(k, facet)| {
            let numbers = numbers_of::<P>(facet);
            (0..P::DIM).map(move |i| (ridge(numbers, i), k << 2 | (i as u32 + 1)))
        });
        ridges.pair(border.len() << 2, all);
    }
}

#[inline]
fn numbers_of<P: Point>(facet: &P::Cell) -> [u32; 3] {
    let mut numbers = [0; 3];
    numbers[..P::DIM].copy_from_slice(&facet.as_ref()[1..]);
    numbers
}
