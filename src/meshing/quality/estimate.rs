//! The radius-edge ratio, rounded, for coordinates of any size.

/// Returns the circumradius of the first `corners` points divided by the length of the shortest edge. It is infinite if the
/// cell is flat or has two equal vertices.
///
/// The origin is moved to an end of the shortest edge, and all lengths are divided by the largest coordinate
/// difference. Very large or small coordinates therefore cause no overflow. Let u, v, w be the edges from that
/// origin. The circumradius of a tetrahedron is |u² (v × w) + v² (w × u) + w² (u × v)| / (2 |u · (v × w)|). The
/// circumradius of a triangle is |u| |v| |u − v| / (2 |u × v|).
pub fn radius_edge_ratio(mut points: [[f64; 3]; 4], corners: usize) -> f64 {
    let points = &mut points[..corners.min(4)];
    let corners = points.len();
    if points.iter().flatten().any(|c| c.abs() > f64::MAX / 4.0) {
        // Differences could overflow. The ratio does not depend on the scale.
        points.iter_mut().flatten().for_each(|c| *c /= 4.0);
    }
    let Some(origin) = shortest_edge_end(points) else {
        return f64::INFINITY;
    };
    let mut edges = [[0.0; 3]; 3];
    let others = (0..corners).filter(|&i| i != origin);
    for (edge, i) in edges.iter_mut().zip(others) {
        *edge = minus(points[i], points[origin]);
    }
    let scale = edges.iter().flatten().fold(0.0f64, |m, c| m.max(c.abs()));
    edges.iter_mut().flatten().for_each(|c| *c /= scale);
    let [u, v, w] = edges;
    let radius = if corners == 4 { tetrahedron_radius(u, v, w) } else { triangle_radius(u, v) };
    let from_origin = edges[..corners - 1].iter().map(|&edge| norm(edge));
    let ratio = radius / from_origin.fold(f64::INFINITY, f64::min);
    if ratio.is_nan() { f64::INFINITY } else { ratio }
}

/// Returns an end of the shortest edge, or `None` if two points are equal.
fn shortest_edge_end(points: &[[f64; 3]]) -> Option<usize> {
    let mut best = (0, f64::INFINITY);
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            let length = norm(minus(points[j], points[i]));
            if length < best.1 {
                best = (i, length);
            }
        }
    }
    (best.1 > 0.0).then_some(best.0)
}

fn tetrahedron_radius(u: [f64; 3], v: [f64; 3], w: [f64; 3]) -> f64 {
    let terms = [(cross(v, w), u), (cross(w, u), v), (cross(u, v), w)];
    let mut sum = [0.0; 3];
    for (normal, edge) in terms {
        let square = dot(edge, edge);
        for axis in 0..3 {
            sum[axis] += square * normal[axis];
        }
    }
    norm(sum) / (2.0 * dot(u, cross(v, w)).abs())
}

fn triangle_radius(u: [f64; 3], v: [f64; 3]) -> f64 {
    norm(u) * norm(v) * norm(minus(u, v)) / (2.0 * norm(cross(u, v)))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the length, without intermediate overflow or underflow.
fn norm(a: [f64; 3]) -> f64 {
    let scale = a.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if scale == 0.0 || !scale.is_finite() {
        return scale;
    }
    let b = a.map(|c| c / scale);
    scale * dot(b, b).sqrt()
}
