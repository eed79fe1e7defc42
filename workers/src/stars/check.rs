//! Do the stars agree? The certificate's second clause.
//!
//! **Statement** (the proof is in ARCHITECTURE.md). The cells are the Delaunay triangulation under three conditions. The
//! exact kernel built every star from points of the input, and every star holds a finite cell. Every finite cell is in
//! the stars of all its vertices. Exactly one vertex has no lexicographically smaller neighbour.
//!
//! A cell is in the stars of all its vertices iff the star of its smallest vertex and that of each other vertex hold
//! it; so agreement is needed of each (smallest, other) pair only. Every rank sums a 128-bit hash of the cell over such
//! pairs of its own stars, once for the pairs seen from the smallest vertex and once from the other. The two sums of
//! pairs that are both at home must be equal, and so must the sums that two ranks hold of the pairs between them.
//!
//! The difference of two sums has the hash of each cell `c` times. If the star of the smallest vertex holds the cell,
//! `c` begins with the number of its other vertices at that place, else with 0; it loses one for each of those whose
//! star holds the cell, which none does twice. All `c` are zero iff the stars agree, and none is beyond the dimension.
//! So equal sums and counts mean agreement but for a collision: probability about 2^-127 for each of the sums, if the
//! hash mixes like a random one. The hash is over ids and coordinate bits, so it shows a corrupted copy as well.
//!
//! The sums follow every change of a star, so a certificate costs one message a pair of ranks. Only where sums differ,
//! a rank looks cells up, or sends lists with a key for each pair. Keys have 64 bits: they show where to look, and
//! certify nothing.
//!
//! **Rounds.** One, or two where lists are needed.
//!
//! **Work and depth.** One vector step over all link facets.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Fingerprint, Message};
use septet_protocol::transport::TransportError;

use crate::config::{Fault, map_in};
use crate::machine::context::Context;
use crate::stars::fingerprint_sums::{KeySet, ShortSums, Sums, unite};
use crate::stars::owned::{Chart, Stars};
use crate::state::cells::finite_cell;
use crate::state::subdomain::{Leaf, Subdomain, leaf_number, owned_groups};
use crate::state::table::Table;

/// A cell of a home star that another star lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Disagreement {
    /// The home vertex.
    pub(crate) owned: u32,
    /// The position of the cell's facet in the arena, which holds until the star is replaced.
    pub(crate) facet: u32,
    /// The local number of the vertex whose star lacks the cell.
    pub(crate) other: u32,
}

/// The outcome of a check.
#[derive(Clone, Debug, Default)]
pub(crate) struct Agreement {
    /// What this rank's stars hold and others lack, in the order of the stars.
    pub(crate) disagreements: Vec<Disagreement>,
    /// Number of ranks whose sums differ from those here, and one more if the sums within this rank differ.
    pub(crate) differing: u64,
}

/// What this rank's stars share with others whose sums differ: keys, and the disagreements they would be.
type SharedPairs = BTreeMap<Rank, Vec<(u64, Disagreement)>>;

/// Sums all stars, then compares the sums.
pub(crate) async fn check<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
) -> Result<Agreement, TransportError> {
    cx.enter(Phase::Check)?;
    let short =
        if stars.sum_subdomain(table) { None } else { Some(sum_all(cx, &subdomain.leaves, table, stars)) };
    compare(cx, &subdomain.leaves, table, stars, short).await
}

/// Compares the sums after an exchange, which have followed every change of a star.
pub(crate) async fn certificate<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
) -> Result<Agreement, TransportError> {
    cx.enter(Phase::Certificate)?;
    if cx.config.fault == Some(Fault::SpoilStar { rank: cx.rank }) {
        spoil_star(table, stars);
    }
    compare(cx, &subdomain.leaves, table, stars, None).await
}

/// Sums all stars; returns the sums of each home vertex.
fn sum_all<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    stars: &mut Stars<P>,
) -> ShortSums {
    stars.extend_hashes(table);
    let groups = owned_groups(leaves);
    let short = ShortSums::new(table.owned, cx.pool.is_none());
    let chart = Chart { table, stars };
    let scans = map_in(&cx.pool, &groups, |(_, owned_points)| {
        let (mut sums, mut pairs) = (Sums::default(), Sweep::default());
        for owned in owned_points.clone() {
            let link = chart.stars.link(owned);
            pairs.visit_lanes(link.len());
            chart.sum_star(owned, link, true, &mut sums, Some(&short));
        }
        (sums, pairs)
    });
    let mut sweeps: BTreeMap<NodeId, Sweep> = BTreeMap::new();
    let mut all = Sums::default();
    for ((at, _), (sums, pairs)) in groups.into_iter().zip(scans) {
        sweeps.entry(leaves[at].id).or_default().join(&pairs);
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
        cx.charge(Account::member(Phase::Check, leaf), cost, items);
    }
    stars.sums = all;
    short
}

/// The planted fault: the first home star with a cell loses one.
fn spoil_star<P: Point>(table: &mut Table<P>, stars: &mut Stars<P>) {
    stars.write_out(table);
    let cell_of = |owned: u32| {
        let link = stars.link(owned);
        let at = link.iter().position(|facet| finite_cell::<P>(owned, facet).is_some())?;
        Some((owned, at, link.to_vec()))
    };
    let Some((owned, at, link)) = (0..table.owned).find_map(cell_of) else { return };
    let mut spoilt = link.clone();
    spoilt.remove(at);
    stars.recount(table, owned, &link, &spoilt);
    stars.replace(owned, &spoilt);
}

/// Compares the sums as they are; `short` are those of each home vertex, if they are known.
async fn compare<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    short: Option<ShortSums>,
) -> Result<Agreement, TransportError> {
    record(cx, leaves, Chart { table, stars });
    let mut agreement = within(cx, leaves, Chart { table, stars }, short);
    stars.sums.remote.retain(|_, sum| *sum != (0, 0));
    for (&rank, &(sum, count)) in &stars.sums.remote {
        let fingerprint = Fingerprint { sum, pairs: count };
        cx.send(rank, NodeId::ROOT, 0, Body::Fingerprint(fingerprint));
    }
    let (mut shared, mut lists) = (None, BTreeMap::new());
    while cx.exchange().await? {
        let theirs = take_sums(cx);
        lists.extend(take_lists(cx));
        if shared.is_none() {
            let ranks: BTreeSet<Rank> = theirs.keys().chain(stars.sums.remote.keys()).copied().collect();
            let differ = |r: &Rank| theirs.get(r) != stars.sums.remote.get(r);
            let differing: Vec<Rank> = ranks.into_iter().filter(differ).collect();
            agreement.differing += differing.len() as u64;
            if !differing.is_empty() {
                stars.write_out(table);
            }
            shared = Some(send_lists(cx, Chart { table, stars }, &differing));
        }
    }
    agreement.explain(&shared.unwrap_or_default(), lists);
    Ok(agreement)
}

/// Whether the stars of this rank agree with each other, and where not.
fn within<P: Point>(
    cx: &Context<P>,
    leaves: &[Leaf<P>],
    chart: Chart<'_, P>,
    short: Option<ShortSums>,
) -> Agreement {
    if chart.stars.sums.from_smallest == chart.stars.sums.from_other {
        return Agreement::default();
    }
    Agreement { disagreements: chart.locate(&cx.pool, leaves, short), differing: 1 }
}

/// Records what the stars of every two leaves must agree on, if that is asked for.
fn record<P: Point>(cx: &mut Context<P>, leaves: &[Leaf<P>], chart: Chart<'_, P>) {
    let Some(recorder) = &mut cx.recorder else { return };
    let mut sums: BTreeMap<(u32, u32), (u128, u64)> = BTreeMap::new();
    for (at, leaf) in (0u32..).zip(leaves) {
        for owned in leaf.owned() {
            chart.each_pair(owned, |key, other| {
                let to = leaf_number(leaves, other);
                if to != at {
                    Sums::count(sums.entry((at, to)).or_default(), key);
                }
            });
        }
    }
    recorder.checked(sums);
}

/// Takes the sums of other ranks.
fn take_sums<P: Point>(cx: &mut Context<P>) -> BTreeMap<Rank, (u128, u64)> {
    let sums = cx.take(|m: &mut Message<P>| match &m.body {
        Body::Fingerprint(Fingerprint { sum, pairs }) => Some((m.from, (*sum, *pairs))),
        _ => None,
    });
    sums.into_iter().collect()
}

/// Takes the keys that other ranks list.
fn take_lists<P: Point>(cx: &mut Context<P>) -> Vec<(Rank, Vec<u64>)> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::FingerprintList(words) => Some((m.from, std::mem::take(&mut words.0))),
        _ => None,
    })
}

/// Lists what is shared with some ranks, and sends each the keys.
fn send_lists<P: Point>(cx: &mut Context<P>, chart: Chart<'_, P>, ranks: &[Rank]) -> SharedPairs {
    let mut shared: SharedPairs = ranks.iter().map(|&rank| (rank, Vec::new())).collect();
    if ranks.is_empty() {
        return shared;
    }
    chart.each_shared(|rank, key, disagreement| {
        if let Some(list) = shared.get_mut(&rank) {
            list.push((key, disagreement));
        }
    });
    for (&rank, list) in &shared {
        let keys = list.iter().map(|pair| pair.0).collect();
        cx.send(rank, NodeId::ROOT, 0, Body::FingerprintList(Bulk(keys)));
    }
    shared
}

impl Agreement {
    /// How many disagreements there are. Sums that differ although all lists agree count, too: a collision in the lists.
    pub(crate) fn count(&self) -> u64 {
        if self.disagreements.is_empty() { self.differing } else { self.disagreements.len() as u64 }
    }

    /// Adds what is shared with other ranks and not in their lists.
    fn explain(&mut self, shared: &SharedPairs, lists: BTreeMap<Rank, Vec<u64>>) {
        for (rank, keys) in lists {
            let theirs: KeySet = keys.into_iter().collect();
            let pairs = shared.get(&rank).into_iter().flatten();
            self.disagreements.extend(pairs.filter(|pair| !theirs.contains(&pair.0)).map(|pair| pair.1));
        }
        self.disagreements.sort_unstable();
        self.disagreements.dedup();
    }
}

impl<P: Point> Chart<'_, P> {
    /// Calls `f` with every pair shared with another rank: rank, key, and the disagreement it would be.
    fn each_shared(&self, mut f: impl FnMut(Rank, u64, Disagreement)) {
        let Chart { table, stars } = self;
        for owned in 0..table.owned {
            // Most stars have home points alone.
            let (link, mut leaves) = (stars.link(owned), false);
            for &v in bytemuck::cast_slice::<_, u32>(link) {
                leaves |= v >= table.owned;
            }
            if !leaves {
                continue;
            }
            for (facet, link) in (stars.start(owned)..).zip(link) {
                if link.as_ref().iter().all(|&v| v != INFINITE && table.is_owned(v)) {
                    continue;
                }
                let Some(cell) = finite_cell::<P>(owned, link) else { continue };
                let smallest = self.smallest(&cell);
                let hash = stars.cell_hash(&cell);
                // The key of a pair on the wire: both hashes are mixed already, so their difference is spread as they are.
                let mut shared = |with: u32, other: u32| {
                    let key = (hash ^ stars.hashes[other as usize]) as u64;
                    f(table.owners[with as usize], key, Disagreement { owned, facet, other: with });
                };
                if smallest == owned {
                    for &other in link.as_ref().iter().filter(|&&v| !table.is_owned(v)) {
                        shared(other, other);
                    }
                } else if !table.is_owned(smallest) {
                    shared(smallest, owned);
                }
            }
        }
    }
}
