//! A worker: its state, and what it does with a round's messages.

use std::sync::Arc;

use septet_geometry::complex::INFINITE;
use septet_geometry::graph::Supergraph;
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, Simplex};
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Child, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::{Correction, Pool, SetRule, Task, Wanted, WorkerConfig};
use crate::direct::halo::{Halo, halo};
use crate::direct::interface::{insert, interface};
use crate::direct::piece::triangulate_piece;
use crate::graph::independent::{Selection, independent};
use crate::graph::sets::SetEngine;
use crate::graph::summaries::summaries;
use crate::machine::context::Context;
use crate::machine::outbox::Outbox;
use crate::machine::profile::received;
use crate::neighbours::query::Engine;
use crate::partition::leader::Leader;
use crate::partition::shared::{Input, load, partition};
use crate::schedule::{Known, Outcome, next};
use crate::splaying::exchange::Exchange;
use crate::stars::check::Agreement;
use crate::stars::hulls::Stars;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tasks::Recorder;

/// What a worker runs: the first phases as functions, then those that are still methods of [`Worker`].
pub(crate) async fn work<P: Point>(mut cx: Context<P>) -> Result<(), TransportError> {
    let mut worker = Worker::new(cx.rank, cx.config.clone(), cx.pool.clone());
    let Input { population, mut frame, block } = load(&mut cx).await?;
    let (mut subdomain, mut table) = partition(&mut cx, population, block).await?;
    worker.phase = Phase::Partition;
    if worker.next_phase() == Phase::Halo {
        let Halo { margins, arrived } = halo(&mut cx, &subdomain, &mut table, &mut frame).await?;
        let piece = triangulate_piece(&mut cx, &mut subdomain, &mut table, arrived, &frame).await?;
        let arrived = interface(&mut cx, &subdomain, &mut table, piece.as_ref(), margins).await?;
        worker.stars.set_piece(insert(&mut cx, &mut subdomain, &table, piece, arrived).await?);
        worker.phase = Phase::Hulls;
    }
    (worker.population, worker.frame, worker.table) = (population, frame, table);
    worker.settle(subdomain);
    loop {
        match next(worker.phase, &worker.config, &worker.known) {
            Phase::Done => return Ok(()),
            Phase::Summaries => {
                worker.swap(&mut cx);
                if worker.phase == Phase::Choice {
                    worker.land(Phase::Choice);
                }
                worker.shrink(Phase::Neighbours);
                worker.swap(&mut cx);
                let Worker { subdomain, table, frame, .. } = &mut worker;
                summaries(&mut cx, subdomain, table, frame).await?;
                worker.phase = Phase::Summaries;
            }
            Phase::Independent => {
                let Task::Independent { fixed } = cx.config.task else { return Ok(()) };
                let graphs = std::mem::take(&mut worker.selection.graphs);
                worker.selection =
                    independent(&mut cx, &worker.subdomain.leaves, &worker.table, graphs, fixed).await?;
                worker.phase = Phase::Independent;
            }
            phase => worker.run(&mut cx, phase).await?,
        }
    }
}

impl<P: Point> Worker<P> {
    /// Runs one phase that is not a function yet.
    async fn run(&mut self, cx: &mut Context<P>, phase: Phase) -> Result<(), TransportError> {
        cx.close();
        cx.note(phase);
        self.swap(cx);
        let mut sent = self.begin(phase, self.out.round())?;
        loop {
            let (round, inbox) = cx.pass(sent, self.busy()).await;
            self.out.set_round(round);
            let Some(inbox) = inbox else { break };
            sent = self.step(round, inbox)?;
        }
        self.swap(cx);
        Ok(())
    }
}

/// One worker of the machine. Pure: what it does depends on its messages and its parameters alone.
pub struct Worker<P: Point> {
    pub(crate) rank: Rank,
    pub(crate) config: Arc<WorkerConfig>,
    pub(crate) pool: Pool,
    pub(crate) out: Outbox<P>,
    pub(crate) ledger: LedgerPart,
    pub(crate) phase: Phase,
    pub(crate) known: Known,
    /// Steps since the phase began.
    pub(crate) step: u32,
    pub(crate) population: u64,
    pub(crate) frame: PointBatch<P>,
    pub(crate) leader: Leader<P>,
    pub(crate) subdomain: Subdomain<P>,
    pub(crate) table: Table<P>,
    pub(crate) engine: Engine<P>,
    pub(crate) sets: SetEngine,
    /// Graph neighbours of home points, where they are kept as lists.
    pub(crate) adjacency: Lists<u32>,
    pub(crate) selection: Selection,
    pub(crate) stars: Stars<P>,
    pub(crate) agreement: Agreement,
    pub(crate) exchange: Exchange<P>,
    /// What leaves have to say to each other, if asked for.
    pub(crate) recorder: Option<Box<Recorder>>,
}

impl<P: Point> Worker<P> {
    /// A worker with no points yet.
    pub(crate) fn new(rank: Rank, config: Arc<WorkerConfig>, pool: Pool) -> Self {
        let known = Known {
            supergraph: match config.wanted {
                Wanted::Fixed(supergraph) => Some(supergraph),
                _ => None,
            },
            outcome: Outcome::Passed,
            level: 0,
        };
        Worker {
            rank,
            out: Outbox::new(config.run, rank),
            config,
            pool,
            ledger: LedgerPart::default(),
            phase: Phase::Load,
            known,
            step: 0,
            population: 0,
            frame: PointBatch::default(),
            leader: Leader::default(),
            subdomain: Subdomain::default(),
            table: Table::default(),
            engine: Engine::default(),
            sets: SetEngine::default(),
            adjacency: Lists::default(),
            selection: Selection::default(),
            stars: Stars::default(),
            agreement: Agreement::default(),
            exchange: Exchange::default(),
            recorder: None,
        }
    }

    /// Has it more to do although no message is on its way to it?
    pub fn busy(&self) -> bool {
        // What a gathering brings is used when the exchange begins again: no reason to wait before.
        let exchanging = self.phase == Phase::Repair && self.exchange.is_pending();
        self.out.has_own() || exchanging || self.sets.is_pending()
    }

    /// Begins a phase (the one before moved nothing any more). Returns what it sends.
    ///
    /// # Errors
    /// If it was told to stop, or by a planted fault.
    pub fn begin(&mut self, phase: Phase, round: u32) -> Result<Vec<Message<P>>, TransportError> {
        self.out.set_round(round);
        self.known.enter(self.phase, phase, &self.config);
        let _span = self.out.site().round(phase, None);
        if self.phase == Phase::Choice {
            self.land(Phase::Choice);
        }
        self.phase = phase;
        self.step = 0;
        if let Some(fault) = self.config.fault {
            fault.strike(self.rank, phase)?;
        }
        match phase {
            Phase::Load
            | Phase::Partition
            | Phase::Halo
            | Phase::Summaries
            | Phase::Independent
            | Phase::Pieces
            | Phase::Seam
            | Phase::Done => {}
            Phase::Radii => self.begin_radii(),
            Phase::Probe => self.begin_probe(),
            Phase::Neighbours if self.config.correction == Correction::Naive => self.begin_correction(),
            Phase::Neighbours => self.begin_neighbours(),
            Phase::Choice => self.begin_choice(),
            Phase::KnnRadii => self.begin_knn_radii(),
            Phase::KnnProbe => self.begin_knn_probe(),
            Phase::Knn => self.begin_knn(),
            Phase::Sets => self.begin_sets(),
            Phase::Graph if self.config.task != Task::Delaunay => self.begin_conflicts(),
            Phase::Graph => self.begin_graph(),
            Phase::Hulls => self.begin_hulls(),
            Phase::Check => self.begin_check(),
            Phase::Certificate => self.begin_certificate(),
            Phase::Repair => self.begin_repair(),
            Phase::Fallback => self.begin_fallback(),
            Phase::Merge => self.begin_merge(),
            Phase::Collect => self.begin_collect(),
        }
        self.config.stop.check()?;
        Ok(self.out.take(self.phase, &mut self.ledger))
    }

    /// Handles a round's messages, in whatever order they came, and returns what it sends.
    ///
    /// # Errors
    /// A message that does not belong to this run, or to the phase; or if it was told to stop.
    pub fn step(
        &mut self,
        round: u32,
        mut inbox: Vec<Message<P>>,
    ) -> Result<Vec<Message<P>>, TransportError> {
        self.out.set_round(round);
        let _span = self.out.site().round(self.phase, Some(inbox.len()));
        received(self.phase, &inbox);
        self.step += 1;
        inbox.extend(self.out.take_own());
        inbox.sort_by_key(|m| (m.from, m.sequence));
        inbox.dedup_by_key(|m| (m.from, m.sequence));
        for message in &inbox {
            if message.run != self.config.run || message.to != self.rank {
                return Err(Self::bad(message, "it belongs to another run or rank"));
            }
        }
        match self.phase {
            Phase::Probe | Phase::Neighbours | Phase::KnnProbe | Phase::Choice | Phase::Knn => {
                self.on_queries(&mut inbox)?;
                self.on_choice(&mut inbox);
            }
            Phase::Sets => {
                self.on_ghosts(&mut inbox);
                self.on_reverse(&mut inbox);
                self.on_sets(&mut inbox);
            }
            Phase::Check | Phase::Certificate => self.on_check(&mut inbox),
            Phase::Repair => self.on_repair(&mut inbox),
            Phase::Fallback => self.on_fallback(&mut inbox),
            Phase::Merge => self.on_merge(&mut inbox),
            Phase::Collect => self.on_collect(&mut inbox),
            Phase::Load
            | Phase::Partition
            | Phase::Halo
            | Phase::Summaries
            | Phase::Independent
            | Phase::Pieces
            | Phase::Seam
            | Phase::Radii
            | Phase::KnnRadii
            | Phase::Graph
            | Phase::Hulls
            | Phase::Done => {}
        }
        if let Some(message) = inbox.first() {
            let fits = message.body.is_consistent();
            let why = if fits { "it has no place" } else { "its arrays do not fit together" };
            return Err(Self::bad(message, &format!("{why} in phase {}", self.phase.name())));
        }
        self.config.stop.check()?;
        Ok(self.out.take(self.phase, &mut self.ledger))
    }

    fn bad(message: &Message<P>, why: &str) -> TransportError {
        TransportError::BadMessage { from: message.from, reason: why.to_string() }
    }

    /// What the functions of the first phases leave.
    fn settle(&mut self, subdomain: Subdomain<P>) {
        for group in &subdomain.led {
            let Child { population, first, ranks, .. } = group.child;
            self.leader.lead(group.node, population, first, ranks);
        }
        self.subdomain = subdomain;
    }

    /// Takes what every phase needs of the machine from the context, or gives it back.
    fn swap(&mut self, cx: &mut Context<P>) {
        std::mem::swap(&mut self.out, &mut cx.out);
        std::mem::swap(&mut self.ledger, &mut cx.ledger);
        std::mem::swap(&mut self.recorder, &mut cx.recorder);
    }

    /// The supergraph; a density graph until one is chosen.
    pub(crate) fn supergraph(&self) -> Supergraph {
        self.known.supergraph.unwrap_or(Supergraph::Density { alpha: 2.5 })
    }

    /// The separator-set rule: one side's points suffice for the density graph only, so where the choice
    /// fell on nearest neighbours both sides are taken.
    pub(crate) fn set_rule(&self) -> SetRule {
        match (self.config.sets, self.supergraph()) {
            (SetRule::Smaller, Supergraph::Knn { .. } | Supergraph::Overlap { .. }) => SetRule::Both,
            (rule, _) => rule,
        }
    }
}

/// The vertices of a cell `(centre, facet)`, or `None` if it is infinite.
pub(crate) fn finite_cell<P: Point>(centre: u32, facet: &P::Facet) -> Option<P::Cell> {
    let mut cell = P::Cell::splat(centre);
    for (slot, &v) in facet.as_ref().iter().enumerate() {
        if v == INFINITE {
            return None;
        }
        cell.as_mut()[slot + 1] = v;
    }
    Some(cell)
}
