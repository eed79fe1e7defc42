//! The messages that stars receive and send in one step.
//!
//! **Statement.** See [`crate::splaying::splay`]. A star processes all messages of a step together, whether they came from this
//! rank or from another.
//!
//! **Work and depth.** The stars are charged for their own work in [`crate::splaying::step`]. This module sorts the messages
//! of all stars of a rank once per step.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::ids::Rank;

use crate::machine::context::Context;
use crate::splaying::messages::{GatheredPoint, Objection, Objections, Proposal};
use crate::splaying::wire::{CellMessage, ObjectionMessage, take_objections, take_points, take_proposals};
use crate::stars::owned::Stars;
use crate::state::table::Table;

/// The messages to one star in a step, in order.
#[derive(Clone, Copy)]
pub(super) struct StarInbox<'a, P: Point> {
    /// The owned vertex.
    pub(super) vertex: u32,
    /// By cell, then by sender.
    pub(super) proposals: &'a [Proposal<P::Cell>],
    /// By cell, then by sender.
    pub(super) objections: &'a [Objection<P::Cell>],
    pub(super) gathered: &'a [GatheredPoint],
    /// The answers to questions about its cells, with repetitions.
    pub(super) answers: &'a [GatheredPoint],
    /// The witnesses of the objections to all stars.
    witnesses: &'a [u32],
}

impl<'a, P: Point> StarInbox<'a, P> {
    /// Returns the witnesses of an objection.
    pub(super) fn witnesses(&self, objection: &Objection<P::Cell>) -> &'a [u32] {
        &self.witnesses[objection.witnesses.clone()]
    }
}

/// The messages that owned stars have received and not yet processed.
#[derive(Debug)]
pub(super) struct Pending<P: Point> {
    pub(super) proposals: Vec<Proposal<P::Cell>>,
    pub(super) objections: Objections<P::Cell>,
    pub(super) gathered: Vec<GatheredPoint>,
    pub(super) answers: Vec<GatheredPoint>,
}

impl<P: Point> Pending<P> {
    /// Starts with the points that stars received from a gathering, and without messages of other stars.
    pub(super) fn new(gathered: Vec<GatheredPoint>) -> Self {
        Pending { proposals: Vec::new(), objections: Objections::default(), gathered, answers: Vec::new() }
    }

    /// Returns `true` if there are no messages.
    pub(super) fn is_empty(&self) -> bool {
        self.gathered.is_empty()
            && self.answers.is_empty()
            && self.proposals.is_empty()
            && self.objections.is_empty()
    }

    /// Sorts all messages by receiver.
    pub(super) fn sort(&mut self) {
        self.proposals.sort_unstable();
        self.gathered.sort_unstable();
        self.answers.sort_unstable();
        self.objections.sort();
    }

    /// Returns the messages of each star, once all messages are sorted.
    pub(super) fn by_star(&self) -> Vec<StarInbox<'_, P>> {
        let mut proposals = self.proposals.chunk_by(|a, b| a.to == b.to).peekable();
        let mut objections = self.objections.list().chunk_by(|a, b| a.to == b.to).peekable();
        let mut gathered = self.gathered.chunk_by(|a, b| a.star == b.star).peekable();
        let mut answers = self.answers.chunk_by(|a, b| a.star == b.star).peekable();
        let mut stars = Vec::new();
        loop {
            let heads = [
                proposals.peek().map(|own| own[0].to),
                objections.peek().map(|own| own[0].to),
                gathered.peek().map(|own| own[0].star),
                answers.peek().map(|own| own[0].star),
            ];
            let Some(vertex) = heads.into_iter().flatten().min() else { return stars };
            stars.push(StarInbox {
                vertex,
                proposals: proposals.next_if(|own| own[0].to == vertex).unwrap_or_default(),
                objections: objections.next_if(|own| own[0].to == vertex).unwrap_or_default(),
                gathered: gathered.next_if(|own| own[0].star == vertex).unwrap_or_default(),
                answers: answers.next_if(|own| own[0].star == vertex).unwrap_or_default(),
                witnesses: self.objections.witnesses(),
            });
        }
    }

    /// Receives the answers that other ranks have found for owned stars.
    pub(super) fn receive_answers(&mut self, cx: &mut Context<P>, table: &mut Table<P>) {
        take_points(cx, table, &mut self.answers);
    }

    /// Receives the messages of other ranks.
    pub(super) fn receive(&mut self, cx: &mut Context<P>, table: &mut Table<P>, stars: &mut Stars<P>) {
        let proposals = take_proposals(cx);
        let objections = take_objections(cx);
        if !(proposals.is_empty() && objections.is_empty()) {
            stars.extract_links(table);
        }
        for message in proposals {
            let indices = message.intern(table);
            self.proposals.extend(message.proposals(&indices).filter(|own| own.is_for_star_of(table)));
        }
        for message in objections {
            let indices = message.cells.intern(table);
            for (own, witnesses) in message.cells.proposals(&indices).zip(message.witnesses(&indices)) {
                if own.is_for_star_of(table) {
                    self.objections.add([own.to].into_iter(), own.cell, own.from, &witnesses);
                }
            }
        }
    }
}

/// The messages that the stars of a rank or its registers send in a step.
pub(super) struct StepOutput<P: Point> {
    pub(super) proposals: Vec<Proposal<P::Cell>>,
    pub(super) objections: Objections<P::Cell>,
}

impl<P: Point> Default for StepOutput<P> {
    fn default() -> Self {
        StepOutput { proposals: Vec::new(), objections: Objections::default() }
    }
}

impl<P: Point> StepOutput<P> {
    /// Appends other messages.
    pub(super) fn append(&mut self, mut other: Self) {
        if self.proposals.is_empty() {
            std::mem::swap(&mut self.proposals, &mut other.proposals);
        }
        self.proposals.extend(other.proposals);
        self.objections.append(other.objections);
    }

    /// Returns `true` if there are no messages.
    pub(super) fn is_empty(&self) -> bool {
        self.proposals.is_empty() && self.objections.is_empty()
    }

    /// Adds the messages to stars of this rank to `pending`, and sends the others to the owners of their receivers.
    pub(super) fn send(&self, cx: &mut Context<P>, table: &Table<P>, pending: &mut Pending<P>, round: u32) {
        self.send_proposals(cx, table, pending, round);
        self.send_objections(cx, table, pending, round);
    }

    fn send_proposals(&self, cx: &mut Context<P>, table: &Table<P>, pending: &mut Pending<P>, round: u32) {
        let mut messages: BTreeMap<Rank, CellMessage<P>> = BTreeMap::new();
        for proposal in &self.proposals {
            if table.is_owned(proposal.to) {
                pending.proposals.push(*proposal);
            } else {
                messages.entry(table.owners()[proposal.to as usize]).or_default().add(table, proposal);
            }
        }
        cx.send_each(round, messages.into_iter().map(|(rank, message)| (rank, message.into_proposals())));
    }

    fn send_objections(&self, cx: &mut Context<P>, table: &Table<P>, pending: &mut Pending<P>, round: u32) {
        let mut messages: BTreeMap<Rank, ObjectionMessage<P>> = BTreeMap::new();
        for Objection { to, cell, from, witnesses } in self.objections.list() {
            let (to, cell, from) = (*to, *cell, *from);
            let witnesses = &self.objections.witnesses()[witnesses.clone()];
            if table.is_owned(to) {
                pending.objections.add([to].into_iter(), cell, from, witnesses);
            } else {
                let message = messages.entry(table.owners()[to as usize]).or_default();
                message.add(table, &Proposal { to, cell, from }, witnesses);
            }
        }
        cx.send_each(round, messages.into_iter().map(|(rank, message)| (rank, message.into_body())));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn every_star_gets_each_message_once() {
        let proposal = |to, cell, from| Proposal { to, cell, from };
        let mut pending = Pending::<DVec2>::new(
            [(0, 9), (4, 11), (4, 10)].map(|(star, point)| GatheredPoint { star, point }).to_vec(),
        );
        pending.proposals = vec![
            proposal(4, [2, 4, 9], 2),
            proposal(1, [1, 5, 6], 6),
            proposal(1, [1, 5, 6], 5),
            proposal(1, [1, 7, 8], 7),
        ];
        pending.objections.add([7].into_iter(), [3, 7, 8], 3, &[40]);
        pending.objections.add([4, 1].into_iter(), [1, 4, 9], 9, &[50, 51]);
        pending.sort();
        let stars = pending.by_star();
        let counts: Vec<_> = stars
            .iter()
            .map(|s| (s.vertex, s.proposals.len(), s.objections.len(), s.gathered.len()))
            .collect();
        assert_eq!(counts, [(0, 0, 0, 1), (1, 3, 1, 0), (4, 1, 1, 2), (7, 0, 1, 0)]);
        assert_eq!(stars[1].proposals[0], proposal(1, [1, 5, 6], 5));
        assert_eq!(stars[1].witnesses(&stars[1].objections[0]), [50, 51]);
        assert_eq!(stars[3].witnesses(&stars[3].objections[0]), [40]);
        assert!(Pending::<DVec2>::new(Vec::new()).by_star().is_empty());
    }
}
