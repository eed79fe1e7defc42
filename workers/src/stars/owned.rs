//! The stars of a rank's owned points: their links or covers, or the subdomain triangulation that contains them. Sums of the cells
//! follow every change ([`crate::stars::check`]).

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::point::Point;
use septet_protocol::message::Merged;

use crate::config::{Growth, Stop};
use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::stars::fingerprint_sums::Sums;
use crate::stars::vertex_hashes::VertexHashes;
use crate::state::link_arena::LinkArena;
use crate::state::table::Table;

/// Returns the number of facets per link for which memory is reserved. A link of a uniform point set has 27 facets on
/// average in space and 6 in the plane.
pub(crate) fn usual_facets(dimension: usize) -> usize {
    if dimension == 2 { 7 } else { 30 }
}

/// The stars of all owned points.
#[derive(Debug)]
pub(crate) struct Stars<P: Point> {
    /// The links; empty while the triangulation contains them.
    links: LinkArena<P>,
    /// The covers of the hidden points ([`StarBuilder::cover`](septet_geometry::hull::StarBuilder::cover)). Their links are empty.
    covers: BTreeMap<u32, P::Cell>,
    triangulation: Option<SubdomainTriangulation<P>>,
    sums: Sums,
    hashes: VertexHashes,
    /// The owned points whose stars changed by splaying.
    changed: BTreeSet<u32>,
    /// The bytes of the links.
    growth: Growth,
}

impl<P: Point> Default for Stars<P> {
    fn default() -> Self {
        Stars {
            links: LinkArena::default(),
            covers: BTreeMap::new(),
            triangulation: None,
            sums: Sums::default(),
            hashes: VertexHashes::default(),
            changed: BTreeSet::new(),
            growth: Growth::default(),
        }
    }
}

impl<P: Point> Stars<P> {
    /// Creates the stars of a subdomain triangulation.
    pub(crate) fn from_subdomain(triangulation: Option<SubdomainTriangulation<P>>) -> Self {
        Stars { triangulation, ..Stars::default() }
    }

    /// Returns the link of an owned point as local indices, infinite facets included.
    #[inline]
    pub(crate) fn link(&self, vertex: u32) -> &[P::Facet] {
        self.links.link(vertex)
    }

    /// Returns the cover of an owned point that its candidates hide, as local indices.
    #[inline]
    pub(crate) fn cover(&self, vertex: u32) -> Option<P::Cell> {
        if P::IS_WEIGHTED { self.covers.get(&vertex).copied() } else { None }
    }

    /// Returns the hidden owned points, in order.
    pub(crate) fn hidden(&self) -> Vec<u32> {
        match &self.triangulation {
            Some(triangulation) => triangulation.hidden().collect(),
            None => self.covers.keys().copied().collect(),
        }
    }

    /// Returns the position of the link's first facet among the facets of all links.
    pub(crate) fn start(&self, vertex: u32) -> u32 {
        self.links.start(vertex)
    }

    /// Returns the number of facets of all links, including replaced ones.
    pub(crate) fn positions(&self) -> usize {
        self.links.len()
    }

    /// Returns `true` if splaying changed the star of an owned point.
    pub(crate) fn has_changed(&self, vertex: u32) -> bool {
        self.changed.contains(&vertex)
    }

    /// Returns the owned points whose stars splaying has changed.
    pub(crate) fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        self.changed.iter().copied()
    }

    /// Returns the sums of the cells.
    pub(crate) fn sums(&self) -> &Sums {
        &self.sums
    }

    /// Returns the hashes of the vertices.
    #[inline]
    pub(crate) fn hashes(&self) -> &VertexHashes {
        &self.hashes
    }

    /// Reserves memory for links and for the facets that splaying appends.
    pub(super) fn reserve(&mut self, links: usize) {
        let facets = links * usual_facets(P::DIM);
        self.links.reserve(links, facets + facets / 2);
    }

    /// Appends the links of the next owned points, which are concatenated in `facets`.
    pub(crate) fn append(&mut self, facets: &[P::Facet], lengths: &[u32]) {
        self.links.append(facets, lengths);
    }

    /// Adds the covers of hidden points, whose links are empty.
    pub(crate) fn add_covers(&mut self, covers: impl IntoIterator<Item = (u32, P::Cell)>) {
        self.covers.extend(covers);
    }

    /// Counts the bytes of the links. Returns `true` if the run goes on.
    pub(super) fn admits_more(&mut self, stop: &Stop) -> bool {
        stop.admits(&mut self.growth, self.links.bytes())
    }

    /// Hashes the points that were added to the table since the last call.
    pub(crate) fn extend_hashes(&mut self, table: &Table<P>) {
        self.hashes.extend(table);
    }

    /// Sets the sums of the cells.
    pub(super) fn set_sums(&mut self, sums: Sums) {
        self.sums = sums;
    }

    /// Removes sums that are zero.
    pub(super) fn drop_zero_sums(&mut self) {
        self.sums.drop_zeros();
    }

    /// Sums the cells of the subdomain triangulation. Returns `false` if the links have replaced it.
    pub(super) fn sum_subdomain(&mut self, table: &Table<P>) -> bool {
        let Some(triangulation) = &mut self.triangulation else { return false };
        self.sums = Sums::of_subdomain(triangulation, table);
        true
    }

    /// Replaces the link of an owned point. The sums follow the change; the set of changed stars does not.
    pub(super) fn replace(&mut self, table: &Table<P>, vertex: u32, change: &Change<'_, P>) {
        let (mut gained, mut lost) = (Sums::default(), Sums::default());
        let view = StarsView::new(table, self);
        view.add_facets(vertex, change.gained, &mut gained, None);
        view.add_facets(vertex, change.lost, &mut lost, None);
        self.sums.add(gained);
        self.sums.subtract(lost);
        self.links.replace(vertex, change.link);
        self.covers.extend(change.cover.map(|cover| (vertex, cover)));
    }

    /// Replaces the link of an owned point that splaying has changed.
    pub(crate) fn splay(&mut self, table: &Table<P>, vertex: u32, change: &Change<'_, P>) {
        self.replace(table, vertex, change);
        self.changed.insert(vertex);
    }

    /// Returns the subdomain triangulation, unless its links were extracted.
    pub(crate) fn triangulation(&self) -> Option<&SubdomainTriangulation<P>> {
        self.triangulation.as_ref()
    }

    /// Removes and returns the subdomain triangulation.
    pub(crate) fn take_triangulation(&mut self) -> Option<SubdomainTriangulation<P>> {
        self.triangulation.take()
    }

    /// Extracts the links for pictures, and keeps the subdomain triangulation.
    pub(crate) fn copy_links(&mut self) {
        if let Some(triangulation) = &self.triangulation {
            self.links = triangulation.links();
        }
    }

    /// Replaces the subdomain triangulation by its links, before stars are compared or changed one by one.
    pub(crate) fn extract_links(&mut self, table: &mut Table<P>) {
        if let Some(triangulation) = self.triangulation.take() {
            self.links = triangulation.links();
            self.covers = triangulation.covers().collect();
            table.with_radii();
            self.extend_hashes(table);
        }
    }
}

/// The change of one link.
pub(crate) struct Change<'a, P: Point> {
    /// The new link.
    pub(crate) link: &'a [P::Facet],
    /// The facets that only the new link has.
    pub(crate) gained: &'a [P::Facet],
    /// The facets that only the old link had.
    pub(crate) lost: &'a [P::Facet],
    /// The cover of the point, if it became hidden.
    pub(crate) cover: Option<P::Cell>,
}

/// The stars and the table of their vertices, for threads that read both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StarsView<'a, P: Point> {
    table: &'a Table<P>,
    stars: &'a Stars<P>,
}

impl<'a, P: Point> StarsView<'a, P> {
    /// Views stars with the table of their vertices.
    pub(crate) fn new(table: &'a Table<P>, stars: &'a Stars<P>) -> Self {
        StarsView { table, stars }
    }

    /// Returns the table.
    #[inline]
    pub(crate) fn table(&self) -> &'a Table<P> {
        self.table
    }

    /// Returns the stars.
    #[inline]
    pub(crate) fn stars(&self) -> &'a Stars<P> {
        self.stars
    }

    /// Returns the merged result of the subdomain triangulation, if the stars come from one.
    pub(crate) fn merged(&self) -> Option<Merged> {
        self.stars.triangulation().map(SubdomainTriangulation::merged)
    }

    /// Returns the link of an owned point.
    #[inline]
    pub(crate) fn link(&self, vertex: u32) -> &'a [P::Facet] {
        self.stars.link(vertex)
    }

    /// Returns the lexicographically smallest vertex of a finite cell.
    #[inline]
    pub(crate) fn smallest(&self, cell: &P::Cell) -> u32 {
        self.stars.hashes.smallest(self.table, cell)
    }
}
