//! One star, and all that it hears in a step of the exchange.
//!
//! **Statement.** See [`crate::splaying::splay`]. A star looks for each cell among its own once, however many stars proposed
//! it or object to it. It takes the vertices of the cells that it lacks, and the points against the cells that it holds,
//! and grows from its link (`hull::change`). Then it says what it gained, and what it lost and why. It refuses a cell that
//! it still lacks, and says why: a point of its link is in the sphere of the cell.
//!
//! **Work and depth.** Let a star with `l` facets hear of `m` cells, get `q` points and change by `c` facets. It sorts the
//! cells, sweeps over the link for each cell and point, and over its points for each cell that it refuses or lost. For
//! each of those, and of the cells that it gained, it sweeps over what it heard. That is O((m + q) l + m log m + c m)
//! work and O(m + q + c) depth.

#[cfg(test)]
mod tests;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::{Extended, StarBuilder, Witnesses};
use septet_geometry::point::Point;

use crate::splaying::pending::{Announced, Objection, Proposal, StarNews};
use crate::stars::links::{Sought, difference, link_points};
use crate::stars::owned::{Change, Chart};
use crate::state::cells::{finite_cell, in_order};

/// What stars make of what they heard, one after the other.
pub(crate) struct Splayed<P: Point> {
    stars: Vec<Star>,
    /// The links of those that changed; what they have that they had not, and had that they have not.
    links: Vec<P::Facet>,
    fresh: Vec<P::Facet>,
    gone: Vec<P::Facet>,
    /// What they say.
    pub(crate) proposals: Vec<Proposal<P>>,
    pub(crate) objections: Announced<P>,
}

/// A star that heard something: where its lists end.
struct Star {
    owned: u32,
    links: usize,
    fresh: usize,
    gone: usize,
    cost: Cost,
}

impl<P: Point> Default for Splayed<P> {
    fn default() -> Self {
        Splayed {
            stars: Vec::new(),
            links: Vec::new(),
            fresh: Vec::new(),
            gone: Vec::new(),
            proposals: Vec::new(),
            objections: Announced::default(),
        }
    }
}

impl<P: Point> Splayed<P> {
    /// Each star, and what its reaction cost.
    pub(crate) fn costs(&self) -> impl Iterator<Item = (u32, Cost)> {
        self.stars.iter().map(|star| (star.owned, star.cost))
    }

    /// Calls `f` with every star that changed: its vertex, and its change.
    pub(crate) fn each_change(&self, mut f: impl FnMut(u32, &Change<'_, P>)) {
        let (mut links, mut fresh, mut gone) = (0, 0, 0);
        for star in &self.stars {
            let change = Change {
                link: &self.links[links..star.links],
                fresh: &self.fresh[fresh..star.fresh],
                gone: &self.gone[gone..star.gone],
            };
            if !(change.fresh.is_empty() && change.gone.is_empty()) {
                f(star.owned, &change);
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
    /// Points that the present star gets, with repeats.
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

impl<P: Point> Chart<'_, P> {
    /// One star takes in its `news`, objections with these `points`, and says what it makes of it.
    pub(crate) fn splay_star(
        &self,
        news: &StarNews<'_, P>,
        points: &[u32],
        tools: &mut Tools<P>,
        out: &mut Splayed<P>,
    ) {
        let mut cost = Cost::ZERO;
        let (links, fresh, gone) = (out.links.len(), out.fresh.len(), out.gone.len());
        let mut refused = self.take_in(news, points, tools, &mut cost);
        if !tools.added.is_empty() {
            if news.gathered.is_empty() {
                self.rebuild_star(news.owned, tools, out, &mut cost);
            } else {
                self.build_whole(news.owned, tools, out, &mut cost);
            }
            if !refused.is_empty() {
                let mut looked = Sweep::default();
                let held = Sought::<P>::of(&out.fresh[fresh..], news.owned);
                refused.retain(|cell| !held.has(cell, &mut looked));
                cost.charge_nested_sweep(looked);
            }
        }
        let changed = out.fresh.len() > fresh || out.gone.len() > gone;
        self.propose_fresh(news, fresh, out, &mut cost);
        if !refused.is_empty() || out.gone.len() > gone {
            let link = if changed { &out.links[links..] } else { self.stars.link(news.owned) };
            let present = link_points::<P>(link, &mut tools.seen, &mut cost);
            self.object(news, &refused, (gone, &present), tools, out, &mut cost);
        }
        let (links, fresh, gone) = (out.links.len(), out.fresh.len(), out.gone.len());
        out.stars.push(Star { owned: news.owned, links, fresh, gone, cost });
    }

    /// Collects the points that a star is to get; returns the cells that it lacks.
    fn take_in(
        &self,
        news: &StarNews<'_, P>,
        points: &[u32],
        tools: &mut Tools<P>,
        cost: &mut Cost,
    ) -> Vec<P::Cell> {
        let owned = news.owned;
        let link = self.stars.link(owned);
        let (sought, mut looked) = (Sought::<P>::of(link, owned), Sweep::default());
        let mut missing: Vec<P::Cell> = news.proposed.iter().map(|p| p.1).collect();
        cost.distinct_nested(&mut missing, Ord::cmp);
        missing.retain(|cell| !sought.has(cell, &mut looked));
        let mut held: Vec<P::Cell> = news.objected.iter().map(|o| o.1).collect();
        cost.distinct_nested(&mut held, Ord::cmp);
        held.retain(|cell| sought.has(cell, &mut looked));
        tools.added.clear();
        let proposed = missing.iter().flat_map(AsRef::as_ref);
        // Every cell tells its run of the sorted objections whether it is held.
        looked.visit_lanes(news.objected.len());
        let heeded = news.objected.iter().filter(|o| held.binary_search(&o.1).is_ok());
        let named = proposed.chain(heeded.flat_map(|o| &points[o.3.clone()])).copied();
        tools.added.extend(named.chain(news.gathered.iter().map(|g| g.1)));
        looked.visit_lanes(tools.added.len());
        cost.charge_nested_sweep(looked);
        missing
    }

    /// A star gets the points collected for it; appends its link, and how it differs, if it does.
    fn rebuild_star(&self, owned: u32, tools: &mut Tools<P>, out: &mut Splayed<P>, cost: &mut Cost) {
        let old = self.stars.link(owned);
        let before = out.links.len();
        match tools.builder.extend(&self.table.positions, owned, old, &tools.added, cost) {
            Extended::Changed => {
                tools.builder.facets(&mut out.links);
                tools.builder.created_facets(&mut out.fresh);
                out.gone.extend(tools.builder.removed_facets().iter().map(|&at| old[at as usize]));
                let mut flags = Sweep::default();
                flags.visit_lanes(out.links.len() - before + old.len());
                cost.charge_nested_sweep(flags);
            }
            Extended::Same => {}
            Extended::Open => self.build_whole(owned, tools, out, cost),
        }
    }

    /// A star from all its points: where it has no link yet, and where a gathering brings what may be missing from a
    /// link that is not one.
    fn build_whole(&self, owned: u32, tools: &mut Tools<P>, out: &mut Splayed<P>, cost: &mut Cost) {
        let old = self.stars.link(owned);
        let mut candidates: Vec<u32> =
            old.iter().flat_map(AsRef::as_ref).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend(&tools.added);
        cost.distinct_indices(&mut candidates, &mut tools.seen);
        if tools.builder.build(&self.table.positions, owned, &candidates, cost) {
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

    /// The vertices whose stars hear what a star gains or loses: the smallest of the cell, or if that is its own, the
    /// others.
    fn partners(&self, owned: u32, cell: &P::Cell) -> impl Iterator<Item = u32> {
        let smallest = self.smallest(cell);
        let asked = move |v: u32| v != owned && (smallest == owned || v == smallest);
        cell.as_ref().iter().copied().filter(move |&v| asked(v))
    }

    /// Proposes what a star gained to those that did not propose it.
    fn propose_fresh(&self, news: &StarNews<'_, P>, fresh: usize, out: &mut Splayed<P>, cost: &mut Cost) {
        let (mut step, mut looked) = (Sweep::default(), Sweep::default());
        let (facets, proposals) = (&out.fresh[fresh..], &mut out.proposals);
        step.each(facets, |facet| {
            let Some(cell) = finite_cell::<P>(news.owned, facet) else { return };
            let cell = in_order::<P>(&cell);
            let tellers = of_cell(news.proposed, &cell, |p| p.1, &mut looked);
            let others = self.partners(news.owned, &cell).filter(|v| tellers.iter().all(|p| p.2 != *v));
            proposals.extend(others.map(|v| (v, cell, news.owned)));
        });
        cost.charge_nested_sweep(looked);
        cost.charge_nested_sweep(step);
    }

    /// Says to those that proposed a cell why the star does not hold it; and to those that did not object why it lost what
    /// it had.
    fn object(
        &self,
        news: &StarNews<'_, P>,
        refused: &[P::Cell],
        (gone, present): (usize, &[u32]),
        tools: &mut Tools<P>,
        out: &mut Splayed<P>,
        cost: &mut Cost,
    ) {
        let (owned, table) = (news.owned, &self.table.positions);
        let (mut tests, against) = (Sweep::default(), &mut tools.against);
        if present.is_empty() {
            return;
        }
        tools.witnesses.load(table, owned, present, &mut tests);
        for cell in refused {
            against.clear();
            tools.witnesses.append_inside(table, cell, against, &mut tests);
            if !against.is_empty() {
                let tellers = of_cell(news.proposed, cell, |p| p.1, &mut tests);
                out.objections.add(tellers.iter().map(|p| p.2), cell, owned, against);
            }
        }
        for facet in &out.gone[gone..] {
            let Some(cell) = finite_cell::<P>(owned, facet) else { continue };
            let cell = in_order::<P>(&cell);
            against.clear();
            tools.witnesses.append_inside(table, &cell, against, &mut tests);
            let tellers: &[Objection<P>] = of_cell(news.objected, &cell, |o| o.1, &mut tests);
            let others = self.partners(owned, &cell).filter(|v| tellers.iter().all(|o| o.2 != *v));
            out.objections.add(others, &cell, owned, against);
        }
        cost.charge_nested_sweep(tests);
    }
}

/// The news of one cell, in a list that is in the order of the cells. The machine compares it with all news in one
/// step, which is the charge; a processor searches.
fn of_cell<'a, T, C: Ord>(news: &'a [T], cell: &C, cell_of: impl Fn(&T) -> C, looked: &mut Sweep) -> &'a [T] {
    looked.visit_lanes(news.len());
    let first = news.partition_point(|t| cell_of(t) < *cell);
    let count = news[first..].iter().take_while(|t| cell_of(t) == *cell).count();
    &news[first..first + count]
}
