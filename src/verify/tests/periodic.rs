//! Periodic boxes: brute-force triangulations pass, and altered ones are refused.
//!
//! The search uses integers only. The vertices of a cell with a vertex in the box are at most one length away from it. Each such
//! simplex is tested against all images at most two lengths away. Ties are broken by explicit ranks of positions.

use std::array::from_fn;
use std::cmp::Ordering;
use std::collections::BTreeSet;

use num_bigint::BigInt;

use super::fixtures::{Numbers, failed, integers, turn};
use super::weights::ANY_ORDER;
use crate::exact::Site;
use crate::place::{Image as Moved, Place};
use crate::predicates::{orientation, power};
use crate::{Fault, PeriodicBox, Report, Sites, Triangulation, VerifyOptions, verify};

/// A vertex: a row and its offset.
type Vertex = (u64, Vec<i32>);

/// A periodic triangulation that owns its arrays.
#[derive(Clone, Debug)]
struct Torus<const D: usize> {
    points: Vec<[f64; D]>,
    weights: Option<Vec<f64>>,
    lengths: [Option<f64>; D],
    cells: Vec<Vec<Vertex>>,
}

/// Moves a cell by the offset that makes the sorted list least.
fn class(cell: &[Vertex]) -> Vec<Vertex> {
    let moved = |by: &[i32]| {
        let minus = |offset: &[i32]| offset.iter().zip(by).map(|(a, b)| a - b).collect::<Vec<i32>>();
        let mut all: Vec<Vertex> = cell.iter().map(|(row, offset)| (*row, minus(offset))).collect();
        all.sort();
        all
    };
    cell.iter().map(|(_, offset)| moved(offset)).min().unwrap()
}

impl<const D: usize> Torus<D> {
    fn verify(&self, options: VerifyOptions) -> Report {
        let cells: Vec<u64> = self.cells.iter().flatten().map(|v| v.0).collect();
        let offsets: Vec<i32> = self.cells.iter().flatten().flat_map(|v| v.1.clone()).collect();
        let coordinates = self.points.as_flattened();
        let mesh = Triangulation { dimension: D, coordinates, cells: &cells };
        let periodic = Some(PeriodicBox { lengths: &self.lengths, offsets: &offsets });
        verify(Sites { mesh, weights: self.weights.as_deref(), periodic }, &options, &mut |_, _, _| {})
    }

    fn fault(&self, level: &str) -> Fault {
        let report = self.verify(ANY_ORDER);
        let level = report.level(level).unwrap();
        level.faults.first().cloned().unwrap_or_else(|| panic!("{report:?}"))
    }

    /// Returns the classes of the cells, or `None` if one occurs twice.
    fn classes(&self) -> Option<BTreeSet<Vec<Vertex>>> {
        let set: BTreeSet<_> = self.cells.iter().map(|cell| class(cell)).collect();
        (set.len() == self.cells.len()).then_some(set)
    }

    /// Returns the triangulation of the same sites, by definition.
    fn correct(&self) -> Self {
        search(&self.points, self.weights.as_deref(), self.lengths)
    }
}

/// An image: its row, its offset, and its lift in integers.
type Image = (u64, Vec<i32>, Vec<BigInt>);

/// Returns the images in the box, and at most `most` lengths away. Those in the box come first.
fn images<const D: usize>(
    points: &[[f64; D]],
    weights: Option<&[f64]>,
    lengths: [Option<f64>; D],
    most: i32,
) -> Vec<Image> {
    let none = vec![0.0; points.len()];
    let mut numbers = points.to_vec();
    numbers.push(from_fn(|axis| lengths[axis].unwrap_or(0.0)));
    let heights = [weights.unwrap_or(&none), &[0.0]].concat();
    let mut lifted = integers(&numbers, &heights);
    let lengths = lifted.pop().unwrap();
    let zero = BigInt::ZERO;
    let mut all: Vec<Image> = Vec::new();
    for (row, lift) in lifted.iter().enumerate() {
        let mut choices: Vec<Vec<i32>> = vec![Vec::new()];
        for axis in 0..D {
            let mut own = vec![0];
            if lengths[axis] > zero {
                // The offset that moves the point into the box, rounded towards zero, then down.
                let quotient = &lift[axis] / &lengths[axis];
                let is_below = &quotient * &lengths[axis] > lift[axis];
                let base = -i32::try_from(&quotient - BigInt::from(i32::from(is_below))).unwrap();
                own = (base - most..=base + most).collect();
                own.sort_by_key(|k| *k != base);
            }
            choices =
                choices.iter().flat_map(|c| own.iter().map(move |k| [&c[..], &[*k]].concat())).collect();
        }
        for (number, offset) in choices.into_iter().enumerate() {
            let mut image: Vec<BigInt> = (0..D).map(|k| &lift[k] + &lengths[k] * offset[k]).collect();
            let square = |row: &[BigInt]| row[..D].iter().map(|x| x * x).sum::<BigInt>();
            let height = square(&image) + &lift[D] - square(lift);
            image.push(height);
            all.push((row as u64, offset, image));
            let last = all.len() - 1;
            if number == 0 {
                all.swap(row, last);
            }
        }
    }
    all
}

/// Returns the sign of `q` relative to the plane through the lifts of a positive simplex: greater if it is strictly above, with ties
/// broken by the ranks of positions.
fn above<const D: usize>(simplex: &[&Vec<BigInt>], q: &Vec<BigInt>) -> [Ordering; 2] {
    let mut rows = simplex.to_vec();
    rows.push(q);
    let plain = turn(&rows, D + 1);
    if plain.is_ne() {
        return [plain; 2];
    }
    // Raise the highest position, then the next, until the sign changes.
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&i, &j| rows[j][..D].cmp(&rows[i][..D]));
    for i in order {
        let mut raised = rows[i].clone();
        raised[D] += 1;
        let mut others = rows.clone();
        others[i] = &raised;
        let sign = turn(&others, D + 1);
        if sign.is_ne() {
            return [plain, sign];
        }
    }
    [plain; 2]
}

fn search<const D: usize>(
    points: &[[f64; D]],
    weights: Option<&[f64]>,
    lengths: [Option<f64>; D],
) -> Torus<D> {
    let [near, far] = [1, 2].map(|most| images(points, weights, lengths, most));
    // Of sites at one position modulo the lattice, the first of the heaviest ones stays.
    let is_kept = |row: usize| {
        let own = &near[row];
        let beats = |other: &Image| {
            let key = |image: &Image| (image.2[D].clone(), image.0);
            other.2[..D] == own.2[..D] && key(other) < key(own)
        };
        !near[..points.len()].iter().any(beats)
    };
    let kept: Vec<bool> = (0..points.len()).map(is_kept).collect();
    let of_kept = |all: Vec<Image>| all.into_iter().filter(|i| kept[i.0 as usize]).collect::<Vec<_>>();
    let count = kept.iter().filter(|kept| **kept).count();
    let (near, far) = (of_kept(near), of_kept(far));
    let mut cells = BTreeSet::new();
    for first in 0..count {
        grow::<D>((&near, &far), &mut vec![first], &mut cells);
    }
    let cells = cells.into_iter().collect();
    Torus { points: points.to_vec(), weights: weights.map(<[f64]>::to_vec), lengths, cells }
}

/// Adds all cells of which these images are the first vertices.
fn grow<const D: usize>(
    (near, far): (&[Image], &[Image]),
    row: &mut Vec<usize>,
    cells: &mut BTreeSet<Vec<Vertex>>,
) {
    if row.len() <= D {
        for next in row[row.len() - 1] + 1..near.len() {
            row.push(next);
            grow::<D>((near, far), row, cells);
            row.pop();
        }
        return;
    }
    let mut simplex: Vec<&Vec<BigInt>> = row.iter().map(|&i| &near[i].2).collect();
    let mut vertices: Vec<Vertex> = row.iter().map(|&i| (near[i].0, near[i].1.clone())).collect();
    match turn(&simplex, D) {
        Ordering::Equal => return,
        Ordering::Less => {
            simplex.swap(D - 1, D);
            vertices.swap(D - 1, D);
        }
        Ordering::Greater => {}
    }
    let is_corner = |image: &Image| simplex.iter().any(|corner| corner[..D] == image.2[..D]);
    let is_empty = |image: &Image| is_corner(image) || above::<D>(&simplex, &image.2)[1].is_gt();
    if near.iter().all(is_empty) && far.iter().all(is_empty) {
        cells.insert(class(&vertices));
    }
}

/// Draws sites and a box.
fn set<const D: usize>(kind: u64, numbers: &mut Numbers) -> Torus<D> {
    let most = if D == 2 { 5 } else { 2 };
    let count = numbers.below(most) + 1;
    let (side, spread) = [(3, 0), (3, 5), (60, 0), (60, 900), (2, 3)][kind as usize % 5];
    let mut lengths: [Option<f64>; D] = from_fn(|_| Some((side + numbers.below(3)) as f64));
    let mut points = Vec::new();
    for _ in 0..count {
        // Some points lie outside of the box.
        points.push(from_fn(|axis| {
            let length = lengths[axis].unwrap() as u64;
            numbers.below(length + 1) as f64 + (length as f64) * (numbers.below(3) as f64 - 1.0)
        }));
    }
    let mut weights: Option<Vec<f64>> =
        (spread > 0).then(|| points.iter().map(|_| numbers.below(spread) as f64).collect());
    if numbers.below(4) == 0 {
        lengths[numbers.below(D as u64) as usize] = None;
    }
    if numbers.below(3) == 0 {
        // Sums of these numbers are rounded.
        let scale = 0.1;
        points.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
        lengths.iter_mut().flatten().for_each(|x| *x *= scale);
        weights.iter_mut().flatten().for_each(|x| *x *= scale * scale);
    }
    Torus { points, weights, lengths, cells: Vec::new() }.correct()
}

/// Returns the cells of all sites but one.
fn without<const D: usize>(torus: &Torus<D>, site: usize, weights: &[f64]) -> Vec<Vec<Vertex>> {
    let rest = |i: usize| i + usize::from(i >= site);
    let others: Vec<[f64; D]> = (1..torus.points.len()).map(|i| torus.points[rest(i - 1)]).collect();
    let of_others: Vec<f64> = (1..torus.points.len()).map(|i| weights[rest(i - 1)]).collect();
    let mut cells = search(&others, Some(&of_others), torus.lengths).cells;
    for vertex in cells.iter_mut().flatten() {
        vertex.0 = rest(vertex.0 as usize) as u64;
    }
    cells
}

/// Returns one alteration of a triangulation, and its name.
fn altered<const D: usize>(torus: &Torus<D>, numbers: &mut Numbers) -> (&'static str, Torus<D>) {
    let mut other = torus.clone();
    let [site, cell] = [torus.points.len(), torus.cells.len()].map(|end| numbers.below(end as u64) as usize);
    let (slot, axis) = (numbers.below(D as u64 + 1) as usize, numbers.below(D as u64) as usize);
    let weights = torus.weights.clone().unwrap_or_else(|| vec![0.0; torus.points.len()]);
    let what = match numbers.below(9) {
        0 => {
            other.cells[cell][slot].1[axis] += if numbers.below(2) == 0 { 1 } else { -1 };
            "offset"
        }
        1 => {
            // The cells of the set in which this site is heavier.
            let mut heavier = weights;
            heavier[site] += heavier.iter().fold(1.0, |m: f64, w| m.max(w.abs()));
            other.cells = search(&torus.points, Some(&heavier), torus.lengths).cells;
            "shown"
        }
        2 => {
            other.cells = without(torus, site, &weights);
            "hidden"
        }
        3 => {
            let mut twice = torus.cells[cell].clone();
            for vertex in &mut twice {
                vertex.1[axis] += i32::from(torus.lengths[axis].is_some());
            }
            other.cells.push(twice);
            "twice"
        }
        4 => {
            other.cells.remove(cell);
            "missing"
        }
        5 => {
            // All cells that cross a face of the box are missing.
            other.cells.retain(|cell| cell.iter().all(|v| v.1[axis] == cell[0].1[axis]));
            "sheet missing"
        }
        6 => {
            // A covering of several sheets.
            let times = if numbers.below(2) == 0 { 2 } else { -1 };
            other.cells.iter_mut().flatten().for_each(|vertex| vertex.1[axis] *= times);
            "sheets"
        }
        7 => {
            other.cells[cell][slot] =
                torus.cells[numbers.below(torus.cells.len() as u64) as usize][slot].clone();
            "vertex replaced"
        }
        _ => {
            other.cells[cell] = torus.cells[numbers.below(torus.cells.len() as u64) as usize].clone();
            "replaced"
        }
    };
    (what, other)
}

fn alterations<const D: usize>(sets: u64, counts: &mut [u32; 3]) {
    for i in 0..sets {
        let mut numbers = Numbers(7100 + 100 * D as u64 + i);
        let torus = set::<D>(i, &mut numbers);
        let report = torus.verify(ANY_ORDER);
        assert!(report.passed(), "{torus:?}: {report:?}");
        counts[0] += 1;
        if torus.cells.is_empty() {
            continue;
        }
        let correct = torus.classes();
        for _ in 0..20 {
            let (what, other) = altered(&torus, &mut numbers);
            let good = other.classes() == correct;
            let report = other.verify(ANY_ORDER);
            assert_eq!(report.passed(), good, "{what}: {other:?} {report:?}");
            // Without the perturbation, more may pass if there are ties.
            let passed = other.verify(VerifyOptions::default()).passed();
            assert!(passed >= good, "{what}: {other:?}");
            counts[if good { 1 } else { 2 }] += 1;
        }
    }
}

#[test]
fn only_the_canonical_triangulation_of_the_box_passes() {
    let sets = std::env::var("SEPTET_SETS").map_or(16, |n| n.parse().unwrap());
    let mut counts = [0; 3];
    alterations::<2>(sets, &mut counts);
    alterations::<3>(sets / 2, &mut counts);
    println!("{counts:?} valid, altered without effect, refused");
    assert!(u64::from(counts[2]) > 10 * sets, "{counts:?}");
}

/// The plane lattice in a box of `side` by `side` squares, moved by `shift`.
fn squares(side: usize, shift: f64) -> Torus<2> {
    let points: Vec<[f64; 2]> =
        (0..side * side).map(|i| [(i / side) as f64 + shift, (i % side) as f64 + shift]).collect();
    let mut cells = Vec::new();
    for i in 0..side * side {
        let corner = |x: usize, y: usize| {
            let (x, y) = (i / side + x, i % side + y);
            ((x % side * side + y % side) as u64, vec![(x / side) as i32, (y / side) as i32])
        };
        // The diagonal that the perturbation selects joins the middle positions.
        cells.push(vec![corner(0, 0), corner(1, 0), corner(0, 1)]);
        cells.push(vec![corner(1, 0), corner(1, 1), corner(0, 1)]);
    }
    Torus { points, weights: None, lengths: [Some(side as f64); 2], cells }
}

#[test]
fn lattices_of_any_size_pass() {
    for (side, shift) in [(1, 0.0), (2, 0.1), (3, -7.3), (40, 0.1)] {
        let torus = squares(side, shift);
        let [report, strict] = [VerifyOptions::default(), ANY_ORDER].map(|options| torus.verify(options));
        assert!(report.passed(), "{report:?}");
        assert!(strict.passed() || shift != 0.0, "{strict:?}");
        assert_eq!((report.interior_facets, report.hull_facets), (3 * (side * side) as u64, 0));
        assert_eq!(report.dimension_of_points, 2);
        for threads in [1, 3] {
            assert_eq!(torus.verify(VerifyOptions { threads, ..VerifyOptions::default() }), report);
        }
    }
}

#[test]
fn faults_have_their_levels() {
    let good = squares(3, 0.0);
    let with = |alter: &dyn Fn(&mut Torus<2>)| {
        let mut torus = good.clone();
        alter(&mut torus);
        torus
    };
    let missing = with(&|torus| drop(torus.cells.pop()));
    assert!(matches!(missing.fault("manifold"), Fault::OpenFacet { .. }));
    let far = with(&|torus| torus.cells[4][1].1[0] = 1 << 27);
    assert_eq!(far.fault("structure"), Fault::OffsetNotAdmitted { cell: 4 });
    let far = with(&|torus| torus.points[5][0] = 1e12);
    assert_eq!(far.fault("structure"), Fault::TooFar { point: 5 });
    let open = with(&|torus| torus.lengths[0] = None);
    assert!(matches!(open.fault("structure"), Fault::OffsetNotAdmitted { .. }));
    let twice = with(&|torus| {
        let moved = |v: &Vertex| (v.0, vec![v.1[0] - 5, v.1[1]]);
        let again = torus.cells[2].iter().map(moved).collect();
        torus.cells.push(again);
    });
    assert_eq!(twice.fault("structure"), Fault::CellTwice { cells: [2, 18] });
    let unused = with(&|torus| torus.points.push([0.5; 2]));
    assert_eq!(unused.fault("structure"), Fault::Unused { point: 9 });
    // A point on the upper face repeats one on the lower face.
    let duplicate = with(&|torus| torus.points.push([3.0, -6.0]));
    let report = duplicate.verify(ANY_ORDER);
    assert!(report.passed() && report.duplicates == 1, "{report:?}");
    let second = with(&|torus| {
        torus.points.push([3.0, 0.0]);
        torus
            .cells
            .iter_mut()
            .flatten()
            .filter(|v| v.0 == 0)
            .for_each(|v| *v = (9, vec![v.1[0] - 1, v.1[1]]));
    });
    assert_eq!(second.fault("structure"), Fault::NotRepresentative { vertex: 9, smallest: 0 });
    assert!(second.verify(VerifyOptions::default()).passed());
    // Two sheets: all local conditions hold.
    let mut sheets = squares(1, 0.0);
    sheets.cells.iter_mut().flatten().for_each(|vertex| vertex.1[0] *= 2);
    assert_eq!(failed(&sheets.verify(VerifyOptions::default())), ["single cover"]);
    assert_eq!(sheets.fault("single cover"), Fault::LongerThanBox { cell: 0, axis: 0 });
}

#[test]
fn arrays_of_other_lengths_are_refused() {
    let good = squares(2, 0.0);
    let cells: Vec<u64> = good.cells.iter().flatten().map(|v| v.0).collect();
    let offsets: Vec<i32> = good.cells.iter().flatten().flat_map(|v| v.1.clone()).collect();
    let refuse = |lengths: &[Option<f64>], offsets: &[i32]| {
        let mesh = Triangulation { dimension: 2, coordinates: good.points.as_flattened(), cells: &cells };
        let sites = Sites { mesh, weights: None, periodic: Some(PeriodicBox { lengths, offsets }) };
        let report = verify(sites, &VerifyOptions::default(), &mut |_, _, _| {});
        assert!(matches!(report.levels[0].faults[..], [Fault::Shape { .. }]), "{report:?}");
    };
    let two = [Some(2.0); 2];
    refuse(&two, &offsets[1..]);
    refuse(&two, &[&offsets[..], &[0, 0]].concat());
    refuse(&two[1..], &offsets);
    for length in [0.0, -2.0, f64::NAN, f64::INFINITY] {
        refuse(&[Some(2.0), Some(length)], &offsets);
    }
    refuse(&[None, None], &offsets);
    refuse(&[Some(1e300), Some(1e-300)], &offsets);
}

/// Compares signs of images, most of whose positions are rounded, with those of integers.
fn signs<const D: usize, const N: usize>(counts: &mut [u32; 3]) {
    let mut numbers = Numbers(7400 + D as u64);
    for _ in 0..6000 {
        let length = [1.0, 0.1, 1.0 / 3.0, 3.0, 1e-3][numbers.below(5) as usize];
        let far = if numbers.below(4) == 0 { 1 << 20 } else { 1 };
        let mut image = || -> ([f64; D], [i32; D], f64) {
            let point = from_fn(|_| {
                let x = (numbers.below(4) as f64 - 1.0) * length / 2.0;
                [x.next_up(), x + 1e-9 * length, x, x, x, x][numbers.below(6) as usize]
            });
            let steps = from_fn(|_| far * (numbers.below(4) as i32 - 2) + numbers.below(2) as i32);
            (point, steps, numbers.below(3) as f64 * length * length)
        };
        let all: [_; N] = from_fn(|_| image());
        let query = image();
        let rows: Vec<_> = all.into_iter().chain([query]).collect();
        let mut given: Vec<[f64; D]> = rows.iter().map(|row| row.0).collect();
        given.push([length; D]);
        let mut weights: Vec<f64> = rows.iter().map(|row| row.2).collect();
        weights.push(0.0);
        let mut whole = integers(&given, &weights);
        let unit = whole.pop().unwrap()[0].clone();
        let squares = |row: &[BigInt]| row.iter().map(|x| x * x).sum::<BigInt>();
        for (row, (_, steps, _)) in whole.iter_mut().zip(&rows) {
            let before = squares(&row[..D]);
            for axis in 0..D {
                row[axis] += &unit * steps[axis];
            }
            let change = squares(&row[..D]) - before;
            row[D] += change;
        }
        let places: Vec<Moved<D>> = rows.iter().map(|r| Moved::of(&r.0, r.1, &[length; D])).collect();
        let cell: [Moved<D>; N] = from_fn(|i| places[i]);
        let lifted: Vec<_> = whole.iter().collect();
        let label = || format!("{rows:?} {length}");
        assert_eq!(orientation(&cell), turn(&lifted[..N], D), "{}", label());
        assert_eq!(cell[0].lexicographic(&cell[1]), whole[0][..D].cmp(&whole[1][..D]), "{}", label());
        let is_long = |axis: usize| {
            let difference = &whole[0][axis] - &whole[1][axis];
            difference > unit || -difference > unit
        };
        assert!(
            (0..D).all(|axis| cell[0].is_farther(&cell[1], axis, length) == is_long(axis)),
            "{}",
            label()
        );
        let sites: [Site<Moved<D>>; N] = from_fn(|i| Site { place: places[i], weight: rows[i].2 });
        let sign = power(&sites, &Site { place: places[N], weight: rows[N].2 });
        assert_eq!(sign, turn(&lifted, D + 1).reverse(), "{}", label());
        counts[(sign as i8 + 1) as usize] += 1;
    }
}

#[test]
fn signs_of_images_are_exact() {
    let mut counts = [0; 3];
    signs::<2, 3>(&mut counts);
    signs::<3, 4>(&mut counts);
    assert!(counts.iter().all(|&count| count > 30), "{counts:?}");
}
