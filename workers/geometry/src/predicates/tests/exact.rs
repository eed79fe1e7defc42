//! The determinants by definition, in big integers, without the forms, bounds and units of the stages.

use num_bigint::{BigInt, Sign as BigSign};

use crate::point::{Point, lex_cmp};
use crate::predicates::Sign;

/// Converts `x` to units of the smallest double times `2^below`, which saves time.
fn big(x: f64, below: i64) -> BigInt {
    let bits = x.to_bits();
    let exponent = i64::from((bits >> 52) as u32 & 0x7ff);
    let fraction = bits & ((1 << 52) - 1);
    let significand = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    if significand == 0 {
        return BigInt::ZERO;
    }
    let size = BigInt::from(significand) << (exponent.max(1) - 1 - below);
    if x < 0.0 { -size } else { size }
}

/// Laplace expansion along the first row.
fn determinant(rows: &[Vec<BigInt>]) -> BigInt {
    if rows.len() == 1 {
        return rows[0][0].clone();
    }
    let mut sum = BigInt::ZERO;
    for column in 0..rows.len() {
        let rest: Vec<Vec<BigInt>> = rows[1..]
            .iter()
            .map(|row| (0..row.len()).filter(|&j| j != column).map(|j| row[j].clone()).collect())
            .collect();
        let term = &rows[0][column] * determinant(&rest);
        if column % 2 == 0 { sum += term } else { sum -= term }
    }
    sum
}

pub fn sign_of(x: &BigInt) -> Sign {
    match x.sign() {
        BigSign::Minus => Sign::Negative,
        BigSign::NoSign => Sign::Zero,
        BigSign::Plus => Sign::Positive,
    }
}

/// The differences between the points and `base`, row by row.
fn differences<P: Point>(points: &[P], base: &P) -> Vec<Vec<BigInt>> {
    let places = points.iter().chain([base]).flat_map(|p| (0..P::DIM).flat_map(|i| [p.coord(i), p.low(i)]));
    let used = places.filter(|x| *x != 0.0).map(|x| i64::from((x.to_bits() >> 52) as u32 & 0x7ff));
    let below = used.map(|e| e.max(1) - 1).min().unwrap_or(0);
    let place = |p: &P, i: usize| big(p.coord(i), below) + big(p.low(i), below);
    let row = |p: &P| (0..P::DIM).map(|i| place(p, i) - place(base, i)).collect();
    points.iter().map(row).collect()
}

/// The orientation of `DIM + 1` points.
pub fn orientation<P: Point>(cell: &[P]) -> Sign {
    sign_of(&determinant(&differences(&cell[1..], &cell[0])))
}

/// The in-sphere determinant of rows of differences, positive inside for positively oriented cells.
pub fn in_sphere_of(mut rows: Vec<Vec<BigInt>>) -> BigInt {
    for row in &mut rows {
        let lift: BigInt = row.iter().map(|x| x * x).sum();
        row.push(lift);
    }
    let det = determinant(&rows);
    if rows.len() % 2 == 1 { det } else { -det }
}

/// Whether the differences of the points to `q` are linearly independent: elimination without division.
pub fn is_outside<P: Point>(basis: &[P], q: P) -> bool {
    let mut rows = differences(basis, &q);
    for rank in 0..rows.len() {
        let pivot =
            (rank..rows.len()).find_map(|r| Some((r, (0..P::DIM).find(|&c| rows[r][c] != BigInt::ZERO)?)));
        let Some((row, column)) = pivot else { return false };
        rows.swap(rank, row);
        let (above, below) = rows.split_at_mut(rank + 1);
        let pivot = &above[rank];
        for row in below {
            let factor = row[column].clone();
            for (entry, p) in row.iter_mut().zip(pivot) {
                *entry = &*entry * &pivot[column] - p * &factor;
            }
        }
    }
    true
}

pub fn in_sphere<P: Point>(cell: &[P], q: P) -> Sign {
    if P::IS_WEIGHTED { weighted_in_sphere(cell, q) } else { sign_of(&in_sphere_of(differences(cell, &q))) }
}

/// The determinant of heights `|p|^2 - w`, in units of the smallest double.
fn weighted_in_sphere<P: Point>(cell: &[P], q: P) -> Sign {
    let place = |p: &P| (0..P::DIM).map(|i| big(p.coord(i), 0) + big(p.low(i), 0)).collect::<Vec<BigInt>>();
    // Squares of lengths have the unit 2^-2148, and weights 2^-1074.
    let height = |p: &P| place(p).iter().map(|x| x * x).sum::<BigInt>() - (big(p.weight(), 0) << 1074);
    let mut rows: Vec<Vec<BigInt>> = Vec::new();
    for p in cell.iter().chain([&q]) {
        let mut row = place(p);
        row.extend([height(p), BigInt::from(1)]);
        rows.push(row);
    }
    let det = sign_of(&determinant(&rows));
    if P::DIM == 2 { det } else { det.opposite() }
}

/// The cell with corner `i` replaced by `q`.
pub fn replaced<P: Point>(cell: &[P], i: usize, q: P) -> Vec<P> {
    let mut cell = cell.to_vec();
    cell[i] = q;
    cell
}

/// The perturbed test, literally as in the statement of the module.
pub fn conflicts<P: Point>(cell: &[P], q: P) -> bool {
    match in_sphere(cell, q) {
        Sign::Positive => return true,
        Sign::Negative => return false,
        Sign::Zero => {}
    }
    let mut ranked: Vec<(P, Option<usize>)> = cell.iter().enumerate().map(|(i, &p)| (p, Some(i))).collect();
    ranked.push((q, None));
    ranked.sort_by(|a, b| lex_cmp(&b.0, &a.0));
    for (_, corner) in ranked {
        let derivative = match corner {
            None => orientation(cell).opposite(),
            Some(i) => orientation(&replaced(cell, i, q)),
        };
        if derivative != Sign::Zero {
            return derivative == Sign::Positive;
        }
    }
    panic!("the cell is flat");
}
