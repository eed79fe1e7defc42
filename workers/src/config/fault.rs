//! Faults that tests plant in a machine, to run code that fault-free runs do not reach.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::panic_any;
use std::str::FromStr;

use septet_geometry::cost::Cost;
use septet_geometry::point::{Point, dist2};
use septet_geometry::separator::{SEPARATOR_WORDS, Separator};
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::{Account, Charge, LedgerPart, Role};
use septet_protocol::transport::TransportError;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// One planted fault. Its text has one of the forms `refuse:2-3`, `refuse-draws:2`, `spoil:1`, `die:2:hulls`,
/// `panic:2:hulls`, `halve-alpha`, `small-sphere`, `one-clock` and `free-loop`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// Leaders do not split the shared nodes from `first` to `last`. The lowest rank of the group holds such a node
    /// as a leaf, and the other ranks of the group relay the messages about it.
    RefuseSplit {
        /// The first node.
        first: NodeId,
        /// The last node.
        last: NodeId,
    },
    /// A hash of node and attempt rejects about one of `every` separators. Some nodes therefore draw again while
    /// others continue. If `every` is 1, every separator is rejected and no node is split.
    RefuseDraws {
        /// The reciprocal of the share of rejected separators, at least 1.
        every: u32,
    },
    /// A worker loses a cell of one of its stars before every certificate.
    SpoilStar {
        /// The worker.
        rank: Rank,
    },
    /// A worker ends when a phase begins.
    DieAt {
        /// The worker.
        rank: Rank,
        /// The phase.
        phase: Phase,
    },
    /// A worker panics when a phase begins.
    PanicAt {
        /// The worker.
        rank: Rank,
        /// The phase.
        phase: Phase,
    },
    /// Graphs are built with half the chosen alpha.
    HalveAlpha,
    /// Every separator is a sphere around one sample that contains a twentieth of the points. It is always accepted.
    SmallSphere,
    /// A worker has one clock for all its subproblems, so they wait for each other.
    OneClock,
    /// The radii within leaves are charged one step per point, not one per pair.
    FreeLoop,
}

/// A text that is not the name of a fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "unknown fault `{0}`: expected refuse:NODE[-NODE], refuse-draws:EVERY, spoil:RANK, die:RANK:PHASE, \
     panic:RANK:PHASE, halve-alpha, small-sphere, one-clock or free-loop"
)]
pub struct FaultTextError(String);

impl Fault {
    /// Returns `true` if the fault leaves the node unsplit.
    pub(crate) fn refuses(self, node: NodeId) -> bool {
        matches!(self, Fault::RefuseSplit { first, last } if (first..=last).contains(&node))
    }

    /// Returns `true` if the fault rejects the separator of this attempt.
    pub(crate) fn refuses_draw(self, node: NodeId, attempt: u32) -> bool {
        let Fault::RefuseDraws { every } = self else { return false };
        let mixed = (node.0 ^ u64::from(attempt).rotate_left(40)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        (mixed >> 32).is_multiple_of(u64::from(every))
    }

    /// Returns the separator that replaces a drawn one, if this fault replaces separators.
    pub(crate) fn separator<P: Point>(self, samples: &[P]) -> Option<Separator<P>> {
        if self != Fault::SmallSphere {
            return None;
        }
        let centre = *samples.first()?;
        let mut distances: Vec<f64> = samples.iter().map(|&x| dist2(x, centre)).collect();
        distances.sort_unstable_by(f64::total_cmp);
        // The squared radius is midway between those of the last sample inside and of the first sample outside.
        let inside = (distances.len() / 20).max(1);
        let radius = (0.5 * (distances[inside - 1] + distances.get(inside)?)).sqrt();
        let mut words = [0.0; SEPARATOR_WORDS];
        for (i, word) in words.iter_mut().enumerate().take(P::DIM) {
            *word = centre.coord(i);
        }
        (words[3], words[4], words[8]) = (1.0, 0.5 / radius, -0.5 * radius);
        Separator::from_array(&words)
    }

    /// Returns `true` if the fault forces the split to be accepted: [`Fault::SmallSphere`], if no side is empty.
    pub(crate) fn accepts(self, inside: u64, outside: u64) -> bool {
        self == Fault::SmallSphere && inside > 0 && outside > 0
    }

    /// Returns the charge that replaces the true charge of the radii within leaves, if this fault replaces it.
    pub(crate) fn charge_of_radii(self, members: &[u32]) -> Option<Cost> {
        (self == Fault::FreeLoop).then(|| {
            let mut cost = Cost::ZERO;
            cost.map(members, |_| ());
            cost
        })
    }

    /// Changes the charges of a worker's ledger before it is sent.
    pub(crate) fn distort(self, ledger: &mut LedgerPart) {
        if self != Fault::OneClock {
            return;
        }
        let mut clocks: BTreeMap<(Role, Phase), Cost> = BTreeMap::new();
        let of_phases = |(account, _): &(&Account, &mut Charge)| !matches!(account.role, Role::Pass(_));
        for (account, Charge { cost, .. }) in ledger.charges.iter_mut().filter(of_phases) {
            let clock = clocks.entry((account.role, account.phase)).or_default();
            clock.then(*cost);
            // The clock determines when a subproblem ends. The work of the subproblem is unchanged.
            let [_, depth, scans, inner_log] = clock.to_parts();
            *cost = Cost::from_parts([cost.work(), depth, scans, inner_log]);
        }
    }

    /// Makes a worker fail or panic if the fault strikes it in this phase.
    pub(crate) fn strike(self, worker: Rank, now: Phase) -> Result<(), TransportError> {
        match self {
            Fault::DieAt { rank, phase } if rank == worker && phase == now => {
                let reason = format!("it ended at the beginning of phase {}", now.name());
                Err(TransportError::WorkerFailed { rank, reason })
            }
            Fault::PanicAt { rank, phase } if rank == worker && phase == now => {
                panic_any(format!("it panicked at the beginning of phase {}", now.name()))
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::RefuseSplit { first, last } => write!(f, "refuse:{}-{}", first.0, last.0),
            Fault::RefuseDraws { every } => write!(f, "refuse-draws:{every}"),
            Fault::SpoilStar { rank } => write!(f, "spoil:{rank}"),
            Fault::DieAt { rank, phase } => write!(f, "die:{rank}:{}", phase.name()),
            Fault::PanicAt { rank, phase } => write!(f, "panic:{rank}:{}", phase.name()),
            Fault::HalveAlpha => f.write_str("halve-alpha"),
            Fault::SmallSphere => f.write_str("small-sphere"),
            Fault::OneClock => f.write_str("one-clock"),
            Fault::FreeLoop => f.write_str("free-loop"),
        }
    }
}

impl FromStr for Fault {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        parse(text).ok_or_else(|| FaultTextError(text.to_string()))
    }
}

fn parse(text: &str) -> Option<Fault> {
    match text {
        "halve-alpha" => return Some(Fault::HalveAlpha),
        "small-sphere" => return Some(Fault::SmallSphere),
        "one-clock" => return Some(Fault::OneClock),
        "free-loop" => return Some(Fault::FreeLoop),
        _ => {}
    }
    let (kind, rest) = text.split_once(':')?;
    match kind {
        "refuse" => {
            let (first, last) = rest.split_once('-').unwrap_or((rest, rest));
            Some(Fault::RefuseSplit { first: NodeId(first.parse().ok()?), last: NodeId(last.parse().ok()?) })
        }
        "refuse-draws" => {
            let every = rest.parse().ok().filter(|&every| every > 0)?;
            Some(Fault::RefuseDraws { every })
        }
        "spoil" => Some(Fault::SpoilStar { rank: rest.parse().ok()? }),
        "die" | "panic" => {
            let (rank, name) = rest.split_once(':')?;
            let phase = Phase::ALL.into_iter().find(|p| p.name() == name)?;
            let rank = rank.parse().ok()?;
            Some(if kind == "die" { Fault::DieAt { rank, phase } } else { Fault::PanicAt { rank, phase } })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_survive_the_text() {
        let texts = ["refuse:2-3", "refuse-draws:3", "spoil:1", "die:2:hulls", "panic:1:load"];
        for text in texts.into_iter().chain(["halve-alpha", "small-sphere", "one-clock", "free-loop"]) {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
        assert_eq!("refuse:5".parse::<Fault>().unwrap().to_string(), "refuse:5-5");
        for text in
            ["", "refuse", "refuse:x", "refuse-draws:0", "spoil:-1", "die:2", "die:2:lunch", "sleep:3"]
        {
            assert!(text.parse::<Fault>().is_err(), "{text}");
        }
    }

    #[test]
    fn draws_are_refused_by_node_and_attempt() {
        let refused = |every: u32, attempt: u32| {
            (1..=1000).filter(|&n| Fault::RefuseDraws { every }.refuses_draw(NodeId(n), attempt)).count()
        };
        assert_eq!(refused(1, 0), 1000);
        for attempt in 0..8 {
            assert!((400..600).contains(&refused(2, attempt)), "attempt {attempt}");
            assert!((260..400).contains(&refused(3, attempt)), "attempt {attempt}");
        }
        assert!(!Fault::HalveAlpha.refuses_draw(NodeId::ROOT, 0));
    }
}
