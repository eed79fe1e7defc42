//! f-spaced sets with boundary: the points of a mesh of the unit square or cube.
//!
//! **Statement.** The set is that of [`septet_meshing::generate`] for the unit square or cube, corners first, then points on
//! edges, on faces and in the volume. It is f-spaced (Definition 5.2 read with `>=`). No point lies in the smallest ball
//! of an edge's piece or of a face's triangle, so all circumcentres lie in the domain, and a cell with its centre c outside of all
//! those balls has `R <= f(c)`: a radius-edge ratio of at most `1 / (1 - L)`, and Delaunay edges
//! `|uv| <= 2(1+L)/(1-L) min(nn_u, nn_v)`. Such a ball has a radius of at most f at its centre, so it lies within
//! `f(x) / (1 - L)` of the boundary, x its point. Where the centre is in one, `R <= g f(c)` with `g = sqrt(2) / (1 - L)`, and
//! 5/4 in the place of g for constant f, farther than 3 f from the other faces. That edges are within 1.25 times the bound above
//! everywhere is measured, not proved: the most of 250 sets was 1.18 times it.
//!
//! **Why sizes need not be below the local feature size.** Sizes of a request are at most 1, so the balls of pieces and triangles
//! have radii below 1 and do not reach what is disjoint from their own face; what meets it does so at right angles,
//! where the generator's lemmas hold at any size.
//!
//! **Work.** That of the generator's runs: independent sets and triangulations on the machine, all of them `O(n log n)`.
//! The set is the same for every number of workers and threads.
//!
//! **Departures.** The generator works in a thread of its own while the caller's hears of it: so a caller that unwinds
//! from its callback ends the runs of the machine.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use glam::DVec2;
use septet_geometry::point::Point;
use septet_meshing::domain::Domain;
use septet_meshing::generate::{Failure, Machine, Rules, Triangulation, generate};
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;
use tracing::subscriber::{NoSubscriber, with_default};

use super::request::GenerateError;
use super::sizing::Sizing;
use super::unit::Unit;
use crate::config::{Config, Workers};
use crate::mesh::machine::Counted;

/// Points that cells of 32 bits can have.
const MOST_POINTS: u64 = 1 << 26;

/// How often the caller is told that the generator is still at work.
const PATIENCE: Duration = Duration::from_millis(50);

/// A machine that tells how many points there are.
struct Told<M> {
    machine: M,
    points: Sender<u64>,
}

impl<M> Told<M> {
    fn tell(&self, points: usize) {
        // Nobody listens any more if the caller has given up.
        let _ = self.points.send(points as u64);
    }
}

impl<P: Point, M: Machine<P>> Machine<P> for Told<M> {
    type Error = M::Error;

    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, M::Error> {
        let set = self.machine.independent(sites, fixed)?;
        self.tell(fixed + set.members.len());
        Ok(set)
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Triangulation<P::Cell>, M::Error> {
        self.tell(points.len());
        self.machine.delaunay(points)
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, M::Error> {
        self.machine.planar(sets)
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        self.machine.map(items, f)
    }
}

/// Tells the machine to give up when it is dropped.
struct GiveUp(Arc<AtomicBool>);

impl Drop for GiveUp {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// An f-spaced, completed set with boundary.
pub(super) fn build<P: Unit>(
    sizing: Sizing,
    seed: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<P>, GenerateError> {
    let refused = |reason: String| GenerateError::Incomplete { reason };
    let domain = P::domain().map_err(|defects| refused(format!("{} defects", defects.len())))?;
    let give_up = GiveUp(Arc::default());
    let config = machine(seed, Config::default().machine.threads, give_up.0.clone());
    let work = |points: Sender<u64>| {
        // What the machine does to make points is no part of a run over them.
        with_default(NoSubscriber::new(), || {
            set(&domain, sizing, seed, &mut Told { machine: Counted::new(config), points })
        })
    };
    match heard(work, give_up, progress) {
        Ok(points) => Ok(points),
        Err(Failure::Machine(error)) => Err(error.into()),
        Err(failure) => Err(refused(format!("{failure:?}"))),
    }
}

/// What comes of work in a thread of its own. If `progress` unwinds, the work is told to give up, and waited for.
fn heard<T: Send>(
    work: impl FnOnce(Sender<u64>) -> T + Send,
    give_up: GiveUp,
    progress: &mut dyn FnMut(u64),
) -> T {
    let (points, told) = channel();
    thread::scope(|scope| {
        // Dropped before the scope waits for its thread.
        let _give_up = give_up;
        let work = scope.spawn(move || work(points));
        let mut latest = 0;
        loop {
            match told.recv_timeout(PATIENCE) {
                Ok(points) => latest = points,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            progress(latest);
        }
        work.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

fn machine(seed: u64, workers: usize, cancel: Arc<AtomicBool>) -> Config {
    Config::default().with(|config| {
        config.machine.workers = Workers::Count(workers as u32);
        config.machine.threads = workers;
        config.machine.seed = seed;
        config.control.cancel = Some(cancel);
    })
}

/// The set as a machine makes it.
fn set<P: Unit, M: Machine<P> + Sync>(
    domain: &Domain<P>,
    sizing: Sizing,
    seed: u64,
    machine: &mut M,
) -> Result<Vec<P>, Failure<M::Error>> {
    let size = |x: P| sizing.at(&x);
    let rules = Rules { size: &size, lipschitz: sizing.slope, seed, most: MOST_POINTS };
    Ok(generate(domain, rules, machine)?.vertices.points)
}

#[cfg(test)]
mod tests;
