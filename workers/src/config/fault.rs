//! Faults that tests plant in a machine: what a fault-free run never shows has to be run, too.

use std::fmt;
use std::str::FromStr;

use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::transport::TransportError;
use thiserror::Error;

/// One planted fault. As text: `refuse:2-3`, `spoil:1`, `die:2:hulls`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Leaders leave the shared nodes with these path numbers unsplit: their group's lowest rank holds each
    /// of them as a leaf, and the other ranks of the group pass on what they are sent for it.
    RefuseSplit {
        /// The first node.
        first: NodeId,
        /// The last one.
        last: NodeId,
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
}

/// Why a text names no fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}` is no fault: expected refuse:NODE[-NODE], spoil:RANK or die:RANK:PHASE")]
pub struct FaultTextError(String);

impl Fault {
    /// Is the node to be left unsplit?
    pub(crate) fn refuses(self, node: NodeId) -> bool {
        matches!(self, Fault::RefuseSplit { first, last } if (first..=last).contains(&node))
    }

    /// Ends a worker whose time has come.
    pub(crate) fn strike(self, worker: Rank, now: Phase) -> Result<(), TransportError> {
        match self {
            Fault::DieAt { rank, phase } if rank == worker && phase == now => {
                let reason = format!("it ended at the beginning of phase {}", now.name());
                Err(TransportError::WorkerFailed { rank, reason })
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::RefuseSplit { first, last } => write!(f, "refuse:{}-{}", first.0, last.0),
            Fault::SpoilStar { rank } => write!(f, "spoil:{rank}"),
            Fault::DieAt { rank, phase } => write!(f, "die:{rank}:{}", phase.name()),
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
    let (kind, rest) = text.split_once(':')?;
    match kind {
        "refuse" => {
            let (first, last) = rest.split_once('-').unwrap_or((rest, rest));
            Some(Fault::RefuseSplit { first: NodeId(first.parse().ok()?), last: NodeId(last.parse().ok()?) })
        }
        "spoil" => Some(Fault::SpoilStar { rank: rest.parse().ok()? }),
        "die" => {
            let (rank, name) = rest.split_once(':')?;
            let phase = Phase::ALL.into_iter().find(|p| p.name() == name)?;
            Some(Fault::DieAt { rank: rank.parse().ok()?, phase })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_survive_the_text() {
        for text in ["refuse:2-3", "spoil:1", "die:2:hulls"] {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
        assert_eq!("refuse:5".parse::<Fault>().unwrap().to_string(), "refuse:5-5");
        for text in ["", "refuse", "refuse:x", "spoil:-1", "die:2", "die:2:lunch", "sleep:3"] {
            assert!(text.parse::<Fault>().is_err(), "{text}");
        }
    }
}
