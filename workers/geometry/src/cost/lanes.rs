//! Vector steps whose items have their own meters.

use super::price::{Price, Primitive};
use super::tape::{Call, LaneStep, Step, Tape};

/// A vector step whose items have their own meters: the sum of their work, and the maximum of their depths.
#[derive(Clone, Debug, Default)]
pub struct Lanes {
    price: Price,
    /// The record of the step, if calls are recorded.
    record: Option<Box<LaneStep>>,
    /// The depth of the longest lane, if calls are recorded.
    longest: u64,
}

impl Lanes {
    /// Creates a step without lanes.
    pub(super) fn new(records: bool) -> Self {
        Lanes { price: Price::ZERO, record: records.then(Box::default), longest: 0 }
    }

    /// Adds a lane with this price and record.
    pub(super) fn add_lane(&mut self, own: Price, tape: Option<Tape>) {
        let price = own.of_lane();
        self.price.join(price);
        if let (Some(record), Some(mut tape)) = (&mut self.record, tape) {
            if own.depth() == 0 {
                tape = Tape::default();
                tape.call(Call { primitive: Primitive::VectorStep, items: 1 });
            }
            record.lanes += 1;
            tape.count(&mut record.calls);
            if price.depth() > self.longest {
                self.longest = price.depth();
                record.longest = tape;
            }
        }
    }

    /// Adds the lanes of another part of the same step.
    pub fn join(&mut self, other: Lanes) {
        self.price.join(other.price);
        if let (Some(record), Some(part)) = (&mut self.record, other.record) {
            record.lanes += part.lanes;
            part.calls.iter().for_each(|(call, n)| *record.calls.entry(*call).or_default() += n);
            if other.longest > self.longest {
                self.longest = other.longest;
                record.longest = part.longest;
            }
        }
    }

    /// Returns the price of the step, and its record.
    pub(super) fn into_step(self) -> (Price, Option<Step>) {
        let step = self.record.filter(|record| record.lanes > 0).map(|record| Step::Lanes(*record));
        (self.price, step)
    }
}
