//! What processes know of their parts of a file after they have read them.

use super::super::ids::Counting;

/// What a process knows of its part of a file, as the processes exchange it: the number of the file, the number of rounded
/// integers, and whether the first column counts the rows (0: cannot, 1: does not, 2: does, 3: does, beside fractions).
pub(super) type PartFacts = [u64; 3];

/// Returns the facts of a part of a file.
pub(super) fn part_facts(file: usize, rounded: u64, counting: Option<Counting>) -> PartFacts {
    let counting = counting.map_or(0, |of| if of.counts { 2 + u64::from(of.has_fraction) } else { 1 });
    [file as u64, rounded, counting]
}

/// Returns whether the first column of a file counts the rows, if the parts of all processes tell.
pub(super) fn counting_of(file: usize, facts: &[Vec<PartFacts>]) -> Option<Counting> {
    let parts = facts.iter().flatten().filter(|part| part[0] == file as u64 && part[2] > 0);
    let of = |part: &PartFacts| Counting { counts: part[2] > 1, has_fraction: part[2] > 2 };
    parts.map(of).reduce(Counting::and)
}
