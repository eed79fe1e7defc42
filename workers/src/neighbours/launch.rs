//! The first walk of the balls of owned points, through the part of the tree that their rank holds.

use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::{Point, dist2};
use septet_geometry::selection::NeighbourList;

use crate::neighbours::results::Part;
use crate::neighbours::search::{Ball, Search};
use crate::neighbours::walk::{BallCounts, MovingBall, SearchSpace};
use crate::state::subdomain::Way;
use crate::state::tree::Leaf;

/// Balls after a walk, with the points that they found and the ways by which they leave the path.
#[derive(Default)]
pub(crate) struct WalkedBalls {
    balls: Vec<u32>,
    found: Lists<u32>,
    ways: Lists<Way>,
}

/// A ball after its walk.
pub(crate) struct WalkedBall<'a> {
    /// Its index in the batch or group.
    pub(crate) ball: usize,
    /// The points found.
    pub(crate) found: &'a [u32],
    /// The ways by which it leaves the path.
    pub(crate) ways: &'a [Way],
}

impl WalkedBalls {
    /// Adds the ball with the index `ball`.
    pub(crate) fn push(&mut self, ball: usize, found: impl IntoIterator<Item = u32>, ways: &[Way]) {
        self.balls.push(ball as u32);
        self.found.push(found);
        self.ways.push(ways.iter().copied());
    }

    /// Returns the number of balls.
    pub(crate) fn len(&self) -> usize {
        self.balls.len()
    }

    /// Returns the balls, in the order in which they were added.
    pub(crate) fn iter(&self) -> impl Iterator<Item = WalkedBall<'_>> {
        let lists = self.found.iter().zip(self.ways.iter());
        self.balls.iter().zip(lists).map(|(&ball, (found, ways))| WalkedBall {
            ball: ball as usize,
            found,
            ways,
        })
    }

    /// Returns the points found, one list for each ball.
    pub(crate) fn into_found(self) -> Lists<u32> {
        self.found
    }
}

/// A group of balls after their first walk.
pub(crate) struct WalkedGroup {
    /// The complete lists of the balls that do not leave the path.
    pub(crate) complete: Part,
    /// The balls that leave the path, by their indices in the group.
    pub(crate) leaving: WalkedBalls,
    pub(crate) counts: BallCounts,
}

/// The input of a first walk.
#[derive(Clone, Copy)]
pub(crate) struct LaunchInput<'a> {
    /// For each leaf, the nearest points of its points within the leaf. `None` if they were not searched.
    pub(crate) known: Option<&'a [NearestLists]>,
    /// For each leaf, the largest squared radius of its balls.
    pub(crate) largest2: &'a [f64],
}

/// Returns, for each leaf, the largest squared radius of its balls.
pub(crate) fn largest_balls<P>(leaves: &[Leaf<P>], balls: &[Ball]) -> Vec<f64> {
    let mut largest2 = vec![0.0; leaves.len()];
    for ball in balls {
        let most: &mut f64 = &mut largest2[ball.leaf];
        *most = most.max(ball.radius2);
    }
    largest2
}

/// Walks a group of balls through the part of the tree that this rank holds.
pub(crate) fn walk_balls<P: Point>(
    space: SearchSpace<P>,
    search: Search,
    group: &[Ball],
    input: LaunchInput,
) -> WalkedGroup {
    let (positions, leaves) = (space.table.positions(), space.subdomain.leaves());
    let mut walk = space.walk(search);
    let mut complete = Part::with_capacity(group.len(), group.len() * search.wanted as usize);
    let mut leaving = WalkedBalls::default();
    let (mut found, mut ways) = (NeighbourList::default(), Vec::new());
    let mut before = None;
    for (at, ball) in group.iter().enumerate() {
        let leaf = &leaves[ball.leaf];
        if before != Some(ball.leaf) {
            before = Some(ball.leaf);
            walk.start(ball.leaf, input.largest2[ball.leaf]);
        }
        let centre = positions[ball.point as usize];
        found.clear();
        ways.clear();
        let moving = MovingBall { centre, radius2: ball.radius2, own_leaf: Some(leaf.id()) };
        walk.follow(0, &moving, &mut ways, &mut found);
        let own = input.known.map(|leaves| leaves[ball.leaf].of(ball.point - leaf.start()));
        if let Some((kth2, list)) = own
            && found.is_empty()
            && ways.is_empty()
            && kth2 <= ball.radius2
        {
            // The list from the ball's own leaf is already complete.
            complete.push(ball.point, kth2, list.iter().copied());
            continue;
        }
        found.extend(own.map_or(&[], |own| own.1), |j| dist2(positions[j as usize], centre));
        let kth2 = found.keep_nearest(search.wanted as usize, ball.radius2);
        let list = found.positions().iter().copied();
        if ways.is_empty() {
            complete.push(ball.point, kth2, list);
        } else {
            leaving.push(at, list, &ways);
        }
    }
    WalkedGroup { complete, leaving, counts: walk.into_counts() }
}
