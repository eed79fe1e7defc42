//! f-spaced sets with boundary: the points of a mesh of the unit square or cube.
//!
//! **Statement.** The set is the result of [`septet_meshing::generate`] for the unit square or cube: corners first,
//! then points on edges, on faces and in the volume.
//! 1. The set is f-spaced (Definition 5.2 read with `>=`).
//! 2. No point lies in the smallest ball of a subsegment of an edge or of a subfacet of a face. Hence all circumcentres
//!    lie in the domain.
//! 3. A cell whose centre c lies outside all these balls has `R <= f(c)`. Then the radius-edge ratio is at most
//!    `1 / (1 - L)`, and Delaunay edges satisfy `|uv| <= 2(1+L)/(1-L) min(nn_u, nn_v)`.
//! 4. Such a ball has a radius of at most f at its centre. It therefore lies within `f(x) / (1 - L)` of the boundary
//!    for each of its points x.
//! 5. A cell whose centre lies in such a ball has `R <= g f(c)` with `g = sqrt(2) / (1 - L)`. If f is constant and the
//!    centre is farther than 3 f from the other faces, g is 5/4.
//!
//! All Delaunay edges, including those near the boundary, stay within 1.25 times the bound of claim 3. This is
//! measured, not proved: the maximum over 250 sets was 1.18 times the bound.
//!
//! **Why sizes need not be below the local feature size.** The sizes of a request are at most 1. The balls of
//! subsegments and subfacets therefore have radii below 1 and do not reach faces that are disjoint from their own.
//! Faces that meet their own face meet it at right angles, and then the lemmas of the generator hold for any size.
//!
//! **Work.** The generator computes independent sets and triangulations on the machine, each in `O(n log n)` work. The
//! set is the same for every number of workers and threads.
//!
//! **Departures.** The generator runs in its own thread and sends its progress to the thread of the caller. If the
//! caller's callback unwinds, the runs of the machine are cancelled.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use glam::DVec2;
use septet_geometry::evaluation::{Evaluated, Evaluation};
use septet_geometry::point::Point;
use septet_meshing::domain::Domain;
use septet_meshing::executor::{Evaluator, Part};
use septet_meshing::generate::{Delaunay, GenerationError, MeshMachine, Rules, generate};
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;
use tracing::subscriber::{NoSubscriber, with_default};

use super::request::GenerateError;
use super::sizing::Sizing;
use super::unit::Unit;
use crate::mesh::machine::CountedMachine;
use crate::spec::{Spec, Workers, cores};

/// The largest number of points for which 32 bits can index the cells.
const MOST_POINTS: u64 = 1 << 26;

/// The interval at which the callback of the caller runs while the generator works.
const PATIENCE: Duration = Duration::from_millis(50);

/// A machine that sends the number of points after each step.
struct Reporting<M> {
    machine: M,
    points: Sender<u64>,
}

impl<M> Reporting<M> {
    fn report(&self, points: usize) {
        // The receiver is gone if the caller has given up.
        let _ = self.points.send(points as u64);
    }
}

impl<P: Point, M: MeshMachine<P>> Evaluator<P> for Reporting<M> {
    type Error = M::Error;

    fn evaluate(&self, part: Part, rule: &dyn Evaluation) -> Result<Evaluated, M::Error> {
        self.machine.evaluate(part, rule)
    }
}

impl<P: Point, M: MeshMachine<P>> MeshMachine<P> for Reporting<M> {
    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, M::Error> {
        let set = self.machine.independent(sites, fixed)?;
        self.report(fixed + set.members.len());
        Ok(set)
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Delaunay<P::Cell>, M::Error> {
        self.report(points.len());
        self.machine.delaunay(points)
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, M::Error> {
        self.machine.planar(sets)
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        self.machine.map(items, f)
    }
}

/// Cancels the runs of the machine when it is dropped.
struct GiveUp(Arc<AtomicBool>);

impl Drop for GiveUp {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Builds a complete f-spaced set with boundary.
pub(super) fn build<P: Unit>(
    sizing: Sizing,
    seed: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<P>, GenerateError> {
    let incomplete = |reason: String| GenerateError::Incomplete { reason };
    let domain = P::domain().map_err(|defects| incomplete(format!("{} defects", defects.len())))?;
    let give_up = GiveUp(Arc::default());
    let spec = machine(seed, cores(), give_up.0.clone());
    let work = |points: Sender<u64>| {
        // Traces of later runs over the points must not include the spans of their generation.
        with_default(NoSubscriber::new(), || {
            set(&domain, sizing, seed, &mut Reporting { machine: CountedMachine::new(spec), points })
        })
    };
    match run_in_thread(work, give_up, progress) {
        Ok(points) => Ok(points),
        Err(GenerationError::Machine(error)) => Err(error.into()),
        Err(failure) => Err(incomplete(format!("{failure:?}"))),
    }
}

/// Runs `work` in its own thread and calls `progress` meanwhile. If `progress` unwinds, cancels the work and waits for
/// its end.
fn run_in_thread<T: Send>(
    work: impl FnOnce(Sender<u64>) -> T + Send,
    give_up: GiveUp,
    progress: &mut dyn FnMut(u64),
) -> T {
    let (points, counts) = channel();
    thread::scope(|scope| {
        // This guard is dropped before the scope waits for its thread.
        let _give_up = give_up;
        let work = scope.spawn(move || work(points));
        let mut latest = 0;
        loop {
            match counts.recv_timeout(PATIENCE) {
                Ok(points) => latest = points,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            progress(latest);
        }
        work.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

fn machine(seed: u64, workers: usize, cancel: Arc<AtomicBool>) -> Spec {
    Spec::default().with(|spec| {
        spec.machine.workers = Workers::Count(workers as u32);
        spec.machine.threads = Some(workers);
        spec.machine.seed = seed;
        spec.control.cancel = Some(cancel);
    })
}

/// Generates the set on a machine.
fn set<P: Unit, M: MeshMachine<P> + Sync>(
    domain: &Domain<P>,
    sizing: Sizing,
    seed: u64,
    machine: &mut M,
) -> Result<Vec<P>, GenerationError<M::Error>> {
    let size = |x: P| sizing.at(&x);
    let rules = Rules { size: &size, lipschitz: sizing.slope, seed, most: MOST_POINTS };
    Ok(generate(domain, rules, machine)?.vertices.points)
}

#[cfg(test)]
mod tests;
