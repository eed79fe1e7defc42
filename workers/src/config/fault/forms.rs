//! The forms of faults, for lists and errors.

/// The form of a fault's text, and the effect of the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultForm {
    /// The text, with its parameters in capital letters.
    pub text: &'static str,
    /// The effect, in one sentence.
    pub effect: &'static str,
}

impl FaultForm {
    /// Returns the name of the fault: the text before its parameters.
    pub fn name(&self) -> &'static str {
        self.text.split(':').next().unwrap_or(self.text)
    }

    /// Returns the form of the fault with this name.
    pub(super) fn of(name: &str) -> Option<&'static FaultForm> {
        FAULTS.iter().find(|form| form.name() == name)
    }
}

const fn form(text: &'static str, effect: &'static str) -> FaultForm {
    FaultForm { text, effect }
}

/// All faults: first those of charges, then those of the machine, then those that end or disturb a run.
pub const FAULTS: [FaultForm; 29] = [
    form(
        "slow:PHASE:LAW[:FACTOR]",
        "Each node of the phase takes FACTOR times LAW additional steps. LAW is log, log2 (the square of log) or root3.",
    ),
    form("work:PHASE:FACTOR", "The work of the phase is multiplied by FACTOR."),
    form("free:PHASE", "The phase costs one step of one processor at each node."),
    form("sequential-leaf", "One processor computes the radii within a leaf, pair by pair."),
    form("free-loop", "The radii within leaves are charged one step per point, not one per pair."),
    form("one-clock", "A worker has one clock for all its subproblems, so they wait for each other."),
    form("flood", "Every point goes to every leaf."),
    form("far-ghosts:FACTOR", "Points go to all leaves within FACTOR times their reach."),
    form("half-ghosts", "About half of the points stay in their own leaves (separator sets `ghost`)."),
    form(
        "half-separators",
        "About half of the points are in no separator set (separator sets `both`, `own` and `smaller`).",
    ),
    form("halve-alpha", "Graphs are built with half the chosen alpha."),
    form("blind-probes", "Cells that ask for a point in their circumsphere get no answer."),
    form("first-ball", "Balls of overlap graphs extend to the first neighbour, whatever k is."),
    form(
        "worst-choice",
        "The choice takes the supergraph that it predicts to be the worst (constants for counting).",
    ),
    form("always-punt", "Every node punts in the correction of neighbour balls `fmt`."),
    form("slow-hub", "Local hulls with many candidates are built by distance."),
    form("old-spheres", "Every set is divided by the separator of the partition (separator sets `own`)."),
    form(
        "small-sphere",
        "Every separator is a sphere that contains a twentieth of the points, and is accepted.",
    ),
    form("random-planes", "Planes with random normals through the median replace great circles."),
    form("median-planes", "Planes across the longest side, at the median, replace great circles."),
    form("no-centrepoint", "Great circles pass through the centre of the lift, not through a centrepoint."),
    form("no-map", "No conformal map corrects the normals of great circles."),
    form("no-scoring", "The first admissible great circle is used, regardless of its score."),
    form("refuse:NODE[-NODE]", "Leaders do not split these shared nodes."),
    form("refuse-draws:EVERY", "About one of EVERY separators is rejected."),
    form("spoil:RANK", "The worker loses a cell of one of its stars before every certificate."),
    form("die:RANK:PHASE", "The worker ends when the phase begins."),
    form("panic:RANK:PHASE", "The worker panics when the phase begins."),
    form(
        "flip:KIND:SEED",
        "One bit of one message of this kind is flipped before it is sent. KIND is survey, keys, alike, candidates, repeated, start, plan, samples, sphere, counts, decision, move, query, answer, summary, children, frame, sample-stars, choice, ghosts, splits, copies, reverse, items, set-counts, set-decision, crossings, lists, fingerprint, fingerprint-list, propose, object, joined, left, merged, outcome, gather, region, facets, across, branch-counts, branch-decision, totals, work-items, work-counts or sites.",
    ),
];
