//! The defects of received bodies, which no rank sends: with them, a rank could not even refuse the message.
//!
//! A body without a defect may still be wrong. The certificate, the sums and the balance of the ledger detect that.

use septet_geometry::point::Point;
use septet_geometry::range::Digits;
use septet_geometry::separator::Separator;

use super::{
    Body, Child, Crossings, Decision, Merged, PointBatch, Route, RouteBatch, SampleStars, SetCounts,
    SplitBatch, Summary, Survey, Totals,
};
use crate::ids::{NodeId, Rank};

const COLUMNS: &str = "its arrays do not fit together";
const RANK: &str = "it names a rank that does not exist";
const PLACE: &str = "it has a coordinate outside the exact range";
const WEIGHT: &str = "it has a weight that is not a number";
const RADIUS: &str = "it has a radius that is not a number";
const COUNT: &str = "it counts more than a run can contain";
const POINT: &str = "it names a point that it does not contain";

/// Returns the defect with this name, unless the condition holds.
fn unless(holds: bool, defect: &'static str) -> Option<&'static str> {
    (!holds).then_some(defect)
}

fn of_places<P: Point>(points: &[P]) -> Option<&'static str> {
    let fits = |digits: Option<Digits>| digits.is_some_and(Digits::fits);
    unless(fits(Digits::upper_bound(points)) || fits(Digits::of(points)), PLACE)
}

fn of_radii(radii2: &[f64]) -> Option<&'static str> {
    unless(radii2.iter().all(|&radius2| radius2 >= 0.0), RADIUS)
}

/// Counts below this number cannot overflow when those of all ranks are added.
const MOST: u64 = 1 << 44;

fn of_counts(counts: &[u64]) -> Option<&'static str> {
    unless(counts.iter().all(|&count| count < MOST), COUNT)
}

fn of_ranks(ranks: u32, named: &[Rank]) -> Option<&'static str> {
    unless(named.iter().all(|&rank| rank < ranks), RANK)
}

/// Returns the defect of positions in a batch of `points` points.
fn of_positions(positions: &[u32], points: usize) -> Option<&'static str> {
    unless(positions.iter().all(|&at| (at as usize) < points), POINT)
}

fn add_up_to(counts: &[u32], sum: usize) -> bool {
    counts.iter().map(|&count| u64::from(count)).sum::<u64>() == sum as u64
}

impl Merged {
    fn defect(&self) -> Option<&'static str> {
        let Merged {
            stars, cells, hull_facets, minima, disagreements, repaired, local, exchange_rounds, ..
        } = *self;
        of_counts(&[stars, cells, hull_facets, minima, disagreements, repaired, local, exchange_rounds])
    }
}

impl Totals {
    fn defect(&self) -> Option<&'static str> {
        self.merged.defect().or_else(|| of_counts(&[self.cells, self.hull_facets, self.left_out]))
    }
}

impl Survey {
    fn defect(&self) -> Option<&'static str> {
        let (low, high) = self.digits;
        let valid = Digits::new(self.digits) == Digits::NONE || -1074 <= low && low <= high && high <= 1024;
        of_counts(&[self.rows, self.refused, self.negative_zeros]).or_else(|| unless(valid, PLACE))
    }
}

impl<P: Point> PointBatch<P> {
    /// Returns the defect of a batch with all columns.
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        unless(self.is_consistent(), COLUMNS).or_else(|| self.defect_in_transit(ranks))
    }

    /// Returns the defect of a batch whose last two columns may be empty.
    fn defect_in_transit(&self, ranks: u32) -> Option<&'static str> {
        let fits = |column: usize| column == 0 || column == self.len();
        let columns =
            self.positions.len() == self.len() && fits(self.owners.len()) && fits(self.radii2.len());
        unless(columns, COLUMNS)
            .or_else(|| of_ranks(ranks, &self.owners))
            .or_else(|| of_places(&self.positions))
            .or_else(|| of_radii(&self.radii2))
    }
}

impl<P: Point> Summary<P> {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        of_radii(&[self.max_radius2]).or_else(|| self.smallest.defect(ranks))
    }
}

impl Child {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        let end = self.first.checked_add(self.ranks);
        unless(self.ranks > 0 && end.is_some_and(|end| end <= ranks), RANK)
            .or_else(|| of_counts(&[self.population]))
    }
}

impl<P: Point> SplitBatch<P> {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        let nodes = self.nodes.len();
        let has_columns = self.interior.len() == nodes
            && self.separators.len() == nodes * Separator::<P>::WORDS
            && self.boxes.len() == nodes * 4;
        unless(has_columns, COLUMNS)
            .or_else(|| of_ranks(ranks, &self.interior))
            .or_else(|| unless(self.separators.iter().all(|word| word.is_finite()), PLACE))
    }
}

impl RouteBatch {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        unless(self.is_consistent(), COLUMNS)
            .or_else(|| of_ranks(ranks, &self.receivers))
            .or_else(|| of_counts(&self.counts))
    }
}

impl Decision {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        let children = if let Decision::Split(children) = self { children.as_slice() } else { &[] };
        children.iter().find_map(|child| child.defect(ranks))
    }
}

impl Route {
    fn defect(&self, ranks: u32) -> Option<&'static str> {
        unless(self.receivers.len() == self.counts.len(), COLUMNS)
            .or_else(|| of_ranks(ranks, &self.receivers))
            .or_else(|| of_counts(&self.counts))
    }
}

impl<P: Point> Body<P> {
    /// Returns the defect of a body that no rank of a machine of `ranks` ranks sends, or `None`. The receiver's own
    /// indices are not checked here.
    pub fn defect(&self, ranks: u32) -> Option<&'static str> {
        let corners = P::DIM + 1;
        match self {
            Body::Move(points) | Body::Copies(points) => points.defect_in_transit(ranks),
            Body::Frame(points) | Body::Ghosts(points) | Body::Gather(points) => points.defect(ranks),
            Body::Samples(points) => of_places(points),
            Body::Sphere(words) => unless(words.iter().all(|word| word.is_finite()), PLACE),
            Body::Counts { inside, outside, boxes } => unless(boxes.is_empty() || boxes.len() == 4, COLUMNS)
                .or_else(|| of_counts(&[*inside, *outside])),
            Body::SetCounts(SetCounts { inside, outside, crossing_inside, crossing_outside }) => {
                of_counts(&[*inside, *outside, *crossing_inside, *crossing_outside])
            }
            Body::Crossings(Crossings { balls, height }) => {
                of_counts(&[*balls]).or_else(|| unless(*height <= u64::from(NodeId::DEEPEST) + 1, COUNT))
            }
            Body::SampleStars(SampleStars { sampled, of_alpha }) => of_counts(&[*sampled])
                .or_else(|| of_alpha.iter().find_map(|of| of_counts(&[of.certified, of.edges, of.missing]))),
            Body::Merged(merged) => merged.defect(),
            Body::BranchCounts { inside, outside, boxes } => {
                unless(inside.len() == outside.len() && (boxes.is_empty() || boxes.len() == 4), COLUMNS)
                    .or_else(|| of_counts(inside))
                    .or_else(|| of_counts(outside))
            }
            Body::Totals(totals) => totals.defect(),
            Body::Decision { decision, routes, .. } => {
                decision.defect(ranks).or_else(|| routes.iter().find_map(|route| route.defect(ranks)))
            }
            Body::BranchDecision { decision, routes, .. } => {
                decision.defect(ranks).or_else(|| routes.defect(ranks))
            }
            Body::Query(batch) => of_places(&batch.centres).or_else(|| of_radii(&batch.radii2)),
            Body::Reply(batch) => batch.points.defect(ranks),
            Body::Summary(summary) => summary.defect(ranks),
            Body::Children(both) => both.iter().find_map(|summary| summary.defect(ranks)),
            Body::Splits(splits) => splits.defect(ranks),
            Body::Reverse { points, counts, targets } => points.defect(ranks).or_else(|| {
                unless(counts.len() == points.len() && add_up_to(counts, targets.len()), COLUMNS)
            }),
            Body::Items { points, slots } => {
                points.defect(ranks).or_else(|| unless(slots.len() == points.len(), COLUMNS))
            }
            Body::Lists(lists) => lists.points.defect(ranks).or_else(|| {
                let fits = lists.slots.len() == lists.counts.len();
                unless(fits && add_up_to(&lists.counts, lists.points.len()), COLUMNS)
            }),
            Body::Propose { points, cells } => points
                .defect(ranks)
                .or_else(|| unless(cells.len().is_multiple_of(corners), COLUMNS))
                .or_else(|| of_positions(cells, points.len())),
            Body::Object { points, cells, counts, conflicts } => points
                .defect(ranks)
                .or_else(|| {
                    let fits = cells.len() == corners * counts.len();
                    unless(fits && add_up_to(counts, conflicts.len()), COLUMNS)
                })
                .or_else(|| of_positions(cells, points.len()))
                .or_else(|| of_positions(conflicts, points.len())),
            Body::WorkItems { lengths, words } => unless(add_up_to(lengths, words.len()), COLUMNS),
            Body::WorkCounts(counts) => {
                unless(counts.len() == 2 * ranks as usize, COLUMNS).or_else(|| of_counts(counts))
            }
            _ => self.defect_of_input(ranks),
        }
    }

    /// Returns the defect of a body of phase `load`.
    fn defect_of_input(&self, ranks: u32) -> Option<&'static str> {
        match self {
            Body::Survey(survey) => survey.defect(),
            Body::Sites(sites) => {
                of_counts(&[sites.hidden]).or_else(|| unless(!sites.heaviest.is_nan(), WEIGHT))
            }
            Body::Candidates(points) => points.defect_in_transit(ranks),
            Body::Repeated { keys, first } => unless(keys.len() == first.len(), COLUMNS),
            Body::Start { population, frame } => of_counts(&[population.count])
                .or_else(|| unless(frame.len() <= P::DIM + 1, COUNT))
                .or_else(|| frame.defect_in_transit(ranks)),
            _ => self.defect_of_result(ranks),
        }
    }

    /// Returns the defect of a body about open regions or facets between workers.
    fn defect_of_result(&self, ranks: u32) -> Option<&'static str> {
        match self {
            Body::Facets { vertices, entries } => unless(vertices.len() == P::DIM * entries.len(), COLUMNS),
            Body::Across { entries, ranks: across, cells } => {
                unless([across.len(), cells.len()] == [entries.len(); 2], COLUMNS)
                    .or_else(|| of_ranks(ranks, across))
            }
            Body::Region { vertices, counts, points } => points.defect(ranks).or_else(|| {
                unless(vertices.len() == counts.len() && add_up_to(counts, points.len()), COLUMNS)
            }),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use septet_geometry::point::Point;

    use super::*;
    use crate::codec::Bulk;
    use crate::message::SiteTotals;

    const RANKS: u32 = 4;

    fn batch<P: Point>() -> PointBatch<P> {
        let mut points = PointBatch::default();
        (0..3).for_each(|id| points.push(id, P::splat(id as f64), 1, f64::INFINITY));
        points
    }

    /// Expects a valid body, and a defect after each change of it.
    fn refuses(body: &Body<DVec2>, changes: &[fn(&mut Body<DVec2>)]) {
        assert_eq!(body.defect(RANKS), None, "{body:?}");
        for (at, change) in changes.iter().enumerate() {
            let mut changed = body.clone();
            change(&mut changed);
            assert!(changed.defect(RANKS).is_some(), "change {at}: {changed:?}");
        }
    }

    macro_rules! change {
        ($body:pat => $change:expr) => {
            |body| {
                let $body = body else { unreachable!() };
                $change;
            }
        };
    }

    #[test]
    fn defects_of_points_are_found() {
        refuses(
            &Body::Ghosts(batch()),
            &[
                change!(Body::Ghosts(points) => points.owners[2] = RANKS),
                change!(Body::Ghosts(points) => points.radii2[0] = f64::NAN),
                change!(Body::Ghosts(points) => points.radii2[0] = -1.0),
                change!(Body::Ghosts(points) => points.positions[1].x = f64::INFINITY),
                change!(Body::Ghosts(points) => points.positions[1].y = 1e300),
                change!(Body::Ghosts(points) => points.positions[1].y = 1e-300),
                change!(Body::Ghosts(points) => points.ids.push(7)),
                change!(Body::Ghosts(points) => points.radii2.0.clear()),
            ],
        );
        let block = PointBatch::in_transit(vec![7], vec![DVec2::ONE]);
        refuses(&Body::Copies(block.clone()), &[change!(Body::Copies(points) => points.ids.push(8))]);
        refuses(&Body::Move(block), &[change!(Body::Move(points) => points.owners.0 = vec![1, 2])]);
    }

    #[test]
    fn defects_of_indices_are_found() {
        let cells = Bulk(vec![0, 1, 2]);
        refuses(
            &Body::Propose { points: batch(), cells: cells.clone() },
            &[change!(Body::Propose { cells, .. } => cells[0] = u32::MAX)],
        );
        refuses(
            &Body::Object { points: batch(), cells, counts: Bulk(vec![2]), conflicts: Bulk(vec![0, 2]) },
            &[
                change!(Body::Object { cells, .. } => cells[1] = 3),
                change!(Body::Object { conflicts, .. } => conflicts[1] = 3),
                change!(Body::Object { counts, .. } => counts[0] = 1),
                change!(Body::Object { counts, .. } => counts.push(0)),
            ],
        );
        refuses(
            &Body::Region { vertices: Bulk(vec![4]), counts: Bulk(vec![3]), points: batch() },
            &[
                change!(Body::Region { counts, .. } => counts[0] = 4),
                change!(Body::Region { vertices, .. } => vertices.push(5)),
            ],
        );
    }

    #[test]
    fn defects_of_groups_and_counts_are_found() {
        let child = Child { population: 5, first: 2, ranks: 2, leaf: false };
        let split = Body::Decision {
            decision: Decision::Split([Child { first: 1, ranks: 1, ..child }, child]),
            boxes: Bulk(Vec::new()),
            routes: Box::default(),
        };
        refuses(
            &split,
            &[
                change!(Body::Decision { decision: Decision::Split([_, b]), .. } => b.ranks = 3),
                change!(Body::Decision { decision: Decision::Split([_, b]), .. } => b.ranks = 0),
                change!(Body::Decision { decision: Decision::Split([_, b]), .. } => b.first = u32::MAX),
                change!(Body::Decision { decision: Decision::Split([a, _]), .. } => a.population = MOST),
                change!(Body::Decision { routes, .. } => routes[1].push(RANKS, 1)),
                change!(Body::Decision { routes, .. } => routes[0].push(1, MOST)),
            ],
        );
        let splits = SplitBatch {
            nodes: Bulk(vec![1]),
            interior: Bulk(vec![2]),
            separators: Bulk(vec![0.5; 9]),
            boxes: Bulk(vec![DVec2::ZERO; 4]),
        };
        refuses(
            &Body::Splits(splits),
            &[
                change!(Body::Splits(splits) => splits.nodes.push(2)),
                change!(Body::Splits(splits) => splits.interior[0] = RANKS),
                change!(Body::Splits(splits) => splits.separators.0.truncate(8)),
                change!(Body::Splits(splits) => splits.separators[3] = f64::NAN),
                change!(Body::Splits(splits) => splits.boxes.0.truncate(3)),
            ],
        );
        let mut route = Route::default();
        route.push(2, 7);
        refuses(
            &Body::BranchDecision {
                decision: Decision::Retry,
                boxes: Bulk(Vec::new()),
                routes: RouteBatch::of(&[[route.clone(), Route::default()], [Route::default(), route]]),
            },
            &[
                change!(Body::BranchDecision { routes, .. } => routes.lengths[1] = 1),
                change!(Body::BranchDecision { routes, .. } => routes.lengths.push(0)),
                change!(Body::BranchDecision { routes, .. } => routes.counts.push(1)),
                change!(Body::BranchDecision { routes, .. } => routes.receivers[0] = RANKS),
                change!(Body::BranchDecision { routes, .. } => routes.counts[1] = MOST),
                change!(Body::BranchDecision { decision, .. } => *decision = Decision::Split([Child { population: 5, first: 2, ranks: 9, leaf: true }; 2])),
            ],
        );
        refuses(
            &Body::BranchCounts {
                inside: Bulk(vec![3, 1]),
                outside: Bulk(vec![4, 0]),
                boxes: Bulk(vec![DVec2::ZERO; 4]),
            },
            &[
                change!(Body::BranchCounts { inside, .. } => inside[1] = MOST),
                change!(Body::BranchCounts { outside, .. } => outside.push(0)),
                change!(Body::BranchCounts { boxes, .. } => boxes.0.truncate(3)),
            ],
        );
    }

    #[test]
    fn defects_of_sums_are_found() {
        refuses(
            &Body::Merged(Merged::default()),
            &[
                change!(Body::Merged(merged) => merged.cells = MOST),
                change!(Body::Merged(merged) => merged.exchange_rounds = u64::MAX),
            ],
        );
        refuses(
            &Body::Totals(Box::default()),
            &[
                change!(Body::Totals(totals) => totals.merged.stars = MOST),
                change!(Body::Totals(totals) => totals.cells = MOST),
                change!(Body::Totals(totals) => totals.hull_facets = u64::MAX),
                change!(Body::Totals(totals) => totals.left_out = MOST),
            ],
        );
        refuses(
            &Body::Sites(SiteTotals::default()),
            &[
                change!(Body::Sites(sites) => sites.hidden = MOST),
                change!(Body::Sites(sites) => sites.heaviest = f64::NAN),
            ],
        );
        refuses(
            &Body::Counts { inside: 3, outside: 4, boxes: Bulk(vec![DVec2::ZERO; 4]) },
            &[
                change!(Body::Counts { inside, .. } => *inside = MOST),
                change!(Body::Counts { boxes, .. } => boxes.0.truncate(3)),
            ],
        );
    }
}
