//! Proposals and objections as messages between ranks. Cells are rows of positions in a batch of points; the batch contains
//! each point once.

use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasherDefault;

use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::splaying::messages::{GatheredPoint, Proposal};
use crate::state::cells::in_order;
use crate::state::table::{IdHasher, Table};

/// Cells for one rank.
pub(super) struct CellMessage<P> {
    points: PointBatch<P>,
    /// `d + 1` positions in `points` per cell: the sender, the receiver, the other vertices.
    cells: Vec<u32>,
    /// The position in `points` of each local index.
    positions: HashMap<u64, u32, BuildHasherDefault<IdHasher>>,
}

impl<P> Default for CellMessage<P> {
    fn default() -> Self {
        CellMessage { points: PointBatch::default(), cells: Vec::new(), positions: HashMap::default() }
    }
}

impl<P: Point> CellMessage<P> {
    /// Returns the position of a point in the batch. Adds the point if it is missing.
    fn position(&mut self, table: &Table<P>, v: u32) -> u32 {
        let next = self.points.len() as u32;
        let position = *self.positions.entry(u64::from(v)).or_insert(next);
        if position == next {
            table.export(v, &mut self.points);
        }
        position
    }

    /// Adds a cell.
    pub(super) fn add(&mut self, table: &Table<P>, proposal: &Proposal<P::Cell>) {
        let Proposal { to, cell, from } = proposal;
        let others = cell.as_ref().iter().filter(|&v| v != from && v != to);
        for &v in [from, to].into_iter().chain(others) {
            let position = self.position(table, v);
            self.cells.push(position);
        }
    }

    /// Converts the cells to a message of proposals.
    pub(super) fn into_proposals(self) -> Body<P> {
        Body::Propose { points: self.points, cells: Bulk(self.cells) }
    }
}

/// Objections for one rank.
pub(super) struct ObjectionMessage<P> {
    cells: CellMessage<P>,
    /// The number of witnesses of each cell.
    counts: Vec<u32>,
    /// The witnesses of all cells, as positions in the batch.
    witnesses: Vec<u32>,
}

impl<P> Default for ObjectionMessage<P> {
    fn default() -> Self {
        ObjectionMessage { cells: CellMessage::default(), counts: Vec::new(), witnesses: Vec::new() }
    }
}

impl<P: Point> ObjectionMessage<P> {
    /// Adds a cell and its witnesses.
    pub(super) fn add(&mut self, table: &Table<P>, cell: &Proposal<P::Cell>, witnesses: &[u32]) {
        self.cells.add(table, cell);
        self.counts.push(witnesses.len() as u32);
        self.witnesses.extend(witnesses.iter().map(|&v| self.cells.position(table, v)));
    }

    /// Converts the objections to a message.
    pub(super) fn into_body(self) -> Body<P> {
        Body::Object {
            points: self.cells.points,
            cells: Bulk(self.cells.cells),
            counts: Bulk(self.counts),
            conflicts: Bulk(self.witnesses),
        }
    }
}

/// A received message of proposals, or the cells of a message of objections.
pub(super) struct ReceivedCells<P> {
    points: PointBatch<P>,
    cells: Vec<u32>,
}

impl<P: Point> ReceivedCells<P> {
    /// Adds the points to the table. Returns their local indices.
    pub(super) fn intern(&self, table: &mut Table<P>) -> Vec<u32> {
        table.intern_all(&self.points)
    }

    /// Returns the cells as proposals, given the local indices of the points.
    pub(super) fn proposals<'a>(
        &'a self,
        indices: &'a [u32],
    ) -> impl Iterator<Item = Proposal<P::Cell>> + 'a {
        self.cells.chunks_exact(P::DIM + 1).map(|row| {
            let mut cell = P::Cell::splat(0);
            for (v, &position) in cell.as_mut().iter_mut().zip(row) {
                *v = indices[position as usize];
            }
            let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
            Proposal { to, cell: in_order::<P>(&cell), from }
        })
    }
}

/// A received message of objections.
pub(super) struct ReceivedObjections<P> {
    pub(super) cells: ReceivedCells<P>,
    /// The number of witnesses of each cell.
    counts: Vec<u32>,
    /// The witnesses of all cells, as positions in the batch.
    witnesses: Vec<u32>,
}

impl<P: Point> ReceivedObjections<P> {
    /// Returns the witnesses of each cell, given the local indices of the points.
    pub(super) fn witnesses<'a>(&'a self, indices: &'a [u32]) -> impl Iterator<Item = Vec<u32>> + 'a {
        let mut rest = self.witnesses.as_slice();
        self.counts.iter().map(move |&count| {
            let (own, others) = rest.split_at(count as usize);
            rest = others;
            own.iter().map(|&position| indices[position as usize]).collect()
        })
    }
}

pub(super) fn take_proposals<P: Point>(cx: &mut Context<P>) -> Vec<ReceivedCells<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Propose { points, cells } => {
            Some(ReceivedCells { points: std::mem::take(points), cells: std::mem::take(&mut cells.0) })
        }
        _ => None,
    })
}

pub(super) fn take_objections<P: Point>(cx: &mut Context<P>) -> Vec<ReceivedObjections<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Object { points, cells, counts, conflicts } => Some(ReceivedObjections {
            cells: ReceivedCells { points: std::mem::take(points), cells: std::mem::take(&mut cells.0) },
            counts: std::mem::take(&mut counts.0),
            witnesses: std::mem::take(&mut conflicts.0),
        }),
        _ => None,
    })
}

/// Sends points to the owners of the stars that need them. Each rank receives its stars in order.
pub(super) fn send_points<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    points: BTreeMap<Rank, Vec<GatheredPoint>>,
) {
    let bodies = points.into_iter().map(|(rank, mut points)| {
        points.sort_unstable();
        let (mut vertices, mut counts, mut batch) = (Vec::new(), Vec::new(), PointBatch::default());
        for own in points.chunk_by(|a, b| a.star == b.star) {
            vertices.push(table.ids()[own[0].star as usize]);
            counts.push(own.len() as u32);
            for answer in own {
                table.export(answer.point, &mut batch);
            }
        }
        (rank, Body::Region { vertices: Bulk(vertices), counts: Bulk(counts), points: batch })
    });
    cx.send_each(0, bodies);
}

/// Receives points for owned stars.
pub(super) fn take_points<P: Point>(
    cx: &mut Context<P>,
    table: &mut Table<P>,
    taken: &mut Vec<GatheredPoint>,
) {
    for ((vertices, counts), points) in cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Region { vertices, counts, points } => {
            let stars = (std::mem::take(&mut vertices.0), std::mem::take(&mut counts.0));
            Some((stars, std::mem::take(points)))
        }
        _ => None,
    }) {
        let indices = table.intern_all(&points);
        let mut at = 0;
        for (id, count) in vertices.into_iter().zip(counts) {
            let end = (at + count as usize).min(indices.len());
            if let Some(star) = table.find(id).filter(|&v| table.is_owned(v)) {
                taken.extend(indices[at..end].iter().map(|&point| GatheredPoint { star, point }));
            }
            at = end;
        }
    }
}
