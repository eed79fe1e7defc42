//! Brent's bound as a function of the number of processors.
//!
//! **Statement.** A step has work `W` and depth `D`. By Brent's principle, `p` processors run it in
//! `ceil((W - D) / p) + D` steps ([`steps_on`]). The bound `T_p` of a computation is the sum over its steps. `T_1` is the
//! work if no step is deeper than its work, `T_p` does not increase with p, and it is at least the sum of the depths.
//!
//! **Source.** Brent, "The parallel evaluation of general arithmetic expressions", J. ACM 21, 1974.
//!
//! **Work.** One division for each step and each power of two up to n. The sum is not charged, because it is no part of the
//! computation.

use std::collections::BTreeMap;

use septet_geometry::cost::Price;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Returns the number of steps in which `processors` processors run a step of the machine.
pub fn steps_on(price: Price, processors: u64) -> u64 {
    price.work().saturating_sub(price.depth()).div_ceil(processors.max(1)) + price.depth()
}

/// The largest number of bounds: ranks number their points by 32 bits.
const MOST: usize = 33;

/// Brent's bound for each power of two up to the number of points.
///
/// In reports, it is a map from the number of processors to the bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BrentCurve {
    /// The bounds on 1, 2, 4, ... processors. Zero from `len` on.
    bounds: Bounds,
    len: usize,
}

/// The storage of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bounds([u64; MOST]);

impl Default for Bounds {
    fn default() -> Self {
        Bounds([0; MOST])
    }
}

impl BrentCurve {
    /// Returns the bounds of a computation without steps, for up to `most` processors.
    pub fn up_to(most: u64) -> Self {
        BrentCurve { bounds: Bounds::default(), len: (most.max(1).ilog2() as usize + 1).min(MOST) }
    }

    /// Adds a step of the machine that runs after the others.
    pub fn add_step(&mut self, price: Price) {
        for (exponent, bound) in self.bounds.0[..self.len].iter_mut().enumerate() {
            *bound += steps_on(price, 1 << exponent);
        }
    }

    /// Returns the bounds of two computations, one after the other. A computation without steps may have no bounds.
    #[must_use]
    pub fn then(mut self, next: BrentCurve) -> Self {
        self.len = self.len.max(next.len);
        self.bounds.0.iter_mut().zip(next.bounds.0).for_each(|(sum, bound)| *sum += bound);
        self
    }

    /// Returns each number of processors with its bound, in ascending order.
    pub fn each(&self) -> impl Iterator<Item = (u64, u64)> {
        self.bounds.0[..self.len].iter().enumerate().map(|(exponent, &bound)| (1 << exponent, bound))
    }
}

impl Serialize for BrentCurve {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.each().map(|(processors, bound)| (processors.to_string(), bound)))
    }
}

impl<'de> Deserialize<'de> for BrentCurve {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let map = BTreeMap::<String, u64>::deserialize(deserializer)?;
        let mut curve = BrentCurve { len: map.len().min(MOST), ..BrentCurve::default() };
        for (exponent, bound) in curve.bounds.0[..curve.len].iter_mut().enumerate() {
            let of = map.get(&(1u64 << exponent).to_string());
            *bound = *of.ok_or_else(|| {
                D::Error::custom(format!("there is no bound for {} processors", 1u64 << exponent))
            })?;
        }
        if map.len() > MOST {
            return Err(D::Error::custom(format!("there are more than {MOST} bounds")));
        }
        Ok(curve)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for BrentCurve {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        BTreeMap::<String, u64>::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        BTreeMap::<String, u64>::json_schema(generator)
    }

    fn inline_schema() -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_fall_from_the_work_to_the_depth() {
        let mut curve = BrentCurve::up_to(100);
        for (work, depth) in [(1000, 3), (7, 7), (64, 1)] {
            curve.add_step(Price::from_parts([work, depth, 0, 0, 0]));
        }
        let all: Vec<(u64, u64)> = curve.each().collect();
        assert_eq!(all[0], (1, 1071));
        assert_eq!(all.last(), Some(&(64, 997u64.div_ceil(64) + 3 + 7 + 1 + 1)));
        assert!(all.windows(2).all(|pair| pair[1].0 == 2 * pair[0].0 && pair[1].1 <= pair[0].1));
        let sum = curve.then(BrentCurve::default()).then(curve);
        assert!(sum.each().zip(curve.each()).all(|(sum, one)| sum == (one.0, 2 * one.1)));
    }
}
