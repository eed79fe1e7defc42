//! One insertion: the cells in conflict are dug out, and the point is joined to the border.
//!
//! **Work.** One comparison with a sphere for each cell of the cavity and each facet of its border; one
//! record written for each facet. The cavity's slots are filled first.

use super::Incremental;
use super::cells::Cell;
use super::read::corners;
use super::ridges::{Ridges, ridge};
use super::sphere::{Inverse, KEPT, NO_SPHERE, Query, REMOVED};
use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex};
use crate::predicates::{conflicts_infinite, in_sphere};

/// What one insertion needs; kept from one to the next.
#[derive(Clone, Debug)]
pub(super) struct Scratch<P: Point> {
    /// The cells in conflict.
    cavity: List<u32>,
    /// The facets of the border: the code of the cell outside, then the vertices so that a point inside
    /// and they make a positive cell.
    border: List<P::Cell>,
    /// The cells that the exact predicates found free of conflict.
    kept: Vec<u32>,
    /// The numbers of a facet's vertices in `around`; the third is 0 in the plane.
    numbers: Vec<[u32; 3]>,
    /// The vertices of the border, from 1 on.
    around: Vec<Inverse<P>>,
    /// Their names, and a new cell of each.
    names: Vec<(u32, u32)>,
    ridges: Ridges,
}

impl<P: Point> Default for Scratch<P> {
    fn default() -> Self {
        Scratch {
            cavity: List::new(0),
            border: List::new(P::Cell::splat(0)),
            kept: Vec::new(),
            numbers: Vec::new(),
            around: Vec::new(),
            names: Vec::new(),
            ridges: Ridges::default(),
        }
    }
}

/// A list whose items are written in any case, and stay or are written over. Storage is reused.
#[derive(Clone, Debug)]
struct List<T> {
    items: Vec<T>,
    len: usize,
}

impl<T: Copy> List<T> {
    /// An empty list; `item` fills its storage.
    fn new(item: T) -> Self {
        List { items: vec![item; 256], len: 0 }
    }

    fn begin(&mut self) {
        self.len = 0;
    }

    /// Room for so many more items.
    #[inline]
    fn make_room(&mut self, more: usize) {
        if self.items.len() < self.len + more {
            self.grow();
        }
    }

    #[cold]
    fn grow(&mut self) {
        let item = self.items[0];
        self.items.resize(2 * self.items.len(), item);
    }

    /// Writes an item, which stays if `stays` is 1 and not if it is 0. There is room.
    #[inline]
    fn put(&mut self, item: T, stays: u32) {
        self.items[self.len] = item;
        self.len += stays as usize;
    }

    #[inline]
    fn get(&self, at: usize) -> Option<&T> {
        self.items().get(at)
    }

    #[inline]
    fn items(&self) -> &[T] {
        &self.items[..self.len]
    }
}

/// In the incidence table, the mark of a vertex that has a number in the present border.
const NUMBERED: u32 = 1 << 31;

/// The facet of a positive cell opposite `slot` behind the code across it, so that a point inside and the
/// facet are a positive cell.
#[inline]
fn facet<P: Point>(vertices: &P::Cell, slot: usize, code: u32) -> P::Cell {
    let from = match (P::DIM, slot) {
        (2, 0) => [1, 2, 0],
        (2, 1) => [2, 0, 0],
        (2, _) => [0, 1, 0],
        (_, 0) => [1, 2, 3],
        (_, 1) => [0, 3, 2],
        (_, 2) => [0, 1, 3],
        _ => [0, 2, 1],
    };
    let mut facet = P::Cell::splat(code);
    for i in 0..P::DIM {
        facet.as_mut()[i + 1] = vertices.as_ref()[from[i]];
    }
    facet
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

    /// Finds the cells in conflict with `q`, a connected set, and its border. Which way a neighbour goes
    /// cannot be foreseen, so it is written to both lists, and the one that it belongs to grows.
    #[inline(never)]
    fn dig(&mut self, q: P, query: &Query<P>, seed: u32) {
        let (slots, points) = (&mut self.cells.slots[..], &self.points[..]);
        let Scratch { cavity, border, kept, .. } = &mut self.scratch;
        cavity.begin();
        border.begin();
        cavity.put(seed, 1);
        *slots[seed as usize].radius_mut() |= REMOVED;
        let mut head = 0;
        while let Some(&cell) = cavity.get(head) {
            head += 1;
            let Cell { neighbours, vertices, .. } = slots[cell as usize];
            cavity.make_room(P::Cell::LEN);
            border.make_room(P::Cell::LEN);
            let mut open = 0;
            for slot in 0..P::Cell::LEN {
                let code = neighbours.as_ref()[slot];
                let next = &mut slots[(code >> 2) as usize];
                let power = query.power(next);
                let live = next.radius() >> 31 ^ 1;
                let inside = live & u32::from(power.is_inside());
                let outside = live & u32::from(power.is_outside());
                *next.radius_mut() |= inside << 31;
                cavity.put(code >> 2, inside);
                border.put(facet::<P>(&vertices, slot, code), outside);
                open |= (live ^ inside ^ outside) << slot;
            }
            while open != 0 {
                let slot = open.trailing_zeros() as usize;
                open &= open - 1;
                let code = neighbours.as_ref()[slot];
                let inside = conflicts_once(slots, points, kept, code >> 2, q);
                *slots[(code >> 2) as usize].radius_mut() |= u32::from(inside) << 31;
                cavity.put(code >> 2, u32::from(inside));
                border.put(facet::<P>(&vertices, slot, code), u32::from(!inside));
            }
        }
        for cell in kept.drain(..) {
            *slots[cell as usize].radius_mut() &= !KEPT;
        }
    }

    /// Numbers the new cells: slots of the cavity, free ones, new ones.
    #[inline(never)]
    fn allocate(&mut self) {
        let Scratch { cavity, border, .. } = &self.scratch;
        let (cavity, border) = (cavity.items(), border.items());
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

    /// Numbers the vertices of the border and enters the ridges.
    #[inline(never)]
    fn number(&mut self, q: P) {
        let Scratch { border, numbers, around, names, ridges, .. } = &mut self.scratch;
        around.clear();
        around.push(Inverse::default());
        names.clear();
        numbers.clear();
        for (facet, &cell) in border.items().iter().zip(&self.cells.created) {
            let mut own = [0; 3];
            for i in 0..P::DIM {
                let vertex = facet.as_ref()[i + 1];
                let known = &mut self.incident[vertex.wrapping_add(1) as usize];
                if *known & NUMBERED == 0 {
                    *known = NUMBERED | around.len() as u32;
                    let to = self.points.get(vertex as usize).copied().unwrap_or(P::splat(f64::NAN));
                    around.push(self.frame.inverse(q, to));
                    names.push((vertex, cell));
                }
                own[i] = *known & !NUMBERED;
            }
            for i in 0..P::DIM {
                ridges.enter(ridge(own, i), cell << 2 | (i as u32 + 1));
            }
            numbers.push(own);
        }
    }

    /// Writes the new cells.
    #[inline(never)]
    fn fill(&mut self, vertex: u32, query: &Query<P>) {
        let small = Ridges::is_small(self.scratch.around.len());
        if !small {
            self.pair_large();
        }
        let Scratch { border, numbers, around, names, ridges, .. } = &self.scratch;
        let created = &self.cells.created[..];
        let slots = &mut self.cells.slots[..];
        for (k, ((facet, &own), &cell)) in border.items().iter().zip(numbers).zip(created).enumerate() {
            let outer = facet.as_ref()[0];
            let mut neighbours = P::Cell::splat(outer);
            for i in 0..P::DIM {
                let mate = if small { ridges.mate(ridge(own, i)) } else { ridges.paired(k, i) };
                neighbours.as_mut()[i + 1] = mate;
            }
            let mut vertices = *facet;
            vertices.as_mut()[0] = vertex;
            let sphere = query.sphere(own.map(|i| &around[i as usize]));
            slots[(outer >> 2) as usize].neighbours.as_mut()[(outer & 3) as usize] = cell << 2;
            slots[cell as usize] = Cell { sphere, neighbours, vertices };
        }
        for &(vertex, cell) in names {
            self.incident[vertex.wrapping_add(1) as usize] = cell;
        }
        self.incident[vertex as usize + 1] = created[0];
        self.last = created[0];
    }

    #[cold]
    fn pair_large(&mut self) {
        let Scratch { numbers, ridges, .. } = &mut self.scratch;
        let all = numbers
            .iter()
            .zip(0u32..)
            .flat_map(|(&own, k)| (0..P::DIM).map(move |i| (ridge(own, i), k << 2 | i as u32)));
        ridges.pair(&self.cells.created, all);
    }
}
