//! Small meshes for tests of writers and reports.

use septet_core::model::MeshView;

/// A mesh that owns its arrays.
pub struct Sample {
    /// 2 or 3.
    pub dimension: usize,
    /// The coordinates of all points.
    pub coordinates: Vec<f64>,
    /// The cells, as point indices.
    pub cells: Vec<u64>,
    /// The owner of each cell: a worker.
    pub owner: Vec<u32>,
    /// The home leaf of each cell.
    pub owning_leaf: Vec<u64>,
}

impl Sample {
    fn new(dimension: usize, coordinates: Vec<f64>, mut rows: Vec<Vec<u64>>) -> Self {
        rows.sort();
        let owner = (0..rows.len() as u32).map(|i| i % 3).collect();
        let owning_leaf = (0..rows.len() as u64).map(|i| i << 33).collect();
        Self { dimension, coordinates, cells: rows.concat(), owner, owning_leaf }
    }

    /// Returns the mesh in the form that writers accept.
    pub fn view(&self) -> MeshView<'_> {
        MeshView {
            dimension: self.dimension,
            coordinates: &self.coordinates,
            heights: None,
            cells: &self.cells,
            owner: Some(&self.owner),
            owning_leaf: Some(&self.owning_leaf),
            run: None,
            labels: None,
        }
    }
}

/// Returns the unit cube as k x k x k cubes of six tetrahedra each.
pub fn kuhn(k: u64) -> Sample {
    let at = |x: u64, y: u64, z: u64| x + (k + 1) * (y + (k + 1) * z);
    let mut coordinates = Vec::new();
    let mut rows = Vec::new();
    for (z, y, x) in lattice(k + 1) {
        coordinates.extend([x, y, z].map(|c| c as f64 / k as f64));
    }
    for (z, y, x) in lattice(k) {
        for path in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut corner = [x, y, z];
            let mut cell = vec![at(x, y, z)];
            for axis in path {
                corner[axis] += 1;
                cell.push(at(corner[0], corner[1], corner[2]));
            }
            if !matches!(path, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]) {
                cell.swap(2, 3);
            }
            rows.push(cell);
        }
    }
    Sample::new(3, coordinates, rows)
}

fn lattice(k: u64) -> impl Iterator<Item = (u64, u64, u64)> {
    (0..k).flat_map(move |a| (0..k).flat_map(move |b| (0..k).map(move |c| (a, b, c))))
}

/// Returns the unit square as k x k squares of two triangles each.
pub fn squares(k: u64) -> Sample {
    let at = |x: u64, y: u64| x + (k + 1) * y;
    let mut coordinates = Vec::new();
    let mut rows = Vec::new();
    for y in 0..=k {
        for x in 0..=k {
            coordinates.extend([x, y].map(|c| c as f64 / k as f64));
        }
    }
    for y in 0..k {
        for x in 0..k {
            rows.push(vec![at(x, y), at(x + 1, y), at(x + 1, y + 1)]);
            rows.push(vec![at(x, y), at(x + 1, y + 1), at(x, y + 1)]);
        }
    }
    Sample::new(2, coordinates, rows)
}

/// Returns points without cells.
pub fn no_cells(dimension: usize, points: usize) -> Sample {
    let coordinates = (0..points * dimension).map(|i| i as f64 / 8.0).collect();
    Sample::new(dimension, coordinates, Vec::new())
}
