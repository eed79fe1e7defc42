//! Outputs of several processes, which are threads here, against those of one.

mod failures;
mod same_bytes;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use septet_core::model::Points;
use septet_core::run::distributed::{ProcessPoint, triangulate};
use septet_core::spec::{Spec, Workers};
use septet_core::{Outcome, channels};
use septet_protocol::wire::{Ended, Processes};

use super::*;
use crate::thread_wire::{Threads, connect};

/// The share of a process of a run.
struct Own {
    run: Outcome,
    rows: Points,
    first: u64,
}

impl Own {
    fn mesh(&self) -> SharedMesh<'_> {
        let (coordinates, first) = (self.rows.coordinates(), self.first);
        SharedMesh { run: &self.run, coordinates, heights: None, first, source_index: None, dropped: 0 }
    }
}

/// Runs the same function on all processes, each with its own data.
pub(super) fn on_each<O: Sync, T: Send>(
    owns: &[O],
    work: impl Fn(&mut Processes<'_>, &O) -> Result<T, Ended> + Sync,
) -> Vec<Result<T, Ended>> {
    let work = &work;
    thread::scope(|scope| {
        let start =
            |(mut wire, own): (Threads, _)| scope.spawn(move || work(&mut Processes::over(&mut wire), own));
        let threads: Vec<_> = connect(owns.len() as u32).into_iter().zip(owns).map(start).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Small leaves let all workers have points.
fn spec(workers: u32) -> Spec {
    Spec::default().with(|spec| {
        spec.machine.workers = Workers::Count(workers);
        spec.machine.threads = Some(1);
        spec.tree.leaf = Some(20);
        spec.input.skip_invalid = true;
        spec.keep.owner = true;
    })
}

/// Triangulates points on several processes. Their blocks of rows have different lengths.
fn run_apart<C>(points: &[C], wrap: fn(Vec<C>) -> Points, workers: u32, count: u32) -> Vec<Own>
where
    C: ProcessPoint + Clone + Sync,
{
    let at = |process: u32| points.len() * (process * process) as usize / (count * count) as usize;
    thread::scope(|scope| {
        let start = |(process, mut transport)| {
            let (first, end) = (at(process), at(process + 1));
            scope.spawn(move || {
                let own = &points[first..end];
                let run = triangulate(&mut transport, own, first as u64, &spec(workers)).unwrap();
                Own { run, rows: wrap(own.to_vec()), first: first as u64 }
            })
        };
        let threads: Vec<_> = (0..).zip(channels::<C::Point>(count)).map(start).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Triangulates points on several processes.
fn apart(points: &Points, workers: u32, count: u32) -> Vec<Own> {
    match points {
        Points::Plane(points) => run_apart(points, Points::Plane, workers, count),
        Points::Space(points) => run_apart(points, Points::Space, workers, count),
        Points::Higher(_) => unreachable!("sets are plane or spatial"),
    }
}

/// Triangulates points on one process.
fn alone(points: &Points, workers: u32) -> Outcome {
    let spec = spec(workers);
    match points {
        Points::Plane(points) => septet_core::triangulate(points, &spec).unwrap(),
        Points::Space(points) => septet_core::triangulate(points, &spec).unwrap(),
        Points::Higher(_) => unreachable!("sets are plane or spatial"),
    }
}

/// The outputs of all formats in a directory.
fn outputs(directory: &Path) -> Vec<PathBuf> {
    ["m.npy", "m.pvtu", "m.vtk", "m.vtu"].map(|name| directory.join(name)).to_vec()
}

/// The files below a directory, by their paths in it.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.insert(format!("{name}/"), Vec::new());
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(path).unwrap());
        }
    }
    found
}

/// Returns the refusal with which all processes end.
fn refused<T: std::fmt::Debug>(results: Vec<Result<T, Ended>>) -> septet_protocol::wire::Refused {
    let refused = |result| match result {
        Err(Ended::Refused(refused)) => refused,
        other => panic!("{other:?}"),
    };
    let all: Vec<_> = results.into_iter().map(refused).collect();
    assert!(all.iter().all(|other| *other == all[0]), "{all:?}");
    all[0].clone()
}
