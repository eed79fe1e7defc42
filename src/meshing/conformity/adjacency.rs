//! Checks of the cells at each facet, and of the listed faces among these facets.

use std::collections::BTreeMap;

use septet_geometry::point::Simplex;

use super::checker::Checker;
use super::defect::MeshDefect;
use crate::executor::Executor;
use crate::mesh::OUTSIDE;
use crate::space::Space;

/// The number of ranges of points.
const RANGES: usize = 64;

/// A facet of a cell.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side<F> {
    /// Its points, ascending.
    key: F,
    cell: u32,
    /// Whether the ascending order is positive when seen from inside the cell.
    inside: bool,
}

/// Sorts a simplex. Also returns whether the permutation was odd.
fn sorted<S: Simplex>(mut simplex: S) -> (S, bool) {
    let row = simplex.as_mut();
    let mut odd = false;
    for i in 1..row.len() {
        let mut j = i;
        while j > 0 && row[j - 1] > row[j] {
            row.swap(j - 1, j);
            odd = !odd;
            j -= 1;
        }
    }
    (simplex, odd)
}

impl<P: Space> Checker<'_, P> {
    /// Returns the facets of all cells, sorted. Each item of the map sorts the facets whose smallest points are in a
    /// range.
    fn sides(&self, executor: &impl Executor) -> Vec<Side<P::Facet>> {
        let width = self.mesh.points.len().div_ceil(RANGES).max(1) as u32;
        let numbered: Vec<u32> = (0..self.mesh.cells.len() as u32).collect();
        let chunks: Vec<&[u32]> = numbered.chunks(numbered.len().div_ceil(RANGES).max(1)).collect();
        let parts = executor.map(&chunks, |rows| {
            let mut parts: Vec<Vec<Side<P::Facet>>> = vec![Vec::new(); RANGES];
            for side in self.sides_of(rows) {
                parts[(side.key.as_ref()[0] / width) as usize].push(side);
            }
            parts
        });
        let ranges: Vec<usize> = (0..RANGES).collect();
        let sorted = executor.map(&ranges, |&range| {
            let mut sides: Vec<Side<P::Facet>> =
                parts.iter().flat_map(|part| part[range].iter().copied()).collect();
            sides.sort_unstable();
            sides
        });
        sorted.concat()
    }

    fn sides_of(&self, rows: &[u32]) -> Vec<Side<P::Facet>> {
        let mut sides = Vec::with_capacity(rows.len() * (P::DIM + 1));
        for &row in rows {
            let cell = &self.mesh.cells[row as usize];
            let vertices = cell.as_ref();
            for i in 0..=P::DIM {
                let mut facet = P::Facet::splat(0);
                let rest = vertices.iter().enumerate().filter(|&(k, _)| k != i);
                for (slot, (_, &v)) in facet.as_mut().iter_mut().zip(rest) {
                    *slot = v;
                }
                let (key, odd) = sorted(facet);
                sides.push(Side { key, cell: row, inside: odd ^ (i % 2 == 1) });
            }
        }
        sides
    }

    /// Checks parts 1 and 2 of the statement of [`super::check`].
    pub(super) fn faces(&mut self, executor: &impl Executor) {
        let mut faces: BTreeMap<P::Facet, u32> = BTreeMap::new();
        for (row, face) in self.mesh.faces.iter().enumerate() {
            if faces.insert(sorted(face.vertices).0, row as u32).is_some() {
                self.report(MeshDefect::Twice { what: "face", row: row as u32 });
            }
        }
        let sides = self.sides(executor);
        let mut seen = vec![false; self.mesh.faces.len()];
        for group in sides.chunk_by(|a, b| a.key == b.key) {
            let cells: Vec<u32> = group.iter().map(|s| s.cell).collect();
            let vertices = || group[0].key.as_ref().to_vec();
            match *group {
                [a, b] if a.inside == b.inside => {
                    self.report(MeshDefect::SameSide { cells: [a.cell, b.cell] });
                }
                [_] | [_, _] => {}
                _ => self.report(MeshDefect::Crowded { vertices: vertices(), count: group.len() }),
            }
            if let Some(&face) = faces.get(&group[0].key) {
                seen[face as usize] = true;
                self.check_cells(face, cells);
                continue;
            }
            match *cells.as_slice() {
                [cell] => self.report(MeshDefect::Open { cell, vertices: vertices() }),
                [a, b] if self.mesh.regions[a as usize] != self.mesh.regions[b as usize] => {
                    self.report(MeshDefect::Unmarked { cells: [a, b] });
                }
                _ => {}
            }
        }
        for (row, _) in seen.iter().enumerate().filter(|(_, seen)| !**seen) {
            self.check_cells(row as u32, Vec::new());
        }
    }

    /// Checks that a face belongs to exactly the cells that it lists.
    fn check_cells(&mut self, face: u32, found: Vec<u32>) {
        let mut listed: Vec<u32> = self.mesh.faces[face as usize].cells.to_vec();
        listed.retain(|&c| c != OUTSIDE);
        listed.sort_unstable();
        if listed != found || found.is_empty() {
            self.report(MeshDefect::FaceCells { face, listed, found });
        }
    }
}
