//! The coordinator: rank 0. It leads the root, hands out the blocks of the input, judges certificates and
//! takes the cells; otherwise it never holds bulk points.
//!
//! [`Coordinator::run`] is the whole machine as it sees it: one exchange a round; a phase ends when nothing
//! moved, which every rank learns in the same exchange.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use rayon::prelude::*;
use septet_geometry::complex::INFINITE;
use septet_geometry::graph::Supergraph;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Body, Merged, Message, PointBatch};
use septet_protocol::tasks::TaskLog;
use septet_protocol::transport::{Transport, TransportError};
use septet_workers::choice::{choose, encode_choice};
use septet_workers::config::{Wanted, WorkerConfig};
use septet_workers::leader::{Leader, by_node};
use septet_workers::machine::{Context, Running};
use septet_workers::outbox::Outbox;
use septet_workers::profile::{phase_span, run_span};
use septet_workers::schedule::{Known, Outcome, next};
use septet_workers::{frame, partition, sharing, summaries};

use crate::config::{Config, Progress};
use crate::error::Error;
use crate::pieces::{Loose, Piece};
use crate::prepare::Prepared;
use crate::view::Album;

pub(crate) use septet_workers::leader::Plan;

/// What a run leaves with the coordinator.
#[derive(Debug, Default)]
pub(crate) struct Collected {
    /// Pieces of a triangulation, in the order of their arrival.
    pub(crate) pieces: Vec<Loose>,
    /// Rows of cells, in the parts in which they arrived.
    pub(crate) cells: Vec<Vec<u64>>,
    pub(crate) owner: Vec<Rank>,
    pub(crate) leaves: Vec<u64>,
    pub(crate) edges: Vec<u64>,
    /// Members of an independent set, in the order of their arrival.
    pub(crate) members: Vec<u64>,
    /// Points undecided at the start of each of its rounds.
    pub(crate) undecided: Vec<u64>,
    pub(crate) ledger: LedgerPart,
    /// Workers whose part of the ledger has arrived.
    pub(crate) parts: u32,
    /// What the workers show of themselves.
    pub(crate) album: Album,
    pub(crate) merged: Merged,
    pub(crate) supergraph: Option<Supergraph>,
    pub(crate) why: Option<String>,
    /// What leaves had to say to each other, if recorded.
    pub(crate) tasks: Option<Box<TaskLog>>,
    /// Number of points gathered when the exchange was cut short.
    pub(crate) fallback: Option<(String, u64)>,
    /// Wall-clock seconds of each phase, measured here.
    pub(crate) seconds: Vec<(Phase, f64)>,
}

/// Vertices, number of points around each, and the points.
type Neighbourhoods<P> = (Vec<u64>, Vec<u32>, PointBatch<P>);

/// The coordinator's state.
pub(crate) struct Coordinator<'a, P: Point> {
    config: &'a Config,
    machine: Arc<WorkerConfig>,
    leader: Leader<P>,
    out: Outbox<P>,
    phase: Phase,
    known: Known,
    population: u64,
    samples: (u32, Vec<u64>),
    gathered: (u32, PointBatch<P>),
    certificates: u32,
    result: Collected,
}

impl<'a, P: Point> Coordinator<'a, P> {
    pub(crate) fn new(config: &'a Config, machine: Arc<WorkerConfig>) -> Self {
        let supergraph = match machine.wanted {
            Wanted::Fixed(supergraph) => Some(supergraph),
            _ => None,
        };
        Coordinator {
            config,
            out: Outbox::new(machine.run, COORDINATOR),
            machine,
            leader: Leader::default(),
            phase: Phase::Load,
            known: Known { supergraph, outcome: Outcome::Passed, level: 0 },
            population: 0,
            samples: (0, Vec::new()),
            gathered: (0, PointBatch::default()),
            certificates: 0,
            result: Collected::default(),
        }
    }

    /// Runs the machine to its end: rank 0, and the clock of the phases.
    pub(crate) fn run(
        self,
        transport: &mut dyn Transport<P>,
        points: &Prepared<'_, P>,
        plan: &Plan,
    ) -> Result<Collected, Error> {
        let (config, machine) = (self.config, self.machine.clone());
        let _run = run_span(&machine, points.positions.len() as u64);
        let cancelled = || config.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed));
        let failure = |error| match error {
            TransportError::Stopped if cancelled() => Error::Interrupted,
            error => error.into(),
        };
        let program = |cx| self.coordinate(cx, points, plan);
        let mut rank = Running::start(COORDINATOR, machine.clone(), None, program);
        let mut span = phase_span(machine.run, rank.phase());
        let mut outbox = rank.step().map_err(failure)?;
        let (mut round, mut started, mut seconds) = (0, Instant::now(), Vec::new());
        while !rank.is_done() {
            let delivery = transport.exchange(outbox, rank.busy()).map_err(failure)?;
            if cancelled() {
                return Err(Error::Interrupted);
            }
            round += 1;
            if !delivery.active {
                time(&mut seconds, rank.phase(), started.elapsed().as_secs_f64());
                started = Instant::now();
            }
            rank.deliver(round, delivery.active.then_some(delivery.inbox));
            outbox = rank.step().map_err(failure)?;
            if !delivery.active {
                drop(span);
                span = phase_span(machine.run, rank.phase());
            }
            if let Some(progress) = &config.progress {
                let position = (rank.phase() as usize, Phase::ALL.len() - 1);
                progress(Progress { phase: rank.phase().name(), position, round });
            }
        }
        let mut collected = rank.into_result().unwrap_or_default();
        collected.seconds = seconds;
        Ok(collected)
    }

    /// What rank 0 runs.
    async fn coordinate(
        mut self,
        mut cx: Context<P>,
        points: &Prepared<'_, P>,
        plan: &Plan,
    ) -> Result<Collected, TransportError> {
        cx.enter(Phase::Load)?;
        self.load(&mut cx, points);
        while cx.exchange().await? {}
        let led = partition::lead_root(&mut cx, self.population, plan.clone()).await?;
        for root in &led {
            self.leader.lead(root.node, root.child.population, root.child.first, root.child.ranks);
        }
        self.phase = Phase::Partition;
        loop {
            let phase = next(self.phase, &self.machine, &self.known);
            self.known.enter(self.phase, phase, &self.machine);
            self.phase = phase;
            match phase {
                Phase::Done => break,
                Phase::Summaries => summaries::lead_root(&mut cx, &led).await?,
                Phase::Sets => {
                    let Some(supergraph) = self.known.supergraph else {
                        let reason = "no supergraph was chosen before the separator sets".to_string();
                        return Err(TransportError::WorkerFailed { rank: COORDINATOR, reason });
                    };
                    sharing::lead_root(&mut cx, &led, supergraph).await?;
                }
                Phase::Halo => {
                    cx.enter(phase)?;
                    let mut known = PointBatch::default();
                    while cx.exchange().await? {
                        frame::collect(&mut cx, &mut known);
                    }
                }
                phase => {
                    cx.enter(phase)?;
                    self.gathered = (0, PointBatch::default());
                    while cx.exchange().await? {
                        let (out, _, inbox) = cx.parts();
                        std::mem::swap(&mut self.out, out);
                        let mut inbox = std::mem::take(inbox);
                        self.step(&mut inbox)?;
                        let (out, _, rest) = cx.parts();
                        std::mem::swap(&mut self.out, out);
                        *rest = inbox;
                    }
                }
            }
        }
        cx.enter(Phase::Done)?;
        self.result.ledger.merge(cx.parts().1);
        self.result.supergraph = self.known.supergraph;
        Ok(self.result)
    }

    fn cancelled(&self) -> bool {
        self.config.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed))
    }

    /// Blocks of the input in its order, one a worker.
    fn load(&mut self, cx: &mut Context<P>, points: &Prepared<'_, P>) {
        let workers = self.machine.workers;
        self.population = points.positions.len() as u64;
        let mut frame = PointBatch::default();
        for &i in &points.frame {
            frame.push(points.id(i), points.positions[i], COORDINATOR, f64::INFINITY);
        }
        let n = points.positions.len();
        let share = |r: u32| (n as u128 * u128::from(r) / u128::from(workers)) as usize;
        let block = |rank: u32| {
            let range = share(rank - 1)..share(rank);
            // With a little room: about as many points as a worker is sent come home to it, and then those near its border.
            let room = range.len() + range.len() / 8;
            let (mut ids, mut positions) = (Vec::with_capacity(room), Vec::with_capacity(room));
            ids.extend(points.ids(range.clone()));
            positions.extend_from_slice(&points.positions[range.clone()]);
            let radii2 = points.radii2.get(range).unwrap_or_default().to_vec();
            PointBatch { radii2: Bulk(radii2), ..PointBatch::homeless(ids, positions) }
        };
        let blocks: Vec<PointBatch<P>> = (1..workers + 1).into_par_iter().map(block).collect();
        for (rank, block) in (1..).zip(blocks) {
            let start = Body::Start { population: self.population, frame: frame.clone() };
            cx.send(rank, NodeId::ROOT, 0, start);
            cx.send(rank, NodeId::ROOT, 0, Body::Block(block));
        }
    }

    fn broadcast(&mut self, body: &Body<P>) {
        for rank in 1..=self.machine.workers {
            self.out.send(rank, NodeId::ROOT, 0, body.clone());
        }
    }

    /// Handles a round's messages.
    fn step(&mut self, inbox: &mut Vec<Message<P>>) -> Result<(), TransportError> {
        match self.phase {
            Phase::Choice => self.on_samples(inbox),
            Phase::Merge => self.on_merged(inbox),
            Phase::Fallback => self.on_gathered(inbox),
            Phase::Graph | Phase::Collect => self.on_collected(inbox)?,
            _ => {}
        }
        Ok(())
    }

    /// Sums the sampled stars; decides when all workers have reported.
    fn on_samples(&mut self, inbox: &mut Vec<Message<P>>) {
        let (reports, sums) = &mut self.samples;
        inbox.retain(|m| match &m.body {
            Body::SampleStars(counts) => {
                *reports += 1;
                sums.resize(counts.len().max(sums.len()), 0);
                for (sum, count) in sums.iter_mut().zip(&counts.0) {
                    *sum += count;
                }
                false
            }
            _ => true,
        });
        if *reports == self.machine.workers {
            *reports = 0;
            let (supergraph, why) = choose(self.machine.wanted, sums[0], &sums[1..], self.population);
            self.known.supergraph = Some(supergraph);
            self.result.why = Some(why);
            let (kind, parameter) = encode_choice(supergraph);
            self.broadcast(&Body::Choice { kind, parameter });
        }
    }

    /// Joins the root's children; judges the certificate.
    fn on_merged(&mut self, inbox: &mut Vec<Message<P>>) {
        let phase = if self.certificates > 0 { Phase::Certificate } else { Phase::Merge };
        let below = by_node(inbox, |m| match m.body {
            Body::Merged(merged) => Some((m.round, merged)),
            _ => None,
        });
        for (child, all) in below {
            for (round, merged) in all {
                let whole = if child == NodeId::ROOT {
                    Some(merged)
                } else {
                    let ledger = &mut self.result.ledger;
                    let joined = self.leader.on_merged(child, merged, phase, self.out.site(), ledger);
                    joined.map(|(_, all)| {
                        ledger.tally(round, Phase::Merge).merged += 1;
                        all
                    })
                };
                if let Some(whole) = whole {
                    self.judge(whole);
                }
            }
        }
    }

    fn judge(&mut self, merged: Merged) {
        let passed = merged.stars == self.population && merged.disagreements == 0 && merged.minima == 1;
        self.known.outcome = match (passed, self.certificates) {
            (true, _) => Outcome::Passed,
            (false, 0) => Outcome::GatherUnresolved,
            (false, 1) => Outcome::GatherAll,
            _ => Outcome::Failed,
        };
        self.certificates += 1;
        let rounds = self.result.merged.exchange_rounds + merged.exchange_rounds;
        self.result.merged = Merged { exchange_rounds: rounds, ..merged };
        let body = Body::Outcome(self.known.outcome.number());
        self.broadcast(&body);
    }

    /// Triangulates what was gathered and returns to every unresolved star its neighbours in it.
    fn on_gathered(&mut self, inbox: &mut Vec<Message<P>>) {
        let (reports, region) = &mut self.gathered;
        inbox.retain_mut(|m| match &mut m.body {
            Body::Gather(points) => {
                *reports += 1;
                region.ids.append(&mut points.ids);
                region.positions.append(&mut points.positions);
                region.owners.append(&mut points.owners);
                region.radii2.append(&mut points.radii2);
                false
            }
            _ => true,
        });
        if *reports == self.machine.workers {
            *reports = 0;
            let region = std::mem::take(region);
            self.answer_region(&region);
        }
    }

    fn answer_region(&mut self, region: &PointBatch<P>) {
        // A point gathered twice counts once; it is wanted if either copy is.
        let mut places: BTreeMap<u64, (usize, bool)> = BTreeMap::new();
        for i in 0..region.len() {
            let entry = places.entry(region.ids[i]).or_insert((i, false));
            entry.1 |= region.radii2[i] > 0.0;
        }
        let members: Vec<(usize, bool)> = places.into_values().collect();
        let n = members.len() as u64;
        let reason = match self.known.outcome {
            Outcome::GatherAll => "the whole set was triangulated at once",
            _ => "unresolved stars were gathered and triangulated at once",
        };
        let previous = self.result.fallback.as_ref().map_or(0, |f| f.1);
        self.result.fallback = Some((reason.to_string(), n.max(previous)));
        let points: Vec<P> = members.iter().map(|&(i, _)| region.positions[i]).collect();
        let order = insertion_order(&points);
        let built = Incremental::build_while(points, Some(&order), &mut || !self.cancelled());
        let Ok(delaunay) = built else { return };
        let mut batches: BTreeMap<Rank, Neighbourhoods<P>> = BTreeMap::new();
        let mut link: Vec<P::Facet> = Vec::new();
        for (vertex, &(i, wanted)) in (0u32..).zip(&members) {
            if !wanted {
                continue;
            }
            delaunay.link_of(vertex, &mut link);
            let mut around: Vec<u32> = link.iter().flat_map(AsRef::as_ref).copied().collect();
            around.sort_unstable();
            around.dedup();
            around.retain(|&v| v != INFINITE);
            let (vertices, counts, batch) = batches.entry(region.owners[i]).or_default();
            vertices.push(region.ids[i]);
            counts.push(around.len() as u32);
            for v in around {
                let j = members[v as usize].0;
                batch.push(region.ids[j], region.positions[j], region.owners[j], f64::INFINITY);
            }
        }
        for (rank, (vertices, counts, points)) in batches {
            let body = Body::Region { vertices: Bulk(vertices), counts: Bulk(counts), points };
            self.out.send(rank, NodeId::ROOT, 0, body);
        }
    }

    fn on_collected(&mut self, inbox: &mut Vec<Message<P>>) -> Result<(), TransportError> {
        let keep_owner = self.config.with_owner;
        let mut torn = None;
        for message in std::mem::take(inbox) {
            match message.body {
                Body::Cells { cells, mut leaves } => {
                    if keep_owner {
                        let rows = cells.len() / (P::DIM + 1);
                        self.result.owner.extend(std::iter::repeat_n(message.from, rows));
                        self.result.leaves.append(&mut leaves);
                    }
                    self.result.cells.push(cells.0);
                }
                Body::Piece { leaf, ids: Bulk(ids), rows: Bulk(rows), open: Bulk(open) } => {
                    let (owner, seam) = (message.from, Vec::new());
                    self.result.pieces.push(Loose { piece: Piece { owner, leaf, ids, rows, seam }, open });
                }
                Body::Selected { mut members, undecided } => {
                    self.result.members.append(&mut members);
                    let sums = &mut self.result.undecided;
                    sums.resize(sums.len().max(undecided.len()), 0);
                    sums.iter_mut().zip(&undecided.0).for_each(|(sum, count)| *sum += count);
                }
                Body::Edges(mut edges) => self.result.edges.append(&mut edges),
                Body::Tasks(log) => self.result.tasks = Some(log),
                Body::View(part) if part.is_consistent() => self.result.album.add(&part),
                Body::Ledger(words) => match LedgerPart::from_words(&words) {
                    Some(part) => {
                        self.result.ledger.merge(&part);
                        self.result.parts += 1;
                    }
                    None => torn = Some(message.from),
                },
                body => inbox.push(Message { body, ..message }),
            }
        }
        match torn {
            None => Ok(()),
            Some(from) => {
                let reason = "its ledger is torn".to_string();
                Err(TransportError::BadMessage { from, reason })
            }
        }
    }
}

/// Seconds of a phase; of one that runs in several passes, all of them.
fn time(all: &mut Vec<(Phase, f64)>, phase: Phase, seconds: f64) {
    match all.last_mut() {
        Some((last, sum)) if *last == phase => *sum += seconds,
        _ => all.push((phase, seconds)),
    }
}
