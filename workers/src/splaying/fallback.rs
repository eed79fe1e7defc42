//! What the exchange leaves open is gathered by the coordinator.
//!
//! The region is the vertices that hold a cell which another star lacks, with their links; or all points, if that was not
//! enough. Each of these vertices gets its neighbours in the region's triangulation, and the exchange goes on
//! ([`crate::splaying::repair`]), in which it proposes what the others lack.

use std::collections::BTreeSet;

use septet_geometry::complex::INFINITE;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::schedule::Outcome;
use crate::worker::Worker;

impl<P: Point> Worker<P> {
    /// Gathers what the last check found unresolved, or everything.
    pub(crate) fn begin_fallback(&mut self) {
        self.write_out();
        let all = self.known.outcome == Outcome::GatherAll;
        let disagreements = self.finish_check();
        self.exchange.unresolved = if all {
            (0..self.table.home).collect()
        } else {
            // Those who lack a cell are told of it again: the set must not depend on who is at home with whom.
            disagreements.iter().map(|d| d.home).collect()
        };
        self.exchange.rounds = 0;
        let mut batch = PointBatch::default();
        let mut links = BTreeSet::new();
        for &home in &self.exchange.unresolved {
            let i = home as usize;
            // A radius of 1 marks a vertex whose star is wanted.
            batch.push(self.table.ids[i], self.table.positions[i], self.rank, 1.0);
            links.extend(self.stars.link(home).iter().flat_map(std::convert::AsRef::as_ref).copied());
        }
        links.remove(&INFINITE);
        for v in links.difference(&self.exchange.unresolved) {
            let i = *v as usize;
            batch.push(self.table.ids[i], self.table.positions[i], self.table.owners[i], 0.0);
        }
        self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Gather(batch));
    }

    /// Takes the gathered region's neighbours; they are used when the exchange goes on.
    pub(crate) fn on_fallback(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Region { vertices, counts, points } => {
                let taken = (std::mem::take(&mut vertices.0), std::mem::take(&mut counts.0));
                received.push((taken, std::mem::take(points)));
                false
            }
            _ => true,
        });
        for ((vertices, counts), points) in received {
            let numbers = self.table.intern_all(&points);
            let mut at = 0;
            for (id, count) in vertices.into_iter().zip(counts) {
                let end = (at + count as usize).min(numbers.len());
                if let Some(home) = self.table.find(id).filter(|&h| self.table.is_home(h)) {
                    self.exchange.gathered.extend(numbers[at..end].iter().map(|&v| (home, v)));
                }
                at = end;
            }
        }
    }
}
