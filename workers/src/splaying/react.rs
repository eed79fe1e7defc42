//! One star, and all that it was told in a step of the exchange.
//!
//! **Statement.** See [`crate::splaying::repair`]. A star looks for each cell among its own once, however many proposed it or
//! object to it. It takes the vertices of those that it lacks and the points against those that it holds, grows from
//! its link (`hull::change`), and then says what it gained, what it lost and why, and why it refuses what it
//! does not hold even so: a point of its link is in the sphere of a cell that it has all vertices of and lacks.
//!
//! **Work and depth.** For a star with `l` facets that is told of `m` cells, gets `q` points and changes by `c` facets: a
//! sort of the cells, sweeps over the link for each cell and point, over its points for each cell that is refused or lost,
//! and over what it was told for each of those and of the cells it gained; O((m + q) l + m log m + c m) work,
//! O(m + q + c) depth.

#[cfg(test)]
mod tests;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::{Extended, StarBuilder, Witnesses};
use septet_geometry::point::Point;

use crate::splaying::exchange::{Objection, Proposal, Said, Told, in_order};
use crate::stars::links::{Sought, difference, link_points};
use crate::worker::{Worker, finite_cell};

/// What stars make of what they were told, one after the other.
pub(crate) struct Reactions<P: Point> {
    stars: Vec<Star>,
    /// The links of those that changed; what they have that they had not, and had that they have not.
    links: Vec<P::Facet>,
    fresh: Vec<P::Facet>,
    gone: Vec<P::Facet>,
    /// What they say.
    pub(crate) proposals: Vec<Proposal<P>>,
    pub(crate) objections: Said<P>,
}

/// A star that was told something: where its lists end.
struct Star {
    home: u32,
    links: usize,
    fresh: usize,
    gone: usize,
    cost: Cost,
}

impl<P: Point> Default for Reactions<P> {
    fn default() -> Self {
        Reactions {
            stars: Vec::new(),
            links: Vec::new(),
            fresh: Vec::new(),
            gone: Vec::new(),
            proposals: Vec::new(),
            objections: Said::default(),
        }
    }
}

impl<P: Point> Reactions<P> {
    /// Each star, and what its reaction cost.
    pub(crate) fn costs(&self) -> impl Iterator<Item = (u32, Cost)> {
        self.stars.iter().map(|star| (star.home, star.cost))
    }

    /// Calls `f` with every star that changed: its vertex, its link, the facets that came and those that went.
    pub(crate) fn each_change(&self, mut f: impl FnMut(u32, &[P::Facet], &[P::Facet], &[P::Facet])) {
        let (mut links, mut fresh, mut gone) = (0, 0, 0);
        for star in &self.stars {
            let (came, went) = (&self.fresh[fresh..star.fresh], &self.gone[gone..star.gone]);
            if !(came.is_empty() && went.is_empty()) {
                f(star.home, &self.links[links..star.links], came, went);
            }
            (links, fresh, gone) = (star.links, star.fresh, star.gone);
        }
    }
}

/// What reacting needs, in reused storage.
pub(crate) struct Tools<P: Point> {
    builder: StarBuilder<P>,
    witnesses: Witnesses<P>,
    seen: Marks,
    /// Points that the star at hand gets, with repeats.
    added: Vec<u32>,
    /// Points against a cell.
    against: Vec<u32>,
}

impl<P: Point> Tools<P> {
    /// For a table of so many points.
    pub(crate) fn new(points: usize) -> Self {
        Tools {
            builder: StarBuilder::default(),
            witnesses: Witnesses::default(),
            seen: Marks::new(points),
            added: Vec::new(),
            against: Vec::new(),
        }
    }
}

impl<P: Point> Worker<P> {
    /// One star: takes in what it was `told`, objections with these `points`, and says what it makes of it.
    pub(crate) fn react(
        &self,
        told: &Told<'_, P>,
        points: &[u32],
        tools: &mut Tools<P>,
        out: &mut Reactions<P>,
    ) {
        let mut cost = Cost::ZERO;
        let (links, fresh, gone) = (out.links.len(), out.fresh.len(), out.gone.len());
        let mut refused = self.take_in(told, points, tools, &mut cost);
        if !tools.added.is_empty() {
            if told.gathered.is_empty() {
                self.rebuild_star(told.home, tools, out, &mut cost);
            } else {
                self.build_anew(told.home, tools, out, &mut cost);
            }
            if !refused.is_empty() {
                let mut looked = Sweep::default();
                let held = Sought::<P>::of(&out.fresh[fresh..], told.home);
                refused.retain(|cell| !held.has(cell, &mut looked));
                cost.swept_inside(looked);
            }
        }
        let changed = out.fresh.len() > fresh || out.gone.len() > gone;
        self.propose_fresh(told, fresh, out, &mut cost);
        if !refused.is_empty() || out.gone.len() > gone {
            let link = if changed { &out.links[links..] } else { self.stars.link(told.home) };
            let present = link_points::<P>(link, &mut tools.seen, &mut cost);
            self.object(told, &refused, (gone, &present), tools, out, &mut cost);
        }
        let (links, fresh, gone) = (out.links.len(), out.fresh.len(), out.gone.len());
        out.stars.push(Star { home: told.home, links, fresh, gone, cost });
    }

    /// Collects the points that a star is to get; returns the cells that it lacks.
    fn take_in(
        &self,
        told: &Told<'_, P>,
        points: &[u32],
        tools: &mut Tools<P>,
        cost: &mut Cost,
    ) -> Vec<P::Cell> {
        let home = told.home;
        let link = self.stars.link(home);
        let (sought, mut looked) = (Sought::<P>::of(link, home), Sweep::default());
        let mut lacking: Vec<P::Cell> = told.proposed.iter().map(|p| p.1).collect();
        cost.distinct_inside(&mut lacking, Ord::cmp);
        lacking.retain(|cell| !sought.has(cell, &mut looked));
        let mut held: Vec<P::Cell> = told.objected.iter().map(|o| o.1).collect();
        cost.distinct_inside(&mut held, Ord::cmp);
        held.retain(|cell| sought.has(cell, &mut looked));
        tools.added.clear();
        let proposed = lacking.iter().flat_map(AsRef::as_ref);
        // Every cell tells its run of the sorted objections whether it is held.
        looked.visit_lanes(told.objected.len());
        let heeded = told.objected.iter().filter(|o| held.binary_search(&o.1).is_ok());
        let named = proposed.chain(heeded.flat_map(|o| &points[o.3.clone()])).copied();
        tools.added.extend(named.chain(told.gathered.iter().map(|g| g.1)));
        looked.visit_lanes(tools.added.len());
        cost.swept_inside(looked);
        lacking
    }

    /// A star gets the points collected for it; appends its link, and how it differs, if it does.
    fn rebuild_star(&self, home: u32, tools: &mut Tools<P>, out: &mut Reactions<P>, cost: &mut Cost) {
        let old = self.stars.link(home);
        let before = out.links.len();
        match tools.builder.extend(&self.table.positions, home, old, &tools.added, cost) {
            Extended::Changed => {
                tools.builder.facets(&mut out.links);
                tools.builder.fresh(&mut out.fresh);
                out.gone.extend(tools.builder.gone().iter().map(|&at| old[at as usize]));
                let mut flags = Sweep::default();
                flags.visit_lanes(out.links.len() - before + old.len());
                cost.swept_inside(flags);
            }
            Extended::Same => {}
            Extended::Open => self.build_anew(home, tools, out, cost),
        }
    }

    /// A star from all its points: where it has no link yet, and where a gathering brings what may be missing from a
    /// link that is not one.
    fn build_anew(&self, home: u32, tools: &mut Tools<P>, out: &mut Reactions<P>, cost: &mut Cost) {
        let old = self.stars.link(home);
        let mut candidates: Vec<u32> =
            old.iter().flat_map(AsRef::as_ref).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend(&tools.added);
        cost.distinct_numbers(&mut candidates, &mut tools.seen);
        if tools.builder.build(&self.table.positions, home, &candidates, cost) {
            let before = out.links.len();
            tools.builder.facets(&mut out.links);
            let (fresh, gone) = difference::<P>(old, &out.links[before..], cost);
            if fresh.is_empty() && gone.is_empty() {
                out.links.truncate(before);
            }
            out.fresh.extend(fresh);
            out.gone.extend(gone);
        }
    }

    /// The vertices whose stars are told of what a star gains or loses: the smallest of the cell, or if that is its own, the
    /// others.
    fn partners(&self, home: u32, cell: &P::Cell) -> impl Iterator<Item = u32> {
        let smallest = self.smallest(cell);
        let asked = move |v: u32| v != home && (smallest == home || v == smallest);
        cell.as_ref().iter().copied().filter(move |&v| asked(v))
    }

    /// Proposes what a star gained to those that did not propose it.
    fn propose_fresh(&self, told: &Told<'_, P>, fresh: usize, out: &mut Reactions<P>, cost: &mut Cost) {
        let (mut step, mut looked) = (Sweep::default(), Sweep::default());
        let (facets, proposals) = (&out.fresh[fresh..], &mut out.proposals);
        step.each(facets, |facet| {
            let Some(cell) = finite_cell::<P>(told.home, facet) else { return };
            let cell = in_order::<P>(&cell);
            let tellers = of_cell(told.proposed, &cell, |p| p.1, &mut looked);
            let others = self.partners(told.home, &cell).filter(|v| tellers.iter().all(|p| p.2 != *v));
            proposals.extend(others.map(|v| (v, cell, told.home)));
        });
        cost.swept_inside(looked);
        cost.swept_inside(step);
    }

    /// Tells why a star does not hold what was proposed, those who did; and why it lost what it had, those who did not say
    /// so.
    fn object(
        &self,
        told: &Told<'_, P>,
        refused: &[P::Cell],
        (gone, present): (usize, &[u32]),
        tools: &mut Tools<P>,
        out: &mut Reactions<P>,
        cost: &mut Cost,
    ) {
        let (home, table) = (told.home, &self.table.positions);
        let (mut tests, against) = (Sweep::default(), &mut tools.against);
        if present.is_empty() {
            return;
        }
        tools.witnesses.begin(table, home, present, &mut tests);
        for cell in refused {
            against.clear();
            tools.witnesses.against(table, cell, against, &mut tests);
            if !against.is_empty() {
                let tellers = of_cell(told.proposed, cell, |p| p.1, &mut tests);
                out.objections.add(tellers.iter().map(|p| p.2), cell, home, against);
            }
        }
        for facet in &out.gone[gone..] {
            let Some(cell) = finite_cell::<P>(home, facet) else { continue };
            let cell = in_order::<P>(&cell);
            against.clear();
            tools.witnesses.against(table, &cell, against, &mut tests);
            let tellers: &[Objection<P>] = of_cell(told.objected, &cell, |o| o.1, &mut tests);
            let others = self.partners(home, &cell).filter(|v| tellers.iter().all(|o| o.2 != *v));
            out.objections.add(others, &cell, home, against);
        }
        cost.swept_inside(tests);
    }
}

/// What was told of one cell, in a list that is in the order of the cells. The machine compares it with all that was
/// told, in one step, and that is what is charged; a processor searches.
fn of_cell<'a, T, C: Ord>(told: &'a [T], cell: &C, cell_of: impl Fn(&T) -> C, looked: &mut Sweep) -> &'a [T] {
    looked.visit_lanes(told.len());
    let first = told.partition_point(|t| cell_of(t) < *cell);
    let count = told[first..].iter().take_while(|t| cell_of(t) == *cell).count();
    &told[first..first + count]
}
