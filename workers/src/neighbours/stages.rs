//! The bottom-up correction in a constant number of stages at each node.
//!
//! **Statement.** Balls are corrected node by node from the leaves up ([`crate::neighbours::bottom_up`]). At a node of `m`
//! points with `c` crossing balls, one of two corrections takes place:
//! 1. If `c <= m^(1-1/d) log m`, the balls march down the tree beyond the separator in *stages*. One stage covers a
//!    *block* of levels at once. If the node has `h` levels below it, the `h - 1` of them that have inner nodes form `d`
//!    blocks, whose numbers of levels differ by at most 1. So a node has `d` stages, whatever its size and its shape are,
//!    and fewer only if `h <= d`.
//! 2. Otherwise the node *punts*: the balls descend level by level.
//!
//! **A stage.** A ball that arrives at the root of a block of `J` levels has `2^J - 1` places, one for each possible node.
//! 1. A copy-scan copies the ball to its places. In a vector step, each place tests its node. A scan over the Euler tour of
//!    the block then counts the nodes above each place that the ball misses.
//! 2. A scan computes the positions of the replicas below the block: those with no missed node above. A vector step moves
//!    them. A copy-scan copies the ball to them.
//! 3. On the way up, a vector step moves the results of replicas to the places of their ball, and a segmented reduction takes
//!    the nearest. A copy-scan distributes it.
//!
//! Each of the three is charged as all pairs of a ball and a place: a copy-scan, a step and a segmented scan.
//!
//! **Source.** Frieze, Miller and Teng (1993): fast correction, and punting. Rootfix by a scan over the Euler tour: Blelloch
//! (1990).
//!
//! **Work and depth.** If the separators cut `O(m^(1-1/d))` balls, a stage has `O(m^(1-1/d) 2^(h/d))` places, which is
//! `O(m)` for a tree that is `h = log2 m + O(1)` high. A node without a punt takes O(1) depth, so all nodes take O(log n)
//! depth, and O(n log n) work in such a tree. If `h = c log2 m`, the work of a node is `O(m^(1 + (c - 1)/d))`. A node that
//! punts takes O(log m) depth.
//!
//! **Rounds.** Before the pass of a shared level, the members of each group add up their crossing balls and find the height
//! of the node. Both go up and, as sums of the group, down its tree. Then each member decides in the same way.
//!
//! **Departures.**
//! 1. Frieze, Miller and Teng bound the number of crossing balls by `m^mu` for a constant `mu` above `1 - 1/d`. The bound here
//!    has a logarithm in place of the larger exponent.
//! 2. They also punt if the replicas of a stage are too many. Here, the work of a stage counts all its replicas.
//! 3. A rank walks the balls level by level, and only to the nodes that they reach. The march decides how the ledger charges
//!    this walk.

use septet_geometry::cost::{Cost, ceil_log2};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, Crossings, Message};
use septet_protocol::transport::TransportError;

use crate::config::{Correction, Fault, WorkerConfig};
use crate::machine::context::Context;
use crate::machine::group_relay::{Ascent, Descent};
use crate::neighbours::walk::Visits;
use crate::state::subdomain::{Group, Subdomain};

/// The way in which the crossing balls of a node go down the tree beyond its separator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum March {
    /// Level by level, without a decision.
    Levels,
    /// Level by level, because too many balls cross the separator.
    Punt,
    /// In stages, one for each block.
    Stages(Blocks),
}

/// The blocks below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    /// The number of levels of inner nodes below the node.
    levels: u32,
    /// The largest number of blocks.
    most: u32,
}

/// A node whose balls are corrected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossed {
    /// Number of its points.
    pub(crate) population: u64,
    /// Its balls that cross its separator, and its height.
    pub(crate) crossings: Crossings,
}

impl March {
    /// Decides how the balls of a node march.
    pub(crate) fn of<P: Point>(config: &WorkerConfig, node: Crossed) -> March {
        match config.graph.correction {
            Correction::Stages if node.punts(P::DIM, config.fault) => March::Punt,
            Correction::Stages => March::Stages(Blocks::below(node.crossings.height, P::DIM)),
            Correction::BottomUp | Correction::Descent | Correction::Pairs => March::Levels,
        }
    }

    /// Charges the visits of a node in the pass of the balls of its ancestor at `level`, or of its own balls. `meter` is an
    /// empty meter.
    pub(crate) fn charge(self, meter: &Cost, (level, node): (u32, NodeId), visits: Visits) -> Cost {
        let Visits { down, both } = visits;
        let mut cost = meter.fresh();
        match self {
            March::Stages(blocks) if node.level() > level => {
                if let Some(levels) = blocks.at(node.level() - level - 1) {
                    let places = down.of_parts((1 << levels) - 1);
                    (0..3).for_each(|_| cost.charge_pairs(places));
                }
            }
            March::Levels | March::Punt | March::Stages(_) => {
                cost.charge_replication(down);
                cost.charge_combination(both);
            }
        }
        if self != March::Levels && node.level() == level {
            // The number of crossing balls.
            cost.charge_sweep(down);
        }
        cost
    }
}

impl Crossed {
    /// Returns `true` if more than `m^(1-1/d) log2 m` balls cross the separator. Only products are compared.
    fn punts(self, dimension: usize, fault: Option<Fault>) -> bool {
        let (m, log) = (self.population as f64, ceil_log2(self.population) as f64);
        let power = |x: f64, exponent: usize| (0..exponent).fold(1.0, |product, _| product * x);
        let most = power(m, dimension - 1) * power(log, dimension);
        fault == Some(Fault::AlwaysPunt) || power(self.crossings.balls as f64, dimension) > most
    }
}

impl Blocks {
    /// Returns the blocks below a node of a height. The last level has leaves only.
    fn below(height: u64, dimension: usize) -> Self {
        let levels = height.saturating_sub(1).min(u64::from(NodeId::DEEPEST)) as u32;
        Blocks { levels, most: dimension as u32 }
    }

    /// Returns the number of levels of the block that starts at a level, where 0 is the level of the children. Returns
    /// `None` if no block starts there.
    fn at(self, level: u32) -> Option<u32> {
        let start = |block: u32| block * self.levels / self.most;
        let of_block = |block| (start(block) == level).then(|| start(block + 1) - level);
        (0..self.most).filter_map(of_block).find(|&levels| levels > 0)
    }
}

/// What the members of the shared nodes of one level know.
#[derive(Default)]
struct Sums {
    up: Ascent<Crossings>,
    down: Descent<Crossings>,
}

impl Sums {
    /// Adds what this rank knows, or the members below it. The leader passes the sum down.
    fn add<P: Point>(&mut self, cx: &mut Context<P>, group: &Group, own: Crossings) {
        if let Some(sum) = self.up.add(cx, group, |sum: Crossings| sum.join(own), Body::Crossings) {
            let node = Crossed { population: group.child.population, crossings: sum };
            cx.facts(group.node).punts += u64::from(March::of::<P>(cx.config(), node) == March::Punt);
            self.pass_down(cx, group, sum);
        }
    }

    fn pass_down<P: Point>(&mut self, cx: &mut Context<P>, group: &Group, sum: Crossings) {
        self.down.pass_down(cx, group, 0, sum, Body::Crossings);
    }

    /// Receives the sums of branches and of groups of a round.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, subdomain: &Subdomain<P>) {
        let sums = cx.take(|m: &mut Message<P>| match m.body {
            Body::Crossings(sum) => Some((m.node, m.from, sum)),
            _ => None,
        });
        for (node, from, sum) in sums {
            let Some(shared) = subdomain.shared(node) else { continue };
            if shared.group().place(cx.rank()).above() == Some(from) {
                self.pass_down(cx, shared.group(), sum);
            } else {
                self.add(cx, shared.group(), sum);
            }
        }
    }
}

/// Decides together with the members of a shared node how its balls march. `crossed` is the group of the node, if this rank
/// shares one at the current level, and what this rank knows of it. All ranks call this function in the same round, in the
/// phase of the correction, and are then at the start of a pass.
pub(crate) async fn decide<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    crossed: Option<(Group, Crossings)>,
) -> Result<March, TransportError> {
    if cx.config().graph.correction != Correction::Stages {
        return Ok(March::Levels);
    }
    let mut sums = Sums::default();
    if let Some((group, own)) = &crossed {
        sums.add(cx, group, *own);
    }
    while cx.exchange().await? {
        sums.receive(cx, subdomain);
    }
    cx.enter(Phase::Neighbours)?;
    let population = crossed.map_or(0, |(group, _)| group.child.population);
    let crossings =
        sums.down.take(u32::MAX).into_iter().next().map_or_else(Crossings::default, |(_, sum)| sum);
    Ok(March::of::<P>(cx.config(), Crossed { population, crossings }))
}

#[cfg(test)]
mod tests {
    use septet_geometry::cost::Sweep;

    use super::*;

    #[test]
    fn blocks_share_the_levels_evenly() {
        let of = |height, d| {
            let blocks = Blocks::below(height, d);
            (0..=height as u32).filter_map(|level| blocks.at(level)).collect::<Vec<u32>>()
        };
        let expected: [&[u32]; 6] = [&[], &[], &[1], &[1, 1], &[1, 1, 1], &[1, 1, 2]];
        for (height, expected) in (0..).zip(expected) {
            assert_eq!(of(height, 3), expected);
        }
        assert_eq!(of(8, 2), [3, 4]);
        for (height, d) in (4..=u64::from(NodeId::DEEPEST)).flat_map(|height| [(height, 2), (height, 3)]) {
            let blocks = of(height, d);
            assert_eq!((blocks.len(), u64::from(blocks.iter().sum::<u32>())), (d, height - 1));
            assert!(blocks.iter().max().unwrap() - blocks.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn a_node_punts_above_the_bound() {
        // In the plane, 32 * 10 balls of 1,024 points; in space, 256 * 12 balls of 4,096 points.
        for (population, most, d) in [(1024, 320, 2), (4096, 3072, 3)] {
            let punts = |balls, fault| {
                Crossed { population, crossings: Crossings { balls, height: 9 } }.punts(d, fault)
            };
            assert!(!punts(most, None) && punts(most + 1, None));
            assert!(punts(0, Some(Fault::AlwaysPunt)) && !punts(0, Some(Fault::FirstBall)));
        }
    }

    #[test]
    fn a_block_is_charged_at_its_root() {
        let meter = Cost::of_subproblem(false);
        let mut down = Sweep::default();
        (0..5).for_each(|_| down.visit());
        let visits = Visits { down, both: Sweep::default() };
        let of = |march: March, node: u64| {
            let cost = march.charge(&meter, (1, NodeId(node)), visits);
            (cost.work(), cost.depth())
        };
        // The node at level 1, its child, and the levels below: two blocks of two levels.
        let stages = March::Stages(Blocks::below(5, 2));
        assert_eq!(of(stages, 2), (5 * 8, 8));
        assert_eq!(of(stages, 4), (3 * 3 * 5 * 3, 9));
        assert_eq!(of(stages, 8), (0, 0));
        assert_eq!(of(stages, 16), (3 * 3 * 5 * 3, 9));
        assert_eq!((of(March::Punt, 2), of(March::Punt, 8)), ((5 * 8, 8), (5 * 6, 6)));
        assert_eq!(of(March::Levels, 2), (5 * 6, 6));
    }
}
