//! Starts the processes of a run on this computer.
//!
//! The first process starts the others with its own arguments. They find their place in [`PLACE`], and their connection to
//! the first process as standard input. This connection carries all others, so that no socket has a name that a program
//! outside the run could connect to. A process whose connection ends stops, so none outlives another one for long (`loss`).

use std::env;
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use septet_workers::transport::socket::{OnEnd, SocketWire};

/// The environment variable with the place of a process: its number and the number of processes.
pub const PLACE: &str = "SEPTET_PROCESS";

/// The time that the other processes have to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// The time that they have after one was lost, since some of them may wait for it.
const SHORT_PATIENCE: Duration = Duration::from_millis(500);

/// The time between two looks at processes that should end.
const PAUSE: Duration = Duration::from_millis(1);

/// The place of a process that another one started.
pub struct Place {
    process: u32,
    processes: u32,
    /// The connection to the first process.
    launch: UnixStream,
}

impl Place {
    /// Returns the place of this process, or `None` if a user started it.
    ///
    /// # Errors
    /// Returns a message if the variable is set, but no process of a run has started this one.
    pub fn of_environment() -> Result<Option<Self>, String> {
        let Some(value) = env::var_os(PLACE) else { return Ok(None) };
        let value = value.to_string_lossy();
        let numbers = value.split_once('/').and_then(|(process, processes)| {
            Some((process.parse::<u32>().ok()?, processes.parse::<u32>().ok()?))
        });
        let Some((process, processes)) = numbers.filter(|&(process, of)| 0 < process && process < of) else {
            return Err(format!("{PLACE} is {value:?}, which is not the place of a process in a run"));
        };
        let no_run = |_| format!("{PLACE} is {value:?}, but this process was not started by a run");
        let launch = inherited().map_err(no_run)?;
        Ok(Some(Place { process, processes, launch }))
    }

    /// Returns the number of this process.
    pub fn process(&self) -> u32 {
        self.process
    }

    /// Returns the number of processes.
    pub fn processes(&self) -> u32 {
        self.processes
    }

    /// Connects this process with the others. Standard input is empty from now on.
    ///
    /// # Errors
    /// See [`SocketWire::started`].
    pub fn connect(self, on_end: &OnEnd) -> io::Result<SocketWire> {
        rustix::stdio::dup2_stdin(File::open("/dev/null")?)?;
        SocketWire::started(self.launch, (self.process, self.processes), on_end)
    }
}

/// Returns standard input, which must be a Unix socket without a name.
fn inherited() -> io::Result<UnixStream> {
    let stream = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let is_nameless = stream.local_addr()?.is_unnamed() && stream.peer_addr()?.is_unnamed();
    if is_nameless { Ok(stream) } else { Err(io::Error::other("the socket has a name")) }
}

/// The processes that this process started. Dropping them waits for their end.
pub struct Started {
    children: Vec<Child>,
    /// The connections to them, until they carry the wire.
    launched: Vec<UnixStream>,
    patience: Duration,
}

impl Started {
    /// Starts the other processes of a run.
    ///
    /// # Errors
    /// Fails if a connection or a process cannot be created.
    pub fn start(processes: u32) -> io::Result<Self> {
        let mut started = Started { children: Vec::new(), launched: Vec::new(), patience: PATIENCE };
        for process in 1..processes {
            // A process that has started would wait for the missing one.
            started.add((process, processes)).inspect_err(|_| started.kill())?;
        }
        Ok(started)
    }

    fn add(&mut self, (process, processes): (u32, u32)) -> io::Result<()> {
        let (own, other) = UnixStream::pair()?;
        let mut command = Command::new(env::current_exe()?);
        command.args(env::args_os().skip(1)).env(PLACE, format!("{process}/{processes}"));
        command.stdin(OwnedFd::from(other)).stdout(Stdio::null());
        self.children.push(command.spawn()?);
        self.launched.push(own);
        Ok(())
    }

    /// Connects this process, which is the first one, with the others. Ends when `is_stopped` returns `true`.
    ///
    /// # Errors
    /// See [`SocketWire::first`].
    pub fn connect(&mut self, is_stopped: &dyn Fn() -> bool, on_end: &OnEnd) -> io::Result<SocketWire> {
        let (children, launched) = (&mut self.children, std::mem::take(&mut self.launched));
        let check = &mut || {
            if is_stopped() { Err(io::ErrorKind::Interrupted.into()) } else { all_run(children) }
        };
        let connected = SocketWire::first(launched, check, on_end);
        connected.map_err(|error| {
            let is_gone = matches!(
                error.kind(),
                io::ErrorKind::UnexpectedEof | io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset
            );
            let error = if is_gone { self.reason_of(error) } else { error };
            // The others would wait for the one that is missing.
            self.kill();
            error
        })
    }

    /// Returns the reason why a connection ended. It ends shortly before its process.
    fn reason_of(&mut self, error: io::Error) -> io::Error {
        let end = Instant::now() + SHORT_PATIENCE;
        while Instant::now() < end {
            if let Err(reason) = all_run(&mut self.children) {
                return reason;
            }
            thread::sleep(PAUSE);
        }
        error
    }

    fn kill(&mut self) {
        for child in &mut self.children {
            let _ = child.kill();
        }
    }

    /// Gives the others less time to end, because a process was lost.
    pub fn hurry(&mut self) {
        self.patience = SHORT_PATIENCE;
    }

    /// Returns a description of the first process that a signal ended.
    pub fn killed(&mut self) -> Option<String> {
        (1..).zip(&mut self.children).find_map(|(process, child): (u32, _)| {
            let status = child.try_wait().ok()??;
            status.signal().map(|_| format!("process {process} ended: {status}"))
        })
    }
}

/// Fails if a process has ended.
fn all_run(children: &mut [Child]) -> io::Result<()> {
    for (process, child) in (1_u32..).zip(children) {
        if let Some(status) = child.try_wait()? {
            return Err(io::Error::other(format!("process {process} ended: {status}")));
        }
    }
    Ok(())
}

impl Drop for Started {
    fn drop(&mut self) {
        self.launched.clear();
        let end = Instant::now() + self.patience;
        for child in &mut self.children {
            while matches!(child.try_wait(), Ok(None)) && Instant::now() < end {
                thread::sleep(PAUSE);
            }
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
