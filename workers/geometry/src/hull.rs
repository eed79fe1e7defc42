//! The star of a vertex as a local convex hull.
//!
//! **Statement** (paper, Lemmas 4.1 and 4.3). Lift the points to the paraboloid. The edges at `p` of
//! the lower hull, hence of the Delaunay triangulation, are the vertices of the convex hull, one
//! dimension down, of the rays from `p`'s lift to the other lifts. If the candidates hold every
//! Delaunay neighbour of `p`, the hull of the candidates gives the star of `p`.
//!
//! We do not cut the rays with a hyperplane: the hull is kept as the *link* of `p`, a closed complex of
//! `DIM`-vertex facets in which the vertical ray is the infinite vertex, and a candidate is added by
//! digging the facets it conflicts with ([`crate::complex`]). A finite facet `f` conflicts with `q` iff
//! `q` lies in the circumsphere of `(p, f)`; an infinite one iff `q` lies beyond the hull facet.
//!
//! **Work and depth.** One sweep over the link's facets for each candidate: a vector step. With `m`
//! candidates and link size `l`: depth O(m), work O(m l); both constants under the paper's hypothesis.
//!
//! **Departures.** (1) Candidates come in order of distance, so that most conflict with nothing.
//! (2) In coordinates relative to `p` both tests read `w |q|^2 - v . q < 0`, with `w = 0` for infinite
//! facets, and are done in rounded arithmetic with one error bound per facet; what the bound does not
//! decide goes to the exact predicates. (3) Of those undecided, few need be asked: see below.
//!
//! **One exact test a candidate.** Over the cone that the link spans, the lifted facets are the graph of a
//! convex function, the largest of their linear functions; under the perturbation too. A candidate `q` in
//! the cone lies below it iff it lies below the facet whose own cone holds `q`: if that does not conflict,
//! no facet does. Outside the cone `q` lies beyond some infinite facet, strictly. So if rounded arithmetic
//! finds no conflict but leaves facets undecided, the exact test of that one finite facet, or an
//! orientation for each infinite one, decides; and when there is a conflict, only facets that meet the
//! cavity are asked, as it is dug. Among cospherical points, where nothing is decided by rounding, this is
//! what keeps a sweep from one exact test for each facet. (A `q` on the common face of several cones is
//! in all of them, and their functions agree there.)
//!
//! **Error bound.** Relative coordinates `a - p` carry a relative error of at most `u = 2^-53` each.
//! `w` is a sum of products of `DIM` of them and `|w|`'s permanent is at most `sqrt(3) A`, `A` the
//! product of the lengths; `v` is a sum of terms `|a|^2 (b x c)`, permanent at most
//! `sqrt(3) A (|a| + |b| + |c|)`. Counting roundings (at most 24 per term, the evaluation of
//! `w |q|^2 - v . q` included) the error is below `24 sqrt(3) u A (|q|^2 + (|a|+|b|+|c|) |q|)`. We use
//! 64 `u`, which covers the rounding of the bound itself, and add the smallest normal number, which
//! covers what underflow may lose (products of five coordinates in the admitted range are no smaller
//! than 2^-1074, each subnormal rounding loses at most that).

use crate::complex::{Complex, INFINITE};
use crate::cost::Cost;
use crate::point::{Point, Simplex, dist2, lex_cmp};
use crate::predicates::{Sign, conflicts_infinite, in_sphere, orientation, raises_dimension};

/// A link facet's side test.
#[derive(Clone, Copy, Debug)]
struct Plane<P> {
    w: f64,
    v: P,
    err_qq: f64,
    err_q: f64,
}

/// Where a candidate lies with respect to a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Conflict,
    Clear,
    Undecided,
}

const UNIT: f64 = 64.0 * (f64::EPSILON / 2.0);

/// Builds stars, one after the other, in reused storage.
#[derive(Debug)]
pub struct StarBuilder<P: Point> {
    link: Complex<P::Facet>,
    planes: Vec<Plane<P>>,
    /// Candidate points, in insertion order; the link's vertices are positions in here.
    ids: Vec<u32>,
    points: Vec<P>,
    rel: Vec<P>,
    /// Of every facet: what rounded arithmetic says of the candidate at hand.
    side: Vec<Side>,
    centre: P,
    order: Vec<(f64, u32)>,
}

impl<P: Point> Default for StarBuilder<P> {
    fn default() -> Self {
        StarBuilder {
            link: Complex::default(),
            planes: Vec::new(),
            ids: Vec::new(),
            points: Vec::new(),
            rel: Vec::new(),
            side: Vec::new(),
            centre: P::default(),
            order: Vec::new(),
        }
    }
}

impl<P: Point> StarBuilder<P> {
    /// Builds the star of `table[centre]` among the `candidates` (positions in `table`, in any order,
    /// repeats and the centre itself ignored). Returns false, with no link, if the candidates and the
    /// centre span no cell.
    pub fn build(&mut self, table: &[P], centre: u32, candidates: &[u32], cost: &mut Cost) -> bool {
        self.centre = table[centre as usize];
        self.order.clear();
        let c = self.centre;
        let others = candidates.iter().filter(|&&i| i != centre);
        self.order.extend(others.map(|&i| (dist2(table[i as usize], c), i)));
        cost.sort(&mut self.order, |a, b| {
            let by_rank = || lex_cmp(&table[a.1 as usize], &table[b.1 as usize]);
            a.0.total_cmp(&b.0).then_with(by_rank)
        });
        self.order.dedup_by_key(|e| e.1);
        self.ids.clear();
        self.points.clear();
        self.rel.clear();
        for &(_, id) in &self.order {
            let p = table[id as usize];
            self.ids.push(id);
            self.points.push(p);
            self.rel.push(p - c);
        }
        let Some(first) = self.first_simplex(cost) else {
            self.link.clear();
            return false;
        };
        self.start(first);
        for q in 0..self.ids.len() as u32 {
            if !first.as_ref().contains(&q) {
                self.insert(q, cost);
            }
        }
        true
    }

    /// The link's facets as positions in the table, infinite ones included, oriented so that
    /// `(centre, facet)` is positive. Appends to `out`.
    pub fn facets(&self, out: &mut Vec<P::Facet>) {
        for cell in self.link.live_cells() {
            let mut facet = *self.link.cell(cell);
            for v in facet.as_mut() {
                if *v != INFINITE {
                    *v = self.ids[*v as usize];
                }
            }
            out.push(facet);
        }
    }

    /// Number of facets of the link.
    pub fn link_size(&self) -> usize {
        self.link.len()
    }

    /// The first candidates, in order, that span a cell with the centre, positively oriented.
    fn first_simplex(&self, cost: &mut Cost) -> Option<P::Facet> {
        let mut basis = vec![self.centre];
        let mut facet = P::Facet::splat(0);
        let mut found = 0;
        let mut sweep = cost.sweep();
        for q in 0..self.points.len() {
            sweep.visit();
            if raises_dimension(&basis, self.points[q]) {
                basis.push(self.points[q]);
                facet.as_mut()[found] = q as u32;
                found += 1;
                if found == P::DIM {
                    break;
                }
            }
        }
        cost.swept_inside(sweep);
        if found < P::DIM {
            return None;
        }
        if orientation(&basis) == Sign::Negative {
            facet.as_mut().swap(0, 1);
        }
        Some(facet)
    }

    fn start(&mut self, first: P::Facet) {
        self.link.start(first);
        self.planes.clear();
        self.side.clear();
        for cell in 0..self.link.slots() {
            let plane = self.plane(cell);
            self.planes.push(plane);
            self.side.push(Side::Clear);
        }
    }

    /// One sweep over the facets; then the cavity, if any.
    fn insert(&mut self, q: u32, cost: &mut Cost) {
        let rel = self.rel[q as usize];
        let qq = rel.norm2();
        let length = qq.sqrt();
        let (mut seed, mut undecided) = (None, false);
        let mut sweep = cost.sweep();
        for cell in 0..self.link.slots() {
            if !self.link.is_live(cell) {
                continue;
            }
            sweep.visit();
            let plane = &self.planes[cell as usize];
            let value = plane.w * qq - plane.v.dot(rel);
            let err = plane.err_qq * qq + plane.err_q * length + f64::MIN_POSITIVE;
            // Most often.
            if value > err {
                self.side[cell as usize] = Side::Clear;
            } else if value < -err {
                self.side[cell as usize] = Side::Conflict;
                seed = seed.or(Some(cell));
            } else {
                self.side[cell as usize] = Side::Undecided;
                undecided = true;
            }
        }
        if seed.is_none() && undecided {
            seed = self.conflict_among_undecided(q);
        }
        if let Some(seed) = seed {
            let (side, corners) = (&self.side, Corners { centre: self.centre, points: &self.points });
            self.link.insert(q, seed, |link, cell| match side[cell as usize] {
                Side::Conflict => true,
                Side::Clear => false,
                Side::Undecided => corners.conflict(link, cell, q),
            });
            self.refresh_planes(&mut sweep);
        }
        cost.swept_inside(sweep);
    }

    fn refresh_planes(&mut self, sweep: &mut crate::cost::Sweep) {
        self.planes
            .resize(self.link.slots() as usize, Plane { w: 0.0, v: P::default(), err_qq: 0.0, err_q: 0.0 });
        self.side.resize(self.link.slots() as usize, Side::Clear);
        for i in 0..self.link.created().len() {
            let cell = self.link.created()[i];
            self.planes[cell as usize] = self.plane(cell);
            self.side[cell as usize] = Side::Clear;
            sweep.visit();
        }
    }

    fn plane(&self, cell: u32) -> Plane<P> {
        let facet = self.link.cell(cell).as_ref();
        let mut rel = [P::default(); 3];
        let (mut count, mut product, mut sum) = (0, 1.0, 0.0);
        let mut infinite = None;
        for (slot, &v) in facet.iter().enumerate() {
            if v == INFINITE {
                infinite = Some(slot);
            } else {
                rel[count] = self.rel[v as usize];
                let length = rel[count].norm2().sqrt();
                product *= length;
                sum += length;
                count += 1;
            }
        }
        match infinite {
            None => {
                let (w, v) = P::sphere_plane(&rel[..count]);
                Plane { w, v, err_qq: UNIT * product, err_q: UNIT * product * sum }
            }
            Some(slot) => {
                let normal = P::hull_normal(&rel[..count]);
                // The query stands in the infinite vertex' slot: its way to the last one is a sign.
                let v = if (P::DIM - 1 - slot) % 2 == 0 { normal } else { normal * -1.0 };
                Plane { w: 0.0, v, err_qq: 0.0, err_q: UNIT * product }
            }
        }
    }

    /// A facet that conflicts, if any does, where the decided ones do not.
    #[cold]
    fn conflict_among_undecided(&self, q: u32) -> Option<u32> {
        let corners = Corners { centre: self.centre, points: &self.points };
        for cell in self.link.live_cells().filter(|&cell| self.side[cell as usize] == Side::Undecided) {
            match corners.cone(&self.link, cell, q) {
                Cone::Beyond => return Some(cell),
                Cone::Holds => return corners.conflict(&self.link, cell, q).then_some(cell),
                Cone::Elsewhere => {}
            }
        }
        None
    }
}

/// Where a candidate lies with respect to the cone of a facet.
enum Cone {
    /// In the closed cone of a finite facet.
    Holds,
    /// Strictly beyond the hull facet of an infinite one.
    Beyond,
    Elsewhere,
}

/// The coordinates of the centre and of the link's vertices.
struct Corners<'a, P> {
    centre: P,
    points: &'a [P],
}

impl<P: Point> Corners<'_, P> {
    /// The exact test of one facet.
    #[cold]
    fn conflict(&self, link: &Complex<P::Facet>, cell: u32, q: u32) -> bool {
        let q = self.points[q as usize];
        let (points, infinite) = self.of(link, cell);
        let n = P::DIM + 1;
        match infinite {
            None => in_sphere(&points[..n], q),
            Some(slot) => {
                let (next, _) = link.neighbour(cell, slot);
                let (finite, _) = self.of(link, next);
                conflicts_infinite(&points[..n], slot + 1, &finite[..n], q)
            }
        }
    }

    fn cone(&self, link: &Complex<P::Facet>, cell: u32, q: u32) -> Cone {
        let q = self.points[q as usize];
        let (mut points, infinite) = self.of(link, cell);
        let n = P::DIM + 1;
        if let Some(slot) = infinite {
            points[slot + 1] = q;
            let beyond = orientation(&points[..n]) == Sign::Positive;
            return if beyond { Cone::Beyond } else { Cone::Elsewhere };
        }
        for slot in 1..n {
            let corner = std::mem::replace(&mut points[slot], q);
            if orientation(&points[..n]) == Sign::Negative {
                return Cone::Elsewhere;
            }
            points[slot] = corner;
        }
        Cone::Holds
    }

    /// The points of `(centre, facet)`, and the facet's infinite slot.
    fn of(&self, link: &Complex<P::Facet>, cell: u32) -> ([P; 4], Option<usize>) {
        let mut points = [self.centre; 4];
        let mut infinite = None;
        for (slot, &v) in link.cell(cell).as_ref().iter().enumerate() {
            if v == INFINITE {
                infinite = Some(slot);
            } else {
                points[slot + 1] = self.points[v as usize];
            }
        }
        (points, infinite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    fn extend<P: Point>(points: &[P], pick: &mut Vec<usize>, out: &mut Vec<Vec<u32>>) {
        if pick.len() > P::DIM {
            let mut cell: Vec<P> = pick.iter().map(|&i| points[i]).collect();
            match orientation(&cell) {
                Sign::Zero => return,
                Sign::Negative => cell.swap(0, 1),
                Sign::Positive => {}
            }
            if (0..points.len()).all(|q| pick.contains(&q) || !in_sphere(&cell, points[q])) {
                out.push(pick.iter().map(|&i| i as u32).collect());
            }
            return;
        }
        for i in pick.last().map_or(0, |l| l + 1)..points.len() {
            pick.push(i);
            extend(points, pick, out);
            pick.pop();
        }
    }

    /// Every cell of a tiny set found by brute force, as sorted vertex lists.
    fn brute<P: Point>(points: &[P]) -> Vec<Vec<u32>> {
        let mut cells = Vec::new();
        extend(points, &mut Vec::new(), &mut cells);
        cells
    }

    fn check_stars<P: Point>(points: &[P]) {
        let cells = brute(points);
        let everyone: Vec<u32> = (0..points.len() as u32).collect();
        let mut builder = StarBuilder::default();
        for v in everyone.iter().copied() {
            let mut cost = Cost::ZERO;
            assert!(builder.build(points, v, &everyone, &mut cost));
            assert!(cost.work() > 0 && cost.depth() > 0);
            let mut facets = Vec::new();
            builder.facets(&mut facets);
            let mut star: Vec<Vec<u32>> = facets
                .iter()
                .filter(|f| !f.as_ref().contains(&INFINITE))
                .map(|f| {
                    let mut c = f.as_ref().to_vec();
                    c.push(v);
                    c.sort_unstable();
                    c
                })
                .collect();
            star.sort();
            let expected: Vec<Vec<u32>> = cells.iter().filter(|c| c.contains(&v)).cloned().collect();
            assert_eq!(star, expected, "star of {v}");
        }
    }

    #[test]
    fn stars_of_a_grid_match_brute_force() {
        let mut points = Vec::new();
        for x in 0..3 {
            for y in 0..3 {
                for z in 0..2 {
                    points.push(DVec3::new(x as f64, y as f64, z as f64));
                }
            }
        }
        check_stars(&points);
        let plane: Vec<DVec2> = (0..16).map(|i| DVec2::new((i % 4) as f64, (i / 4) as f64)).collect();
        check_stars(&plane);
    }

    #[test]
    fn stars_of_scattered_points_match_brute_force() {
        let mut state = 7u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / 1024.0
        };
        let points: Vec<DVec3> = (0..14).map(|_| DVec3::new(next(), next(), next())).collect();
        check_stars(&points);
        let points: Vec<DVec2> = (0..20).map(|_| DVec2::new(next(), next())).collect();
        check_stars(&points);
    }

    #[test]
    fn stars_of_points_on_a_sphere_match_brute_force() {
        // All integer points at distance 3 from the origin: exactly cospherical.
        let range = -3..=3;
        let all = range.clone().flat_map(|x| range.clone().map(move |y| (x, y)));
        let all = all.flat_map(|(x, y)| range.clone().map(move |z| DVec3::new(x.into(), y.into(), z.into())));
        let lattice: Vec<DVec3> = all.filter(|p| p.dot(*p) == 9.0).collect();
        assert_eq!(lattice.len(), 30);
        check_stars(&lattice);
        // Rounded, and with some points inside, so that stars have conflicts of every kind.
        let turned = |p: &DVec3| DVec3::new(p.x + 0.3 * p.y, p.y - 0.3 * p.x, p.z * 1.09_f64.sqrt()) / 7.0;
        let mut rounded: Vec<DVec3> = lattice.iter().step_by(2).map(turned).collect();
        check_stars(&rounded);
        rounded.extend([DVec3::new(0.01, 0.02, 0.0), DVec3::new(-0.2, 0.1, 0.05), DVec3::new(0.0, 0.0, 0.3)]);
        check_stars(&rounded);
        let circle = [(5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3), (-5, 0), (-4, -3), (0, -5), (3, -4)];
        let mut plane: Vec<DVec2> = circle.iter().map(|&(x, y)| DVec2::new(x.into(), y.into())).collect();
        check_stars(&plane);
        plane.extend([DVec2::ZERO, DVec2::X, DVec2::new(0.5, -2.0)]);
        check_stars(&plane);
    }

    #[test]
    fn flat_candidates_span_nothing() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        let mut builder = StarBuilder::default();
        assert!(!builder.build(&points, 0, &[0, 1, 2, 3], &mut Cost::default()));
    }
}
