//! `septet triangulate` and `septet simulate` by several processes. Each process reads a block of the rows and writes its
//! part of the outputs.
//!
//! All processes run the same command. They agree on every error before they continue, so that all end with the same exit
//! code. Only the first one prints.

#[cfg(unix)]
mod launch;
#[cfg(unix)]
mod loss;

#[cfg(unix)]
use std::io::ErrorKind;
#[cfg(unix)]
use std::sync::Arc;

use septet_core::Spec;
use septet_core::spec::{Transport, Workers, cores};
use septet_protocol::wire::Wire;

#[cfg(unix)]
use crate::errors::caught;
use crate::errors::{Code, Failure};
use crate::progress::Talk;
use crate::run::{Goal, Team, run};

/// Runs a goal on a process of a team. By default, there is one worker for each process.
fn of_team(
    goal: Goal<'_>,
    (requested, threads): (&Spec, usize),
    mut team: Team<'_>,
    talk: &Talk,
) -> Result<(), Failure> {
    team.check_same()?;
    team.processes.set_part_bytes(goal.args().hidden.part_bytes.unwrap_or_default());
    run(goal, (requested.clone(), Some(threads)), &mut team, talk)
}

/// Returns the failure for a command that several processes cannot run.
pub fn not_on_processes() -> Failure {
    let message = "this program runs `triangulate` and `simulate` only, because the other commands need all points in \
                   one process";
    Failure::new(Code::Usage, message).help("run the command with `septet`")
}

/// Runs a goal on a process that a wire connects with others.
///
/// # Errors
/// Fails with the first failure of any process.
pub fn on_wire(goal: Goal<'_>, wire: &mut dyn Wire, name: &'static str, talk: &Talk) -> Result<(), Failure> {
    let requested = goal.requested()?;
    if requested.machine.transport != Transport::Channel {
        let message =
            "--transport and --processes do not work with this program, which several processes run";
        return Err(Failure::new(Code::Usage, message).help("omit them"));
    }
    of_team(goal, (&requested, 1), Team::new(wire, name), talk)
}

/// Returns `true` if another process started this one to run a command with it.
pub fn is_started(goal: Goal<'_>) -> bool {
    #[cfg(unix)]
    let is_started = matches!(launch::Place::of_environment(), Ok(Some(_)));
    #[cfg(not(unix))]
    let is_started = false;
    is_started
        && goal.requested().is_ok_and(|spec| matches!(spec.machine.transport, Transport::Processes { .. }))
}

/// Runs a goal with `--transport processes`. The first process starts the others.
///
/// # Errors
/// Fails if a process does not start, or with the first failure of any process.
#[cfg(unix)]
pub fn local(goal: Goal<'_>, requested: &Spec, talk: &Talk) -> Result<(), Failure> {
    let cores = cores();
    let threads = |processes: u32| (cores / processes as usize).max(1);
    let loss = Arc::<loss::Loss>::default();
    let on_end = &loss.hook(&talk.cancel);
    if let Some(place) = launch::Place::of_environment().map_err(misplaced)? {
        let (process, processes) = (place.process(), place.processes());
        let mut wire = place.connect(on_end).map_err(|error| not_started(&error).of_process(process))?;
        let run = || of_team(goal, (requested, threads(processes)), Team::new(&mut wire, "processes"), talk);
        return loss.ended(caught(run));
    }
    let machine = &requested.machine;
    let processes = machine.transport.processes().unwrap_or(match machine.workers {
        Workers::Count(workers) => workers.clamp(1, cores as u32),
        Workers::Auto | Workers::Leaves => cores as u32,
    });
    let mut started = launch::Started::start(processes).map_err(|error| not_started(&error))?;
    let mut wire = started.connect(&|| talk.is_cancelled(), on_end).map_err(|error| not_started(&error))?;
    let run = || of_team(goal, (requested, threads(processes)), Team::new(&mut wire, "processes"), talk);
    let result = loss.ended(caught(run));
    // The first connection that breaks may belong to a process that ended because of another one.
    let is_lost = result.as_ref().is_err_and(|failure| failure.code == Code::Machine);
    if !is_lost {
        return result;
    }
    started.hurry();
    match started.killed() {
        Some(killed) => Err(Failure::new(Code::Machine, killed).help("see whether memory ran out")),
        None => result,
    }
}

/// Refuses `--transport processes` on a system without Unix sockets.
///
/// # Errors
/// Fails always.
#[cfg(not(unix))]
pub fn local(_: Goal<'_>, _: &Spec, _: &Talk) -> Result<(), Failure> {
    let message = "--transport processes needs Unix sockets, which this system does not have";
    Err(Failure::new(Code::Usage, message).help("use --transport channel"))
}

/// Returns the failure for a process whose environment states a place in a run that does not exist.
#[cfg(unix)]
fn misplaced(reason: String) -> Failure {
    let help = format!("unset {}: only the program sets it, for the processes that it starts", launch::PLACE);
    Failure::new(Code::Usage, reason).help(help)
}

#[cfg(unix)]
fn not_started(error: &std::io::Error) -> Failure {
    match error.kind() {
        ErrorKind::Interrupted => Failure::interrupted(),
        ErrorKind::InvalidData => misplaced(error.to_string()),
        _ => Failure::new(Code::Machine, format!("the processes of the run do not start: {error}"))
            .help("reduce --processes, raise the limit of open files, or use --transport channel"),
    }
}
