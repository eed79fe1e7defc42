//! Typed forms of values that messages encode as numbers or as short arrays of words.

use bincode::de::{BorrowDecode, BorrowDecoder, Decoder};
use bincode::enc::Encoder;
use bincode::error::{DecodeError, EncodeError};
use bincode::{Decode, Encode};
use septet_geometry::graph::Supergraph;

use crate::codec::Bulk;
use crate::ids::Phase;
use crate::outcome::Outcome;

/// The decision of a leader on the set of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetDecision {
    /// The set is not divided.
    Stop,
    /// The crossing points of both sides go to both children.
    Both,
    /// The crossing points of the interior go to both children.
    Interior,
    /// The crossing points of the exterior go to both children.
    Exterior,
}

/// The counts of a member's share of a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetCounts {
    /// Interior points.
    pub inside: u64,
    /// Exterior points.
    pub outside: u64,
    /// Interior points whose balls cross the separator.
    pub crossing_inside: u64,
    /// Exterior points whose balls cross the separator.
    pub crossing_outside: u64,
}

/// What members of a group know of a node whose balls are corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossings {
    /// Their balls that cross its separator.
    pub balls: u64,
    /// The largest number of levels below it.
    pub height: u64,
}

impl Crossings {
    /// Joins what two sets of members know.
    #[must_use]
    pub fn join(self, other: Crossings) -> Crossings {
        Crossings { balls: self.balls.saturating_add(other.balls), height: self.height.max(other.height) }
    }
}

/// The supergraph that the coordinator chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChosenSupergraph(pub Supergraph);

/// The counts of sampled stars.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleStars {
    /// Sampled stars.
    pub sampled: u64,
    /// What each alpha does for these stars: 2.5, 3, 4 and 6.
    pub of_alpha: [AlphaCounts; 4],
}

/// What an alpha does for sampled stars.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlphaCounts {
    /// Stars that it certifies.
    pub certified: u64,
    /// Edges of the supergraph at the sampled points.
    pub edges: u64,
    /// Vertices of the links to which the supergraph has no edge.
    pub missing: u64,
}

impl AlphaCounts {
    /// Adds the counts of other stars.
    pub fn add(&mut self, other: AlphaCounts) {
        self.certified = self.certified.saturating_add(other.certified);
        self.edges = self.edges.saturating_add(other.edges);
        self.missing = self.missing.saturating_add(other.missing);
    }
}

impl SampleStars {
    /// Adds the counts of other stars.
    pub fn add(&mut self, other: SampleStars) {
        self.sampled = self.sampled.saturating_add(other.sampled);
        self.of_alpha.iter_mut().zip(other.of_alpha).for_each(|(sum, counts)| sum.add(counts));
    }
}

/// The order-free fingerprint of the cells that two workers share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingerprint {
    /// The sum of the keys of all pairs of a cell and a vertex.
    pub sum: u128,
    /// Number of pairs.
    pub pairs: u64,
}

impl From<Outcome> for u8 {
    fn from(outcome: Outcome) -> u8 {
        outcome.number()
    }
}

impl TryFrom<u8> for Outcome {
    type Error = ();

    fn try_from(number: u8) -> Result<Self, ()> {
        Outcome::from_number(number).ok_or(())
    }
}

impl From<SetDecision> for u8 {
    fn from(decision: SetDecision) -> u8 {
        decision as u8
    }
}

impl TryFrom<u8> for SetDecision {
    type Error = ();

    fn try_from(number: u8) -> Result<Self, ()> {
        let all = [SetDecision::Stop, SetDecision::Both, SetDecision::Interior, SetDecision::Exterior];
        all.get(usize::from(number)).copied().ok_or(())
    }
}

impl From<ChosenSupergraph> for (u8, f64) {
    fn from(ChosenSupergraph(supergraph): ChosenSupergraph) -> (u8, f64) {
        match supergraph {
            Supergraph::Density { alpha } => (0, alpha),
            // A sample of stars chooses balls to the first neighbour only.
            Supergraph::Overlap { alpha, .. } => (1, alpha),
            Supergraph::Knn { k } => (2, f64::from(k)),
        }
    }
}

impl TryFrom<(u8, f64)> for ChosenSupergraph {
    type Error = ();

    fn try_from((kind, parameter): (u8, f64)) -> Result<Self, ()> {
        match kind {
            0 => Ok(ChosenSupergraph(Supergraph::Density { alpha: parameter })),
            1 => Ok(ChosenSupergraph(Supergraph::Overlap { alpha: parameter, k: 1 })),
            2 => Ok(ChosenSupergraph(Supergraph::Knn { k: parameter as u32 })),
            _ => Err(()),
        }
    }
}

impl From<SetCounts> for Bulk<u64> {
    fn from(counts: SetCounts) -> Self {
        let SetCounts { inside, outside, crossing_inside, crossing_outside } = counts;
        Bulk(vec![inside, outside, crossing_inside, crossing_outside])
    }
}

impl TryFrom<Bulk<u64>> for SetCounts {
    type Error = ();

    fn try_from(words: Bulk<u64>) -> Result<Self, ()> {
        let &[inside, outside, crossing_inside, crossing_outside] = words.0.as_slice() else {
            return Err(());
        };
        Ok(SetCounts { inside, outside, crossing_inside, crossing_outside })
    }
}

impl From<Crossings> for Bulk<u64> {
    fn from(Crossings { balls, height }: Crossings) -> Self {
        Bulk(vec![balls, height])
    }
}

impl TryFrom<Bulk<u64>> for Crossings {
    type Error = ();

    fn try_from(words: Bulk<u64>) -> Result<Self, ()> {
        let &[balls, height] = words.0.as_slice() else { return Err(()) };
        Ok(Crossings { balls, height })
    }
}

impl From<SampleStars> for Bulk<u64> {
    fn from(SampleStars { sampled, of_alpha }: SampleStars) -> Self {
        let words = |AlphaCounts { certified, edges, missing }| [certified, edges, missing];
        Bulk([sampled].into_iter().chain(of_alpha.into_iter().flat_map(words)).collect())
    }
}

impl TryFrom<Bulk<u64>> for SampleStars {
    type Error = ();

    fn try_from(words: Bulk<u64>) -> Result<Self, ()> {
        let Some((&sampled, counts)) = words.0.split_first() else { return Err(()) };
        let (rows, []) = counts.as_chunks::<3>() else { return Err(()) };
        let of_alpha: &[[u64; 3]; 4] = rows.try_into().map_err(|_| ())?;
        let counts = |[certified, edges, missing]: [u64; 3]| AlphaCounts { certified, edges, missing };
        Ok(SampleStars { sampled, of_alpha: of_alpha.map(counts) })
    }
}

impl From<Fingerprint> for Bulk<u64> {
    fn from(Fingerprint { sum, pairs }: Fingerprint) -> Self {
        Bulk(vec![sum as u64, (sum >> 64) as u64, pairs])
    }
}

impl TryFrom<Bulk<u64>> for Fingerprint {
    type Error = ();

    fn try_from(words: Bulk<u64>) -> Result<Self, ()> {
        let &[low, high, pairs] = words.0.as_slice() else { return Err(()) };
        Ok(Fingerprint { sum: u128::from(low) | u128::from(high) << 64, pairs })
    }
}

/// Encodes a type in the form of another, and rejects values of that form without a meaning.
macro_rules! encoded_as {
    ($type:ty, $form:ty) => {
        impl Encode for $type {
            fn encode<E: Encoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
                <$form>::from(*self).encode(encoder)
            }
        }

        impl<Context> Decode<Context> for $type {
            fn decode<D: Decoder<Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
                let form = <$form as Decode<Context>>::decode(decoder)?;
                Self::try_from(form).map_err(|_| DecodeError::Other(concat!("invalid ", stringify!($type))))
            }
        }

        impl<'de, Context> BorrowDecode<'de, Context> for $type {
            fn borrow_decode<D: BorrowDecoder<'de, Context = Context>>(
                decoder: &mut D,
            ) -> Result<Self, DecodeError> {
                <$type as Decode<Context>>::decode(decoder)
            }
        }
    };
}

encoded_as!(Outcome, u8);
encoded_as!(Phase, u8);
encoded_as!(SetDecision, u8);
encoded_as!(ChosenSupergraph, (u8, f64));
encoded_as!(SetCounts, Bulk<u64>);
encoded_as!(Crossings, Bulk<u64>);
encoded_as!(SampleStars, Bulk<u64>);
encoded_as!(Fingerprint, Bulk<u64>);

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use super::*;
    use crate::codec::{decode, encode};

    #[expect(clippy::needless_pass_by_value, reason = "callers write values")]
    fn travels_as<T: Encode + Decode<()> + Debug + PartialEq>(value: T, form: &impl Encode) {
        let bytes = encode(&value).unwrap();
        assert_eq!(bytes, encode(form).unwrap());
        assert_eq!(decode::<T>(&bytes).unwrap(), value);
    }

    #[test]
    fn values_travel_as_codes_and_words() {
        travels_as(Outcome::GatherAll, &2u8);
        travels_as(Phase::Neighbours, &(Phase::Neighbours as u8));
        travels_as(SetDecision::Stop, &0u8);
        travels_as(SetDecision::Exterior, &3u8);
        travels_as(ChosenSupergraph(Supergraph::Density { alpha: 2.5 }), &(0u8, 2.5));
        travels_as(ChosenSupergraph(Supergraph::Overlap { alpha: 3.0, k: 1 }), &(1u8, 3.0));
        travels_as(ChosenSupergraph(Supergraph::Knn { k: 9 }), &(2u8, 9.0));
        let counts = SetCounts { inside: 1, outside: 2, crossing_inside: 3, crossing_outside: 4 };
        travels_as(counts, &Bulk(vec![1u64, 2, 3, 4]));
        travels_as(Crossings { balls: 5, height: 6 }, &Bulk(vec![5u64, 6]));
        let of_alpha = [1, 2, 3, 4].map(|n| AlphaCounts { certified: n, edges: 10 * n, missing: 100 * n });
        let words = vec![5u64, 1, 10, 100, 2, 20, 200, 3, 30, 300, 4, 40, 400];
        travels_as(SampleStars { sampled: 5, of_alpha }, &Bulk(words));
        travels_as(Fingerprint { sum: 7 | 9 << 64, pairs: 2 }, &Bulk(vec![7u64, 9, 2]));
    }

    #[test]
    fn codes_and_words_without_meaning_are_errors() {
        assert!(decode::<Outcome>(&[4]).is_err());
        assert!(decode::<Phase>(&[Phase::ALL.len() as u8]).is_err());
        assert!(decode::<SetDecision>(&[4]).is_err());
        assert!(decode::<ChosenSupergraph>(&encode(&(3u8, 1.0)).unwrap()).is_err());
        assert!(decode::<SetCounts>(&encode(&Bulk(vec![1u64; 3])).unwrap()).is_err());
        assert!(decode::<Crossings>(&encode(&Bulk(vec![1u64; 3])).unwrap()).is_err());
    }
}
