//! Comparison and search of links in star splaying, with their charges.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::point::Point;

/// The facets in which two links differ.
pub(crate) struct LinkDifference<F> {
    /// The facets that only the new link has.
    pub(crate) gained: Vec<F>,
    /// The facets that only the old link has.
    pub(crate) lost: Vec<F>,
}

/// Compares two links. Sorts the facets of both links together and keeps the facets that have no equal neighbour in
/// this order.
pub(crate) fn difference<P: Point>(
    old: &[P::Facet],
    new: &[P::Facet],
    cost: &mut Cost,
) -> LinkDifference<P::Facet> {
    let mut own = cost.nested();
    let both: Vec<(P::Facet, bool)> =
        old.iter().map(|&f| (f, false)).chain(new.iter().map(|&f| (f, true))).collect();
    let mut both = own.map(&both, |&(mut facet, is_new)| {
        facet.as_mut().sort_unstable();
        // The key is the concatenation of the vertices.
        let key = facet.as_ref().iter().fold(0u128, |key, &v| key << 32 | u128::from(v));
        (key, facet, is_new)
    });
    own.sort(&mut both, |a, b| a.0.cmp(&b.0));
    let key_at = |i: Option<usize>| i.and_then(|i| both.get(i)).map(|f| f.0);
    let indices: Vec<usize> = (0..both.len()).collect();
    let unmatched = own.pack(&indices, |&i| {
        let key = key_at(Some(i));
        key != key_at(i.checked_sub(1)) && key != key_at(Some(i + 1))
    });
    let (gained, lost): (Vec<usize>, Vec<usize>) = own.split(&unmatched, |&i| both[i].2);
    cost.then(own);
    let facets = |indices: Vec<usize>| indices.into_iter().map(|i| both[i].1).collect();
    LinkDifference { gained: facets(gained), lost: facets(lost) }
}

/// Returns the sum of vertex indices, which serves as a hash.
#[inline]
fn sum_of(vertices: &[u32]) -> u32 {
    vertices.iter().fold(0, |sum: u32, &v| sum.wrapping_add(v))
}

/// Returns a function that tests whether a facet in the link of `vertex` is the facet of a cell. It compares the sums of
/// vertices first. Different facets of a link have different sets of vertices.
pub(crate) fn is_facet_of<P: Point>(cell: &P::Cell, vertex: u32) -> impl Fn(&P::Facet) -> bool {
    let others = sum_of(cell.as_ref()).wrapping_sub(vertex);
    move |facet| sum_of(facet.as_ref()) == others && facet.as_ref().iter().all(|v| cell.as_ref().contains(v))
}

/// The link of an owned point, prepared for searches.
pub(crate) struct LinkSearch<'a, P: Point> {
    link: &'a [P::Facet],
    vertex: u32,
    /// The sum of each facet's vertices.
    sums: Vec<u32>,
}

impl<'a, P: Point> LinkSearch<'a, P> {
    /// Prepares the link of `vertex`.
    pub(crate) fn new(link: &'a [P::Facet], vertex: u32) -> Self {
        LinkSearch { link, vertex, sums: link.iter().map(|facet| sum_of(facet.as_ref())).collect() }
    }

    /// Returns `true` if the star has a cell. Charges a comparison with every facet. Compares sums first, and vertices only if
    /// some sum is equal.
    pub(crate) fn contains(&self, cell: &P::Cell, sweep: &mut Sweep) -> bool {
        let sums = sweep.visit_all(&self.sums);
        let others = sum_of(cell.as_ref()).wrapping_sub(self.vertex);
        let mut any = false;
        for &sum in sums {
            any |= sum == others;
        }
        let mut candidates = self.sums.iter().zip(self.link).filter(|&(&sum, _)| sum == others);
        any && candidates.any(|(_, facet)| facet.as_ref().iter().all(|v| cell.as_ref().contains(v)))
    }
}

/// Returns the finite vertices of a link, each once.
pub(crate) fn link_points<P: Point>(link: &[P::Facet], seen: &mut Marks, cost: &mut Cost) -> Vec<u32> {
    let mut points = bytemuck::cast_slice::<_, u32>(link).to_vec();
    cost.distinct_indices(&mut points, seen);
    points.retain(|&v| v != INFINITE);
    points
}
