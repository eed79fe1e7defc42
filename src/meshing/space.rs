//! Exact contacts between segments, triangles and points, in the plane and in space.
//!
//! **Statement.** A *wall* is a simplex of codimension one: an edge in the plane, a triangle in space. A set of points,
//! edges and walls is a simplicial complex iff no two of them meet outside a common face. For two triangles in space,
//! it suffices to test every edge of each triangle against the other.
//!
//! *Proof.* The intersection of two triangles is convex. If it extends beyond the common face, some extreme point of
//! it lies beyond this face. This point lies on an edge of one of the triangles. Beyond the common face of the edge
//! and the other triangle, the edge meets that triangle iff it meets it beyond the common face of the two triangles.
//! QED.
//!
//! **Work and depth.** O(1) per pair.
//!
//! All answers follow from signs of orientations ([`septet_geometry::predicates`]). In space, these include
//! orientations of projections along an axis, which drop a coordinate and do not round.

use glam::{DVec2, DVec3};
use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, orientation, raises_dimension};

/// The contact between a segment and a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// They do not meet.
    None,
    /// The segment passes through the interior of the wall.
    Proper,
    /// They may meet in another way: at an edge, in a plane, or at an end.
    Degenerate,
}

/// A dimension for domains: the plane or space.
pub trait Space: Point {
    /// A face of a wall: a vertex of an edge, or an edge of a triangle, as ascending vertex indices.
    type Hinge: Copy + Ord + std::fmt::Debug + AsRef<[u32]>;

    /// Returns the hinges of a wall, in the order of the opposite vertices.
    fn hinges(wall: &Self::Facet) -> Vec<Self::Hinge>;

    /// Returns the edges of a wall, ends ascending.
    fn edges(wall: &Self::Facet) -> Vec<[u32; 2]>;

    /// Returns `true` if three points are collinear. The test is exact.
    fn collinear(a: Self, b: Self, c: Self) -> bool {
        if Self::DIM == 2 { orientation(&[a, b, c]) == Sign::Zero } else { collinear(a, b, c) }
    }

    /// Returns `true` if two edges without a common end meet. Touching counts.
    fn edges_meet(e: [Self; 2], f: [Self; 2]) -> bool;

    /// Returns `true` if an edge and a wall without a common vertex meet. Touching counts.
    fn edge_meets_wall(e: [Self; 2], wall: &[Self]) -> bool;

    /// Returns `true` if an edge from the first vertex of a wall to `q` starts inside the wall. `q` is not a vertex
    /// of the wall.
    fn edge_enters_wall(wall: &[Self], q: Self) -> bool;

    /// Returns `true` if the point lies on the closed wall.
    fn on_wall(wall: &[Self], q: Self) -> bool;

    /// Returns the contact between the segment from `p` to `q` and the wall.
    fn crossing(wall: &[Self], p: Self, q: Self) -> Crossing;

    /// Returns the corners of a wall.
    fn corners(points: &[Self], wall: &Self::Facet) -> Vec<Self> {
        wall.as_ref().iter().map(|&v| points[v as usize]).collect()
    }
}

/// Returns `true` if three points are collinear.
fn collinear<P: Point>(a: P, b: P, c: P) -> bool {
    !raises_dimension(&[a], b) || !raises_dimension(&[a, b], c)
}

/// Returns `true` if `q`, which must lie on the line through `a` and `b`, lies between them. The ends count.
fn between<P: Point>(a: P, b: P, q: P) -> bool {
    (0..P::DIM).all(|i| {
        let (a, b, q) = (a.coord(i), b.coord(i), q.coord(i));
        a.min(b) <= q && q <= a.max(b)
    })
}

/// Returns `true` if `q` lies on the closed segment.
pub fn on_segment<P: Space>(a: P, b: P, q: P) -> bool {
    between(a, b, q) && P::collinear(a, b, q)
}

/// Returns `true` if two edges with a common end `a` overlap in more than this end.
pub fn edges_overlap<P: Space>(a: P, b: P, c: P) -> bool {
    P::collinear(a, b, c) && (between(a, b, c) || between(a, c, b))
}

/// Drops coordinate `axis` of a point in space. The other two keep a right-handed order.
pub fn project(p: DVec3, axis: usize) -> DVec2 {
    match axis {
        0 => DVec2::new(p.y, p.z),
        1 => DVec2::new(p.z, p.x),
        _ => DVec2::new(p.x, p.y),
    }
}

/// Returns an axis along which the triangle does not project to a line: the axis with the largest rounded area, if
/// exact signs confirm it. Returns `None` for triangles without area.
pub fn projection_axis(a: DVec3, b: DVec3, c: DVec3) -> Option<usize> {
    let n = (b - a).cross(c - a).abs();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&i, &j| n[j].total_cmp(&n[i]));
    axes.into_iter().find(|&axis| orientation(&[a, b, c].map(|p| project(p, axis))) != Sign::Zero)
}

fn sign2(a: DVec2, b: DVec2, c: DVec2) -> Sign {
    orientation(&[a, b, c])
}

/// Returns `true` if two closed segments in the plane meet.
fn segments_meet(e: [DVec2; 2], f: [DVec2; 2]) -> bool {
    let (s, t) = (sign2(e[0], e[1], f[0]), sign2(e[0], e[1], f[1]));
    let (u, v) = (sign2(f[0], f[1], e[0]), sign2(f[0], f[1], e[1]));
    if s != Sign::Zero && t != Sign::Zero && u != Sign::Zero && v != Sign::Zero {
        return s != t && u != v;
    }
    [(e[0], e[1], f[0], s), (e[0], e[1], f[1], t), (f[0], f[1], e[0], u), (f[0], f[1], e[1], v)]
        .into_iter()
        .any(|(a, b, q, sign)| sign == Sign::Zero && between(a, b, q))
}

/// Returns `true` if the closed triangle in the plane contains the point.
fn in_triangle(t: [DVec2; 3], q: DVec2) -> bool {
    let signs = [sign2(t[0], t[1], q), sign2(t[1], t[2], q), sign2(t[2], t[0], q)];
    !(signs.contains(&Sign::Positive) && signs.contains(&Sign::Negative))
}

impl Space for DVec2 {
    type Hinge = [u32; 1];

    fn hinges(wall: &[u32; 2]) -> Vec<[u32; 1]> {
        vec![[wall[1]], [wall[0]]]
    }

    fn edges(wall: &[u32; 2]) -> Vec<[u32; 2]> {
        vec![ascending(*wall)]
    }

    fn edges_meet(e: [Self; 2], f: [Self; 2]) -> bool {
        segments_meet(e, f)
    }

    fn edge_meets_wall(e: [Self; 2], wall: &[Self]) -> bool {
        segments_meet(e, [wall[0], wall[1]])
    }

    fn edge_enters_wall(wall: &[Self], q: Self) -> bool {
        edges_overlap(wall[0], wall[1], q)
    }

    fn on_wall(wall: &[Self], q: Self) -> bool {
        on_segment(wall[0], wall[1], q)
    }

    fn crossing(wall: &[Self], p: Self, q: Self) -> Crossing {
        let (s, t) = (sign2(wall[0], wall[1], p), sign2(wall[0], wall[1], q));
        let (u, v) = (sign2(p, q, wall[0]), sign2(p, q, wall[1]));
        let zero = Sign::Zero;
        if (s == t && s != zero) || (u == v && u != zero) {
            Crossing::None
        } else if [s, t, u, v].contains(&zero) {
            Crossing::Degenerate
        } else {
            Crossing::Proper
        }
    }
}

impl Space for DVec3 {
    type Hinge = [u32; 2];

    fn hinges(w: &[u32; 3]) -> Vec<[u32; 2]> {
        vec![ascending([w[1], w[2]]), ascending([w[2], w[0]]), ascending([w[0], w[1]])]
    }

    fn edges(wall: &[u32; 3]) -> Vec<[u32; 2]> {
        Self::hinges(wall)
    }

    fn edges_meet(e: [Self; 2], f: [Self; 2]) -> bool {
        if orientation(&[e[0], e[1], f[0], f[1]]) != Sign::Zero {
            return false;
        }
        let axis = projection_axis(e[0], e[1], f[0]).or_else(|| projection_axis(e[0], e[1], f[1]));
        match axis {
            Some(axis) => segments_meet(e.map(|p| project(p, axis)), f.map(|p| project(p, axis))),
            // All four points are collinear.
            None => [(e, f), (f, e)].into_iter().any(|(a, b)| b.iter().any(|&q| between(a[0], a[1], q))),
        }
    }

    fn edge_meets_wall(e: [Self; 2], w: &[Self]) -> bool {
        let at = |q| orientation(&[w[0], w[1], w[2], q]);
        let (s, t) = (at(e[0]), at(e[1]));
        if s == Sign::Zero && t == Sign::Zero {
            let Some(axis) = projection_axis(w[0], w[1], w[2]) else { return false };
            let e = e.map(|p| project(p, axis));
            let w = [0, 1, 2].map(|i| project(w[i], axis));
            return in_triangle(w, e[0])
                || in_triangle(w, e[1])
                || (0..3).any(|i| segments_meet(e, [w[i], w[(i + 1) % 3]]));
        }
        s != t && !mixed(around(w, e[0], e[1]))
    }

    fn edge_enters_wall(w: &[Self], q: Self) -> bool {
        if orientation(&[w[0], w[1], w[2], q]) != Sign::Zero {
            return false;
        }
        let Some(axis) = projection_axis(w[0], w[1], w[2]) else { return false };
        let [a, b, c] = [0, 1, 2].map(|i| project(w[i], axis));
        let q = project(q, axis);
        let turn = sign2(a, b, c);
        let against = |sign: Sign| sign != Sign::Zero && sign != turn;
        !against(sign2(a, b, q)) && !against(sign2(a, q, c))
    }

    fn on_wall(w: &[Self], q: Self) -> bool {
        if orientation(&[w[0], w[1], w[2], q]) != Sign::Zero {
            return false;
        }
        let Some(axis) = projection_axis(w[0], w[1], w[2]) else { return false };
        in_triangle([0, 1, 2].map(|i| project(w[i], axis)), project(q, axis))
    }

    fn crossing(w: &[Self], p: Self, q: Self) -> Crossing {
        let at = |q| orientation(&[w[0], w[1], w[2], q]);
        let (s, t) = (at(p), at(q));
        if s == t && s != Sign::Zero {
            return Crossing::None;
        }
        let around = around(w, p, q);
        if mixed(around) {
            Crossing::None
        } else if s == Sign::Zero || t == Sign::Zero || around.contains(&Sign::Zero) {
            Crossing::Degenerate
        } else {
            Crossing::Proper
        }
    }
}

/// Returns the sides on which the edges of the triangle pass the line through `p` and `q`.
fn around(w: &[DVec3], p: DVec3, q: DVec3) -> [Sign; 3] {
    [(0, 1), (1, 2), (2, 0)].map(|(i, j)| orientation(&[p, q, w[i], w[j]]))
}

fn mixed(signs: [Sign; 3]) -> bool {
    signs.contains(&Sign::Positive) && signs.contains(&Sign::Negative)
}

/// Sorts two indices.
pub fn ascending(pair: [u32; 2]) -> [u32; 2] {
    [pair[0].min(pair[1]), pair[0].max(pair[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [DVec3; 3] = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn edges_at_walls() {
        assert!(DVec3::edge_meets_wall([v(1.0, 1.0, -1.0), v(1.0, 1.0, 1.0)], &T));
        assert!(DVec3::edge_meets_wall([v(1.0, 1.0, 0.0), v(1.0, 1.0, 1.0)], &T));
        assert!(DVec3::edge_meets_wall([v(2.0, 2.0, -1.0), v(2.0, 2.0, 1.0)], &T));
        assert!(!DVec3::edge_meets_wall([v(2.0, 2.1, -1.0), v(2.0, 2.1, 1.0)], &T));
        assert!(DVec3::edge_meets_wall([v(-1.0, 1.0, 0.0), v(9.0, 1.0, 0.0)], &T));
        assert!(!DVec3::edge_meets_wall([v(-1.0, 5.0, 0.0), v(9.0, 1.0, 0.0)], &T));
        assert!(DVec3::edge_enters_wall(&T, v(1.0, 1.0, 0.0)));
        assert!(DVec3::edge_enters_wall(&T, v(9.0, 0.0, 0.0)));
        assert!(!DVec3::edge_enters_wall(&T, v(-1.0, 0.0, 0.0)));
        assert!(!DVec3::edge_enters_wall(&T, v(-1.0, 1.0, 0.0)));
        assert!(!DVec3::edge_enters_wall(&T, v(1.0, 1.0, 1e-300)));
    }

    #[test]
    fn crossings_separate_proper_from_degenerate() {
        let at = |x, y| DVec3::crossing(&T, v(x, y, -1.0), v(x, y, 1.0));
        assert_eq!(at(1.0, 1.0), Crossing::Proper);
        assert_eq!(at(2.0, 2.0), Crossing::Degenerate);
        assert_eq!(at(0.0, 0.0), Crossing::Degenerate);
        assert_eq!(at(-1.0, 0.0), Crossing::None);
        assert_eq!(DVec3::crossing(&T, v(1.0, 1.0, 0.0), v(1.0, 1.0, 2.0)), Crossing::Degenerate);
        assert_eq!(DVec3::crossing(&T, v(1.0, 1.0, 1.0), v(1.0, 1.0, 2.0)), Crossing::None);
        let e = [DVec2::ZERO, DVec2::new(2.0, 0.0)];
        assert_eq!(DVec2::crossing(&e, DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0)), Crossing::Proper);
        assert_eq!(DVec2::crossing(&e, DVec2::new(0.0, -1.0), DVec2::new(0.0, 1.0)), Crossing::Degenerate);
        assert_eq!(DVec2::crossing(&e, DVec2::new(3.0, -1.0), DVec2::new(3.0, 1.0)), Crossing::None);
    }

    #[test]
    fn edges_of_space_meet_in_planes_and_on_lines() {
        let e = [v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0)];
        assert!(DVec3::edges_meet(e, [v(0.0, 2.0, 1.0), v(2.0, 0.0, 1.0)]));
        assert!(!DVec3::edges_meet(e, [v(0.0, 2.0, 1.0), v(2.0, 0.0, 1.5)]));
        assert!(DVec3::edges_meet(e, [v(1.0, 1.0, 1.0), v(3.0, 3.0, 3.0)]));
        assert!(!DVec3::edges_meet(e, [v(2.5, 2.5, 2.5), v(3.0, 3.0, 3.0)]));
        assert!(on_segment(e[0], e[1], v(1.0, 1.0, 1.0)));
        assert!(!on_segment(e[0], e[1], v(1.0, 1.0, 1.0 + f64::EPSILON)));
        assert!(
            edges_overlap(e[0], e[1], v(1.0, 1.0, 1.0)) && !edges_overlap(e[0], e[1], v(-1.0, -1.0, -1.0))
        );
    }
}
