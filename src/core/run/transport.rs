//! The transport of a run.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::transport::Transport;
use septet_workers::config::WorkerConfig;
use septet_workers::transport::launch;

use crate::config::Config;

/// A function that starts the workers of a machine, for [`crate::run_on`].
///
/// With [`crate::config::Workers::Leaves`] it is called twice: the first machine grows the tree to count the leaves.
pub type Start<'a, P> = dyn FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> + 'a;

/// Returns a function that starts workers on the transport of the configuration.
pub(crate) fn started<P: Point>(
    config: &Config,
) -> impl FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> {
    let kind = config.machine.transport_kind();
    move |machine| launch::<P>(kind, machine)
}
