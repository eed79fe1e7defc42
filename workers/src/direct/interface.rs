//! The seams between pieces, where only the answer is wanted.
//!
//! **Statement.** Let `B` be the home points of a worker and `G` any other points, and let every home point `b`
//! be sent to each worker whose region is met by what holds the conflicts of a cell of `b` in the triangulation
//! of `B + G` ([`septet_geometry::conflict_region::ConflictRegion`]: the closed ball, beyond the hull a closed half-space). Then
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
//! So one sending suffices, whatever `G` is. `G` is the halo ([`crate::direct::ghost_layer`]), so that the cells of a piece are nearly
//! those of the whole: few reach farther than the halos of their vertices, and a vertex has been sent to all that its
//! halo meets. Points that come now are left out where they are nobody's neighbours ([`crate::direct::subdomain_triangulation`]).
//!
//! **Rounds.** At most one a shared level. **Work.** One clearance a level for each vertex at the border
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), one test a level for each cell whose
//! ball is not clear of the border by that of a vertex, and the insertion of what comes: `O(n^(1-1/d))` points for
//! well-spaced sets.
//!
//! The certificate does not rely on any of this.

use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::complex::INFINITE;
use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use crate::direct::ghost_layer::Margin;
use crate::direct::interface_cells::{InterfaceCells, Outgoing, reaches};
use crate::direct::subdomain_triangulation::{SubdomainTriangulation, reach_of};
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::Subdomain;
use crate::state::table::{IdHasher, Table};

/// Points on their way, with the cells that send them.
struct Transit<P> {
    points: PointBatch<P>,
    /// Positions in `points`, `d + 1` a cell; [`INFINITE`]; and marked [`CARRIED`] what only gives the cell its shape.
    cells: Vec<u32>,
}

impl<P> Transit<P> {
    fn into_body(self) -> Body<P> {
        Body::Seam { points: self.points, cells: Bulk(self.cells) }
    }
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

/// Sends the vertices of cells that reach beyond their ghost layers to the workers that these cells reach. Returns the
/// ghosts that arrived, by local numbers.
pub(crate) async fn interface<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    piece: Option<&SubdomainTriangulation<P>>,
    margins: Vec<Margin>,
) -> Result<Vec<u32>, TransportError> {
    cx.enter(Phase::Seam)?;
    let mut router = Router { subdomain, sent: HashSet::default() };
    let open = piece.filter(|_| !subdomain.path().is_empty()).map_or_else(Vec::new, |piece| {
        InterfaceCells::of(subdomain.path(), piece, table.positions(), &margins).scan()
    });
    drop(margins);
    router.send_cells_out(cx, table, &open);
    drop(open);
    let mut arrived = Vec::new();
    while cx.exchange().await? {
        for (node, transit) in take_transits(cx) {
            if let Some(holder) = subdomain.relayed(node, cx.rank) {
                cx.send(holder, node, 0, transit.into_body());
                continue;
            }
            let mine = router.route(cx, &transit, subdomain.position(node));
            for at in (0..transit.points.len()).filter(|&at| mine.holds(at)) {
                table.arrive(&transit.points, at, cx.rank, &mut arrived);
            }
        }
    }
    Ok(arrived)
}

/// Inserts the ghosts that arrived last. The piece then holds the stars of all owned points.
pub(crate) async fn insert<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    mut piece: Option<SubdomainTriangulation<P>>,
    ghosts: &mut Ghosts,
    arrived: Vec<u32>,
) -> Result<Option<SubdomainTriangulation<P>>, TransportError> {
    cx.enter(Phase::Hulls)?;
    if let Some(piece) = &mut piece {
        let at = subdomain.root();
        let _span = cx.site().subproblem(Phase::Hulls, at, "insert ghosts", arrived.len() as u64);
        piece.add(&arrived, table.positions(), &cx.config.stop);
        ghosts.add_to_first(arrived);
    }
    while cx.exchange().await? {}
    Ok(piece)
}

fn take_transits<P: Point>(cx: &mut Context<P>) -> Vec<(NodeId, Transit<P>)> {
    cx.take(|m| match &mut m.body {
        Body::Seam { points, cells } => {
            let (points, cells) = (std::mem::take(points), std::mem::take(&mut cells.0));
            Some((m.node, Transit { points, cells }))
        }
        _ => None,
    })
}

/// Which points of a transit reach this rank's own piece.
enum Mine {
    All,
    Some(Vec<bool>),
}

impl Mine {
    fn holds(&self, at: usize) -> bool {
        match self {
            Mine::All => true,
            Mine::Some(marks) => marks[at],
        }
    }
}

/// Sends cells along the path of the tree.
struct Router<'a, P> {
    subdomain: &'a Subdomain<P>,
    /// Points sent to children of one rank: owned point, position on the path, and side.
    sent: HashSet<u64, BuildHasherDefault<IdHasher>>,
}

impl<P: Point> Router<'_, P> {
    /// Sends the vertices of cells to where the cells reach.
    fn send_cells_out(&mut self, cx: &mut Context<P>, table: &Table<P>, cells: &[Outgoing<P::Cell>]) {
        let mut transit = Transit { points: PointBatch::default(), cells: Vec::new() };
        let mut places = vec![INFINITE; if cells.is_empty() { 0 } else { table.positions().len() }];
        let mut rows: Vec<P::Cell> = Vec::with_capacity(cells.len());
        for out in cells {
            let mut row = out.cell;
            for (i, v) in row.as_mut().iter_mut().enumerate().filter(|(_, v)| **v != INFINITE) {
                let place = &mut places[*v as usize];
                if *place == INFINITE {
                    *place = transit.points.len() as u32;
                    table.export(*v, &mut transit.points);
                }
                *v = if out.sent >> i & 1 == 1 { *place } else { *place | CARRIED };
            }
            rows.push(row);
        }
        let mut parcels = BTreeMap::new();
        for (row, out) in rows.iter().zip(cells) {
            for i in ones(out.levels) {
                self.pack(&transit, row, (i, 1 - self.subdomain.path()[i].mine()), &mut parcels);
            }
        }
        self.send_parcels(cx, parcels);
    }

    /// Sends cells on along the path, from a position on it. Returns the points that reach this rank's own piece.
    fn route(&mut self, cx: &mut Context<P>, transit: &Transit<P>, start: usize) -> Mine {
        if start == self.subdomain.path().len() && transit.cells.is_empty() {
            return Mine::All;
        }
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
        self.send_parcels(cx, parcels);
        Mine::Some(mine)
    }

    fn send_parcels(&self, cx: &mut Context<P>, parcels: Parcels<P>) {
        for ((i, side), parcel) in parcels.into_iter().filter(|(_, p)| !p.transit.points.is_empty()) {
            let shared = &self.subdomain.path()[i];
            let (to, node) = (shared.member_below(cx.rank, side), shared.id().child(side));
            cx.send(to, node, 0, parcel.transit.into_body());
        }
    }

    /// Puts a cell into the parcels of all it reaches. Does it reach this worker's piece?
    fn walk_path(
        &mut self,
        transit: &Transit<P>,
        cell: &P::Cell,
        reach: &ConflictRegion<P>,
        start: usize,
        parcels: &mut Parcels<P>,
    ) -> bool {
        for i in start..self.subdomain.path().len() {
            let shared = &self.subdomain.path()[i];
            let (mine, goes_on) = (shared.mine(), shared.goes_on());
            if reaches(shared.split(), reach, 1 - mine) {
                self.pack(transit, cell, (i, 1 - mine), parcels);
            }
            let reached = reaches(self.subdomain.path()[i].split(), reach, mine);
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
        let child = &self.subdomain.path()[to.0].children()[to.1];
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
            if self.sent.insert(key) {
                parcel.point(&transit.points, v);
            } else {
                parcel.places[v as usize] = LEFT_OUT;
            }
        }
    }
}
