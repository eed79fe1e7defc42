//! The data of a rank for pictures: sampled points, and the splits that it reports.
//!
//! Ranks make these data only on request, and no other result of the run depends on them. A hash of the coordinates
//! decides whether a point is in the sample, so the sample is the same for every number of ranks.

use std::collections::BTreeSet;

use septet_geometry::cost::Sweep;
use septet_geometry::hash::hash_of_place;
use septet_geometry::measure::Diameters;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{SHOWN_LOCAL, SHOWN_REPAIRED, ViewPart};

use crate::machine::context::Context;
use crate::result::merge::Results;
use crate::state::ghosts::Ghosts;
use crate::state::tree::{Split, Tree, join_bounds};

/// Returns `true` if a point is in the sample of a set with `population` points. The expected size of the sample is
/// five standard deviations below `wanted`, so that the sample rarely has to be truncated.
pub fn is_shown<P: Point>(population: u64, wanted: u32, x: P) -> bool {
    let wanted = f64::from(wanted);
    if population as f64 <= wanted {
        return wanted > 0.0;
    }
    let rate = (wanted - 5.0 * wanted.sqrt()).max(1.0) / population as f64;
    ((hash_of_place(x) >> 11) as f64) < rate * (1u64 << 53) as f64
}

/// Returns a sample of the points, and the splits that this rank reports.
pub(crate) fn view_part<P: Point>(
    cx: &Context<P>,
    results: Results<'_, P>,
    ghosts: &Ghosts,
    population: u64,
) -> ViewPart<P> {
    let sample = Sample { population, wanted: cx.config().shown.view };
    let mut part = ViewPart::default();
    results.show_points(sample, &mut part);
    results.show_ghosts(ghosts, sample, &mut part);
    results.show_splits(cx.rank(), &mut part);
    part
}

/// The sample: about `wanted` of `population` points.
#[derive(Clone, Copy)]
struct Sample {
    population: u64,
    wanted: u32,
}

impl Sample {
    fn contains<P: Point>(self, x: P) -> bool {
        is_shown(self.population, self.wanted, x)
    }
}

impl<P: Point> Results<'_, P> {
    fn position(&self, at: u32) -> P {
        self.view().table().positions()[at as usize]
    }

    fn show_points(&self, sample: Sample, part: &mut ViewPart<P>) {
        let mut diameters = Diameters::default();
        for leaf in self.subdomain().leaves() {
            for vertex in leaf.owned().filter(|&v| sample.contains(self.position(v))) {
                let star = self.merge_star(vertex, &mut diameters, &mut Sweep::default()).merged;
                self.view().table().export(vertex, &mut part.points);
                part.leaves.push(leaf.id().0);
                part.crossing.push(self.crossed_levels(vertex, leaf.id()));
                let repaired = if star.repaired > 0 { SHOWN_REPAIRED } else { 0 };
                let local = if star.local > 0 { SHOWN_LOCAL } else { 0 };
                part.flags.push(repaired | local);
            }
        }
    }

    /// Returns a word whose bit `l` is set if the separator ball of an owned point crosses the separator of its
    /// ancestor at level `l`.
    fn crossed_levels(&self, vertex: u32, leaf: NodeId) -> u64 {
        let x = self.position(vertex);
        let radius = self.separator_radius(vertex);
        let bit = |id: NodeId, split: &Split<P>| {
            u64::from(split.separator().crosses(x, radius)) << id.level().min(NodeId::DEEPEST)
        };
        let mut levels = 0;
        for shared in self.subdomain().path() {
            levels |= bit(shared.id(), shared.split());
        }
        let mut tree = self.subdomain().tree();
        while let Some(Tree::Node(inner)) = tree {
            levels |= bit(inner.id(), inner.split());
            tree = inner.children().get(inner.id().side_of(leaf));
        }
        levels
    }

    fn show_ghosts(&self, ghosts: &Ghosts, sample: Sample, part: &mut ViewPart<P>) {
        for (at, leaf) in self.subdomain().leaves().iter().enumerate() {
            let shown: BTreeSet<u32> =
                ghosts.of(at).iter().copied().filter(|&g| sample.contains(self.position(g))).collect();
            for ghost in shown {
                part.ghosts.push(self.view().table().ids()[ghost as usize]);
                part.ghost_leaves.push(leaf.id().0);
            }
        }
    }

    /// Adds the splits of this rank's own subtree, and the splits of the shared nodes of which it is the lowest rank.
    fn show_splits(&self, rank: Rank, part: &mut ViewPart<P>) {
        for shared in self.subdomain().path().iter().filter(|s| s.first() == rank) {
            show_split(shared.id(), shared.split(), part);
        }
        let mut open: Vec<&Tree<P>> = self.subdomain().tree().into_iter().collect();
        while let Some(tree) = open.pop() {
            if let Tree::Node(inner) = tree {
                show_split(inner.id(), inner.split(), part);
                open.extend(inner.children());
            }
        }
    }
}

fn show_split<P: Point>(id: NodeId, split: &Split<P>, part: &mut ViewPart<P>) {
    let (low, high) = join_bounds(split.boxes()[0], split.boxes()[1]);
    part.nodes.push(id.0);
    part.separators.extend_from_slice(split.separator().to_array().as_ref());
    part.boxes.extend([low, high]);
}
