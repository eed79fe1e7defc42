//! What the generator asks of the machine.

use glam::DVec2;
use septet_geometry::complex::INFINITE;
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::{Point, Simplex, lex_cmp};
use septet_geometry::priority::{compare, priority};

use crate::points::conflicts::{Site, Sites};
use crate::points::independent::{Independent, by_rounds};

/// A Delaunay triangulation with its adjacency.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulation<C> {
    /// `d + 1` vertices a cell, positively oriented.
    pub cells: Vec<C>,
    /// Across the facet opposite each vertex a cell, or `u32::MAX` across the hull.
    pub neighbours: Vec<C>,
}

/// Finds independent sets and triangulations.
pub trait Machine<P: Point> {
    /// Why it could not.
    type Error;

    /// What follows belongs to this stage.
    fn stage(&mut self, _name: &'static str) {}

    /// The maximal independent set of the conflict graph that contains the first `fixed` sites and is otherwise
    /// the greedy one of a random order that depends on nothing but the places; its other members. No two sites
    /// coincide. Machines that take the order of [`septet_geometry::priority`] make the same points.
    ///
    /// # Errors
    /// The machine's own.
    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Self::Error>;

    /// The Delaunay triangulation. Without cells if the points do not span the space.
    ///
    /// # Errors
    /// The machine's own.
    fn delaunay(&mut self, points: &[P]) -> Result<Triangulation<P::Cell>, Self::Error>;

    /// The same in the planes of facets, several at once.
    ///
    /// # Errors
    /// The machine's own.
    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Self::Error>;

    /// Maps items, in order; on all cores where there are some.
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U>
    where
        Self: Sized;
}

/// One processor, no messages: what the machine is compared with.
#[derive(Clone, Copy, Debug)]
pub struct Alone {
    /// Decides priorities.
    pub seed: u64,
}

impl<P: Point> Machine<P> for Alone {
    type Error = IncrementalError;

    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Self::Error> {
        let (earlier, new) = sites.split_at(fixed);
        let earlier = Sites::new(earlier);
        let barred: Vec<bool> = new.iter().map(|s| !earlier.against(s).is_empty()).collect();
        let graph = Sites::new(new).graph();
        let mut set = by_rounds(&graph, &ranks(self.seed, new), &barred);
        set.members.iter_mut().for_each(|m| *m += fixed as u32);
        Ok(set)
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Triangulation<P::Cell>, Self::Error> {
        let built = match Incremental::new(points.to_vec()) {
            Err(IncrementalError::Flat { .. }) => {
                return Ok(Triangulation { cells: Vec::new(), neighbours: Vec::new() });
            }
            built => built?,
        };
        let complex = built.complex();
        let mut number = vec![u32::MAX; complex.slots() as usize];
        let finite = || complex.entries().filter(|(_, cell, _)| !cell.as_ref().contains(&INFINITE));
        for (i, (slot, _, _)) in finite().enumerate() {
            number[slot as usize] = i as u32;
        }
        let mut made = Triangulation { cells: Vec::new(), neighbours: Vec::new() };
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
        let one = |points: &Vec<DVec2>| Ok(Machine::<DVec2>::delaunay(&mut self.clone(), points)?.cells);
        sets.iter().map(one).collect()
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}

/// The place of each site in the order of priorities.
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

/// Keeps the first of each group of coincident sites; sites come out in lexicographic order of their places.
pub(super) fn distinct<P: Point, T>(mut sites: Vec<(Site<P>, T)>) -> Vec<(Site<P>, T)> {
    sites.sort_by(|a, b| lex_cmp(&a.0.at, &b.0.at));
    sites.dedup_by(|b, a| a.0.at == b.0.at);
    sites
}
