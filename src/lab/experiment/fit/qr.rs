//! Least squares by Householder's QR.
//!
//! **Statement.** For a matrix A with at least as many rows as columns, `A = Q R` with R upper triangular and Q a
//! product of reflections `1 - 2 v v' / v'v` (Golub and Van Loan, Matrix Computations, algorithm 5.2.1). The
//! coefficients that minimise `|A c - y|` are `R^-1` times the first rows of `Q' y`, and `(A'A)^-1 = R^-1 R^-1'`.

/// R by columns, without the zeros below the diagonal, and the first rows of `Q' y`.
pub(super) struct Triangle {
    columns: Vec<Vec<f64>>,
    values: Vec<f64>,
}

/// The solution of a least squares problem.
pub(super) struct Solution {
    /// The coefficients.
    pub coefficients: Vec<f64>,
    /// `(A'A)^-1`, row by row.
    pub bread: Vec<Vec<f64>>,
}

/// Returns the inner product. The sum starts at 0, because `Iterator::sum` starts at -0 and would return -0 for empty
/// vectors.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

impl Triangle {
    /// Factors the matrix of these columns, and applies the reflections to the values.
    pub(super) fn of(mut columns: Vec<Vec<f64>>, mut values: Vec<f64>) -> Self {
        for j in 0..columns.len() {
            let (left, right) = columns.split_at_mut(j + 1);
            let pivot = &mut left[j][j..];
            let norm = dot(pivot, pivot).sqrt();
            if norm == 0.0 {
                continue;
            }
            // With this sign, there is no cancellation.
            let diagonal = if pivot[0] > 0.0 { -norm } else { norm };
            pivot[0] -= diagonal;
            let half = -diagonal * pivot[0];
            for column in right.iter_mut().chain([&mut values]) {
                let share = dot(pivot, &column[j..]) / half;
                column[j..].iter_mut().zip(pivot.iter()).for_each(|(c, v)| *c -= share * v);
            }
            left[j][j] = diagonal;
        }
        for (j, column) in columns.iter_mut().enumerate() {
            column.truncate(j + 1);
        }
        values.truncate(columns.len());
        Triangle { columns, values }
    }

    /// Returns the absolute values of the diagonal entries.
    pub(super) fn diagonal(&self) -> impl Iterator<Item = f64> {
        self.columns.iter().enumerate().map(|(j, column)| column[j].abs())
    }

    /// Returns the solution. No diagonal entry may be 0.
    pub(super) fn solve(&self) -> Solution {
        let width = self.columns.len();
        let inverse: Vec<Vec<f64>> = (0..width).map(|row| self.inverse_row(row)).collect();
        let bread = inverse.iter().map(|a| inverse.iter().map(|b| dot(a, b)).collect());
        Solution {
            coefficients: inverse.iter().map(|row| dot(row, &self.values)).collect(),
            bread: bread.collect(),
        }
    }

    /// Returns a row of `R^-1`: the solution of `x R = e_row`.
    fn inverse_row(&self, row: usize) -> Vec<f64> {
        let mut x = vec![0.0; self.columns.len()];
        for (j, column) in self.columns.iter().enumerate().skip(row) {
            let unit = if j == row { 1.0 } else { 0.0 };
            x[j] = (unit - dot(&x[..j], &column[..j])) / column[j];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The columns of Hilbert's matrix, and the sum of each row: the solution is all ones.
    #[test]
    fn an_ill_conditioned_system_is_solved() {
        let entry = |i: usize, j: usize| 1.0 / (i + j + 1) as f64;
        let columns: Vec<Vec<f64>> = (0..5).map(|j| (0..8).map(|i| entry(i, j)).collect()).collect();
        let values = (0..8).map(|i| (0..5).map(|j| entry(i, j)).sum()).collect();
        let solution = Triangle::of(columns, values).solve();
        for c in &solution.coefficients {
            assert!((c - 1.0).abs() < 1e-10, "{:?}", solution.coefficients);
        }
    }

    /// The product of the normal matrix and its inverse is the identity. Residuals are orthogonal to the columns.
    #[test]
    fn normal_equations_hold() {
        let columns = vec![vec![1.0; 5], vec![-2.0, 0.0, 1.0, 3.0, 7.0], vec![4.0, 0.5, 1.0, -9.0, 2.0]];
        let values = vec![1.0, -1.0, 2.5, 3.0, 0.25];
        let Solution { coefficients, bread } = Triangle::of(columns.clone(), values.clone()).solve();
        let fitted =
            |i: usize| columns.iter().zip(&coefficients).map(|(column, c)| column[i] * c).sum::<f64>();
        let residuals: Vec<f64> = (0..5).map(|i| values[i] - fitted(i)).collect();
        for (i, a) in columns.iter().enumerate() {
            assert!(dot(a, &residuals).abs() < 1e-12);
            for j in 0..3 {
                let entry: f64 = columns.iter().zip(&bread).map(|(b, row)| dot(a, b) * row[j]).sum();
                assert!((entry - f64::from(i == j)).abs() < 1e-12, "{i} {j} {entry}");
            }
        }
    }
}
