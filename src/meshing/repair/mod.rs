//! From the content of a file to an input whose check is exact.
//!
//! **Statement.** Files round coordinates, repeat points and list the parts of a domain one by one. Each step removes one
//! kind of these deviations and says so ([`Change`]). The numbering of points stays. Facets keep the number that they
//! have in the file, also if several stand for one. The steps run in this order:
//!
//! | step | runs | file |
//! | --- | --- | --- |
//! | points within a distance become one | with a weld distance | `weld` |
//! | elements without length or area are dropped | on request | `degenerate` |
//! | facets with equal corners are dropped | on request | `double` |
//! | edges are divided at the points on them | on request | `junctions` |
//! | small holes are closed | on request | `holes` |
//! | solids become regions or markers | always | `solids` |
//! | facets that are planar within the digits become triangles | always | `flat` |
//!
//! The exact check ([`crate::check()`]) judges the result. It knows no tolerance, and no step can make it accept an input
//! whose elements intersect. It identifies points with equal coordinates. Parts that an odd number of facets separates
//! from the outside are inside. So it accepts equal points, and edges with four facets.
//!
//! **Work and depth.** `O(m log m)`, sequential.

mod change;
mod degenerate;
mod double;
mod flat;
mod holes;
mod junctions;
mod mending;
mod solids;
mod weld;

use glam::{DVec2, DVec3};
use septet_geometry::range::{scale, scale_exponent};

use crate::defect::{Defect, Element};
use crate::digits::Digits;
use crate::facet::Triangulate;
use crate::input::{DomainKind, Input};

pub use change::{Change, ChangeInFile, Dropped};
pub use holes::{MOST_AREA, MOST_EDGES};
#[doc(hidden)]
pub use mending::Mending;
pub use solids::Solids;

/// How far an input may deviate from an exact domain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Tolerance {
    /// Whether equal points, facets that are not exactly planar, and edges or vertices that are not manifold are defects.
    /// Then nothing is welded or repaired.
    pub strict: bool,
    /// The distance within which points are joined, in the unit of the file.
    pub weld: Option<f64>,
    /// Whether T-junctions, double and degenerate elements, small holes and bent polygons of surfaces are repaired.
    pub repair: bool,
}

impl Tolerance {
    /// Returns the tolerance after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}

/// An input that is ready for the exact check.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared<P> {
    /// The input.
    pub input: Input<P>,
    /// The number in the file of each facet. New facets follow those of the file.
    pub origin: Vec<u32>,
    /// The solids of the facets, if each solid is a region.
    pub solids: Option<Solids>,
    /// The changes.
    pub changes: Vec<Change>,
}

impl<P> Prepared<P> {
    /// Replaces the numbers of facets in a defect by those in the file.
    pub(crate) fn in_file(&self, mut defect: Defect) -> Defect {
        let id = |f: &mut u32| *f = self.origin.get(*f as usize).copied().unwrap_or(*f);
        let name = |element: &mut Element| {
            if let Element::Facet(f) = element {
                id(f);
            }
        };
        match &mut defect {
            Defect::NoSuchPoint { element, .. }
            | Defect::Degenerate { element, .. }
            | Defect::Dangling { element, .. }
            | Defect::Misplaced { element, .. }
            | Defect::TooThin { element, .. } => name(element),
            Defect::NotPlanar { facet, .. }
            | Defect::FacetHole { facet, .. }
            | Defect::OpenEdge { facet, .. } => id(facet),
            Defect::Doubled { elements, .. } | Defect::Intersect { elements, .. } => {
                elements.iter_mut().for_each(name);
            }
            Defect::NonManifoldEdge { facets, .. } => facets.iter_mut().for_each(id),
            Defect::Empty
            | Defect::Range(_)
            | Defect::Duplicate { .. }
            | Defect::NonManifoldVertex { .. }
            | Defect::Unclosed
            | Defect::SharedComponent { .. } => {}
        }
        defect
    }
}

/// The steps that need the dimension.
pub trait Repair: Triangulate {
    /// Runs the steps on facets.
    #[doc(hidden)]
    fn facets(mending: &mut Mending<Self>, tolerance: &Tolerance, exponent: i32);
}

impl Repair for DVec2 {
    fn facets(_: &mut Mending<Self>, _: &Tolerance, _: i32) {}
}

impl Repair for DVec3 {
    fn facets(mending: &mut Mending<Self>, tolerance: &Tolerance, exponent: i32) {
        let scaled: Vec<DVec3> = mending.input.points.iter().map(|&p| scale(p, exponent)).collect();
        let limit = Digits::of(&mending.input.points).rounding();
        if tolerance.repair {
            double::double(mending);
            if mending.input.kind == DomainKind::Surface {
                junctions::junctions(mending, &scaled, limit.max(tolerance.weld.unwrap_or(0.0)));
                holes::holes(mending);
            }
        }
        solids::solids(mending);
        flat::flatten(mending, (&scaled, exponent), limit, tolerance.repair);
    }
}

/// Prepares an input for the exact check.
pub fn prepare<P: Repair>(input: &Input<P>, tolerance: &Tolerance) -> Prepared<P> {
    let mut mending = Mending::new(input);
    let all =
        [input.points.as_slice(), &input.holes, &input.regions.iter().map(|r| r.at).collect::<Vec<_>>()];
    let count = input.points.len();
    let named = input.facets.iter().flat_map(|f| f.polygons.iter().flatten().copied());
    let has_points = named.chain(input.segments.iter().flat_map(|s| s.ends)).all(|v| (v as usize) < count);
    // The check reports coordinates out of range.
    if let (Ok(exponent), true) = (scale_exponent(&all.concat()), has_points) {
        if let Some(distance) = tolerance.weld {
            weld::weld(&mut mending, distance);
        }
        if tolerance.repair {
            let scaled: Vec<P> = mending.input.points.iter().map(|&p| scale(p, exponent)).collect();
            degenerate::degenerate(&mut mending, &scaled);
        }
        P::facets(&mut mending, tolerance, exponent);
    }
    let Mending { input, origin, solids, is_by_regions, changes, .. } = mending;
    let solids = is_by_regions.then(|| Solids::new(input.solids.len() as u32, solids));
    Prepared { input, origin, solids, changes }
}
