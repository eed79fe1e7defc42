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
//! others), then those that the statement asks for and that are not there yet.
//!
//! **Rounds.** At most one a shared level, twice. **Work.** One comparison a cell, one clearance a home point and level
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), one test a level for each cell whose
//! ball is not clear of the border by that of a vertex, and the insertion of what comes: `O(n^(1-1/d))` points for
//! well-spaced sets.
//!
//! **Departure** from the walk along the hull: every cell is tested, for the cells that reach out of a piece
//! need not hang together where the piece surrounds another. The certificate does not rely on any of this.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::ball::Reach;
use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex};
use septet_geometry::separator::Side;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::piece::{Piece, reach_of};
use crate::table::IdHasher;
use crate::tree::Split;
use crate::worker::Worker;

/// What the seams need between their steps.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    /// Foreign points that came and are not inserted yet.
    arrived: Vec<u32>,
    /// Slots of cells that reach out and were not ordinary.
    unusual: Vec<u32>,
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
    places: HashMap<u64, u32, BuildHasherDefault<IdHasher>>,
}

impl<P: Point> Parcel<P> {
    fn new(origin: Rank) -> Self {
        let transit = Transit { origin, points: PointBatch::default(), cells: Vec::new() };
        Parcel { transit, places: HashMap::default() }
    }

    fn point(&mut self, from: &PointBatch<P>, at: u32) -> u32 {
        let points = &mut self.transit.points;
        *self.places.entry(u64::from(at)).or_insert_with(|| {
            let i = at as usize;
            points.push(from.ids[i], from.positions[i], from.owners[i], from.radii2[i]);
            points.len() as u32 - 1
        })
    }

    /// A cell with all its vertices.
    fn cell(&mut self, from: &PointBatch<P>, cell: &P::Cell) {
        for &v in cell.as_ref() {
            let place = if v == INFINITE { INFINITE } else { self.point(from, v) };
            self.transit.cells.push(place);
        }
    }
}

fn reaches<P: Point>(split: &Split<P>, reach: &Reach<P>, side: usize) -> bool {
    let (low, high) = split.boxes[side];
    let wanted = if side == 0 { Side::Interior } else { Side::Exterior };
    reach.meets(&split.separator, wanted, low, high)
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
        let (mut ordinary, mut unusual) = (Vec::new(), Vec::new());
        if let Some(piece) = self.stars.piece().filter(|_| !self.path.is_empty()) {
            let clear = self.clearances();
            piece.each_cell(|slot, cell| {
                // Nearly every cell is far from the border: all of its ball is within twice the radius of a vertex.
                let clear = clear.get(cell.as_ref()[0] as usize).copied().unwrap_or(0.0);
                if 2.0 * piece.radius_bound(slot) < clear {
                    return;
                }
                if piece.ball(slot).is_some_and(|ball| !self.leaves_home(&ball)) {
                    return;
                }
                let (reach, corners) = reach_of::<P>(cell, |v| self.table.positions[v as usize]);
                if !self.leaves_home(&reach) {
                } else if Piece::is_ordinary(&reach, &corners[..=P::DIM]) {
                    ordinary.push(*cell);
                } else {
                    unusual.push(slot);
                }
            });
        }
        self.seams.unusual = unusual;
        self.send_cells_out(&ordinary);
    }

    /// For each home point a distance within which all places are on its sides of all separators.
    fn clearances(&self) -> Vec<f64> {
        let home = &self.table.positions[..self.table.home as usize];
        let least = |x: &P| {
            let clear = self.path.iter().map(|shared| shared.split.separator.clearance(*x));
            clear.fold(f64::INFINITY, f64::min)
        };
        home.iter().map(least).collect()
    }

    /// Inserts what came; sends the vertices of all cells that still reach out.
    pub(crate) fn begin_seam(&mut self) {
        self.insert_arrived();
        let mut open = Vec::new();
        if let Some(piece) = self.stars.piece().filter(|_| !self.path.is_empty()) {
            let mut look = |cell: &P::Cell| {
                let (reach, _) = reach_of::<P>(cell, |v| self.table.positions[v as usize]);
                if self.leaves_home(&reach) {
                    open.push(*cell);
                }
            };
            // The other cells are as they were: a new one has a foreign vertex.
            piece.each_mixed_cell(|_, cell| look(cell));
            for &slot in self.seams.unusual.iter().filter(|&&slot| piece.is_live(slot)) {
                let cell = piece.cell(slot);
                if cell.as_ref().iter().all(|&v| v == INFINITE || self.table.is_home(v)) {
                    look(&cell);
                }
            }
        }
        self.seams.unusual = Vec::new();
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

    fn leaves_home(&self, reach: &Reach<P>) -> bool {
        self.path.iter().any(|shared| reaches(&shared.split, reach, 1 - shared.mine))
    }

    /// Sends the vertices of cells, given by local numbers, to where the cells reach.
    fn send_cells_out(&mut self, cells: &[P::Cell]) {
        let mut all = Parcel::new(self.rank);
        let mut places = HashMap::<u64, u32, BuildHasherDefault<IdHasher>>::default();
        for cell in cells {
            for &v in cell.as_ref() {
                let place = if v == INFINITE {
                    INFINITE
                } else {
                    let points = &mut all.transit.points;
                    *places.entry(u64::from(v)).or_insert_with(|| {
                        self.table.export(v, points);
                        points.len() as u32 - 1
                    })
                };
                all.transit.cells.push(place);
            }
        }
        self.route(&all.transit, 0, true);
    }

    /// Sends points on along the path, from a position on it; those that reach this worker's own piece stay.
    fn route(&mut self, transit: &Transit<P>, start: usize, from_home: bool) {
        let mut parcels: BTreeMap<(usize, usize), Parcel<P>> = BTreeMap::new();
        let mut mine: Vec<bool> = vec![false; transit.points.len()];
        for row in transit.cells.chunks_exact(P::DIM + 1) {
            let mut cell = P::Cell::splat(0);
            cell.as_mut().copy_from_slice(row);
            let (reach, _) = reach_of::<P>(&cell, |v| transit.points.positions[v as usize]);
            let stays = self.walk_path(transit, &cell, &reach, (start, from_home), &mut parcels);
            if stays && !from_home {
                for &v in row.iter().filter(|&&v| v != INFINITE) {
                    mine[v as usize] = true;
                }
            }
        }
        for ((i, side), parcel) in parcels {
            let shared = &self.path[i];
            let (to, node) = (shared.member_below(self.rank, side), shared.id.child(side));
            let Transit { origin, points, cells } = parcel.transit;
            self.out.send(to, node, 0, Body::Seam { origin, points, cells: Bulk(cells) });
        }
        for at in (0..mine.len()).filter(|&at| mine[at]) {
            self.arrive(transit, at);
        }
    }

    /// Puts a cell into the parcels of all it reaches. Does it reach this worker's piece?
    fn walk_path(
        &mut self,
        transit: &Transit<P>,
        cell: &P::Cell,
        reach: &Reach<P>,
        (start, from_home): (usize, bool),
        parcels: &mut BTreeMap<(usize, usize), Parcel<P>>,
    ) -> bool {
        for i in start..self.path.len() {
            let shared = &self.path[i];
            let (mine, goes_on) = (shared.mine, shared.goes_on);
            if reaches(&shared.split, reach, 1 - mine) {
                self.pack(transit, cell, (i, 1 - mine), parcels);
            }
            if !from_home {
                let reached = reaches(&self.path[i].split, reach, mine);
                if reached && !goes_on {
                    self.pack(transit, cell, (i, mine), parcels);
                }
                if !reached || !goes_on {
                    return false;
                }
            }
        }
        true
    }

    fn pack(
        &mut self,
        transit: &Transit<P>,
        cell: &P::Cell,
        to: (usize, usize),
        parcels: &mut BTreeMap<(usize, usize), Parcel<P>>,
    ) {
        let child = &self.path[to.0].children[to.1];
        if child.ranks > 1 && !child.leaf {
            let parcel = parcels.entry(to).or_insert_with(|| Parcel::new(transit.origin));
            parcel.cell(&transit.points, cell);
            return;
        }
        // Nobody further down has to know why: the points alone, those of the sender's home, each once.
        for &v in cell.as_ref().iter().filter(|&&v| v != INFINITE) {
            if transit.points.owners[v as usize] != transit.origin {
                continue;
            }
            let key = transit.points.ids[v as usize] << 6 | to.0 as u64;
            if self.seams.sent.insert(key) {
                let parcel = parcels.entry(to).or_insert_with(|| Parcel::new(transit.origin));
                parcel.point(&transit.points, v);
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
                self.route(&transit, start, false);
            }
        }
    }
}
