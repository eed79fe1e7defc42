//! A reference test of whether two triangles meet beyond their common face, by clipping one against the other in
//! integers.
//!
//! Unlike [`crate::space`], it uses no orientation predicates, no projections and no case analysis.

use glam::DVec3;

/// A point in homogeneous coordinates, the last one positive.
type Rational = [i128; 4];

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

fn reduced(p: Rational) -> Rational {
    let d = p.iter().fold(0, |d, &c| gcd(d, c));
    p.map(|c| c / d)
}

fn whole(p: DVec3) -> [i128; 3] {
    [p.x as i128, p.y as i128, p.z as i128]
}

fn minus(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the plane through `at` with the given normal, as a form that is 0 on it.
fn plane(normal: [i128; 3], at: [i128; 3]) -> [i128; 4] {
    let [a, b, c] = normal;
    [a, b, c, -(a * at[0] + b * at[1] + c * at[2])]
}

fn value(form: [i128; 4], p: Rational) -> i128 {
    (0..4).map(|i| form[i] * p[i]).sum()
}

/// Returns the part of a convex polygon on which the form is not negative.
fn clip(polygon: &[Rational], form: [i128; 4]) -> Vec<Rational> {
    let mut left = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (f, g) = (value(form, p), value(form, q));
        if f >= 0 {
            left.push(p);
        }
        if (f < 0 && g > 0) || (f > 0 && g < 0) {
            let mixed: Rational = std::array::from_fn(|k| f.abs() * q[k] + g.abs() * p[k]);
            left.push(reduced(mixed));
        }
    }
    left
}

/// Returns the extreme points of the intersection of two triangles, possibly with others of its points.
fn common(s: [DVec3; 3], t: [DVec3; 3]) -> Vec<Rational> {
    let t = t.map(whole);
    let normal = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    let level = plane(normal, t[0]);
    let mut forms = vec![level, level.map(|c| -c)];
    for i in 0..3 {
        forms.push(plane(cross(normal, minus(t[(i + 1) % 3], t[i])), t[i]));
    }
    let mut polygon: Vec<Rational> = s.map(whole).map(|p| [p[0], p[1], p[2], 1]).to_vec();
    for form in forms {
        polygon = clip(&polygon, form);
    }
    polygon
}

/// Returns `true` if a point lies on the segment or point that these common vertices span.
fn spanned(p: Rational, vertices: &[[i128; 3]]) -> bool {
    let difference = |v: [i128; 3]| minus([p[0], p[1], p[2]], v.map(|c| c * p[3]));
    match *vertices {
        [] => false,
        [v] => difference(v) == [0; 3],
        [v, w, ..] => {
            let (a, b) = (difference(v), difference(w));
            let inner: i128 = (0..3).map(|i| a[i] * b[i]).sum();
            cross(a, b) == [0; 3] && inner <= 0
        }
    }
}

/// Returns `true` if two triangles, given by point indices, meet beyond the span of their common vertices.
/// Coordinates are small integers.
pub fn beyond(points: &[DVec3], s: [u32; 3], t: [u32; 3]) -> bool {
    let at = |v: u32| points[v as usize];
    let shared: Vec<[i128; 3]> = s.iter().filter(|v| t.contains(v)).map(|&v| whole(at(v))).collect();
    shared.len() < 3 && common(s.map(at), t.map(at)).into_iter().any(|p| !spanned(p, &shared))
}
