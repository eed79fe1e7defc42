//! The share of a worker: its points, and the cells whose lexicographically smallest vertices they are.

use septet_geometry::point::Point;
use septet_geometry::range::scale;
use septet_protocol::ids::NodeId;
use septet_protocol::transport::Placement;
use septet_workers::share::{PieceRows, Places, Seam};
use septet_workers::state::rows::{HULL, INTERFACE};

/// What a worker holds at the end of a run: its points, and the cells whose lexicographically smallest vertices they are.
/// Every point and every cell of a triangulation is in one share.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WorkerShare {
    /// The rank of the worker, at least 1.
    pub rank: u32,
    /// The input index of each point: first the points of the worker, then other points, the other vertices of its cells
    /// among them. A run that keeps places keeps no more than these.
    pub ids: Vec<u64>,
    /// Number of points of the worker.
    pub owned: usize,
    /// Coordinates, `space` per point, as in the input. A coordinate that was -0.0 is 0.0. Empty unless the run keeps places,
    /// as every run by several processes does.
    pub coordinates: Vec<f64>,
    /// The rank of the worker that owns each point. A point belongs to this worker iff it is `rank`. Empty unless the run keeps
    /// places.
    pub owners: Vec<u32>,
    /// The leaves of the partition tree that the worker holds, each with its number of cells. The cells of a leaf are
    /// consecutive. [`crate::triangulate`] makes one leaf for each worker.
    pub leaves: Vec<(NodeId, u64)>,
    /// Number of vertices of a cell.
    corners: usize,
    /// Number of entries of a row.
    width: usize,
    /// For each cell its vertices, then its neighbours, if it has any, as in [`PieceRows`].
    rows: Vec<u32>,
    /// The neighbours on other workers.
    seam: Vec<Seam>,
}

/// The cell across a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Neighbour {
    /// The facet is on the convex hull.
    Hull,
    /// A cell of the same share.
    Local(u32),
    /// A cell of another worker.
    Remote {
        /// The rank of the worker.
        rank: u32,
        /// The cell of its share.
        cell: u32,
    },
}

impl WorkerShare {
    /// Creates the share of a rank of a machine in this `placement`. Divides coordinates by 2 to the power `exponent`. Returns
    /// `None` if the arrays do not fit together.
    pub(crate) fn of<P: Point>(
        rank: u32,
        piece: PieceRows,
        (exponent, placement): (i32, Placement),
    ) -> Option<Self> {
        let corners = P::DIM + 1;
        let width = piece.width(corners);
        let PieceRows { ids, owned, leaves, rows, seam, places, .. } = piece;
        if owned > ids.len() || seam.iter().any(|seam| !placement.has_worker(seam.rank)) {
            return None;
        }
        let (coordinates, owners) = (Vec::new(), Vec::new());
        let share = WorkerShare { rank, ids, owned, coordinates, owners, leaves, corners, width, rows, seam };
        if places == Places::default() { Some(share) } else { share.placed::<P>(places, exponent) }
    }

    /// Adds the places of the points, and removes the points that are neither those of the worker nor vertices of its cells.
    fn placed<P: Point>(mut self, places: Places, exponent: i32) -> Option<Self> {
        let positions: &[P] = bytemuck::try_cast_slice(&places.coordinates).ok()?;
        self.owners = places.owners;
        if [positions.len(), self.owners.len()] != [self.ids.len(); 2] {
            return None;
        }
        if (0..).zip(&self.owners).any(|(at, &owner)| (owner == self.rank) != (at < self.owned)) {
            return None;
        }
        let mut keeps: Vec<bool> = (0..self.ids.len()).map(|at| at < self.owned).collect();
        for row in self.rows.chunks_exact(self.width) {
            for &vertex in &row[..self.corners] {
                *keeps.get_mut(vertex as usize)? = true;
            }
        }
        let mut next = 0;
        let kept = keeps.iter().map(|&keeps| {
            let at = next;
            next += u32::from(keeps);
            at
        });
        let kept: Vec<u32> = kept.collect();
        for row in self.rows.chunks_exact_mut(self.width) {
            row[..self.corners].iter_mut().for_each(|vertex| *vertex = kept[*vertex as usize]);
        }
        self.coordinates.reserve_exact(next as usize * P::DIM);
        for (&x, _) in positions.iter().zip(&keeps).filter(|(_, keeps)| **keeps) {
            let x = if exponent == 0 { x } else { scale(x, -exponent) };
            self.coordinates.extend((0..P::DIM).map(|i| x.coord(i)));
        }
        keep(&mut self.ids, &keeps);
        keep(&mut self.owners, &keeps);
        Some(self)
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.rows.len() / self.width
    }

    /// Returns the vertices of a cell as positions in [`WorkerShare::ids`]: `space + 1` of them, positively oriented.
    ///
    /// # Panics
    /// Panics if there is no such cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.rows[cell * self.width..][..self.corners]
    }

    /// Returns the input indices of the vertices of a cell, positively oriented.
    ///
    /// # Panics
    /// Panics if there is no such cell.
    pub fn cell_ids(&self, cell: usize) -> impl Iterator<Item = u64> + '_ {
        self.cell(cell).iter().map(|&vertex| self.ids[vertex as usize])
    }

    /// Returns the leaf of each cell.
    pub fn leaf_of_cells(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.leaves.iter().flat_map(|&(leaf, cells)| std::iter::repeat_n(leaf, cells as usize))
    }

    /// Returns `true` if the cells have neighbours: always after [`crate::triangulate`], and after [`crate::simulate`] if the run
    /// keeps them ([`crate::spec::Keep::neighbours`]).
    pub fn has_neighbours(&self) -> bool {
        self.width > self.corners
    }

    /// Returns the cell across the facet opposite the vertex in `slot` of a cell, or `None` if the cells have no neighbours.
    ///
    /// # Panics
    /// Panics if there is no such cell, or if `slot` is more than `space`.
    pub fn neighbour(&self, cell: usize, slot: usize) -> Option<Neighbour> {
        assert!(slot < self.corners, "a cell has {} facets", self.corners);
        let row = &self.rows[cell * self.width..][..self.width];
        Some(match *row.get(self.corners + slot)? {
            HULL => Neighbour::Hull,
            code if code > INTERFACE => {
                let Seam { rank, cell } = self.seam[(code - INTERFACE) as usize - 1];
                Neighbour::Remote { rank, cell }
            }
            code => Neighbour::Local(code),
        })
    }

    /// Returns the neighbours on other workers.
    pub(crate) fn seam(&self) -> &[Seam] {
        &self.seam
    }
}

/// Removes the items whose flag is not set.
fn keep<T>(items: &mut Vec<T>, flags: &[bool]) {
    let mut at = 0..items.len();
    items.retain(|_| at.next().is_some_and(|i| flags[i]));
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    /// A triangle of two own points and a ghost, after a ghost without a cell. Its neighbour is on rank 2.
    fn piece() -> PieceRows {
        PieceRows {
            ids: vec![7, 8, 5, 1 << 40],
            owned: 2,
            has_neighbours: true,
            rows: vec![0, 1, 3, HULL, INTERFACE + 1, HULL],
            open: vec![0],
            seam: vec![Seam { rank: 2, cell: 9 }],
            places: Places {
                coordinates: vec![0.0, 0.0, 2.0, 0.0, 9.0, 9.0, 0.0, 2.0],
                owners: vec![1, 1, 2, 2],
            },
            ..PieceRows::default()
        }
    }

    fn made(piece: PieceRows) -> Option<WorkerShare> {
        WorkerShare::of::<DVec2>(1, piece, (1, Placement::new(2, 1).unwrap()))
    }

    #[test]
    fn points_without_a_use_are_removed() {
        let share = made(piece()).unwrap();
        assert_eq!((&share.ids[..], &share.owners[..]), (&[7, 8, 1 << 40][..], &[1, 1, 2][..]));
        assert_eq!(share.coordinates, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        assert_eq!((share.owned, share.cell_count(), share.cell(0)), (2, 1, &[0, 1, 2][..]));
        let across = [0, 1, 2].map(|slot| share.neighbour(0, slot).unwrap());
        assert_eq!(across, [Neighbour::Hull, Neighbour::Remote { rank: 2, cell: 9 }, Neighbour::Hull]);
        assert_eq!(made(PieceRows::default()).unwrap().cell_count(), 0);
    }

    #[test]
    fn shares_without_places_keep_all_points() {
        let share = made(PieceRows { places: Places::default(), ..piece() }).unwrap();
        assert_eq!((share.ids.len(), share.cell(0)), (4, &[0, 1, 3][..]));
        assert!(share.cell_ids(0).eq([7, 8, 1 << 40]) && share.owners.is_empty());
    }

    #[test]
    fn cells_without_neighbours_say_so() {
        let rows = vec![0, 1, 3];
        let share = made(PieceRows { has_neighbours: false, rows, seam: Vec::new(), ..piece() }).unwrap();
        assert!(!share.has_neighbours());
        assert_eq!((share.cell_count(), share.cell(0), share.neighbour(0, 2)), (1, &[0, 1, 2][..], None));
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let spoilt: [fn(&mut PieceRows); 6] = [
            |piece| piece.ids.push(3),
            |piece| piece.owned = 3,
            |piece| piece.places.coordinates.push(0.5),
            |piece| piece.places.owners[0] = 2,
            |piece| piece.rows[0] = 4,
            |piece| piece.seam[0].rank = 3,
        ];
        for spoil in spoilt {
            let mut other = piece();
            spoil(&mut other);
            assert_eq!(made(other), None);
        }
    }
}
