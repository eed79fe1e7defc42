//! Do the stars agree? The certificate's second clause.
//!
//! **Statement** (the proof is in ARCHITECTURE.md). If every star was built by the exact kernel from points
//! of the input and holds a finite cell, if every finite cell stands in the stars of all its vertices, and if
//! exactly one vertex has no lexicographically smaller neighbour, then the cells are the Delaunay
//! triangulation.
//!
//! A cell stands in all its vertices' stars iff it stands in the star of its smallest vertex together with
//! each other vertex' star; so agreement is needed of each (smallest, other) pair only. Pairs at home on one
//! worker are looked up. For pairs across two workers each worker sums a 128-bit hash of (cell, other
//! vertex) over its own stars; equal sums and counts mean agreement but for a collision (probability below
//! 2^-100 for any number of cells that fits a machine, if the hash mixes as well as a random one; the
//! hash is over ids and coordinate bits, so a corrupted copy shows as well). Only pairs of workers that
//! differ exchange lists.
//!
//! **Rounds.** One, or two where lists are needed. **Work and depth.** One vector step over (cell, vertex)
//! pairs.

use std::collections::{BTreeMap, HashSet};
use std::sync::atomic::{AtomicU8, Ordering};

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, Message};

use crate::config::map_in;
use crate::worker::{Worker, finite_cell};

/// A cell of a home star that another star lacks: the home vertex, the position of its facet in the
/// arena, and the local number of the other vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Disagreement {
    pub(crate) home: u32,
    pub(crate) facet: u32,
    pub(crate) other: u32,
}

/// The state of a check.
#[derive(Clone, Debug, Default)]
pub(crate) struct Agreement {
    sums: BTreeMap<Rank, (u128, u64)>,
    compared: bool,
    lists: BTreeMap<Rank, Vec<u128>>,
    /// What this worker's stars hold and others lack.
    pub(crate) disagreements: Vec<Disagreement>,
    /// Number of workers whose fingerprints differ.
    pub(crate) differing: u64,
}

/// The hash of a point: id and coordinate bits.
fn point_hash<P: Point>(id: u64, x: P) -> u128 {
    let mut h = u128::from(id) | 1 << 64;
    for i in 0..P::DIM {
        h = mix(h ^ u128::from(x.coord(i).to_bits()) << (i * 29));
    }
    mix(h)
}

/// Mixes 128 bits (the multiplier is that of the 128-bit PCG family).
fn mix(h: u128) -> u128 {
    let h = (h ^ (h >> 67)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    let h = (h ^ (h >> 59)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    h ^ (h >> 64)
}

/// What one group of stars gives.
#[derive(Default)]
struct Scan {
    sums: BTreeMap<Rank, (u128, u64)>,
    disagreements: Vec<Disagreement>,
    pairs: Sweep,
}

impl<P: Point> Worker<P> {
    pub(crate) fn begin_check(&mut self) {
        let hashes = self.point_hashes();
        let seen: Vec<AtomicU8> = (0..self.stars.arena_len()).map(|_| AtomicU8::new(0)).collect();
        let scans = map_in(&self.pool, &self.leaves, |leaf| {
            let mut scan = Scan::default();
            for home in leaf.home() {
                self.scan_star(home, &hashes, &seen, &mut scan);
            }
            scan
        });
        let missing = map_in(&self.pool, &self.leaves, |leaf| {
            leaf.home().flat_map(|home| self.lacking(home, &seen)).collect::<Vec<_>>()
        });
        self.agreement = Agreement::default();
        let ids: Vec<NodeId> = self.leaves.iter().map(|l| l.id).collect();
        for (id, scan) in ids.into_iter().zip(scans) {
            let mut cost = Cost::ZERO;
            let items = scan.pairs.items();
            cost.swept(scan.pairs);
            self.ledger.charge(self.phase, id, cost, items);
            for (rank, (sum, count)) in scan.sums {
                let entry = self.agreement.sums.entry(rank).or_default();
                *entry = (entry.0.wrapping_add(sum), entry.1 + count);
            }
            self.agreement.disagreements.extend(scan.disagreements);
        }
        self.agreement.disagreements.extend(missing.into_iter().flatten());
        for (&rank, &(sum, count)) in &self.agreement.sums {
            let words = vec![sum as u64, (sum >> 64) as u64, count];
            self.out.send(rank, NodeId::ROOT, 0, Body::Fingerprint(Bulk(words)));
        }
    }

    fn point_hashes(&self) -> Vec<u128> {
        let points = self.table.ids.iter().zip(&self.table.positions);
        points.map(|(&id, &x)| point_hash(id, x)).collect()
    }

    /// The position, in a cell of local numbers, of its lexicographically smallest vertex.
    fn smallest(&self, cell: &P::Cell) -> u32 {
        let less = |a: u32, b: u32| {
            lex_cmp(&self.table.positions[a as usize], &self.table.positions[b as usize]).is_lt()
        };
        let vertices = cell.as_ref();
        vertices[1..].iter().fold(vertices[0], |m, &v| if less(v, m) { v } else { m })
    }

    /// The key of (cell, vertex other than the smallest).
    fn key(cell: &P::Cell, other: u32, hashes: &[u128]) -> u128 {
        let sum = cell.as_ref().iter().fold(0u128, |s, &v| s.wrapping_add(hashes[v as usize]));
        mix(mix(sum) ^ hashes[other as usize])
    }

    /// The pairs of one star: looked up at home, summed for other workers.
    fn scan_star(&self, home: u32, hashes: &[u128], seen: &[AtomicU8], scan: &mut Scan) {
        let start = self.stars.start(home);
        for (facet, link) in (start..).zip(self.stars.link(home)) {
            let Some(cell) = finite_cell::<P>(home, link) else { continue };
            let smallest = self.smallest(&cell);
            scan.pairs.each(link.as_ref(), |_| {});
            if smallest == home {
                for &other in link.as_ref() {
                    if !self.table.is_home(other) {
                        self.add(scan, other, Self::key(&cell, other, hashes));
                    }
                }
            } else if self.table.is_home(smallest) {
                match self.position_in(smallest, &cell) {
                    Some(at) => {
                        seen[at as usize].fetch_add(1, Ordering::Relaxed);
                    }
                    None => scan.disagreements.push(Disagreement { home, facet, other: smallest }),
                }
            } else {
                self.add(scan, smallest, Self::key(&cell, home, hashes));
            }
        }
    }

    fn add(&self, scan: &mut Scan, remote: u32, key: u128) {
        let entry = scan.sums.entry(self.table.owners[remote as usize]).or_default();
        *entry = (entry.0.wrapping_add(key), entry.1 + 1);
    }

    /// The position of a cell in the star of a home vertex of it.
    pub(crate) fn position_in(&self, home: u32, cell: &P::Cell) -> Option<u32> {
        let others = |v: &u32| cell.as_ref().contains(v);
        let at = self.stars.link(home).iter().position(|f| f.as_ref().iter().all(others))?;
        Some(self.stars.start(home) + at as u32)
    }

    /// Cells of a star that home vertices other than their smallest, this one, lack.
    fn lacking(&self, home: u32, seen: &[AtomicU8]) -> Vec<Disagreement> {
        let mut found = Vec::new();
        for (facet, link) in (self.stars.start(home)..).zip(self.stars.link(home)) {
            let Some(cell) = finite_cell::<P>(home, link) else { continue };
            let at_home = link.as_ref().iter().filter(|&&v| self.table.is_home(v)).count();
            if at_home == 0 || self.smallest(&cell) != home {
                continue;
            }
            if usize::from(seen[facet as usize].load(Ordering::Relaxed)) == at_home {
                continue;
            }
            for &other in link.as_ref() {
                if self.table.is_home(other) && self.position_in(other, &cell).is_none() {
                    found.push(Disagreement { home, facet, other });
                }
            }
        }
        found
    }

    pub(crate) fn on_check(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut theirs: BTreeMap<Rank, (u128, u64)> = BTreeMap::new();
        let mut lists = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Fingerprint(w) if w.len() == 3 => {
                theirs.insert(m.from, (u128::from(w[0]) | u128::from(w[1]) << 64, w[2]));
                false
            }
            Body::FingerprintList(w) => {
                lists.push((m.from, std::mem::take(&mut w.0)));
                false
            }
            _ => true,
        });
        if !self.agreement.compared {
            self.agreement.compared = true;
            let ranks: std::collections::BTreeSet<Rank> =
                theirs.keys().chain(self.agreement.sums.keys()).copied().collect();
            let differ = |r: &Rank| theirs.get(r) != self.agreement.sums.get(r);
            let differing: Vec<Rank> = ranks.into_iter().filter(differ).collect();
            self.agreement.differing = differing.len() as u64;
            self.send_lists(&differing);
        }
        for (from, words) in lists {
            self.compare_list(from, &words);
        }
    }

    /// Calls `f` with every pair shared with another worker: rank, key, and the disagreement it would be.
    fn each_shared(&self, mut f: impl FnMut(Rank, u128, Disagreement)) {
        let hashes = self.point_hashes();
        for home in 0..self.table.home {
            for (facet, link) in (self.stars.start(home)..).zip(self.stars.link(home)) {
                if link.as_ref().iter().all(|&v| v != INFINITE && self.table.is_home(v)) {
                    continue;
                }
                let Some(cell) = finite_cell::<P>(home, link) else { continue };
                let smallest = self.smallest(&cell);
                let mut shared = |other: u32, key: u128| {
                    let rank = self.table.owners[other as usize];
                    f(rank, key, Disagreement { home, facet, other });
                };
                if smallest == home {
                    for &other in link.as_ref().iter().filter(|&&v| !self.table.is_home(v)) {
                        shared(other, Self::key(&cell, other, &hashes));
                    }
                } else if !self.table.is_home(smallest) {
                    shared(smallest, Self::key(&cell, home, &hashes));
                }
            }
        }
    }

    fn send_lists(&mut self, ranks: &[Rank]) {
        if ranks.is_empty() {
            return;
        }
        let mut lists: BTreeMap<Rank, Vec<u64>> = ranks.iter().map(|&r| (r, Vec::new())).collect();
        self.each_shared(|rank, key, _| {
            if let Some(list) = lists.get_mut(&rank) {
                list.extend([key as u64, (key >> 64) as u64]);
            }
        });
        for (rank, words) in lists {
            self.out.send(rank, NodeId::ROOT, 0, Body::FingerprintList(Bulk(words)));
        }
    }

    fn compare_list(&mut self, from: Rank, words: &[u64]) {
        let list = words.chunks_exact(2).map(|w| u128::from(w[0]) | u128::from(w[1]) << 64).collect();
        self.agreement.lists.insert(from, list);
    }

    /// Ends a check: what this worker holds and others lack, in the order of the stars.
    pub(crate) fn finish_check(&mut self) -> Vec<Disagreement> {
        let lists: BTreeMap<Rank, HashSet<u128>> = std::mem::take(&mut self.agreement.lists)
            .into_iter()
            .map(|(rank, keys)| (rank, keys.into_iter().collect()))
            .collect();
        let mut found = std::mem::take(&mut self.agreement.disagreements);
        if !lists.is_empty() {
            self.each_shared(|rank, key, disagreement| {
                if lists.get(&rank).is_some_and(|keys| !keys.contains(&key)) {
                    found.push(disagreement);
                }
            });
        }
        found.sort_unstable();
        found.dedup();
        self.agreement.disagreements.clone_from(&found);
        found
    }
}
