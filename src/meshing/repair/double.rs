//! Facets with the same corners.
//!
//! **Statement.** Inside is what an odd number of facets separates from the outside. An even number of equal facets
//! separates nothing, so none of them matters; of an odd number, one does. If the file lists a facet twice by mistake,
//! one of the two belongs to the surface, though. The edges tell: each closed surface has an even number of facets at
//! every edge. So equal facets that share edges are taken together. One of each stays if this leaves fewer edges with an
//! odd number of facets than none does, or as many. In a complex, where edges may be open, one stays.
//!
//! **Work and depth.** `O(m log m)`, sequential.

use std::collections::{BTreeMap, BTreeSet};

use super::change::{Change, Dropped};
use super::mending::Mending;
use crate::defect::Element;
use crate::input::DomainKind;
use crate::sides::Sets;
use crate::space::Space;

/// Drops facets with the corners of others.
pub(super) fn double<P: Space>(mending: &mut Mending<P>) {
    let same = mending.same();
    let groups = groups(mending, &same);
    if groups.is_empty() {
        return;
    }
    let all: BTreeSet<u32> = groups.iter().flatten().copied().collect();
    let mut base: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for facet in (0..mending.input.facets.len() as u32).filter(|f| !all.contains(f)) {
        for edge in mending.edges_of(facet, &same) {
            *base.entry(edge).or_default() += 1;
        }
    }
    let edges: Vec<Vec<[u32; 2]>> = groups.iter().map(|g| mending.edges_of(g[0], &same)).collect();
    let mut sets = Sets::new(groups.len());
    let mut at: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for (g, edges) in edges.iter().enumerate() {
        for &edge in edges {
            let first = *at.entry(edge).or_insert(g as u32);
            sets.join(first, g as u32);
        }
    }
    let mut joined: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for g in 0..groups.len() {
        joined.entry(sets.find(g as u32)).or_default().push(g);
    }
    let mut keep = vec![true; mending.input.facets.len()];
    for members in joined.into_values() {
        let mut added: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for &edge in members.iter().flat_map(|&g| &edges[g]) {
            *added.entry(edge).or_default() += 1;
        }
        let odd = |with: u32| {
            let count = |(e, n): (&[u32; 2], &u32)| (base.get(e).copied().unwrap_or(0) + with * n) % 2;
            added.iter().map(count).sum::<u32>()
        };
        let stays = mending.input.kind == DomainKind::Complex || odd(1) <= odd(0);
        for &f in members.iter().flat_map(|&g| &groups[g][usize::from(stays)..]) {
            keep[f as usize] = false;
        }
    }
    for f in (0..keep.len()).filter(|&f| !keep[f]) {
        let corner = mending.input.facets[f].polygons[0][0];
        let at = Mending::place(mending.input.points[corner as usize]);
        let element = Element::Facet(mending.origin[f]);
        mending.changes.push(Change::Dropped { element, why: Dropped::Double, at });
    }
    mending.retain(&keep);
}

/// Returns the lists of facets with equal corners. Facets of several polygons are not compared, and the facets of
/// different solids do not count as equal.
pub(super) fn groups<P: Space>(mending: &Mending<P>, same: &[u32]) -> Vec<Vec<u32>> {
    let mut by_corners: BTreeMap<(Vec<u32>, Vec<u32>), Vec<u32>> = BTreeMap::new();
    for (f, facet) in mending.input.facets.iter().enumerate() {
        let [polygon] = &facet.polygons[..] else { continue };
        let corners: Option<Vec<u32>> = polygon.iter().map(|&v| same.get(v as usize).copied()).collect();
        let Some(mut corners) = corners.filter(|c| c.len() > 2 && facet.holes.is_empty()) else { continue };
        corners.sort_unstable();
        by_corners.entry((corners, mending.solids_of(f))).or_default().push(f as u32);
    }
    by_corners.into_values().filter(|g| g.len() > 1).collect()
}
