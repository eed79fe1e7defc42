//! The region that a new point replaces, and its new cells.
//!
//! **Statement.** A point is inserted in a cell, on a wall, or on a kept edge. The *cavity* is a set of cells, connected
//! through faces that are not closed walls. It begins with the cells at the place of the point, and grows by cells whose
//! spheres contain the point. If the point lies on a patch, walls of this patch are *opened*: those at the place of the
//! point, and those connected to them for which the spheres of the cells on both sides contain the point. Then the cavity
//! shrinks until every face around it sees the point (exact sign, and not flat), and until no vertex and no kept edge is
//! lost. The new cells join the point to these faces. *So all cells stay positive, kept edges stay or are divided, and
//! each patch stays tiled*: the new walls join the point to the rim of the opened walls.
//!
//! *Proof.* The faces around the cavity form closed surfaces, together with opened walls on the hull, which contain the
//! point. They are star-shaped around the point. An edge of the rim belongs to one face around the cavity on each side
//! of the patch, so the face that joins it to the point is shared by the two new cells there. QED.
//!
//! **Source.** Bowyer (1981), Watson (1981); Shewchuk (1998); Si (2015).
//!
//! *Rounding.* A point on a patch lies in its plane up to the grid of doubles. The argument holds up to this distance.
//!
//! **Work and depth.** O(k log k) for k cells, and O(k w) for w opened walls and kept edges. Shrinking starts again for
//! each set of cells that it removes.

use glam::DVec3;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use super::solid::{FREE, Outer, Row, Side, Solid};
use crate::constrained::cells::{NONE, edges_of, key};
use crate::space::ascending;

/// The least volume of a new cell, relative to a cube over its longest edge. Flatter cells are not made.
const FLAT: f64 = 1e-11;

/// The place of a new point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// In a cell.
    Cell(u32),
    /// On a wall.
    Wall(Side),
    /// On a kept edge of a cell.
    Edge(u32, [u32; 2]),
}

/// A wall through which a cavity passes.
#[derive(Clone, Copy, Debug)]
struct Opened {
    face: [u32; 3],
    patch: u32,
    /// Whether the wall contains the point.
    first: bool,
}

/// A cavity.
#[derive(Debug, Default)]
pub(super) struct Cavity {
    cells: Vec<u32>,
    /// The cells at the place of the point.
    first: Vec<u32>,
    opened: Vec<Opened>,
    pub(super) faces: Vec<Outer>,
    /// The edges that the new walls join to the point, with their patches.
    rim: Vec<([u32; 2], u32)>,
    /// The edge that the point divides.
    divided: Option<[u32; 2]>,
}

/// A triangle of the cone over an edge around a cavity: the edge, and the face around the cavity with the slot of the
/// new cell.
type Blade = ([u32; 2], u32, usize);

impl Solid {
    /// Returns the cavity of a vertex at a place. Returns `None` if the vertex cannot be inserted there.
    pub(super) fn cavity(&mut self, q: u32, place: Place) -> Option<Cavity> {
        self.epoch += 1;
        let mut cavity = self.begin(place);
        self.open_walls(q, &mut cavity);
        self.grow(q, &mut cavity);
        self.shrink(q, &mut cavity)?;
        cavity.rim = Self::rim(&cavity);
        self.is_closed(&cavity).then_some(cavity)
    }

    /// Returns the cells and walls at a place.
    fn begin(&self, place: Place) -> Cavity {
        let mut cavity = Cavity::default();
        match place {
            Place::Cell(cell) => cavity.first.push(cell),
            Place::Wall(side) => {
                cavity.first.push(side.cell);
                self.open(side, true, &mut cavity);
            }
            Place::Edge(cell, edge) => {
                cavity.divided = Some(ascending(edge));
                cavity.first = self.around(cell, edge);
                for &cell in &cavity.first.clone() {
                    for slot in 0..4 {
                        let row = &self.rows[cell as usize];
                        if row.walls[slot] != NONE && !edge.contains(&row.corners[slot]) {
                            self.open(Side { cell, slot }, true, &mut cavity);
                        }
                    }
                }
            }
        }
        cavity
    }

    /// Opens a wall, with the cells on its sides.
    fn open(&self, side: Side, first: bool, cavity: &mut Cavity) {
        let face = key(self.face(side));
        if cavity.opened.iter().any(|o| o.face == face) {
            return;
        }
        let row = &self.rows[side.cell as usize];
        cavity.opened.push(Opened { face, patch: row.walls[side.slot], first });
        for cell in [side.cell, row.across[side.slot]] {
            let list = if first { &mut cavity.first } else { &mut cavity.cells };
            if cell != NONE && !list.contains(&cell) {
                list.push(cell);
            }
        }
    }

    fn conflicts(&mut self, cell: u32, q: u32) -> bool {
        self.visits += 1;
        in_sphere(&self.points(*self.corners(cell)), self.at[q as usize])
    }

    /// Opens the walls of a patch that are connected to opened ones and in conflict on both sides.
    fn open_walls(&mut self, q: u32, cavity: &mut Cavity) {
        let mut stack: Vec<Side> = Vec::new();
        for &cell in &cavity.first {
            let slots = (0..4).map(|slot| Side { cell, slot });
            stack.extend(slots.filter(|s| cavity.opened.iter().any(|o| o.face == key(self.face(*s)))));
        }
        while let Some(side) = stack.pop() {
            let [a, b, c] = self.face(side);
            let patch = self.rows[side.cell as usize].walls[side.slot];
            for edge in [[a, b], [b, c], [c, a]] {
                if self.is_kept(edge) {
                    continue;
                }
                let Some(next) = self.next_wall(side, edge) else { continue };
                let row = self.rows[next.cell as usize];
                let face = key(self.face(next));
                if row.walls[next.slot] != patch || cavity.opened.iter().any(|o| o.face == face) {
                    continue;
                }
                let beyond = row.across[next.slot];
                if self.conflicts(next.cell, q) && (beyond == NONE || self.conflicts(beyond, q)) {
                    self.open(next, false, cavity);
                    stack.push(next);
                }
            }
        }
    }

    /// Returns whether a cavity may pass through a face.
    fn passes(&self, side: Side, opened: &[Opened]) -> bool {
        self.rows[side.cell as usize].walls[side.slot] == NONE
            || !opened.is_empty() && {
                let face = key(self.face(side));
                opened.iter().any(|o| o.face == face)
            }
    }

    /// Adds the cells whose spheres contain the point.
    fn grow(&mut self, q: u32, cavity: &mut Cavity) {
        let mut cells = std::mem::take(&mut cavity.cells);
        cells.extend(&cavity.first);
        cells.sort_unstable();
        cells.dedup();
        for &cell in &cells {
            self.inside[cell as usize] = self.epoch;
            self.seen[cell as usize] = self.epoch;
        }
        let mut next = 0;
        while next < cells.len() {
            let cell = cells[next];
            next += 1;
            for slot in 0..4 {
                let other = self.rows[cell as usize].across[slot];
                if other == NONE
                    || self.seen[other as usize] == self.epoch
                    || !self.passes(Side { cell, slot }, &cavity.opened)
                {
                    continue;
                }
                self.seen[other as usize] = self.epoch;
                if self.conflicts(other, q) {
                    self.inside[other as usize] = self.epoch;
                    cells.push(other);
                }
            }
        }
        cavity.cells = cells;
    }

    fn is_inside(&self, cell: u32) -> bool {
        cell != NONE && self.inside[cell as usize] == self.epoch
    }

    /// Removes cells until all faces see the point, and nothing is lost.
    fn shrink(&mut self, q: u32, cavity: &mut Cavity) -> Option<()> {
        loop {
            self.surround(cavity);
            let mut gone: Vec<u32> =
                cavity.faces.iter().filter(|f| !self.sees(f.corners, q)).map(|f| f.side.cell).collect();
            if gone.is_empty() {
                gone = self.losing(cavity);
            }
            if gone.is_empty() {
                return Some(());
            }
            gone.sort_unstable();
            gone.dedup();
            if gone.iter().any(|cell| cavity.first.contains(cell)) {
                return None;
            }
            self.remove(&gone, cavity);
        }
    }

    /// Returns whether a face sees a vertex on its positive side, at some distance.
    fn sees(&self, [a, b, c]: [u32; 3], q: u32) -> bool {
        is_thick(self.points([a, b, c, q]))
    }

    /// Finds the faces around a cavity.
    fn surround(&self, cavity: &mut Cavity) {
        cavity.faces.clear();
        for &cell in &cavity.cells {
            for slot in 0..4 {
                let side = Side { cell, slot };
                let other = self.rows[cell as usize].across[slot];
                let passes = self.passes(side, &cavity.opened);
                if passes && (self.is_inside(other) || other == NONE) {
                    continue;
                }
                cavity.faces.push(Outer { corners: self.face(side), side });
            }
        }
    }

    /// Returns the cells with a vertex or a kept edge that is not on the faces around the cavity.
    fn losing(&self, cavity: &Cavity) -> Vec<u32> {
        let mut vertices: Vec<u32> = cavity.faces.iter().flat_map(|f| f.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let has =
            |[a, b]: [u32; 2]| cavity.faces.iter().any(|f| f.corners.contains(&a) && f.corners.contains(&b));
        let loses = |cell: &u32| {
            let row = self.corners(*cell);
            row.iter().any(|v| vertices.binary_search(v).is_err())
                || edges_of(row).into_iter().any(|e| self.is_kept(e) && Some(e) != cavity.divided && !has(e))
        };
        cavity.cells.iter().copied().filter(loses).collect()
    }

    /// Removes cells, and those that they connect to the place of the point.
    fn remove(&mut self, gone: &[u32], cavity: &mut Cavity) {
        let epoch = self.epoch;
        for &cell in gone {
            self.inside[cell as usize] = epoch - 1;
            let faces = [0, 1, 2, 3].map(|slot| key(self.face(Side { cell, slot })));
            cavity.opened.retain(|o| o.first || !faces.contains(&o.face));
        }
        let mut cells = cavity.first.clone();
        let mut next = 0;
        while next < cells.len() {
            let cell = cells[next];
            next += 1;
            for slot in 0..4 {
                let other = self.rows[cell as usize].across[slot];
                if self.is_inside(other)
                    && self.passes(Side { cell, slot }, &cavity.opened)
                    && !cells.contains(&other)
                {
                    cells.push(other);
                }
            }
        }
        for &cell in &cavity.cells {
            self.inside[cell as usize] = epoch - 1;
        }
        for &cell in &cells {
            self.inside[cell as usize] = epoch;
        }
        cavity.cells = cells;
    }

    /// Returns the edges of opened walls that belong to one of them only, with their patches.
    fn rim(cavity: &Cavity) -> Vec<([u32; 2], u32)> {
        let mut all: Vec<([u32; 2], u32)> = Vec::new();
        for o in &cavity.opened {
            let [a, b, c] = o.face;
            all.extend([[a, b], [b, c], [a, c]].map(|e| (e, o.patch)));
        }
        all.sort_unstable();
        let count = |x: &([u32; 2], u32)| all.iter().filter(|y| *y == x).count();
        all.iter().copied().filter(|x| Some(x.0) != cavity.divided && count(x) == 1).collect()
    }

    /// Returns the triangles of the cone, by their edges.
    fn blades(cavity: &Cavity) -> Vec<Blade> {
        let mut blades: Vec<Blade> = Vec::with_capacity(3 * cavity.faces.len());
        for (i, face) in (0u32..).zip(&cavity.faces) {
            let [a, b, c] = face.corners;
            // The new cell is (a, b, c, q).
            blades.extend([(ascending([b, c]), i, 0), (ascending([a, c]), i, 1), (ascending([a, b]), i, 2)]);
        }
        blades.sort_unstable();
        blades
    }

    /// Returns whether the new cells would fit: two at each edge, or one at the rim on the hull. Only walls separate
    /// components.
    fn is_closed(&self, cavity: &Cavity) -> bool {
        let blades = Self::blades(cavity);
        let mut met = 0;
        for group in blades.chunk_by(|x, y| x.0 == y.0) {
            let walls = cavity.rim.iter().filter(|r| r.0 == group[0].0).count();
            let label = |b: &Blade| self.rows[cavity.faces[b.1 as usize].side.cell as usize].label;
            let fits = match group {
                [_] => walls == 1,
                [x, y] => walls == 1 || walls == 0 && label(x) == label(y),
                _ => false,
            };
            if !fits {
                return false;
            }
            met += walls;
        }
        met == cavity.rim.len()
    }

    /// Replaces the cells of a cavity. Returns the new cells.
    pub(super) fn fill(&mut self, cavity: &Cavity, q: u32) -> Vec<u32> {
        let made: Vec<Row> = cavity.faces.iter().map(|face| self.new_row(face, q)).collect();
        let back: Vec<Option<Side>> = cavity.faces.iter().map(|face| self.opposite(face.side)).collect();
        for &cell in &cavity.cells {
            self.rows[cell as usize] = FREE;
            self.free.push(cell);
        }
        let mut new = Vec::with_capacity(made.len());
        for (row, back) in made.into_iter().zip(back) {
            let cell = self.free.pop().unwrap_or_else(|| {
                self.rows.push(FREE);
                self.inside.push(0);
                self.seen.push(0);
                self.rows.len() as u32 - 1
            });
            self.rows[cell as usize] = row;
            if let Some(side) = back {
                self.rows[side.cell as usize].across[side.slot] = cell;
            }
            new.push(cell);
        }
        for group in Self::blades(cavity).chunk_by(|x, y| x.0 == y.0) {
            let wall = cavity.rim.iter().find(|r| r.0 == group[0].0).map_or(NONE, |r| r.1);
            let cells: Vec<u32> = group.iter().map(|b| new[b.1 as usize]).collect();
            for (i, &(_, face, slot)) in group.iter().enumerate() {
                let row = &mut self.rows[new[face as usize] as usize];
                row.walls[slot] = wall;
                row.across[slot] = if cells.len() == 2 { cells[1 - i] } else { NONE };
            }
        }
        if let Some(edge) = cavity.divided {
            self.divide(edge, q, &new);
        }
        self.renew_fans(&new);
        new
    }

    /// Returns the new cell at a face around a cavity, not yet connected to others.
    fn new_row(&self, face: &Outer, q: u32) -> Row {
        let [a, b, c] = face.corners;
        let Side { cell, slot } = face.side;
        let old = &self.rows[cell as usize];
        Row {
            corners: [a, b, c, q],
            across: [NONE, NONE, NONE, old.across[slot]],
            walls: [NONE, NONE, NONE, old.walls[slot]],
            label: old.label,
        }
    }

    /// Returns the same face of the cell beyond it, if that cell stays.
    fn opposite(&self, side: Side) -> Option<Side> {
        let other = self.rows[side.cell as usize].across[side.slot];
        if other == NONE {
            return None;
        }
        let slot = self.rows[other as usize].across.iter().position(|&c| c == side.cell)?;
        Some(Side { cell: other, slot })
    }

    /// Divides a kept edge.
    fn divide(&mut self, edge: [u32; 2], q: u32, new: &[u32]) {
        let Some(line) = self.kept.remove(&edge) else { return };
        let was = self.fans.remove(&edge).is_some();
        for end in edge {
            let half = ascending([end, q]);
            self.kept.insert(half, line);
            if was {
                let mut left: Vec<u32> = new.to_vec();
                left.retain(|&c| half.iter().all(|v| self.corners(c).contains(v)));
                let mut firsts = Vec::new();
                while let Some(&first) = left.first() {
                    let fan = self.fan(first, half);
                    left.retain(|c| !fan.contains(c));
                    firsts.push(first);
                }
                self.fans.insert(half, firsts);
            }
        }
    }

    /// Replaces the cells of fans that are no longer at their edges.
    fn renew_fans(&mut self, new: &[u32]) {
        if self.fans.is_empty() {
            return;
        }
        let has = |rows: &[Row], cell: u32, edge: &[u32; 2]| {
            edge.iter().all(|v| rows[cell as usize].corners.contains(v))
        };
        let mut fans = std::mem::take(&mut self.fans);
        for (edge, cells) in &mut fans {
            for cell in cells.iter_mut().filter(|cell| !has(&self.rows, **cell, edge)) {
                if let Some(&other) = new.iter().find(|&&c| has(&self.rows, c, edge)) {
                    *cell = other;
                }
            }
        }
        self.fans = fans;
    }
}

/// Returns whether a cell is positive and not flat.
pub(super) fn is_thick(p: [DVec3; 4]) -> bool {
    let [u, v, w] = [p[1] - p[0], p[2] - p[0], p[3] - p[0]];
    let lengths = [u, v, w, v - u, w - u, w - v].map(DVec3::length_squared);
    let longest = lengths.into_iter().fold(0.0, f64::max);
    u.cross(v).dot(w).abs() > FLAT * longest * longest.sqrt() && orientation(&p) == Sign::Positive
}
