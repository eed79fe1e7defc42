//! The position of circumcentres relative to balls, which determines the promised radius-edge ratio.
//!
//! **Statement.** Every edge on a segment and every face on a facet has a smallest ball through its corners. The
//! circumcentre of a cell, if it lies in the domain, is
//! - *near* if it lies in the ball of an edge, or above a face with `r <= f(m)`;
//! - *above* if it lies only above faces with `r > f(m)`;
//! - *free* if it lies in no ball.
//!
//! If balls of one or more faces of a facet contain the centre, it is above the face whose ball has the least power.
//! The faces are Delaunay, so this face contains the foot of the centre. A centre that lies on the boundary of a ball
//! up to rounding (`ROUNDING`) counts as inside. If features meet at less than 90 degrees, the generator keeps the
//! points of the volume out of larger balls, which the mesh does not show. A centre within `f / (1 - L)` of a feature
//! then also counts as near.
//!
//! **Work and depth.** Two tree queries per cell, plus the work of [`super::zones`].

use std::collections::BTreeMap;

use septet_geometry::measure::circumcircle;
use septet_geometry::point::{Point, dist2};

use super::CentrePlace;
use super::promise::Promise;
use super::zones::Zones;
use crate::bvh::{Bounds, Bvh};
use crate::distance::Features;
use crate::domain::{Domain, Feature};
use crate::mesh::Mesh;
use crate::space::Space;

/// If features meet at a smaller angle (in degrees), they have larger balls than the mesh shows.
const RIGHT: f64 = 90.0;

/// The relative tolerance when a centre is compared with a ball, or a radius with f.
const ROUNDING: f64 = 1e-9;

/// Balls of one kind, as centres and squared radii. Each ball has the feature of its corners.
struct BallKind<P> {
    balls: Vec<(P, f64)>,
    features: Vec<u32>,
    tree: Bvh<P>,
}

impl<P: Point> BallKind<P> {
    fn new(balls: Vec<(P, f64)>, features: Vec<u32>) -> Self {
        let bounds = |&(centre, radius2): &(P, f64)| {
            let half = P::splat(radius2.sqrt() * (1.0 + ROUNDING));
            Bounds { low: centre - half, high: centre + half }
        };
        BallKind { tree: Bvh::new(balls.iter().map(bounds).collect()), balls, features }
    }

    /// Returns, for each feature in ascending order, the ball of least power that contains the point.
    fn holding(&self, x: P) -> BTreeMap<u32, (f64, u32)> {
        let mut found: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
        self.tree.visit(&Bounds::of([x]), |i| {
            let (centre, radius2) = self.balls[i as usize];
            let distance2 = dist2(centre, x);
            if distance2 < radius2 * (1.0 + ROUNDING) {
                let new = (distance2 - radius2, i);
                let least = found.entry(self.features[i as usize]).or_insert(new);
                if new.0 < least.0 {
                    *least = new;
                }
            }
            true
        });
        found
    }
}

/// The balls of the edges on segments and of the faces on facets of a mesh.
pub struct BoundaryBalls<'a, P: Space> {
    zones: Zones<'a, P>,
    subsegments: BallKind<P>,
    subfacets: BallKind<P>,
    /// The ratio `r / f(m)` of every subfacet.
    widths: Vec<f64>,
}

impl<'a, P: Space> BoundaryBalls<'a, P> {
    /// Collects the balls of a mesh. `size` is f in the scaled coordinates of the domain, and its Lipschitz constant.
    pub fn new(
        domain: &'a Domain<P>,
        features: &'a Features<P>,
        mesh: &Mesh<P>,
        size: &'a (dyn Fn(P) -> f64 + Sync),
        lipschitz: f64,
    ) -> Self {
        let at = |v: u32| domain.simplices.frame.inward(mesh.points[v as usize]);
        let subsegment = |ends: &[u32]| {
            let (p, q) = (at(ends[0]), at(ends[1]));
            ((p + q) * 0.5, 0.25 * dist2(p, q))
        };
        let faces = mesh.faces.iter();
        let of_faces: Vec<u32> = faces.clone().map(|f| f.facet).collect();
        let (subsegments, subfacets) = if P::DIM == 2 {
            let balls = faces.map(|f| subsegment(f.vertices.as_ref())).collect();
            (BallKind::new(balls, of_faces), BallKind::new(Vec::new(), Vec::new()))
        } else {
            let edges = mesh.edges.iter();
            let of_edges = edges.clone().map(|e| e.segment).collect();
            let balls = faces.map(|f| circumcircle([0, 1, 2].map(|i| at(f.vertices.as_ref()[i])))).collect();
            let subsegments = edges.map(|e| subsegment(&e.vertices)).collect();
            (BallKind::new(subsegments, of_edges), BallKind::new(balls, of_faces))
        };
        let widths = subfacets.balls.iter().map(|&(m, radius2)| radius2.sqrt() / size(m)).collect();
        let zone = if domain.small_angles(RIGHT).is_empty() { 0.0 } else { 1.0 / (1.0 - lipschitz) };
        let zones = Zones { domain, features, size, zone };
        BoundaryBalls { zones, subsegments, subfacets, widths }
    }

    /// Returns the largest `r / f(m)` of a face on a facet.
    pub fn widest(&self) -> f64 {
        self.widths.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the bounds promised for this mesh.
    pub fn promise(&self, lipschitz: f64) -> Promise {
        let widest = self.widest();
        Promise::with(lipschitz, if widest <= 1.0 + ROUNDING { 1.0 } else { widest * (1.0 + ROUNDING) })
    }

    /// Returns the position of a circumcentre with the given circumradius.
    pub fn place(&self, centre: P, radius: f64) -> CentrePlace {
        let place = self.zones.place(centre, radius);
        if let CentrePlace::Outside(_) = place {
            return place;
        }
        if let Some((&segment, _)) = self.subsegments.holding(centre).first_key_value() {
            return CentrePlace::Near(Feature::Segment(segment));
        }
        let above = self.subfacets.holding(centre);
        let complete = |(_, (_, i)): &(&u32, &(f64, u32))| self.widths[*i as usize] <= 1.0 + ROUNDING;
        match (above.iter().find(complete), above.first_key_value()) {
            (Some((&facet, _)), _) => CentrePlace::Near(Feature::Facet(facet)),
            (None, Some((&facet, _))) => CentrePlace::Above(Feature::Facet(facet)),
            (None, None) => place,
        }
    }
}
