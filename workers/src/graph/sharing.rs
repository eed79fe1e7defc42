//! The decision on how the children of a node share its set.
//!
//! **Statement** (paper, Section 4.3; see also `crate::graph::separator_sets`). The leader of a shared node sums the
//! counts of the members of its group. It decides which crossing points go to both children, or that the set is not
//! divided, and sends the decision to the members. All members apply it in the same step.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;
use septet_protocol::message::{Body, Message, SetCounts, SetDecision};

use crate::config::{Fault, SetRule};
use crate::machine::context::Context;
use crate::machine::group_relay::{Ascent, Descent};
use crate::state::subdomain::{Group, Subdomain};

/// A set is not divided if the set of the larger child would contain more than this share of it.
const STOP_SHARE: f64 = 0.93;

/// The position of a member of a set relative to a separator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Its side: 0 is interior, 1 is exterior.
    pub(crate) side: usize,
    /// Whether its ball crosses the separator.
    pub(crate) crosses: bool,
}

/// The crossing points that belong to the sets of both children: the points of both sides, or of one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crossing {
    Both,
    Interior,
    Exterior,
}

impl Crossing {
    /// Returns `true` if a point at this position belongs to the set of `child`.
    pub(crate) fn sends(self, place: Place, child: usize) -> bool {
        let crosses = match self {
            Crossing::Both => true,
            Crossing::Interior => place.side == 0,
            Crossing::Exterior => place.side == 1,
        };
        child == place.side || (place.crosses && crosses)
    }
}

/// The decision of a leader on a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sharing {
    /// The set is not divided.
    Stop,
    /// The set is divided.
    Crossing(Crossing),
}

impl Sharing {
    /// Decides from the numbers of interior points, exterior points, crossing interior points and crossing exterior
    /// points. The planted fault [`Fault::Flood`] divides every set, although each child has all its points.
    pub(crate) fn decide(sum: [u64; 4], rule: SetRule, fault: Option<Fault>) -> Self {
        if fault == Some(Fault::Flood) {
            return Sharing::Crossing(Crossing::Both);
        }
        let [inside, outside, crossing_inside, crossing_outside] = sum;
        let (crossing, children) = match rule {
            SetRule::Smaller if crossing_inside <= crossing_outside => {
                (Crossing::Interior, [inside, outside + crossing_inside])
            }
            SetRule::Smaller => (Crossing::Exterior, [inside + crossing_outside, outside]),
            SetRule::Both | SetRule::Own | SetRule::Ghost => {
                (Crossing::Both, [inside + crossing_outside, outside + crossing_inside])
            }
        };
        if shrinks(children, inside + outside) { Sharing::Crossing(crossing) } else { Sharing::Stop }
    }
}

/// Returns `true` if the sets of both children are small enough to divide a set with this number of members.
pub(crate) fn shrinks(children: [u64; 2], members: u64) -> bool {
    children[0].max(children[1]) as f64 <= STOP_SHARE * members as f64
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

/// Returns the rule for a supergraph. Rule `smaller` is valid for the density graph only, so other graphs use rule
/// `both` instead.
pub(crate) fn set_rule(rule: SetRule, supergraph: Supergraph) -> SetRule {
    match (rule, supergraph) {
        (SetRule::Smaller, Supergraph::Knn { .. } | Supergraph::Overlap { .. }) => SetRule::Both,
        (rule, _) => rule,
    }
}

/// The counts and the decisions of sets, which go through the trees of the groups.
#[derive(Default)]
pub(crate) struct SetVotes {
    counts: Ascent<[u64; 4]>,
    decisions: Descent<Sharing>,
}

/// The rule of a run, and the current step of the phase.
#[derive(Clone, Copy)]
pub(crate) struct SetStep {
    pub(crate) rule: SetRule,
    /// The number of rounds since the phase began.
    pub(crate) step: u32,
}

impl SetVotes {
    /// Adds counts of the set of a shared node: those of this rank's share, or the sum of members below it. The leader
    /// decides when the counts of all members have arrived.
    pub(crate) fn add<P: Point>(&mut self, cx: &mut Context<P>, group: &Group, own: [u64; 4], at: SetStep) {
        let join = |sum: [u64; 4]| [0, 1, 2, 3].map(|i| sum[i] + own[i]);
        if let Some(sum) = self.counts.add(cx, group, join, |sum| Body::SetCounts(counts_of(sum))) {
            let sharing = Sharing::decide(sum, at.rule, cx.config().fault);
            self.pass_down(cx, group, sharing, at);
        }
    }

    /// Receives the counts and the decisions of a step.
    pub(crate) fn receive<P: Point>(&mut self, cx: &mut Context<P>, subdomain: &Subdomain<P>, at: SetStep) {
        for (node, SetCounts { inside, outside, crossing_inside, crossing_outside }) in
            cx.take(|m: &mut Message<P>| match m.body {
                Body::SetCounts(counts) => Some((m.node, counts)),
                _ => None,
            })
        {
            let Some(shared) = subdomain.shared(node) else { continue };
            let sum = [inside, outside, crossing_inside, crossing_outside];
            self.add(cx, shared.group(), sum, at);
        }
        for (node, decision) in cx.take(|m: &mut Message<P>| match m.body {
            Body::SetDecision(decision) => Some((m.node, decision)),
            _ => None,
        }) {
            let Some(shared) = subdomain.shared(node) else { continue };
            self.pass_down(cx, shared.group(), decision.into(), at);
        }
    }

    /// Removes and returns the decisions that all members of their groups apply in this step.
    pub(crate) fn take_decisions(&mut self, at: SetStep) -> Vec<(NodeId, Sharing)> {
        self.decisions.take(at.step)
    }

    /// Returns `true` if a decision waits for its step.
    pub(crate) fn is_pending(&self) -> bool {
        !self.decisions.is_empty()
    }

    fn pass_down<P: Point>(&mut self, cx: &mut Context<P>, group: &Group, sharing: Sharing, at: SetStep) {
        self.decisions.pass_down(cx, group, at.step, sharing, |sharing| Body::SetDecision(sharing.into()));
    }
}

/// Returns the message with counts.
fn counts_of([inside, outside, crossing_inside, crossing_outside]: [u64; 4]) -> SetCounts {
    SetCounts { inside, outside, crossing_inside, crossing_outside }
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
            assert_eq!(Sharing::decide(sum, SetRule::Smaller, None), smaller, "{sum:?}");
            assert_eq!(Sharing::decide(sum, SetRule::Both, None), paper, "{sum:?}");
        }
    }

    #[test]
    fn crossing_points_of_the_chosen_side_go_to_both_children() {
        let sides = |crossing: Crossing, side: usize, crosses: bool| {
            [0, 1].map(|child| crossing.sends(Place { side, crosses }, child))
        };
        for side in 0..2 {
            let own = [side == 0, side == 1];
            for crossing in [Crossing::Both, Crossing::Interior, Crossing::Exterior] {
                assert_eq!(sides(crossing, side, false), own);
            }
            assert_eq!(sides(Crossing::Both, side, true), [true; 2]);
        }
        assert_eq!(sides(Crossing::Interior, 0, true), [true; 2]);
        assert_eq!(sides(Crossing::Interior, 1, true), [false, true]);
        assert_eq!(sides(Crossing::Exterior, 0, true), [true, false]);
        assert_eq!(sides(Crossing::Exterior, 1, true), [true; 2]);
    }
}
