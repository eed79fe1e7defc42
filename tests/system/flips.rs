//! Flipped bits in messages: a run with one is refused, or has the outputs and the ledger of the quiet run.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::panic;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use crate::common::sets::{Draw, plane, space};
use crate::common::{simulated, with_graph};
use glam::{DVec2, DVec3};
use septet_core::config::{Alpha, Fault, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_core::generate::Kind;
use septet_core::{Config, Error, Run, run_on};
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};
use septet_workers::config::{Flip, WorkerConfig};
use septet_workers::host::Host;

/// The number of messages of each kind from each rank.
type Counts = Rc<RefCell<BTreeMap<(&'static str, Rank), u32>>>;

/// All ranks on one thread. Counts the messages of each kind and sender.
struct Counting<P: Point> {
    host: Host<P>,
    size: u32,
    begun: bool,
    sent: Vec<Message<P>>,
    counts: Counts,
}

impl<P: Point> Counting<P> {
    fn new(config: &Arc<WorkerConfig>, counts: Counts) -> Self {
        let host = Host::new(1..=config.workers, config, &None);
        Counting { host, size: config.ranks(), begun: false, sent: Vec::new(), counts }
    }
}

impl<P: Point> Transport<P> for Counting<P> {
    fn size(&self) -> u32 {
        self.size
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let busy = state.is_busy()?;
        if !std::mem::replace(&mut self.begun, true) {
            self.sent = self.host.begin()?;
        }
        let busy = busy || self.host.busy();
        let mut sent = std::mem::take(&mut self.sent);
        sent.extend(outbox);
        for message in &sent {
            *self.counts.borrow_mut().entry((message.body.kind(), message.from)).or_default() += 1;
        }
        let active = busy || !sent.is_empty();
        let (inbox, inner) = sent.into_iter().partition(|message| message.to == COORDINATOR);
        if !self.host.is_done() {
            self.sent = self.host.turn(Delivery { inbox: inner, active })?;
        }
        Ok(Delivery { inbox, active })
    }
}

/// The result of a run with a flipped bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    /// Runs that ended with an error of the machine.
    failed: u32,
    /// Those of them that only the balance of the ledger detected.
    unbalanced: u32,
    /// Runs whose certificate failed.
    rejected: u32,
    /// Runs with the outputs and the ledger of the quiet run.
    equal: u32,
    /// Runs with the outputs of the quiet run and another ledger.
    other_ledger: u32,
    /// Runs with other outputs.
    other_output: u32,
    /// Runs in which a rank panicked.
    panics: u32,
    /// Runs of more than 10 s.
    slow: u32,
}

/// The number of panics in this process, without those that other tests plant.
static PANICS: AtomicU32 = AtomicU32::new(0);

fn count_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            let text = info.payload_as_str().unwrap_or_default();
            if !text.starts_with("it panicked at the beginning") {
                PANICS.fetch_add(1, Ordering::Relaxed);
            }
            before(info);
        }));
    });
}

/// Runs on a machine of one thread. Returns the counts of messages.
fn run<P: Point>(points: &[P], config: &Config, counted: bool) -> (Result<Run, Error>, Counts) {
    let counts = Counts::default();
    let result = run_on(points, config, counted, &mut |machine| {
        Ok(Box::new(Counting::new(machine, counts.clone())) as Box<dyn Transport<P>>)
    });
    (result, counts)
}

/// A run without flips, with which others are compared.
struct Quiet<'a, P> {
    points: &'a [P],
    config: Config,
    counted: bool,
    run: Run,
    counts: BTreeMap<(&'static str, Rank), u32>,
}

impl<'a, P: Point> Quiet<'a, P> {
    fn new(points: &'a [P], config: Config, counted: bool) -> Self {
        let (result, counts) = run(points, &config, counted);
        let quiet = result.unwrap_or_else(|e| panic!("{config:?}: {e}"));
        Quiet { points, config, counted, run: quiet, counts: counts.take() }
    }

    /// Returns the kinds of messages that occur.
    fn kinds(&self) -> Vec<&'static str> {
        let mut kinds: Vec<&str> = self.counts.keys().map(|key| key.0).collect();
        kinds.dedup();
        kinds
    }

    /// Runs with `wanted` flips of a kind, one at a time.
    fn flipped(&self, kind: &str, wanted: u32) -> Tally {
        let mut tally = Tally::default();
        let mut struck = 0;
        for seed in 0.. {
            let flip = Flip::new(kind, seed).unwrap();
            let (from, earlier) = flip.target(9);
            if self.counts.get(&(flip.kind(), from)).is_none_or(|&sent| sent <= earlier) {
                continue;
            }
            self.try_flip(flip, &mut tally);
            struck += 1;
            if struck == wanted {
                break;
            }
        }
        tally
    }

    fn try_flip(&self, flip: Flip, tally: &mut Tally) {
        let config = self.config.clone().with(|c| c.planted.fault = Some(Fault::Flip(flip)));
        let (panics, start) = (PANICS.load(Ordering::Relaxed), Instant::now());
        let (result, _) = run(self.points, &config, self.counted);
        tally.slow += u32::from(start.elapsed() > Duration::from_secs(10));
        tally.panics += PANICS.load(Ordering::Relaxed) - panics;
        let show = std::env::var_os("SEPTET_FLIPS_SHOW").is_some();
        match result {
            Err(Error::Machine(error)) => {
                tally.failed += 1;
                tally.unbalanced += u32::from(error.to_string().contains("are not those that were sent"));
                if show {
                    println!("{} {}: {error}", flip.kind(), flip.seed());
                }
            }
            Err(Error::NotCertified { .. }) => tally.rejected += 1,
            Err(error) => panic!("{flip:?}: {error}"),
            Ok(run)
                if run.cells() != self.run.cells()
                    || run.sets != self.run.sets
                    || run.graph != self.run.graph =>
            {
                tally.other_output += 1;
                println!("OUTPUT {flip:?}");
            }
            Ok(run) if run.ledger.part != self.run.ledger.part => {
                tally.other_ledger += 1;
                println!("LEDGER {flip:?}");
            }
            Ok(_) => tally.equal += 1,
        }
    }
}

/// Points in general position, on a grid, and coincident.
fn mixed<P: Point>(random: &[P], n: usize) -> Vec<P> {
    let mut draw = Draw::new(9);
    let mut all = random.to_vec();
    while all.len() < n {
        let copy = all[draw.below(all.len())];
        let mut at = P::splat(0.0);
        for i in 0..P::DIM {
            at.set_coord(i, draw.below(8) as f64 / 8.0);
        }
        all.push(if draw.below(4) == 0 { copy } else { at });
    }
    all
}

/// The configurations under which the kinds of messages occur.
fn configurations(leaf: u64) -> Vec<(Config, bool)> {
    let base = simulated(Workers::Count(8), 0, leaf);
    let knn = (GraphKind::Knn, SeparatorSets::Ghost, Alpha::Auto, Neighbours::Count(6));
    let repaired = with_graph(&base, knn);
    let shown = base.clone().with(|c| {
        c.keep.graph = true;
        c.keep.sets = true;
    });
    let capped = repaired.clone().with(|c| c.planted.exchange_cap = Some(1));
    vec![(base, false), (shown, true), (repaired, true), (capped, true)]
}

fn survey<P: Point>(points: &[P], leaf: u64, wanted: u32) {
    count_panics();
    let only = std::env::var("SEPTET_FLIPS_KIND").ok();
    let way = std::env::var("SEPTET_FLIPS_WAY").ok().map(|way| way.parse().unwrap());
    for (at, (config, counted)) in configurations(leaf).into_iter().enumerate() {
        if way.is_some_and(|way: usize| way != at) {
            continue;
        }
        let quiet = Quiet::new(points, config, counted);
        for kind in quiet.kinds() {
            if only.as_ref().is_some_and(|only| only != kind) {
                continue;
            }
            let tally = quiet.flipped(kind, wanted);
            println!("{} {at} {kind}: {tally:?}", P::DIM);
        }
    }
}

#[test]
#[ignore = "a survey of minutes"]
fn survey_of_flips() {
    let n: usize = std::env::var("SEPTET_FLIPS_POINTS").map_or(400, |n| n.parse().unwrap());
    let wanted = std::env::var("SEPTET_FLIPS").map_or(20, |n| n.parse().unwrap());
    let dim = std::env::var("SEPTET_FLIPS_DIM").unwrap_or_default();
    let half = n as u64 / 2;
    if dim != "3" {
        survey::<DVec2>(&mixed(&plane(Kind::Uniform, half, 5), n), 20, wanted);
    }
    if dim != "2" {
        survey::<DVec3>(&mixed(&space(Kind::Uniform, half, 5), n), 20, wanted);
    }
}
