//! Points inside a constrained triangulation whose faces on facets are kept.
//!
//! **Statement.** A point is inserted by removing the cells whose spheres contain it, up to the faces of facets. Cells
//! with a face on the boundary of this region that does not see the point stay, until all faces see it (exact signs). A
//! point is refused if its own cell must stay, or if a vertex would be lost. So all cells stay positive, and no face of
//! a facet changes.
//!
//! **Source.** Bowyer (1981), Watson (1981); Weatherill and Hassan (1994) for the faces that must see the point.
//!
//! **Work and depth.** One walk and the cells in conflict, for each point, one after the other.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::point::Simplex;
use septet_geometry::predicates::Sign;

use super::cells::{Cells, NONE, face_of, key};
use super::layout::space;
use super::points::Points;
use crate::generate::{GeneratedMesh, Interior};
use crate::space::Space;

/// The cells of a mesh, and its faces on facets.
pub(super) struct Inner {
    points: Points,
    cells: Cells,
    kept: BTreeSet<[u32; 3]>,
    /// The component of each cell by its index.
    labels: BTreeMap<u32, u32>,
    last: u32,
}

impl Inner {
    pub(super) fn new<P: Space>(mesh: &GeneratedMesh<P>) -> Self {
        let at: Vec<_> = mesh.vertices.points.iter().map(|&p| space(p)).collect();
        let points = Points::new(at, vec![Vec::new(); mesh.vertices.len()]);
        let rows = mesh.delaunay.cells.iter().map(|c| [0, 1, 2, 3].map(|i| c.as_ref()[i]));
        let cells = Cells::new(points.len(), rows.clone());
        let of: BTreeMap<[u32; 4], u32> = rows.map(sorted).zip(mesh.labels.of.iter().copied()).collect();
        let labels = cells.all().map(|(cell, row)| (cell, of[&sorted(*row)])).collect();
        let kept = mesh.faces.iter().map(|(_, f, _)| key([0, 1, 2].map(|i| f.as_ref()[i]))).collect();
        Inner { points, cells, kept, labels, last: 0 }
    }

    /// Returns a cell that contains the point.
    fn locate(&self, q: u32) -> Option<u32> {
        let beyond = |cell: u32, slot: usize| {
            let [a, b, c] = face_of(self.cells.row(cell), slot);
            self.points.orientation([a, b, c, q]) == Sign::Negative
        };
        let mut cell = self.cells.at(self.last);
        for step in 0..self.labels.len() {
            let out = (0..4).map(|i| (i + step) % 4).find(|&slot| beyond(cell, slot));
            let Some(slot) = out else { return Some(cell) };
            cell = self.cells.across(cell)[slot];
            if cell == NONE {
                break;
            }
        }
        let holds = |cell: &u32| (0..4).all(|slot| !beyond(*cell, slot));
        self.cells.all().map(|(cell, _)| cell).find(holds)
    }

    /// Returns the faces around a region, positive towards its inside, with their cells.
    fn around(&self, region: &BTreeSet<u32>) -> Vec<(u32, [u32; 3])> {
        let mut faces = Vec::new();
        for &cell in region {
            for slot in 0..4 {
                let face = face_of(self.cells.row(cell), slot);
                if !region.contains(&self.cells.across(cell)[slot]) || self.kept.contains(&key(face)) {
                    faces.push((cell, face));
                }
            }
        }
        faces
    }

    /// Returns the cells around `first` for which a test holds, up to the faces that are kept.
    fn connected(&self, first: u32, mut test: impl FnMut(u32) -> bool) -> BTreeSet<u32> {
        let (mut region, mut stack, mut seen) =
            (BTreeSet::from([first]), vec![first], BTreeSet::from([first]));
        while let Some(cell) = stack.pop() {
            for slot in 0..4 {
                let other = self.cells.across(cell)[slot];
                if other == NONE || self.kept.contains(&key(face_of(self.cells.row(cell), slot))) {
                    continue;
                }
                if seen.insert(other) && test(other) {
                    region.insert(other);
                    stack.push(other);
                }
            }
        }
        region
    }

    fn insert_last(&mut self) -> Option<()> {
        let q = self.points.len() as u32 - 1;
        let first = self.locate(q)?;
        let mut region = self.connected(first, |cell| self.points.in_sphere(*self.cells.row(cell), q));
        let faces = loop {
            let faces = self.around(&region);
            let unseen =
                |&&(_, [a, b, c]): &&(u32, [u32; 3])| self.points.orientation([a, b, c, q]) != Sign::Positive;
            let stay: BTreeSet<u32> = faces.iter().filter(unseen).map(|f| f.0).collect();
            if stay.is_empty() {
                break faces;
            }
            if stay.contains(&first) {
                return None;
            }
            region = self.connected(first, |cell| region.contains(&cell) && !stay.contains(&cell));
        };
        let on: BTreeSet<u32> = faces.iter().flat_map(|f| f.1).collect();
        if region.iter().any(|&cell| self.cells.row(cell).iter().any(|v| !on.contains(v))) {
            return None;
        }
        let label = self.labels.get(&first).copied()?;
        let old: Vec<u32> = region.into_iter().collect();
        for cell in &old {
            self.labels.remove(cell);
        }
        let new: Vec<[u32; 4]> = faces.into_iter().map(|(_, [a, b, c])| [a, b, c, q]).collect();
        self.cells.grow(self.points.len());
        self.labels.extend(self.cells.replace(&old, &new).into_iter().map(|cell| (cell, label)));
        self.last = q;
        Some(())
    }

    /// Replaces the cells of the mesh, and the cells at its faces.
    pub(super) fn update<P: Space>(self, mesh: &mut GeneratedMesh<P>) {
        let mut at: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
        (mesh.labels.of, mesh.delaunay.cells) = (Vec::new(), Vec::new());
        for ((cell, row), number) in self.cells.all().zip(0..) {
            for slot in 0..4 {
                let face = key(face_of(row, slot));
                if self.kept.contains(&face) {
                    at.entry(face).or_default().push(number);
                }
            }
            mesh.labels.of.push(self.labels[&cell]);
            let mut out = P::Cell::splat(u32::MAX);
            out.as_mut().copy_from_slice(row);
            mesh.delaunay.cells.push(out);
        }
        mesh.delaunay.neighbours = vec![P::Cell::splat(u32::MAX); mesh.delaunay.cells.len()];
        for (_, face, cells) in &mut mesh.faces {
            let found = at.get(&key([0, 1, 2].map(|i| face.as_ref()[i]))).map_or(&[][..], Vec::as_slice);
            *cells = [0, 1].map(|i| found.get(i).copied().unwrap_or(u32::MAX));
        }
    }
}

impl<P: Space> Interior<P> for Inner {
    fn cells(&self) -> Vec<P::Cell> {
        let row = |(_, row): (u32, &[u32; 4])| {
            let mut out = P::Cell::splat(u32::MAX);
            out.as_mut().copy_from_slice(row);
            out
        };
        self.cells.all().map(row).collect()
    }

    fn insert(&mut self, points: &[P]) -> Vec<bool> {
        let one = |p: &P| {
            self.points.push(space(*p));
            let done = self.insert_last().is_some();
            if !done {
                self.points.pop();
            }
            done
        };
        points.iter().map(one).collect()
    }
}

fn sorted(mut row: [u32; 4]) -> [u32; 4] {
    row.sort_unstable();
    row
}
