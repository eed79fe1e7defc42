//! Machines in which rank 0 owns points, because the group of the root has every rank. The results must be those of other
//! machines: no phase may assume that rank 0 owns no point.

mod weighted;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::graph::Supergraph;
use septet_geometry::hash::Draw;
use septet_protocol::ids::{COORDINATOR, NodeId, Rank};
use septet_protocol::message::{Child, PointBatch, PointSum, UNKNOWN_RADIUS2};

use super::*;
use crate::config::{Correction, Family, Fault, Purpose, SetRule, Task, Wanted, WorkerConfig};
use crate::machine::context::Running;
use crate::machine::group::Group;

/// The rows that the ranks hold at first.
#[derive(Clone, Copy)]
enum Blocks {
    Equal,
    AllOnRank0,
}

/// The program of a rank of a machine whose root's group has every rank. The frame is the first points.
async fn with_everyone<P: Point>(
    mut cx: Context<P>,
    points: &[P],
    blocks: Blocks,
) -> Result<Share<P>, TransportError> {
    let cx = &mut cx;
    let (population, ranks) = (points.len() as u64, cx.config().ranks());
    let mut frame = PointBatch::default();
    for (id, &position) in points.iter().enumerate().take(P::DIM + 1) {
        frame.push(id as u64, position, COORDINATOR, UNKNOWN_RADIUS2);
    }
    let at = |rank: Rank| match blocks {
        Blocks::Equal => points.len() * rank as usize / ranks as usize,
        Blocks::AllOnRank0 => points.len() * rank.min(1) as usize,
    };
    let range = at(cx.rank())..at(cx.rank() + 1);
    let ids = range.clone().map(|i| i as u64).collect();
    let mut block = PointBatch::in_transit(ids, points[range].to_vec());
    block.radii2.0 = vec![1e-2; block.len()];
    let leaf = population <= cx.config().tree.leaf;
    let group = Group::new(NodeId::ROOT, Child { population, first: COORDINATOR, ranks, leaf });
    let (subdomain, table) = partition(cx, group, block, Plan::new()).await?;
    assert!(table.owned_len() > 0 || cx.config().fault.is_some() || leaf, "rank {} owns no point", cx.rank());
    let population = PointSum::of((0..).zip(points.iter().copied()));
    let share = Share::new(cx.rank());
    finish(cx, Ground::new(subdomain, table, frame, population), share).await
}

/// Runs a machine to its end. Returns the shares of the ranks.
fn run_everyone<P: Point>(config: WorkerConfig, points: &[P], blocks: Blocks) -> Vec<Share<P>> {
    let config = Arc::new(config);
    let start = |rank| Running::start(rank, config.clone(), None, |cx| with_everyone(cx, points, blocks));
    let mut ranks: Vec<_> = (0..config.ranks()).map(start).collect();
    for round in 1.. {
        let mut wire = Vec::new();
        for rank in &mut ranks {
            wire.extend(rank.step().unwrap());
        }
        if ranks.iter().all(Running::is_done) {
            break;
        }
        let active = !wire.is_empty() || ranks.iter().any(Running::busy);
        let mut boxes: Vec<Vec<_>> = ranks.iter().map(|_| Vec::new()).collect();
        for message in wire {
            boxes[message.to as usize].push(message);
        }
        for (rank, inbox) in ranks.iter_mut().zip(boxes) {
            rank.deliver(round, active.then_some(inbox));
        }
    }
    ranks.into_iter().map(|rank| rank.into_result().unwrap()).collect()
}

/// The cells of a result, as sorted rows of sorted ids.
fn cells<P: Point>(shares: &[Share<P>]) -> Vec<Vec<u64>> {
    let corners = P::DIM + 1;
    let of_piece = |share: &Share<P>| {
        let piece = &share.piece;
        let rows = piece.rows.chunks_exact(piece.width(corners)).map(|row| &row[..corners]);
        rows.map(|row| row.iter().map(|&v| piece.ids[v as usize]).collect()).collect::<Vec<Vec<u64>>>()
    };
    let mut all: Vec<Vec<u64>> = shares.iter().flat_map(of_piece).collect();
    for row in &mut all {
        row.sort_unstable();
    }
    all.sort_unstable();
    all
}

fn random<P: Point>(n: usize) -> Vec<P> {
    let mut draw = Draw::new(31);
    (0..n).map(|_| draw.point()).collect()
}

/// The ways of a run through the phases: path, supergraph, separator sets, correction, faults, gathering.
pub(crate) fn ways(workers: u32) -> Vec<(&'static str, WorkerConfig)> {
    let density = Wanted::Fixed(Supergraph::Density { alpha: 2.5 });
    let auto = |purpose| Wanted::Auto { family: Family::Density, purpose };
    let base = WorkerConfig { workers, ..WorkerConfig::plain() };
    let way = |name, change: &dyn Fn(&mut WorkerConfig)| {
        let mut config = base.clone();
        change(&mut config);
        (name, config)
    };
    vec![
        way("knn", &|_| {}),
        way("density", &|c| c.graph.wanted = density),
        way("overlap", &|c| {
            c.graph.wanted = Wanted::Fixed(Supergraph::Overlap { alpha: 2.0, k: 3 });
        }),
        way("auto", &|c| c.graph.wanted = auto(Purpose::Counting)),
        way("auto-timing", &|c| c.graph.wanted = auto(Purpose::Timing)),
        way("both", &|c| (c.graph.wanted, c.graph.sets) = (density, SetRule::Both)),
        way("own", &|c| (c.graph.wanted, c.graph.sets) = (density, SetRule::Own)),
        way("smaller", &|c| (c.graph.wanted, c.graph.sets) = (density, SetRule::Smaller)),
        way("bottom-up", &|c| (c.graph.wanted, c.graph.correction) = (density, Correction::BottomUp)),
        way("picture", &|c| {
            (c.shown.view, c.shown.with_neighbours) = (100, true);
            (c.shown.with_edges, c.shown.with_sets) = (true, true);
        }),
        way("gathered", &|c| {
            (c.graph.wanted, c.graph.exchange_cap) = (Wanted::Fixed(Supergraph::Knn { k: 4 }), Some(0));
        }),
        way("unsplit", &|c| c.fault = Some(Fault::RefuseSplit { first: NodeId(2), last: NodeId(3) })),
        way("whole", &|c| c.tree.leaf = 10_000),
        way("direct", &|c| (c.counted, c.tree.balanced) = (false, true)),
        way("direct, picture", &|c| {
            (c.counted, c.shown.view) = (false, 100);
        }),
        way("direct, unsplit", &|c| {
            (c.counted, c.fault) = (false, Some(Fault::RefuseSplit { first: NodeId(2), last: NodeId(3) }));
        }),
    ]
}

/// A run that selects an independent set.
pub(crate) fn selecting(workers: u32) -> WorkerConfig {
    let mut config = WorkerConfig { workers, ..WorkerConfig::plain() };
    config.task = Task::Independent { fixed: 3 };
    config.graph.wanted = Wanted::Fixed(Supergraph::Density { alpha: 1.0 });
    config
}

/// The cells do not depend on the ranks that own points, rank 0 among them or alone.
fn every_phase_works_with_points_on_rank_0<P: Point>() {
    let points = random::<P>(600);
    let mut expected = None;
    for workers in [0, 1, 4] {
        for (name, config) in ways(workers) {
            let (counted, ranks) = (config.counted, config.ranks());
            let gathers = name == "gathered";
            let shares = run_everyone(config, &points, Blocks::Equal);
            let share = &shares[0];
            let merged = share.certified.totals.merged;
            assert_eq!((merged.stars, merged.disagreements, merged.minima), (600, 0, 1), "{name}, {workers}");
            assert_eq!(shares.len() as u32, ranks, "{name}, {workers}");
            assert_eq!(share.certified.fallback.is_some(), gathers, "{name}, {workers}");
            let cells = cells(&shares);
            assert_eq!(cells.len() as u64, merged.cells, "{name}, {workers}");
            assert_eq!(expected.get_or_insert_with(|| cells.clone()), &cells, "{name}, {workers}, {counted}");
        }
    }
}

#[test]
fn every_phase_works_with_points_on_rank_0_in_both_dimensions() {
    every_phase_works_with_points_on_rank_0::<DVec2>();
    every_phase_works_with_points_on_rank_0::<DVec3>();
}

/// The independent set does not depend on the ranks that own points.
#[test]
fn independent_sets_do_not_depend_on_the_owners() {
    let points = random::<DVec2>(600);
    let members = [0, 1, 4].map(|workers| {
        let shares = run_everyone(selecting(workers), &points, Blocks::Equal);
        let mut members: Vec<u64> = shares.into_iter().flat_map(|share| share.selected.members).collect();
        members.sort_unstable();
        members
    });
    assert!(members[0].len() > 10 && members.iter().all(|set| *set == members[0]), "{members:?}");
}

/// If one rank holds all points at first, the first move gives all ranks equal shares, and the cells are the same.
#[test]
fn one_rank_with_all_points_shares_them() {
    let points = random::<DVec3>(20_000);
    let config = || WorkerConfig { workers: 7, counted: false, ..WorkerConfig::plain() };
    let shares = run_everyone(config(), &points, Blocks::AllOnRank0);
    let mut loads = BTreeMap::new();
    for (key, tally) in shares.iter().flat_map(|share| &share.ledger.part.rounds) {
        let load: &mut u64 = loads.entry(key.round).or_default();
        *load = tally.largest_load.max(*load);
    }
    let loads: Vec<u64> = loads.into_values().filter(|&load| load > 0).collect();
    let &[first, ref moved @ .., last] = loads.as_slice() else { panic!("{loads:?}") };
    assert!(first == 20_000 && moved.len() >= 2 && last <= 2500 * 13 / 10 + 100, "{loads:?}");
    assert!(moved.iter().all(|&load| load <= 2500 * 11 / 10 + 100), "{loads:?}");
    assert_eq!(cells(&shares), cells(&run_everyone(config(), &points, Blocks::Equal)));
}
