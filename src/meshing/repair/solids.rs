//! Several solids as one domain.
//!
//! **Statement.** A solid is closed if every edge has an even number of its facets. Then the number of its facets that a
//! path in general position crosses has a parity that depends only on the ends. A point is in the solid if the
//! parity from the outside is odd. If all solids are closed, the domain is their union. The region of a component is
//! the solid with the least volume that contains it: an inclusion is cut out of the solid around it. Facets that two
//! solids share separate them and count once, for both.
//!
//! If a solid is not closed, the solids are parts of one surface (inlet, wall), and their numbers are markers.
//!
//! **Work and depth.** `O(m log m)` for the edges and for the walls, sequential.

use std::collections::{BTreeMap, BTreeSet};

use super::change::Change;
use super::mending::Mending;
use crate::domain::Component;
use crate::input::Region;
use crate::sides::Sides;
use crate::simplices::Simplices;
use crate::space::Space;

/// The solids to which each facet of a prepared input belongs.
#[derive(Clone, Debug, PartialEq)]
pub struct Solids {
    count: u32,
    of: Vec<Vec<u32>>,
}

/// Decides whether solids are regions or parts of a surface. Numbers of solids become markers of facets.
pub(super) fn solids<P: Space>(mending: &mut Mending<P>) {
    if mending.solids.is_empty() {
        return;
    }
    let names: Vec<String> = mending.input.solids.iter().map(|s| s.name.clone()).collect();
    for (facet, solids) in mending.input.facets.iter_mut().zip(&mending.solids) {
        facet.marker = i64::from(solids[0]) + 1;
    }
    if are_closed(mending) {
        mending.is_by_regions = true;
        let shared = merge(mending);
        mending.changes.push(Change::Regions { names, shared });
    } else {
        mending.changes.push(Change::Parts { names });
    }
}

/// Returns `true` if every edge has an even number of facets of each solid.
fn are_closed<P: Space>(mending: &Mending<P>) -> bool {
    let same = mending.same();
    let mut odd: BTreeSet<(u32, [u32; 2])> = BTreeSet::new();
    for facet in 0..mending.input.facets.len() as u32 {
        let solid = mending.solids[facet as usize][0];
        for edge in mending.edges_of(facet, &same) {
            if !odd.insert((solid, edge)) {
                odd.remove(&(solid, edge));
            }
        }
    }
    odd.is_empty()
}

/// Merges equal facets of different solids. Returns the number of facets that others stand for.
fn merge<P: Space>(mending: &mut Mending<P>) -> u64 {
    let same = mending.same();
    let mut first: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    let mut keep = vec![true; mending.input.facets.len()];
    for (f, facet) in mending.input.facets.iter().enumerate() {
        let mut corners: Vec<u32> = facet.polygons.concat();
        for v in &mut corners {
            *v = same.get(*v as usize).copied().unwrap_or(*v);
        }
        corners.sort_unstable();
        let one = *first.entry(corners).or_insert(f);
        let solid = mending.solids[f][0];
        if one != f && !mending.solids[one].contains(&solid) {
            mending.solids[one].push(solid);
            keep[f] = false;
        }
    }
    mending.retain(&keep);
    keep.iter().filter(|kept| !**kept).count() as u64
}

impl Solids {
    pub(super) fn new(count: u32, of: Vec<Vec<u32>>) -> Self {
        Solids { count, of }
    }

    /// Returns the solids of which a facet is part of the boundary.
    fn at(&self, facet: u32) -> &[u32] {
        self.of.get(facet as usize).map_or(&[], Vec::as_slice)
    }

    /// Sets which components are inside, and their regions. Returns the regions.
    pub(crate) fn classify<P: Space>(
        &self,
        simplices: &Simplices<P>,
        sides: &Sides<P>,
        components: &mut [Component],
    ) -> Vec<Region<P>> {
        let mut near: Vec<Vec<(u32, u32)>> = vec![Vec::new(); components.len()];
        for (wall, &facet) in simplices.owner.iter().enumerate() {
            let [a, b] = sides.components_at(wall as u32);
            near[a as usize].push((b, facet));
            near[b as usize].push((a, facet));
        }
        let mut within: Vec<Option<BTreeSet<u32>>> = vec![None; components.len()];
        within[0] = Some(BTreeSet::new());
        let mut stack = vec![0u32];
        while let Some(c) = stack.pop() {
            for &(n, facet) in &near[c as usize] {
                if within[n as usize].is_none() {
                    let mut set = within[c as usize].clone().unwrap_or_default();
                    for solid in self.at(facet) {
                        if !set.insert(*solid) {
                            set.remove(solid);
                        }
                    }
                    within[n as usize] = Some(set);
                    stack.push(n);
                }
            }
        }
        let within: Vec<BTreeSet<u32>> = within.into_iter().map(Option::unwrap_or_default).collect();
        let mut volumes = vec![0.0; self.count as usize];
        for (set, component) in within.iter().zip(&*components) {
            for &s in set {
                volumes[s as usize] += component.measure;
            }
        }
        for (set, component) in within.iter().zip(&mut *components) {
            let least =
                |a: &&u32, b: &&u32| volumes[**a as usize].total_cmp(&volumes[**b as usize]).then(b.cmp(a));
            component.region = set.iter().min_by(least).copied();
            component.inside = component.region.is_some();
        }
        let place = |solid: u32| {
            let owned = |f: &u32| self.at(*f).contains(&solid);
            let wall = simplices.owner.iter().position(owned).unwrap_or(0);
            let corner = simplices.walls.get(wall).map_or(0, |w| w.as_ref()[0]);
            septet_geometry::range::scale(simplices.points[corner as usize], -simplices.frame.exponent)
        };
        let region = |s: u32| Region { at: place(s), attribute: f64::from(s + 1), limit: None };
        (0..self.count).map(region).collect()
    }
}
