//! Values that go through the trees of several groups at the same time, in phases that do not wait for one group.
//!
//! A phase calls these operations with the values that arrived in a step. They never wait. Compare
//! `Context::gather` and `Context::distribute`, in which a group does nothing else.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;
use septet_protocol::message::Body;

use crate::machine::context::Context;
use crate::machine::group::Group;

/// One member's part in sums that go up the trees of groups: sums of branches that are not complete.
///
/// **Rounds.** As many as the tree is high, if all members add their values in the same round.
#[derive(Debug)]
pub(crate) struct Ascent<T>(BTreeMap<NodeId, BranchSum<T>>);

/// The sum of the values of a member and of the members below it.
#[derive(Debug)]
struct BranchSum<T> {
    sum: T,
    /// The number of values that have not arrived, among the member's own and those of the branches below it.
    missing: usize,
}

impl<T> Default for Ascent<T> {
    fn default() -> Self {
        Ascent(BTreeMap::new())
    }
}

impl<T: Copy + Default> Ascent<T> {
    /// Adds this member's value, or the sum of a branch below it. Sends the sum of this member's branch to the member
    /// above once it is complete, or returns it on the leader.
    pub(crate) fn add<P: Point>(
        &mut self,
        cx: &mut Context<P>,
        group: &Group,
        join: impl FnOnce(T) -> T,
        into_body: impl FnOnce(T) -> Body<P>,
    ) -> Option<T> {
        let place = group.place(cx.rank());
        let missing = place.below().len() + 1;
        let branch = self.0.entry(group.node).or_insert_with(|| BranchSum { sum: T::default(), missing });
        branch.sum = join(branch.sum);
        branch.missing -= 1;
        if branch.missing > 0 {
            return None;
        }
        let sum = self.0.remove(&group.node)?.sum;
        let Some(above) = place.above() else { return Some(sum) };
        cx.send_to((group.node, above), into_body(sum));
        None
    }
}

/// One member's part in values that go down the trees of groups. All members of a group use a value in the same step.
#[derive(Debug)]
pub(crate) struct Descent<T>(Vec<Held<T>>);

/// A value, and the step in which the members of a group use it.
#[derive(Debug)]
struct Held<T> {
    step: u32,
    node: NodeId,
    value: T,
}

impl<T> Default for Descent<T> {
    fn default() -> Self {
        Descent(Vec::new())
    }
}

impl<T: Copy> Descent<T> {
    /// Passes a value to the members directly below, and keeps it until it has arrived at all members. `step` is the
    /// current step of the phase, which has one step for each round.
    pub(crate) fn pass_down<P: Point>(
        &mut self,
        cx: &mut Context<P>,
        group: &Group,
        step: u32,
        value: T,
        into_body: impl Fn(T) -> Body<P>,
    ) {
        let place = group.place(cx.rank());
        cx.route(place.below().map(|rank| ((group.node, rank), into_body(value))));
        self.0.push(Held { step: step + place.rounds_to_bottom(), node: group.node, value });
    }

    /// Removes and returns the values that all members of their groups use in this step, in the order of the nodes.
    pub(crate) fn take(&mut self, step: u32) -> Vec<(NodeId, T)> {
        let mut taken: Vec<(NodeId, T)> =
            self.0.extract_if(.., |held| held.step <= step).map(|held| (held.node, held.value)).collect();
        taken.sort_by_key(|(node, _)| *node);
        taken
    }

    /// Returns `true` if no value waits for its step.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
