//! The edges of a graph of nearest neighbours, from both ends.
//!
//! **Statement.** `i` and `j` are joined if one is among the nearest of the other. Each point knows its own nearest; so
//! every `i` tells all of these that it is joined to them, and every point unites what it knew and what it was told.
//! A list holds all points as near as its last one, so a point sees by the distance alone whether it knew.
//!
//! **Source.** Paper, Section 4.5.
//!
//! **Rounds.** One. **Work and depth.** One vector step over the lists to tell; a delivery to the leaves, a sort of the
//! edges that were not known, and one vector step over the points to unite.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, dist2};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::neighbours::done::Done;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Both ends of the edges of the home points.
pub(crate) struct Reverse {
    /// The nearest of each home point.
    nearest: Done,
    heard: Heard,
}

/// What the home points were told.
struct Heard {
    /// The position of each home point's leaf.
    leaf_of: Vec<u32>,
    /// Edges that the end told did not know: a home point, and who is joined to it.
    unknown: Vec<(u32, u32)>,
    /// Of each leaf, the edges that its points were told.
    told: Vec<Sweep>,
}

impl Heard {
    fn nothing<P>(subdomain: &Subdomain<P>) -> Self {
        let told = vec![Sweep::default(); subdomain.leaves.len()];
        Heard { leaf_of: subdomain.leaf_numbers(), unknown: Vec::new(), told }
    }

    /// A home point, with this squared radius, is told who is joined to it, so far from it.
    #[inline]
    fn hear(&mut self, edge: (u32, u32), distance2: f64, radius2: f64) {
        self.told[self.leaf_of[edge.0 as usize] as usize].visit();
        if distance2 > radius2 {
            self.unknown.push(edge);
        }
    }
}

/// Tells every point which points it is among the nearest of. Each rank gets a point once.
pub(crate) async fn reverse_edges<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    nearest: Done,
) -> Result<Reverse, TransportError> {
    let mut heard = Heard::nothing(subdomain);
    for (to, Telling { points, counts, targets, .. }) in tell(cx, subdomain, table, &nearest, &mut heard) {
        let body = Body::Reverse { points, counts: Bulk(counts), targets: Bulk(targets) };
        cx.send(to, NodeId::ROOT, 0, body);
    }
    while cx.exchange().await? {
        for Telling { points, counts, targets, .. } in take_tellings(cx) {
            // The sender's own points.
            let tellers = table.receive_all(&points).into_iter().zip(counts);
            let tellers = tellers.flat_map(|(number, count)| std::iter::repeat_n(number, count as usize));
            for (number, target) in tellers.zip(targets) {
                if let Some(home) = table.find_home(target) {
                    let [x, other] = [home, number].map(|i| table.positions[i as usize]);
                    heard.hear((home, number), dist2(x, other), table.radii2[home as usize]);
                }
            }
        }
    }
    Ok(Reverse { nearest, heard })
}

/// Tells the home points; returns what the points of other ranks are told, by rank.
fn tell<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    nearest: &Done,
    heard: &mut Heard,
) -> BTreeMap<Rank, Telling<P>> {
    let mut tellings: BTreeMap<Rank, Telling<P>> = BTreeMap::new();
    let mut other_leaves = Vec::new();
    let (nearest, homes) = (nearest.by_home(table.home), table.home as usize);
    // Of home points, both of the same length.
    let (positions, radii2) = (&table.positions[..homes], &table.radii2[..homes]);
    for (leaf, number) in subdomain.leaves.iter().zip(0u32..) {
        let mut edges = Sweep::default();
        for home in leaf.home() {
            let own = positions[home as usize];
            edges.each(nearest[home as usize], |&j| {
                if let Some(&x) = positions.get(j as usize) {
                    heard.hear((j, home), dist2(x, own), radii2[j as usize]);
                    if cx.recorder.is_some() {
                        other_leaves.push(heard.leaf_of[j as usize]);
                    }
                } else {
                    let telling = tellings.entry(table.owners[j as usize]).or_default();
                    telling.tell(table, home, table.ids[j as usize]);
                }
            });
            if let Some(recorder) = &mut cx.recorder {
                recorder.reverse(number, &mut other_leaves);
            }
        }
        let mut cost = Cost::ZERO;
        cost.swept(edges);
        cx.ledger.charge(Phase::Sets, leaf.id, cost, edges.items());
    }
    tellings
}

fn take_tellings<P: Point>(cx: &mut Context<P>) -> Vec<Telling<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Reverse { points, counts, targets } => Some(Telling {
            points: std::mem::take(points),
            counts: std::mem::take(&mut counts.0),
            targets: std::mem::take(&mut targets.0),
            last: None,
        }),
        _ => None,
    })
}

impl Reverse {
    /// The edges of every leaf's points from both ends, each once: those that a point did not know are sorted by the
    /// point.
    pub(crate) fn unite<P: Point>(
        self,
        cx: &mut Context<P>,
        subdomain: &Subdomain<P>,
        table: &Table<P>,
    ) -> Lists<u32> {
        let Reverse { nearest: done, heard } = self;
        let nearest = done.by_home(table.home);
        let items = nearest.iter().map(|list| list.len()).sum::<usize>() + heard.unknown.len();
        // Delivery to the leaves; within each the order is charged.
        let mut unknown = vec![Vec::new(); subdomain.leaves.len()];
        for edge in heard.unknown {
            unknown[heard.leaf_of[edge.0 as usize] as usize].push(edge);
        }
        let mut united = Lists::with_capacity(table.home as usize, items);
        for ((leaf, unknown), told) in subdomain.leaves.iter().zip(unknown).zip(heard.told) {
            let mut cost = Cost::ZERO;
            cost.delivered(told);
            let place = |edge: &(u32, u32)| (edge.0 - leaf.start) as usize;
            let own = cost.sorted_by_place(&unknown, place, leaf.home_len() as usize);
            let homes: Vec<u32> = leaf.home().collect();
            let mut rest = own.as_slice();
            cost.map_nested(&homes, |&home, inner| {
                let (segment, others) = rest.split_at(rest.iter().take_while(|edge| edge.0 == home).count());
                rest = others;
                let mut added = Sweep::default();
                added.visit_lanes(segment.len());
                inner.swept_inside(added);
                united.push_two(nearest[home as usize], segment.iter().map(|edge| edge.1));
            });
            cx.ledger.charge(Phase::Graph, leaf.id, cost, 0);
            cx.ledger.facts(leaf.id).members += leaf.home_len();
        }
        united
    }
}

/// What one rank is told of other ends of edges.
#[derive(Default)]
struct Telling<P: Point> {
    points: PointBatch<P>,
    counts: Vec<u32>,
    targets: Vec<u64>,
    last: Option<u32>,
}

impl<P: Point> Telling<P> {
    /// Tells a point there of a home point. Those of one home point come together.
    fn tell(&mut self, table: &Table<P>, home: u32, target: u64) {
        if self.last != Some(home) {
            self.last = Some(home);
            table.export(home, &mut self.points);
            self.counts.push(0);
        }
        if let Some(count) = self.counts.last_mut() {
            *count += 1;
        }
        self.targets.push(target);
    }
}
