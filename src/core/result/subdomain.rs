//! The part of a triangulation that a process holds, if several processes triangulate their points together.

use serde::{Deserialize, Serialize};

use septet_geometry::point::Point;
use septet_geometry::range::scale;
use septet_protocol::ids::Rank;
use septet_protocol::transport::Placement;
use septet_workers::share::{CellRows, PieceRows, Places};
use septet_workers::state::rows::{HULL, INTERFACE};

use crate::result::run::Accounting;

/// The part of a triangulation that a process holds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Part {
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the affine hull of the points of all processes; -1 for no points. If it is less than `space`, the
    /// subdomains are empty.
    pub dimension: isize,
    /// The input points by their use. The numbers count the points of all processes. The lists of duplicates and of dropped
    /// points contain those of this process. The first point at the same coordinates may belong to another process.
    pub points: Accounting,
    /// Number of cells of all processes.
    pub cells: u64,
    /// Number of facets of the convex hull of all points.
    pub hull_facets: u64,
    /// The process of each worker.
    pub placement: Placement,
    /// The subdomain of each worker of this process, in the order of the ranks.
    pub subdomains: Vec<Subdomain>,
}

/// The fields of a [`Part`] that all processes have in common, except the placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartTotals {
    space: usize,
    dimension: isize,
    /// Number of input points.
    input: u64,
    /// Number of vertices.
    used: u64,
    cells: u64,
    hull_facets: u64,
}

impl Part {
    /// Returns the totals, from which a process without workers makes its part.
    pub fn totals(&self) -> PartTotals {
        let Part { space, dimension, points: Accounting { input, used, .. }, cells, hull_facets, .. } = *self;
        PartTotals { space, dimension, input, used, cells, hull_facets }
    }

    /// Creates the part of a process without workers.
    pub fn of_totals(totals: PartTotals, placement: Placement) -> Self {
        let PartTotals { space, dimension, input, used, cells, hull_facets } = totals;
        Part {
            space,
            dimension,
            points: Accounting { input, used, ..Accounting::default() },
            cells,
            hull_facets,
            placement,
            subdomains: Vec::new(),
        }
    }
}

/// The subdomain triangulation of a worker: its points, and the cells whose lexicographically smallest vertices they are.
/// Every cell of the triangulation is in one subdomain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Subdomain {
    /// The rank of the worker, at least 1.
    pub rank: u32,
    /// The input index of each point: first the points of the worker, then the other vertices of its cells.
    pub ids: Vec<u64>,
    /// Coordinates, `space` per point, as in the input. A coordinate that was -0.0 is 0.0.
    pub coordinates: Vec<f64>,
    /// The rank of the worker that owns each point. A point belongs to this worker iff it is `rank`.
    pub owners: Vec<u32>,
    /// Number of points of the worker.
    pub owned: usize,
    cells: Cells,
}

/// The cells of a subdomain.
#[derive(Clone, Debug, PartialEq)]
struct Cells {
    /// Number of vertices of a cell.
    corners: usize,
    /// Number of entries of a row.
    width: usize,
    /// For each cell its vertices, then its neighbours, as in the piece. The cells of stars have no neighbours.
    rows: Vec<u32>,
    /// The neighbours on other workers, by rank and cell.
    seam: Vec<(u32, u32)>,
}

/// The cell across a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Neighbour {
    /// The facet is on the convex hull.
    Hull,
    /// A cell of the same subdomain.
    Local(u32),
    /// A cell of another worker.
    Remote {
        /// The rank of the worker.
        rank: u32,
        /// The cell of its subdomain.
        cell: u32,
    },
}

impl Subdomain {
    /// Creates the subdomain of a rank from its piece. Divides coordinates by 2 to the power `exponent`. Returns `None` if
    /// the arrays do not fit together.
    pub(crate) fn of_piece<P: Point>(
        rank: Rank,
        piece: PieceRows,
        (exponent, placement): (i32, Placement),
    ) -> Option<Self> {
        let PieceRows { ids, rows, seam, places, .. } = piece;
        if seam.iter().any(|seam| !placement.has_worker(seam.rank)) {
            return None;
        }
        let corners = P::DIM + 1;
        let seam = seam.into_iter().map(|seam| (seam.rank, seam.cell)).collect();
        Self::of::<P>(rank, (ids, places), Cells { corners, width: 2 * corners, rows, seam }, exponent)
    }

    /// Creates the subdomain of a rank from the cells of its stars, whose neighbours are unknown. Divides coordinates by 2 to
    /// the power `exponent`. Returns `None` if the arrays do not fit together.
    pub(crate) fn of_stars<P: Point>(rank: Rank, cells: CellRows, exponent: i32) -> Option<Self> {
        let CellRows { rows, ids, places, .. } = cells;
        let mut order: Vec<u32> = (0..ids.len() as u32).collect();
        order.sort_unstable_by_key(|&point| ids[point as usize]);
        let position = |id: &u64| {
            let at = order.binary_search_by_key(id, |&point| ids[point as usize]).ok()?;
            Some(order[at])
        };
        let rows = rows.iter().map(position).collect::<Option<Vec<u32>>>()?;
        let corners = P::DIM + 1;
        Self::of::<P>(
            rank,
            (ids, places),
            Cells { corners, width: corners, rows, seam: Vec::new() },
            exponent,
        )
    }

    /// Creates a subdomain without the points that are neither those of the rank nor vertices of its cells.
    fn of<P: Point>(
        rank: Rank,
        (mut ids, places): (Vec<u64>, Places),
        mut cells: Cells,
        exponent: i32,
    ) -> Option<Self> {
        let positions: &[P] = bytemuck::try_cast_slice(&places.coordinates).ok()?;
        let mut owners = places.owners;
        if [positions.len(), owners.len()] != [ids.len(); 2] {
            return None;
        }
        let Cells { corners, width, .. } = cells;
        let mut keeps: Vec<bool> = owners.iter().map(|&owner| owner == rank).collect();
        let owned = keeps.iter().filter(|keeps| **keeps).count();
        if !owners[..owned].iter().all(|&owner| owner == rank) {
            return None;
        }
        for row in cells.rows.chunks_exact(width) {
            for &vertex in &row[..corners] {
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
        for row in cells.rows.chunks_exact_mut(width) {
            row[..corners].iter_mut().for_each(|vertex| *vertex = kept[*vertex as usize]);
        }
        let mut coordinates = Vec::with_capacity(next as usize * P::DIM);
        for (&x, _) in positions.iter().zip(&keeps).filter(|(_, keeps)| **keeps) {
            let x = if exponent == 0 { x } else { scale(x, -exponent) };
            coordinates.extend((0..P::DIM).map(|i| x.coord(i)));
        }
        keep(&mut ids, &keeps);
        keep(&mut owners, &keeps);
        Some(Subdomain { rank, ids, coordinates, owners, owned, cells })
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.rows.len() / self.cells.width
    }

    /// Returns the vertices of a cell as positions in [`Subdomain::ids`]: `space + 1` of them, positively oriented.
    ///
    /// # Panics
    /// Panics if there is no such cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.cells.rows[cell * self.cells.width..][..self.cells.corners]
    }

    /// Returns the cell across the facet opposite the vertex in `slot` of a cell.
    ///
    /// # Panics
    /// Panics if there is no such cell, or if `slot` is more than `space`. Also panics if the cells have no neighbours, as
    /// those of a simulation, which only the command line runs on several processes.
    pub fn neighbour(&self, cell: usize, slot: usize) -> Neighbour {
        let Cells { corners, width, rows, seam } = &self.cells;
        match rows[cell * width..][..*width][*corners..][slot] {
            HULL => Neighbour::Hull,
            code if code > INTERFACE => {
                let (rank, cell) = seam[(code - INTERFACE) as usize - 1];
                Neighbour::Remote { rank, cell }
            }
            code => Neighbour::Local(code),
        }
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
    use septet_workers::share::{Places, Seam};

    use super::*;

    /// A triangle of two own points and a ghost, after a ghost without a cell. Its neighbour is on rank 2.
    fn piece() -> PieceRows {
        PieceRows {
            ids: vec![7, 8, 5, 1 << 40],
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

    fn made(piece: PieceRows) -> Option<Subdomain> {
        Subdomain::of_piece::<DVec2>(1, piece, (1, Placement::new(2, 1).unwrap()))
    }

    /// The same triangle from stars.
    fn stars() -> CellRows {
        let PieceRows { ids, places, .. } = piece();
        CellRows { rows: vec![7, 8, 1 << 40], ids, places, ..CellRows::default() }
    }

    #[test]
    fn points_without_a_use_are_removed() {
        let subdomain = made(piece()).unwrap();
        assert_eq!((&subdomain.ids[..], &subdomain.owners[..]), (&[7, 8, 1 << 40][..], &[1, 1, 2][..]));
        assert_eq!(subdomain.coordinates, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        assert_eq!((subdomain.owned, subdomain.cell_count(), subdomain.cell(0)), (2, 1, &[0, 1, 2][..]));
        let across = [0, 1, 2].map(|slot| subdomain.neighbour(0, slot));
        assert_eq!(across, [Neighbour::Hull, Neighbour::Remote { rank: 2, cell: 9 }, Neighbour::Hull]);
        assert_eq!(made(PieceRows::default()).unwrap().cell_count(), 0);
    }

    #[test]
    fn cells_of_stars_are_those_of_the_piece_without_neighbours() {
        let (of_stars, of_piece) =
            (Subdomain::of_stars::<DVec2>(1, stars(), 1).unwrap(), made(piece()).unwrap());
        assert_eq!((of_stars.cell_count(), of_stars.cell(0)), (1, of_piece.cell(0)));
        assert_eq!(Subdomain { cells: of_piece.cells.clone(), ..of_stars }, of_piece);
        let unknown = CellRows { rows: vec![7, 8, 6], ..stars() };
        assert_eq!(Subdomain::of_stars::<DVec2>(1, unknown, 1), None);
        let empty = Subdomain::of_stars::<DVec2>(1, CellRows::default(), 1);
        assert_eq!(empty.unwrap().cell_count(), 0);
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let spoilt: [fn(&mut PieceRows); 5] = [
            |piece| piece.ids.push(3),
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
