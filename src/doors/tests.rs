//! Calls over flat arrays.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::{
    Call, Code, Door, Failure, Forecast, Method, NONE, Periodic, Request, Sites, Triangulated, simulated,
};

fn call() -> Call {
    Call::new(Door::Python)
}

/// Points of a grid with a side of `side` steps, the first axis fastest.
fn grid(side: u32, columns: u32) -> Vec<f64> {
    let point = |i: u32| (0..columns).map(move |axis| f64::from(i / side.pow(axis) % side));
    (0..side.pow(columns)).flat_map(point).collect()
}

fn made(points: &[f64], columns: usize) -> Triangulated {
    Triangulated::new(points, columns, &Request::new(call())).unwrap()
}

fn failed(points: &[f64], columns: usize, request: &Request) -> Failure {
    Triangulated::new(points, columns, request).unwrap_err()
}

#[test]
fn flat_arrays_have_the_shapes_of_the_triangulation() {
    for columns in [2, 3] {
        let points = grid(3, columns as u32);
        let t = made(&points, columns);
        let (n, m) = (t.len(), t.cell_count());
        assert_eq!((n * columns, t.columns(), t.dimension()), (points.len(), columns, columns as isize));
        assert_eq!(t.points(), points);
        assert_eq!((t.cells().len(), t.neighbours().len()), (m * (columns + 1), m * (columns + 1)));
        assert_eq!(t.vertex_cells().len(), n);
        let call = call();
        let (hull, edges) = (t.hull(&call).unwrap(), t.edges(&call).unwrap());
        assert_eq!(hull.len() / columns, t.neighbours().iter().filter(|&&next| next == NONE).count());
        assert_eq!(t.vertex_neighbours(&call).unwrap().indices.len(), edges.len());
        let total: f64 = t.volumes(&call).unwrap().iter().sum();
        assert!((total - 2f64.powi(columns as i32)).abs() < 1e-12);
        assert_eq!(t.circumcentres(&call).unwrap().len(), m * columns);
        assert_eq!(t.circumradii(&call).unwrap(), vec![(columns as f64).sqrt() / 2.0; m]);
        assert_eq!(t.transforms(&call).unwrap().len(), m * (columns + 1) * columns);
        let values = vec![0.5; 4 * n];
        assert_eq!(t.gradients(&values, 4, &call).unwrap(), vec![0.0; m * columns * 4]);
        let again = Triangulated::of_rows(&points, columns, t.cells(), Sites::default(), &call).unwrap();
        assert_eq!(again.neighbours(), t.neighbours());
        assert!(t.run().is_some_and(|run| run.cell_count() == m) && again.run().is_none());
        assert_eq!(
            Triangulated::of_rows(&points, columns, &[1], Sites::default(), &call).unwrap_err().code,
            Code::Usage
        );
    }
}

#[test]
fn queries_take_flat_arrays() {
    let t = made(&grid(4, 3), 3);
    let queries = [0.5, 1.25, 2.0, 3.0, 3.0, 3.0, 7.0, 0.0, 0.0, f64::NAN, 0.0, 0.0];
    let call = call();
    let cells = t.locate(&queries, &call).unwrap();
    assert!(cells[..2].iter().all(|&cell| cell != NONE) && cells[2..] == [NONE; 2]);
    assert_eq!(t.nearest(&queries, &call).unwrap()[1..], [63, 3, NONE]);
    let found = t.barycentric(&queries, &call).unwrap();
    assert_eq!((&found.cells, found.coordinates.len()), (&cells, 16));
    let again = t.barycentric_in(&queries, &cells, &call).unwrap();
    assert_eq!(again[..8], found.coordinates[..8]);
    let values: Vec<f64> = grid(4, 3).chunks_exact(3).flat_map(|p| [p[0] - p[2], 1.0]).collect();
    for method in Method::ALL {
        let got = t.interpolate((&values, 2), &queries, (method, -9.0), &call).unwrap();
        let expected = [-1.5, 1.0, 0.0, 1.0, -9.0, -9.0, -9.0, -9.0];
        assert!(got.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-12), "{method:?}: {got:?}");
        assert_eq!(t.weights(&queries, method, &call).unwrap().offsets.len(), 5);
    }
    assert_eq!(t.interpolate((&values, 3), &[], (Method::Linear, 0.0), &call).unwrap_err().code, Code::Usage);
    assert_eq!(t.locate(&queries[..4], &call).unwrap_err().code, Code::Usage);
}

#[test]
fn voronoi_cells_and_alpha_shapes_are_flat() {
    let t = made(&grid(4, 2), 2);
    let call = call();
    let (low, high) = ([-0.5, -0.5], [3.5, 3.5]);
    assert_eq!(t.voronoi_volumes(Some((&low, &high)), &call).unwrap(), [1.0; 16]);
    assert_eq!(t.voronoi_volumes(None, &call).unwrap()[5], 1.0);
    let centroids = t.voronoi_centroids(Some((&low, &high)), &call).unwrap();
    assert!(centroids.iter().zip(grid(4, 2)).all(|(x, y)| (x - y).abs() < 1e-14));
    assert!(t.voronoi_centroids(None, &call).unwrap()[0].is_nan());
    assert_eq!(t.ridges(None, &call).unwrap().points.len() * 2, t.edges(&call).unwrap().len());
    assert_eq!(t.voronoi_regions(&call).unwrap().len(), 16);
    let failure = t.voronoi_volumes(Some((&[0.0, 0.0], &[3.0, 2.0])), &call).unwrap_err();
    assert_eq!((failure.code, failure.index), (Code::Input, Some(12)));
    assert_eq!(t.voronoi_volumes(Some((&low[..1], &high)), &call).unwrap_err().code, Code::Usage);
    let filtration = t.alpha_filtration(&call).unwrap();
    assert_eq!(filtration.cells, t.alpha_values(&call).unwrap());
    assert_eq!(filtration.facets, filtration.edges);
    let shape = t.alpha_shape(1.0, &call).unwrap();
    assert_eq!((shape.volume, shape.boundary.len(), shape.singular.len()), (9.0, 24, 0));
    assert_eq!(t.alpha_shape(-1.0, &call).unwrap_err().code, Code::Usage);
}

#[test]
fn failures_name_points_and_options() {
    let mut points = grid(3, 3);
    points[16] = f64::INFINITY;
    let request = Request::new(call());
    let failure = failed(&points, 3, &request);
    assert_eq!((failure.code, failure.index), (Code::Input, Some(5)));
    assert!(failure.message.ends_with("drop such points with on_invalid=\"skip\""), "{failure:?}");
    let c = failed(&points, 3, &Request::new(Call::new(Door::C)));
    assert!(c.message.ends_with("drop such points with skip_invalid"), "{c:?}");
    let skipping = Request { skip_invalid: true, ..request.clone() };
    let t = Triangulated::new(&points, 3, &skipping).unwrap();
    assert_eq!((t.skipped(), t.vertex_cells()[5]), (&[5][..], NONE));
    let again = Triangulated::of_rows(&points, 3, t.cells(), Sites::default(), &call()).unwrap();
    assert_eq!(again.skipped(), [5]);
    let limited = failed(&grid(3, 3), 3, &Request { max_memory: Some(9), ..request.clone() });
    assert!(matches!(limited.forecast, Some(Forecast { bytes: 10.., limit: 9 })), "{limited:?}");
    assert!(limited.code == Code::Limit && limited.message.contains("raise max_memory=..."), "{limited:?}");
    for (columns, part) in
        [(4, "septet triangulate"), (6, "septet triangulate"), (1, "2 coordinates"), (0, "3 for")]
    {
        let failure = failed(&[0.0; 12], columns, &request);
        assert!(failure.code == Code::Usage && failure.message.contains(part), "{failure:?}");
    }
    assert_eq!(failed(&[0.0; 7], 2, &request).code, Code::Usage);
    assert!(Failure::panicked(Door::C).message.contains("report"));
}

#[test]
fn few_and_flat_points_have_no_cells() {
    let line = [0.0, 0.0, 1.0, 1.0, 3.0, 3.0];
    for (points, dimension) in [(&[][..], -1), (&line[..2], 0), (&line[..], 1)] {
        let t = made(points, 2);
        assert_eq!((t.dimension(), t.cell_count(), t.is_empty()), (dimension, 0, points.is_empty()));
        assert_eq!(t.locate(&[0.0, 0.0], &call()).unwrap(), [NONE]);
        let failure = t.voronoi_volumes(None, &call()).unwrap_err();
        assert_eq!((failure.code, failure.index), (Code::Usage, None));
        assert!(t.hull(&call()).unwrap().is_empty() && t.edges(&call()).unwrap().is_empty());
        assert_eq!(
            Triangulated::of_rows(points, 2, &[], Sites::default(), &call()).unwrap().dimension(),
            dimension
        );
    }
}

#[test]
fn calls_are_cancelled_and_report_progress() {
    let flag = Arc::new(AtomicBool::new(true));
    let cancelled = Request::new(call().cancel(flag.clone()));
    let failure = failed(&grid(3, 2), 2, &cancelled);
    assert_eq!((failure.code, &failure.message[..]), (Code::Interrupted, "interrupted"));
    let t = made(&grid(3, 2), 2);
    assert_eq!(t.locate(&[0.0, 0.0], &cancelled.call).unwrap_err().code, Code::Interrupted);
    flag.store(false, Ordering::Relaxed);
    assert!(t.locate(&[0.0, 0.0], &cancelled.call).is_ok());
    // The callback cancels the call from within.
    let phases = Arc::new(Mutex::new(Vec::new()));
    let (seen, ends) = (phases.clone(), flag.clone());
    let progress = move |at: septet_core::spec::Progress| {
        seen.lock().unwrap().push(at.phase);
        ends.store(true, Ordering::Relaxed);
    };
    let watched = Request { progress: Some(Arc::new(progress)), ..cancelled };
    assert_eq!(failed(&grid(30, 2), 2, &watched).code, Code::Interrupted);
    assert!(!phases.lock().unwrap().is_empty());
}

#[test]
fn threads_do_not_matter() {
    let points: Vec<f64> = (0u32..9000).map(|i| f64::from(i.wrapping_mul(2_654_435_761) >> 12)).collect();
    let of = |threads| {
        let request = Request { seed: threads as u64, ..Request::new(call().threads(threads)) };
        let t = Triangulated::new(&points, 3, &request).unwrap();
        let found = t.locate(&points, &request.call).unwrap();
        let volumes = t.volumes(&request.call).unwrap();
        (t.cells().to_vec(), t.neighbours().to_vec(), found, volumes)
    };
    assert!(of(1) == of(4) && of(1) == of(0));
}

/// Cells that wind twice around their centre are locally Delaunay and convex.
#[test]
fn a_double_cover_is_no_triangulation() {
    let mut points = vec![0.0, 0.0];
    for i in 0..5 {
        let angle = 0.8 * std::f64::consts::PI * f64::from(i);
        points.extend([angle.cos(), angle.sin()]);
    }
    let mut cells: Vec<[u32; 3]> = (0..5).map(|i| [0, 1 + i, 1 + (i + 1) % 5]).collect();
    cells.sort_unstable();
    let failure =
        Triangulated::of_rows(&points, 2, cells.as_flattened(), Sites::default(), &call()).unwrap_err();
    assert_eq!(failure.code, Code::Input);
}

#[test]
fn points_with_weights_have_a_regular_triangulation() {
    // The third ball lies in the first.
    let points = [0.0, 0.0, 4.0, 0.0, 0.5, 0.5, 0.0, 4.0, -0.0, 4.0];
    let weights = |weights: &[f64]| Request {
        sites: Sites { weights: Some(weights.to_vec()), periodic: None },
        ..Request::new(call())
    };
    let request = weights(&[9.0, 1.0, 0.25, 1.0, 1.0]);
    let t = Triangulated::new(&points, 2, &request).unwrap();
    let call = call();
    assert_eq!((t.cells(), t.hidden(), t.duplicates()), (&[0, 1, 3][..], &[2][..], &[4, 3][..]));
    assert_eq!((t.offsets(), t.sheets(), t.is_simplicial()), (None, None, true));
    assert_eq!(t.locate(&points, &call).unwrap(), [0; 5]);
    assert_eq!(t.vertex_cells(), [0, 0, NONE, 0, 0]);
    assert!(t.points()[8].is_sign_negative());
    let corners = (&[-1.0, -1.0][..], &[5.0, 5.0][..]);
    let volumes = t.voronoi_volumes(Some(corners), &call).unwrap();
    assert!((volumes.iter().sum::<f64>() - 36.0).abs() < 1e-12 && volumes[2] == 0.0 && volumes[4] == 0.0);
    let cells = t.power_cells(Some(corners), &call).unwrap();
    assert_eq!((cells.cells.len(), cells.cells.row(2).len()), (5, 0));
    assert_eq!(cells.corners.len(), 2 * cells.cells.indices.len());
    let centroids = t.voronoi_centroids(Some(corners), &call).unwrap();
    // The bisector of the first two sites is x = (16 + 9 - 1) / 8.
    assert!(centroids[2] > 3.0 && centroids[4].is_nan());
    let failure = t.nearest(&points, &call).unwrap_err();
    assert_eq!(failure.code, Code::Usage);
    assert!(
        failure.message.starts_with("nearest_vertex: not available with weights; use simplices"),
        "{}",
        failure.message
    );
    assert!(t.voronoi_volumes(None, &call).unwrap_err().message.contains("box=(low, high)"));
    assert!(t.weights(&points, Method::Linear, &call).is_ok());
    assert!(t.weights(&points, Method::Sibson, &call).is_err());
    assert_eq!(failed(&points, 2, &weights(&[1.0])).code, Code::Usage);
    let failure = failed(&points, 2, &weights(&[1.0, f64::NAN, 1.0, 1.0, 1.0]));
    assert_eq!((failure.code, failure.index), (Code::Input, Some(1)));
    let again = Triangulated::of_rows(&points, 2, t.cells(), request.sites.clone(), &call).unwrap();
    assert_eq!(again.voronoi_volumes(Some(corners), &call).unwrap(), volumes);
    assert!(again.run().is_none() && t.run().is_some());
    assert!(Triangulated::of_rows(&points, 2, t.cells(), Sites::default(), &call).is_err());
    // Two points that others hide coincide.
    let points = [0.0, 0.0, 4.0, 0.0, 1.0, 1.0, 0.0, 4.0, 1.0, 1.0];
    let t = Triangulated::new(&points, 2, &weights(&[9.0, 1.0, -9.0, 1.0, -9.0])).unwrap();
    assert_eq!((t.cells(), t.hidden(), t.duplicates()), (&[0, 1, 3][..], &[2][..], &[4, 2][..]));
    assert_eq!(t.vertex_cells(), [0, 0, NONE, 0, NONE]);
}

#[test]
fn a_periodic_box_has_cells_with_offsets() {
    for columns in [2, 3] {
        let points = grid(3, columns as u32);
        let periodic = Periodic::of_lengths(&vec![3.0; columns]);
        let sites = Sites { weights: None, periodic: Some(periodic) };
        let t = Triangulated::new(&points, columns, &Request { sites, ..Request::new(call()) }).unwrap();
        let (m, call) = (t.cell_count(), call());
        assert_eq!(t.offsets().unwrap().len(), m * (columns + 1) * columns);
        assert!(t.neighbours().iter().all(|&next| (next as usize) < m));
        for (slot, &next) in t.neighbours().iter().enumerate() {
            let back = &t.neighbours()[next as usize * (columns + 1)..][..=columns];
            assert!(back.contains(&((slot / (columns + 1)) as u32)));
        }
        let box_volume = 3f64.powi(columns as i32);
        assert!((t.volumes(&call).unwrap().iter().sum::<f64>() - box_volume).abs() < 1e-9);
        let volumes = t.voronoi_volumes(None, &call).unwrap();
        assert!(volumes.iter().all(|volume| (volume - 1.0).abs() < 1e-12), "{volumes:?}");
        let centroids = t.voronoi_centroids(None, &call).unwrap();
        assert!(centroids.iter().zip(&points).all(|(x, y)| (x - y).abs() < 1e-12));
        assert_eq!((t.points(), t.dimension()), (points.clone(), columns as isize));
        let unfolded = t.unfolded(&call).unwrap().unwrap();
        assert_eq!(unfolded.cells.len(), t.cells().len());
        for failure in [t.locate(&points, &call).unwrap_err(), t.hull(&call).unwrap_err()] {
            assert!(
                failure.message.contains("not available in a periodic box; use simplices"),
                "{}",
                failure.message
            );
        }
        let corners = (&points[..columns], &points[..columns]);
        assert!(t.voronoi_volumes(Some(corners), &call).unwrap_err().message.contains("omit box"));
    }
}

/// Points with weights whose run was made with other ones.
#[test]
fn a_run_is_taken_with_its_weights_and_its_box() {
    let points = [0.125, 0.25, 0.5, 0.75, 0.75, 0.375];
    let plain = Request::new(call());
    let ran = |request: &Request| simulated(&points, 2, request, &request.spec()).unwrap();
    let with = |weights: &[f64], lengths: &[f64]| {
        let periodic = (!lengths.is_empty()).then(|| Periodic::of_lengths(lengths));
        Request {
            sites: Sites { weights: (!weights.is_empty()).then(|| weights.to_vec()), periodic },
            ..Request::new(call())
        }
    };
    let of_run = |run: &Request, request: &Request| Triangulated::of_run(&points, 2, ran(run), request);
    let (weights, boxed) = (with(&[0.0; 3], &[]), with(&[], &[1.0; 2]));
    assert!(
        of_run(&plain, &plain).is_ok()
            && of_run(&weights, &weights).is_ok()
            && of_run(&boxed, &boxed).is_ok()
    );
    let wrong = [
        (&plain, with(&[0.0; 2], &[])),
        (&weights, with(&[0.0; 4], &[])),
        (&plain, boxed.clone()),
        (&boxed, plain.clone()),
        (&boxed, with(&[], &[1.0; 3])),
    ];
    for (run, request) in wrong {
        assert_eq!(of_run(run, &request).unwrap_err().code, Code::Usage);
    }
    let failure = Triangulated::of_run(&points[..4], 2, ran(&plain), &plain).unwrap_err();
    assert_eq!(failure.code, Code::Usage);
}
