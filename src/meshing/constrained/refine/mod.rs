//! Refinement of a constrained triangulation: points where the shape or the size of a cell asks for them.
//!
//! **Statement.** A cell is *bad* if its circumradius exceeds B times its shortest edge, or the size at its
//! circumcentre. The worst bad cell receives its circumcentre. If a wall or a kept edge is in the way, or if the
//! smallest ball around one of those next to the new cells contains the circumcentre, this wall or edge is divided
//! instead: a wall at the centre of its circle, an edge in the middle, or at a power of two from an end where kept edges
//! meet at less than 60 degrees. A wall is replaced by an edge in the same way. So the boundary is divided only where a
//! cell asks for it. If it must be kept as it is ([`Limits::divides`]), points of the volume keep away from walls instead.
//!
//! *It ends.* A point is inserted only if its distance from all vertices of its cavity is at least the shortest edge of
//! the bad cell, or half the size if the cell is only too large. So no edge becomes shorter than the shortest edge of the
//! first cells or than half the least size. In Delaunay cells, a cavity has the nearest vertex of its point, so vertices
//! keep this distance, and a bounded domain has room for finitely many. A limit of vertices bounds all other cases. Points
//! on two features that meet at a small angle would otherwise approach each other forever. There, the rule leaves cells
//! that are bad. So does a cavity that cannot be filled.
//!
//! *The mesh still conforms*, because of [`cavity`].
//!
//! **Source.** Ruppert (1995), Shewchuk (1998), Si (2015).
//!
//! **Departures.** Edges and walls are not divided only because a vertex encroaches on them: only if a bad cell asks.
//! No bound holds for a cell that is left. The octree of Section 5 of the paper gives sizes for its conforming meshes;
//! here the cells themselves say where points are missing, so that small features far away count for nothing.
//!
//! **Work and depth.** Sequential: O(log n) for each cell that is made, the cells of the walks and of the cavities
//! ([`cavity`]), and for each point the kept edges with several fans.

mod cavity;
mod collapse;
mod shape;
mod solid;
mod walk;

use std::collections::BinaryHeap;

use glam::DVec3;
use septet_geometry::measure::circumcircle;

use super::cells::{NONE, edges_of};
use super::recovered::Recovered;
use super::segments::shell;
use crate::generate::GeneratedMesh;
use crate::mesh::Carrier;
use crate::space::{Space, ascending};
use crate::worst::Bad;

use cavity::{Cavity, Place};
use shape::{Shape, in_smallest_ball};
use solid::{Outer, Side, Solid};
use walk::{FlatWalk, Walk};

/// The cosine of 30 degrees: the angle of two lines below which points on them are not a reason to refine.
const COS_SMALL: f64 = 0.866_025_403_784_438_6;

/// The least distance of a point from the plane of a wall next to it that must not be divided, relative to the least
/// distance from vertices.
const LEAST_HEIGHT: f64 = 0.35;

/// What refinement must reach, and what it may do.
pub(super) struct Limits<'a> {
    /// The largest ratio of circumradius and shortest edge.
    pub(super) ratio: f64,
    /// The largest circumradius at a circumcentre.
    pub(super) size: &'a dyn Fn(DVec3) -> f64,
    /// Moves a point to the nearest place that can be written.
    pub(super) snapped: &'a dyn Fn(DVec3) -> DVec3,
    /// Whether walls and kept edges may be divided.
    pub(super) divides: bool,
    /// The largest number of vertices.
    pub(super) most: u64,
    /// Returns `true` if the caller has cancelled.
    pub(super) is_cancelled: &'a dyn Fn() -> bool,
}

/// The counts of a refinement.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refined {
    /// Points of recovery that were removed.
    pub(super) removed: u64,
    /// Bad cells that were examined.
    pub(super) bad: u64,
    /// Points that were inserted.
    pub(super) points: u64,
    /// Cells that were visited.
    pub(super) visits: u64,
}

/// Refinement stopped early: the limit of vertices is reached, or the caller has cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

/// The number of bad cells after which the caller is asked whether to go on.
const PATIENCE: u64 = 256;

/// Returns a constrained triangulation without the points that it does not need, and their number.
pub(super) fn collapsed<P: Space>(made: &Recovered) -> (GeneratedMesh<P>, u64) {
    let mut solid = Solid::new(made);
    let removed = solid.collapse(made.given);
    (solid.into_mesh(), removed)
}

/// Refines a constrained triangulation.
///
/// # Errors
/// Returns [`Stopped`] at the limit of vertices, or if the caller has cancelled.
pub(super) fn refine<P: Space>(
    made: &Recovered,
    limits: &Limits<'_>,
) -> Result<(GeneratedMesh<P>, Refined), Stopped> {
    let mut solid = Solid::new(made);
    let removed = solid.collapse(made.given);
    let acute = solid.acute_ends();
    let mut refiner = Refiner {
        solid,
        limits,
        acute,
        heap: BinaryHeap::new(),
        done: Refined { removed, ..Refined::default() },
    };
    for cell in 0..refiner.solid.rows.len() as u32 {
        refiner.judge(cell);
    }
    refiner.run()?;
    let mut done = refiner.done;
    done.visits = refiner.solid.visits;
    Ok((refiner.solid.into_mesh(), done))
}

struct Refiner<'a> {
    solid: Solid,
    limits: &'a Limits<'a>,
    /// Whether kept edges meet at less than 60 degrees at each vertex of the first cells.
    acute: Vec<bool>,
    heap: BinaryHeap<Bad<4>>,
    done: Refined,
}

impl Refiner<'_> {
    fn run(&mut self) -> Result<(), Stopped> {
        while let Some(bad) = self.heap.pop() {
            if self.solid.rows.get(bad.cell as usize).is_none_or(|row| row.corners != bad.corners) {
                continue;
            }
            self.done.bad += 1;
            let is_cancelled = self.done.bad.is_multiple_of(PATIENCE) && (self.limits.is_cancelled)();
            if is_cancelled || self.solid.at.len() as u64 >= self.limits.most {
                return Err(Stopped);
            }
            if self.attempt(bad.cell).is_some() {
                self.done.points += 1;
                if self.solid.rows[bad.cell as usize].corners == bad.corners {
                    self.heap.push(bad);
                }
            }
        }
        Ok(())
    }

    /// Adds a cell to the queue if it is bad.
    fn judge(&mut self, cell: u32) {
        let corners = *self.solid.corners(cell);
        if corners[0] == NONE {
            return;
        }
        let shape = Shape::of(self.solid.points(corners));
        let ratio2 = shape.radius2 / shape.shortest2;
        let limit2 = self.limits.ratio * self.limits.ratio;
        let badness = if ratio2 > limit2 && !self.is_forced(&corners) {
            ratio2
        } else {
            if !shape.centre.is_finite() {
                return;
            }
            let size = (self.limits.size)(shape.centre);
            // Cells that are only too large come after all others.
            if shape.radius2 <= size * size {
                return;
            }
            -size * size / shape.radius2
        };
        self.heap.push(Bad { badness, corners, cell });
    }

    /// Returns whether the shortest edge of a cell joins two kept edges that meet at a small angle.
    fn is_forced(&self, corners: &[u32; 4]) -> bool {
        let length = |e: &[u32; 2]| {
            let [a, b] = self.solid.points(*e);
            a.distance_squared(b)
        };
        let Some([u, v]) = edges_of(corners).into_iter().min_by(|a, b| length(a).total_cmp(&length(b)))
        else {
            return false;
        };
        let [s, t] = [u, v].map(|x| &self.solid.lines_at[x as usize]);
        s.iter().any(|&x| t.iter().any(|&y| x != y && self.meet_sharply(x, y)))
    }

    /// Returns whether two lines have a common end where they meet at a small angle.
    fn meet_sharply(&self, x: u32, y: u32) -> bool {
        let [x, y] = [x, y].map(|l| self.solid.lines[l as usize].ends);
        let Some(&v) = x.iter().find(|v| y.contains(v)) else { return false };
        let towards = |ends: [u32; 2]| {
            let other = if ends[0] == v { ends[1] } else { ends[0] };
            (self.solid.at[other as usize] - self.solid.at[v as usize]).normalize_or_zero()
        };
        towards(x).dot(towards(y)) > COS_SMALL
    }

    /// Inserts a point for a bad cell. Returns `None` if no point can be inserted.
    fn attempt(&mut self, cell: u32) -> Option<()> {
        let shape = Shape::of(self.solid.points(*self.solid.corners(cell)));
        if !shape.centre.is_finite() {
            return None;
        }
        let size = 0.5 * (self.limits.size)(shape.centre);
        let is_shapeless = shape.radius2 > self.limits.ratio * self.limits.ratio * shape.shortest2;
        let apart2 = if is_shapeless { shape.shortest2 } else { shape.shortest2.min(size * size) };
        let to = (self.limits.snapped)(shape.centre);
        match self.solid.walk(cell, to)? {
            Walk::Wall(side) => self.divide_wall(side, apart2),
            Walk::Cell(place) => self.insert_inside(place, to, apart2),
        }
    }

    /// Inserts a point in a cell, or divides the part of the boundary on which it encroaches.
    fn insert_inside(&mut self, place: u32, to: DVec3, apart2: f64) -> Option<()> {
        let q = self.solid.push(to, Carrier::Volume, None);
        let cavity = self.solid.cavity(q, Place::Cell(place));
        let own = self.solid.faces(place);
        let faces = cavity.as_ref().map_or(&own[..], |cavity| &cavity.faces);
        if !self.limits.divides {
            let is_near = faces.iter().any(|f| self.is_near(f, to, apart2));
            return self.finish(cavity.filter(|_| !is_near), q, apart2);
        }
        if let Some((cell, edge)) = self.encroached_edge(faces, to) {
            self.solid.pop();
            return self.divide_edge(cell, edge, apart2);
        }
        if let Some(side) = self.encroached_wall(faces, to) {
            self.solid.pop();
            return self.divide_wall(side, apart2);
        }
        self.finish(cavity, q, apart2)
    }

    /// Returns whether a point is too near to the plane of a wall that is kept.
    fn is_near(&self, face: &Outer, p: DVec3, apart2: f64) -> bool {
        let [a, b, c] = self.solid.points(face.corners);
        let height = (b - a).cross(c - a).normalize_or_zero().dot(p - a);
        self.solid.is_wall(face.side) && height * height < LEAST_HEIGHT * LEAST_HEIGHT * apart2
    }

    /// Inserts a point at the centre of a wall, or divides the kept edge on which it encroaches.
    fn divide_wall(&mut self, side: Side, apart2: f64) -> Option<()> {
        if !self.limits.divides {
            return None;
        }
        let triangle = self.solid.points(self.solid.face(side));
        let (centre, _) = circumcircle(triangle);
        if !centre.is_finite() {
            return None;
        }
        let patch = self.solid.rows[side.cell as usize].walls[side.slot];
        let to = (self.limits.snapped)(self.solid.on_patch(patch, centre));
        let place = match self.solid.walk_flat(side, to)? {
            FlatWalk::Edge(cell, edge) => return self.divide_edge(cell, edge, apart2),
            FlatWalk::Wall(place) => place,
        };
        let q = self.solid.push(to, Carrier::Facet(self.solid.facets[patch as usize]), None);
        let cavity = self.solid.cavity(q, Place::Wall(place));
        let own = [Outer { corners: self.solid.face(place), side: place }];
        let faces = cavity.as_ref().map_or(&own[..], |cavity| &cavity.faces);
        if let Some((cell, edge)) = self.encroached_edge(faces, to) {
            self.solid.pop();
            return self.divide_edge(cell, edge, apart2);
        }
        self.finish(cavity, q, apart2)
    }

    /// Divides a kept edge of a cell.
    fn divide_edge(&mut self, cell: u32, edge: [u32; 2], apart2: f64) -> Option<()> {
        if !self.limits.divides {
            return None;
        }
        let edge = ascending(edge);
        let line = *self.solid.kept.get(&edge)?;
        let carrier = self.solid.lines[line as usize].carrier;
        let [a, b] = self.solid.points(edge);
        let length = a.distance(b);
        let is_acute = |v: u32| self.acute.get(v as usize).copied().unwrap_or(false);
        let along = match edge.map(is_acute) {
            [true, false] => shell(length) / length,
            [false, true] => 1.0 - shell(length) / length,
            _ => 0.5,
        };
        let wish = self.solid.on_line(line, a + (b - a) * along);
        let q = self.solid.push((self.limits.snapped)(wish), carrier, Some(line));
        let cavity = self.solid.cavity(q, Place::Edge(cell, edge));
        self.finish(cavity, q, apart2)
    }

    /// Fills a cavity if there is one, and if its vertices are far enough from the point.
    fn finish(&mut self, cavity: Option<Cavity>, q: u32, apart2: f64) -> Option<()> {
        let at = self.solid.at[q as usize];
        let far = |v: u32| self.solid.at[v as usize].distance_squared(at) >= apart2;
        let Some(cavity) = cavity.filter(|c| c.faces.iter().all(|f| f.corners.into_iter().all(far))) else {
            self.solid.pop();
            return None;
        };
        for cell in self.solid.fill(&cavity, q) {
            self.judge(cell);
        }
        Some(())
    }

    /// Returns the kept edge of some faces that sees a point at the largest angle above 90 degrees, with a cell at it.
    fn encroached_edge(&self, faces: &[Outer], p: DVec3) -> Option<(u32, [u32; 2])> {
        let mut best: Option<(f64, u32, [u32; 2])> = None;
        for face in faces {
            let [a, b, c] = face.corners;
            for edge in [[a, b], [b, c], [c, a]].map(ascending) {
                let Some(angle) = in_smallest_ball(self.solid.points(edge), p) else { continue };
                if best.is_none_or(|b| (angle, edge) < (b.0, b.2)) && self.solid.is_kept(edge) {
                    best = Some((angle, face.side.cell, edge));
                }
            }
        }
        best.map(|(_, cell, edge)| (cell, edge))
    }

    /// Returns the wall among some faces whose smallest ball contains a point, relative to its size as deep as possible.
    fn encroached_wall(&self, faces: &[Outer], p: DVec3) -> Option<Side> {
        let mut best: Option<(f64, Side)> = None;
        for face in faces {
            if !self.solid.is_wall(face.side) {
                continue;
            }
            let (centre, radius2) = circumcircle(self.solid.points(face.corners));
            let depth = centre.distance_squared(p) / radius2;
            if depth < 1.0 && best.is_none_or(|(least, _)| depth < least) {
                best = Some((depth, face.side));
            }
        }
        best.map(|b| b.1)
    }
}
