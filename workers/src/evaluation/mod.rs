//! Evaluations: a rule of the caller at items, level by level.
//!
//! **Statement.** The ranks hold blocks of the items of a level: consecutive items, in equal numbers up to one. Every rank
//! evaluates the rule at its items ([`septet_geometry::evaluation`]). The items of the next level keep their order, so they
//! go to other ranks only to make the blocks equal. Results stay with the ranks.
//!
//! **Source.** Section 5 of the paper, whose octree is built level by level. **Rounds.** None for a rule with one level.
//! Otherwise `2 t + 1` for each level, with `t` levels of the tree of all ranks: `2 t` for the numbers of items of all ranks,
//! and one for the items. The last level has no items to send.
//!
//! **Work and depth.** A level is one vector step, whose lanes the rule charges, and a scan over its items. Each level is a
//! step of its phase.
//!
//! **Departures.** Each rank reads its block of the first items from the caller, as it reads its rows in phase `load`, without
//! messages. The data of the rule, for example the domain, is part of the parameters that all ranks have.

use septet_geometry::evaluation::{Evaluated, Evaluation, Items, Made, Progress};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::machine::reduction::Reduced;
use crate::state::blocks::block_of;

/// Number of items that one core evaluates in turn.
const CHUNK: usize = 64;

/// Evaluates a rule in this phase. Returns the results of the items that this rank evaluated.
///
/// # Errors
/// See [`Context::exchange`].
pub(crate) async fn evaluate<P: Point>(
    cx: &mut Context<P>,
    rule: &dyn Evaluation,
    phase: Phase,
) -> Result<Evaluated, TransportError> {
    cx.enter(phase)?;
    let (mut evaluated, mut progress) = (Evaluated::default(), Progress::default());
    progress.next = rule.count();
    let mut items = rule.first(own_block(cx, progress.next));
    loop {
        let (results, next) = evaluate_level(cx, rule, &items, (phase, progress));
        let own = [results.len() as u64, next.len() as u64];
        evaluated.levels.push(results);
        if rule.is_flat() {
            break;
        }
        let counts = cx.all_reduce(Counts::of(cx, own)).await?;
        progress.add(counts.totals());
        if progress.next == 0 {
            break;
        }
        if rule.stops(&progress) {
            evaluated.rest = next;
            break;
        }
        items = level(cx, &next, &counts).await?;
    }
    cx.end_phase().await?;
    Ok(evaluated)
}

/// Returns the block of this rank. The coordinator has none.
fn own_block<P: Point>(cx: &Context<P>, items: u64) -> std::ops::Range<u64> {
    if cx.is_coordinator() { 0..0 } else { block_of(items, cx.rank() - 1, cx.config().workers) }
}

/// Evaluates the items of this rank on a level, and charges them. Returns the results and the items of the next level.
fn evaluate_level<P: Point>(
    cx: &mut Context<P>,
    rule: &dyn Evaluation,
    items: &Items,
    (phase, progress): (Phase, Progress),
) -> (Items, Items) {
    if items.is_empty() {
        return (Items::default(), Items::default());
    }
    let meter = cx.shared_cost();
    let all: Vec<&[u64]> = items.iter().collect();
    let chunks: Vec<&[&[u64]]> = all.chunks(CHUNK).collect();
    let parts = cx.map(&chunks, |chunk| Made::of(rule, chunk.iter().copied(), &meter));
    let mut made = Made::new(&meter);
    for part in parts {
        made.append(part);
    }
    let (results, next, cost) = made.into_parts(rule.is_flat());
    let count = items.len() as u64;
    cx.charge(Account::step(phase, progress.levels, NodeId::ROOT), cost, count);
    let population = &mut cx.facts(NodeId::ROOT).population;
    *population = (*population).max(progress.next);
    (results, next)
}

/// Makes the blocks of the next level equal: sends the items of this rank to the ranks whose blocks contain them. Returns the
/// block of this rank.
async fn level<P: Point>(
    cx: &mut Context<P>,
    next: &Items,
    counts: &Counts,
) -> Result<Items, TransportError> {
    let (rank, workers, total) = (cx.rank(), cx.config().workers, counts.totals()[1]);
    let from = counts.before(rank);
    let own = from..from + next.len() as u64;
    let shares: Vec<(Rank, usize)> = (1..=workers)
        .map(|worker| {
            let block = block_of(total, worker - 1, workers);
            let shared = block.end.min(own.end).saturating_sub(block.start.max(own.start));
            (worker, shared as usize)
        })
        .filter(|&(_, shared)| shared > 0)
        .collect();
    let parts = next.parts(shares.iter().map(|&(_, shared)| shared));
    let bodies = shares.iter().zip(parts).map(|(&(worker, _), part)| {
        let (lengths, words) = part.into_parts();
        (worker, Body::WorkItems { lengths: Bulk(lengths), words: Bulk(words) })
    });
    cx.send_each(0, bodies);
    cx.next_round().await?;
    let arrived = cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::WorkItems { lengths, words } => {
            Items::from_parts(std::mem::take(&mut lengths.0), std::mem::take(&mut words.0))
        }
        _ => None,
    });
    let mut items = Items::default();
    for part in arrived {
        items.append(part);
    }
    let block = own_block(cx, total);
    if items.len() as u64 != block.end - block.start {
        let reason = format!("{} items arrived instead of {}", items.len(), block.end - block.start);
        return Err(TransportError::WorkerFailed { rank, reason });
    }
    Ok(items)
}

/// For each rank, the number of results of a level and the number of its items of the next level. Ranks that are not known
/// have zeros.
#[derive(Clone, Debug)]
struct Counts(Vec<u64>);

impl Counts {
    /// Creates the counts of this rank.
    fn of<P: Point>(cx: &Context<P>, own: [u64; 2]) -> Self {
        let mut counts = vec![0; 2 * cx.config().ranks() as usize];
        let at = 2 * cx.rank() as usize;
        counts[at..at + 2].copy_from_slice(&own);
        Counts(counts)
    }

    /// Returns the sums over all ranks.
    fn totals(&self) -> [u64; 2] {
        let (pairs, _) = self.0.as_chunks::<2>();
        pairs.iter().fold([0, 0], |[results, next], &[r, n]| [results + r, next + n])
    }

    /// Returns the number of items of the next level on smaller ranks.
    fn before(&self, rank: Rank) -> u64 {
        let (pairs, _) = self.0.as_chunks::<2>();
        pairs.iter().take(rank as usize).map(|&[_, next]| next).sum()
    }
}

impl<P> Reduced<P> for Counts {
    fn join(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(sum, count)| *sum += count);
        self
    }

    fn into_body(self) -> Body<P> {
        Body::WorkCounts(Bulk(self.0))
    }

    fn take(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::WorkCounts(counts) => Some(Counts(std::mem::take(&mut counts.0))),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
