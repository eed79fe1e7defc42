//! The refinement of surface and volume.

use crate::generate::remesh::chord::Chord;
use std::collections::BTreeMap;

use septet_geometry::incremental::facet_without;
use septet_geometry::point::{Point, dist2, lex_cmp};
use septet_geometry::range::scale;

use super::deviation::{of_faces, of_vertices};
use super::features::SurfaceFeatures;
use super::options::{DEFAULT_DISTANCE, Options};
use super::refinement::{Refinement, edges_of};
use super::restricted::{Restricted, RestrictedFace};
use super::surface::Surface;
use super::thin_sheets::{THIN, THINNEST};
use super::topology::{crowded, lost, unfaced, useful};
use crate::angles::cosine;
use crate::bvh::Bvh;
use crate::conformity::LOOSE;
use crate::domain::Feature;
use crate::generate::balls::{Ball, Balls};
use crate::generate::generator::{Candidate, Generator};
use crate::generate::machine::MeshMachine;
use crate::generate::volume::sampling_cells;
use crate::generate::{GeneratedMesh, GenerationError, Missing};
use crate::manifold::euler;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::{Space, ascending};

/// The maximum number of rounds of a stage.
const ROUNDS: u32 = 150;

/// The cosine of the largest angle between a face and the surface at s. It applies while the ball of the face exceeds
/// [`TURNED`] times f.
const TURN: f64 = 0.5;
const TURNED: f64 = 0.02;

/// The size below which a fault is not refined further, relative to the diagonal of the surface. Ridges or sheets
/// that meet at small angles cause such faults.
const SMALLEST: f64 = 1e-6;

/// The limit for the refinement of a boundary with a wrong number of handles: the maximum number of vertices,
/// relative to the first such boundary without other faults.
const MORE: usize = 2;

/// The maximum number of times that vertices without a face are removed. Vertices that recur later are kept.
const TAKEN: u32 = 3;

impl<'a, P: Space, M: MeshMachine<P> + Sync> Refinement<'a, P, M> {
    pub(super) fn new(
        generator: Generator<'a, P, M>,
        features: &'a SurfaceFeatures,
        options: Options,
    ) -> Self {
        let mut ridge_of = vec![None; generator.domain.segments.len()];
        for (r, ridge) in (0u32..).zip(&features.ridges) {
            (0u32..).zip(&ridge.segments).for_each(|(i, &s)| ridge_of[s as usize] = Some((r, i)));
        }
        let surface = Surface::new(generator.domain);
        let scaled = |d| scale(P::splat(d), generator.domain.simplices.exponent).coord(0);
        let distance = options.distance.map(scaled);
        let (chords, chord_tree, at_corners) = (Vec::new(), Bvh::new(Vec::new()), Vec::new());
        let (thinnest, euler) = (THIN, euler(generator.domain.triangles()));
        Refinement {
            generator,
            features,
            surface,
            distance,
            ridge_of,
            thinnest,
            euler,
            whole: None,
            chords,
            at_corners,
            chord_tree,
        }
    }

    /// Returns the largest distance allowed at a point.
    pub(super) fn distance_at(&self, at: P) -> f64 {
        self.distance.unwrap_or_else(|| DEFAULT_DISTANCE * (self.generator.rules.size)(at))
    }

    /// Runs all stages.
    pub(super) fn run(mut self) -> Result<GeneratedMesh<P>, GenerationError<M::Error>> {
        self.ridges()?;
        self.generator.begin("surface");
        let walls: Vec<u32> = (0..self.surface.walls()).collect();
        let found = self.generator.machine.map(&walls, |&w| {
            let made = self.surface.candidates(w, &self.generator.rules, self.generator.seed_of(w));
            Some(made?.into_iter().filter(|(site, _)| !self.generator.subsegments.hold(site.at)).collect())
        });
        let most = self.generator.rules.most;
        let found: Option<Vec<Vec<Candidate<P>>>> = found.into_iter().collect();
        let found = found.ok_or(GenerationError::TooMany(most))?;
        self.generator.sample(found.into_iter().flatten().collect()).map_err(GenerationError::Machine)?;
        let made = self.refined(false)?;
        self.generator.subfacets = Balls::new(made.faces.iter().map(ball).collect());
        self.generator.begin("volume");
        let cells = sampling_cells(self.generator.domain, &self.generator.rules, &*self.generator.machine)
            .ok_or(GenerationError::TooMany(most))?;
        let found =
            self.generator.machine.map(&cells, |(cell, whole)| self.generator.candidates_of(cell, *whole));
        self.generator.sample(found.into_iter().flatten().collect()).map_err(GenerationError::Machine)?;
        let made = self.refined(true)?;
        Ok(self.finished(made))
    }

    fn finished(self, mut made: Restricted<P>) -> GeneratedMesh<P> {
        let Generator { mut vertices, stages, .. } = self.generator;
        let face = |f: &RestrictedFace<P>| {
            let cell = &made.delaunay.cells[f.cells[0] as usize];
            let apex = cell.as_ref().iter().copied().find(|v| !f.vertices.contains(v)).unwrap_or_default();
            let facet = facet_without::<P>(cell, apex);
            (f.place.facet, facet, [f.cells[0], u32::MAX])
        };
        let mut faces: Vec<_> = made.faces.iter().map(face).collect();
        let mut subsegments: Vec<_> = self.chords.iter().map(|c| (c.segment, c.ends)).collect();
        let kept = unfaced(&mut vertices.carriers, &made);
        if kept.contains(&false) {
            let mut next = 0;
            let number = |k: &bool| {
                next += u32::from(*k);
                next - u32::from(*k)
            };
            let number: Vec<u32> = kept.iter().map(number).collect();
            let renumbered = |v: &mut u32| *v = number[*v as usize];
            faces.iter_mut().flat_map(|f| f.1.as_mut()).for_each(renumbered);
            subsegments.iter_mut().flat_map(|p| &mut p.1).for_each(renumbered);
            made.delaunay.cells.iter_mut().flat_map(AsMut::as_mut).for_each(renumbered);
            vertices.keep(&kept);
        }
        faces.sort_unstable();
        let Restricted { delaunay, labels, .. } = made;
        GeneratedMesh { vertices, delaunay, labels, faces, subsegments, stages }
    }

    /// Inserts an independent set of candidates, with the values of the size function as their sizes.
    pub(super) fn insert(&mut self, candidates: Vec<Candidate<P>>) -> Result<(), GenerationError<M::Error>> {
        let before = self.generator.vertices.len();
        self.generator.complete(candidates, true).map_err(GenerationError::Machine)?;
        for v in before..self.generator.vertices.len() {
            self.generator.vertices.sizes[v] = (self.generator.rules.size)(self.generator.vertices.points[v]);
        }
        if self.generator.vertices.len() as u64 > self.generator.rules.most {
            return Err(GenerationError::TooMany(self.generator.rules.most));
        }
        Ok(())
    }

    /// Refines until there are no faults. Faults are handled in this order: faces and chords, violations of the
    /// manifold property, cells, and the requested distance.
    fn refined(&mut self, volume: bool) -> Result<Restricted<P>, GenerationError<M::Error>> {
        let (mut last, mut taken) = (Vec::new(), 0);
        for _ in 0..ROUNDS {
            let delaunay = self
                .generator
                .machine
                .delaunay(&self.generator.vertices.points)
                .map_err(GenerationError::Machine)?;
            let made = Restricted::new(&self.generator, &self.surface, delaunay);
            let mut found = self.coarse(&made);
            if found.is_empty() {
                found = crowded(self, &made);
            }
            if found.is_empty() {
                found = lost(self, &made);
            }
            if found.is_empty() && taken < TAKEN {
                let useful = useful(&made, &self.generator.vertices.carriers);
                if useful.contains(&false) {
                    taken += 1;
                    self.generator.vertices.keep(&useful);
                    self.make_chords();
                    continue;
                }
            }
            if found.is_empty() && self.divides_sheets(&made) {
                continue;
            }
            if found.is_empty() && volume {
                found = self.cells(&made);
            }
            if found.is_empty() && volume {
                found = self.distant(&made);
            }
            if found.is_empty() {
                return Ok(made);
            }
            let limit = SMALLEST * self.surface.diagonal();
            let stuck: Vec<_> = found.iter().copied().filter(|(site, _)| site.size <= limit).collect();
            if !stuck.is_empty() {
                return Err(GenerationError::Missing(missing(&stuck)));
            }
            found = self.unmet(&found)?;
            last.clone_from(&found);
            self.insert(found)?;
            self.make_chords();
        }
        Err(GenerationError::Missing(missing(&last)))
    }

    /// Halves the limit for thin sheets if the boundary and the surface have different numbers of handles and there
    /// are not too many points yet.
    fn divides_sheets(&mut self, made: &Restricted<P>) -> bool {
        if self.thinnest <= THINNEST || euler(made.faces.iter().map(|f| f.vertices)) == self.euler {
            return false;
        }
        let now = self.generator.vertices.len();
        if now > MORE * *self.whole.get_or_insert(now) {
            return false;
        }
        self.thinnest *= 0.5;
        true
    }

    /// Returns the candidates that are not vertices yet. Fails if all candidates are vertices.
    fn unmet(&self, candidates: &[Candidate<P>]) -> Result<Vec<Candidate<P>>, GenerationError<M::Error>> {
        let mut points = self.generator.vertices.points.clone();
        points.sort_unstable_by(lex_cmp);
        let is_new = |c: &&Candidate<P>| points.binary_search_by(|p| lex_cmp(p, &c.0.at)).is_err();
        let new: Vec<_> = candidates.iter().filter(is_new).copied().collect();
        if new.is_empty() && !candidates.is_empty() {
            return Err(GenerationError::Missing(missing(candidates)));
        }
        Ok(new)
    }

    /// Returns the candidate for the centre of an empty surface ball: the midpoint of a chord whose ball contains it,
    /// or the point itself.
    pub(super) fn on_surface(&self, face: &RestrictedFace<P>) -> Candidate<P> {
        let at = face.place.at;
        let size = face.radius.min((self.generator.rules.size)(at));
        self.at_surface(Site { at, size }, face.place.facet)
    }

    /// Returns a site on a facet, or the midpoint of a chord whose ball contains it.
    pub(super) fn at_surface(&self, site: Site<P>, facet: u32) -> Candidate<P> {
        match self.generator.subsegments.holding(site.at).first() {
            Some(&c) => self.chords[c as usize].candidate(),
            None => (site, Carrier::Facet(facet)),
        }
    }

    /// Returns candidates for chords that are not edges of the boundary, and for coarse faces. A face is coarse if it
    /// is too large, too far from the surface, turned away from it, or has a vertex off the surface.
    fn coarse(&self, made: &Restricted<P>) -> Vec<Candidate<P>> {
        let mut edges: Vec<[u32; 2]> = made.faces.iter().flat_map(|f| edges_of(f.vertices)).collect();
        edges.sort_unstable();
        let is_missing = |c: &&Chord<P>| edges.binary_search(&ascending(c.ends)).is_err();
        let mut missing_chords: Vec<&Chord<P>> = self.chords.iter().filter(is_missing).collect();
        missing_chords.sort_unstable_by_key(|c| ascending(c.ends));
        let ends: Vec<[u32; 2]> = missing_chords.iter().map(|c| ascending(c.ends)).collect();
        let rings = if ends.is_empty() {
            Vec::new()
        } else {
            made.crossed_twice(&self.generator, &self.surface, &ends)
        };
        let mut found: Vec<Candidate<P>> = missing_chords
            .iter()
            .zip(&rings)
            .flat_map(|(chord, ring)| self.for_chord(chord, ring.as_ref()))
            .collect();
        let numbers: Vec<u32> = (0..made.faces.len() as u32).collect();
        let decided = self.generator.machine.map(&numbers, |&f| {
            let face = &made.faces[f as usize];
            self.is_coarse_face(made, face).then(|| self.on_surface(face))
        });
        found.extend(decided.into_iter().flatten());
        found
    }

    fn is_coarse_face(&self, made: &Restricted<P>, face: &RestrictedFace<P>) -> bool {
        let vertices = &self.generator.vertices;
        if made.is_shared(face)
            || face.vertices.iter().any(|&v| vertices.carriers[v as usize] == Carrier::Volume)
        {
            return true;
        }
        let at = face.place.at;
        let largest = face.vertices.iter().map(|&v| vertices.sizes[v as usize]).fold(0.0, f64::max);
        let distance = self.distance_at(at);
        if self.generator.rules.is_too_large(at, face.radius, largest)
            || dist2(at, face.centre) > distance * distance
        {
            return true;
        }
        let [a, b, c] = face.vertices.map(|v| vertices.points[v as usize]);
        let turned = cosine(P::hull_normal(&[b - a, c - a]), face.place.normal).abs() < TURN;
        turned && face.radius > TURNED * (self.generator.rules.size)(at) || self.is_wide(face)
    }

    /// Returns candidates for the cells inside that are too large.
    fn cells(&self, made: &Restricted<P>) -> Vec<Candidate<P>> {
        let balls = Balls::new(made.faces.iter().map(ball).collect());
        let numbers: Vec<u32> = (0..made.delaunay.cells.len() as u32).collect();
        let chunks: Vec<&[u32]> = numbers.chunks(4096).collect();
        let one = |&i: &u32| self.centre_of(made, &balls, i);
        let found =
            self.generator.machine.map(&chunks, |chunk| chunk.iter().filter_map(one).collect::<Vec<_>>());
        found.into_iter().flatten().collect()
    }

    fn centre_of(&self, made: &Restricted<P>, balls: &Balls<P>, i: u32) -> Option<Candidate<P>> {
        if !made.labels.is_inside(i) {
            return None;
        }
        let (cell, centre) = (&made.delaunay.cells[i as usize], made.centres[i as usize]);
        let vertices = &self.generator.vertices;
        let largest = cell.as_ref().iter().map(|&v| vertices.sizes[v as usize]).fold(0.0, f64::max);
        // The smallest vertex is used, so that the result does not depend on the order that a machine returns.
        let first = cell.as_ref().iter().copied().min().unwrap_or_default();
        let radius = dist2(centre, vertices.points[first as usize]).sqrt();
        if !self.generator.rules.is_too_large(centre, radius, largest) {
            return None;
        }
        let held = balls.holding(centre).into_iter().map(|f| &made.faces[f as usize]);
        if let Some(face) =
            held.max_by(|a, b| a.radius.total_cmp(&b.radius).then(b.vertices.cmp(&a.vertices)))
        {
            return Some(self.on_surface(face));
        }
        Some(match self.generator.subsegments.holding(centre).first() {
            Some(&c) => self.chords[c as usize].candidate(),
            None => (self.generator.rules.site(centre), Carrier::Volume),
        })
    }

    /// Returns candidates where boundary and surface are too far from each other: the points s of faces, and vertices
    /// of the surface.
    fn distant(&self, made: &Restricted<P>) -> Vec<Candidate<P>> {
        let (machine, points) = (&*self.generator.machine, &self.generator.vertices.points);
        let sizes = &self.generator.vertices.sizes;
        let limit = |row: usize| {
            let sizes = made.faces[row].vertices.map(|v| sizes[v as usize]);
            self.distance.unwrap_or(LOOSE * sizes[0].max(sizes[1]).max(sizes[2]))
        };
        let faces: Vec<[P; 3]> = made.faces.iter().map(|f| f.vertices.map(|v| points[v as usize])).collect();
        let far = of_faces(machine, &self.surface, &faces);
        let vertices = of_vertices(machine, self.generator.domain, &faces);
        let faces = made.faces.iter().zip(far).enumerate().filter(|(row, (_, d))| *d > limit(*row));
        let mut found: Vec<Candidate<P>> = faces.map(|(_, (f, _))| self.on_surface(f)).collect();
        for (d, at, row) in vertices {
            if d > limit(row)
                && let Some(place) = self.surface.nearest(at)
            {
                found.push(self.at_surface(Site { at, size: d }, place.facet));
            }
        }
        found
    }
}

fn ball<P: Space>(face: &RestrictedFace<P>) -> Ball<P> {
    Ball { centre: face.place.at, radius2: face.radius * face.radius }
}

/// Returns the features on which candidates lie, with the number of candidates on each.
fn missing<P: Point>(candidates: &[Candidate<P>]) -> Missing {
    let mut features: BTreeMap<Feature, u32> = BTreeMap::new();
    for (_, carrier) in candidates {
        if let Some(feature) = carrier.feature() {
            *features.entry(feature).or_default() += 1;
        }
    }
    Missing { features: features.into_iter().collect() }
}
