//! The subtree of the partition tree that one worker grows alone.

use septet_geometry::cost::Cost;
use septet_geometry::point::Point;
use septet_geometry::separator::{CurveCube, DrawKey};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::LedgerPart;

use crate::config::WorkerConfig;
use crate::machine::profile::Site;
use crate::partition::leader::{
    Accepted, Draw, DrawOf, MAX_ATTEMPTS, acceptable, draw_from, enter_facts, is_leaf, refused,
};
use crate::partition::sides::sides_of;
use crate::state::tree::Split;

/// A node of a subtree that is listed in preorder.
pub(crate) enum Sketch<P> {
    Leaf,
    Inner(Box<Split<P>>),
}

/// A subtree, with its charges and facts.
pub(crate) struct Grown<P> {
    pub(crate) leaves: Vec<(NodeId, Vec<u32>)>,
    pub(crate) tree: Vec<Sketch<P>>,
    pub(crate) charges: Vec<(NodeId, Cost, u64)>,
    pub(crate) facts: LedgerPart,
}

impl<P> Default for Grown<P> {
    fn default() -> Self {
        Grown { leaves: Vec::new(), tree: Vec::new(), charges: Vec::new(), facts: LedgerPart::default() }
    }
}

impl<P> Grown<P> {
    fn append(&mut self, mut other: Grown<P>) {
        self.leaves.append(&mut other.leaves);
        self.tree.append(&mut other.tree);
        self.charges.append(&mut other.charges);
        self.facts.merge(&other.facts);
    }
}

/// A node whose subtree is not grown yet.
pub(crate) struct Ungrown<P> {
    pub(crate) node: NodeId,
    pub(crate) members: Vec<u32>,
    /// The cube of the curve that the separator of the parent cuts, if it cuts one.
    pub(crate) curve: Option<CurveCube<P>>,
}

/// Splits the nodes that one worker holds.
pub(crate) struct Builder<'a, P> {
    pub(crate) config: &'a WorkerConfig,
    pub(crate) site: Site,
    pub(crate) positions: &'a [P],
}

impl<P: Point> Builder<'_, P> {
    /// Splits a node and its descendants, in parallel if the worker has more than one core.
    pub(crate) fn grow(&self, top: Ungrown<P>, pool: &crate::config::Pool) -> Grown<P> {
        match pool {
            Some(pool) => pool.install(|| self.grow_here(top, true)),
            None => self.grow_here(top, false),
        }
    }

    fn grow_here(&self, ungrown: Ungrown<P>, join: bool) -> Grown<P> {
        let node = ungrown.node;
        let mut grown = Grown::default();
        let population = ungrown.members.len() as u64;
        let split = if is_leaf(self.config, node, population) {
            enter_facts::<P>(grown.facts.facts(node), population, 0, None);
            None
        } else {
            self.split(&ungrown, &mut grown)
        };
        let Some((split, [inside, outside])) = split else {
            grown.tree.push(Sketch::Leaf);
            grown.leaves.push((node, ungrown.members));
            return grown;
        };
        drop(ungrown);
        let curve = split.separator().curve_cube();
        grown.tree.push(Sketch::Inner(Box::new(split)));
        let below = |side, members| self.grow_here(Ungrown { node: node.child(side), members, curve }, join);
        let (interior, exterior) = (|| below(0, inside), || below(1, outside));
        let (a, b) = if join { rayon::join(interior, exterior) } else { (interior(), exterior()) };
        grown.append(a);
        grown.append(b);
        grown
    }

    /// Splits a node by the steps that the members and the leader of a shared node take.
    fn split(
        &self,
        &Ungrown { node, ref members, curve }: &Ungrown<P>,
        grown: &mut Grown<P>,
    ) -> Option<(Split<P>, [Vec<u32>; 2])> {
        let points: Vec<P> = members.iter().map(|&i| self.positions[i as usize]).collect();
        let population = points.len() as u64;
        let _span = self.site.subproblem(Phase::Partition, node, "split", population);
        let mut cost = Cost::of_subproblem(self.config.cost_log.is_recording());
        let mut found = None;
        let mut attempts = 0;
        while found.is_none() && attempts < MAX_ATTEMPTS {
            let key = DrawKey { seed: self.config.seed, node: node.0, attempt: attempts };
            let sampler = self.config.sampler(key, population);
            let mut samples = cost.pack(&points, |&x| sampler.accepts(x));
            let next = DrawOf { node, attempt: attempts, population, curve };
            let Draw { separator, kind } = draw_from(self.config, next, &mut samples, &mut cost);
            let refused = refused(self.config, node, attempts);
            attempts += 1;
            let Some(separator) = separator else { break };
            let counted = sides_of(&separator, &points, &mut cost);
            if !refused && acceptable::<P>(self.config, counted.inside, population - counted.inside) {
                found = Some((separator, kind, counted));
            }
        }
        let facts = grown.facts.facts(node);
        let result = found.map(|(separator, kind, counted)| {
            let accepted = Accepted { inside: counted.inside, kind, separator: &separator };
            enter_facts(facts, population, attempts, Some(&accepted));
            let numbered: Vec<(u32, u8)> = members.iter().copied().zip(counted.of).collect();
            let (a, b) = cost.split(&numbered, |m| m.1 == 0);
            let strip = |v: Vec<(u32, u8)>| v.into_iter().map(|m| m.0).collect();
            (Split::new(separator, counted.boxes), [strip(a), strip(b)])
        });
        if result.is_none() {
            enter_facts::<P>(facts, population, attempts, None);
        }
        grown.charges.push((node, cost, population));
        result
    }
}
