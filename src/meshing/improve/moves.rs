//! Moves of vertices.
//!
//! **Statement.** A search tries a fixed set of directions with halving steps. The vertex moves to the position at
//! which the worst cell around it is best, if this position is better than the current one.
//! - Points on facets move in their plane, and points on segments along their segment, between their neighbours.
//!   Corners do not move. Points on a remeshed surface move on the surface, if the boundary still follows it
//!   ([`super::surface`]).
//! - Every cell around the vertex remains positively oriented (exact sign). No radius-edge ratio around it rises above
//!   the larger of the bound and the worst previous ratio there.
//!
//! **Source.** Freitag and Ollivier-Gooch (1997) for optimisation-based smoothing. **Departures.** A pattern search
//! replaces the linear programs, because it needs no gradients and the objective is not differentiable at its maxima.
//!
//! **Work and depth.** O(1) for a vertex.

use std::cell::OnceCell;

use septet_geometry::point::Point;

use super::change::{Change, Kind, Placed};
use super::editable::{Editable, row_of};
use super::rules::{Rules, measured};
use super::shape::Grade;
use super::surface::Sized;
use crate::mesh::Carrier;
use crate::space::Space;

/// The number of rounds of a search.
const SEARCHES: u32 = 10;

/// A search ends if no step of this part of the first one, or of more, helps.
const FUTILE: f64 = 0.05;

/// The cells around a moving vertex, as rows of points.
pub(super) struct Fan<P> {
    /// The cells with the place of the vertex in each.
    pub(super) cells: Vec<([P; 4], usize)>,
    /// The largest radius-edge ratio that they may have.
    pub(super) ratio: f64,
}

impl<P: Space> Fan<P> {
    /// Returns the cells around a vertex, and their grade.
    fn around(mesh: &Editable<P>, rules: &Rules<'_, P>, v: u32) -> (Self, Grade) {
        let star = mesh.star(v);
        let (before, worst) = measured(mesh, star);
        let slot = |c: u32| mesh.cells[c as usize].iter().position(|&w| w == v).unwrap_or_default();
        // A position that is not better is often bad for the worst cells.
        let mut worst_first = star.to_vec();
        worst_first.sort_by(|&a, &b| mesh.sines[a as usize].total_cmp(&mesh.sines[b as usize]));
        let cells = worst_first.iter().map(|&c| (mesh.corners(c), slot(c))).collect();
        (Fan { cells, ratio: rules.ratio(worst) }, before)
    }

    /// Returns the grade of the cells with the vertex at a point, if all cells are positive and no ratio is too large.
    /// Returns `None` as soon as a sine is at most `above`.
    pub(super) fn at(&self, rules: &Rules<'_, P>, p: P, above: f64) -> Option<Grade> {
        let mut all = Grade::BEST;
        for &(mut corners, slot) in &self.cells {
            corners[slot] = p;
            all = all.and(super::shape::grade(row_of(&corners)));
            if all.sine <= above {
                return None;
            }
        }
        for &(mut corners, slot) in &self.cells {
            corners[slot] = p;
            rules.admits(row_of(&corners), self.ratio)?;
        }
        Some(all)
    }

    /// Searches for a better position, from a position with this grade. `place` maps a direction and a step to a
    /// position and its carrier. `settle` maps a better position to a permitted one.
    pub(super) fn climb(
        &self,
        rules: &Rules<'_, P>,
        (start, mut step): (Placed<P>, f64),
        mut best: Grade,
        place: impl Fn(P, P, f64) -> Option<(P, Carrier)>,
        settle: impl Fn(P, Carrier) -> Option<(P, Carrier)>,
    ) -> (Placed<P>, Grade) {
        let (mut found, first_step) = (start, step);
        let directions = directions::<P>();
        for _ in 0..SEARCHES {
            let centre = found.at;
            for &d in &directions {
                let better = |at: P, above: Grade| {
                    self.at(rules, at, above.sine).filter(|grade| grade.may_replace(above, rules.wanted))
                };
                let Some((wish, carrier)) = place(centre, d, step) else { continue };
                let wish = rules.snapped(wish);
                let settled = better(wish, best).and_then(|_| settle(wish, carrier));
                let Some((at, carrier)) = settled else { continue };
                let at = rules.snapped(at);
                if let Some(grade) = better(at, best) {
                    best = grade;
                    found = Placed { at, carrier, ..found };
                }
            }
            if found.at == centre {
                step *= 0.5;
            }
            if found.at == start.at && step < FUTILE * first_step {
                break;
            }
            if best.sine > 1.2 * rules.wanted {
                break;
            }
        }
        (found, best)
    }
}

/// Whether a vertex with this carrier does not move.
fn is_kept<P: Space>(rules: &Rules<'_, P>, carrier: Carrier) -> bool {
    match carrier {
        Carrier::Corner(_) => true,
        Carrier::Segment(_) => rules.target.fixed || P::DIM == 2,
        Carrier::Facet(_) => rules.target.fixed,
        Carrier::Volume => false,
    }
}

/// Returns the best move of a vertex.
pub(super) fn slide<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, v: u32) -> Option<Change<P>> {
    let carrier = mesh.carriers[v as usize];
    if is_kept(rules, carrier) {
        return None;
    }
    let (fan, before) = Fan::around(mesh, rules, v);
    let start = Placed { vertex: v, at: mesh.points[v as usize], carrier, size: mesh.sizes[v as usize] };
    let chain = chain(mesh, rules, v);
    if chain.is_none() && matches!(carrier, Carrier::Segment(_)) {
        return None;
    }
    let place = |centre: P, d: P, step: f64| match carrier {
        Carrier::Facet(f) => {
            let n = rules.normals[f as usize];
            Some((centre + (d - n * n.dot(d)) * step, carrier))
        }
        Carrier::Segment(_) => chain.as_ref().and_then(|c| c.place(centre, d, step)).map(|p| (p, carrier)),
        _ => Some((centre + d * step, carrier)),
    };
    let faces = boundary(mesh, rules, v);
    let off = OnceCell::new();
    let settle = |wish: P, carrier: Carrier| {
        let Some((surface, old)) = rules.surface.as_ref().zip(faces.as_ref()) else {
            return Some((wish, carrier));
        };
        let (at, carrier) = match carrier {
            Carrier::Facet(_) => {
                surface.place(wish, &rules.normals).map(|(at, facet)| (at, Carrier::Facet(facet)))?
            }
            _ => (wish, carrier),
        };
        let moved = |&((face, size), slot): &(Sized<P>, usize)| {
            let mut face = face;
            face[slot] = at;
            (face, size)
        };
        let new: Vec<Sized<P>> = old.iter().map(moved).collect();
        let old: Vec<Sized<P>> = old.iter().map(|f| f.0).collect();
        let before = || *off.get_or_init(|| surface.off_all(&old));
        (turns_little(&old, &new) && surface.permits(&old, before, &new)).then_some((at, carrier))
    };
    let (placed, grade) = fan.climb(rules, (start, 0.25 * start.size), before, place, settle);
    let mut change = Change::of(Kind::Move, grade, mesh.star(v).to_vec(), Vec::new());
    change.placed = Some(placed);
    (placed.at != start.at && grade.is_worth(before, rules.wanted)).then_some(change)
}

/// Returns `true` if no face turns by more than 60 degrees.
fn turns_little<P: Space>(old: &[Sized<P>], new: &[Sized<P>]) -> bool {
    let normal = |&([a, b, c], _): &Sized<P>| P::hull_normal(&[b - a, c - a]);
    old.iter().zip(new).all(|(old, new)| crate::angles::cosine(normal(old), normal(new)) > 0.5)
}

/// Returns the faces around a vertex of a remeshed surface, with the place of the vertex in each.
fn boundary<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, v: u32) -> Option<Vec<(Sized<P>, usize)>> {
    if rules.surface.is_none() || mesh.carriers[v as usize] == Carrier::Volume {
        return None;
    }
    let of = |(face, _): ([u32; 3], u32)| {
        let slot = face.iter().position(|&w| w == v).unwrap_or_default();
        ((mesh.triangle(face), size_of(mesh, face)), slot)
    };
    Some(mesh.faces_at(v).into_iter().map(of).collect())
}

/// Returns the largest size at the corners of a face.
pub(super) fn size_of<P: Space>(mesh: &Editable<P>, face: [u32; 3]) -> f64 {
    face.map(|v| mesh.sizes[v as usize]).into_iter().fold(0.0, f64::max)
}

/// The part of a segment on which a vertex can move.
struct Chain<P> {
    from: P,
    along: P,
    /// The parameters of its ends.
    between: [f64; 2],
}

impl<P: Space> Chain<P> {
    fn place(&self, centre: P, d: P, step: f64) -> Option<P> {
        let length2 = self.along.norm2();
        let t = (centre + d * step - self.from).dot(self.along) / length2;
        (self.between[0] < t && t < self.between[1]).then(|| self.from + self.along * t)
    }
}

/// Returns the part of its segment between the neighbours of a vertex on a segment.
fn chain<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, v: u32) -> Option<Chain<P>> {
    let Carrier::Segment(s) = mesh.carriers[v as usize] else { return None };
    let [from, to] = rules.domain.segments[s as usize].ends().map(|w| rules.domain.points()[w as usize]);
    let along = to - from;
    let t = |p: P| (p - from).dot(along) / along.norm2();
    let mut between = [0.0f64, 1.0f64];
    let mut neighbours: Vec<u32> = mesh.star(v).iter().flat_map(|&c| mesh.cells[c as usize]).collect();
    neighbours.sort_unstable();
    neighbours.dedup();
    for w in neighbours
        .into_iter()
        .filter(|&w| w != v && mesh.edges.contains_key(&crate::space::ascending([v, w])))
    {
        let [own, other] = [v, w].map(|w| t(mesh.points[w as usize]));
        if other < own {
            between[0] = between[0].max(other);
        } else {
            between[1] = between[1].min(other);
        }
    }
    // Rounding must not change the order of the points.
    let margin = 1e-3 * (between[1] - between[0]);
    Some(Chain { from, along, between: [between[0] + margin, between[1] - margin] })
}

/// Returns the search directions: the axes and the diagonals.
fn directions<P: Point>() -> Vec<P> {
    let mut found = Vec::new();
    for code in 1..3usize.pow(P::DIM as u32) {
        let mut d = P::splat(0.0);
        let mut rest = code;
        for i in 0..P::DIM {
            d.set_coord(i, [0.0, 1.0, -1.0][rest % 3]);
            rest /= 3;
        }
        found.push(d / d.norm2().sqrt());
    }
    found
}
