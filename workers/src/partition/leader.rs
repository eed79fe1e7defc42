//! The leader of a shared subproblem: it collects samples and counts, draws separators, and decides on the split.
//!
//! A leader is a member of the group ([`crate::machine::collectives`]). It acts once the values of all its members have
//! arrived through the tree of the group ([`crate::machine::group_tree`]).

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::separator::{
    CurveCube, DrawKey, DrawKind, Drawn, Separator, cut, cut_at_median, cut_curve, draw as draw_separator,
    draw_ablated, draw_bisecting, split_bound,
};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::{Account, NodeFacts, NodeKind};
use septet_protocol::message::{Body, Child, Decision, Route};

use crate::config::{Fault, Partition, WorkerConfig};
use crate::machine::context::Context;
use crate::machine::group_tree::Gathered;
use crate::partition::levelling::routes;
use crate::partition::parts::{Decided, Samples, SideCounts};
use crate::state::subdomain::Group;

/// The largest number of separators drawn for a subproblem. If all of them are rejected, the subproblem is not split.
pub const MAX_ATTEMPTS: u32 = 8;

/// A plan for the placement of nodes on ranks: the number of leaves below each node.
pub type Plan = BTreeMap<NodeId, u32>;

/// Returns the hash of a separator, which is part of the facts of its node.
pub fn separator_hash<P: Point>(separator: &Separator<P>) -> u64 {
    let mut h = 0u64;
    for word in separator.to_array().as_ref() {
        h = (h ^ word.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31);
    }
    h
}

/// The outcome of an attempt to draw a separator.
#[derive(Clone, Copy, Debug)]
pub struct Draw<P> {
    /// The separator, if one was found.
    pub separator: Option<Separator<P>>,
    /// The kind of node that the separator makes; a leaf if there is no separator.
    pub kind: NodeKind,
}

impl<P> From<Drawn<P>> for Draw<P> {
    fn from(drawn: Drawn<P>) -> Self {
        let kind = match drawn.kind {
            DrawKind::Sphere => NodeKind::Sphere,
            DrawKind::Plane { .. } => NodeKind::Plane,
            DrawKind::Curve => NodeKind::Curve,
            DrawKind::None { .. } => NodeKind::Leaf,
        };
        Draw { separator: drawn.separator, kind }
    }
}

/// The subproblem and the attempt for which a separator is drawn.
#[derive(Clone, Copy, Debug)]
pub struct DrawOf<P> {
    /// Node of the subproblem.
    pub node: NodeId,
    /// Number of the attempt, from 0.
    pub attempt: u32,
    /// Number of points of the subproblem.
    pub population: u64,
    /// The cube of the curve that the separator of the parent cuts, if it cuts one.
    pub curve: Option<CurveCube<P>>,
}

/// Draws a separator from samples, which may be in any order. The scans of the draw run over the samples.
pub fn draw_from<P: Point>(
    config: &WorkerConfig,
    DrawOf { node, attempt, population, curve }: DrawOf<P>,
    samples: &mut [P],
    cost: &mut Cost,
) -> Draw<P> {
    let key = DrawKey { seed: config.seed, node: node.0, attempt };
    let mut own = cost.nested();
    if !config.tree.balanced || config.fault.is_some() {
        // Draws and planted separators must not depend on the order of arrival. Bisecting draws sort the samples
        // themselves.
        samples.sort_unstable_by(lex_cmp);
    }
    let (ablation, tries) = (config.fault.and_then(Fault::ablation), config.tree.tries);
    let mut drawn = match (ablation, config.tree.partition, config.tree.balanced) {
        // An ablation removes a part of the draw of spheres. The baselines have none of these parts.
        (Some(ablation), Partition::Sphere, _) => {
            draw_ablated(ablation, key, population, tries, samples, &mut own)
        }
        (None, Partition::Sphere, false) => draw_separator(key, population, tries, samples, &mut own),
        (None, Partition::Sphere, true) => draw_bisecting(key, population, samples, &mut own),
        (_, Partition::Kd, false) => cut(key, samples, &mut own),
        (_, Partition::Kd, true) => cut_at_median(key, population, samples, &mut own),
        (_, Partition::Hilbert, _) => cut_curve(key, curve, samples, &mut own),
    };
    cost.then(own);
    if let Some(planted) = config.fault.and_then(|fault| fault.separator(samples)) {
        drawn = Drawn { separator: Some(planted), kind: DrawKind::Sphere, ..drawn };
    }
    drawn.into()
}

/// Returns `true` if both sides have points and the larger side is within [`split_bound`], or if a planted fault
/// accepts the split.
pub fn acceptable<P: Point>(config: &WorkerConfig, inside: u64, outside: u64) -> bool {
    if config.fault.is_some_and(|fault| fault.accepts(inside, outside)) {
        return true;
    }
    let larger = inside.max(outside) as f64;
    inside > 0 && outside > 0 && larger <= split_bound::<P>() * (inside + outside) as f64
}

/// Returns `true` if a planted fault rejects the separator of this attempt.
pub fn refused(config: &WorkerConfig, node: NodeId, attempt: u32) -> bool {
    config.fault.is_some_and(|fault| fault.refuses_draw(node, attempt))
}

/// Returns `true` if a node of this population is a leaf and is not split further.
pub fn is_leaf(config: &WorkerConfig, node: NodeId, population: u64) -> bool {
    population <= config.tree.leaf || node.level() >= NodeId::DEEPEST
}

/// Draws a separator from the samples of a node's members.
pub(super) fn draw<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    draw: DrawOf<P>,
    Gathered { value: Samples(mut samples), round }: Gathered<Samples<P>>,
) -> Draw<P> {
    let tally = cx.tally(round);
    tally.active += 1;
    tally.separators += 1;
    let mut cost = cx.shared_cost();
    let _span = cx.site().subproblem(Phase::Partition, group.node, "draw", draw.population);
    let drawn = draw_from(cx.config(), draw, &mut samples, &mut cost);
    cx.charge(Account::leader(Phase::Partition, group.node), cost, 0);
    drawn
}

/// Decides on an attempt at a node from the counts of its members: accepts the separator, retries, or leaves the node
/// unsplit.
pub(super) fn decide_split<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    attempt: u32,
    Draw { separator, kind }: Draw<P>,
    Gathered { value: mut counts, round }: Gathered<SideCounts<P>>,
    plan: &Plan,
) -> Decided<P> {
    let node = group.node;
    cx.tally(round).retries += u64::from(attempt > 0);
    let inside: u64 = counts.inside.iter().sum();
    let outside: u64 = counts.outside.iter().sum();
    let good = counts.is_complete()
        && !refused(cx.config(), node, attempt)
        && acceptable::<P>(cx.config(), inside, outside);
    let decision = if cx.config().fault.is_some_and(|fault| fault.refuses(node)) {
        Decision::Leaf
    } else if separator.is_some() && good {
        Decision::Split(place(group, [inside, outside], plan, cx.config()))
    } else if separator.is_some() && attempt + 1 < MAX_ATTEMPTS {
        Decision::Retry
    } else {
        Decision::Leaf
    };
    let facts = cx.facts(node);
    facts.population = group.child.population;
    facts.attempts = u64::from(attempt) + 1;
    let Decision::Split(children) = &decision else {
        let routes = vec![Default::default(); group.members().len()];
        return Decided { decision, boxes: Vec::new(), routes };
    };
    facts.inside = inside;
    facts.kind = kind;
    facts.separator = separator.as_ref().map_or(0, separator_hash);
    let routes = routes_of(group, children, &mut counts);
    Decided { decision, boxes: counts.boxes, routes }
}

/// Returns the routes of each member to both children, in the order of the group's tree, as the counts are.
fn routes_of<P>(group: &Group, children: &[Child; 2], counts: &mut SideCounts<P>) -> Vec<[Route; 2]> {
    group.sort_by_rank(&mut counts.inside);
    group.sort_by_rank(&mut counts.outside);
    let interior = routes(group.members(), &counts.inside, &children[0]);
    let exterior = routes(group.members(), &counts.outside, &children[1]);
    let mut both: Vec<[Route; 2]> = interior.into_iter().zip(exterior).map(|(a, b)| [a, b]).collect();
    group.sort_by_number(&mut both);
    both
}

/// Divides the ranks of a group between the children: in proportion to their planned leaves if there is a plan.
/// Otherwise, a separator that bisects the points halves the ranks, and any other separator divides them in proportion
/// to the points.
fn place(group: &Group, population: [u64; 2], plan: &Plan, config: &WorkerConfig) -> [Child; 2] {
    let ids = [group.node.child(0), group.node.child(1)];
    let planned = |i: usize| plan.get(&ids[i]).map(|&l| u64::from(l));
    let Child { first, ranks, .. } = group.child;
    let interior = match (planned(0), planned(1)) {
        (Some(a), Some(b)) => divide(ranks, [a, b]),
        _ if config.tree.balanced => halve(ranks, population),
        _ => divide(ranks, population),
    };
    let child = |i: usize, first: Rank, ranks: u32| Child {
        population: population[i],
        first,
        ranks,
        leaf: is_leaf(config, ids[i], population[i]),
    };
    [child(0, first, interior), child(1, first + interior, ranks - interior)]
}

/// Sends the plan of each child to the child's leader.
pub(super) fn send_plan<P: Point>(cx: &mut Context<P>, group: &Group, children: &[Child; 2], plan: &Plan) {
    for (side, &child) in children.iter().enumerate() {
        let below = group.below(side, child);
        if below.is_whole() {
            continue;
        }
        let id = below.node;
        let planned = plan.iter().filter(|(n, _)| id.contains(**n) && **n != id);
        let (nodes, leaves): (Vec<u64>, Vec<u32>) = planned.map(|(n, l)| (n.0, *l)).unzip();
        if !nodes.is_empty() {
            let body = Body::Plan { nodes: Bulk(nodes), leaves: Bulk(leaves) };
            cx.contribute(&below, 0, body);
        }
    }
}

/// Takes the plan that the leader of the parent sent.
pub(super) fn take_plan<P: Point>(cx: &mut Context<P>) -> Plan {
    let plans = cx.take(|m| match &mut m.body {
        Body::Plan { nodes, leaves } => Some((std::mem::take(&mut nodes.0), std::mem::take(&mut leaves.0))),
        _ => None,
    });
    plans.into_iter().flat_map(|(nodes, leaves)| nodes.into_iter().map(NodeId).zip(leaves)).collect()
}

/// Returns the number of ranks for the interior child, in proportion to the children's weights. There are at least two
/// `ranks`, and each child gets at least one.
pub fn divide(ranks: u32, weight: [u64; 2]) -> u32 {
    let [a, b] = weight.map(u128::from);
    let total = (a + b).max(1);
    let rounded = (2 * u128::from(ranks) * a + total) / (2 * total);
    (rounded as u32).clamp(1, ranks - 1)
}

/// Returns the number of ranks for the interior child of a separator that bisects the points: half of them, because a
/// group whose number of ranks is a power of two then stays one. If the children's weights are too different, the number
/// is proportional to them.
fn halve(ranks: u32, weight: [u64; 2]) -> u32 {
    let half = if weight[0] < weight[1] { ranks / 2 } else { ranks.div_ceil(2) };
    let proportional = divide(ranks, weight);
    let [a, b] = weight.map(|w| w as f64);
    let load = |interior: u32| (a / f64::from(interior)).max(b / f64::from(ranks - interior));
    if load(half) <= 1.1 * load(proportional) { half } else { proportional }
}

/// Returns the words of the separator that was drawn, for a [`Body::Sphere`]; none if there is no separator.
pub(crate) fn words_of<P: Point>(drawn: &Draw<P>) -> Vec<f64> {
    drawn.separator.map_or(Vec::new(), |s| s.to_array().as_ref().to_vec())
}

/// Returns the separator that a [`Body::Sphere`] contains, if any.
pub fn separator_of<P: Point>(words: &[f64]) -> Option<Separator<P>> {
    Separator::from_array(words)
}

/// A separator that splits a node.
pub(crate) struct Accepted<'a, P> {
    pub(crate) inside: u64,
    pub(crate) kind: NodeKind,
    pub(crate) separator: &'a Separator<P>,
}

/// Records the facts of a node that one rank holds alone, in the form that leaders use for shared nodes.
pub(crate) fn enter_facts<P: Point>(
    facts: &mut NodeFacts,
    population: u64,
    attempts: u32,
    accepted: Option<&Accepted<'_, P>>,
) {
    facts.population = population;
    facts.attempts = u64::from(attempts);
    if let Some(Accepted { inside, kind, separator }) = accepted {
        facts.inside = *inside;
        facts.kind = *kind;
        facts.separator = separator_hash(*separator);
    }
}
