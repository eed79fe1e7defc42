//! Facets matched by their vertices, and the third level: manifold.
//!
//! **Statement.** A facet has one cell or two, two lie on opposite sides of it; the cells at a vertex
//! are connected through facets at it; in space the link of every vertex is a disc or a sphere.
//!
//! **Why the Euler characteristic decides.** In a link every edge has one triangle or two, and its
//! triangles are connected through edges. Take the link apart at pinched vertices: a connected
//! surface with `b` boundary curves, of characteristic at most 2 (equal only for the sphere), at most
//! 1 for `b >= 1` (equal only for the disc). Every pinch lowers the characteristic of the link by
//! one. So 2 without boundary is a sphere, 1 with boundary a disc, and nothing else is. In the plane
//! links are graphs of degree at most two: connected, they are paths or cycles.
//!
//! **Work.** Facets are found at their smallest vertex and vertices one by one: O(s log s) for a star
//! of s cells, in parallel over vertices. Memory: `2 N` words of 32 bits per cell.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::report::{Fault, Tally};
use super::runner::Runner;
use super::soup::Soup;

/// The facet has one cell.
pub(super) const BOUNDARY: u32 = u32::MAX;
/// The facet has too many cells, or two on the same side: a fault of its own.
pub(super) const BROKEN: u32 = u32::MAX - 1;

/// The cells at each vertex, ascending.
struct Stars {
    offsets: Vec<usize>,
    cells: Vec<u32>,
}

impl Stars {
    fn new<const N: usize>(points: usize, cells: &[[u32; N]]) -> Self {
        let mut offsets = vec![0; points + 1];
        for &v in cells.iter().flatten() {
            offsets[v as usize + 1] += 1;
        }
        for i in 0..points {
            offsets[i + 1] += offsets[i];
        }
        let mut next = offsets.clone();
        let mut at = vec![0; cells.len() * N];
        for (cell, row) in cells.iter().enumerate() {
            for &v in row {
                at[next[v as usize]] = cell as u32;
                next[v as usize] += 1;
            }
        }
        Self { offsets, cells: at }
    }

    fn of(&self, vertex: usize) -> &[u32] {
        &self.cells[self.offsets[vertex]..self.offsets[vertex + 1]]
    }
}

/// Facets are numbered `cell * N + slot`, the slot of the vertex opposite.
pub(super) struct Facets {
    /// For each facet its twin, [`BOUNDARY`] or [`BROKEN`].
    pub twin: Vec<u32>,
}

/// Is the orientation that the positive cell induces on its facet opposite to `slot`, relative to
/// the sorted vertices of the facet, odd?
fn parity<const N: usize>(row: &[u32; N], slot: usize) -> bool {
    let mut odd = slot % 2 == 1;
    for i in (0..N).filter(|&i| i != slot) {
        for j in (i + 1..N).filter(|&j| j != slot) {
            odd ^= row[i] > row[j];
        }
    }
    odd
}

/// The facets at `vertex` whose smallest vertex it is, as (the other vertices, number), sorted.
fn facets_at<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    star: &[u32],
    vertex: u32,
    found: &mut Vec<([u32; 2], u32)>,
) {
    found.clear();
    for &cell in star {
        let row = soup.cells[cell as usize];
        for slot in (0..N).filter(|&slot| row[slot] != vertex) {
            let mut key = [0, 0];
            let mut smallest = true;
            let others = (0..N).filter(|&i| i != slot && row[i] != vertex);
            for (k, i) in others.enumerate() {
                key[k] = row[i];
                smallest &= row[i] > vertex;
            }
            if smallest {
                if N == 4 {
                    key.sort_unstable();
                }
                found.push((key, cell * N as u32 + slot as u32));
            }
        }
    }
    found.sort_unstable();
}

/// Matches the facets of one group of equal vertices.
fn match_group<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    group: &[([u32; 2], u32)],
    twin: &[AtomicU32],
    tally: &mut Tally,
) {
    let at = |k: usize| {
        let facet = group[k].1;
        (facet / N as u32, facet as usize % N)
    };
    tally.checked += 1;
    let odd = |k: usize| parity(&soup.cells[at(k).0 as usize], at(k).1);
    if group.len() == 1 {
        return;
    }
    let (cell, slot) = at(0);
    if group.len() == 2 {
        if odd(0) != odd(1) || soup.is_flat(cell) || soup.is_flat(at(1).0) {
            twin[group[0].1 as usize].store(group[1].1, Relaxed);
            twin[group[1].1 as usize].store(group[0].1, Relaxed);
            return;
        }
        let cells = [cell as u64, at(1).0 as u64];
        tally.fault(Fault::SameSide { facet: soup.facet(cell, slot), cells });
    } else {
        let cells = (0..group.len().min(4)).map(|k| at(k).0 as u64).collect();
        let count = group.len() as u64;
        tally.fault(Fault::FacetOvershared { facet: soup.facet(cell, slot), cells, count });
    }
    for &(_, facet) in group {
        twin[facet as usize].store(BROKEN, Relaxed);
    }
}

impl Facets {
    /// The level `manifold`.
    pub fn new<const D: usize, const N: usize>(soup: &Soup<D, N>, runner: &mut Runner<'_>) -> (Self, Tally) {
        let points = soup.points.len();
        let stars = Stars::new(points, &soup.cells);
        let twin: Vec<AtomicU32> = (0..soup.cells.len() * N).map(|_| AtomicU32::new(BOUNDARY)).collect();
        let mut tally = runner.each("facets", points, |range, tally| {
            let mut found = Vec::new();
            for vertex in range {
                facets_at(soup, stars.of(vertex), vertex as u32, &mut found);
                for group in found.chunk_by(|a, b| a.0 == b.0) {
                    match_group(soup, group, &twin, tally);
                }
            }
        });
        let facets = Self { twin: twin.into_iter().map(AtomicU32::into_inner).collect() };
        tally.append(runner.each("vertices", points, |range, tally| {
            let mut scratch = Scratch::default();
            for vertex in range.filter(|&v| soup.used[v]) {
                tally.checked += 1;
                facets.check_star(soup, stars.of(vertex), vertex as u32, &mut scratch, tally);
            }
        }));
        (facets, tally)
    }

    /// The numbers of the boundary facets, ascending.
    pub fn boundary(&self) -> Vec<u32> {
        let all = self.twin.iter().enumerate();
        all.filter(|&(_, &twin)| twin == BOUNDARY).map(|(facet, _)| facet as u32).collect()
    }

    /// The number of facets with two cells.
    pub fn interior(&self) -> u64 {
        self.twin.iter().filter(|&&twin| twin < BROKEN).count() as u64 / 2
    }

    /// Connectivity and characteristic of one link. Stars with a broken facet have their fault.
    fn check_star<const D: usize, const N: usize>(
        &self,
        soup: &Soup<D, N>,
        star: &[u32],
        vertex: u32,
        scratch: &mut Scratch,
        tally: &mut Tally,
    ) {
        let Scratch { seen, stack, link } = scratch;
        seen.clear();
        seen.resize(star.len(), false);
        stack.clear();
        link.clear();
        let mut boundary = 0;
        if !star.is_empty() {
            seen[0] = true;
            stack.push(0);
        }
        while let Some(here) = stack.pop() {
            let cell = star[here];
            let row = soup.cells[cell as usize];
            for slot in (0..N).filter(|&slot| row[slot] != vertex) {
                link.push(row[slot]);
                match self.twin[cell as usize * N + slot] {
                    BOUNDARY => boundary += 1,
                    BROKEN => return,
                    twin => {
                        let there = star.binary_search(&(twin / N as u32));
                        if let Some(there) = there.ok().filter(|&there| !seen[there]) {
                            seen[there] = true;
                            stack.push(there);
                        }
                    }
                }
            }
        }
        if let Some(other) = seen.iter().position(|seen| !seen) {
            let cells = [star[0] as u64, star[other] as u64];
            return tally.fault(Fault::PinchedVertex { vertex: vertex as u64, cells });
        }
        if N == 4 {
            link.sort_unstable();
            link.dedup();
            // Triangles f, edges (3 f + b) / 2.
            let edges = usize::midpoint(3 * star.len(), boundary);
            let euler = link.len() as i64 - edges as i64 + star.len() as i64;
            if euler != if boundary == 0 { 2 } else { 1 } {
                let (vertex, boundary) = (vertex as u64, boundary as u64);
                tally.fault(Fault::LinkNotADisc { vertex, euler, boundary });
            }
        }
    }
}

/// Buffers of the star check: which cells were seen, which are to be visited, the link's vertices.
#[derive(Default)]
struct Scratch {
    seen: Vec<bool>,
    stack: Vec<usize>,
    link: Vec<u32>,
}
