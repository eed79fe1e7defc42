//! The recovery of patches: cells that a missing triangle crosses are replaced.
//!
//! **Statement.** All parts are edges, so the boundary of a connected set of missing triangles of a patch consists of
//! edges of cells. A cell meets the interior of the set iff one of its edges crosses it, and then all its edges between
//! the two sides of the plane do. The search starts at an edge of the boundary, in the cell that the missing triangle
//! enters, and visits all cells around every crossing edge. The set divides the region of these cells in two. Each is
//! filled by [`super::wrap`]. Faces of earlier patches inside the region stay faces.
//!
//! *Why the cells exist.* All parts are edges of the perturbed Delaunay triangulation of all points. So the
//! constrained triangulation exists (Shewchuk 2008, with weights as perturbation), and its cells in the two regions are
//! those that gift wrapping finds.
//!
//! **Work and depth.** The cells that are crossed, and the work of gift wrapping.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::predicates::Sign;

use super::cells::{Cells, NONE, edges_of, face_of, key};
use super::points::Points;
use super::segments::Subsegments;
use super::wrap::wrap;
use crate::sides::Sets;
use crate::space::ascending;

/// The faces that patches consist of, with ascending vertices, and their patches.
pub(super) type Kept = BTreeMap<[u32; 3], u32>;

/// The state of the recovery of patches.
pub(super) struct Patches<'a> {
    pub(super) points: &'a Points,
    pub(super) cells: &'a mut Cells,
    pub(super) subs: &'a Subsegments,
    pub(super) kept: Kept,
    /// The number of triangles that were missing.
    pub(super) missing: u64,
}

impl Patches<'_> {
    /// Recovers the triangles of a patch, which are positive towards one side.
    ///
    /// # Errors
    /// Returns the triangles that cannot be recovered.
    pub(super) fn recover(&mut self, patch: u32, triangles: &[[u32; 3]]) -> Result<(), Vec<[u32; 3]>> {
        let mut missing = Vec::new();
        for &t in triangles {
            if self.cells.with(&t).is_some() {
                self.kept.insert(key(t), patch);
            } else {
                missing.push(t);
            }
        }
        self.missing += missing.len() as u64;
        for region in self.regions(&missing) {
            if self.carve(&region).is_none() {
                return Err(region);
            }
            self.kept.extend(region.iter().map(|&t| (key(t), patch)));
        }
        Ok(())
    }

    /// Returns the edges of cells between vertices of some chains, if cells have been exchanged.
    pub(super) fn edges_between(&self, chains: &[&[u32]], exchanged: bool) -> Vec<[u32; 2]> {
        if !exchanged || chains.len() + chains.iter().map(|c| c.len() - 2).sum::<usize>() <= 3 {
            return Vec::new();
        }
        let on: BTreeSet<u32> = chains.iter().flat_map(|c| c.iter().copied()).collect();
        let from = |&v: &u32| {
            let others = self.cells.neighbours(v).into_iter().filter(move |&w| v < w);
            others.filter(|w| on.contains(w)).map(move |w| [v, w]).collect::<Vec<_>>()
        };
        on.iter().flat_map(from).collect()
    }

    /// Divides triangles into sets that are connected across edges that are missing as well.
    fn regions(&self, missing: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
        let mut at: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut sets = Sets::new(missing.len());
        for (i, &t) in (0u32..).zip(missing) {
            for edge in directed(t) {
                if let Some(j) = at.insert(ascending(edge), i)
                    && self.cells.with(&edge).is_none()
                {
                    sets.join(i, j);
                }
            }
        }
        let mut regions: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for (i, &t) in (0u32..).zip(missing) {
            regions.entry(sets.find(i)).or_default().push(t);
        }
        regions.into_values().collect()
    }

    fn carve(&mut self, region: &[[u32; 3]]) -> Option<()> {
        let [a, b, c] = region[0];
        let inner: BTreeSet<u32> = region.as_flattened().iter().copied().collect();
        let mut sides: BTreeMap<u32, Sign> = BTreeMap::new();
        let points = self.points;
        let mut side = |v: u32| {
            let found = || if inner.contains(&v) { Sign::Zero } else { points.orientation([a, b, c, v]) };
            *sides.entry(v).or_insert_with(found)
        };
        let crossed = self.crossed(region, &mut side)?;
        let (mut faces, mut vertices) = ([Vec::new(), Vec::new()], [BTreeSet::new(), BTreeSet::new()]);
        for &t in region {
            let [a, b, c] = t;
            faces[0].push(t);
            faces[1].push([a, c, b]);
            for set in &mut vertices {
                set.extend(t);
            }
        }
        for &cell in &crossed {
            for &v in self.cells.row(cell) {
                match side(v) {
                    Sign::Positive => drop(vertices[0].insert(v)),
                    Sign::Negative => drop(vertices[1].insert(v)),
                    Sign::Zero => {}
                }
            }
            for slot in 0..4 {
                let face = face_of(self.cells.row(cell), slot);
                let other = self.cells.across(cell)[slot];
                if other != NONE && crossed.contains(&other) && !self.kept.contains_key(&key(face)) {
                    continue;
                }
                let signs = face.map(&mut side);
                match [Sign::Positive, Sign::Negative].map(|s| signs.contains(&s)) {
                    [true, false] => faces[0].push(face),
                    [false, true] => faces[1].push(face),
                    _ => return None,
                }
            }
        }
        let mut made = Vec::new();
        for (faces, vertices) in faces.iter().zip(vertices) {
            let all: Vec<u32> = vertices.iter().copied().collect();
            let filled = wrap(self.points, faces, &all)?;
            let used: BTreeSet<u32> = filled.as_flattened().iter().copied().collect();
            if used != vertices {
                return None;
            }
            made.extend(filled);
        }
        self.cells.replace(&crossed.into_iter().collect::<Vec<_>>(), &made);
        Some(())
    }

    /// Returns the cells that the triangles cross. Returns `None` if a part crosses them.
    fn crossed(&self, region: &[[u32; 3]], side: &mut impl FnMut(u32) -> Sign) -> Option<BTreeSet<u32>> {
        let mut found = BTreeSet::new();
        let mut stack = Vec::new();
        for &[a, b, c] in region {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                if let Some(cell) = self.cells.with(&[a, b]) {
                    let first = self.entered(cell, [a, b, c])?;
                    if found.insert(first) {
                        stack.push(first);
                    }
                }
            }
        }
        let mut edges = BTreeSet::new();
        while let Some(cell) = stack.pop() {
            for edge in edges_of(self.cells.row(cell)) {
                let signs = edge.map(&mut *side);
                let crosses = signs.contains(&Sign::Positive) && signs.contains(&Sign::Negative);
                if crosses && edges.insert(edge) {
                    if self.subs.has(edge) {
                        return None;
                    }
                    for next in self.cells.around(cell, edge) {
                        if found.insert(next) {
                            stack.push(next);
                        }
                    }
                }
            }
        }
        (!found.is_empty()).then_some(found)
    }

    /// Returns the cell at the edge from a to b that the triangle enters there.
    fn entered(&self, cell: u32, [a, b, c]: [u32; 3]) -> Option<u32> {
        let positive = |cell: [u32; 4]| self.points.orientation(cell) == Sign::Positive;
        self.cells.around(cell, [a, b]).into_iter().find(|&cell| {
            let mut others = self.cells.row(cell).iter().copied().filter(|v| ![a, b].contains(v));
            let (Some(x), Some(y)) = (others.next(), others.next()) else { return false };
            let [x, y] = if positive([a, b, x, y]) { [x, y] } else { [y, x] };
            c != x && c != y && positive([a, b, x, c]) && positive([a, b, c, y])
        })
    }
}

fn directed([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
