//! The triangulation of a worker's subdomain, which `triangulate` computes as a whole.
//!
//! The stars of all owned points come from one triangulation. They therefore agree on each cell whose vertices are all
//! owned. Workers have to agree only on cells with vertices of several workers. Links are extracted only if stars have
//! to be compared or changed one by one.

use septet_geometry::complex::INFINITE;
use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::dependence::Dependence;
use septet_geometry::incremental::{
    Incremental, KeptCells, Operations, STOP_CHECK_INTERVAL, facet_without, insertion_order, insertion_round,
};
use septet_geometry::point::{Point, dist2};
use septet_protocol::checksum::row_hash;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Merged, PointBatch, UNKNOWN_RADIUS2};
use septet_protocol::transport::TransportError;

use crate::config::{Growth, STEP, Stop};
use crate::direct::first_coordinates::FirstCoordinates;
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::ghosts::Ghosts;
use crate::state::link_arena::LinkArena;
use crate::state::rows::{AdjacencyRows, HULL, INTERFACE};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// The Delaunay triangulation of a worker's owned points and ghosts; with weights, the regular triangulation. The owned
/// points are its first vertices, in the order of their local indices.
#[derive(Debug)]
pub(crate) struct SubdomainTriangulation<P: Point> {
    delaunay: Incremental<P>,
    /// The local index of each ghost, in the order of the vertices.
    ghosts: Vec<u32>,
    /// Number of owned points.
    owned: u32,
    /// The largest weight of all ranks; 0 without weights.
    heaviest: f64,
    /// The cells that belong to this worker; empty before [`SubdomainTriangulation::scan`].
    kept: KeptCells,
    /// The counts of the owned stars; zero before the scan.
    merged: Merged,
    /// The bytes of the triangulation.
    growth: Growth,
}

/// This bit of an owned vertex is set when a finite cell of the vertex has been found.
const HAS_CELL: u8 = 1;

/// This bit of an owned vertex is set when a lexicographically smaller neighbour has been found.
const HAS_SMALLER: u8 = 2;

/// Sets the bits that a cell implies for its vertices. `finite` is [`HAS_CELL`] if the cell is finite, otherwise 0.
fn note_vertices(vertices: &[u32], smallest: u32, finite: u8, seen: &mut [u8]) {
    for &v in vertices {
        if let Some(seen) = seen.get_mut(v as usize) {
            *seen |= finite | if v == smallest { 0 } else { HAS_SMALLER };
        }
    }
}

impl<P: Point> SubdomainTriangulation<P> {
    /// Triangulates the owned points and the ghosts among `others`. The owned points have the indices below `owned`,
    /// in insertion order. No point of any rank is heavier than `heaviest`. `others` are distinct local indices, and
    /// `more` is the number of further points for which memory is reserved. Returns `None` if all points lie in a plane, if there are too many, or if the run is
    /// stopped.
    pub(super) fn new(
        positions: &[P],
        (owned, heaviest): (u32, f64),
        others: &[u32],
        more: usize,
        stop: &Stop,
    ) -> Option<Self> {
        let unordered: Vec<u32> = others.iter().copied().filter(|&v| v >= owned).collect();
        let at: Vec<P> = unordered.iter().map(|&v| positions[v as usize]).collect();
        let ghosts: Vec<u32> = insertion_order(&at).into_iter().map(|i| unordered[i as usize]).collect();
        let mut points = Vec::with_capacity(owned as usize + ghosts.len() + more);
        points.extend_from_slice(&positions[..owned as usize]);
        points.extend(ghosts.iter().map(|&v| positions[v as usize]));
        let order = in_rounds(&points, owned as usize);
        let mut growth = stop.growth();
        let go_on = &mut |bytes| stop.admits(&mut growth, bytes);
        let delaunay = Incremental::build_below((points, heaviest), order, go_on).ok()?;
        let (kept, merged) = (KeptCells::default(), Merged::default());
        Some(SubdomainTriangulation { delaunay, ghosts, owned, heaviest, kept, merged, growth })
    }

    /// Inserts late ghosts, given as local indices. Skips a ghost that would have no owned neighbour, because later
    /// points cannot give it one. The exception is a ghost with a large cavity ([`Incremental::insert_if_adjacent`]).
    /// A ghost that is already a vertex does not change the triangulation. Ends early if the run is stopped. Returns the
    /// operations of the insertions.
    pub(super) fn add(&mut self, ghosts: &[u32], positions: &[P], stop: &Stop) -> Operations {
        self.delaunay.take_operations();
        let points: Vec<P> = ghosts.iter().map(|&g| positions[g as usize]).collect();
        let mut next = 0;
        for (count, i) in insertion_order(&points).into_iter().enumerate() {
            let bytes = self.delaunay.bytes();
            if count.is_multiple_of(STOP_CHECK_INTERVAL) || bytes >= next {
                if !stop.admits(&mut self.growth, bytes) {
                    break;
                }
                next = bytes + STEP;
            }
            if let Ok(Some(_)) = self.delaunay.insert_if_adjacent(points[i as usize], None, self.owned) {
                self.ghosts.push(ghosts[i as usize]);
            }
        }
        self.delaunay.take_operations()
    }

    /// Returns an upper bound on the circumradius of a finite cell, or NaN.
    #[inline]
    pub(super) fn radius_bound(&self, slot: u32) -> f64 {
        self.delaunay.radius_bound(slot)
    }

    /// Returns the circumradius of a finite cell in the kernel's units, to be compared with
    /// [`SubdomainTriangulation::radius_within`].
    #[inline]
    pub(super) fn rounded_radius(&self, slot: u32) -> f32 {
        self.delaunay.rounded_radius(slot)
    }

    /// Returns the largest rounded radius for which a circumball lies within the distance `across` of each vertex. If
    /// there is no such radius, returns 0, which is below every radius.
    pub(super) fn radius_within(&self, across: f64) -> f32 {
        self.delaunay.radius_within(across)
    }

    /// Returns the number of slots of cells.
    pub(super) fn slots(&self) -> u32 {
        self.delaunay.complex().slots()
    }

    /// Calls `f` with the slot and the vertices of every cell that has an owned vertex. Vertices are local indices.
    /// Infinite cells have the vertex [`INFINITE`].
    pub(super) fn each_cell(&self, mut f: impl FnMut(u32, &P::Cell)) {
        for (slot, cell, _) in self.delaunay.complex().entries() {
            let ghosts = cell.as_ref().iter().filter(|&&v| v >= self.owned).count();
            if ghosts == 0 {
                f(slot, cell);
            } else if ghosts <= P::DIM {
                f(slot, &self.to_local(cell));
            }
        }
    }

    /// Returns the first owned vertex of the cell in a slot. Returns `None` for a removed cell and for a cell without
    /// owned vertices.
    #[inline]
    pub(super) fn owned_vertex(&self, slot: u32) -> Option<u32> {
        let cells = self.delaunay.complex();
        let first = cells.cell(slot).as_ref().iter().copied().find(|&v| v < self.owned);
        first.filter(|_| cells.is_live(slot))
    }

    /// Returns the vertices of the cell in a slot, in the kernel's numbering. These are the local indices of owned
    /// vertices; [`SubdomainTriangulation::to_local`] converts the others.
    #[inline]
    pub(super) fn vertices(&self, slot: u32) -> &P::Cell {
        self.delaunay.complex().cell(slot)
    }

    /// Converts the kernel's vertex numbers of a cell to local indices.
    pub(super) fn to_local(&self, cell: &P::Cell) -> P::Cell {
        let mut local = *cell;
        for v in local.as_mut().iter_mut().filter(|v| **v >= self.owned && **v != INFINITE) {
            *v = self.ghosts[(*v - self.owned) as usize];
        }
        local
    }

    /// Returns a region that contains every point in conflict with a cell, given by its slot and local indices. The
    /// kernel already stores a rounded sphere, which is used if it is hardly larger than the exact one.
    pub(super) fn conflict_region(&self, slot: u32, cell: &P::Cell, positions: &[P]) -> ConflictRegion<P> {
        if self.radius_bound(slot) > self.delaunay.extent() / FINEST
            && let Some((centre, radius2)) = self.delaunay.ball(slot)
        {
            return ConflictRegion::Ball { centre, radius: radius2.sqrt() * (1.0 + f64::EPSILON) };
        }
        conflict_region::<P>(cell, self.heaviest, |v| positions[v as usize])
    }

    /// Returns the owned points that are hidden, as local indices.
    pub(crate) fn hidden(&self) -> impl Iterator<Item = u32> + '_ {
        (0..if P::IS_WEIGHTED { self.owned } else { 0 }).filter(|&v| self.delaunay.is_hidden(v))
    }

    /// Returns the hidden owned points with a cell below each of them, as local indices.
    pub(crate) fn covers(&self) -> impl Iterator<Item = (u32, P::Cell)> + '_ {
        self.hidden().map(|v| (v, self.to_local(&self.delaunay.cover_of(v))))
    }

    /// Scans all cells once. Counts the contribution of the owned stars to the merged result. Finds the cells that
    /// belong to this worker, which are those whose smallest vertex is owned. Calls `mixed` with each finite cell that
    /// has both owned vertices and ghosts, and with its smallest vertex, all as local indices.
    pub(crate) fn scan(&mut self, positions: &[P], mut mixed: impl FnMut(&P::Cell, u32)) {
        let firsts = FirstCoordinates::new(positions);
        let mut kept = KeptCells::of(self.slots());
        // The last entry represents all vertices that are not owned. No bit is ever set in it.
        let mut seen = vec![0u8; self.owned as usize + 1];
        // A hidden site needs no star, and is not the smallest vertex.
        for v in self.hidden() {
            seen[v as usize] = HAS_CELL | HAS_SMALLER;
        }
        let mut cell_hash = 0;
        let others = self.scan_owned(&firsts, &mut seen, &mut kept, &mut cell_hash);
        seen.truncate(self.owned as usize);
        let hull_facets = self.scan_interface(&others, &firsts, &mut seen, &mut kept, |cell, smallest| {
            if smallest < self.owned {
                cell_hash = cell_hash.wrapping_add(row_hash(cell.as_ref()));
            }
            mixed(cell, smallest);
        });
        self.merged = Merged {
            cells: u64::from(kept.len()),
            stars: seen.iter().filter(|&&s| s & HAS_CELL != 0).count() as u64,
            minima: seen.iter().filter(|&&s| s & HAS_SMALLER == 0).count() as u64,
            hull_facets,
            cell_hash,
            ..Merged::default()
        };
        self.kept = kept;
    }

    /// Scans the cells whose vertices are all owned, and adds their hashes to `cell_hash`. Returns the slots of the others.
    fn scan_owned(
        &self,
        firsts: &FirstCoordinates<'_, P>,
        seen: &mut [u8],
        kept: &mut KeptCells,
        cell_hash: &mut u64,
    ) -> Vec<u32> {
        let cells = self.delaunay.complex();
        let mut others = Vec::new();
        for word in 0..self.slots().div_ceil(u64::BITS) {
            // For nearly every cell, both bits of all vertices are already set. Such a cell has only owned vertices and
            // sets no new bit.
            let (live, known) = self.delaunay.masks(word as usize, |cell| {
                let bits = |v: u32| seen[v.min(self.owned) as usize];
                let both = HAS_CELL | HAS_SMALLER;
                cell.as_ref().iter().fold(both, |all, &v| all & bits(v)) == both
            });
            let mut owned = live & known;
            for i in ones(live & !known) {
                let slot = word * u64::BITS + i as u32;
                let vertices = cells.cell(slot).as_ref();
                if vertices.iter().all(|&v| v < self.owned) {
                    note_vertices(vertices, firsts.smallest(vertices), HAS_CELL, seen);
                    owned |= 1 << i;
                } else {
                    others.push(slot);
                }
            }
            for i in ones(owned) {
                let cell = cells.cell(word * u64::BITS + i as u32);
                *cell_hash = cell_hash.wrapping_add(row_hash(cell.as_ref()));
            }
            kept.keep_word(word as usize, owned);
        }
        others
    }

    /// Scans the cells in the slots `others`, which have a vertex that is not owned. Returns the number of hull facets
    /// that belong to this worker.
    fn scan_interface(
        &self,
        others: &[u32],
        firsts: &FirstCoordinates<'_, P>,
        seen: &mut [u8],
        kept: &mut KeptCells,
        mut mixed: impl FnMut(&P::Cell, u32),
    ) -> u64 {
        let mut hull_facets = 0;
        for &slot in others {
            let cell = self.vertices(slot);
            if cell.as_ref().iter().all(|&v| v >= self.owned) {
                // The cell is in no owned star, so the triangulation of all points might not contain it.
                continue;
            }
            let infinite = cell.as_ref().contains(&INFINITE);
            let cell = &self.to_local(cell);
            let smallest = firsts.smallest(cell.as_ref());
            note_vertices(cell.as_ref(), smallest, if infinite { 0 } else { HAS_CELL }, seen);
            if infinite {
                kept.mark_outer(slot);
                hull_facets += u64::from(smallest < self.owned);
                continue;
            }
            mixed(cell, smallest);
            if smallest < self.owned {
                kept.keep(slot);
            }
        }
        hull_facets
    }

    /// Returns the counts of [`SubdomainTriangulation::scan`] for the merged result.
    pub(crate) fn merged(&self) -> Merged {
        self.merged
    }

    /// Returns the cells that [`SubdomainTriangulation::scan`] found to belong to this worker.
    pub(crate) fn into_rows(self) -> AdjacencyRows {
        let SubdomainTriangulation { delaunay, ghosts, owned, kept, .. } = self;
        let local = |v: u32| if v < owned { v } else { ghosts[(v - owned) as usize] };
        let (rows, open) = delaunay.into_rows(&kept, [INTERFACE, HULL], local);
        AdjacencyRows::new(rows, open)
    }

    /// Returns the squared distance of every owned point to its nearest vertex, which is a neighbour.
    pub(crate) fn nearest_edges(&self) -> Vec<f64> {
        let mut radii2 = vec![UNKNOWN_RADIUS2; self.owned as usize];
        let points = self.delaunay.vertices();
        for cell in self.delaunay.cells() {
            let vertices = cell.as_ref();
            for (i, &a) in vertices.iter().enumerate() {
                for &b in &vertices[..i] {
                    let d2 = dist2(points[a as usize], points[b as usize]);
                    for v in [a, b] {
                        if let Some(r2) = radii2.get_mut(v as usize) {
                            *r2 = r2.min(d2);
                        }
                    }
                }
            }
        }
        radii2
    }

    /// Returns the links of all owned points, as local indices.
    pub(crate) fn links(&self) -> LinkArena<P> {
        let mut lengths = vec![0u32; self.owned as usize];
        self.each_cell(|_, cell| {
            for &v in cell.as_ref() {
                if let Some(len) = lengths.get_mut(v as usize) {
                    *len += 1;
                }
            }
        });
        let mut links = LinkArena::with_capacities(&lengths);
        self.each_cell(|_, cell| {
            for &v in cell.as_ref().iter().filter(|&&v| v < self.owned) {
                links.push(v, facet_without::<P>(cell, v));
            }
        });
        links
    }
}

/// The number of late ghosts for which memory is reserved, as a multiple of `n^((d-1)/d)` for `n` owned points.
/// Random points need slightly less. Reserved memory costs nothing before it is written.
const LAYERS: f64 = 4.0;

/// Triangulates the owned points and the ghosts that arrived. Returns no triangulation if there are no owned points.
///
/// # Errors
/// Fails if the owned points and the frame lie in a plane, because then the frame is not that of the input, or if there
/// are too many points.
pub(crate) async fn triangulate_subdomain<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    mut ghosts: Vec<u32>,
    (frame, heaviest): (&PointBatch<P>, f64),
) -> Result<(Option<SubdomainTriangulation<P>>, Ghosts), TransportError> {
    cx.enter(Phase::Pieces)?;
    let owned = table.owned_len();
    let (mut triangulation, mut held) = (None, Ghosts::default());
    if owned > 0 {
        let _span =
            cx.site().subproblem(Phase::Pieces, subdomain.root(), "triangulate piece", u64::from(owned));
        let more = if subdomain.path().is_empty() { 0 } else { late_ghosts::<P>(owned) };
        let triangulate = |positions: &[P], ghosts: &[u32]| {
            SubdomainTriangulation::new(positions, (owned, heaviest), ghosts, more, &cx.config().stop)
        };
        triangulation = triangulate(table.positions(), &ghosts);
        if triangulation.is_none() {
            // The points may lie in a plane. The frame spans the space, and its points are input points, so they may be
            // in any star.
            let frame = table.intern_all(frame);
            ghosts.extend(frame.into_iter().filter(|&v| v >= owned));
            ghosts.sort_unstable();
            ghosts.dedup();
            triangulation = triangulate(table.positions(), &ghosts);
        }
        charge_piece(cx, subdomain.root(), triangulation.as_ref());
        held.add_to_first(ghosts);
    }
    while cx.exchange().await? {}
    if owned > 0 && triangulation.is_none() {
        let reason = "its points and the frame do not span the space, or are too many".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    }
    Ok((triangulation, held))
}

/// Charges a subdomain triangulation, if the run charges the direct path: as an insertion in random order, whose
/// independent points are inserted at once ([`septet_geometry::dependence`]), or by the operations of the worker.
fn charge_piece<P: Point>(
    cx: &mut Context<P>,
    root: NodeId,
    triangulation: Option<&SubdomainTriangulation<P>>,
) {
    let shown = cx.config().shown;
    let Some(own) = triangulation.filter(|_| shown.charges_direct()) else { return };
    let points = own.delaunay.vertices();
    // Dependences are those of Delaunay triangulations.
    if !shown.with_prices || P::IS_WEIGHTED {
        let mut cost = cx.own_cost();
        own.delaunay.charge(&mut cost);
        cx.charge(Account::member(Phase::Pieces, root), cost, points.len() as u64);
        return;
    }
    if let Ok(made) = Dependence::new(points, cx.config().seed) {
        cx.charge(Account::member(Phase::Pieces, root), made.cost(), points.len() as u64);
    }
}

/// Returns the number of late ghosts for which memory is reserved.
fn late_ghosts<P: Point>(owned: u32) -> usize {
    let layer = f64::from(owned).powf((P::DIM - 1) as f64 / P::DIM as f64);
    (LAYERS * layer) as usize
}

/// The kernel stores spheres in single precision, relative to its extent. For radii above the extent divided by this
/// number, the stored sphere is larger than the exact one by at most a thousandth.
const FINEST: f64 = 4096.0;

/// Merges two sequences of points, each in insertion order; the second begins at `half`. Rounds ascend, and within a
/// round the first sequence precedes the second. Returns the indices of the points in the merged order.
fn in_rounds<P: Point>(points: &[P], half: usize) -> impl Iterator<Item = u32> + use<P> {
    let mut parts = Vec::new();
    let (mut first, mut second) = points.split_at(half);
    while !first.is_empty() || !second.is_empty() {
        let round = |rest: &[P]| rest.first().map_or(u64::MAX, insertion_round);
        let next = round(first).min(round(second));
        for (rest, end) in [(&mut first, half), (&mut second, points.len())] {
            if round(rest) == next {
                let start = end - rest.len();
                let len = round_len(rest);
                parts.push(start as u32..(start + len) as u32);
                *rest = &rest[len..];
            }
        }
    }
    parts.into_iter().flatten()
}

/// Returns the number of points in the round of the first point. The points are in insertion order.
pub(super) fn round_len<P: Point>(points: &[P]) -> usize {
    let Some(round) = points.first().map(insertion_round) else { return 0 };
    // Far points come last, whatever their round is, so the rounds do not ascend everywhere.
    points.iter().position(|p| insertion_round(p) > round).unwrap_or(points.len())
}

/// Returns a region that contains every point in conflict with a cell, of weight at most `heaviest`. `corner` returns a
/// finite vertex.
pub(super) fn conflict_region<P: Point>(
    cell: &P::Cell,
    heaviest: f64,
    corner: impl Fn(u32) -> P,
) -> ConflictRegion<P> {
    let mut corners = [P::default(); 4];
    let mut infinite = None;
    for (slot, &v) in cell.as_ref().iter().enumerate() {
        if v == INFINITE {
            infinite = Some(slot);
        } else {
            corners[slot] = corner(v);
        }
    }
    let Some(slot) = infinite else {
        return ConflictRegion::of_cell(&corners[..=P::DIM], heaviest);
    };
    // The cell would be positively oriented if a point beyond the hull facet replaced infinity. Moving that vertex to
    // the end needs an even permutation.
    corners.swap(slot, P::DIM);
    if slot != P::DIM {
        corners.swap(0, 1);
    }
    ConflictRegion::of_facet(&corners[..P::DIM])
}
