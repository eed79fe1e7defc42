//! Measurements on points, cells and surfaces that share no code with the algorithm. They use all pairs, Cramer's rule
//! and plain distances. Points in the plane have a third coordinate of 0.

use septet_workers::config::cores::{map, sort_rows};

/// A point.
pub(super) type X = [f64; 3];

/// Returns the squared distance, summed in the order of the coordinates.
pub(super) fn distance2(a: &X, b: &X) -> f64 {
    (0..3).map(|i| a[i] - b[i]).fold(0.0, |sum, d| sum + d * d)
}

pub(super) fn minus(a: &X, b: &X) -> X {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: &X, b: &X) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &X, b: &X) -> X {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the squared distance from each point to its `k`-th nearest other point, computed from all pairs.
pub(super) fn kth_nearest2(points: &[X], k: usize) -> Vec<f64> {
    let of = |p: &X| {
        let mut row: Vec<f64> = points.iter().map(|q| distance2(p, q)).collect();
        // The distance of the point to itself, 0, is the smallest.
        *row.select_nth_unstable_by(k, f64::total_cmp).1
    };
    map(points, of)
}

/// Returns, in order, the pairs `i < j` that satisfy a symmetric rule. The rule receives the squared distance of a pair
/// and its two squared radii.
pub(super) fn pairs(
    points: &[X],
    radii2: &[f64],
    joins: impl Fn(f64, f64, f64) -> bool + Sync,
) -> Vec<(u64, u64)> {
    let numbers: Vec<usize> = (0..points.len()).collect();
    let of = |&i: &usize| {
        let (p, r) = (&points[i], radii2[i]);
        let joined = |j: &usize| joins(distance2(p, &points[*j]), r, radii2[*j]);
        (i + 1..points.len()).filter(joined).map(|j| (i as u64, j as u64)).collect::<Vec<_>>()
    };
    map(&numbers, of).concat()
}

/// Returns the rule of Definition 2.2 for overlap graphs, for `alpha >= 1`.
pub(super) fn overlap(alpha: f64) -> impl Fn(f64, f64, f64) -> bool + Sync {
    move |d2, a2, b2| d2.sqrt() <= alpha * a2.min(b2).sqrt() + a2.max(b2).sqrt()
}

/// Returns the rule of Section 4.2 for density graphs.
pub(super) fn density(alpha: f64) -> impl Fn(f64, f64, f64) -> bool + Sync {
    move |d2, a2, b2| d2 <= alpha * alpha * a2.min(b2)
}

/// Returns the rule of Section 4.5 for nearest-neighbour graphs.
pub(super) fn nearest() -> impl Fn(f64, f64, f64) -> bool + Sync {
    |d2, a2, b2| d2 <= a2.max(b2)
}

/// Returns the degrees of `n` vertices.
pub(super) fn degrees(n: usize, edges: &[(u64, u64)]) -> Vec<u64> {
    let mut degrees = vec![0; n];
    for &(i, j) in edges {
        degrees[i as usize] += 1;
        degrees[j as usize] += 1;
    }
    degrees
}

/// The circumsphere of a cell, and its shortest and longest edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellShape {
    pub(super) centre: X,
    pub(super) radius: f64,
    pub(super) shortest: f64,
    pub(super) longest: f64,
}

impl CellShape {
    /// Returns the circumradius over the shortest edge.
    pub(super) fn ratio(&self) -> f64 {
        self.radius / self.shortest
    }
}

/// Returns the shape of a cell with 3 or 4 corners.
pub(super) fn shape(corners: &[X]) -> CellShape {
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0f64);
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[..i] {
            let d2 = distance2(a, b);
            (shortest, longest) = (shortest.min(d2), longest.max(d2));
        }
    }
    let to_centre = orthocentre(corners, &[0.0; 4]);
    let centre = [0, 1, 2].map(|i| corners[0][i] + to_centre[i]);
    let radius = dot(&to_centre, &to_centre).sqrt();
    CellShape { centre, radius, shortest: shortest.sqrt(), longest: longest.sqrt() }
}

/// Returns the vector from the first corner of a cell to the centre of the sphere that is orthogonal to all corners, whose
/// weights are squared lengths.
pub(super) fn orthocentre(corners: &[X], weights: &[f64]) -> X {
    let side = |i: usize| minus(&corners[i], &corners[0]);
    let (u, v) = (side(1), side(2));
    let square = |i: usize, x: &X| dot(x, x) - (weights[i] - weights[0]);
    let (squares, offset) = ([square(1, &u), square(2, &v)], |x: X, by: f64| x.map(|x| x / by));
    if corners.len() == 3 {
        let twice = 2.0 * (u[0] * v[1] - u[1] * v[0]);
        let x = squares[0] * v[1] - squares[1] * u[1];
        let y = squares[1] * u[0] - squares[0] * v[0];
        offset([x, y, 0.0], twice)
    } else {
        let w = side(3);
        let (vw, wu, uv, w2) = (cross(&v, &w), cross(&w, &u), cross(&u, &v), square(3, &w));
        let sum = |i: usize| squares[0] * vw[i] + squares[1] * wu[i] + w2 * uv[i];
        offset([sum(0), sum(1), sum(2)], 2.0 * dot(&u, &vw))
    }
}

/// Returns the shapes of cells that are given as rows of `d + 1` point indices.
pub(super) fn shapes(points: &[X], cells: &[u64], d: usize) -> Vec<CellShape> {
    let of = |row: &&[u64]| {
        let corners: Vec<X> = row.iter().map(|&v| points[v as usize]).collect();
        shape(&corners)
    };
    map(&cells.chunks_exact(d + 1).collect::<Vec<_>>(), of)
}

/// For each of `n` points, returns the cells that contain it as a vertex.
pub(super) fn stars(n: usize, cells: &[u64], d: usize) -> Vec<Vec<u32>> {
    let mut stars = vec![Vec::new(); n];
    for (number, row) in (0u32..).zip(cells.chunks_exact(d + 1)) {
        for &v in row {
            stars[v as usize].push(number);
        }
    }
    stars
}

/// Returns the edges of the cells in order, each once, with the smaller index first.
pub(super) fn edges(cells: &[u64], d: usize) -> Vec<(u64, u64)> {
    let mut edges: Vec<[u64; 2]> = cells
        .chunks_exact(d + 1)
        .flat_map(|row| {
            row.iter().enumerate().flat_map(|(i, &a)| row[..i].iter().map(move |&b| [a.min(b), a.max(b)]))
        })
        .collect();
    sort_rows(edges.as_flattened_mut(), 2);
    edges.dedup();
    edges.into_iter().map(<(u64, u64)>::from).collect()
}

/// Returns the smallest angle of a triangle, computed from its sides.
pub(super) fn smallest_angle(corners: &[X]) -> f64 {
    let angle = |at: usize| {
        let (a, b) =
            (minus(&corners[(at + 1) % 3], &corners[at]), minus(&corners[(at + 2) % 3], &corners[at]));
        let turned = cross(&a, &b);
        dot(&turned, &turned).sqrt().atan2(dot(&a, &b))
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

/// Returns the largest number of balls that contain one of the `places` in their interior. Balls are reduced slightly,
/// against rounding.
pub(super) fn ply(points: &[X], radii2: &[f64], places: &[X]) -> u64 {
    let holding = |place: &X| {
        points.iter().zip(radii2).filter(|&(p, &r2)| distance2(p, place) < r2 * (1.0 - 1e-12)).count() as u64
    };
    map(places, holding).into_iter().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_of_known_cells() {
        let right = shape(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        assert_eq!(
            (right.centre, right.radius, right.shortest, right.longest),
            ([1.5, 2.0, 0.0], 2.5, 3.0, 5.0)
        );
        let corner = shape(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]);
        assert_eq!((corner.centre, corner.radius), ([1.0; 3], 3f64.sqrt()));
        let angle = smallest_angle(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 3f64.sqrt(), 0.0]]);
        assert!((angle - std::f64::consts::PI / 6.0).abs() < 1e-15);
    }

    #[test]
    fn pairs_and_plies_on_a_line() {
        let points: Vec<X> = [0.0, 1.0, 3.0, 7.0].map(|x| [x, 0.0, 0.0]).to_vec();
        let radii2 = kth_nearest2(&points, 1);
        assert_eq!(radii2, [1.0, 1.0, 4.0, 16.0]);
        assert_eq!(pairs(&points, &radii2, density(2.0)), [(0, 1), (1, 2), (2, 3)]);
        assert_eq!(pairs(&points, &radii2, nearest()), [(0, 1), (1, 2), (2, 3)]);
        assert_eq!(pairs(&points, &radii2, overlap(1.0)).len(), 4);
        assert_eq!(ply(&points, &radii2, &[[3.5, 0.0, 0.0], [9.0, 0.0, 0.0]]), 2);
        assert_eq!(degrees(4, &[(0, 1), (1, 2)]), [1, 2, 1, 0]);
        assert_eq!(edges(&[0, 1, 2, 1, 2, 3], 2), [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]);
    }
}
