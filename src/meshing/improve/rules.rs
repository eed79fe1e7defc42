//! The rules that all changes of an improvement obey.

use glam::DVec2;
use septet_geometry::measure::radius_edge_ratio;
use septet_geometry::predicates::{Sign, orientation};

use super::editable::{Editable, row_of};
use super::shape::{Grade, grade};
use super::surface::Surface;
use super::target::Target;
use crate::domain::Domain;
use crate::space::Space;

/// The domain and the target of an improvement.
pub(super) struct Rules<'a, P: Space> {
    pub(super) domain: &'a Domain<P>,
    pub(super) target: &'a Target,
    /// The sine of the target.
    pub(super) wanted: f64,
    /// The unit normal of each facet. Empty in the plane.
    pub(super) normals: Vec<P>,
    /// The surface that a remeshed boundary follows.
    pub(super) surface: Option<Surface<P>>,
}

/// The relative error of a radius-edge ratio. A flip of cospherical cells keeps the ratio, but rounds it differently.
const ROUNDING: f64 = 1e-12;

impl<'a, P: Space> Rules<'a, P> {
    pub(super) fn new(domain: &'a Domain<P>, target: &'a Target) -> Self {
        let unit = |f: u32| {
            let n = crate::generate::normal_of(domain, f);
            n / n.norm2().sqrt()
        };
        Rules {
            domain,
            target,
            wanted: target.angle.to_radians().sin(),
            normals: (0..domain.facets.len() as u32).map(unit).collect(),
            surface: target.follow.map(|follow| Surface::new(domain, follow.distance)),
        }
    }

    /// Moves a new vertex to the nearest point that can be written.
    pub(super) fn snapped(&self, p: P) -> P {
        self.domain.simplices.frame.snapped(p)
    }

    /// Returns the radius-edge ratio that cells may have if they replace cells with this largest ratio.
    pub(super) fn ratio(&self, worst: f64) -> f64 {
        self.target.ratio.max(worst * (1.0 + ROUNDING))
    }

    /// Returns the grade of a new cell, or `None` if the cell is not positive or its radius-edge ratio is too large to replace
    /// cells with this largest ratio.
    pub(super) fn admits(&self, cell: &[P], worst: f64) -> Option<Grade> {
        let grade = grade(cell);
        let is_good = grade.sine > 0.0
            && radius_edge_ratio(cell) <= self.ratio(worst)
            && orientation(cell) == Sign::Positive;
        is_good.then_some(grade)
    }

    /// Returns `true` if the diagonals of four points of a facet cross: those from a to b and from c to d. The test is
    /// exact in a projection along an axis.
    pub(super) fn cross(&self, facet: u32, [a, b, c, d]: [P; 4]) -> bool {
        let normal = self.normals[facet as usize];
        let size = |i: usize| normal.coord(i).abs();
        let axis = (1..3).fold(0, |k, i| if size(i) > size(k) { i } else { k });
        let flat = |p: P| match axis {
            0 => DVec2::new(p.coord(1), p.coord(2)),
            1 => DVec2::new(p.coord(2), p.coord(0)),
            _ => DVec2::new(p.coord(0), p.coord(1)),
        };
        let side = |p: P, q: P, r: P| orientation(&[p, q, r].map(flat));
        let apart = |s: Sign, t: Sign| s != Sign::Zero && t != Sign::Zero && s != t;
        apart(side(a, b, c), side(a, b, d)) && apart(side(c, d, a), side(c, d, b))
    }
}

/// Returns the grade of some cells, and their largest radius-edge ratio.
pub(super) fn measured<P: Space>(mesh: &Editable<P>, cells: &[u32]) -> (Grade, f64) {
    let of = |&c: &u32| {
        let corners = mesh.corners(c);
        (grade(row_of(&corners)), radius_edge_ratio(row_of(&corners)))
    };
    cells.iter().map(of).fold((Grade::BEST, 0.0), |a, b| (a.0.and(b.0), a.1.max(b.1)))
}
