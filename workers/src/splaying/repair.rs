//! Stars that disagree exchange what they miss (star splaying).
//!
//! **Statement** (Shewchuk 2005; the end of it in ARCHITECTURE.md). If a cell `t` of `star(v)` is missing from
//! `star(a)`, `v` proposes it: `a` takes `t`'s vertices, and holds `t` then, or answers with those points of its link
//! that conflict with `t`. A star that gained a cell proposes it, and of a cell that it lost it tells the points
//! that took its place. Each exchange with any disagreement enlarges some candidate set, so it ends; and if every
//! vertex but the smallest has a smaller candidate, it ends in the triangulation.
//!
//! **Who is told.** Stars agree on a cell iff that of its smallest vertex agrees with each other's
//! ([`crate::stars::check`]), so of what it gains or loses a star tells the smallest vertex, or if that is its own, the others;
//! but none that told it of just that in the same step. Each of the two of such a pair then hears of every
//! change of the other, so when nothing is said any more, all stars agree.
//!
//! **After a gathering** the stars get its points, and what the check told and still holds is proposed all the same.
//!
//! **Departure.** All stars move in lockstep, those of one worker like those of two: what is exchanged in a
//! round does not depend on where a star is at home, so work and depth do not depend on the number of
//! workers. A round of exchange is one round of messages.
//!
//! **Rounds.** None where the paper's hypothesis holds; about `0.6 log2 n` on uniform sets (measured).

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::message::Message;

use crate::config::map_in;
use crate::splaying::exchange::{Proposal, Said, in_order, star_by_star};
use crate::splaying::react::{Reactions, Tools};
use crate::stars::check::Disagreement;
use crate::worker::{Worker, finite_cell};

/// Stars that are looked at one after the other.
const GROUP: usize = 512;

impl<P: Point> Worker<P> {
    pub(crate) fn begin_repair(&mut self) {
        let disagreements = self.finish_check();
        if self.exchange.is_pending() || !disagreements.is_empty() {
            self.write_out();
        }
        let propose = |d: &Disagreement| {
            let facet = self.stars.link(d.home)[(d.facet - self.stars.start(d.home)) as usize];
            finite_cell::<P>(d.home, &facet).map(|cell| (d.other, in_order::<P>(&cell), d.home))
        };
        let proposals = disagreements.iter().filter_map(propose).collect();
        self.react_all(proposals);
    }

    fn cap(&self) -> u32 {
        let default = 6 * (64 - self.population.max(2).leading_zeros());
        self.config.exchange_cap.unwrap_or(default)
    }

    /// Every step is a round of exchange.
    pub(crate) fn on_repair(&mut self, inbox: &mut Vec<Message<P>>) {
        if !inbox.is_empty() {
            self.write_out();
        }
        self.take_said(inbox);
        self.react_all(Vec::new());
    }

    /// All stars that were told something take it in, then say what has changed; and what the check found, where a star
    /// still holds it.
    fn react_all(&mut self, mut found: Vec<Proposal<P>>) {
        if found.is_empty() && !self.exchange.is_pending() {
            return;
        }
        let mut proposed = std::mem::take(&mut self.exchange.proposed);
        let mut objected = std::mem::take(&mut self.exchange.objected);
        let mut gathered = std::mem::take(&mut self.exchange.gathered);
        self.extend_hashes();
        proposed.sort_unstable();
        gathered.sort_unstable();
        let (objected, points) = objected.sorted();
        let stars = star_by_star::<P>(&proposed, objected, &gathered);
        let groups: Vec<_> = stars.chunks(GROUP).collect();
        let reactions = map_in(&self.pool, &groups, |group| {
            let mut tools = Tools::new(self.table.positions.len());
            let mut out = Reactions::default();
            group.iter().for_each(|told| self.react(told, points, &mut tools, &mut out));
            out
        });
        self.charge_stars(reactions.iter().flat_map(Reactions::costs));
        let (mut proposals, mut objections) = (Vec::new(), Said::default());
        for group in reactions {
            self.replace_stars(&group);
            proposals.extend(group.proposals);
            objections.append(group.objections);
        }
        if !groups.is_empty() {
            self.retain_held(&mut found);
        }
        proposals.extend(found);
        // All ranks step together, so the number of the round is the same on each.
        let round = self.step + 1;
        if (proposals.is_empty() && objections.is_empty()) || round > self.cap() {
            return;
        }
        self.exchange.rounds = round;
        self.send_proposals(proposals);
        self.send_objections(&objections);
    }

    /// Leaves those proposals whose cells their stars hold still: each looks at every facet of its link.
    fn retain_held(&mut self, found: &mut Vec<Proposal<P>>) {
        let mut costs = Vec::new();
        found.retain(|(_, cell, from)| {
            let (mut looks, mut cost) = (Sweep::default(), Cost::ZERO);
            looks.visit_lanes(self.stars.link(*from).len());
            cost.swept_inside(looks);
            costs.push((*from, cost));
            self.position_in(*from, cell).is_some()
        });
        self.charge_stars(costs.into_iter());
    }

    /// Puts changed stars in the place of the old ones.
    fn replace_stars(&mut self, group: &Reactions<P>) {
        group.each_change(|home, link, fresh, gone| {
            self.recount_star(home, gone, fresh);
            self.stars.replace(home, link);
            self.exchange.repaired.insert(home);
        });
    }
}
