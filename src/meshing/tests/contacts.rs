//! Intersections compared with a test of all pairs.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::brute::beyond;
use crate::check;
use crate::defect::{Defect, Element};
use crate::input::{DomainKind, Input, InputSegment};
use crate::space::Space;

/// Small integer coordinates, so that contacts of every kind are frequent.
fn points(count: usize, side: u32) -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec((0..side, 0..side, 0..side), count).prop_map(|all| {
        let mut seen = BTreeSet::new();
        let distinct = all.into_iter().filter(|p| seen.insert(*p));
        distinct.map(|(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z))).collect()
    })
}

/// Triangles with area, no two on the same vertices.
fn triangles(points: &[DVec3], picks: &[[usize; 3]]) -> Vec<[u32; 3]> {
    let n = points.len();
    let mut seen = BTreeSet::new();
    let named = picks.iter().map(|t| t.map(|i| (i % n) as u32));
    named
        .filter(|t| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            let mut key = *t;
            key.sort_unstable();
            !DVec3::collinear(a, b, c) && seen.insert(key)
        })
        .collect()
}

fn pairs(defects: &[Defect]) -> BTreeSet<[u32; 2]> {
    let pair = |d: &Defect| match d {
        Defect::Intersect { elements: [Element::Facet(a), Element::Facet(b)], .. }
        | Defect::Doubled { elements: [Element::Facet(a), Element::Facet(b)], .. } => Some([*a, *b]),
        _ => None,
    };
    defects.iter().filter_map(pair).collect()
}

fn picks(count: usize) -> impl Strategy<Value = Vec<[usize; 3]>> {
    prop::collection::vec([0..60usize, 0..60, 0..60], 2..count)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn triangles_of_a_surface(points in points(12, 4), picks in picks(7)) {
        let faces = triangles(&points, &picks);
        prop_assume!(faces.len() > 1);
        let input = Input::surface(points.clone(), faces.iter().map(|f| f.to_vec()));
        let found = check(&input).err().map(|d| pairs(&d)).unwrap_or_default();
        for (i, &s) in faces.iter().enumerate() {
            for (j, &t) in faces.iter().enumerate().skip(i + 1) {
                let expected = beyond(&points, s, t);
                prop_assert_eq!(expected, beyond(&points, t, s));
                prop_assert_eq!(found.contains(&[i as u32, j as u32]), expected, "{:?} {:?}", s, t);
            }
        }
    }

    /// Edges of the plane: touching edges are divided, so only crossings and overlaps are defects.
    #[test]
    fn segments_of_the_plane(coordinates in prop::collection::vec((0..5u32, 0..5u32), 4..9),
                             ends in prop::collection::vec([0..40usize, 0..40], 2..7)) {
        let mut seen = BTreeSet::new();
        let distinct = coordinates.into_iter().filter(|p| seen.insert(*p));
        let points: Vec<DVec2> = distinct.map(|(x, y)| DVec2::new(f64::from(x), f64::from(y))).collect();
        let mut seen = BTreeSet::new();
        let ends = ends.iter().map(|e| e.map(|i| (i % points.len()) as u32));
        let ends: Vec<[u32; 2]> =
            ends.filter(|e| e[0] != e[1] && seen.insert([e[0].min(e[1]), e[0].max(e[1])])).collect();
        let mut input = Input::new(DomainKind::Complex, points.clone());
        input.segments = ends.iter().map(|&ends| InputSegment { ends, marker: 0 }).collect();
        prop_assume!(!ends.is_empty());
        let defects = check(&input).err().unwrap_or_default();
        let faulty = defects.iter().any(|d| matches!(d, Defect::Intersect { .. } | Defect::Doubled { .. }));
        let expected = ends.iter().enumerate().any(|(i, &e)| {
            ends[i + 1..].iter().any(|&f| at_fault(&points, e, f))
        });
        prop_assert_eq!(faulty, expected, "{:?}", defects);
    }
}

/// Returns `true` if two segments overlap, or cross where there is no point. Uses their parameters in integers.
fn at_fault(points: &[DVec2], e: [u32; 2], f: [u32; 2]) -> bool {
    let at = |v: u32| points[v as usize].to_array().map(|c| c as i64);
    let ([a, b], [c, d]) = (e.map(at), f.map(at));
    let minus = |p: [i64; 2], q: [i64; 2]| [p[0] - q[0], p[1] - q[1]];
    let wedge = |p: [i64; 2], q: [i64; 2]| p[0] * q[1] - p[1] * q[0];
    let dot = |p: [i64; 2], q: [i64; 2]| p[0] * q[0] + p[1] * q[1];
    let (u, v, w) = (minus(b, a), minus(d, c), minus(c, a));
    let det = wedge(u, v);
    if det == 0 {
        let (s, t) = (dot(w, u), dot(minus(d, a), u));
        return wedge(w, u) == 0 && s.min(t).max(0) < s.max(t).min(dot(u, u));
    }
    // a + u s / det = c + v t / det.
    let (s, t) = (wedge(w, v) * det.signum(), wedge(w, u) * det.signum());
    if s < 0 || t < 0 || s > det.abs() || t > det.abs() {
        return false;
    }
    let place = [0, 1].map(|i| a[i] * det.abs() + u[i] * s);
    !points.iter().any(|p| p.to_array().map(|c| c as i64 * det.abs()) == place)
}
