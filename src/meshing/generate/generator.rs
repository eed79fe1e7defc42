//! The state of generation, which all stages share.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::At;
use septet_geometry::point::Point;

use super::balls::Balls;
use super::machine::{MeshMachine, distinct};
use super::vertices::{Holders, Vertices, flat_groups};
use crate::domain::Domain;
use crate::executor::{Part, evaluated, in_sequence};
use crate::mesh::Carrier;
use crate::points::candidates::Name;
use crate::points::conflicts::{Site, Sites};
use crate::size::Sizing;
use crate::space::Space;

/// A simplex is complete if its circumradius is at most this fraction of the size at its centre.
pub(super) const COMPLETE: f64 = 1.0 - 1e-9;

/// A cell is divided while its side exceeds this multiple of the size at its centre. Completion finds the remaining
/// gaps. Sides of at most the size, with two candidates per cell, lead to the same numbers of rounds, points and
/// cells, but need several times as many candidates.
pub(super) const SIDE: f64 = 1.4;

/// The number of candidates per cell.
pub(super) const CANDIDATES: u32 = 1;

/// A candidate for a point, and its carrier.
pub(super) type Candidate<P> = (Site<P>, Carrier);

/// The parameters of generation.
#[derive(Clone, Copy)]
pub struct Rules<'a, P> {
    /// The size function, in the scaled coordinates of the domain.
    pub size: &'a dyn Sizing<P>,
    /// Its Lipschitz constant.
    pub lipschitz: f64,
    /// The seed for the positions of candidates.
    pub seed: u64,
    /// The maximum number of vertices.
    pub most: u64,
}

impl<P: Point> Rules<'_, P> {
    pub(super) fn site(&self, at: P) -> Site<P> {
        Site { at, size: self.size.at(at) }
    }

    /// Returns the site of a lane.
    fn site_of_lane(&self, At(at): At<P>, own: &mut Cost) -> f64 {
        in_sequence(own, |visits| self.size.at_counted(at, visits))
    }

    /// Returns `true` if a simplex is too large. `largest` is the largest size at its corners. The size at its centre
    /// is evaluated only if the sizes at the corners do not decide.
    pub(super) fn is_too_large(&self, centre: P, radius: f64, largest: f64, visits: &mut Sweep) -> bool {
        visits.visit();
        radius * (1.0 + self.lipschitz) > largest * COMPLETE
            && radius > COMPLETE * self.size.at_counted(centre, visits)
    }
}

/// The counts of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounts {
    /// `segments`, `facets`, `volume`, or `force` for the recovery stage.
    pub name: &'static str,
    /// The number of candidates in the graphs of independent sets.
    pub candidates: u64,
    /// The number of points placed.
    pub points: u64,
    /// The number of rounds of completion.
    pub completion: u32,
    /// The number of rounds of local priorities, over all sets.
    pub set_rounds: u32,
    /// The largest number of rounds of one set, and its number of candidates.
    pub longest: (u32, u64),
}

/// The generator.
pub(super) struct Generator<'a, P: Space, M> {
    pub(super) domain: &'a Domain<P>,
    pub(super) rules: Rules<'a, P>,
    pub(super) machine: &'a mut M,
    pub(super) holders: Holders,
    /// The groups of coplanar facets of each carrier.
    pub(super) flats: Holders,
    /// The segments of each carrier. Entries of facets are meaningless.
    pub(super) lines: Holders,
    pub(super) vertices: Vertices<P>,
    pub(super) stages: Vec<StageCounts>,
    /// The balls of subsegments.
    pub(super) subsegments: Balls<P>,
    /// The balls of subfacets.
    pub(super) subfacets: Balls<P>,
    /// Further balls in which no points of the volume are placed.
    pub(super) closed: Balls<P>,
    /// Whether circumcentres are moved out of balls.
    pub(super) off_centres: bool,
    /// The radii of the shells around enclosed corners.
    pub(super) shells: BTreeMap<u32, f64>,
}

impl<'a, P: Space, M: MeshMachine<P> + Sync> Generator<'a, P, M> {
    /// Creates the generator, without vertices.
    pub(super) fn new(domain: &'a Domain<P>, rules: Rules<'a, P>, machine: &'a mut M) -> Self {
        let vertices = Vertices { points: Vec::new(), sizes: Vec::new(), carriers: Vec::new() };
        let (holders, lines) = (Holders::new(domain), Holders::of_segments(domain));
        let flats = holders.grouped(&flat_groups(domain));
        let none = || Balls::new(Vec::new());
        let (subsegments, subfacets, closed) = (none(), none(), none());
        Generator {
            domain,
            rules,
            machine,
            holders,
            flats,
            lines,
            vertices,
            stages: Vec::new(),
            subsegments,
            subfacets,
            closed,
            off_centres: false,
            shells: BTreeMap::new(),
        }
    }

    pub(super) fn begin(&mut self, name: &'static str) {
        self.machine.stage(name);
        self.stages.push(StageCounts { name, ..StageCounts::default() });
    }

    /// Places the vertices at these corners.
    pub(super) fn place_corners(&mut self, corners: impl Iterator<Item = u32>) -> Result<(), M::Error> {
        let at = |c: u32| self.domain.points()[self.domain.corners[c as usize] as usize];
        let places = corners.map(|c| (at(c), Carrier::Corner(c))).collect();
        for (site, carrier) in self.sized(places)? {
            self.vertices.push(site, carrier);
        }
        Ok(())
    }

    /// Moves candidates to points that can be written.
    fn snapped(&self, mut candidates: Vec<Candidate<P>>) -> Vec<Candidate<P>> {
        let frame = &self.domain.simplices.frame;
        for c in &mut candidates {
            c.0.at = frame.snapped(c.0.at);
        }
        candidates
    }

    /// Evaluates the size function at points.
    pub(super) fn sized(&self, places: Vec<(P, Carrier)>) -> Result<Vec<Candidate<P>>, M::Error> {
        let points: Vec<At<P>> = places.iter().map(|&(at, _)| At(at)).collect();
        let sizes =
            evaluated(&*self.machine, Part::Sizes, &points, |at, own| self.rules.site_of_lane(at, own))?;
        Ok(places.into_iter().zip(sizes).map(|((at, carrier), size)| (Site { at, size }, carrier)).collect())
    }

    /// Gives the vertices from the first one on the values of the size function as their sizes.
    pub(super) fn size_vertices(&mut self, first: usize) -> Result<(), M::Error> {
        let points: Vec<At<P>> = self.vertices.points[first..].iter().map(|&at| At(at)).collect();
        let sizes =
            evaluated(&*self.machine, Part::Sizes, &points, |at, own| self.rules.site_of_lane(at, own))?;
        self.vertices.sizes[first..].copy_from_slice(&sizes);
        Ok(())
    }

    /// Places the first points of a stage: a maximal independent set of candidates, with all earlier points fixed.
    pub(super) fn sample(&mut self, candidates: Vec<Candidate<P>>) -> Result<(), M::Error> {
        let mut sites = self.vertices.sites();
        let fixed = sites.len();
        let candidates = distinct(self.snapped(candidates));
        sites.extend(candidates.iter().map(|c| c.0));
        self.place(&sites, fixed, &candidates)
    }

    /// Runs a round of completion: places an independent set of the candidates that do not conflict with a vertex,
    /// and returns the number of points placed. If `free` is set, no candidate may conflict with a vertex.
    pub(super) fn complete(&mut self, candidates: Vec<Candidate<P>>, free: bool) -> Result<u64, M::Error> {
        let mut candidates = distinct(self.snapped(candidates));
        if !free && !candidates.is_empty() {
            let sites = self.vertices.sites();
            let earlier = Sites::new(&sites);
            let sites: Vec<Site<P>> = candidates.iter().map(|c| c.0).collect();
            let free = evaluated(&*self.machine, Part::Conflicts, &sites, |site: Site<P>, own| {
                in_sequence(own, |visits| !earlier.any_against_counted(&site, visits))
            })?;
            let mut free = free.into_iter();
            candidates.retain(|_| free.next() == Some(true));
        }
        if candidates.is_empty() {
            return Ok(0);
        }
        let sites: Vec<Site<P>> = candidates.iter().map(|c| c.0).collect();
        let before = self.vertices.len();
        self.place(&sites, 0, &candidates)?;
        if let Some(stage) = self.stages.last_mut() {
            stage.completion += 1;
        }
        Ok((self.vertices.len() - before) as u64)
    }

    fn place(
        &mut self,
        sites: &[Site<P>],
        fixed: usize,
        candidates: &[Candidate<P>],
    ) -> Result<(), M::Error> {
        if candidates.is_empty() {
            return Ok(());
        }
        let set = self.machine.independent(sites, fixed)?;
        for &m in &set.members {
            let (site, carrier) = candidates[m as usize - fixed];
            self.vertices.push(site, carrier);
        }
        if let Some(stage) = self.stages.last_mut() {
            let rounds = set.rounds() as u32;
            stage.candidates += candidates.len() as u64;
            stage.points += set.members.len() as u64;
            stage.set_rounds += rounds;
            stage.longest = stage.longest.max((rounds, candidates.len() as u64));
        }
        Ok(())
    }

    /// Returns the seed of a feature. Features of the same kind have different seeds.
    pub(super) fn seed_of(&self, feature: u32) -> u64 {
        Name { cell: crate::octree::CellKey::ROOT, number: feature }.priority(self.rules.seed).0
    }
}
