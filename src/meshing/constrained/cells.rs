//! A tetrahedralization that changes.
//!
//! **Statement.** Every cell is positive. Two cells share each face, except on the hull. A point is inserted by
//! removing the cells whose perturbed spheres contain it (Bowyer 1981, Watson 1981). With exact signs, the region that
//! they leave in a Delaunay triangulation is star-shaped. In another triangulation, cells stay until it is. So the new
//! cells are positive.
//!
//! **Work and depth.** A search in a star visits its cells.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::predicates::Sign;

use super::points::Points;

/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// The slots of the face opposite each vertex. The face is positive towards that vertex.
const FACES: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

/// Returns the face of a cell opposite a vertex, positive towards the vertex.
pub(super) fn face_of(cell: &[u32; 4], slot: usize) -> [u32; 3] {
    FACES[slot].map(|i| cell[i])
}

/// Sorts the vertices of a face.
pub(super) fn key(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// Returns the edges of a cell, ends ascending.
pub(super) fn edges_of(c: &[u32; 4]) -> [[u32; 2]; 6] {
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(|(i, j)| [c[i].min(c[j]), c[i].max(c[j])])
}

/// The cells.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    rows: Vec<[u32; 4]>,
    across: Vec<[u32; 4]>,
    free: Vec<u32>,
    /// A cell at each vertex.
    at: Vec<u32>,
    seen: RefCell<Seen>,
}

/// The cells that a search has met.
#[derive(Clone, Debug, Default)]
struct Seen {
    last: Vec<u32>,
    search: u32,
}

impl Seen {
    /// Begins a search among this many cells.
    fn begin(&mut self, cells: usize) {
        self.last.resize(cells, 0);
        self.search = self.search.wrapping_add(1);
        if self.search == 0 {
            self.last.fill(0);
            self.search = 1;
        }
    }

    /// Returns `true` for a cell that is met for the first time.
    fn insert(&mut self, cell: u32) -> bool {
        std::mem::replace(&mut self.last[cell as usize], self.search) != self.search
    }
}

impl Cells {
    /// Connects positive cells. The result does not depend on their order.
    pub(super) fn new(vertices: usize, cells: impl Iterator<Item = [u32; 4]>) -> Self {
        let mut rows: Vec<[u32; 4]> = cells.map(canonical).collect();
        rows.sort_unstable();
        let count = rows.len();
        let mut made = Cells {
            across: vec![[NONE; 4]; count],
            rows,
            free: Vec::new(),
            at: vec![NONE; vertices],
            seen: RefCell::default(),
        };
        let mut faces: Vec<([u32; 3], u32, usize)> = Vec::with_capacity(4 * count);
        for (i, cell) in (0u32..).zip(&made.rows) {
            faces.extend((0..4).map(|slot| (key(face_of(cell, slot)), i, slot)));
            for &v in cell {
                made.at[v as usize] = i;
            }
        }
        faces.sort_unstable();
        for pair in faces.windows(2).filter(|w| w[0].0 == w[1].0) {
            made.join((pair[0].1, pair[0].2), (pair[1].1, pair[1].2));
        }
        made
    }

    fn join(&mut self, a: (u32, usize), b: (u32, usize)) {
        self.across[a.0 as usize][a.1] = b.0;
        self.across[b.0 as usize][b.1] = a.0;
    }

    pub(super) fn row(&self, cell: u32) -> &[u32; 4] {
        &self.rows[cell as usize]
    }

    pub(super) fn across(&self, cell: u32) -> &[u32; 4] {
        &self.across[cell as usize]
    }

    /// Returns all cells with their vertices, in the order of their indices.
    pub(super) fn all(&self) -> impl Iterator<Item = (u32, &[u32; 4])> {
        (0u32..).zip(&self.rows).filter(|(_, row)| row[0] != NONE)
    }

    /// Returns a cell at a vertex for which the test holds, in a search around the vertex.
    fn find(&self, v: u32, mut test: impl FnMut(&[u32; 4]) -> bool) -> Option<u32> {
        let first = self.at[v as usize];
        let mut stack = vec![first];
        let mut seen = self.seen.borrow_mut();
        seen.begin(self.rows.len());
        seen.insert(first);
        while let Some(cell) = stack.pop() {
            let row = self.row(cell);
            if test(row) {
                return Some(cell);
            }
            for (slot, &next) in self.across(cell).iter().enumerate() {
                if row[slot] != v && next != NONE && seen.insert(next) {
                    stack.push(next);
                }
            }
        }
        None
    }

    /// Returns the vertices that share an edge with a vertex, ascending.
    pub(super) fn neighbours(&self, v: u32) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        self.find(v, |row| {
            found.extend(row);
            false
        });
        found.remove(&v);
        found
    }

    /// Returns a cell that contains all given vertices.
    pub(super) fn with(&self, vertices: &[u32]) -> Option<u32> {
        self.find(vertices[0], |row| vertices.iter().all(|v| row.contains(v)))
    }

    /// Returns the cells around an edge of a cell.
    pub(super) fn around(&self, cell: u32, edge: [u32; 2]) -> Vec<u32> {
        let mut found = vec![cell];
        let mut next = 0;
        while next < found.len() {
            let here = found[next];
            for (slot, &other) in self.across(here).iter().enumerate() {
                if !edge.contains(&self.row(here)[slot]) && other != NONE && !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// Returns a cell that contains the point, starting at a cell at `from`.
    fn locate(&self, points: &Points, from: u32, q: u32) -> Option<u32> {
        let mut cell = self.at[from as usize];
        let beyond = |cell: u32, slot: usize| {
            let [a, b, c] = face_of(self.row(cell), slot);
            points.orientation([a, b, c, q]) == Sign::Negative
        };
        for step in 0..self.rows.len() {
            let out = (0..4).map(|i| (i + step) % 4).find(|&slot| beyond(cell, slot));
            let Some(slot) = out else { return Some(cell) };
            cell = self.across(cell)[slot];
            if cell == NONE {
                return None;
            }
        }
        self.all().map(|(cell, _)| cell).find(|&cell| (0..4).all(|slot| !beyond(cell, slot)))
    }

    /// Inserts a point and returns the cells that were removed. In a Delaunay triangulation, these are the cells whose
    /// spheres contain the point. Otherwise, cells stay until all faces around the removed region see the point, no
    /// vertex is lost, and no edge is lost that must be kept. Returns `None` if a cell at the point would have to stay.
    pub(super) fn insert(
        &mut self,
        points: &Points,
        near: u32,
        q: u32,
        keeps: impl Fn([u32; 2]) -> bool,
    ) -> Option<Vec<[u32; 4]>> {
        let first = self.holding(points, self.locate(points, near, q)?, q);
        let mut region = self.connected(&first, |cell| points.in_sphere(*self.row(cell), q));
        let faces = loop {
            let faces = self.around_region(&region);
            let unseen =
                |&&(_, [a, b, c]): &&(u32, [u32; 3])| points.orientation([a, b, c, q]) != Sign::Positive;
            let mut stay: BTreeSet<u32> = faces.iter().filter(unseen).map(|f| f.0).collect();
            if stay.is_empty() {
                stay = self.losing(&region, &faces, &keeps);
            }
            if stay.is_empty() {
                break faces;
            }
            stay = stay.difference(&first).copied().collect();
            if stay.is_empty() {
                return None;
            }
            region = self.connected(&first, |cell| region.contains(&cell) && !stay.contains(&cell));
        };
        let made: Vec<[u32; 4]> = faces.into_iter().map(|(_, [a, b, c])| [a, b, c, q]).collect();
        let region: Vec<u32> = region.into_iter().collect();
        let removed = region.iter().map(|&c| *self.row(c)).collect();
        self.grow(points.len());
        self.replace(&region, &made);
        Some(removed)
    }

    /// Returns the cells that contain a point, from one of them.
    fn holding(&self, points: &Points, first: u32, q: u32) -> BTreeSet<u32> {
        let (mut found, mut stack) = (BTreeSet::from([first]), vec![first]);
        while let Some(cell) = stack.pop() {
            for slot in 0..4 {
                let [a, b, c] = face_of(self.row(cell), slot);
                let other = self.across(cell)[slot];
                if other != NONE && points.orientation([a, b, c, q]) == Sign::Zero && found.insert(other) {
                    stack.push(other);
                }
            }
        }
        found
    }

    /// Returns the cells that are connected to the first ones and for which a test holds, with the first ones.
    fn connected(&self, first: &BTreeSet<u32>, test: impl Fn(u32) -> bool) -> BTreeSet<u32> {
        let (mut region, mut seen) = (first.clone(), first.clone());
        let mut stack: Vec<u32> = first.iter().copied().collect();
        while let Some(cell) = stack.pop() {
            for &other in self.across(cell).iter().filter(|&&c| c != NONE) {
                if seen.insert(other) && test(other) {
                    region.insert(other);
                    stack.push(other);
                }
            }
        }
        region
    }

    /// Returns the faces around a region, positive towards its inside, with their cells.
    fn around_region(&self, region: &BTreeSet<u32>) -> Vec<(u32, [u32; 3])> {
        let faces = region.iter().flat_map(|&cell| (0..4).map(move |slot| (cell, slot)));
        let outer = faces.filter(|&(cell, slot)| !region.contains(&self.across(cell)[slot]));
        outer.map(|(cell, slot)| (cell, face_of(self.row(cell), slot))).collect()
    }

    /// Returns the cells of a region with a vertex or an edge that must be kept but is not on the faces around it.
    fn losing(
        &self,
        region: &BTreeSet<u32>,
        faces: &[(u32, [u32; 3])],
        keeps: &impl Fn([u32; 2]) -> bool,
    ) -> BTreeSet<u32> {
        let vertices: BTreeSet<u32> = faces.iter().flat_map(|f| f.1).collect();
        let edges: BTreeSet<[u32; 2]> = faces
            .iter()
            .flat_map(|&(_, [a, b, c])| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        let loses = |cell: &u32| {
            let row = self.row(*cell);
            row.iter().any(|v| !vertices.contains(v))
                || edges_of(row).into_iter().any(|e| !edges.contains(&e) && keeps(e))
        };
        region.iter().copied().filter(loses).collect()
    }

    /// Exchanges two cells for three around an edge that passes through their common face. Returns `false` if there are no
    /// such cells.
    pub(super) fn flip(&mut self, points: &Points, [p, q]: [u32; 2]) -> bool {
        let mut found = None;
        self.find(p, |row| {
            let slot = row.iter().position(|&v| v == p).unwrap_or(0);
            let face = face_of(row, slot);
            if points.crosses([p, q], face) {
                found = Some((*row, slot, face));
            }
            found.is_some()
        });
        let Some((row, slot, [a, b, c])) = found else { return false };
        let Some(cell) = self.with(&row) else { return false };
        let other = self.across(cell)[slot];
        if other == NONE || !self.row(other).contains(&q) {
            return false;
        }
        // The face is positive towards p, so (p, q) passes it from the positive to the negative side.
        let new = [[a, b], [b, c], [c, a]].map(|[s, t]| {
            let cell = [p, q, s, t];
            if points.orientation(cell) == Sign::Positive { cell } else { [p, q, t, s] }
        });
        self.replace(&[cell, other], &new);
        true
    }

    /// Makes room for the vertices below `count`.
    pub(super) fn grow(&mut self, count: usize) {
        self.at.resize(count, NONE);
    }

    /// Replaces cells by others that fill the same region, and returns the new ones.
    pub(super) fn replace(&mut self, old: &[u32], new: &[[u32; 4]]) -> Vec<u32> {
        let mut made = Vec::with_capacity(new.len());
        let gone: BTreeSet<u32> = old.iter().copied().collect();
        let mut open: BTreeMap<[u32; 3], (u32, usize)> = BTreeMap::new();
        for &cell in old {
            for slot in 0..4 {
                let other = self.across(cell)[slot];
                if other != NONE && !gone.contains(&other) {
                    let back = self.across(other).iter().position(|&c| c == cell);
                    open.insert(key(face_of(self.row(cell), slot)), (other, back.unwrap_or(0)));
                }
            }
        }
        for &cell in old {
            self.rows[cell as usize] = [NONE; 4];
            self.across[cell as usize] = [NONE; 4];
            self.free.push(cell);
        }
        for &row in new {
            let cell = self.free.pop().unwrap_or_else(|| {
                self.rows.push([NONE; 4]);
                self.across.push([NONE; 4]);
                self.rows.len() as u32 - 1
            });
            made.push(cell);
            self.rows[cell as usize] = row;
            for &v in &row {
                self.at[v as usize] = cell;
            }
            for slot in 0..4 {
                let face = key(face_of(&row, slot));
                match open.remove(&face) {
                    Some(other) => self.join((cell, slot), other),
                    None => drop(open.insert(face, (cell, slot))),
                }
            }
        }
        made
    }
}

/// Sorts the vertices of a cell without changing its orientation.
fn canonical(mut cell: [u32; 4]) -> [u32; 4] {
    let mut odd = false;
    for i in 1..4 {
        let mut j = i;
        while j > 0 && cell[j - 1] > cell[j] {
            cell.swap(j - 1, j);
            odd = !odd;
            j -= 1;
        }
    }
    if odd {
        cell.swap(2, 3);
    }
    cell
}
