//! Calls as a C program makes them.
#![allow(unsafe_code, reason = "calls of functions for C")]

use std::ffi::CStr;
use std::mem::offset_of;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicI32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use septet_c::Handle;
use septet_c::ffi::*;

const OPTION: i32 = 2;
const POINTS: i32 = 3;
const LIMIT: i32 = 5;
const CANCELLED: i32 = 130;

/// The text and the row of the last failure.
fn failure() -> (String, i64) {
    let text = unsafe { CStr::from_ptr(septet_last_error()) };
    (text.to_str().unwrap().to_owned(), septet_last_index())
}

fn defaults() -> Options {
    let mut options = Options {
        size: 0,
        threads: 9,
        skip_invalid: 9,
        seed: 9,
        max_memory: 9,
        cancel: null(),
        weights: null(),
        period: null(),
        origin: null(),
        wrap: 9,
        reserved: 9,
    };
    unsafe { septet_options_init_sized(&raw mut options, size_of::<Options>()) };
    options
}

#[test]
fn options_of_older_programs_are_not_overwritten() {
    let mut options = Options { wrap: 9, reserved: 9, weights: [1.0].as_ptr(), ..defaults() };
    options.threads = 9;
    unsafe { septet_options_init(&raw mut options) };
    assert_eq!((options.size, options.threads), (offset_of!(Options, weights), 0));
    assert!(options.wrap == 9 && options.reserved == 9 && !options.weights.is_null());
    // A program that was built for a later library.
    unsafe { septet_options_init_sized(&raw mut options, size_of::<Options>() + 64) };
    assert_eq!((options.size, options.wrap, options.weights), (size_of::<Options>(), 0, null()));
}

/// Triangulates points. A failure writes nothing.
fn made(points: &[f64], dimension: usize, options: &Options) -> Result<*mut Handle, i32> {
    let mut t = null_mut();
    let n = points.len() / dimension;
    match unsafe { septet_triangulate(points.as_ptr(), n, dimension as u32, options, &raw mut t) } {
        0 => Ok(t),
        status => {
            assert!(t.is_null());
            Err(status)
        }
    }
}

/// Numbers from 0 to 1 that look random.
fn numbers(count: usize) -> Vec<f64> {
    let mut state = 7u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| next()).collect()
}

fn cells(t: *const Handle) -> Vec<i64> {
    let corners = unsafe { septet_dimension(t) } as usize + 1;
    let mut cells = vec![7; unsafe { septet_cells_count(t) } * corners];
    assert_eq!(unsafe { septet_cells_i64(t, cells.as_mut_ptr()) }, 0);
    cells
}

#[test]
fn a_square_has_two_cells() {
    let points = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let t = made(&points, 2, &defaults()).unwrap();
    unsafe {
        assert_eq!((septet_dimension(t), septet_rank(t), septet_points_count(t)), (2, 2, 5));
        assert_eq!((septet_cells_count(t), septet_hull_count(t), septet_duplicates_count(t)), (2, 4, 1));
        let (mut narrow, mut wide) = ([7i32; 6], [7i64; 6]);
        assert_eq!(septet_cells_i32(t, narrow.as_mut_ptr()), 0);
        assert_eq!(narrow.map(i64::from).to_vec(), cells(t));
        assert_eq!(septet_neighbors_i32(t, narrow.as_mut_ptr()), 0);
        assert_eq!(septet_neighbors_i64(t, wide.as_mut_ptr()), 0);
        assert_eq!(narrow.map(i64::from), wide);
        assert_eq!(wide.iter().filter(|&&next| next == -1).count(), 4);
        let (mut hull, mut first, mut duplicate) = ([7i64; 8], [7i64; 5], [7i64; 2]);
        assert_eq!(septet_hull(t, hull.as_mut_ptr()), 0);
        assert_eq!(hull, [0, 1, 1, 2, 2, 3, 3, 0]);
        assert_eq!(septet_vertex_to_cell(t, first.as_mut_ptr()), 0);
        assert_eq!((first[0], first[4]), (0, first[1]));
        assert_eq!(septet_duplicates(t, duplicate.as_mut_ptr()), 0);
        assert_eq!(duplicate, [4, 1]);
        let (mut volumes, mut alpha) = ([7.0; 5], [7.0; 2]);
        let (low, high) = ([0.0, 0.0], [1.0, 1.0]);
        assert_eq!(septet_voronoi_volumes(t, low.as_ptr(), high.as_ptr(), 1, volumes.as_mut_ptr()), 0);
        assert_eq!(volumes, [0.25, 0.25, 0.25, 0.25, 0.0]);
        assert_eq!(septet_voronoi_volumes(t, null(), null(), 1, volumes.as_mut_ptr()), 0);
        assert!(volumes[..4].iter().all(|volume| volume.is_infinite()));
        assert_eq!(septet_alpha(t, alpha.as_mut_ptr()), 0);
        assert_eq!(alpha, [0.5, 0.5]);
        septet_free(t);
    }
}

#[test]
fn queries_have_answers() {
    let points = [0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 4.0, 4.0];
    let t = made(&points, 2, &defaults()).unwrap();
    let queries = [1.0, 1.5, 4.0, 4.0, 5.0, 0.0, f64::NAN, 0.0];
    let (mut found, mut nearest) = ([7i64; 4], [7i64; 4]);
    // Two columns: the sum of the coordinates, and 3.
    let values = [0.0, 3.0, 4.0, 3.0, 4.0, 3.0, 8.0, 3.0];
    let mut interpolated = [7.0; 8];
    unsafe {
        assert_eq!(septet_locate(t, queries.as_ptr(), 4, 0, found.as_mut_ptr()), 0);
        assert_eq!(septet_nearest(t, queries.as_ptr(), 4, 0, nearest.as_mut_ptr()), 0);
        for method in 0..3 {
            let (values, out) = (values.as_ptr(), interpolated.as_mut_ptr());
            assert_eq!(septet_interpolate(t, values, 2, queries.as_ptr(), 4, method, -1.0, 2, out), 0);
            let expected = [2.5, 3.0, 8.0, 3.0, -1.0, -1.0, -1.0, -1.0];
            assert!(
                interpolated.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-12),
                "{interpolated:?}"
            );
        }
        let (values, out) = (values.as_ptr(), interpolated.as_mut_ptr());
        assert_eq!(septet_interpolate(t, values, 2, queries.as_ptr(), 4, 3, 0.0, 1, out), OPTION);
        assert_eq!(septet_locate(t, queries.as_ptr(), 4, 5000, found.as_mut_ptr()), OPTION);
        septet_free(t);
    }
    assert!(found[0] >= 0 && found[1] >= 0);
    assert_eq!(found[2..], [-1, -1]);
    assert_eq!(nearest, [0, 3, 1, -1]);
}

#[test]
fn null_is_refused() {
    let points = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
    let t = made(&points, 2, &defaults()).unwrap();
    let mut out = null_mut();
    unsafe {
        assert_eq!(septet_triangulate(points.as_ptr(), 3, 2, null(), null_mut()), OPTION);
        assert!(failure().0.starts_with("out is NULL"), "{:?}", failure());
        assert_eq!(septet_triangulate(null(), 3, 2, null(), &raw mut out), OPTION);
        assert!(failure().0.starts_with("points is NULL"), "{:?}", failure());
        assert_eq!(septet_cells_i32(null(), null_mut()), OPTION);
        assert_eq!(septet_cells_i32(t, null_mut()), OPTION);
        assert_eq!(septet_locate(t, null(), 1, 0, null_mut()), OPTION);
        assert_eq!(septet_locate(t, null(), 0, 0, null_mut()), 0);
        assert_eq!(septet_voronoi_volumes(t, points.as_ptr(), null(), 0, [0.0; 3].as_mut_ptr()), OPTION);
        assert_eq!((septet_cells_count(null()), septet_rank(null()), septet_dimension(null())), (0, 0, 0));
        septet_options_init(null_mut());
        septet_free(null_mut());
        septet_free(t);
    }
    assert!(out.is_null());
}

#[test]
fn bad_points_are_named() {
    let mut points = numbers(300);
    points[3 * 17 + 2] = f64::NAN;
    assert_eq!(made(&points, 3, &defaults()), Err(POINTS));
    let (text, index) = failure();
    assert!(text.contains("point 17") && text.contains("skip_invalid") && index == 17, "{text} {index}");
    let t = made(&points, 3, &Options { skip_invalid: 1, ..defaults() }).unwrap();
    assert!(!cells(t).contains(&17));
    unsafe { septet_free(t) };
    points[3 * 17 + 2] = 1e300;
    points[0] = 1e-300;
    assert_eq!(made(&points, 3, &defaults()), Err(POINTS));
    assert_eq!(failure().1, 0);
    let square = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
    let t = made(&square, 2, &defaults()).unwrap();
    let (low, high, mut volumes) = ([0.0, 0.0], [1.0, 0.5], [0.0; 3]);
    unsafe {
        assert_eq!(septet_voronoi_volumes(t, low.as_ptr(), high.as_ptr(), 0, volumes.as_mut_ptr()), POINTS);
        assert_eq!(failure().1, 2);
        assert_eq!(septet_voronoi_volumes(t, high.as_ptr(), low.as_ptr(), 0, volumes.as_mut_ptr()), OPTION);
        septet_free(t);
    }
}

#[test]
fn flat_and_empty_sets_have_no_cells() {
    let line: Vec<f64> = (0..10).flat_map(|i| [f64::from(i), 2.0 * f64::from(i), 0.0]).collect();
    for (points, rank) in [(&line[..], 1), (&line[..3], 0), (&[], -1)] {
        let t = made(points, 3, &defaults()).unwrap();
        unsafe {
            assert_eq!((septet_rank(t), septet_cells_count(t), septet_hull_count(t)), (rank, 0, 0));
            assert_eq!(septet_cells_i32(t, null_mut()), 0);
            let mut nearest = [7];
            assert_eq!(septet_nearest(t, [2.1, 4.0, 0.0].as_ptr(), 1, 0, nearest.as_mut_ptr()), 0);
            assert_eq!(nearest, [[2], [0], [-1]][(1 - rank) as usize]);
            septet_free(t);
        }
    }
    let mut t = null_mut();
    unsafe {
        assert_eq!(septet_triangulate(null(), 0, 2, null(), &raw mut t), 0);
        assert_eq!(septet_points_count(t), 0);
        septet_free(t);
    }
}

#[test]
fn dimensions_and_sizes_are_checked() {
    let points = numbers(60);
    assert_eq!(made(&points, 4, &defaults()), Err(OPTION));
    assert!(failure().0.contains("septet triangulate"), "{}", failure().0);
    assert_eq!(made(&points, 1, &defaults()), Err(OPTION));
    let mut t = null_mut();
    for n in [usize::MAX, usize::MAX / 3 + 1, isize::MAX as usize / 8] {
        let status = unsafe { septet_triangulate(points.as_ptr(), n, 3, null(), &raw mut t) };
        assert!(status == OPTION && t.is_null());
    }
    // The numbers of a box are not read before the dimension is known to be 2 or 3: this pointer is not aligned.
    let period = [1.0; 3].as_ptr().wrapping_byte_add(1);
    for dimension in [0, 1, 4, u32::MAX] {
        let options = Options { period, ..defaults() };
        let status = unsafe { septet_triangulate(null(), 0, dimension, &raw const options, &raw mut t) };
        assert!(status == OPTION && t.is_null() && failure().0.contains("coordinates"), "{}", failure().0);
    }
    assert_eq!(made(&points, 3, &Options { reserved: 1, ..defaults() }), Err(OPTION));
    assert!(failure().0.contains("reserved is 1"), "{}", failure().0);
    for size in [0, 7, size_of::<Options>() + 8] {
        assert_eq!(made(&points, 3, &Options { size, ..defaults() }), Err(OPTION));
        assert!(failure().0.contains("septet_options_init"), "{}", failure().0);
    }
    // A program that was built when the options ended before `skip_invalid`.
    let size = offset_of!(Options, skip_invalid);
    let t = made(&points, 3, &Options { size, skip_invalid: 77, ..defaults() }).unwrap();
    unsafe { septet_free(t) };
    assert_eq!(made(&points, 3, &Options { skip_invalid: 77, ..defaults() }), Err(OPTION));
    assert_eq!(made(&points, 3, &Options { threads: u32::MAX, ..defaults() }), Err(OPTION));
    assert_eq!(made(&points, 3, &Options { max_memory: 1, ..defaults() }), Err(LIMIT));
    assert!(failure().0.contains("raise max_memory"), "{}", failure().0);
}

#[test]
fn threads_do_not_matter() {
    let points = numbers(3 * 4000);
    let expected = {
        let t = made(&points, 3, &Options { threads: 1, ..defaults() }).unwrap();
        let all = cells(t);
        unsafe { septet_free(t) };
        all
    };
    // Two threads use the library at the same time, and share a triangulation.
    let shared = made(&points, 3, &Options { threads: 4, seed: 5, ..defaults() }).unwrap() as usize;
    thread::scope(|scope| {
        for threads in [1, 4] {
            let (points, expected) = (&points, &expected);
            scope.spawn(move || {
                let t = made(points, 3, &Options { threads, ..defaults() }).unwrap();
                assert_eq!(&cells(t), expected);
                assert_eq!(&cells(shared as *const Handle), expected);
                let (mut found, mut nearest) = (vec![7; 4000], vec![7; 4000]);
                unsafe {
                    assert_eq!(septet_locate(t, points.as_ptr(), 4000, threads, found.as_mut_ptr()), 0);
                    assert_eq!(septet_nearest(t, points.as_ptr(), 4000, threads, nearest.as_mut_ptr()), 0);
                    septet_free(t);
                }
                assert!(found.iter().all(|&cell| cell >= 0) && nearest.iter().copied().eq(0..4000));
            });
        }
    });
    unsafe { septet_free(shared as *mut Handle) };
}

#[test]
fn another_thread_ends_a_call() {
    let points = numbers(3 * 400_000);
    for threads in [1, 2] {
        let cancel = AtomicI32::new(0);
        let options = Options { threads, cancel: cancel.as_ptr(), ..defaults() };
        let stored = thread::scope(|scope| {
            let canceller = scope.spawn(|| {
                thread::sleep(Duration::from_millis(150));
                cancel.store(1, Ordering::Release);
                Instant::now()
            });
            assert_eq!(made(&points, 3, &options), Err(CANCELLED));
            canceller.join().unwrap()
        });
        let waited = stored.elapsed();
        assert!(waited < Duration::from_secs(1), "{threads} threads: {waited:?}");
        assert_eq!(failure(), ("interrupted".to_owned(), -1));
        // The flag is still set.
        assert_eq!(made(&points[..30], 3, &options), Err(CANCELLED));
        cancel.store(0, Ordering::Release);
        let t = made(&points[..30], 3, &options).unwrap();
        unsafe { septet_free(t) };
    }
}

#[test]
fn versions_are_those_of_the_header() {
    let version = unsafe { CStr::from_ptr(septet_version()) };
    assert_eq!((version.to_str(), septet_abi()), (Ok(env!("CARGO_PKG_VERSION")), 1));
}

#[test]
fn weights_hide_points() {
    // The last ball lies in the others.
    let points = [0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.5, 0.5];
    let weights = [4.0, 1.0, 1.0, 0.01];
    let with = |weights: &[f64]| Options { weights: weights.as_ptr(), ..defaults() };
    let t = made(&points, 2, &with(&weights)).unwrap();
    let (low, high, mut volumes) = ([-1.0, -1.0], [3.0, 3.0], [7.0; 4]);
    let (mut found, mut hidden) = ([7], [7]);
    unsafe {
        assert_eq!((septet_cells_count(t), septet_hidden_count(t), septet_is_simplicial(t)), (1, 1, 1));
        assert_eq!((septet_hidden(t, hidden.as_mut_ptr()), hidden), (0, [3]));
        assert_eq!((septet_locate(t, points[6..].as_ptr(), 1, 1, found.as_mut_ptr()), found), (0, [0]));
        assert_eq!(septet_voronoi_volumes(t, low.as_ptr(), high.as_ptr(), 1, volumes.as_mut_ptr()), 0);
        assert!((volumes.iter().sum::<f64>() - 16.0).abs() < 1e-12 && volumes[3] == 0.0, "{volumes:?}");
        assert_eq!(septet_voronoi_volumes(t, null(), null(), 1, volumes.as_mut_ptr()), OPTION);
        assert!(failure().0.contains("low and high"), "{}", failure().0);
        assert_eq!(septet_nearest(t, points.as_ptr(), 1, 1, found.as_mut_ptr()), OPTION);
        let (text, _) = failure();
        assert!(
            text.contains("septet_nearest")
                && text.contains("use septet_cells_i32, septet_cells_i64")
                && text.contains("septet_locate"),
            "{text}"
        );
        assert_eq!(septet_offsets(t, null_mut()), OPTION);
        assert_eq!(septet_sheets(t, null_mut()), OPTION);
        septet_free(t);
    }
    assert_eq!(made(&points, 2, &with(&[1.0, f64::NAN, 1.0, 1.0])), Err(POINTS));
    assert_eq!(failure().1, 1);
    // A program that was built before there were weights.
    let old = Options { size: offset_of!(Options, weights), ..with(&weights) };
    let t = made(&points, 2, &old).unwrap();
    unsafe {
        assert_eq!((septet_cells_count(t), septet_hidden_count(t)), (3, 0));
        septet_free(t);
    }
}

#[test]
fn a_periodic_box_has_offsets() {
    let points = [0.5, 0.25];
    let (period, origin) = ([1.0, 2.0], [0.0, -1.0]);
    let with = Options { period: period.as_ptr(), origin: origin.as_ptr(), ..defaults() };
    let t = made(&points, 2, &with).unwrap();
    let (mut cells, mut next, mut offsets) = ([7i32; 6], [7i32; 6], [7i32; 12]);
    let (mut sheets, mut volumes) = ([7u32; 2], [7.0; 1]);
    unsafe {
        assert_eq!((septet_cells_count(t), septet_is_simplicial(t), septet_hull_count(t)), (2, 0, 0));
        assert_eq!((septet_cells_i32(t, cells.as_mut_ptr()), cells), (0, [0; 6]));
        assert_eq!((septet_neighbors_i32(t, next.as_mut_ptr()), next), (0, [1, 1, 1, 0, 0, 0]));
        assert_eq!(septet_offsets(t, offsets.as_mut_ptr()), 0);
        assert_eq!((septet_sheets(t, sheets.as_mut_ptr()), sheets), (0, [3, 3]));
        assert_eq!(septet_voronoi_volumes(t, null(), null(), 1, volumes.as_mut_ptr()), 0);
        assert_eq!(
            septet_voronoi_volumes(t, points.as_ptr(), points.as_ptr(), 1, volumes.as_mut_ptr()),
            OPTION
        );
        assert!(failure().0.contains("pass NULL for low and high"), "{}", failure().0);
        assert_eq!(septet_locate(t, points.as_ptr(), 1, 1, [7].as_mut_ptr()), OPTION);
        assert!(failure().0.contains("septet_offsets"), "{}", failure().0);
        septet_free(t);
    }
    // Each cell is half of a box.
    for cell in offsets.chunks(6) {
        let [a, b] = [[cell[2], cell[3]], [cell[4], cell[5]]];
        assert_eq!((&cell[..2], (a[0] * b[1] - a[1] * b[0])), (&[0, 0][..], 1));
    }
    assert!((volumes[0] - 2.0).abs() < 1e-12, "{volumes:?}");
    let outside = Options { period: period.as_ptr(), ..defaults() };
    assert_eq!(made(&[0.5, -0.25], 2, &outside), Err(POINTS));
    assert!(failure().1 == 0 && failure().0.contains("wrap"), "{:?}", failure());
    let t = made(&[0.5, -0.25], 2, &Options { wrap: 1, ..outside }).unwrap();
    unsafe { septet_free(t) };
    assert_eq!(made(&points, 2, &Options { wrap: 2, ..with }), Err(OPTION));
    assert_eq!(made(&points, 2, &Options { period: null(), ..with }), Err(OPTION));
    assert!(failure().0.contains("set period"), "{}", failure().0);
}
