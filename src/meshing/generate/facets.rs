//! Points on facets in space.
//!
//! **Statement.** A planar generator runs in the plane of each facet, on all facets at once:
//! 1. Candidates lie in the cells of a quadtree per facet, outside the balls of subsegments.
//! 2. A maximal independent set of them is taken, with all earlier points fixed.
//! 3. Circumcentres of subfacets that are too large are added until no subfacet is too large. A circumcentre in a
//!    ball of a subsegment is moved off-centre, out of the ball.

use glam::{DVec2, DVec3};
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::At;
use septet_geometry::measure;
use septet_geometry::point::{Point, dist2, lex_cmp};

use super::balls::{Ball, Balls};
use super::generator::{CANDIDATES, Candidate, Generator, SIDE};
use super::machine::MeshMachine;
use super::segments::{Chains, Subsegment, subsegments_of};
use super::subdivision::{Division, divided};
use crate::bvh::{Bounds, Bvh};
use crate::executor::{Part, evaluated, in_sequence};
use crate::mesh::Carrier;
use crate::octree::{CellKey, Cube, DEEPEST};
use crate::points::candidates::Name;
use crate::space::Space;

/// The plane of a facet, and the walls of the facet in planar coordinates.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    origin: DVec3,
    axes: [DVec3; 2],
    walls: Vec<[DVec2; 3]>,
    tree: Bvh<DVec2>,
    /// A bound on the distance between rounded and exact points of the facet.
    rounding: f64,
}

/// A bound on the rounding of a point in a plane, relative to the largest coordinate.
pub(super) const ROUNDING: f64 = 1e-14;

impl Plane {
    fn new(walls: &[[DVec3; 3]], grid: f64) -> Self {
        let normal = |w: &[DVec3; 3]| (w[1] - w[0]).cross(w[2] - w[0]);
        let largest =
            walls.iter().max_by(|a, b| normal(a).length_squared().total_cmp(&normal(b).length_squared()));
        let wall = largest.copied().unwrap_or_default();
        let n = normal(&wall).normalize_or(DVec3::Z);
        let small = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .min_by(|a, b| n.dot(*a).abs().total_cmp(&n.dot(*b).abs()));
        let u = n.cross(small.unwrap_or(DVec3::X)).normalize();
        let coordinates = walls.iter().flatten().flat_map(DVec3::to_array);
        let rounding = ROUNDING * coordinates.fold(0.0, |largest, x| x.abs().max(largest)) + grid;
        let axes = [u, n.cross(u)];
        let mut plane =
            Plane { origin: wall[0], axes, walls: Vec::new(), tree: Bvh::new(Vec::new()), rounding };
        plane.walls = walls.iter().map(|w| w.map(|p| plane.of(p))).collect();
        plane.tree = Bvh::new(plane.walls.iter().map(|w| Bounds::of(*w)).collect());
        plane
    }

    pub(super) fn of(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1]))
    }

    pub(super) fn lift(&self, q: DVec2) -> DVec3 {
        self.origin + self.axes[0] * q.x + self.axes[1] * q.y
    }

    /// Returns the unit normal, up to rounding. The two axes and the normal are right-handed.
    pub(super) fn normal(&self) -> DVec3 {
        self.axes[0].cross(self.axes[1])
    }

    /// Returns `true` if the facet contains the point. The test is rounded, so either answer is correct on the
    /// boundary.
    pub(super) fn holds(&self, q: DVec2) -> bool {
        self.wall_at(q).is_some()
    }

    /// Returns the position, in the list of the facet, of a wall that contains the point. The test is rounded, like
    /// [`Self::holds`].
    pub(super) fn wall_at(&self, q: DVec2) -> Option<usize> {
        self.wall_at_counted(q, &mut Sweep::default())
    }

    /// Returns [`Plane::wall_at`], and counts the visits of the tree.
    fn wall_at_counted(&self, q: DVec2, visits: &mut Sweep) -> Option<usize> {
        let turn = |a: DVec2, b: DVec2| (b - a).perp_dot(q - a);
        let mut found = None;
        self.tree.visit_counted(&Bounds::of([q]), visits, |i| {
            let [a, b, c] = self.walls[i as usize];
            let turns = [turn(a, b), turn(b, c), turn(c, a)];
            let held = turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0);
            found = held.then_some(i as usize);
            !held
        });
        found
    }

    fn meets(&self, bounds: &Bounds<DVec2>, visits: &mut Sweep) -> bool {
        let mut met = false;
        self.tree.visit_counted(bounds, visits, |_| {
            met = true;
            false
        });
        met
    }
}

/// Returns the smallest ball through three points.
pub(super) fn circumcircle<P: Point>(a: P, b: P, c: P) -> Ball<P> {
    let (centre, radius2) = measure::circumcircle([a, b, c]);
    Ball { centre, radius2 }
}

/// A subfacet: its facet and its vertices.
pub type Subfacet = (u32, [u32; 3]);

/// The subfacets of all facets.
pub(super) type Subfacets = Vec<Subfacet>;

/// The subsegments and subfacets, in the order of their balls.
pub(super) struct Subfeatures<'a> {
    pub(super) subsegments: Vec<Subsegment>,
    pub(super) subfacets: &'a Subfacets,
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the planes of all facets. Empty in the plane.
    pub(super) fn planes(&self) -> Vec<Plane> {
        let at = |v: u32| as_space(self.domain.points()[v as usize]);
        let corners = |w: &u32| {
            let wall = self.domain.walls()[*w as usize];
            [0, 1, 2].map(|i| at(wall.as_ref()[i]))
        };
        let walls = |f: &crate::domain::Facet| f.walls.iter().map(corners).collect::<Vec<_>>();
        let grid = self.domain.simplices.frame.grid();
        self.domain.facets.iter().map(|f| Plane::new(&walls(f), grid)).collect()
    }

    /// Places the points of all facets.
    pub(super) fn facets(&mut self, planes: &[Plane], chains: &Chains) -> Result<Subfacets, M::Error> {
        self.begin("facets");
        let found = self.facet_candidates(planes)?;
        self.sample(found)?;
        let mut subfacets: Vec<Vec<[u32; 3]>> = vec![Vec::new(); planes.len()];
        let mut stale: Vec<u32> = (0..planes.len() as u32).collect();
        let flats = Subfeatures { subsegments: subsegments_of(chains), subfacets: &Vec::new() };
        loop {
            self.triangulate_facets(planes, chains, &stale, &mut subfacets)?;
            let coarse: Vec<Subfacet> =
                stale.iter().flat_map(|&f| subfacets[f as usize].iter().map(move |&t| (f, t))).collect();
            let found = self.coarse_centres(planes, &coarse, &flats)?;
            let before = self.vertices.len();
            if self.complete(found, false)? == 0 {
                break;
            }
            let new = &self.vertices.carriers[before..];
            stale =
                new.iter().filter_map(|c| if let Carrier::Facet(f) = c { Some(*f) } else { None }).collect();
            stale.sort_unstable();
            stale.dedup();
        }
        let all: Subfacets =
            (0u32..).zip(subfacets).flat_map(|(f, t)| t.into_iter().map(move |t| (f, t))).collect();
        self.subfacets = Balls::new(self.balls_of_subfacets(&all));
        Ok(all)
    }

    pub(super) fn balls_of_subfacets(&self, subfacets: &Subfacets) -> Vec<Ball<P>> {
        let ball = |(_, t): &Subfacet| {
            let [a, b, c] = t.map(|v| self.vertices.points[v as usize]);
            circumcircle(a, b, c)
        };
        subfacets.iter().map(ball).collect()
    }

    /// Computes the Delaunay triangulations of some facets in their planes. Triangles outside a facet are omitted.
    pub(super) fn triangulate_facets(
        &mut self,
        planes: &[Plane],
        chains: &Chains,
        which: &[u32],
        subfacets: &mut [Vec<[u32; 3]>],
    ) -> Result<(), M::Error> {
        if planes.is_empty() {
            return Ok(());
        }
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); planes.len()];
        for (v, carrier) in (0u32..).zip(&self.vertices.carriers) {
            if !matches!(carrier, Carrier::Segment(_)) {
                self.holders.of(carrier).iter().for_each(|&f| members[f as usize].push(v));
            }
        }
        for (s, chain) in (0u32..).zip(chains) {
            let inner = chain.get(1..chain.len() - 1).unwrap_or_default();
            for &f in self.holders.of(&Carrier::Segment(s)) {
                members[f as usize].extend(inner);
            }
        }
        let coordinates = |&f: &u32| {
            let plane = &planes[f as usize];
            members[f as usize]
                .iter()
                .map(|&v| plane.of(as_space(self.vertices.points[v as usize])))
                .collect()
        };
        let sets: Vec<Vec<DVec2>> = which.iter().map(coordinates).collect();
        for ((&f, set), made) in which.iter().zip(&sets).zip(self.machine.planar(&sets)?) {
            // The rounding must not depend on the order in which a machine returns the corners.
            let middle = |t: &[u32; 3]| {
                let mut corners = t.map(|v| set[v as usize]);
                corners.sort_unstable_by(lex_cmp);
                corners.iter().sum::<DVec2>() / 3.0
            };
            let inside = made.into_iter().filter(|t| planes[f as usize].holds(middle(t)));
            let own = inside.map(|t| {
                let mut t = t.map(|v| members[f as usize][v as usize]);
                t.sort_unstable();
                t
            });
            let mut own: Vec<[u32; 3]> = own.filter(|t| !self.is_on_a_line(t, &planes[f as usize])).collect();
            // The order must not depend on the machine.
            own.sort_unstable();
            subfacets[f as usize] = own;
        }
        Ok(())
    }

    /// Returns `true` if all corners of a triangle lie on one segment, or on several collinear segments. Such a
    /// triangle is flat up to rounding.
    fn is_on_a_line(&self, triangle: &[u32; 3], plane: &Plane) -> bool {
        let carriers = &self.vertices.carriers;
        let on_segment = |v: &u32| matches!(carriers[*v as usize], Carrier::Corner(_) | Carrier::Segment(_));
        triangle.iter().all(on_segment)
            && (!self.lines.common(carriers, triangle).is_empty() || {
                let [a, b, c] = triangle.map(|v| plane.of(as_space(self.vertices.points[v as usize])));
                let longest =
                    [a - b, b - c, c - a].into_iter().map(DVec2::length_squared).fold(0.0, f64::max);
                (b - a).perp_dot(c - a).abs() <= plane.rounding * longest.sqrt()
            })
    }

    /// Returns the candidates of all facets.
    fn facet_candidates(&self, planes: &[Plane]) -> Result<Vec<Candidate<P>>, M::Error> {
        let cubes: Vec<Cube<DVec2>> = planes.iter().map(|plane| Cube::around(&plane.tree.bounds())).collect();
        let roots: Vec<(u32, CellKey)> = (0..planes.len() as u32).map(|f| (f, CellKey::ROOT)).collect();
        let decide = |(f, key): (u32, CellKey), own: &mut Cost| {
            // A damaged message may name a facet that does not exist. The run then ends with an error.
            let Some((plane, cube)) = planes.get(f as usize).zip(cubes.get(f as usize)) else {
                return Division::Drop;
            };
            let cell = cube.cell(key);
            let half = DVec2::splat(0.5 * cell.side);
            in_sequence(own, |visits| {
                if !plane.meets(&Bounds { low: cell.centre - half, high: cell.centre + half }, visits) {
                    return Division::Drop;
                }
                let size = self.rules.size.at_counted(from_space(plane.lift(cell.centre)), visits);
                let is_wide = SIDE * size < cell.side && key.level < DEEPEST;
                if is_wide { Division::Divide((f, key)) } else { Division::Leaf((f, key)) }
            })
        };
        let children =
            |&(f, key): &(u32, CellKey)| (0..4).map(|i| (f, key.child::<DVec2>(i))).collect::<Vec<_>>();
        let leaves = divided(&*self.machine, (&roots, 4, u64::MAX), children, decide)?;
        let mut leaves: Vec<(u32, CellKey)> = leaves.unwrap_or_default();
        leaves.sort_by_key(|&(f, _)| f);
        let places =
            evaluated(&*self.machine, Part::Candidates, &leaves, |(f, key): (u32, CellKey), own| {
                let (plane, cell) = (&planes[f as usize], cubes[f as usize].cell(key));
                let seed = self.seed_of(f);
                let place = |number| {
                    let q = Name { cell: key, number }.place(&cell, seed);
                    let at = from_space(plane.lift(q));
                    let is_free = in_sequence(own, |visits| {
                        plane.wall_at_counted(q, visits).is_some()
                            && !self.subsegments.hold_counted(at, visits)
                    });
                    is_free.then_some(At(at))
                };
                (0..CANDIDATES).filter_map(place).collect::<Vec<At<P>>>()
            })?;
        let places = leaves.iter().zip(places);
        let found = places.flat_map(|(&(f, _), at)| at.into_iter().map(move |at| (at.0, Carrier::Facet(f))));
        self.sized(found.collect())
    }

    /// Returns the centres of the subfacets that are too large.
    fn coarse_centres(
        &self,
        planes: &[Plane],
        subfacets: &[Subfacet],
        flats: &Subfeatures<'_>,
    ) -> Result<Vec<Candidate<P>>, M::Error> {
        let found = evaluated(&*self.machine, Part::Completion, subfacets, |(f, t): Subfacet, own| {
            in_sequence(own, |visits| self.centre_in(&planes[f as usize], t, flats, visits)).map(At)
        })?;
        let found = subfacets.iter().zip(found).filter_map(|(&(f, _), at)| Some((at?.0, Carrier::Facet(f))));
        self.sized(found.collect())
    }

    /// Returns the centre of a subfacet that is too large, or its off-centre point.
    fn centre_in(
        &self,
        plane: &Plane,
        t: [u32; 3],
        flats: &Subfeatures<'_>,
        visits: &mut Sweep,
    ) -> Option<P> {
        let [a, b, c] = t.map(|v| self.vertices.points[v as usize]);
        let Ball { centre, radius2 } = circumcircle(a, b, c);
        let largest = t.iter().map(|&v| self.vertices.sizes[v as usize]).fold(0.0, f64::max);
        if !self.rules.is_too_large(centre, radius2.sqrt(), largest, visits) {
            return None;
        }
        let centre = self.off_centre(centre, flats, visits)?;
        let q = plane.of(as_space(centre));
        let at = from_space(plane.lift(q));
        let is_free = plane.wall_at_counted(q, visits).is_some()
            && dist2(at, a) > 0.0
            && !self.subsegments.hold_counted(at, visits);
        is_free.then_some(at)
    }
}

/// Converts a point to three coordinates.
pub(super) fn as_space<P: Point>(p: P) -> DVec3 {
    DVec3::new(p.coord(0), p.coord(1), if P::DIM == 3 { p.coord(2) } else { 0.0 })
}

pub(super) fn from_space<P: Point>(p: DVec3) -> P {
    P::from_coords(&p.to_array())
}
