//! Balls of home points on their way through what their own rank knows of the tree.

use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::{Point, dist2};
use septet_geometry::selection::NeighbourList;

use crate::neighbours::ask::{Ask, Ball};
use crate::neighbours::results::Part;
use crate::neighbours::walk::{Counts, Ground, Probe};
use crate::state::subdomain::{Leaf, Way};

/// Balls, with what they found and their ways out.
#[derive(Default)]
pub(crate) struct Looked {
    balls: Vec<u32>,
    found: Lists<u32>,
    ways: Lists<Way>,
}

impl Looked {
    /// Adds a ball by its position.
    pub(crate) fn push(&mut self, ball: usize, found: impl IntoIterator<Item = u32>, ways: &[Way]) {
        self.balls.push(ball as u32);
        self.found.push(found);
        self.ways.push(ways.iter().copied());
    }

    /// Number of balls.
    pub(crate) fn len(&self) -> usize {
        self.balls.len()
    }

    /// Position, what was found, ways.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &[u32], &[Way])> {
        let lists = self.found.iter().zip(self.ways.iter());
        self.balls.iter().zip(lists).map(|(&ball, (found, ways))| (ball as usize, found, ways))
    }

    /// What was found, list after list.
    pub(crate) fn into_found(self) -> Lists<u32> {
        self.found
    }
}

/// A group of balls after their walk.
pub(crate) struct Walked {
    /// Those that stay, with their complete lists.
    pub(crate) done: Part,
    /// Those that leave.
    pub(crate) leaving: Looked,
    pub(crate) counts: Counts,
}

/// What a group of balls starts from.
#[derive(Clone, Copy)]
pub(crate) struct Start<'a> {
    /// What each leaf found among its own points, if it looked.
    pub(crate) known: Option<&'a [NearestLists]>,
    /// The largest squared radius of the balls of each leaf.
    pub(crate) largest2: &'a [f64],
}

/// The largest squared radius of the balls of each leaf.
pub(crate) fn largest_balls<P>(leaves: &[Leaf<P>], balls: &[Ball]) -> Vec<f64> {
    let mut largest2 = vec![0.0; leaves.len()];
    for ball in balls {
        let most: &mut f64 = &mut largest2[ball.leaf];
        *most = most.max(ball.radius2);
    }
    largest2
}

/// Walks a group of balls.
pub(crate) fn walk_balls<P: Point>(ground: Ground<P>, ask: Ask, group: &[Ball], start: Start) -> Walked {
    let (positions, leaves) = (&ground.table.positions, &ground.subdomain.leaves);
    let mut walk = ground.walk(ask);
    let mut done = Part::with_capacity(group.len(), group.len() * ask.wanted as usize);
    let mut leaving = Looked::default();
    let (mut found, mut ways) = (NeighbourList::default(), Vec::new());
    let mut before = None;
    for (at, ball) in group.iter().enumerate() {
        let leaf = &leaves[ball.leaf];
        if before != Some(ball.leaf) {
            before = Some(ball.leaf);
            walk.start(ball.leaf, start.largest2[ball.leaf]);
        }
        let centre = positions[ball.owned as usize];
        found.clear();
        ways.clear();
        let probe = Probe { centre, radius2: ball.radius2, owned: Some(leaf.id) };
        walk.follow(0, &probe, &mut ways, &mut found);
        let own = start.known.map(|leaves| leaves[ball.leaf].of(ball.owned - leaf.start));
        if let Some((kth2, list)) = own
            && found.is_empty()
            && ways.is_empty()
            && kth2 <= ball.radius2
        {
            // Its own leaf's list is complete.
            done.push(ball.owned, kth2, list.iter().copied());
            continue;
        }
        found.extend(own.map_or(&[], |own| own.1), |j| dist2(positions[j as usize], centre));
        let kth2 = found.keep_nearest(ask.wanted as usize, ball.radius2);
        let list = found.positions().iter().copied();
        if ways.is_empty() {
            done.push(ball.owned, kth2, list);
        } else {
            leaving.push(at, list, &ways);
        }
    }
    Walked { done, leaving, counts: walk.into_counts() }
}
