//! The start and the end of an MPI program.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::collective::CommunicatorCollectives;
use mpi::topology::{Communicator, SimpleCommunicator};

use crate::MpiWire;
use crate::idle::Idle;

/// The exit code if MPI cannot be used. It is the code of a transport that failed.
pub const UNUSABLE: u8 = 6;

/// The exit code after a panic.
pub const PANICKED: u8 = 101;

/// The time that a failed process waits for the others.
const GRACE: Duration = Duration::from_secs(5);

/// Starts MPI, does the work, and returns its exit code after all processes have done theirs.
///
/// A process whose work panics ends all processes. A process whose work fails waits for the others for five seconds,
/// because they may have failed with the same error. Then it ends all processes that still run.
pub fn run(work: impl FnOnce(&mut MpiWire) -> ExitCode) -> ExitCode {
    let Some((universe, level)) = mpi::initialize_with_threading(Threading::Funneled) else {
        eprintln!("septet-mpi: MPI has been initialized already");
        return ExitCode::from(UNUSABLE);
    };
    let world = universe.world();
    if level < Threading::Funneled {
        if world.rank() == 0 {
            eprintln!(
                "septet-mpi: the MPI library offers the thread level {level:?}, and septet needs Funneled"
            );
        }
        return ExitCode::from(UNUSABLE);
    }
    let mut wire = MpiWire::new(&world);
    let Ok(code) = catch_unwind(AssertUnwindSafe(|| work(&mut wire))) else {
        world.abort(i32::from(PANICKED));
    };
    leave(&world, code);
    // Communicators end before MPI does.
    drop(wire);
    drop(universe);
    code
}

/// Waits until all processes have done their work. Ends all processes if this one failed and others are missing.
fn leave(world: &SimpleCommunicator, code: ExitCode) {
    let (start, mut idle) = (Instant::now(), Idle::begin());
    let mut end = world.immediate_barrier();
    while let Err(open) = end.test() {
        if code != ExitCode::SUCCESS && start.elapsed() > GRACE {
            world.abort(i32::from(number(code)));
        }
        end = open;
        idle.rest();
    }
}

/// The number of an exit code.
fn number(code: ExitCode) -> u8 {
    (0..=u8::MAX).find(|&number| ExitCode::from(number) == code).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes_have_numbers() {
        assert_eq!([0, 1, 6, 255].map(|code| number(ExitCode::from(code))), [0, 1, 6, 255]);
    }
}
