//! Starts the processes of a run on this computer.
//!
//! The first process starts the others with its own arguments. They find their place in [`PLACE`], and the folder of their
//! sockets in [`FOLDER`]. A process whose connection ends stops, so none outlives the first one for long.

use std::env;
use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::process::{ExitStatusExt, parent_id};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use septet_workers::transport::socket::SocketWire;

/// The environment variable with the place of a process: its number, the number of processes, and the id of the first
/// process.
const PLACE: &str = "SEPTET_PROCESS";

/// The environment variable with the folder of the sockets.
const FOLDER: &str = "SEPTET_PROCESS_FOLDER";

/// The time that the other processes have to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// The time that they have after one was lost, since some of them may wait for it.
const SHORT_PATIENCE: Duration = Duration::from_millis(500);

/// The place of a process that another one started.
pub struct Place {
    process: u32,
    processes: u32,
    /// The process id of the first process.
    first: u32,
    folder: PathBuf,
}

impl Place {
    /// Returns the place of this process, unless a user started it.
    pub fn of_environment() -> Option<Self> {
        let place = env::var(PLACE).ok()?;
        let mut numbers = place.split('/').map(|number| number.parse().ok());
        let mut number = || numbers.next().flatten();
        let (process, processes, first) = (number()?, number()?, number()?);
        let folder = env::var_os(FOLDER)?.into();
        (0 < process && process < processes).then_some(Place { process, processes, first, folder })
    }

    /// Returns the number of this process.
    pub fn process(&self) -> u32 {
        self.process
    }

    /// Returns the number of processes.
    pub fn processes(&self) -> u32 {
        self.processes
    }

    /// Connects this process with the others.
    ///
    /// # Errors
    /// See [`SocketWire::connect`].
    pub fn connect(&self) -> io::Result<SocketWire> {
        let check = &mut || {
            // The parent of a process changes when the parent ends.
            if parent_id() == self.first {
                Ok(())
            } else {
                Err(io::Error::other("the first process has ended"))
            }
        };
        SocketWire::connect(&self.folder, self.process, self.processes, check)
    }
}

/// The processes that this process started. Dropping them waits for their end.
pub struct Started {
    children: Vec<Child>,
    folder: PathBuf,
    patience: Duration,
}

impl Started {
    /// Starts the other processes of a run.
    ///
    /// # Errors
    /// Fails if the folder of the sockets or a process cannot be created.
    pub fn start(processes: u32) -> io::Result<Self> {
        let program = env::current_exe()?;
        let folder = create_folder()?;
        let mut started = Started { children: Vec::new(), folder, patience: PATIENCE };
        for process in 1..processes {
            let place = format!("{process}/{processes}/{}", std::process::id());
            let mut command = Command::new(&program);
            command.args(env::args_os().skip(1)).env(PLACE, place).env(FOLDER, &started.folder);
            command.stdin(Stdio::null()).stdout(Stdio::null());
            started.children.push(command.spawn()?);
        }
        Ok(started)
    }

    /// Connects this process, which is the first one, with the others.
    ///
    /// # Errors
    /// See [`SocketWire::connect`].
    pub fn connect(&mut self) -> io::Result<SocketWire> {
        let Started { children, folder, .. } = self;
        let processes = children.len() as u32 + 1;
        let check = &mut || {
            for (process, child) in (1..).zip(&mut *children) {
                if let Some(status) = child.try_wait()? {
                    return Err(io::Error::other(format!("process {process} ended: {status}")));
                }
            }
            Ok(())
        };
        // The others would wait for the one that is missing.
        SocketWire::connect(folder, 0, processes, check).inspect_err(|_| self.kill())
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

impl Drop for Started {
    fn drop(&mut self) {
        let end = Instant::now() + self.patience;
        for child in &mut self.children {
            while matches!(child.try_wait(), Ok(None)) && Instant::now() < end {
                thread::sleep(Duration::from_millis(1));
            }
            let _ = child.kill();
            let _ = child.wait();
        }
        // `drop` cannot report a failure.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Creates a folder that only its user can open.
fn create_folder() -> io::Result<PathBuf> {
    let base = env::temp_dir();
    let mut number = 0;
    loop {
        let folder = base.join(format!("septet-{}-{number}", std::process::id()));
        match DirBuilder::new().mode(0o700).create(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && number < 1000 => number += 1,
            Err(error) => return Err(error),
        }
    }
}
