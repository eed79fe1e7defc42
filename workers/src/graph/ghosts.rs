//! Ghosts: every point goes to each leaf that an edge of it can reach.
//!
//! **Statement.** An edge of the density or overlap graph between `j` and a home point of a subproblem
//! with largest radius `R` is no longer than `reach(r_j, R)` ([`Supergraph::reach`]). So `j` goes down to
//! every child whose side of the separator, and whose box, its ball of that radius meets. Then a leaf
//! holds all graph neighbours of its home points, and nothing has to return. For the density graph that is
//! `alpha min(r_j, R)`: the two-sided minimum keeps a singularity's points from going everywhere.
//!
//! **Rounds.** At most one a shared level. **Work and depth.** One vector step over the balls at a node.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::config::{SetRule, map_in};
use crate::stars::check::GROUP;
use crate::state::subdomain::{Leaf, Shared, Split, Tree};
use crate::state::tasks::Reach;
use crate::worker::Worker;

/// One walk of points through what a worker knows of the tree.
struct Walk<'a, P> {
    rule: Supergraph,
    path: &'a [Shared<P>],
    leaves: &'a [Leaf<P>],
    shared: Vec<Sweep>,
    local: Vec<Sweep>,
    reach: Reach,
}

/// A point under way: position, squared radius, and its home leaf while on the way there.
#[derive(Clone, Copy)]
struct Pushed<P> {
    position: P,
    radius2: f64,
    home: Option<NodeId>,
}

/// What a walk counted.
struct Counts {
    shared: Vec<Sweep>,
    local: Vec<Sweep>,
    reach: Reach,
}

impl<P: Point> Walk<'_, P> {
    fn into_counts(self) -> Counts {
        let Walk { shared, local, reach, .. } = self;
        Counts { shared, local, reach }
    }

    fn goes(&self, split: &Split<P>, side: usize, max2: f64, x: &Pushed<P>) -> bool {
        let reach = self.rule.reach(x.radius2, max2);
        split.reaches(x.position, reach * reach * (1.0 + 1e-12), side)
    }

    fn along_path(&mut self, start: usize, x: &Pushed<P>, out: &mut Vec<(usize, usize)>) -> bool {
        for i in start..self.path.len() {
            let shared = &self.path[i];
            self.shared[i].visit();
            let max2 = |side: usize| shared.summaries.as_ref().map_or(f64::INFINITY, |s| s[side].max_radius2);
            let other = 1 - shared.mine;
            if self.goes(&shared.split, other, max2(other), x) {
                out.push((i, other));
            }
            if x.home.is_none() {
                let reached = self.goes(&shared.split, shared.mine, max2(shared.mine), x);
                if reached && !shared.goes_on {
                    out.push((i, shared.mine));
                }
                if !reached || !shared.goes_on {
                    return false;
                }
            }
        }
        true
    }

    fn down(&mut self, tree: &Tree<P>, x: &Pushed<P>, hits: &mut Vec<usize>) {
        match tree {
            Tree::Leaf(at) => {
                if x.home != Some(self.leaves[*at].id) {
                    hits.push(*at);
                }
            }
            Tree::Node(inner) => {
                let home = x.home.map(|leaf| inner.id.side_of(leaf));
                self.local[inner.number].visit();
                for (side, child) in inner.children.iter().enumerate() {
                    let on_way = home == Some(side);
                    if on_way || self.goes(&inner.split, side, inner.max_radius2[side], x) {
                        let home = x.home.filter(|_| on_way);
                        if !on_way {
                            self.reach.visit(inner.id.child(side));
                        }
                        self.down(child, &Pushed { home, ..*x }, hits);
                    }
                }
            }
        }
    }
}

impl<P: Point> Worker<P> {
    fn ghost_walk(&self) -> Walk<'_, P> {
        Walk {
            rule: self.supergraph(),
            path: &self.subdomain.path,
            leaves: &self.subdomain.leaves,
            shared: vec![Sweep::default(); self.subdomain.path.len()],
            local: vec![Sweep::default(); self.subdomain.inner_ids.len()],
            reach: Reach::new(self.recorder.is_some()),
        }
    }

    /// Starts the separator sets by the rule of the run.
    pub(crate) fn begin_sets(&mut self) {
        let fetched = matches!(self.supergraph(), Supergraph::Knn { .. });
        if fetched {
            self.finish_knn();
        }
        let push = self.config.sets == SetRule::Ghost && !fetched;
        self.count_crossings();
        if push {
            self.push_home();
        }
        if self.config.sets != SetRule::Ghost {
            self.begin_set_recursion();
        }
    }

    /// Measures every separator against the home points below it, which follow each other.
    fn count_crossings(&mut self) {
        let (table, rule) = (&self.table, self.supergraph());
        let homes = 0..table.home as usize;
        let radii: Vec<f64> =
            table.radii2[homes.clone()].iter().map(|&r2| rule.separator_radius(r2)).collect();
        let mut splits: Vec<(NodeId, &Split<P>, Range<usize>)> =
            self.subdomain.path.iter().map(|shared| (shared.id, &shared.split, homes.clone())).collect();
        if let Some((_, tree)) = &self.subdomain.tree {
            splits_below(tree, &self.subdomain.leaves, &mut splits);
        }
        let groups: Vec<(NodeId, &Split<P>, Range<usize>)> = splits
            .into_iter()
            .flat_map(|(id, split, homes)| {
                let end = homes.end;
                homes.step_by(GROUP).map(move |start| (id, split, start..end.min(start + GROUP)))
            })
            .collect();
        let counted = map_in(&self.pool, &groups, |(id, split, homes)| {
            let centres = table.positions[homes.clone()].iter().copied();
            let balls = centres.zip(radii[homes.clone()].iter().copied());
            (*id, split.separator.count_crossing(balls))
        });
        for (id, [inside, outside]) in counted {
            let facts = self.ledger.facts(id);
            facts.crossing_inside += inside;
            facts.crossing_outside += outside;
        }
    }

    /// Pushes home points to other leaves.
    fn push_home(&mut self) {
        let mut groups = Vec::new();
        for (at, leaf) in self.subdomain.leaves.iter().enumerate() {
            let homes: Vec<u32> = leaf.home().collect();
            groups.extend(homes.chunks(GROUP).map(|c| (at, c.to_vec())));
        }
        let walked = map_in(&self.pool, &groups, |(at, homes)| {
            let mut walk = self.ghost_walk();
            let mut found = Vec::new();
            walk.reach.start(*at);
            for &home in homes {
                let x = Pushed {
                    position: self.table.positions[home as usize],
                    radius2: self.table.radii2[home as usize],
                    home: Some(self.subdomain.leaves[*at].id),
                };
                let (mut hits, mut ways) = (Vec::new(), Vec::new());
                walk.along_path(0, &x, &mut ways);
                if let Some((_, tree)) = &self.subdomain.tree {
                    walk.down(tree, &x, &mut hits);
                }
                if !hits.is_empty() || !ways.is_empty() {
                    found.push((home, hits, ways));
                }
            }
            (found, walk)
        });
        let mut batches: BTreeMap<(NodeId, Rank), PointBatch<P>> = BTreeMap::new();
        let reduced: Vec<_> = walked.into_iter().map(|(found, walk)| (found, walk.into_counts())).collect();
        for (found, counts) in reduced {
            let Counts { shared, local, reach } = counts;
            self.charge_sets(&shared, &local);
            if let (Some(recorder), Some(reached)) = (&mut self.recorder, reach.reached) {
                recorder.reached(Phase::Sets, reached);
            }
            for (home, hits, ways) in found {
                for at in hits {
                    self.subdomain.leaves[at].ghosts.push(home);
                }
                self.batch_ghost(home, &ways, &mut batches);
            }
        }
        self.send_ghosts(batches);
    }

    fn charge_sets(&mut self, shared: &[Sweep], local: &[Sweep]) {
        let ids: Vec<NodeId> = self.subdomain.path.iter().map(|s| s.id).collect();
        for (ids, sweeps) in [(&ids, shared), (&self.subdomain.inner_ids, local)] {
            for (&id, sweep) in ids.iter().zip(sweeps) {
                if sweep.items() > 0 {
                    self.sets.sweeps.entry(id).or_default().join(sweep);
                }
            }
        }
    }

    fn batch_ghost(
        &self,
        point: u32,
        ways: &[(usize, usize)],
        batches: &mut BTreeMap<(NodeId, Rank), PointBatch<P>>,
    ) {
        for &(i, side) in ways {
            let shared = &self.subdomain.path[i];
            let to = shared.member_below(self.rank, side);
            let batch = batches.entry((shared.id.child(side), to)).or_default();
            self.table.export(point, batch);
        }
    }

    fn send_ghosts(&mut self, batches: BTreeMap<(NodeId, Rank), PointBatch<P>>) {
        for ((node, to), batch) in batches {
            self.out.send(to, node, 0, Body::Ghosts(batch));
        }
    }

    /// Points pushed here by other workers.
    pub(crate) fn on_ghosts(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Ghosts(points) => {
                received.push((m.node, std::mem::take(points)));
                false
            }
            _ => true,
        });
        let mut batches = BTreeMap::new();
        for (node, points) in received {
            if let Some((at, holder)) = self.subdomain.relay
                && at == node
                && holder != self.rank
            {
                self.out.send(holder, node, 0, Body::Ghosts(points));
                continue;
            }
            let numbers = self.table.intern_all(&points);
            let start =
                self.subdomain.path.iter().position(|s| s.id == node).unwrap_or(self.subdomain.path.len());
            let mut walk = self.ghost_walk();
            let mut found = Vec::with_capacity(numbers.len());
            for &number in &numbers {
                let x = Pushed {
                    position: self.table.positions[number as usize],
                    radius2: self.table.radii2[number as usize],
                    home: None,
                };
                let (mut hits, mut ways) = (Vec::new(), Vec::new());
                if walk.along_path(start, &x, &mut ways)
                    && let Some((_, tree)) = &self.subdomain.tree
                {
                    walk.down(tree, &x, &mut hits);
                }
                found.push((hits, ways));
            }
            let (shared, local) = (walk.shared, walk.local);
            self.charge_sets(&shared, &local);
            for (number, (hits, ways)) in numbers.into_iter().zip(found) {
                for at in hits {
                    self.subdomain.leaves[at].ghosts.push(number);
                }
                self.batch_ghost(number, &ways, &mut batches);
            }
        }
        self.send_ghosts(batches);
    }

    /// Charges the descent of the separator sets, once it is over.
    pub(crate) fn finish_sets(&mut self) {
        for (node, sweep) in std::mem::take(&mut self.sets.sweeps) {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            self.ledger.charge(Phase::Sets, node, cost, items);
        }
    }
}

/// The splits of a worker's own piece, in preorder, each with the home points below it. Returns those below the tree.
fn splits_below<'a, P>(
    tree: &'a Tree<P>,
    leaves: &[Leaf<P>],
    splits: &mut Vec<(NodeId, &'a Split<P>, Range<usize>)>,
) -> Range<usize> {
    match tree {
        Tree::Leaf(at) => leaves[*at].start as usize..leaves[*at].end as usize,
        Tree::Node(inner) => {
            let place = splits.len();
            splits.push((inner.id, &inner.split, 0..0));
            let [interior, exterior] = [0, 1].map(|side| splits_below(&inner.children[side], leaves, splits));
            debug_assert_eq!(interior.end, exterior.start, "leaves are numbered in the order of the tree");
            let below = interior.start..exterior.end;
            splits[place].2 = below.clone();
            below
        }
    }
}
