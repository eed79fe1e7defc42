//! Links of stars, compared and tested: what the exchange does with them, charged.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks};
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

/// The finite points of a link.
pub(crate) fn link_points<P: Point>(link: &[P::Facet], seen: &mut Marks, cost: &mut Cost) -> Vec<u32> {
    let mut points = Vec::with_capacity(P::DIM * link.len());
    for facet in link {
        points.extend_from_slice(facet.as_ref());
    }
    cost.distinct_numbers(&mut points, seen);
    points.retain(|&v| v != INFINITE);
    points
}
