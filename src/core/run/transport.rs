//! The transport of a run.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_workers::config::WorkerConfig;
use septet_workers::transport::{Machine, machine};

use crate::spec::Spec;

/// A function that returns a machine for these parameters, for [`crate::run_on`].
///
/// With [`crate::spec::Workers::Leaves`] it is called twice: the first machine grows the tree to count the leaves.
pub type Start<'a, P> = dyn FnMut(&Arc<WorkerConfig>) -> Box<dyn Machine<P>> + 'a;

/// Returns a function that returns machines with the transport of the configuration.
pub(crate) fn started<P: Point>(
    spec: &Spec,
) -> impl FnMut(&Arc<WorkerConfig>) -> Box<dyn Machine<P>> + use<P> {
    let kind = spec.machine.transport_kind();
    move |_| machine::<P>(kind)
}
