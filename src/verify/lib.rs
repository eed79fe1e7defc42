//! An independent verifier of Delaunay triangulations, for the files of septet and of any other program.
//!
//! The verifier shares no code with the construction of triangulations. It has its own arithmetic: dyadic big integers
//! behind its own `f64` filter (modules `exact` and `predicates`). Its only inputs are the coordinates and the list of
//! cells.
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
//! Then `K` is a Delaunay triangulation of `P`. That is, `K` is a simplicial complex, it covers the convex hull of `P`
//! once, and no circumsphere of a cell contains a point of `P` in its interior. Conversely, every Delaunay triangulation
//! satisfies 1-6, with any `t`.
//!
//! **Source.** Local conditions alone do not suffice: a pentagram is locally convex everywhere. One additional global
//! query suffices. For convex hulls, this result is due to Mehlhorn et al., *Checking geometric programs* (1996), and
//! to Devillers, Liotta, Preparata and Tamassia (1998). Applied to the lifted hull, their condition is local convexity
//! at all ridges. A ridge lies between two finite facets (finite|finite, condition 5), between two infinite facets
//! (infinite|infinite, condition 4), or between one of each (finite|infinite). Convexity at finite|infinite ridges
//! follows from 2: the infinite facet above a boundary facet is vertical, the lifted cell is not, and the two meet at
//! an angle below 180 degrees. The proof here is elementary. It uses the second clause of 6, whose check takes time
//! linear in the size of the hull.
//!
//! **Proof.** *Cover.* From a point `y` inside a cell `s`, walk straight towards `x`, from cell to cell through
//! facets. By 6, no ridge contains `x`, so the cones from `x` over ridges have dimension `d - 1`. For all `y` except
//! a set of measure zero, the segment therefore misses all ridges. By 3, the walk continues across every interior
//! facet, and it can be reversed. It does not leave through a boundary facet, because `x` would then be on the outer
//! side of that facet. So it ends in a cell that contains `x`, and this cell is `t`. The walk back from `(x, t)`
//! towards `y` is determined by `y`. So no other cell contains `y`. Hence the cells have disjoint interiors, and
//! their union `U` is star-shaped from `x`. A ray from `x` crosses one boundary facet and meets no cell after it,
//! because a walk back would cross that facet outwards. So the boundary facets, seen from `x`, tile the sphere of
//! directions once.
//!
//! *Convexity.* Take a generic point of a boundary ridge. Its two facets lie on either side of the ridge, seen from
//! `x`, because they would overlap otherwise. There, `U` is the wedge on the inner side of the two facets, which is
//! convex by 4. Let `y` and `z` be generic points of the boundary. In space, the plane through `x`, `y` and `z` misses
//! all vertices. For `d` = 2, take the plane itself. This plane cuts `U` in a star-shaped polygon without an angle
//! above 180 degrees. Such a polygon is convex. So `U` contains the segment `yz`, and by closure `U` is convex. By 1,
//! it is the convex hull of `P`.
//!
//! *Heights.* On each cell, let `h` be the affine interpolation of `|p|^2` at its vertices. It agrees on the two sides of
//! an interior facet, and by 5 it is convex across the facet. All facets in the interior of `U` are interior facets. So `h`
//! is convex along all segments except a set of measure zero. Hence it extends to a convex function on `U`, equal to
//! `|p|^2` at every vertex. The affine function of a cell is at most `h`, so it is at most `|p|^2` at every point of `P`.
//! The circumsphere of the cell is therefore empty.
//!
//! *Face to face.* Suppose that a closed cell contains a point of `P` that is not its vertex. By strict convexity, `h`
//! would be above `|p|^2` there. Suppose that two edges cross at a point inside both. The cells around each edge form a
//! closed fan, or a fan between two boundary facets, and fill `U` near that point. No simplex has two crossing edges, so
//! `U` would be covered twice. Suppose that an edge crosses the inside of a facet. It runs through a cell of that facet,
//! and that cell and the cells of the edge cover a part of `U` twice. QED.
//!
//! **Coplanar boundary facets** need no in-circle test in their plane. `h` is convex on `U`, so it is convex on the face of
//! `U` in that plane. There, `h` is the planar interpolation, and the facets are a planar Delaunay triangulation.
//!
//! **With the perturbation** ([`VerifyOptions::perturbed`]), the same proof holds for the heights `|p|^2 + e_p`. Ties are
//! impossible, so convexity across each interior facet is *strict*. Then `h` determines `K`, including the ties in coplanar
//! boundary facets. So `K` is the one triangulation that the lexicographic perturbation selects.
//!
//! Conditions 1-6 imply the properties that the other checks test (links of vertices, folded facets). These checks
//! help to locate a fault.
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

/// The requirements of a verification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifyOptions {
    /// Whether the cells must be the cells of septet's canonical triangulation. The lexicographic perturbation then
    /// breaks ties, and the smallest index represents coincident points.
    pub perturbed: bool,
    /// Whether the vertices of a cell may be in any order. Otherwise, every cell must be positively oriented.
    pub any_order: bool,
    /// The number of threads, or 0 for the default of rayon. The report does not depend on it.
    pub threads: usize,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self { perturbed: false, any_order: true, threads: 0 }
    }
}

/// Decides whether the mesh is a Delaunay triangulation of its points, exactly and for any finite coordinates.
///
/// If the level `structure` fails, the other levels have no meaning. They do not run, and their
/// [`LevelReport::stopped_by`] names that level. Otherwise all levels run. `progress` receives the stage, the number of
/// items done, and their total.
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

/// Returns the reason why the arrays are not a mesh, or `None` if they are.
fn misshapen(mesh: &Triangulation<'_>) -> Option<&'static str> {
    let d = mesh.dimension;
    // Facets have 32-bit numbers, and two of them are reserved.
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

/// Adds the levels that did not run.
fn stop(report: &mut Report) {
    for &name in &LEVELS[report.levels.len()..] {
        let mut level = Tally::default().level(name);
        level.passed = false;
        level.stopped_by = Some(LEVELS[0]);
        report.levels.push(level);
    }
}

/// Runs all levels on arrays of consistent lengths.
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
