//! Constrained triangulations against brute force, and of difficult inputs.

use std::collections::BTreeSet;

use glam::DVec2;
use proptest::prelude::*;
use septet_geometry::hash::Draw;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use super::constrained::{Constrained, Crossed};
use crate::generate::{Alone, MeshMachine};
use crate::space::{Space, ascending, edges_overlap, on_segment};

fn start(points: &[DVec2]) -> Constrained {
    let delaunay = MeshMachine::<DVec2>::delaunay(&mut Alone { seed: 1 }, points).unwrap();
    Constrained::new(points.to_vec(), delaunay)
}

fn built(points: &[DVec2], segments: &[[u32; 2]]) -> Constrained {
    let mut made = start(points);
    for &[a, b] in segments {
        made.constrain(a, b).unwrap();
    }
    made
}

/// The cells, smallest vertex first, sorted.
fn cells(made: &Constrained) -> Vec<[u32; 3]> {
    let first = |&[a, b, c]: &[u32; 3]| {
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    };
    let mut cells: Vec<[u32; 3]> = made.cells().iter().map(first).collect();
    cells.sort_unstable();
    cells
}

fn constraints(made: &Constrained) -> BTreeSet<[u32; 2]> {
    let all = (0..made.cells().len() as u32).flat_map(|c| (0..3).map(move |i| (c, i)));
    let edge = |(c, i): (u32, usize)| {
        let corners = made.cells()[c as usize];
        ascending([corners[(i + 1) % 3], corners[(i + 2) % 3]])
    };
    all.filter(|&(c, i)| made.is_constrained(c, i)).map(edge).collect()
}

/// Checks cells, adjacency and marks, and that all edges are legal.
fn check(made: &Constrained, expected_cells: usize) {
    assert_eq!(made.cells().len(), expected_cells);
    let p = |v: u32| made.points()[v as usize];
    for (c, &corners) in (0u32..).zip(made.cells()) {
        assert_eq!(orientation(&corners.map(p)), Sign::Positive);
        for i in 0..3 {
            let Some(other) = made.across(c, i) else { continue };
            let back = (0..3).find(|&j| made.across(other, j) == Some(c)).unwrap();
            let (own, theirs) = (corners, made.cells()[other as usize]);
            assert_eq!(
                [own[(i + 1) % 3], own[(i + 2) % 3]],
                [theirs[(back + 2) % 3], theirs[(back + 1) % 3]]
            );
            assert_eq!(made.is_constrained(c, i), made.is_constrained(other, back));
            assert!(made.is_constrained(c, i) || !in_sphere(&corners.map(p), p(theirs[back])));
        }
    }
    for v in 0..made.points().len() as u32 {
        let cell = made.at[v as usize];
        assert!(made.cells()[cell as usize].contains(&v));
    }
}

/// The constrained Delaunay triangles by definition: a triangle is one iff no constraint crosses it, and no vertex that
/// sees it lies in its perturbed circle. For each pair of points, sight is tested along the edges of the triangle.
fn brute(points: &[DVec2], segments: &[[u32; 2]]) -> Vec<[u32; 3]> {
    let n = points.len() as u32;
    let p = |v: u32| points[v as usize];
    let apart = |[a, b]: [u32; 2], [c, d]: [u32; 2]| {
        let shared = [c, d].iter().filter(|v| [a, b].contains(v)).count();
        match shared {
            2 => true,
            1 => {
                let (o, x) = if c == a || d == a { (a, b) } else { (b, a) };
                let y = if c == o { d } else { c };
                !edges_overlap(p(o), p(x), p(y))
            }
            _ => !DVec2::edges_meet([p(a), p(b)], [p(c), p(d)]),
        }
    };
    let free = |e: [u32; 2]| {
        segments.iter().all(|&s| apart(e, s))
            && (0..n).all(|v| e.contains(&v) || !on_segment(p(e[0]), p(e[1]), p(v)))
    };
    let inside = |t: [u32; 3], v: u32| {
        (0..3).all(|i| orientation(&[p(t[i]), p(t[(i + 1) % 3]), p(v)]) != Sign::Negative)
    };
    let mut found = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            for c in a + 1..n {
                let t = [a, b, c];
                let fits = b != c
                    && orientation(&t.map(p)) == Sign::Positive
                    && [[a, b], [b, c], [c, a]].into_iter().all(free)
                    && (0..n).all(|v| t.contains(&v) || !inside(t, v));
                if fits
                    && (0..n).all(|v| {
                        t.contains(&v) || !in_sphere(&t.map(p), p(v)) || hidden(points, segments, t, v)
                    })
                {
                    found.push(t);
                }
            }
        }
    }
    found
}

/// Whether constraints hide all inner points of the triangle from a vertex. Rows of inner points are tested.
fn hidden(points: &[DVec2], segments: &[[u32; 2]], t: [u32; 3], v: u32) -> bool {
    let p = |v: u32| points[v as usize];
    let [a, b, c] = t.map(p);
    let steps = 12;
    (1..steps).all(|i| {
        (1..steps - i).all(|j| {
            let (s, r) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
            let x = a + (b - a) * s + (c - a) * r;
            segments.iter().any(|e| !e.contains(&v) && DVec2::edges_meet([x, p(v)], e.map(p)))
        })
    })
}

/// Distinct points of a small lattice or at random, and segments between them that meet only at common ends.
fn sample(seed: u64, n: usize, lattice: Option<u64>, wanted: usize) -> (Vec<DVec2>, Vec<[u32; 2]>) {
    let mut draw = Draw::new(seed);
    let mut points: Vec<DVec2> = Vec::new();
    while points.len() < n {
        let mut coordinate = || {
            let unit = draw.unit();
            lattice.map_or(unit, |k| (unit * k as f64).floor())
        };
        let q = DVec2::new(coordinate(), coordinate());
        if !points.contains(&q) {
            points.push(q);
        }
    }
    let p = |v: u32| points[v as usize];
    let mut segments: Vec<[u32; 2]> = Vec::new();
    for _ in 0..wanted * 4 {
        let mut vertex = || (draw.unit() * n as f64) as u32;
        let [a, b] = [vertex(), vertex()];
        let clear = a != b
            && (0..n as u32).all(|v| v == a || v == b || !on_segment(p(a), p(b), p(v)))
            && segments.iter().all(|&[c, d]| {
                let shared = [c, d].iter().filter(|v| **v == a || **v == b).count();
                shared == 1 || shared == 0 && !DVec2::edges_meet([p(a), p(b)], [p(c), p(d)])
            });
        if clear && segments.len() < wanted {
            segments.push([a, b]);
        }
    }
    (points, segments)
}

fn spans(points: &[DVec2]) -> bool {
    points[2..].iter().any(|&q| !DVec2::collinear(points[0], points[1], q))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

    /// The triangulation is the one of the definition, also on lattices, where most circles have several points.
    #[test]
    fn cells_are_those_of_the_definition(seed: u64, n in 4usize..11, side in 3u64..6, is_lattice: bool, wanted in 1usize..9) {
        let (points, segments) = sample(seed, n.min((side * side) as usize), is_lattice.then_some(side), wanted);
        prop_assume!(spans(&points));
        let made = built(&points, &segments);
        check(&made, start(&points).cells().len());
        prop_assert_eq!(constraints(&made), segments.iter().map(|&s| ascending(s)).collect());
        prop_assert_eq!(cells(&made), brute(&points, &segments));
    }

    /// Many segments, in any order and direction, give the same cells.
    #[test]
    fn the_order_of_segments_does_not_matter(seed: u64, n in 20usize..120, side in 8u64..14, is_lattice: bool) {
        let n = n.min((side * side) as usize);
        let (points, segments) = sample(seed, n, is_lattice.then_some(side), n);
        prop_assume!(spans(&points));
        let made = built(&points, &segments);
        check(&made, start(&points).cells().len());
        let turned: Vec<[u32; 2]> = segments.iter().rev().map(|&[a, b]| [b, a]).collect();
        prop_assert_eq!(cells(&built(&points, &turned)), cells(&made));
        // The numbering of the points does not matter either.
        let n = points.len() as u32;
        let back: Vec<DVec2> = points.iter().rev().copied().collect();
        let renamed: Vec<[u32; 2]> = segments.iter().map(|s| s.map(|v| n - 1 - v)).collect();
        let other = built(&back, &renamed);
        let sorted = |t: [u32; 3]| { let mut t = t; t.sort_unstable(); t };
        let mine: BTreeSet<[u32; 3]> = made.cells().iter().map(|&t| sorted(t)).collect();
        let theirs: BTreeSet<[u32; 3]> = other.cells().iter().map(|t| sorted(t.map(|v| n - 1 - v))).collect();
        prop_assert_eq!(mine, theirs);
    }
}

/// A segment along the edges of a zigzag, whose chains visit vertices twice.
#[test]
fn segments_cross_fans_with_dangling_edges() {
    // The spikes are constraints that end next to the segment, on both sides.
    let mut points = vec![DVec2::new(-1.0, 0.0), DVec2::new(41.0, 0.25)];
    let mut segments = Vec::new();
    for i in 0..40u32 {
        let x = f64::from(i) + 0.5;
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let n = points.len() as u32;
        points.extend([DVec2::new(x, side * 9.0), DVec2::new(x, side * (0.5 + f64::from(i % 7)))]);
        segments.push([n, n + 1]);
    }
    segments.push([0, 1]);
    let made = built(&points, &segments);
    check(&made, start(&points).cells().len());
    assert_eq!(constraints(&made).len(), segments.len());
    assert!(made.work() > 0);
}

/// A segment that crosses thousands of edges between two rows of points, and points on it.
#[test]
fn long_segments() {
    let mut points = vec![DVec2::new(-1.0, 0.0), DVec2::new(2001.0, 0.0)];
    let mut draw = Draw::new(7);
    for i in 0..2000u32 {
        let y = (1e-3 + draw.unit()) * if draw.unit() < 0.5 { 1.0 } else { -1.0 };
        points.push(DVec2::new(f64::from(i), if i % 500 == 250 { 0.0 } else { y }));
    }
    let made = built(&points, &[[1, 0]]);
    check(&made, start(&points).cells().len());
    assert_eq!(constraints(&made).len(), 5);
}

#[test]
fn crossings_are_refused_and_change_nothing() {
    let points = [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [1., 2.]].map(DVec2::from);
    let mut made = built(&points, &[[0, 2]]);
    let before = cells(&made);
    let Err(Crossed(ends)) = made.constrain(1, 3) else { panic!("the segments cross") };
    assert_eq!(ascending(ends), [0, 2]);
    assert_eq!(cells(&made), before);
    check(&made, before.len());
}

/// Points within a few units in the last place of a line.
#[test]
fn nearly_collinear_points() {
    let mut points: Vec<DVec2> =
        (0..60).map(|i| DVec2::new(0.1 * f64::from(i), 0.3 * f64::from(i))).collect();
    points.extend([DVec2::new(3.0, -5.0), DVec2::new(-2.0, 7.0)]);
    let mut made = start(&points);
    let count = made.cells().len();
    assert_eq!(made.constrain(0, 59), Ok(()));
    assert!(made.constrain(60, 61).is_err() || constraints(&made).len() > 1);
    check(&made, count);
}
