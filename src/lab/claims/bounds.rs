//! The constants of `brent`, `level-depth` and `replication`.
//!
//! The bounds hold for every seed. The claim `exact-counts` compares counts of one seed without a band.
//!
//! Each constant is 1.15 times the largest value over the seeds 1 to 3, rounded up to three digits. Three groups of
//! constants follow other rules:
//! - The bytes of lists vary by up to 21 % between seeds on thin sets, and other counts by at most 7 % (standard
//!   deviation). Their constants are 1.5 times the largest values.
//! - Probes process few balls, so their work varies by a factor of two. Its constants are a tenth of the constants of
//!   the descents that follow.
//! - The constants of the certificate are derived from the constants of a check and of a merge.
//!
//! `septet reproduce brent level-depth replication --figures --seed S` prints the values. After a change of the
//! charges, `bench/accept/bounds.py` prints these tables from the reports of these seeds.

use septet_core::generate::Kind;

/// A bound in the plane and in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    plane: f64,
    space: f64,
}

impl Bound {
    const fn new(plane: f64, space: f64) -> Bound {
        Bound { plane, space }
    }

    /// Returns the bound in `d` dimensions.
    pub(super) fn of(self, d: usize) -> f64 {
        if d == 2 { self.plane } else { self.space }
    }
}

/// The bounds of a phase.
#[derive(Clone, Copy, Debug)]
pub(super) struct PhaseBounds {
    pub(super) name: &'static str,
    /// Whether only runs with nearest-neighbour lists have the phase.
    pub(super) of_lists: bool,
    /// Bound on the work over `n log2 n`.
    pub(super) work: Bound,
    /// Bound on the depth over `log2 n`.
    pub(super) depth: Bound,
}

const fn phase(name: &'static str, work: Bound, depth: Bound) -> PhaseBounds {
    PhaseBounds { name, of_lists: false, work, depth }
}

const fn of_lists(name: &'static str, work: Bound, depth: Bound) -> PhaseBounds {
    PhaseBounds { name, of_lists: true, work, depth }
}

/// Bound on `T_n` over `log2 n`.
pub(super) const T_N: Bound = Bound::new(268.0, 608.0);

/// The bounds of the phases.
pub(super) const PHASES: [PhaseBounds; 14] = [
    phase("partition", Bound::new(47.2, 46.1), Bound::new(72.1, 76.2)),
    phase("radii", Bound::new(17.5, 17.5), Bound::new(0.384, 0.384)),
    phase("probe", Bound::new(1.18, 3.23), Bound::new(8.98, 8.64)),
    phase("neighbours", Bound::new(11.8, 32.3), Bound::new(9.71, 10.1)),
    phase("summaries", Bound::new(0.135, 0.135), Bound::new(1.03, 1.06)),
    phase("separator-sets", Bound::new(6.25, 13.8), Bound::new(6.65, 6.87)),
    phase("graph", Bound::new(52.9, 142.0), Bound::new(0.511, 0.512)),
    phase("hulls", Bound::new(34.6, 208.0), Bound::new(12.6, 26.6)),
    phase("check", Bound::new(11.2, 46.5), Bound::new(1.92, 2.18)),
    // Splaying is rare on these points. Its certificate costs at most as much as a check and a merge.
    phase("certificate", Bound::new(15.7, 68.4), Bound::new(3.1, 3.4)),
    phase("merge", Bound::new(4.48, 21.9), Bound::new(1.10, 1.14)),
    of_lists("knn-radii", Bound::new(96.6, 86.5), Bound::new(2.05, 2.05)),
    of_lists("knn-probe", Bound::new(17.4, 50.2), Bound::new(13.0, 13.2)),
    of_lists("knn", Bound::new(174.0, 502.0), Bound::new(14.9, 15.2)),
];

/// The bound on the depth of a small node, of fewer than 1,600 points, in a phase that runs level by level.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelCap {
    pub(super) name: &'static str,
    /// Whether only some nodes of a run have the phase. The bound then holds for nodes of any size.
    pub(super) probes: bool,
    pub(super) depth: Bound,
}

const fn level(name: &'static str, depth: Bound) -> LevelCap {
    LevelCap { name, probes: false, depth }
}

const fn of_probe(name: &'static str, depth: Bound) -> LevelCap {
    LevelCap { probes: true, ..level(name, depth) }
}

/// The bounds on the depth of small nodes, in steps.
pub(super) const LEVELS: [LevelCap; 7] = [
    level("partition", Bound::new(93.2, 96.6)),
    of_probe("probe", Bound::new(11.5, 11.5)),
    level("neighbours", Bound::new(11.5, 11.5)),
    level("summaries", Bound::new(1.15, 1.15)),
    of_probe("knn-probe", Bound::new(17.3, 17.3)),
    level("knn", Bound::new(17.3, 17.3)),
    level("separator-sets", Bound::new(8.05, 8.05)),
];

/// The bounds of `replication` for one kind of points. Each is a count divided by the number of points.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReplicationBounds {
    pub(super) kind: Kind,
    /// Points of all leaves, ghosts included, for density graphs.
    pub(super) density: Bound,
    /// Points of all leaves, ghosts included, for overlap graphs.
    pub(super) overlap: Bound,
    /// Items of the descent of nearest-neighbour lists, summed over all nodes.
    pub(super) items: Bound,
    /// Visits of balls to leaves.
    pub(super) visits: Bound,
    /// Bytes of the messages of the lists.
    pub(super) bytes: Bound,
}

const fn of_kind(kind: Kind, [density, overlap, items, visits, bytes]: [Bound; 5]) -> ReplicationBounds {
    ReplicationBounds { kind, density, overlap, items, visits, bytes }
}

/// The bounds of `replication`.
pub(super) const REPLICATION: [ReplicationBounds; 9] = [
    of_kind(
        Kind::Uniform,
        [
            Bound::new(2.12, 6.07),
            Bound::new(3.17, 11.2),
            Bound::new(110.0, 366.0),
            Bound::new(2.23, 7.95),
            Bound::new(41.8, 208.0),
        ],
    ),
    of_kind(
        Kind::Jittered,
        [
            Bound::new(2.91, 9.21),
            Bound::new(3.68, 14.1),
            Bound::new(115.0, 383.0),
            Bound::new(2.36, 8.34),
            Bound::new(47.9, 267.0),
        ],
    ),
    of_kind(
        Kind::Grid,
        [
            Bound::new(3.49, 13.2),
            Bound::new(4.29, 18.2),
            Bound::new(117.0, 385.0),
            Bound::new(2.40, 8.43),
            Bound::new(48.9, 279.0),
        ],
    ),
    of_kind(
        Kind::Sphere,
        [
            Bound::new(1.21, 2.23),
            Bound::new(1.33, 3.36),
            Bound::new(30.1, 122.0),
            Bound::new(0.472, 2.49),
            Bound::new(1.80, 61.7),
        ],
    ),
    of_kind(
        Kind::Slab,
        [
            Bound::new(1.76, 2.21),
            Bound::new(2.35, 3.30),
            Bound::new(63.0, 114.0),
            Bound::new(1.21, 2.34),
            Bound::new(3.17, 44.0),
        ],
    ),
    of_kind(
        Kind::Clusters,
        [
            Bound::new(2.14, 6.19),
            Bound::new(4.33, 17.9),
            Bound::new(114.0, 380.0),
            Bound::new(2.31, 8.30),
            Bound::new(13.7, 50.5),
        ],
    ),
    of_kind(
        Kind::Line,
        [
            Bound::new(1.92, 3.56),
            Bound::new(2.82, 5.36),
            Bound::new(80.4, 142.0),
            Bound::new(1.60, 3.11),
            Bound::new(6.15, 11.1),
        ],
    ),
    of_kind(
        Kind::WellSpaced,
        [
            Bound::new(3.21, 12.2),
            Bound::new(4.04, 17.7),
            Bound::new(115.0, 387.0),
            Bound::new(2.32, 8.46),
            Bound::new(44.6, 250.0),
        ],
    ),
    of_kind(
        Kind::GradedPoint,
        [
            Bound::new(3.24, 13.0),
            Bound::new(4.34, 25.1),
            Bound::new(118.0, 450.0),
            Bound::new(2.39, 9.81),
            Bound::new(54.3, 279.0),
        ],
    ),
];
