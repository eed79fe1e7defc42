//! Stars that disagree exchange what they miss (star splaying).
//!
//! **Statement** (Shewchuk 2005; termination in ARCHITECTURE.md). If a cell `t` of `star(v)` is missing from
//! `star(a)`, `a` receives `t`'s vertices, and answers with the points of its own link that conflict with `t`;
//! both rebuild. A star that changed proposes its new cells, and to the vertices of a cell it dropped it sends
//! the points that took its place. Each exchange with any disagreement enlarges some candidate set, so it
//! ends; and if every vertex but the smallest has a smaller candidate, it ends in the triangulation.
//!
//! **Departure.** All stars move in lockstep, those of one worker like those of two: what is exchanged in a
//! round does not depend on where a star is at home, so work and depth do not depend on the number of
//! workers. A round of exchange is two rounds of messages: proposals, and answers.
//!
//! **Rounds.** None where the paper's hypothesis holds; about `0.4 log2 n` on uniform sets (measured).

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::{StarBuilder, Witnesses};
use septet_geometry::point::Point;
use septet_protocol::message::Message;

use crate::check::Disagreement;
use crate::config::map_in;
use crate::exchange::{GROUP, Proposal, Said, in_order};
use crate::links::{difference, link_points};
use crate::worker::{Worker, finite_cell};

/// Stars that were rebuilt one after the other.
struct Rebuilt<P: Point> {
    stars: Vec<Star>,
    /// The links of those that changed.
    links: Vec<P::Facet>,
    /// What they have that they had not, and had that they have not; of the latter the points against each cell.
    fresh: Vec<P::Facet>,
    gone: Vec<P::Facet>,
    against: Vec<u32>,
    counts: Vec<u32>,
}

/// A star that was rebuilt: where its lists end.
struct Star {
    home: u32,
    links: usize,
    fresh: usize,
    gone: usize,
    cost: Cost,
}

impl<P: Point> Default for Rebuilt<P> {
    fn default() -> Self {
        Rebuilt {
            stars: Vec::new(),
            links: Vec::new(),
            fresh: Vec::new(),
            gone: Vec::new(),
            against: Vec::new(),
            counts: Vec::new(),
        }
    }
}

/// What rebuilding a star needs, in reused storage.
struct Tools<P: Point> {
    builder: StarBuilder<P>,
    witnesses: Witnesses<P>,
    seen: Marks,
}

impl<P: Point> Worker<P> {
    pub(crate) fn begin_repair(&mut self) {
        let disagreements = self.finish_check();
        if self.exchange.is_pending() || !disagreements.is_empty() {
            self.write_out();
        }
        if self.exchange.is_pending() {
            // After a gathering the stars get its points first.
            self.rebuild();
            return;
        }
        let propose = |d: &Disagreement| {
            let facet = self.stars.link(d.home)[(d.facet - self.stars.start(d.home)) as usize];
            finite_cell::<P>(d.home, &facet).map(|cell| (d.other, in_order::<P>(&cell), d.home))
        };
        let proposals: Vec<Proposal<P>> = disagreements.iter().filter_map(propose).collect();
        if !proposals.is_empty() {
            self.exchange.rounds = 1;
        }
        self.send_proposals(proposals);
    }

    fn cap(&self) -> u32 {
        let default = 4 * (64 - self.population.max(2).leading_zeros());
        self.config.exchange_cap.unwrap_or(default)
    }

    /// Odd steps answer proposals, even ones rebuild.
    pub(crate) fn on_repair(&mut self, inbox: &mut Vec<Message<P>>) {
        if !inbox.is_empty() {
            self.write_out();
        }
        self.take_said(inbox);
        if self.step.is_multiple_of(2) {
            self.heed_objections();
            self.rebuild();
        } else {
            self.answer_proposals();
        }
    }

    /// Rebuilds every star that got points; proposes what is new, objects to what is gone.
    fn rebuild(&mut self) {
        let mut pairs = std::mem::take(&mut self.exchange.additions);
        if pairs.is_empty() {
            return;
        }
        // Delivery to the stars; what a star was told twice it drops itself.
        pairs.sort_unstable();
        let additions: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
        self.extend_hashes();
        let groups: Vec<&[&[(u32, u32)]]> = additions.chunks(GROUP).collect();
        let rebuilt = map_in(&self.pool, &groups, |group| {
            let mut tools = Tools {
                builder: StarBuilder::default(),
                witnesses: Witnesses::default(),
                seen: Marks::new(self.table.positions.len()),
            };
            let mut out = Rebuilt::default();
            group.iter().for_each(|added| self.rebuild_star(added, &mut tools, &mut out));
            out
        });
        let (mut proposals, mut objections) = (Vec::new(), Said::default());
        for group in &rebuilt {
            self.take_rebuilt(group, &mut proposals, &mut objections);
        }
        self.charge_stars(rebuilt.iter().flat_map(|group| &group.stars).map(|star| (star.home, star.cost)));
        // All ranks step together, so the number of the round is the same on each.
        let round = self.step / 2 + 1;
        if (proposals.is_empty() && objections.is_empty()) || round > self.cap() {
            return;
        }
        self.exchange.rounds = round;
        self.send_proposals(proposals);
        self.send_objections(&objections);
    }

    /// Puts changed stars in the place of the old ones; adds what is to be said of them.
    fn take_rebuilt(
        &mut self,
        group: &Rebuilt<P>,
        proposals: &mut Vec<Proposal<P>>,
        objections: &mut Said<P>,
    ) {
        let (mut links, mut fresh, mut gone, mut against) = (0, 0, 0, 0);
        for star in &group.stars {
            let home = star.home;
            let (came, went) = (&group.fresh[fresh..star.fresh], &group.gone[gone..star.gone]);
            if !(came.is_empty() && went.is_empty()) {
                self.recount_star(home, went, came);
                self.stars.replace(home, &group.links[links..star.links]);
                self.exchange.repaired.insert(home);
            }
            for cell in came.iter().filter_map(|facet| finite_cell::<P>(home, facet)) {
                let cell = in_order::<P>(&cell);
                let others = cell.as_ref().iter().filter(|&&v| v != home);
                proposals.extend(others.map(|&v| (v, cell, home)));
            }
            for (facet, &count) in went.iter().zip(&group.counts[gone..]) {
                let points = &group.against[against..against + count as usize];
                against += count as usize;
                if let Some(cell) = finite_cell::<P>(home, facet) {
                    let cell = in_order::<P>(&cell);
                    let others = cell.as_ref().iter().copied().filter(|&v| v != home);
                    objections.add(others, &cell, home, points);
                }
            }
            (links, fresh, gone) = (star.links, star.fresh, star.gone);
        }
    }

    /// One star and the points it got.
    fn rebuild_star(&self, added: &[(u32, u32)], tools: &mut Tools<P>, out: &mut Rebuilt<P>) {
        let home = added[0].0;
        let old = self.stars.link(home);
        let numbers: Vec<u32> = added.iter().map(|a| a.1).collect();
        let mut cost = Cost::ZERO;
        let (fresh, gone, before) = (out.fresh.len(), out.gone.len(), out.links.len());
        if tools.builder.extend(&self.table.positions, home, old, &numbers, &mut cost) {
            tools.builder.facets(&mut out.links);
            tools.builder.fresh(&mut out.fresh);
            out.gone.extend(tools.builder.gone().iter().map(|&at| old[at as usize]));
            let mut flags = Sweep::default();
            flags.visit_lanes(out.links.len() - before + old.len());
            cost.swept_inside(flags);
        } else {
            self.build_anew(home, &numbers, tools, out, &mut cost);
        }
        if out.fresh.len() == fresh && out.gone.len() == gone {
            out.links.truncate(before);
        }
        let link = &out.links[before..];
        let lost = &out.gone[gone..];
        let mut points = Vec::new();
        let mut tests = Sweep::default();
        if lost.iter().any(|facet| finite_cell::<P>(home, facet).is_some()) {
            points = link_points::<P>(link, &mut tools.seen, &mut cost);
            tools.witnesses.begin(&self.table.positions, home, &points, &mut tests);
        }
        for facet in lost {
            let known = out.against.len();
            if let Some(cell) = finite_cell::<P>(home, facet)
                && !points.is_empty()
            {
                tools.witnesses.against(&self.table.positions, &cell, &mut out.against, &mut tests);
            }
            out.counts.push((out.against.len() - known) as u32);
        }
        cost.swept_inside(tests);
        let (links, fresh, gone) = (out.links.len(), out.fresh.len(), out.gone.len());
        out.stars.push(Star { home, links, fresh, gone, cost });
    }

    /// A star without a closed link: from all its points.
    fn build_anew(
        &self,
        home: u32,
        added: &[u32],
        tools: &mut Tools<P>,
        out: &mut Rebuilt<P>,
        cost: &mut Cost,
    ) {
        let old = self.stars.link(home);
        let mut candidates: Vec<u32> =
            old.iter().flat_map(AsRef::as_ref).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend(added);
        cost.distinct_numbers(&mut candidates, &mut tools.seen);
        if tools.builder.build(&self.table.positions, home, &candidates, cost) {
            let before = out.links.len();
            tools.builder.facets(&mut out.links);
            let (fresh, gone) = difference::<P>(old, &out.links[before..], cost);
            out.fresh.extend(fresh);
            out.gone.extend(gone);
        }
    }
}
