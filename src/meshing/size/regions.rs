//! Size limits of regions.
//!
//! **Statement.** Let a region have a limit V for the volume (in the plane: the area) of its cells. Its size h is the
//! side of the regular simplex of measure V. Cells then have about this measure. The limit is a target, not a bound.
//! Outside the region K, the size may grow with the distance from K: `h + L dist(x, K)` is L-Lipschitz. The distance
//! is 0 in K, and elsewhere it is the distance from the walls of K.
//!
//! **Work and depth.** Each query locates the point, and then searches for the nearest wall of each region.

use septet_geometry::cost::Sweep;
use septet_geometry::range::scale;

use crate::bvh::Bvh;
use crate::distance::{closest_on_segment, closest_on_triangle};
use crate::domain::Domain;
use crate::sides::{Location, Sides};
use crate::space::Space;

/// A region with a limit.
#[derive(Clone, Debug)]
struct Limited<P: Space> {
    component: u32,
    size: f64,
    walls: Vec<P::Facet>,
    tree: Bvh<P>,
}

/// The limits of all regions, as sizes.
#[derive(Clone, Debug)]
pub struct Regions<P: Space> {
    slope: f64,
    points: Vec<P>,
    sides: Sides<P>,
    limits: Vec<Limited<P>>,
}

impl<P: Space> Regions<P> {
    /// Collects the limits of a domain. Returns `None` if no region has a limit.
    pub fn new(slope: f64, domain: &Domain<P>) -> Option<Self> {
        let limited = domain.components.iter().enumerate().filter_map(|(c, component)| {
            let limit = domain.regions[component.region? as usize].limit?;
            Some((c as u32, scale(P::splat(side(P::DIM, limit)), domain.simplices.frame.exponent).coord(0)))
        });
        let limits: Vec<_> = limited.map(|(c, size)| walls_of(domain, c, size)).collect();
        let (points, sides) = (domain.points().to_vec(), domain.sides.clone());
        (!limits.is_empty()).then_some(Regions { slope, points, sides, limits })
    }

    /// Returns the largest size that the limits allow at a point.
    pub fn at(&self, x: P) -> f64 {
        self.at_counted(x, &mut Sweep::default())
    }

    /// Returns [`Regions::at`], and counts the visits of the trees of walls.
    pub(super) fn at_counted(&self, x: P, visits: &mut Sweep) -> f64 {
        let place = self.sides.locate_counted(&self.points, x, visits);
        let sizes = self.limits.iter().map(|l| {
            let inside = place == Some(Location::Component(l.component));
            l.size + if inside { 0.0 } else { self.slope * self.distance(l, x, visits) }
        });
        sizes.fold(f64::INFINITY, f64::min)
    }

    fn distance(&self, limited: &Limited<P>, x: P, visits: &mut Sweep) -> f64 {
        let mut least = f64::INFINITY;
        let dist2 = |i: u32| {
            let corners = P::corners(&self.points, &limited.walls[i as usize]);
            let closest = match corners[..] {
                [a, b] => closest_on_segment(a, b, x),
                [a, b, c, ..] => closest_on_triangle(a, b, c, x),
                _ => x,
            };
            (x - closest).norm2()
        };
        limited.tree.nearest_counted(x, visits, dist2, |_, d2| {
            least = d2.sqrt();
            false
        });
        least
    }
}

/// Returns a component with its walls.
fn walls_of<P: Space>(domain: &Domain<P>, component: u32, size: f64) -> Limited<P> {
    let all =
        (0..domain.walls().len() as u32).filter(|&w| domain.sides.components_at(w).contains(&component));
    let walls: Vec<P::Facet> = all.map(|w| domain.walls()[w as usize]).collect();
    let tree = Bvh::new(walls.iter().map(|w| domain.simplices.bounds(w.as_ref())).collect());
    Limited { component, size, walls, tree }
}

/// Returns the side of the regular triangle with an area, or of the regular tetrahedron with a volume. Only square
/// roots and Newton steps are used, so the result is the same on every platform.
fn side(dimension: usize, measure: f64) -> f64 {
    if dimension == 2 {
        return (4.0 * measure / 3f64.sqrt()).sqrt();
    }
    let cube = 6.0 * 2f64.sqrt() * measure;
    let exponent = ((cube.to_bits() >> 52) as i64 - 1023).div_euclid(3);
    // The initial value is correct within a factor of two. From the third step on, the number of correct digits
    // doubles.
    let mut side = f64::from_bits(((exponent + 1023) as u64) << 52) * 1.5;
    for _ in 0..10 {
        side = (2.0 * side + cube / (side * side)) / 3.0;
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check;
    use crate::input::Region;
    use crate::size::{SizeFunction, SizeOptions};
    use crate::tests::shapes::{add_box, cube};
    use glam::DVec3;

    #[test]
    fn sides_of_regular_simplices() {
        for side_wanted in [1e-9, 0.3, 1.0, 1.26, 2.0, 7e5] {
            let volume = side_wanted * side_wanted * side_wanted / (6.0 * 2f64.sqrt());
            assert!((side(3, volume) - side_wanted).abs() < 1e-15 * side_wanted);
            let area = 3f64.sqrt() / 4.0 * side_wanted * side_wanted;
            assert!((side(2, area) - side_wanted).abs() < 1e-15 * side_wanted);
        }
    }

    #[test]
    fn a_limited_region_is_fine_inside_and_coarser_with_the_distance() {
        let mut input = cube();
        add_box(&mut input, DVec3::splat(1.0), DVec3::new(2.0, 3.0, 3.0));
        let volume = 0.001 / (6.0 * 2f64.sqrt());
        let region = |at, limit| Region { at: DVec3::splat(at), attribute: 0.0, limit };
        input.regions = vec![region(0.5, None), region(1.5, Some(volume))];
        let domain = check(&input).unwrap();
        let size = SizeFunction::new(&domain, &SizeOptions::new(0.25)).unwrap();
        let at = |x, y, z| size.at(DVec3::new(x, y, z));
        assert!((at(1.5, 1.2, 2.9) - 0.1).abs() < 1e-15);
        assert!((at(2.0, 2.0, 2.0) - 0.1).abs() < 1e-15);
        assert!((at(2.5, 2.0, 2.0) - 0.225).abs() < 1e-15);
        let unlimited = {
            input.regions[1].limit = None;
            SizeFunction::new(&check(&input).unwrap(), &SizeOptions::new(0.25)).unwrap()
        };
        assert!(unlimited.at(DVec3::new(1.5, 1.2, 2.9)) > 0.2);
        let places: Vec<DVec3> = (0..60)
            .map(|i| DVec3::new(f64::from(i * 7 % 41), f64::from(i * 11 % 37), f64::from(i % 35)) / 10.0)
            .collect();
        for &x in &places {
            for &y in &places {
                assert!((size.at(x) - size.at(y)).abs() <= 0.25 * x.distance(y) * (1.0 + 1e-12) + 1e-14);
            }
        }
    }
}
