//! The insertion baseline: parallel randomized incremental insertion, and the dependences between its steps.
//!
//! **Statement.** Points are inserted in random order. The *conflicts* of a cell are the later points inside its
//! circumsphere, and its *pivot* is the first of them. A facet between two cells is *ready* as soon as both exist. It
//! is then *settled* as follows:
//! 1. If the pivots are equal, the facet disappears together with both cells.
//! 2. If neither cell has a pivot, both remain in the result.
//! 3. Otherwise the cell with the earlier pivot `v` is replaced, at this facet, by the cone from `v` over it.
//!
//! The new cell depends on the two old cells `t` and `o` alone. Its conflicts `C` satisfy
//! `C(t) & C(o) <= C <= C(t) | C(o)`. So only points in conflict with exactly one of the two cells are tested. A
//! *round* settles all ready facets at once. The longest chain of dependent cells is O(log n) with high probability,
//! for any points.
//!
//! **Source.** Blelloch, Gu, Shun and Sun, "Parallelism in randomized incremental algorithms", J. ACM 67, 2020
//! (`ParIncrementalDT`); the same authors, "Randomized incremental convex hull is highly parallel", SPAA 2020.
//!
//! **Work and depth.** O(n log n) expected in the plane, and wherever random samples have triangulations of linear
//! size; otherwise O(n^2) in space. A chain has O(log n) cells. On the machine of [`crate::cost`], a halving merge
//! unites the conflicts of a cell in O(log m) steps for m points. The steps of a chain are then O(log^2 n). With a
//! concurrent hash table instead of the merge, a chain would take O(log n) steps, which [`Clock::hashed`] counts.
//!
//! **Departures.** The exterior is represented by a vertex, and the first affinely independent points are inserted
//! first, instead of a bounding simplex. The second cell of a facet is found in a table. An access to the table
//! counts one step, as in the paper, although an EREW machine would have to sort. The choice favours the baseline.
//! Drawing the order is not charged. [`crate::predicates`] breaks ties, so the cells equal the cells of
//! [`crate::incremental`].

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::complex::INFINITE;
use crate::cost::Cost;
use crate::incremental::IncrementalError;
use crate::point::{Point, Simplex, lex_cmp};
use crate::predicates::{Sign, in_sphere, orientation, raises_dimension};

/// Numbers of steps along a chain of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    /// Number of cells: the dependence depth.
    pub chain: u64,
    /// Vector steps, with each scan counted as 1.
    pub steps: u64,
    /// Vector steps, with a scan of `m` items counted as `ceil(log2 m)`.
    pub log_scan: u64,
    /// Number of vector steps if uniting conflicts took one step, as with a concurrent hash table. The EREW machine has
    /// no such table.
    pub hashed: u64,
}

impl Clock {
    fn later(self, other: Clock) -> Clock {
        Clock {
            chain: self.chain.max(other.chain),
            steps: self.steps.max(other.steps),
            log_scan: self.log_scan.max(other.log_scan),
            hashed: self.hashed.max(other.hashed),
        }
    }

    /// Appends one cell to the chain: first the cost of uniting its conflicts (`union`), then its other costs (`rest`).
    fn then(self, union: Cost, rest: Cost) -> Clock {
        Clock {
            chain: self.chain + 1,
            steps: self.steps + union.depth() + rest.depth(),
            log_scan: self.log_scan + union.depth_log_scan(1) + rest.depth_log_scan(1),
            hashed: self.hashed + union.depth().min(1) + rest.depth(),
        }
    }
}

/// Counts of one round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Round {
    /// Number of ready facets.
    pub facets: u64,
    /// Number of cells created.
    pub cells: u64,
    /// Number of in-sphere tests, including those of infinite cells.
    pub tests: u64,
    /// Number of elementary operations.
    pub work: u64,
    /// Vector steps of the slowest cell.
    pub steps: u64,
}

impl Round {
    /// Adds a cost that is incurred in parallel to the rest of the round.
    fn charge(&mut self, cost: Cost) {
        self.work += cost.work();
        self.steps = self.steps.max(cost.depth());
    }
}

/// The Delaunay triangulation, with the counts of its rounds.
#[derive(Clone, Debug)]
pub struct Dependence<P: Point> {
    /// Finite cells, positively oriented, as indices of the given points, in the order in which they were completed.
    pub cells: Vec<P::Cell>,
    /// Number of hull facets.
    pub hull_facets: u64,
    /// Maxima over all chains.
    pub clock: Clock,
    /// Counts of each round. The first round tests all points against the first cells; the others settle facets.
    pub rounds: Vec<Round>,
}

impl<P: Point> Dependence<P> {
    /// Triangulates distinct points, inserted in an order drawn from the seed.
    ///
    /// # Errors
    /// Fails if points coincide or are not finite, if there are too many, or if they do not span the space.
    pub fn new(points: &[P], seed: u64) -> Result<Self, IncrementalError> {
        let (order, positions) = insertion(points, seed)?;
        let mut builder = Builder::new(&positions);
        let mut ready = builder.start();
        while !ready.is_empty() {
            ready = builder.round(&ready);
        }
        let name = |mut cell: P::Cell| {
            cell.as_mut().iter_mut().for_each(|v| *v = order[*v as usize]);
            cell
        };
        Ok(Dependence {
            cells: builder.finite.into_iter().map(name).collect(),
            hull_facets: builder.infinite,
            clock: builder.clock,
            rounds: builder.rounds,
        })
    }

    /// Sums the counts of all rounds.
    pub fn total(&self) -> Round {
        self.rounds.iter().fold(Round::default(), |sum, r| Round {
            facets: sum.facets + r.facets,
            cells: sum.cells + r.cells,
            tests: sum.tests + r.tests,
            work: sum.work + r.work,
            steps: sum.steps + r.steps,
        })
    }

    /// Returns Brent's bound on the number of steps with `processors` processors: the sum of
    /// `floor((work - steps) / processors) + steps` over all rounds.
    pub fn brent(&self, processors: u64) -> u64 {
        let bound = |r: &Round| r.work.saturating_sub(r.steps) / processors.max(1) + r.steps;
        self.rounds.iter().map(bound).sum()
    }
}

/// Draws a random order that starts with affinely independent points. Returns the indices and the points in this order.
/// The order is a function of the set and the seed, not of the numbering.
fn insertion<P: Point>(points: &[P], seed: u64) -> Result<(Vec<u32>, Vec<P>), IncrementalError> {
    if points.len() > MOST_POINTS {
        return Err(IncrementalError::TooMany);
    }
    let finite = |p: &P| (0..P::DIM).all(|i| p.coord(i).is_finite());
    if let Some(point) = points.iter().position(|p| !finite(p)) {
        return Err(IncrementalError::NotFinite { point: point as u32 });
    }
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| lex_cmp(&points[a as usize], &points[b as usize]).then(a.cmp(&b)));
    let same = |w: &&[u32]| lex_cmp(&points[w[0] as usize], &points[w[1] as usize]).is_eq();
    if let Some(pair) = order.windows(2).find(same) {
        return Err(IncrementalError::Coincident { point: pair[1], vertex: pair[0] });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut keyed: Vec<(u64, u32)> = order.into_iter().map(|i| (rng.next_u64(), i)).collect();
    // Equal keys keep their lexicographic order.
    keyed.sort_by_key(|k| k.0);
    let mut frame: Vec<P> = Vec::new();
    let (mut first, mut rest) = (Vec::new(), Vec::with_capacity(keyed.len()));
    for (_, i) in keyed {
        let p = points[i as usize];
        if frame.len() <= P::DIM && raises_dimension(&frame, p) {
            frame.push(p);
            first.push(i);
        } else {
            rest.push(i);
        }
    }
    if frame.len() <= P::DIM {
        return Err(IncrementalError::Flat { dimension: frame.len() as isize - 1 });
    }
    first.append(&mut rest);
    let positions = first.iter().map(|&i| points[i as usize]).collect();
    Ok((first, positions))
}

/// Largest number of points, as in [`crate::incremental`].
const MOST_POINTS: usize = 1 << 26;

/// A cell with facets that are not settled.
#[derive(Clone, Debug)]
struct OpenCell<P: Point> {
    vertices: P::Cell,
    /// Later points inside the circumsphere, in the order of insertion. The first is the pivot.
    conflicts: Vec<u32>,
    clock: Clock,
    /// Number of facets that are not settled.
    open: usize,
}

/// One side of a facet.
#[derive(Clone, Copy, Debug)]
struct Half {
    cell: u32,
    /// Slot of the opposite vertex.
    slot: usize,
}

/// A facet with both of its cells.
#[derive(Clone, Copy, Debug)]
struct ReadyFacet {
    sides: [Half; 2],
}

/// A point that may be in conflict with a cell.
#[derive(Clone, Copy)]
struct Candidate<P: Point> {
    point: u32,
    /// Whether the point conflicts with both old cells, and therefore with the new cell.
    certain: bool,
    /// The cell, copied to each candidate.
    cell: P::Cell,
}

/// The origin of a new cell.
struct Origin {
    /// The clock after both old cells.
    after: Clock,
    /// Cost of settling the facet.
    before: Cost,
    /// Cost of uniting the conflicts.
    union: Cost,
    /// A slot whose facet has a known second cell.
    known: Option<(usize, Half)>,
}

struct Builder<'a, P: Point> {
    points: &'a [P],
    cells: Vec<OpenCell<P>>,
    /// Slots of completed cells.
    free: Vec<u32>,
    /// Facets with one cell so far, by their sorted vertices.
    table: BTreeMap<P::Facet, Half>,
    finite: Vec<P::Cell>,
    infinite: u64,
    clock: Clock,
    rounds: Vec<Round>,
}

impl<'a, P: Point> Builder<'a, P> {
    fn new(points: &'a [P]) -> Self {
        Builder {
            points,
            cells: Vec::new(),
            free: Vec::new(),
            table: BTreeMap::new(),
            finite: Vec::new(),
            infinite: 0,
            clock: Clock::default(),
            rounds: Vec::new(),
        }
    }

    /// Creates the first simplex and the infinite cells around it, and tests every other point against each of these
    /// cells.
    fn start(&mut self) -> Vec<ReadyFacet> {
        let n = P::DIM + 1;
        let mut simplex = P::Cell::splat(0);
        simplex.as_mut().iter_mut().zip(0..).for_each(|(slot, v)| *slot = v);
        if orientation(&self.points[..n]) == Sign::Negative {
            simplex.as_mut().swap(0, 1);
        }
        let mut cells = vec![simplex];
        for slot in 0..n {
            // Seen from beyond, a facet has the reverse orientation: swap two other vertices.
            let mut outer = simplex;
            outer.as_mut()[slot] = INFINITE;
            outer.as_mut().swap(0, 1);
            cells.push(outer);
        }
        let mut round = Round::default();
        let mut ready = Vec::new();
        for vertices in cells {
            let others = (n as u32..self.points.len() as u32).map(|point| (point, false)).collect();
            let origin =
                Origin { after: Clock::default(), before: Cost::ZERO, union: Cost::ZERO, known: None };
            self.create(vertices, others, &origin, &mut round, &mut ready);
        }
        self.rounds.push(round);
        ready
    }

    /// Settles all ready facets. Returns the facets that become ready, for the next round.
    fn round(&mut self, ready: &[ReadyFacet]) -> Vec<ReadyFacet> {
        let mut round = Round { facets: ready.len() as u64, ..Round::default() };
        let mut next = Vec::new();
        for facet in ready {
            let mut settling = Cost::ZERO;
            let replaced = settling.map(std::slice::from_ref(facet), |facet| self.replaced_side(facet.sides));
            if let Some((old, other)) = replaced[0] {
                self.replace(old, other, settling, &mut round, &mut next);
            } else {
                round.charge(settling);
                facet.sides.iter().for_each(|side| self.release(side.cell));
            }
        }
        self.rounds.push(round);
        next
    }

    /// Returns the side of a facet whose cell is replaced, then the other side. Returns `None` if both cells remain or
    /// both are removed.
    fn replaced_side(&self, [a, b]: [Half; 2]) -> Option<(Half, Half)> {
        let pivot = |half: Half| self.cells[half.cell as usize].conflicts.first().copied();
        match (pivot(a), pivot(b)) {
            (v, w) if v == w => None,
            (Some(v), Some(w)) if w < v => Some((b, a)),
            (None, _) => Some((b, a)),
            _ => Some((a, b)),
        }
    }

    /// Replaces the first cell of a facet, at this facet, by the cone from its pivot.
    fn replace(
        &mut self,
        old: Half,
        other: Half,
        before: Cost,
        round: &mut Round,
        next: &mut Vec<ReadyFacet>,
    ) {
        let (t, o) = (&self.cells[old.cell as usize], &self.cells[other.cell as usize]);
        let mut vertices = t.vertices;
        vertices.as_mut()[old.slot] = t.conflicts[0];
        let mut union = Cost::ZERO;
        // The pivot is a vertex of the new cell, not a conflict.
        let candidates = union.unite(&t.conflicts[1..], &o.conflicts);
        let origin = Origin { after: t.clock.later(o.clock), before, union, known: Some((old.slot, other)) };
        self.create(vertices, candidates, &origin, round, next);
        self.release(old.cell);
    }

    /// Creates a cell from its vertices and the candidates for its conflicts.
    fn create(
        &mut self,
        vertices: P::Cell,
        candidates: Vec<(u32, bool)>,
        origin: &Origin,
        round: &mut Round,
        ready: &mut Vec<ReadyFacet>,
    ) {
        let index = self.free.pop().unwrap_or(self.cells.len() as u32);
        let mut rest = origin.before;
        let conflicts = self.conflicts(&vertices, candidates, round, &mut rest);
        let slots: Vec<usize> = (0..=P::DIM).collect();
        let facets = rest.map(&slots, |&slot| facet_without::<P>(&vertices, slot));
        for (slot, facet) in facets.into_iter().enumerate() {
            let known = origin.known.filter(|k| k.0 == slot).map(|k| k.1);
            let half = Half { cell: index, slot };
            let mate = known.or_else(|| self.table.remove(&facet));
            match mate {
                Some(mate) => ready.push(ReadyFacet { sides: [half, mate] }),
                None => drop(self.table.insert(facet, half)),
            }
        }
        let clock = origin.after.then(origin.union, rest);
        self.clock = self.clock.later(clock);
        round.cells += 1;
        rest.then(origin.union);
        round.charge(rest);
        let cell = OpenCell { vertices, conflicts, clock, open: slots.len() };
        match self.cells.get_mut(index as usize) {
            Some(slot) => *slot = cell,
            None => self.cells.push(cell),
        }
    }

    /// Selects the candidates that conflict with a new cell. A copy-scan copies the cell to each candidate.
    fn conflicts(
        &self,
        vertices: &P::Cell,
        candidates: Vec<(u32, bool)>,
        round: &mut Round,
        cost: &mut Cost,
    ) -> Vec<u32> {
        if candidates.is_empty() {
            return Vec::new();
        }
        let copy = |(point, certain)| Candidate::<P> { point, certain, cell: P::Cell::splat(INFINITE) };
        let mut candidates: Vec<Candidate<P>> = candidates.into_iter().map(copy).collect();
        cost.broadcast(&mut candidates, |c| c.cell = *vertices);
        let kept = cost.pack(&candidates, |c| {
            round.tests += u64::from(!c.certain);
            c.certain || self.in_conflict(&c.cell, c.point)
        });
        cost.close(candidates.len() as u64);
        kept.into_iter().map(|c| c.point).collect()
    }

    /// Settles one more facet of a cell. After the last one, the cell is part of the result or removed.
    fn release(&mut self, index: u32) {
        let cell = &mut self.cells[index as usize];
        cell.open -= 1;
        if cell.open > 0 {
            return;
        }
        if !cell.conflicts.is_empty() {
            cell.conflicts = Vec::new();
        } else if cell.vertices.as_ref().contains(&INFINITE) {
            self.infinite += 1;
        } else {
            self.finite.push(cell.vertices);
        }
        self.free.push(index);
    }

    /// Returns `true` if a later point lies inside the circumsphere of a cell, or beyond the hull facet of an infinite
    /// cell.
    fn in_conflict(&self, vertices: &P::Cell, point: u32) -> bool {
        let n = P::DIM + 1;
        let q = self.points[point as usize];
        let mut corners = [q; 4];
        let mut outer = None;
        for (slot, &v) in vertices.as_ref().iter().enumerate() {
            match self.points.get(v as usize) {
                Some(&p) => corners[slot] = p,
                None => outer = Some(slot),
            }
        }
        // The corner of infinity already holds the query.
        match outer.map(|slot| (slot, orientation(&corners[..n]))) {
            None => in_sphere(&corners[..n], q),
            Some((_, Sign::Positive)) => true,
            Some((_, Sign::Negative)) => false,
            Some((slot, Sign::Zero)) => in_sphere(&self.inner_cell(corners, slot)[..n], q),
        }
    }

    /// Returns a positively oriented cell on the inner side of a hull facet. It is needed only for points in the
    /// plane of the facet, and for them every such cell gives the same answer.
    fn inner_cell(&self, mut corners: [P; 4], slot: usize) -> [P; 4] {
        let n = P::DIM + 1;
        for &apex in &self.points[..n] {
            corners[slot] = apex;
            // The first points are not coplanar, and none of them lies beyond the facet.
            if orientation(&corners[..n]) == Sign::Negative {
                break;
            }
        }
        corners.swap(0, 1);
        corners
    }
}

/// Returns the sorted vertices of a cell except one, which identify a facet.
fn facet_without<P: Point>(vertices: &P::Cell, slot: usize) -> P::Facet {
    let mut facet = P::Facet::splat(INFINITE);
    let others = vertices.as_ref().iter().enumerate().filter(|v| v.0 != slot);
    facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
    facet.as_mut().sort_unstable();
    facet
}

#[cfg(test)]
mod tests;
