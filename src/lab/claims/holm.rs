//! Holm's adjustment of p-values (1979).
//!
//! **Statement.** Let `p_1 <= .. <= p_m` be the p-values of m tests. The adjusted value of `p_i` is the maximum over
//! `j <= i` of `(m - j + 1) p_j`, at most 1. Reject every hypothesis whose adjusted value is at most a. Then the
//! probability that any true hypothesis is rejected is at most a, for any dependence between the tests.

/// Returns the adjusted p-values, in the order of the p-values. An undefined p-value counts as 1.
pub(super) fn adjusted(all: &[f64]) -> Vec<f64> {
    let defined = |p: f64| if p.is_nan() { 1.0 } else { p };
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| defined(all[a]).total_cmp(&defined(all[b])));
    let (mut out, mut largest) = (vec![0.0; all.len()], 0.0f64);
    for (rank, &at) in order.iter().enumerate() {
        largest = largest.max((all.len() - rank) as f64 * defined(all[at])).min(1.0);
        out[at] = largest;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holm's procedure at 5 % on 0.01, 0.04, 0.03, 0.005 rejects the first and the last.
    #[test]
    fn values_by_hand() {
        assert_eq!(adjusted(&[0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02]);
        assert_eq!(adjusted(&[0.5, f64::NAN]), [1.0, 1.0]);
        assert!(adjusted(&[]).is_empty());
    }
}
