//! The fourth level: the boundary is closed and locally convex.
//!
//! **Statement.** A *ridge* is a face of dimension `d - 2`: a vertex in the plane and an edge in space. Every ridge of a boundary facet lies in
//! exactly two boundary facets. The far vertex of one is not strictly beyond the plane of the other. Ridges of the
//! boundary correspond to the infinite|infinite ridges of the lifted hull ([`super`]). Coplanar facets are allowed, but
//! must not be folded onto each other.
//!
//! In a periodic box, ridges and facets are classes of translated ones. A facet in the plane may have a ridge twice.
//!
//! One direction of the test suffices. Either direction decides whether the angle between the facets, measured through
//! the cells, exceeds 180 degrees.
//!
//! **Work.** O(h log h) for h ridges, because they are sorted.

use std::cmp::Ordering;
use std::ops::Range;

use rayon::prelude::*;

use super::fault::Fault;
use super::place::{Place, Steps, Vertex};
use super::predicates::replaced;
use super::report::Tally;
use super::runner::Runner;
use super::soup::{Corner, Soup};

/// A ridge in a boundary facet.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Ridge<S, const D: usize> {
    /// Its settled vertices. The last one is repeated, because there are `D - 1`.
    vertices: [Vertex<S>; D],
    facet: u32,
    /// The far vertex of the facet, translated as the ridge was.
    far: Vertex<S>,
    /// The translation of the first vertex.
    by: S,
}

/// Returns the ridges of a boundary facet.
fn ridges<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    facet: u32,
) -> impl Iterator<Item = Ridge<P::Steps, D>> {
    let row = soup.cells[(facet / N as u32) as usize];
    let slot = facet as usize % N;
    (0..N).filter(move |&far| far != slot).map(move |far| {
        let mut vertices = [row[far]; D];
        let rest = (0..N).filter(|&i| i != slot && i != far).map(|i| row[i]);
        for (to, vertex) in vertices.iter_mut().zip(rest) {
            *to = vertex;
        }
        let by = Vertex::settle(&mut vertices[..D - 1]);
        vertices[D - 1] = vertices[D - 2];
        let far = Vertex { steps: row[far].steps.minus(by), ..row[far] };
        Ridge { vertices, facet, far, by }
    })
}

/// Checks the level `hull`.
pub(super) fn check<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    boundary: &[u32],
    runner: &mut Runner<'_>,
) -> Tally {
    let of = |block: Range<usize>| boundary[block].iter().flat_map(|&f| ridges(soup, f)).collect::<Vec<_>>();
    let mut sorted: Vec<Ridge<P::Steps, D>> = runner.map(boundary.len(), of).concat();
    runner.on_threads(&mut || sorted.par_sort_unstable());
    let groups: Vec<&[Ridge<P::Steps, D>]> = sorted.chunk_by(|a, b| a.vertices == b.vertices).collect();
    runner.each("hull", groups.len(), |range, tally| {
        for group in &groups[range] {
            tally.checked += 1;
            match group {
                [] => {}
                [one, other] => check_ridge(soup, one, other, tally),
                [first, ..] => {
                    tally.fault(Fault::OpenRidge { ridge: first.rows(), count: group.len() as u64 });
                }
            }
        }
    })
}

impl<S, const D: usize> Ridge<S, D> {
    /// Returns the vertices as input indices.
    fn rows(&self) -> Vec<u64> {
        self.vertices[..D - 1].iter().map(|v| v.row as u64).collect()
    }
}

/// Checks a ridge with two boundary facets.
fn check_ridge<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    one: &Ridge<P::Steps, D>,
    other: &Ridge<P::Steps, D>,
    tally: &mut Tally,
) {
    let (cell, slot) = (one.facet / N as u32, one.facet as usize % N);
    let (next, inner) = (other.facet / N as u32, other.facet as usize % N);
    if soup.is_flat(cell) || soup.is_flat(next) {
        return;
    }
    let corners = soup.corners_at(cell, P::Steps::ZERO.minus(one.by));
    let side = |v: Corner<P, D>| replaced(&corners, slot, &soup.place(v));
    let (ridge, cells) = (one.rows(), [cell as u64, next as u64]);
    match side(other.far) {
        Ordering::Greater => {}
        Ordering::Less => tally.fault(Fault::Reflex { ridge, cells }),
        // Coplanar facets are folded unless their cells lie on the same side of the plane.
        Ordering::Equal => {
            let inner = soup.cells[next as usize][inner].moved(P::Steps::ZERO.minus(other.by));
            if side(inner).is_lt() {
                tally.fault(Fault::Folded { ridge, cells });
            }
        }
    }
}
