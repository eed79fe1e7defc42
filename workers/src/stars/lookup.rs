//! Where home stars do not agree with each other.
//!
//! **Statement.** See [`crate::stars::check`]: a cell is agreed on iff its smallest vertex' star agrees with each other's. Where the sums
//! of a worker's own pairs differ, the cells are looked for of those smallest vertices whose own sums differ ([`ShortSums`]).
//!
//! **Work and depth.** Two vector steps over all link facets, in which few cells are looked for in a link of O(1) facets.

use std::sync::atomic::{AtomicU8, Ordering};

use septet_geometry::point::Point;

use crate::config::map_in;
use crate::stars::check::Disagreement;
use crate::stars::links::is_facet_of;
use crate::stars::sums::{OpenShares, ShortSums, Sums};
use crate::worker::{Worker, finite_cell};

impl<P: Point> Worker<P> {
    /// Finds what home stars hold and other home stars lack: among the cells of those smallest vertices whose own
    /// sums differ.
    pub(crate) fn look_up(&self, short: Option<ShortSums>) -> Vec<Disagreement> {
        let open = short.unwrap_or_else(|| self.short_sums()).open();
        let seen: Vec<AtomicU8> = (0..self.stars.arena_len()).map(|_| AtomicU8::new(0)).collect();
        let groups = self.home_groups();
        let mut found = map_in(&self.pool, &groups, |(_, homes)| {
            homes.clone().flat_map(|home| self.unknown_to_smallest(home, &open, &seen)).collect::<Vec<_>>()
        });
        found.extend(map_in(&self.pool, &groups, |(_, homes)| {
            let differing = homes.clone().filter(|&home| open.of(home) != 0);
            differing.flat_map(|home| self.lacking(home, &open, &seen)).collect::<Vec<_>>()
        }));
        found.into_iter().flatten().collect()
    }

    /// The sums of each home vertex.
    fn short_sums(&self) -> ShortSums {
        let short = ShortSums::new(self.table.home, self.pool.is_none());
        map_in(&self.pool, &self.home_groups(), |(_, homes)| {
            for home in homes.clone() {
                self.sum_star(home, self.stars.link(home), true, &mut Sums::default(), Some(&short));
            }
        });
        short
    }

    /// Cells of a star that their smallest vertex, at home here, lacks; marks those it has.
    fn unknown_to_smallest(&self, home: u32, open: &OpenShares, seen: &[AtomicU8]) -> Vec<Disagreement> {
        let mut found = Vec::new();
        for (facet, link) in (self.stars.start(home)..).zip(self.stars.link(home)) {
            // Most stars agree: only where one beside it does not, the smallest vertex is asked for.
            if link.as_ref().iter().fold(0, |any, &v| any | open.of(v)) == 0 {
                continue;
            }
            let Some(cell) = finite_cell::<P>(home, link) else { continue };
            let smallest = self.smallest(&cell);
            if smallest == home || open.of(smallest) == 0 || !open.holds(smallest, self.cell_hash(&cell)) {
                continue;
            }
            match self.position_in(smallest, &cell) {
                Some(at) => {
                    seen[at as usize].fetch_add(1, Ordering::Relaxed);
                }
                None => found.push(Disagreement { home, facet, other: smallest }),
            }
        }
        found
    }

    /// The position of a cell in the star of a home vertex of it.
    pub(crate) fn position_in(&self, home: u32, cell: &P::Cell) -> Option<u32> {
        let at = self.stars.link(home).iter().position(is_facet_of::<P>(cell, home))?;
        Some(self.stars.start(home) + at as u32)
    }

    /// Cells of a star that home vertices other than their smallest, this one, lack.
    fn lacking(&self, home: u32, open: &OpenShares, seen: &[AtomicU8]) -> Vec<Disagreement> {
        let mut found = Vec::new();
        for (facet, link) in (self.stars.start(home)..).zip(self.stars.link(home)) {
            let Some(cell) = finite_cell::<P>(home, link) else { continue };
            let at_home = link.as_ref().iter().filter(|&&v| self.table.is_home(v)).count();
            let known = usize::from(seen[facet as usize].load(Ordering::Relaxed));
            if known == at_home || self.smallest(&cell) != home || !open.holds(home, self.cell_hash(&cell)) {
                continue;
            }
            for &other in link.as_ref() {
                if self.table.is_home(other) && self.position_in(other, &cell).is_none() {
                    found.push(Disagreement { home, facet, other });
                }
            }
        }
        found
    }
}
