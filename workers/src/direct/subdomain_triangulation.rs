//! A worker's piece, triangulated at once where only the answer is wanted (`triangulate`).
//!
//! The stars of its home points are those of one triangulation, so cells whose vertices are all at home agree
//! by construction; what two workers must agree on are the cells between them. Links are written out only if
//! stars have to be compared or changed one by one.

use septet_geometry::complex::INFINITE;
use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::incremental::{
    ASKED_EVERY, Incremental, Kept, MARKS, facet_without, insertion_order, insertion_round,
};
use septet_geometry::point::{Point, Simplex, dist2};
use septet_protocol::ids::Phase;
use septet_protocol::message::{Merged, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::Stop;
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::cells::{Smallest, smallest_of};
use crate::state::subdomain::{Ghosts, Subdomain};
use crate::state::table::Table;
/// Across a facet of a piece's cell: outer space.
pub const HULL: u32 = u32::MAX;

/// Across a facet of a piece's cell: a cell of another piece. Numbers of cells are smaller.
pub const SEAM: u32 = MARKS;

/// The triangulation of a worker's piece and of the foreign points it was sent. Home points are its first
/// vertices, by their local numbers.
#[derive(Debug)]
pub(crate) struct SubdomainTriangulation<P: Point> {
    delaunay: Incremental<P>,
    /// Local number of each foreign vertex.
    numbers: Vec<u32>,
    owned: u32,
    /// Cells that belong here, and what they contribute: once surveyed.
    kept: Kept,
    merged: Merged,
}

/// What a vertex is known to have: a finite cell, and a smaller neighbour.
const CELL: u8 = 1;
const SMALLER: u8 = 2;

/// Notes what a cell says of its vertices at home.
fn note_star<S: Simplex>(cell: &S, smallest: u32, finite: u8, seen: &mut [u8]) {
    for &v in cell.as_ref() {
        if let Some(seen) = seen.get_mut(v as usize) {
            *seen |= finite | if v == smallest { 0 } else { SMALLER };
        }
    }
}

/// Links as arrays: the facets of all, and where each begins and how many it has.
pub(crate) type Links<P> = (Vec<<P as Point>::Facet>, Vec<(u32, u32)>);

impl<P: Point> SubdomainTriangulation<P> {
    /// Triangulates the home points, which are numbered in the order of insertion, and those of `others` (local
    /// numbers, each once) that are not among them, with room for `more`. Nothing if all lie in a plane, if
    /// they are too many for one triangulation, or if told to stop.
    pub(crate) fn new(positions: &[P], owned: u32, others: &[u32], more: usize, stop: &Stop) -> Option<Self> {
        let ghosts: Vec<u32> = others.iter().copied().filter(|&v| v >= owned).collect();
        let at: Vec<P> = ghosts.iter().map(|&v| positions[v as usize]).collect();
        let numbers: Vec<u32> = insertion_order(&at).into_iter().map(|i| ghosts[i as usize]).collect();
        let mut points = Vec::with_capacity(owned as usize + numbers.len() + more);
        points.extend_from_slice(&positions[..owned as usize]);
        points.extend(numbers.iter().map(|&v| positions[v as usize]));
        let order = in_rounds(&points, owned as usize);
        let delaunay = Incremental::build_in_place(points, order, &mut || !stop.is_raised()).ok()?;
        Some(SubdomainTriangulation {
            delaunay,
            numbers,
            owned,
            kept: Kept::default(),
            merged: Merged::default(),
        })
    }

    /// Adds foreign points, by their local numbers, as far as they are neighbours of home points then (others never are) or
    /// undo very many cells ([`Incremental::insert_beside`]).
    /// Those that are vertices already change nothing. It ends where it is told to stop.
    pub(crate) fn add(&mut self, ghosts: &[u32], positions: &[P], stop: &Stop) {
        let points: Vec<P> = ghosts.iter().map(|&g| positions[g as usize]).collect();
        for (count, i) in insertion_order(&points).into_iter().enumerate() {
            if count.is_multiple_of(ASKED_EVERY) && stop.is_raised() {
                return;
            }
            if let Ok(Some(_)) = self.delaunay.insert_beside(points[i as usize], None, self.owned) {
                self.numbers.push(ghosts[i as usize]);
            }
        }
    }

    /// The kernel's rounded sphere of a cell, which is somewhat larger than [`reach_of`] and costs nothing.
    pub(crate) fn ball(&self, slot: u32) -> Option<ConflictRegion<P>> {
        let (centre, radius2) = self.delaunay.ball(slot)?;
        Some(ConflictRegion::Ball { centre, radius: radius2.sqrt() * (1.0 + f64::EPSILON) })
    }

    /// A number that the radius of a finite cell's ball does not exceed, or not a number.
    #[inline]
    pub(crate) fn radius_bound(&self, slot: u32) -> f64 {
        self.delaunay.radius_bound(slot)
    }

    /// The radius of a finite cell's sphere as the kernel keeps it, to be compared with [`SubdomainTriangulation::radius_within`].
    #[inline]
    pub(crate) fn rounded_radius(&self, slot: u32) -> f32 {
        self.delaunay.rounded_radius(slot)
    }

    /// The most that a rounded radius may be if all of its ball is to be within `across` of each vertex; 0, which none
    /// has, if no ball is.
    pub(crate) fn radius_within(&self, across: f64) -> f32 {
        self.delaunay.radius_within(across)
    }

    /// Number of slots for cells.
    pub(crate) fn slots(&self) -> u32 {
        self.delaunay.complex().slots()
    }

    /// Calls `f` with every cell of which a vertex is at home: its slot and its vertices' local numbers,
    /// [`INFINITE`] among them in infinite ones.
    pub(crate) fn each_cell(&self, mut f: impl FnMut(u32, &P::Cell)) {
        for (slot, cell, _) in self.delaunay.complex().entries() {
            let ghosts = cell.as_ref().iter().filter(|&&v| v >= self.owned).count();
            if ghosts == 0 {
                f(slot, cell);
            } else if ghosts <= P::DIM {
                f(slot, &self.local(cell));
            }
        }
    }

    /// The first vertex at home of the cell in a slot, if there is a cell that has one.
    #[inline]
    pub(crate) fn owned_vertex(&self, slot: u32) -> Option<u32> {
        let cells = self.delaunay.complex();
        let first = cells.cell(slot).as_ref().iter().copied().find(|&v| v < self.owned);
        first.filter(|_| cells.is_live(slot))
    }

    /// The vertices of the cell in a slot as the piece numbers them: those at home by their local numbers,
    /// [`SubdomainTriangulation::local`] for all.
    #[inline]
    pub(crate) fn vertices(&self, slot: u32) -> &P::Cell {
        self.delaunay.complex().cell(slot)
    }

    /// What holds every point that conflicts with a cell of local numbers: the kernel's sphere where that is hardly larger
    /// than the cell's own.
    pub(crate) fn reach(&self, slot: u32, cell: &P::Cell, positions: &[P]) -> ConflictRegion<P> {
        if self.radius_bound(slot) > self.delaunay.extent() / FINEST
            && let Some(ball) = self.ball(slot)
        {
            return ball;
        }
        reach_of::<P>(cell, |v| positions[v as usize])
    }

    /// A cell of the piece by local numbers.
    pub(crate) fn local(&self, cell: &P::Cell) -> P::Cell {
        let mut own = *cell;
        for v in own.as_mut().iter_mut().filter(|v| **v >= self.owned && **v != INFINITE) {
            *v = self.numbers[(*v - self.owned) as usize];
        }
        own
    }

    /// Looks at all cells once: what the stars of all home points contribute to the merged result, and which cells
    /// belong here, those whose smallest vertex is at home. Calls `mixed` with every finite cell that has
    /// vertices at home and foreign ones, and with its smallest vertex, by local numbers.
    pub(crate) fn scan(&mut self, positions: &[P], mixed: impl FnMut(&P::Cell, u32)) {
        let firsts = Firsts::of(positions);
        let mut kept = Kept::of(self.slots());
        // Nothing is ever known in the last place, which is that of all vertices not at home.
        let mut seen = vec![0u8; self.owned as usize + 1];
        let border = self.scan_owned(&firsts, &mut seen, &mut kept);
        seen.truncate(self.owned as usize);
        let hull_facets = self.scan_interface(&border, &firsts, &mut seen, &mut kept, mixed);
        self.merged = Merged {
            cells: u64::from(kept.len()),
            stars: seen.iter().filter(|&&s| s & CELL != 0).count() as u64,
            minima: seen.iter().filter(|&&s| s & SMALLER == 0).count() as u64,
            hull_facets,
            ..Merged::default()
        };
        self.kept = kept;
    }

    /// The part of [`SubdomainTriangulation::scan`] that most cells need, those whose vertices are all at home. Returns the slots of others.
    fn scan_owned(&self, firsts: &Firsts<'_, P>, seen: &mut [u8], kept: &mut Kept) -> Vec<u32> {
        let cells = self.delaunay.complex();
        let mut border = Vec::new();
        for word in 0..self.slots().div_ceil(u64::BITS) {
            // Nearly every cell is at home and tells nothing new.
            let (live, old) = self.delaunay.masks(word as usize, |cell| {
                let known = |v: u32| seen[v.min(self.owned) as usize];
                cell.as_ref().iter().fold(CELL | SMALLER, |all, &v| all & known(v)) == CELL | SMALLER
            });
            let mut at_home = live & old;
            for i in ones(live & !old) {
                let slot = word * u64::BITS + i as u32;
                let cell = cells.cell(slot);
                if cell.as_ref().iter().all(|&v| v < self.owned) {
                    note_star(cell, firsts.smallest(cell), CELL, seen);
                    at_home |= 1 << i;
                } else {
                    border.push(slot);
                }
            }
            kept.keep_word(word as usize, at_home);
        }
        border
    }

    /// The part of [`SubdomainTriangulation::scan`] for cells that have other vertices, too. Returns the number of facets of the hull that
    /// belong here.
    fn scan_interface(
        &self,
        border: &[u32],
        firsts: &Firsts<'_, P>,
        seen: &mut [u8],
        kept: &mut Kept,
        mut mixed: impl FnMut(&P::Cell, u32),
    ) -> u64 {
        let mut hull_facets = 0;
        for &slot in border {
            let cell = self.vertices(slot);
            if cell.as_ref().iter().all(|&v| v >= self.owned) {
                // Of no star at home: whether it is there is not known here.
                continue;
            }
            let infinite = cell.as_ref().contains(&INFINITE);
            let cell = &self.local(cell);
            let smallest = firsts.smallest(cell);
            note_star(cell, smallest, if infinite { 0 } else { CELL }, seen);
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

    /// What [`SubdomainTriangulation::scan`] found for the merged result.
    pub(crate) fn merged(&self) -> Merged {
        self.merged
    }

    /// The cells that belong here, once surveyed: rows of their vertices' local numbers and of their neighbours, which
    /// are cells by their new numbers, [`HULL`], or [`SEAM`] for a cell of another piece; and the numbers of those with one
    /// of the two.
    pub(crate) fn into_rows(self) -> (Vec<u32>, Vec<u32>) {
        let SubdomainTriangulation { delaunay, numbers, owned, kept, .. } = self;
        delaunay.into_rows(&kept, [SEAM, HULL], |v| if v < owned { v } else { numbers[(v - owned) as usize] })
    }

    /// The squared distance of every home point to its nearest vertex, which is a neighbour.
    pub(crate) fn nearest_edges(&self) -> Vec<f64> {
        let mut radii2 = vec![f64::INFINITY; self.owned as usize];
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

    /// All links of home points in local numbers, by two passes over the cells.
    pub(crate) fn links(&self) -> Links<P> {
        let mut ranges = vec![(0u32, 0u32); self.owned as usize];
        self.each_cell(|_, cell| {
            for &v in cell.as_ref() {
                if let Some(range) = ranges.get_mut(v as usize) {
                    range.1 += 1;
                }
            }
        });
        let mut total = 0;
        for range in &mut ranges {
            let start = total;
            total += range.1;
            *range = (start, 0);
        }
        let mut facets = vec![P::Facet::splat(0); total as usize];
        self.each_cell(|_, cell| {
            for &v in cell.as_ref() {
                if let Some(range) = ranges.get_mut(v as usize) {
                    facets[(range.0 + range.1) as usize] = facet_without::<P>(cell, v);
                    range.1 += 1;
                }
            }
        });
        (facets, ranges)
    }
}

/// Ghosts to expect beyond the ghost layer, as a multiple of the number of owned points to the power `(d - 1) / d`.
const LAYERS: f64 = 4.0;

/// Triangulates the owned points and the ghosts that arrived. Returns no piece if there are no owned points, or if they
/// and the frame lie in a plane.
pub(crate) async fn triangulate_subdomain<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    mut ghosts: Vec<u32>,
    frame: &PointBatch<P>,
) -> Result<(Option<SubdomainTriangulation<P>>, Ghosts), TransportError> {
    cx.enter(Phase::Pieces)?;
    let owned = table.owned;
    let (mut piece, mut held) = (None, Ghosts::default());
    if owned > 0 {
        let _span =
            cx.site().subproblem(Phase::Pieces, subdomain.root(), "triangulate piece", u64::from(owned));
        let more = if subdomain.path.is_empty() { 0 } else { expected_ghosts::<P>(owned) };
        piece = SubdomainTriangulation::new(&table.positions, owned, &ghosts, more, &cx.config.stop);
        if piece.is_none() {
            // A flat piece: points of the frame are real points, so they may stand in any star.
            let frame = table.intern_all(frame);
            ghosts.extend(frame.into_iter().filter(|&v| v >= owned));
            ghosts.sort_unstable();
            ghosts.dedup();
            piece = SubdomainTriangulation::new(&table.positions, owned, &ghosts, more, &cx.config.stop);
        }
        held.add_to_first(ghosts);
    }
    while cx.exchange().await? {}
    Ok((piece, held))
}

/// Ghosts beyond its ghost layer that a piece of so many points makes room for: somewhat more than random points need.
/// Memory that is not written to is not used.
fn expected_ghosts<P: Point>(owned: u32) -> usize {
    let layer = f64::from(owned).powf((P::DIM - 1) as f64 / P::DIM as f64);
    (LAYERS * layer) as usize
}

/// The extent of a piece over the smallest radius of which the kernel's sphere, which is in single precision, is larger
/// by a thousandth at most.
const FINEST: f64 = 4096.0;

/// The numbers of points in two runs, each in order of insertion, the second from `half` on: one round of both after the
/// other.
fn in_rounds<P: Point>(points: &[P], half: usize) -> impl Iterator<Item = u32> + use<P> {
    let mut parts = Vec::new();
    let (mut first, mut second) = points.split_at(half);
    while !first.is_empty() || !second.is_empty() {
        let round = |run: &[P]| run.first().map_or(u64::MAX, insertion_round);
        let now = round(first).min(round(second));
        for (run, end) in [(&mut first, half), (&mut second, points.len())] {
            if round(run) == now {
                let start = end - run.len();
                let len = round_len(run);
                parts.push(start as u32..(start + len) as u32);
                *run = &run[len..];
            }
        }
    }
    parts.into_iter().flatten()
}

/// Of points in order of insertion, how many are of the round of the first: at least one.
pub(crate) fn round_len<P: Point>(points: &[P]) -> usize {
    let Some(round) = points.first().map(insertion_round) else { return 0 };
    points.partition_point(|p| insertion_round(p) <= round).max(1)
}

/// First coordinates of points beside the first point's, in single precision: rounding keeps their order, and a core's
/// caches hold most of them.
struct Firsts<'a, P> {
    positions: &'a [P],
    rounded: Vec<f32>,
}

impl<'a, P: Point> Firsts<'a, P> {
    fn of(positions: &'a [P]) -> Self {
        let origin = positions.first().map_or(0.0, |x| x.coord(0));
        Firsts { positions, rounded: positions.iter().map(|x| (x.coord(0) - origin) as f32).collect() }
    }

    /// The same as [`smallest_of`]: by first coordinates, unless two may be equal.
    #[inline]
    fn smallest(&self, cell: &P::Cell) -> u32 {
        let first = |v: u32| self.rounded.get(v as usize).copied().unwrap_or(f32::INFINITY);
        let vertices = cell.as_ref();
        let mut smallest = Smallest::of(vertices[0], first(vertices[0]));
        vertices[1..].iter().for_each(|&v| smallest.look(v, first(v)));
        smallest.vertex(|| smallest_of(self.positions, vertices.iter().copied()))
    }
}

/// What holds every point that conflicts with a cell; `corner` gives the position of a finite vertex.
pub(crate) fn reach_of<P: Point>(cell: &P::Cell, corner: impl Fn(u32) -> P) -> ConflictRegion<P> {
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
        return ConflictRegion::of_cell(&corners[..=P::DIM]);
    };
    // A point beyond, in the place of infinity, makes the cell positive: bring that place to the end.
    corners.swap(slot, P::DIM);
    if slot != P::DIM {
        corners.swap(0, 1);
    }
    ConflictRegion::of_facet(&corners[..P::DIM])
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    /// What rounding makes equal, what is equal, zeros of both signs, and what lies beyond single precision.
    fn rounded_coordinates_find_the_smallest<P: Point>() {
        let near = |k: u32| 1.0 + f64::from(k) * f64::EPSILON;
        let firsts =
            [near(0), near(1), near(2), 0.5, 0.0, -0.0, -3.0, 1e39, 1e300, -1e39, -1e300, 1e-50, 2e-50];
        let mut positions: Vec<P> = Vec::new();
        for (i, &first) in firsts.iter().enumerate() {
            for rest in [i as f64 % 3.0, 7.0] {
                positions.push(P::from_coords(&[first, rest, -rest][..P::DIM]));
            }
        }
        let all = positions.len() as u32;
        let firsts = Firsts::of(&positions);
        let mut draw = septet_geometry::hash::Draw::new(5);
        for _ in 0..20_000 {
            let mut cell = P::Cell::splat(INFINITE);
            for v in cell.as_mut() {
                let drawn = draw.below(all as usize + 2) as u32;
                *v = if drawn < all { drawn } else { INFINITE };
            }
            let found = firsts.smallest(&cell);
            assert_eq!(found, smallest_of(&positions, cell.as_ref().iter().copied()), "{cell:?}");
        }
    }

    #[test]
    fn rounded_coordinates_find_the_smallest_vertex() {
        rounded_coordinates_find_the_smallest::<DVec3>();
        rounded_coordinates_find_the_smallest::<DVec2>();
    }
}
