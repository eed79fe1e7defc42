//! Where home stars do not agree with each other.
//!
//! **Statement.** See [`crate::stars::check`]: a cell is agreed on iff its smallest vertex' star agrees with each other's. Where the sums
//! of a worker's own pairs differ, the cells are looked for of those smallest vertices whose own sums differ ([`ShortSums`]).
//!
//! **Work and depth.** Two vector steps over all link facets, in which few cells are looked for in a link of O(1) facets.

use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};

use septet_geometry::point::Point;

use crate::config::{Pool, map_in};
use crate::stars::check::Disagreement;
use crate::stars::fingerprint_sums::{OpenShares, ShortSums, Sums};
use crate::stars::owned::Chart;
use crate::state::cells::finite_cell;
use crate::state::tree::{Leaf, owned_groups};

impl<P: Point> Chart<'_, P> {
    /// Finds what home stars hold and other home stars lack: among the cells of those smallest vertices whose own
    /// sums differ.
    pub(crate) fn locate(
        &self,
        pool: &Pool,
        leaves: &[Leaf<P>],
        short: Option<ShortSums>,
    ) -> Vec<Disagreement> {
        let groups = owned_groups(leaves);
        let open = short.unwrap_or_else(|| self.short_sums(pool, &groups)).open();
        let seen: Vec<AtomicU8> = (0..self.stars.arena_len()).map(|_| AtomicU8::new(0)).collect();
        let mut found = map_in(pool, &groups, |(_, owned_points)| {
            owned_points
                .clone()
                .flat_map(|owned| self.unknown_to_smallest(owned, &open, &seen))
                .collect::<Vec<_>>()
        });
        found.extend(map_in(pool, &groups, |(_, owned_points)| {
            let differing = owned_points.clone().filter(|&owned| open.of(owned) != 0);
            differing.flat_map(|owned| self.missing(owned, &open, &seen)).collect::<Vec<_>>()
        }));
        found.into_iter().flatten().collect()
    }

    /// The sums of each home vertex.
    fn short_sums(&self, pool: &Pool, groups: &[(usize, Range<u32>)]) -> ShortSums {
        let short = ShortSums::new(self.table.owned_len(), pool.is_none());
        map_in(pool, groups, |(_, owned_points)| {
            for owned in owned_points.clone() {
                self.sum_star(owned, self.stars.link(owned), true, &mut Sums::default(), Some(&short));
            }
        });
        short
    }

    /// Cells of a star that their smallest vertex, at home here, lacks; marks those it has.
    fn unknown_to_smallest(&self, owned: u32, open: &OpenShares, seen: &[AtomicU8]) -> Vec<Disagreement> {
        let mut found = Vec::new();
        for (facet, link) in (self.stars.start(owned)..).zip(self.stars.link(owned)) {
            // Most stars agree: only where one beside it does not, the smallest vertex is asked for.
            if link.as_ref().iter().fold(0, |any, &v| any | open.of(v)) == 0 {
                continue;
            }
            let Some(cell) = finite_cell::<P>(owned, link) else { continue };
            let smallest = self.smallest(&cell);
            if smallest == owned
                || open.of(smallest) == 0
                || !open.holds(smallest, self.stars.cell_hash(&cell))
            {
                continue;
            }
            match self.stars.position_in(smallest, &cell) {
                Some(at) => {
                    seen[at as usize].fetch_add(1, Ordering::Relaxed);
                }
                None => found.push(Disagreement { owned, facet, other: smallest }),
            }
        }
        found
    }

    /// Cells of a star that home vertices other than their smallest, this one, lack.
    fn missing(&self, owned: u32, open: &OpenShares, seen: &[AtomicU8]) -> Vec<Disagreement> {
        let mut found = Vec::new();
        for (facet, link) in (self.stars.start(owned)..).zip(self.stars.link(owned)) {
            let Some(cell) = finite_cell::<P>(owned, link) else { continue };
            let at_home = link.as_ref().iter().filter(|&&v| self.table.is_owned(v)).count();
            let known = usize::from(seen[facet as usize].load(Ordering::Relaxed));
            if known == at_home
                || self.smallest(&cell) != owned
                || !open.holds(owned, self.stars.cell_hash(&cell))
            {
                continue;
            }
            for &other in link.as_ref() {
                if self.table.is_owned(other) && self.stars.position_in(other, &cell).is_none() {
                    found.push(Disagreement { owned, facet, other });
                }
            }
        }
        found
    }
}
