//! An independent verifier of Delaunay and regular triangulations, for the files of septet and of any other program.
//!
//! The verifier shares no code with the construction of triangulations. It has its own arithmetic: dyadic big integers
//! behind its own `f64` filter (modules `exact` and `predicates`). Its only inputs are the coordinates, the weights, the
//! list of cells, and the offsets of their vertices in a periodic box.
//!
//! # Theorem
//!
//! A *site* is a position `p` in `R^d`, `d >= 2`, and a weight `w`. Plain points are sites of weight 0. The *lift*
//! of a site is the point `(p, |p|^2 - w)` of `R^(d+1)`. The *lift of a cell* is the hyperplane through the lifts of its
//! vertices. A site is *hidden* if its lift is strictly above the lower hull of all lifts. No plain point is.
//!
//! Let `P` be a finite set of distinct sites, and `K` a list of `d`-simplices with vertices in `P` such that
//!
//! 1. (`structure`) distinct vertices have distinct positions, and every site is a vertex of a cell, or it has a weight and
//!    satisfies 7;
//! 2. (`orientation`) no cell is flat;
//! 3. (`manifold`) a facet has one cell (a *boundary* facet) or two, which lie on opposite sides;
//! 4. (`hull`) a ridge of a boundary facet lies in exactly two boundary facets, and the far vertex of
//!    one is not strictly on the outer side of the other's hyperplane;
//! 5. (`empty spheres`) for each interior facet, the lift of the far vertex of one cell is not strictly below the lift of
//!    the other cell. Without weights, the far vertex is not strictly inside the circumsphere of the other cell;
//! 6. (`single cover`) for one cell `t` and one interior point `x` of it: `x` is in no other closed
//!    cell, and strictly on the inner side of the hyperplane of every boundary facet;
//! 7. (`hidden sites`) if a site is not a vertex, a closed cell contains its position, and its lift is strictly above the
//!    lift of this cell.
//!
//! Then `K` is a regular triangulation of `P`, and its vertices are all sites that are not hidden. That is, `K` is a
//! simplicial complex, it covers the convex hull of all positions once, and no site has a lift strictly below that of a
//! cell. Without weights, `K` is a Delaunay triangulation: no circumsphere of a cell contains a point of `P` in its
//! interior. Conversely, every such triangulation satisfies 1-7, with any `t`.
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
//! convex by 4. Let `y` and `z` be generic points of `U`. A plane through `x`, `y` and `z` misses all faces of dimension `d - 3`.
//! For `d` = 2, take the plane itself. The triangle `xyz` cuts `U` in a polygon that is star-shaped from `x` and contains the
//! edges `xy` and `xz`. If the polygon is not the triangle, a chain of its boundary leaves the edge `yz`, lies inside the
//! triangle, and returns to `yz`. At the last of the points of the chain that are farthest from `yz`, the angle of `U` exceeds
//! 180 degrees, which contradicts the wedges. So `U` contains the segment `yz`, and by closure `U` is convex. By 1 and 7, `U`
//! contains all positions. So it is their convex hull.
//!
//! *Heights.* On each cell, let `h` be the affine interpolation of `|p|^2 - w` at its vertices. It agrees on the two sides
//! of an interior facet, and by 5 it is convex across the facet. All facets in the interior of `U` are interior facets.
//! So `h` is convex along all segments except a set of measure zero. Hence it extends to a convex function on `U`, equal
//! to `|p|^2 - w` at every vertex. The affine function of a cell is at most `h`, so no lift of a vertex is below it. By 7,
//! the lift of any other site is strictly above `h`. So no lift is below that of a cell, the graph of `h` is the lower hull
//! of all lifts, and the vertices are the sites that are not hidden. In particular, a vertex that should be hidden
//! contradicts 5. Without weights, a lift on or above that of a cell is on or outside the circumsphere of the cell.
//!
//! *Face to face.* Let `f` be a face of a cell `s`, and `p` a point in the relative interior of `f`. A facet of a cell
//! around `f` contains `f`, or it misses a ball `B` around `p`. Walk straight from a generic point of `s` in `B` to any
//! generic point of `U` in `B`. The walk stays in the interior of `U`, which is convex. So it crosses only interior
//! facets that contain `f`, and it ends in a cell around `f`. So these cells fill `U` near `p`. Now let `p` also be in a
//! cell `t`. Interior points of `t` are arbitrarily close to `p`, and the cells have disjoint interiors. So `t` is one of the
//! cells around `f`. A face of `t` is thus the face of `s` that has `p` in its relative interior. So `s` and `t` meet in
//! common faces, and in one face, because they meet in a convex set. QED.
//!
//! **Conversely**, let `K` be such a triangulation. In a convex region covered once, 2-4 and 6 hold. No lift is
//! below that of a cell, which implies 5. A site that is not a vertex is hidden, and the lift of the cell around it is the
//! lower hull there, which implies 7.
//!
//! **Coincident sites.** Of several sites at one position, a heaviest one is a vertex, or none is. Lighter ones are hidden
//! if a heavier one is a vertex, or hidden by 7. So one heaviest site for each position without a vertex is checked by 7. Sites
//! of equal weight are *duplicates* and count as one site.
//!
//! **Coplanar boundary facets** need no in-circle test in their plane. `h` is convex on `U`, so it is convex on the face of
//! `U` in that plane. There, `h` is the planar interpolation, and the facets are a planar regular triangulation.
//!
//! **With the perturbation** ([`VerifyOptions::perturbed`]), the same proof holds for the heights `|p|^2 - w + e_p`. Ties are
//! impossible, so convexity across each interior facet is *strict*. Then `h` determines `K`, including the ties in coplanar
//! boundary facets. So `K` is the one triangulation that the lexicographic perturbation selects. Condition 7 needs no
//! perturbation: the same sites are hidden with it and without it. A lift strictly above the lower hull remains so. Let the
//! lift of a site at `q` be on the hull. If it is a convex combination of lifts of others, one of their positions is
//! lexicographically larger than `q`, because `q` is a convex combination of them. Its infinitesimal exceeds that of `q` by
//! orders of magnitude, so the perturbed lift of `q` is strictly below theirs.
//!
//! # Periodic boxes
//!
//! A box has a length `L_a > 0` along each *periodic* axis `a`. All axes may be periodic, or some. A row of the input at `x`
//! stands for its images `x + k L`, for all vectors `k` of whole numbers that are 0 on the other axes. A vertex of `K` is a row
//! and such a `k`, its *offset*. `K` stands for the list `K*` of all translations of its cells by vectors `k L`. Two vertices,
//! facets or cells are in one *class* if they are translations of each other. Let `P*` be the set of all images of sites.
//! Conditions 1-5 and 7 are those above, for `P*` and `K*`. By periodicity, it suffices to check one member of each class:
//!
//! 1. distinct rows of vertices have no equal images, a cell has distinct vertices, and no two cells are in one class; each row
//!    is a vertex, coincides with one modulo the lattice, or satisfies 7;
//! 3. a class of facets has one cell or two, which lie on opposite sides. If all axes are periodic, it has two;
//! 4. a class of ridges of boundary facets has two of these facets, or none;
//! 5. the far vertex of a neighbour is that of the translation of the neighbour that has the facet of the cell;
//! 6. (`single cover`) no edge of a cell is longer than `L_a` along a periodic axis `a`. For one cell `t` of `K` and one interior
//!    point `x` of it: `x` is in no other closed cell of `K*`, and strictly on the inner side of the hyperplane of every
//!    boundary facet of `K`. These hyperplanes are parallel to all periodic axes;
//! 7. the image in the box of a hidden site is in a closed cell of `K*`, and strictly above its lift.
//!
//! Then `K*` is the regular (Delaunay) triangulation of `P*` with the ties of `K`, its vertices are the images that are not
//! hidden, and `K` has exactly one member of each class of its cells. Conversely, every such `K` satisfies 1-7, with any `t`.
//! It need not be a simplicial complex modulo the lattice: a cell may have several images of one site.
//!
//! **Proof.** A nonzero translation moves every facet, ridge and cell to another one, because their vertices are finitely many.
//! So a facet of `K*` has as many cells as its class has in `K`, and likewise for ridges. The hyperplane of a boundary facet and
//! those of its translations are equal up to translations along periodic axes, to which they are parallel. So `x` is on the
//! inner side of all of them. So 1-7 hold for `P*` and `K*`. `K*` has finitely many classes, and a bounded region meets finitely
//! many of its cells. The proof above uses no more than that: a walk along a segment crosses finitely many cells, and countably
//! many exceptional sets of measure zero have measure zero. Without boundary facets, a ray from `x` meets no boundary, and `U`
//! is the whole space. Translating a cell adds an affine function to `|p|^2 - w`, so 5 does not depend on the member.
//!
//! *Single cover.* For a box periodic along all axes, conditions 1-5 make `K` a closed manifold that covers the torus some
//! number of times. The second clause of 6 says that this number is one. It is equivalent to a sum of volumes of one box, but it
//! needs exact arithmetic for few cells only, and it is the same condition for all boxes. Its first clause bounds the number of
//! translations of a cell that come near `x`.
//!
//! *Conversely,* let `p` and `q` be joined in the triangulation, and let `f(y) = |y - c|^2 - w_y - r` be the power of sites with respect to the
//! ball of a cell of both. Then `f(p) = f(q) = 0`, and `f >= 0` for all images. For a vector `v` of the lattice,
//! `f(q - v) + f(p + v) = 2 |v|^2 - 2 v . (q - p)`, so `v . (q - p) <= |v|^2`. With `v = +- L_a e_a`, no edge is longer than `L_a`
//! along `a`. The convex hull of `P*` is the product of the periodic axes and the hull of the projection to the others. So the
//! hyperplanes of its facets are parallel to the periodic axes. QED.
//!
//! **Source.** Dolbilin and Huson, "Periodic Delone tilings" (1997), for the definition and the bound of edges.
//!
//! **Departure.** Links of vertices are not checked in a periodic box: the other conditions imply their form.
//!
//! # Implementation
//!
//! Conditions 1-7 imply the properties that the other checks test (links of vertices, folded facets). These checks
//! help to locate a fault.
//!
//! **Work.** O(n log n + m log m) for m cells, mostly O(1) filtered predicates per facet; a short walk for each hidden site.

mod cover;
mod dyadic;
mod exact;
mod facets;
mod fault;
mod hidden;
mod hull;
mod minors;
mod place;
mod predicates;
mod rank;
mod report;
mod ring;
mod runner;
mod soup;
mod spheres;
#[cfg(test)]
mod tests;
mod translations;
mod triangulation;

pub use fault::Fault;
pub use report::{KEPT, LevelReport, Report};
pub use triangulation::{PeriodicBox, Sites, Triangulation};

use facets::Facets;
use place::{Image, Place};
use report::Tally;
use runner::Runner;
use soup::Soup;

/// The levels, in order.
pub const LEVELS: [&str; 6] =
    ["structure", "orientation", "manifold", "hull", "empty spheres", "single cover"];

/// The largest dimension that the verifier takes.
const MOST_DIMENSION: usize = 6;

/// The level that follows [`LEVELS`] with weights.
pub const HIDDEN_SITES: &str = "hidden sites";

/// The requirements of a verification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifyOptions {
    /// Whether the cells must be the cells of septet's canonical triangulation. The lexicographic perturbation then
    /// breaks ties, and the smallest index represents coincident points of equal weight.
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
/// [`Triangulation::weighted`] adds weights. The mesh must then be a regular triangulation whose vertices are all points
/// that are not hidden. With [`Sites::periodic`], the mesh must be the triangulation of all images of the points, of which it
/// has one cell of each class of translated cells.
///
/// If the level `structure` fails, the other levels have no meaning. They do not run, and their
/// [`LevelReport::stopped_by`] names that level. Otherwise all of [`LEVELS`] run, and [`HIDDEN_SITES`] runs if they pass.
/// `progress` receives the stage, the number of items done, and their total.
pub fn verify<'a>(
    sites: impl Into<Sites<'a>>,
    options: &VerifyOptions,
    progress: &mut dyn FnMut(&str, u64, u64),
) -> Report {
    let sites = sites.into();
    let mesh = &sites.mesh;
    let mut report = Report {
        levels: Vec::with_capacity(LEVELS.len() + 1),
        dimension: mesh.dimension,
        perturbed: options.perturbed,
        points: 0,
        cells: 0,
        hull_facets: 0,
        interior_facets: 0,
        ties: 0,
        vertices_used: 0,
        duplicates: 0,
        hidden: sites.weights.map(|_| 0),
        dimension_of_points: -1,
    };
    if let Some(reason) = misshapen(&sites) {
        let mut tally = Tally::default();
        tally.fault(Fault::Shape { reason });
        report.levels.push(tally.level(LEVELS[0]));
        stop(&mut report, LEVELS[0]);
        return report;
    }
    report.points = mesh.point_count() as u64;
    report.cells = mesh.cell_count() as u64;
    let mut runner = Runner::new(options.threads, progress);
    let check = match (mesh.dimension, sites.periodic) {
        (2, None) => levels::<[f64; 2], 2, 3>,
        (2, Some(_)) => levels::<Image<2>, 2, 3>,
        (3, Some(_)) => levels::<Image<3>, 3, 4>,
        (4, _) => levels::<[f64; 4], 4, 5>,
        (5, _) => levels::<[f64; 5], 5, 6>,
        (6, _) => levels::<[f64; 6], 6, 7>,
        _ => levels::<[f64; 3], 3, 4>,
    };
    check(&sites, *options, &mut runner, &mut report);
    report
}

/// Returns the reason why the arrays are not a mesh, or `None` if they are.
fn misshapen(sites: &Sites<'_>) -> Option<&'static str> {
    let mesh = &sites.mesh;
    let d = mesh.dimension;
    // Facets have 32-bit numbers, and two of them are reserved.
    let most = (u32::MAX - 2) as usize;
    if !(2..=MOST_DIMENSION).contains(&d) {
        Some("the dimension is not one of 2 to 6")
    } else if d > 3 && (sites.weights.is_some() || sites.periodic.is_some()) {
        Some("weights and periodic boxes have two or three dimensions")
    } else if !mesh.coordinates.len().is_multiple_of(d) {
        Some("the number of coordinates is not a multiple of the dimension")
    } else if !mesh.cells.len().is_multiple_of(d + 1) {
        Some("the number of indices is not a multiple of the cells' size")
    } else if sites.weights.is_some_and(|weights| weights.len() != mesh.point_count()) {
        Some("the number of weights is not the number of points")
    } else if mesh.cells.len() > most || mesh.coordinates.len() / d > most {
        Some("more than 4,294,967,293 points or indices: too large for this verifier")
    } else {
        sites.periodic.as_ref().and_then(|periodic| misshapen_box(periodic, mesh))
    }
}

/// Returns the reason why the arrays are not a periodic box with offsets, or `None` if they are.
fn misshapen_box(periodic: &PeriodicBox<'_>, mesh: &Triangulation<'_>) -> Option<&'static str> {
    let lengths = || periodic.lengths.iter().flatten();
    if periodic.lengths.len() != mesh.dimension {
        Some("the number of lengths of the box is not the dimension")
    } else if lengths().next().is_none() {
        Some("no axis of the box is periodic")
    } else if !lengths().all(|length| length.is_finite() && *length > 0.0) {
        Some("a length of the box is not a positive number")
    } else if periodic.offsets.len() != mesh.cells.len() * mesh.dimension {
        Some("the number of offsets is not the number of indices times the dimension")
    } else {
        None
    }
}

/// Adds the levels that did not run because the level `earlier` failed.
fn stop(report: &mut Report, earlier: &'static str) {
    let names = LEVELS.into_iter().chain(report.hidden.map(|_| HIDDEN_SITES));
    for name in names.skip(report.levels.len()) {
        let mut level = Tally::default().level(name);
        level.passed = false;
        level.stopped_by = Some(earlier);
        report.levels.push(level);
    }
}

/// Runs all levels on arrays of consistent lengths.
fn levels<P: Place<D>, const D: usize, const N: usize>(
    sites: &Sites<'_>,
    options: VerifyOptions,
    runner: &mut Runner<'_>,
    report: &mut Report,
) {
    let (mut soup, mut tally) = Soup::<P, D, N>::load(sites, runner);
    if tally.count == 0 {
        tally.append(soup.structure(options.perturbed, runner));
        report.vertices_used = soup.used.iter().filter(|&&used| used).count() as u64;
        report.duplicates = soup.duplicates;
        report.hidden = report.hidden.map(|_| soup.hidden);
        report.dimension_of_points = soup.dimension;
    }
    report.levels.push(tally.level(LEVELS[0]));
    if !report.passed() {
        return stop(report, LEVELS[0]);
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
    if let Some(earlier) = report.levels.iter().find(|level| !level.passed).map(|level| level.name) {
        stop(report, earlier);
    } else if report.hidden.is_some() {
        report.levels.push(hidden::check(&soup, &facets, runner).level(HIDDEN_SITES));
    }
}
