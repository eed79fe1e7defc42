//! Selects the supergraph by a sample of stars if the user does not specify one.
//!
//! **Statement.** A hash of the coordinates draws about 64 points. Each sampled point searches for its nearest points, at most 60
//! (30 in the plane), in a ball. The radius of the ball is six times the distance to the nearest point of its leaf, but at
//! most the distance to the 20th (10th). So the points found include its nearest neighbour. The star of the sampled point is built from these points. `sampled` counts, for each alpha of 2.5, 3,
//! 4 and 6, the edges at the point and the vertices of its link that the supergraph lacks. `rule` chooses by the sums. The
//! selection is independent of the number of workers.
//!
//! The phase precedes the nearest-neighbour balls, because only some supergraphs need them for all points.
//!
//! **Work and depth.** All pairs of a sampled point and a point of its leaf, the descent (`crate::neighbours::descent`) and
//! all pairs of the points found for a star. Then the stars of the sample, in one vector step.
//!
//! **Rounds.** The rounds of the descent, one round for the reports to the coordinator, and those of its choice down the
//! tree of ranks.
//!
//! **Departure.** The paper assumes that alpha is known.

mod rule;
mod sampled;

use std::collections::BTreeMap;

use septet_geometry::cost::Lanes;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::Point;
use septet_geometry::separator::{DrawKey, Sampler};
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, ChosenSupergraph, SampleStars};
use septet_protocol::transport::TransportError;

use crate::config::{Family, Fault, Wanted};
use crate::machine::collectives::Reports;
use crate::machine::context::Context;
use crate::neighbours::descent::Descent;
use crate::neighbours::search::{Ball, Search};
use crate::share::Choice;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};
use rule::{ALPHAS, Request};
use sampled::{MOST_CANDIDATES, Sampled};

/// The expected number of sampled stars.
const SAMPLED_STARS: u64 = 64;

/// The number of points of the leaf that bound a sampled ball, in the plane, in space and in dimensions 4 to 6.
const BOUNDING: [usize; 5] = [10, 20, 40, 80, 160];

/// Chooses the supergraph. Each rank samples stars and reports how many of them each alpha certifies. The coordinator
/// sums the reports and sends the supergraph to every rank. `population` and `heaviest` are the number and the largest weight
/// of all points. Only the coordinator's result contains the reason.
pub(crate) async fn choice<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    (population, heaviest): (u64, f64),
) -> Result<Choice, TransportError> {
    cx.enter(Phase::Choice)?;
    let Wanted::Auto { family, purpose } = cx.config().graph.wanted else {
        return Ok(Choice { supergraph: cx.config().graph.wanted.fixed(population), why: None });
    };
    let worst = cx.config().fault == Some(Fault::WorstChoice);
    let repair = cx.config().graph.repair;
    let request = Request { family, purpose, repair, dimension: P::DIM, population, worst };
    let balls = balls_of_sample(cx, subdomain, table, population);
    let search = Search {
        phase: Phase::Choice,
        wanted: MOST_CANDIDATES[P::DIM - 2],
        probe: false,
        own_leaf: true,
        everywhere: false,
    };
    let mut descent = Descent::new(subdomain, search, &[]);
    descent.launch(cx, table, &balls, None);
    let leaves = subdomain.leaves();
    let of_sample = (family, heaviest);
    let mut samples = report_samples(cx, (leaves, table, of_sample), balls, &descent);
    let (mut chosen, mut why, mut counts) = (None, None, SampleCounts::default());
    while cx.exchange().await? {
        descent.receive(cx, table)?;
        samples = samples.and_then(|balls| report_samples(cx, (leaves, table, of_sample), balls, &descent));
        if cx.is_coordinator() {
            why = counts.receive(cx, request).or(why);
        }
        let received = cx.take(|m| match m.body {
            Body::Choice(ChosenSupergraph(rule)) => Some(rule),
            _ => None,
        });
        if let Some(rule) = received.iter().find(|&&rule| !request.admits(rule)) {
            let reason = format!("the coordinator cannot choose {rule:?}");
            return Err(TransportError::BadMessage { from: COORDINATOR, reason });
        }
        if let Some(&rule) = received.last() {
            cx.pass_on(|| Body::Choice(ChosenSupergraph(rule)));
            chosen = Some(rule);
        }
    }
    descent.finish(cx);
    if chosen.is_none() {
        let reason = "phase choice ended before every rank had reported its sampled stars".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    }
    Ok(Choice { supergraph: chosen, why })
}

/// The sums of the reports of all ranks, on the coordinator.
#[derive(Debug, Default)]
struct SampleCounts {
    reports: Reports,
    sum: SampleStars,
}

impl SampleCounts {
    /// Adds the reports of a round. When all ranks have reported, selects the supergraph, sends it to every rank and returns
    /// the reason.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, request: Request) -> Option<String> {
        let reports = cx.take(|m| match &mut m.body {
            Body::SampleStars(counts) => Some(*counts),
            _ => None,
        });
        for &counts in &reports {
            self.sum.add(counts);
        }
        if !self.reports.complete(reports.len(), cx.config().ranks()) {
            return None;
        }
        let (supergraph, why) = request.choose(&self.sum);
        cx.send_to_all(|| Body::Choice(ChosenSupergraph(supergraph)));
        Some(why)
    }
}

/// Samples owned points. The radius of a sampled ball is six times the distance to the nearest point of the leaf,
/// which is at least the distance to the nearest of all points, but at most the distance to the 20th point of the leaf (10th in
/// the plane), if there is one. It is infinite if the leaf contains no other point.
fn balls_of_sample<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    population: u64,
) -> Vec<Ball> {
    let key = DrawKey { seed: cx.config().seed, node: 0, attempt: 0 };
    let sampler = Sampler::new(key, population, SAMPLED_STARS);
    let positions = table.positions();
    let mut balls = Vec::new();
    for (at, leaf) in subdomain.leaves().iter().enumerate() {
        let members: Vec<u32> = leaf.owned().collect();
        let mut cost = cx.own_cost();
        let sample = cost.pack(&members, |&point| sampler.accepts(positions[point as usize]));
        let all = |_| f64::INFINITY;
        let nearest = nearest_direct(positions, &sample, &members, 1, all, &mut cost);
        let bounding = nearest_direct(positions, &sample, &members, BOUNDING[P::DIM - 2], all, &mut cost);
        let items = leaf.owned_len() * (sample.len() as u64).max(1);
        cx.charge(Account::member(Phase::Choice, leaf.id()), cost, items);
        let wide2 = ALPHAS[3] * ALPHAS[3];
        let radii2 = nearest
            .iter()
            .zip(bounding.iter())
            .map(|((nearest2, _), (most2, _))| most2.min(nearest2 * wide2));
        balls.extend(sample.into_iter().zip(radii2).map(|(point, radius2)| Ball {
            point,
            leaf: at,
            radius2,
        }));
    }
    balls
}

/// Sends the counts of the sample if the lists of all its balls are complete. Otherwise returns the balls.
fn report_samples<P: Point>(
    cx: &mut Context<P>,
    (leaves, table, of_sample): (&[Leaf<P>], &Table<P>, (Family, f64)),
    balls: Vec<Ball>,
    descent: &Descent<P>,
) -> Option<Vec<Ball>> {
    if descent.complete().len() < balls.len() {
        return Some(balls);
    }
    let mut charges: BTreeMap<u32, Lanes> = BTreeMap::new();
    let meter = cx.own_cost();
    let (mut sampled, mut sum) = (Sampled::new(table, of_sample), SampleStars::default());
    for nearest in descent.complete().iter() {
        let (point, mut cost) = (nearest.point, meter.nested());
        // Samples are in the order of their indices.
        let at = balls.binary_search_by_key(&point, |ball| ball.point);
        let radius2 = at.map_or(0.0, |at| balls[at].radius2);
        let of_alpha = sampled.counts(nearest, radius2, &mut cost);
        sum.add(SampleStars { sampled: 1, of_alpha });
        charges.entry(leaf_number(leaves, point)).or_insert_with(|| meter.lanes()).add(cost);
    }
    for (leaf, lanes) in charges {
        let mut cost = meter.fresh();
        cost.run_lanes(lanes);
        cx.charge(Account::member(Phase::Choice, leaves[leaf as usize].id()), cost, 0);
    }
    cx.send_to_coordinator(Body::SampleStars(sum));
    None
}
