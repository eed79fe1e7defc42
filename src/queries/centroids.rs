//! Centroids of Voronoi cells.
//!
//! **Statement.** The term of an edge, a triangle and a cell in [`crate::dual`] is the signed volume of a tetrahedron. Its corners are
//! `v`, the middle of the edge, the centre of the triangle and the centre of the cell. Its centroid is their mean. So the first
//! moment of a bounded Voronoi cell is the sum of its terms, each times this mean. In the plane, the terms are triangles of `v`,
//! the middle of the edge and the centre.
//!
//! *Proof.* Volume and first moment of a simplex are polynomials in its corners, up to the sign of the orientation. Where
//! the centres lie in their cells, the simplices divide the Voronoi cell. Both sides are polynomials in the position of the
//! centre, so the identity holds for all positions. QED.
//!
//! **Work.** O(1) for each cell, plus the cost of cut cells ([`crate::voronoi`]).

use crate::dimension::Dimension;
use crate::dual::part_in_triangle;
use crate::error::QueryError;
use crate::loops;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

impl<P: Dimension> Tessellation<P> {
    /// Returns the centroid of the Voronoi cell of each point. It is NaN for unbounded cells, duplicates and skipped points.
    ///
    /// # Errors
    /// Fails if the points do not span the space.
    pub fn voronoi_centroids(&self) -> Result<Vec<P>, QueryError> {
        self.has_cells()?;
        let (volumes, mut centroids) = self.moments(&self.centres());
        for (v, &is_open) in self.on_hull().iter().enumerate() {
            let is_cell = self.vertex_cell[v] != NONE && !is_open;
            centroids[v] =
                if is_cell { self.placed(v, centroids[v] / volumes[v]) } else { P::splat(f64::NAN) };
        }
        Ok(centroids)
    }

    /// Returns the centroid of the part of the Voronoi cell of each point in a box. It is NaN for duplicates and skipped points.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, or if a vertex lies outside of it.
    pub fn voronoi_centroids_in(&self, low: P, high: P) -> Result<Vec<P>, QueryError> {
        self.has_cells()?;
        let centres = self.centres();
        let frame = self.frame((low, high), &centres)?;
        let (volumes, moments) = self.moments(&centres);
        let blocks = loops::blocks(self.points.len(), |block| {
            let mut star = Seen::default();
            let one = |v: usize| {
                if self.vertex_cell[v] == NONE {
                    return P::splat(f64::NAN);
                }
                if !frame.is_cut[v] {
                    return self.placed(v, moments[v] / volumes[v]);
                }
                let measures = self.cut(v as u32, &frame, &mut star).1;
                let mut moment = P::default();
                (0..P::DIM).for_each(|axis| moment.set_coord(axis, measures.moment[axis]));
                self.placed(v, moment / measures.volume)
            };
            block.map(one).collect::<Vec<P>>()
        });
        Ok(loops::joined(self.points.len(), blocks))
    }

    /// Returns a place relative to a point in the units of the points.
    fn placed(&self, v: usize, relative: P) -> P {
        let mut place = self.points[v] + relative;
        (0..P::DIM).for_each(|axis| place.set_coord(axis, self.unscaled(place.coord(axis), 1)));
        place
    }

    /// Returns the volume of the Voronoi cell of each vertex, and its first moment relative to the vertex.
    fn moments(&self, centres: &[P]) -> (Vec<f64>, Vec<P>) {
        /// Cells whose parts are in memory at the same time.
        const MANY: usize = 1 << 18;
        let mut volumes = vec![0.0; self.points.len()];
        let mut moments = vec![P::default(); self.points.len()];
        for first in (0..self.cells.len()).step_by(MANY) {
            let parts = loops::map(MANY.min(self.cells.len() - first), |at| {
                moments_in(&self.corners((first + at) as u32), centres[first + at])
            });
            for (cell, parts) in self.cells[first..].iter().zip(parts) {
                for (&v, (volume, moment)) in cell.as_ref().iter().zip(parts) {
                    volumes[v as usize] += volume;
                    moments[v as usize] = moments[v as usize] + moment;
                }
            }
        }
        (volumes, moments)
    }
}

/// Returns the volume of the part of a cell that belongs to each corner, and its first moment relative to the corner. The
/// circumcentre is relative to the first corner.
fn moments_in<P: Dimension>(corners: &[P; 4], centre: P) -> [(f64, P); 4] {
    let mut parts = [(0.0, P::default()); 4];
    for &[v, i, j, k] in P::EDGES {
        let middle = |from: P| (corners[v] - from + (corners[i] - from)) / 2.0;
        let centre_from = |from: P| centre + (corners[0] - from);
        let mut add = |part: f64, mean: &dyn Fn(P) -> P| {
            for corner in [v, i] {
                let (volume, moment) = parts[corner];
                parts[corner] = (volume + part, moment + mean(corners[corner]) * part);
            }
        };
        if P::DIM == 2 {
            let part = P::hull_normal(&[corners[i] - corners[v]]).dot(centre_from(corners[v])) / 4.0;
            add(part, &|from| (middle(from) + centre_from(from)) / 3.0);
            continue;
        }
        for (apex, turn) in [(j, 1.0), (k, -1.0)] {
            let (part, height) = part_in_triangle(corners, centre, [v, i, apex]);
            add(turn * part, &|from| (middle(from) + centre_from(from) * 2.0 - height) / 4.0);
        }
    }
    parts
}
