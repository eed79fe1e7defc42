//! Links of stars, compared and tested: what the exchange does with them, charged.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::point::Point;

/// The facets of a new link that the old one lacks, and those of the old one that the new one lacks: both are
/// sorted together, and what stands alone is packed.
pub(crate) fn difference<P: Point>(
    old: &[P::Facet],
    new: &[P::Facet],
    cost: &mut Cost,
) -> (Vec<P::Facet>, Vec<P::Facet>) {
    let mut own = Cost::ZERO;
    let both: Vec<(P::Facet, bool)> =
        old.iter().map(|&f| (f, false)).chain(new.iter().map(|&f| (f, true))).collect();
    let mut both = own.map(&both, |&(mut facet, is_new)| {
        facet.as_mut().sort_unstable();
        // The vertices as one number.
        let key = facet.as_ref().iter().fold(0u128, |key, &v| key << 32 | u128::from(v));
        (key, facet, is_new)
    });
    own.sort(&mut both, |a, b| a.0.cmp(&b.0));
    let at = |i: Option<usize>| i.and_then(|i| both.get(i)).map(|f| f.0);
    let places: Vec<usize> = (0..both.len()).collect();
    let alone = own.pack(&places, |&i| {
        let this = at(Some(i));
        this != at(i.checked_sub(1)) && this != at(Some(i + 1))
    });
    let (fresh, gone): (Vec<usize>, Vec<usize>) = own.split(&alone, |&i| both[i].2);
    own.close(both.len() as u64);
    cost.then(own);
    let facets = |places: Vec<usize>| places.into_iter().map(|i| both[i].1).collect();
    (facets(fresh), facets(gone))
}

/// The sum of some vertices' numbers.
#[inline]
fn sum_of(vertices: &[u32]) -> u32 {
    vertices.iter().fold(0, |sum: u32, &v| sum.wrapping_add(v))
}

/// Is a facet of the link of a vertex that of a cell? No two facets of a link have the same vertices; that their sums are
/// equal is asked first.
pub(crate) fn is_facet_of<P: Point>(cell: &P::Cell, owned: u32) -> impl Fn(&P::Facet) -> bool {
    let others = sum_of(cell.as_ref()).wrapping_sub(owned);
    move |facet| sum_of(facet.as_ref()) == others && facet.as_ref().iter().all(|v| cell.as_ref().contains(v))
}

/// A link in which cells are looked for.
pub(crate) struct Sought<'a, P: Point> {
    link: &'a [P::Facet],
    owned: u32,
    /// The sum of each facet's vertices.
    sums: Vec<u32>,
}

impl<'a, P: Point> Sought<'a, P> {
    /// The link of a home vertex.
    pub(crate) fn of(link: &'a [P::Facet], owned: u32) -> Self {
        Sought { link, owned, sums: link.iter().map(|facet| sum_of(facet.as_ref())).collect() }
    }

    /// Has its star a cell? Looks at every facet: at its sum, and at its vertices only where some sum is that of
    /// the cell.
    pub(crate) fn has(&self, cell: &P::Cell, looks: &mut Sweep) -> bool {
        looks.visit_lanes(self.sums.len());
        let others = sum_of(cell.as_ref()).wrapping_sub(self.owned);
        let mut likely = false;
        for &sum in &self.sums {
            likely |= sum == others;
        }
        let mut likeliest = self.sums.iter().zip(self.link).filter(|&(&sum, _)| sum == others);
        likely && likeliest.any(|(_, facet)| facet.as_ref().iter().all(|v| cell.as_ref().contains(v)))
    }
}

/// The finite points of a link.
pub(crate) fn link_points<P: Point>(link: &[P::Facet], seen: &mut Marks, cost: &mut Cost) -> Vec<u32> {
    let mut points = bytemuck::cast_slice::<_, u32>(link).to_vec();
    cost.distinct_indices(&mut points, seen);
    points.retain(|&v| v != INFINITE);
    points
}
