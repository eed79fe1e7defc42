//! Cells of the triangulation, as local indices of their vertices.

use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex, lex_cmp};

/// Returns the cell of a vertex and a facet of its link, with the vertex first.
#[inline]
pub(crate) fn star_cell<P: Point>(centre: u32, facet: &P::Facet) -> P::Cell {
    let mut cell = P::Cell::splat(centre);
    cell.as_mut()[1..].copy_from_slice(facet.as_ref());
    cell
}

/// Returns the cell of a vertex and a facet of its link, or `None` if the cell is infinite.
#[inline]
pub(crate) fn finite_cell<P: Point>(centre: u32, facet: &P::Facet) -> Option<P::Cell> {
    let is_finite = facet.as_ref().iter().all(|&v| v != INFINITE);
    is_finite.then(|| star_cell::<P>(centre, facet))
}

/// Returns the cell with its vertices in ascending order, so that equal cells compare equal.
pub(crate) fn in_order<P: Point>(cell: &P::Cell) -> P::Cell {
    let mut ordered = *cell;
    ordered.as_mut().sort_unstable();
    ordered
}

/// Returns the facet of a cell opposite the vertex in `slot`.
pub(crate) fn opposite<P: Point>(cell: &[u32], slot: usize) -> P::Facet {
    let mut facet = P::Facet::splat(0);
    let others = cell.iter().enumerate().filter(|&(at, _)| at != slot);
    facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
    facet
}

/// Returns the first coordinate of a vertex. It is infinite for [`INFINITE`].
#[inline]
pub(crate) fn first_coordinate<P: Point>(positions: &[P], vertex: u32) -> f64 {
    positions.get(vertex as usize).map_or(f64::INFINITY, |x| x.coord(0))
}

/// Returns the lexicographically smallest finite vertex of a cell, or [`INFINITE`] if there is none.
///
/// `first` maps a vertex to its first coordinate, or to a rounded one, and [`INFINITE`] to infinity. Rounding
/// preserves the order except for ties. If the compared values all differ, they decide; otherwise the positions
/// decide.
#[inline]
pub(crate) fn smallest_vertex<P: Point, C: PartialOrd + Copy>(
    positions: &[P],
    vertices: &[u32],
    first: impl Fn(u32) -> C,
) -> u32 {
    let (mut smallest, mut least, mut is_tied) = (vertices[0], first(vertices[0]), false);
    for &v in &vertices[1..] {
        let other = first(v);
        is_tied |= other == least;
        (smallest, least) = if other < least { (v, other) } else { (smallest, least) };
    }
    if is_tied { smallest_by_positions(positions, vertices) } else { smallest }
}

fn smallest_by_positions<P: Point>(positions: &[P], vertices: &[u32]) -> u32 {
    let at = |v: u32| &positions[v as usize];
    let smaller = |best: u32, v: u32| best == INFINITE || (v != INFINITE && lex_cmp(at(v), at(best)).is_lt());
    vertices.iter().fold(INFINITE, |best, &v| if smaller(best, v) { v } else { best })
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::Draw;

    use super::*;

    /// Coordinates that are equal, or equal after rounding, zeros of both signs, and values beyond single precision.
    fn positions<P: Point>() -> Vec<P> {
        let near = |k: u32| 1.0 + f64::from(k) * f64::EPSILON;
        let firsts =
            [near(0), near(1), near(2), 0.5, 0.0, -0.0, -3.0, 1e39, 1e300, -1e39, -1e300, 1e-50, 2e-50];
        let mut positions: Vec<P> = Vec::new();
        for (i, &first) in firsts.iter().enumerate() {
            for rest in [i as f64 % 3.0, 7.0] {
                positions.push(P::from_coords(&[first, rest, -rest][..P::DIM]));
            }
        }
        positions
    }

    fn rounded_coordinates_find_the_smallest<P: Point>() {
        let positions = positions::<P>();
        let all = positions.len() as u32;
        let mut draw = Draw::new(5);
        for _ in 0..20_000 {
            let mut cell = P::Cell::splat(INFINITE);
            for v in cell.as_mut() {
                let drawn = draw.below(all as usize + 2) as u32;
                *v = if drawn < all { drawn } else { INFINITE };
            }
            let expected = smallest_by_positions(&positions, cell.as_ref());
            let exact = |v: u32| first_coordinate(&positions, v);
            assert_eq!(smallest_vertex(&positions, cell.as_ref(), exact), expected, "{cell:?}");
            let rounded = |v: u32| exact(v) as f32;
            assert_eq!(smallest_vertex(&positions, cell.as_ref(), rounded), expected, "{cell:?}");
        }
    }

    #[test]
    fn rounded_coordinates_find_the_smallest_vertex() {
        rounded_coordinates_find_the_smallest::<DVec3>();
        rounded_coordinates_find_the_smallest::<DVec2>();
    }
}
