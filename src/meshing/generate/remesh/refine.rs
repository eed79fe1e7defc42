//! The refinement of surface and volume.

use crate::generate::remesh::chord::Chord;
use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::incremental::facet_without;
use septet_geometry::point::{dist2, lex_cmp};
use septet_geometry::range::scale;

use super::deviation::{of_faces, of_vertices};
use super::features::SurfaceFeatures;
use super::options::{DEFAULT_DISTANCE, Options};
use super::refinement::{Refinement, edges_of};
use super::restricted::{Restricted, RestrictedFace};
use super::surface::{Surface, WallPart, quarters};
use super::thin_sheets::{THIN, THINNEST};
use super::topology::{crowded, lost, unfaced, useful};
use crate::angles::cosine;
use crate::bvh::Bvh;
use crate::conformity::LOOSE;
use crate::domain::{Domain, Feature};
use crate::executor::{Part, evaluated, in_sequence};
use crate::generate::balls::{Ball, Balls};
use crate::generate::generator::{Candidate, Generator};
use crate::generate::machine::MeshMachine;
use crate::generate::subdivision::divided;
use crate::generate::volume::{CELLS, sampling_cells};
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
        let scaled = |d| scale(P::splat(d), generator.domain.simplices.frame.exponent).coord(0);
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
    pub(super) fn distance_at(&self, at: P, visits: &mut Sweep) -> f64 {
        self.distance.unwrap_or_else(|| DEFAULT_DISTANCE * self.generator.rules.size.at_counted(at, visits))
    }

    /// Returns the candidates of all walls, outside the balls of chords. Returns `None` if there are more than
    /// [`CELLS`] per vertex allowed.
    fn wall_candidates(&self) -> Result<Option<Vec<Candidate<P>>>, M::Error> {
        let generator = &self.generator;
        let (machine, most) = (&*generator.machine, generator.rules.most.saturating_mul(CELLS));
        let decide = |part: WallPart, own: &mut Cost| {
            in_sequence(own, |visits| self.surface.decide_part(part, &generator.rules, visits))
        };
        let roots = self.surface.roots();
        // Small walls have no candidates.
        let most = most.saturating_add(roots.len() as u64);
        let leaves = divided(machine, (&roots, 4, most), quarters, decide)?;
        let Some(mut leaves): Option<Vec<(WallPart, f64)>> = leaves else { return Ok(None) };
        leaves.sort_by_key(|((wall, _), _)| *wall);
        let places = evaluated(machine, Part::Candidates, &leaves, |(part, size): (WallPart, f64), own| {
            let mut found = self.surface.candidates(part, size, generator.seed_of(part.0));
            in_sequence(own, |visits| {
                found.retain(|at| !generator.subsegments.hold_counted(at.0, visits));
            });
            found
        })?;
        let found = leaves.iter().zip(places).flat_map(|(((wall, _), _), places)| {
            places.into_iter().map(|at| (at.0, self.surface.carrier(*wall)))
        });
        generator.sized(found.collect()).map(Some)
    }

    /// Runs all stages.
    pub(super) fn run(mut self) -> Result<GeneratedMesh<P>, GenerationError<M::Error>> {
        self.ridges()?;
        self.generator.begin("surface");
        let most = self.generator.rules.most;
        let found = self.wall_candidates().map_err(GenerationError::Machine)?;
        let found = found.ok_or(GenerationError::TooMany(most))?;
        self.generator.sample(found).map_err(GenerationError::Machine)?;
        let made = self.refined(false)?;
        self.generator.subfacets = Balls::new(made.faces.iter().map(ball).collect());
        self.generator.begin("volume");
        let cells = sampling_cells(self.generator.domain, &self.generator.rules, &*self.generator.machine)
            .map_err(GenerationError::Machine)?;
        let cells = cells.ok_or(GenerationError::TooMany(most))?;
        let found = self.generator.volume_candidates(&cells).map_err(GenerationError::Machine)?;
        self.generator.sample(found).map_err(GenerationError::Machine)?;
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
        self.generator.size_vertices(before).map_err(GenerationError::Machine)?;
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
            let mut found = self.coarse(&made).map_err(GenerationError::Machine)?;
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
                found = self.large_cells(&made).map_err(GenerationError::Machine)?;
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
                return Err(GenerationError::Missing(missing(self.generator.domain, &stuck, false)));
            }
            found = self.unmet(&found)?;
            last.clone_from(&found);
            self.insert(found)?;
            self.make_chords();
        }
        Err(GenerationError::Missing(missing(self.generator.domain, &last, false)))
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
        let frame = &self.generator.domain.simplices.frame;
        let is_new = |c: &&Candidate<P>| {
            let at = frame.snapped(c.0.at);
            points.binary_search_by(|p| lex_cmp(p, &at)).is_err()
        };
        let new: Vec<_> = candidates.iter().filter(is_new).copied().collect();
        if new.is_empty() && !candidates.is_empty() {
            return Err(GenerationError::Missing(missing(self.generator.domain, candidates, true)));
        }
        Ok(new)
    }

    /// Returns the candidate for the centre of an empty surface ball: the midpoint of a chord whose ball contains it,
    /// or the point itself.
    pub(super) fn on_surface(&self, face: &RestrictedFace<P>) -> Candidate<P> {
        let at = face.place.at;
        let size = face.radius.min(self.generator.rules.size.at(at));
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
    fn coarse(&self, made: &Restricted<P>) -> Result<Vec<Candidate<P>>, M::Error> {
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
        let coarse = evaluated(&*self.generator.machine, Part::Completion, &numbers, |f: u32, own| {
            in_sequence(own, |visits| self.is_coarse_face(made, &made.faces[f as usize], visits))
        })?;
        let coarse = made.faces.iter().zip(coarse).filter(|(_, coarse)| *coarse);
        found.extend(coarse.map(|(face, _)| self.on_surface(face)));
        Ok(found)
    }

    fn is_coarse_face(&self, made: &Restricted<P>, face: &RestrictedFace<P>, visits: &mut Sweep) -> bool {
        let vertices = &self.generator.vertices;
        if made.is_shared(face)
            || face.vertices.iter().any(|&v| vertices.carriers[v as usize] == Carrier::Volume)
        {
            return true;
        }
        let at = face.place.at;
        let largest = face.vertices.iter().map(|&v| vertices.sizes[v as usize]).fold(0.0, f64::max);
        let distance = self.distance_at(at, visits);
        if self.generator.rules.is_too_large(at, face.radius, largest, visits)
            || dist2(at, face.centre) > distance * distance
        {
            return true;
        }
        let [a, b, c] = face.vertices.map(|v| vertices.points[v as usize]);
        let turned = cosine(P::hull_normal(&[b - a, c - a]), face.place.normal).abs() < TURN;
        turned && face.radius > TURNED * self.generator.rules.size.at_counted(at, visits)
            || self.is_wide(face)
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

/// Returns the surface ball of a face.
pub(super) fn ball<P: Space>(face: &RestrictedFace<P>) -> Ball<P> {
    Ball { centre: face.place.at, radius2: face.radius * face.radius }
}

/// Returns the features on which candidates lie, with the number of candidates on each.
fn missing<P: Space>(domain: &Domain<P>, candidates: &[Candidate<P>], is_rounded: bool) -> Missing {
    let mut features: BTreeMap<Feature, u32> = BTreeMap::new();
    for (_, carrier) in candidates {
        if let Some(feature) = carrier.feature() {
            *features.entry(feature).or_default() += 1;
        }
    }
    Missing::of(domain, features.into_iter().collect(), is_rounded)
}
