//! The fourth level: the boundary is closed and locally convex.
//!
//! **Statement.** A *ridge* is a vertex in the plane and an edge in space. Every ridge of a boundary facet lies in
//! exactly two boundary facets. The far vertex of one is not strictly beyond the plane of the other. Ridges of the
//! boundary correspond to the infinite|infinite ridges of the lifted hull ([`super`]). Coplanar facets are allowed, but
//! must not be folded onto each other.
//!
//! One direction of the test suffices. Either direction decides whether the angle between the facets, measured through
//! the cells, exceeds 180 degrees.
//!
//! **Work.** O(h log h) for h ridges, because they are sorted.

use std::cmp::Ordering;
use std::ops::Range;

use rayon::prelude::*;

use super::predicates::replaced;
use super::report::{Fault, Tally};
use super::runner::Runner;
use super::soup::Soup;

/// A ridge in a boundary facet: its vertices, the facet, and the far vertex of the facet.
type Ridge = ([u32; 2], u32, u32);

/// Returns the ridges of a boundary facet. In the plane, both vertices of a ridge are the same.
fn ridges<const D: usize, const N: usize>(soup: &Soup<D, N>, facet: u32) -> impl Iterator<Item = Ridge> {
    let row = soup.cells[(facet / N as u32) as usize];
    let slot = facet as usize % N;
    (0..N).filter(move |&far| far != slot).map(move |far| {
        let mut rest = (0..N).filter(|&i| i != slot && i != far).map(|i| row[i]);
        let a = rest.next().unwrap_or_default();
        let b = rest.next().unwrap_or(a);
        ([a.min(b), a.max(b)], facet, row[far])
    })
}

/// Checks the level `hull`.
pub(super) fn check<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    boundary: &[u32],
    runner: &mut Runner<'_>,
) -> Tally {
    let of = |block: Range<usize>| boundary[block].iter().flat_map(|&f| ridges(soup, f)).collect::<Vec<_>>();
    let mut sorted: Vec<Ridge> = runner.map(boundary.len(), of).concat();
    runner.on_threads(&mut || sorted.par_sort_unstable());
    let groups: Vec<&[Ridge]> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
    runner.each("hull", groups.len(), |range, tally| {
        for group in &groups[range] {
            tally.checked += 1;
            if let [one, other] = group {
                check_ridge(soup, one, other, tally);
            } else {
                let count = group.len() as u64;
                tally.fault(Fault::OpenRidge { ridge: named::<D>(one_of(group)), count });
            }
        }
    })
}

fn one_of(group: &[Ridge]) -> [u32; 2] {
    group.first().map_or([0, 0], |ridge| ridge.0)
}

/// Returns the vertices of a ridge as input indices.
fn named<const D: usize>(ridge: [u32; 2]) -> Vec<u64> {
    ridge[..D - 1].iter().map(|&v| v as u64).collect()
}

/// Checks a ridge with two boundary facets.
fn check_ridge<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    one: &Ridge,
    other: &Ridge,
    tally: &mut Tally,
) {
    let (cell, slot) = (one.1 / N as u32, one.1 as usize % N);
    let (next, inner) = (other.1 / N as u32, other.1 as usize % N);
    if soup.is_flat(cell) || soup.is_flat(next) {
        return;
    }
    let corners = soup.corners(cell);
    let side = |v: u32| replaced(&corners, slot, &soup.points[v as usize]);
    let (ridge, cells) = (named::<D>(one.0), [cell as u64, next as u64]);
    match side(other.2) {
        Ordering::Greater => {}
        Ordering::Less => tally.fault(Fault::Reflex { ridge, cells }),
        // Coplanar facets are folded unless their cells lie on the same side of the plane.
        Ordering::Equal => {
            if side(soup.cells[next as usize][inner]).is_lt() {
                tally.fault(Fault::Folded { ridge, cells });
            }
        }
    }
}
