//! Points that are forced where features meet at less than 90 degrees.
//!
//! **Statement.** A piece (a triangle) is *missing* if it is no edge (no face) of the Delaunay triangulation. As long as
//! there are any, missing pieces are divided, and missing triangles get their circumcentre; where that lies in the ball
//! of a piece, the piece is divided instead. Points are placed although they are closer to others than f. Without
//! angles below 90 degrees nothing is missing when the stage begins.
//!
//! **Termination.** Pieces at a corner are divided at a distance from it that is a power of two, so that those of
//! all segments there end on common spheres, whatever their angle (Ruppert's concentric shells): pieces between the
//! same two spheres leave each other's ends outside. Triangles that share an edge with a segment's piece cannot be driven
//! out by points of the other facets around it: the sphere through a piece and one apex on each of two facets meets either
//! plane in a circumcircle, which is empty. For the others no proof is known for all angles, so rounds are limited, and what
//! is missing at the end is an error with the features that cause it.
//!
//! **Source.** Ruppert (1995), section 5; Shewchuk (2002), conforming triangulations; Cohen-Steiner, Colin de Verdiere
//! and Yvinec (2004).

use glam::DVec2;
use septet_geometry::incremental::facet_without;
use septet_geometry::point::{Simplex, dist2};

use super::balls::{Ball, Balls};
use super::cells::is_flat;
use super::facets::{Plane, Triangles, circumcircle, from_space};
use super::machine::{Machine, Triangulation};
use super::segments::Chains;
use super::witness::Near;
use super::work::Work;
use super::{Failure, Missing};
use crate::domain::Feature;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// Rounds before the generator gives up.
const MOST_ROUNDS: u32 = 100;

/// What a triangulation lacks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Lacking {
    /// Segments, and the ends of pieces.
    pub(super) pieces: Vec<(u32, [u32; 2])>,
    /// Facets, and the corners of triangles.
    pub(super) triangles: Vec<(u32, [u32; 3])>,
}

impl Lacking {
    pub(super) fn is_empty(&self) -> bool {
        self.pieces.is_empty() && self.triangles.is_empty()
    }

    /// The features, each once, with the number of pieces or triangles of each.
    pub(super) fn features(&self) -> Vec<(Feature, u32)> {
        let segments = self.pieces.iter().map(|p| Feature::Segment(p.0));
        let mut all: Vec<Feature> =
            segments.chain(self.triangles.iter().map(|t| Feature::Facet(t.0))).collect();
        all.sort_unstable();
        all.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect()
    }
}

impl<P: Space, M: Machine<P> + Sync> Work<'_, P, M> {
    /// Forces points until nothing is missing. The chains and triangles that are then in the triangulation.
    pub(super) fn force(
        &mut self,
        planes: &[Plane],
        mut chains: Chains,
        triangles: Triangles,
    ) -> Result<(Chains, Triangles), Failure<M::Error>> {
        let mut by_facet = vec![Vec::new(); planes.len()];
        triangles.into_iter().for_each(|(f, t)| by_facet[f as usize].push(t));
        for round in 0.. {
            let triangles = listed(&by_facet);
            let forced = match self.unwitnessed(planes, &chains, &triangles, width(round)) {
                Ok(witnesses) => {
                    let delaunay = self.machine.delaunay(&self.vertices.points).map_err(Failure::Machine)?;
                    let lacking = self.lacking(&delaunay, planes, &chains, &triangles);
                    if lacking.is_empty() {
                        self.triangles = Balls::new(self.balls_of_triangles(&triangles));
                        self.closed = Balls::new(witnesses);
                        return Ok((chains, triangles));
                    }
                    if std::env::var("DBG").is_ok() {
                        eprintln!("lacking {:?}", lacking.features());
                    }
                    self.divided(planes, &chains, &lacking)
                }
                Err(lacking) => {
                    if std::env::var("DBG").is_ok() {
                        let f = lacking.features();
                        eprintln!("round {round} {} pieces {} triangles of {}: {:?}", lacking.pieces.len(), lacking.triangles.len(), f.len(), &f[..f.len().min(5)]);
                    }
                    if round == MOST_ROUNDS || self.vertices.len() as u64 > self.rules.most {
                        return Err(Failure::Missing(Missing { features: lacking.features() }));
                    }
                    self.divided(planes, &chains, &lacking)
                }
            };
            if round == 0 {
                self.begin("force");
            }
            let before = self.vertices.len();
            self.complete_forced(forced).map_err(Failure::Machine)?;
            let stale = self.facets_of(&self.vertices.carriers[before..]);
            chains = self.chains();
            self.pieces = Balls::new(self.balls_of_pieces(&chains));
            self.triangulate_facets(planes, &chains, &stale, &mut by_facet).map_err(Failure::Machine)?;
        }
        Ok((chains, Vec::new()))
    }

    /// The facets that hold these.
    fn facets_of(&self, carriers: &[Carrier]) -> Vec<u32> {
        let mut facets: Vec<u32> =
            if P::DIM == 2 { Vec::new() } else { carriers.iter().flat_map(|c| self.holders.of(c)).copied().collect() };
        facets.sort_unstable();
        facets.dedup();
        facets
    }

    /// The witnesses of triangles whose smallest ball is none; or else what has no witness.
    fn unwitnessed(
        &self,
        planes: &[Plane],
        chains: &Chains,
        triangles: &Triangles,
        widest: f64,
    ) -> Result<Vec<Ball<P>>, Lacking> {
        let _ = planes;
        let near = Near::new(&self.vertices.points);
        let pieces = pieces_of(chains);
        let empty = self.machine.map(&pieces, |&(_, [a, b])| {
            let [p, q] = [a, b].map(|v| self.vertices.points[v as usize]);
            near.is_empty(&Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) })
        });
        let pieces: Vec<(u32, [u32; 2])> =
            pieces.into_iter().zip(empty).filter(|(_, empty)| !empty).map(|(piece, _)| piece).collect();
        if !pieces.is_empty() {
            return Err(Lacking { pieces, triangles: Vec::new() });
        }
        let found = self.machine.map(triangles, |(_, t)| {
            near.witness(t.map(|v| self.vertices.points[v as usize]), widest)
        });
        let lacking: Triangles =
            triangles.iter().zip(&found).filter(|(_, found)| found.is_none()).map(|(t, _)| *t).collect();
        if lacking.is_empty() {
            return Ok(found.into_iter().flatten().collect());
        }
        Err(Lacking { pieces: Vec::new(), triangles: lacking })
    }

    /// Where what is missing is divided; the size of a site is the radius of what it divides.
    fn divided(&self, planes: &[Plane], chains: &Chains, lacking: &Lacking) -> Vec<(Site<P>, Carrier)> {
        let mut forced: Vec<(Site<P>, Carrier)> =
            lacking.pieces.iter().map(|&(s, piece)| self.halved(s, piece)).collect();
        let pieces = pieces_of(chains);
        for &(f, t) in &lacking.triangles {
            let plane = &planes[f as usize];
            let [a, b, c] = t.map(|v| self.vertices.points[v as usize]);
            let Ball { centre, radius2 } = circumcircle(a, b, c);
            let flat = |p: P| plane.of(super::facets::as_space(p));
            let own = |s: u32| self.holders.of(&Carrier::Segment(s)).contains(&f);
            let own: Vec<&(u32, [u32; 2])> = pieces.iter().filter(|p| own(p.0)).collect();
            let ends: Vec<[DVec2; 2]> =
                own.iter().map(|p| p.1.map(|v| flat(self.vertices.points[v as usize]))).collect();
            let behind = first_crossed(&ends, [flat((a + b + c) / 3.0), flat(centre)]).map(|i| own[i]);
            let held = || self.pieces.holding(centre).first().map(|&i| &pieces[i as usize]);
            if let Some(&(s, piece)) = behind.or_else(held) {
                forced.push(self.halved(s, piece));
                continue;
            }
            if std::env::var("DBG").is_ok() && lacking.triangles.len() < 3 {
                let near = Near::new(&self.vertices.points);
                eprintln!("  facet {f} {t:?} r {:e} sides {:?} carriers {:?} centre {centre:?} own {:?}", radius2.sqrt(), [dist2(a,b).sqrt(), dist2(b,c).sqrt(), dist2(c,a).sqrt()], t.map(|v| self.vertices.carriers[v as usize]), self.domain.facets[f as usize].boundary.iter().map(|s| (s, &self.domain.segments[*s as usize].facets)).collect::<Vec<_>>());
                for (v, p) in self.vertices.points.iter().enumerate() { if (Ball { centre, radius2: radius2 * 1.01}).holds(*p) { eprintln!("      near {v} {:?} depth {:e} height {:e} {p:?}", self.vertices.carriers[v], 1.0 - (dist2(centre, *p)/radius2).sqrt(), { let n = P::hull_normal(&[b - a, c - a]); n.dot(*p - a) / n.norm2().sqrt() }); } }
                let _ = near;
            }
            let at = from_space(plane.lift(flat(centre)));
            forced.push((Site { at, size: radius2.sqrt() }, Carrier::Facet(f)));
        }
        forced
    }

    /// The place that divides a piece.
    fn halved(&self, s: u32, [a, b]: [u32; 2]) -> (Site<P>, Carrier) {
        let (p, q) = (self.vertices.points[a as usize], self.vertices.points[b as usize]);
        let length = dist2(p, q).sqrt();
        let is_corner = |v: u32| matches!(self.vertices.carriers[v as usize], Carrier::Corner(_));
        let t = match (is_corner(a), is_corner(b)) {
            (true, false) => shell(length),
            (false, true) => 1.0 - shell(length),
            _ => 0.5,
        };
        let at = p + (q - p) * t;
        (Site { at, size: 0.25 * length }, Carrier::Segment(s))
    }

    /// Places forced points as far as they are independent, with the sizes of the function.
    fn complete_forced(&mut self, forced: Vec<(Site<P>, Carrier)>) -> Result<u64, M::Error> {
        let before = self.vertices.len();
        let placed = self.complete(forced, true)?;
        for v in before..self.vertices.len() {
            self.vertices.sizes[v] = (self.rules.size)(self.vertices.points[v]);
        }
        Ok(placed)
    }

    /// What is not in the triangulation.
    pub(super) fn lacking(
        &self,
        delaunay: &Triangulation<P::Cell>,
        planes: &[Plane],
        chains: &Chains,
        triangles: &Triangles,
    ) -> Lacking {
        let (edges, faces) = self.carried(delaunay);
        let pieces = (0u32..).zip(chains).flat_map(|(s, c)| c.windows(2).map(move |w| (s, [w[0], w[1]])));
        let absent = |&(_, [a, b]): &(u32, [u32; 2])| edges.binary_search(&[a.min(b), a.max(b)]).is_err();
        let pieces = pieces.filter(absent).collect();
        let absent = |(_, t): &&(u32, [u32; 3])| {
            let mut t = *t;
            t.sort_unstable();
            faces.binary_search(&t).is_err()
        };
        let mut missing: Triangles = triangles.iter().filter(absent).copied().collect();
        missing.sort_unstable();
        let whole = if missing.is_empty() { Vec::new() } else { self.tiled(planes, triangles, &faces) };
        missing.retain(|(f, _)| !whole[*f as usize]);
        Lacking { pieces, triangles: missing }
    }

    /// Edges between vertices of segments, and faces whose vertices one facet holds, beside which there is a cell that
    /// is not flat; ascending.
    fn carried(&self, delaunay: &Triangulation<P::Cell>) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
        let carriers = &self.vertices.carriers;
        let (mut edges, mut faces) = (Vec::new(), Vec::new());
        let on_segment = |v: u32| matches!(carriers[v as usize], Carrier::Corner(_) | Carrier::Segment(_));
        for (cell, across) in delaunay.cells.iter().zip(&delaunay.neighbours) {
            let vertices = cell.as_ref();
            for (i, &a) in vertices.iter().enumerate().filter(|(_, v)| on_segment(**v)) {
                edges.extend(vertices[..i].iter().filter(|&&b| on_segment(b)).map(|&b| [a.min(b), a.max(b)]));
            }
            if P::DIM == 2
                || vertices.iter().filter(|v| carriers[**v as usize] != Carrier::Volume).count() < 3
            {
                continue;
            }
            if is_flat(&self.flats, carriers, vertices) {
                continue;
            }
            for &v in vertices {
                let face = facet_without::<P>(cell, v);
                if !self.holders.common(carriers, face.as_ref()).is_empty() {
                    let mut row = [0; 3];
                    row.copy_from_slice(face.as_ref());
                    row.sort_unstable();
                    faces.push(row);
                }
            }
            debug_assert_eq!(across.as_ref().len(), P::Cell::LEN);
        }
        edges.sort_unstable();
        edges.dedup();
        faces.sort_unstable();
        faces.dedup();
        (edges, faces)
    }

    /// Do the faces that are there tile each facet, although they are not the triangles of its own triangulation? So
    /// it may be where four points lie on a circle as nearly as they can be rounded.
    fn tiled(&self, planes: &[Plane], triangles: &Triangles, faces: &[[u32; 3]]) -> Vec<bool> {
        let area = |f: u32, t: &[u32; 3]| {
            let plane = &planes[f as usize];
            let [a, b, c] = t.map(|v| plane.of(super::facets::as_space(self.vertices.points[v as usize])));
            (b - a).perp_dot(c - a).abs()
        };
        let (mut there, mut whole) = (vec![0.0; planes.len()], vec![0.0; planes.len()]);
        for face in faces {
            if let Some(f) = self.facet_of(face, planes) {
                there[f as usize] += area(f, face);
            }
        }
        for (f, t) in triangles {
            whole[*f as usize] += area(*f, t);
        }
        there
            .iter()
            .zip(&whole)
            .map(|(there, whole): (&f64, &f64)| (there - whole).abs() <= 1e-12 * whole)
            .collect()
    }
}

/// All pieces with their segments.
fn pieces_of(chains: &Chains) -> Vec<(u32, [u32; 2])> {
    (0u32..).zip(chains).flat_map(|(s, c)| c.windows(2).map(move |w| (s, [w[0], w[1]]))).collect()
}

/// All triangles with their facets.
fn listed(by_facet: &[Vec<[u32; 3]>]) -> Triangles {
    (0u32..).zip(by_facet).flat_map(|(f, t)| t.iter().map(move |t| (f, *t))).collect()
}

/// The first of some segments of the plane that a way crosses.
fn first_crossed(segments: &[[DVec2; 2]], [from, to]: [DVec2; 2]) -> Option<usize> {
    let crossed = |(i, [p, q]): (usize, &[DVec2; 2])| {
        let beside = |x: DVec2| (*q - *p).perp_dot(x - *p);
        let along = |x: DVec2| (to - from).perp_dot(x - from);
        let (s, t) = (beside(from), beside(to));
        ((s > 0.0) != (t > 0.0) && (along(*p) > 0.0) != (along(*q) > 0.0)).then(|| (s / (s - t), i))
    };
    let crossed = segments.iter().enumerate().filter_map(crossed);
    crossed.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

/// How wide witnesses may be.
fn width(round: u32) -> f64 {
    let omega: f64 = std::env::var("OMEGA").map_or(1.25, |x| x.parse().unwrap());
    if round < 30 { omega } else { omega * f64::from(round - 28) }
}

/// Where a piece that begins at a corner is divided: at the power of two nearest to half of its length, as a part of it.
fn shell(length: f64) -> f64 {
    let half = 0.5 * length;
    let below = f64::from_bits(half.to_bits() >> 52 << 52);
    let power = if half > below * std::f64::consts::SQRT_2 { 2.0 * below } else { below };
    power / length
}
