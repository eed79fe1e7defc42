//! First coordinates of points in single precision, which decide nearly always which vertex of a cell is smallest.

use septet_geometry::point::Point;

use crate::state::cells::smallest_vertex;

/// The first coordinates of points, relative to the first point and in single precision. Rounding preserves their
/// order, and most of them fit into the caches of a core.
pub(super) struct FirstCoordinates<'a, P> {
    positions: &'a [P],
    rounded: Vec<f32>,
}

impl<'a, P: Point> FirstCoordinates<'a, P> {
    /// Rounds the first coordinates.
    pub(super) fn new(positions: &'a [P]) -> Self {
        let origin = positions.first().map_or(0.0, |x| x.coord(0));
        let rounded = positions.iter().map(|x| (x.coord(0) - origin) as f32).collect();
        FirstCoordinates { positions, rounded }
    }

    /// Returns the lexicographically smallest vertex of a cell, given as local indices.
    #[inline]
    pub(super) fn smallest(&self, vertices: &[u32]) -> u32 {
        let first = |v: u32| self.rounded.get(v as usize).copied().unwrap_or(f32::INFINITY);
        smallest_vertex(self.positions, vertices, first)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::complex::INFINITE;
    use septet_geometry::point::Simplex;

    use super::*;
    use crate::state::cells::{first_coordinate, smallest_vertex};

    /// Checks that relative rounded coordinates give the same vertex as exact ones.
    fn rounded_coordinates_find_the_smallest<P: Point>() {
        let near = |k: u32| 1.0 + f64::from(k) * f64::EPSILON;
        let firsts =
            [near(0), near(1), near(2), 0.5, 0.0, -0.0, -3.0, 1e39, 1e300, -1e39, -1e300, 1e-50, 2e-50];
        let point = |i: usize, rest: f64| P::from_coords(&[firsts[i], rest, -rest][..P::DIM]);
        let positions: Vec<P> =
            (0..firsts.len()).flat_map(|i| [i as f64 % 3.0, 7.0].map(|rest| point(i, rest))).collect();
        let all = positions.len() as u32;
        let rounded = FirstCoordinates::new(&positions);
        let exact = |v: u32| first_coordinate(&positions, v);
        let mut draw = septet_geometry::hash::Draw::new(5);
        for _ in 0..20_000 {
            let mut cell = P::Cell::splat(INFINITE);
            for v in cell.as_mut() {
                let drawn = draw.below(all as usize + 2) as u32;
                *v = if drawn < all { drawn } else { INFINITE };
            }
            let expected = smallest_vertex(&positions, cell.as_ref(), exact);
            assert_eq!(rounded.smallest(cell.as_ref()), expected, "{cell:?}");
        }
    }

    #[test]
    fn rounded_coordinates_find_the_smallest_vertex() {
        rounded_coordinates_find_the_smallest::<DVec3>();
        rounded_coordinates_find_the_smallest::<DVec2>();
    }
}
