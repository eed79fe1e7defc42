//! The third level, manifold: facets are matched by their vertices.
//!
//! **Statement.** 1. A facet has one cell, or two on opposite sides. 2. The cells at a vertex are connected through
//! facets at that vertex. 3. For `d` = 3, the link of every vertex is a disc or a sphere.
//!
//! In a periodic box, vertices, facets and cells are classes of translated ones, and only 1 is checked: the theorem of [`super`]
//! needs no more. Facets are matched by their vertices up to a translation. If all axes are periodic, no facet has one cell.
//!
//! **Euler characteristic.** The characteristic of a link decides 3. In a link, every edge has one triangle or two,
//! and the triangles are connected through edges. Separate the link at pinched vertices. The result is a connected
//! surface with `b` boundary curves. Its characteristic is at most 2, with equality only for the sphere. For
//! `b >= 1`, the characteristic is at most 1, with equality only for the disc. Every pinch lowers the characteristic
//! of the link by one. So a link without boundary is a sphere if and only if its characteristic is 2. A link with
//! boundary is a disc if and only if its characteristic is 1. In the plane, links are graphs of degree at most two,
//! and a connected one is a path or a cycle.
//!
//! **Work.** Each facet is found at its smallest row. A star of s cells takes O(s log s), and vertices are processed
//! in parallel. **Memory.** `2 N` words of 32 bits per cell.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::fault::Fault;
use super::place::{Place, Steps, Vertex};
use super::report::Tally;
use super::runner::Runner;
use super::soup::{Corner, Soup};

/// The twin of a facet with one cell.
pub(super) const BOUNDARY: u32 = u32::MAX;
/// The twin of a facet with more than two cells, or with two on the same side. It is reported as a fault.
pub(super) const BROKEN: u32 = u32::MAX - 1;

/// The cells at each vertex, in ascending order.
struct Stars {
    offsets: Vec<usize>,
    cells: Vec<u32>,
}

impl Stars {
    fn new<S: Steps, const N: usize>(points: usize, cells: &[[Vertex<S>; N]]) -> Self {
        // Several images of a point may be vertices of one cell.
        let rows = |cell: &[Vertex<S>; N]| {
            let rows = cell.map(|v| v.row as usize);
            (0..N).filter(move |&i| !rows[..i].contains(&rows[i])).map(move |i| rows[i])
        };
        let mut offsets = vec![0; points + 1];
        for v in cells.iter().flat_map(rows) {
            offsets[v + 1] += 1;
        }
        for i in 0..points {
            offsets[i + 1] += offsets[i];
        }
        let mut next = offsets.clone();
        let mut at = vec![0; offsets[points]];
        for (cell, row) in cells.iter().enumerate() {
            for v in rows(row) {
                at[next[v]] = cell as u32;
                next[v] += 1;
            }
        }
        Self { offsets, cells: at }
    }

    fn of(&self, vertex: usize) -> &[u32] {
        &self.cells[self.offsets[vertex]..self.offsets[vertex + 1]]
    }
}

/// The facets of all cells. The facet opposite to the vertex in `slot` has the number `cell * N + slot`.
pub(super) struct Facets {
    /// The twin of each facet: the same facet in the other cell, [`BOUNDARY`] or [`BROKEN`].
    pub twin: Vec<u32>,
}

/// Returns `true` if the orientation that a positive cell induces on its facet opposite to `slot` is odd, relative to the
/// sorted vertices of the facet.
fn parity<S: Steps, const N: usize>(row: &[Vertex<S>; N], slot: usize) -> bool {
    let mut odd = slot % 2 == 1;
    for i in (0..N).filter(|&i| i != slot) {
        for j in (i + 1..N).filter(|&j| j != slot) {
            odd ^= row[i] > row[j];
        }
    }
    odd
}

/// The settled vertices of a facet, and its number.
type Keyed<P, const D: usize> = ([Corner<P, D>; D], u32);

/// Finds the facets whose smallest row is `vertex`. Returns their settled vertices and their numbers, sorted.
fn facets_at<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    star: &[u32],
    vertex: u32,
    found: &mut Vec<Keyed<P, D>>,
) {
    found.clear();
    for &cell in star {
        let row = &soup.cells[cell as usize];
        for slot in 0..N {
            let rows = (0..N).filter(|&i| i != slot).map(|i| row[i].row);
            if rows.min() == Some(vertex) {
                found.push((soup.settled(cell, slot).0, cell * N as u32 + slot as u32));
            }
        }
    }
    found.sort_unstable();
}

/// Matches the facets of a group with the same vertices.
fn match_group<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    group: &[Keyed<P, D>],
    twin: &[AtomicU32],
    tally: &mut Tally,
) {
    let at = |k: usize| {
        let facet = group[k].1;
        (facet / N as u32, facet as usize % N)
    };
    tally.checked += 1;
    let odd = |k: usize| parity(&soup.cells[at(k).0 as usize], at(k).1);
    let (cell, slot) = at(0);
    if group.len() == 1 {
        if soup.is_closed() {
            tally.fault(Fault::OpenFacet { facet: soup.facet(cell, slot), cell: cell as u64 });
        }
        return;
    }
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
    /// Matches all facets and checks the level `manifold`.
    pub fn new<P: Place<D>, const D: usize, const N: usize>(
        soup: &Soup<P, D, N>,
        runner: &mut Runner<'_>,
    ) -> (Self, Tally) {
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
        if P::IS_PERIODIC {
            return (facets, tally);
        }
        tally.append(runner.each("vertices", points, |range, tally| {
            let mut scratch = Scratch::default();
            for vertex in range.filter(|&v| soup.used[v]) {
                tally.checked += 1;
                facets.check_star(soup, stars.of(vertex), vertex as u32, &mut scratch, tally);
            }
        }));
        (facets, tally)
    }

    /// Returns the numbers of the boundary facets, in ascending order.
    pub fn boundary(&self) -> Vec<u32> {
        let all = self.twin.iter().enumerate();
        all.filter(|&(_, &twin)| twin == BOUNDARY).map(|(facet, _)| facet as u32).collect()
    }

    /// Returns the number of facets with two cells.
    pub fn interior(&self) -> u64 {
        self.twin.iter().filter(|&&twin| twin < BROKEN).count() as u64 / 2
    }

    /// Checks that a star is connected, and checks the Euler characteristic of its link. A broken facet in the star was
    /// reported before.
    fn check_star<P: Place<D>, const D: usize, const N: usize>(
        &self,
        soup: &Soup<P, D, N>,
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
            let row = soup.cells[cell as usize].map(|v| v.row);
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
            // A link of f triangles with b boundary edges has (3 f + b) / 2 edges.
            let edges = usize::midpoint(3 * star.len(), boundary);
            let euler = link.len() as i64 - edges as i64 + star.len() as i64;
            if euler != if boundary == 0 { 2 } else { 1 } {
                let (vertex, boundary) = (vertex as u64, boundary as u64);
                tally.fault(Fault::LinkNotADisc { vertex, euler, boundary });
            }
        }
    }
}

/// The buffers of the check of a star.
#[derive(Default)]
struct Scratch {
    /// Whether a cell was seen.
    seen: Vec<bool>,
    /// The cells to visit.
    stack: Vec<usize>,
    /// The vertices of the link.
    link: Vec<u32>,
}
