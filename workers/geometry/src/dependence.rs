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
//! **Charges.** The baseline is charged by the primitives of [`crate::cost`], as the paper's recursion is:
//! - the keys of the order, their sort, the search for the first points, and the move of the points;
//! - in each round: the pack of the ready facets, and a scan that assigns processors to candidates;
//! - for each facet: the comparison of the pivots, and the update of the facets that a cell has left;
//! - for each new cell: the union of the conflicts, a copy of the cell to each candidate, a test and a pack of the
//!   candidates, and for each of its facets the computation of a key and an access to the table of facets.
//!
//! **Departures.** The exterior is represented by a vertex, and the first affinely independent points are inserted
//! first, instead of a bounding simplex. The second cell of a facet is found in a table. An access to the table
//! counts one step, as in the paper, although an EREW machine would have to sort. Several facets of a cell can be settled
//! in one round, and each update counts one step. Both choices favour the baseline. [`crate::predicates`] breaks ties,
//! so the cells equal the cells of [`crate::incremental`].

mod counts;
mod network;
mod order;

use std::collections::BTreeMap;

pub use counts::{Clock, Round};
use network::Network;
pub use network::Traffic;
use order::Order;

use crate::complex::INFINITE;
use crate::cost::{Cost, Price};
use crate::incremental::IncrementalError;
use crate::point::{Point, Simplex};
use crate::predicates::{ExactTests, Sign, in_sphere, orientation};

/// The Delaunay triangulation, with the counts of its rounds.
#[derive(Clone, Debug)]
pub struct Dependence<P: Point> {
    /// Finite cells, positively oriented, as indices of the given points, in the order in which they were completed.
    pub cells: Vec<P::Cell>,
    /// Number of hull facets.
    pub hull_facets: u64,
    /// Maxima over all chains.
    pub clock: Clock,
    /// Counts of each round. The first round draws the order and tests all points against the first cells; the others
    /// settle facets.
    pub rounds: Vec<Round>,
    /// Exact tests of all rounds.
    pub exact_tests: ExactTests,
    /// The messages between the owners of the points.
    pub traffic: Traffic,
}

impl<P: Point> Dependence<P> {
    /// Triangulates distinct points, inserted in an order drawn from the seed.
    ///
    /// # Errors
    /// Fails if points coincide or are not finite, if there are too many, or if they do not span the space.
    pub fn new(points: &[P], seed: u64) -> Result<Self, IncrementalError> {
        Self::owned(points, seed, &[])
    }

    /// Triangulates points that have `owners`, and counts the messages between them. Without owners, there are none.
    ///
    /// # Errors
    /// See [`Dependence::new`].
    pub fn owned(points: &[P], seed: u64, owners: &[u32]) -> Result<Self, IncrementalError> {
        let exact = ExactTests::so_far();
        let mut drawing = Cost::default().nested();
        let order = Order::draw(points, seed, &mut drawing)?;
        let inserted = order.indices.iter().filter_map(|&i| owners.get(i as usize).copied());
        let network = Network::new(inserted.collect(), P::DIM);
        let mut builder = Builder::new(&order.positions, network);
        let mut joined = builder.start(drawing.price());
        while joined.iter().any(Option::is_some) {
            joined = builder.round(&joined);
        }
        let name = |mut cell: P::Cell| {
            cell.as_mut().iter_mut().for_each(|v| *v = order.indices[*v as usize]);
            cell
        };
        Ok(Dependence {
            cells: builder.finite.into_iter().map(name).collect(),
            hull_facets: builder.infinite,
            clock: builder.clock,
            rounds: builder.rounds,
            exact_tests: exact.since(),
            traffic: builder.network.traffic(),
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

    /// Returns the cost of the triangulation as a nested problem: the work of all rounds, and the steps of the longest
    /// chain.
    pub fn cost(&self) -> Cost {
        let Clock { steps, log_scan, .. } = self.clock;
        let mut cost = Cost::of_clock(self.total().work, steps, log_scan);
        cost.charge_exact_tests(self.exact_tests);
        cost
    }

    /// Returns Brent's bound on the number of steps with `processors` processors: the sum of
    /// `floor((work - steps) / processors) + steps` over all rounds.
    pub fn brent(&self, processors: u64) -> u64 {
        let bound = |r: &Round| r.work.saturating_sub(r.steps) / processors.max(1) + r.steps;
        self.rounds.iter().map(bound).sum()
    }
}

/// A cell with facets that are not settled.
#[derive(Clone, Debug)]
struct OpenCell<P: Point> {
    vertices: P::Cell,
    /// Later points inside the circumsphere, in the order of insertion. The first is the pivot.
    conflicts: Vec<u32>,
    clock: Clock,
    /// Number of facets that are not settled.
    open: usize,
    /// The owner that holds the cell.
    holder: u32,
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
    /// The meter of the new cell.
    lane: Cost,
    /// Cost of uniting the conflicts.
    union: Price,
    /// A slot whose facet has a known second cell.
    known: Option<(usize, Half)>,
    /// The owner that holds the new cell.
    holder: u32,
}

impl Default for Origin {
    fn default() -> Self {
        Origin {
            after: Clock::default(),
            lane: Cost::default().nested(),
            union: Price::ZERO,
            known: None,
            holder: 0,
        }
    }
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
    /// The steps that all cells of the round wait for.
    shared: Price,
    network: Network,
}

impl<'a, P: Point> Builder<'a, P> {
    fn new(points: &'a [P], network: Network) -> Self {
        Builder {
            points,
            cells: Vec::new(),
            free: Vec::new(),
            table: BTreeMap::new(),
            finite: Vec::new(),
            infinite: 0,
            clock: Clock::default(),
            rounds: Vec::new(),
            shared: Price::ZERO,
            network,
        }
    }

    /// Creates the first simplex and the infinite cells around it, after `drawing` the order. Tests every other point
    /// against each of these cells. Returns the facets that become ready, slot by slot.
    fn start(&mut self, drawing: Price) -> Vec<Option<ReadyFacet>> {
        self.shared = drawing;
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
        let mut joined = Vec::new();
        self.network.send_points();
        for vertices in cells {
            let others = (n as u32..self.points.len() as u32).map(|point| (point, false)).collect();
            let origin = Origin { holder: self.network.owner(0), ..Origin::default() };
            self.create(vertices, others, origin, &mut round, &mut joined);
        }
        self.network.end_round();
        round.charge_shared(self.shared);
        self.rounds.push(round);
        joined
    }

    /// Settles the ready facets among the slots of the cells of the last round. Returns the facets that become ready,
    /// slot by slot, for the next round.
    fn round(&mut self, slots: &[Option<ReadyFacet>]) -> Vec<Option<ReadyFacet>> {
        let ready = self.ready(slots);
        let mut round = Round { facets: ready.len() as u64, ..Round::default() };
        let mut joined = Vec::new();
        for facet in ready {
            self.tell_holders(&facet);
            let mut lane = Cost::default().nested();
            let replaced = lane.map(&[facet.sides], |&sides| self.replaced_side(sides));
            if let Some((old, other)) = replaced[0] {
                self.replace(old, other, lane, &mut round, &mut joined);
            } else {
                lane.map(&facet.sides, |side| self.release(side.cell));
                round.charge(lane.price());
            }
        }
        self.network.end_round();
        round.charge_shared(self.shared);
        self.rounds.push(round);
        joined
    }

    /// Tells the holders of both cells of a facet that it is settled.
    fn tell_holders(&mut self, facet: &ReadyFacet) {
        for side in facet.sides {
            let cell = &self.cells[side.cell as usize];
            self.network.tell(facet_without::<P>(&cell.vertices, side.slot).as_ref(), cell.holder);
        }
    }

    /// Packs the ready facets, and assigns processors to their candidates by a scan over the numbers of conflicts.
    fn ready(&mut self, slots: &[Option<ReadyFacet>]) -> Vec<ReadyFacet> {
        let mut cost = Cost::default().nested();
        let ready: Vec<ReadyFacet> = cost.pack(slots, Option::is_some).into_iter().flatten().collect();
        let conflicts = |side: &Half| self.cells[side.cell as usize].conflicts.len();
        let candidates = cost.map(&ready, |facet| facet.sides.iter().map(conflicts).sum());
        cost.scan(&candidates);
        self.shared = cost.price();
        ready
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
        mut lane: Cost,
        round: &mut Round,
        joined: &mut Vec<Option<ReadyFacet>>,
    ) {
        let (t, o) = (&self.cells[old.cell as usize], &self.cells[other.cell as usize]);
        let mut vertices = t.vertices;
        vertices.as_mut()[old.slot] = t.conflicts[0];
        let mut union = Cost::default().nested();
        // The pivot is a vertex of the new cell, not a conflict.
        let candidates = union.unite(&t.conflicts[1..], &o.conflicts);
        let after = t.clock.later(o.clock);
        let holder = self.network.owner(t.conflicts[0]);
        for (half, cell) in [(old, t), (other, o)] {
            self.network.copy((half.cell, cell.holder), cell.conflicts.len(), holder);
        }
        lane.map(&[old], |old| self.release(old.cell));
        let origin = Origin { after, lane, union: union.price(), known: Some((old.slot, other)), holder };
        self.create(vertices, candidates, origin, round, joined);
    }

    /// Creates a cell from its vertices and the candidates for its conflicts.
    fn create(
        &mut self,
        vertices: P::Cell,
        candidates: Vec<(u32, bool)>,
        origin: Origin,
        round: &mut Round,
        joined: &mut Vec<Option<ReadyFacet>>,
    ) {
        let Origin { after, mut lane, union, known, holder } = origin;
        let index = self.free.pop().unwrap_or(self.cells.len() as u32);
        let conflicts = self.conflicts(&vertices, candidates, round, &mut lane);
        let slots: Vec<usize> = (0..=P::DIM).collect();
        let facets = lane.map(&slots, |&slot| (slot, facet_without::<P>(&vertices, slot)));
        for (_, facet) in &facets {
            self.network.report(facet.as_ref(), holder);
        }
        joined.extend(lane.map(&facets, |&(slot, facet)| {
            let half = Half { cell: index, slot };
            let known = known.filter(|k| k.0 == slot).map(|k| k.1);
            let mate = known.or_else(|| self.table.remove(&facet));
            if mate.is_none() {
                self.table.insert(facet, half);
            }
            mate.map(|mate| ReadyFacet { sides: [half, mate] })
        }));
        let mut own = lane.price();
        let mut rest = self.shared;
        rest.then(own);
        let clock = after.then(union, rest);
        self.clock = self.clock.later(clock);
        round.cells += 1;
        own.then(union);
        round.charge(own);
        let cell = OpenCell { vertices, conflicts, clock, open: slots.len(), holder };
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
