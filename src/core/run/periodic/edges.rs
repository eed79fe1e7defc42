//! Whether a periodic triangulation is a simplicial complex, and how many boxes make it one.
//!
//! **Statement.** It is one iff no site is joined to its own image, and no two sites are joined twice: then the vertices of a
//! simplex determine it. In a grid of `s_a` boxes along each axis, two edges from one site to images `k` and `k'` of another
//! one lead to the same vertex iff `k - k'` is a multiple of `s`. An edge to an own image `k` is also one to `-k`, and a loop
//! iff `k` is a multiple. Components of edges are at most one length, so differences are at most 2, and three boxes suffice.
//!
//! **Work.** A pass over the edges, and a sort of those between different boxes.

use std::collections::BTreeSet;

use septet_workers::config::cores::map_blocks;

use super::lattice::Lattice;
use crate::result::periodic::{Steps, Vertex, difference};

/// Number of cells that one core handles in turn.
const BLOCK: usize = 1 << 14;

/// The differences of images that must not be multiples of the numbers of boxes.
#[derive(Debug, Default)]
pub(super) struct Clashes(BTreeSet<Steps>);

/// An edge from a site to an image of a site that is not smaller.
type Edge = ((u32, u32), Steps);

/// Calls `f` with the edges of some packed cells of `corners` vertices.
fn each_edge(packed: &[u64], corners: usize, mut f: impl FnMut(Edge)) {
    for cell in packed.chunks_exact(corners) {
        for (i, &a) in cell.iter().enumerate() {
            for &b in &cell[..i] {
                let (from, to) = (Vertex::unpack(a.min(b)), Vertex::unpack(a.max(b)));
                f(((from.row, to.row), difference(to.steps, from.steps)));
            }
        }
    }
}

/// The edges to other boxes, sorted, and their sites.
#[derive(Default)]
struct Crossing {
    edges: Vec<Edge>,
    /// Bit `row % 64` of word `row / 64` is set if the row has such an edge.
    rows: Vec<u64>,
}

impl Crossing {
    fn of(packed: &[u64], corners: usize) -> Self {
        let found = map_blocks(packed.len() / corners, BLOCK, |cells| {
            let mut edges = Vec::new();
            for cell in packed[cells.start * corners..cells.end * corners].chunks_exact(corners) {
                // The first vertex of a cell has the offset 0. Most cells have no other.
                let steps = |word: u64| word as u32;
                if cell.iter().any(|&word| steps(word) != steps(cell[0])) {
                    each_edge(cell, corners, |edge| edges.extend((edge.1 != [0; 3]).then_some(edge)));
                }
            }
            edges.sort_unstable();
            edges.dedup();
            edges
        });
        let mut crossing = Crossing { edges: found.concat(), rows: Vec::new() };
        crossing.edges.sort_unstable();
        crossing.edges.dedup();
        for row in crossing.edges.iter().flat_map(|((a, b), _)| [*a, *b]) {
            let word = row as usize / 64;
            crossing.rows.resize(crossing.rows.len().max(word + 1), 0);
            crossing.rows[word] |= 1 << (row % 64);
        }
        crossing
    }

    fn has(&self, row: u32) -> bool {
        self.rows.get(row as usize / 64).is_some_and(|word| word >> (row % 64) & 1 == 1)
    }

    /// Returns the edges within a box whose sites are also joined by an edge to another box.
    fn doubled(&self, packed: &[u64], corners: usize) -> Vec<Edge> {
        let found = map_blocks(packed.len() / corners, BLOCK, |cells| {
            let mut edges = Vec::new();
            for cell in packed[cells.start * corners..cells.end * corners].chunks_exact(corners) {
                if cell.iter().filter(|&&word| self.has((word >> 32) as u32)).count() > 1 {
                    each_edge(cell, corners, |edge| {
                        let ((a, b), steps) = edge;
                        edges.extend((steps == [0; 3] && self.has(a) && self.has(b)).then_some(edge));
                    });
                }
            }
            edges.sort_unstable();
            edges.dedup();
            edges.retain(|(sites, _)| {
                let at = self.edges.partition_point(|(other, _)| other < sites);
                self.edges.get(at).is_some_and(|(other, _)| other == sites)
            });
            edges
        });
        found.concat()
    }
}

impl Clashes {
    /// Finds the clashes of packed cells of `corners` vertices.
    pub(super) fn of(packed: &[u64], corners: usize) -> Self {
        let crossing = Crossing::of(packed, corners);
        let mut edges = crossing.doubled(packed, corners);
        edges.extend(crossing.edges);
        edges.sort_unstable();
        edges.dedup();
        let mut clashes = BTreeSet::new();
        for between in edges.chunk_by(|a, b| a.0 == b.0) {
            let (a, b) = between[0].0;
            let mut steps: Vec<Steps> = between.iter().map(|(_, steps)| *steps).collect();
            if a == b {
                // An edge from a site to its image is also one to the opposite image, and two ends must differ from the site.
                steps.extend(between.iter().map(|(_, steps)| difference([0; 3], *steps)));
                steps.push([0; 3]);
            }
            for (i, one) in steps.iter().enumerate() {
                clashes.extend(steps[..i].iter().map(|other| difference(*one, *other)));
            }
        }
        Clashes(clashes)
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
