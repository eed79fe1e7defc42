//! Circumradii and determinants in numbers of two floats.
//!
//! **Statement.** The circumcentre relative to a corner is a vector divided by twice the determinant of the cell. So the
//! circumradius is the quotient of two lengths. Both are polynomials, evaluated here in sums of two floats with about 104
//! binary digits and rounded once. Unless the cell is thin ([`crate::dual::THIN`]), cancellation takes less than 50 of them, so
//! the relative error of the radius is a few units in the last place.
//!
//! **Source.** Dekker, "A floating-point technique for extending the available precision" (1971).
//!
//! **Range.** Scaled coordinates are below `2^196` ([`septet_geometry::range`]), so products of four fit.
//!
//! **Work.** O(1).

use septet_geometry::point::Point;

/// A sum of two floats, of which the second is below half a unit in the last place of the first.
#[derive(Clone, Copy, Debug, Default)]
struct Double(f64, f64);

impl Double {
    /// Returns `a + b`, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Double(high, (a - (high - of_b)) + (b - of_b))
    }

    /// Returns `a b`, exactly.
    fn product(a: f64, b: f64) -> Self {
        /// Divides a float into two halves of 26 digits.
        fn halves(a: f64) -> (f64, f64) {
            let big = 134_217_729.0 * a;
            let high = big - (big - a);
            (high, a - high)
        }
        let high = a * b;
        let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
        Double(high, a2 * b2 - (((high - a1 * b1) - a2 * b1) - a1 * b2))
    }

    fn plus(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.0, other.0), Self::sum(self.1, other.1));
        let all = Self::sum(high.0, high.1 + low.0);
        Self::sum(all.0, all.1 + low.1)
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Double(-other.0, -other.1))
    }

    fn times(self, other: Self) -> Self {
        let high = Self::product(self.0, other.0);
        Self::sum(high.0, high.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

type Vector = [Double; 3];

fn dot(a: &Vector, b: &Vector) -> Double {
    (0..3).map(|i| a[i].times(b[i])).fold(Double::default(), Double::plus)
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        a[i].times(b[j]).minus(a[j].times(b[i]))
    })
}

fn scaled(a: &Vector, by: Double) -> Vector {
    a.map(|x| x.times(by))
}

/// Returns the vector from the first corner of a cell to another one; its third coordinate is 0 in the plane.
fn side<P: Point>(cell: &[P], corner: usize) -> Vector {
    let difference = |axis| Double::sum(cell[corner].coord(axis), -cell[0].coord(axis));
    std::array::from_fn(|axis| if axis < P::DIM { difference(axis) } else { Double::default() })
}

/// Returns the difference `b + steps length - a`.
fn moved(a: f64, b: f64, (steps, length): (i32, f64)) -> Double {
    Double::sum(b, -a).plus(Double::product(f64::from(steps), length))
}

/// Returns `b + steps length - a`, rounded once.
pub(crate) fn difference(a: f64, b: f64, shift: (i32, f64)) -> f64 {
    moved(a, b, shift).0
}

/// Returns the orientation determinant of a positively oriented cell whose corners are images: corner `i` lies at `cell[i]` plus
/// `steps[i]` times `lengths`. The first corner has no steps. `None` if the cell is thin.
pub(crate) fn determinant_of_images<P: Point>(cell: &[P], steps: &[[i32; 3]], lengths: P) -> Option<f64> {
    /// The smallest determinant of a cell that is not thin, over the product of the lengths of its edges at the first corner.
    const FLAT: f64 = 1e-12;
    let side = |corner: usize| -> Vector {
        std::array::from_fn(|axis| {
            if axis >= P::DIM {
                return Double::default();
            }
            let shift = (steps[corner][axis], lengths.coord(axis));
            moved(cell[0].coord(axis), cell[corner].coord(axis), shift)
        })
    };
    let (a, b) = (side(1), side(2));
    let normal = cross(&a, &b);
    let size = |edge: &Vector| dot(edge, edge).0.sqrt();
    let (determinant, sizes) = if P::DIM == 2 {
        (normal[2].0, size(&a) * size(&b))
    } else {
        let c = side(3);
        (dot(&normal, &c).0, size(&a) * size(&b) * size(&c))
    };
    (determinant > FLAT * sizes).then_some(determinant)
}

/// Returns the orientation determinant of a positively oriented cell that is not thin.
pub(crate) fn determinant<P: Point>(cell: &[P]) -> f64 {
    let normal = cross(&side(cell, 1), &side(cell, 2));
    if P::DIM == 2 { normal[2].0 } else { dot(&normal, &side(cell, 3)).0 }
}

/// Returns the circumradius of a cell that is not thin.
pub(crate) fn circumradius<P: Point>(cell: &[P]) -> f64 {
    let (a, b) = (side(cell, 1), side(cell, 2));
    let [squared_a, squared_b] = [dot(&a, &a), dot(&b, &b)];
    let normal = cross(&a, &b);
    if P::DIM == 2 {
        // The product of the sides over twice the determinant.
        let c: Vector = std::array::from_fn(|axis| a[axis].minus(b[axis]));
        let [x, y, z] = [squared_a, squared_b, dot(&c, &c)].map(|square| square.0.sqrt());
        return x * y / (2.0 * normal[2].0.abs()) * z;
    }
    let c = side(cell, 3);
    let terms =
        [scaled(&cross(&b, &c), squared_a), scaled(&cross(&c, &a), squared_b), scaled(&normal, dot(&c, &c))];
    let over: [f64; 3] =
        std::array::from_fn(|axis| terms[0][axis].plus(terms[1][axis]).plus(terms[2][axis]).0);
    let under = 2.0 * dot(&normal, &c).0.abs();
    over.map(|x| x / under).iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::mix;

    use super::*;
    use crate::exact;

    #[test]
    fn radii_of_flat_cells_are_rounded_once() {
        let mut state = 5;
        let mut draw = || {
            state = mix(state, 0x9E37_79B9_7F4A_7C15);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for round in 0..400 {
            let height = 0.5f64.powi(round % 20);
            let plane = [[draw(), draw()], [draw(), draw()], [draw(), draw()]].map(DVec2::from);
            let space = [(); 4].map(|()| DVec3::new(draw(), draw(), height * draw()));
            for (cell, sign) in [(space, 1.0), ([space[1], space[0], space[2], space[3]], -1.0)] {
                let (found, expected) = (sign * determinant(&cell), sign * exact::measure(&cell));
                assert!((found - expected).abs() <= f64::EPSILON * expected.abs(), "{found} {expected}");
            }
            check(&plane, exact::circumcentre(&plane).length());
            check(&space, exact::circumcentre(&space).length());
        }
    }

    fn check<P: Point>(cell: &[P], expected: f64) {
        let radius = circumradius(cell);
        assert!((radius - expected).abs() <= 4.0 * f64::EPSILON * expected, "{radius} {expected}");
    }
}
