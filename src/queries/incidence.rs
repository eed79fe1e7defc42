//! Facets of the hull, vertices that edges join, volumes and shapes of cells.
//!
//! **Work.** O(m) for m cells of bounded stars.

use septet_geometry::point::Simplex;
use septet_meshing::quality::shapes::{Shape, Shapes};

use crate::dimension::Dimension;
use crate::double;
use crate::dual::THIN;
use crate::exact;
use crate::loops;
use crate::ragged::Ragged;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

impl<P: Dimension> Tessellation<P> {
    /// Returns the facets of the convex hull, counter-clockwise from outside, with the smallest vertex first, sorted. In the
    /// plane, the hull is to the left of each edge.
    pub fn hull(&self) -> Vec<P::Facet> {
        let blocks = loops::blocks(self.cells.len(), |block| {
            let mut facets = Vec::new();
            for cell in block {
                let next = self.neighbours[cell].as_ref().iter().enumerate();
                let open = next.filter(|(_, next)| **next == NONE);
                facets.extend(open.map(|(slot, _)| facet::<P>(&self.cells[cell], slot)));
            }
            facets
        });
        let mut facets = loops::joined(0, blocks);
        facets.sort_unstable();
        facets
    }

    /// Returns the vertices that an edge joins to each point, ascending. The list of a duplicate is empty.
    pub fn vertex_neighbours(&self) -> Ragged {
        let blocks = loops::blocks(self.points.len(), |block| {
            let (mut star, mut rows) = (Seen::default(), Ragged::default());
            for v in block {
                let mut around = Vec::new();
                if self.vertex_cell[v] != NONE {
                    self.star(v as u32, &mut star);
                    around.extend(self.vertices_of(star.list()).filter(|&w| w != v as u32));
                    around.sort_unstable();
                    around.dedup();
                }
                rows.push(&around);
            }
            rows
        });
        let mut all = Ragged::default();
        for rows in &blocks {
            all.append(rows);
        }
        all
    }

    /// Returns the edges: smaller vertex first, sorted.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let around = self.vertex_neighbours();
        let of = |v: u32| around.row(v as usize).iter().filter(move |w| **w > v).map(move |&w| [v, w]);
        (0..around.len() as u32).flat_map(of).collect()
    }

    /// Returns the area or volume of each cell. It is positive, with a relative error below `1e-15`.
    pub fn cell_volumes(&self) -> Vec<f64> {
        let factorial = if P::DIM == 2 { 2.0 } else { 6.0 };
        loops::map(self.cells.len(), |cell| {
            self.unscaled(self.determinant(cell as u32) / factorial, P::DIM as i32)
        })
    }

    /// Returns the orientation determinant of a cell, scaled.
    pub(crate) fn determinant(&self, cell: u32) -> f64 {
        let corners = self.corners(cell);
        let rounded = P::rounded_orientation(&corners[..=P::DIM]);
        if rounded.bound > rounded.det * THIN {
            exact::measure(&corners)
        } else {
            double::determinant(&corners)
        }
    }

    /// Measures the shape of a cell: radius-edge ratio, angles, volume.
    ///
    /// # Panics
    /// Panics if there is no such cell.
    pub fn shape(&self, cell: u32) -> Shape {
        let mut corners = self.corners(cell);
        for corner in &mut corners {
            *corner = septet_geometry::range::scale(*corner, -self.exponent);
        }
        Shape::of(&corners[..=P::DIM])
    }

    /// Measures the shapes of all cells.
    pub fn shapes(&self) -> Shapes {
        let blocks = loops::blocks(self.cells.len(), |block| {
            let mut shapes = Shapes::default();
            block.for_each(|cell| shapes.add(&self.shape(cell as u32)));
            shapes
        });
        let mut all = Shapes::default();
        for shapes in &blocks {
            all.merge(shapes);
        }
        all
    }
}

/// Returns the facet of a cell opposite a slot: counter-clockwise from outside of the cell, with the smallest vertex first. In the plane,
/// the cell is to its left.
pub(crate) fn facet<P: Dimension>(cell: &P::Cell, slot: usize) -> P::Facet {
    let mut facet = P::Facet::splat(0);
    let others = cell.as_ref().iter().enumerate().filter(|(i, _)| *i != slot);
    facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
    // The others of an even slot see the cell from the right side; those of an odd slot are an odd permutation of them.
    if slot % 2 == 1 {
        facet.as_mut().swap(P::DIM - 2, P::DIM - 1);
    }
    if P::DIM == 3 {
        let least = (0..P::DIM).min_by_key(|&i| facet.as_ref()[i]).unwrap_or(0);
        facet.as_mut().rotate_left(least);
    }
    facet
}
