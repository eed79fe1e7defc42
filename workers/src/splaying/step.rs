//! One star and its messages in one step of splaying.
//!
//! **Statement.** See [`crate::splaying::splay`]. A star looks up each cell once, however many stars propose it or object to it.
//! It adds the vertices of the proposed cells that it lacks, and the witnesses against the cells that it has. It extends its
//! link by these points (`hull::change`). Then it sends the cells that it gained, and objections to those that it lost. It
//! rejects a proposed cell that it still lacks, with witnesses: the points of its link in the circumsphere of the cell. A hidden
//! point has no link: it rejects every cell, with points of its cover.
//!
//! **Work and depth.** Let a star with `l` facets receive `m` cells, add `q` points and change by `c` facets. It
//! sorts the cells and sweeps over the link for each cell and each point. For each cell that it rejects or lost, it
//! sweeps over its points and its messages. For each cell that it gained, it sweeps over its messages. This takes
//! O((m + q) l + m log m + c m) work and O(m + q + c) depth.

mod report;
#[cfg(test)]
mod tests;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::{Extended, StarBuilder, Witnesses};
use septet_geometry::point::Point;
use septet_geometry::predicates::ExactTests;

use crate::config::Repair;
use crate::splaying::messages::{Objections, Proposal};
use crate::splaying::pending::StarInbox;
use crate::stars::links::{LinkSearch, difference, link_points};
use crate::stars::owned::{Change, StarsView};
use crate::state::cells::{finite_cell, in_order};

/// The results of the steps of several stars.
pub(super) struct Splayed<P: Point> {
    stars: Vec<SplayedStar<P::Cell>>,
    /// The new links of the stars that changed.
    links: Vec<P::Facet>,
    /// The facets gained.
    gained: Vec<P::Facet>,
    /// The facets lost.
    lost: Vec<P::Facet>,
    pub(super) proposals: Vec<Proposal<P::Cell>>,
    pub(super) objections: Objections<P::Cell>,
}

/// A star that received messages.
struct SplayedStar<C> {
    vertex: u32,
    /// The lengths of the lists after the step of the star.
    ends: Lengths,
    /// The cover of the vertex, if the step hid it.
    cover: Option<C>,
    cost: Cost,
}

/// Lengths of the lists of [`Splayed`].
#[derive(Clone, Copy, Default)]
struct Lengths {
    links: usize,
    gained: usize,
    lost: usize,
}

impl<P: Point> Default for Splayed<P> {
    fn default() -> Self {
        Splayed {
            stars: Vec::new(),
            links: Vec::new(),
            gained: Vec::new(),
            lost: Vec::new(),
            proposals: Vec::new(),
            objections: Objections::default(),
        }
    }
}

impl<P: Point> Splayed<P> {
    fn lengths(&self) -> Lengths {
        Lengths { links: self.links.len(), gained: self.gained.len(), lost: self.lost.len() }
    }

    /// Takes the meter of each star.
    pub(super) fn take_costs(&mut self) -> impl Iterator<Item = (u32, Cost)> {
        self.stars.iter_mut().map(|star| (star.vertex, std::mem::take(&mut star.cost)))
    }

    /// Calls `f` with the vertex and the change of every star that changed.
    pub(super) fn each_change(&self, mut f: impl FnMut(u32, &Change<'_, P>)) {
        let mut start = Lengths::default();
        for SplayedStar { vertex, ends, cover, .. } in &self.stars {
            let change = Change {
                link: &self.links[start.links..ends.links],
                gained: &self.gained[start.gained..ends.gained],
                lost: &self.lost[start.lost..ends.lost],
                cover: *cover,
            };
            if !(change.gained.is_empty() && change.lost.is_empty() && cover.is_none()) {
                f(*vertex, &change);
            }
            start = *ends;
        }
    }
}

/// Reused storage.
pub(super) struct Tools<P: Point> {
    builder: StarBuilder<P>,
    witnesses: Witnesses<P>,
    seen: Marks,
    /// An empty meter.
    meter: Cost,
    repair: Repair,
    /// The points that the current star adds, with repetitions.
    added: Vec<u32>,
    /// A witness against each cell that the current star lost, if its link was extended.
    removers: Vec<u32>,
    /// The witnesses against the current cell.
    against: Vec<u32>,
}

impl<P: Point> Tools<P> {
    /// Creates storage for a table with this number of points.
    pub(super) fn new(points: usize, meter: Cost, repair: Repair) -> Self {
        Tools {
            builder: match repair {
                Repair::Probe => StarBuilder::keeping_stars(),
                Repair::Splay => StarBuilder::default(),
            },
            witnesses: Witnesses::default(),
            seen: Marks::new(points),
            meter,
            repair,
            added: Vec::new(),
            removers: Vec::new(),
            against: Vec::new(),
        }
    }
}

/// The step of one star.
pub(super) struct StarStep<'a, P: Point> {
    view: StarsView<'a, P>,
    inbox: StarInbox<'a, P>,
    tools: &'a mut Tools<P>,
    out: &'a mut Splayed<P>,
    /// The lengths of the lists of `out` before the step.
    start: Lengths,
    /// The cover of the vertex, once it is hidden.
    cover: Option<P::Cell>,
    cost: Cost,
}

impl<'a, P: Point> StarStep<'a, P> {
    /// Prepares the step of the star that received `inbox`.
    pub(super) fn new(
        view: StarsView<'a, P>,
        inbox: StarInbox<'a, P>,
        tools: &'a mut Tools<P>,
        out: &'a mut Splayed<P>,
    ) -> Self {
        let start = out.lengths();
        let cost = tools.meter.nested();
        StarStep { view, inbox, tools, out, start, cover: view.stars().cover(inbox.vertex), cost }
    }

    /// Processes the messages of the star, and appends its new link and its own messages to the results.
    pub(super) fn run(mut self) {
        let vertex = self.inbox.vertex;
        if self.tools.repair == Repair::Probe {
            self.run_told();
            return;
        }
        let mut rejected = self.collect_points();
        if !self.tools.added.is_empty() {
            self.add_points();
            if !rejected.is_empty() {
                let mut sweep = Sweep::default();
                let gained = LinkSearch::<P>::new(&self.out.gained[self.start.gained..], vertex);
                rejected.retain(|cell| !gained.contains(cell, &mut sweep));
                self.cost.charge_sweep(sweep);
            }
        }
        self.propose_gained();
        if !rejected.is_empty() || self.out.lost.len() > self.start.lost {
            self.object(&rejected);
        }
        self.end();
    }

    /// Adds the collected points to the link. A hidden vertex stays hidden.
    fn add_points(&mut self) {
        if self.cover.is_some() {
            return;
        }
        if self.inbox.gathered.is_empty() {
            self.extend_link();
        } else {
            self.rebuild_link();
        }
    }

    /// Records the end of the step.
    fn end(self) {
        let (vertex, ends) = (self.inbox.vertex, self.out.lengths());
        let cover = self.cover.filter(|_| self.view.stars().cover(vertex).is_none());
        self.out.stars.push(SplayedStar { vertex, ends, cover, cost: self.cost });
    }

    /// Returns the link before the step.
    fn old_link(&self) -> &'a [P::Facet] {
        self.view.link(self.inbox.vertex)
    }

    /// Collects the points to be added. Returns the proposed cells that the star lacks.
    fn collect_points(&mut self) -> Vec<P::Cell> {
        let StarInbox { vertex, proposals, objections, gathered, answers, .. } = self.inbox;
        let (link, mut sweep) = (LinkSearch::<P>::new(self.old_link(), vertex), Sweep::default());
        let mut missing: Vec<P::Cell> = proposals.iter().map(|p| p.cell).collect();
        self.cost.distinct(&mut missing, Ord::cmp);
        missing.retain(|cell| !link.contains(cell, &mut sweep));
        let mut present: Vec<P::Cell> = objections.iter().map(|o| o.cell).collect();
        self.cost.distinct(&mut present, Ord::cmp);
        present.retain(|cell| link.contains(cell, &mut sweep));
        // Each cell marks its run of the sorted objections.
        let valid = sweep.visit_all(objections).iter().filter(|o| present.binary_search(&o.cell).is_ok());
        let added = &mut self.tools.added;
        added.clear();
        added.extend(missing.iter().flat_map(AsRef::as_ref));
        added.extend(valid.flat_map(|o| self.inbox.witnesses(o)));
        added.extend(gathered.iter().chain(answers).map(|g| g.point));
        sweep.visit_all(added);
        self.cost.charge_sweep(sweep);
        missing
    }

    /// Extends the link by the collected points.
    fn extend_link(&mut self) {
        let (vertex, old) = (self.inbox.vertex, self.old_link());
        let positions = self.view.table().positions();
        let StarStep { tools, out, cost, start, cover, .. } = self;
        match tools.builder.extend(positions, vertex, old, &tools.added, cost) {
            Extended::Changed => {
                *cover = tools.builder.cover();
                tools.builder.facets(&mut out.links);
                tools.builder.created_facets(&mut out.gained);
                out.lost.extend(tools.builder.removed_facets().iter().map(|&at| old[at as usize]));
                tools.removers.extend_from_slice(tools.builder.removers());
                if tools.repair == Repair::Splay {
                    let mut flags = Sweep::default();
                    flags.visit_all(&out.links[start.links..]);
                    flags.visit_all(old);
                    cost.charge_sweep(flags);
                }
            }
            Extended::Same => {}
            Extended::Open => self.rebuild_link(),
        }
    }

    /// Builds the link from the old link's points and the collected points. This handles stars without a link and,
    /// after gathering, links with holes.
    fn rebuild_link(&mut self) {
        let (vertex, old) = (self.inbox.vertex, self.old_link());
        let positions = self.view.table().positions();
        let StarStep { tools, out, cost, start, cover, .. } = self;
        let mut candidates: Vec<u32> =
            old.iter().flat_map(AsRef::as_ref).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend(&tools.added);
        cost.distinct_indices(&mut candidates, &mut tools.seen);
        if tools.builder.build(positions, vertex, &candidates, cost) {
            *cover = tools.builder.cover();
            tools.builder.facets(&mut out.links);
            let change = difference::<P>(old, &out.links[start.links..], cost);
            if change.gained.is_empty() && change.lost.is_empty() {
                out.links.truncate(start.links);
            }
            out.gained.extend(change.gained);
            out.lost.extend(change.lost);
        }
    }

    /// Proposes the cells gained to their receivers, except to stars that proposed them.
    fn propose_gained(&mut self) {
        let StarInbox { vertex, proposals, .. } = self.inbox;
        let (mut step, mut sweep) = (Sweep::default(), Sweep::default());
        let (view, out) = (self.view, &mut *self.out);
        step.each(&out.gained[self.start.gained..], |facet| {
            let Some(cell) = finite_cell::<P>(vertex, facet) else { return };
            let cell = in_order::<P>(&cell);
            let senders = with_cell(proposals, &cell, |p| p.cell, &mut sweep);
            let others = receivers(view, vertex, &cell).filter(|v| senders.iter().all(|p| p.from != *v));
            out.proposals.extend(others.map(|to| Proposal { to, cell, from: vertex }));
        });
        self.cost.charge_sweep(sweep);
        self.cost.charge_sweep(step);
    }

    /// Sends objections: for each rejected proposal to its proposers, for each lost cell to the stars that must agree on it.
    /// For lost cells, it skips stars that objected to the cell in the same step.
    fn object(&mut self, rejected: &[P::Cell]) {
        let StarInbox { vertex, proposals, objections, .. } = self.inbox;
        let (view, out, tools) = (self.view, &mut *self.out, &mut *self.tools);
        let positions = view.table().positions();
        let has_changed = out.gained.len() > self.start.gained || out.lost.len() > self.start.lost;
        let link = if has_changed { &out.links[self.start.links..] } else { view.link(vertex) };
        let points = match self.cover {
            Some(cover) => cover.as_ref().to_vec(),
            None => link_points::<P>(link, &mut tools.seen, &mut self.cost),
        };
        if points.is_empty() {
            return;
        }
        let exact = ExactTests::so_far();
        let (mut sweep, against) = (Sweep::default(), &mut tools.against);
        tools.witnesses.load(positions, vertex, &points, &mut sweep);
        for cell in rejected {
            against.clear();
            tools.witnesses.append_inside(positions, cell, against, &mut sweep);
            if !against.is_empty() {
                let proposers = with_cell(proposals, cell, |p| p.cell, &mut sweep);
                out.objections.add(proposers.iter().map(|p| p.from), *cell, vertex, against);
            }
        }
        for facet in &out.lost[self.start.lost..] {
            let Some(cell) = finite_cell::<P>(vertex, facet) else { continue };
            let cell = in_order::<P>(&cell);
            against.clear();
            tools.witnesses.append_inside(positions, &cell, against, &mut sweep);
            let objectors = with_cell(objections, &cell, |o| o.cell, &mut sweep);
            let others = receivers(view, vertex, &cell).filter(|v| objectors.iter().all(|o| o.from != *v));
            out.objections.add(others, cell, vertex, against);
        }
        self.cost.charge_sweep(sweep);
        self.cost.charge_exact_tests(exact.since());
    }
}

/// Returns the vertices whose stars must agree with the star of `vertex` on a cell: the smallest vertex of the cell, or all
/// others if `vertex` is the smallest.
fn receivers<P: Point>(view: StarsView<'_, P>, vertex: u32, cell: &P::Cell) -> impl Iterator<Item = u32> {
    let smallest = view.smallest(cell);
    let is_receiver = move |v: u32| v != vertex && (smallest == vertex || v == smallest);
    cell.as_ref().iter().copied().filter(move |&v| is_receiver(v))
}

/// Returns the messages about one cell, from messages sorted by cell. Charges a comparison with every message,
/// because the model compares all of them in one step. The code uses a binary search.
fn with_cell<'a, T, C: Ord>(
    messages: &'a [T],
    cell: &C,
    cell_of: impl Fn(&T) -> C,
    sweep: &mut Sweep,
) -> &'a [T] {
    let first = sweep.visit_all(messages).partition_point(|t| cell_of(t) < *cell);
    let count = messages[first..].iter().take_while(|t| cell_of(t) == *cell).count();
    &messages[first..first + count]
}
