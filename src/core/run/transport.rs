//! The transport of a run.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::transport::Transport;
use septet_workers::config::WorkerConfig;
use septet_workers::transport::{TransportKind, launch};

use crate::config::Config;

/// Starts the workers of a machine: what [`crate::run_on`] is given. It may be called twice, for [`crate::config::Workers::Leaves`]
/// grows the tree first to count its leaves.
pub type Start<'a, P> = dyn FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> + 'a;

/// The transport of the configuration.
pub(crate) fn started<P: Point>(
    config: &Config,
) -> impl FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> {
    let kind = match config.transport {
        TransportKind::Channel { .. } => TransportKind::Channel { threads: config.threads },
        TransportKind::Sim { delivery_seed } => TransportKind::Sim { delivery_seed },
    };
    move |machine| launch::<P>(kind, machine)
}
