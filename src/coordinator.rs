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
use septet_workers::config::{SetRule, Wanted, WorkerConfig};
use septet_workers::leader::{Leader, by_node, is_leaf};
use septet_workers::outbox::Outbox;
use septet_workers::partition::lead_partition;
use septet_workers::profile::{phase_span, received, run_span};
use septet_workers::schedule::{Known, Outcome, next};

use crate::config::{Config, Progress};
use crate::error::Error;
use crate::pieces::{Loose, Piece};
use crate::prepare::Prepared;
use crate::view::Album;

/// Leaves below every node of a planned tree.
pub(crate) type Plan = BTreeMap<NodeId, u32>;

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
    frame: PointBatch<P>,
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
            frame: PointBatch::default(),
            samples: (0, Vec::new()),
            gathered: (0, PointBatch::default()),
            certificates: 0,
            result: Collected::default(),
        }
    }

    /// Runs the machine to its end.
    pub(crate) fn run(
        mut self,
        transport: &mut dyn Transport<P>,
        points: &Prepared<'_, P>,
        plan: &Plan,
    ) -> Result<Collected, Error> {
        let _run = run_span(&self.machine, points.positions.len() as u64);
        let mut phase = phase_span(self.machine.run, self.phase);
        let mut outbox = self.load(points, plan);
        let mut round = 0;
        let mut started = Instant::now();
        while self.phase != Phase::Done {
            let delivery = match transport.exchange(outbox, self.out.has_own()) {
                Err(TransportError::Stopped) if self.cancelled() => return Err(Error::Interrupted),
                delivery => delivery?,
            };
            round += 1;
            self.out.set_round(round);
            if self.cancelled() {
                return Err(Error::Interrupted);
            }
            if delivery.active {
                outbox = self.step(delivery.inbox)?;
            } else {
                self.time(started.elapsed().as_secs_f64());
                started = Instant::now();
                let begun = next(self.phase, &self.machine, &self.known);
                self.known.enter(self.phase, begun, &self.machine);
                self.phase = begun;
                drop(phase);
                phase = phase_span(self.machine.run, self.phase);
                outbox = self.begin();
            }
            self.tell(round);
        }
        self.result.supergraph = self.known.supergraph;
        Ok(self.result)
    }

    fn cancelled(&self) -> bool {
        self.config.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed))
    }

    /// Seconds of a phase; of one that runs in several passes, all of them.
    fn time(&mut self, seconds: f64) {
        match self.result.seconds.last_mut() {
            Some((phase, sum)) if *phase == self.phase => *sum += seconds,
            _ => self.result.seconds.push((self.phase, seconds)),
        }
    }

    fn tell(&self, round: u32) {
        if let Some(progress) = &self.config.progress {
            let position = (self.phase as usize, Phase::ALL.len() - 1);
            progress(Progress { phase: self.phase.name(), position, round });
        }
    }

    /// Blocks of the input in its order, one a worker; and to the root's leader the root.
    fn load(&mut self, points: &Prepared<'_, P>, plan: &Plan) -> Vec<Message<P>> {
        let _span = self.out.site().round(self.phase, None);
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
            self.out.send(rank, NodeId::ROOT, 0, start);
            self.out.send(rank, NodeId::ROOT, 0, Body::Block(block));
        }
        if workers > 1 && !is_leaf(&self.machine, NodeId::ROOT, self.population) {
            let (nodes, leaves): (Vec<u64>, Vec<u32>) = plan.iter().map(|(n, l)| (n.0, *l)).unzip();
            self.leader.plan(&nodes, &leaves);
            self.leader.lead(NodeId::ROOT, self.population, 1, workers);
        }
        self.out.take(self.phase, &mut self.result.ledger)
    }

    fn begin(&mut self) -> Vec<Message<P>> {
        let _span = self.out.site().round(self.phase, None);
        if self.phase == Phase::Fallback {
            self.gathered = (0, PointBatch::default());
        }
        self.out.take(self.phase, &mut self.result.ledger)
    }

    fn broadcast(&mut self, body: &Body<P>) {
        for rank in 1..=self.machine.workers {
            self.out.send(rank, NodeId::ROOT, 0, body.clone());
        }
    }

    /// Handles a round's messages; returns what it sends.
    fn step(&mut self, mut inbox: Vec<Message<P>>) -> Result<Vec<Message<P>>, Error> {
        let _span = self.out.site().round(self.phase, Some(inbox.len()));
        received(self.phase, &inbox);
        inbox.extend(self.out.take_own());
        inbox.sort_by_key(|m| (m.from, m.sequence));
        inbox.dedup_by_key(|m| (m.from, m.sequence));
        if matches!(self.phase, Phase::Summaries | Phase::Halo) {
            self.on_frame(&mut inbox);
        }
        let ledger = &mut self.result.ledger;
        match self.phase {
            Phase::Partition => {
                let (leader, out) = (&mut self.leader, &mut self.out);
                lead_partition(&mut inbox, leader, &self.machine, out, ledger, self.phase);
            }
            Phase::Summaries => {
                let below = by_node(&mut inbox, |m| match &m.body {
                    Body::Summary(summary) => Some(summary.clone()),
                    _ => None,
                });
                for (child, summary) in
                    below.into_iter().flat_map(|(c, s)| s.into_iter().map(move |s| (c, s)))
                {
                    self.leader.on_summary(child, summary, &mut self.out, ledger);
                }
            }
            Phase::Sets => {
                let counts = by_node(&mut inbox, |m| match &mut m.body {
                    Body::SetCounts(c) => Some(std::mem::take(&mut c.0)),
                    _ => None,
                });
                let density = matches!(self.known.supergraph, Some(Supergraph::Density { .. }));
                let smaller = self.machine.sets == SetRule::Smaller;
                let rule = if smaller && !density { SetRule::Both } else { self.machine.sets };
                for (node, all) in counts {
                    self.leader.on_set_counts(node, &all, rule, &mut self.out);
                }
            }
            Phase::Choice => self.on_samples(&mut inbox),
            Phase::Merge => self.on_merged(&mut inbox),
            Phase::Fallback => self.on_gathered(&mut inbox),
            Phase::Graph | Phase::Collect => self.on_collected(&mut inbox)?,
            _ => {}
        }
        match inbox.first() {
            None => Ok(self.out.take(self.phase, &mut self.result.ledger)),
            Some(message) => Err(TransportError::BadMessage {
                from: message.from,
                reason: format!("it has no place at the coordinator in phase {}", self.phase.name()),
            }
            .into()),
        }
    }

    /// Collects where the frame's points are at home; tells all when it knows.
    fn on_frame(&mut self, inbox: &mut Vec<Message<P>>) {
        let frame = &mut self.frame;
        let before = frame.len();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Frame(homes) => {
                frame.ids.append(&mut homes.ids);
                frame.positions.append(&mut homes.positions);
                frame.owners.append(&mut homes.owners);
                frame.radii2.append(&mut homes.radii2);
                false
            }
            _ => true,
        });
        if before <= P::DIM && frame.len() == P::DIM + 1 {
            let body = Body::Frame(frame.clone());
            self.broadcast(&body);
        }
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

    fn on_collected(&mut self, inbox: &mut Vec<Message<P>>) -> Result<(), Error> {
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
                Err(TransportError::BadMessage { from, reason }.into())
            }
        }
    }
}
