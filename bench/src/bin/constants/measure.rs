//! Runs of one setting.

use std::error::Error;

use septet_core::generate::{Generated, Kind, Request, generate};
use septet_core::model::Points;
use septet_core::spec::{Partition, Transport, Workers};
use septet_core::{Outcome, Spec, simulate};
use septet_geometry::point::Point;
use septet_lab::baselines::incremental;

use super::journal::{Counts, Key};
use super::setting::{Method, Setting};

/// Generates the sets, and keeps the last one.
pub struct Sets {
    kind: Kind,
    dimension: usize,
    last: Option<(Request, Generated)>,
}

impl Sets {
    /// Creates the sets of a kind.
    pub fn new(kind: Kind, dimension: usize) -> Self {
        Sets { kind, dimension, last: None }
    }

    /// Returns the default setting of `simulate`.
    pub fn default_setting(&mut self) -> Result<Setting, Box<dyn Error>> {
        let (points, spec) = self.set(100, 1)?;
        let run = recursion(points, &spec)?;
        let used = &run.settled;
        Ok(Setting { method: Method::Spheres, samples: used.samples, tries: used.tries, leaf: used.leaf })
    }

    /// Counts one run.
    pub fn measure(&mut self, key: Key) -> Result<Counts, Box<dyn Error>> {
        let Setting { method, samples, tries, leaf } = key.setting;
        let (points, spec) = self.set(key.n, key.seed)?;
        if method == Method::Insertion {
            return match points {
                Points::Plane(points) => insertion(points, &spec),
                Points::Space(points) => insertion(points, &spec),
                Points::Higher(_) => unreachable!("the settings have dimensions 2 and 3"),
            };
        }
        let is_sphere = method == Method::Spheres;
        let spec = spec.with(|c| {
            c.tree.partition = if is_sphere { Partition::Sphere } else { Partition::Kd };
            c.tree.constants.samples = Some(samples);
            c.tree.constants.tries = is_sphere.then_some(tries);
            c.tree.leaf = Some(leaf);
        });
        let run = recursion(points, &spec)?;
        let (paper, repair) = (&run.ledger.totals.paper, &run.ledger.totals.repair);
        Ok(Counts {
            points: run.points.used,
            work: paper.work,
            repair_work: repair.work,
            depth: paper.depth,
            repair_depth: repair.depth,
            steps: paper.brent + repair.brent,
        })
    }

    fn set(&mut self, n: u64, seed: u64) -> Result<(&Points, Spec), Box<dyn Error>> {
        let request =
            Request { kind: self.kind, n, dimension: self.dimension, seed, lipschitz: None, ratio: None };
        let kept = self.last.take().filter(|(kept, _)| *kept == request);
        let (_, set) = self.last.insert(match kept {
            Some(kept) => kept,
            None => (request, generate(&request, &mut |_, _, _| {})?),
        });
        let spec = Spec::default().with(|c| {
            c.machine.workers = Workers::Count(2);
            c.machine.threads = Some(2);
            c.machine.transport = Transport::Channel;
            c.machine.seed = seed;
            c.recursion.spacing = set.spacing.map(|s| s.lipschitz);
        });
        Ok((&set.points, spec))
    }
}

fn recursion(points: &Points, spec: &Spec) -> Result<Outcome, septet_core::error::Error> {
    match points {
        Points::Plane(points) => simulate(points, spec),
        Points::Space(points) => simulate(points, spec),
        Points::Higher(_) => unreachable!("the settings have dimensions 2 and 3"),
    }
}

fn insertion<P: Point>(points: &[P], spec: &Spec) -> Result<Counts, Box<dyn Error>> {
    let baseline = incremental(points, spec)?;
    Ok(Counts {
        points: baseline.points.used,
        work: baseline.rounds.iter().map(|r| r.work).sum(),
        repair_work: 0,
        depth: baseline.clock.steps,
        repair_depth: 0,
        steps: baseline.brent,
    })
}
