//! Determinants of any size over any ring, by all minors of the first columns.
//!
//! **Statement.** For each set of `c` rows, at most the number of columns, [`Minors`] has the determinant of these rows and the
//! first `c` columns.
//!
//! **Method.** The determinant of a set of `c` rows is expanded along the column `c - 1`: each row of the set is multiplied by the
//! minor of the others, with alternating signs. There is no division.
//!
//! **Work.** `c` products for each set of `c` rows: at most `k 2^(k-1)` for `k` rows.
//!
//! **Roundings.** With floats, a monomial passes one product and at most `c - 1` sums at each `c >= 2`: at most
//! `2 + 3 + .. + d = d (d + 1) / 2 - 1` roundings.

use super::ring::Ring;

/// The minors of sets of rows. Bit `i` of the position of a minor is set if row `i` is in its set.
pub(super) struct Minors<R>(Vec<R>);

impl<R: Ring> Minors<R> {
    /// Computes all minors of `K` rows.
    pub fn of<const D: usize, const K: usize>(rows: &[[R; D]; K]) -> Self {
        let mut minors = vec![rows[0][0].clone()];
        for set in 1..1_usize << K {
            let column = set.count_ones() as usize - 1;
            let minor = if column >= D { rows[0][0].clone() } else { expanded(rows, set, column, &minors) };
            minors.push(minor);
        }
        Minors(minors)
    }

    /// Returns the determinant of a square matrix: all rows.
    pub fn determinant(mut self) -> Option<R> {
        self.0.pop()
    }

    /// Returns the minor of all `count` rows but one.
    pub fn without(&self, row: usize, count: usize) -> &R {
        &self.0[((1 << count) - 1) ^ (1 << row)]
    }
}

/// Expands the minor of a set along its last column.
fn expanded<R: Ring, const D: usize>(rows: &[[R; D]], set: usize, column: usize, minors: &[R]) -> R {
    let mut members = (0..rows.len()).rev().filter(|row| set & (1 << row) != 0);
    let term = |row: usize| {
        let rest = set ^ (1 << row);
        if rest == 0 { rows[row][column].clone() } else { rows[row][column].times(&minors[rest]) }
    };
    // The last row has a positive sign.
    let first = members.next().map_or_else(|| rows[0][column].clone(), term);
    members.enumerate().fold(
        first,
        |sum, (at, row)| {
            if at % 2 == 0 { sum.minus(&term(row)) } else { sum.plus(&term(row)) }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn determinants_are_those_of_products_of_triangles() {
        // The product of a lower and an upper triangular matrix with units on the diagonal, but for one.
        let entry = |i: usize, j: usize| (i * 5 + j * 3) as i64 % 7 - 3;
        let lower = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Equal => 1,
            std::cmp::Ordering::Less => 0,
            std::cmp::Ordering::Greater => entry(i, j),
        };
        let upper = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Equal if i == 2 => -4,
            std::cmp::Ordering::Equal => 1,
            std::cmp::Ordering::Less => entry(i, j),
            std::cmp::Ordering::Greater => 0,
        };
        let rows: [[i64; 6]; 6] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| lower(i, k) * upper(k, j)).sum()));
        assert_eq!(Minors::of(&rows).determinant(), Some(-4));
        let mut swapped = rows;
        swapped.swap(1, 4);
        assert_eq!(Minors::of(&swapped).determinant(), Some(4));
        // The minors of seven rows: the last one is zero but for one.
        let more: [[i64; 6]; 7] = std::array::from_fn(|i| if i < 6 { rows[i] } else { [0; 6] });
        let minors = Minors::of(&more);
        assert_eq!((*minors.without(6, 7), *minors.without(2, 7)), (-4, 0));
    }
}
