//! Is a mesh a mesh of its domain?
//!
//! **Statement.** [`check`] finds nothing only if
//! 1. every cell is positive (exact sign), each facet of cells is in at most two, in two on opposite sides;
//! 2. a facet of cells in one cell only, or between two components, is a listed face, and a listed face is in
//!    exactly the cells that it names;
//! 3. on each segment the listed edges are a chain from corner to corner;
//! 4. on each facet the faces, all turned one way in a projection along an axis (exact signs), have each edge once in
//!    each direction, but for the pieces of its boundary segments, which they have once; and for each pair of components (or the
//!    outside) their areas add up to those of the domain's walls between these, to 1e-9 of the facet;
//! 5. the cells of each component add up to its measure, to 1e-9 of it;
//! 6. corners are where the domain has them, points are on their carriers to 1e-12 of the largest coordinate, cells use every
//!    point, rows are in canonical order, markers are the domain's.
//!
//! *Then, up to the tolerances, the cells tile the domain and the faces its facets, each once.* By 4 the faces of a facet are
//! a chain whose boundary is the facet's, so they cover it with a constant degree, and by its area with degree one. By 1 and 2
//! the cells of a component are a chain whose boundary lies in faces on the walls; they cover with
//! degrees that are constant between walls and, all being positive, nowhere negative; by 4 the boundary is that of the
//! component, so the degree is one in it and zero elsewhere; 5 says so once more, by other numbers.
//!
//! It shares no code with generation: of the domain it reads features, walls and components, of geometry the
//! predicates.
//!
//! **Work and depth.** `O(m log m)`, sequential.

mod adjacency;
mod checker;
mod defect;
mod findings;
mod follow;
mod shape;
mod tiles;

use septet_geometry::point::Point;
use septet_geometry::range::{scale, scale_exponent};

use crate::domain::Domain;
use crate::mesh::Mesh;
use crate::space::Space;

pub use checker::{OFF, SUMS};
pub use defect::{MeshDefect, SideComponent};
pub use findings::{Conformity, Deviation};
pub use follow::{Follow, LOOSE};

use checker::Checker;

/// Compares a mesh with its domain.
pub fn check<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Conformity {
    compare(domain, mesh, None)
}

/// Compares a mesh whose boundary follows a closed surface of space without being it. Finds nothing only if
/// 1. and 2. hold as in [`check`];
/// 3. every face is in one cell and its corners lie on the surface; every edge of faces is in two of them, the faces at
///    every vertex are one fan: the boundary is a closed 2-manifold;
/// 4. where other than two ridges meet there is a point of the mesh, and the listed edges join each point on a ridge to the
///    next, all along the ridges, and are edges of faces;
/// 5. boundary and surface are no farther from each other than is asked, both ways, in the places that [`Deviation`] looks at;
/// 6. every component has cells, points are on their carriers to 1e-12 of the largest coordinate, cells use every point, rows
///    are in canonical order.
///
/// *Then the boundary does not cross itself:* cells of a component that have all their facets in common, on opposite sides, but for
/// those on the boundary, cover space with a degree that changes at the boundary alone, by one, and is nowhere negative.
/// Measures and boundaries are added up, and nothing else is asked of them.
pub fn check_remeshed<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, follow: &Follow) -> Conformity {
    compare(domain, mesh, Some(follow))
}

fn compare<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, follow: Option<&Follow>) -> Conformity {
    let mut checker = Checker { domain, mesh, points: Vec::new(), found: Conformity::default() };
    checker.found.defects = shape::shape(domain, mesh);
    if !checker.found.is_clean() {
        return checker.found;
    }
    checker.points = mesh.points.iter().map(|&p| scale(p, domain.simplices.exponent)).collect();
    if let Some(range) = out_of_range(&checker.points) {
        checker.found.defects.push(MeshDefect::Range(range));
        return checker.found;
    }
    checker.cells();
    checker.faces();
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

fn out_of_range<P: Point>(points: &[P]) -> Option<String> {
    match scale_exponent(points) {
        Ok(0) => None,
        Ok(e) => Some(format!("in the domain's scale they lie outside the exact range (by 2^{e})")),
        Err(error) => Some(error.to_string()),
    }
}
