//! Balls on their way through what one rank knows of the tree: its path of shared nodes, and its own subtree.

use septet_geometry::coordinate_arrays::CoordinateArrays;
use septet_geometry::cost::Sweep;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::point::Point;
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::NodeId;

use crate::machine::tasks::Reach;
use crate::neighbours::ask::Ask;
use crate::state::subdomain::{Shared, Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::{Bounds, Split, Tree};

/// What a walk needs of a rank.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a, P: Point> {
    pub(crate) subdomain: &'a Subdomain<P>,
    pub(crate) table: &'a Table<P>,
    /// The home points of each leaf in blocks, if lists are looked for.
    pub(crate) blocks: &'a [KdBlocks<P>],
    /// Whether to record which nodes the balls reach.
    pub(crate) recorded: bool,
}

impl<'a, P: Point> Ground<'a, P> {
    /// Starts a walk, which has counted nothing yet.
    pub(crate) fn walk(self, ask: Ask) -> Walk<'a, P> {
        let Ground { subdomain, table, blocks, recorded } = self;
        let (shared, local) = (subdomain.path().len(), subdomain.inner_ids().len());
        Walk {
            subdomain,
            owned_points: table.coordinates(),
            blocks,
            ask,
            around: Around {
                ball: (P::default(), f64::INFINITY),
                shared: vec![None; shared],
                local: vec![None; local],
            },
            counts: Counts {
                shared: vec![Visits::default(); shared],
                local: vec![Visits::default(); local],
                at_leaf: vec![AtLeaf::default(); subdomain.leaves().len()],
                reach: Reach::new(recorded),
            },
        }
    }
}

/// One walk of balls through what a rank knows of the tree, with its own counters.
pub(crate) struct Walk<'a, P: Point> {
    subdomain: &'a Subdomain<P>,
    owned_points: &'a CoordinateArrays<P>,
    blocks: &'a [KdBlocks<P>],
    ask: Ask,
    around: Around<P>,
    counts: Counts,
}

/// A ball around all balls of one leaf. Where it does not cross a separator, none of them does. Each node, shared or
/// local, is tested once.
struct Around<P> {
    ball: (P, f64),
    shared: Vec<Option<bool>>,
    local: Vec<Option<bool>>,
}

impl<P: Point> Around<P> {
    fn enter(&mut self, bounds: Bounds<P>, largest2: f64) {
        self.ball = ball_around(bounds, largest2);
        self.shared.fill(None);
        self.local.fill(None);
    }
}

/// A ball that holds all balls of at most this squared radius around points of the box. The box is taken as seen from the
/// centre as it was rounded, which far from the origin may be off by more than the box is wide; what is added covers the
/// roundings that are left, all relative to the radius.
fn ball_around<P: Point>((low, high): Bounds<P>, largest2: f64) -> (P, f64) {
    let centre = low + (high - low) * 0.5;
    let mut half = P::default();
    for k in 0..P::DIM {
        half.set_coord(k, (high.coord(k) - centre.coord(k)).max(centre.coord(k) - low.coord(k)));
    }
    (centre, (half.norm2().sqrt() + largest2.sqrt()) * (1.0 + 1e-9))
}

/// A ball under way.
#[derive(Clone, Copy)]
pub(crate) struct Probe<P> {
    pub(crate) centre: P,
    pub(crate) radius2: f64,
    /// The leaf where it is at home, if that lies below.
    pub(crate) owned: Option<NodeId>,
}

/// Which children of a node a ball goes to. A ball of the walk's leaf goes to the far side only if the ball around all
/// of them crosses the separator, which is `known` after the first test.
fn sides<P: Point>(
    (id, split): (NodeId, &Split<P>),
    ball: &Probe<P>,
    probe: bool,
    (around, known): ((P, f64), &mut Option<bool>),
) -> [bool; 2] {
    match ball.owned {
        Some(leaf) => {
            let owned = id.side_of(leaf);
            let meets = *known.get_or_insert_with(|| split.separator().crosses(around.0, around.1));
            let mut sides = [true; 2];
            sides[1 - owned] = meets && split.reaches(ball.centre, ball.radius2, 1 - owned);
            sides
        }
        None if probe => {
            let mut sides = [false; 2];
            sides[split.side(ball.centre)] = true;
            sides
        }
        None => [0, 1].map(|side| split.reaches(ball.centre, ball.radius2, side)),
    }
}

/// What a walk counted.
pub(crate) struct Counts {
    /// Of each shared node of the path.
    pub(crate) shared: Vec<Visits>,
    /// Of each inner node of the rank's own subtree.
    pub(crate) local: Vec<Visits>,
    /// Of each leaf.
    pub(crate) at_leaf: Vec<AtLeaf>,
    pub(crate) reach: Reach,
}

/// Balls that visited an inner node: all, and those that went on to both of its sides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Visits {
    pub(crate) down: Sweep,
    pub(crate) both: Sweep,
}

impl Visits {
    /// Counts a ball.
    pub(crate) fn visit(&mut self, both: bool) {
        self.down.visit();
        if both {
            self.both.visit();
        }
    }

    /// Adds those that were counted elsewhere.
    pub(crate) fn join(&mut self, other: &Visits) {
        self.down.join(&other.down);
        self.both.join(&other.both);
    }
}

/// Balls that visited a leaf, and the pairs of them and its points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AtLeaf {
    pub(crate) pairs: Sweep,
    pub(crate) visits: u64,
}

impl<P: Point> Walk<'_, P> {
    /// Balls of this leaf are next, the largest of this squared radius.
    pub(crate) fn start(&mut self, leaf: usize, largest2: f64) {
        self.counts.reach.start(leaf);
        self.around.enter(self.subdomain.leaves()[leaf].bounds(), largest2);
    }

    /// What it counted, once it is over.
    pub(crate) fn into_counts(self) -> Counts {
        self.counts
    }

    /// Counts a ball at a local inner node, from which it goes to both sides or not.
    pub(crate) fn visit_local(&mut self, number: usize, both: bool) {
        self.counts.local[number].visit(both);
    }

    /// Follows a ball from position `start` of the path, then through the rank's own subtree; collects the ways out
    /// and the points found.
    pub(crate) fn follow(
        &mut self,
        start: usize,
        ball: &Probe<P>,
        ways: &mut Vec<Way>,
        found: &mut NeighbourList,
    ) {
        let Walk { subdomain, ask, around, counts, .. } = self;
        let reach = |level: usize, shared: &Shared<P>| {
            let known = &mut around.shared[level];
            let sides = sides((shared.id(), shared.split()), ball, ask.probe, (around.ball, known));
            counts.shared[level].visit(sides[0] && sides[1]);
            sides
        };
        let arrives = subdomain.follow(start, reach, |way| ways.push(way));
        if arrives && let Some(tree) = self.subdomain.tree() {
            self.down(tree, ball, found);
        }
    }

    /// Follows a ball through a subtree; collects the points found.
    pub(crate) fn down(&mut self, tree: &Tree<P>, ball: &Probe<P>, found: &mut NeighbourList) {
        match tree {
            Tree::Leaf(at) => self.at_leaf(*at, ball, found),
            Tree::Node(inner) => {
                let here = Probe { owned: ball.owned.filter(|&leaf| inner.id().contains(leaf)), ..*ball };
                let known = &mut self.around.local[inner.number()];
                let node = (inner.id(), inner.split());
                let sides = sides(node, &here, self.ask.probe, (self.around.ball, known));
                self.counts.local[inner.number()].visit(sides[0] && sides[1]);
                for (side, child) in inner.children().iter().enumerate() {
                    if sides[side] {
                        let on_way = here.owned.filter(|&leaf| inner.id().side_of(leaf) == side);
                        let before = found.len();
                        self.down(child, &Probe { owned: on_way, ..here }, found);
                        if on_way.is_none() {
                            let wanted = self.ask.wanted as usize;
                            self.counts.reach.found(
                                inner.id().child(side),
                                found.iter().skip(before),
                                wanted,
                                ball.radius2,
                            );
                        }
                    }
                }
            }
        }
    }

    fn at_leaf(&mut self, at: usize, ball: &Probe<P>, found: &mut NeighbourList) {
        let leaf = &self.subdomain.leaves()[at];
        if ball.owned == Some(leaf.id()) && !self.ask.own_leaf {
            return;
        }
        let AtLeaf { pairs, visits } = &mut self.counts.at_leaf[at];
        *visits += 1;
        if let Some(blocks) = self.blocks.get(at) {
            pairs.each_in_blocks(blocks, ball.centre, ball.radius2, leaf.start(), found);
            return;
        }
        let owned_points = leaf.indices();
        let mut limit2 = ball.radius2;
        let nearest_only = self.ask.wanted == 1;
        pairs.each_distance(self.owned_points, owned_points, ball.centre, limit2, |at, d2| {
            // No two points coincide: distance zero is the centre itself.
            if d2 > 0.0 {
                found.push((d2, leaf.start() + at as u32));
                limit2 = if nearest_only { d2 } else { limit2 };
            }
            limit2
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::separator::Separator;

    use super::*;

    /// Every ball of the box reaches no farther than the ball around them, in integers.
    #[test]
    fn the_ball_around_a_box_holds_it_far_from_the_origin() {
        let far = 2f64.powi(52);
        // The middle of 31 is no integer, and between 2^52 and 2^53 there are only integers.
        for wide in [1.0, 2.0, 31.0, 33.0, 1e6 + 1.0] {
            for from in [0.0, 1.0, 2.0, 3.0] {
                let low = DVec2::splat(far + from);
                let high = low + DVec2::splat(wide);
                let (centre, radius) = ball_around((low, high), 4.0);
                for corner in [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)] {
                    let away = corner - centre;
                    assert!(away.length() + 2.0 <= radius, "{wide} {from}: {away} {radius}");
                }
            }
        }
        let (centre, radius) = ball_around((DVec3::ZERO, DVec3::splat(2.0)), 0.0);
        assert!(centre == DVec3::ONE && (radius - 3f64.sqrt()).abs() < 1e-8);
    }

    /// With the ball around all of them a ball goes to the far side where it does without it.
    #[test]
    fn the_ball_around_a_leaf_keeps_no_ball_from_the_far_side() {
        let far = 2f64.powi(52);
        // Of the flat one the middle is rounded away from the cuts, by as much as its balls reach beyond them.
        let mut went = 0;
        for (width, height, cut) in [(32, 32, 31), (32, 1, 33)]
            .into_iter()
            .flat_map(|(w, h, c)| (c..c + 4).map(move |cut| (w, h, cut)))
        {
            let low = DVec2::new(far + f64::from(1 - i32::from(height > 1)), far);
            let leaf = (low, low + DVec2::new(f64::from(width - 1), f64::from(height - 1)));
            let beyond = far + f64::from(cut);
            let separator = Separator::plane(0, beyond);
            let other = (DVec2::new(beyond, far), DVec2::new(beyond + 31.0, far + 31.0));
            let split = Split::new(separator, [leaf, other]);
            let mut known = [None; 3];
            for (at, largest) in [1.0f64, 2.0, 4.0].into_iter().enumerate() {
                let around = ball_around(leaf, largest * largest);
                for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                    let centre = low + DVec2::new(f64::from(x), f64::from(y));
                    let id = NodeId::ROOT;
                    let ball = Probe { centre, radius2: largest * largest, owned: Some(id.child(0)) };
                    let sides = sides((id, &split), &ball, false, (around, &mut known[at]));
                    assert_eq!(sides, [true, split.reaches(centre, ball.radius2, 1)], "{cut} {x} {y}");
                    went += u32::from(sides[1]);
                }
            }
        }
        assert!(went > 100, "{went}");
    }
}
