//! The values of the partition that go through the tree of a group: samples, separators, counts, decisions and points.

use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::message::{Body, Decision, PointBatch, Route, RouteBatch};

use crate::machine::group_tree::{Divided, Joined, Parts};
use crate::state::tree::join_bounds;

/// The samples of some members.
pub(crate) struct Samples<P>(pub(crate) Vec<P>);

impl<P: Point> Parts<P> for Samples<P> {
    fn into_body(self) -> Body<P> {
        Body::Samples(Bulk(self.0))
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::Samples(points) = body else { return None };
        Some(Samples(std::mem::take(&mut points.0)))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Joined<P> for Samples<P> {
    fn append(&mut self, Samples(mut next): Self) {
        self.0.append(&mut next);
    }
}

impl<P: Point> Parts<P> for PointBatch<P> {
    fn into_body(self) -> Body<P> {
        Body::Move(self)
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::Move(points) = body else { return None };
        Some(std::mem::take(points))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Joined<P> for PointBatch<P> {
    fn append(&mut self, mut next: Self) {
        PointBatch::append(self, &mut next);
    }
}

/// The words of a separator, which all members receive. There are none if no separator was found.
pub(crate) struct Words(pub(crate) Vec<f64>);

impl<P: Point> Parts<P> for Words {
    fn into_body(self) -> Body<P> {
        Body::Sphere(Bulk(self.0))
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::Sphere(words) = body else { return None };
        Some(Words(std::mem::take(&mut words.0)))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Divided<P> for Words {
    fn split_off(&mut self, _: usize) -> Self {
        Words(self.0.clone())
    }
}

/// The counts of some members, and the boxes of their points.
pub(super) struct SideCounts<P> {
    /// The interior points of each member.
    pub(super) inside: Vec<u64>,
    /// The exterior points of each member.
    pub(super) outside: Vec<u64>,
    /// The corners of the interior and the exterior box; empty if some member has not counted.
    pub(super) boxes: Vec<P>,
}

impl<P: Point> SideCounts<P> {
    /// Creates the counts of a member without a separator.
    pub(super) fn none() -> Self {
        SideCounts { inside: vec![0], outside: vec![0], boxes: Vec::new() }
    }

    /// Returns `true` if all members have counted their points on both sides of a separator.
    pub(super) fn is_complete(&self) -> bool {
        self.boxes.len() == 4
    }
}

impl<P: Point> Parts<P> for SideCounts<P> {
    fn into_body(self) -> Body<P> {
        let SideCounts { inside, outside, boxes } = self;
        let boxes = Bulk(boxes);
        match (inside.as_slice(), outside.as_slice()) {
            (&[inside], &[outside]) => Body::Counts { inside, outside, boxes },
            _ => Body::BranchCounts { inside: Bulk(inside), outside: Bulk(outside), boxes },
        }
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::Counts { inside, outside, boxes } => Some(SideCounts {
                inside: vec![*inside],
                outside: vec![*outside],
                boxes: std::mem::take(&mut boxes.0),
            }),
            Body::BranchCounts { inside, outside, boxes } => Some(SideCounts {
                inside: std::mem::take(&mut inside.0),
                outside: std::mem::take(&mut outside.0),
                boxes: std::mem::take(&mut boxes.0),
            }),
            _ => None,
        }
    }

    fn fits(&self, members: usize) -> bool {
        self.inside.len() == members && self.outside.len() == members
    }
}

impl<P: Point> Joined<P> for SideCounts<P> {
    fn append(&mut self, mut next: Self) {
        self.inside.append(&mut next.inside);
        self.outside.append(&mut next.outside);
        self.boxes = match (self.boxes.as_slice(), next.boxes.as_slice()) {
            (&[a, b, c, d], &[e, f, g, h]) => {
                let [interior, exterior] = [join_bounds((a, b), (e, f)), join_bounds((c, d), (g, h))];
                vec![interior.0, interior.1, exterior.0, exterior.1]
            }
            _ => Vec::new(),
        };
    }
}

/// The decision of a leader, for some members.
pub(super) struct Decided<P> {
    pub(super) decision: Decision,
    /// The corners of the interior and the exterior box; empty unless the node is split.
    pub(super) boxes: Vec<P>,
    /// The routes of each member to both children; without receivers unless the node is split.
    pub(super) routes: Vec<[Route; 2]>,
}

impl<P: Point> Parts<P> for Decided<P> {
    fn into_body(self) -> Body<P> {
        let Decided { decision, boxes, mut routes } = self;
        let boxes = Bulk(boxes);
        match routes.pop() {
            Some(only) if routes.is_empty() => Body::Decision { decision, boxes, routes: Box::new(only) },
            last => {
                routes.extend(last);
                Body::BranchDecision { decision, boxes, routes: RouteBatch::of(&routes) }
            }
        }
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let (decision, boxes, routes) = match body {
            Body::Decision { decision, boxes, routes } => {
                (decision, boxes, vec![std::mem::take(&mut **routes)])
            }
            Body::BranchDecision { decision, boxes, routes } => (decision, boxes, routes.to_routes()),
            _ => return None,
        };
        Some(Decided { decision: decision.clone(), boxes: std::mem::take(&mut boxes.0), routes })
    }

    fn fits(&self, members: usize) -> bool {
        self.routes.len() == members
    }
}

impl<P: Point> Divided<P> for Decided<P> {
    fn split_off(&mut self, members: usize) -> Self {
        let start = self.routes.len().saturating_sub(members);
        let routes = self.routes.split_off(start);
        Decided { decision: self.decision.clone(), boxes: self.boxes.clone(), routes }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn through_a_message<T: Parts<DVec2>>(value: T) -> T {
        let mut body = value.into_body();
        assert_eq!(body.defect(9), None);
        T::take_from(&mut body).expect("a value of its own kind")
    }

    fn counts(inside: u64, at: f64) -> SideCounts<DVec2> {
        let [low, high] = [at, at + 1.0].map(DVec2::splat);
        SideCounts { inside: vec![inside], outside: vec![inside + 1], boxes: vec![low, high, -high, -low] }
    }

    #[test]
    fn counts_keep_the_counts_of_each_member_and_join_the_boxes() {
        let mut all = counts(4, 2.0);
        assert!(matches!(counts(4, 2.0).into_body(), Body::Counts { inside: 4, outside: 5, .. }));
        all.append(through_a_message(counts(6, 7.0)));
        let all = through_a_message(all);
        assert!(all.fits(2) && !all.fits(1) && all.is_complete());
        assert_eq!((all.inside, all.outside), (vec![4, 6], vec![5, 7]));
        assert_eq!(all.boxes, [2.0, 8.0, -8.0, -2.0].map(DVec2::splat));
        let mut missing = counts(4, 2.0);
        missing.append(SideCounts::none());
        missing.append(counts(4, 2.0));
        assert!(missing.fits(3) && !missing.is_complete());
    }

    #[test]
    fn decisions_are_divided_by_member() {
        let route = |to: u32| {
            let mut route = Route::default();
            (1..=to).for_each(|receiver| route.push(receiver, u64::from(receiver)));
            route
        };
        let routes: Vec<[Route; 2]> = (0..4).map(|at| [route(at), route(2 * at)]).collect();
        let mut own =
            Decided { decision: Decision::Retry, boxes: vec![DVec2::ONE; 4], routes: routes.clone() };
        let last = through_a_message(own.split_off(1));
        let middle = through_a_message(own.split_off(2));
        assert!(own.fits(1) && middle.fits(2) && last.fits(1));
        assert_eq!([own.routes, middle.routes, last.routes].concat(), routes);
        assert_eq!((middle.decision, middle.boxes.len()), (Decision::Retry, 4));
    }
}
