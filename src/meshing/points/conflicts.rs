//! Conflicts between sites.
//!
//! **Statement.** Sites p and q conflict iff `|p - q| < min(f(p), f(q))`, decided by one expression that is symmetric
//! to the last bit. Whoever conflicts with p lies in the box of half side `f(p)` around it.
//!
//! **Work and depth.** `O(m log m)` and the sites in the boxes; where all sites are candidates of cells, a constant
//! number for each.

use septet_geometry::point::Point;

use crate::bvh::{Bounds, Bvh};

/// A place with the size there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site<P> {
    /// The place.
    pub at: P,
    /// The size function's value.
    pub size: f64,
}

impl<P: Point> Site<P> {
    /// Are the sites closer than the smaller of their sizes?
    pub fn conflicts(&self, other: &Self) -> bool {
        let least = self.size.min(other.size);
        (self.at - other.at).norm2() < least * least
    }

    /// A box that holds every site in conflict.
    fn reach(&self) -> Bounds<P> {
        // What is in conflict as rounded may be farther by a few units in the last place.
        let half = P::splat(self.size * (1.0 + 1e-9));
        Bounds { low: self.at - half, high: self.at + half }
    }
}

/// Sites that can be asked for conflicts.
#[derive(Clone, Debug)]
pub struct Sites<'a, P> {
    sites: &'a [Site<P>],
    tree: Bvh<P>,
}

impl<'a, P: Point> Sites<'a, P> {
    /// Makes them ready.
    pub fn new(sites: &'a [Site<P>]) -> Self {
        Sites { sites, tree: Bvh::new(sites.iter().map(|s| Bounds::of([s.at])).collect()) }
    }

    /// The positions of those in conflict with a site, ascending; the site itself, if it is one of them, too.
    pub fn against(&self, site: &Site<P>) -> Vec<u32> {
        let mut near = self.tree.meeting(&site.reach());
        near.retain(|&i| site.conflicts(&self.sites[i as usize]));
        near
    }

    /// Is any of them in conflict with the site?
    pub fn any_against(&self, site: &Site<P>) -> bool {
        let mut found = false;
        self.tree.visit(&site.reach(), |i| {
            found = site.conflicts(&self.sites[i as usize]);
            !found
        });
        found
    }

    /// The conflict graph: the neighbours of each site, ascending.
    pub fn graph(&self) -> Vec<Vec<u32>> {
        let others = |(i, site): (usize, &Site<P>)| {
            let mut near = self.against(site);
            near.retain(|&j| j as usize != i);
            near
        };
        self.sites.iter().enumerate().map(others).collect()
    }
}
