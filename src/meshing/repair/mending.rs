//! An input during repair, and the queries and changes that the steps share.

use glam::DVec3;
use septet_geometry::point::lex_cmp;

use super::change::Change;
use crate::defect::At;
use crate::input::{Input, InputFacet};
use crate::space::{Space, ascending};

/// An input that is being changed.
#[doc(hidden)]
#[derive(Debug)]
pub struct Mending<P> {
    pub(super) input: Input<P>,
    pub(super) origin: Vec<u32>,
    /// The solids of each facet. Empty if there is only one.
    pub(super) solids: Vec<Vec<u32>>,
    /// Whether each solid is a region.
    pub(super) is_by_regions: bool,
    pub(super) changes: Vec<Change>,
    /// The number of facets in the file.
    pub(super) facets_of_file: u32,
}

impl<P: Space> Mending<P> {
    pub(super) fn new(input: &Input<P>) -> Self {
        let facets_of_file = input.facets.len() as u32;
        let mut solids = Vec::new();
        if input.solids.len() > 1 {
            for (s, of) in input.solids.iter().enumerate() {
                solids.resize((of.end as usize).max(solids.len()), vec![s as u32]);
            }
            solids.resize(input.facets.len(), vec![0]);
        }
        let origin = (0..facets_of_file).collect();
        let (is_by_regions, changes) = (false, Vec::new());
        Mending { input: input.clone(), origin, solids, is_by_regions, changes, facets_of_file }
    }

    /// Returns the solids of a facet, or an empty list if there is only one.
    pub(super) fn solids_of(&self, facet: usize) -> Vec<u32> {
        self.solids.get(facet).cloned().unwrap_or_default()
    }

    /// Returns the first of the points with the same coordinates, for each point.
    pub(super) fn same(&self) -> Vec<u32> {
        let points = &self.input.points;
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by(|&a, &b| lex_cmp(&points[a as usize], &points[b as usize]).then(a.cmp(&b)));
        let mut same: Vec<u32> = (0..points.len() as u32).collect();
        for group in order.chunk_by(|&a, &b| points[a as usize] == points[b as usize]) {
            for &v in group {
                same[v as usize] = group[0];
            }
        }
        same
    }

    /// Returns the edges of the polygons of a facet, between the first of equal points.
    pub(super) fn edges_of(&self, facet: u32, same: &[u32]) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for polygon in self.input.facets[facet as usize].polygons.iter().filter(|l| l.len() > 2) {
            let ids: Vec<u32> = polygon.iter().filter_map(|&v| same.get(v as usize).copied()).collect();
            let pairs = (0..ids.len()).map(|k| [ids[k], ids[(k + 1) % ids.len()]]);
            edges.extend(pairs.filter(|e| e[0] != e[1]).map(ascending));
        }
        edges
    }

    pub(super) fn place(p: P) -> At {
        At((0..P::DIM).map(|i| p.coord(i)).collect())
    }

    /// Keeps some of the facets.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        fn kept<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut at = 0;
            list.retain(|_| {
                at += 1;
                keep[at - 1]
            });
        }
        if keep.iter().any(|k| !k) {
            kept(&mut self.input.facets, keep);
            kept(&mut self.origin, keep);
            if !self.solids.is_empty() {
                kept(&mut self.solids, keep);
            }
        }
    }

    pub(super) fn push(&mut self, facet: InputFacet<P>, origin: u32, solids: Vec<u32>) {
        self.input.facets.push(facet);
        self.origin.push(origin);
        if !solids.is_empty() {
            self.solids.push(solids);
        }
    }
}

impl Mending<DVec3> {
    /// Returns the area of the facets, without regard to holes.
    pub(super) fn area(&self) -> f64 {
        let points = &self.input.points;
        let of = |l: &Vec<u32>| -> f64 {
            let at = |k: usize| points[l[k % l.len()] as usize] - points[l[0] as usize];
            (0..l.len()).map(|k| at(k).cross(at(k + 1))).sum::<DVec3>().length() / 2.0
        };
        self.input.facets.iter().flat_map(|f| &f.polygons).filter(|l| l.len() > 2).map(of).sum()
    }
}
