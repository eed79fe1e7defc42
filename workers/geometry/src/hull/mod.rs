//! The star of a vertex as a local convex hull.
//!
//! **Statement** (paper, Lemmas 4.1 and 4.3). Lift the points to the paraboloid. The edges at `p` of
//! the lower hull, hence of the Delaunay triangulation, are the vertices of the convex hull, one
//! dimension down, of the rays from `p`'s lift to the other lifts. If the candidates hold every
//! Delaunay neighbour of `p`, the hull of the candidates gives the star of `p`.
//!
//! We do not cut the rays with a hyperplane: the hull is kept as the *link* of `p`, a closed complex of
//! `DIM`-vertex facets in which the vertical ray is the infinite vertex, and a candidate is added by
//! digging the facets it conflicts with ([`crate::complex`]). A finite facet `f` conflicts with `q` iff
//! `q` lies in the circumsphere of `(p, f)`; an infinite one iff `q` lies beyond the hull facet.
//!
//! **Work and depth.** One sweep over the link's facets for each candidate: a vector step. With `m`
//! candidates and link size `l`: depth O(m), work O(m l); both constants under the paper's hypothesis.
//!
//! **Departures.** (1) Candidates come in order of distance, so that most conflict with nothing, and the
//! sweeps end where no facet reaches: a facet conflicts with no candidate farther than its sphere's
//! diameter. (2) The tests are done in
//! rounded arithmetic on inverse images ([`planes`]), with one error bound per facet; what the bound does not
//! decide goes to the exact predicates. (3) Of those undecided, few need be asked: see below.
//!
//! **One exact test a candidate.** Over the cone that the link spans, the lifted facets are the graph of a
//! convex function, the largest of their linear functions; under the perturbation too. A candidate `q` in
//! the cone lies below it iff it lies below the facet whose own cone holds `q`: if that does not conflict,
//! no facet does. Outside the cone `q` lies beyond some infinite facet, strictly. So if rounded arithmetic
//! finds no conflict but leaves facets undecided, the exact test of that one finite facet, or an
//! orientation for each infinite one, decides; and when there is a conflict, only facets that meet the
//! cavity are asked, as it is dug. Among cospherical points, where nothing is decided by rounding, this is
//! what keeps a sweep from one exact test for each facet. (A `q` on the common face of several cones is
//! in all of them, and their functions agree there.)

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

mod change;
mod corners;
mod planes;
mod witness;

pub use change::Extended;
use corners::{Cone, Corners};
use planes::{Image, Planes, Side};
pub use witness::Witnesses;

use crate::complex::{Complex, INFINITE};
use crate::cost::{Cost, Places};
use crate::point::{Point, Simplex, dist2, lex_cmp};
use crate::predicates::{Sign, orientation, raises_dimension};
use crate::simd::widest;

/// Builds stars, one after the other, in reused storage.
#[derive(Debug)]
pub struct StarBuilder<P: Point> {
    link: Complex<P::Facet>,
    planes: Planes,
    /// Candidates by distance, and how many have been looked at.
    order: Vec<u32>,
    seen: usize,
    keys: Vec<u64>,
    centre: P,
    /// Infinity, then the candidates looked at, in order; the link's vertices are positions in here less 1.
    points: Vec<Candidate<P>>,
    /// Facets that the candidate at hand may conflict with.
    uncertain: Vec<u32>,
    /// The cavity, where some facets were undecided.
    dug: Vec<u32>,
    /// Of every facet: what rounded arithmetic says of the candidate at hand.
    sides: Vec<Side>,
    /// Of every facet of the link that was loaded ([`StarBuilder::extend`]): is it gone? And those that are.
    loaded: Vec<bool>,
    gone: Vec<u32>,
    /// Where the numbers of points stand in `points`.
    places: Places,
}

/// A point that may be in the star.
#[derive(Clone, Copy, Debug)]
struct Candidate<P> {
    image: Image<P>,
    at: P,
    /// Its position in the table.
    id: u32,
}

impl<P: Point> Candidate<P> {
    /// A point of the table, as seen from a centre.
    fn of(table: &[P], id: u32, centre: P) -> Self {
        let at = table[id as usize];
        let rel = at - centre;
        Candidate { image: Image::of(rel, rel.norm2()), at, id }
    }

    /// The vertex at infinity.
    fn infinity() -> Self {
        Candidate { image: Image::of_infinity(), at: P::default(), id: INFINITE }
    }
}

/// The candidate of a vertex of the link.
#[inline]
fn candidate<P: Point>(points: &[Candidate<P>], vertex: u32) -> &Candidate<P> {
    &points[vertex.wrapping_add(1) as usize]
}

impl<P: Point> Default for StarBuilder<P> {
    fn default() -> Self {
        StarBuilder {
            link: Complex::default(),
            planes: Planes::default(),
            order: Vec::new(),
            seen: 0,
            keys: Vec::new(),
            centre: P::default(),
            points: Vec::new(),
            uncertain: Vec::new(),
            dug: Vec::new(),
            sides: Vec::new(),
            loaded: Vec::new(),
            gone: Vec::new(),
            places: Places::default(),
        }
    }
}

/// Candidates that are looked at together: then it is asked whether the rest is out of reach.
const AT_ONCE: usize = 32;

/// Candidates between two questions whether the rest is out of reach.
const ASKED_EVERY: u32 = 4;

impl<P: Point> StarBuilder<P> {
    /// Builds the star of `table[centre]` among the `candidates` (positions in `table`, in any order,
    /// repeats and the centre itself ignored). Returns false, with no link, if the candidates and the
    /// centre span no cell.
    pub fn build(&mut self, table: &[P], centre: u32, candidates: &[u32], cost: &mut Cost) -> bool {
        self.centre = table[centre as usize];
        self.points.clear();
        self.points.push(Candidate::infinity());
        self.order.clear();
        self.seen = 0;
        self.loaded.clear();
        self.gone.clear();
        self.order.extend_from_slice(candidates);
        if candidates.contains(&centre) {
            self.order.retain(|&i| i != centre);
        }
        self.sort_by_distance(table, cost);
        let mut more = |this: &mut Self| this.look_at_more(table);
        let first = self.first_simplex(&mut more, cost);
        if let Some(first) = first {
            self.start(first);
            widest(
                #[inline(always)]
                || self.sweep_all(first, &mut more, cost),
            );
        } else {
            self.link.clear();
        }
        first.is_some()
    }

    /// The link's facets as positions in the table, infinite ones included, oriented so that
    /// `(centre, facet)` is positive. Appends to `out`.
    pub fn facets(&self, out: &mut Vec<P::Facet>) {
        out.extend(self.link.live_cells().map(|cell| self.named(cell)));
    }

    /// A facet by positions in the table.
    #[inline]
    fn named(&self, cell: u32) -> P::Facet {
        let mut facet = *self.link.cell(cell);
        for v in facet.as_mut() {
            *v = candidate(&self.points, *v).id;
        }
        facet
    }

    /// Number of facets of the link.
    pub fn link_size(&self) -> usize {
        self.link.len()
    }

    /// Sorts the candidates by their distances from the centre, then by rank.
    fn sort_by_distance(&mut self, table: &[P], cost: &mut Cost) {
        let c = self.centre;
        // The bits of squared distances are in the order of the distances.
        let distance2 = |i: u32| dist2(table[i as usize], c).to_bits();
        cost.sort_keyed(&mut self.order, &mut self.keys, distance2, |&a, &b| {
            let by_rank = || lex_cmp(&table[a as usize], &table[b as usize]);
            distance2(a).cmp(&distance2(b)).then_with(by_rank)
        });
    }

    /// Takes the next candidates in order; are there any?
    fn look_at_more(&mut self, table: &[P]) -> bool {
        let next = &self.order[self.seen..];
        let next = if next.len() > 2 * AT_ONCE { &next[..AT_ONCE] } else { next };
        self.seen += next.len();
        for &id in next {
            if self.points.last().is_some_and(|last| last.id != id) {
                self.points.push(Candidate::of(table, id, self.centre));
            }
        }
        !next.is_empty()
    }

    /// The first candidates, in order, that span a cell with the centre, positively oriented.
    fn first_simplex(
        &mut self,
        more: &mut impl FnMut(&mut Self) -> bool,
        cost: &mut Cost,
    ) -> Option<P::Facet> {
        let mut basis = [self.centre; 4];
        let mut facet = P::Facet::splat(0);
        let (mut found, mut q) = (0, 1);
        let mut sweep = cost.sweep();
        while found < P::DIM {
            if q == self.points.len() && !more(self) {
                break;
            }
            // The next run may have held nothing but repeats.
            let Some(p) = self.points.get(q) else { continue };
            sweep.visit();
            if raises_dimension(&basis[..=found], p.at) {
                facet.as_mut()[found] = q as u32 - 1;
                found += 1;
                basis[found] = p.at;
            }
            q += 1;
        }
        cost.swept_inside(sweep);
        if found < P::DIM {
            return None;
        }
        if orientation(&basis[..=P::DIM]) == Sign::Negative {
            facet.as_mut().swap(0, 1);
        }
        Some(facet)
    }

    fn start(&mut self, first: P::Facet) {
        self.link.start(first);
        self.sides.clear();
        let longest = self.points[1].image.length;
        self.planes.clear(longest);
        self.enter_created(longest);
    }

    /// Adds the candidates beside the `first` one by one, as far as any facet reaches.
    #[inline(always)]
    fn sweep_all(&mut self, first: P::Facet, more: &mut impl FnMut(&mut Self) -> bool, cost: &mut Cost) {
        let last = first.as_ref().iter().fold(0, |last, &q| q.max(last));
        for q in 0.. {
            while q as usize + 1 == self.points.len() {
                if self.planes.are_out_of_reach(self.reach_of(q - 1)) || !more(self) {
                    return;
                }
            }
            if q > last || !first.as_ref().contains(&q) {
                let asks = q % ASKED_EVERY == 0;
                self.insert(q, asks, cost);
                if asks && self.planes.are_out_of_reach(self.reach_of(q)) {
                    return;
                }
            }
        }
    }

    /// The squared length of a candidate's image, which none to come is longer than.
    fn reach_of(&self, q: u32) -> f64 {
        let length = candidate(&self.points, q).image.length;
        length * length
    }

    /// One sweep over the facets; then the cavity, if any. A facet that is `asked` says how far it reaches, too.
    #[inline(always)]
    fn insert(&mut self, q: u32, asked: bool, cost: &mut Cost) {
        let image = candidate(&self.points, q).image;
        let mut sweep = cost.sweep();
        sweep.visit_lanes(if asked { 2 * self.link.len() } else { self.link.len() });
        self.uncertain.clear();
        let (mut seed, mut undecided) = (None, false);
        self.planes.each_uncertain(&image.at, |facet, side| {
            self.uncertain.push(facet);
            self.sides[facet as usize] = side;
            match side {
                Side::Conflict => seed = Some(facet),
                _ => undecided = true,
            }
        });
        if !self.uncertain.is_empty() {
            if undecided {
                self.decide(q, seed);
            }
            let (sides, cavity) = (&self.sides, if undecided { &self.dug } else { &self.uncertain });
            let conflicts = !cavity.is_empty();
            // What single precision was not certain of, and the ridges of the facets that go.
            sweep.visit_lanes(self.uncertain.len() + P::DIM * cavity.len());
            if conflicts {
                for &facet in cavity {
                    if let Some(is_gone) = self.loaded.get_mut(facet as usize)
                        && !*is_gone
                    {
                        *is_gone = true;
                        self.gone.push(facet);
                    }
                }
                self.link.replace(q, cavity, |facet| sides[facet as usize] == Side::Conflict);
                for &facet in self.link.free() {
                    self.planes.remove(facet);
                }
            }
            for &facet in &self.uncertain {
                self.sides[facet as usize] = Side::Clear;
            }
            if conflicts {
                self.enter_created(image.length);
                // Their planes, and their ridges.
                sweep.visit_lanes((1 + P::DIM) * self.link.created().len());
            }
        }
        cost.swept_inside(sweep);
    }

    /// Computes the planes of new facets; no image to come is longer than `longest`.
    #[inline(always)]
    fn enter_created(&mut self, longest: f64) {
        let slots = self.link.slots() as usize;
        if slots > self.sides.len() {
            let room = self.planes.make_room(slots);
            self.sides.resize(room, Side::Clear);
        }
        for &facet in self.link.created() {
            enter(&mut self.planes, &self.points, facet, self.link.cell(facet), longest);
        }
    }

    /// Digs the cavity where some facets are undecided, and marks those of them that are in it.
    #[cold]
    fn decide(&mut self, q: u32, seed: Option<u32>) {
        self.dug.clear();
        let Some(seed) = seed.or_else(|| self.conflict_among_undecided(q)) else { return };
        let corners = Corners { centre: self.centre, points: &self.points };
        self.sides[seed as usize] = Side::Dug;
        self.dug.push(seed);
        let mut head = 0;
        while let Some(&facet) = self.dug.get(head) {
            head += 1;
            for slot in 0..P::DIM {
                let (next, _) = self.link.neighbour(facet, slot);
                let side = &mut self.sides[next as usize];
                if *side == Side::Undecided {
                    *side = if corners.conflict(&self.link, next, q) { Side::Conflict } else { Side::Clear };
                }
                if *side == Side::Conflict {
                    *side = Side::Dug;
                    self.dug.push(next);
                }
            }
        }
        for &facet in &self.dug {
            self.sides[facet as usize] = Side::Conflict;
        }
    }

    /// A facet that conflicts, if any does, where the decided ones do not.
    #[cold]
    fn conflict_among_undecided(&self, q: u32) -> Option<u32> {
        let corners = Corners { centre: self.centre, points: &self.points };
        for &cell in &self.uncertain {
            match corners.cone(&self.link, cell, q) {
                Cone::Beyond => return Some(cell),
                Cone::Holds => return corners.conflict(&self.link, cell, q).then_some(cell),
                Cone::Elsewhere => {}
            }
        }
        None
    }
}

/// Computes the plane of a facet.
#[inline(always)]
fn enter<P: Point>(
    planes: &mut Planes,
    points: &[Candidate<P>],
    facet: u32,
    vertices: &P::Facet,
    longest: f64,
) {
    let image = |i: usize| &candidate(points, vertices.as_ref()[i % P::DIM]).image;
    planes.set(facet, [image(0), image(1), image(2)], longest);
}

#[cfg(test)]
mod tests;
