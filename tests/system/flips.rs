//! Flipped bits in messages: a run with one is refused, or has the outputs and the ledger of the quiet run.
//!
//! `SEPTET_FLIPS=100 cargo test --release --test system flips::survey -- --ignored --nocapture` counts the outcomes of 100
//! flips for each kind of message and each configuration, with 2,000 points.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::panic;
use std::rc::Rc;
use std::sync::Once;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use crate::common::observed::Observed;
use crate::common::sets::{Draw, plane, space};
use crate::common::transports::each_transport;
use crate::common::{simulated, task, with_graph};
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Correction, Fault, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_core::{Error, Outcome, Spec, independent, run_on};
use septet_geometry::point::Point;
use septet_protocol::ids::Rank;
use septet_protocol::message::Message;
use septet_protocol::message::kinds::KINDS;
use septet_workers::config::Flip;

/// The number of messages of each kind from each rank.
type Counts = Rc<RefCell<BTreeMap<(&'static str, Rank), u32>>>;

/// The outcomes of runs with a flipped bit.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    /// Runs that ended with an error of the machine.
    failed: u32,
    /// Those of them that only the balance of the ledger detected.
    unbalanced: u32,
    /// Runs whose certificate failed.
    rejected: u32,
    /// Runs with the outputs and the ledger of the quiet run.
    equal: u32,
    /// Runs with other outputs or another ledger.
    escaped: u32,
    /// Panics of ranks.
    panics: u32,
    /// Runs of more than 10 s.
    slow: u32,
}

/// The number of panics in this process, without those that tests plant.
static PANICS: AtomicU32 = AtomicU32::new(0);

fn count_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !info.payload_as_str().unwrap_or_default().starts_with("it panicked at the beginning") {
                PANICS.fetch_add(1, Ordering::Relaxed);
            }
            before(info);
        }));
    });
}

/// Runs on a machine of one thread. Returns the counts of messages.
fn run<P: Point>(points: &[P], spec: &Spec, counted: bool) -> (Result<Outcome, Error>, Counts) {
    let counts = Counts::default();
    let result = run_on(points, (spec, task(counted)), &mut |_| {
        let counts = counts.clone();
        Box::new(Observed(move |_, messages: &[Message<P>]| {
            for message in messages {
                *counts.borrow_mut().entry((message.body.kind(), message.from)).or_default() += 1;
            }
        }))
    });
    (result, counts)
}

/// Returns `true` if outputs and ledgers are equal.
fn is_same(a: &Outcome, b: &Outcome) -> bool {
    let picture = |run: &Outcome| format!("{:?}", run.kept.picture);
    a.cells() == b.cells()
        && (&a.kept.graph, &a.kept.sets, a.hull_facets) == (&b.kept.graph, &b.kept.sets, b.hull_facets)
        && a.ledger.part == b.ledger.part
        && picture(a) == picture(b)
}

/// A run without flips, with which others are compared.
struct Quiet<'a, P> {
    points: &'a [P],
    spec: Spec,
    counted: bool,
    run: Outcome,
    counts: BTreeMap<(&'static str, Rank), u32>,
}

impl<'a, P: Point> Quiet<'a, P> {
    fn new(points: &'a [P], spec: Spec, counted: bool) -> Self {
        let (result, counts) = run(points, &spec, counted);
        let quiet = result.unwrap_or_else(|e| panic!("{spec:?}: {e}"));
        Quiet { points, spec, counted, run: quiet, counts: counts.take() }
    }

    /// Returns the kinds of messages that occur.
    fn kinds(&self) -> BTreeSet<&'static str> {
        self.counts.keys().map(|key| key.0).collect()
    }

    /// Returns the first flips that strike a message of a kind.
    fn flips(&self, kind: &'static str, wanted: usize) -> impl Iterator<Item = Flip> + '_ {
        let strikes = |flip: &Flip| {
            let (from, earlier) = flip.target(self.run.settled.workers + 1);
            self.counts.get(&(flip.kind(), from)).is_some_and(|&sent| sent > earlier)
        };
        let all = (0..).map(move |seed| Flip::new(kind, seed).expect("a kind that occurs"));
        all.filter(strikes).take(wanted)
    }

    /// Runs with flips of a kind, one at a time.
    fn flipped(&self, kind: &'static str, wanted: usize) -> Tally {
        let mut tally = Tally::default();
        for flip in self.flips(kind, wanted) {
            let spec = self.spec.clone().with(|c| c.planted.fault = Some(Fault::Flip(flip)));
            let (panics, start) = (PANICS.load(Ordering::Relaxed), Instant::now());
            let (result, _) = run(self.points, &spec, self.counted);
            tally.slow += u32::from(start.elapsed() > Duration::from_secs(10));
            tally.panics += PANICS.load(Ordering::Relaxed) - panics;
            match result {
                Err(Error::Machine(error)) => {
                    tally.failed += 1;
                    tally.unbalanced += u32::from(error.to_string().contains("are not those that were sent"));
                }
                Err(Error::NotCertified { .. }) => tally.rejected += 1,
                Err(error) => panic!("{flip:?}: {error}"),
                Ok(run) if is_same(&run, &self.run) => tally.equal += 1,
                Ok(_) => {
                    println!("{flip:?} escaped");
                    tally.escaped += 1;
                }
            }
        }
        tally
    }
}

/// The number of workers.
const WORKERS: u32 = 8;

/// Half of the points are in general position. The others are on a grid or coincide with other points.
fn mixed<P: Point>(mut points: Vec<P>) -> Vec<P> {
    let mut draw = Draw::new(9);
    for _ in 0..points.len() {
        let copy = points[draw.below(points.len())];
        let mut at = P::splat(0.0);
        for i in 0..P::DIM {
            at.set_coord(i, draw.below(8) as f64 / 8.0);
        }
        points.push(if draw.below(4) == 0 { copy } else { at });
    }
    points
}

/// Configurations of `triangulate` and, if the second entry is `true`, of `simulate`. Stars are repaired in the fourth, and
/// gathered in the fifth. The last has a group of more than 33 ranks.
fn configurations() -> [(Spec, bool); 7] {
    use SeparatorSets::{Both, Ghost};
    let base = simulated(Workers::Count(WORKERS), 0, 20);
    let direct = base.clone().with(|c| c.keep.view = Some(100));
    let chosen = base.clone().with(|c| (c.keep.graph, c.keep.view, c.keep.owner) = (true, Some(100), true));
    let in_sets = with_graph(&base, (GraphKind::Density, Both, Alpha::Value(2.5), Neighbours::Auto));
    let in_sets = in_sets.with(|c| c.keep.sets = true);
    let with_ghosts = with_graph(&base, (GraphKind::Density, Ghost, Alpha::Value(2.5), Neighbours::Auto));
    let with_ghosts = with_ghosts.with(|c| c.recursion.neighbours = Correction::Stages);
    let few = with_graph(&base, (GraphKind::Knn, Ghost, Alpha::Auto, Neighbours::Count(6)));
    let capped = few.clone().with(|c| c.planted.exchange_cap = Some(1));
    let large = base.with(|c| c.machine.workers = Workers::Count(40));
    [
        (direct, false),
        (chosen, true),
        (in_sets, true),
        (few, true),
        (capped, true),
        (with_ghosts, true),
        (large, false),
    ]
}

/// Flips bits of all kinds of messages under all configurations.
fn no_flip_escapes<P: Point>(points: &[P], wanted: usize) {
    count_panics();
    let mut occurred = BTreeSet::new();
    for (number, (spec, counted)) in configurations().into_iter().enumerate() {
        let quiet = Quiet::new(points, spec, counted);
        for kind in quiet.kinds() {
            let tally = quiet.flipped(kind, wanted);
            println!("{} dimensions, configuration {number}, {kind}: {tally:?}", P::DIM);
            let Tally { escaped, panics, slow, unbalanced, .. } = tally;
            assert_eq!((escaped, panics, slow), (0, 0, 0), "{kind}, configuration {number}");
            // The sum of the points of the certificate detects these without the balance.
            let is_of_points = kind == "move";
            assert!(!is_of_points || unbalanced == 0, "{kind}, configuration {number}: {tally:?}");
        }
        occurred.extend(quiet.kinds());
    }
    // A plan occurs with a worker for each leaf only, and the others in independent sets, in evaluations and with weights
    // only.
    let absent = ["plan", "joined", "left", "work-items", "work-counts", "sites"];
    let expected: BTreeSet<&str> = KINDS.into_iter().filter(|kind| !absent.contains(kind)).collect();
    assert_eq!(occurred, expected);
}

#[test]
fn no_flip_escapes_in_the_plane() {
    no_flip_escapes(&mixed(plane(Kind::Uniform, 150, 5)), 4);
}

#[test]
fn no_flip_escapes_in_space() {
    no_flip_escapes(&mixed(space(Kind::Uniform, 150, 5)), 4);
}

#[test]
#[ignore = "a survey of minutes"]
fn survey() {
    let wanted = std::env::var("SEPTET_FLIPS").map_or(5, |number| number.parse().expect("a number"));
    no_flip_escapes(&mixed(plane(Kind::Uniform, 1000, 5)), wanted);
    no_flip_escapes(&mixed(space(Kind::Uniform, 1000, 5)), wanted);
}

/// Flips act in the machine, so all transports end alike.
#[test]
fn flips_strike_on_all_transports() {
    let points = mixed(plane(Kind::Uniform, 150, 5));
    let base = simulated(Workers::Count(WORKERS), 0, 20);
    let quiet = Quiet::new(&points, base.clone(), false);
    for kind in ["start", "samples", "move", "splits", "copies", "merged"] {
        for flip in quiet.flips(kind, 2) {
            let spec = base.clone().with(|c| c.planted.fault = Some(Fault::Flip(flip)));
            each_transport(|start| match start.run(&points, &spec, false) {
                Err(Error::Machine(_) | Error::NotCertified { .. }) => {}
                other => panic!("{start:?}, {flip:?}: {:?}", other.map(|run| run.cell_count())),
            });
        }
    }
}

#[test]
fn no_flip_changes_an_independent_set() {
    let places = space(Kind::Uniform, 400, 5);
    let sizes = vec![0.1; places.len()];
    let base = simulated(Workers::Count(WORKERS), 0, 20);
    let quiet = independent(&places, &sizes, 0, &base).unwrap();
    let mut refused = 0;
    for kind in ["samples", "counts", "move", "ghosts", "joined", "left"] {
        for seed in 0..20 {
            let flip = Fault::Flip(Flip::new(kind, seed).unwrap());
            let spec = base.clone().with(|c| c.planted.fault = Some(flip));
            match independent(&places, &sizes, 0, &spec) {
                Err(Error::Machine(_)) => refused += 1,
                Err(error) => panic!("{kind} {seed}: {error}"),
                Ok(run) => {
                    assert_eq!(run.kept.selected, quiet.kept.selected, "{kind} {seed}");
                    assert!(run.ledger.part == quiet.ledger.part, "{kind} {seed}");
                }
            }
        }
    }
    assert!(refused > 70, "{refused}");
}
