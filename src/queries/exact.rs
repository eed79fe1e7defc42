//! Signs and ratios of determinants in big integers, for the rare calls that rounded arithmetic cannot decide.
//!
//! **Statement.** Multiplied by a common power of two, coordinates are integers, so every polynomial in them is exact. This
//! holds for any finite coordinates, also for those that [`septet_geometry::range`] does not admit. A ratio is truncated to
//! 64 digits or more and rounded once.
//!
//! **Work.** O(1) operations on integers with as many digits as the coordinates of the call spread over.

use std::array::from_fn;
use std::cmp::Ordering;

use num_bigint::BigInt;
use septet_geometry::point::Point;
use septet_geometry::predicates::Sign;
use septet_meshing::exact::{determinant, integers, rounded};

type Vector = [BigInt; 3];

/// Returns the sign of an integer.
fn sign(x: &BigInt) -> Sign {
    match x.cmp(&BigInt::ZERO) {
        Ordering::Less => Sign::Negative,
        Ordering::Equal => Sign::Zero,
        Ordering::Greater => Sign::Positive,
    }
}

/// Returns `a / b`, rounded; NaN if `b` is 0.
fn ratio(a: &BigInt, b: &BigInt) -> f64 {
    if *b == BigInt::ZERO {
        return f64::NAN;
    }
    let shift = (b.bits() + 66).saturating_sub(a.bits());
    rounded(&((a << shift) / b), -(shift as i32))
}

/// Converts points to integers with three coordinates; the third is 0 in the plane.
fn vectors<P: Point>(points: &[P]) -> Vec<Vector> {
    let of = |p: Vec<BigInt>| from_fn(|axis| p.get(axis).cloned().unwrap_or(BigInt::ZERO));
    integers(points).into_iter().map(of).collect()
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    from_fn(|axis| &a[axis] - &b[axis])
}

fn plus(a: &Vector, b: &Vector) -> Vector {
    from_fn(|axis| &a[axis] + &b[axis])
}

fn times(a: &Vector, by: &BigInt) -> Vector {
    from_fn(|axis| &a[axis] * by)
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    from_fn(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

/// Returns the orientation determinant of a cell of integers, times the same factor for all cells.
fn orientation_of(cell: &[Vec<BigInt>]) -> BigInt {
    determinant(&cell[..cell.len() - 1], &cell[cell.len() - 1])
}

/// Returns the sign of the orientation of `DIM + 1` points with any finite coordinates.
pub(crate) fn orientation<P: Point>(cell: &[P]) -> Sign {
    sign(&orientation_of(&integers(&cell[..=P::DIM])))
}

/// Returns the barycentric coordinates of `q` in a positively oriented cell. Their signs are exact.
pub(crate) fn barycentric<P: Point>(cell: &[P], q: P) -> [f64; 4] {
    let n = P::DIM + 1;
    let mut all = [q; 5];
    all[..n].copy_from_slice(&cell[..n]);
    let all = integers(&all[..=n]);
    let whole = orientation_of(&all[..n]);
    from_fn(|corner| {
        if corner >= n {
            return 0.0;
        }
        let mut replaced = all[..n].to_vec();
        replaced[corner].clone_from(&all[n]);
        ratio(&orientation_of(&replaced), &whole)
    })
}

/// Compares the distances of `a` and `b` to `q`.
pub(crate) fn nearer<P: Point>(q: P, a: P, b: P) -> Ordering {
    let all = vectors(&[q, a, b]);
    let [to_a, to_b] = [1, 2].map(|i| minus(&all[i], &all[0]));
    dot(&to_a, &to_a).cmp(&dot(&to_b, &to_b))
}

/// Returns the circumcentre of a positively oriented cell relative to its first corner. It may be infinite.
pub(crate) fn circumcentre<P: Point>(cell: &[P]) -> P {
    let (all, unit) = integers_with_unit(&cell[..=P::DIM]);
    let (over, under) = centre_of::<P>(&all);
    let mut centre = P::default();
    for (axis, over) in over.iter().enumerate().take(P::DIM) {
        centre.set_coord(axis, ratio(over, &under) * unit);
    }
    centre
}

/// Returns the circumcentre relative to the first corner as a fraction.
fn centre_of<P: Point>(all: &[Vector]) -> (Vector, BigInt) {
    let rel: Vec<Vector> = all[1..].iter().map(|p| minus(p, &all[0])).collect();
    let (over, under) = if P::DIM == 2 {
        let up: Vector = [BigInt::ZERO, BigInt::ZERO, BigInt::from(1)];
        let squares = [dot(&rel[0], &rel[0]), dot(&rel[1], &rel[1])];
        let turned =
            plus(&times(&cross(&rel[1], &up), &squares[0]), &times(&cross(&up, &rel[0]), &squares[1]));
        (turned, cross(&rel[0], &rel[1])[2].clone())
    } else {
        let sides = [cross(&rel[1], &rel[2]), cross(&rel[2], &rel[0]), cross(&rel[0], &rel[1])];
        let [a, b, c]: [Vector; 3] = from_fn(|i| times(&sides[i], &dot(&rel[i], &rel[i])));
        (plus(&plus(&a, &b), &c), dot(&rel[0], &sides[0]))
    };
    (over, under * 2)
}

/// Returns the parts of edges in a positively oriented cell, as [`crate::dual::parts`] does, each rounded once.
pub(crate) fn parts<P: Point>(cell: &[P], edges: &[[usize; 4]]) -> [f64; 6] {
    let (all, unit) = integers_with_unit(&cell[..=P::DIM]);
    let (over, under) = centre_of::<P>(&all);
    // The vector from a corner to the circumcentre, times the denominator.
    let to_centre = |corner: usize| plus(&over, &times(&minus(&all[0], &all[corner]), &under));
    let mut parts = [0.0; 6];
    for (part, &[v, i, j, k]) in parts.iter_mut().zip(edges) {
        let along = minus(&all[i], &all[v]);
        if P::DIM == 2 {
            *part = ratio(&cross(&along, &to_centre(v))[2], &(&under * 4)) * unit * unit;
            continue;
        }
        let [(a, m), (b, n)] = [j, k].map(|apex| {
            let (p, q) = (minus(&all[v], &all[apex]), minus(&all[i], &all[apex]));
            let normal = cross(&p, &q);
            (dot(&p, &q) * dot(&normal, &to_centre(apex)), dot(&normal, &normal))
        });
        let sum = (a * &n - b * &m) * dot(&along, &along);
        *part = ratio(&sum, &(m * n * &under * 24)) * unit * unit * unit;
    }
    parts
}

/// Converts points to integers, with the length of the unit.
fn integers_with_unit<P: Point>(points: &[P]) -> (Vec<Vector>, f64) {
    let all = vectors(points);
    let pairs = points.iter().zip(&all).flat_map(|(p, whole)| (0..P::DIM).map(|i| (p.coord(i), &whole[i])));
    // A coordinate divided by its integer is a power of two.
    let unit = pairs.into_iter().find(|(x, _)| *x != 0.0).map_or(1.0, |(x, whole)| x / rounded(whole, 0));
    (all, unit)
}

/// Returns six times the volume of a positively oriented cell, or twice its area, rounded.
pub(crate) fn measure<P: Point>(cell: &[P]) -> f64 {
    let (all, unit) = integers_with_unit(&cell[..=P::DIM]);
    let cell: Vec<Vec<BigInt>> = all.into_iter().map(|p| p[..P::DIM].to_vec()).collect();
    rounded(&orientation_of(&cell), 0) * unit.powi(P::DIM as i32)
}

/// Returns six times the volume of a positively oriented cell, or twice its area, rounded. Corner `i` lies at `cell[i]` plus `steps[i]`
/// times `lengths`.
pub(crate) fn measure_of_images<P: Point>(cell: &[P], steps: &[[i32; 3]], lengths: P) -> f64 {
    let given: Vec<P> = std::iter::once(lengths).chain(cell.iter().copied()).collect();
    let (all, unit) = integers_with_unit(&given);
    let image = |(p, steps): (&Vector, &[i32; 3])| -> Vec<BigInt> {
        (0..P::DIM).map(|axis| &p[axis] + &all[0][axis] * steps[axis]).collect()
    };
    let cell: Vec<Vec<BigInt>> = all[1..].iter().zip(steps).map(image).collect();
    rounded(&orientation_of(&cell), P::DIM as i32 * unit.log2() as i32)
}

/// Returns the squared circumradius of a triangle in space, rounded; NaN if the corners are collinear.
pub(crate) fn radius2_of_triangle<P: Point>(triangle: &[P; 3]) -> f64 {
    let (all, unit) = integers_with_unit(triangle);
    let [u, v] = [minus(&all[1], &all[0]), minus(&all[2], &all[0])];
    let (w, normal) = (minus(&v, &u), cross(&u, &v));
    let over = dot(&u, &u) * dot(&v, &v) * dot(&w, &w);
    ratio(&over, &(dot(&normal, &normal) * 4)) * unit * unit
}

/// Whether `p` lies strictly inside of the smallest ball whose sphere passes through the corners of an edge or a triangle.
pub(crate) fn in_smallest_ball<P: Point>(face: &[P], p: P) -> bool {
    let mut all = face.to_vec();
    all.push(p);
    let all = vectors(&all);
    let (face, p) = all.split_at(face.len());
    if face.len() == 2 {
        return sign(&dot(&minus(&p[0], &face[0]), &minus(&p[0], &face[1]))) == Sign::Negative;
    }
    let [u, v, w] = [&face[1], &face[2], &p[0]].map(|x| minus(x, &face[0]));
    let n = cross(&u, &v);
    let twice = plus(&times(&cross(&v, &n), &dot(&u, &u)), &times(&cross(&n, &u), &dot(&v, &v)));
    sign(&(dot(&w, &w) * dot(&n, &n) - dot(&w, &twice))) == Sign::Negative
}
