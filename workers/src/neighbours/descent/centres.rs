//! Balls with any centres, each of which visits one leaf, or all leaves that it meets.
//!
//! **Statement.** A ball goes down the tree from the root. At each node, it goes to the child whose box of points is nearest to
//! its centre. If both are equally near, for example if both contain the centre, the side of the centre decides. So a ball has no
//! replicas. It returns with the nearest point of the leaf in the ball. Points that tie all return.
//!
//! The leaf is a function of the tree: [`Separator::side`](septet_geometry::separator::Separator::side) decides ties. The answers
//! therefore depend on the tree, and not on the ranks.
//!
//! **Departure.** The leaf that holds the centre is a worse choice if the centre is far from all points, as in the free space around
//! a surface: the nearest point is then often beyond a separator.
//!
//! **Work and depth.** At each node, the replication of its balls, which is an upper bound. At a leaf, all pairs of its balls and
//! points. Each level of the tree is a step of the phase.
//!
//! **Rounds.** At most twice the number of shared levels.

use septet_geometry::point::Point;
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::Phase;

use super::{Descent, GROUP, WaitingBall};
use crate::machine::context::Context;
use crate::neighbours::launch::{WalkedBall, WalkedBalls};
use crate::neighbours::results::CompletedLists;
use crate::neighbours::router::QueryRouter;
use crate::neighbours::search::Search;
use crate::neighbours::walk::{BallCounts, MovingBall, SearchSpace};
use crate::state::table::Table;

/// The search of a ball with any centre. A point at the centre is found, too.
pub(crate) const AT_CENTRE: Search =
    Search { phase: Phase::ProbeCells, wanted: 1, probe: true, own_leaf: true, everywhere: false };

/// The search of all leaves that a ball with any centre meets, with replicas as in a descent.
pub(crate) const IN_BALL: Search = Search { probe: false, ..AT_CENTRE };

/// A ball with any centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Centre<P> {
    /// The centre.
    pub(crate) at: P,
    /// The squared radius.
    pub(crate) radius2: f64,
    /// The leaf that asks. Consecutive balls of one leaf travel together.
    pub(crate) leaf: u32,
}

impl<P: Point> Descent<'_, P> {
    /// Sends balls down the tree. The list of a ball has the position of the ball in the place of an owned point.
    pub(crate) fn launch_centres(&mut self, cx: &mut Context<P>, table: &Table<P>, balls: &[Centre<P>]) {
        let groups: Vec<&[Centre<P>]> = balls.chunks(GROUP).collect();
        let (space, search) = (self.space(table), self.search);
        let walked = cx.map(&groups, |group| walk_centres(space, search, group));
        let mut router = QueryRouter::new(cx.rank(), search);
        for ((walked, counts), start) in walked.iter().zip((0..).step_by(GROUP)) {
            self.tallies.add(cx, search.phase, counts);
            // The points found by the balls that leave the path.
            let (block, mut numbers) = (self.chains.next_block(), Vec::new());
            for WalkedBall { ball, found, ways } in walked.iter() {
                let Centre { at, radius2, leaf } = balls[start + ball];
                let number = (start + ball) as u32;
                if ways.is_empty() {
                    self.complete.push(number, radius2, found.iter().copied());
                } else {
                    let mut waiting = WaitingBall::of_owned(number, at, radius2);
                    self.chains.add(&mut waiting.list, block, numbers.len()..numbers.len() + found.len());
                    numbers.extend_from_slice(found);
                    self.forward(&mut router, ways, u64::from(leaf), waiting);
                }
            }
            self.chains.add_block(numbers);
        }
        router.send(cx);
    }

    /// Takes the lists that were completed since the last call.
    pub(crate) fn take_complete(&mut self) -> CompletedLists {
        std::mem::take(&mut self.complete)
    }

    /// Charges step number `step` of the phase and the steps of the levels after it.
    pub(crate) fn finish_cells(self, cx: &mut Context<P>, step: u32) {
        self.tallies.charge_cells(cx, step);
    }
}

/// Walks a group of balls from the root.
fn walk_centres<P: Point>(
    space: SearchSpace<'_, P>,
    search: Search,
    group: &[Centre<P>],
) -> (WalkedBalls, BallCounts) {
    let mut walk = space.walk(search);
    let (mut walked, mut found, mut ways) = (WalkedBalls::default(), NeighbourList::default(), Vec::new());
    for (number, &Centre { at, radius2, .. }) in group.iter().enumerate() {
        found.clear();
        ways.clear();
        walk.follow(0, &MovingBall { centre: at, radius2, own_leaf: None }, &mut ways, &mut found);
        found.keep_nearest(search.wanted as usize, radius2);
        walked.push(number, found.positions().iter().copied(), &ways);
    }
    (walked, walk.into_counts())
}
