//! The operations that the generator requests from the machine.

use glam::DVec2;
use septet_geometry::complex::INFINITE;
use septet_geometry::evaluation::{Evaluated, Evaluation};
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::{Point, Simplex, lex_cmp};
use septet_geometry::priority::{compare, priority};

use crate::executor::{Evaluator, Part, Sequential, Uncounted, always};
use crate::points::conflicts::{Site, Sites};
use crate::points::independent::{Independent, by_rounds};

/// A Delaunay triangulation and its adjacency.
#[derive(Clone, Debug, PartialEq)]
pub struct Delaunay<C> {
    /// `d + 1` vertices per cell, positively oriented.
    pub cells: Vec<C>,
    /// The cell across the facet opposite each vertex, or `u32::MAX` across the hull.
    pub neighbours: Vec<C>,
}

/// A provider of evaluations, independent sets and triangulations.
pub trait MeshMachine<P: Point>: Evaluator<P> {
    /// Begins a stage. Later runs belong to it.
    fn stage(&mut self, _name: &'static str) {}

    /// Returns an error if the caller has cancelled. Long sequential steps ask for it.
    fn cancelled(&self) -> Option<Self::Error> {
        None
    }

    /// Returns a maximal independent set of the conflict graph. It contains the first `fixed` sites, which are
    /// omitted from the result. The other members form the greedy set in a random order that depends only on the
    /// positions. No two of the given sites may coincide. All machines that use the order of
    /// [`septet_geometry::priority`] return the same sets.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Self::Error>;

    /// Returns the Delaunay triangulation. It has no cells if the points do not span the space.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    fn delaunay(&mut self, points: &[P]) -> Result<Delaunay<P::Cell>, Self::Error>;

    /// Returns the planar triangulations of several sets of points, given in the planes of their facets.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Self::Error>;

    /// Maps `f` over the items, in order. Implementations may use all cores.
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U>
    where
        Self: Sized;
}

/// A machine with one processor and no messages: the reference for tests.
#[derive(Clone, Copy, Debug)]
pub struct Alone {
    /// The seed of the priorities.
    pub seed: u64,
}

impl<P: Point> Evaluator<P> for Alone {
    type Error = IncrementalError;

    fn evaluate(&self, part: Part, rule: &dyn Evaluation) -> Result<Evaluated, Self::Error> {
        Ok(always(Evaluator::<P>::evaluate(&Uncounted(Sequential), part, rule)))
    }
}

impl<P: Point> MeshMachine<P> for Alone {
    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Self::Error> {
        let (earlier, new) = sites.split_at(fixed);
        let earlier = Sites::new(earlier);
        let barred: Vec<bool> = new.iter().map(|s| !earlier.against(s).is_empty()).collect();
        let graph = Sites::new(new).graph();
        let mut set = by_rounds(&graph, &ranks(self.seed, new), &barred);
        set.members.iter_mut().for_each(|m| *m += fixed as u32);
        Ok(set)
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Delaunay<P::Cell>, Self::Error> {
        let built = match Incremental::new(points.to_vec()) {
            Err(IncrementalError::Flat { .. }) => {
                return Ok(Delaunay { cells: Vec::new(), neighbours: Vec::new() });
            }
            built => built?,
        };
        let complex = built.complex();
        let mut number = vec![u32::MAX; complex.slots() as usize];
        let finite = || complex.entries().filter(|(_, cell, _)| !cell.as_ref().contains(&INFINITE));
        for (i, (slot, _, _)) in finite().enumerate() {
            number[slot as usize] = i as u32;
        }
        let mut made = Delaunay { cells: Vec::new(), neighbours: Vec::new() };
        for (slot, cell, _) in finite() {
            made.cells.push(*cell);
            let mut across = P::Cell::splat(u32::MAX);
            for (i, to) in across.as_mut().iter_mut().enumerate() {
                *to = number[complex.neighbour(slot, i).0 as usize];
            }
            made.neighbours.push(across);
        }
        Ok(made)
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Self::Error> {
        let one = |points: &Vec<DVec2>| Ok(MeshMachine::<DVec2>::delaunay(&mut self.clone(), points)?.cells);
        sets.iter().map(one).collect()
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}

/// Returns the rank of each site in the order of priorities.
fn ranks<P: Point>(seed: u64, sites: &[Site<P>]) -> Vec<u32> {
    let mut order: Vec<((u64, P), u32)> =
        sites.iter().zip(0..).map(|(s, i)| ((priority(seed, s.at), s.at), i)).collect();
    order.sort_unstable_by(|a, b| compare(a.0, b.0));
    let mut ranks = vec![0; sites.len()];
    for ((_, site), rank) in order.into_iter().zip(0..) {
        ranks[site as usize] = rank;
    }
    ranks
}

/// Sorts the sites lexicographically by position, and keeps the first of each group of coincident sites.
pub(super) fn distinct<P: Point, T>(mut sites: Vec<(Site<P>, T)>) -> Vec<(Site<P>, T)> {
    sites.sort_by(|a, b| lex_cmp(&a.0.at, &b.0.at));
    sites.dedup_by(|b, a| a.0.at == b.0.at);
    sites
}
