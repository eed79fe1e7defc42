//! Values that all ranks combine, through the tree of all ranks.

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Rank};
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::machine::collectives::ranks_below;
use crate::machine::context::Context;
use crate::machine::group_tree::FAN;

/// A value that ranks combine. The order of ranks must not matter.
pub(crate) trait Reduced<P>: Sized + Clone {
    /// Combines the values of disjoint sets of ranks.
    #[must_use]
    fn join(self, other: Self) -> Self;

    /// Converts the value to the body of a message.
    fn into_body(self) -> Body<P>;

    /// Takes the value from the body of a message, if the body contains one.
    fn take(body: &mut Body<P>) -> Option<Self>;
}

impl<P: Point> Context<P> {
    /// Combines the values of all ranks, and returns the result on every rank.
    ///
    /// **Rounds.** One up and one down for each level of the tree of all ranks, which has a fan of 32.
    ///
    /// # Errors
    /// Fails if a value is missing. See [`Context::exchange`] for other errors.
    pub(crate) async fn all_reduce<T: Reduced<P>>(&mut self, own: T) -> Result<T, TransportError> {
        let (rank, ranks) = (self.rank(), self.config().ranks());
        let (here, height) = (level(rank), level(ranks - 1));
        let mut value = own;
        for at in (1..=height).rev() {
            if here == at {
                self.send(above(rank), NodeId::ROOT, 0, value.clone().into_body());
            }
            self.next_round().await?;
            let values = self.take(|m| T::take(&mut m.body));
            let expected = if here + 1 == at { ranks_below(rank, ranks).len() } else { 0 };
            if values.len() != expected {
                let reason = format!("{} values of ranks instead of {expected}", values.len());
                return Err(TransportError::WorkerFailed { rank, reason });
            }
            value = values.into_iter().fold(value, T::join);
        }
        for at in 0..height {
            if here == at {
                for below in ranks_below(rank, ranks) {
                    self.send(below, NodeId::ROOT, 0, value.clone().into_body());
                }
            }
            self.next_round().await?;
            if here == at + 1 {
                value = self.take_one(|m| T::take(&mut m.body))?;
            }
        }
        Ok(value)
    }
}

/// Returns the rank above a worker in the tree of all ranks.
fn above(rank: Rank) -> Rank {
    (rank - 1) / FAN
}

/// Returns the level of a rank in the tree of all ranks.
fn level(rank: Rank) -> u32 {
    if rank == COORDINATOR { 0 } else { 1 + level(above(rank)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_one_level_below_the_rank_above() {
        for ranks in [1, 2, 33, 34, 1057, 1058, 5000] {
            for rank in 0..ranks {
                for below in ranks_below(rank, ranks) {
                    assert_eq!((above(below), level(below)), (rank, level(rank) + 1));
                }
            }
        }
        assert_eq!([0, 1, 32, 33, 1056, 1057].map(level), [0, 1, 1, 2, 2, 3]);
    }
}
