//! The seams between pieces, where only the answer is wanted.
//!
//! **Statement.** Let `B` be the home points of a worker and `G` any other points, and let every home point `b`
//! be sent to each worker whose region is met by what holds the conflicts of a cell of `b` in the triangulation
//! of `B + G` ([`septet_geometry::ball::Reach`]: the closed ball, beyond the hull a closed half-space). Then
//! every worker holds all neighbours of its home points, and the triangulation of what it holds has their true
//! stars.
//!
//! *Proof.* Let `a`, at home with another worker, be a neighbour of `b` in the triangulation of all points. An
//! edge of a (perturbed, hence generic) Delaunay triangulation stays one when other points are left out, so
//! `ab` is an edge of that of `B + G + a`. If `a` is in `G`, the edge is in `B + G`, and a cell's closed ball
//! (half-space) has its vertices in it. Otherwise `a` becomes a neighbour of `b` by being inserted, which it
//! does only if it conflicts with a cell of `b`. Either way what holds the conflicts of a cell of `b` has `a` in
//! it, which lies in its worker's region, so `b` is sent there. A star is decided by its vertex and its true
//! neighbours; more points change nothing. QED.
//!
//! So one sending suffices, whatever `G` is. It is done twice because cells that bridge a concave part of a
//! piece reach very far: first the vertices of ordinary cells are sent (they are enough to undo most of the
//! others), then those that the statement asks for and that are not there yet. Where no unusual cell of `b` reached,
//! nothing is asked for any more: a point that conflicts with a cell of `b` in `B + G` conflicts, by the same argument,
//! with one of `b` in `B`, and if that was ordinary `b` was sent to the point.
//!
//! **Rounds.** At most one a shared level, twice. **Work.** One clearance a level for each vertex at the border
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), one test a level for each cell whose
//! ball is not clear of the border by that of a vertex, and the insertion of what comes: `O(n^(1-1/d))` points for
//! well-spaced sets.
//!
//! The cells of a piece that reach out are found by a walk along its border ([`crate::border`]). The certificate does
//! not rely on any of this.

use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::ball::Reach;
use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::border::{Outgoing, Unusual, ones, reaches};
use crate::piece::{Piece, reach_of};
use crate::table::IdHasher;
use crate::worker::Worker;

/// What the seams need between their steps.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    /// Foreign points that came and are not inserted yet.
    arrived: Vec<u32>,
    /// Cells that reach out and were not ordinary.
    unusual: Unusual,
    /// What the border knew of home points.
    clear: Vec<f64>,
    /// What went where a group is one worker: position on the path, and home point.
    sent: HashSet<u64, BuildHasherDefault<IdHasher>>,
}

/// Points on their way, with the cells that send them.
struct Transit<P> {
    origin: Rank,
    points: PointBatch<P>,
    /// Positions in `points`, `d + 1` a cell.
    cells: Vec<u32>,
}

/// Points and cells for one receiver.
struct Parcel<P> {
    transit: Transit<P>,
    /// The position of each point of where it comes from, or [`INFINITE`].
    places: Vec<u32>,
}

/// The position of a point that need not go along.
const LEFT_OUT: u32 = INFINITE - 1;

/// By position on the path and side.
type Parcels<P> = BTreeMap<(usize, usize), Parcel<P>>;

impl<P: Point> Parcel<P> {
    /// An empty one, for points and cells of `from`.
    fn of(from: &Transit<P>) -> Self {
        let transit = Transit { origin: from.origin, points: PointBatch::default(), cells: Vec::new() };
        Parcel { transit, places: vec![INFINITE; from.points.len()] }
    }

    fn point(&mut self, from: &PointBatch<P>, at: u32) -> u32 {
        let (i, points) = (at as usize, &mut self.transit.points);
        let place = &mut self.places[i];
        if *place == INFINITE {
            *place = points.len() as u32;
            points.push(from.ids[i], from.positions[i], from.owners[i], from.radii2[i]);
        }
        *place
    }

    /// A cell with all its vertices.
    fn cell(&mut self, from: &PointBatch<P>, cell: &P::Cell) {
        for &v in cell.as_ref() {
            let place = if v == INFINITE { INFINITE } else { self.point(from, v) };
            self.transit.cells.push(place);
        }
    }
}

impl<P: Point> Worker<P> {
    /// Triangulates the home points; sends the vertices of ordinary cells that reach out.
    pub(crate) fn begin_pieces(&mut self) {
        self.report_frame();
        if self.table.home == 0 {
            return;
        }
        let piece = self.tree.as_ref().map_or(NodeId::ROOT, |t| t.0);
        let home = u64::from(self.table.home);
        let _span = self.out.site().subproblem(Phase::Pieces, piece, "triangulate piece", home);
        let mut built = Piece::new(&self.table.positions, self.table.home, &[], &self.config.stop);
        if built.is_none() {
            // A flat piece: points of the frame are real points, so they may stand in any star.
            let frame = self.table.intern_all(&self.frame);
            built = Piece::new(&self.table.positions, self.table.home, &frame, &self.config.stop);
        }
        self.stars.set_piece(built);
        self.send_ordinary();
    }

    fn send_ordinary(&mut self) {
        let (mut ordinary, mut unusual, mut clear) = (Vec::new(), Unusual::default(), Vec::new());
        if let Some(mut border) = self.border(Vec::new()) {
            (ordinary, unusual) = border.survey();
            clear = border.clear;
        }
        (self.seams.unusual, self.seams.clear) = (unusual, clear);
        self.send_cells_out(&ordinary);
    }

    /// Inserts what came; sends the vertices of cells that still reach out to where unusual ones did.
    pub(crate) fn begin_seam(&mut self) {
        self.insert_arrived();
        let mut open = Vec::new();
        let (unusual, clear) =
            (std::mem::take(&mut self.seams.unusual), std::mem::take(&mut self.seams.clear));
        if let (Some(piece), Some(mut border)) = (self.stars.piece(), self.border(clear)) {
            // The other cells are as they were: a new one has a foreign vertex.
            let is_sought = |v: u32| unusual.levels[v as usize] != 0;
            piece.each_mixed_cell(is_sought, |slot, cell| {
                open.extend(border.outgoing(slot, cell, &unusual));
            });
            for &slot in unusual.slots.iter().filter(|&&slot| piece.is_live(slot)) {
                let cell = piece.cell(slot);
                if cell.as_ref().iter().all(|&v| v == INFINITE || self.table.is_home(v)) {
                    open.extend(border.outgoing(slot, &cell, &unusual));
                }
            }
        }
        if let Some(mut piece) = self.stars.take_piece() {
            piece.forget_fresh();
            self.stars.set_piece(Some(piece));
        }
        self.send_cells_out(&open);
    }

    /// Inserts the last foreign points.
    pub(crate) fn finish_seams(&mut self) {
        self.insert_arrived();
        self.seams.sent = HashSet::default();
        if let Some(mut piece) = self.stars.take_piece() {
            piece.forget_fresh();
            self.stars.set_piece(Some(piece));
        }
    }

    fn insert_arrived(&mut self) {
        let arrived = std::mem::take(&mut self.seams.arrived);
        let Some(mut piece) = self.stars.take_piece() else { return };
        let id = self.tree.as_ref().map_or(NodeId::ROOT, |t| t.0);
        let _span = self.out.site().subproblem(self.phase, id, "insert ghosts", arrived.len() as u64);

        piece.add(&arrived, &self.table.positions, &self.config.stop);
        self.stars.set_piece(Some(piece));
        if let Some(leaf) = self.leaves.first_mut() {
            leaf.ghosts.extend(arrived);
        }
    }

    /// Sends the vertices of cells to where the cells reach.
    fn send_cells_out(&mut self, cells: &[Outgoing<P::Cell>]) {
        let mut transit = Transit { origin: self.rank, points: PointBatch::default(), cells: Vec::new() };
        let mut places = vec![INFINITE; if cells.is_empty() { 0 } else { self.table.positions.len() }];
        let mut rows: Vec<P::Cell> = Vec::with_capacity(cells.len());
        for out in cells {
            let mut row = out.cell;
            for v in row.as_mut().iter_mut().filter(|v| **v != INFINITE) {
                let place = &mut places[*v as usize];
                if *place == INFINITE {
                    *place = transit.points.len() as u32;
                    self.table.export(*v, &mut transit.points);
                }
                *v = *place;
            }
            rows.push(row);
        }
        let mut parcels = BTreeMap::new();
        for (row, out) in rows.iter().zip(cells) {
            for i in ones(out.levels) {
                self.pack(&transit, row, (i, 1 - self.path[i].mine), &mut parcels);
            }
        }
        self.send_parcels(parcels);
    }

    /// Sends points on along the path, from a position on it; those that reach this worker's own piece stay.
    fn route(&mut self, transit: &Transit<P>, start: usize) {
        let mut parcels: Parcels<P> = BTreeMap::new();
        let mut mine: Vec<bool> = vec![false; transit.points.len()];
        for row in transit.cells.chunks_exact(P::DIM + 1) {
            let mut cell = P::Cell::splat(0);
            cell.as_mut().copy_from_slice(row);
            let reach = reach_of::<P>(&cell, |v| transit.points.positions[v as usize]);
            if self.walk_path(transit, &cell, &reach, start, &mut parcels) {
                for &v in row.iter().filter(|&&v| v != INFINITE) {
                    mine[v as usize] = true;
                }
            }
        }
        self.send_parcels(parcels);
        for at in (0..mine.len()).filter(|&at| mine[at]) {
            self.arrive(transit, at);
        }
    }

    fn send_parcels(&mut self, parcels: Parcels<P>) {
        for ((i, side), parcel) in parcels.into_iter().filter(|(_, p)| !p.transit.points.is_empty()) {
            let shared = &self.path[i];
            let (to, node) = (shared.member_below(self.rank, side), shared.id.child(side));
            let Transit { origin, points, cells } = parcel.transit;
            self.out.send(to, node, 0, Body::Seam { origin, points, cells: Bulk(cells) });
        }
    }

    /// Puts a cell into the parcels of all it reaches. Does it reach this worker's piece?
    fn walk_path(
        &mut self,
        transit: &Transit<P>,
        cell: &P::Cell,
        reach: &Reach<P>,
        start: usize,
        parcels: &mut Parcels<P>,
    ) -> bool {
        for i in start..self.path.len() {
            let shared = &self.path[i];
            let (mine, goes_on) = (shared.mine, shared.goes_on);
            if reaches(&shared.split, reach, 1 - mine) {
                self.pack(transit, cell, (i, 1 - mine), parcels);
            }
            let reached = reaches(&self.path[i].split, reach, mine);
            if reached && !goes_on {
                self.pack(transit, cell, (i, mine), parcels);
            }
            if !reached || !goes_on {
                return false;
            }
        }
        true
    }

    fn pack(&mut self, transit: &Transit<P>, cell: &P::Cell, to: (usize, usize), parcels: &mut Parcels<P>) {
        let child = &self.path[to.0].children[to.1];
        let parcel = parcels.entry(to).or_insert_with(|| Parcel::of(transit));
        if child.ranks > 1 && !child.leaf {
            parcel.cell(&transit.points, cell);
            return;
        }
        // Nobody further down has to know why: the points alone, those of the sender's home, each once.
        for &v in cell.as_ref().iter().filter(|&&v| v != INFINITE) {
            if parcel.places[v as usize] != INFINITE {
                continue;
            }
            let key = transit.points.ids[v as usize] << 6 | to.0 as u64;
            if transit.points.owners[v as usize] == transit.origin && self.seams.sent.insert(key) {
                parcel.point(&transit.points, v);
            } else {
                parcel.places[v as usize] = LEFT_OUT;
            }
        }
    }

    /// A point that may be a neighbour of a home point.
    fn arrive(&mut self, transit: &Transit<P>, at: usize) {
        let points = &transit.points;
        let (id, owner) = (points.ids[at], points.owners[at]);
        if owner != transit.origin || owner == self.rank {
            return;
        }
        let (number, is_new) = self.table.receive(id, points.positions[at], owner);
        if is_new {
            self.seams.arrived.push(number);
        }
    }

    /// Points sent here, or through here.
    pub(crate) fn on_seam(&mut self, inbox: &mut Vec<Message<P>>) {
        self.learn_frame(inbox);
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Seam { origin, points, cells } => {
                let (points, cells) = (std::mem::take(points), std::mem::take(&mut cells.0));
                received.push((m.node, Transit { origin: *origin, points, cells }));
                false
            }
            _ => true,
        });
        for (node, transit) in received {
            if let Some((at, holder)) = self.relay
                && at == node
                && holder != self.rank
            {
                let Transit { origin, points, cells } = transit;
                self.out.send(holder, node, 0, Body::Seam { origin, points, cells: Bulk(cells) });
                continue;
            }
            let start = self.path.iter().position(|s| s.id == node).unwrap_or(self.path.len());
            if start == self.path.len() {
                (0..transit.points.len()).for_each(|at| self.arrive(&transit, at));
            } else {
                self.route(&transit, start);
            }
        }
    }
}
