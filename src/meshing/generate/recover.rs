//! Recovery: the insertion of points until every subsegment and subfacet is in the triangulation.
//!
//! **Statement.** At the end, no vertex lies in the smallest ball of a subsegment, and every subfacet has a
//! [`super::witness`] of at most [`WIDEST`] times its radius. No points of the volume are placed in these balls, so no
//! subsegment or subfacet can be lost later. The radii of cells at the boundary exceed the radii of its subfacets by
//! at most this factor. Simplices that violate the rule are divided ([`super::divide`]), subsegments before subfacets.
//! Points may then be closer than f. If there are no angles below 90 degrees, recovery inserts no points.
//!
//! **Termination.**
//!
//! *Subsegments.* Points of facets are kept out of the balls of subsegments, so only corners and points of other
//! segments can lie in them. Segments without a common corner have a positive distance. Segments with a common corner
//! are divided on common spheres. Subsegments of equal length from a corner exclude each other's ends from their balls,
//! and so do subsegments between the same two spheres. A further sphere lies inside a ball only if the subsegment is
//! longer than its distance from the next segment. That distance is proportional to the distance from the corner.
//! Lengths of subsegments are therefore bounded from below by lfs times a constant that depends on the angles.
//!
//! *Subfacets.* A circumcentre is inserted because a vertex v of another facet is at most one diameter away. Facets
//! without a common point have a positive distance. At angles of at least 90 degrees, v would lie in the ball of a
//! subsegment between the facets. Radii are therefore bounded from below by the distance from the common corner or
//! segment times the sine of the angle there.
//!
//! *Subfacets with an edge on the common segment.* These have a witness of some width at any angle. The sphere
//! through a subsegment and one apex on each of two facets meets both planes in circumcircles, which are empty.
//! Points may approach the segment forever, because each row of subfacets may require a finer row next to it. No
//! proof excludes this. In practice, it does not happen at angles of about ten degrees, but it does below one degree.
//! After [`PATIENT`] rounds, the width allowed for witnesses therefore grows with every round. In the limit, this is
//! the condition of the Delaunay triangulation itself. If recovery still does not end, an error reports the features.
//!
//! *Corners.* Several facets may meet at a corner within about ten degrees of each other, between segments more than
//! 90 degrees apart (folds and creases of scans). Subfacets at the corner then recur at half the size. Such corners
//! are enclosed ([`super::corner_shells`]). Elsewhere, arcs of adjacent facets may refine each other forever. No
//! proof excludes this.
//!
//! **Source.** Ruppert (1995), section 5; Shewchuk (1998; 2002); Cohen-Steiner, Colin de Verdiere and Yvinec (2004).

use super::balls::{Ball, Balls};
use super::corner_shells::ENCLOSE_AFTER;
use super::error::{GenerationError, Missing};
use super::facets::{Plane, ROUNDING, Subfacets};
use super::generator::{Candidate, Generator};
use super::machine::MeshMachine;
use super::missing::MissingParts;
use super::segments::{Chains, Subsegment, subsegments_of};
use super::witness::Near;
use crate::frame::FINEST;
use crate::space::Space;

/// The largest radius of a witness, relative to the radius of its subfacet.
pub const WIDEST: f64 = 1.25;

/// The number of rounds before the width of witnesses grows.
const PATIENT: u32 = 30;
const MOST_ROUNDS: u32 = 90;

/// The subfacets of each facet.
type ByFacet = Vec<Vec<[u32; 3]>>;

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Inserts points until nothing is missing. Returns the chains and subfacets of the final triangulation. Closes the
    /// balls of subfacets and witnesses to points of the volume.
    pub(super) fn recover(
        &mut self,
        planes: &[Plane],
        mut chains: Chains,
        subfacets: Subfacets,
    ) -> Result<(Chains, Subfacets), GenerationError<M::Error>> {
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
                    // Simplices that are missing at this point are missing because of rounding.
                    let delaunay =
                        self.machine.delaunay(&self.vertices.points).map_err(GenerationError::Machine)?;
                    let missing = self.missing(&delaunay, planes, &chains, &subfacets);
                    if missing.is_empty() {
                        self.subfacets = Balls::new(self.balls_of_subfacets(&subfacets));
                        self.closed = Balls::new(witnesses);
                        return Ok((chains, subfacets));
                    }
                    missing
                }
            };
            let dividing = self.divided(planes, &chains, &missing);
            let finest = dividing.iter().map(|f| f.0.size).fold(f64::INFINITY, f64::min);
            let is_rounded = finest < self.coarse_rounding();
            if round == MOST_ROUNDS || is_rounded {
                let missing = Missing::of(self.domain, missing.features(), is_rounded);
                return Err(GenerationError::Missing(missing));
            }
            if self.vertices.len() as u64 > self.rules.most {
                return Err(GenerationError::TooMany(self.rules.most));
            }
            if round == 0 {
                self.begin("force");
            }
            round += 1;
            let corners = if round > ENCLOSE_AFTER { self.unresolved_corners(&missing) } else { Vec::new() };
            let stale = if corners.is_empty() {
                let before = self.vertices.len();
                self.insert_dividing(dividing).map_err(GenerationError::Machine)?;
                self.facets_of(before)
            } else {
                self.enclose(&corners, &chains);
                (0..planes.len() as u32).collect()
            };
            chains = self.chains();
            self.subsegments = Balls::new(self.balls_of_subsegments(&chains));
            self.triangulate_facets(planes, &chains, &stale, &mut by_facet)
                .map_err(GenerationError::Machine)?;
        }
    }

    /// Returns a length well above the rounding of coordinates.
    fn coarse_rounding(&self) -> f64 {
        let points = self.domain.points();
        let largest = points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).abs())).fold(0.0, f64::max);
        100.0 * ROUNDING * largest + FINEST * self.domain.simplices.frame.grid()
    }

    /// Returns the facets that contain the vertices with indices from `first`.
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

    /// Returns the witnesses of the subfacets whose smallest balls contain a vertex. The error has the subsegments
    /// whose balls contain vertices or, if there are none, the subfacets without a witness.
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

    /// Returns the subsegments whose balls contain vertices.
    pub(super) fn encroached(&self, near: &Near<'_, P>, chains: &Chains) -> Vec<Subsegment> {
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

    /// Inserts an independent set of the points, with the values of the size function as their sizes.
    fn insert_dividing(&mut self, dividing: Vec<Candidate<P>>) -> Result<u64, M::Error> {
        let before = self.vertices.len();
        let placed = self.complete(dividing, true)?;
        self.size_vertices(before)?;
        Ok(placed)
    }
}

/// Returns all subfacets with their facets.
fn listed(by_facet: &[Vec<[u32; 3]>]) -> Subfacets {
    (0u32..).zip(by_facet).flat_map(|(f, t)| t.iter().map(move |t| (f, *t))).collect()
}

/// Returns the allowed width of witnesses in a round.
fn width(round: u32) -> f64 {
    WIDEST * f64::from(round.saturating_sub(PATIENT) + 1)
}
