//! The check that a mesh conforms to its domain.
//!
//! **Statement.** [`check`] reports no defect only if
//! 1. every cell is positive (exact sign), and each facet of cells is in at most two cells, which lie on opposite
//!    sides;
//! 2. a facet that is in only one cell, or between two components, is a listed face, and a listed face is in exactly
//!    the cells that it lists;
//! 3. on each segment, the listed edges form a chain from corner to corner;
//! 4. the faces on each facet all have the same orientation in a projection along an axis (exact signs). Each
//!    subsegment of the facet's boundary occurs once in them, and every other edge once in each direction. For each
//!    pair of components (or the outside), their total area equals the area of the domain's walls between the pair,
//!    to 1e-9 of the facet;
//! 5. the measures of the cells of each component add up to the measure of the component, to 1e-9 of that measure;
//! 6. corners have the same positions as in the domain, and points lie on their carriers to 1e-12 of the largest
//!    coordinate and the step of the grid of translated coordinates ([`crate::frame`]). Cells use every point, rows are in canonical order, and markers agree with the domain.
//!
//! *Then, up to the tolerances, the cells tile the domain and the faces tile its facets, each once.*
//!
//! *Proof.*
//! - *Facets.* By 4, the faces of a facet form a chain whose boundary is the boundary of the facet. They therefore
//!   cover the facet with a constant degree. Because the areas are equal, the degree is one.
//! - *Cells.* By 1 and 2, the cells of a component form a chain whose boundary lies in faces on the walls. The degree
//!   with which they cover space is therefore constant between walls. It is nowhere negative, because all cells are
//!   positive. By 4, the boundary of the chain is the boundary of the component. The degree is therefore one inside
//!   and zero elsewhere. Part 5 confirms this with independent numbers. QED.
//!
//! The check shares no code with generation. It reads the features, walls and components of the domain, and it uses the
//! predicates of the geometry crate.
//!
//! **Work and depth.** `O(m log m)`. The orientations of cells, and the sorts of their facets, are parallel.

mod adjacency;
mod checker;
mod defect;
mod findings;
mod follow;
mod shape;
mod tiles;

use septet_geometry::point::Point;
use septet_geometry::range::scale_exponent;

use crate::domain::Domain;
use crate::executor::{Executor, Sequential};
use crate::mesh::Mesh;
use crate::space::Space;

pub use checker::{OFF, SUMS};
pub use defect::{MeshDefect, SideComponent};
pub use findings::{Conformity, Deviation};
pub use follow::{Follow, LOOSE};

use checker::Checker;

/// Compares a mesh with its domain.
pub fn check<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Conformity {
    check_on(domain, mesh, None, &Sequential)
}

/// Compares a mesh that has a remeshed boundary with its closed surface in space. Reports no defect only if
/// 1. parts 1 and 2 of [`check`] hold;
/// 2. every face is in one cell, and its corners lie on the surface;
/// 3. the boundary is a closed 2-manifold: every edge of a face is in exactly two faces, and the faces at every
///    vertex form one fan;
/// 4. every vertex at which one ridge ends, or more than two ridges meet, is a point of the mesh. The listed edges
///    are edges of faces, and they connect consecutive points along all ridges;
/// 5. the distance between boundary and surface is within the limit, in both directions, at the points that
///    [`Deviation`] samples;
/// 6. every component has cells, points lie on their carriers to 1e-12 of the largest coordinate, cells use every
///    point, and rows are in canonical order.
///
/// *Then the boundary does not cross itself.* The cells of a component share each facet that is not on the boundary
/// with a cell on the opposite side. They therefore cover space with a degree that changes only at the boundary, by
/// one, and is nowhere negative. The measures of domain and mesh are reported but not compared.
pub fn check_remeshed<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, follow: &Follow) -> Conformity {
    check_on(domain, mesh, Some(follow), &Sequential)
}

/// Runs [`check_remeshed`] if there are requirements for a remeshed boundary, and otherwise [`check`]. The executor maps
/// over the cells and their facets, so the result does not depend on it.
pub fn check_on<P: Space>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    follow: Option<&Follow>,
    executor: &impl Executor,
) -> Conformity {
    let mut checker = Checker { domain, mesh, points: Vec::new(), found: Conformity::default() };
    checker.found.defects = shape::shape(domain, mesh);
    if !checker.found.is_clean() {
        return checker.found;
    }
    checker.points = mesh.points.iter().map(|&p| domain.simplices.frame.inward(p)).collect();
    if let Some(range) = inexact(domain, mesh).or_else(|| out_of_range(&checker.points)) {
        checker.found.defects.push(MeshDefect::Range(range));
        return checker.found;
    }
    checker.cells(executor);
    checker.faces(executor);
    checker.used();
    checker.carriers(follow.is_none());
    if let Some(follow) = follow {
        checker.boundaries();
        checker.follows(follow);
    } else {
        checker.segments();
        checker.facets();
    }
    checker.volumes(follow.is_none());
    checker.found
}

/// Returns the first point for which the translation of the domain is not exact, so that signs would not be those of
/// the numbers that are written.
fn inexact<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Option<String> {
    let frame = &domain.simplices.frame;
    let first = frame.is_translated().then(|| mesh.points.iter().position(|&p| !frame.is_exact(p)))??;
    Some(format!("point {first} is not exact relative to the centre of the domain"))
}

fn out_of_range<P: Point>(points: &[P]) -> Option<String> {
    match scale_exponent(points) {
        Ok(0) => None,
        Ok(e) => Some(format!("outside the exact range by a factor of 2^{e}, in the scale of the domain")),
        Err(error) => Some(error.to_string()),
    }
}
