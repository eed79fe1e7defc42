use septet_geometry::coordinates::Coordinates;

use super::{Draw, both, corners, made, orientation, replaced, twice, whole_sets};
use crate::{Dimension, Method, NONE, Tessellation};

/// Queries at halves of whole numbers: on vertices, edges and facets, in cells and outside.
fn queries<P: Dimension>(points: &[P]) -> Vec<P> {
    let mut draw = Draw(3);
    let mut queries = points.to_vec();
    for _ in 0..200 {
        let [a, b] = [0, 1].map(|_| points[draw.below(points.len() as u64) as usize]);
        queries.push((a + b) * 0.5);
        queries.push(draw.point(|draw| draw.below(40) as f64 / 2.0 - 6.0));
    }
    queries
}

fn expected<P: Dimension>(t: &Tessellation<P>, q: P) -> u32 {
    let holds =
        |cell: &usize| (0..=P::DIM).all(|slot| orientation(&replaced(corners(t, *cell), slot, q)) >= 0);
    (0..t.cells().len()).find(holds).map_or(NONE, |cell| cell as u32)
}

both!(location_in_the_plane, location_in_space, location);

fn location<P: Dimension + Coordinates>() {
    for points in whole_sets::<P>() {
        let t = made(&points);
        let queries = queries(&points);
        let found = t.locate(&queries);
        let barycentric = t.barycentric(&queries);
        assert_eq!(barycentric.cells, found);
        for (i, &q) in queries.iter().enumerate() {
            assert_eq!(found[i], expected(&t, q), "{q:?}");
            assert_eq!(t.locate(&[q]), [found[i]]);
            let row = &barycentric.coordinates[i * (P::DIM + 1)..][..=P::DIM];
            if found[i] == NONE {
                assert!(row.iter().all(|x| x.is_nan()));
                continue;
            }
            let cell = corners(&t, found[i] as usize);
            let mut sum = P::default();
            for (slot, (&x, &corner)) in row.iter().zip(&cell).enumerate() {
                let is_zero = orientation(&replaced(cell.clone(), slot, q)) == 0;
                assert!(if is_zero { x == 0.0 } else { x > 0.0 });
                sum = sum + corner * x;
            }
            assert!((sum - q).norm2() < 1e-24 && (row.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }
}

both!(nearest_vertices_in_the_plane, nearest_vertices_in_space, nearest_vertices);

fn nearest_vertices<P: Dimension + Coordinates>() {
    for points in whole_sets::<P>() {
        let t = made(&points);
        let mut queries = queries(&points);
        // Far outside, and at the common centre of many.
        queries.push(P::splat(0.0));
        queries.push(P::splat(1e6));
        let found = t.nearest(&queries);
        for (&q, found) in queries.iter().zip(found) {
            let distance = |p: P| -> i128 { (0..3).map(|i| (twice(p)[i] - twice(q)[i]).pow(2)).sum() };
            let nearest = (0..points.len()).min_by_key(|&v| (distance(points[v]), v)).unwrap();
            assert_eq!(found as usize, nearest, "{q:?}");
        }
    }
}

both!(scales_of_the_plane, scales_of_space, scales);

/// A power of two changes no answer. Tiny and huge numbers in queries are exact.
fn scales<P: Dimension + Coordinates>() {
    let mut draw = Draw(5);
    let points: Vec<P> = draw.grid(50, 5);
    let t = made(&points);
    let queries = queries(&points);
    let (cells, nearest) = (t.locate(&queries), t.nearest(&queries));
    for factor in [2f64.powi(-900), 2f64.powi(300), 2f64.powi(1000)] {
        let scaled = |list: &[P]| list.iter().map(|&p| p * factor).collect::<Vec<P>>();
        let t = made(&scaled(&points));
        assert_eq!(t.locate(&scaled(&queries)), cells);
        assert_eq!(t.nearest(&scaled(&queries)), nearest);
        assert_eq!(t.point(7), points[7] * factor);
    }
    let low = (0..points.len()).min_by(|&a, &b| points[a].coord(0).total_cmp(&points[b].coord(0))).unwrap();
    let at = |x: f64| {
        let mut q = points[low];
        q.set_coord(0, x);
        q
    };
    assert_eq!(points[low].coord(0), 0.0);
    for tiny in [1e-320, 1e-200, 1e-100, 1e-70] {
        // Beyond the hull by a tiny length, and inside of it; or on it, if the other coordinates are at its end.
        let found = t.locate(&[at(-tiny), at(0.0), at(tiny)]);
        assert_eq!(found[0], NONE);
        assert_eq!(found[1], expected(&t, points[low]));
        assert_eq!(t.nearest(&[at(-tiny), at(tiny)]), [t.nearest(&[points[low]])[0]; 2]);
        let weights = t.weights(&[at(tiny)], Method::Sibson);
        assert!(found[2] == NONE || (weights.values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(at);
    assert_eq!((t.locate(&wrong), t.nearest(&wrong)), (vec![NONE; 3], vec![NONE; 3]));
    assert_eq!(t.locate(&[at(1e308), at(-1e308)]), [NONE; 2]);
    let far = t.nearest(&[at(f64::MAX), at(-f64::MAX)]);
    assert_eq!(far.iter().map(|&v| points[v as usize].coord(0)).collect::<Vec<_>>(), [4.0, 0.0]);
}

both!(order_of_the_plane, order_of_space, order);

/// Many queries, in several blocks: in any order, one by one, and on one thread.
fn order<P: Dimension + Coordinates>() {
    let mut draw = Draw(9);
    let t = made(&draw.uniform::<P>(3000));
    let queries: Vec<P> = (0..10_000).map(|_| draw.point(|draw| 1.2 * draw.unit() - 0.1)).collect();
    let found = t.locate(&queries);
    let weights = t.weights(&queries, Method::Laplace);
    assert!(found.contains(&NONE) && found.iter().any(|cell| *cell != NONE));
    let reversed: Vec<P> = queries.iter().rev().copied().collect();
    assert!(t.locate(&reversed).into_iter().rev().eq(found.iter().copied()));
    for i in (0..queries.len()).step_by(97) {
        assert_eq!(t.locate(&queries[i..=i]), [found[i]]);
        let row = weights.offsets[i] as usize..weights.offsets[i + 1] as usize;
        assert_eq!(t.weights(&queries[i..=i], Method::Laplace).values, weights.values[row]);
    }
}
