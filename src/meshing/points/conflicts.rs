//! Conflicts between sites.
//!
//! **Statement.** Sites p and q conflict iff `|p - q| < min(f(p), f(q))`. A single expression decides this, and it is
//! symmetric to the last bit. Every site that conflicts with p lies in the box around p whose half side is `f(p)`.
//!
//! **Work and depth.** `O(m log m)`, plus the number of sites in the boxes. If all sites are candidates of cells,
//! this number is constant per site.

use septet_geometry::cost::Sweep;
use septet_geometry::evaluation::{At, Reader, Words};
use septet_geometry::point::Point;

use crate::bvh::{Bounds, Bvh};

/// A position, and the size there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site<P> {
    /// The position.
    pub at: P,
    /// The size function at the position.
    pub size: f64,
}

impl<P: Point> Words for Site<P> {
    fn write(&self, words: &mut Vec<u64>) {
        (At(self.at), self.size).write(words);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let (At(at), size) = Words::read(from);
        Site { at, size }
    }
}

impl<P: Point> Site<P> {
    /// Returns `true` if the sites are closer than the smaller of their sizes.
    pub fn conflicts(&self, other: &Self) -> bool {
        let least = self.size.min(other.size);
        (self.at - other.at).norm2() < least * least
    }

    /// Returns a box that contains every site in conflict with this one.
    fn reach(&self) -> Bounds<P> {
        // Because of rounding, sites in conflict may be farther by a few units in the last place.
        let half = P::splat(self.size * (1.0 + 1e-9));
        Bounds { low: self.at - half, high: self.at + half }
    }
}

/// Sites, with a tree for queries.
#[derive(Clone, Debug)]
pub struct Sites<'a, P> {
    sites: &'a [Site<P>],
    tree: Bvh<P>,
}

impl<'a, P: Point> Sites<'a, P> {
    /// Builds the tree.
    pub fn new(sites: &'a [Site<P>]) -> Self {
        Sites { sites, tree: Bvh::new(sites.iter().map(|s| Bounds::of([s.at])).collect()) }
    }

    /// Returns the indices of the sites in conflict with a site, in ascending order. If the site is in the list, it
    /// is included.
    pub fn against(&self, site: &Site<P>) -> Vec<u32> {
        self.against_counted(site, &mut Sweep::default())
    }

    /// Returns [`Sites::against`], and counts the visits of the tree.
    pub(crate) fn against_counted(&self, site: &Site<P>, visits: &mut Sweep) -> Vec<u32> {
        let mut near = self.tree.meeting_counted(&site.reach(), visits);
        near.retain(|&i| site.conflicts(&self.sites[i as usize]));
        near
    }

    /// Returns `true` if any site conflicts with the given site.
    pub fn any_against(&self, site: &Site<P>) -> bool {
        self.any_against_counted(site, &mut Sweep::default())
    }

    /// Returns [`Sites::any_against`], and counts the visits of the tree.
    pub(crate) fn any_against_counted(&self, site: &Site<P>, visits: &mut Sweep) -> bool {
        let mut found = false;
        self.tree.visit_counted(&site.reach(), visits, |i| {
            found = site.conflicts(&self.sites[i as usize]);
            !found
        });
        found
    }

    /// Returns the conflict graph: the neighbours of each site, in ascending order.
    pub fn graph(&self) -> Vec<Vec<u32>> {
        let others = |(i, site): (usize, &Site<P>)| {
            let mut near = self.against(site);
            near.retain(|&j| j as usize != i);
            near
        };
        self.sites.iter().enumerate().map(others).collect()
    }
}
