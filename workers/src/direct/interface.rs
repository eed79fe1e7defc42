//! The interface exchange of `triangulate`, which completes the stars of all owned points.
//!
//! **Statement.** Let `P` be the set of all points and `DT(X)` the perturbed, hence generic, Delaunay triangulation of
//! `X`. The *conflict region* of a cell is its closed circumball, or the closed half-space beyond its hull facet. It
//! contains every point in conflict with the cell ([`septet_geometry::conflict_region::ConflictRegion`]). The *region*
//! of a worker lies on its side of every separator on its path from the root of the tree. Let a worker own the points
//! `B` and hold any ghosts `G`. Suppose that every worker sends each `b` in its `B` to each worker whose region meets
//! the conflict region of a cell of `b` in `DT(B + G)`. Then:
//! 1. Every worker holds all neighbours in `DT(P)` of its owned points.
//! 2. In the triangulation of the points that it holds, each owned point has the same star as in `DT(P)`.
//!
//! *Proof of 1.* Let `ab` be an edge of `DT(P)`, `b` in `B`, and `a` owned by another worker `W`. It suffices to show
//! that `a` lies in the conflict region of a cell of `b`. The point `a` also lies in the region of `W`, so the two
//! regions meet and `b` is sent to `W`. A Delaunay edge persists if other points are removed, so `ab` is an edge of
//! `DT(B + G + a)`.
//! - *`a` is in `G`.* Then `ab` is an edge of a cell of `DT(B + G)`. Its conflict region is closed and contains `a`.
//! - *`a` is not in `G`.* Then inserting `a` makes it adjacent to `b`. So `a` conflicts with a cell of `b`.
//!
//! *Proof of 2.* A vertex and its neighbours in `DT(P)` determine its star. Further points do not change this star.
//! QED.
//!
//! One exchange therefore suffices for any `G`. With the ghost layer as `G` ([`crate::direct::ghost_layer`]), most
//! cells of a subdomain triangulation are also cells of `DT(P)`. Few conflict regions extend beyond the halo balls of
//! their vertices, and a vertex was already sent to every worker that its halo ball meets. A ghost that arrives in this
//! exchange is skipped if it would have no owned neighbour ([`SubdomainTriangulation::add`] has an exception for large
//! cavities).
//!
//! **Rounds.** At most one per shared level.
//!
//! **Work.** For each vertex at the interface, one clearance per level
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)). For each cell that the clearance of
//! its vertex does not exclude, one test per level. In addition, the insertion of the late ghosts; well-spaced sets
//! have `O(n^(1-1/d))` of them.
//!
//! The certificate does not rely on this proof.

use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use crate::direct::ghost_layer::GhostLayer;
use crate::direct::interface_cells::{InterfaceCells, Outgoing, reaches};
use crate::direct::subdomain_triangulation::{SubdomainTriangulation, conflict_region};
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::{Shared, Subdomain, Way};
use crate::state::table::{IdHasher, Table};

/// The points of a message, and the cells that require them.
struct CellBatch<P> {
    points: PointBatch<P>,
    /// `d + 1` entries per cell, each an index in `points` or [`INFINITE`]. An index with the mark [`SHAPE_ONLY`] is a
    /// vertex that only defines the cell.
    cells: Vec<u32>,
}

impl<P> CellBatch<P> {
    fn into_body(self) -> Body<P> {
        Body::Seam { points: self.points, cells: Bulk(self.cells) }
    }
}

impl<P> Default for CellBatch<P> {
    fn default() -> Self {
        CellBatch { points: PointBatch::default(), cells: Vec::new() }
    }
}

/// The mark of a vertex that the receiver needs to compute the conflict region, but does not keep.
const SHAPE_ONLY: u32 = 1 << 31;

/// The points and cells of a batch that go to one receiver.
struct Parcel<P> {
    batch: CellBatch<P>,
    /// For each point of the source, its index in `batch`, or [`OMITTED`], or [`INFINITE`] before the point is
    /// considered.
    indices: Vec<u32>,
}

/// The index of a point that was already sent to the receiver in another message.
const OMITTED: u32 = INFINITE - 1;

/// The parcels, keyed by the place at which they leave the path.
type Parcels<P> = BTreeMap<Way, Parcel<P>>;

impl<P: Point> Parcel<P> {
    /// Creates an empty parcel for points and cells of `source`.
    fn new(source: &CellBatch<P>) -> Self {
        Parcel { batch: CellBatch::default(), indices: vec![INFINITE; source.points.len()] }
    }

    /// Adds point `at` of the source unless the parcel already contains it. Returns its index in the parcel.
    fn add_point(&mut self, source: &PointBatch<P>, at: u32) -> u32 {
        let (i, points) = (at as usize, &mut self.batch.points);
        let index = &mut self.indices[i];
        if *index == INFINITE {
            *index = points.len() as u32;
            points.push(source.ids[i], source.positions[i], source.owners[i], source.radii2[i]);
        }
        *index
    }

    /// Adds a cell of the source with all its vertices.
    fn add_cell(&mut self, source: &PointBatch<P>, cell: &P::Cell) {
        for &v in cell.as_ref() {
            let index = if v == INFINITE {
                INFINITE
            } else {
                self.add_point(source, v & !SHAPE_ONLY) | v & SHAPE_ONLY
            };
            self.batch.cells.push(index);
        }
    }
}

/// Sends the vertices of cells that extend beyond the ghost layer to the workers whose regions these cells reach.
/// Returns the ghosts that arrived, as local indices.
pub(crate) async fn interface<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    triangulation: Option<&SubdomainTriangulation<P>>,
    layer: GhostLayer,
) -> Result<Vec<u32>, TransportError> {
    cx.enter(Phase::Seam)?;
    let mut router = Router { subdomain, sent: HashSet::default() };
    let outgoing = triangulation.filter(|_| !subdomain.path().is_empty()).map_or_else(Vec::new, |own| {
        InterfaceCells::new(subdomain.path(), own, table.positions(), layer.margins()).scan()
    });
    drop(layer);
    router.send_outgoing(cx, table, &outgoing);
    drop(outgoing);
    let mut arrived = Vec::new();
    while cx.exchange().await? {
        for (node, batch) in take_batches(cx) {
            let received = subdomain.receive(cx, node, batch, CellBatch::into_body);
            let Some((start, batch)) = received else { continue };
            let arrivals = router.forward(cx, &batch, start);
            for at in (0..batch.points.len()).filter(|&at| arrivals.contain(at)) {
                table.arrive(&batch.points, at, cx.rank(), &mut arrived);
            }
        }
    }
    Ok(arrived)
}

/// Inserts the ghosts of the interface exchange. The triangulation then contains the stars of all owned points.
pub(crate) async fn insert<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    mut triangulation: Option<SubdomainTriangulation<P>>,
    ghosts: &mut Ghosts,
    arrived: Vec<u32>,
) -> Result<Option<SubdomainTriangulation<P>>, TransportError> {
    cx.enter(Phase::Hulls)?;
    if let Some(own) = &mut triangulation {
        let at = subdomain.root();
        let _span = cx.site().subproblem(Phase::Hulls, at, "insert ghosts", arrived.len() as u64);
        own.add(&arrived, table.positions(), &cx.config().stop);
        ghosts.add_to_first(arrived);
    }
    while cx.exchange().await? {}
    Ok(triangulation)
}

fn take_batches<P: Point>(cx: &mut Context<P>) -> Vec<(NodeId, CellBatch<P>)> {
    cx.take(|m| match &mut m.body {
        Body::Seam { points, cells } => {
            let (points, cells) = (std::mem::take(points), std::mem::take(&mut cells.0));
            Some((m.node, CellBatch { points, cells }))
        }
        _ => None,
    })
}

/// The points of a batch that this rank keeps as ghosts.
enum Arrivals {
    All,
    /// Whether each point is kept.
    Some(Vec<bool>),
}

impl Arrivals {
    fn contain(&self, at: usize) -> bool {
        match self {
            Arrivals::All => true,
            Arrivals::Some(marks) => marks[at],
        }
    }
}

/// Sends points along the path of this rank. If one rank holds a child, it sends each point to that rank at most once.
struct Router<'a, P> {
    subdomain: &'a Subdomain<P>,
    /// The keys ([`sent_key`]) of the points already sent to children that one rank holds.
    sent: HashSet<u64, BuildHasherDefault<IdHasher>>,
}

/// Returns the key of a point that leaves the path at `way`. A path has at most 64 levels, so level and side fit into
/// seven bits.
fn sent_key(id: u64, way: Way) -> u64 {
    id << 7 | (way.level << 1 | way.side) as u64
}

impl<P: Point> Router<'_, P> {
    /// Sends the vertices of outgoing cells to the other sides of the separators that the cells cross.
    fn send_outgoing(&mut self, cx: &mut Context<P>, table: &Table<P>, outgoing: &[Outgoing<P::Cell>]) {
        let mut batch = CellBatch::default();
        let mut indices = vec![INFINITE; if outgoing.is_empty() { 0 } else { table.positions().len() }];
        let mut rows: Vec<P::Cell> = Vec::with_capacity(outgoing.len());
        for out in outgoing {
            let mut row = out.cell;
            for (i, v) in row.as_mut().iter_mut().enumerate().filter(|(_, v)| **v != INFINITE) {
                let index = &mut indices[*v as usize];
                if *index == INFINITE {
                    *index = batch.points.len() as u32;
                    table.export(*v, &mut batch.points);
                }
                *v = if out.sent >> i & 1 == 1 { *index } else { *index | SHAPE_ONLY };
            }
            rows.push(row);
        }
        let mut parcels = BTreeMap::new();
        for (row, out) in rows.iter().zip(outgoing) {
            for level in ones(out.levels) {
                let side = 1 - self.subdomain.path()[level].mine();
                self.pack(&batch, row, Way { level, side }, &mut parcels);
            }
        }
        self.send_parcels(cx, parcels);
    }

    /// Forwards the cells of a batch from position `start` of the path. Returns the points that this rank keeps.
    fn forward(&mut self, cx: &mut Context<P>, batch: &CellBatch<P>, start: usize) -> Arrivals {
        if start == self.subdomain.path().len() && batch.cells.is_empty() {
            return Arrivals::All;
        }
        let subdomain = self.subdomain;
        let mut parcels: Parcels<P> = BTreeMap::new();
        let mut arrives: Vec<bool> = vec![false; batch.points.len()];
        for row in batch.cells.chunks_exact(P::DIM + 1) {
            let mut cell = P::Cell::splat(0);
            cell.as_mut().copy_from_slice(row);
            let region = conflict_region::<P>(&cell, |v| batch.points.positions[(v & !SHAPE_ONLY) as usize]);
            let reach =
                |_: usize, shared: &Shared<P>| [0, 1].map(|side| reaches(shared.split(), &region, side));
            if subdomain.follow(start, reach, |way| self.pack(batch, &cell, way, &mut parcels)) {
                for &v in row.iter().filter(|&&v| v & SHAPE_ONLY == 0) {
                    arrives[v as usize] = true;
                }
            }
        }
        self.send_parcels(cx, parcels);
        Arrivals::Some(arrives)
    }

    fn send_parcels(&self, cx: &mut Context<P>, parcels: Parcels<P>) {
        let rank = cx.rank();
        let filled = parcels.into_iter().filter(|(_, parcel)| !parcel.batch.points.is_empty());
        cx.route(filled.map(|(way, parcel)| (self.subdomain.beyond(way, rank), parcel.batch.into_body())));
    }

    /// Adds a cell of `batch` to the parcel that leaves the path at `way`. If one rank holds that child, adds only the
    /// points that have not been sent to the rank.
    fn pack(&mut self, batch: &CellBatch<P>, cell: &P::Cell, way: Way, parcels: &mut Parcels<P>) {
        let child = self.subdomain.path()[way.level].children()[way.side];
        let parcel = parcels.entry(way).or_insert_with(|| Parcel::new(batch));
        if child.ranks > 1 && !child.leaf {
            parcel.add_cell(&batch.points, cell);
            return;
        }
        for &v in cell.as_ref().iter().filter(|&&v| v & SHAPE_ONLY == 0) {
            if parcel.indices[v as usize] != INFINITE {
                continue;
            }
            if self.sent.insert(sent_key(batch.points.ids[v as usize], way)) {
                parcel.add_point(&batch.points, v);
            } else {
                parcel.indices[v as usize] = OMITTED;
            }
        }
    }
}
