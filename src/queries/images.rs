//! Volumes of cells in a periodic box, whose vertices are images of points.
//!
//! **Statement.** A vertex lies at its point plus whole numbers of lengths. The volume of a cell is a polynomial in the points and the
//! lengths.
//!
//! **Rounding.** The polynomial is evaluated in numbers of two floats (`double`), or by big integers if the cell is thin, and rounded once.
//! So the relative error of a volume is below 1e-15.
//!
//! **Work.** O(1) for each cell.

use septet_geometry::range::scale;

use crate::dimension::Dimension;
use crate::power::{exponent_of, times};
use crate::{double, exact, loops};

/// Returns the area or volume of each cell in a periodic box with these lengths. `cells` are rows of `DIM + 1` points, positively
/// oriented, and `offsets` has `DIM` whole numbers of lengths to each of their vertices, which are 0 along axes that are not periodic.
///
/// # Panics
/// Panics if there is no such point, or if there are fewer lengths or offsets.
pub fn volumes_in_box<P: Dimension>(
    points: &[P],
    (cells, offsets): (&[u32], &[i32]),
    lengths: &[Option<f64>],
) -> Vec<f64> {
    let corners = P::DIM + 1;
    let exponent = exponent_of(lengths.iter().flatten().copied().fold(0.0, f64::max));
    let mut scaled = P::default();
    for (axis, length) in lengths.iter().enumerate().take(P::DIM) {
        scaled.set_coord(axis, times(length.unwrap_or(0.0), exponent));
    }
    let factorial = if P::DIM == 2 { 2.0 } else { 6.0 };
    loops::map(cells.len() / corners, |at| {
        let (first, mut cell, mut steps) = (at * corners, [P::default(); 4], [[0; 3]; 4]);
        for corner in 0..corners {
            cell[corner] = scale(points[cells[first + corner] as usize], exponent);
            let own = &offsets[(first + corner) * P::DIM..][..P::DIM];
            let base = &offsets[first * P::DIM..][..P::DIM];
            own.iter().zip(base).enumerate().for_each(|(axis, (to, from))| steps[corner][axis] = to - from);
        }
        let (cell, steps) = (&cell[..corners], &steps[..corners]);
        let measure = double::determinant_of_images(cell, steps, scaled)
            .unwrap_or_else(|| exact::measure_of_images(cell, steps, scaled));
        (0..P::DIM).fold(measure / factorial, |volume, _| times(volume, -exponent))
    })
}
