//! An independent verifier of Delaunay triangulations, for septet's files and anybody's.
//!
//! It shares no code with what builds triangulations: it has its own arithmetic (dyadic big
//! integers behind its own `f64` filter, modules `exact` and
//! `predicates`), and it trusts nothing but the
//! coordinates and the list of cells.
//!
//! # Theorem
//!
//! Let `P` be a finite set of distinct points of `R^d`, `d` = 2 or 3, and `K` a list of `d`-simplices
//! with vertices in `P` such that
//!
//! 1. (`structure`) every point of `P` is a vertex of a cell;
//! 2. (`orientation`) no cell is flat;
//! 3. (`manifold`) a facet has one cell (a *boundary* facet) or two, which lie on opposite sides;
//! 4. (`hull`) a ridge of a boundary facet lies in exactly two boundary facets, and the far vertex of
//!    one is not strictly on the outer side of the other's hyperplane;
//! 5. (`empty spheres`) for each interior facet, the far vertex of one cell is not strictly inside the
//!    circumsphere of the other;
//! 6. (`single cover`) for one cell `t` and one interior point `x` of it: `x` is in no other closed
//!    cell, and strictly on the inner side of the hyperplane of every boundary facet.
//!
//! Then `K` is a Delaunay triangulation of `P`: a simplicial complex that covers the convex hull of
//! `P` once, whose circumspheres contain no point of `P` in their interior. Conversely every Delaunay
//! triangulation satisfies 1-6, with any `t`.
//!
//! **Source.** Local conditions alone do not suffice (a pentagram is locally convex everywhere); that
//! one global query completes them is due to Mehlhorn et al., *Checking geometric programs* (1996),
//! and Devillers, Liotta, Preparata and Tamassia (1998), for convex hulls. Applied to the lifted hull
//! it asks for local convexity at all ridges, finite|finite (5), infinite|infinite (4), and
//! finite|infinite. The last is no condition of its own: the vertical facet above a boundary facet
//! meets the lifted cell, which is not vertical, at an angle below 180 degrees by 2 alone. The proof
//! here is elementary, and uses the second clause of 6, which costs O(hull).
//!
//! **Proof.** *Cover.* From a point `y` inside a cell `s` walk straight towards `x`, from cell to cell
//! through facets. For all `y` but a set of measure zero the segment misses all ridges: by 6 no ridge
//! contains `x`, so that the cones from `x` over ridges have dimension `d - 1`. By 3 the walk goes on
//! across every interior facet, and back the same way. It leaves through no boundary facet, for then
//! `x` would be on its outer side. So it ends in a cell that contains `x`, and this is `t`. The walk
//! back from `(x, t)` towards `y` is determined by `y`; so no other cell contains `y`. Hence cells
//! have disjoint interiors, and their union `U` is star-shaped from `x`. A ray from `x` crosses one
//! boundary facet and nothing after it (a walk back would cross that facet outwards); so the boundary
//! facets, seen from `x`, tile the sphere of directions once.
//!
//! *Convexity.* At a generic point of a boundary ridge its two facets lie, seen from `x`, on either
//! side of the ridge (else they would overlap), and there `U` is the wedge below them, convex by 4.
//! For generic points `y`, `z` of the boundary the plane through `x`, `y`, `z` misses all vertices
//! (in the plane: take the plane itself) and cuts `U` in a star-shaped polygon with no angle above
//! 180 degrees, which is convex. So `U` contains the segment `yz`, and by closure is convex. By 1 it
//! is the convex hull of `P`.
//!
//! *Heights.* Let `h` on each cell be the affine interpolation of `|p|^2` at its vertices. It agrees
//! on the two sides of an interior facet, and by 5 is convex across it; all facets in the interior
//! of `U` are interior facets. So `h` is convex along all segments but a set of measure zero, hence
//! extends to a convex function on `U`, equal to `|p|^2` at every vertex. The affine function of a
//! cell is at most `h`, so at most `|p|^2` at every point of `P`: its circumsphere is empty.
//!
//! *Face to face.* A point of `P` in a closed cell that is not its vertex would have `h` above
//! `|p|^2`, by strict convexity. Two edges that cross at a point inside both would each have cells
//! around them (a closed fan, or one between two boundary facets) that fill `U` near that point; no
//! simplex has two crossing edges; so `U` would be covered twice. An edge that crosses the inside of
//! a facet runs through one of its cells, which with its own cells covers a piece twice. QED.
//!
//! **Coplanar boundary facets** need no in-circle test in their plane: `h` is convex on `U`, so on
//! the face of `U` in that plane, where it is the planar interpolation: planar Delaunay is implied.
//!
//! **With the perturbation** ([`VerifyOptions::perturbed`]) the same proof holds for heights
//! `|p|^2 + e_p`, with *strict* convexity across each interior facet, since a tie is impossible: then
//! `h` determines `K`, including the ties in coplanar boundary facets, so `K` is the one
//! triangulation that the lexicographic perturbation selects.
//!
//! The remaining checks (links of vertices, folded facets) follow from 1-6; they are there to name
//! the place of a fault.
//!
//! **Work.** O(n log n + m log m) for m cells, mostly O(1) filtered predicates per facet.

mod cover;
mod exact;
mod facets;
mod hull;
mod predicates;
mod report;
mod runner;
mod soup;
mod spheres;
#[cfg(test)]
mod tests;
mod triangulation;

pub use report::{Fault, KEPT, LevelReport, Report};
pub use triangulation::Triangulation;

use facets::Facets;
use report::Tally;
use runner::Runner;
use soup::Soup;

/// The levels, in order.
pub const LEVELS: [&str; 6] =
    ["structure", "orientation", "manifold", "hull", "empty spheres", "single cover"];

/// What to require.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifyOptions {
    /// Ties must be broken by the lexicographic perturbation, and the smallest index stand for
    /// coincident points: the cells are those of septet's canonical triangulation.
    pub perturbed: bool,
    /// The order of the vertices in a row does not matter; else every cell must be positive.
    pub any_order: bool,
    /// Number of threads; 0 for rayon's choice. The report does not depend on it.
    pub threads: usize,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self { perturbed: false, any_order: true, threads: 0 }
    }
}

/// Is the mesh a Delaunay triangulation of its points? Decided exactly, for any finite coordinates.
///
/// All levels run, unless `structure` fails: without it the others have no meaning, and say that they
/// were stopped. `progress` is told the stage, and how many of how many items are done.
pub fn verify(
    mesh: &Triangulation<'_>,
    options: &VerifyOptions,
    progress: &mut dyn FnMut(&str, u64, u64),
) -> Report {
    let mut report = Report {
        levels: Vec::with_capacity(LEVELS.len()),
        dimension: mesh.dimension,
        perturbed: options.perturbed,
        points: 0,
        cells: 0,
        hull_facets: 0,
        interior_facets: 0,
        ties: 0,
        vertices_used: 0,
        duplicates: 0,
        dimension_of_points: -1,
    };
    if let Some(reason) = misshapen(mesh) {
        let mut tally = Tally::default();
        tally.fault(Fault::Shape { reason });
        report.levels.push(tally.level(LEVELS[0]));
        stop(&mut report);
        return report;
    }
    report.points = mesh.point_count() as u64;
    report.cells = mesh.cell_count() as u64;
    let mut runner = Runner::new(options.threads, progress);
    if mesh.dimension == 2 {
        levels::<2, 3>(mesh, *options, &mut runner, &mut report);
    } else {
        levels::<3, 4>(mesh, *options, &mut runner, &mut report);
    }
    report
}

/// Why the arrays are no mesh, if they are none.
fn misshapen(mesh: &Triangulation<'_>) -> Option<&'static str> {
    let d = mesh.dimension;
    // Facets are numbered in 32 bits, two of their numbers are reserved.
    let most = (u32::MAX - 2) as usize;
    if d != 2 && d != 3 {
        Some("the dimension is neither 2 nor 3")
    } else if !mesh.coordinates.len().is_multiple_of(d) {
        Some("the number of coordinates is not a multiple of the dimension")
    } else if !mesh.cells.len().is_multiple_of(d + 1) {
        Some("the number of indices is not a multiple of the cells' size")
    } else if mesh.cells.len() > most || mesh.coordinates.len() / d > most {
        Some("more than 4,294,967,293 points or indices: too large for this verifier")
    } else {
        None
    }
}

/// The levels that were not reached.
fn stop(report: &mut Report) {
    for &name in &LEVELS[report.levels.len()..] {
        let mut level = Tally::default().level(name);
        level.passed = false;
        level.stopped_by = Some(LEVELS[0]);
        report.levels.push(level);
    }
}

/// All levels of a well-shaped mesh.
fn levels<const D: usize, const N: usize>(
    mesh: &Triangulation<'_>,
    options: VerifyOptions,
    runner: &mut Runner<'_>,
    report: &mut Report,
) {
    let (mut soup, mut tally) = Soup::<D, N>::load(mesh, runner);
    if tally.count == 0 {
        tally.append(soup.structure(options.perturbed, runner));
        report.vertices_used = soup.used.iter().filter(|&&used| used).count() as u64;
        report.duplicates = soup.duplicates;
        report.dimension_of_points = soup.dimension;
    }
    report.levels.push(tally.level(LEVELS[0]));
    if !report.passed() {
        return stop(report);
    }
    report.levels.push(soup.orient(options.any_order, runner).level(LEVELS[1]));
    let (facets, tally) = Facets::new(&soup, runner);
    report.levels.push(tally.level(LEVELS[2]));
    let boundary = facets.boundary();
    report.hull_facets = boundary.len() as u64;
    report.interior_facets = facets.interior();
    report.levels.push(hull::check(&soup, &boundary, runner).level(LEVELS[3]));
    let tally = spheres::check(&soup, &facets, options.perturbed, runner);
    report.ties = tally.ties;
    report.levels.push(tally.level(LEVELS[4]));
    report.levels.push(cover::check(&soup, &boundary, runner).level(LEVELS[5]));
}
