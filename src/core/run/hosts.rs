//! The place of the ranks of a run: all in this process, or some of them.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::transport::{HostState, Placement, ProcessTransport, TransportError};
use septet_workers::config::WorkerConfig;
use septet_workers::transport::process::OneProcess;
use septet_workers::transport::{Machine, TransportKind, machine};

use crate::coordinator::{Coordinator, Plan, Returned};
use crate::error::{Error, incomplete};
use crate::input::Held;
use crate::spec::{Control, Spec, SpecError, Task};

/// A function that returns a machine for these parameters, for [`crate::run_on`].
///
/// With [`crate::spec::Workers::Leaves`] it is called twice: the first machine grows the tree to count the leaves.
pub type Start<'a, P> = dyn FnMut(&Arc<WorkerConfig>) -> Box<dyn Machine<P>> + 'a;

/// The largest number of points that `triangulate` handles on the thread of its caller unless the caller sets the number of
/// threads. It takes less time for them than threads take to start and to wait for each other in every round.
const FEW: usize = 4096;

/// Returns a function that returns machines with the transport of the specification, for this number of points.
pub(crate) fn started<P: Point>(
    (spec, task): (&Spec, Task),
    points: usize,
) -> impl FnMut(&Arc<WorkerConfig>) -> Box<dyn Machine<P>> + use<P> {
    let is_small = task == Task::Triangulate && points <= FEW && spec.machine.threads.is_none();
    let kind = match spec.machine.transport_kind() {
        TransportKind::Channel { .. } if is_small => TransportKind::Channel { threads: 1 },
        kind => kind,
    };
    move |_| machine::<P>(kind)
}

/// The place of the ranks.
pub(crate) enum Hosts<'a, P> {
    /// All ranks are in this process, on the machines that a function starts.
    Own(&'a mut Start<'a, P>),
    /// Several processes share the ranks.
    Team {
        /// The transport between the processes.
        transport: &'a mut dyn ProcessTransport<P>,
        /// The process of each worker.
        placement: Placement,
    },
}

/// The machine to start, and how its caller observes it.
pub(crate) struct Order<'a> {
    /// The parameters of the ranks.
    pub(crate) machine: &'a WorkerConfig,
    /// The plan of the placement.
    pub(crate) plan: &'a Plan,
    /// Progress and cancellation.
    pub(crate) control: &'a Control,
    /// Number of threads of one of several processes.
    pub(crate) threads: usize,
}

/// What the ranks of this process return.
pub(crate) struct Left<P> {
    /// The shares of the ranks, in their order, with measured times.
    pub(crate) returned: Returned<P>,
    /// The process of each worker.
    pub(crate) placement: Placement,
    /// Whether several processes may share the ranks.
    pub(crate) is_team: bool,
}

impl<P: Point> Hosts<'_, P> {
    /// Returns `true` if several processes may share the ranks.
    pub(crate) fn is_team(&self) -> bool {
        matches!(self, Hosts::Team { .. })
    }

    /// Returns the number of workers that the place decides.
    pub(crate) fn workers(&self) -> Option<u32> {
        match self {
            Hosts::Own(_) => None,
            Hosts::Team { placement, .. } => Some(placement.workers()),
        }
    }

    /// Runs the ranks of this process until the machine stops.
    pub(crate) fn run(&mut self, order: &Order<'_>, input: Held<'_, P>) -> Result<Left<P>, Error> {
        let config = Arc::new(order.machine.clone());
        let workers = config.workers;
        let coordinator = Coordinator::new(order.control, config.clone());
        let (returned, placement, expected) = match self {
            Hosts::Own(start) => {
                let mut machine = start(&config);
                let returned = coordinator.shares(machine.as_mut(), input, order.plan)?;
                let placement = Placement::new(workers, 1).ok_or(SpecError::NoWorkers)?;
                (returned, placement, config.ranks())
            }
            Hosts::Team { transport, placement } => {
                let (placement, process) = (*placement, transport.process());
                let mut machine =
                    OneProcess { transport: &mut **transport, placement, threads: order.threads };
                let returned = coordinator.shares(&mut machine, input, order.plan)?;
                let own = placement.workers_of(process).len() as u32;
                (returned, placement, own + u32::from(process == 0))
            }
        };
        check_ranks(&returned, expected, placement)?;
        Ok(Left { returned, placement, is_team: self.is_team() })
    }

    /// Ends the run on all processes, because this process cannot start. Returns the error of the run. An error of the
    /// specification keeps its type, because all processes have it.
    pub(crate) fn end(&mut self, error: Error) -> Error {
        let Hosts::Team { transport, .. } = self else { return error };
        end_all(*transport, error)
    }
}

/// Ends a run on all processes, as [`Hosts::end`] does.
pub(crate) fn end_all<P: Point>(transport: &mut dyn ProcessTransport<P>, error: Error) -> Error {
    let process = transport.process();
    let reason = format!("process {process} does not start: {error}");
    let failed = match error {
        Error::Memory { forecast: used, limit, .. } => TransportError::Memory { used, limit },
        _ => TransportError::WorkerFailed { rank: process + 1, reason },
    };
    let ended = transport.exchange(Vec::new(), HostState::Failed(failed.clone()));
    match (error, ended) {
        (error @ Error::Spec(_), _) => error,
        (_, Err(first)) => first.into(),
        (_, Ok(_)) => failed.into(),
    }
}

/// Checks that a machine returned the shares of all its ranks.
fn check_ranks<P>(returned: &Returned<P>, expected: u32, placement: Placement) -> Result<(), Error> {
    let (arrived, first) = (returned.shares.len(), returned.shares.first().map(|share| share.rank));
    if arrived != expected as usize {
        return Err(incomplete(format!("the machine returned the shares of {arrived} of {expected} ranks")));
    }
    if placement.processes() == 1 && first != Some(COORDINATOR) {
        return Err(incomplete("the share of the coordinator is missing".to_string()));
    }
    Ok(())
}
