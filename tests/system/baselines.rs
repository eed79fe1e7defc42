//! The baselines: other counts, the same triangulation.

use std::collections::BTreeMap;

use crate::common::sets::{plane, space};
use crate::common::{
    assert_same_counts, assert_verified, combinations, levels, simulated, threaded, with_graph,
};
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Correction, Graph, Partition, Until, Workers};
use septet_core::{Outcome, Spec, count, simulate, triangulate};
use septet_geometry::point::Point;
use septet_geometry::range::{scale, scale_exponent};
use septet_geometry::separator::{DrawKey, Sampler, node_samples};
use septet_lab::baselines::incremental;
use septet_lab::experiment::fit::{Abscissa, Conclusion, FitRequest, Growth, Key, Law, fit};
use septet_lab::experiment::{Line, Runner, Sweep, parse_sizes};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::{Ledger, NodeFacts};

const LEAF: u64 = 60;

fn counted<P: Point>(points: &[P], spec: &Spec) -> Outcome {
    simulate(points, spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"))
}

/// The same cells as the paper's, and on every machine the same counts.
fn over_machines<P: Point>(points: &[P], rival: &Spec, reference: &Outcome) -> Outcome {
    let alone = counted(points, &rival.clone().with(|c| c.machine.workers = Workers::Count(1)));
    assert!(alone.cells() == reference.cells(), "{rival:?}: other cells");
    for workers in [2, 5, 64].map(Workers::Count).into_iter().chain([Workers::Leaves]) {
        let run = counted(points, &rival.clone().with(|c| c.machine.workers = workers));
        assert!(run.cells() == reference.cells(), "{workers:?}: other cells");
        assert_same_counts(&alone.ledger, &run.ledger, &format!("{workers:?}"));
    }
    let channel = threaded(Workers::Count(5), 2, LEAF).with(|c| c.machine.workers = Workers::Count(5));
    let channel = channel.with(|c| {
        c.tree.partition = rival.tree.partition;
        c.recursion.neighbours = rival.recursion.neighbours;
        c.recursion.graph = rival.recursion.graph;
        c.recursion.sets = rival.recursion.sets;
    });
    let run = counted(points, &channel);
    assert!(run.cells() == reference.cells(), "over a channel: other cells");
    assert_same_counts(&alone.ledger, &run.ledger, "over a channel");
    alone
}

fn planes<P: Point>(points: &[P]) {
    without_spheres(points, Partition::Kd);
}

/// The cells of a baseline without spheres are the same on all machines, and so are its counts.
fn without_spheres<P: Point>(points: &[P], partition: Partition) {
    let paper = simulated(Workers::Count(3), 5, LEAF);
    let reference = counted(points, &paper);
    assert_verified(points, &reference);
    for choice in [0, 1, 4] {
        let rival = with_graph(&paper, combinations(false)[choice]).with(|c| c.tree.partition = partition);
        let run = over_machines(points, &rival, &reference);
        let nodes = &run.ledger.part.nodes;
        assert!(
            nodes.len() > 16
                && nodes.values().all(|facts| facts.kind != septet_protocol::ledger::NodeKind::Sphere),
            "a sphere in {partition:?}"
        );
    }
    for workers in [1, 5, 64] {
        let fast = threaded(Workers::Count(workers), 2, LEAF).with(|c| c.tree.partition = partition);
        assert!(triangulate(points, &fast).unwrap().cells() == reference.cells(), "{workers} workers");
    }
}

#[test]
fn k_d_planes_give_the_same_cells_in_space() {
    planes(&space(Kind::Uniform, 1500, 3));
    planes(&space(Kind::Sphere, 800, 3));
}

/// Blocks along a curve: in space and in the plane, of clusters, of a grid with points on the faces of cells, and of points
/// that one cell of the curve cannot separate.
#[test]
fn blocks_along_a_curve_give_the_same_cells() {
    without_spheres(&space(Kind::Uniform, 1500, 3), Partition::Hilbert);
    without_spheres(&space(Kind::Grid, 1331, 3), Partition::Hilbert);
    without_spheres(&plane(Kind::Clusters, 2000, 3), Partition::Hilbert);
    let mut far = plane(Kind::Uniform, 800, 2);
    far.push(glam::DVec2::splat(1e30));
    without_spheres(&far, Partition::Hilbert);
}

/// Points that the curve can tell apart need no planes.
#[test]
fn a_curve_cuts_all_nodes() {
    let spec = simulated(Workers::Count(5), 5, 60).with(|c| c.tree.partition = Partition::Hilbert);
    let nodes = counted(&space(Kind::Uniform, 4000, 6), &spec).ledger.part.nodes;
    let split = nodes.values().filter(|facts| !facts.is_leaf());
    assert!(split.clone().count() > 60);
    assert!(split.clone().all(|facts| facts.kind == septet_protocol::ledger::NodeKind::Curve));
}

/// Many points lie on every plane: each has one side, the same everywhere.
#[test]
fn planes_through_grid_points() {
    planes(&space(Kind::Grid, 1331, 3));
    planes(&plane(Kind::Grid, 1600, 3));
}

#[test]
fn k_d_planes_give_the_same_cells_in_the_plane() {
    planes(&plane(Kind::Clusters, 2000, 3));
}

/// Largest number of samples of a draw by default.
const SAMPLES: u64 = 100;

/// The rule by itself: across the longest side of the node's samples, half of them lie on either side. Returns
/// the number of nodes that were cut.
fn halved<P: Point>(points: &mut [P], node: NodeId, ledger: &Ledger) -> usize {
    let facts = &ledger.part.nodes[&node];
    assert_eq!(facts.population, points.len() as u64);
    if facts.is_leaf() {
        return 0;
    }
    assert_eq!(facts.attempts, 1, "{node:?}");
    let key = DrawKey { seed: Spec::default().machine.seed, node: node.0, attempt: 0 };
    let sampler = Sampler::new(key, facts.population, node_samples(SAMPLES, facts.population));
    let sampled = |p: &P| sampler.accepts(*p);
    let extent = |axis: usize| {
        let coords = || points.iter().filter(|p| sampled(p)).map(|p| p.coord(axis));
        coords().fold(f64::MIN, f64::max) - coords().fold(f64::MAX, f64::min)
    };
    let longest = (0..P::DIM).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap();
    points.sort_by(|a, b| a.coord(longest).total_cmp(&b.coord(longest)));
    let (inside, outside) = points.split_at_mut(facts.inside as usize);
    let [a, b] = [&*inside, &*outside].map(|side| side.iter().filter(|p| sampled(p)).count());
    assert!(a.abs_diff(b) <= 1, "{node:?} of {} points: {a} samples and {b}", facts.population);
    1 + halved(inside, node.child(0), ledger) + halved(outside, node.child(1), ledger)
}

#[test]
fn planes_halve_their_samples() {
    fn check<P: Point>(points: &[P]) {
        let spec = simulated(Workers::Count(5), 5, 100).with(|c| c.tree.partition = Partition::Kd);
        let ledger = counted(points, &spec).ledger;
        let exponent = scale_exponent(points).unwrap();
        let mut points: Vec<P> = points.iter().map(|&p| scale(p, exponent)).collect();
        assert!(halved(&mut points, NodeId::ROOT, &ledger) > 30);
    }
    check(&space(Kind::Uniform, 5000, 6));
    check(&space(Kind::Slab, 5000, 6));
    check(&plane(Kind::Clusters, 5000, 6));
}

fn graph(run: &Outcome) -> BTreeMap<NodeId, NodeFacts> {
    let without_visits =
        |(&node, facts): (&NodeId, &NodeFacts)| (node, NodeFacts { visits: 0, punts: 0, pairs: 0, ..*facts });
    run.ledger.part.nodes.iter().map(without_visits).collect()
}

fn corrected<P: Point>(points: &[P]) {
    let paper = simulated(Workers::Count(3), 5, LEAF)
        .with(|c| c.recursion.graph = Graph::Density { alpha: Alpha::Value(3.0) });
    let reference = counted(points, &paper);
    let rival = paper.clone().with(|c| c.recursion.neighbours = Correction::BottomUp);
    let naive = over_machines(points, &rival, &reference);
    // Tree, separator sets and graph are functions of the radii, so those are the same.
    assert_eq!(graph(&naive), graph(&reference));
    assert_eq!(naive.ledger.part.edge_hash, reference.ledger.part.edge_hash);
    let radii = |ledger: &Ledger| depth(ledger, Phase::Probe) + depth(ledger, Phase::Neighbours);
    assert!(radii(&naive.ledger) > radii(&reference.ledger));
    for correction in [Correction::Stages, Correction::Pairs] {
        let run =
            over_machines(points, &paper.clone().with(|c| c.recursion.neighbours = correction), &reference);
        assert_eq!(graph(&run), graph(&reference));
        assert_eq!(run.ledger.part.edge_hash, reference.ledger.part.edge_hash);
        let total = run.ledger.tree.total();
        assert_eq!((total.pairs > 0, total.punts), (correction == Correction::Pairs, 0));
    }
    let both = rival.with(|c| c.tree.partition = Partition::Kd);
    over_machines(points, &both, &reference);
}

fn depth(ledger: &Ledger, phase: Phase) -> u64 {
    ledger.phases.iter().find(|p| p.phase == phase).map_or(0, |p| p.depth)
}

#[test]
fn naive_correction_finds_the_same_balls() {
    corrected(&space(Kind::Uniform, 2500, 9));
    corrected(&plane(Kind::GradedPoint, 2500, 9));
}

/// All corrections find the same radii, bit by bit, for any number of workers.
fn same_radii<P: Point>(points: &[P], what: &str) {
    let run = |correction, workers| {
        let spec = simulated(Workers::Count(workers), 5, 20).with(|c| {
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(3.0) };
            c.recursion.neighbours = correction;
            c.keep.graph = true;
        });
        let run = count(points, Some(Until::Neighbours), &spec).unwrap();
        let radii2 = run.kept.radii2.expect("radii");
        let bits: Vec<(u64, u64)> = radii2.into_iter().map(|(i, r2)| (i, r2.to_bits())).collect();
        let total = run.ledger.tree.total();
        (bits, [total.punts, total.pairs, run.ledger.totals.paper.work, run.ledger.totals.paper.depth])
    };
    let (expected, _) = run(Correction::Descent, 1);
    assert_eq!(expected.len(), points.len(), "{what}");
    for correction in [Correction::BottomUp, Correction::Stages, Correction::Pairs] {
        let (_, counts) = run(correction, 1);
        for workers in [1, 3, 16] {
            let found = run(correction, workers);
            assert!(found.0 == expected, "{what}, {correction:?}, {workers} workers");
            assert_eq!(found.1, counts, "{what}, {correction:?}, {workers} workers");
        }
    }
}

#[test]
fn all_corrections_find_the_same_radii() {
    for kind in [Kind::Uniform, Kind::Clusters, Kind::Line, Kind::Grid] {
        same_radii(&plane(kind, 700, 3), &format!("{kind} in the plane"));
        same_radii(&space(kind, 700, 3), &format!("{kind} in space"));
    }
}

/// Levels below each node.
fn heights(ledger: &Ledger) -> BTreeMap<NodeId, u32> {
    let mut heights: BTreeMap<NodeId, u32> = BTreeMap::new();
    for &leaf in ledger.part.nodes.keys() {
        let mut at = Some(leaf);
        while let Some(node) = at {
            let height = heights.entry(node).or_default();
            *height = (*height).max(leaf.level() - node.level());
            at = node.parent();
        }
    }
    heights
}

/// A node of the descent takes a fixed number of steps: 10 to replicate and combine balls, and 3 for the pairs at a
/// leaf. A node that corrects by itself takes as many levels as lie below it. Over all levels, this is a square.
#[test]
fn naive_depth_is_quadratic_in_the_levels() {
    let mut rows = Vec::new();
    for n in [500, 2000, 8000] {
        let points = space(Kind::Uniform, n, 2);
        let paper = simulated(Workers::Count(1), 5, 20)
            .with(|c| c.recursion.graph = Graph::Density { alpha: Alpha::Value(3.0) });
        let naive =
            counted(&points, &paper.clone().with(|c| c.recursion.neighbours = Correction::BottomUp)).ledger;
        let descent = counted(&points, &paper).ledger;
        let heights = heights(&naive);
        for (node, charge) in naive.part.members(Phase::Neighbours) {
            let height = u64::from(heights[&node]);
            assert!(
                charge.cost.depth() >= 2 && charge.cost.depth() <= 10 * (height + 1) + 3,
                "{node:?}: {charge:?}"
            );
        }
        let h = f64::from(levels(&naive));
        let [slow, fast] = [&naive, &descent].map(|l| depth(l, Phase::Neighbours) as f64);
        println!("n {n}: {h} levels, depth {slow} naive, {fast} by descent");
        assert!(
            fast >= h && fast <= 10.0 * (h + 1.0) + 3.0,
            "{n} points: depth {fast} by descent, {h} levels"
        );
        assert!(slow >= h * (h + 1.0), "{n} points: depth {slow}, {h} levels");
        rows.push((h, slow));
    }
    let per_level = |row: &(f64, f64)| row.1 / row.0;
    assert!(per_level(&rows[2]) > 1.3 * per_level(&rows[0]), "depth per level grows: {rows:?}");
}

fn sweep(correction: Correction) -> Vec<Line> {
    let sizes = "2^9..2^14,per-octave=2";
    let spec = simulated(Workers::Count(1), 5, 12).with(|c| c.recursion.neighbours = correction);
    let sweep = Sweep {
        sizes: parse_sizes(sizes).unwrap(),
        sizes_text: sizes.to_string(),
        kinds: vec![Kind::Uniform],
        dimension: 2,
        lipschitz: None,
        workers: vec![Workers::Count(1)],
        first_seed: 1,
        seeds: 4,
        weak: false,
        timed: false,
        until: Some(Until::Neighbours),
        spec,
    };
    let mut runner = Runner::default();
    sweep.jobs().iter().map(|job| runner.run(&sweep, job, &mut |_, _, _| {}).unwrap()).collect()
}

/// These sizes need not distinguish log^2 n from log^1.5 n, but they exclude log n.
#[test]
fn the_fit_distinguishes_the_bottom_up_correction_from_the_descent() {
    let [naive, descent] = [Correction::BottomUp, Correction::Descent].map(sweep);
    let ask = |lines: &[Line], key| {
        let request = FitRequest { x: Abscissa::PointsOverLeaf, ..FitRequest::new(key, Some("neighbours")) };
        let answer = fit(lines, &request).unwrap();
        println!("{}", answer.text());
        (answer.series[0].conclusion.clone(), answer.series[0].growth.clone())
    };
    let bends = |growth: Option<Growth>| growth.unwrap().curvature.bends;
    let (conclusion, growth) = ask(&naive, Key::Depth);
    let laws = match &conclusion {
        Conclusion::Law { law } => vec![*law],
        Conclusion::CannotTell { laws } => laws.clone(),
        other => panic!("{other:?}"),
    };
    assert!(laws.contains(&Law::LogSquared) && !laws.contains(&Law::Log), "{laws:?}");
    assert!(bends(growth));
    let (conclusion, growth) = ask(&descent, Key::Depth);
    assert!(!bends(growth) && conclusion != Conclusion::Law { law: Law::LogSquared }, "{conclusion:?}");
    let level = |lines: &[Line]| {
        let answer = fit(lines, &FitRequest::new(Key::LevelDepth, Some("neighbours"))).unwrap();
        answer.series[0].conclusion.clone()
    };
    assert_eq!(level(&naive), Conclusion::SizeBound);
    assert_eq!(level(&descent), Conclusion::SizeFree);
}

fn inserted<P: Point>(points: &[P]) {
    let run = triangulate(points, &threaded(Workers::Count(3), 2, LEAF)).unwrap();
    for seed in [1, 2] {
        let rival = incremental(points, &Spec::default().with(|c| c.machine.seed = seed)).unwrap();
        assert!(rival.cells == run.cells(), "other cells");
        assert_eq!((rival.hull_facets, &rival.points), (run.hull_facets, &run.points));
        assert!(rival.brent <= rival.rounds.iter().map(|r| r.work).sum());
    }
}

#[test]
fn insertion_gives_the_same_bytes() {
    for kind in [Kind::Uniform, Kind::Clusters, Kind::Sphere, Kind::GradedPoint] {
        inserted(&space(kind, 1500, 5));
        inserted(&plane(kind, 2000, 5));
    }
    let mut grid = space(Kind::Grid, 1000, 5);
    grid.extend_from_within(100..200);
    inserted(&grid);
}
