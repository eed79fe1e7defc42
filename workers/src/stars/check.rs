//! The check that all stars agree: conditions (H2) and (H4) of the certificate.
//!
//! **Statement** ([`crate::stars`] has the proof). The finite cells of all stars are the Delaunay triangulation if four conditions
//! hold:
//! - (H1) The exact kernel built every star from input points, and every star has a finite cell, or is hidden by its candidates.
//! - (H2) Every finite cell is in the stars of all its vertices.
//! - (H3) Exactly one vertex has no lexicographically smaller neighbour.
//! - (H4) All copies of a point have the same id and the same coordinates.
//!
//! [`crate::result::merge`] counts the stars with a finite cell and the vertices without a smaller neighbour.
//!
//! **Pairs.** All stars agree on a cell if and only if the star of its smallest vertex agrees with the star of each
//! other vertex. It therefore suffices to check the pairs (smallest vertex, other vertex). Every rank sums a 128-bit
//! hash of the cell over the pairs in its own stars. One sum covers the pairs in the stars of smallest vertices, the
//! other covers the pairs in the stars of the other vertices. The two sums over pairs of owned vertices must be
//! equal. For the pairs between two ranks, the sums of both ranks must also be equal.
//!
//! *Equal sums imply agreement, except for collisions.* In the difference of the two sums, the hash of each cell has a
//! coefficient `c`. If the star of the smallest vertex has the cell, it adds 1 for each other vertex that the sums cover. If the
//! star of such a vertex has the cell, it subtracts 1. No star counts a cell twice, so `|c|` is at most the dimension. All `c`
//! are zero if and only if the stars agree. If some `c` is not zero, the sums are equal with probability about `2^-127`,
//! provided that the hash behaves like a random function. QED.
//!
//! The hash covers ids and coordinate bits, so the sums also detect different copies of a point (H4).
//!
//! **Cost.** The sums follow every change of a star, so a certificate costs one message for each pair of ranks. Only if sums
//! differ does a rank look up cells, or send a list of keys. Keys have 64 bits: they locate disagreements and certify nothing.
//!
//! **Rounds.** One, or two if lists are needed.
//!
//! **Work and depth.** A vector step sums all link facets. Then the facets are sorted by the keys of their cells, as messages
//! are by their receivers: the copies of a cell are next to each other, and a cell with too few copies is a disagreement. For
//! `m` facets, this is a delivery: O(m log m) work and O(log m) depth. The certificate charges the delivery again for the
//! stars that splaying has changed. The program looks cells up only if sums differ ([`crate::stars::look_up`]). Because this
//! depends on the ranks that own the stars, the delivery is always charged.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Fingerprint, Message};
use septet_protocol::transport::TransportError;

use crate::config::Fault;
use crate::machine::context::Context;
use crate::stars::fingerprint_sums::{KeySet, PairSum, Sums, VertexSums};
use crate::stars::owned::{Change, Stars, StarsView};
use crate::state::cells::finite_cell;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number, owned_groups};

/// A cell of an owned star that the star of another vertex lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Disagreement {
    /// The owned vertex whose star has the cell.
    pub(crate) holder: u32,
    /// The position of the cell's facet among the facets of all links. Valid until the star changes.
    pub(crate) facet: u32,
    /// The vertex whose star lacks the cell.
    pub(crate) other: u32,
}

/// The outcome of a check.
#[derive(Clone, Debug, Default)]
pub(crate) struct Agreement {
    disagreements: Vec<Disagreement>,
    /// Number of ranks whose sums differ from the sums of this rank, plus 1 if the sums within this rank differ.
    differing: u64,
}

/// A pair with a ghost, identified by a key that both ranks can compute.
#[derive(Clone, Copy)]
struct SharedPair {
    key: u64,
    /// The disagreement if the other rank does not list the key.
    disagreement: Disagreement,
}

/// The pairs shared with the ranks whose sums differ.
type SharedPairs = BTreeMap<Rank, Vec<SharedPair>>;

/// Sums all stars, then compares the sums.
pub(crate) async fn check<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
) -> Result<Agreement, TransportError> {
    cx.enter(Phase::Check)?;
    let vertex_sums =
        if stars.sum_subdomain(table) { None } else { Some(sum_all(cx, subdomain.leaves(), table, stars)) };
    compare(cx, subdomain.leaves(), table, stars, vertex_sums).await
}

/// Compares the sums after splaying.
pub(crate) async fn certificate<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
) -> Result<Agreement, TransportError> {
    cx.enter(Phase::Certificate)?;
    if cx.config().fault == Some(Fault::SpoilStar { rank: cx.rank() }) {
        spoil_star(table, stars);
    }
    charge_changed(cx, subdomain.leaves(), stars);
    compare(cx, subdomain.leaves(), table, stars, None).await
}

/// Sums all stars. Returns the sums of each owned vertex.
fn sum_all<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    stars: &mut Stars<P>,
) -> VertexSums {
    stars.extend_hashes(table);
    let groups = owned_groups(leaves);
    let vertex_sums = VertexSums::new(table.owned_len(), cx.pool().is_none());
    let view = StarsView::new(table, stars);
    let scans = cx.map(&groups, |(_, vertices)| {
        let (mut sums, mut pairs) = (Sums::default(), Sweep::default());
        for vertex in vertices.clone() {
            let link = view.link(vertex);
            view.add_facets(vertex, pairs.visit_all(link), &mut sums, Some(&vertex_sums));
        }
        (sums, pairs)
    });
    let mut sweeps: BTreeMap<NodeId, Sweep> = BTreeMap::new();
    let mut all = Sums::default();
    for ((at, _), (sums, pairs)) in groups.into_iter().zip(scans) {
        sweeps.entry(leaves[at].id()).or_default().join(&pairs);
        all.add(sums);
    }
    for (leaf, sweep) in sweeps {
        let mut cost = cx.own_cost();
        let items = sweep.items();
        cost.charge_sweep(sweep);
        cost.charge_delivery(sweep);
        cx.charge(Account::member(Phase::Check, leaf), cost, items);
    }
    stars.set_sums(all);
    vertex_sums
}

/// Charges each leaf for the look-ups of the cells of the stars that splaying has changed.
fn charge_changed<P: Point>(cx: &mut Context<P>, leaves: &[Leaf<P>], stars: &Stars<P>) {
    let mut sweeps: BTreeMap<u32, Sweep> = BTreeMap::new();
    for vertex in stars.changed() {
        sweeps.entry(leaf_number(leaves, vertex)).or_default().visit_all(stars.link(vertex));
    }
    for (leaf, sweep) in sweeps {
        let mut cost = cx.own_cost();
        cost.charge_delivery(sweep);
        cx.charge(Account::member(Phase::Certificate, leaves[leaf as usize].id()), cost, sweep.items());
    }
}

/// Removes a cell from the first owned star that has one: a planted fault.
fn spoil_star<P: Point>(table: &mut Table<P>, stars: &mut Stars<P>) {
    stars.extract_links(table);
    let finite_facet = |vertex: u32| {
        let at = stars.link(vertex).iter().position(|facet| finite_cell::<P>(vertex, facet).is_some())?;
        Some((vertex, at))
    };
    let Some((vertex, at)) = table.owned().find_map(finite_facet) else { return };
    let mut link = stars.link(vertex).to_vec();
    let lost = link.remove(at);
    stars.replace(table, vertex, &Change { link: &link, gained: &[], lost: &[lost], cover: None });
}

/// Compares the sums within this rank and with other ranks. `vertex_sums` are the sums of each owned vertex, if known.
async fn compare<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    vertex_sums: Option<VertexSums>,
) -> Result<Agreement, TransportError> {
    let mut agreement = compare_within(cx, leaves, StarsView::new(table, stars), vertex_sums);
    stars.drop_zero_sums();
    send_sums(cx, stars.sums());
    let (mut shared, mut lists) = (None, BTreeMap::new());
    while cx.exchange().await? {
        let theirs = take_sums(cx);
        lists.extend(take_lists(cx));
        if shared.is_none() {
            let own = stars.sums().remote();
            let ranks: BTreeSet<Rank> = theirs.keys().chain(own.keys()).copied().collect();
            let differing: Vec<Rank> = ranks.into_iter().filter(|r| theirs.get(r) != own.get(r)).collect();
            agreement.differing += differing.len() as u64;
            if !differing.is_empty() {
                stars.extract_links(table);
            }
            shared = Some(send_lists(cx, StarsView::new(table, stars), &differing));
        }
    }
    agreement.add_unlisted(&shared.unwrap_or_default(), lists);
    Ok(agreement)
}

/// Compares the stars of this rank with each other.
fn compare_within<P: Point>(
    cx: &Context<P>,
    leaves: &[Leaf<P>],
    view: StarsView<'_, P>,
    vertex_sums: Option<VertexSums>,
) -> Agreement {
    if view.stars().sums().agree_within() {
        return Agreement::default();
    }
    Agreement { disagreements: view.locate(cx.pool(), leaves, vertex_sums), differing: 1 }
}

fn send_sums<P: Point>(cx: &mut Context<P>, sums: &Sums) {
    let body = |sum: &PairSum| Body::Fingerprint(Fingerprint { sum: sum.hashes(), pairs: sum.pairs() });
    cx.send_each(0, sums.remote().iter().map(|(&rank, sum)| (rank, body(sum))));
}

fn take_sums<P: Point>(cx: &mut Context<P>) -> BTreeMap<Rank, PairSum> {
    let sums = cx.take(|m: &mut Message<P>| match &m.body {
        Body::Fingerprint(Fingerprint { sum, pairs }) => Some((m.from, PairSum::new(*sum, *pairs))),
        _ => None,
    });
    sums.into_iter().collect()
}

fn take_lists<P: Point>(cx: &mut Context<P>) -> Vec<(Rank, Vec<u64>)> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::FingerprintList(words) => Some((m.from, std::mem::take(&mut words.0))),
        _ => None,
    })
}

/// Sends each rank whose sums differ the keys of the pairs shared with it. Returns these pairs.
fn send_lists<P: Point>(cx: &mut Context<P>, view: StarsView<'_, P>, ranks: &[Rank]) -> SharedPairs {
    let mut shared: SharedPairs = ranks.iter().map(|&rank| (rank, Vec::new())).collect();
    if ranks.is_empty() {
        return shared;
    }
    view.each_shared(|rank, pair| {
        if let Some(list) = shared.get_mut(&rank) {
            list.push(pair);
        }
    });
    let body =
        |list: &Vec<_>| Body::FingerprintList(Bulk(list.iter().map(|pair: &SharedPair| pair.key).collect()));
    cx.send_each(0, shared.iter().map(|(&rank, list)| (rank, body(list))));
    shared
}

impl Agreement {
    /// Returns the cells of owned stars that other stars lack, in the order of the stars.
    pub(crate) fn disagreements(&self) -> &[Disagreement] {
        &self.disagreements
    }

    /// Returns the number of disagreements. If all lists agree, which implies a collision of keys, returns the number of
    /// sums that differ.
    pub(crate) fn count(&self) -> u64 {
        if self.disagreements.is_empty() { self.differing } else { self.disagreements.len() as u64 }
    }

    /// Adds the shared pairs that the other rank does not list.
    fn add_unlisted(&mut self, shared: &SharedPairs, lists: BTreeMap<Rank, Vec<u64>>) {
        for (rank, keys) in lists {
            let theirs: KeySet = keys.into_iter().collect();
            let pairs = shared.get(&rank).into_iter().flatten();
            let unlisted = pairs.filter(|pair| !theirs.contains(&pair.key));
            self.disagreements.extend(unlisted.map(|pair| pair.disagreement));
        }
        self.disagreements.sort_unstable();
        self.disagreements.dedup();
    }
}

impl<P: Point> StarsView<'_, P> {
    /// Calls `f` with every pair in owned stars that has a ghost, and with the rank that owns the ghost.
    fn each_shared(&self, mut f: impl FnMut(Rank, SharedPair)) {
        let (table, stars) = (self.table(), self.stars());
        for holder in table.owned() {
            // Most links have owned vertices only. This loop has no branches.
            let (link, mut has_others) = (stars.link(holder), false);
            for &v in bytemuck::cast_slice::<_, u32>(link) {
                has_others |= v >= table.owned_len();
            }
            if !has_others {
                continue;
            }
            for (facet, link) in (stars.start(holder)..).zip(link) {
                if link.as_ref().iter().all(|&v| v != INFINITE && table.is_owned(v)) {
                    continue;
                }
                let Some(cell) = finite_cell::<P>(holder, link) else { continue };
                let smallest = self.smallest(&cell);
                let hash = stars.hashes().cell_hash(cell.as_ref());
                let mut share = |ghost: u32, other: u32| {
                    let key = stars.hashes().list_key(hash, other);
                    let disagreement = Disagreement { holder, facet, other: ghost };
                    f(table.owners()[ghost as usize], SharedPair { key, disagreement });
                };
                if smallest == holder {
                    for &other in link.as_ref().iter().filter(|&&v| !table.is_owned(v)) {
                        share(other, other);
                    }
                } else if !table.is_owned(smallest) {
                    share(smallest, holder);
                }
            }
        }
    }
}

#[cfg(test)]
impl Agreement {
    /// Returns the number of sums that differ.
    pub(crate) fn differing(&self) -> u64 {
        self.differing
    }
}
