//! The constrained triangulation of a planar straight-line graph.
//!
//! **Statement.** Points and constraints are inserted one by one into the triangulation of a box around all of them.
//! A constraint that is not yet an edge replaces the edges that it crosses. The polygons on its two sides are filled
//! with the Delaunay triangles of their chains (Anglada 1997). Finally, the algorithm removes the triangles outside
//! the graph, and the triangles that a path from a hole point reaches without crossing a constraint. The triangles
//! are used for exact tests and distances, not for meshes. Not all of them are Delaunay.
//!
//! **Work and depth.** `O(m^2)` in the worst case for `m` points, sequential.
//!
//! A triangle is stored as three directed edges with their opposite vertices. All signs are exact.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use crate::bvh::Bounds;
use crate::space::ascending;

/// The position of a point.
enum Spot {
    Vertex(u32),
    /// On the edge from `.0` to `.1`, which belongs to the triangle on its left.
    Edge(u32, u32),
    Inside([u32; 3]),
}

/// A constrained triangulation of points in the plane. Vertices `0..4` are the corners of the box.
#[derive(Clone, Debug)]
pub struct Planar {
    points: Vec<DVec2>,
    /// The vertex opposite each directed edge, on its left.
    apex: BTreeMap<(u32, u32), u32>,
    constraints: BTreeSet<[u32; 2]>,
    /// The constraints that bound the graph. `None` stands for all.
    barriers: Option<BTreeSet<[u32; 2]>>,
    /// The edge at which the next search starts.
    last: (u32, u32),
}

/// The error for two constraints that cross without a common vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossed;

impl Planar {
    /// Creates the two triangles of a box with room for points in `bounds`.
    pub fn new(bounds: &Bounds<DVec2>) -> Self {
        let room = bounds.extent().max_element().max(f64::MIN_POSITIVE);
        let (low, high) = (bounds.low - DVec2::splat(room), bounds.high + DVec2::splat(room));
        let points = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let (apex, constraints) = (BTreeMap::new(), BTreeSet::new());
        let mut planar = Planar { points, apex, constraints, barriers: None, last: (0, 1) };
        planar.add([0, 1, 2]);
        planar.add([0, 2, 3]);
        planar
    }

    fn add(&mut self, [a, b, c]: [u32; 3]) {
        self.apex.insert((a, b), c);
        self.apex.insert((b, c), a);
        self.apex.insert((c, a), b);
        self.last = (a, b);
    }

    fn remove(&mut self, [a, b, c]: [u32; 3]) {
        for edge in [(a, b), (b, c), (c, a)] {
            self.apex.remove(&edge);
        }
    }

    fn side(&self, a: u32, b: u32, q: DVec2) -> Sign {
        orientation(&[self.points[a as usize], self.points[b as usize], q])
    }

    fn turn(&self, a: u32, b: u32, c: u32) -> Sign {
        self.side(a, b, self.points[c as usize])
    }

    /// Returns the position of a point in a triangle (at a corner, on an edge, or inside), or `None` if the point
    /// lies outside.
    fn spot_in(&self, t: [u32; 3], q: DVec2) -> Option<Spot> {
        if let Some(&v) = t.iter().find(|&&v| self.points[v as usize] == q) {
            return Some(Spot::Vertex(v));
        }
        let edges = [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let sides = edges.map(|(a, b)| self.side(a, b, q));
        if sides.contains(&Sign::Negative) {
            return None;
        }
        let on = edges.iter().zip(sides).find(|(_, s)| *s == Sign::Zero);
        Some(on.map_or(Spot::Inside(t), |(&(a, b), _)| Spot::Edge(a, b)))
    }

    /// Walks towards `q`. If the walk is cyclic, tests every triangle.
    fn locate(&self, q: DVec2) -> Option<Spot> {
        let (mut a, mut b) = self.last;
        for step in 0..self.apex.len() {
            let Some(&c) = self.apex.get(&(a, b)) else { break };
            let mut edges = [(a, b), (b, c), (c, a)];
            edges.rotate_left(step % 3);
            match edges.into_iter().find(|&(u, v)| self.side(u, v, q) == Sign::Negative) {
                Some((u, v)) => (a, b) = (v, u),
                None => return self.spot_in([a, b, c], q),
            }
        }
        self.apex.iter().find_map(|(&(a, b), &c)| self.spot_in([a, b, c], q))
    }

    /// Inserts a point and returns its vertex. Returns `None` if the point lies outside the box.
    pub fn insert(&mut self, q: DVec2) -> Option<u32> {
        let spot = self.locate(q)?;
        let n = self.points.len() as u32;
        match spot {
            Spot::Vertex(v) => return Some(v),
            Spot::Inside([a, b, c]) => {
                self.points.push(q);
                self.remove([a, b, c]);
                for (u, v) in [(a, b), (b, c), (c, a)] {
                    self.add([u, v, n]);
                }
            }
            Spot::Edge(a, b) => {
                let (&c, &d) = (self.apex.get(&(a, b))?, self.apex.get(&(b, a))?);
                self.points.push(q);
                self.remove([a, b, c]);
                self.remove([b, a, d]);
                for (u, v) in [(b, c), (c, a), (a, d), (d, b)] {
                    self.add([u, v, n]);
                }
                if self.constraints.remove(&ascending([a, b])) {
                    self.constraints.insert(ascending([a, n]));
                    self.constraints.insert(ascending([n, b]));
                }
            }
        }
        Some(n)
    }

    /// Returns the neighbours of a vertex: `(u, v)` for every triangle `(vertex, u, v)`.
    fn fan(&self, vertex: u32) -> impl Iterator<Item = (u32, u32)> {
        self.apex.range((vertex, 0)..=(vertex, u32::MAX)).map(|(&(_, u), &v)| (u, v))
    }

    /// Turns the segment between two vertices into a constraint, divided at all vertices on it.
    ///
    /// # Errors
    /// Returns [`Crossed`] if it crosses an earlier constraint. The part beyond the crossing is then undefined.
    pub fn constrain(&mut self, from: u32, to: u32) -> Result<(), Crossed> {
        let mut at = from;
        while at != to {
            at = self.constrain_step(at, to)?;
        }
        Ok(())
    }

    /// Adds the constraint up to the first vertex on the segment, and returns that vertex.
    fn constrain_step(&mut self, from: u32, to: u32) -> Result<u32, Crossed> {
        let ahead = |v: u32| {
            let [o, a, b] = [from, to, v].map(|i| self.points[i as usize]);
            (a - o).dot(b - o) > 0.0
        };
        let direct = self.fan(from).map(|(u, _)| u);
        let direct = direct.filter(|&u| self.turn(from, to, u) == Sign::Zero && ahead(u)).min();
        if let Some(next) = direct {
            self.constraints.insert(ascending([from, next]));
            return Ok(next);
        }
        let opening = |&(u, v): &(u32, u32)| {
            self.turn(from, to, u) == Sign::Negative && self.turn(from, to, v) == Sign::Positive
        };
        let Some((mut right, mut left)) = self.fan(from).find(opening) else { return Err(Crossed) };
        let (mut above, mut below, mut taken) = (vec![left], vec![right], vec![[from, right, left]]);
        let end = loop {
            if self.constraints.contains(&ascending([left, right])) {
                return Err(Crossed);
            }
            let Some(&next) = self.apex.get(&(left, right)) else { return Err(Crossed) };
            taken.push([left, right, next]);
            match self.turn(from, to, next) {
                Sign::Zero => break next,
                Sign::Positive => {
                    left = next;
                    above.push(next);
                }
                Sign::Negative => {
                    right = next;
                    below.push(next);
                }
            }
        };
        for triangle in taken {
            self.remove(triangle);
        }
        below.reverse();
        self.fill(&above, from, end);
        self.fill(&below, end, from);
        self.constraints.insert(ascending([from, end]));
        Ok(end)
    }

    /// Fills the polygon between an edge and a chain of vertices from `a` to `b` on its left. The triangle on the
    /// edge is Delaunay. It therefore separates the part of the chain between two visits to the same vertex from the
    /// rest.
    fn fill(&mut self, chain: &[u32], a: u32, b: u32) {
        let mut stack = vec![(chain, a, b)];
        while let Some((chain, a, b)) = stack.pop() {
            let Some((&first, _)) = chain.split_first() else { continue };
            let point = |v: u32| self.points[v as usize];
            let (mut at, mut c) = (0, first);
            for (i, &v) in chain.iter().enumerate() {
                if v != c && in_sphere(&[point(a), point(b), point(c)], point(v)) {
                    (at, c) = (i, v);
                }
            }
            self.add([a, b, c]);
            stack.push((&chain[..at], a, c));
            stack.push((&chain[at + 1..], c, b));
        }
    }

    /// Closes the boundary of the graph: later constraints do not bound it.
    pub fn close(&mut self) {
        self.barriers = Some(self.constraints.clone());
    }

    /// Returns `true` if the edge bounds the graph or a hole.
    fn is_barrier(&self, a: u32, b: u32) -> bool {
        self.barriers.as_ref().unwrap_or(&self.constraints).contains(&ascending([a, b]))
    }

    /// Returns the triangles that are neither outside the graph nor in a hole, smallest vertex first, ascending. Also
    /// returns the indices of hole points that lie on a constraint or outside the graph.
    pub fn inside(&self, holes: &[DVec2]) -> (Vec<[u32; 3]>, Vec<usize>) {
        let mut gone = BTreeSet::new();
        self.flood(0, 1, &mut gone);
        let mut misplaced = Vec::new();
        for (i, &hole) in holes.iter().enumerate() {
            match self.locate(hole) {
                Some(Spot::Inside([a, b, _])) if !gone.contains(&self.canonical(a, b)) => {
                    self.flood(a, b, &mut gone);
                }
                Some(Spot::Edge(a, b)) if !self.is_barrier(a, b) && !gone.contains(&self.canonical(a, b)) => {
                    self.flood(a, b, &mut gone);
                }
                _ => misplaced.push(i),
            }
        }
        let all: BTreeSet<[u32; 3]> = self.apex.keys().map(|&(a, b)| self.canonical(a, b)).collect();
        (all.difference(&gone).copied().collect(), misplaced)
    }

    /// Returns the triangle on the left of an edge, its smallest vertex first.
    fn canonical(&self, a: u32, b: u32) -> [u32; 3] {
        let c = self.apex.get(&(a, b)).copied().unwrap_or(a);
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }

    fn flood(&self, a: u32, b: u32, gone: &mut BTreeSet<[u32; 3]>) {
        let mut stack = vec![(a, b)];
        while let Some((a, b)) = stack.pop() {
            let Some(&c) = self.apex.get(&(a, b)) else { continue };
            if gone.insert(self.canonical(a, b)) {
                let edges = [(a, b), (b, c), (c, a)];
                stack.extend(edges.into_iter().filter(|&(u, v)| !self.is_barrier(u, v)).map(|(u, v)| (v, u)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(points: &[[f64; 2]], loops: &[&[usize]]) -> (Planar, Vec<u32>) {
        let points: Vec<DVec2> = points.iter().map(|&p| p.into()).collect();
        let mut planar = Planar::new(&Bounds::of(points.iter().copied()));
        let ids: Vec<u32> = points.iter().map(|&p| planar.insert(p).unwrap()).collect();
        for l in loops {
            for i in 0..l.len() {
                planar.constrain(ids[l[i]], ids[l[(i + 1) % l.len()]]).unwrap();
            }
        }
        (planar, ids)
    }

    fn area(planar: &Planar, triangles: &[[u32; 3]]) -> f64 {
        let p = |v: u32| planar.points[v as usize];
        triangles.iter().map(|t| (p(t[1]) - p(t[0])).perp_dot(p(t[2]) - p(t[0])) / 2.0).sum()
    }

    #[test]
    fn a_square_with_a_hole_and_a_notch() {
        let points = [
            [0., 0.],
            [8., 0.],
            [8., 8.],
            [4., 1.],
            [0., 8.],
            [3., 2.],
            [5., 0.5],
            [4., 0.25],
            [1., 1.],
            [2., 1.],
            [2., 2.],
        ];
        let (planar, _) = build(&points, &[&[0, 1, 2, 3, 4], &[8, 9, 10]]);
        let (inside, misplaced) = planar.inside(&[DVec2::new(1.75, 1.25)]);
        assert!(misplaced.is_empty());
        assert_eq!(area(&planar, &inside), 64.0 - 28.0 - 0.5);
        let (inside, misplaced) = planar.inside(&[DVec2::new(1.5, 1.0), DVec2::new(20.0, 1.0)]);
        assert_eq!((area(&planar, &inside), misplaced), (36.0, vec![0, 1]));
    }

    #[test]
    fn constraints_pass_through_vertices_and_stop_at_constraints() {
        let points = [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [2., 2.], [1., 3.]];
        let (mut planar, ids) = build(&points, &[&[0, 1, 2, 3]]);
        planar.constrain(ids[0], ids[2]).unwrap();
        assert!(planar.is_barrier(ids[0], ids[4]) && planar.is_barrier(ids[4], ids[2]));
        assert_eq!(planar.constrain(ids[1], ids[5]), Ok(()));
        let mut planar = build(&points[..4], &[&[0, 1, 2, 3], &[0, 2]]).0;
        assert_eq!(planar.constrain(5, 7), Err(Crossed));
    }

    #[test]
    fn long_constraints_cross_many_edges() {
        let mut points = vec![[-1.0, 0.0], [40.0, 0.3]];
        points.extend((0..120u32).map(|i| [(i % 40) as f64, ((i * 29) % 13) as f64 - 6.0]));
        let (mut planar, ids) = build(&points, &[]);
        planar.constrain(ids[0], ids[1]).unwrap();
        assert!(planar.is_barrier(ids[0], ids[1]) || planar.constraints.len() > 1);
        let all: BTreeSet<[u32; 3]> = planar.apex.keys().map(|&(a, b)| planar.canonical(a, b)).collect();
        let all: Vec<_> = all.into_iter().collect();
        assert!(all.iter().all(|t| planar.turn(t[0], t[1], t[2]) == Sign::Positive));
        let (low, high) = (planar.points[0], planar.points[2]);
        let whole = (high.x - low.x) * (high.y - low.y);
        assert!((area(&planar, &all) - whole).abs() < 1e-9 * whole);
    }
}
