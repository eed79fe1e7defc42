//! How the set of a node is shared by its children, and who decides it.
//!
//! **Statement** (paper, Section 4.3). See `crate::graph::separator_sets`. The leader of a shared node sums its members' counts
//! and tells them which crossing points go to both children, or that the set is not divided.

use std::collections::BTreeMap;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;
use septet_protocol::message::{Body, Message, SetCounts, SetDecision};

use crate::config::SetRule;
use crate::machine::context::Context;
use crate::state::subdomain::Group;

/// A set whose larger child holds more than this share of it is not divided further.
const STOP_SHARE: f64 = 0.93;

/// Where a member of a set is: its side of the separator, and whether its ball crosses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) side: usize,
    pub(crate) crosses: bool,
}

/// Which crossing points belong to both children's sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crossing {
    Both,
    Interior,
    Exterior,
}

impl Crossing {
    /// Whether a point at this place belongs to the set of a child.
    pub(crate) fn sends(self, place: Place, child: usize) -> bool {
        let crosses = match self {
            Crossing::Both => true,
            Crossing::Interior => place.side == 0,
            Crossing::Exterior => place.side == 1,
        };
        child == place.side || (place.crosses && crosses)
    }
}

/// What a leader decides about a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sharing {
    /// It is not divided.
    Stop,
    /// It is divided.
    Crossing(Crossing),
}

impl Sharing {
    /// Decides from the numbers of interior and exterior points, and of those among them whose balls cross.
    pub(crate) fn decide(sum: [u64; 4], rule: SetRule) -> Self {
        let [inside, outside, crossing_inside, crossing_outside] = sum;
        let (crossing, children) = match rule {
            SetRule::Smaller if crossing_inside <= crossing_outside => {
                (Crossing::Interior, [inside, outside + crossing_inside])
            }
            SetRule::Smaller => (Crossing::Exterior, [inside + crossing_outside, outside]),
            _ => (Crossing::Both, [inside + crossing_outside, outside + crossing_inside]),
        };
        let larger = children[0].max(children[1]) as f64;
        if larger > STOP_SHARE * (inside + outside) as f64 {
            Sharing::Stop
        } else {
            Sharing::Crossing(crossing)
        }
    }
}

impl From<Sharing> for SetDecision {
    fn from(sharing: Sharing) -> Self {
        match sharing {
            Sharing::Stop => SetDecision::Stop,
            Sharing::Crossing(Crossing::Both) => SetDecision::Both,
            Sharing::Crossing(Crossing::Interior) => SetDecision::Interior,
            Sharing::Crossing(Crossing::Exterior) => SetDecision::Exterior,
        }
    }
}

impl From<SetDecision> for Sharing {
    fn from(decision: SetDecision) -> Self {
        match decision {
            SetDecision::Stop => Sharing::Stop,
            SetDecision::Both => Sharing::Crossing(Crossing::Both),
            SetDecision::Interior => Sharing::Crossing(Crossing::Interior),
            SetDecision::Exterior => Sharing::Crossing(Crossing::Exterior),
        }
    }
}

/// The message of a member's counts.
pub(crate) fn counts_of([inside, outside, crossing_inside, crossing_outside]: [u64; 4]) -> SetCounts {
    SetCounts { inside, outside, crossing_inside, crossing_outside }
}

/// The rule for a supergraph: the points of one side suffice for the density graph only, so for the others both sides
/// are taken.
pub(crate) fn set_rule(rule: SetRule, supergraph: Supergraph) -> SetRule {
    match (rule, supergraph) {
        (SetRule::Smaller, Supergraph::Knn { .. } | Supergraph::Overlap { .. }) => SetRule::Both,
        (rule, _) => rule,
    }
}

/// Decides on the sets of the nodes that this rank leads, and whose members' counts are here.
pub(crate) fn lead<P: Point>(cx: &mut Context<P>, led: &[Group], rule: SetRule) {
    let mut sums: BTreeMap<NodeId, [u64; 4]> = BTreeMap::new();
    for (node, counts) in cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::SetCounts(counts) => Some((m.node, *counts)),
        _ => None,
    }) {
        let sum = sums.entry(node).or_default();
        let SetCounts { inside, outside, crossing_inside, crossing_outside } = counts;
        let counts = [inside, outside, crossing_inside, crossing_outside];
        sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    for (node, sum) in sums {
        let Some(group) = led.iter().find(|group| group.node == node) else { continue };
        let sharing = Sharing::decide(sum, rule);
        cx.broadcast(group, 0, || Body::SetDecision(sharing.into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Sharing; 4] = [
        Sharing::Stop,
        Sharing::Crossing(Crossing::Both),
        Sharing::Crossing(Crossing::Interior),
        Sharing::Crossing(Crossing::Exterior),
    ];

    #[test]
    fn decisions_survive_the_wire() {
        for sharing in ALL {
            assert_eq!(Sharing::from(SetDecision::from(sharing)), sharing);
        }
    }

    #[test]
    fn the_smaller_side_crosses_and_large_sets_stop() {
        let [stop, both, interior, exterior] = ALL;
        for (sum, smaller, paper) in [
            ([50, 50, 10, 20], interior, both),
            ([50, 50, 20, 10], exterior, both),
            ([50, 50, 44, 0], exterior, stop),
            ([90, 10, 4, 4], interior, stop),
            ([94, 6, 0, 0], stop, stop),
        ] {
            assert_eq!(Sharing::decide(sum, SetRule::Smaller), smaller, "{sum:?}");
            assert_eq!(Sharing::decide(sum, SetRule::Both), paper, "{sum:?}");
        }
    }

    #[test]
    fn crossing_points_of_the_chosen_side_go_to_both_children() {
        let sides = |crossing: Crossing, side: usize, crosses: bool| {
            [0, 1].map(|child| crossing.sends(Place { side, crosses }, child))
        };
        for side in 0..2 {
            let owned = [side == 0, side == 1];
            for crossing in [Crossing::Both, Crossing::Interior, Crossing::Exterior] {
                assert_eq!(sides(crossing, side, false), owned);
            }
            assert_eq!(sides(Crossing::Both, side, true), [true; 2]);
        }
        assert_eq!(sides(Crossing::Interior, 0, true), [true; 2]);
        assert_eq!(sides(Crossing::Interior, 1, true), [false, true]);
        assert_eq!(sides(Crossing::Exterior, 0, true), [true, false]);
        assert_eq!(sides(Crossing::Exterior, 1, true), [true; 2]);
    }
}
