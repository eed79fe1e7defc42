//! Maximal independent sets on the machine: those of the sequential algorithm, for every number of workers.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use septet_core::error::SiteError;
use septet_core::generate::Kind;
use septet_core::spec::{Fault, Partition, Workers};
use septet_core::{Error, Outcome, Selection, Spec, independent};
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::priority::priority;
use septet_meshing::points::conflicts::{Site, Sites};
use septet_meshing::points::independent::{Independent, by_rounds, greedy};
use septet_protocol::ids::{NodeId, Phase};

use crate::common::sets::{Draw, plane, space};
use crate::common::{assert_same_counts, base, simulated, threaded};

const LEAF: u64 = 40;

/// The set without a machine: conflicts by a tree of boxes, the greedy algorithm and the same rounds on lists.
fn oracle<P: Point>(places: &[P], sizes: &[f64], fixed: usize, seed: u64) -> Independent {
    let sites: Vec<Site<P>> = places.iter().zip(sizes).map(|(&at, &size)| Site { at, size }).collect();
    let (earlier, later) = sites.split_at(fixed);
    let bars = Sites::new(earlier);
    let barred: Vec<bool> = later.iter().map(|s| !bars.against(s).is_empty()).collect();
    let graph = Sites::new(later).graph();
    let mut order: Vec<usize> = (0..later.len()).collect();
    order.sort_by(|&i, &j| lex_cmp(&later[i].at, &later[j].at));
    let mut rank = vec![0; later.len()];
    order.into_iter().enumerate().for_each(|(r, i)| rank[i] = r);
    let priorities: Vec<(u64, usize)> =
        later.iter().zip(rank).map(|(s, rank)| (priority(seed, s.at), rank)).collect();
    let set = by_rounds(&graph, &priorities, &barred);
    assert_eq!(set.members, greedy(&graph, &priorities, &barred));
    set
}

/// The set that a run selected.
fn set_of(run: &Outcome) -> &Selection {
    run.kept.selected.as_ref().unwrap()
}

fn assert_is(run: &Outcome, set: &Independent, fixed: usize, what: &str) {
    let members: Vec<usize> = set.members.iter().map(|&v| v as usize + fixed).collect();
    assert_eq!(set_of(run).members, members, "{what}: members");
    assert_eq!(set_of(run).undecided, set.undecided, "{what}: undecided");
}

/// The same set and the same counts on every machine.
fn checked<P: Point>(places: &[P], sizes: &[f64], fixed: usize, what: &str) -> Outcome {
    let set = oracle(places, sizes, fixed, 1);
    let spec = simulated(Workers::Count(1), 0, LEAF);
    let one = independent(places, sizes, fixed, &spec).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_is(&one, &set, fixed, what);
    let machines = [
        simulated(Workers::Count(2), 1, LEAF),
        simulated(Workers::Count(5), 2, LEAF),
        simulated(Workers::Count(8), 3, LEAF),
        simulated(Workers::Count(64), 4, LEAF),
        simulated(Workers::Leaves, 5, LEAF),
        threaded(Workers::Count(1), 2, LEAF),
        threaded(Workers::Count(5), 2, LEAF),
    ];
    for spec in machines {
        let what = format!("{what}, {spec:?}");
        let run = independent(places, sizes, fixed, &spec).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_is(&run, &set, fixed, &what);
        assert_same_counts(&one.ledger, &run.ledger, &what);
    }
    one
}

/// Sizes that hold about `degree` neighbours where `n` points are spread evenly over the unit cube or square.
fn even(n: usize, dimension: usize, degree: f64) -> f64 {
    match dimension {
        2 => (degree / n as f64 / PI).sqrt(),
        _ => (degree / n as f64 * 0.75 / PI).cbrt(),
    }
}

#[test]
fn uniform_sets_in_space_and_in_the_plane() {
    let points = space(Kind::Uniform, 1500, 3);
    let run = checked(&points, &vec![even(1500, 3, 12.0); 1500], 0, "space");
    assert!(set_of(&run).rounds() > 3 && set_of(&run).members.len() > 100);
    let points = plane(Kind::Uniform, 1500, 3);
    checked(&points, &vec![even(1500, 2, 12.0); 1500], 0, "plane");
}

#[test]
fn graded_sizes_and_clusters() {
    let points = space(Kind::Clusters, 1200, 4);
    let sizes: Vec<f64> = points.iter().map(|p| 1e-4 + 0.2 * p.distance(points[0])).collect();
    checked(&points, &sizes, 0, "clusters");
    let points = plane(Kind::Uniform, 1200, 4);
    let sizes: Vec<f64> = points.iter().map(|p| 1e-6 + 0.3 * p.distance(DVec2::splat(0.5))).collect();
    checked(&points, &sizes, 0, "singularity");
    // Not Lipschitz at all: neighbours' sizes differ by orders of magnitude.
    let mut draw = Draw::new(9);
    let sizes: Vec<f64> = points.iter().map(|_| 1e-3 + 0.3 * draw.unit().powi(8)).collect();
    checked(&points, &sizes, 0, "rough");
}

/// Facets and segments of a domain lie in space but fill a plane or a line: the tree divides them all the same.
#[test]
fn sets_in_a_plane_or_on_a_line_of_space() {
    let flat = plane(Kind::Uniform, 2000, 5);
    let axis: Vec<DVec3> = flat.iter().map(|p| DVec3::new(p.x, 0.25, p.y)).collect();
    let slanted: Vec<DVec3> = flat.iter().map(|p| DVec3::new(p.x, p.y, 0.5 * p.x - 0.25 * p.y)).collect();
    let line: Vec<DVec3> = flat.iter().map(|p| DVec3::new(p.x, 2.0 * p.x, -0.5 * p.x)).collect();
    let straight: Vec<DVec3> = flat.iter().map(|p| DVec3::new(0.0, 0.0, p.x)).collect();
    let line_size = 6.0 / 2000.0;
    for (what, points, size) in [
        ("axis", axis, even(2000, 2, 12.0)),
        ("slanted", slanted, even(2000, 2, 12.0)),
        ("line", line, 2.0 * line_size),
        ("straight", straight, line_size),
    ] {
        let run = checked(&points, &vec![size; 2000], 0, what);
        let leaves = run.ledger.part.nodes.values().filter(|facts| facts.is_leaf());
        let largest = leaves.map(|facts| facts.population).max().unwrap();
        assert!(largest <= LEAF, "{what}: a leaf of {largest}");
    }
    // Two of them crossing in one set, and equal distances: sizes are strict bounds.
    let cross: Vec<DVec3> = (-300..=300)
        .flat_map(|i| [DVec3::new(f64::from(i), 0.0, 0.0), DVec3::new(0.0, f64::from(i), f64::from(i))])
        .filter(|p| p.x != 0.0 || p.y != 0.0)
        .collect();
    let run = checked(&cross, &vec![1.0; cross.len()], 0, "cross");
    assert_eq!(
        set_of(&run).members.len(),
        cross.len(),
        "points at a distance of their sizes do not conflict"
    );
    let run = checked(&cross, &vec![1.5; cross.len()], 0, "cross");
    assert!(set_of(&run).members.len() < cross.len());
}

#[test]
fn fixed_points_are_respected() {
    let points = space(Kind::Uniform, 1500, 6);
    let sizes = vec![even(1500, 3, 12.0); 1500];
    for fixed in [1, 40, 700, 1500] {
        let run = checked(&points, &sizes, fixed, &format!("{fixed} fixed"));
        assert!(set_of(&run).members.iter().all(|&m| m >= fixed));
        let near = |m: &usize| (0..fixed).any(|f| points[f].distance(points[*m]) < sizes[0]);
        assert!(!set_of(&run).members.iter().any(near));
    }
}

#[test]
fn few_points_on_many_workers() {
    let mut draw = Draw::new(11);
    for n in 0..10 {
        let points: Vec<DVec3> = (0..n).map(|_| draw.point()).collect();
        let sizes: Vec<f64> = (0..n).map(|_| 0.1 + draw.unit()).collect();
        for fixed in [0, n / 3] {
            let set = oracle(&points, &sizes, fixed, 1);
            for leaf in [1, 2, 100] {
                for workers in [1, 2, 5, 8, 64] {
                    for spec in [
                        simulated(Workers::Count(workers), 7, leaf),
                        threaded(Workers::Count(workers), 2, leaf),
                    ] {
                        let run = independent(&points, &sizes, fixed, &spec).unwrap();
                        assert_is(&run, &set, fixed, &format!("{n} points, {spec:?}"));
                    }
                }
            }
        }
    }
}

#[test]
fn one_leaf_planes_and_refused_splits() {
    let points = plane(Kind::Uniform, 900, 8);
    let sizes = vec![even(900, 2, 10.0); 900];
    let set = oracle(&points, &sizes, 20, 1);
    let kd = simulated(Workers::Count(5), 1, LEAF).with(|c| c.tree.partition = Partition::Kd);
    let refused = |workers, first, last| {
        let fault = Fault::RefuseSplit { first: NodeId(first), last: NodeId(last) };
        simulated(Workers::Count(workers), 3, LEAF).with(|c| c.planted.fault = Some(fault))
    };
    let whole = simulated(Workers::Count(3), 1, 10_000);
    for spec in [kd, whole, refused(2, 1, 1), refused(5, 3, 3), refused(8, 2, 3), refused(8, 4, 7)] {
        let run = independent(&points, &sizes, 20, &spec).unwrap();
        assert_is(&run, &set, 20, &format!("{spec:?} {:?}", spec.planted.fault));
    }
}

/// No order of delivery matters, and no order of the sites.
#[test]
fn orders_do_not_matter() {
    let points = plane(Kind::Uniform, 700, 9);
    let sizes: Vec<f64> = points.iter().map(|p| 0.01 + 0.1 * p.x).collect();
    let set = oracle(&points, &sizes, 0, 1);
    for delivery in 10..20 {
        let run = independent(&points, &sizes, 0, &simulated(Workers::Count(7), delivery, LEAF)).unwrap();
        assert_is(&run, &set, 0, "delivery");
    }
    let mut order: Vec<usize> = (0..700).collect();
    Draw::new(1).shuffle(&mut order);
    let (places, of): (Vec<DVec2>, Vec<f64>) = order.iter().map(|&i| (points[i], sizes[i])).unzip();
    let run = independent(&places, &of, 0, &simulated(Workers::Count(7), 1, LEAF)).unwrap();
    let mut members: Vec<u32> = set_of(&run).members.iter().map(|&m| order[m] as u32).collect();
    members.sort_unstable();
    assert_eq!(members, set.members);
    let other = simulated(Workers::Count(7), 1, LEAF).with(|c| c.machine.seed = 2);
    let run = independent(&points, &sizes, 0, &other).unwrap();
    assert_is(&run, &oracle(&points, &sizes, 0, 2), 0, "another seed");
    assert_ne!(set_of(&run).members, set.members.iter().map(|&v| v as usize).collect::<Vec<_>>());
}

/// Rounds of the set, and of the machine: two each, and one before.
#[test]
fn rounds_are_logarithmic_and_messages_are_counted() {
    for (n, workers) in [(1000, 4), (10_000, 8), (100_000, 16)] {
        let points = space(Kind::Uniform, n as u64, 12);
        let sizes = vec![even(n, 3, 12.0); n];
        let spec = simulated(Workers::Count(workers), 1, 5 * LEAF);
        let run = independent(&points, &sizes, 10, &spec).unwrap();
        let bound = (n as f64).log2() + 2.0;
        println!(
            "{n}: {} rounds, {} members, {:?}",
            set_of(&run).rounds(),
            set_of(&run).members.len(),
            set_of(&run).undecided
        );
        assert!(set_of(&run).rounds() as f64 <= bound, "{} rounds, bound {bound}", set_of(&run).rounds());
        assert!(set_of(&run).undecided.windows(2).all(|w| w[1] < w[0]));
        let phase = run.ledger.phases.iter().find(|p| p.phase == Phase::Independent).unwrap();
        assert!(phase.rounds <= 2 * set_of(&run).rounds() as u64 + 1, "{phase:?}");
        assert!(phase.messages > 0 && phase.bytes > 0 && phase.work > 0, "{phase:?}");
        // A step of the program is a constant number of vector steps.
        assert!(phase.depth <= 12 * (set_of(&run).rounds() as u64 + 1), "{phase:?}");
        let members = set_of(&run).members.len() as f64 / n as f64;
        assert!((0.1..0.3).contains(&members), "{members} of the sites");
    }
}

/// The work of a separator's draw from so many samples, at most (`separator::draw` and its tests): it takes some 400 of
/// them, whatever it divides; 460 is three deviations above.
const DRAW: f64 = 6.0 * 460.0 * 460.0 + 300.0 * 460.0;

/// Work a site is a constant for each level above it, and constants: counts at sizes that differ by 4 and 16.
#[test]
fn work_is_the_same_for_each_level() {
    const LEAF: u64 = 250;
    let mut before: Option<[f64; 2]> = None;
    for n in [2000, 8000, 32_000] {
        let points = space(Kind::Uniform, n as u64, 12);
        let run = independent(&points, &vec![even(n, 3, 12.0); n], 0, &threaded(Workers::Count(1), 2, LEAF))
            .unwrap();
        let nodes = &run.ledger.part.nodes;
        let work = |phase| run.ledger.phases.iter().find(|p| p.phase == phase).unwrap().work as f64;
        let divided: u64 = nodes.values().filter(|f| !f.is_leaf()).map(|f| f.population).sum();
        let attempted: u64 = nodes.values().map(|f| f.attempts * f.population).sum();
        let attempts: u64 = nodes.values().map(|f| f.attempts).sum();
        let levels = nodes.keys().map(|node| node.level()).max().unwrap();
        assert!(f64::from(levels) <= 1.5 * (n as f64 / LEAF as f64).log2() + 2.0, "{n}: {levels} levels");
        // Samples, sides, counts: six steps over the sites of an attempt; then a split, of four.
        let steps = (6 * attempted + 4 * divided) as f64;
        let draws = work(Phase::Partition) - steps;
        assert!(draws > 0.0 && draws <= DRAW * attempts as f64, "{n}: {draws} of {attempts} draws");
        // Six for each site or copy that comes to a node.
        let sets = work(Phase::Sets) / divided as f64;
        assert!((6.0..12.0).contains(&sets), "{n}: {sets} for each site and level");
        let each = [Phase::Graph, Phase::Independent].map(|phase| work(phase) / n as f64);
        println!(
            "{n}: {levels} levels, {:.0} a draw, {sets:.2} a site and level, {each:?}",
            draws / attempts as f64
        );
        // Fewer sites lie at the boundary, and more of them beside a separator; both come to an end.
        if let Some([graph, rounds]) = before {
            assert!(
                each[0] < 1.25 * graph && each[1] < 1.2 * rounds,
                "{n}: {each:?} after {graph}, {rounds}"
            );
        }
        before = Some(each);
    }
}

/// Sites far from 1, and sizes whose squares overflow.
#[test]
fn the_scale_does_not_matter() {
    let points = space(Kind::Uniform, 400, 13);
    let size = even(400, 3, 12.0);
    let spec = simulated(Workers::Count(3), 1, LEAF);
    for factor in [2f64.powi(-500), 2f64.powi(-90), 2f64.powi(700)] {
        let places: Vec<DVec3> = points.iter().map(|&p| p * factor).collect();
        let run = independent(&places, &vec![size * factor; 400], 0, &spec).unwrap();
        // An independent and maximal set of the conflicts in the scale of 1.
        let near = |i: usize, j: usize| i != j && points[i].distance_squared(points[j]) < size * size;
        assert!(set_of(&run).members.iter().all(|&i| !set_of(&run).members.iter().any(|&j| near(i, j))));
        let covered = |i| set_of(&run).members.iter().any(|&j| i == j || near(i, j));
        assert!((0..400).all(covered), "{factor}: not maximal");
    }
    let run = independent(&points, &vec![f64::MAX; 400], 0, &spec).unwrap();
    assert_eq!((set_of(&run).members.len(), set_of(&run).rounds()), (1, 1));
    let run = independent(&points, &vec![f64::MIN_POSITIVE; 400], 0, &spec).unwrap();
    assert_eq!((set_of(&run).members.len(), set_of(&run).rounds()), (400, 1));
    // The only small site conflicts with no other site, however large the others are.
    let sizes: Vec<f64> = (0..400).map(|i| if i == 17 { 1e-200 } else { 1e200 }).collect();
    let run = independent(&points, &sizes, 0, &spec).unwrap();
    assert!(set_of(&run).members.len() == 2 && set_of(&run).members.contains(&17));
}

#[test]
fn inputs_without_a_graph_are_refused() {
    let points = [DVec2::ZERO, DVec2::ONE, DVec2::new(-0.0, 0.0)];
    let refused = |points: &[DVec2], sizes: &[f64], fixed, spec: &Spec| {
        independent(points, sizes, fixed, spec).unwrap_err()
    };
    let spec = base();
    let error = refused(&points, &[1.0; 3], 0, &spec);
    assert!(matches!(error, Error::Sites(SiteError::Coincident { first: 0, second: 2 })), "{error}");
    let error = refused(&points, &[1.0; 2], 0, &spec);
    assert!(matches!(error, Error::Sites(SiteError::Lengths { places: 3, sizes: 2 })), "{error}");
    let error = refused(&points, &[1.0; 3], 4, &spec);
    assert!(matches!(error, Error::Sites(SiteError::Fixed { fixed: 4, sites: 3 })), "{error}");
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(&points, &[1.0, size, 1.0], 0, &spec);
        assert!(matches!(error, Error::Sites(SiteError::Size { index: 1, .. })), "{error}");
    }
    let error = refused(&[DVec2::ZERO, DVec2::new(f64::NAN, 0.0)], &[1.0; 2], 0, &spec);
    assert!(matches!(error, Error::Points(_)), "{error}");
    let tight = base().with(|c| c.machine.max_memory = Some(1000));
    assert!(matches!(refused(&points, &[1.0; 3], 0, &tight), Error::Memory { points: 3, .. }));
    let cancelled = base().with(|c| c.control.cancel = Some(std::sync::Arc::new(true.into())));
    assert!(matches!(refused(&points[..2], &[1.0; 2], 0, &cancelled), Error::Interrupted));
    let dead = Fault::DieAt { rank: 1, phase: Phase::Independent };
    let dead = base().with(|c| c.planted.fault = Some(dead));
    assert!(matches!(refused(&points[..2], &[1.0; 2], 0, &dead), Error::Machine(_)));
}
