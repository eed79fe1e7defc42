//! The tree of a group, and the operations of a group in which all members stay in step.
//!
//! **Statement.** The leader is the root of the tree. Every member has at most `FAN` members directly below it. The
//! height `h` depends only on the size of the group: 1 for up to 33 members, 2 for up to 1,057.
//!
//! **Shape.** The members are numbered cyclically, and the leader has number 0. The numbers after the first are divided
//! into at most `FAN` intervals, whose lengths differ by at most one. Each interval has a tree of the same form, whose
//! root is directly below the leader. So the members of a branch have consecutive numbers.
//!
//! **Rounds.** `Context::gather` and `Context::distribute` take `h` rounds. In each of them, the members of one
//! level send. Each operation ends in the same round for all members.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::ids::Rank;
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::machine::group::Group;

/// The largest number of ranks directly below a rank in a tree of ranks.
pub(super) const FAN: u32 = 32;

/// A value with one part for each member of a branch, in the order of their numbers.
pub(crate) trait Parts<P>: Sized {
    /// Returns the message that carries the value.
    fn into_body(self) -> Body<P>;

    /// Takes the value out of a message. Returns `None` if the message is of another kind.
    fn take_from(body: &mut Body<P>) -> Option<Self>;

    /// Returns `true` if the value may be that of a branch with this number of members.
    fn fits(&self, members: usize) -> bool;
}

/// A value that goes up the tree of a group.
pub(crate) trait Joined<P>: Parts<P> {
    /// Appends the value of the next branch.
    fn append(&mut self, next: Self);
}

/// A value that goes down the tree of a group.
pub(crate) trait Divided<P>: Parts<P> {
    /// Removes and returns the parts of the last members.
    fn split_off(&mut self, members: usize) -> Self;
}

/// The value of a whole group.
pub(crate) struct Gathered<T> {
    /// The value.
    pub(crate) value: T,
    /// The round in which the members directly below the leader sent it.
    pub(crate) round: u32,
}

/// A member with all members below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Branch {
    root: Rank,
    members: usize,
}

/// The place of a member in the tree of its group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TreePlace {
    /// The member directly above. `None` for the leader.
    above: Option<Rank>,
    /// The number of members above.
    level: u32,
    /// The height of the tree.
    height: u32,
    /// The number of members of this member's branch.
    members: usize,
    /// The branches below.
    below: Vec<Branch>,
}

impl TreePlace {
    /// Returns the member directly above, or `None` for the leader.
    pub(crate) fn above(&self) -> Option<Rank> {
        self.above
    }

    /// Returns the members directly below.
    pub(crate) fn below(&self) -> impl ExactSizeIterator<Item = Rank> {
        self.below.iter().map(|branch| branch.root)
    }

    /// Returns the number of rounds in which a message that this member receives reaches the lowest level of the tree.
    pub(crate) fn rounds_to_bottom(&self) -> u32 {
        self.height - self.level
    }
}

/// Divides an interval into at most [`FAN`] intervals, whose lengths differ by at most one.
fn divided(numbers: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let (start, len) = (u64::from(numbers.start), u64::from(numbers.end - numbers.start));
    let parts = len.min(u64::from(FAN));
    let bound = move |i: u64| (start + len * i / parts) as u32;
    (0..parts).map(move |i| bound(i)..bound(i + 1))
}

impl Group {
    /// Returns the height of the tree of the group.
    pub(crate) fn height(&self) -> u32 {
        let (mut height, mut members) = (0, self.child.ranks);
        while members > 1 {
            members = (members - 1).div_ceil(FAN);
            height += 1;
        }
        height
    }

    /// Returns the place of a member in the tree of the group.
    pub(crate) fn place(&self, rank: Rank) -> TreePlace {
        let own = self.number(rank);
        let (mut numbers, mut above, mut level) = (0..self.child.ranks, None, 0);
        while numbers.start != own {
            let Some(part) = divided(numbers.start + 1..numbers.end).find(|part| part.contains(&own)) else {
                break;
            };
            above = Some(self.rank_of(numbers.start));
            numbers = part;
            level += 1;
        }
        let branch = |part: Range<u32>| Branch { root: self.rank_of(part.start), members: part.len() };
        TreePlace {
            above,
            level,
            height: self.height(),
            members: numbers.len(),
            below: divided(numbers.start + 1..numbers.end).map(branch).collect(),
        }
    }

    /// Changes values of all members from the order of their numbers to the order of their ranks.
    pub(crate) fn sort_by_rank<T>(&self, values: &mut [T]) {
        values.rotate_right((self.leader - self.child.first) as usize);
    }

    /// Changes values of all members from the order of their ranks to the order of their numbers.
    pub(crate) fn sort_by_number<T>(&self, values: &mut [T]) {
        values.rotate_left((self.leader - self.child.first) as usize);
    }

    /// Returns the number of a member. A rank outside the group, which only a corrupt message can cause, gets the number
    /// of some member.
    fn number(&self, rank: Rank) -> u32 {
        let ranks = self.child.ranks.max(1);
        if rank >= self.leader {
            (rank - self.leader) % ranks
        } else {
            (ranks - (self.leader - rank) % ranks) % ranks
        }
    }

    fn rank_of(&self, number: u32) -> Rank {
        let (end, rank) = (self.child.first + self.child.ranks, self.leader + number);
        if rank < end { rank } else { rank - self.child.ranks }
    }
}

impl<P: Point> Context<P> {
    /// Sends the values of all members up the tree to the leader. Returns the value of the group on the leader, and `None`
    /// on the other members. All members must call this function in the same round.
    ///
    /// # Errors
    /// Fails if a value is missing, arrives twice or has another number of parts. See [`Context::exchange`] for other errors.
    pub(crate) async fn gather<T: Joined<P>>(
        &mut self,
        group: &Group,
        attempt: u32,
        own: T,
    ) -> Result<Option<Gathered<T>>, TransportError> {
        let place = group.place(self.rank());
        let (mut gathered, mut round) = (Some(own), self.round());
        for level in (1..=place.height).rev() {
            if let Some(above) = place.above.filter(|_| level == place.level)
                && let Some(value) = gathered.take()
            {
                self.send(above, group.node, attempt, value.into_body());
            }
            round = self.round();
            self.next_round().await?;
            if let Some(all) = gathered.as_mut().filter(|_| level == place.level + 1) {
                self.take_parts(&place.below)?.into_iter().for_each(|next| all.append(next));
            }
        }
        Ok(gathered.map(|value| Gathered { value, round }))
    }

    /// Sends the parts of a value from the leader down the tree. Only the leader has a value. Returns this member's part. All
    /// members must call this function in the same round.
    ///
    /// # Errors
    /// Fails if a value is missing, arrives twice or has another number of parts. See [`Context::exchange`] for other errors.
    pub(crate) async fn distribute<T: Divided<P>>(
        &mut self,
        group: &Group,
        attempt: u32,
        mut value: Option<T>,
    ) -> Result<T, TransportError> {
        let place = group.place(self.rank());
        for level in 0..place.height {
            if let Some(value) = value.as_mut().filter(|_| level == place.level) {
                for &Branch { root, members } in place.below.iter().rev() {
                    let part = value.split_off(members);
                    self.send(root, group.node, attempt, part.into_body());
                }
            }
            self.next_round().await?;
            if let Some(above) = place.above.filter(|_| level + 1 == place.level) {
                value = self.take_parts(&[Branch { root: above, members: place.members }])?.pop();
            }
        }
        value.ok_or_else(|| self.missing(group.leader))
    }

    /// Takes the value of each of these branches, in their order.
    fn take_parts<T: Parts<P>>(&mut self, branches: &[Branch]) -> Result<Vec<T>, TransportError> {
        let mut arrived = self.take(|m| T::take_from(&mut m.body).map(|value| (m.from, value)));
        self.refuse_rest()?;
        let mut parts = Vec::with_capacity(branches.len());
        for branch in branches {
            let fits = |(from, value): &(Rank, T)| *from == branch.root && value.fits(branch.members);
            let at = arrived.iter().position(fits).ok_or_else(|| self.missing(branch.root))?;
            parts.push(arrived.swap_remove(at).1);
        }
        if let Some(&(from, _)) = arrived.first() {
            let reason =
                format!("its second value for a group has no place in phase {}", self.phase().name());
            return Err(TransportError::BadMessage { from, reason });
        }
        Ok(parts)
    }

    fn missing(&self, from: Rank) -> TransportError {
        let reason =
            format!("its value for the members of a group is missing in phase {}", self.phase().name());
        TransportError::BadMessage { from, reason }
    }
}

#[cfg(test)]
mod tests {
    use septet_protocol::ids::NodeId;
    use septet_protocol::message::Child;

    use super::*;

    fn group(first: Rank, ranks: u32, leader: Rank) -> Group {
        let child = Child { population: 0, first, ranks, leaf: false };
        Group { node: NodeId::ROOT, leader, child }
    }

    /// Groups of many sizes, each with several leaders.
    fn groups() -> impl Iterator<Item = Group> {
        let sizes = [1, 2, 3, 31, 32, 33, 34, 63, 64, 65, 100, 256, 511, 512, 1024, 1057, 1058, 3000];
        sizes.into_iter().flat_map(|ranks| {
            let leaders = [0, 1, ranks / 2, ranks - 1].into_iter().filter(move |&at| at < ranks);
            leaders.flat_map(move |at| [0, 7].map(|first| group(first, ranks, first + at)))
        })
    }

    #[test]
    fn every_member_is_below_one_member_of_the_level_above() {
        for group in groups() {
            let mut above = vec![None; group.child.ranks as usize];
            let index = |rank: Rank| (rank - group.child.first) as usize;
            for rank in group.members() {
                let place = group.place(rank);
                assert!(place.below.len() <= FAN as usize, "{group:?}");
                for below in place.below() {
                    assert_eq!(above[index(below)].replace(rank), None, "{group:?}, {below}");
                    assert_eq!(group.place(below).level, place.level + 1);
                }
            }
            for rank in group.members() {
                assert_eq!(group.place(rank).above(), above[index(rank)], "{group:?}, {rank}");
                assert_eq!(above[index(rank)].is_none(), rank == group.leader, "{group:?}, {rank}");
            }
        }
    }

    #[test]
    fn branches_have_consecutive_members() {
        for group in groups() {
            for rank in group.members() {
                let place = group.place(rank);
                let mut next = group.number(rank) + 1;
                for branch in &place.below {
                    assert_eq!(group.rank_of(next), branch.root);
                    assert_eq!(group.place(branch.root).members, branch.members);
                    next += branch.members as u32;
                }
                assert_eq!(next, group.number(rank) + place.members as u32);
            }
            assert_eq!(group.place(group.leader).members, group.members().len());
        }
    }

    #[test]
    fn the_height_depends_on_the_size_alone() {
        for group in groups() {
            let lowest = group.members().map(|rank| group.place(rank).level).max();
            assert_eq!(lowest, Some(group.height()), "{group:?}");
        }
        let heights = [1, 2, 33, 34, 1057, 1058, 33_825, 33_826].map(|ranks| group(0, ranks, 0).height());
        assert_eq!(heights, [0, 1, 1, 2, 2, 3, 3, 4]);
        assert_eq!(group(1, 33, 9).place(9).below().len(), 32);
    }

    #[test]
    fn values_change_between_both_orders() {
        for group in groups() {
            let mut ranks: Vec<Rank> = (0..group.child.ranks).map(|number| group.rank_of(number)).collect();
            let numbered = ranks.clone();
            group.sort_by_rank(&mut ranks);
            assert!(ranks.iter().copied().eq(group.members()), "{group:?}");
            group.sort_by_number(&mut ranks);
            assert_eq!(ranks, numbered);
        }
    }
}
