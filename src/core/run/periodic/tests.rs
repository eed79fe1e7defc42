//! Periodic triangulations compared with plain triangulations of many images.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use septet_geometry::coordinates::Coordinates;
use septet_geometry::hash::Draw;
use septet_geometry::point::{Point, Position, lex_cmp};
use septet_geometry::site::Weighted;

use crate::error::{Error, PeriodicError};
use crate::result::outcome::Outcome;
use crate::result::periodic::PeriodicCells;
use crate::run::calls::triangulate;
use crate::spec::{Periodic, Spec, Workers};

fn spec(lengths: &[f64], workers: u32) -> Spec {
    let mut spec = Spec::default();
    spec.input.periodic = Some(Periodic::of_lengths(lengths));
    spec.machine.workers = Workers::Count(workers);
    spec
}

fn part(run: &Outcome) -> &PeriodicCells {
    run.kept.periodic.as_ref().expect("a periodic run")
}

/// A class of cells: its vertices as rows and offsets, moved so that the first offset of the least list is 0, and sorted.
type Class = Vec<(u64, Vec<i32>)>;

fn class(cell: &[(u64, Vec<i32>)]) -> Class {
    let all = cell.iter().map(|(_, by)| {
        let minus = |offset: &Vec<i32>| offset.iter().zip(by).map(|(a, b)| a - b).collect::<Vec<i32>>();
        let mut moved: Class = cell.iter().map(|(row, offset)| (*row, minus(offset))).collect();
        moved.sort();
        moved
    });
    all.min().expect("a cell has vertices")
}

/// The classes of the cells of a run.
fn classes(run: &Outcome, dimension: usize) -> BTreeSet<Class> {
    let corners = dimension + 1;
    let offsets = part(run).offsets();
    let offsets = offsets.chunks_exact(corners * dimension);
    let cells = run.cells().chunks_exact(corners).zip(offsets);
    cells
        .map(|(rows, offsets)| {
            let vertices = rows.iter().zip(offsets.chunks_exact(dimension));
            class(&vertices.map(|(row, offset)| (*row, offset.to_vec())).collect::<Vec<_>>())
        })
        .collect()
}

/// The classes of the cells that touch the box, by a plain triangulation of `5^d` images. All sums are exact.
fn expected<P: Position>(sites: &[Weighted<P>], lengths: &[f64]) -> BTreeSet<Class> {
    let (mut images, mut of) = (Vec::new(), Vec::new());
    for code in 0..5usize.pow(P::DIM as u32) {
        let steps: Vec<i32> = (0..P::DIM).map(|i| (code / 5usize.pow(i as u32) % 5) as i32 - 2).collect();
        for (row, site) in sites.iter().enumerate() {
            let mut at = site.position();
            for (i, &k) in steps.iter().enumerate() {
                let moved = at.coord(i) + f64::from(k) * lengths[i];
                assert_eq!(moved - f64::from(k) * lengths[i], at.coord(i), "an exact sum");
                at.set_coord(i, moved);
            }
            images.push(Weighted::new(at, site.weight()));
            of.push((row as u64, steps.clone()));
        }
    }
    let run = triangulate(&images, &Spec::default()).unwrap();
    let cells = run.cells().chunks_exact(P::DIM + 1);
    let touching = cells.filter(|cell| cell.iter().any(|&v| of[v as usize].1.iter().all(|&k| k == 0)));
    touching.map(|cell| class(&cell.iter().map(|&v| of[v as usize].clone()).collect::<Vec<_>>())).collect()
}

/// Distinct sites on a grid of `side` nodes for each length, with small weights or none.
fn sites<P: Position>(n: usize, side: usize, weight: f64, lengths: &[f64], seed: u64) -> Vec<Weighted<P>> {
    let mut draw = Draw::new(seed);
    let mut all: Vec<Weighted<P>> = Vec::new();
    for _ in 0..n {
        let mut at = P::default();
        for (i, length) in lengths.iter().enumerate() {
            at.set_coord(i, draw.below(side) as f64 / side as f64 * length);
        }
        all.push(Weighted::new(at, weight * draw.below(3) as f64));
    }
    all.sort_by(lex_cmp);
    all.dedup_by(|a, b| lex_cmp(a, b).is_eq());
    draw.shuffle(&mut all);
    all
}

fn agrees_with_many_images<P: Position>(sizes: &[usize], lengths: &[f64]) {
    for &n in sizes {
        for side in [4, 16, 1 << 12] {
            for weight in [0.0, 0.03125, 1.0] {
                let sites = sites::<P>(n, side, weight, lengths, n as u64);
                let expected = expected(&sites, lengths);
                for workers in [1, 3] {
                    let run = triangulate(&sites, &spec(lengths, workers)).unwrap();
                    let what = format!("{n} sites of {side}, weights {weight}, {workers} workers");
                    assert!(classes(&run, P::DIM) == expected, "{what}");
                    assert_eq!(run.cells().len(), expected.len() * (P::DIM + 1), "{what}");
                    let rows: BTreeSet<u64> = run.cells().iter().copied().collect();
                    let hidden = run.left_out.hidden.len();
                    assert_eq!((rows.len() + hidden) as u64, run.points.input, "{what}");
                    assert_eq!(run.points.used, rows.len() as u64, "{what}");
                }
            }
        }
    }
}

#[test]
fn the_plane_agrees_with_many_images() {
    agrees_with_many_images::<DVec2>(&[1, 2, 3, 5, 9, 40, 300], &[1.0, 2.0]);
}

#[test]
fn space_agrees_with_many_images() {
    agrees_with_many_images::<DVec3>(&[1, 2, 3, 7, 30], &[1.0, 2.0, 1.0]);
}

/// Without weights, no site is hidden, and the Euler characteristic of a torus is 0.
#[test]
fn sums_that_are_rounded_are_exact() {
    let mut draw = Draw::new(5);
    let lengths = [0.3, 0.7, 0.1];
    for n in [1usize, 4, 60, 900] {
        let points: Vec<[f64; 3]> = (0..n).map(|_| lengths.map(|length| draw.unit() * length)).collect();
        let run = triangulate(&points, &spec(&lengths, 1)).unwrap();
        let again = triangulate(&points, &spec(&lengths, 4)).unwrap();
        assert_eq!((run.cells(), part(&run).offsets()), (again.cells(), part(&again).offsets()));
        let flat: Vec<[f64; 2]> = points.iter().map(|&[x, y, _]| [x, y]).collect();
        let plane = triangulate(&flat, &spec(&lengths[..2], 2)).unwrap();
        assert_eq!(plane.cell_count(), 2 * n);
        assert_eq!((run.points.used, plane.points.used), (n as u64, n as u64));
        let few = n < 10;
        assert_eq!(part(&run).is_simplicial, !few && part(&run).sheets == [1, 1, 1]);
        assert!(!few || part(&run).sheets.iter().product::<u32>() > 1);
    }
}

/// A translation of the box, and of points out of it, changes no class.
#[test]
fn the_origin_does_not_matter() {
    let lengths = [1.0, 2.0];
    let sites = sites::<DVec2>(50, 1 << 10, 0.0, &lengths, 3);
    let points: Vec<DVec2> = sites.iter().map(|site| site.position()).collect();
    let first = triangulate(&points, &spec(&lengths, 1)).unwrap();
    let mut other = spec(&lengths, 2);
    let periodic = other.input.periodic.as_mut().unwrap();
    (periodic.origin, periodic.wrap) = (vec![-17.25, 0.5], true);
    let second = triangulate(&points, &other).unwrap();
    assert_eq!(first.cells(), second.cells());
    assert_eq!(part(&first).offsets(), part(&second).offsets());
    let refused = triangulate(
        &points,
        &other.with(|spec| {
            spec.input.periodic.as_mut().unwrap().wrap = false;
        }),
    );
    assert!(matches!(refused, Err(Error::Periodic(PeriodicError::Outside { index: 0, others: 49, .. }))));
}

fn error<C: Coordinates>(points: &[C], lengths: &[f64]) -> PeriodicError {
    match triangulate(points, &spec(lengths, 1)) {
        Err(Error::Periodic(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn boxes_that_cannot_be_used_are_refused() {
    let points = [[0.25, 0.5], [0.5, 0.75]];
    assert!(matches!(error(&points, &[1.0]), PeriodicError::Dimension { given: 1, dimension: 2, .. }));
    assert!(matches!(error(&points, &[1.0, 0.0]), PeriodicError::Number { .. }));
    assert!(matches!(error(&points, &[1.0, f64::NAN]), PeriodicError::Number { .. }));
    assert!(matches!(error(&points, &[1.0, 0.7]), PeriodicError::Outside { index: 1, others: 0, .. }));
    // The upper face is that of the lower one.
    let run = triangulate(&[[0.25, 0.5], [0.25, 1.5], [1.25, 0.5]], &spec(&[1.25, 1.5], 1)).unwrap();
    assert_eq!((run.points.duplicate, run.points.used), (0, 3));
    let run = triangulate(&[[0.0, 0.5], [1.25, 0.5]], &spec(&[1.25, 1.5], 1)).unwrap();
    assert_eq!(run.left_out.duplicates, [(1, 0)]);
}

/// Along an axis that is not periodic, the box does not end.
#[test]
fn some_axes_may_be_open() {
    let sites = sites::<DVec2>(40, 1 << 10, 0.0, &[1.0, 1.0], 8);
    let points: Vec<DVec2> = sites.iter().map(|site| site.position()).collect();
    let mut spec = spec(&[1.0, 1.0], 2);
    spec.input.periodic.as_mut().unwrap().lengths[1] = None;
    let run = triangulate(&points, &spec).unwrap();
    let of_row = |v: u64, k: i32| points[v as usize] + DVec2::X * f64::from(k);
    let mut strip: Vec<DVec2> = Vec::new();
    for k in -3..=3 {
        strip.extend((0..points.len()).map(|v| of_row(v as u64, k)));
    }
    let plain = triangulate(&strip, &Spec::default()).unwrap();
    let n = points.len() as u64;
    let classes_of_strip: BTreeSet<Class> = plain
        .cells()
        .chunks_exact(3)
        .filter(|cell| cell.iter().any(|&v| v / n == 3))
        .map(|cell| class(&cell.iter().map(|&v| (v % n, vec![(v / n) as i32 - 3, 0])).collect::<Vec<_>>()))
        .collect();
    assert!(classes(&run, 2) == classes_of_strip);
}

/// Points in a plane of the box, so sparse along one axis that the first images are flat.
#[test]
fn layers_have_cells() {
    let mut draw = Draw::new(9);
    let points: Vec<[f64; 3]> = (0..300).map(|_| [draw.unit(), draw.unit(), 0.5]).collect();
    let run = triangulate(&points, &spec(&[1.0; 3], 2)).unwrap();
    // The prism between a triangle and its image has three tetrahedra.
    assert_eq!(run.cell_count(), 3 * 600);
    let line: Vec<[f64; 2]> = points.iter().map(|&[x, _, y]| [x, y]).collect();
    assert_eq!(triangulate(&line, &spec(&[1.0; 2], 1)).unwrap().cell_count(), 600);
}

/// Powers of two change nothing, wherever the exponents are.
#[test]
fn scales_do_not_matter() {
    let mut draw = Draw::new(11);
    let points: Vec<[f64; 2]> = (0..90).map(|_| [draw.unit(), draw.unit().powi(6)]).collect();
    let first = triangulate(&points, &spec(&[1.0; 2], 1)).unwrap();
    for exponent in [-900, -400, -200, 150, 400, 900] {
        let factor = 2f64.powi(exponent);
        let scaled: Vec<[f64; 2]> = points.iter().map(|point| point.map(|x| x * factor)).collect();
        let run = triangulate(&scaled, &spec(&[factor; 2], 3)).unwrap();
        assert_eq!(
            (run.cells(), part(&run).offsets()),
            (first.cells(), part(&first).offsets()),
            "{exponent}"
        );
        assert_eq!(part(&run).images, part(&first).images);
    }
    let far = [[1e-200, 0.5], [0.25, 0.5]];
    assert!(matches!(error(&far, &[1.0, 1.0]), PeriodicError::Spread { .. }));
}

#[test]
fn negative_zeros_are_zeros() {
    let signs = [-0.0, 0.0].map(|zero: f64| {
        let points = [[zero, 0.05], [0.0, 0.97], [0.3, 0.4], [0.6, 0.7]];
        let mut spec = spec(&[1.0; 2], 1);
        spec.input.periodic.as_mut().unwrap().wrap = true;
        let run = triangulate(&points, &spec).unwrap();
        assert_eq!(run.cell_count(), 8);
        (run.cells().to_vec(), part(&run).offsets())
    });
    assert_eq!(signs[0], signs[1]);
}

/// One site in a square or a cube is joined to its opposite images, so two boxes join it twice to the other.
#[test]
fn a_lattice_needs_three_boxes() {
    let one = triangulate(&[[0.25, 0.75]], &spec(&[1.0; 2], 1)).unwrap();
    assert_eq!(part(&one).sheets, [3, 3]);
    let one = triangulate(&[[0.25, 0.75, 0.5]], &spec(&[1.0; 3], 1)).unwrap();
    assert_eq!(part(&one).sheets, [3, 3, 3]);
    let nodes: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3)]).collect();
    let whole = triangulate(&nodes, &spec(&[3.0; 2], 1)).unwrap();
    assert!(part(&whole).is_simplicial && part(&whole).sheets == [1, 1]);
}

/// Sites many lengths away from the box, on both sides.
#[test]
fn offsets_may_be_large() {
    let mut wrapped = spec(&[1.0; 2], 1);
    wrapped.input.periodic.as_mut().unwrap().wrap = true;
    let (near, far) = ([[0.5, 0.25], [0.75, 0.5]], [[600_000.5, 0.25], [-599_999.25, 0.5]]);
    let [near, far] = [near, far].map(|points| triangulate(&points, &wrapped).unwrap());
    assert_eq!(near.cells(), far.cells());
    let moved = part(&near).offsets().into_iter().zip(part(&far).offsets());
    let shifts: BTreeSet<i32> = moved.map(|(near, far)| far - near).collect();
    assert_eq!(shifts, BTreeSet::from([0, 1_200_000]));
}
