//! The rounds of local priorities on sites, computed from the sites alone.
//!
//! **Statement.** Two sites are adjacent if their distance is less than the smaller of their sizes. In each round, a
//! site joins the independent set if its priority precedes those of all its undecided neighbours. Then the neighbours
//! of the sites that joined leave. Neighbours are found from all pairs.

use glam::{DVec2, DVec3};
use septet_geometry::priority::priority;

use super::measure::{X, pairs};
use super::sample::Sample;

/// The counts of the rounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rounds {
    pub(super) number: f64,
    /// Number of undecided sites, summed over all rounds.
    pub(super) open_points: f64,
    /// Number of neighbours of undecided sites, decided neighbours included, summed over all rounds.
    pub(super) open_edges: f64,
}

/// Returns the counts for sites of one common size at the points of a sample.
pub(super) fn rounds_of(sample: Sample, points: &[X], seed: u64) -> Rounds {
    let priorities: Vec<u64> = points
        .iter()
        .map(|&[x, y, z]| match sample.d {
            2 => priority(seed, DVec2::new(x, y)),
            _ => priority(seed, DVec3::new(x, y, z)),
        })
        .collect();
    let sizes2 = vec![sample.site_size().powi(2); points.len()];
    let edges = pairs(points, &sizes2, |d2, a2, b2| d2 < a2.min(b2));
    let mut lists = vec![Vec::new(); points.len()];
    for (i, j) in edges {
        lists[i as usize].push(j as usize);
        lists[j as usize].push(i as usize);
    }
    rounds(&lists, &priorities)
}

fn rounds(lists: &[Vec<usize>], priorities: &[u64]) -> Rounds {
    let mut open = vec![true; lists.len()];
    let mut counts = Rounds::default();
    let mut undecided: Vec<usize> = (0..lists.len()).collect();
    while !undecided.is_empty() {
        counts.number += 1.0;
        counts.open_points += undecided.len() as f64;
        counts.open_edges += undecided.iter().map(|&v| lists[v].len() as f64).sum::<f64>();
        let key = |v: usize| (priorities[v], v);
        let first = |&v: &usize| lists[v].iter().all(|&u| !open[u] || key(v) < key(u));
        let joined: Vec<usize> = undecided.iter().copied().filter(first).collect();
        for v in joined {
            open[v] = false;
            lists[v].iter().for_each(|&u| open[u] = false);
        }
        undecided.retain(|&v| open[v]);
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path 0 - 1 - 2 - 3 with priorities 1, 2, 3, 4: site 0 joins and 1 leaves; then 2 joins and 3 leaves.
    #[test]
    fn rounds_by_hand() {
        let lists = [vec![1], vec![0, 2], vec![1, 3], vec![2]];
        let expected = Rounds { number: 2.0, open_points: 6.0, open_edges: 9.0 };
        assert_eq!(rounds(&lists, &[1, 2, 3, 4]), expected);
        assert_eq!(rounds(&[], &[]), Rounds::default());
        assert_eq!(rounds(&[vec![]], &[1]), Rounds { number: 1.0, open_points: 1.0, open_edges: 0.0 });
    }
}
