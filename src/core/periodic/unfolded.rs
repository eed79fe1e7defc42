//! A periodic triangulation as cells with all their vertices, for pictures.

use std::collections::BTreeMap;

use super::lattice::Periodic;
use super::quotient::PeriodicCells;

/// The cells of a periodic triangulation, each once, with vertices outside of the box as points of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unfolded {
    /// The points of the input, then the images that are vertices of cells, in the order of their rows and offsets:
    /// `space` coordinates for each. Coordinates of images are rounded.
    pub coordinates: Vec<f64>,
    /// The row of each point.
    pub rows: Vec<u64>,
    /// The offset of each point: `space` whole numbers of lengths.
    pub offsets: Vec<i32>,
    /// `space + 1` points for each cell, in the canonical order of cells.
    pub cells: Vec<u64>,
}

impl Unfolded {
    /// Unfolds the cells of a run. `coordinates` are those of the input, `space` for each point, and `cells` are rows.
    pub fn of(
        (cells, periodic): (&[u64], &PeriodicCells),
        coordinates: &[f64],
        periodic_box: &Periodic,
    ) -> Self {
        let space = periodic_box.lengths.len();
        let points = (coordinates.len() / space) as u64;
        let offsets = periodic.offsets.chunks_exact(space);
        let is_image = |offset: &[i32]| offset.iter().any(|&steps| steps != 0);
        let mut images: BTreeMap<(u64, &[i32]), u64> = BTreeMap::new();
        for (&row, offset) in cells.iter().zip(offsets.clone()).filter(|(_, offset)| is_image(offset)) {
            images.insert((row, offset), 0);
        }
        let mut unfolded = Unfolded {
            coordinates: coordinates.to_vec(),
            rows: (0..points).collect(),
            offsets: vec![0; coordinates.len()],
            cells: Vec::with_capacity(cells.len()),
        };
        for (&(row, offset), point) in &mut images {
            *point = unfolded.rows.len() as u64;
            unfolded.rows.push(row);
            unfolded.offsets.extend_from_slice(offset);
            let at = &coordinates[row as usize * space..][..space];
            for ((x, &steps), length) in at.iter().zip(offset).zip(&periodic_box.lengths) {
                unfolded.coordinates.push(x + length.map_or(0.0, |length| f64::from(steps) * length));
            }
        }
        let vertices = cells.iter().zip(offsets);
        unfolded.cells.extend(vertices.map(|(&row, offset)| *images.get(&(row, offset)).unwrap_or(&row)));
        unfolded
    }
}
