//! The points of a mesh, from corners to the volume, and the mesh in their Delaunay triangulation.
//!
//! **Statement.** Let f be L-Lipschitz and nowhere above the local feature size. Let no two features meet at less than
//! 90 degrees. Let each facet be convex, or let no feature that shares a corner with it be nearer than f to the rest
//! of it. (In a convex facet, the corner is the nearest point because of the angle.) The generator places points that
//! are f-spaced: the distance between two points is at least the smaller of their sizes. These points satisfy
//!
//! 1. (Gabriel) no point lies in the smallest ball of a subsegment or of a subfacet, so all subsegments and subfacets
//!    are in the Delaunay triangulation;
//! 2. (completion) the circumradius is at most `(1 - 1e-9) f(centre)` for every subsegment, every subfacet with its
//!    centre outside all balls of subsegments, and every cell with its centre outside all balls. All centres of cells
//!    lie in the domain.
//!
//! Balls are written (centre, radius): (p, s) for a subsegment, (m, r) for a subfacet. A point is *above* a subfacet
//! if the ball of the subfacet contains it and its foot in the plane lies in the subfacet. A cell with centre c,
//! circumradius R and shortest edge l satisfies `R / l <= g / (1 - g L)`, where
//!
//! - (free) g = 1 if c lies in no ball;
//! - (near) `g = sqrt(2) / (1 - L)` if c lies in the ball of a subsegment, or above a subfacet with `r <= f(m)`;
//! - (above) `g = sqrt(2) k / (1 - k L)` if c lies above a subfacet with `r <= k f(m)`, `k >= 1`; for any subfacet,
//!   `g = max sqrt(4 - 2 d^2) / (1 - L sqrt(3 + 2 d))` over d in `[0, sqrt(2)]`.
//!
//! *Proof.* The shortest edge of a cell ends at some vertex v with `l >= f(v) >= f(c) - L R`. So `R <= g f(c)` gives
//! `R / l <= g / (1 - g L)`. If c lies in no ball, completion gives g = 1. By completion, `s <= f(p)` for every
//! subsegment.
//!
//! 1. *The ball of a subsegment contains c.* The foot q of c on the line of the subsegment lies in the subsegment.
//!    Let v be the nearer end, so that `|v - q| = s - |p - q|`. Then
//!    `|v - c|^2 = |q - c|^2 + |v - q|^2 <= (s^2 - |p - q|^2) + (s - |p - q|)^2 <= 2 s^2`. The ball of the cell is
//!    empty, so `R <= |v - c| <= sqrt(2) s`. Because `s <= f(p) <= f(c) + L s`, we have `s <= f(c) / (1 - L)`.
//! 2. *The ball of a subfacet contains c, no ball of a subsegment does, and the foot q of c in the plane lies in the
//!    facet.* Let (m, r) be the ball of the subfacet that contains q. This ball also contains c, because the
//!    subfacets are Delaunay and the power of q is least there. So c is above this subfacet. Let `q = sum a_i v_i` be
//!    a convex combination of its corners. Because `sum a_i |v_i - q|^2 = r^2 - |m - q|^2`, some corner has
//!    `|v - c|^2 <= |q - c|^2 + r^2 - d^2 <= 2 (r^2 - d^2)` with `d = |m - q|`. Therefore `R <= sqrt(2) r`. If
//!    `r <= k f(m) <= k (f(c) + L r)`, then `r <= k f(c) / (1 - k L)`. For k = 1 this is the case (near), otherwise
//!    (above).
//! 3. *A bound for any subfacet, without k.* If m lies in no ball of a subsegment, completion gives k = 1. Otherwise
//!    let (p, s) be the ball of that subsegment. It lies in the plane of the facet: if m lies outside the facet, step 4
//!    gives a subsegment on its boundary; otherwise all other subsegments are farther from m than `s <= f(p)`. Choose s
//!    as unit, `s = 1 <= f(p)`. The circumcircle of the subfacet is empty, so its radius is at most the distance of m
//!    from the nearer end of the subsegment: `r^2 <= 1 + |m - p|^2 <= 2`. So `R^2 <= 2 (r^2 - d^2) <= 4 - 2 d^2`.
//!    Moreover `|c - p|^2 = |q - p|^2 + |c - q|^2 <= (|m - p| + d)^2 + r^2 - d^2 <= 1 + 2 d + 2`, hence
//!    `f(c) >= 1 - L sqrt(3 + 2 d)`.
//! 4. *If q lies outside the facet, the ball of a subsegment contains c.* The path from the subfacet to q leaves the
//!    facet through a subsegment. It does not leave through a vertex, because no vertex lies in the disc (m, r). The
//!    line of the subsegment meets the disc in a chord. The chord is part of the subsegment, whose ends are vertices.
//!    The subfacet lies on one side of the line, and q lies on the other.
//!    - Suppose that m lies beyond the line. Then the subfacet lies in the part of the disc that the line cuts off on
//!      its side. This part is less than half the disc, so it lies in the ball over the chord. The third corner of the
//!      subfacet would lie in the ball of the subsegment, a contradiction.
//!    - So m lies on the side of the subfacet. Then the part of the ball (m, r) beyond the line is less than half of
//!      the ball. It lies in the ball over the chord, hence in that of the subsegment, and it contains c. QED.
//!
//! The value of k for a mesh can be computed from its subfacets ([`crate::quality::balls`]). By `r <= sqrt(2) s` and
//! `s <= f(m) + L s`, k is at most `sqrt(2) / (1 - L)`. Nothing is promised if `g L >= 1`. For (near), this inequality
//! holds if `L >= 0.41`. For (above) with any subfacet, it holds if `L >= 0.25`. For (above) with a known k, it holds
//! if `k L >= 0.41`.
//!
//! Two facts follow from the lemma of Ruppert and Shewchuk for angles of at least 90 degrees. Circumcentres lie in
//! the domain, and points on one feature stay out of the balls on another. Suppose that the projection of a point
//! onto the plane or line of a feature ends outside the feature. By the lemma, it crosses the ball of a subsegment of
//! the boundary, and this ball is empty.
//!
//! **Source.** Section 5 of the paper; Ruppert (1995), Shewchuk (1998), Spielman, Teng and Ungor (2007).
//!
//! **Departures.**
//! - *Dimensions in order.* Features of each dimension are complete before the next dimension begins. A circumcentre in
//!   a ball of a complete feature therefore does not divide that feature. It is moved out of the ball (`off_centre`),
//!   or skipped if there is no room or if features meet at less than 90 degrees. This is the reason for the factor g.
//! - *Large subfacets.* If a subfacet is larger than f, dividing the subsegment below it would give k = 1. But the
//!   points would be closer than f: the halves have the length s, which can be `r / sqrt(2)`.
//! - *Cocircular points.* If four points of a facet inside the domain are cocircular up to rounding, the centre of the
//!   circle may be inserted (`missing`). Its distance from the points is the radius of the circle, which may be below
//!   f.
//! - *Small angles.* If features meet at less than 90 degrees, two kinds of simplices are divided (`recover`),
//!   although points are then closer than f. These are subsegments whose balls contain a point, and subfacets without
//!   an empty ball of little more than the smallest radius. No points of the volume are placed in the empty balls
//!   that are found in this way. Claim 1 holds with these balls instead of the smallest ones.
//!
//! **Rounds and work.** Each stage needs one independent set at the beginning, and one per round of completion. Each
//! triangulation and each set is a run of the [`MeshMachine`].

mod balls;
mod barrier;
mod cell_labels;
mod cells;
mod corner_shells;
mod divide;
mod error;
mod facets;
mod finish;
mod generator;
mod machine;
mod missing;
mod off_centre;
mod reason;
mod recover;
pub mod remesh;
mod segments;
mod subdivision;
mod vertices;
mod volume;
mod witness;

use crate::domain::Domain;
use crate::executor::{Executor, Uncounted, always};
use crate::space::Space;

pub use cell_labels::CellLabels;
pub use error::{GenerationError, Missing, Reason};
pub use facets::Subfacet;
pub use generator::{Rules, StageCounts};
pub use machine::{Alone, Delaunay, MeshMachine};
pub use reason::Coarse;
pub use segments::Subsegment;
pub use vertices::{Holders, Vertices};

use barrier::Own;
pub(crate) use finish::canonical;
use generator::Generator;
pub(crate) use vertices::normal_of;
use volume::Filled;

/// The result of generation.
#[derive(Clone, Debug)]
pub struct GeneratedMesh<P: Space> {
    /// The vertices.
    pub vertices: Vertices<P>,
    /// Their Delaunay triangulation.
    pub delaunay: Delaunay<P::Cell>,
    /// The component of each cell.
    pub labels: CellLabels,
    /// Faces of the mesh on facets (in the plane: edges on segments), as facet, face, and adjacent cells.
    pub faces: Vec<(u32, P::Facet, [u32; 2])>,
    /// The subsegments, with their segments.
    pub subsegments: Vec<Subsegment>,
    /// The counts of each stage.
    pub stages: Vec<StageCounts>,
}

/// Estimates the number of points of a mesh from the cells in which candidates are placed, without counts. Returns one more than the
/// limit if there are too many cells.
pub fn expected_points<P: Space>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    executor: &(impl Executor + Copy),
) -> u64 {
    let Some(cells) = always(volume::sampling_cells(domain, &rules, &Uncounted(*executor))) else {
        return rules.most.saturating_add(1);
    };
    let cube = volume::root_of(domain);
    let share = |&(key, _): &volume::SampledCell| {
        let cell = cube.cell(key);
        let cubes = cell.side / rules.size.at(cell.centre);
        (0..P::DIM).fold(1.0, |product, _| product * cubes)
    };
    executor.map(&cells, share).iter().sum::<f64>().ceil() as u64 + domain.corners.len() as u64
}

/// Generates the points of a domain and triangulates them.
///
/// # Errors
/// Returns a [`GenerationError`] if the machine fails, features cannot be recovered, or the mesh needs too many
/// vertices.
pub fn generate<P: Space, M: MeshMachine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    machine: &mut M,
) -> Result<GeneratedMesh<P>, GenerationError<M::Error>> {
    // If the sizes are too fine, generation fails before any other work.
    let cells = volume::sampling_cells(domain, &rules, &*machine).map_err(GenerationError::Machine)?;
    let cells = cells.ok_or(GenerationError::TooMany(rules.most))?;
    let mut generator = Generator::new(domain, rules, machine);
    generator.place_corners(0..domain.corners.len() as u32).map_err(GenerationError::Machine)?;
    generator.off_centres = domain.small_angles(90.0).is_empty();
    let planes = generator.planes();
    let chains = generator.segments().map_err(GenerationError::Machine)?;
    let subfacets = if P::DIM == 3 {
        generator.facets(&planes, &chains).map_err(GenerationError::Machine)?
    } else {
        Vec::new()
    };
    let (chains, subfacets) = generator.recover(&planes, chains, subfacets)?;
    let own = Own { planes: &planes, chains: &chains, subfacets: &subfacets };
    let Filled { delaunay, labels, barrier } = generator.volume(own, &cells)?;
    let faces = generator.faces(&delaunay, &labels, &barrier, &planes);
    let subsegments = segments::subsegments_of(&chains);
    Ok(GeneratedMesh {
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
