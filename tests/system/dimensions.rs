//! Dimensions 4 to 6: cells agree with a search by definition, and with Qhull.
//!
//! `SEPTET_SETS=10000 cargo test --release --features dimensions --test system dimensions::` searches 10,000 sets (default: 60).
//!
//! The search uses integers only, and no code of septet. It tests every simplex of points against every point.

use std::collections::BTreeSet;
use std::process::Command;

use septet_core::generate::{Kind, Request, generate};
use septet_core::model::{HigherPoints, Points};
use septet_core::spec::{Alpha, Graph, Spec, Workers};
use septet_core::{Outcome, simulate, triangulate};
use septet_geometry::higher::VecN;
use septet_geometry::point::Point;

use super::oracle::{python, run_checker, source};
use crate::common::sets::Draw;
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{base, with_workers};

/// A point with coordinates of at most 1,000.
type Site<const D: usize> = [i64; D];

/// Returns the determinant of the differences from the first point to the others.
fn volume<const D: usize>(simplex: &[Site<D>]) -> i128 {
    let rows: Vec<Vec<i128>> = simplex[1..]
        .iter()
        .map(|p| (0..D).map(|axis| i128::from(p[axis] - simplex[0][axis])).collect())
        .collect();
    determinant(&rows)
}

fn determinant(rows: &[Vec<i128>]) -> i128 {
    let Some((first, rest)) = rows.split_first() else { return 1 };
    let without = |column: usize| -> Vec<Vec<i128>> {
        let keep = |row: &Vec<i128>| [&row[..column], &row[column + 1..]].concat();
        rest.iter().map(keep).collect()
    };
    let term = |(column, &x): (usize, &i128)| {
        let minor = if x == 0 { 0 } else { determinant(&without(column)) };
        if column % 2 == 0 { x * minor } else { -x * minor }
    };
    first.iter().enumerate().map(term).sum()
}

/// Whether the lift of a point lies below the hyperplane through the lifts of a simplex. The height over it is a sum over all
/// these points: squared length times volume of the simplex of the others. If it is zero, the largest point with a volume
/// decides, because an infinitesimal raises larger points more.
fn is_below<const D: usize>(simplex: &[Site<D>], point: &Site<D>) -> bool {
    let all = [simplex, &[*point]].concat();
    let sign = volume(simplex).signum();
    let mut terms: Vec<(Site<D>, i128)> = (0..all.len())
        .map(|i| {
            let others = [&all[..i], &all[i + 1..]].concat();
            let turned = if (all.len() - 1 - i) % 2 == 0 { sign } else { -sign };
            (all[i], turned * volume(&others))
        })
        .collect();
    let square = |p: &Site<D>| p.iter().map(|&x| i128::from(x * x)).sum::<i128>();
    let height: i128 = terms.iter().map(|(p, coefficient)| square(p) * coefficient).sum();
    if height != 0 {
        return height < 0;
    }
    terms.sort_unstable();
    terms.iter().rev().find(|(_, coefficient)| *coefficient != 0).is_some_and(|(_, last)| *last < 0)
}

/// Returns the cells by definition, as sorted rows. Of several points at one place the first counts.
fn search<const D: usize>(points: &[Site<D>]) -> BTreeSet<Vec<u64>> {
    let rows: Vec<usize> = (0..points.len()).filter(|&i| !points[..i].contains(&points[i])).collect();
    let (mut cells, mut picks) = (BTreeSet::new(), vec![Vec::new()]);
    while let Some(pick) = picks.pop() {
        if pick.len() <= D {
            let next = pick.last().map_or(0, |last| last + 1);
            picks.extend((next..rows.len()).map(|at| [&pick[..], &[at]].concat()));
            continue;
        }
        let simplex: Vec<Site<D>> = pick.iter().map(|&at| points[rows[at]]).collect();
        let is_empty =
            || (0..rows.len()).all(|at| pick.contains(&at) || !is_below(&simplex, &points[rows[at]]));
        if volume(&simplex) != 0 && is_empty() {
            cells.insert(pick.iter().map(|&at| rows[at] as u64).collect());
        }
    }
    cells
}

const KINDS: [&str; 6] = ["random", "coarse", "corners of a cube", "cross polytope", "flat", "repeated"];

fn set<const D: usize>(kind: &str, draw: &mut Draw) -> Vec<Site<D>> {
    let count = D + 2 + draw.below(5);
    let mut points = |range: usize| -> Vec<Site<D>> {
        (0..count).map(|_| std::array::from_fn(|_| draw.below(range) as i64)).collect()
    };
    match kind {
        "random" => points(1000),
        "coarse" => points(3),
        "corners of a cube" => points(2),
        "cross polytope" => {
            let unit = |axis: usize, x: i64| std::array::from_fn(|i| if i == axis { x } else { 0 });
            let corners = (0..D).flat_map(|axis| [unit(axis, 1), unit(axis, -1)]);
            corners.chain([[0; D]]).collect()
        }
        "flat" => {
            let mut flat = points(4);
            for p in &mut flat {
                p[D - 1] = p[0] + p[1];
            }
            flat
        }
        "repeated" => {
            let once = points(20);
            [&once[..], &once[..3]].concat()
        }
        other => unreachable!("no set is {other}"),
    }
}

fn of_sites<const D: usize>(sites: &[Site<D>]) -> Vec<VecN<D>> {
    sites.iter().map(|site| VecN(site.map(|x| x as f64))).collect()
}

fn sorted_cells(run: &Outcome) -> BTreeSet<Vec<u64>> {
    let sorted = |cell: &[u64]| {
        let mut cell = cell.to_vec();
        cell.sort_unstable();
        cell
    };
    run.cells().chunks_exact(run.space + 1).map(sorted).collect()
}

/// Compares runs with the search, over one or all transports, and with a run of permuted rows.
fn compare<const D: usize>(what: &str, sites: &[Site<D>], draw: &mut Draw, everywhere: bool)
where
    VecN<D>: Point,
{
    let (expected, points) = (search(sites), of_sites(sites));
    let mut first: Option<Vec<u64>> = None;
    for workers in [1, 3, 8] {
        let spec = with_workers(Workers::Count(workers), 4);
        let mut check = |start: TestTransport| {
            for counted in [false, true] {
                let what = format!("{what}, d = {D}, {start:?}, {workers} workers, counted {counted}");
                let run = start.run(&points, &spec, counted).unwrap_or_else(|e| panic!("{what}: {e}"));
                assert_eq!(sorted_cells(&run), expected, "{what}: {sites:?}");
                let bytes = first.get_or_insert_with(|| run.cells().to_vec());
                assert!(bytes == run.cells(), "{what}: other bytes");
            }
        };
        if everywhere { each_transport(check) } else { check(TestTransport::Sim(workers.into())) }
    }
    let mut order: Vec<usize> = (0..sites.len()).collect();
    draw.shuffle(&mut order);
    let permuted: Vec<VecN<D>> = order.iter().map(|&i| points[i]).collect();
    let run = simulate(&permuted, &base()).unwrap();
    let place = |row: &u64| sites[order[*row as usize]];
    let cells: BTreeSet<Vec<Site<D>>> =
        sorted_cells(&run).iter().map(|cell| as_places(cell, place)).collect();
    let wanted = expected.iter().map(|cell| as_places(cell, |row| sites[*row as usize])).collect();
    assert_eq!(cells, wanted, "{what}, d = {D}: permuted rows");
}

fn as_places<const D: usize>(cell: &[u64], place: impl Fn(&u64) -> Site<D>) -> Vec<Site<D>> {
    let mut places: Vec<Site<D>> = cell.iter().map(place).collect();
    places.sort_unstable();
    places
}

#[test]
fn small_sets_agree_with_the_definition() {
    let sets: usize = std::env::var("SEPTET_SETS").map_or(60, |n| n.parse().expect("a number"));
    for i in 0..sets {
        let mut draw = Draw::new(5100 + i as u64);
        let kind = KINDS[i / 3 % KINDS.len()];
        let (what, everywhere) = (format!("set {i}, {kind}"), i % 30 < 3);
        match i % 3 {
            0 => compare::<4>(&what, &set(kind, &mut draw), &mut draw, everywhere),
            1 => compare::<5>(&what, &set(kind, &mut draw), &mut draw, everywhere),
            _ => compare::<6>(&what, &set(kind, &mut draw), &mut draw, everywhere),
        }
    }
}

/// Points that do not span the space have no cells, and this is no error.
#[test]
fn flat_sets_have_no_cells() {
    let flat: Vec<[f64; 4]> =
        (0..40).map(|i| [f64::from(i), f64::from(i * i), f64::from(i % 7), 2.0]).collect();
    let run = simulate(&flat, &Spec::default()).unwrap();
    assert_eq!((run.facts.cells, run.space, run.facts.dimension), (0, 4, 3));
    assert!(triangulate(&flat, &Spec::default()).unwrap().cells().is_empty());
}

/// If splaying may not continue, rank 0 gathers the open stars, and builds them among all their neighbours.
#[test]
fn open_stars_are_gathered() {
    let request =
        Request { kind: Kind::Uniform, n: 150, dimension: 4, seed: 9, lipschitz: None, ratio: None };
    let Points::Higher(HigherPoints::Four(points)) = generate(&request, &mut |_, _, _| {}).unwrap().points
    else {
        unreachable!("the dimension is 4")
    };
    let plain = simulate(&points, &with_workers(Workers::Count(3), 20)).unwrap();
    let mut gathered = 0;
    for counted in [false, true] {
        let spec = with_workers(Workers::Count(3), 20).with(|c| {
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(1.0) };
            c.planted.exchange_cap = Some(1);
        });
        let run = TestTransport::Sim(3).run(&points, &spec, counted).unwrap();
        gathered += usize::from(run.fallback.is_some());
        assert!(run.cells() == plain.cells(), "counted {counted}");
    }
    assert!(gathered > 0);
}

fn by_qhull<P: Point>(points: &[P], what: &str) {
    for counted in [false, true] {
        let run =
            TestTransport::Channel(2).run(points, &with_workers(Workers::Count(3), 300), counted).unwrap();
        let mut command = Command::new(python());
        command.arg(source("scipy_check.py"));
        run_checker(command, points, &run, false, what);
    }
}

#[test]
#[ignore = "needs Python with numpy and scipy"]
fn cells_agree_with_qhull() {
    for kind in [Kind::Uniform, Kind::Ball] {
        for (dimension, n) in [(4, 2000), (5, 500), (6, 300)] {
            let request = Request { kind, n, dimension, seed: 6, lipschitz: None, ratio: None };
            match generate(&request, &mut |_, _, _| {}).unwrap().points {
                Points::Higher(HigherPoints::Four(points)) => by_qhull(&points, kind.name()),
                Points::Higher(HigherPoints::Five(points)) => by_qhull(&points, kind.name()),
                Points::Higher(HigherPoints::Six(points)) => by_qhull(&points, kind.name()),
                Points::Plane(_) | Points::Space(_) => unreachable!("the dimension is above 3"),
            }
        }
    }
}
