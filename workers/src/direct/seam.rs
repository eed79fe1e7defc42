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
//! So one sending suffices, whatever `G` is. `G` is the halo ([`crate::direct::halo`]), so that the cells of a piece are nearly
//! those of the whole: few reach farther than the halos of their vertices, and a vertex has been sent to all that its
//! halo meets. Points that come now are left out where they are nobody's neighbours ([`crate::direct::piece`]).
//!
//! **Rounds.** At most one a shared level. **Work.** One clearance a level for each vertex at the border
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), one test a level for each cell whose
//! ball is not clear of the border by that of a vertex, and the insertion of what comes: `O(n^(1-1/d))` points for
//! well-spaced sets.
//!
//! The certificate does not rely on any of this.

use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::ball::Reach;
use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::direct::border::{Outgoing, ones, reaches};
use crate::direct::halo::Margin;
use crate::direct::piece::{Piece, reach_of};
use crate::state::table::IdHasher;
use crate::worker::Worker;

/// What the seams need between their steps.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    /// Foreign points that came and are not inserted yet.
    pub(crate) arrived: Vec<u32>,
    /// For each home point how far around it nothing more has to be told.
    pub(crate) margins: Vec<Margin>,
    /// What went where a group is one worker: home point, position on the path, and side.
    sent: HashSet<u64, BuildHasherDefault<IdHasher>>,
}

/// Points on their way, with the cells that send them.
struct Transit<P> {
    points: PointBatch<P>,
    /// Positions in `points`, `d + 1` a cell; [`INFINITE`]; and marked [`CARRIED`] what only gives the cell its shape.
    cells: Vec<u32>,
}

/// The mark of a vertex that need not arrive where its cell reaches.
const CARRIED: u32 = 1 << 31;

/// Points and cells for one receiver.
struct Parcel<P> {
    transit: Transit<P>,
    /// The position of each point of where it comes from, or [`INFINITE`].
    places: Vec<u32>,
}

/// The position of a point that need not go along.
const LEFT_OUT: u32 = INFINITE - 1;

/// Foreign points to expect beyond the halo, as a multiple of the number of home points to the power `(d - 1) / d`.
const LAYERS: f64 = 4.0;

/// By position on the path and side.
type Parcels<P> = BTreeMap<(usize, usize), Parcel<P>>;

impl<P: Point> Parcel<P> {
    /// An empty one, for points and cells of `from`.
    fn of(from: &Transit<P>) -> Self {
        let transit = Transit { points: PointBatch::default(), cells: Vec::new() };
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
            let place = if v == INFINITE { INFINITE } else { self.point(from, v & !CARRIED) | v & CARRIED };
            self.transit.cells.push(place);
        }
    }
}

/// Foreign points beyond its halo that a piece of so many makes room for: somewhat more than random points need. Memory
/// that is not written to is not used.
fn expected_foreign<P: Point>(home: u32) -> usize {
    let layer = f64::from(home).powf((P::DIM - 1) as f64 / P::DIM as f64);
    (LAYERS * layer) as usize
}

impl<P: Point> Worker<P> {
    /// Triangulates the home points and the halo that came.
    pub(crate) fn begin_pieces(&mut self) {
        let home = self.table.home;
        if home == 0 {
            return;
        }
        let piece = self.subdomain.tree.as_ref().map_or(NodeId::ROOT, |t| t.0);
        let _span = self.out.site().subproblem(Phase::Pieces, piece, "triangulate piece", u64::from(home));
        let mut foreign = std::mem::take(&mut self.seams.arrived);
        let more = if self.subdomain.path.is_empty() { 0 } else { expected_foreign::<P>(home) };
        let mut built = Piece::new(&self.table.positions, home, &foreign, more, &self.config.stop);
        if built.is_none() {
            // A flat piece: points of the frame are real points, so they may stand in any star.
            let frame = self.table.intern_all(&self.frame);
            foreign.extend(frame.into_iter().filter(|&v| v >= home));
            foreign.sort_unstable();
            foreign.dedup();
            built = Piece::new(&self.table.positions, home, &foreign, more, &self.config.stop);
        }
        self.stars.set_piece(built);
        self.note_ghosts(foreign);
    }

    /// Sends the vertices of cells that reach out beyond their halos.
    pub(crate) fn begin_seam(&mut self) {
        let open = self.border().map_or_else(Vec::new, |mut border| border.survey());
        self.seams.margins = Vec::new();
        self.send_cells_out(&open);
    }

    /// Inserts the last foreign points.
    pub(crate) fn finish_seams(&mut self) {
        self.seams.sent = HashSet::default();
        let arrived = std::mem::take(&mut self.seams.arrived);
        let Some(mut piece) = self.stars.take_piece() else { return };
        let id = self.subdomain.tree.as_ref().map_or(NodeId::ROOT, |t| t.0);
        let _span = self.out.site().subproblem(self.phase, id, "insert ghosts", arrived.len() as u64);

        piece.add(&arrived, &self.table.positions, &self.config.stop);
        self.stars.set_piece(Some(piece));
        self.note_ghosts(arrived);
    }

    fn note_ghosts(&mut self, foreign: Vec<u32>) {
        self.ghosts.add_to_first(foreign);
    }

    /// The rank that holds a leaf which this worker is asked for, if it is another.
    pub(crate) fn relayed(&self, node: NodeId) -> Option<Rank> {
        self.subdomain
            .relay
            .filter(|&(at, holder)| at == node && holder != self.rank)
            .map(|(_, holder)| holder)
    }

    /// Sends the vertices of cells to where the cells reach.
    fn send_cells_out(&mut self, cells: &[Outgoing<P::Cell>]) {
        let mut transit = Transit { points: PointBatch::default(), cells: Vec::new() };
        let mut places = vec![INFINITE; if cells.is_empty() { 0 } else { self.table.positions.len() }];
        let mut rows: Vec<P::Cell> = Vec::with_capacity(cells.len());
        for out in cells {
            let mut row = out.cell;
            for (i, v) in row.as_mut().iter_mut().enumerate().filter(|(_, v)| **v != INFINITE) {
                let place = &mut places[*v as usize];
                if *place == INFINITE {
                    *place = transit.points.len() as u32;
                    self.table.export(*v, &mut transit.points);
                }
                *v = if out.sent >> i & 1 == 1 { *place } else { *place | CARRIED };
            }
            rows.push(row);
        }
        let mut parcels = BTreeMap::new();
        for (row, out) in rows.iter().zip(cells) {
            for i in ones(out.levels) {
                self.pack(&transit, row, (i, 1 - self.subdomain.path[i].mine), &mut parcels);
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
            let reach = reach_of::<P>(&cell, |v| transit.points.positions[(v & !CARRIED) as usize]);
            if self.walk_path(transit, &cell, &reach, start, &mut parcels) {
                for &v in row.iter().filter(|&&v| v & CARRIED == 0) {
                    mine[v as usize] = true;
                }
            }
        }
        self.send_parcels(parcels);
        for at in (0..mine.len()).filter(|&at| mine[at]) {
            self.arrive(&transit.points, at);
        }
    }

    fn send_parcels(&mut self, parcels: Parcels<P>) {
        for ((i, side), parcel) in parcels.into_iter().filter(|(_, p)| !p.transit.points.is_empty()) {
            let shared = &self.subdomain.path[i];
            let (to, node) = (shared.member_below(self.rank, side), shared.id.child(side));
            let Transit { points, cells } = parcel.transit;
            self.out.send(to, node, 0, Body::Seam { points, cells: Bulk(cells) });
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
        for i in start..self.subdomain.path.len() {
            let shared = &self.subdomain.path[i];
            let (mine, goes_on) = (shared.mine, shared.goes_on);
            if reaches(&shared.split, reach, 1 - mine) {
                self.pack(transit, cell, (i, 1 - mine), parcels);
            }
            let reached = reaches(&self.subdomain.path[i].split, reach, mine);
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
        let child = &self.subdomain.path[to.0].children[to.1];
        let parcel = parcels.entry(to).or_insert_with(|| Parcel::of(transit));
        if child.ranks > 1 && !child.leaf {
            parcel.cell(&transit.points, cell);
            return;
        }
        // Nobody further down has to know why: the points alone, each once.
        for &v in cell.as_ref().iter().filter(|&&v| v & CARRIED == 0) {
            if parcel.places[v as usize] != INFINITE {
                continue;
            }
            let key = transit.points.ids[v as usize] << 7 | (to.0 << 1 | to.1) as u64;
            if self.seams.sent.insert(key) {
                parcel.point(&transit.points, v);
            } else {
                parcel.places[v as usize] = LEFT_OUT;
            }
        }
    }

    /// A point that may be a neighbour of a home point.
    pub(crate) fn arrive(&mut self, points: &PointBatch<P>, at: usize) {
        self.table.arrive(points, at, self.rank, &mut self.seams.arrived);
    }

    /// Points sent here, or through here.
    pub(crate) fn on_seam(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Seam { points, cells } => {
                let (points, cells) = (std::mem::take(points), std::mem::take(&mut cells.0));
                received.push((m.node, Transit { points, cells }));
                false
            }
            _ => true,
        });
        for (node, transit) in received {
            if let Some(holder) = self.relayed(node) {
                let Transit { points, cells } = transit;
                self.out.send(holder, node, 0, Body::Seam { points, cells: Bulk(cells) });
                continue;
            }
            let start =
                self.subdomain.path.iter().position(|s| s.id == node).unwrap_or(self.subdomain.path.len());
            if start == self.subdomain.path.len() && transit.cells.is_empty() {
                (0..transit.points.len()).for_each(|at| self.arrive(&transit.points, at));
            } else {
                self.route(&transit, start);
            }
        }
    }
}
