//! Points that are forced so that nothing of the domain is lost.
//!
//! **Statement.** At the end no vertex lies in the smallest ball of a piece, and every triangle has a [`super::witness`] of
//! at most [`WIDEST`] times its radius. Those balls are closed to the points of the volume, so nothing can be lost any more, and
//! cells at the boundary have radii no larger than those of its triangles by more than that. What breaks the rule is divided
//! ([`super::divide`]), pieces before triangles, although points then are closer than f. Without angles below 90 degrees
//! there is nothing to do.
//!
//! **Termination.** *Pieces.* Points of facets are kept out of the balls of pieces, so only corners and points of other segments
//! can be in them. Segments without a common corner have a distance; those with one are divided on common spheres:
//! pieces of equal length from a corner, and pieces between the same two spheres, leave each other's ends outside; one
//! sphere more is inside of a ball only if the piece is longer than its distance from the next segment, which is
//! proportional to that from the corner. So lengths of pieces are bounded below, by lfs times a constant of the angles.
//!
//! *Triangles.* The centre of one is placed because a vertex v of another facet is no farther than its diameter. Facets without a
//! common point have a distance; at angles of at least 90 degrees v would lie in the ball of a piece between. So radii are
//! bounded below by the distance from the common corner or segment times the sine of the angle there. Triangles with an edge on
//! the segment itself have a witness whatever the angles, of some width: the sphere through a piece and one apex on each of
//! two facets meets both planes in circumcircles, which are empty. What no proof is known for is that points come
//! no closer to the segment: each row of triangles may ask for a finer one below. At angles of some ten degrees they do not,
//! below one degree they do. So after [`PATIENT`] rounds wider balls will do, and more and more, which is what the Delaunay
//! triangulation asks for itself; and if that has no end either, the features are an error. Several facets at one
//! corner within some ten degrees of each other, between segments more than 90 degrees apart (folds and creases of scans), have triangles at
//! the corner that come again at half the size: such corners are enclosed ([`super::corner_shells`]). Nothing says that arcs of neighbouring facets, each
//! finer for the other, have an end everywhere else.
//!
//! **Source.** Ruppert (1995), section 5; Shewchuk (1998; 2002); Cohen-Steiner, Colin de Verdiere and Yvinec (2004).

use super::balls::{Ball, Balls};
use super::corner_shells::ENCLOSE_AFTER;
use super::facets::{Plane, ROUNDING, Subfacets};
use super::generator::Generator;
use super::machine::Machine;
use super::missing::MissingParts;
use super::segments::{Chains, subsegments_of};
use super::witness::Near;
use super::{Failure, Missing};
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// The largest radius of a witness, over that of the triangle.
pub const WIDEST: f64 = 1.25;

/// Rounds before witnesses may be wider, and before the generator gives up.
const PATIENT: u32 = 30;
const MOST_ROUNDS: u32 = 90;

/// A facet's triangles, by facets.
type ByFacet = Vec<Vec<[u32; 3]>>;

impl<P: Space, M: Machine<P> + Sync> Generator<'_, P, M> {
    /// Forces points until nothing is missing. The chains and triangles that are then in the triangulation; triangles and
    /// witnesses are closed.
    pub(super) fn recover(
        &mut self,
        planes: &[Plane],
        mut chains: Chains,
        subfacets: Subfacets,
    ) -> Result<(Chains, Subfacets), Failure<M::Error>> {
        let mut by_facet: ByFacet = vec![Vec::new(); planes.len()];
        for (f, t) in subfacets {
            by_facet[f as usize].push(t);
        }
        let mut round = 0;
        loop {
            let subfacets = listed(&by_facet);
            let missing = match self.witnesses(&chains, &subfacets, width(round)) {
                Err(missing) => missing,
                Ok(witnesses) => {
                    // What is lacking now is so by rounding.
                    let delaunay = self.machine.delaunay(&self.vertices.points).map_err(Failure::Machine)?;
                    let missing = self.missing(&delaunay, planes, &chains, &subfacets);
                    if missing.is_empty() {
                        self.subfacets = Balls::new(self.balls_of_subfacets(&subfacets));
                        self.closed = Balls::new(witnesses);
                        return Ok((chains, subfacets));
                    }
                    missing
                }
            };
            let forced = self.divided(planes, &chains, &missing);
            let finest = forced.iter().map(|f| f.0.size).fold(f64::INFINITY, f64::min);
            if round == MOST_ROUNDS || finest < self.coarse_rounding() {
                return Err(Failure::Missing(Missing { features: missing.features() }));
            }
            if self.vertices.len() as u64 > self.rules.most {
                return Err(Failure::TooMany(self.rules.most));
            }
            if round == 0 {
                self.begin("force");
            }
            round += 1;
            let corners = if round > ENCLOSE_AFTER { self.unresolved_corners(&missing) } else { Vec::new() };
            let stale = if corners.is_empty() {
                let before = self.vertices.len();
                self.insert_forced(forced).map_err(Failure::Machine)?;
                self.facets_of(before)
            } else {
                self.enclose(&corners, &chains);
                (0..planes.len() as u32).collect()
            };
            chains = self.chains();
            self.subsegments = Balls::new(self.balls_of_subsegments(&chains));
            self.triangulate_facets(planes, &chains, &stale, &mut by_facet).map_err(Failure::Machine)?;
        }
    }

    /// A length well above what rounding does to coordinates.
    fn coarse_rounding(&self) -> f64 {
        let points = self.domain.points();
        let largest = points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).abs())).fold(0.0, f64::max);
        100.0 * ROUNDING * largest
    }

    /// The facets that hold the vertices from a number on.
    fn facets_of(&self, first: usize) -> Vec<u32> {
        if P::DIM == 2 {
            return Vec::new();
        }
        let new = &self.vertices.carriers[first..];
        let mut facets: Vec<u32> = new.iter().flat_map(|c| self.holders.of(c)).copied().collect();
        facets.sort_unstable();
        facets.dedup();
        facets
    }

    /// Witnesses of the triangles whose smallest ball is none; or else the pieces whose balls hold vertices; or, if there
    /// are no such pieces, the triangles that have no witness.
    fn witnesses(
        &self,
        chains: &Chains,
        subfacets: &Subfacets,
        widest: f64,
    ) -> Result<Vec<Ball<P>>, MissingParts> {
        let near = Near::new(&self.vertices.points);
        let subsegments = self.encroached(&near, chains);
        if !subsegments.is_empty() {
            return Err(MissingParts { subsegments, subfacets: Vec::new() });
        }
        let corners = |t: &[u32; 3]| t.map(|v| self.vertices.points[v as usize]);
        let found = self.machine.map(subfacets, |(_, t)| near.witness(corners(t), widest));
        let without = subfacets.iter().zip(&found).filter(|(_, found)| found.is_none());
        let missing: Subfacets = without.map(|(t, _)| *t).collect();
        if !missing.is_empty() {
            return Err(MissingParts { subsegments: Vec::new(), subfacets: missing });
        }
        Ok(found.into_iter().flatten().filter_map(|w| (!w.smallest).then_some(w.ball)).collect())
    }

    /// The pieces whose balls hold vertices.
    pub(super) fn encroached(&self, near: &Near<'_, P>, chains: &Chains) -> Vec<(u32, [u32; 2])> {
        let subsegments = subsegments_of(chains);
        let empty = self.machine.map(&subsegments, |&(_, subsegment)| {
            near.is_empty(subsegment.map(|v| self.vertices.points[v as usize]))
        });
        subsegments
            .into_iter()
            .zip(empty)
            .filter(|(_, empty)| !empty)
            .map(|(subsegment, _)| subsegment)
            .collect()
    }

    /// Places forced points as far as they are independent, with the sizes of the function.
    fn insert_forced(&mut self, forced: Vec<(Site<P>, Carrier)>) -> Result<u64, M::Error> {
        let before = self.vertices.len();
        let placed = self.complete(forced, true)?;
        for v in before..self.vertices.len() {
            self.vertices.sizes[v] = (self.rules.size)(self.vertices.points[v]);
        }
        Ok(placed)
    }
}

/// All triangles with their facets.
fn listed(by_facet: &[Vec<[u32; 3]>]) -> Subfacets {
    (0u32..).zip(by_facet).flat_map(|(f, t)| t.iter().map(move |t| (f, *t))).collect()
}

/// How wide witnesses may be.
fn width(round: u32) -> f64 {
    WIDEST * f64::from(round.saturating_sub(PATIENT) + 1)
}
