//! The transports of the machine, so that one list of cases runs over all of them.
//!
//! A worker process runs the program of the test itself, with [`RANK`] in its environment. A test program with a `main`
//! of its own calls [`serve`] first. In a program of the test harness, the test [`WORKER_TEST`] calls it.

use std::env;
use std::fs::File;
use std::io::{Write, stdin};
use std::process::Command;

use glam::{DVec2, DVec3};
use septet_core::spec::Transport;
use septet_core::{Error, Run, Spec, run_on, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::transport::TransportError;
use septet_workers::config::WorkerConfig;
use septet_workers::transport::pipe::{Processes, serve_pipe};

/// The environment variable that holds the rank of a worker process.
pub const RANK: &str = "SEPTET_PIPE_RANK";
const CONFIG: &str = "SEPTET_PIPE_CONFIG";
const DIMENSION: &str = "SEPTET_PIPE_DIMENSION";

/// The test that runs a worker in a process of its own.
pub const WORKER_TEST: &str = "transports::a_process_is_a_worker";

/// Returns the command that starts a worker process, without its environment.
pub type ProcessProgram = fn() -> Command;

/// A way to start the machine.
#[derive(Clone, Copy, Debug)]
pub enum TestTransport {
    /// Workers on this number of threads, with messages over channels.
    Channel(usize),
    /// All workers on one thread, with this seed of the order of delivery.
    Sim(u64),
    /// One process per worker, with messages over pipes.
    Processes(ProcessProgram),
}

impl TestTransport {
    /// Returns the configuration for this transport.
    pub fn configure(self, spec: &Spec) -> Spec {
        spec.clone().with(|c| match self {
            TestTransport::Channel(threads) => {
                c.machine.threads = Some(threads);
                c.machine.transport = Transport::Channel;
            }
            TestTransport::Sim(delivery_seed) => c.machine.transport = Transport::Sim { delivery_seed },
            TestTransport::Processes(_) => {}
        })
    }

    /// Runs `simulate` (`counted`) or `triangulate` over this transport.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn run<P: Point>(self, points: &[P], spec: &Spec, counted: bool) -> Result<Run, Error> {
        let spec = self.configure(spec);
        match self {
            TestTransport::Processes(program) => over_processes(points, &spec, counted, program),
            _ if counted => simulate(points, &spec),
            _ => triangulate(points, &spec),
        }
    }
}

/// Calls `check` with each transport: channels with 1, 2 and 4 threads, the simulator with three orders of delivery,
/// and, on Unix, processes that run [`WORKER_TEST`].
pub fn each_transport(check: impl FnMut(TestTransport)) {
    let channels = [1, 2, 4].map(TestTransport::Channel);
    let orders = [0, 1, 77].map(TestTransport::Sim);
    let processes = cfg!(unix).then_some(TestTransport::Processes(harness));
    channels.into_iter().chain(orders).chain(processes).for_each(check);
}

/// The test harness prints to standard output, so a worker under it writes its messages to descriptor 3.
fn harness() -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", "exec \"$0\" \"$@\" 3>&1 >/dev/null"]).arg(env::current_exe().expect("this program"));
    command.args([WORKER_TEST, "--exact", "--test-threads=1"]);
    command
}

/// Returns the pipe to the coordinator of a worker that the test harness runs.
///
/// # Panics
/// If descriptor 3 is not open.
pub fn harness_output() -> File {
    File::options().write(true).open("/dev/fd/3").expect("the pipe to the coordinator")
}

/// Runs on a machine whose workers are processes.
fn over_processes<P: Point>(
    points: &[P],
    spec: &Spec,
    counted: bool,
    program: ProcessProgram,
) -> Result<Run, Error> {
    run_on(points, spec, counted, &mut |_| {
        Box::new(Processes::new(move |machine, rank| {
            let mut command = program();
            command.env(RANK, rank.to_string()).env(CONFIG, machine.to_string());
            command.env(DIMENSION, P::DIM.to_string());
            command
        }))
    })
}

/// Runs the rank that the environment names until the run is over, and sends its messages to `output()`. Returns `None`
/// if the environment names no rank.
///
/// # Panics
/// If the environment names a rank and holds an invalid configuration.
pub fn serve<W: Write + Send>(output: impl FnOnce() -> W) -> Option<Result<(), TransportError>> {
    let rank = env::var(RANK).ok()?.parse().expect("a rank");
    let config: WorkerConfig = env::var(CONFIG).expect("a configuration").parse().expect("a configuration");
    let result = match env::var(DIMENSION).as_deref() {
        Ok("2") => serve_pipe::<DVec2>(stdin(), output(), rank, config),
        Ok("3") => serve_pipe::<DVec3>(stdin(), output(), rank, config),
        other => panic!("dimension {other:?}"),
    };
    // The coordinator ends a run by closing its pipes.
    Some(if matches!(result, Err(TransportError::Stopped)) { Ok(()) } else { result })
}
