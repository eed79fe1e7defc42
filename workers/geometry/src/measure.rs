//! Measures of cells: circumradius, shortest edge and radius-edge ratio (paper, Section 1).
//!
//! The values are rounded. They serve reports and the choice of parameters, and never affect the triangulation.
//!
//! **Work and depth.** O(1) for each cell.

#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use crate::point::{Array, Point, dist2};
use crate::simd::widest;

/// Computes the squared circumradius of a cell of `DIM + 1` points, which is infinite for a flat cell.
pub fn circumradius2<P: Point>(cell: &[P]) -> f64 {
    let rel = vectors(cell);
    let (w, v) = P::sphere_plane(&rel.as_ref()[..P::DIM]);
    // The circumcentre relative to the first point is v / (2 w).
    let r = (v / (2.0 * w)).norm2();
    if r.is_nan() { f64::INFINITY } else { r }
}

/// Computes the squared distance from the first corner of a cell within which all conflicting points of weight at most
/// `heaviest` lie. It is infinite for a flat cell.
///
/// Let `c` be the centre and `R` its distance. By [`crate::site`], these points lie in the ball of squared radius
/// `R^2 + heaviest - w` around `c`, where `w` is the weight of the corner.
pub fn conflict_reach2<P: Point>(cell: &[P], heaviest: f64) -> f64 {
    let centre2 = circumradius2(cell);
    if !P::IS_WEIGHTED {
        return 4.0 * centre2;
    }
    let reach = centre2.sqrt() + (centre2 + heaviest - cell[0].weight()).max(0.0).sqrt();
    reach * reach
}

/// Returns the vectors from the first corner of a cell to the others.
#[inline(always)]
fn vectors<P: Point>(cell: &[P]) -> P::Axes<P> {
    P::Axes::from_fn(|i| if i < P::DIM { cell[i + 1] - cell[0] } else { P::default() })
}

/// Number of cells that are measured together. Few stars have more.
const TOGETHER: usize = 32;

/// Largest number of lanes in one register. The number of cells measured is rounded up to a multiple of this.
const LANES: usize = 4;

/// Measures the cells of stars, in reused storage.
#[derive(Debug, Default)]
pub struct Diameters {
    /// Coordinates of the corners of the cells, except the first corner: one array for each corner and axis.
    corners: [[[f64; TOGETHER]; 3]; 3],
    squares: [f64; TOGETHER],
}

impl Diameters {
    /// Returns `true` if no circumsphere has a diameter above the finite `length`. Each cell
    /// consists of `table[centre]` and a facet of `link`; all cells are finite. Uses one division for each cell.
    /// Returns `false` if a cell is flat.
    pub fn are_at_most<P: Point>(
        &mut self,
        table: &[P],
        centre: u32,
        link: &[P::Facet],
        length: f64,
    ) -> bool {
        let at = table[centre as usize];
        if P::DIM > 3 {
            return link.iter().all(|facet| {
                let corner =
                    |i: usize| i.checked_sub(1).map_or(at, |slot| table[facet.as_ref()[slot] as usize]);
                4.0 * circumradius2(P::Corners::from_fn(corner).as_ref()) <= length * length
            });
        }
        link.chunks(TOGETHER).all(|facets| {
            widest(
                #[inline(always)]
                || self.measure(table, at, facets),
            );
            self.squares.iter().zip(facets).all(|(&square, _)| square <= length * length)
        })
    }

    /// Computes the squared diameters for at most [`TOGETHER`] facets, and unused values up to a multiple of [`LANES`].
    #[inline(always)]
    fn measure<P: Point>(&mut self, table: &[P], at: P, facets: &[P::Facet]) {
        for (lane, facet) in facets.iter().enumerate().take(TOGETHER) {
            for (corner, &v) in self.corners.iter_mut().zip(facet.as_ref()) {
                let x = table[v as usize];
                for (axis, column) in corner.iter_mut().enumerate().take(P::DIM) {
                    column[lane] = x.coord(axis);
                }
            }
        }
        for lane in 0..facets.len().next_multiple_of(LANES).min(TOGETHER) {
            let rel: [P; 3] = std::array::from_fn(|corner| {
                let mut x = P::default();
                (0..P::DIM).for_each(|axis| x.set_coord(axis, self.corners[corner][axis][lane]));
                x - at
            });
            let (w, v) = P::sphere_plane(&rel[..P::DIM]);
            // The circumcentre relative to the first point is v / (2 w). If w is zero, the result is infinite or NaN.
            self.squares[lane] = (v * (1.0 / w)).norm2();
        }
    }
}

/// Computes the circumcentre of a cell of `DIM + 1` points, which is not finite for a flat cell.
pub fn circumcentre<P: Point>(cell: &[P]) -> P {
    let rel = vectors(cell);
    let (w, v) = P::sphere_plane(&rel.as_ref()[..P::DIM]);
    cell[0] + v / (2.0 * w)
}

/// Computes the centre and the squared radius of the smallest circumscribed ball of three points. They are not finite
/// if the points are collinear.
pub fn circumcircle<P: Point>([a, b, c]: [P; 3]) -> (P, f64) {
    let (u, v) = (b - a, c - a);
    let (uu, vv, uv) = (u.norm2(), v.norm2(), u.dot(v));
    let twice = 2.0 * (uu * vv - uv * uv);
    let offset = u * (vv * (uu - uv) / twice) + v * (uu * (vv - uv) / twice);
    (a + offset, offset.norm2())
}

/// Computes the squared length of a cell's shortest edge.
pub fn shortest_edge2<P: Point>(cell: &[P]) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..=P::DIM {
        for j in 0..i {
            least = least.min(dist2(cell[i], cell[j]));
        }
    }
    least
}

/// Computes the circumradius divided by the shortest edge: `1 / sqrt 3` for an equilateral triangle, `sqrt(3/8)` for
/// a regular tetrahedron, infinite for a flat cell.
pub fn radius_edge_ratio<P: Point>(cell: &[P]) -> f64 {
    (circumradius2(cell) / shortest_edge2(cell)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn regular_cells() {
        let t = [
            DVec3::new(1., 1., 1.),
            DVec3::new(1., -1., -1.),
            DVec3::new(-1., 1., -1.),
            DVec3::new(-1., -1., 1.),
        ];
        assert!((radius_edge_ratio(&t) - (3.0f64 / 8.0).sqrt()).abs() < 1e-12);
        assert!(circumcentre(&t).length() < 1e-12);
        let e = [DVec2::ZERO, DVec2::X, DVec2::new(0.5, 0.75f64.sqrt())];
        assert!((radius_edge_ratio(&e) - 1.0 / 3.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(radius_edge_ratio(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0]), f64::INFINITY);
        let mut diameters = Diameters::default();
        assert!(!diameters.are_at_most(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0], 0, &[[1, 2]], 1e9));
        for unit in [1.0, 1e45, 1e-45] {
            let (t, width) = (t.map(|x| x * unit), 12f64.sqrt() * unit);
            // These numbers of cells do or do not fill registers exactly.
            for cells in [1, 3, 4, 31, 32, 33, 70] {
                let mut link = vec![[1, 2, 3]; cells];
                assert!(diameters.are_at_most(&t, 0, &link, width * 1.0001));
                assert!(!diameters.are_at_most(&t, 0, &link, width * 0.9999));
                link[cells - 1] = [1, 2, 2];
                assert!(!diameters.are_at_most(&t, 0, &link, width * 1.0001));
            }
        }
        assert!(diameters.are_at_most(&t, 0, &[], 0.0));
    }
}
