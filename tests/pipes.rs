//! Workers as processes, one rank each, over pipes: nothing can be shared, and output and ledger are those of
//! the simulator.
//!
//! This program is its own worker: with `SEPTET_PIPE_RANK` set it runs that rank and nothing else.

use std::env;
use std::io::{stdin, stdout};
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};
use septet_core::config::Workers;
use septet_core::generate::Kind;
use septet_core::{Config, Error, Run, run_on, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::transport::{Transport, TransportError};
use septet_workers::config::WorkerConfig;
use septet_workers::transport::pipe::{Pipes, serve_pipe};

use septet_common as common;
use septet_common::sets::{plane, space};
use septet_common::{assert_same_counts, simulated, with_graph};

const RANK: &str = "SEPTET_PIPE_RANK";
const CONFIG: &str = "SEPTET_PIPE_CONFIG";
const DIMENSION: &str = "SEPTET_PIPE_DIMENSION";

fn worker(rank: &str) -> ExitCode {
    let rank = rank.parse().expect("a rank");
    let config: WorkerConfig = env::var(CONFIG).expect("a configuration").parse().expect("a configuration");
    let result = match env::var(DIMENSION).as_deref() {
        Ok("2") => serve_pipe::<DVec2>(stdin(), stdout(), rank, config),
        Ok("3") => serve_pipe::<DVec3>(stdin(), stdout(), rank, config),
        other => panic!("dimension {other:?}"),
    };
    match result {
        Ok(()) | Err(TransportError::Stopped) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

fn over_pipes<P: Point>(points: &[P], config: &Config, counted: bool) -> Result<Run, Error> {
    let program = env::current_exe().expect("this program");
    run_on(points, config, counted, &mut |machine| {
        let pipes = Pipes::launch(machine, &mut |machine, rank| {
            let mut command = Command::new(&program);
            command.env(RANK, rank.to_string()).env(CONFIG, machine.to_string());
            command.env(DIMENSION, P::DIM.to_string());
            command
        })?;
        Ok(Box::new(pipes) as Box<dyn Transport<P>>)
    })
}

fn same_as_simulated<P: Point>(points: &[P], config: &Config) {
    for counted in [false, true] {
        let run = if counted { simulate(points, config) } else { triangulate(points, config) };
        let (expected, found) = (run.unwrap(), over_pipes(points, config, counted).unwrap());
        assert!(expected.cells() == found.cells(), "{config:?}: other cells");
        assert!(expected.graph == found.graph, "{config:?}: another graph");
        assert_eq!(expected.owner(), found.owner());
        assert_eq!(expected.home_leaf(), found.home_leaf());
        assert_same_counts(&expected.ledger, &found.ledger, &format!("{config:?}"));
        assert_eq!(expected.ledger.phases, found.ledger.phases, "{config:?}");
        assert!(expected.ledger.part == found.ledger.part, "{config:?}: other rounds");
    }
}

fn equal_runs() {
    let points = space(Kind::Uniform, 3000, 5);
    for (workers, graph) in [(1, 0), (3, 1), (8, 2), (5, 4), (3, 6)] {
        let config = simulated(Workers::Count(workers), 9, 60);
        let config = with_graph(&config, common::combinations(true)[graph]);
        let config = config.with(|c| {
            c.keep.graph = true;
            c.keep.owner = true;
        });
        same_as_simulated(&points, &config);
    }
    same_as_simulated(&plane(Kind::Clusters, 3000, 5), &simulated(Workers::Count(4), 1, 60));
    same_as_simulated(&plane(Kind::Grid, 900, 5), &simulated(Workers::Leaves, 1, 60));
}

/// A process that ends, or talks nonsense, is an error that names its rank.
fn broken_processes() {
    let points = plane(Kind::Uniform, 200, 5);
    let config = simulated(Workers::Count(2), 9, 60);
    for script in ["exit 3", "printf '\\0\\1\\0\\0\\0\\7\\0\\0\\0'; exit 0"] {
        let result = run_on(&points, &config, true, &mut |machine| {
            let pipes = Pipes::launch(machine, &mut |_, _| {
                let mut command = Command::new("sh");
                command.args(["-c", script]);
                command
            })?;
            Ok(Box::new(pipes) as Box<dyn Transport<DVec2>>)
        });
        match result {
            Err(Error::Machine(TransportError::WorkerFailed { rank: 1, .. })) => {}
            other => panic!("`{script}`: {:?}", other.map(|run| run.cell_count())),
        }
    }
    let missing = run_on(&points, &config, true, &mut |machine| {
        let pipes = Pipes::launch(machine, &mut |_, _| Command::new("/nonexistent/septet"))?;
        Ok(Box::new(pipes) as Box<dyn Transport<DVec2>>)
    });
    assert!(matches!(missing, Err(Error::Start(_))));
}

/// A worker that fails or panics, and an interrupt, give the same error as in the simulator.
fn failures_are_those_of_the_simulator() {
    let points = plane(Kind::Uniform, 200, 5);
    for fault in ["die:2:hulls", "panic:2:partition", "panic:1:collect"] {
        let config = simulated(Workers::Count(3), 9, 20);
        let config = config.with(|c| c.planted.fault = Some(fault.parse().unwrap()));
        let (expected, found) = (simulate(&points, &config), over_pipes(&points, &config, true));
        let [expected, found] = [expected, found].map(|run| format!("{:?}", run.map(drop).unwrap_err()));
        assert_eq!(expected, found, "{fault}");
    }
    let cancel = Some(Arc::new(AtomicBool::new(true)));
    let config = simulated(Workers::Count(2), 9, 60).with(|c| c.control.cancel = cancel);
    assert!(matches!(over_pipes(&points, &config, true), Err(Error::Interrupted)));
}

fn main() -> ExitCode {
    if let Ok(rank) = env::var(RANK) {
        return worker(&rank);
    }
    let tests: [(&str, fn()); 3] = [
        ("equal_runs", equal_runs),
        ("broken_processes", broken_processes),
        ("failures_are_those_of_the_simulator", failures_are_those_of_the_simulator),
    ];
    let arguments: Vec<String> = env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|a| a == flag);
    let filter = arguments.iter().find(|a| !a.starts_with('-') && *a != "terse");
    for (name, test) in tests {
        let skipped = has("--ignored") || filter.is_some_and(|f| !name.contains(f.as_str()));
        match (skipped, has("--list")) {
            (true, _) => {}
            (false, true) => println!("{name}: test"),
            (false, false) => {
                test();
                println!("test {name} ... ok");
            }
        }
    }
    ExitCode::SUCCESS
}
