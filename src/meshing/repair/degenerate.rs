//! Elements without length or area are dropped.
//!
//! **Statement.** A facet whose corners lie on a line covers no area, so the union of the facets stays the same. Its
//! edges may then lie on others without being equal to them, which [`super::junctions`] divides.
//!
//! **Work and depth.** O(1) exact signs for each corner.

use super::change::{Change, Dropped};
use super::mending::Mending;
use crate::defect::Element;
use crate::input::DomainKind;
use crate::space::Space;

/// Drops segments without length, and facets without area.
pub(super) fn degenerate<P: Space>(mending: &mut Mending<P>, scaled: &[P]) {
    let same = mending.same();
    let id = |v: u32| same.get(v as usize).copied().unwrap_or(v);
    let (changes, points) = (&mut mending.changes, &mending.input.points);
    let mut drop = |element, v: u32| {
        let at = Mending::place(points[v as usize]);
        changes.push(Change::Dropped { element, why: Dropped::Degenerate, at });
    };
    let exists = |list: &[u32]| list.iter().all(|&v| (v as usize) < scaled.len());
    mending.input.segments.retain(|s| {
        let keep = !exists(&s.ends) || id(s.ends[0]) != id(s.ends[1]);
        if !keep {
            drop(Element::Segment(s.ends), s.ends[0]);
        }
        keep
    });
    let surface = mending.input.kind == DomainKind::Surface;
    let mut keep = Vec::with_capacity(mending.input.facets.len());
    for (facet, &origin) in mending.input.facets.iter().zip(&mending.origin) {
        let corners = facet.polygons.concat();
        let is_lines = !surface && facet.polygons.iter().all(|l| l.len() < 3);
        let is_kept = P::DIM == 2 || is_lines || !exists(&corners) || has_area(&corners, scaled);
        if !is_kept {
            drop(Element::Facet(origin), corners.first().copied().unwrap_or(0));
        }
        keep.push(is_kept);
    }
    mending.retain(&keep);
}

/// Returns `true` if three of the corners are not collinear.
pub(super) fn has_area<P: Space>(corners: &[u32], scaled: &[P]) -> bool {
    let p = |v: u32| scaled[v as usize];
    let Some((&a, rest)) = corners.split_first() else { return false };
    let Some(&b) = rest.iter().find(|&&b| p(b) != p(a)) else { return false };
    rest.iter().any(|&c| !P::collinear(p(a), p(b), p(c)))
}
