//! Locates disagreements between the stars of one rank.
//!
//! **Statement.** By [`crate::stars::check`], all stars agree on a cell if and only if the star of its smallest vertex agrees
//! with the star of each other vertex. If the sums within a rank differ, this module finds the cells on which owned stars
//! disagree. It examines only cells whose smallest vertex has a sum that is not zero ([`VertexSums`]).
//!
//! **Work and depth.** Two vector steps over all link facets. Few cells are looked up, each in O(log l) time in a link of `l`
//! facets ([`crate::stars::look_up`]).

use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};

use septet_geometry::point::Point;

use crate::config::{Pool, map_in};
use crate::stars::check::Disagreement;
use crate::stars::fingerprint_sums::{DifferingBuckets, Sums, VertexSums};
use crate::stars::look_up::LookUp;
use crate::stars::owned::StarsView;
use crate::state::cells::finite_cell;
use crate::state::tree::{Leaf, owned_groups};

impl<P: Point> StarsView<'_, P> {
    /// Returns the cells of owned stars that other owned stars lack.
    pub(super) fn locate(
        &self,
        pool: &Pool,
        leaves: &[Leaf<P>],
        vertex_sums: Option<VertexSums>,
    ) -> Vec<Disagreement> {
        let groups = owned_groups(leaves);
        let differing = vertex_sums.unwrap_or_else(|| self.vertex_sums(pool, &groups)).into_differing();
        let matches = Matches {
            view: *self,
            look_up: LookUp::new(self.stars(), self.table().owned()),
            differing,
            counts: (0..self.stars().positions()).map(|_| AtomicU8::new(0)).collect(),
        };
        let mut found = map_in(pool, &groups, |(_, vertices)| {
            vertices.clone().flat_map(|v| matches.missing_at_smallest(v)).collect::<Vec<_>>()
        });
        found.extend(map_in(pool, &groups, |(_, vertices)| {
            let smallest = vertices.clone().filter(|&v| matches.differing.of(v) != 0);
            smallest.flat_map(|v| matches.missing_at_others(v)).collect::<Vec<_>>()
        }));
        found.into_iter().flatten().collect()
    }

    /// Computes the sums of each owned vertex.
    fn vertex_sums(&self, pool: &Pool, groups: &[(usize, Range<u32>)]) -> VertexSums {
        let vertex_sums = VertexSums::new(self.table().owned_len(), pool.is_none());
        map_in(pool, groups, |(_, vertices)| {
            for v in vertices.clone() {
                self.add_facets(v, self.link(v), &mut Sums::default(), Some(&vertex_sums));
            }
        });
        vertex_sums
    }
}

/// Cells in the stars of smallest vertices, matched with the stars of their other vertices.
struct Matches<'a, P: Point> {
    view: StarsView<'a, P>,
    look_up: LookUp<'a, P>,
    differing: DifferingBuckets,
    /// For each facet in the link of the smallest vertex of its cell, the number of other owned stars that have the cell.
    counts: Vec<AtomicU8>,
}

impl<P: Point> Matches<'_, P> {
    /// Returns `true` if the stars may disagree on the cell.
    fn may_differ(&self, smallest: u32, cell: &P::Cell) -> bool {
        let hash = self.view.stars().hashes().cell_hash(cell.as_ref());
        self.differing.contain(smallest, hash)
    }

    /// Returns the cells in the star of `vertex` that are missing from the star of their smallest vertex, if that is
    /// another owned vertex. Counts the cells that are not missing.
    fn missing_at_smallest(&self, vertex: u32) -> Vec<Disagreement> {
        let stars = self.view.stars();
        let mut found = Vec::new();
        for (facet, link) in (stars.start(vertex)..).zip(stars.link(vertex)) {
            // Most sums are zero. The smallest vertex is computed only if some vertex has a sum that is not zero.
            if link.as_ref().iter().fold(0, |any, &v| any | self.differing.of(v)) == 0 {
                continue;
            }
            let Some(cell) = finite_cell::<P>(vertex, link) else { continue };
            let smallest = self.view.smallest(&cell);
            if smallest == vertex || self.differing.of(smallest) == 0 || !self.may_differ(smallest, &cell) {
                continue;
            }
            match self.look_up.position_in(smallest, &cell) {
                Some(at) => {
                    self.counts[at as usize].fetch_add(1, Ordering::Relaxed);
                }
                None => found.push(Disagreement { holder: vertex, facet, other: smallest }),
            }
        }
        found
    }

    /// Returns the cells whose smallest vertex is `vertex`, with the other owned vertices whose stars lack them.
    fn missing_at_others(&self, vertex: u32) -> Vec<Disagreement> {
        let (stars, table) = (self.view.stars(), self.view.table());
        let mut found = Vec::new();
        for (facet, link) in (stars.start(vertex)..).zip(stars.link(vertex)) {
            let Some(cell) = finite_cell::<P>(vertex, link) else { continue };
            let owned = link.as_ref().iter().filter(|&&v| table.is_owned(v)).count();
            let matched = usize::from(self.counts[facet as usize].load(Ordering::Relaxed));
            if matched == owned || self.view.smallest(&cell) != vertex || !self.may_differ(vertex, &cell) {
                continue;
            }
            for &other in link.as_ref() {
                if table.is_owned(other) && self.look_up.position_in(other, &cell).is_none() {
                    found.push(Disagreement { holder: vertex, facet, other });
                }
            }
        }
        found
    }
}
