//! A machine of one host whose messages a test observes.

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::message::Message;
use septet_protocol::transport::Delivery;
use septet_workers::host::{Host, Job, Watch};
use septet_workers::share::Share;
use septet_workers::transport::{Machine, MachineError};

/// A machine of one host. Before every delivery, it calls the function with the messages of the round, those of ranks
/// to themselves excluded, and with their phase.
pub struct Observed<F>(pub F);

impl<P: Point, F: FnMut(Phase, &[Message<P>])> Machine<P> for Observed<F> {
    fn run(&mut self, job: &Job<'_, P>, _: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError> {
        let mut host = Host::new(COORDINATOR..job.config.ranks(), job, &None);
        let mut inbox = host.begin()?;
        while !host.is_done() {
            self.0(host.phase(), &inbox);
            let active = host.busy() || !inbox.is_empty();
            inbox = host.turn(Delivery { inbox, active })?;
        }
        Ok(host.into_shares())
    }
}
