//! Whether a periodic triangulation is a simplicial complex, and how many boxes make it one.
//!
//! **Statement.** It is one iff no site is joined to its own image, and no two sites are joined twice: then the vertices of a
//! simplex determine it. In a grid of `s_a` boxes along each axis, two edges from one site to images `k` and `k'` of another
//! one lead to the same vertex iff `k - k'` is a multiple of `s`; an edge to an own image `k` is a loop iff `k` is. Components
//! of edges are at most one length, so differences are at most 2, and three boxes suffice.
//!
//! **Work.** A pass over the edges, and a sort of those between different boxes.

use std::collections::{BTreeMap, BTreeSet};

use super::lattice::{Lattice, Steps};
use super::quotient::Vertex;

/// The differences of images that must not be multiples of the numbers of boxes.
#[derive(Debug, Default)]
pub(super) struct Clashes(BTreeSet<Steps>);

/// An edge from a site to an image of a site that is not smaller.
type Edge = ((u32, u32), Steps);

fn difference(a: Steps, b: Steps) -> Steps {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Calls `f` with the edges of all cells. `own` returns the offset of the base site of a row.
fn each_edge(vertices: &[Vertex], corners: usize, own: &dyn Fn(u32) -> Steps, f: &mut dyn FnMut(Edge)) {
    for cell in vertices.chunks_exact(corners) {
        for (i, a) in cell.iter().enumerate() {
            for b in &cell[..i] {
                let at = |v: &Vertex| difference(v.offset, own(v.row));
                let (from, to) = if a.row <= b.row { (a, b) } else { (b, a) };
                f(((from.row, to.row), difference(at(to), at(from))));
            }
        }
    }
}

impl Clashes {
    /// Finds the clashes of cells of `corners` vertices.
    pub(super) fn of(vertices: &[Vertex], corners: usize, own: &dyn Fn(u32) -> Steps) -> Self {
        let mut clashes = Clashes::default();
        // Of two edges between the same sites, at least one leads to another box.
        let mut between: BTreeMap<(u32, u32), BTreeSet<Steps>> = BTreeMap::new();
        each_edge(vertices, corners, own, &mut |((a, b), steps)| {
            if a == b {
                clashes.0.insert(steps);
            } else if steps != [0; 3] {
                between.entry((a, b)).or_default().insert(steps);
            }
        });
        each_edge(vertices, corners, own, &mut |(sites, steps)| {
            if steps == [0; 3]
                && let Some(of_sites) = between.get_mut(&sites)
            {
                of_sites.insert(steps);
            }
        });
        for of_sites in between.into_values() {
            let all: Vec<Steps> = of_sites.into_iter().collect();
            for (i, a) in all.iter().enumerate() {
                clashes.0.extend(all[..i].iter().map(|b| difference(*a, *b)));
            }
        }
        clashes
    }

    /// Returns `true` if there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the smallest numbers of boxes, along `dimension` axes, of which no clash is a multiple.
    pub(super) fn sheets(&self, lattice: &Lattice, dimension: usize) -> Vec<u32> {
        let most: [i32; 3] =
            std::array::from_fn(|axis| if lattice.axes().any(|a| a == axis) { 3 } else { 1 });
        let mut all: Vec<[i32; 3]> = Vec::new();
        for i in 1..=most[0] {
            for j in 1..=most[1] {
                all.extend((1..=most[2]).map(|k| [i, j, k]));
            }
        }
        all.sort_by_key(|sheets| (sheets.iter().product::<i32>(), *sheets));
        let is_multiple =
            |clash: &Steps, sheets: &[i32; 3]| (0..3).all(|axis| clash[axis] % sheets[axis] == 0);
        let found = all.into_iter().find(|sheets| !self.0.iter().any(|clash| is_multiple(clash, sheets)));
        found.unwrap_or(most)[..dimension].iter().map(|&sheets| sheets as u32).collect()
    }
}
