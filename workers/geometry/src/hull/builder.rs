//! Construction of the link of a star: one sweep over its facets for each near candidate.
//!
//! **Statement.** After each step, the link is that of the centre's star among the candidates so far (see [`super`]).
//!
//! **Work and depth.** As in [`super`], plus a sort of the candidates.

use super::candidate::{Candidate, candidate};
use super::conflict_lists::ConflictLists;
use super::general::General;
use super::large::{BATCH, LARGE, LargeStars};
use super::planes::{Planes, Side};

use crate::complex::Complex;
use crate::cost::{Cost, Positions};
use crate::point::{Point, Simplex, dist2, lex_cmp};
use crate::predicates::{ExactTests, Sign, orientation, raises_dimension};
use crate::simd::widest;

/// Builds one star at a time, in reused storage.
#[derive(Debug)]
pub struct StarBuilder<P: Point> {
    pub(super) link: Complex<P::Facet>,
    pub(super) planes: Planes,
    /// Positions of the candidates in the table, by distance.
    pub(super) order: Vec<u32>,
    /// Number of candidates of `order` that were already taken.
    pub(super) taken: usize,
    /// Scratch storage for the sort.
    pub(super) keys: Vec<u64>,
    pub(super) centre: P,
    /// The point at infinity, then the candidates taken from `order`, in their order. Vertex `v` of the link is entry
    /// `v + 1`.
    pub(super) points: Vec<Candidate<P>>,
    /// Facets that the current candidate may conflict with.
    pub(super) uncertain: Vec<u32>,
    /// The facets of the cavity, if some facets were undecided. Otherwise, `uncertain` is the cavity.
    pub(super) cavity: Vec<u32>,
    /// For each facet, the side on which the current candidate lies, as far as it is known.
    pub(super) sides: Vec<Side>,
    /// For each facet of the link that [`StarBuilder::extend`] loaded, whether it was removed.
    pub(super) loaded: Vec<bool>,
    /// The removed facets of that link, in the order of their removal.
    pub(super) removed: Vec<u32>,
    /// For each of them, the candidate that removed it.
    pub(super) removers: Vec<u32>,
    /// Whether the counted machine keeps the complexes of its stars, so that loading a link is free.
    pub(super) keeps_stars: bool,
    /// Scratch storage: maps positions in the table to positions in `points`.
    pub(super) positions: Positions,
    /// Scratch storage for large stars.
    pub(super) conflicts: ConflictLists,
    pub(super) large: LargeStars,
    /// The cover of the centre, if it is hidden ([`StarBuilder::cover`]).
    pub(super) cover: Option<P::Cell>,
    /// The link in dimensions above 3.
    pub(super) general: General<P>,
}

impl<P: Point> Default for StarBuilder<P> {
    fn default() -> Self {
        StarBuilder {
            link: Complex::default(),
            planes: Planes::default(),
            order: Vec::new(),
            taken: 0,
            keys: Vec::new(),
            centre: P::default(),
            points: Vec::new(),
            uncertain: Vec::new(),
            cavity: Vec::new(),
            sides: Vec::new(),
            loaded: Vec::new(),
            removed: Vec::new(),
            removers: Vec::new(),
            keeps_stars: false,
            positions: Positions::default(),
            conflicts: ConflictLists::default(),
            large: LargeStars::default(),
            cover: None,
            general: General::default(),
        }
    }
}

/// Number of candidates between two tests that may end the construction.
const CHECK_INTERVAL: u32 = 4;

impl<P: Point> StarBuilder<P> {
    /// Builds the star of `table[centre]` among the `candidates`. These are positions in `table` in any order;
    /// repetitions and the centre are ignored. Returns `false`, with an empty link, if the candidates and the centre
    /// span no cell. The link is also empty if the centre is hidden ([`StarBuilder::cover`]).
    pub fn build(&mut self, table: &[P], centre: u32, candidates: &[u32], cost: &mut Cost) -> bool {
        if P::DIM > 3 {
            return self.build_general(table, centre, candidates, cost);
        }
        let exact = ExactTests::so_far();
        self.centre = table[centre as usize];
        self.points.clear();
        self.points.push(Candidate::infinity());
        self.order.clear();
        self.taken = 0;
        self.cover = None;
        self.loaded.clear();
        self.removed.clear();
        self.removers.clear();
        self.order.extend_from_slice(candidates);
        if candidates.contains(&centre) {
            self.order.retain(|&i| i != centre);
        }
        self.sort_by_distance(table, cost);
        let mut more = |this: &mut Self| this.take_batch(table);
        let first = self.first_simplex(&mut more, cost);
        if let Some(mut first) = first {
            if self.is_large(self.points.len() - 1) {
                first = self.bring_forward(first);
            }
            self.start(table, first);
            let is_complete = widest(
                #[inline(always)]
                || self.sweep_all(first, &mut more, cost),
            );
            if !is_complete {
                self.add_rest(table, cost);
            }
        } else {
            self.link.clear();
        }
        cost.charge_exact_tests(exact.since());
        first.is_some()
    }

    /// Appends the facets of the link to `out`, infinite ones included, as positions in the table. They are oriented so
    /// that `(centre, facet)` is positive.
    pub fn facets(&self, out: &mut Vec<P::Facet>) {
        if P::DIM > 3 {
            return self.general_facets(out);
        }
        out.extend(self.link.live_cells().map(|cell| self.named(cell)));
    }

    /// Converts a facet to positions in the table.
    #[inline]
    pub(super) fn named(&self, cell: u32) -> P::Facet {
        let mut facet = *self.link.cell(cell);
        for v in facet.as_mut() {
            *v = candidate(&self.points, *v).id;
        }
        facet
    }

    /// Returns the number of facets of the link.
    pub fn link_size(&self) -> usize {
        if P::DIM > 3 { self.general_size() } else { self.link.len() }
    }

    /// Sorts the candidates by distance from the centre, or by decreasing length of their images if they have weights, then
    /// lexicographically.
    pub(super) fn sort_by_distance(&mut self, table: &[P], cost: &mut Cost) {
        let c = self.centre;
        // The bit patterns of squared distances have the order of the distances. That of an image that is not a number is the
        // largest.
        let distance2 = |i: u32| {
            if P::IS_WEIGHTED {
                return !Candidate::of(table, i, c).image.length.to_bits();
            }
            dist2(table[i as usize], c).to_bits()
        };
        cost.sort_keyed(&mut self.order, &mut self.keys, distance2, |&a, &b| {
            let by_rank = || lex_cmp(&table[a as usize], &table[b as usize]);
            distance2(a).cmp(&distance2(b)).then_with(by_rank)
        });
    }

    /// Takes the next batch of candidates. Returns `false` if there are no more candidates.
    fn take_batch(&mut self, table: &[P]) -> bool {
        let next = &self.order[self.taken..];
        let next = if next.len() > LARGE { &next[..BATCH] } else { next };
        self.taken += next.len();
        for &id in next {
            if self.points.last().is_some_and(|last| last.id != id) {
                self.points.push(Candidate::of(table, id, self.centre));
            }
        }
        !next.is_empty()
    }

    /// Finds the first candidates, in order, that span a cell with the centre. Returns their facet, positively
    /// oriented, or `None` if there are no such candidates.
    fn first_simplex(
        &mut self,
        more: &mut impl FnMut(&mut Self) -> bool,
        cost: &mut Cost,
    ) -> Option<P::Facet> {
        let mut basis = [self.centre; 4];
        let mut facet = P::Facet::splat(0);
        let (mut found, mut q) = (0, 1);
        let mut sweep = cost.sweep();
        // The search for a candidate that raises the dimension needs all earlier ones, so each dimension is a sweep.
        while found < P::DIM {
            if q == self.points.len() && !more(self) {
                break;
            }
            // All candidates of the batch may have been repetitions.
            let Some(p) = self.points.get(q) else { continue };
            sweep.visit();
            if raises_dimension(&basis[..=found], p.at) {
                facet.as_mut()[found] = q as u32 - 1;
                found += 1;
                basis[found] = p.at;
                cost.charge_sweep(std::mem::take(&mut sweep));
            }
            q += 1;
        }
        cost.charge_sweep(sweep);
        if found < P::DIM {
            return None;
        }
        if orientation(&basis[..=P::DIM]) == Sign::Negative {
            facet.as_mut().swap(0, 1);
        }
        Some(facet)
    }

    fn start(&mut self, table: &[P], first: P::Facet) {
        self.link.start(first);
        self.sides.clear();
        let longest = if P::IS_WEIGHTED { self.longest_image(table) } else { self.points[1].image.length };
        self.planes.clear(longest);
        self.enter_created(longest);
    }

    /// Returns the length of the longest image of all candidates; 0 if none is a number.
    fn longest_image(&self, table: &[P]) -> f64 {
        let taken = self.points.iter().map(|p| p.image.length);
        let others = self.order.iter().map(|&id| Candidate::of(table, id, self.centre).image.length);
        taken.chain(others).fold(0.0, f64::max)
    }

    /// Adds the candidates that are not in `first` one by one, until the remaining candidates are out of reach of every
    /// facet. Returns `false` if the remaining candidates must be added at random.
    #[inline(always)]
    fn sweep_all(
        &mut self,
        first: P::Facet,
        more: &mut impl FnMut(&mut Self) -> bool,
        cost: &mut Cost,
    ) -> bool {
        let last = first.as_ref().iter().fold(0, |last, &q| q.max(last));
        for q in 0.. {
            while q as usize + 1 == self.points.len() {
                if self.planes.are_out_of_reach(self.reach_of(q - 1)) {
                    return true;
                }
                if self.needs_lists() {
                    return false;
                }
                if !more(self) {
                    return true;
                }
            }
            if q > last || !first.as_ref().contains(&q) {
                let checks_reach = q % CHECK_INTERVAL == 0;
                self.insert(q, checks_reach, cost);
                if P::IS_WEIGHTED && self.link.is_empty() {
                    return true;
                }
                if checks_reach && self.planes.are_out_of_reach(self.reach_of(q)) {
                    return true;
                }
            }
        }
        true
    }

    /// Returns the squared length of a candidate's image under inversion. Later candidates are not closer, so no later
    /// image is longer. Infinite for an image that is not a number.
    fn reach_of(&self, q: u32) -> f64 {
        let length = candidate(&self.points, q).image.length;
        if P::IS_WEIGHTED && length.is_nan() { f64::INFINITY } else { length * length }
    }

    /// Sweeps over the facets, and replaces the cavity if there is one. If `checks_reach` is set, the sweep also
    /// charges the test of each facet's reach. Up to four dependent sweeps follow. They are over the facets that single
    /// precision left uncertain, the ridges of the cavity, the new facets (for their planes), and the ridges of the new
    /// facets.
    #[inline(always)]
    pub(super) fn insert(&mut self, q: u32, checks_reach: bool, cost: &mut Cost) {
        let image = candidate(&self.points, q).image;
        let mut sweep = cost.sweep();
        sweep.visit_lanes(if checks_reach { 2 * self.link.len() } else { self.link.len() });
        let undecided = self.find_cavity(q);
        if self.uncertain.is_empty() {
            cost.charge_sweep(sweep);
            return;
        }
        let (sides, cavity) = (&self.sides, if undecided { &self.cavity } else { &self.uncertain });
        let conflicts = !cavity.is_empty();
        let (mut exact, mut removed) = (cost.sweep(), cost.sweep());
        let (mut planes, mut ridges) = (cost.sweep(), cost.sweep());
        let hides = P::IS_WEIGHTED && cavity.len() == self.link.len();
        exact.visit_all(&self.uncertain);
        removed.visit_parts(cavity, P::DIM);
        if conflicts {
            note_removed(&mut self.loaded, &mut self.removed, cavity);
            self.removers.resize(self.removed.len(), candidate(&self.points, q).id);
            if !hides {
                self.link.replace(q, cavity, |facet| sides[facet as usize] == Side::Conflict);
                for &facet in self.link.free() {
                    self.planes.remove(facet);
                }
            }
        }
        self.clear_sides();
        if hides {
            ridges.visit_lanes(self.link.len());
            self.hide(q);
        } else if conflicts {
            self.enter_created(image.length);
            ridges.visit_parts(planes.visit_all(self.link.created()), P::DIM);
        }
        cost.charge_sweeps([sweep, exact, removed, planes, ridges]);
    }

    /// Computes the planes of the new facets. No later image may be longer than `longest`.
    #[inline(always)]
    pub(super) fn enter_created(&mut self, longest: f64) {
        let slots = self.link.slots() as usize;
        if slots > self.sides.len() {
            let room = self.planes.make_room(slots);
            self.sides.resize(room, Side::Clear);
        }
        for &facet in self.link.created() {
            enter(&mut self.planes, &self.points, facet, self.link.cell(facet), longest);
        }
    }
}

/// Records which facets of a cavity belong to the loaded link. Most links were not loaded.
#[inline(always)]
pub(super) fn note_removed(loaded: &mut [bool], removed: &mut Vec<u32>, cavity: &[u32]) {
    if !loaded.is_empty() {
        for &facet in cavity {
            if let Some(is_removed) = loaded.get_mut(facet as usize)
                && !*is_removed
            {
                *is_removed = true;
                removed.push(facet);
            }
        }
    }
}

/// Computes the plane of a facet.
#[inline(always)]
pub(super) fn enter<P: Point>(
    planes: &mut Planes,
    points: &[Candidate<P>],
    facet: u32,
    vertices: &P::Facet,
    longest: f64,
) {
    let image = |i: usize| &candidate(points, vertices.as_ref()[i % P::DIM]).image;
    planes.set(facet, [image(0), image(1), image(2)], longest);
}
