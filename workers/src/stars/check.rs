//! Do the stars agree? The certificate's second clause.
//!
//! **Statement** (the proof is in ARCHITECTURE.md). If every star was built by the exact kernel from points
//! of the input and holds a finite cell, if every finite cell stands in the stars of all its vertices, and if
//! exactly one vertex has no lexicographically smaller neighbour, then the cells are the Delaunay
//! triangulation.
//!
//! A cell stands in all its vertices' stars iff it stands in the star of its smallest vertex together with
//! each other vertex' star; so agreement is needed of each (smallest, other) pair only. Every worker sums a
//! 128-bit hash of the cell over such pairs of its own stars, once for the pairs seen from the smallest vertex
//! and once from the other: the two sums of pairs that are both at home must be equal, and so must the sums
//! that two workers hold of the pairs between them. The difference of two sums has the hash of each cell `c`
//! times: `c` is the number of the cell's other vertices at that place, if the star of the smallest holds it, else
//! 0, less the number of those whose stars hold it (none does twice). All `c` are zero iff the stars agree, and
//! none is beyond the dimension, so equal sums and counts mean agreement but for a collision: probability about
//! 2^-127 for each of the sums, if the hash mixes like a random one. The hash is over ids and coordinate bits, so
//! a corrupted copy shows as well. The sums follow every change of a star; a certificate costs one message a pair
//! of workers. Only where sums differ are cells looked up, or lists exchanged, of a key for each pair. (Keys are of 64 bits:
//! they tell where to look, and certify nothing.)
//!
//! **Rounds.** One, or two where lists are needed. **Work and depth.** One vector step over all link
//! facets.

use std::collections::BTreeMap;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message};

use crate::config::{Fault, map_in};
use crate::direct::piece::{Piece, smallest_of};
use crate::stars::sums::{
    Away, KeySet, RecentHashes, SHARES, ShortSums, Sums, join, mix, point_hash, share_of, unite,
};
use crate::worker::{Worker, finite_cell};

/// A cell of a home star that another star lacks: the home vertex, the position of its facet in the
/// arena, and the local number of the other vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Disagreement {
    pub(crate) home: u32,
    pub(crate) facet: u32,
    pub(crate) other: u32,
}

/// The state of checks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Agreement {
    sums: Sums,
    /// Hashes of the table's points, as far as they were needed, and their first coordinates.
    hashes: Vec<u128>,
    firsts: Vec<f64>,
    compared: bool,
    /// The pairs shared with those workers whose sums differ: here, and as those workers list them.
    shared: BTreeMap<Rank, Vec<(u64, Disagreement)>>,
    lists: BTreeMap<Rank, Vec<u64>>,
    /// What this worker's stars hold and others lack.
    pub(crate) disagreements: Vec<Disagreement>,
    /// Number of workers whose fingerprints differ, and whether the own sums do.
    pub(crate) differing: u64,
}

/// Home points of one leaf that are scanned together.
pub(crate) const GROUP: usize = 4096;

impl<P: Point> Worker<P> {
    /// Position of a leaf, and some of its home points.
    pub(crate) fn home_groups(&self) -> Vec<(usize, std::ops::Range<u32>)> {
        let mut groups = Vec::new();
        for (at, leaf) in self.subdomain.leaves.iter().enumerate() {
            for start in leaf.home().step_by(GROUP) {
                groups.push((at, start..leaf.end.min(start + GROUP as u32)));
            }
        }
        groups
    }

    /// Sums all stars, then compares.
    pub(crate) fn begin_check(&mut self) {
        if let Some(mut piece) = self.stars.take_piece() {
            self.agreement.sums = self.sum_piece(&mut piece);
            self.stars.set_piece(Some(piece));
            self.begin_certificate();
            return;
        }
        self.extend_hashes();
        let groups = self.home_groups();
        let short = ShortSums::new(self.table.home, self.pool.is_none());
        let scans = map_in(&self.pool, &groups, |(_, homes)| {
            let (mut sums, mut pairs) = (Sums::default(), Sweep::default());
            for home in homes.clone() {
                let link = self.stars.link(home);
                pairs.visit_lanes(link.len());
                self.sum_star(home, link, true, &mut sums, Some(&short));
            }
            (sums, pairs)
        });
        let mut sweeps: BTreeMap<NodeId, Sweep> = BTreeMap::new();
        let mut all = Sums::default();
        for ((at, _), (sums, pairs)) in groups.into_iter().zip(scans) {
            sweeps.entry(self.subdomain.leaves[at].id).or_default().join(&pairs);
            unite(&mut all.from_smallest, sums.from_smallest);
            unite(&mut all.from_other, sums.from_other);
            for (rank, sum) in sums.remote {
                unite(all.remote.entry(rank).or_default(), sum);
            }
        }
        for (leaf, sweep) in sweeps {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            self.ledger.charge(self.phase, leaf, cost, items);
        }
        self.agreement.sums = all;
        self.compare_sums(Some(short));
    }

    /// Compares the sums as they are.
    pub(crate) fn begin_certificate(&mut self) {
        self.compare_sums(None);
    }

    /// Compares the sums; `short` are those of each home vertex, if they are known.
    fn compare_sums(&mut self, short: Option<ShortSums>) {
        if self.phase == Phase::Certificate && self.config.fault == Some(Fault::SpoilStar { rank: self.rank })
        {
            self.spoil_star();
        }
        self.record_agreement();
        let differ = self.agreement.sums.from_smallest != self.agreement.sums.from_other;
        let found = if differ { self.look_up(short) } else { Vec::new() };
        let agreement = &mut self.agreement;
        (agreement.compared, agreement.differing) = (false, u64::from(differ));
        agreement.lists.clear();
        agreement.shared.clear();
        agreement.disagreements = found;
        self.agreement.sums.remote.retain(|_, sum| *sum != (0, 0));
        for (&rank, &(sum, count)) in &self.agreement.sums.remote {
            let words = vec![sum as u64, (sum >> 64) as u64, count];
            self.out.send(rank, NodeId::ROOT, 0, Body::Fingerprint(Bulk(words)));
        }
    }

    /// Follows the change of a home star: facets that are gone, and new ones.
    pub(crate) fn recount_star(&mut self, home: u32, gone: &[P::Facet], fresh: &[P::Facet]) {
        let mut sums = std::mem::take(&mut self.agreement.sums);
        self.sum_star(home, gone, false, &mut sums, None);
        self.sum_star(home, fresh, true, &mut sums, None);
        self.agreement.sums = sums;
    }

    /// The planted fault: the first home star with a cell loses one.
    fn spoil_star(&mut self) {
        self.write_out();
        let cell_of = |home: u32| {
            let link = self.stars.link(home);
            let at = link.iter().position(|facet| finite_cell::<P>(home, facet).is_some())?;
            Some((home, at, link.to_vec()))
        };
        let Some((home, at, link)) = (0..self.table.home).find_map(cell_of) else { return };
        let mut spoilt = link.clone();
        spoilt.remove(at);
        self.recount_star(home, &link, &spoilt);
        self.stars.replace(home, &spoilt);
    }

    /// The sums of a piece, which is surveyed: pairs both at home are in one triangulation and agree.
    fn sum_piece(&self, piece: &mut Piece<P>) -> Sums {
        let table = &self.table;
        let mut sums = Sums::default();
        let mut away = Away::new(true);
        // Few points stand in such cells, each in many that follow each other closely.
        let mut hashes = RecentHashes::of_points(table.positions.len());
        piece.survey(&table.positions, |cell, smallest| {
            let vertices = cell.as_ref();
            let mut sum = 0u128;
            for &v in vertices {
                let make = || point_hash(table.ids[v as usize], table.positions[v as usize]);
                sum = sum.wrapping_add(hashes.hash(v, make));
            }
            let whole = mix(sum);
            for &other in vertices {
                let far = match (table.is_home(smallest), table.is_home(other)) {
                    (true, false) => other,
                    (false, true) => smallest,
                    _ => continue,
                };
                away.count(&mut sums, table.owners[far as usize], whole);
            }
        });
        away.finish(&mut sums);
        sums
    }

    /// Writes the links of a piece out before stars are compared or changed.
    pub(crate) fn write_out(&mut self) {
        if self.stars.piece().is_some() {
            self.stars.write_out();
            self.table.with_radii();
            self.extend_hashes();
        }
    }

    /// Hashes of points that came since the last check.
    pub(crate) fn extend_hashes(&mut self) {
        let known = self.agreement.hashes.len();
        let new = self.table.ids[known..].iter().zip(&self.table.positions[known..]);
        self.agreement.hashes.extend(new.map(|(&id, &x)| point_hash(id, x)));
        self.agreement.firsts.extend(self.table.positions[known..].iter().map(|x| x.coord(0)));
    }

    /// The lexicographically smallest vertex of a cell of local numbers: by the first coordinates, unless two are equal.
    #[inline]
    pub(crate) fn smallest(&self, cell: &P::Cell) -> u32 {
        let (vertices, firsts) = (cell.as_ref(), self.agreement.firsts.as_slice());
        let (mut smallest, mut least, mut equal) = (vertices[0], firsts[vertices[0] as usize], false);
        for &v in &vertices[1..] {
            let x = firsts[v as usize];
            equal |= x == least;
            (smallest, least) = if x < least { (v, x) } else { (smallest, least) };
        }
        if equal { smallest_of(&self.table.positions, cell) } else { smallest }
    }

    /// The hash of a cell.
    pub(crate) fn cell_hash(&self, cell: &P::Cell) -> u128 {
        let hashes = &self.agreement.hashes;
        mix(cell.as_ref().iter().fold(0u128, |s, &v| s.wrapping_add(hashes[v as usize])))
    }

    /// The key of a pair, as it is recorded.
    fn key(&self, cell_hash: u128, other: u32) -> u128 {
        mix(cell_hash ^ self.agreement.hashes[other as usize])
    }

    /// Calls `f` with the pairs of a star: key, and the other vertex.
    pub(crate) fn each_pair(&self, home: u32, link: &[P::Facet], mut f: impl FnMut(u128, u32)) {
        for facet in link {
            let Some(cell) = finite_cell::<P>(home, facet) else { continue };
            let smallest = self.smallest(&cell);
            let hash = self.cell_hash(&cell);
            if smallest == home {
                facet.as_ref().iter().for_each(|&other| f(self.key(hash, other), other));
            } else {
                f(self.key(hash, home), smallest);
            }
        }
    }

    /// Adds the pairs of one star to the sums, or takes them away; adds them to those of each home vertex.
    pub(crate) fn sum_star(
        &self,
        home: u32,
        link: &[P::Facet],
        add: bool,
        sums: &mut Sums,
        short: Option<&ShortSums>,
    ) {
        let table = &self.table;
        let (mut from_smallest, mut from_other) = ((0u128, 0u64), (0u128, 0u64));
        let mut shares = [0u64; SHARES];
        let mut away = Away::new(add);
        let mut elsewhere = |other: u32, hash: u128| away.count(sums, table.owners[other as usize], hash);
        self.each_cell(home, link, |facet, smallest, hash| {
            if smallest == home {
                for &other in facet.as_ref() {
                    if table.is_home(other) {
                        Sums::count(&mut from_smallest, hash);
                        let share = &mut shares[share_of(hash)];
                        *share = share.wrapping_add(hash as u64);
                    } else {
                        elsewhere(other, hash);
                    }
                }
            } else if table.is_home(smallest) {
                if let Some(short) = short {
                    short.subtract(smallest, hash);
                }
                Sums::count(&mut from_other, hash);
            } else {
                elsewhere(smallest, hash);
            }
        });
        away.finish(sums);
        join(&mut sums.from_smallest, from_smallest, add);
        join(&mut sums.from_other, from_other, add);
        if let Some(short) = short {
            short.add(home, shares);
        }
    }

    /// Calls `f` with the cells of a star: facet, smallest vertex, hash ([`Self::smallest`] and [`Self::cell_hash`] in one
    /// look at each vertex).
    #[inline]
    fn each_cell(&self, home: u32, link: &[P::Facet], mut f: impl FnMut(&P::Facet, u32, u128)) {
        let hashes = self.agreement.hashes.as_slice();
        let firsts = &self.agreement.firsts[..hashes.len()];
        let (own, first) = (hashes[home as usize], firsts[home as usize]);
        'facets: for facet in link {
            let (mut sum, mut smallest, mut least, mut equal) = (own, home, first, false);
            for &v in facet.as_ref() {
                let Some(&hash) = hashes.get(v as usize) else {
                    assert_eq!(v, INFINITE, "a vertex stands in the table");
                    continue 'facets;
                };
                let x = firsts[v as usize];
                sum = sum.wrapping_add(hash);
                equal |= x == least;
                (smallest, least) = if x < least { (v, x) } else { (smallest, least) };
            }
            if equal && let Some(cell) = finite_cell::<P>(home, facet) {
                smallest = smallest_of(&self.table.positions, &cell);
            }
            f(facet, smallest, mix(sum));
        }
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
                theirs.keys().chain(self.agreement.sums.remote.keys()).copied().collect();
            let differ = |r: &Rank| theirs.get(r) != self.agreement.sums.remote.get(r);
            let differing: Vec<Rank> = ranks.into_iter().filter(differ).collect();
            self.agreement.differing += differing.len() as u64;
            if !differing.is_empty() {
                self.write_out();
            }
            self.send_lists(&differing);
        }
        for (from, words) in lists {
            self.agreement.lists.insert(from, words);
        }
    }

    /// Calls `f` with every pair shared with another worker: rank, key, and the disagreement it would be.
    fn each_shared(&self, mut f: impl FnMut(Rank, u64, Disagreement)) {
        let homes = self.table.home;
        for home in 0..homes {
            // Most stars stand among home points alone.
            let (link, mut leaves) = (self.stars.link(home), false);
            for &v in bytemuck::cast_slice::<_, u32>(link) {
                leaves |= v >= homes;
            }
            if !leaves {
                continue;
            }
            for (facet, link) in (self.stars.start(home)..).zip(link) {
                if link.as_ref().iter().all(|&v| v != INFINITE && self.table.is_home(v)) {
                    continue;
                }
                let Some(cell) = finite_cell::<P>(home, link) else { continue };
                let smallest = self.smallest(&cell);
                let hash = self.cell_hash(&cell);
                // The key of a pair on the wire: both hashes are mixed already, so their difference is spread as they are.
                let mut shared = |with: u32, other: u32| {
                    let key = (hash ^ self.agreement.hashes[other as usize]) as u64;
                    f(self.table.owners[with as usize], key, Disagreement { home, facet, other: with });
                };
                if smallest == home {
                    for &other in link.as_ref().iter().filter(|&&v| !self.table.is_home(v)) {
                        shared(other, other);
                    }
                } else if !self.table.is_home(smallest) {
                    shared(smallest, home);
                }
            }
        }
    }

    /// Lists what is shared with some workers, and sends each the keys.
    fn send_lists(&mut self, ranks: &[Rank]) {
        if ranks.is_empty() {
            return;
        }
        let mut shared: BTreeMap<Rank, Vec<(u64, Disagreement)>> =
            ranks.iter().map(|&rank| (rank, Vec::new())).collect();
        self.each_shared(|rank, key, disagreement| {
            if let Some(list) = shared.get_mut(&rank) {
                list.push((key, disagreement));
            }
        });
        for (&rank, list) in &shared {
            let keys = list.iter().map(|pair| pair.0).collect();
            self.out.send(rank, NodeId::ROOT, 0, Body::FingerprintList(Bulk(keys)));
        }
        self.agreement.shared = shared;
    }

    /// Ends a check: what this worker holds and others lack, in the order of the stars.
    pub(crate) fn finish_check(&mut self) -> Vec<Disagreement> {
        let lists = std::mem::take(&mut self.agreement.lists);
        let shared = std::mem::take(&mut self.agreement.shared);
        let mut found = std::mem::take(&mut self.agreement.disagreements);
        for (rank, keys) in lists {
            let theirs: KeySet = keys.into_iter().collect();
            let pairs = shared.get(&rank).into_iter().flatten();
            found.extend(pairs.filter(|pair| !theirs.contains(&pair.0)).map(|pair| pair.1));
        }
        found.sort_unstable();
        found.dedup();
        self.agreement.disagreements.clone_from(&found);
        found
    }
}
