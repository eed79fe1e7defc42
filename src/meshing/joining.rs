//! Facets that lie in one plane, and segments that lie on one line, up to the digits of the file.
//!
//! **Statement.** A *flat* is a set of facets, connected across segments without a marker that have exactly these two
//! facets, with one marker. All its vertices lie in the plane of its largest facet, up to
//! `t (1 + |v - m| / h)`, where m is the middle of the largest triangle, h its least height, and t is `STEPS` steps of
//! the file ([`crate::digits`]). The facets do not turn by more than `TURN` at a segment. A *line* is a chain of
//! segments on the boundaries of the same flats, with a corresponding rule.
//!
//! A segment between two facets of one flat is *inner*. A corner is a *joint* if it has segments, but all of them are
//! inner, except possibly two of one line.
//!
//! *The geometry of the domain does not change.* Inner segments and joints remain constraints: the mesh contains them,
//! and its faces tile each facet of the domain exactly. The tolerance decides only which features determine sizes.
//! Flats and lines count as single features, and inner segments and joints do not count ([`crate::distance`]). The size
//! at a corner of an inner segment or of a line is at most the length of the shortest segment there
//! ([`Flats::spacing`]), so that points are still f-spaced.
//!
//! *Why the bound grows with the distance.* If each coordinate is off by t, the plane of a triangle of height h turns by
//! up to about `t / h`.
//!
//! *Two disjoint flats share no point.* A joint lies on one flat, or on one line and the flats around it. These all
//! contain the ends of the line, which are not joints.
//!
//! **Work and depth.** `O(m log m)`, sequential.

use std::collections::BTreeMap;

use crate::domain::{Domain, Segment};
use crate::flats::Flats;
use crate::sides::Sets;
use crate::space::Space;

/// The tolerance in steps of the file. Each of four points may be half a step off on each of three axes.
const STEPS: f64 = 4.0;

/// The cosine of the largest angle between adjacent facets of a flat, and between segments of a line: 5 degrees.
const TURN: f64 = 0.996_194_698_091_745_5;

/// Finds the flats of a domain. `step` is the step of the coordinates, in the coordinates of the domain. In the plane,
/// nothing is joined.
pub fn flats_of<P: Space>(domain: &Domain<P>, step: f64) -> Flats {
    let (corners, segments, facets) = (domain.corners.len(), domain.segments.len(), domain.facets.len());
    let mut flats = Flats { tolerance: STEPS * step, ..Flats::separate(corners, segments, facets) };
    if P::DIM == 3 {
        let at = domain.segments_at();
        flats.join_facets(domain);
        flats.join_segments(domain, &at);
        flats.find_joints(domain, &at);
    }
    flats
}

impl Flats {
    fn join_facets<P: Space>(&mut self, domain: &Domain<P>) {
        let mut across: Vec<Vec<(u32, u32)>> = vec![Vec::new(); domain.facets.len()];
        for (s, segment) in (0u32..).zip(&domain.segments) {
            if let Some([a, b]) = sides_of(domain, segment)
                && domain.dihedral_angle(a, b, s).is_some_and(|cosine| cosine <= -TURN)
            {
                across[a as usize].push((b, s));
                across[b as usize].push((a, s));
            }
        }
        let mut order: Vec<(f64, u32)> =
            (0..self.flats.len() as u32).map(|f| (Carrying::plane(domain, f).area, f)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut sets = Sets::new(self.flats.len());
        let mut met = vec![false; self.flats.len()];
        for (_, seed) in order {
            if std::mem::replace(&mut met[seed as usize], true) {
                continue;
            }
            let plane = Carrying::plane(domain, seed);
            let mut stack = vec![seed];
            while let Some(f) = stack.pop() {
                for &(g, _) in &across[f as usize] {
                    let walls = || domain.facets[g as usize].walls.iter();
                    let vertices = || walls().flat_map(|&w| domain.walls()[w as usize].as_ref().to_vec());
                    let holds = |v: u32| plane.holds(domain.points()[v as usize], self.tolerance);
                    if !met[g as usize] && vertices().all(holds) {
                        met[g as usize] = true;
                        sets.join(seed, g);
                        stack.push(g);
                    }
                }
            }
        }
        self.flats = first_of(&mut sets, self.flats.len());
        for (line, segment) in self.lines.iter_mut().zip(&domain.segments) {
            let inner = sides_of(domain, segment)
                .is_some_and(|[a, b]| self.flats[a as usize] == self.flats[b as usize]);
            *line = line.filter(|_| !inner);
        }
    }

    fn join_segments<P: Space>(&mut self, domain: &Domain<P>, at: &BTreeMap<u32, Vec<u32>>) {
        let count = domain.segments.len();
        let around = |s: u32| {
            let facets = &domain.segments[s as usize].facets;
            let mut flats: Vec<u32> = facets.iter().map(|&f| self.flats[f as usize]).collect();
            flats.sort_unstable();
            (flats, domain.segments[s as usize].marker)
        };
        let next = |v: u32, s: u32| {
            let mut others = at[&v].iter().copied().filter(|&t| self.lines[t as usize].is_some());
            let pair = [others.next()?, others.next()?];
            let t = if pair[0] == s { pair[1] } else { pair[0] };
            let same = || around(s) == around(t) && !domain.segments[s as usize].facets.is_empty();
            let goes_on = others.next().is_none() && same() && domain.plane_angle(s, t, v) <= -TURN;
            goes_on.then_some(t)
        };
        let ends = |s: u32| domain.segments[s as usize].ends();
        let mut order: Vec<(f64, u32)> = (0..count as u32)
            .filter(|&s| self.lines[s as usize].is_some())
            .map(|s| (length2(domain, s), s))
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut sets = Sets::new(count);
        let mut met = vec![false; count];
        for (_, seed) in order {
            if std::mem::replace(&mut met[seed as usize], true) {
                continue;
            }
            let line = Carrying::line(domain, seed);
            for start in ends(seed) {
                let (mut v, mut s) = (start, seed);
                while let Some(t) = next(v, s).filter(|&t| !met[t as usize]) {
                    let [a, b] = ends(t);
                    let far = if a == v { b } else { a };
                    if !line.holds(domain.points()[far as usize], self.tolerance) {
                        break;
                    }
                    met[t as usize] = true;
                    sets.join(seed, t);
                    (v, s) = (far, t);
                }
            }
        }
        let first = first_of(&mut sets, count);
        for (line, first) in self.lines.iter_mut().zip(first) {
            *line = line.map(|_| first);
        }
    }

    fn find_joints<P: Space>(&mut self, domain: &Domain<P>, at: &BTreeMap<u32, Vec<u32>>) {
        for (c, v) in (0u32..).zip(&domain.corners) {
            let segments = at.get(v).map_or(&[][..], Vec::as_slice);
            let lines: Vec<u32> = segments.iter().filter_map(|&s| self.lines[s as usize]).collect();
            let joint = !segments.is_empty()
                && match lines[..] {
                    [] => true,
                    [a, b] => a == b,
                    _ => false,
                };
            self.joints[c as usize] = joint;
        }
        for (c, v) in (0u32..).zip(&domain.corners) {
            let segments = at.get(v).map_or(&[][..], Vec::as_slice);
            let is_joint = |v: u32| domain.corners.binary_search(&v).is_ok_and(|c| self.joints[c]);
            let joined =
                |&s: &u32| self.is_inner(s) || domain.segments[s as usize].ends().into_iter().any(is_joint);
            if segments.iter().any(joined) {
                let least = segments.iter().map(|&s| length2(domain, s)).fold(f64::INFINITY, f64::min);
                self.spacing.push((c, least.sqrt()));
            }
        }
    }
}

/// Returns the facets at a segment, if there are two that a flat may join.
fn sides_of<P: Space>(domain: &Domain<P>, segment: &Segment) -> Option<[u32; 2]> {
    let [a, b] = segment.facets[..] else { return None };
    let marker = |f: u32| domain.facets[f as usize].marker;
    (segment.marker == 0 && marker(a) == marker(b)).then_some([a, b])
}

fn length2<P: Space>(domain: &Domain<P>, s: u32) -> f64 {
    let [a, b] = domain.segments[s as usize].ends().map(|v| domain.points()[v as usize]);
    (b - a).norm2()
}

/// Returns the smallest member of the set of each element.
fn first_of(sets: &mut Sets, count: usize) -> Vec<u32> {
    let mut least: BTreeMap<u32, u32> = BTreeMap::new();
    let roots: Vec<u32> = (0..count as u32).map(|i| sets.find(i)).collect();
    for (i, &root) in (0u32..).zip(&roots) {
        least.entry(root).or_insert(i);
    }
    roots.iter().map(|root| least[root]).collect()
}

/// A plane or line through a facet or segment.
struct Carrying<P> {
    middle: P,
    /// The unit normal of a plane, or the unit direction of a line.
    axis: P,
    is_plane: bool,
    /// Twice the area of the triangle.
    area: f64,
    /// The least height of the triangle, or the length of the segment.
    height: f64,
}

impl<P: Space> Carrying<P> {
    /// Returns the plane of the largest triangle of a facet.
    fn plane(domain: &Domain<P>, f: u32) -> Self {
        let corners = |w: &u32| {
            let row = domain.walls()[*w as usize];
            [0, 1, 2].map(|i| domain.points()[row.as_ref()[i] as usize])
        };
        let normal = |[a, b, c]: [P; 3]| P::hull_normal(&[b - a, c - a]);
        let walls = domain.facets[f as usize].walls.iter().map(corners);
        let largest = walls.max_by(|s, t| normal(*s).norm2().total_cmp(&normal(*t).norm2()));
        let [a, b, c] = largest.unwrap_or_default();
        let twice = normal([a, b, c]).norm2().sqrt();
        let longest = [b - a, c - b, a - c].into_iter().map(P::norm2).fold(0.0, f64::max).sqrt();
        let axis = normal([a, b, c]) / twice;
        Carrying { middle: (a + b + c) / 3.0, axis, is_plane: true, area: twice, height: twice / longest }
    }

    /// Returns the line of a segment.
    fn line(domain: &Domain<P>, s: u32) -> Self {
        let [a, b] = domain.segments[s as usize].ends().map(|v| domain.points()[v as usize]);
        let length = (b - a).norm2().sqrt();
        Carrying { middle: (a + b) * 0.5, axis: (b - a) / length, is_plane: false, area: 0.0, height: length }
    }

    /// Returns `true` if a point lies on the plane or line, up to a tolerance that grows with the distance.
    fn holds(&self, p: P, tolerance: f64) -> bool {
        let to = p - self.middle;
        let along = self.axis.dot(to);
        let off = if self.is_plane { along.abs() } else { (to - self.axis * along).norm2().sqrt() };
        off <= tolerance * (1.0 + to.norm2().sqrt() / self.height)
    }
}
