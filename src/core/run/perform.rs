//! The run of one machine, from its settings to the outcome.

use std::time::Instant;

use septet_geometry::point::Point;

use crate::error::Error;
use crate::input::Held;
use crate::result::outcome::Outcome;
use crate::run::finish::finish;
use crate::run::hosts::{Hosts, Order};
use crate::run::settings::Settings;

/// Starts a machine with these settings, and finishes its run, which began at `start`.
pub(super) fn perform<P: Point>(
    settings: &Settings<'_>,
    input: Held<'_, P>,
    hosts: &mut Hosts<'_, P>,
    start: Instant,
) -> Result<Outcome, Error> {
    let Settings { spec, machine, plan, .. } = settings;
    let threads = spec.machine.threads.unwrap_or(1);
    let order = Order { machine, plan, control: &spec.control, threads };
    finish(settings, hosts.run(&order, input)?, start)
}
