//! The step of a star that reports to registers.
//!
//! **Statement.** A register sends a star only cells that the star lacks, and witnesses only against cells that it has
//! ([`crate::splaying::register`]). The star adds the vertices of these cells, the witnesses and the answers to its candidates. Then it
//! reports each cell that it gained. It *refutes* each cell that it lost, and each proposed cell that it still lacks, with one
//! witness. Against a lost cell, this is the candidate that removed it. Against another cell, it is the point of its link in the
//! circumsphere of the cell that is nearest to the circumcentre. With weights, it is the point of the link or of the cover with
//! the least power.
//!
//! **Work and depth.** Let a star with `l` facets receive `m` cells, add `q` points and change by `c` facets. It sorts the cells
//! with its gained facets, and sweeps over its points for each proposed cell that it refutes. This takes O(m l + (m + c) log (m + c))
//! work and O(log (m + c)) depth, and the addition of `q` points. The machine keeps the complex of the star between two steps
//! ([`StarBuilder::keeping_stars`](septet_geometry::hull::StarBuilder::keeping_stars)). The vertices that the link loses are among
//! those of the lost facets.

use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Point, dist2, lex_cmp};
use septet_geometry::predicates::ExactTests;

use super::StarStep;
use crate::splaying::messages::{Proposal, corners};
use crate::stars::links::link_points;
use crate::state::cells::{finite_cell, in_order};

impl<P: Point> StarStep<'_, P> {
    /// Processes the messages of the star, and appends its new link and its reports to the results.
    pub(super) fn run_told(mut self) {
        self.collect_told();
        self.tools.removers.clear();
        if !self.tools.added.is_empty() {
            self.add_points();
        }
        let mut refuted = self.report_gained();
        let removed = self.refute_removed();
        refuted.extend(removed);
        if !refuted.is_empty() {
            self.refute(&refuted);
        }
        self.end();
    }

    /// Refutes the cells that the extension of the link removed. Returns the lost cells whose removers are not known, because the
    /// link was built again.
    fn refute_removed(&mut self) -> Vec<P::Cell> {
        let (vertex, view, out) = (self.inbox.vertex, self.view, &mut *self.out);
        let lost = out.lost[self.start.lost..].iter();
        let cells = lost.map(|facet| Some(in_order::<P>(&finite_cell::<P>(vertex, facet)?)));
        let removers = &self.tools.removers;
        if removers.is_empty() {
            return cells.flatten().collect();
        }
        for (cell, &remover) in cells.zip(removers) {
            if let Some(cell) = cell {
                out.objections.add([view.smallest(&cell)].into_iter(), cell, vertex, &[remover]);
            }
        }
        Vec::new()
    }

    /// Collects the points to be added.
    fn collect_told(&mut self) {
        let mut sweep = Sweep::default();
        let (inbox, added) = (&self.inbox, &mut self.tools.added);
        added.clear();
        let told = inbox.proposals.iter().flat_map(|p| p.cell.as_ref());
        added.extend(told.filter(|&&v| v != inbox.vertex));
        added.extend(inbox.objections.iter().flat_map(|o| inbox.witnesses(o)));
        added.extend(inbox.gathered.iter().chain(inbox.answers).map(|g| g.point));
        sweep.visit_all(added);
        self.cost.charge_sweep(sweep);
    }

    /// Reports the cells gained to their smallest vertices. Returns the proposed cells that the star did not gain.
    fn report_gained(&mut self) -> Vec<P::Cell> {
        let (vertex, view) = (self.inbox.vertex, self.view);
        let finite =
            self.out.gained[self.start.gained..].iter().filter_map(|facet| finite_cell::<P>(vertex, facet));
        let mut gained: Vec<P::Cell> = finite.map(|cell| in_order::<P>(&cell)).collect();
        let mut proposed: Vec<P::Cell> = self.inbox.proposals.iter().map(|p| p.cell).collect();
        proposed.dedup();
        let (mut sorted, mut changes) = (Sweep::default(), Sweep::default());
        if !proposed.is_empty() {
            sorted.visit_all(&gained);
            sorted.visit_all(&proposed);
            self.cost.charge_sort(sorted);
        }
        changes.visit_all(&gained);
        changes.visit_all(&proposed);
        changes.visit_all(&self.out.lost[self.start.lost..]);
        self.cost.charge_sweep(changes);
        gained.sort_unstable();
        proposed.retain(|cell| gained.binary_search(cell).is_err());
        let reports =
            gained.into_iter().map(|cell| Proposal { to: view.smallest(&cell), cell, from: vertex });
        self.out.proposals.extend(reports);
        proposed
    }

    /// Sends a witness against each cell to its smallest vertex.
    fn refute(&mut self, cells: &[P::Cell]) {
        let (view, vertex, out, tools) = (self.view, self.inbox.vertex, &mut *self.out, &mut *self.tools);
        let (table, positions) = (view.table(), view.table().positions());
        let (lost, gained) = (&out.lost[self.start.lost..], &out.gained[self.start.gained..]);
        let link = if lost.is_empty() && gained.is_empty() {
            view.link(vertex)
        } else {
            &out.links[self.start.links..]
        };
        let points = match self.cover {
            Some(cover) => cover.as_ref().to_vec(),
            None => kept_points::<P>(link, lost, &mut tools.seen, &mut self.cost),
        };
        if points.is_empty() {
            return;
        }
        let exact = ExactTests::so_far();
        let (mut sweep, against) = (Sweep::default(), &mut tools.against);
        tools.witnesses.load(positions, vertex, &points, &mut sweep);
        for cell in cells {
            against.clear();
            tools.witnesses.append_inside(positions, cell, against, &mut sweep);
            sweep.visit();
            let at = circumcentre(&corners(table, cell).as_ref()[..=P::DIM]);
            let place = |v: u32| &positions[v as usize];
            let power = |v: u32| dist2(*place(v), at) - place(v).weight();
            let deepest = against.iter().copied().min_by(|&a, &b| {
                let by_power = power(a).total_cmp(&power(b));
                by_power.then_with(|| lex_cmp(place(a), place(b)))
            });
            if let Some(deepest) = deepest {
                out.objections.add([view.smallest(cell)].into_iter(), *cell, vertex, &[deepest]);
            }
        }
        self.cost.charge_sweep(sweep);
        self.cost.charge_exact_tests(exact.since());
    }
}

/// Returns the finite vertices of a link. The machine keeps their list, and removes those that only the `lost` facets had.
fn kept_points<P: Point>(
    link: &[P::Facet],
    lost: &[P::Facet],
    seen: &mut Marks,
    cost: &mut Cost,
) -> Vec<u32> {
    let points = link_points::<P>(link, seen, &mut cost.fresh());
    if !lost.is_empty() {
        let mut vertices = Sweep::default();
        vertices.visit_all(bytemuck::cast_slice::<P::Facet, u32>(lost));
        cost.charge_distinct(vertices);
    }
    points
}
