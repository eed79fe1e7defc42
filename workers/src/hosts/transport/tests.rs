use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec2;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use super::*;
use crate::config::{Fault, Stop, WorkerConfig};
use crate::hosts::host::Unwatched;
use crate::input::{Rows, Source};
use crate::partition::leader::Plan;

const KINDS: [TransportKind; 3] = [
    TransportKind::Channel { threads: 1 },
    TransportKind::Channel { threads: 3 },
    TransportKind::Sim { delivery_seed: 1 },
];

/// Points of a spiral, in blocks.
struct Spiral;

impl Source<DVec2> for Spiral {
    fn block(&self, block: u32, blocks: u32) -> Rows<DVec2> {
        let points: Vec<DVec2> = (0..300).map(point).collect();
        Rows::of_whole(0, &points, &[], block, blocks)
    }
}

fn point(i: u64) -> DVec2 {
    DVec2::from_angle(2.4 * i as f64) * (i as f64).sqrt()
}

/// Runs a machine of three workers to its end, or to the error that its caller receives. Returns the number of stars.
fn outcome(kind: TransportKind, fault: Option<Fault>, stop: Stop) -> Result<u64, TransportError> {
    let config = WorkerConfig { workers: 3, fault, stop, ..WorkerConfig::plain() };
    let config = Arc::new(config);
    let mut machine = machine::<DVec2>(kind);
    let job = Job { config, source: &Spiral, plan: &Plan::new() };
    let shares = machine.run(&job, &mut Unwatched).map_err(|error| match error {
        MachineError::Transport(error) => error,
        MachineError::Start(error) => panic!("{error}"),
    })?;
    let ranks: Vec<_> = shares.iter().map(|share| share.rank).collect();
    assert_eq!(ranks, [0, 1, 2, 3]);
    Ok(shares[0].certified.totals.merged.stars)
}

/// A rank that fails or panics, the coordinator too, ends the machine with the same error on every transport.
#[test]
fn failures_and_panics_reach_the_caller() {
    for kind in KINDS {
        assert_eq!(outcome(kind, None, Stop::default()), Ok(300), "{kind:?}");
        for rank in [0, 2] {
            for phase in [Phase::Partition, Phase::Hulls, Phase::Collect, Phase::Done] {
                for fault in [Fault::DieAt { rank, phase }, Fault::PanicAt { rank, phase }] {
                    let verb = if matches!(fault, Fault::DieAt { .. }) { "ended" } else { "panicked" };
                    let reason = format!("it {verb} at the beginning of phase {}", phase.name());
                    let expected = Err(TransportError::WorkerFailed { rank, reason });
                    assert_eq!(outcome(kind, Some(fault), Stop::default()), expected, "{kind:?}, {fault}");
                }
            }
        }
    }
}

#[test]
fn interrupts_reach_the_caller() {
    for kind in KINDS {
        let stop = Stop::new(Some(Arc::new(AtomicBool::new(true))), None);
        assert_eq!(outcome(kind, None, stop), Err(TransportError::Stopped), "{kind:?}");
    }
}
