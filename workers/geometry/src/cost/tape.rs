//! Records of the calls of a meter, without prices.
//!
//! **Statement.** A [`Tape`] lists the calls of primitives in their order. A vector step whose items have their own
//! meters is one entry ([`LaneStep`]). The entry has two parts: how often all lanes together made each call, which
//! determines their work, and the calls of the lane with the greatest depth.

use std::collections::BTreeMap;

use super::price::Primitive;

/// One call of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Call {
    /// The primitive.
    pub primitive: Primitive,
    /// The number of items of the call.
    pub items: u64,
}

/// A vector step whose items have their own meters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LaneStep {
    /// The number of lanes.
    pub lanes: u64,
    /// The number of times that the lanes made each call. A lane without calls counts as a vector step over one item.
    pub calls: BTreeMap<Call, u64>,
    /// The calls of the first lane of the greatest depth.
    pub longest: Tape,
}

/// An entry of a tape.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A call of a primitive.
    Call(Call),
    /// A vector step whose items have their own meters.
    Lanes(LaneStep),
}

/// The calls of a computation, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tape {
    steps: Vec<Step>,
}

impl Tape {
    /// Returns the entries in their order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Returns the entries in their order.
    pub fn into_steps(self) -> Vec<Step> {
        self.steps
    }

    /// Returns `true` if nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Appends a call. This function is cold, because most meters have no tape.
    #[cold]
    pub(super) fn call(&mut self, call: Call) {
        self.steps.push(Step::Call(call));
    }

    /// Appends an entry.
    pub(super) fn push(&mut self, step: Step) {
        self.steps.push(step);
    }

    /// Appends the entries of a computation that runs later.
    pub fn append(&mut self, mut next: Tape) {
        self.steps.append(&mut next.steps);
    }

    /// Adds the calls of this tape, those inside vector steps included, to `calls`.
    pub(super) fn count(&self, calls: &mut BTreeMap<Call, u64>) {
        for step in &self.steps {
            match step {
                Step::Call(call) => *calls.entry(*call).or_default() += 1,
                Step::Lanes(lanes) => {
                    lanes.calls.iter().for_each(|(call, n)| *calls.entry(*call).or_default() += n);
                }
            }
        }
    }
}
