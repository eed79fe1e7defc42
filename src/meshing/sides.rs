//! The components of the complement of the walls.
//!
//! **Statement.** Every wall has two sides. Around a hinge (a vertex in the plane, an edge in space), the walls have a
//! cyclic order. Two sides that face each other across the gap between two consecutive walls bound the same component,
//! so they are linked. The classes of linked sides are *shells*. For every shell, take a line in general position
//! through one of its walls. Consecutive sides on this line are also linked: the unbounded component with the first
//! side, and the far side of each wall with the near side of the next. *Then two sides are in one class iff they bound
//! the same component.*
//!
//! *Proof.* Links never join different components. It remains to show that all sides of a component U are in one class.
//! 1. Let S be a shell of U, oriented outwards. S is a cycle, so it has a winding number w, which is constant on U
//!    and 0 far away. Along a line, w changes only at a wall with one side in S. There it changes by 1, between its
//!    value c on U and c - 1, because all sides of S face U. Therefore w has only these two values. One of them is 0,
//!    so c is 0 or 1.
//! 2. The shells of U sum to the boundary of U. The winding number of this boundary is 1 on U if U is bounded, and 0
//!    otherwise. So exactly one shell has c = 1 if U is bounded, and none if U is unbounded.
//! 3. If a line leaves U through S, w becomes c - 1. The line returns to U only after w is c again, that is, through S.
//!    All sides of U on one line are therefore in one class.
//! 4. Let U be bounded. Before a line enters U for the first time, w is 0 for the shell with c = 1, so the line enters
//!    through that shell. If U is unbounded, every line starts in U.
//! 5. The classes of all lines that meet U therefore have a side in common, and every shell of U is on one of these
//!    lines. QED.
//!
//! **Work and depth.** `O(m log m)`, plus for each shell the walls that a thin box meets.

use std::collections::BTreeMap;

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, orientation};

use crate::bvh::{Bounds, Bvh};
use crate::crossed::{CrossedWall, Line};
use crate::resolve::Simplices;
use crate::space::{Crossing, Space};

/// A side of a wall: `2 * wall` for the positive side, `2 * wall + 1` for the negative side.
pub type Side = u32;

/// The location of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Location {
    /// In a component. Component 0 is unbounded.
    Component(u32),
    /// On a wall.
    Wall(u32),
}

/// The error if no line in general position was found through the shell of this wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undecided(pub u32);

/// The components on the sides of the walls.
#[derive(Clone, Debug)]
pub struct Sides<P: Space> {
    walls: Vec<P::Facet>,
    tree: Bvh<P>,
    /// The component of every side.
    component: Vec<u32>,
    count: u32,
    /// Whether an odd number of walls separates each component from the outside.
    odd: Vec<bool>,
}

/// Disjoint sets with union. The smallest member represents a set.
pub(crate) struct Sets(Vec<u32>);

impl Sets {
    pub(crate) fn new(n: usize) -> Self {
        Sets((0..n as u32).collect())
    }

    pub(crate) fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

impl<P: Space> Sides<P> {
    /// Finds the components of a complex that [`crate::contact`] accepts.
    ///
    /// # Errors
    /// Returns [`Undecided`] if all walls of a shell are too thin for a line through them.
    pub fn new(simplices: &Simplices<P>) -> Result<Self, Undecided> {
        let walls = simplices.walls.clone();
        let boxes = walls.iter().map(|w| simplices.bounds(w.as_ref())).collect();
        let tree = Bvh::new(boxes);
        let mut sides = Sides { walls, tree, component: Vec::new(), count: 1, odd: vec![false] };
        // Set 0 is the outside, and set s + 1 is side s.
        let mut sets = Sets::new(2 * sides.walls.len() + 1);
        sides.around_hinges(&simplices.points, &mut sets);
        sides.along_lines(&simplices.points, &mut sets)?;
        sides.number(&mut sets);
        Ok(sides)
    }

    /// Links sides that face each other around hinges.
    fn around_hinges(&self, points: &[P], sets: &mut Sets) {
        let mut hinges: BTreeMap<P::Hinge, Vec<(u32, u32)>> = BTreeMap::new();
        for (i, wall) in self.walls.iter().enumerate() {
            for (hinge, &apex) in P::hinges(wall).into_iter().zip(wall.as_ref()) {
                hinges.entry(hinge).or_default().push((apex, i as u32));
            }
        }
        for (hinge, mut walls) in hinges {
            let turn = |a: u32, b: u32| {
                let ids = hinge.as_ref().iter().copied().chain([a, b]);
                orientation(&ids.map(|v| points[v as usize]).collect::<Vec<_>>())
            };
            let first = walls[0].0;
            // The part of the rotation in which a wall lies, starting at the first wall: the first wall itself, the
            // first half, opposite, the second half.
            let half = |apex: u32| match turn(first, apex) {
                _ if apex == first => 0,
                Sign::Positive => 1,
                Sign::Zero => 2,
                Sign::Negative => 3,
            };
            walls.sort_by(|&(a, i), &(b, j)| {
                let within = || match turn(a, b) {
                    Sign::Positive => std::cmp::Ordering::Less,
                    Sign::Negative => std::cmp::Ordering::Greater,
                    Sign::Zero => i.cmp(&j),
                };
                half(a).cmp(&half(b)).then_with(within)
            });
            for (k, &(apex, wall)) in walls.iter().enumerate() {
                let (next_apex, next) = walls[(k + 1) % walls.len()];
                let ahead = self.side_after(hinge.as_ref(), apex, wall);
                let behind = self.side_after(hinge.as_ref(), next_apex, next) ^ 1;
                sets.join(ahead + 1, behind + 1);
            }
        }
    }

    /// Returns the side of a wall that faces the next wall in the rotation around the hinge.
    fn side_after(&self, hinge: &[u32], apex: u32, wall: u32) -> Side {
        // A point with positive orientation to (hinge, apex) comes next. The parity of the vertex order of the wall
        // selects the side.
        let own = self.walls[wall as usize];
        let own = own.as_ref();
        let ours: Vec<u32> = hinge.iter().copied().chain([apex]).collect();
        let mut inversions = 0;
        let rank: Vec<usize> = ours.iter().map(|v| own.iter().position(|w| w == v).unwrap_or(0)).collect();
        for i in 0..rank.len() {
            inversions += rank[i + 1..].iter().filter(|&&r| r < rank[i]).count() as u32;
        }
        2 * wall + inversions % 2
    }

    /// Links consecutive sides on a line through every shell.
    fn along_lines(&self, points: &[P], sets: &mut Sets) -> Result<(), Undecided> {
        let mut shells: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for side in 0..2 * self.walls.len() as u32 {
            shells.entry(sets.find(side + 1)).or_default().push(side / 2);
        }
        for walls in shells.into_values() {
            let line = walls.iter().find_map(|&wall| self.line_through(points, wall));
            let (from, crossed) = line.ok_or(Undecided(walls[0]))?;
            let mut previous = 0;
            for wall in crossed {
                let near = self.side_towards(points, wall, from);
                sets.join(previous, near + 1);
                previous = (near ^ 1) + 1;
            }
            sets.join(previous, 0);
        }
        Ok(())
    }

    /// Returns the side of a wall on which a point lies. The point must not be in its plane.
    fn side_towards(&self, points: &[P], wall: u32, q: P) -> Side {
        let mut corners = P::corners(points, &self.walls[wall as usize]);
        corners.push(q);
        2 * wall + u32::from(orientation(&corners) == Sign::Negative)
    }

    /// Returns a line in general position through the interior of a wall: its start, and all walls in the order in
    /// which it crosses them.
    fn line_through(&self, points: &[P], wall: u32) -> Option<(P, Vec<u32>)> {
        let corners = P::corners(points, &self.walls[wall as usize]);
        let normal = normal(&corners);
        for attempt in 0..TRIES {
            let mut inner = P::splat(0.0);
            let weights: Vec<f64> = (0..P::DIM as u32).map(|i| 0.25 + unit(attempt * 7 + i)).collect();
            let total: f64 = weights.iter().sum();
            for (&c, w) in corners.iter().zip(weights) {
                inner = inner + c * (w / total);
            }
            let axis = steepest(normal);
            let Some((from, to)) = self.ends(inner, axis, attempt) else { continue };
            if let Some(mut crossed) = self.crossed(points, from, to)
                && crossed.iter().any(|met| met.wall == wall)
            {
                crossed.sort_by(CrossedWall::order);
                return Some((from, crossed.into_iter().map(|met| met.wall).collect()));
            }
        }
        None
    }

    /// Returns two points outside the bounding box, on a line that passes near `inner` and runs mainly along `axis`.
    fn ends(&self, inner: P, axis: usize, attempt: u32) -> Option<(P, P)> {
        let all = self.tree.bounds();
        let extent = all.extent();
        let room = (0..P::DIM).map(|i| extent.coord(i)).fold(f64::MIN_POSITIVE, f64::max);
        let mut direction = P::splat(0.0);
        for i in 0..P::DIM {
            let slope = (unit(attempt * 11 + i as u32 + 3) - 0.5) / 32.0;
            direction.set_coord(i, if i == axis { 1.0 } else { slope });
        }
        let reach = 2.0 * room;
        let (from, to) = (inner - direction * reach, inner + direction * reach);
        let outside = from.coord(axis) < all.low.coord(axis) && to.coord(axis) > all.high.coord(axis);
        outside.then_some((from, to))
    }

    /// Returns the walls that a segment crosses, or `None` if it is not in general position.
    fn crossed(&self, points: &[P], from: P, to: P) -> Option<Vec<CrossedWall<P>>> {
        self.crossed_counted(points, [from, to], &mut Sweep::default())
    }

    /// Returns [`Sides::crossed`], and counts the visits of the tree.
    fn crossed_counted(
        &self,
        points: &[P],
        [from, to]: [P; 2],
        visits: &mut Sweep,
    ) -> Option<Vec<CrossedWall<P>>> {
        let line = Line::through(from, to);
        let mut found = Vec::new();
        for wall in self.tree.meeting_counted(&Bounds::of([from, to]), visits) {
            let corners = P::corners(points, &self.walls[wall as usize]);
            match P::crossing(&corners, from, to) {
                Crossing::None => {}
                Crossing::Degenerate => return None,
                Crossing::Proper => found.push(CrossedWall::new(wall, line, corners)),
            }
        }
        Some(found)
    }

    fn number(&mut self, sets: &mut Sets) {
        let mut names = BTreeMap::from([(sets.find(0), 0)]);
        let walls = self.walls.len() as u32;
        self.component = (0..2 * walls)
            .map(|side| {
                let next = names.len() as u32;
                *names.entry(sets.find(side + 1)).or_insert(next)
            })
            .collect();
        self.count = names.len() as u32;
        self.odd = vec![false; self.count as usize];
        let mut near: Vec<Vec<u32>> = vec![Vec::new(); self.count as usize];
        for wall in 0..walls as usize {
            let (a, b) = (self.component[2 * wall], self.component[2 * wall + 1]);
            near[a as usize].push(b);
            near[b as usize].push(a);
        }
        let mut seen = vec![false; self.count as usize];
        let mut stack = vec![0u32];
        seen[0] = true;
        while let Some(c) = stack.pop() {
            for &n in &near[c as usize] {
                if !std::mem::replace(&mut seen[n as usize], true) {
                    self.odd[n as usize] = !self.odd[c as usize];
                    stack.push(n);
                }
            }
        }
    }

    /// Returns the number of components. Component 0 is unbounded.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the components on the positive and the negative side of a wall.
    pub fn components_at(&self, wall: u32) -> [u32; 2] {
        [0, 1].map(|s| self.component[(2 * wall + s) as usize])
    }

    /// Returns the component on the side of a wall on which a point lies. The point must not be in its plane.
    pub fn towards(&self, points: &[P], wall: u32, q: P) -> u32 {
        self.component[self.side_towards(points, wall, q) as usize]
    }

    /// Returns `true` if an odd number of walls separates the component from the outside. This is meaningful only for
    /// closed surfaces.
    pub fn is_odd(&self, component: u32) -> bool {
        self.odd[component as usize]
    }

    /// Returns the exact location of a point. `points` must be the points of the complex. Returns `None` if every line
    /// that is tried meets an edge.
    pub fn locate(&self, points: &[P], q: P) -> Option<Location> {
        self.locate_counted(points, q, &mut Sweep::default())
    }

    /// Returns [`Sides::locate`], and counts the visits of the tree of walls.
    pub(crate) fn locate_counted(&self, points: &[P], q: P, visits: &mut Sweep) -> Option<Location> {
        if self.tree.bounds().dist2(q) > 0.0 {
            return Some(Location::Component(0));
        }
        let here = self.tree.meeting_counted(&Bounds::of([q]), visits);
        let on = |&wall: &u32| P::on_wall(&P::corners(points, &self.walls[wall as usize]), q);
        if let Some(wall) = here.into_iter().find(on) {
            return Some(Location::Wall(wall));
        }
        (0..ATTEMPTS).find_map(|attempt| {
            let (_, to) = self.ends(q, attempt as usize % P::DIM, attempt)?;
            let crossed = self.crossed_counted(points, [q, to], visits)?;
            let first = crossed.iter().min_by(|a, b| a.order(b));
            let side = first.map(|met| self.side_towards(points, met.wall, q));
            Some(Location::Component(side.map_or(0, |side| self.component[side as usize])))
        })
    }

    /// Returns the area or volume of every component, rounded. For component 0, which is unbounded, it is 0.
    pub fn measures(&self, points: &[P]) -> Vec<f64> {
        let mut sums = vec![0.0; self.count as usize];
        let origin = self.tree.bounds().low;
        for (i, wall) in self.walls.iter().enumerate() {
            let corners = P::corners(points, wall);
            let part = signed_measure(&corners, origin);
            let [positive, negative] = self.components_at(i as u32);
            sums[positive as usize] += part;
            sums[negative as usize] -= part;
        }
        // The division comes last, so that sums of integers remain exact.
        let factorial = if P::DIM == 2 { 2.0 } else { 6.0 };
        for sum in &mut sums {
            *sum /= factorial;
        }
        sums[0] = 0.0;
        sums
    }
}

/// The number of lines that are tried through a wall before another wall is chosen.
const TRIES: u32 = 8;
const ATTEMPTS: u32 = 64;

/// Returns term `i` of a fixed pseudorandom sequence of 24-bit numbers in `[0, 1)`.
fn unit(i: u32) -> f64 {
    let mut x = u64::from(i).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 29;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 32;
    (x >> 40) as f64 / (1u64 << 24) as f64
}

/// Returns a normal vector of a wall, rounded.
fn normal<P: Point>(corners: &[P]) -> P {
    let rel: Vec<P> = corners[1..].iter().map(|&c| c - corners[0]).collect();
    P::hull_normal(&rel)
}

/// Returns the axis of the largest coordinate.
fn steepest<P: Point>(v: P) -> usize {
    (1..P::DIM).fold(0, |k, i| if v.coord(i).abs() > v.coord(k).abs() { i } else { k })
}

/// Returns the signed measure of the parallelepiped that a wall and a point span. It is positive if the point is on
/// the positive side.
fn signed_measure<P: Point>(corners: &[P], origin: P) -> f64 {
    normal(corners).dot(origin - corners[0])
}
