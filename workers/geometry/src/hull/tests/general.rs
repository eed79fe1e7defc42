//! Stars of dimensions 4 to 6 against brute force.

use super::{check_extended, check_stars};
use crate::hash::Draw;
use crate::higher::VecN;
use crate::point::{Point, lex_cmp};
use crate::predicates::{Sign, orientation};

/// The points of a grid whose coordinates are below `sides`.
fn grid<const N: usize>(sides: [u32; N]) -> Vec<VecN<N>> {
    let count = sides.iter().product::<u32>();
    let at = |mut number: u32| {
        VecN(sides.map(|side| {
            let x = number % side;
            number /= side;
            f64::from(x)
        }))
    };
    (0..count).map(at).collect()
}

/// A cross polytope with its centre: all corners are cospherical.
fn cross<const N: usize>() -> Vec<VecN<N>> {
    let mut points = vec![VecN([0.0; N])];
    for axis in 0..N {
        for x in [-1.0, 1.0] {
            let mut p = [0.0; N];
            p[axis] = x;
            points.push(VecN(p));
        }
    }
    points
}

/// Points of a few coordinates, so that many are cospherical or in a common hyperplane.
fn coarse<P: Point>(draw: &mut Draw, n: usize, range: usize) -> Vec<P> {
    let mut points: Vec<P> = (0..n)
        .map(|_| {
            let mut p = P::default();
            (0..P::DIM).for_each(|axis| p.set_coord(axis, draw.below(range) as f64 * 0.25));
            p
        })
        .collect();
    points.sort_unstable_by(lex_cmp);
    points.dedup();
    points
}

fn spans<P: Point>(points: &[P]) -> bool {
    points.len() > P::DIM && points.windows(P::DIM + 1).any(|cell| orientation(cell) != Sign::Zero)
}

fn stars_of_small_sets<P: Point>(n: usize, rounds: u64) {
    for round in 0..rounds {
        let mut draw = Draw::new(round);
        let random: Vec<P> = (0..n).map(|_| draw.point()).collect();
        check_stars(&random);
        check_extended("random", &random);
        for range in [2, 3, 5] {
            let points = coarse::<P>(&mut draw, n, range);
            if spans(&points) {
                check_stars(&points);
                check_extended("coarse", &points);
                let scaled: Vec<P> =
                    points.iter().map(|&p| p * 2f64.powi(-130 + 80 * (round as i32 % 4))).collect();
                check_stars(&scaled);
            }
        }
    }
}

#[test]
fn stars_of_dimension_4() {
    stars_of_small_sets::<VecN<4>>(13, 6);
    check_stars(&grid([2; 4]));
    check_stars(&cross::<4>());
}

#[test]
fn stars_of_dimension_5() {
    stars_of_small_sets::<VecN<5>>(13, 3);
    check_stars(&cross::<5>());
    check_stars(
        &grid([2, 2, 2, 2, 1])
            .iter()
            .map(|p| *p + VecN([0.0, 0.0, 0.0, 0.0, p.0[0] * p.0[1]]))
            .collect::<Vec<_>>(),
    );
}

#[test]
fn stars_of_dimension_6() {
    stars_of_small_sets::<VecN<6>>(12, 2);
    check_stars(&cross::<6>());
}
