//! The machine as a rank sees it: one future per rank, one exchange per round.
//!
//! A rank is an `async fn`. It computes, queues messages (`machine::collectives`), and awaits [`Context::exchange`].
//! The exchange delivers the messages of the round. If no rank sent a message, the exchange returns `false`, and the
//! phase is over on all ranks. A host polls its ranks in turn, and each runs until its next exchange. There is no
//! other executor and no waker.

use std::cell::RefCell;
use std::future::{Future, poll_fn};
use std::panic::{self, AssertUnwindSafe};
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::task::{self, Poll, Waker};

use septet_geometry::cost::Cost;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::ledger::{Account, LedgerPart, NodeFacts, RankKey, RoundKey, RoundTally};
use septet_protocol::message::{Body, Message};
use septet_protocol::transport::TransportError;
use tracing::span::EnteredSpan;

use crate::config::{ChargeRecord, Pool, WorkerConfig, map_in};
use crate::machine::flips::Flips;
use crate::machine::outbox::Outbox;
use crate::machine::profile::{Site, received};

/// A round that ended: its number and the messages to this rank, or `None` if the phase is over.
type Round<P> = (u32, Option<Vec<Message<P>>>);

/// The values that a rank and its host exchange.
struct Mailbox<P> {
    sent: Vec<Message<P>>,
    busy: bool,
    phase: Phase,
    round: Option<Round<P>>,
}

/// The machine as the phases of a rank use it. It holds no data of any phase.
pub struct Context<P: Point> {
    rank: Rank,
    config: Arc<WorkerConfig>,
    pool: Pool,
    ledger: LedgerPart,
    /// The record of the charges, if the run keeps it.
    charges: Vec<ChargeRecord>,
    out: Outbox<P>,
    /// The progress of planted flips.
    flips: Flips,
    phase: Phase,
    /// Messages of this round that the phase has not taken.
    inbox: Vec<Message<P>>,
    mailbox: Rc<RefCell<Mailbox<P>>>,
    /// The span of the work between two exchanges. Never entered while the rank waits.
    span: Option<EnteredSpan>,
}

impl<P: Point> Context<P> {
    /// Returns the rank.
    pub fn rank(&self) -> Rank {
        self.rank
    }

    /// Returns `true` if the rank is the coordinator.
    pub fn is_coordinator(&self) -> bool {
        self.rank == COORDINATOR
    }

    /// Returns the parameters of the run. Clone the [`Arc`] to use them while the context changes.
    pub fn config(&self) -> &Arc<WorkerConfig> {
        &self.config
    }

    /// Returns the rank's own cores, if it has any.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// Maps items in order, on the rank's own cores if it has any.
    pub fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        map_in(&self.pool, items, f)
    }

    /// Returns the current phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Returns the number of the current round, which every message carries.
    pub fn round(&self) -> u32 {
        self.out.round()
    }

    /// Returns an empty meter for a subproblem that a group may share. The ledger prices its scans over the items of the
    /// whole subproblem.
    pub fn shared_cost(&self) -> Cost {
        Cost::of_subproblem(self.config.cost_log.is_recording())
    }

    /// Returns an empty meter for a subproblem that always belongs to one rank, for example a leaf. Its scans run over
    /// the items of their calls.
    pub fn own_cost(&self) -> Cost {
        self.shared_cost().nested()
    }

    /// Charges an account of the ledger: a phase, a node and a role. The account keeps the largest number of `items`,
    /// the length of the scans of a shared meter. The ledger also counts the work for this rank and this round.
    pub fn charge(&mut self, account: Account, cost: Cost, items: u64) {
        self.ledger.charge(account, cost.price(), items);
        let key = RankKey { round: self.round(), phase: account.phase, rank: self.rank };
        self.ledger.rank(key).work += cost.work();
        if let Some(tape) = cost.into_tape().filter(|tape| !tape.is_empty()) {
            self.charges.push(ChargeRecord { account, round: self.round(), tape });
        }
    }

    /// Returns the facts of a node in the ledger, so that the caller can add to them.
    pub fn facts(&mut self, node: NodeId) -> &mut NodeFacts {
        self.ledger.facts(node)
    }

    /// Returns the tally of a round of the current phase in the ledger, so that the caller can add to it.
    pub fn tally(&mut self, round: u32) -> &mut RoundTally {
        self.ledger.tally(RoundKey { round, phase: self.phase })
    }

    /// Counts the points that this rank holds once the points of a round have arrived.
    pub fn record_load(&mut self, round: u32, points: usize) {
        let load = &mut self.tally(round).largest_load;
        *load = (*load).max(points as u64);
    }

    /// Adds the hash of some edges of the supergraph to the ledger.
    pub fn add_edge_hash(&mut self, hash: u64) {
        self.ledger.edge_hash = self.ledger.edge_hash.wrapping_add(hash);
    }

    /// Files the record of the charges, if the run keeps it.
    pub(crate) fn file_charges(&mut self) {
        self.config.cost_log.file(self.rank, std::mem::take(&mut self.charges));
    }

    /// Returns the sum of the hashes of the messages that the rank has sent, minus that of the messages it has received.
    pub(crate) fn balance(&self) -> u64 {
        self.ledger.balance
    }

    /// Takes the ledger of the rank.
    pub(crate) fn take_ledger(&mut self) -> LedgerPart {
        std::mem::take(&mut self.ledger)
    }

    /// Returns the ledger of the rank, for changes by a planted fault.
    pub(crate) fn ledger_mut(&mut self) -> &mut LedgerPart {
        &mut self.ledger
    }

    /// Begins a phase.
    ///
    /// # Errors
    /// Fails if a planted fault strikes.
    #[inline(never)] // `bench/work-instructions` counts from entry to entry.
    pub fn enter(&mut self, phase: Phase) -> Result<(), TransportError> {
        self.phase = phase;
        self.span = None;
        self.span = Some(self.site().round(phase, None));
        self.mailbox.borrow_mut().phase = phase;
        self.config.fault.map_or(Ok(()), |fault| fault.strike(self.rank, phase))
    }

    /// Continues the round in another phase. Times of phases remain with the phase that the rank has entered.
    ///
    /// # Errors
    /// Fails if a planted fault strikes.
    pub fn switch(&mut self, phase: Phase) -> Result<(), TransportError> {
        self.phase = phase;
        self.config.fault.map_or(Ok(()), |fault| fault.strike(self.rank, phase))
    }

    /// Returns the run, the rank and the round.
    pub fn site(&self) -> Site {
        self.out.site()
    }

    /// Queues a message for this round.
    pub(super) fn send(&mut self, to: Rank, node: NodeId, attempt: u32, body: Body<P>) {
        self.out.send(to, node, attempt, body);
    }

    /// Ends the round. Returns `false` if no rank sent a message or had more to do, which ends the phase on all
    /// ranks.
    ///
    /// # Errors
    /// Fails if the phase did not take a message of the last round, if a message belongs to another run or rank, or
    /// if the run is interrupted.
    pub async fn exchange(&mut self) -> Result<bool, TransportError> {
        self.exchange_if(false).await
    }

    /// Ends the round like [`Context::exchange`]. If `pending` is `true`, this rank has more to do in the next round,
    /// even if it has not sent a message.
    ///
    /// # Errors
    /// See [`Context::exchange`].
    pub async fn exchange_if(&mut self, pending: bool) -> Result<bool, TransportError> {
        self.refuse_rest()?;
        self.config.stop.check()?;
        let mut sent = self.out.take(self.phase, &mut self.ledger);
        self.flips.strike(&self.config, &mut sent)?;
        self.span = None;
        let (round, inbox) = self.pass(sent, pending || self.out.has_own()).await;
        self.out.set_round(round);
        let Some(mut inbox) = inbox else { return Ok(false) };
        self.span = Some(self.site().round(self.phase, Some(inbox.len())));
        received(self.phase, &inbox);
        inbox.sort_by_key(|m| (m.from, m.sequence));
        inbox.dedup_by_key(|m| (m.from, m.sequence));
        for message in &inbox {
            self.ledger.balance = self.ledger.balance.wrapping_sub(message.content_hash());
        }
        inbox.extend(self.out.take_own());
        inbox.sort_by_key(|m| (m.from, m.sequence));
        if let Some(message) = inbox.iter().find(|m| m.run != self.config.run || m.to != self.rank) {
            return Err(bad(message, "it belongs to another run or rank".to_string()));
        }
        for message in &inbox {
            if let Some(defect) = message.body.defect(self.config.ranks()) {
                return Err(bad(message, defect.to_string()));
            }
        }
        self.inbox = inbox;
        Ok(true)
    }

    /// Ends a round of a dialogue, in which some rank must have sent a message.
    ///
    /// # Errors
    /// Fails if no rank has sent a message. See [`Context::exchange`] for other errors.
    pub async fn next_round(&mut self) -> Result<(), TransportError> {
        if self.exchange().await? {
            return Ok(());
        }
        let reason = format!("no rank sent a message in the middle of phase {}", self.phase.name());
        Err(TransportError::WorkerFailed { rank: self.rank, reason })
    }

    /// Ends a phase whose last round was a dialogue.
    ///
    /// # Errors
    /// Fails if a rank has sent a message. See [`Context::exchange`] for other errors.
    pub async fn end_phase(&mut self) -> Result<(), TransportError> {
        if !self.exchange().await? {
            return Ok(());
        }
        let reason = format!("a rank sent a message after the end of phase {}", self.phase.name());
        Err(TransportError::WorkerFailed { rank: self.rank, reason })
    }

    /// Takes the messages of a kind, in the order of their senders.
    pub fn take<T>(&mut self, mut kind: impl FnMut(&mut Message<P>) -> Option<T>) -> Vec<T> {
        let mut taken = Vec::new();
        self.inbox.retain_mut(|message| match kind(message) {
            Some(t) => {
                taken.push(t);
                false
            }
            None => true,
        });
        taken
    }

    /// Takes the only message of a kind.
    ///
    /// # Errors
    /// Fails if the number of messages of that kind is not one.
    pub fn take_one<T>(
        &mut self,
        kind: impl FnMut(&mut Message<P>) -> Option<T>,
    ) -> Result<T, TransportError> {
        let mut all = self.take(kind);
        let count = all.len();
        all.pop().filter(|_| count == 1).ok_or_else(|| TransportError::WorkerFailed {
            rank: self.rank,
            reason: format!("{count} messages instead of one in phase {}", self.phase.name()),
        })
    }

    /// Refuses the first message that no operation has taken.
    pub(super) fn refuse_rest(&self) -> Result<(), TransportError> {
        let Some(message) = self.inbox.first() else { return Ok(()) };
        let fits = message.body.is_consistent();
        let why = if fits { "it has no place" } else { "its arrays do not fit together" };
        Err(bad(message, format!("{why} in phase {}", self.phase.name())))
    }

    /// Passes the messages to the host, and waits for the round.
    async fn pass(&mut self, sent: Vec<Message<P>>, busy: bool) -> Round<P> {
        {
            let mut mailbox = self.mailbox.borrow_mut();
            (mailbox.sent, mailbox.busy) = (sent, busy);
        }
        poll_fn(|_| self.mailbox.borrow_mut().round.take().map_or(Poll::Pending, Poll::Ready)).await
    }
}

fn bad<P>(message: &Message<P>, reason: String) -> TransportError {
    TransportError::BadMessage { from: message.from, reason }
}

/// A rank, as its host runs it.
pub struct Running<'a, P, T = ()> {
    rank: Rank,
    mailbox: Rc<RefCell<Mailbox<P>>>,
    program: Pin<Box<dyn Future<Output = Result<T, TransportError>> + 'a>>,
    result: Option<T>,
}

impl<'a, P: Point, T> Running<'a, P, T> {
    /// Creates a rank. [`Running::step`] runs it until its first exchange.
    pub fn start<F>(
        rank: Rank,
        config: Arc<WorkerConfig>,
        pool: Pool,
        program: impl FnOnce(Context<P>) -> F,
    ) -> Self
    where
        F: Future<Output = Result<T, TransportError>> + 'a,
    {
        let mailbox = Mailbox { sent: Vec::new(), busy: false, phase: Phase::Load, round: None };
        let mailbox = Rc::new(RefCell::new(mailbox));
        let context = Context {
            rank,
            out: Outbox::new(config.run, rank),
            flips: Flips::default(),
            config,
            pool,
            ledger: LedgerPart::default(),
            charges: Vec::new(),
            phase: Phase::Load,
            inbox: Vec::new(),
            mailbox: mailbox.clone(),
            span: None,
        };
        Running { rank, mailbox, program: Box::pin(program(context)), result: None }
    }

    /// Returns the rank.
    pub fn rank(&self) -> Rank {
        self.rank
    }

    /// Returns the current phase.
    pub fn phase(&self) -> Phase {
        self.mailbox.borrow().phase
    }

    /// Returns `true` if the rank has more to do although no message may be on its way to it.
    pub fn busy(&self) -> bool {
        self.mailbox.borrow().busy
    }

    /// Returns `true` if the program has ended.
    pub fn is_done(&self) -> bool {
        self.result.is_some()
    }

    /// Returns the result of the program, if it has ended.
    pub fn into_result(self) -> Option<T> {
        self.result
    }

    /// Delivers a round: its number and the messages to the rank, or `None` if the phase is over.
    pub fn deliver(&mut self, round: u32, inbox: Option<Vec<Message<P>>>) {
        self.mailbox.borrow_mut().round = Some((round, inbox));
    }

    /// Runs the rank until its next exchange. Returns the messages that it sends.
    ///
    /// # Errors
    /// Returns the error of the rank, or an error that reports its panic. A rank that failed must not run again.
    pub fn step(&mut self) -> Result<Vec<Message<P>>, TransportError> {
        if self.result.is_none()
            && let Poll::Ready(result) = self.poll()?
        {
            self.mailbox.borrow_mut().busy = false;
            self.result = Some(result?);
        }
        Ok(std::mem::take(&mut self.mailbox.borrow_mut().sent))
    }

    /// Polls the program. The programs of ranks run only here, so their panics are caught here.
    fn poll(&mut self) -> Result<Poll<Result<T, TransportError>>, TransportError> {
        let program = &mut self.program;
        let poll = || program.as_mut().poll(&mut task::Context::from_waker(Waker::noop()));
        panic::catch_unwind(AssertUnwindSafe(poll)).map_err(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            let reason = text.unwrap_or("it panicked").to_string();
            TransportError::WorkerFailed { rank: self.rank, reason }
        })
    }
}

#[cfg(test)]
mod tests;
