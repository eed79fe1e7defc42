//! Points of a mesh, from corners to the volume, and the mesh that their Delaunay triangulation holds.
//!
//! **Statement.** Let f be L-Lipschitz and nowhere above the local feature size, and let no two features meet at less
//! than 90 degrees; and let facets be convex, or else let what shares a corner with one come no nearer to the rest of it
//! than f (of a convex one the corner is nearest already, by the angle). The generator places points that are f-spaced (two are no closer than the smaller of their sizes)
//! such that
//!
//! 1. (Gabriel) no point lies in the smallest ball of a segment's piece, nor in that of a facet's triangle, so all of
//!    them are in the Delaunay triangulation;
//! 2. (completion) every piece, every facet's triangle with its centre outside of all balls of pieces and every cell with its
//!    centre outside of all those balls has a circumradius of at most `(1 - 1e-9) f(centre)`; and all centres of
//!    cells lie in the domain.
//!
//! Then a cell with centre c has `R / l <= g / (1 - g L)`, and
//!
//! - (free) g = 1 where c lies in no ball;
//! - (near) `g = sqrt(2) / (1 - L)` where c lies in the ball of a piece, or above a triangle with `r <= f(m)`;
//! - (above) `g = sqrt(2) k / (1 - k L)` where c lies above a triangle with `r <= k f(m)`, `k >= 1`; and
//!   `g = max sqrt(4 - 2 d^2) / (1 - L sqrt(3 + 2 d))` over d in `[0, sqrt(2)]` whatever the triangle.
//!
//! *Proof.* A cell's shortest edge ends at some vertex v with `l >= f(v) >= f(c) - L R`; so `R <= g f(c)`
//! gives `R / l <= g / (1 - g L)`. Where c lies in no ball that is completion. Let (p, s) be the ball of a piece, `s <= f(p)`, and (m, r)
//! that of a triangle.
//!
//! 1. *The ball of a piece holds c.* Its foot q on the piece's line lies in the piece, so with the nearer end v
//!    `|v - q| = s - |p - q|` and `|v - c|^2 = |q - c|^2 + |v - q|^2 <= (s^2 - |p - q|^2) + (s - |p - q|)^2 <= 2 s^2`. The cell's ball is empty, hence
//!    `R <= |v - c| <= sqrt(2) s`; and `s <= f(p) <= f(c) + L s` makes `s <= f(c) / (1 - L)`.
//! 2. *That of a triangle holds c, no piece's does, and the foot q of c in the plane lies in the facet.* Of the facet's triangles take
//!    for (m, r) the one that holds q: c is *above* it. Its ball holds c, too (the triangles are Delaunay, so powers of q are least there).
//!    With `q = sum a_i v_i` over its corners, `sum a_i |v_i - q|^2 = r^2 - |m - q|^2`, so some corner has
//!    `|v - c|^2 <= |q - c|^2 + r^2 - d^2 <= 2 (r^2 - d^2)`, `d = |m - q|`; hence `R <= sqrt(2) r`. If `r <= k f(m) <= k (f(c) + L r)`, then
//!    `r <= k f(c) / (1 - k L)`. That is near for k = 1, and above for any other.
//! 3. *No such k is known before.* If m lies in no ball of a piece, k = 1 by completion. Else let (p, s) be that piece, which is in the
//!    facet's plane (if m lies outside of the facet, step 4 gives one on its border; else all others are farther from m than
//!    `s <= f(p)`); let s be the unit, `s = 1 <= f(p)`. The triangle's circle is empty, so its radius is no more than the distance of m from the nearer end of
//!    the piece: `r^2 <= 1 + |m - p|^2 <= 2`. So `R^2 <= 2 (r^2 - d^2) <= 4 - 2 d^2`, and
//!    `|c - p|^2 = |q - p|^2 + |c - q|^2 <= (|m - p| + d)^2 + r^2 - d^2 <= 1 + 2 d + 2`, whence `f(c) >= 1 - L sqrt(3 + 2 d)`.
//! 4. *q lies outside of the facet: then the ball of a piece holds c.* The way from the triangle to q leaves the facet through a piece
//!    (through a vertex it does not: those lie in no disc (m, r)), whose line meets the disc in a chord, and the chord is part of the piece, since
//!    its ends are vertices. The triangle lies on one side of the line, q on the other. If m lay beyond the line, the triangle would lie in
//!    the part of the disc cut off, which is less than half of it and so in the ball over the chord: its third corner would be in
//!    the ball of the piece. So m lies on the triangle's side; then the part of the ball (m, r) beyond is less than half of
//!    it, lies in the ball over the chord, so in that of the piece, and holds c. QED.
//!
//! How much larger than f triangles are can be seen ([`crate::quality::balls`]): k is at most `sqrt(2) / (1 - L)`, by `r <= sqrt(2) s` and
//! `s <= f(m) + L s`. Nothing is promised where `g L >= 1`: near from L = 0.41 on, above whatever the triangle from
//! L = 0.25 on, and above one of a known k where `k L` is 0.41.
//!
//! That circumcentres lie in the domain, and that points on one feature stay out of the balls on another, is
//! Ruppert's and Shewchuk's lemma for angles of at least 90 degrees: projections onto a facet or line that leave it
//! cross the ball of a piece of its border, which is empty.
//!
//! **Source.** Section 5 of the paper; Ruppert (1995), Shewchuk (1998), Spielman, Teng and Ungor (2007).
//!
//! **Departures.** Features come in the order of their dimension, each completed before the next begins, so a
//! centre that lies in a ball of what is complete does not divide that: it is lifted out of the ball (`lift`), or given up if
//! there is no room or features meet at less than 90 degrees, which is where g comes from. To divide the piece below a triangle that is
//! larger than f, and so to have k = 1, would place points closer than f: its halves are as long as s, which
//! can be `r / sqrt(2)`. Where four points of a facet inside of the domain are on a circle as nearly as can be rounded, the circle's centre may be
//! added (`lacking`), which is as far from them as the circle's radius, not as f. Where
//! features meet at less than 90 degrees, pieces whose balls hold a point, and triangles without a ball of little more than
//! their radius that holds none, are divided although that spaces points more closely than f (`force`). The balls that are
//! found so are closed to the points of the volume too, so 1 holds with them in the place of the smallest ones.
//!
//! **Rounds and work.** Of every stage: one independent set, then one a round of completion; each triangulation and
//! each set is a run of the [`Machine`].

mod balls;
mod barrier;
mod cells;
mod corner_shells;
mod divide;
mod facets;
mod finish;
mod generator;
mod machine;
mod missing;
mod off_centre;
mod recover;
pub mod remesh;
mod segments;
mod vertices;
mod volume;
mod witness;

use crate::domain::{Domain, Feature};
use crate::space::Space;

pub use cells::Labels;
pub use generator::{Rules, Stage};
pub use machine::{Alone, Machine, Triangulation};
pub use vertices::{Holders, Vertices};

use barrier::Own;
use generator::Generator;
pub(crate) use vertices::normal_of;
use volume::Filled;

/// What was generated.
#[derive(Clone, Debug)]
pub struct Generated<P: Space> {
    /// The vertices.
    pub vertices: Vertices<P>,
    /// Their Delaunay triangulation.
    pub delaunay: Triangulation<P::Cell>,
    /// Which component each cell is in.
    pub labels: Labels,
    /// Faces of the mesh on facets (in the plane: edges on segments): the facet, the face, and the cells beside it.
    pub faces: Vec<(u32, P::Facet, [u32; 2])>,
    /// The pieces of segments.
    pub subsegments: Vec<(u32, [u32; 2])>,
    /// What each stage did.
    pub stages: Vec<Stage>,
}

/// Features of which the triangulation lacks parts, and how many.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The features, ascending.
    pub features: Vec<(Feature, u32)>,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure<E> {
    /// The machine's reason.
    Machine(E),
    /// Features at small angles could not be kept.
    Missing(Missing),
    /// More vertices than allowed.
    TooMany(u64),
    /// This domain cannot be meshed that way.
    Unsupported(&'static str),
}

/// How many points a mesh will have, about: from the cells that candidates are made in. Where there are too many cells for
/// the points allowed, one more than these.
pub fn expected_points<P: Space, M: Machine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &M,
) -> u64 {
    let Some(cells) = volume::sampling_cells(domain, &rules, machine) else {
        return rules.most.saturating_add(1);
    };
    let share = |(cell, _): &(crate::octree::Cell<P>, bool)| {
        let cubes = cell.side / (rules.size)(cell.centre);
        (0..P::DIM).fold(1.0, |product, _| product * cubes)
    };
    machine.map(&cells, share).iter().sum::<f64>().ceil() as u64 + domain.corners.len() as u64
}

/// Generates the points of a domain and triangulates them.
///
/// # Errors
/// [`Failure`].
pub fn generate<P: Space, M: Machine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &mut M,
) -> Result<Generated<P>, Failure<M::Error>> {
    // What is too fine is refused before any work.
    let cells = volume::sampling_cells(domain, &rules, &*machine).ok_or(Failure::TooMany(rules.most))?;
    let mut generator = Generator::new(domain, rules, machine);
    generator.off_centres = domain.small_angles(90.0).is_empty();
    let planes = generator.planes();
    let chains = generator.segments().map_err(Failure::Machine)?;
    let subfacets =
        if P::DIM == 3 { generator.facets(&planes, &chains).map_err(Failure::Machine)? } else { Vec::new() };
    let (chains, subfacets) = generator.recover(&planes, chains, subfacets)?;
    let own = Own { planes: &planes, chains: &chains, subfacets: &subfacets };
    let Filled { delaunay, labels, barrier } = generator.volume(own, &cells)?;
    let faces = generator.faces(&delaunay, &labels, &barrier, &planes);
    let subsegments = segments::subsegments_of(&chains);
    Ok(Generated {
        vertices: generator.vertices,
        delaunay,
        labels,
        faces,
        subsegments,
        stages: generator.stages,
    })
}

#[cfg(test)]
mod tests;
