//! Look-ups of cells in stars.
//!
//! **Statement.** A star has a cell iff its link has the facet of the cell opposite the star's vertex. The links of large
//! stars are sorted once, and searched by bisection. Other links have O(1) facets, which are compared one by one.
//!
//! **Work.** O(log l) comparisons for a link of `l` facets, after O(l log l) for its sort. [`crate::stars::check`] charges the
//! delivery that would look all cells up at once.

use std::collections::BTreeMap;

use septet_geometry::point::{Point, Simplex};

use crate::stars::links::is_facet_of;
use crate::stars::owned::Stars;

/// Number of facets above which a link is sorted.
const SORTED: usize = 128;

/// The stars of a rank, prepared for look-ups. Valid until a star changes.
pub(crate) struct LookUp<'a, P: Point> {
    stars: &'a Stars<P>,
    /// The facets of large links in the order of their vertices, each with its position in the link.
    sorted: BTreeMap<u32, Vec<(P::Facet, u32)>>,
}

impl<'a, P: Point> LookUp<'a, P> {
    /// Prepares look-ups in the stars of these owned points.
    pub(crate) fn new(stars: &'a Stars<P>, vertices: impl Iterator<Item = u32>) -> Self {
        let mut sorted = BTreeMap::new();
        for vertex in vertices.filter(|&v| stars.link(v).len() > SORTED) {
            sorted.entry(vertex).or_insert_with(|| in_order::<P>(stars.link(vertex)));
        }
        LookUp { stars, sorted }
    }

    /// Returns the position of a cell's facet in the link of its vertex `vertex`, among the facets of all links.
    pub(crate) fn position_in(&self, vertex: u32, cell: &P::Cell) -> Option<u32> {
        let Some(facets) = self.sorted.get(&vertex) else {
            let at = self.stars.link(vertex).iter().position(is_facet_of::<P>(cell, vertex))?;
            return Some(self.stars.start(vertex) + at as u32);
        };
        let mut facet = P::Facet::splat(vertex);
        let others = cell.as_ref().iter().filter(|&&v| v != vertex);
        facet.as_mut().iter_mut().zip(others).for_each(|(slot, &v)| *slot = v);
        facet.as_mut().sort_unstable();
        let at = facets.binary_search_by(|entry| entry.0.cmp(&facet)).ok()?;
        Some(self.stars.start(vertex) + facets[at].1)
    }
}

/// Returns the facets of a link, sorted, with their positions.
fn in_order<P: Point>(link: &[P::Facet]) -> Vec<(P::Facet, u32)> {
    let mut facets: Vec<(P::Facet, u32)> = link.iter().copied().zip(0..).collect();
    for (facet, _) in &mut facets {
        facet.as_mut().sort_unstable();
    }
    facets.sort_unstable();
    facets
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::Draw;

    use super::*;

    /// Large and small links, and cells that they lack.
    fn cells_are_found<P: Point>(link: &dyn Fn(u32) -> Vec<P::Facet>) {
        let mut stars: Stars<P> = Stars::default();
        let sizes = [3 * SORTED as u32, 20, 0, SORTED as u32 + 1];
        for &size in &sizes {
            let facets = link(size);
            stars.append(&facets, &[facets.len() as u32]);
        }
        let look_up = LookUp::new(&stars, 0..4);
        assert_eq!(look_up.sorted.len(), 2);
        let mut draw = Draw::new(3);
        for vertex in 0..4 {
            for (at, facet) in (stars.start(vertex)..).zip(stars.link(vertex)) {
                let mut cell = P::Cell::splat(vertex);
                cell.as_mut()[1..].copy_from_slice(facet.as_ref());
                draw.shuffle(cell.as_mut());
                assert_eq!(look_up.position_in(vertex, &cell), Some(at));
                let first = cell.as_ref().iter().position(|&v| v != vertex).unwrap();
                cell.as_mut()[first] = 5;
                assert_eq!(look_up.position_in(vertex, &cell), None);
            }
        }
    }

    #[test]
    fn cells_are_found_in_links_of_any_size() {
        cells_are_found::<DVec3>(&|size| (0..size).map(|i| [10 + i, 1000 + 7 * i % 501, 9000 - i]).collect());
        cells_are_found::<DVec2>(&|size| (0..size).map(|i| [10 + i, 5000 - 3 * i]).collect());
    }
}
