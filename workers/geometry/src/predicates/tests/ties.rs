//! The perturbation: one consistent order of heights for all cells.

use glam::{DVec2, DVec3};

use super::samples::{Kind, Samples};
use super::*;

/// The perturbed determinant of `DIM + 2` points has the same sign from the view of each point.
fn check_consistency<P: Point>(kind: Kind, calls: usize) -> usize {
    let mut samples = Samples::new(17);
    let mut ties = 0;
    for _ in 0..calls {
        let (mut points, q) = samples.call::<P>(kind);
        points.push(q);
        let mut seen: Option<bool> = None;
        for i in 0..points.len() {
            let mut cell = points.clone();
            let query = cell.remove(i);
            let sign = orientation(&cell);
            if sign == Sign::Zero {
                continue;
            }
            if sign == Sign::Negative {
                cell.swap(0, 1);
            }
            ties += usize::from(exact::in_sphere(&cell, query) == Sign::Zero);
            let inside = in_sphere(&cell, query);
            // Removing row i and reversing the orientation of the cell each change the sign.
            let side = inside ^ (sign == Sign::Negative) ^ (i % 2 == 1);
            assert_eq!(*seen.get_or_insert(side), side, "{points:?} from {i}");
        }
    }
    ties
}

#[test]
fn every_facet_of_a_tie_gives_the_same_answer() {
    for kind in [Kind::Grid, Kind::Lowest, Kind::Decimal] {
        let ties = (check_consistency::<DVec3>(kind, 2000), check_consistency::<DVec2>(kind, 2000));
        assert!(ties.0 > 50 && ties.1 > 50, "{kind:?} {ties:?}");
    }
    check_consistency::<DVec3>(Kind::Cospherical, 500);
    check_consistency::<DVec2>(Kind::Cospherical, 500);
}

/// The last stage decides ties of points that are too wide for integers.
#[test]
fn ties_of_the_last_stage_are_the_same() {
    let mut samples = Samples::new(23);
    for _ in 0..300 {
        // A grid with one compressed axis is not a cubic grid, but mirror images in it are cospherical.
        let wide = super::samples::two_to(120);
        let far = 1.0 + samples.below(9) as f64 / 16.0;
        let (a, b) = (DVec3::new(far, 0.0, 0.0) * wide, DVec3::new(0.0, far, 0.0) * wide);
        let (c, d) = (DVec3::new(0.0, 0.0, far) * wide, DVec3::new(-far, 0.0, 0.0) * wide);
        let tiny = super::samples::two_to(-100 - samples.below(50) as i32);
        for q in [DVec3::new(0.0, -far, 0.0) * wide, DVec3::new(0.0, -far * wide, tiny)] {
            let mut cell = [a, b, c, d];
            if orientation(&cell) == Sign::Negative {
                cell.swap(0, 1);
            }
            assert_eq!(in_sphere(&cell, q), exact::conflicts(&cell, q));
            let signs = expansion::conflict(&cell, q);
            assert_eq!(signs.det, exact::in_sphere(&cell, q));
            if signs.det == Sign::Zero {
                assert_eq!(tie::conflicts(&cell, q, &signs.cofactors), exact::conflicts(&cell, q));
            }
        }
    }
}
