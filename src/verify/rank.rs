//! The dimension of the affine hull of points, exactly.
//!
//! **Statement.** [`affine_dimension`] is the dimension of the affine hull of the projections of all points to some axes.
//!
//! **Method.** A point is added to the frame if it is not in the affine hull of the frame. The frame has `r + 1` points, and `r`
//! pivot axes on which their differences have a determinant that is not zero. Then a point is in the affine hull if and only if
//! the determinant of the differences of frame and point is zero on the pivots with each other axis (Schur complement). A point
//! in the hull of a frame is in that of a larger frame, so one pass is enough.
//!
//! **Work.** At most `d` filtered determinants for each point, until the frame spans all axes.

use std::array::from_fn;

use super::predicates::sign;

/// Returns the dimension of the affine hull of the projections to `axes`, or -1 without points.
pub(super) fn affine_dimension<const D: usize>(points: &[[f64; D]], axes: &[usize]) -> i32 {
    let Some(first) = points.first() else { return -1 };
    let mut frame: Vec<&[f64; D]> = vec![first];
    let mut pivots: Vec<usize> = Vec::new();
    for point in points {
        if pivots.len() == axes.len() {
            break;
        }
        frame.push(point);
        let others = axes.iter().copied().filter(|axis| !pivots.contains(axis));
        let raising = { others }.find(|&axis| spans(&frame, &[&pivots[..], &[axis]].concat()));
        match raising {
            Some(axis) => pivots.push(axis),
            None => drop(frame.pop()),
        }
    }
    pivots.len() as i32
}

/// Returns `true` if the differences of `axes.len() + 1` points have a determinant on these axes that is not zero.
fn spans<const D: usize>(frame: &[&[f64; D]], axes: &[usize]) -> bool {
    match axes.len() {
        1 => frame[0][axes[0]] != frame[1][axes[0]],
        2 => of_size::<D, 2>(frame, axes),
        3 => of_size::<D, 3>(frame, axes),
        4 => of_size::<D, 4>(frame, axes),
        5 => of_size::<D, 5>(frame, axes),
        6 => of_size::<D, 6>(frame, axes),
        _ => false,
    }
}

fn of_size<const D: usize, const R: usize>(frame: &[&[f64; D]], axes: &[usize]) -> bool {
    let projected = |i: usize| -> [f64; R] { from_fn(|k| frame[i][axes[k]]) };
    sign(&projected(0), &from_fn::<_, R, _>(|i| projected(i + 1))).is_ne()
}
