//! Stars of dimensions 4 to 6: the link as a list of facets.
//!
//! **Statement.** As in [`super`]. A candidate is tested against all facets, which then lose its cavity. A ridge of exactly
//! one facet of the cavity bounds it, and this facet's other vertex gives way to the candidate.
//!
//! **The rounded test.** Vectors from the centre are multiplied by a power of two that brings all candidates of the star
//! into the unit cube. Let a facet and the centre have the sphere `v . r = w |r|^2` ([`general::plane`]). A candidate
//! conflicts iff `v . r - w |r|^2 > 0`. The minors `v` and `w` have permanents `V` and `W`, so the sign is certain if the
//! absolute value exceeds `1.05 k u (V . |r| + W |r|^2)`, by the proof of [`general`] with its counts of roundings. An
//! infinite vertex is the vector 0 with the lift 1, so hull facets need no special case. The other tests are exact.
//!
//! **Reach.** A finite facet conflicts only with candidates nearer than the diameter of its sphere, `|v| / w`. If the
//! remaining candidates are farther than the diameters of all facets, they need no test.
//!
//! **Work and depth.** One sweep over the facets for each candidate, and for each of its cavities a sort of the ridges. For
//! `m` candidates and links of `l` facets: work O(m l log l). `l` is constant under the paper's hypothesis, but grows with
//! the dimension: about 160, 1,100 and 9,000 facets for points in general position.
//!
//! **Departures.** No adjacency is stored. Ridges are matched by sorted vertices.

use crate::complex::INFINITE;
use crate::cost::{Cost, Sweep};
use crate::point::{Array, Point, Simplex, lex_cmp};
use crate::predicates::general::{self, Minor, in_sphere_factor, scale_of};
use crate::predicates::{Sign, in_sphere, orientation, raises_dimension};

/// The origin of a facet that was created.
pub(super) const CREATED: u32 = u32::MAX;

/// A candidate, with its scaled vector from the centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex<P> {
    at: P,
    pub(super) id: u32,
    vector: P,
    square: f64,
}

/// The rounded sphere through the centre and a facet.
#[derive(Clone, Debug)]
struct Sphere<P: Point> {
    /// The normal `v` with its permanents, which include the factor of the bound.
    normal: P::Axes<Minor>,
    /// As `normal`, for `w`.
    w: Minor,
}

impl<P: Point> Sphere<P> {
    /// Computes the sphere of some vertices. Infinity is `None`.
    fn of(vertex: impl Fn(usize) -> Option<Vertex<P>>) -> Self {
        let factor = in_sphere_factor(P::DIM);
        let (mut w, mut normal) = general::plane(|i| match vertex(i) {
            Some(vertex) => (vertex.vector, vertex.square),
            None => (P::default(), 1.0),
        });
        w.size *= factor;
        normal.as_mut().iter_mut().for_each(|minor| minor.size *= factor);
        Sphere { normal, w }
    }

    /// Returns the side of a candidate: a positive number if it conflicts, a negative one if it does not, and 0 if rounded
    /// arithmetic does not decide.
    #[inline]
    fn side(&self, candidate: &Vertex<P>) -> f64 {
        let (mut value, mut bound) = (0.0, 0.0);
        for (axis, minor) in self.normal.as_ref().iter().enumerate() {
            let x = candidate.vector.coord(axis);
            value += minor.value * x;
            bound += minor.size * x.abs();
        }
        value -= self.w.value * candidate.square;
        bound += self.w.size * candidate.square;
        if value.abs() > bound + general::TINY { value } else { 0.0 }
    }

    /// Returns the squared distance from which on no candidate conflicts. Infinite without a sure diameter.
    fn reach2(&self) -> f64 {
        let least = self.w.value - self.w.size - general::TINY;
        if least <= 0.0 {
            return f64::INFINITY;
        }
        // Quotients of small numbers do not underflow as their squares do. A reach that is no normal number is not sure.
        let part = |m: &Minor| ((m.value.abs() + m.size) / least).powi(2);
        let reach2: f64 = self.normal.as_ref().iter().map(part).sum();
        if reach2.is_normal() { reach2 * (1.0 + 64.0 * f64::EPSILON) } else { f64::INFINITY }
    }
}

/// A facet of the link.
#[derive(Clone, Debug)]
pub(super) struct Facet<P: Point> {
    /// Positions of candidates, or [`INFINITE`].
    pub(super) vertices: P::Facet,
    sphere: Sphere<P>,
    reach2: f64,
    /// The position in the loaded link, or [`CREATED`].
    pub(super) origin: u32,
}

/// A link under construction, in reused storage.
#[derive(Debug)]
pub(super) struct General<P: Point> {
    centre: P,
    scale: f64,
    pub(super) vertices: Vec<Vertex<P>>,
    pub(super) facets: Vec<Facet<P>>,
    /// Some facet of the link that was finite, as an affine frame with the centre.
    frame: P::Facet,
    cavity: Vec<u32>,
    /// Ridges with their facet and the slot of the vertex that they lack.
    ridges: Vec<(P::Facet, u32, u32)>,
}

impl<P: Point> Default for General<P> {
    fn default() -> Self {
        General {
            centre: P::default(),
            scale: 1.0,
            vertices: Vec::new(),
            facets: Vec::new(),
            frame: P::Facet::splat(0),
            cavity: Vec::new(),
            ridges: Vec::new(),
        }
    }
}

/// Returns the sorted vertices of a facet without the vertex in a slot. The last entry is 0.
fn ridge<F: Simplex>(facet: &F, slot: usize) -> F {
    let mut ridge = *facet;
    let vertices = ridge.as_mut();
    vertices.swap(slot, F::LEN - 1);
    vertices[F::LEN - 1] = 0;
    vertices[..F::LEN - 1].sort_unstable();
    ridge
}

impl<P: Point> General<P> {
    /// Sets the candidates, in this order, and removes all facets.
    pub(super) fn begin(&mut self, table: &[P], centre: P, candidates: impl Iterator<Item = u32>) {
        self.centre = centre;
        self.facets.clear();
        self.vertices.clear();
        let mut reach = 0.0f64;
        for id in candidates {
            let at = table[id as usize];
            let vector = at - centre;
            (0..P::DIM).for_each(|axis| reach = reach.max(vector.coord(axis).abs()));
            self.vertices.push(Vertex { at, id, vector, square: 0.0 });
        }
        self.scale = scale_of(reach);
        for vertex in &mut self.vertices {
            vertex.vector = vertex.vector * self.scale;
            vertex.square = vertex.vector.norm2();
        }
    }

    pub(super) fn push(&mut self, vertices: P::Facet, origin: u32) {
        let sphere = Sphere::of(|slot| self.vertices.get(vertices.as_ref()[slot] as usize).copied());
        let reach2 = sphere.reach2();
        self.facets.push(Facet { vertices, sphere, reach2, origin });
    }

    /// Returns the centre and the vertices of a facet, with the candidate in the place of infinity, and that place.
    fn corners(&self, facet: &P::Facet, q: P) -> (P::Corners, Option<usize>) {
        let mut infinite = None;
        let corners = P::Corners::from_fn(|i| {
            let Some(slot) = i.checked_sub(1) else { return self.centre };
            let vertex = self.vertices.get(facet.as_ref()[slot] as usize);
            vertex.map_or_else(
                || {
                    infinite = Some(i);
                    q
                },
                |vertex| vertex.at,
            )
        });
        (corners, infinite)
    }

    /// Returns `true` if a candidate conflicts with a facet. Exact.
    fn conflicts(&self, facet: &P::Facet, q: P) -> bool {
        let (corners, infinite) = self.corners(facet, q);
        let Some(slot) = infinite else { return in_sphere(corners.as_ref(), q) };
        match orientation(corners.as_ref()) {
            Sign::Positive => true,
            Sign::Negative => false,
            Sign::Zero => self.inner_conflict(corners, slot, q),
        }
    }

    /// Decides for a candidate in the hyperplane of a hull facet. Every cell on the inner side of the facet gives the same
    /// answer, and some vertex of the frame is on that side.
    fn inner_conflict(&self, mut corners: P::Corners, slot: usize, q: P) -> bool {
        for &v in self.frame.as_ref() {
            corners.as_mut()[slot] = self.vertices[v as usize].at;
            if orientation(corners.as_ref()) == Sign::Negative {
                // The vertex is not beyond the facet, so the positive cell has the opposite order.
                let other = if slot == 1 { 2 } else { 1 };
                corners.as_mut().swap(0, other);
                return in_sphere(corners.as_ref(), q);
            }
        }
        false
    }

    /// Starts with the facet of the first candidates that span a cell with the centre. Returns `false` if there are none.
    pub(super) fn start(&mut self, cost: &mut Cost) -> bool {
        let (mut basis, mut found) = (vec![self.centre], Vec::with_capacity(P::DIM));
        let mut sweep = cost.sweep();
        for (number, vertex) in (0u32..).zip(&self.vertices) {
            if found.len() == P::DIM {
                break;
            }
            sweep.visit();
            if raises_dimension(&basis, vertex.at) {
                basis.push(vertex.at);
                found.push(number);
                cost.charge_sweep(std::mem::take(&mut sweep));
            }
        }
        cost.charge_sweep(sweep);
        if found.len() < P::DIM {
            return false;
        }
        let mut first = P::Facet::splat(0);
        first.as_mut().copy_from_slice(&found);
        if orientation(&basis) == Sign::Negative {
            first.as_mut().swap(0, 1);
        }
        self.frame = first;
        self.push(first, CREATED);
        for slot in 0..P::DIM {
            let mut outer = first;
            outer.as_mut()[slot] = INFINITE;
            outer.as_mut().swap((slot + 1) % P::DIM, (slot + 2) % P::DIM);
            self.push(outer, CREATED);
        }
        true
    }

    /// Adds a candidate. Calls `lost` with the origin of each facet that it removes.
    pub(super) fn insert(&mut self, q: u32, checks_reach: bool, cost: &mut Cost, mut lost: impl FnMut(u32)) {
        let candidate = self.vertices[q as usize];
        let (mut sweep, mut exact) = (cost.sweep(), cost.sweep());
        sweep.visit_lanes(if checks_reach { 2 * self.facets.len() } else { self.facets.len() });
        let mut cavity = std::mem::take(&mut self.cavity);
        cavity.clear();
        for (number, facet) in (0u32..).zip(&self.facets) {
            let side = facet.sphere.side(&candidate);
            let conflicts = if side == 0.0 {
                exact.visit();
                self.conflicts(&facet.vertices, candidate.at)
            } else {
                side > 0.0
            };
            if conflicts {
                cavity.push(number);
            }
        }
        let (mut removed, mut planes, mut ridges) = (Sweep::default(), Sweep::default(), Sweep::default());
        removed.visit_parts(&cavity, P::DIM);
        if !cavity.is_empty() {
            let created = self.boundary(&cavity, q);
            for &facet in cavity.iter().rev() {
                lost(self.facets.swap_remove(facet as usize).origin);
            }
            ridges.visit_parts(planes.visit_all(&created), P::DIM);
            for facet in created {
                self.push(facet, CREATED);
            }
        }
        self.cavity = cavity;
        cost.charge_sweeps([sweep, exact, removed, planes, ridges]);
    }

    /// Returns the facets that join a candidate to the boundary of its cavity.
    fn boundary(&mut self, cavity: &[u32], q: u32) -> Vec<P::Facet> {
        self.sort_ridges(cavity.iter().copied());
        let once = self.ridges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
        let joined = once.map(|same| {
            let (_, facet, slot) = same[0];
            let mut vertices = self.facets[facet as usize].vertices;
            vertices.as_mut()[slot as usize] = q;
            vertices
        });
        joined.collect()
    }

    fn sort_ridges(&mut self, facets: impl Iterator<Item = u32>) {
        self.ridges.clear();
        for facet in facets {
            let vertices = &self.facets[facet as usize].vertices;
            let of_slot = |slot: u32| (ridge(vertices, slot as usize), facet, slot);
            self.ridges.extend((0..P::DIM as u32).map(of_slot));
        }
        self.ridges.sort_unstable();
    }

    /// Returns `true` if every ridge has two facets, and some facet is finite, which becomes the frame.
    pub(super) fn is_closed(&mut self) -> bool {
        self.sort_ridges(0..self.facets.len() as u32);
        let is_closed = self.ridges.chunk_by(|a, b| a.0 == b.0).all(|same| same.len() == 2);
        let finite = self.facets.iter().find(|facet| !facet.vertices.as_ref().contains(&INFINITE));
        if let Some(facet) = finite {
            self.frame = facet.vertices;
        }
        is_closed && finite.is_some()
    }

    /// Returns `true` if no candidate from number `q` on conflicts with any facet.
    pub(super) fn are_out_of_reach(&self, q: usize) -> bool {
        let Some(next) = self.vertices.get(q) else { return true };
        self.facets.iter().all(|facet| facet.reach2 < next.square)
    }

    pub(super) fn named(&self, facet: &P::Facet) -> P::Facet {
        let mut named = *facet;
        for v in named.as_mut() {
            *v = self.vertices.get(*v as usize).map_or(INFINITE, |vertex| vertex.id);
        }
        named
    }

    /// Returns `true` if a candidate is one of those with which the link of [`General::start`] began.
    pub(super) fn frame_at_start(&self, q: usize) -> bool {
        self.frame.as_ref().contains(&(q as u32))
    }
}

/// Appends to `found` the points in the perturbed circumsphere of a cell of the centre, except its corners. The points are
/// positions in the table. A flat cell contains no points.
pub(super) fn append_inside<P: Point>(
    (table, centre): (&[P], P),
    cell: &P::Cell,
    points: impl Iterator<Item = u32>,
    found: &mut Vec<u32>,
) {
    let mut others: Vec<u32> =
        cell.as_ref().iter().copied().filter(|&v| table[v as usize] != centre).collect();
    if others.len() != P::DIM {
        return;
    }
    // The number of exact tests does not depend on the numbering of the table.
    others.sort_unstable_by(|&a, &b| lex_cmp(&table[a as usize], &table[b as usize]));
    let mut star = General::default();
    star.begin(table, centre, others.iter().copied().chain(points));
    let mut facet = P::Facet::splat(0);
    for (number, v) in (0u32..).zip(facet.as_mut()) {
        *v = number;
    }
    let (corners, _) = star.corners(&facet, centre);
    match orientation(corners.as_ref()) {
        Sign::Zero => return,
        Sign::Negative => facet.as_mut().swap(0, 1),
        Sign::Positive => {}
    }
    let sphere = Sphere::of(|slot| star.vertices.get(facet.as_ref()[slot] as usize).copied());
    for point in &star.vertices[others.len()..] {
        let side = sphere.side(point);
        let may_conflict = side >= 0.0 && !cell.as_ref().contains(&point.id);
        if may_conflict && (side > 0.0 || star.conflicts(&facet, point.at)) {
            found.push(point.id);
        }
    }
}
