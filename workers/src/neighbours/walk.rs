//! Balls on their way through the part of the tree that one rank holds: its path of shared nodes and its own subtree.

use septet_geometry::coordinate_arrays::CoordinateArrays;
use septet_geometry::cost::Sweep;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::point::Point;
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::NodeId;

use crate::neighbours::search::Search;
use crate::state::subdomain::{Shared, Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::{Bounds, Leaf, Split, Tree};

/// The part of the tree that a rank holds, and its points.
#[derive(Clone, Copy)]
pub(crate) struct SearchSpace<'a, P: Point> {
    pub(crate) subdomain: &'a Subdomain<P>,
    pub(crate) table: &'a Table<P>,
    /// The owned points of each leaf in blocks. Empty if balls search for one point only.
    pub(crate) blocks: &'a [KdBlocks<P>],
}

impl<'a, P: Point> SearchSpace<'a, P> {
    /// Starts a walk with counts of zero.
    pub(crate) fn walk(self, search: Search) -> BallWalk<'a, P> {
        let SearchSpace { subdomain, table, blocks } = self;
        let (shared, local) = (subdomain.path().len(), subdomain.inner_ids().len());
        BallWalk {
            subdomain,
            owned_points: table.coordinates(),
            blocks,
            search,
            enclosing: EnclosingBall {
                ball: Enclosure { centre: P::default(), radius: f64::INFINITY },
                shared: vec![None; shared],
                local: vec![None; local],
            },
            counts: DenseCounts {
                shared: vec![Visits::default(); shared],
                local: vec![Visits::default(); local],
                at_leaf: vec![LeafVisits::default(); subdomain.leaves().len()],
            },
        }
    }
}

/// A walk of balls through the part of the tree that one rank holds, with its own counts.
pub(crate) struct BallWalk<'a, P: Point> {
    subdomain: &'a Subdomain<P>,
    owned_points: &'a CoordinateArrays<P>,
    blocks: &'a [KdBlocks<P>],
    search: Search,
    enclosing: EnclosingBall<P>,
    counts: DenseCounts,
}

/// A ball that contains all balls of one leaf.
#[derive(Clone, Copy, Debug)]
struct Enclosure<P> {
    centre: P,
    radius: f64,
}

/// A ball that contains all balls of one leaf, and the separators that it crosses. If it does not cross a separator,
/// the balls of the leaf do not cross it either. Each node is tested once.
struct EnclosingBall<P> {
    ball: Enclosure<P>,
    /// For each shared node, whether the ball crosses its separator. `None` before the test.
    shared: Vec<Option<bool>>,
    /// For each inner node of this rank's subtree, whether the ball crosses its separator. `None` before the test.
    local: Vec<Option<bool>>,
}

impl<P: Point> EnclosingBall<P> {
    fn enter(&mut self, bounds: Bounds<P>, largest2: f64) {
        self.ball = enclosure(bounds, largest2);
        self.shared.fill(None);
        self.local.fill(None);
    }
}

/// Returns a ball that contains every ball with centre in the box and squared radius at most `largest2`.
///
/// Far from the origin, the rounded centre may be off by more than the width of the box. The half widths are therefore
/// measured from the rounded centre. The factor covers the remaining rounding errors, all of which are relative to the
/// radius.
fn enclosure<P: Point>((low, high): Bounds<P>, largest2: f64) -> Enclosure<P> {
    let centre = low + (high - low) * 0.5;
    let mut half = P::default();
    for k in 0..P::DIM {
        half.set_coord(k, (high.coord(k) - centre.coord(k)).max(centre.coord(k) - low.coord(k)));
    }
    Enclosure { centre, radius: (half.norm2().sqrt() + largest2.sqrt()) * (1.0 + 1e-9) }
}

/// A ball on its way down the tree.
#[derive(Clone, Copy)]
pub(crate) struct MovingBall<P> {
    pub(crate) centre: P,
    pub(crate) radius2: f64,
    /// The leaf that owns the centre, if it lies below the current node.
    pub(crate) own_leaf: Option<NodeId>,
}

/// Returns, for each child of the node `id`, whether a ball visits it.
///
/// If the leaf that owns the centre lies below the node, `enclosure` contains the balls of that leaf. The ball visits
/// the far side only if the enclosure crosses the separator. `crosses` caches this test.
fn sides<P: Point>(
    id: NodeId,
    split: &Split<P>,
    ball: &MovingBall<P>,
    search: Search,
    enclosure: Enclosure<P>,
    crosses: &mut Option<bool>,
) -> [bool; 2] {
    match ball.own_leaf {
        Some(leaf) => {
            let own = id.side_of(leaf);
            let meets =
                *crosses.get_or_insert_with(|| split.separator().crosses(enclosure.centre, enclosure.radius));
            let mut sides = [true; 2];
            sides[1 - own] = meets && split.reaches(ball.centre, ball.radius2, 1 - own);
            sides
        }
        None if search.probe => {
            let side =
                if search.finds_centre() { split.nearest(ball.centre) } else { split.side(ball.centre) };
            let mut sides = [false; 2];
            sides[side] = true;
            sides
        }
        None => [0, 1].map(|side| split.reaches(ball.centre, ball.radius2, side)),
    }
}

/// The counts of a walk in progress.
struct DenseCounts {
    /// For each shared node of the path.
    shared: Vec<Visits>,
    /// For each inner node of this rank's subtree.
    local: Vec<Visits>,
    /// For each leaf.
    at_leaf: Vec<LeafVisits>,
}

/// The counts of the nodes that the balls of a walk visited. A group of balls visits few nodes of a large subtree.
pub(crate) struct BallCounts {
    /// The inner nodes, shared or local.
    pub(crate) inner: Vec<(NodeId, Visits)>,
    /// The leaves.
    pub(crate) leaves: Vec<(NodeId, LeafVisits)>,
}

/// The balls that visited an inner node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Visits {
    /// All balls that visited the node.
    pub(crate) down: Sweep,
    /// The balls that continued to both children.
    pub(crate) both: Sweep,
}

impl Visits {
    /// Counts a ball. `both` is `true` if it continues to both children.
    pub(crate) fn visit(&mut self, both: bool) {
        self.down.visit();
        if both {
            self.both.visit();
        }
    }

    /// Adds the counts of another walk.
    pub(crate) fn join(&mut self, other: &Visits) {
        self.down.join(&other.down);
        self.both.join(&other.both);
    }
}

/// The balls that visited a leaf.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LeafVisits {
    /// The pairs of a ball and a point of the leaf.
    pub(crate) pairs: Sweep,
    /// The number of balls.
    pub(crate) visits: u64,
}

impl<P: Point> BallWalk<'_, P> {
    /// Prepares the walk for the balls of a leaf, whose squared radii are at most `largest2`.
    pub(crate) fn start(&mut self, leaf: usize, largest2: f64) {
        self.enclosing.enter(self.subdomain.leaves()[leaf].bounds(), largest2);
    }

    /// Ends the walk and returns its counts.
    pub(crate) fn into_counts(self) -> BallCounts {
        let BallWalk { subdomain, counts: DenseCounts { shared, local, at_leaf }, .. } = self;
        let shared = subdomain.path().iter().map(Shared::id).zip(shared);
        let local = subdomain.inner_ids().iter().copied().zip(local);
        let leaves = subdomain.leaves().iter().map(Leaf::id).zip(at_leaf);
        BallCounts {
            inner: shared.chain(local).filter(|(_, visits)| visits.down.items() > 0).collect(),
            leaves: leaves.filter(|(_, counted)| counted.visits > 0).collect(),
        }
    }

    /// Counts a ball at the inner node `number` of this rank's subtree. `both` is `true` if it continues to both
    /// children.
    pub(crate) fn visit_local(&mut self, number: usize, both: bool) {
        self.counts.local[number].visit(both);
    }

    /// Follows a ball from position `start` of the path, then through this rank's subtree. Appends the ways out of the
    /// path to `ways` and the points found to `found`.
    pub(crate) fn follow(
        &mut self,
        start: usize,
        ball: &MovingBall<P>,
        ways: &mut Vec<Way>,
        found: &mut NeighbourList,
    ) {
        let BallWalk { subdomain, search, enclosing, counts, .. } = self;
        let reach = |level: usize, shared: &Shared<P>| {
            let crosses = &mut enclosing.shared[level];
            let sides = if search.everywhere {
                [true; 2]
            } else {
                sides(shared.id(), shared.split(), ball, *search, enclosing.ball, crosses)
            };
            counts.shared[level].visit(sides[0] && sides[1]);
            sides
        };
        let arrives = subdomain.follow(start, reach, |way| ways.push(way));
        if arrives && let Some(tree) = self.subdomain.tree() {
            self.down(tree, ball, found);
        }
    }

    /// Follows a ball through a subtree. Appends the points found to `found`.
    pub(crate) fn down(&mut self, tree: &Tree<P>, ball: &MovingBall<P>, found: &mut NeighbourList) {
        match tree {
            Tree::Leaf(at) => self.at_leaf(*at, ball, found),
            Tree::Node(inner) => {
                let here =
                    MovingBall { own_leaf: ball.own_leaf.filter(|&leaf| inner.id().contains(leaf)), ..*ball };
                let crosses = &mut self.enclosing.local[inner.number()];
                let enclosure = self.enclosing.ball;
                let sides = if self.search.everywhere {
                    [true; 2]
                } else {
                    sides(inner.id(), inner.split(), &here, self.search, enclosure, crosses)
                };
                self.counts.local[inner.number()].visit(sides[0] && sides[1]);
                for (side, child) in inner.children().iter().enumerate() {
                    if sides[side] {
                        let own_leaf = here.own_leaf.filter(|&leaf| inner.id().side_of(leaf) == side);
                        self.down(child, &MovingBall { own_leaf, ..here }, found);
                    }
                }
            }
        }
    }

    fn at_leaf(&mut self, at: usize, ball: &MovingBall<P>, found: &mut NeighbourList) {
        let leaf = &self.subdomain.leaves()[at];
        if ball.own_leaf == Some(leaf.id()) && !self.search.own_leaf {
            return;
        }
        let LeafVisits { pairs, visits } = &mut self.counts.at_leaf[at];
        *visits += 1;
        if let Some(blocks) = self.blocks.get(at) {
            pairs.each_in_blocks(blocks, ball.centre, ball.radius2, leaf.start(), found);
            return;
        }
        let mut limit2 = ball.radius2;
        let (nearest_only, finds_centre) = (self.search.wanted == 1, self.search.finds_centre());
        pairs.each_distance(self.owned_points, leaf.indices(), ball.centre, limit2, |at, d2| {
            // Distinct points have distinct positions, so distance zero is the centre itself.
            if d2 > 0.0 || finds_centre {
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
    use septet_protocol::ids::Phase;

    use super::*;

    /// The enclosure contains each ball with centre in the box, on integer coordinates.
    #[test]
    fn the_enclosure_of_a_box_contains_it_far_from_the_origin() {
        let far = 2f64.powi(52);
        // Half of 31 is not an integer, and all doubles between 2^52 and 2^53 are integers.
        for wide in [1.0, 2.0, 31.0, 33.0, 1e6 + 1.0] {
            for from in [0.0, 1.0, 2.0, 3.0] {
                let low = DVec2::splat(far + from);
                let high = low + DVec2::splat(wide);
                let Enclosure { centre, radius } = enclosure((low, high), 4.0);
                for corner in [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)] {
                    let away = corner - centre;
                    assert!(away.length() + 2.0 <= radius, "{wide} {from}: {away} {radius}");
                }
            }
        }
        let Enclosure { centre, radius } = enclosure((DVec3::ZERO, DVec3::splat(2.0)), 0.0);
        assert!(centre == DVec3::ONE && (radius - 3f64.sqrt()).abs() < 1e-8);
    }

    /// With and without the enclosure, a ball visits the far side in the same cases.
    #[test]
    fn the_enclosure_of_a_leaf_excludes_no_ball_that_visits_the_far_side() {
        let far = 2f64.powi(52);
        // Rounding moves the centre of the flat leaf away from the cuts, by as much as its balls extend beyond them.
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
            let mut crosses = [None; 3];
            for (at, largest) in [1.0f64, 2.0, 4.0].into_iter().enumerate() {
                let enclosure = enclosure(leaf, largest * largest);
                for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                    let centre = low + DVec2::new(f64::from(x), f64::from(y));
                    let id = NodeId::ROOT;
                    let own_leaf = Some(id.child(0));
                    let ball = MovingBall { centre, radius2: largest * largest, own_leaf };
                    let search = Search {
                        phase: Phase::Neighbours,
                        wanted: 1,
                        probe: false,
                        own_leaf: false,
                        everywhere: false,
                    };
                    let sides = sides(id, &split, &ball, search, enclosure, &mut crosses[at]);
                    assert_eq!(sides, [true, split.reaches(centre, ball.radius2, 1)], "{cut} {x} {y}");
                    went += u32::from(sides[1]);
                }
            }
        }
        assert!(went > 100, "{went}");
    }
}
