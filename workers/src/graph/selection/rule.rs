//! The choice among the supergraphs of a family by the counts of a sample.
//!
//! **Statement.** Let a sampled star have `e` edges in the supergraph of an alpha, and let `m` vertices of its link have no
//! edge to it. For [`Purpose::Counting`], the choice minimises `a e + b m` over the sample: an estimate of the steps with n
//! processors that depend on alpha. An edge costs a test, a copy and a candidate of a hull; a missing vertex costs its part
//! of the repair. For [`Purpose::Timing`], it takes the first alpha for which at most 10 % of the sample are not certified,
//! and 48 nearest neighbours if there is none.
//!
//! **Departures.** The paper leaves `alpha` open. `bench/NOTEBOOK.md` has the measurements behind all constants. For time,
//! lists of neighbours are better than many uncertified stars, because they cost few copies.

use septet_geometry::graph::Supergraph;
use septet_protocol::message::{AlphaCounts, SampleStars};

use crate::config::{FALLBACK_K, Family, Purpose, Repair};

/// The candidates for alpha, in order.
pub(crate) const ALPHAS: [f64; 4] = [2.5, 3.0, 4.0, 6.0];

/// The share of sampled stars that may remain without a local certificate, for [`Purpose::Timing`].
const UNCERTIFIED_SHARE: f64 = 0.1;

/// The steps for each edge and for each missing vertex of a link, with a processor for each point.
struct Steps {
    edge: f64,
    missing: f64,
}

/// Returns the steps in the plane or in space.
fn steps_of(repair: Repair, dimension: usize) -> Steps {
    match (repair, dimension) {
        (Repair::Splay, 2) => Steps { edge: 15.0, missing: 350.0 },
        (Repair::Splay, _) => Steps { edge: 35.0, missing: 2800.0 },
        (Repair::Probe, 2) => Steps { edge: 15.0, missing: 180.0 },
        (Repair::Probe, _) => Steps { edge: 35.0, missing: 1400.0 },
    }
}

/// The request for a choice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) family: Family,
    pub(super) purpose: Purpose,
    /// How the stars that the graph does not determine are repaired.
    pub(super) repair: Repair,
    /// Number of coordinates of a point.
    pub(super) dimension: usize,
    /// Number of points.
    pub(super) population: u64,
    /// Whether a fault takes the worst candidate.
    pub(super) worst: bool,
}

impl Request {
    /// Selects the supergraph. Returns it with the reason.
    pub(super) fn choose(self, sample: &SampleStars) -> (Supergraph, String) {
        match self.purpose {
            Purpose::Counting => self.cheapest(sample),
            Purpose::Timing => self.first_that_certifies(sample),
        }
    }

    fn cheapest(self, sample: &SampleStars) -> (Supergraph, String) {
        let stars = sample.sampled.max(1) as f64;
        let sign = if self.worst { -1.0 } else { 1.0 };
        let steps = |counts: &AlphaCounts| sign * self.steps(counts);
        let pairs = ALPHAS.into_iter().zip(&sample.of_alpha);
        let best = pairs.min_by(|a, b| steps(a.1).total_cmp(&steps(b.1)));
        let (alpha, counts) = best.unwrap_or((ALPHAS[0], &sample.of_alpha[0]));
        let (edges, missing) = (counts.edges as f64 / stars, counts.missing as f64 / stars);
        let why = format!(
            "alpha {alpha} costs least by {} sampled stars: {edges:.1} edges each, {missing:.2} vertices of its link missing",
            sample.sampled
        );
        (self.family.with(alpha), why)
    }

    /// Returns the estimated steps of an alpha, times the number of sampled stars.
    fn steps(self, counts: &AlphaCounts) -> f64 {
        let Steps { edge, missing } = steps_of(self.repair, self.dimension);
        edge * counts.edges as f64 + missing * counts.missing as f64
    }

    fn first_that_certifies(self, sample: &SampleStars) -> (Supergraph, String) {
        let stars = sample.sampled;
        for (alpha, counts) in ALPHAS.into_iter().zip(&sample.of_alpha) {
            let uncertified = stars - counts.certified.min(stars);
            if uncertified as f64 <= UNCERTIFIED_SHARE * stars as f64 {
                let why = format!("alpha {alpha} certifies {} of {stars} sampled stars", counts.certified);
                return (self.family.with(alpha), why);
            }
        }
        let best = sample.of_alpha.last().map_or(0, |counts| counts.certified);
        let k = FALLBACK_K.min(self.population.saturating_sub(1).max(1) as u32);
        let why =
            format!("alpha 6 certifies only {best} of {stars} sampled stars, so {k} nearest neighbours");
        (Supergraph::Knn { k }, why)
    }

    /// Returns `true` if [`Request::choose`] can return the supergraph.
    pub(super) fn admits(self, rule: Supergraph) -> bool {
        match rule {
            Supergraph::Density { .. } | Supergraph::Overlap { .. } => {
                ALPHAS.into_iter().any(|alpha| self.family.with(alpha) == rule)
            }
            Supergraph::Knn { k } => self.purpose == Purpose::Timing && (1..=FALLBACK_K).contains(&k),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(purpose: Purpose, population: u64) -> Request {
        Request {
            family: Family::Density,
            purpose,
            repair: Repair::Splay,
            dimension: 3,
            population,
            worst: false,
        }
    }

    fn sample(sampled: u64, rows: [[u64; 3]; 4]) -> SampleStars {
        let counts = |[certified, edges, missing]: [u64; 3]| AlphaCounts { certified, edges, missing };
        SampleStars { sampled, of_alpha: rows.map(counts) }
    }

    #[test]
    fn for_time_the_first_alpha_that_suffices_is_taken() {
        let certified = |n: u64, counts: [u64; 4]| sample(n, counts.map(|count| [count, 0, 0]));
        let pick = |counts| request(Purpose::Timing, 1_000_000).choose(&certified(1000, counts)).0;
        assert_eq!(pick([900, 950, 990, 1000]), Supergraph::Density { alpha: 2.5 });
        assert_eq!(pick([100, 899, 900, 990]), Supergraph::Density { alpha: 4.0 });
        assert_eq!(pick([0, 0, 0, 899]), Supergraph::Knn { k: 48 });
        let small = request(Purpose::Timing, 10).choose(&certified(10, [0; 4])).0;
        assert_eq!(small, Supergraph::Knn { k: 9 });
    }

    #[test]
    fn for_counts_edges_are_weighed_against_missing_vertices() {
        let pick = |rows| request(Purpose::Counting, 1000).choose(&sample(10, rows)).0;
        let complete = [[0, 400, 0], [0, 700, 0], [0, 1600, 0], [0, 5000, 0]];
        assert_eq!(pick(complete), Supergraph::Density { alpha: 2.5 });
        let sparse = [[0, 70, 140], [0, 110, 130], [0, 260, 90], [0, 800, 30]];
        assert_eq!(pick(sparse), Supergraph::Density { alpha: 6.0 });
        let worst = Request { worst: true, ..request(Purpose::Counting, 1000) };
        assert_eq!(worst.choose(&sample(10, complete)).0, Supergraph::Density { alpha: 6.0 });
    }

    #[test]
    fn only_possible_choices_are_admitted() {
        let counting = request(Purpose::Counting, 1000);
        assert!(counting.admits(Supergraph::Density { alpha: 4.0 }));
        assert!(!counting.admits(Supergraph::Density { alpha: 5.0 }));
        assert!(!counting.admits(Supergraph::Overlap { alpha: 4.0, k: 1 }));
        assert!(!counting.admits(Supergraph::Knn { k: 48 }));
        assert!(request(Purpose::Timing, 1000).admits(Supergraph::Knn { k: 48 }));
    }
}
