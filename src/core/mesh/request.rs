//! The request for a mesh.

use septet_meshing::constrained::Wish;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::DomainKind;
use septet_meshing::repair::Tolerance;
use septet_meshing::size::SizeOptions;
use septet_meshing::size::user::{Constraints, Singularity};

use super::error::MeshError;
use super::field::SizeField;
use crate::spec::Spec;

/// The default Lipschitz constant. It bounds radius-edge ratios away from the boundary by `1/(1-L) = 2`, the usual
/// default of mesh generators. A smaller L needs more points everywhere. A larger L saves few points, because sizes
/// grow by at most L per unit of length and no faster than the local feature size.
pub const DEFAULT_LIPSCHITZ: f64 = 0.5;

/// The angle in degrees whose ratio of circumradius and shortest edge refinement reaches. In the plane, it is the least angle.
const LEAST_ANGLE: f64 = 20.0;

/// The default feature angle in degrees.
pub const DEFAULT_FEATURE_ANGLE: f64 = 60.0;

/// The part of the boundary that the mesh keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Every segment and every facet of the input.
    Exact,
    /// Corners, and ridges above the feature angle.
    Remesh,
}

words!(Boundary {
    Exact "exact" "Keep every segment and facet",
    Remesh "remesh" "Keep corners and ridges, and resample the rest of the surface",
});

impl Boundary {
    /// Returns the default for a kind of domain: `Exact` for a complex, `Remesh` for a surface.
    pub fn of(kind: DomainKind) -> Self {
        match kind {
            DomainKind::Complex => Boundary::Exact,
            DomainKind::Surface => Boundary::Remesh,
        }
    }
}

/// The shape of a singularity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SingularityShape {
    /// A point. The default is the midpoint of the bounding box.
    Point,
    /// A segment. The default is the middle third of the bounding box along the first axis.
    Line,
}

words!(SingularityShape {
    Point "point" "A point",
    Line "line" "A segment",
});

impl SingularityShape {
    /// Returns the number of points that describe the shape.
    pub(super) fn points(self) -> usize {
        match self {
            SingularityShape::Point => 1,
            SingularityShape::Line => 2,
        }
    }
}

/// A point or segment towards which sizes decrease to the smallest size.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularityRequest {
    /// The shape.
    pub shape: SingularityShape,
    /// The coordinates of one or two points. Empty for the default.
    pub at: Vec<f64>,
}

/// The sizes of a mesh, in the unit of the domain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sizes {
    /// The largest size anywhere.
    pub most: Option<f64>,
    /// The smallest size anywhere: it overrides every other size.
    pub least: Option<f64>,
    /// Sizes at points.
    pub field: Option<SizeField>,
    /// A point or segment towards which sizes decrease to the smallest size.
    pub singularity: Option<SingularityRequest>,
    /// The Lipschitz constant L of the size function, between 0 and 1.
    pub lipschitz: f64,
}

impl Default for Sizes {
    fn default() -> Self {
        Sizes { most: None, least: None, field: None, singularity: None, lipschitz: DEFAULT_LIPSCHITZ }
    }
}

/// A mesh: its sizes, its boundary, and the machine of its runs. Lengths are in the unit of the file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshSpec {
    /// The runs of the machine: the groups `machine`, `tree` and `control`, of which progress is not reported. The leaf
    /// size applies to the partition trees of independent sets. Without a memory limit, generation stops once the mesh
    /// certainly needs more than the available memory.
    pub run: Spec,
    /// How far the file may deviate from an exact domain.
    pub tolerance: Tolerance,
    /// The part of the boundary that is kept. The default depends on the kind of the domain.
    pub boundary: Option<Boundary>,
    /// The sizes.
    pub sizes: Sizes,
    /// Whether the domain is triangulated as it is: with points only where an edge of the input needs them, without
    /// sizes and without quality. The boundary is then exact.
    pub as_it_is: bool,
    /// Whether no point is placed on the boundary for sizes and shapes. The boundary is then exact.
    pub keep_surface: bool,
    /// The feature angle in degrees. Edges whose faces turn by more are ridges.
    pub feature_angle: f64,
    /// The largest distance between a surface and the remeshed boundary.
    pub max_distance: Option<f64>,
    /// Whether points are placed by Section 5 of the paper, and not by refinement of the constrained triangulation.
    pub conforming: bool,
    /// Whether cells with small angles are removed. It is the default.
    pub improve: bool,
    /// Whether triangulations run by the paper's recursion. Their work and depth are then those of the paper, and do not
    /// depend on the number of workers. The mesh is the same.
    pub by_recursion: bool,
}

impl Default for MeshSpec {
    fn default() -> Self {
        MeshSpec {
            run: Spec::default(),
            tolerance: Tolerance::default(),
            boundary: None,
            sizes: Sizes::default(),
            as_it_is: false,
            keep_surface: false,
            feature_angle: DEFAULT_FEATURE_ANGLE,
            max_distance: None,
            conforming: false,
            improve: true,
            by_recursion: false,
        }
    }
}

impl MeshSpec {
    /// Returns the specification after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut MeshSpec)) -> Self {
        change(&mut self);
        self
    }

    /// Returns an error if the caller has cancelled.
    pub(super) fn check_cancelled(&self) -> Result<(), MeshError> {
        if self.run.control.is_cancelled() { Err(MeshError::Run(crate::Error::Interrupted)) } else { Ok(()) }
    }

    /// Returns the part of the boundary that the mesh keeps for a domain of this kind.
    pub fn boundary_of(&self, kind: DomainKind) -> Boundary {
        if self.is_constrained() {
            return Boundary::Exact;
        }
        self.boundary.unwrap_or_else(|| Boundary::of(kind))
    }

    /// Returns `true` if the mesh is a constrained triangulation, of which no ratio is promised.
    pub fn is_constrained(&self) -> bool {
        self.as_it_is || self.keep_surface
    }

    /// Returns `true` if this domain is remeshed. A surface that is not a manifold is kept by default.
    pub fn remeshes<P: Triangulate>(&self, domain: &Domain<P>) -> bool {
        self.boundary_of(domain.kind) == Boundary::Remesh && (self.boundary.is_some() || domain.manifold)
    }

    /// Whether the constrained triangulation of a domain is refined.
    pub fn is_refined<P: Triangulate>(&self, domain: &Domain<P>) -> bool {
        !self.as_it_is && (self.keep_surface || !self.conforming) && (P::DIM == 2 || !self.remeshes(domain))
    }

    /// Whether only the request limits the sizes: for a constrained triangulation as it is or refined.
    pub fn is_free<P: Triangulate>(&self, domain: &Domain<P>) -> bool {
        self.as_it_is || self.is_refined(domain)
    }

    /// Returns what refinement must reach: the largest radius-edge ratio, but at most that of an angle of 20 degrees in
    /// the plane.
    pub fn wish(&self) -> Wish {
        let ratio = self.radius_edge().min(0.5 / LEAST_ANGLE.to_radians().sin());
        Wish { ratio, divides: !self.keep_surface }
    }

    /// Returns the largest radius-edge ratio away from the boundary: `1/(1-L)`.
    pub fn radius_edge(&self) -> f64 {
        1.0 / (1.0 - self.sizes.lipschitz)
    }

    /// Returns the options of the size function for this domain.
    ///
    /// # Errors
    /// Fails if a field or a singularity has a different dimension.
    pub fn size_options<P: Triangulate>(&self, domain: &Domain<P>) -> Result<SizeOptions<P>, MeshError> {
        let sizes = &self.sizes;
        let field = sizes.field.as_ref().map(SizeField::cones::<P>).transpose()?.unwrap_or_default();
        let singularities = match (&sizes.singularity, sizes.least) {
            (Some(singularity), Some(size)) => vec![(singularity.place(domain)?, size)],
            _ => Vec::new(),
        };
        let constraints = Constraints { most: sizes.most, least: sizes.least, field, singularities };
        Ok(SizeOptions { constraints, ..SizeOptions::new(sizes.lipschitz) })
    }
}

impl SingularityRequest {
    fn place<P: Triangulate>(&self, domain: &Domain<P>) -> Result<Singularity<P>, MeshError> {
        let due = if self.shape == SingularityShape::Point { P::DIM } else { 2 * P::DIM };
        if self.at.len() == due {
            let (p, q) = (P::from_coords(&self.at), P::from_coords(&self.at[due - P::DIM..]));
            return Ok(if self.shape == SingularityShape::Point {
                Singularity::Point(p)
            } else {
                Singularity::Line(p, q)
            });
        }
        if !self.at.is_empty() {
            let found = if self.shape == SingularityShape::Point { self.at.len() } else { self.at.len() / 2 };
            return Err(MeshError::Dimension { what: "singularity", expected: P::DIM, found });
        }
        let unscaled = |p: P| domain.simplices.frame.outward(p);
        let live = domain.corners.iter().map(|&v| domain.points()[v as usize]);
        let bounds = septet_meshing::bvh::Bounds::of(live);
        let middle = bounds.low + (bounds.high - bounds.low) * 0.5;
        if self.shape == SingularityShape::Point {
            return Ok(Singularity::Point(unscaled(middle)));
        }
        let third = (bounds.high.coord(0) - bounds.low.coord(0)) / 3.0;
        let at = |x: f64| {
            let mut p = middle;
            p.set_coord(0, x);
            unscaled(p)
        };
        Ok(Singularity::Line(at(bounds.low.coord(0) + third), at(bounds.low.coord(0) + 2.0 * third)))
    }
}
