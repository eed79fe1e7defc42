//! Selects the supergraph by a sample of stars if the user does not specify one.
//!
//! **Statement.** A hash of the coordinates draws about a thousand points. Each sampled point searches the ball
//! around it whose radius is six times the distance to the nearest point of its leaf. The points found include its
//! nearest neighbour. The star of the sampled point is built from these points. Let `r` be the distance to the
//! nearest neighbour. The ball of radius `alpha r` certifies the star if and only if the star has no infinite facet
//! and twice its largest circumradius is at most `alpha r`. The coordinator takes the first `alpha` of 2.5, 3, 4 and
//! 6 for which at most 10 % of the sample are not certified. If there is no such `alpha`, it takes the graph of 48
//! nearest neighbours. The selection is independent of the number of workers.
//!
//! The phase precedes the nearest-neighbour balls, because only some supergraphs need them for all points.
//!
//! **Work and depth.** All pairs of a sampled point and a point of its leaf, and the descent
//! (`crate::neighbours::descent`). Then the stars of the sample, in one vector step.
//!
//! **Rounds.** The rounds of the descent, one round for the reports to the coordinator, and those of its choice down the
//! tree of ranks.
//!
//! **Departures.** The paper leaves `alpha` open. Measurements (`bench/README.md`) gave the limits of a tenth (not a
//! fifth) and of 48 neighbours (not 64). Near a fifth, the uncertified stars and the stars that they disturb cost more
//! than lists of neighbours. Splaying is cheap, so shorter lists are better.

use std::collections::BTreeMap;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Lanes};
use septet_geometry::graph::Supergraph;
use septet_geometry::hull::StarBuilder;
use septet_geometry::measure::circumradius2;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, dist2};
use septet_geometry::separator::{DrawKey, Sampler};
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, ChosenSupergraph, SampleStars};
use septet_protocol::transport::TransportError;

use crate::config::{FALLBACK_K, Wanted};
use crate::machine::collectives::Reports;
use crate::machine::context::Context;
use crate::neighbours::descent::Descent;
use crate::neighbours::results::{CompletedLists, Nearest};
use crate::neighbours::search::{Ball, Search};
use crate::share::Choice;
use crate::state::cells::finite_cell;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// The candidates for alpha, in the order of preference.
pub const ALPHAS: [f64; 4] = [2.5, 3.0, 4.0, 6.0];

/// The share of sampled stars that may remain without a local certificate.
pub const UNCERTIFIED_SHARE: f64 = 0.1;

/// The expected number of sampled stars.
const SAMPLED_STARS: u64 = 1000;

/// The largest number of points that a sampled star searches for.
const MOST_CANDIDATES: u32 = 500;

/// Selects the supergraph from the size of the sample and the number of stars that each alpha certifies. Returns it
/// with the reason.
pub fn choose(wanted: Wanted, sample: u64, certified: &[u64], population: u64) -> (Supergraph, String) {
    for (alpha, &good) in ALPHAS.into_iter().zip(certified) {
        let uncertified = sample - good.min(sample);
        if uncertified as f64 <= UNCERTIFIED_SHARE * sample as f64 {
            let supergraph = match wanted {
                Wanted::AutoOverlap => Supergraph::Overlap { alpha, k: 1 },
                _ => Supergraph::Density { alpha },
            };
            let why = format!("alpha {alpha} certifies {good} of {sample} sampled stars");
            return (supergraph, why);
        }
    }
    let best = certified.last().copied().unwrap_or(0);
    let k = FALLBACK_K.min(population.saturating_sub(1).max(1) as u32);
    let why = format!("alpha 6 certifies only {best} of {sample} sampled stars, so {k} nearest neighbours");
    (Supergraph::Knn { k }, why)
}

/// Returns `true` if [`choose`] can return the supergraph.
fn is_choice(rule: Supergraph) -> bool {
    match rule {
        Supergraph::Density { alpha } | Supergraph::Overlap { alpha, k: 1 } => ALPHAS.contains(&alpha),
        Supergraph::Overlap { .. } => false,
        Supergraph::Knn { k } => (1..=FALLBACK_K).contains(&k),
    }
}

/// Chooses the supergraph. Each rank samples stars and reports how many of them each alpha certifies. The coordinator
/// sums the reports and sends the supergraph to every rank. Only the coordinator's result contains the reason.
pub(crate) async fn choice<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    population: u64,
) -> Result<Choice, TransportError> {
    cx.enter(Phase::Choice)?;
    let balls = balls_of_sample(cx, subdomain, table, population);
    let search = Search {
        phase: Phase::Choice,
        wanted: MOST_CANDIDATES,
        probe: false,
        own_leaf: true,
        everywhere: false,
    };
    let mut descent = Descent::new(subdomain, search, &[]);
    descent.launch(cx, table, &balls, None);
    let leaves = subdomain.leaves();
    let mut samples = report_samples(cx, leaves, table, balls, &descent);
    let (mut chosen, mut why, mut counts) = (None, None, SampleCounts::default());
    while cx.exchange().await? {
        descent.receive(cx, table)?;
        samples = samples.and_then(|balls| report_samples(cx, leaves, table, balls, &descent));
        if cx.is_coordinator() {
            why = counts.receive(cx, population).or(why);
        }
        let received = cx.take(|m| match m.body {
            Body::Choice(ChosenSupergraph(rule)) => Some(rule),
            _ => None,
        });
        if let Some(rule) = received.iter().find(|&&rule| !is_choice(rule)) {
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
    /// The number of sampled stars, and the number that each alpha certifies.
    sum: SampleStars,
}

impl SampleCounts {
    /// Adds the reports of a round. When all ranks have reported, selects the supergraph, sends it to every rank and returns
    /// the reason.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, population: u64) -> Option<String> {
        let reports = cx.take(|m| match &mut m.body {
            Body::SampleStars(counts) => Some(*counts),
            _ => None,
        });
        for counts in &reports {
            self.sum.sampled += counts.sampled;
            self.sum.certified.iter_mut().zip(counts.certified).for_each(|(sum, count)| *sum += count);
        }
        if !self.reports.complete(reports.len(), cx.config().ranks()) {
            return None;
        }
        let SampleStars { sampled, certified } = self.sum;
        let (supergraph, why) = choose(cx.config().graph.wanted, sampled, &certified, population);
        cx.send_to_all(|| Body::Choice(ChosenSupergraph(supergraph)));
        Some(why)
    }
}

/// Samples owned points. The radius of a sampled ball is six times the distance to the nearest point of the leaf,
/// which is at least the distance to the nearest of all points. It is infinite if the leaf contains no other point.
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
        let items = leaf.owned_len() * (sample.len() as u64).max(1);
        cx.charge(Account::member(Phase::Choice, leaf.id()), cost, items);
        let radii2 = nearest.kth2.into_iter().map(|nearest2| nearest2 * ALPHAS[3] * ALPHAS[3]);
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
    leaves: &[Leaf<P>],
    table: &Table<P>,
    balls: Vec<Ball>,
    descent: &Descent<P>,
) -> Option<Vec<Ball>> {
    if descent.complete().len() < balls.len() {
        return Some(balls);
    }
    let mut charges: BTreeMap<u32, Lanes> = BTreeMap::new();
    let meter = cx.own_cost();
    let mut needed = Vec::with_capacity(balls.len());
    for SampledStar { point, alpha, cost } in sampled_stars(table, &balls, descent.complete(), &meter) {
        charges.entry(leaf_number(leaves, point)).or_insert_with(|| meter.lanes()).add(cost);
        needed.push(alpha);
    }
    for (leaf, lanes) in charges {
        let mut cost = meter.fresh();
        cost.run_lanes(lanes);
        cx.charge(Account::member(Phase::Choice, leaves[leaf as usize].id()), cost, 0);
    }
    let certified = ALPHAS.map(|a| needed.iter().flatten().filter(|&&t| t <= a).count() as u64);
    let counts = SampleStars { sampled: needed.len() as u64, certified };
    cx.send_to_coordinator(Body::SampleStars(counts));
    None
}

/// The star of a sampled point.
struct SampledStar {
    point: u32,
    /// The smallest alpha that certifies the star, or `None` if the searched ball is too small.
    alpha: Option<f64>,
    cost: Cost,
}

/// Builds the stars of the samples. `meter` is an empty meter.
fn sampled_stars<P: Point>(
    table: &Table<P>,
    samples: &[Ball],
    sampled: &CompletedLists,
    meter: &Cost,
) -> Vec<SampledStar> {
    let mut builder = StarBuilder::default();
    let mut facets: Vec<P::Facet> = Vec::new();
    // Samples are in the order of their indices.
    let radius2 =
        |point: u32| samples.binary_search_by_key(&point, |ball| ball.point).map(|at| samples[at].radius2);
    let mut alpha = |Nearest { point, kth2: farthest2, list: candidates }: Nearest, cost: &mut Cost| {
        let at = table.positions()[point as usize];
        let distances2 = candidates.iter().map(|&j| dist2(table.positions()[j as usize], at));
        let nearest2 = distances2.fold(f64::INFINITY, f64::min);
        // A truncated list is complete only up to its last point.
        let is_whole = candidates.len() < MOST_CANDIDATES as usize;
        let known2 = if is_whole { radius2(point).unwrap_or(0.0) } else { farthest2 };
        if !builder.build(table.positions(), point, candidates, cost) {
            return None;
        }
        facets.clear();
        builder.facets(&mut facets);
        let mut most2: f64 = 0.0;
        for facet in &facets {
            if facet.as_ref().contains(&INFINITE) {
                return None;
            }
            let cell = finite_cell::<P>(point, facet)?;
            let corners: Vec<P> = cell.as_ref().iter().map(|&v| table.positions()[v as usize]).collect();
            most2 = most2.max(circumradius2(&corners));
        }
        (4.0 * most2 <= known2).then(|| (4.0 * most2 / nearest2).sqrt())
    };
    let star = |nearest: Nearest| {
        let (point, mut cost) = (nearest.point, meter.nested());
        SampledStar { point, alpha: alpha(nearest, &mut cost), cost }
    };
    sampled.iter().map(star).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_alpha_that_suffices_is_taken() {
        let pick = |c: [u64; 4]| choose(Wanted::AutoDensity, 1000, &c, 1_000_000).0;
        assert_eq!(pick([900, 950, 990, 1000]), Supergraph::Density { alpha: 2.5 });
        assert_eq!(pick([100, 899, 900, 990]), Supergraph::Density { alpha: 4.0 });
        assert_eq!(pick([0, 0, 0, 899]), Supergraph::Knn { k: 48 });
        let small = choose(Wanted::AutoOverlap, 10, &[0, 0, 0, 0], 10).0;
        assert_eq!(small, Supergraph::Knn { k: 9 });
    }
}
