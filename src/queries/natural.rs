//! Weights of natural neighbours.
//!
//! **Statement.** To insert a query `q` removes the cells whose spheres contain `q`, and adds a cell `(q, F)` for each facet `F` of the
//! boundary of this cavity. Other cells keep their parts of the Voronoi cells ([`crate::dual`]). So the volume that `q` takes from the Voronoi
//! cell of `v` is the sum of the parts at `v` of the removed cells, less that of the added ones. Sibson's weight of `v` is this
//! volume, divided by the sum over all neighbours. Laplace's weight is the measure of the facet between `q` and `v` over their
//! distance, divided by the sum: proportional to the sum of the parts of the edge `qv` over `|q - v|^2`.
//!
//! Both reproduce linear functions, are continuous, and are 1 at a vertex.
//!
//! **On the hull.** Let `q` tend to a flat face of the hull from inside, at the distance `e`. At the depth `z` beyond the face, the
//! points of the plane that are nearest to `q` are its cell in the power diagram of the face, where `q` has the weight `-2 e z`. So the
//! Voronoi cell of `q` grows without bound, and integrals over `z` are integrals over `s = 2 e z`, divided by `2 e`. Laplace's weight tends to
//! the integral over `s` of the length between `q` and `v` over their distance, which is twice the area that `q` takes from `v`: Sibson's
//! weight in the plane of the face. Sibson's weight tends to the integral of that area, which is the integral of
//! `|x - v|^2 - |x - q|^2` over the `x` that `q` takes from `v`: the next kind of weights (Hiyoshi and Sugihara). The
//! facets of the hull in the cavity are the cavity in the plane, because the perturbed in-sphere test at a point of the plane is the
//! perturbed in-circle test ([`septet_geometry::predicates::conflicts_infinite`]). On an edge of the hull, the limit is linear
//! between the two neighbours on it: on a line, all kinds of weights are linear.
//!
//! **Source.** Sibson, "A brief description of natural neighbour interpolation" (1981); Christ, Friedberg and Lee, "Weights of links and
//! plaquettes in a random lattice" (1982); Sugihara, "Surface interpolation based on new local coordinates" (1999);
//! Watson, *Contouring* (1992); Hiyoshi and Sugihara, "Improving continuity of Voronoi-based interpolation over Delaunay spheres" (2002).
//!
//! **Rounding.** The row is checked: the weighted mean of its points must be `q`, up to [`OFF`] of the distance of the farthest.
//! Otherwise each part is computed by big integers and rounded once. That happens near to the hull, where some triangles are nearly flat
//! and some parts nearly infinite.
//!
//! **Departures.** No polygon is clipped. A weight that rounding makes negative is 0. A query whose digits do not fit into the range of exact
//! predicates is moved by less than `2^-214` in scaled units. If that takes it out of the cell, or if the check fails twice, the
//! weights are linear.
//!
//! **Work.** O(c) for a cavity of c cells; about 20 in space and 4 in the plane on evenly spread points.

use glam::{DVec2, DVec3};
use septet_geometry::point::Simplex;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use crate::dimension::Dimension;
use crate::dual::{circumcentre, parts};
use crate::exact;
use crate::incidence::facet;
use crate::locate::Query;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

/// The weights of a query: vertices and their weights.
pub(crate) type Row = Vec<(u32, f64)>;

/// The kinds of natural neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Natural {
    Sibson,
    Laplace,
    /// The integral of Sibson's areas, in the plane.
    Hiyoshi,
}

/// The largest distance of the weighted mean of a row from the query, relative to that of the farthest point.
const OFF: f64 = 1e-11;

/// The cells that the insertion of a query removes, and those that it makes.
pub(crate) struct Cavity<'a, P: Dimension> {
    t: &'a Tessellation<P>,
    /// The query. It lies at no vertex.
    q: P,
    /// The removed cells.
    cells: &'a [u32],
    /// The facets of the cavity that do not contain the query in their planes: cells and slots.
    facets: Vec<(u32, usize)>,
    /// The facets of the hull whose planes contain the query.
    flat: Vec<(u32, usize)>,
}

/// The smallest positive length in scaled units that exact predicates admit.
const UNIT: f64 = f64::from_bits((1023 - 214) << 52);

impl<'a, P: Dimension> Cavity<'a, P> {
    /// Finds the cavity of a query in `cell`. Returns `None` if the query has to be moved and leaves the cell.
    pub(crate) fn of(
        t: &'a Tessellation<P>,
        query: &Query<P>,
        cell: u32,
        seen: &'a mut Seen,
    ) -> Option<Self> {
        let q = query.near;
        let q = if query.fits { q } else { moved(t, q, cell)? };
        seen.clear();
        seen.push(cell);
        let (mut facets, mut flat) = (Vec::new(), Vec::new());
        let mut head = 0;
        while let Some(cell) = seen.get(head) {
            head += 1;
            for (slot, &next) in t.neighbours[cell as usize].as_ref().iter().enumerate() {
                if next == NONE {
                    let mut corners = t.corners(cell);
                    corners[slot] = q;
                    let of_kind =
                        if orientation(&corners[..=P::DIM]) == Sign::Zero { &mut flat } else { &mut facets };
                    of_kind.push((cell, slot));
                } else if !seen.contains(next) {
                    if in_sphere(&t.corners(next)[..=P::DIM], q) {
                        seen.push(next);
                    } else {
                        facets.push((cell, slot));
                    }
                }
            }
        }
        Some(Cavity { t, q, cells: seen.list(), facets, flat })
    }

    /// Returns the weights, or `None` if they are linear.
    pub(crate) fn row(&self, natural: Natural) -> Option<Row> {
        if self.flat.is_empty() {
            let rounded = self.sums(natural, false).row().filter(|row| self.is_mean(row));
            return rounded.or_else(|| self.sums(natural, true).row().filter(|row| self.is_mean(row)));
        }
        if P::DIM == 2 {
            return None;
        }
        let natural = match natural {
            Natural::Laplace => Natural::Sibson,
            Natural::Sibson | Natural::Hiyoshi => Natural::Hiyoshi,
        };
        let mut sums = Sums { natural, is_exact: false, list: Vec::new() };
        self.add_face(&mut sums)?;
        sums.row().filter(|row| self.is_mean(row))
    }

    /// Whether the weighted mean of the points of a row is the query.
    fn is_mean(&self, row: &Row) -> bool {
        let (mut mean, mut farthest) = (P::splat(0.0), 0.0f64);
        for &(v, weight) in row {
            let to = self.t.points[v as usize] - self.q;
            mean = mean + to * weight;
            farthest = farthest.max(to.norm2());
        }
        mean.norm2() <= OFF * OFF * farthest
    }

    /// Adds the removed and the added cells.
    fn sums(&self, natural: Natural, is_exact: bool) -> Sums {
        let mut sums = Sums { natural, is_exact, list: Vec::new() };
        let ids = |cell: u32| self.t.cells[cell as usize];
        for &cell in self.cells {
            sums.add(&self.t.corners(cell), ids(cell).as_ref());
        }
        for &(cell, slot) in &self.facets {
            let (mut corners, mut ids) = (self.t.corners(cell), ids(cell));
            corners[slot] = self.q;
            ids.as_mut()[slot] = NONE;
            sums.add(&corners, ids.as_ref());
        }
        sums
    }

    /// Adds the triangles of a flat face of the hull. Returns `None` if the query lies on an edge of the hull.
    fn add_face(&self, sums: &mut Sums) -> Option<()> {
        let triangles: Vec<[u32; 3]> = self
            .flat
            .iter()
            .map(|&(cell, slot)| {
                let facet = facet::<P>(&self.t.cells[cell as usize], slot);
                std::array::from_fn(|i| facet.as_ref()[i])
            })
            .collect();
        let at = |v: u32| self.t.points[v as usize];
        let [a, b, c] = triangles[0].map(at);
        let is_coplanar = |&v: &u32| orientation(&[a, b, c, at(v)]) == Sign::Zero;
        if !triangles.iter().flatten().all(is_coplanar) {
            return None;
        }
        let vector = |p: P| DVec3::from_array(std::array::from_fn(|i| p.coord(i)));
        let u = vector(b - a).normalize();
        // The part of `c - a` orthogonal to `u`: seen from outside, `u` and `v` are counter-clockwise, as `a`, `b` and `c` are.
        let v = u.cross(vector(c - a)).cross(u).normalize();
        let flat = |p: P| DVec2::new(vector(p - self.q).dot(u), vector(p - self.q).dot(v));
        let none = DVec2::ZERO;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|v| flat(at(v)));
            sums.add(&[a, b, c, none], triangle);
            for i in 0..3 {
                let [from, to] = [triangle[i], triangle[(i + 1) % 3]];
                let has_edge =
                    |other: &[u32; 3]| (0..3).any(|j| [other[j], other[(j + 1) % 3]] == [to, from]);
                if !triangles.iter().any(has_edge) {
                    sums.add(&[none, flat(at(from)), flat(at(to)), none], &[NONE, from, to]);
                }
            }
        }
        Some(())
    }
}

/// Drops the digits of a query below the range of exact predicates. Returns `None` if it then leaves the cell or is a vertex.
fn moved<P: Dimension>(t: &Tessellation<P>, mut q: P, cell: u32) -> Option<P> {
    for axis in 0..P::DIM {
        let x = q.coord(axis);
        // Larger numbers have no lower digits.
        if x.abs() < UNIT * (1u64 << 53) as f64 {
            q.set_coord(axis, (x / UNIT).trunc() * UNIT + 0.0);
        }
    }
    let corners = t.corners(cell);
    let stays = (0..P::Cell::LEN).all(|slot| {
        let mut replaced = corners;
        replaced[slot] = q;
        corners[slot] != q && orientation(&replaced[..=P::DIM]) != Sign::Negative
    });
    stays.then_some(q)
}

/// Sums of parts at vertices.
struct Sums {
    natural: Natural,
    /// Whether parts are computed by big integers.
    is_exact: bool,
    list: Row,
}

impl Sums {
    /// Adds the parts of a cell: of a removed one, or of an added one, which has the query as the vertex [`NONE`]. For
    /// [`Natural::Hiyoshi`], the query is the origin.
    fn add<P: Dimension>(&mut self, corners: &[P; 4], ids: &[u32]) {
        let is_new = ids.contains(&NONE);
        if self.natural == Natural::Laplace && !is_new {
            return;
        }
        let cell = &corners[..=P::DIM];
        let centre = if self.is_exact { P::default() } else { circumcentre(cell) };
        let parts = if self.is_exact { exact::parts(cell, P::EDGES) } else { parts(cell, centre) };
        for (part, &[v, i, ..]) in parts.into_iter().zip(P::EDGES) {
            let lost = if is_new { -part } else { part };
            match self.natural {
                Natural::Sibson => self.list.extend([(ids[v], lost), (ids[i], lost)]),
                Natural::Laplace if ids[v] == NONE || ids[i] == NONE => {
                    let other = if ids[v] == NONE { ids[i] } else { ids[v] };
                    self.list.push((other, part / (corners[i] - corners[v]).norm2()));
                }
                Natural::Laplace => {}
                Natural::Hiyoshi => {
                    // The integral of a linear function over a triangle is its value at the centroid times the area.
                    let middle = (corners[v] + corners[i]) / 2.0;
                    for end in [v, i] {
                        let site = corners[end];
                        let centroid = (site + middle + (centre + corners[0])) / 3.0;
                        self.list.push((ids[end], lost * (site.norm2() - 2.0 * site.dot(centroid))));
                    }
                }
            }
        }
    }

    /// Adds up the parts of each vertex, and divides by their sum. Returns `None` if a sum is not finite.
    fn row(mut self) -> Option<Row> {
        self.list.retain(|(v, _)| *v != NONE);
        // The sort is stable, so that sums do not depend on the algorithm of sorting.
        self.list.sort_by_key(|(v, _)| *v);
        let mut row: Row = Vec::with_capacity(16);
        for (v, part) in self.list {
            match row.last_mut() {
                Some(last) if last.0 == v => last.1 += part,
                _ => row.push((v, part)),
            }
        }
        let all: f64 = row.iter().map(|(_, weight)| weight).sum();
        if !all.is_finite() {
            return None;
        }
        row.retain(|(_, weight)| *weight > 0.0);
        let sum: f64 = row.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut row {
            *weight /= sum;
        }
        (sum > 0.0).then_some(row)
    }
}
