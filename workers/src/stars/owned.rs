//! The stars of a rank's home points: their links in one arena, or the piece that holds them all. Sums of their cells follow
//! every change ([`crate::stars::check`]).

use std::collections::BTreeSet;

use septet_geometry::point::Point;

use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::stars::fingerprint_sums::Sums;
use crate::stars::links::is_facet_of;
use crate::state::table::Table;

/// Room for so many facets of each link, at first: uniform points have 27 in space, 6 in the plane.
pub(crate) fn usual_facets(dimension: usize) -> usize {
    if dimension == 2 { 7 } else { 30 }
}

/// The links of all home points.
#[derive(Debug)]
pub(crate) struct Stars<P: Point> {
    facets: Vec<P::Facet>,
    ranges: Vec<(u32, u32)>,
    /// Instead of both, the piece that they are in.
    piece: Option<SubdomainTriangulation<P>>,
    /// Sums of the cells.
    pub(super) sums: Sums,
    /// Hashes of the table's points, as far as they were needed, and their first coordinates.
    pub(super) hashes: Vec<u128>,
    pub(super) firsts: Vec<f64>,
    /// Home points whose stars the exchange changed.
    changed: BTreeSet<u32>,
}

impl<P: Point> Default for Stars<P> {
    fn default() -> Self {
        Stars {
            facets: Vec::new(),
            ranges: Vec::new(),
            piece: None,
            sums: Sums::default(),
            hashes: Vec::new(),
            firsts: Vec::new(),
            changed: BTreeSet::new(),
        }
    }
}

impl<P: Point> Stars<P> {
    /// The link of a home point: local numbers, infinite facets included.
    pub(crate) fn link(&self, owned: u32) -> &[P::Facet] {
        let (start, len) = self.ranges[owned as usize];
        &self.facets[start as usize..(start + len) as usize]
    }

    /// Position of the link's first facet in the arena.
    pub(crate) fn start(&self, owned: u32) -> u32 {
        self.ranges[owned as usize].0
    }

    /// The position of a cell in the star of a home vertex of it.
    pub(crate) fn position_in(&self, owned: u32, cell: &P::Cell) -> Option<u32> {
        let at = self.link(owned).iter().position(is_facet_of::<P>(cell, owned))?;
        Some(self.start(owned) + at as u32)
    }

    /// Length of the arena.
    pub(crate) fn arena_len(&self) -> usize {
        self.facets.len()
    }

    /// Whether the exchange changed the star of a home point.
    pub(crate) fn has_changed(&self, owned: u32) -> bool {
        self.changed.contains(&owned)
    }

    /// Makes room for so many links, and for what the exchange appends.
    pub(crate) fn reserve(&mut self, links: usize) {
        self.ranges.reserve_exact(links);
        let facets = links * usual_facets(P::DIM);
        self.facets.reserve_exact(facets + facets / 2);
    }

    /// Appends the links of the next home points, one behind the other, by their lengths.
    pub(crate) fn append(&mut self, links: &[P::Facet], lengths: &[u32]) {
        let mut start = self.facets.len() as u32;
        for &len in lengths {
            self.ranges.push((start, len));
            start += len;
        }
        self.facets.extend_from_slice(links);
    }

    /// Replaces the link of a home point; the sums stay as they are.
    pub(crate) fn replace(&mut self, owned: u32, link: &[P::Facet]) {
        self.ranges[owned as usize] = (self.facets.len() as u32, link.len() as u32);
        self.facets.extend_from_slice(link);
    }

    /// Replaces the link of a home point in the exchange.
    pub(crate) fn change(&mut self, table: &Table<P>, owned: u32, change: &Change<'_, P>) {
        self.recount(table, owned, change.gone, change.fresh);
        self.replace(owned, change.link);
        self.changed.insert(owned);
    }

    /// The piece's own triangulation, while no star has been taken out of it.
    pub(crate) fn piece(&self) -> Option<&SubdomainTriangulation<P>> {
        self.piece.as_ref()
    }

    /// The same, to change it.
    pub(crate) fn take_subdomain(&mut self) -> Option<SubdomainTriangulation<P>> {
        self.piece.take()
    }

    /// Keeps the piece's own triangulation, which holds the links of all home points.
    pub(crate) fn set_subdomain(&mut self, piece: Option<SubdomainTriangulation<P>>) {
        self.piece = piece;
    }

    /// Writes the links of a piece out beside it, for pictures only.
    pub(crate) fn show(&mut self) {
        if let Some(piece) = &self.piece {
            (self.facets, self.ranges) = piece.links();
        }
    }

    /// Writes the links of a piece out, once, before stars are compared or changed one by one.
    pub(crate) fn write_out(&mut self, table: &mut Table<P>) {
        if let Some(piece) = self.piece.take() {
            (self.facets, self.ranges) = piece.links();
            table.with_radii();
            self.extend_hashes(table);
        }
    }
}

/// A new link of a home point: the facets that came and those that went.
pub(crate) struct Change<'a, P: Point> {
    pub(crate) link: &'a [P::Facet],
    pub(crate) fresh: &'a [P::Facet],
    pub(crate) gone: &'a [P::Facet],
}

/// The stars and the table that their numbers refer to, to be read by several cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chart<'a, P: Point> {
    pub(crate) table: &'a Table<P>,
    pub(crate) stars: &'a Stars<P>,
}
