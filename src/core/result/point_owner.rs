//! The worker that holds each input point after the partition.

use septet_workers::share::Share;

/// Returns the worker of each of `input` points, and 0 for points that no worker holds. Returns `None` unless the
/// workers hold `population` points of the input, each once.
pub(crate) fn point_owner<P>(input: usize, shares: &[Share<P>], population: u64) -> Option<Vec<u32>> {
    let mut owners = vec![0; input];
    let mut held = 0;
    for Share { rank, owned, .. } in shares {
        held += owned.len() as u64;
        for &id in owned {
            match owners.get_mut(usize::try_from(id).ok()?)? {
                free @ 0 => *free = *rank,
                _ => return None,
            }
        }
    }
    (held == population).then_some(owners)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn every_point_has_one_worker() {
        let owned = |rank, ids: &[u64]| Share::<DVec2> { owned: ids.to_vec(), ..Share::new(rank) };
        let shares = [owned(3, &[4, 0]), owned(1, &[2])];
        assert_eq!(point_owner(5, &shares, 3), Some(vec![3, 0, 1, 0, 3]));
        // A point is missing, does not exist, or has two workers.
        assert_eq!(point_owner(5, &shares, 4), None);
        assert_eq!(point_owner(4, &shares, 3), None);
        assert_eq!(point_owner(5, &[owned(3, &[4]), owned(1, &[4])], 2), None);
    }
}
