//! Fills a cavity with cells by gift wrapping.
//!
//! **Statement.** The front consists of directed faces that need a cell on their positive side. A face receives the
//! vertex on its positive side whose perturbed sphere through the face contains no other vertex that fits. Faces of the
//! new cell leave the front, or enter it in the opposite direction. *If the front becomes empty, the cells tile the
//! cavity:* all are positive, and the sum of their boundaries is the boundary of the cavity. So they cover it with
//! degree one.
//!
//! A cell *fits* if none of its new edges crosses a face of the boundary, and no edge of the boundary crosses one of
//! its new faces. In a constrained triangulation, the cell at a face has the first vertex that fits: a vertex in its
//! sphere that fits would be visible from inside the cell. Most cavities do not need this test, so the first attempt
//! omits it. In another triangulation, this choice may fail. Then a cone from one vertex is tried, and a search that
//! tries all vertices that fit, within a limit.
//!
//! **Source.** Si and Gaertner (2005); Diazzi, Panozzo, Vaxman and Attene (2023).
//!
//! **Work and depth.** O(n) sphere tests for each cell, for n vertices of the cavity, and O(n^2) for each cell of a search.

use std::collections::BTreeSet;

use septet_geometry::predicates::Sign;

use super::cells::face_of;
use super::points::Points;

/// Returns positive cells that tile the region on the positive sides of the faces. Returns `None` if there are none of
/// these vertices that do.
pub(super) fn wrap(points: &Points, faces: &[[u32; 3]], vertices: &[u32]) -> Option<Vec<[u32; 4]>> {
    let greedy = |tests| Wrapping { points, faces, vertices, tests }.run();
    greedy(false)
        .or_else(|| greedy(true))
        .or_else(|| vertices.iter().find_map(|&v| cone(points, faces, v)))
        .or_else(|| Search { points, vertices, cells: Vec::new(), left: SEARCHED }.run(faces))
}

/// The search for cells that fill a cavity, with backtracking.
struct Search<'a> {
    points: &'a Points,
    vertices: &'a [u32],
    cells: Vec<[u32; 4]>,
    /// The number of cells that may still be tried.
    left: u32,
}

impl Search<'_> {
    fn run(mut self, faces: &[[u32; 3]]) -> Option<Vec<[u32; 4]>> {
        let front: BTreeSet<[u32; 3]> = faces.iter().map(|&f| turned(f)).collect();
        (self.vertices.len() <= WIDEST && self.fill(&front)).then_some(self.cells)
    }

    /// Fills the region in front of some faces. Returns whether that is possible.
    fn fill(&mut self, front: &BTreeSet<[u32; 3]>) -> bool {
        let Some(&[a, b, c]) = front.first() else { return true };
        let faces: Vec<[u32; 3]> = front.iter().copied().collect();
        let wrapping = Wrapping { points: self.points, faces: &faces, vertices: self.vertices, tests: true };
        for v in wrapping.candidates([a, b, c]) {
            if self.left == 0 {
                return false;
            }
            self.left -= 1;
            let cell = [a, b, c, v];
            let mut rest = front.clone();
            if wrapping.fits([a, b, c], v) && advance(&mut rest, cell) {
                self.cells.push(cell);
                if self.fill(&rest) {
                    return true;
                }
                self.cells.pop();
            }
        }
        false
    }
}

/// Moves the front over a cell. Returns whether no face would be in the front twice.
fn advance(front: &mut BTreeSet<[u32; 3]>, cell: [u32; 4]) -> bool {
    (0..4).all(|slot| {
        let [a, b, c] = turned(face_of(&cell, slot));
        front.remove(&[a, b, c]) || front.insert(turned([a, c, b]))
    })
}

/// Returns the cells that join a vertex to all faces without it, if these see the vertex.
fn cone(points: &Points, faces: &[[u32; 3]], v: u32) -> Option<Vec<[u32; 4]>> {
    let others = faces.iter().filter(|face| !face.contains(&v)).map(|&[a, b, c]| [a, b, c, v]);
    let cells: Vec<[u32; 4]> = others.collect();
    cells.iter().all(|&cell| points.orientation(cell) == Sign::Positive).then_some(cells)
}

/// The largest number of vertices of a cavity that is searched.
const WIDEST: usize = 20;

/// The largest number of cells that a search tries.
const SEARCHED: u32 = 300;

struct Wrapping<'a> {
    points: &'a Points,
    faces: &'a [[u32; 3]],
    vertices: &'a [u32],
    /// Whether cells must fit.
    tests: bool,
}

impl Wrapping<'_> {
    fn run(&self) -> Option<Vec<[u32; 4]>> {
        let mut front: BTreeSet<[u32; 3]> = self.faces.iter().map(|&f| turned(f)).collect();
        let mut made = Vec::new();
        // A triangulation of n points has at most n (n - 3) / 2 cells.
        let most = self.vertices.len() * self.vertices.len() / 2 + 1;
        while let Some(&face) = front.first() {
            let [a, b, c] = face;
            let cell = [a, b, c, self.apex(face)?];
            if !advance(&mut front, cell) {
                return None;
            }
            made.push(cell);
            if made.len() > most {
                return None;
            }
        }
        Some(made)
    }

    /// Returns the vertices on the positive side of a face, in the order in which spheres through the face meet them.
    fn candidates(&self, [a, b, c]: [u32; 3]) -> Vec<u32> {
        let above = |v: &u32| self.points.orientation([a, b, c, *v]) == Sign::Positive;
        let others = self.vertices.iter().copied().filter(|v| ![a, b, c].contains(v));
        let mut left: Vec<u32> = others.filter(above).collect();
        let mut found = Vec::with_capacity(left.len());
        while !left.is_empty() {
            let mut best = 0;
            for i in 1..left.len() {
                if self.points.in_sphere([a, b, c, left[best]], left[i]) {
                    best = i;
                }
            }
            found.push(left.swap_remove(best));
        }
        found
    }

    /// Returns the vertex of the cell at a face.
    fn apex(&self, face: [u32; 3]) -> Option<u32> {
        let mut found = self.candidates(face).into_iter();
        if self.tests { found.find(|&v| self.fits(face, v)) } else { found.next() }
    }

    fn fits(&self, [a, b, c]: [u32; 3], v: u32) -> bool {
        let cell = [a, b, c, v];
        let new_faces = [[a, b, v], [b, c, v], [c, a, v]];
        self.faces.iter().all(|&face| {
            let [p, q, r] = face;
            let held = |x: u32| !cell.contains(&x) && self.holds(cell, x);
            [a, b, c].into_iter().all(|x| !self.points.crosses([x, v], face))
                && [[p, q], [q, r], [r, p]]
                    .into_iter()
                    .all(|edge| new_faces.into_iter().all(|new| !self.points.crosses(edge, new)))
                && !face.into_iter().any(held)
        })
    }

    /// Returns `true` if a closed cell contains a point.
    fn holds(&self, cell: [u32; 4], x: u32) -> bool {
        (0..4).all(|slot| {
            let [a, b, c] = face_of(&cell, slot);
            self.points.orientation([a, b, c, x]) != Sign::Negative
        })
    }
}

/// Rotates the smallest vertex of a directed face to the front.
fn turned(mut face: [u32; 3]) -> [u32; 3] {
    let first = (0..3).min_by_key(|&i| face[i]).unwrap_or(0);
    face.rotate_left(first);
    face
}
