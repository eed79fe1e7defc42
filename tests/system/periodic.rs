//! Points in periodic boxes, with and without weights: cells, offsets, hidden points and duplicates agree with a search by
//! definition.
//!
//! `SEPTET_SETS=10000 cargo test --release --test system periodic::` searches 10,000 sets (default: 100).
//!
//! `SEPTET_SITES` is the number of points of each comparison with CGAL (default: 5,000).
//!
//! The search uses integers only, and no code of septet. The vertices of a cell with a vertex in the box are at most one box
//! away from it. Each such simplex of sites is tested against all images at most two boxes away.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use glam::{DVec2, DVec3};
use septet_core::spec::{Periodic, Workers};
use septet_core::{Outcome, simulate, triangulate};
use septet_geometry::point::{Point, Position};
use septet_geometry::site::Weighted;

use super::oracle::cgal;
use super::weights::{Site, above, contains, rows, volume};
use crate::common::sets::Draw;
use crate::common::{verified, with_workers, within};

/// Seconds after which a run of a few points has hung.
const PATIENCE: u64 = 60;

/// A cell up to translations: its vertices as rows and offsets, moved by the offset that makes the sorted list least.
type Class = Vec<(u64, Vec<i64>)>;

/// The periodic triangulation of some sites, by definition.
#[derive(Debug, PartialEq, Eq)]
struct Expected {
    cells: BTreeSet<Class>,
    hidden: Vec<u64>,
    duplicates: Vec<(u64, u64)>,
}

fn class(cell: &[(u64, Vec<i64>)]) -> Class {
    let moved = |by: &[i64]| {
        let minus = |offset: &[i64]| offset.iter().zip(by).map(|(a, b)| a - b).collect::<Vec<i64>>();
        let mut all: Class = cell.iter().map(|(row, offset)| (*row, minus(offset))).collect();
        all.sort();
        all
    };
    cell.iter().map(|(_, offset)| moved(offset)).min().expect("a cell has vertices")
}

/// The sites that count: the first of the heaviest ones at each position of the box.
fn kept<const D: usize>(sites: &[Site<D>], lengths: [i64; D], expected: &mut Expected) -> Vec<usize> {
    let mut places: BTreeMap<[i64; D], Vec<usize>> = BTreeMap::new();
    for (i, (place, _)) in sites.iter().enumerate() {
        let base = std::array::from_fn(|axis| place[axis].rem_euclid(lengths[axis]));
        places.entry(base).or_default().push(i);
    }
    let mut kept = Vec::new();
    for group in places.values() {
        let heaviest = group.iter().map(|&i| sites[i].1).max().expect("a group has a site");
        let first = *group.iter().find(|&&i| sites[i].1 == heaviest).expect("it has the heaviest");
        kept.push(first);
        for &i in group.iter().filter(|&&i| i != first) {
            if sites[i].1 == heaviest {
                expected.duplicates.push((i as u64, first as u64));
            } else {
                expected.hidden.push(i as u64);
            }
        }
    }
    expected.duplicates.sort_unstable();
    kept
}

/// The image of a site: its row, its offset from the given point, and the site.
type Image<const D: usize> = (u64, Vec<i64>, Site<D>);

/// Returns the images in the box and at most `most` boxes away, those in the box first.
fn images<const D: usize>(sites: &[Site<D>], kept: &[usize], lengths: [i64; D], most: i64) -> Vec<Image<D>> {
    let mut steps: Vec<Vec<i64>> = vec![Vec::new()];
    for _ in 0..D {
        steps = steps.iter().flat_map(|s| (-most..=most).map(move |k| [&s[..], &[k]].concat())).collect();
    }
    steps.sort_by_key(|steps| steps.iter().any(|&k| k != 0));
    let image = |steps: &Vec<i64>, row: usize| {
        let (place, weight) = sites[row];
        let base = std::array::from_fn::<i64, D, _>(|axis| place[axis].rem_euclid(lengths[axis]));
        let at = std::array::from_fn(|axis| base[axis] + steps[axis] * lengths[axis]);
        let offset = (0..D).map(|axis| (at[axis] - place[axis]) / lengths[axis]).collect();
        (row as u64, offset, (at, weight))
    };
    steps.iter().flat_map(|steps| kept.iter().map(move |&row| image(steps, row))).collect()
}

fn search<const D: usize>(sites: &[Site<D>], lengths: [i64; D]) -> Expected {
    let mut expected = Expected { cells: BTreeSet::new(), hidden: Vec::new(), duplicates: Vec::new() };
    let kept = kept(sites, lengths, &mut expected);
    let (near, far) = (images(sites, &kept, lengths, 1), images(sites, &kept, lengths, 2));
    let mut concealed = BTreeSet::new();
    let has_weights = sites.iter().any(|(_, weight)| *weight != 0);
    for row in rows(near.len(), D + 1) {
        // The images in the box come first.
        if row[0] >= kept.len() {
            break;
        }
        let simplex: Vec<&Site<D>> = row.iter().map(|&i| &near[i].2).collect();
        if volume(&simplex) == 0 {
            continue;
        }
        let is_corner = |site: &Site<D>| simplex.iter().any(|corner| corner.0 == site.0);
        let is_above = |image: &Image<D>| is_corner(&image.2) || above(&simplex, &image.2)[1].is_gt();
        if far.iter().all(is_above) {
            let vertices: Vec<(u64, Vec<i64>)> =
                row.iter().map(|&i| (near[i].0, near[i].1.clone())).collect();
            expected.cells.insert(class(&vertices));
        }
        // Without weights, no lifted site lies above a cell of others.
        let open = near.iter().filter(|image| has_weights && !is_corner(&image.2));
        for (i, _, site) in open {
            if !concealed.contains(i) && contains(&simplex, site) && above(&simplex, site)[0].is_gt() {
                concealed.insert(*i);
            }
        }
    }
    expected.hidden.extend(concealed);
    expected.hidden.sort_unstable();
    expected
}

/// Returns the result of a run in the form of the search.
fn found(run: &Outcome) -> Expected {
    let d = run.space;
    let part = run.kept.periodic.as_ref().expect("a periodic run");
    let offsets = part.offsets();
    let offsets = offsets.chunks_exact(d).map(|offset| offset.iter().map(|&k| i64::from(k)).collect());
    let vertices: Vec<(u64, Vec<i64>)> = run.cells().iter().copied().zip(offsets).collect();
    let cells: BTreeSet<Class> = vertices.chunks_exact(d + 1).map(class).collect();
    assert_eq!((cells.len() as u64, run.cells().len()), (run.facts.cells, (d + 1) * cells.len()));
    let LeftOut { hidden, duplicates } = LeftOut::of(run);
    assert_eq!(run.points.used + (hidden.len() + duplicates.len()) as u64, run.points.input);
    Expected { cells, hidden, duplicates }
}

struct LeftOut {
    hidden: Vec<u64>,
    duplicates: Vec<(u64, u64)>,
}

impl LeftOut {
    fn of(run: &Outcome) -> Self {
        LeftOut { hidden: run.left_out.hidden.clone(), duplicates: run.left_out.duplicates.clone() }
    }
}

/// Compares runs with the search. Returns the number of hidden sites.
fn compare<P: Position, const D: usize>(
    what: &str,
    sites: &[Site<D>],
    lengths: [i64; D],
    draw: &mut Draw,
) -> usize
where
    Weighted<P>: Point,
{
    let mut rows: Vec<usize> = (0..sites.len()).collect();
    draw.shuffle(&mut rows);
    let permuted: Vec<Site<D>> = rows.iter().map(|&i| sites[i]).collect();
    let mut hidden = 0;
    for sites in [sites, &permuted] {
        let expected = search(sites, lengths);
        hidden = expected.hidden.len();
        // A scale whose sums must be rounded is as good as integers.
        for scale in [1.0, 0.1] {
            let is_exact = scale == 1.0;
            let place = |site: &Site<D>| std::array::from_fn::<f64, D, _>(|axis| site.0[axis] as f64 * scale);
            let given: Vec<Weighted<P>> = sites
                .iter()
                .map(|site| Weighted::new(P::from_coords(&place(site)), site.1 as f64 * scale * scale))
                .collect();
            for workers in [1, 3, 8] {
                let mut spec = with_workers(Workers::Count(workers), 2);
                let mut periodic = Periodic::of_lengths(&lengths.map(|length| length as f64 * scale));
                periodic.wrap = true;
                spec.input.periodic = Some(periodic.clone());
                let label = format!("{what}, {workers} workers: {sites:?} in {lengths:?}, scale {scale}");
                let (points, name) = (given.clone(), label.clone());
                let run = within(PATIENCE, &label, move || {
                    let both = [triangulate(&points, &spec), simulate(&points, &spec)];
                    let both = both.map(|run| run.unwrap_or_else(|e| panic!("{name}: {e}")));
                    assert_eq!(found(&both[0]), found(&both[1]), "{name}: other cells by simulate");
                    let [run, _] = both;
                    run
                });
                verified(&given, &run, Some(&periodic));
                if is_exact {
                    assert_eq!(found(&run), expected, "{label}");
                } else {
                    // Rounded coordinates are another set, whose sizes are those of a torus.
                    let found = found(&run);
                    let hidden = found.hidden.len() + found.duplicates.len();
                    assert!(D == 3 || found.cells.len() == 2 * (sites.len() - hidden), "{label}");
                }
            }
        }
    }
    hidden
}

/// Draws sites, weights and a box.
fn set<const D: usize>(kind: usize, draw: &mut Draw) -> (Vec<Site<D>>, [i64; D]) {
    let most = if D == 2 { 5 } else { 2 };
    let count = draw.below(most) + 1;
    let mut number = |from: i64, to: i64| from + draw.below((to - from + 1) as usize) as i64;
    let (side, spread) = [(3, 0), (3, 2), (60, 0), (60, 500), (2, 1), (9, 30)][kind];
    let lengths = std::array::from_fn(|_| side + number(0, 2));
    let mut site = |_| {
        // Some points lie outside of the box.
        let place = std::array::from_fn(|axis| number(0, lengths[axis]) + lengths[axis] * number(-1, 1));
        (place, number(-spread, spread))
    };
    ((0..count).map(&mut site).collect(), lengths)
}

#[test]
fn small_sets_agree_with_the_definition() {
    let sets: usize = std::env::var("SEPTET_SETS").map_or(100, |n| n.parse().expect("a number"));
    let mut hidden = 0;
    for i in 0..sets {
        let mut draw = Draw::new(5300 + i as u64);
        let what = format!("set {i}");
        if i % 2 == 0 {
            let (sites, lengths) = set::<2>(i / 2 % 6, &mut draw);
            hidden += compare::<DVec2, 2>(&what, &sites, lengths, &mut draw);
        } else {
            let (sites, lengths) = set::<3>(i / 2 % 6, &mut draw);
            hidden += compare::<DVec3, 3>(&what, &sites, lengths, &mut draw);
        }
    }
    assert!(hidden > sets / 20, "{hidden} hidden sites in {sets} sets");
}

/// Returns the cells of CGAL's periodic triangulation in the unit box.
fn by_cgal<P: Point>(points: &[P]) -> BTreeSet<Class> {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("points");
    let numbers = points.iter().flat_map(|x| (0..P::DIM).map(|i| x.coord(i)).collect::<Vec<_>>());
    fs::write(&file, numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    let output = Command::new(cgal("cgal_periodic")).arg(P::DIM.to_string()).arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let cell = |line: &str| {
        let numbers: Vec<i64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let vertices = numbers.chunks_exact(P::DIM + 1).map(|v| (v[0] as u64, v[1..].to_vec()));
        class(&vertices.collect::<Vec<_>>())
    };
    String::from_utf8(output.stdout).unwrap().lines().map(cell).collect()
}

fn agrees_with_cgal<P: Position>() {
    let count: usize = std::env::var("SEPTET_SITES").map_or(5000, |n| n.parse().expect("a number"));
    let mut draw = Draw::new(53);
    let points: Vec<P> = (0..count).map(|_| draw.point()).collect();
    let expected = by_cgal(&points);
    for workers in [1, 5] {
        let mut spec = with_workers(Workers::Count(workers), 300);
        spec.input.periodic = Some(Periodic::of_lengths(&vec![1.0; P::DIM]));
        let run = triangulate(&points, &spec).unwrap();
        let found = found(&run);
        println!("{}D, {count} points, {workers} workers: {} cells", P::DIM, expected.len());
        assert!(found.cells == expected, "other cells than CGAL's");
        assert!(run.kept.periodic.is_some_and(|part| part.is_simplicial));
    }
}

#[test]
#[ignore = "needs a C++ compiler and CGAL's headers"]
fn cgal_agrees_in_general_position() {
    agrees_with_cgal::<DVec2>();
    agrees_with_cgal::<DVec3>();
}

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// Adds the parts of a cell to the volumes of the Voronoi cells of its vertices. Each edge, triangle and cell at a vertex spans a
/// signed tetrahedron with it and the centres of their spheres.
fn add_parts(volumes: &mut [f64], rows: &[u64], corners: [Vector; 4]) {
    const EVEN: [[usize; 4]; 12] = [
        [0, 1, 2, 3],
        [0, 2, 3, 1],
        [0, 3, 1, 2],
        [1, 0, 3, 2],
        [1, 3, 2, 0],
        [1, 2, 0, 3],
        [2, 3, 0, 1],
        [2, 0, 1, 3],
        [2, 1, 3, 0],
        [3, 2, 1, 0],
        [3, 1, 0, 2],
        [3, 0, 2, 1],
    ];
    for [v, i, j, k] in EVEN {
        let [a, b, c] = [i, j, k].map(|at| minus(corners[at], corners[v]));
        let (normal, [a2, b2, c2]) = (cross(a, b), [a, b, c].map(|x| dot(x, x)));
        let of_triangle = cross([0, 1, 2].map(|i| a2 * b[i] - b2 * a[i]), normal);
        let triangle = of_triangle.map(|x| x / (2.0 * dot(normal, normal)));
        let six = dot(normal, c);
        let (bc, ca) = (cross(b, c), cross(c, a));
        let cell = [0, 1, 2].map(|i| (a2 * bc[i] + b2 * ca[i] + c2 * normal[i]) / (2.0 * six));
        volumes[rows[v] as usize] += dot(cross(minus(a, b), triangle), cell) / 12.0;
    }
}

/// The volumes that Voro++ prints, which have six digits.
fn by_voro(points: &[DVec3], lengths: [f64; 3]) -> Vec<f64> {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("points");
    let line = |(i, p): (usize, &DVec3)| format!("{i} {:.17e} {:.17e} {:.17e}\n", p.x, p.y, p.z);
    fs::write(&file, points.iter().enumerate().map(line).collect::<String>()).unwrap();
    let mut program = Command::new("voro++");
    program.args(["-p", "-c", "%i %v"]);
    for length in lengths {
        program.args(["0".to_owned(), length.to_string()]);
    }
    let output = program.arg(&file).output().unwrap_or_else(|e| panic!("voro++: {e}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut volumes = vec![f64::NAN; points.len()];
    for line in fs::read_to_string(directory.path().join("points.vol")).unwrap().lines() {
        let (row, volume) = line.split_once(' ').unwrap();
        volumes[row.parse::<usize>().unwrap()] = volume.parse().unwrap();
    }
    volumes
}

#[test]
#[ignore = "needs Voro++"]
fn voronoi_cells_have_the_volumes_of_voro() {
    let count: usize = std::env::var("SEPTET_SITES").map_or(5000, |n| n.parse().expect("a number"));
    let (mut draw, lengths) = (Draw::new(54), [1.0, 2.0, 0.5]);
    let points: Vec<DVec3> = (0..count).map(|_| draw.point::<DVec3>() * DVec3::from(lengths)).collect();
    let mut spec = with_workers(Workers::Count(3), 300);
    spec.input.periodic = Some(Periodic::of_lengths(&lengths));
    let run = triangulate(&points, &spec).unwrap();
    let offsets = run.kept.periodic.as_ref().unwrap().offsets();
    let mut volumes = vec![0.0; count];
    for (rows, offsets) in run.cells().chunks_exact(4).zip(offsets.chunks_exact(12)) {
        let corner = |at: usize| {
            let point = points[rows[at] as usize].to_array();
            [0, 1, 2].map(|axis| point[axis] + f64::from(offsets[3 * at + axis]) * lengths[axis])
        };
        add_parts(&mut volumes, rows, [0, 1, 2, 3].map(corner));
    }
    let sum: f64 = volumes.iter().sum();
    assert!((sum - 1.0).abs() < 1e-12, "the volumes add up to {sum}");
    let expected = by_voro(&points, lengths);
    for (row, (found, expected)) in volumes.iter().zip(&expected).enumerate() {
        assert!((found / expected - 1.0).abs() < 1e-5, "cell {row}: {found}, not {expected}");
    }
    println!("{count} volumes, sum - 1 = {:e}", sum - 1.0);
}
