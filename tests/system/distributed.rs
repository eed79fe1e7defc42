//! Triangulations by several processes: the union of their parts, and the errors of all.
//!
//! Threads are the processes, and channels connect them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};
use septet_core::generate::Kind;
use septet_core::result::canonical::{LabelledCells, canonicalise};
use septet_core::run::distributed::{ProcessPoint, simulate, triangulate};
use septet_core::spec::{SpecError, Workers};
use septet_core::{Error, Neighbour, Outcome, Spec, WorkerShare, channels};
use septet_geometry::point::Point;
use septet_geometry::range::RangeError;
use septet_protocol::transport::TransportError;

use crate::common::sets::{Draw, flat_grid, grid, plane, space};
use crate::common::{base, within};

/// The points of a process, and the input index of the first.
type Held<C> = (Vec<C>, u64);

/// Runs a process for each part of the points.
fn run_all<C>(held: &[Held<C>], spec: impl Fn(usize) -> Spec + Sync) -> Vec<Result<Outcome, Error>>
where
    C: ProcessPoint + Sync,
{
    let spec = &spec;
    std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for ((process, held), mut transport) in
            held.iter().enumerate().zip(channels::<C::Point>(held.len() as u32))
        {
            let run = move || triangulate(&mut transport, &held.0, held.1, &spec(process));
            threads.push(scope.spawn(run));
        }
        threads.into_iter().map(|thread| thread.join().expect("a process panicked")).collect()
    })
}

/// Runs a process for each part of the points, with this number of workers.
fn parts<C: ProcessPoint + Sync>(held: &[Held<C>], workers: u32) -> Vec<Outcome> {
    let all = run_all(held, |_| spec(workers));
    all.into_iter().map(|part| part.unwrap_or_else(|e| panic!("{} processes: {e}", held.len()))).collect()
}

/// Returns the configuration for this number of workers, with so small leaves that all workers get points.
fn spec(workers: u32) -> Spec {
    Spec::default().with(|c| {
        c.machine.workers = Workers::Count(workers);
        c.tree.leaf = Some(20);
    })
}

/// Divides points in these shares. The first has the input index `first_id`.
fn divided<P: Point>(points: &[P], shares: &[usize], first_id: u64) -> Vec<Held<P>> {
    let sum: usize = shares.iter().sum();
    let ends = shares.iter().scan(0, |end, share| {
        *end += share;
        Some(points.len() * *end / sum)
    });
    let mut start = 0;
    ends.map(|end| {
        let own = (points[start..end].to_vec(), first_id + start as u64);
        start = end;
        own
    })
    .collect()
}

/// The share of each rank.
fn by_rank(parts: &[Outcome]) -> BTreeMap<u32, &WorkerShare> {
    let all: Vec<&WorkerShare> = parts.iter().flat_map(|part| &part.shares).collect();
    let by_rank: BTreeMap<u32, &WorkerShare> = all.iter().map(|s| (s.rank, *s)).collect();
    assert_eq!(all.len(), by_rank.len());
    by_rank
}

/// The cells of all parts in canonical order.
fn united<P: Point>(parts: &[Outcome]) -> Vec<u64> {
    let mut rows = Vec::new();
    for share in by_rank(parts).values() {
        for cell in 0..share.cell_count() {
            rows.extend(share.cell(cell).iter().map(|&v| share.ids[v as usize]));
        }
    }
    canonicalise::<P>(LabelledCells { rows, ..LabelledCells::default() }).rows
}

/// Each point has one owner, and all have the coordinates of the input.
fn check_points<P: Point>(parts: &[Outcome], held: &[Held<P>]) {
    let mut owners = BTreeMap::new();
    for share in by_rank(parts).values() {
        assert_eq!(share.coordinates.len(), share.ids.len() * P::DIM);
        for (at, (&id, x)) in share.ids.iter().zip(share.coordinates.chunks(P::DIM)).enumerate() {
            let (points, first) =
                held.iter().find(|(p, first)| (*first..first + p.len() as u64).contains(&id)).unwrap();
            assert_eq!(P::from_coords(x), points[(id - first) as usize], "{id}");
            assert_eq!(share.owners[at] == share.rank, at < share.owned);
            if at < share.owned {
                assert_eq!(owners.insert(id, share.rank), None);
            }
        }
    }
    for share in by_rank(parts).values() {
        let found: Vec<_> = share.ids.iter().map(|id| owners[id]).collect();
        assert_eq!(found, share.owners);
    }
    assert_eq!(owners.len() as u64, parts[0].points.used);
}

/// Every neighbour has the same facet, and the cell as its neighbour there. Returns the number of facets between workers,
/// each counted twice.
fn check_adjacency(parts: &[Outcome]) -> usize {
    let by_rank = by_rank(parts);
    let (mut hull, mut between) = (0, 0);
    for (&rank, share) in &by_rank {
        for cell in 0..share.cell_count() {
            let row = share.cell(cell);
            for slot in 0..row.len() {
                let (other_rank, other) = match share.neighbour(cell, slot).unwrap() {
                    Neighbour::Hull => {
                        hull += 1;
                        continue;
                    }
                    Neighbour::Local(other) => (rank, other as usize),
                    Neighbour::Remote { rank: other, cell } => {
                        assert_ne!(other, rank);
                        between += 1;
                        (other, cell as usize)
                    }
                };
                let there = by_rank[&other_rank];
                let back = if other_rank == rank {
                    Neighbour::Local(cell as u32)
                } else {
                    Neighbour::Remote { rank, cell: cell as u32 }
                };
                let slots = (0..row.len()).filter(|&s| there.neighbour(other, s) == Some(back));
                let facet = facet(share, cell, slot);
                assert!(
                    slots.into_iter().any(|s| self::facet(there, other, s) == facet),
                    "{rank} {cell} {slot}"
                );
            }
        }
    }
    assert_eq!(hull as u64, parts[0].hull_facets);
    between
}

/// The vertices of a facet, ascending.
fn facet(share: &WorkerShare, cell: usize, slot: usize) -> Vec<u64> {
    let others = share.cell(cell).iter().enumerate().filter(|&(at, _)| at != slot);
    let mut ids: Vec<u64> = others.map(|(_, &v)| share.ids[v as usize]).collect();
    ids.sort_unstable();
    ids
}

/// Compares the parts with the triangulation of all points.
fn check<P: Point + ProcessPoint<Point = P>>(held: &[Held<P>], workers: u32) -> Vec<Outcome> {
    let points: Vec<P> = held.iter().flat_map(|(points, _)| points.iter().copied()).collect();
    let ids: Vec<u64> = held.iter().flat_map(|(points, first)| (*first..).take(points.len())).collect();
    let whole = septet_core::triangulate(&points, &base()).unwrap();
    let parts = parts(held, workers);
    let rows: Vec<u64> = whole.cells().iter().map(|&v| ids[v as usize]).collect();
    let expected = canonicalise::<P>(LabelledCells { rows, ..LabelledCells::default() }).rows;
    let what = format!("{} points, {} processes, {workers} workers", points.len(), held.len());
    assert!(united::<P>(&parts) == expected, "{what}");
    let id = |&(row, first): &(u64, u64)| (ids[row as usize], ids[first as usize]);
    let mut duplicates: Vec<_> = parts.iter().flat_map(|part| part.left_out.duplicates.clone()).collect();
    duplicates.sort_unstable();
    assert_eq!(duplicates, whole.left_out.duplicates.iter().map(id).collect::<Vec<_>>(), "{what}");
    for (part, (points, first)) in parts.iter().zip(held) {
        let own = *first..first + points.len() as u64;
        assert!(part.left_out.duplicates.iter().all(|(row, _)| own.contains(row)), "{what}");
        let global =
            (part.points.input, part.points.used, part.dimension, part.cell_count(), part.hull_facets);
        let cells = whole.cell_count();
        let expected = (whole.points.input, whole.points.used, whole.dimension, cells, whole.hull_facets);
        assert_eq!(global, expected, "{what}");
    }
    if whole.dimension == P::DIM as isize {
        check_points(&parts, held);
        let between = check_adjacency(&parts);
        assert!(between > 0 || workers == 1 || points.len() < 100, "{what}");
    }
    parts
}

const PROCESSES: [usize; 4] = [1, 2, 5, 8];

/// Checks points in equal shares on all numbers of processes.
fn check_all<P: Point + ProcessPoint<Point = P>>(points: &[P]) {
    for processes in PROCESSES {
        let held = divided(points, &vec![1; processes], 1 << 33);
        check(&held, processes as u32);
        check(&held, processes as u32 + 3);
    }
}

#[test]
fn random_points_of_several_processes() {
    check_all(&space(Kind::Uniform, 1500, 5));
    check_all(&plane(Kind::Clusters, 1500, 5));
}

#[test]
fn grids_and_flat_sets_of_several_processes() {
    check_all(&grid([7, 6, 5], 0.25));
    check_all(&flat_grid(20, 15));
    check_all(&flat_grid(20, 15).into_iter().map(|x| x.extend(1.0)).collect::<Vec<DVec3>>());
}

/// Coordinates far outside the exact range are scaled, and are returned as they were.
#[test]
fn scaled_points_of_several_processes() {
    let points: Vec<DVec3> = space(Kind::Uniform, 400, 5).into_iter().map(|x| x * 1e-200).collect();
    check(&divided(&points, &[1, 2, 1], 0), 4);
}

#[test]
fn coincident_points_of_several_processes() {
    let points = plane(Kind::Uniform, 300, 5);
    let mut draw = Draw::new(3);
    let twice: Vec<DVec2> = (0..600).map(|_| points[draw.below(points.len())]).collect();
    check_all(&twice);
    check_all(&vec![DVec2::ONE; 40]);
}

#[test]
fn few_points_of_several_processes() {
    for n in 0..10 {
        for processes in PROCESSES {
            check(&divided(&space(Kind::Uniform, 10, 5)[..n], &vec![1; processes], 3), processes as u32);
            check(&divided(&plane(Kind::Uniform, 10, 5)[..n], &vec![1; processes], 3), processes as u32 + 1);
        }
    }
}

#[test]
fn empty_and_unequal_processes() {
    let points = space(Kind::Uniform, 900, 5);
    for shares in [&[0, 1][..], &[1, 0, 0, 0, 0], &[0, 0, 900, 0, 1], &[1, 899], &[450, 0, 3, 447]] {
        let held = divided(&points, shares, 0);
        check(&held, shares.len() as u32);
        check(&held, 2 * shares.len() as u32);
    }
    // The order of the indices need not be that of the processes, and indices may be missing.
    let mut held = divided(&points, &[1, 2, 3], 1 << 40);
    held.reverse();
    held[1].1 = 7;
    check(&held, 3);
}

/// Arrays are points as well, and a transport serves several runs.
#[test]
fn a_transport_serves_several_runs() {
    let points: Vec<[f64; 2]> = plane(Kind::Uniform, 200, 5).into_iter().map(|x| x.to_array()).collect();
    let counts = std::thread::scope(|scope| {
        let start = |(process, mut transport): (usize, _)| {
            let own = &points[100 * process..100 * (process + 1)];
            scope.spawn(move || {
                let run =
                    |workers| triangulate(&mut transport, own, 100 * process as u64, &spec(workers)).unwrap();
                [2, 5, 3].map(run).map(|part| (part.cells, part.shares.len()))
            })
        };
        let threads: Vec<_> = channels::<DVec2>(2).into_iter().enumerate().map(start).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
    });
    let cells = counts[0][0].0;
    assert_eq!(counts, [[(cells, 1), (cells, 3), (cells, 2)], [(cells, 1), (cells, 2), (cells, 1)]]);
}

/// Runs that all end with an error. Returns the errors of the processes.
fn errors<P: Point + ProcessPoint<Point = P>>(
    held: Vec<Held<P>>,
    spec: impl Fn(usize) -> Spec + Sync + Send + 'static,
) -> Vec<Error> {
    let all = within(60, "a run with an error", move || run_all(&held, spec));
    all.into_iter().map(|part| part.map(|part| part.cells).expect_err("an error")).collect()
}

/// One worker for each process.
fn default_of(processes: usize) -> impl Fn(usize) -> Spec + Sync + Send + Clone + 'static {
    move |_| spec(processes as u32)
}

#[test]
fn a_point_that_is_not_finite_ends_all_processes() {
    let mut points = space(Kind::Uniform, 200, 5);
    points[120].y = f64::NAN;
    points[130].x = f64::INFINITY;
    let held = divided(&points, &[1, 1, 1, 1], 1 << 33);
    let expected = (1usize << 33) + 120;
    for error in errors(held.clone(), default_of(4)) {
        let is_it = |error: &Error| matches!(error, Error::Points(RangeError::NotFinite { index, value }) if *index == expected && value.is_nan());
        assert!(is_it(&error), "{error}");
    }
    let skipping = |_| default_of(4)(0).with(|c| c.input.skip_invalid = true);
    let parts = run_all(&held, skipping).into_iter().map(Result::unwrap);
    let refused: Vec<_> = parts.map(|part| (part.points.used, part.left_out.refused)).collect();
    let first = 1u64 << 33;
    assert_eq!(refused, [(198, vec![]), (198, vec![]), (198, vec![first + 120, first + 130]), (198, vec![])]);
}

/// A rank that fails or panics, and a flipped bit, end all processes.
#[test]
fn faults_end_all_processes_with_the_same_error() {
    let points = plane(Kind::Uniform, 300, 5);
    for fault in ["panic:3:pieces", "panic:0:merge", "die:1:collect", "die:2:load", "spoil:2"] {
        let spec = move |_| default_of(4)(0).with(|c| c.planted.fault = Some(fault.parse().unwrap()));
        let found = errors(divided(&points, &[1; 4], 0), spec);
        let texts: Vec<_> = found.iter().map(ToString::to_string).collect();
        assert!(texts.iter().all(|text| *text == texts[0]), "{fault}: {texts:?}");
        let is_machine = found.iter().all(|error| matches!(error, Error::Machine(_)));
        let is_rejected = found.iter().all(|error| matches!(error, Error::NotCertified { .. }));
        assert!(if fault.starts_with("spoil") { is_rejected } else { is_machine }, "{fault}: {texts:?}");
    }
}

/// A flip of a message before the totals is detected by all processes or by none, and then it changes nothing.
#[test]
fn flips_are_detected_by_all_processes() {
    let points = space(Kind::Uniform, 200, 5);
    let held = divided(&points, &[1; 4], 0);
    let quiet = united::<DVec3>(&parts(&held, 8));
    let (mut detected, mut harmless) = (0, 0);
    for kind in [
        "survey", "start", "keys", "move", "samples", "splits", "copies", "merged", "facets", "across",
        "totals",
    ] {
        for seed in 0..10 {
            let fault = format!("flip:{kind}:{seed}").parse().unwrap();
            let faulty = move |_| spec(8).with(|c| c.planted.fault = Some(fault));
            let held = held.clone();
            let all = within(60, "a run with a flip", move || run_all(&held, faulty));
            let failed = all.iter().filter(|part| part.is_err()).count();
            // A flip on the way down may reach some processes only.
            assert!(kind == "totals" || failed == 0 || failed == all.len(), "{kind} {seed}: {failed}");
            if failed == 0 {
                let parts: Vec<Outcome> = all.into_iter().map(Result::unwrap).collect();
                assert!(united::<DVec3>(&parts) == quiet, "{kind} {seed}");
                harmless += 1;
            } else {
                detected += 1;
            }
        }
    }
    println!("{detected} detected, {harmless} harmless");
    assert!(detected > 25, "{detected}");
}

#[test]
fn indices_that_two_processes_use_are_refused() {
    let points = plane(Kind::Uniform, 100, 5);
    let held: Vec<Held<DVec2>> = divided(&points, &[1, 1], 0).into_iter().map(|(own, _)| (own, 9)).collect();
    for error in errors(held, default_of(2)) {
        assert!(matches!(error, Error::Indices { rows: 100, first: 9, last: 58 }), "{error}");
    }
    let late: Vec<Held<DVec2>> = vec![(points.clone(), 100), (points, u64::MAX - 5)];
    let texts: Vec<String> = errors(late, default_of(2)).iter().map(ToString::to_string).collect();
    assert!(texts[0] == texts[1] && texts[0].contains("process 1 does not start"), "{texts:?}");
}

#[test]
fn limits_of_one_process_end_all_processes() {
    let held = divided(&plane(Kind::Uniform, 100, 5), &[1, 1, 1], 0);
    let limit =
        move |process: usize| default_of(3)(0).with(|c| c.machine.max_memory = (process == 1).then_some(1));
    for error in errors(held.clone(), limit) {
        assert!(matches!(&error, Error::Exceeded { limit: 1, .. }), "{error}");
    }
    let cancelled = |process: usize| {
        default_of(3)(0).with(|c| c.control.cancel = (process == 2).then(|| Arc::new(AtomicBool::new(true))))
    };
    let found = errors(held, cancelled);
    assert!(matches!(found[2], Error::Interrupted));
    assert!(found[..2].iter().all(|error| matches!(error, Error::Machine(TransportError::Stopped))));
}

#[test]
fn configurations_for_one_process_are_refused() {
    let held = divided(&plane(Kind::Uniform, 100, 5), &[1, 1, 1], 0);
    let refused = |change: fn(&mut Spec)| {
        let found = errors(held.clone(), move |_| default_of(3)(0).with(change));
        let kinds: Vec<SpecError> = found
            .into_iter()
            .map(|error| match error {
                Error::Spec(error) => error,
                other => panic!("{other}"),
            })
            .collect();
        assert!(kinds.iter().all(|kind| *kind == kinds[0]), "{kinds:?}");
        kinds[0].clone()
    };
    assert!(matches!(refused(|c| c.machine.workers = Workers::Leaves), SpecError::NotDistributed { .. }));
    assert!(matches!(refused(|c| c.keep.view = Some(10)), SpecError::NotDistributed { .. }));
    assert!(matches!(refused(|c| c.keep.costs = true), SpecError::NotDistributed { .. }));
    let few = SpecError::TooFewWorkers { workers: 2, processes: 3 };
    assert_eq!(refused(|c| c.machine.workers = Workers::Count(2)), few);
}

/// A simulation by several processes has the cells of a triangulation, and the same neighbours on request.
#[test]
fn simulations_have_the_cells_and_the_neighbours_of_triangulations() {
    let points = space(Kind::Uniform, 900, 3);
    let whole = septet_core::triangulate(&points, &base()).unwrap();
    for processes in [1, 2, 5] {
        let held = divided(&points, &vec![1; processes], 0);
        let spec = spec(processes as u32 + 3).with(|spec| spec.keep.neighbours = true);
        let parts: Vec<Outcome> = std::thread::scope(|scope| {
            let (mut threads, spec) = (Vec::new(), &spec);
            for (mut transport, held) in channels::<DVec3>(processes as u32).into_iter().zip(&held) {
                threads.push(scope.spawn(move || simulate(&mut transport, &held.0, held.1, spec).unwrap()));
            }
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(united::<DVec3>(&parts) == whole.cells(), "{processes} processes");
        check_points(&parts, &held);
        assert!(check_adjacency(&parts) > 0);
        assert!(parts.iter().all(|part| part.settled.counted && part.own_counts.is_some()));
    }
}
