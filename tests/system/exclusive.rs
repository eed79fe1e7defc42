//! Exclusive reads and writes between workers, by a log of all accesses: what a round's messages read in the
//! memory of their sender and write in that of their receiver.
//!
//! A cell is a point's record in the memory of one worker, or the place where an answer to a query is awaited.
//! In one step of the machine
//! 1. a record that moves is given away by the one worker that has it, to one other;
//! 2. a record is read only by the processors of a worker that was sent it before, or was given it;
//! 3. a subproblem takes each of its points once, by one of its processors: what both children need was copied;
//! 4. an answer is written once by each worker that was asked, and by no other.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

use glam::DVec3;
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::run_on;
use septet_core::spec::{Correction, Partition, Workers};
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::message::{Body, ListBatch, Message, PointBatch, ReplyBatch};

use crate::common::observed::Observed;
use crate::common::sets::space;
use crate::common::{combinations, simulated, task, with_graph};

/// The number of points of every run, all distinct.
const POINTS: u64 = 1500;

type Sent = (Phase, Message<DVec3>);

fn records(body: &Body<DVec3>) -> Vec<&PointBatch<DVec3>> {
    match body {
        Body::Start { frame: points, .. }
        | Body::Move(points)
        | Body::Frame(points)
        | Body::Ghosts(points)
        | Body::Gather(points)
        | Body::Reverse { points, .. }
        | Body::Items { points, .. }
        | Body::Propose { points, .. }
        | Body::Object { points, .. }
        | Body::Region { points, .. } => vec![points],
        Body::Reply(answer) => vec![&answer.points],
        Body::Lists(list) => vec![&list.points],
        Body::Summary(summary) => vec![&summary.smallest],
        Body::Children(both) => both.iter().map(|s| &s.smallest).collect(),
        _ => Vec::new(),
    }
}

/// The worker whose memory holds a point as its own, and those that were sent a copy.
#[derive(Default)]
struct Memory {
    owner: BTreeMap<u64, Rank>,
    copies: BTreeSet<(Rank, u64)>,
    /// Places where answers are awaited: who waits, its name of the query, who was asked.
    awaited: BTreeSet<(Rank, u32, Rank)>,
    /// For each point that a subproblem has taken, the rank that holds it for the subproblem. A group that does not divide
    /// its set hands its shares over to one rank.
    taken: BTreeMap<(Phase, NodeId, u64), Rank>,
}

impl Memory {
    /// The memory of a number of workers, each with its block of the points.
    fn of_blocks(workers: u32) -> Self {
        let block_of = |rank: Rank| {
            let at = |block: u32| POINTS * u64::from(block) / u64::from(workers);
            (at(rank - 1)..at(rank)).map(move |id| (id, rank))
        };
        Memory { owner: (1..=workers).flat_map(block_of).collect(), ..Memory::default() }
    }

    fn may_read(&self, rank: Rank, id: u64) -> bool {
        rank == COORDINATOR || self.owner.get(&id) == Some(&rank) || self.copies.contains(&(rank, id))
    }

    /// The reads of a message at its sender: the accesses that are not exclusive.
    fn read(&mut self, phase: Phase, m: &Message<DVec3>) -> Option<String> {
        let what = |why: &str, id: u64| Some(format!("{} {}: point {id} {why}", phase.name(), m.node.0));
        for batch in records(&m.body) {
            for &id in batch.ids.iter() {
                let mine = self.owner.get(&id) == Some(&m.from);
                match &m.body {
                    Body::Move(_) if !mine => return what("is given by another than its worker", id),
                    // A message in flight belongs to no rank until it arrives.
                    Body::Move(_) => drop(self.owner.remove(&id)),
                    Body::Ghosts(_) | Body::Items { .. }
                        if self
                            .taken
                            .insert((phase, m.node, id), m.to)
                            .is_some_and(|holder| holder != m.from) =>
                    {
                        return what("is taken twice", id);
                    }
                    _ if !self.may_read(m.from, id) => return what("is read where it never was", id),
                    _ => {}
                }
            }
        }
        None
    }

    /// The writes of a message at its receiver.
    fn write(&mut self, m: &Message<DVec3>) -> Option<String> {
        match &m.body {
            Body::Move(points) => {
                for &id in points.ids.iter() {
                    if self.owner.insert(id, m.to).is_some() {
                        return Some(format!("point {id} has two owners"));
                    }
                }
            }
            Body::Query(batch) => {
                self.awaited.extend(batch.slots.iter().map(|&slot| (m.from, slot, m.to)));
            }
            Body::Items { slots, .. } => {
                self.awaited.extend(slots.iter().map(|&slot| (m.from, slot, m.to)));
            }
            Body::Reply(ReplyBatch { slots, .. }) | Body::Lists(ListBatch { slots, .. }) => {
                for &slot in slots.iter() {
                    if !self.awaited.remove(&(m.to, slot, m.from)) {
                        return Some(format!("{} answers {} of {} again, or unasked", m.from, slot, m.to));
                    }
                }
            }
            _ => {}
        }
        for batch in records(&m.body) {
            self.copies.extend(batch.ids.iter().map(|&id| (m.to, id)));
        }
        None
    }
}

/// The first access that is not exclusive.
fn conflict(log: &[Sent], workers: u32) -> Option<String> {
    let mut memory = Memory::of_blocks(workers);
    for step in log.chunk_by(|a, b| a.1.round == b.1.round) {
        // All reads of a step come before its writes.
        for (phase, message) in step {
            if let Some(conflict) = memory.read(*phase, message) {
                return Some(conflict);
            }
        }
        for (_, message) in step {
            if let Some(conflict) = memory.write(message) {
                return Some(conflict);
            }
        }
    }
    (!memory.awaited.is_empty()).then(|| format!("{} answers are missing", memory.awaited.len()))
}

fn logged(workers: u32, choice: usize, counted: bool) -> Vec<Sent> {
    let spec = with_graph(&simulated(Workers::Count(workers), 0, 60), combinations(false)[choice]);
    logged_of(&spec, counted)
}

fn logged_of(spec: &Spec, counted: bool) -> Vec<Sent> {
    let points = space(Kind::Uniform, POINTS, 4);
    let log = Arc::new(Mutex::new(Vec::new()));
    let run = run_on(&points, (spec, task(counted)), &mut |_| {
        let log = log.clone();
        Box::new(Observed(move |phase, messages: &[Message<DVec3>]| {
            log.lock().unwrap().extend(messages.iter().map(|m| (phase, m.clone())));
        }))
    });
    assert!(run.unwrap().refutation.is_none());
    let mut log = std::mem::take(&mut *log.lock().unwrap());
    log.sort_by_key(|(_, message)| message.round);
    log
}

#[test]
fn accesses_between_workers_are_exclusive() {
    for choice in 0..combinations(false).len() {
        for (workers, counted) in [(2, true), (5, true), (16, true), (5, false)] {
            let log = logged(workers, choice, counted);
            assert!(log.len() > 50, "{} messages", log.len());
            let found = conflict(&log, workers);
            assert!(found.is_none(), "{:?}, {workers} workers: {found:?}", combinations(false)[choice]);
        }
    }
}

#[test]
fn accesses_of_rivals_are_exclusive() {
    for workers in [2, 5, 16] {
        let spec = simulated(Workers::Count(workers), 0, 60).with(|c| {
            c.tree.partition = Partition::Kd;
            c.recursion.neighbours = Correction::BottomUp;
        });
        let log = logged_of(&spec, true);
        let asked = log.iter().filter(|(phase, _)| *phase == Phase::Neighbours).count();
        assert!(asked >= 2 * workers as usize, "{asked} messages of the correction");
        assert_eq!(conflict(&log, workers), None, "{workers} workers");
    }
}

/// Each kind of planted access is found.
#[test]
fn the_log_finds_what_is_not_exclusive() {
    let log = logged(5, 1, true);
    let doubled = |is: &dyn Fn(&Body<DVec3>) -> bool, change: &dyn Fn(&mut Message<DVec3>)| {
        let mut log = log.clone();
        let at = log.iter().position(|(_, m)| m.from != COORDINATOR && is(&m.body)).expect("such a message");
        let (phase, mut message) = log[at].clone();
        change(&mut message);
        log.insert(at, (phase, message));
        conflict(&log, 5)
    };
    let elsewhere = |m: &mut Message<DVec3>| m.to = m.to % 5 + 1;
    let full = |points: &PointBatch<DVec3>| !points.is_empty();
    let found = [
        doubled(&|b| matches!(b, Body::Move(p) if full(p)), &elsewhere),
        doubled(&|b| matches!(b, Body::Items { points, .. } if full(points)), &elsewhere),
        doubled(&|b| matches!(b, Body::Reply(list) if !list.slots.is_empty()), &|_| {}),
        doubled(&|b| matches!(b, Body::Lists(list) if full(&list.points)), &|_| {}),
    ];
    let again = "again, or unasked";
    for (found, words) in found.iter().zip(["given by another", "taken twice", again, again]) {
        assert!(found.as_ref().is_some_and(|f| f.contains(words)), "{words}: {found:?}");
    }
}
