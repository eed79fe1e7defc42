//! The choice of the supergraph where none is given: a sample of stars.
//!
//! **Statement.** A hash of their coordinates draws about a thousand points. Each asks for its surroundings, out to six
//! times the distance of the nearest point of its leaf; the nearest point of all is among them. Its star, built from
//! them, is certified by the ball of radius `alpha` times that distance iff it has no infinite facet and twice its
//! largest circumradius is no more. The coordinator takes the first of 2.5, 3, 4, 6 with at most 10 % of the sample not
//! certified, else 48 nearest neighbours. The choice does not depend on the number of workers.
//!
//! The phase comes before the nearest-neighbour balls: only graphs that are made of them need those of all points.
//!
//! **Work and depth.** At a leaf the pairs of its sample and its points; the descent's
//! (`crate::neighbours::descent`). The stars of the sample are not charged.
//!
//! **Rounds.** The descent's, one up and one down.
//!
//! **Departures.** The paper leaves alpha open. A tenth, not a fifth, and 48, not 64, are measured (`bench/README.md`).
//! Near a fifth the stars that are not certified, and those that they disturb, cost more than lists of neighbours do;
//! and since repair is cheap, shorter lists pay.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::Cost;
use septet_geometry::graph::Supergraph;
use septet_geometry::hull::StarBuilder;
use septet_geometry::measure::circumradius2;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, dist2};
use septet_geometry::separator::{DrawKey, is_sample};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::message::{self, Body, SampleStars};
use septet_protocol::transport::TransportError;

use crate::config::Wanted;
use crate::coordinator::Choice;
use crate::machine::collectives::Reports;
use crate::machine::context::Context;
use crate::neighbours::ask::{Ask, Ball};
use crate::neighbours::descent::Descent;
use crate::neighbours::results::CompletedLists;
use crate::state::cells::finite_cell;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// The alphas that are tried.
pub const ALPHAS: [f64; 4] = [2.5, 3.0, 4.0, 6.0];

/// The share of sampled stars that may stay without a local certificate.
pub const UNCERTIFIED_SHARE: f64 = 0.1;

/// Neighbours where no alpha suffices.
pub const FALLBACK_K: u32 = 48;

/// Most points that a sampled star asks for.
const MOST_CANDIDATES: u32 = 500;

/// From the sample's size and the numbers certified at each alpha: the supergraph, and why.
pub fn choose(wanted: Wanted, sample: u64, certified: &[u64], population: u64) -> (Supergraph, String) {
    for (alpha, &good) in ALPHAS.into_iter().zip(certified) {
        let open = sample - good.min(sample);
        if open as f64 <= UNCERTIFIED_SHARE * sample as f64 {
            let supergraph = match wanted {
                Wanted::AutoOverlap => Supergraph::Overlap { alpha },
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

/// Chooses the supergraph. Every worker samples stars and reports how many of them each alpha certifies. The coordinator
/// adds up the reports and broadcasts its choice. Its result also has the reason.
pub(crate) async fn choice<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    population: u64,
) -> Result<Choice, TransportError> {
    cx.enter(Phase::Choice)?;
    let balls = balls_of_sample(cx, subdomain, table, population);
    let ask = Ask { phase: Phase::Choice, wanted: MOST_CANDIDATES, probe: false, own_leaf: true };
    let mut descent = Descent::new(subdomain, ask, &[]);
    descent.launch(cx, table, &balls, None);
    let mut samples = report_samples(cx, table, balls, &descent);
    let (mut chosen, mut counts) = (None, SampleCounts::default());
    while cx.exchange().await? {
        descent.receive(cx, table)?;
        samples = samples.and_then(|balls| report_samples(cx, table, balls, &descent));
        if cx.is_coordinator() {
            chosen = counts.receive(cx, population).or(chosen);
        }
        let received = cx.take(|m| match m.body {
            Body::Choice(message::Choice(rule)) => Some(rule),
            _ => None,
        });
        chosen = received.last().map(|&rule| Choice { supergraph: Some(rule), why: None }).or(chosen);
    }
    descent.land(cx);
    chosen.ok_or_else(|| {
        let reason = if cx.is_coordinator() {
            "not all workers reported their sampled stars"
        } else {
            "phase choice ended without a choice"
        };
        TransportError::WorkerFailed { rank: cx.rank(), reason: reason.to_string() }
    })
}

/// The reports of all workers, as the coordinator adds them up.
#[derive(Debug, Default)]
struct SampleCounts {
    reports: Reports,
    sum: SampleStars,
}

impl SampleCounts {
    /// Adds the reports of a round. Once every worker has reported, chooses the supergraph and broadcasts it.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, population: u64) -> Option<Choice> {
        let reports = cx.take(|m| match &mut m.body {
            Body::SampleStars(counts) => Some(*counts),
            _ => None,
        });
        for counts in &reports {
            self.sum.sampled += counts.sampled;
            self.sum.certified.iter_mut().zip(counts.certified).for_each(|(sum, count)| *sum += count);
        }
        if !self.reports.complete(reports.len(), cx.config().workers) {
            return None;
        }
        let SampleStars { sampled, certified } = self.sum;
        let (supergraph, why) = choose(cx.config().graph.wanted, sampled, &certified, population);
        cx.to_workers(|| Body::Choice(message::Choice(supergraph)));
        Some(Choice { supergraph: Some(supergraph), why: Some(why) })
    }
}

/// The balls of sampled points: six times as far as the nearest point of the leaf, which is no nearer than the
/// nearest of all; without limit if there is none.
fn balls_of_sample<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    population: u64,
) -> Vec<Ball> {
    let population = population * 2 / 5;
    let key = DrawKey { seed: cx.config.seed, node: 0, attempt: 0 };
    let positions = &table.positions;
    let mut balls = Vec::new();
    for (at, leaf) in subdomain.leaves.iter().enumerate() {
        let members: Vec<u32> = leaf.owned().collect();
        let mut cost = Cost::ZERO;
        let sample = cost.pack(&members, |&owned| is_sample(key, population, positions[owned as usize]));
        let all = |_| f64::INFINITY;
        let nearest = nearest_direct(positions, &sample, &members, 1, all, &mut cost);
        let items = leaf.owned_len() * (sample.len() as u64).max(1);
        cx.charge(Account::member(Phase::Choice, leaf.id), cost, items);
        let radii2 = nearest.kth2.into_iter().map(|nearest2| nearest2 * ALPHAS[3] * ALPHAS[3]);
        balls.extend(sample.into_iter().zip(radii2).map(|(owned, radius2)| Ball {
            owned,
            leaf: at,
            radius2,
        }));
    }
    balls
}

/// Sends the sample's outcome if all its balls are back; if not, returns the balls.
fn report_samples<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    balls: Vec<Ball>,
    descent: &Descent<P>,
) -> Option<Vec<Ball>> {
    if descent.done().len() < balls.len() {
        return Some(balls);
    }
    let needed = needed_alphas(table, &balls, descent.done());
    let certified = ALPHAS.map(|a| needed.iter().filter(|&&t| t <= a).count() as u64);
    let counts = SampleStars { sampled: needed.len() as u64, certified };
    if !cx.is_coordinator() {
        cx.to_coordinator(Body::SampleStars(counts));
    }
    None
}

/// For each sampled star the least alpha whose ball certifies it, infinite if six does not.
fn needed_alphas<P: Point>(table: &Table<P>, samples: &[Ball], sampled: &CompletedLists) -> Vec<f64> {
    let mut builder = StarBuilder::default();
    let mut facets: Vec<P::Facet> = Vec::new();
    // Samples are in the order of their numbers.
    let radius2 =
        |owned: u32| samples.binary_search_by_key(&owned, |ball| ball.owned).map(|at| samples[at].radius2);
    let star = |(owned, farthest2, candidates): (u32, f64, &[u32])| {
        let at = table.positions[owned as usize];
        let distances2 = candidates.iter().map(|&j| dist2(table.positions[j as usize], at));
        let nearest2 = distances2.fold(f64::INFINITY, f64::min);
        // A list cut short knows its surroundings only that far.
        let full = candidates.len() < MOST_CANDIDATES as usize;
        let known2 = if full { radius2(owned).unwrap_or(0.0) } else { farthest2 };
        if !builder.build(&table.positions, owned, candidates, &mut Cost::default()) {
            return f64::INFINITY;
        }
        facets.clear();
        builder.facets(&mut facets);
        let mut most2: f64 = 0.0;
        for facet in &facets {
            if facet.as_ref().contains(&INFINITE) {
                return f64::INFINITY;
            }
            let Some(cell) = finite_cell::<P>(owned, facet) else { return f64::INFINITY };
            let corners: Vec<P> = cell.as_ref().iter().map(|&v| table.positions[v as usize]).collect();
            most2 = most2.max(circumradius2(&corners));
        }
        if 4.0 * most2 > known2 { f64::INFINITY } else { (4.0 * most2 / nearest2).sqrt() }
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
