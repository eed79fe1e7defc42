//! The links of many vertices in one array of facets.

use septet_geometry::point::{Point, Simplex};

/// The links of the vertices 0, 1, ... A replaced link leaves its old facets behind.
#[derive(Debug)]
pub(crate) struct LinkArena<P: Point> {
    facets: Vec<P::Facet>,
    ranges: Vec<LinkRange>,
}

/// The position of a link in the array.
#[derive(Clone, Copy, Debug)]
struct LinkRange {
    start: u32,
    len: u32,
}

impl<P: Point> Default for LinkArena<P> {
    fn default() -> Self {
        LinkArena { facets: Vec::new(), ranges: Vec::new() }
    }
}

impl<P: Point> LinkArena<P> {
    /// Creates empty links with room for the given numbers of facets, to be filled by [`LinkArena::push`].
    pub(crate) fn with_capacities(capacities: &[u32]) -> Self {
        let mut ranges = Vec::with_capacity(capacities.len());
        let mut start = 0;
        for &capacity in capacities {
            ranges.push(LinkRange { start, len: 0 });
            start += capacity;
        }
        LinkArena { facets: vec![P::Facet::splat(0); start as usize], ranges }
    }

    /// Adds a facet to a link that has room.
    pub(crate) fn push(&mut self, vertex: u32, facet: P::Facet) {
        let range = &mut self.ranges[vertex as usize];
        self.facets[(range.start + range.len) as usize] = facet;
        range.len += 1;
    }

    /// Reserves memory for links and for facets.
    pub(crate) fn reserve(&mut self, links: usize, facets: usize) {
        self.ranges.reserve_exact(links);
        self.facets.reserve_exact(facets);
    }

    /// Appends the links of the next vertices, which are concatenated in `facets`.
    pub(crate) fn append(&mut self, facets: &[P::Facet], lengths: &[u32]) {
        let mut start = self.facets.len() as u32;
        for &len in lengths {
            self.ranges.push(LinkRange { start, len });
            start += len;
        }
        self.facets.extend_from_slice(facets);
    }

    /// Replaces a link.
    pub(crate) fn replace(&mut self, vertex: u32, link: &[P::Facet]) {
        self.ranges[vertex as usize] = LinkRange { start: self.facets.len() as u32, len: link.len() as u32 };
        self.facets.extend_from_slice(link);
    }

    /// Returns the link of a vertex, infinite facets included.
    #[inline]
    pub(crate) fn link(&self, vertex: u32) -> &[P::Facet] {
        let LinkRange { start, len } = self.ranges[vertex as usize];
        &self.facets[start as usize..(start + len) as usize]
    }

    /// Returns the position of a link's first facet in the array.
    #[inline]
    pub(crate) fn start(&self, vertex: u32) -> u32 {
        self.ranges[vertex as usize].start
    }

    /// Returns the bytes that hold the links.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(&self.facets[..]) + size_of_val(&self.ranges[..])) as u64
    }

    /// Returns the length of the array.
    pub(crate) fn len(&self) -> usize {
        self.facets.len()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn links_are_filled_appended_and_replaced() {
        let mut links = LinkArena::<DVec2>::with_capacities(&[1, 2]);
        for (vertex, facet) in [(1, [0, 3]), (0, [1, 2]), (1, [3, 4])] {
            links.push(vertex, facet);
        }
        links.append(&[[5, 6], [6, 7], [8, 9]], &[2, 0, 1]);
        links.replace(0, &[[2, 3], [3, 1]]);
        let expected: [&[[u32; 2]]; 5] =
            [&[[2, 3], [3, 1]], &[[0, 3], [3, 4]], &[[5, 6], [6, 7]], &[], &[[8, 9]]];
        for (vertex, link) in (0u32..).zip(expected) {
            assert_eq!(links.link(vertex), link);
        }
        assert_eq!([0, 1, 2, 4].map(|vertex| links.start(vertex)), [6, 1, 3, 5]);
        assert_eq!(links.len(), 8);
    }
}
