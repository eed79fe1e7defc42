//! The sets and runs that claims share. Specimens and counted runs are computed only once. A limited number of sets is
//! kept.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use septet_core::generate::{Generated, Request, Spacing, generate};
use septet_core::model::{HigherPoints, Points};
use septet_core::result::view::MOST_POINTS;
use septet_core::spec::{
    Alpha, Correction, DEFAULT_ALPHA, Fault, Graph, Spec, SpecError, Until, Workers, alpha_of_spacing,
};
use septet_core::{Error, Outcome, count, independent, simulate};
use septet_geometry::point::{Point, Position};
use septet_geometry::site::Weighted;

use super::counted::Counted;
use super::measure::{X, kth_nearest2};
use super::sample::Sample;
use super::{ClaimError, Extent, Figure};

/// The parameters of the experiments.
#[derive(Clone, Debug)]
pub struct LabOptions {
    /// The extent of the experiments.
    pub extent: Extent,
    /// The first seed.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// The correction of neighbour balls. The claims about its depth must fail for the bottom-up correction.
    pub correction: Correction,
    /// A fault that tests inject into every machine.
    pub fault: Option<Fault>,
    /// A flag that cancels the experiments when it becomes `true`.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Default for LabOptions {
    fn default() -> Self {
        LabOptions {
            extent: Extent::Quick,
            seed: 1,
            threads: 2,
            correction: Correction::Descent,
            fault: None,
            cancel: None,
        }
    }
}

/// Runs that are counted together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runs<'a> {
    /// The name of the runs, which identifies them.
    pub(super) name: &'a str,
    /// The sets.
    pub(super) samples: &'a [Sample],
    /// Number of seeds of each set.
    pub(super) seeds: u64,
    /// The last phase, if the runs stop before their end.
    pub(super) until: Option<Until>,
}

/// A point set, and a run of the paper's recursion on it.
pub(super) struct Specimen {
    pub(super) name: String,
    pub(super) seed: u64,
    pub(super) d: usize,
    pub(super) points: Vec<X>,
    /// The size function of the set and its Lipschitz constant. `None` for kinds that have none.
    pub(super) spacing: Option<Spacing>,
    /// The alpha that follows from the spacing, or the default.
    pub(super) alpha: f64,
    /// Squared distance from each point to the nearest other point, computed from all pairs.
    pub(super) nearest2: Vec<f64>,
    pub(super) run: Outcome,
}

impl Specimen {
    /// Returns `true` if a location in the unit square or cube is *free*: farther than `f/(1-L)` from the boundary, so
    /// that no ball that protects the boundary contains it. Here, f is the size at the location, and L is the Lipschitz
    /// constant. Returns `false` for a set without a spacing.
    pub(super) fn is_free(&self, x: &X) -> bool {
        is_free(self.spacing.as_ref(), self.d, x)
    }
}

/// Returns [`Specimen::is_free`] for this spacing in `d` dimensions.
pub(super) fn is_free(spacing: Option<&Spacing>, d: usize, x: &X) -> bool {
    let gap = x[..d].iter().map(|x| x.min(1.0 - x)).fold(f64::INFINITY, f64::min);
    spacing.is_some_and(|s| gap * (1.0 - s.lipschitz) > s.size(*x))
}

/// The laboratory, which generates sets, runs the machine, and keeps the results.
pub struct Lab<'a> {
    /// The parameters of the experiments.
    pub options: LabOptions,
    sets: BTreeMap<String, Rc<Generated>>,
    specimens: BTreeMap<String, Rc<Specimen>>,
    counted: BTreeMap<String, Rc<Vec<Counted>>>,
    report: Box<dyn FnMut(&str) + 'a>,
}

/// Maximum number of sets that are kept in memory.
const KEPT: usize = 24;

impl<'a> Lab<'a> {
    /// Creates an empty laboratory. It calls `report` with a description of every new set and run.
    pub fn new(options: LabOptions, report: impl FnMut(&str) + 'a) -> Lab<'a> {
        let (sets, specimens, counted) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Lab { options, sets, specimens, counted, report: Box::new(report) }
    }

    pub(super) fn brief(&self) -> bool {
        self.options.extent == Extent::Brief
    }

    pub(super) fn seed(&self) -> u64 {
        self.options.seed
    }

    /// Returns `true` if a machine with a planted fault has exceeded a bound. Then the claim fails, whatever its other sets
    /// show.
    pub(super) fn has_detected(&self, figures: &[Figure]) -> bool {
        self.options.fault.is_some() && figures.iter().any(|figure| !figure.holds())
    }

    /// Returns `count` consecutive seeds, starting with the first seed.
    pub(super) fn seeds(&self, count: u64) -> impl Iterator<Item = u64> + use<> {
        let first = self.seed();
        (0..count).map(move |i| first.wrapping_add(i))
    }

    /// Returns `quick` or `full`, depending on the extent.
    pub(super) fn by_extent<T>(&self, quick: T, full: T) -> T {
        if self.options.extent == Extent::Full { full } else { quick }
    }

    /// Returns the number of points for the extent. For the brief extent, this is a third of the quick number.
    pub(super) fn size(&self, quick: u64, full: u64) -> u64 {
        if self.brief() { quick / 3 } else { self.by_extent(quick, full) }
    }

    fn set(&mut self, sample: Sample, seed: u64) -> Result<Rc<Generated>, ClaimError> {
        let key = format!("{} seed {seed}", sample.name());
        if let Some(set) = self.sets.get(&key) {
            return Ok(set.clone());
        }
        (self.report)(&key);
        let Sample { kind, n, d, lipschitz } = sample;
        let request = Request { kind, n, dimension: d, seed, lipschitz, ratio: None };
        let set = Rc::new(generate(&request, &mut |_, _, _| {})?);
        if self.sets.len() >= KEPT {
            self.sets.pop_first();
        }
        if n <= 1 << 17 {
            self.sets.insert(key, set.clone());
        }
        Ok(set)
    }

    /// Returns the points of a set.
    pub(super) fn points(&mut self, sample: Sample, seed: u64) -> Result<Vec<X>, ClaimError> {
        Ok(coordinates(&self.set(sample, seed)?.points))
    }

    /// Returns the spacing of a set, if it has one.
    pub(super) fn spacing(&mut self, sample: Sample, seed: u64) -> Result<Option<Spacing>, ClaimError> {
        Ok(self.set(sample, seed)?.spacing)
    }

    fn base(&self, set: &Generated, seed: u64) -> Spec {
        let spacing = set.spacing.map(|s| s.lipschitz);
        Spec::default().with(|c| {
            c.machine.workers = Workers::Count(1);
            c.machine.threads = Some(self.options.threads);
            c.machine.seed = seed;
            c.recursion.neighbours = self.options.correction;
            c.recursion.spacing = spacing;
            // If the spacing is known, alpha follows from it. Otherwise, alpha is fixed.
            let alpha = if spacing.is_some() { Alpha::Auto } else { Alpha::Value(DEFAULT_ALPHA) };
            c.recursion.graph = Graph::Density { alpha };
            c.planted.fault = self.options.fault;
            c.control.cancel.clone_from(&self.options.cancel);
        })
    }

    /// Runs the paper's recursion on a set. `change` modifies the configuration.
    pub(super) fn run(
        &mut self,
        sample: Sample,
        seed: u64,
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let set = self.set(sample, seed)?;
        (self.report)(&format!("run over {} seed {seed}", sample.name()));
        let spec = change(self.base(&set, seed));
        Ok(match &set.points {
            Points::Plane(points) => simulate(points, &spec)?,
            Points::Space(points) => simulate(points, &spec)?,
            Points::Higher(points) => return Err(not_in_space(points)),
        })
    }

    /// Runs the paper's recursion on a set with these weights. `change` modifies the configuration.
    pub(super) fn run_with_weights(
        &mut self,
        (sample, seed): (Sample, u64),
        weights: &[f64],
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let set = self.set(sample, seed)?;
        (self.report)(&format!("run over {} seed {seed} with weights", sample.name()));
        let spec = change(self.base(&set, seed));
        Ok(match &set.points {
            Points::Plane(points) => simulate(&with_weights(points, weights), &spec)?,
            Points::Space(points) => simulate(&with_weights(points, weights), &spec)?,
            Points::Higher(points) => return Err(not_in_space(points)),
        })
    }

    /// Runs the paper's recursion on a set in the unit cube and its centre, which is the last point. `change` modifies
    /// the configuration.
    pub(super) fn run_with_centre(
        &mut self,
        sample: Sample,
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let seed = self.seed();
        let set = self.set(sample, seed)?;
        (self.report)(&format!("run over {} seed {seed} and the centre", sample.name()));
        let spec = change(self.base(&set, seed));
        Ok(match &set.points {
            Points::Plane(points) => simulate(&with_centre(points), &spec)?,
            Points::Space(points) => simulate(&with_centre(points), &spec)?,
            Points::Higher(points) => return Err(not_in_space(points)),
        })
    }

    /// Computes an independent set of sites at the points of a set. All sites have the same size
    /// ([`Sample::site_size`]). `change` modifies the configuration.
    pub(super) fn independent(
        &mut self,
        sample: Sample,
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let seed = self.seed();
        let set = self.set(sample, seed)?;
        (self.report)(&format!("independent set of {} seed {seed}", sample.name()));
        let spec = change(self.base(&set, seed));
        let sizes = vec![sample.site_size(); set.points.len()];
        Ok(match &set.points {
            Points::Plane(points) => independent(points, &sizes, 0, &spec)?,
            Points::Space(points) => independent(points, &sizes, 0, &spec)?,
            Points::Higher(points) => return Err(not_in_space(points)),
        })
    }

    /// Returns the counts of one run. `change` modifies the configuration.
    pub(super) fn counts(
        &mut self,
        sample: Sample,
        seed: u64,
        until: Option<Until>,
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let set = self.set(sample, seed)?;
        (self.report)(&format!("counts over {} seed {seed}", sample.name()));
        let spec = change(self.base(&set, seed));
        counts_of(&set.points, until, &spec)
    }

    /// Builds the supergraph of a set whose first `repeats` points are also its last points. `change` modifies the
    /// configuration.
    pub(super) fn graph_with_repeats(
        &mut self,
        sample: Sample,
        repeats: usize,
        change: impl FnOnce(Spec) -> Spec,
    ) -> Result<Outcome, ClaimError> {
        let seed = self.seed();
        let set = self.set(sample, seed)?;
        (self.report)(&format!("graph of {} seed {seed} and {repeats} repeated points", sample.name()));
        let spec = change(self.base(&set, seed));
        let points = match &set.points {
            Points::Plane(points) => Points::Plane([&points[..], &points[..repeats]].concat()),
            Points::Space(points) => Points::Space([&points[..], &points[..repeats]].concat()),
            Points::Higher(points) => return Err(not_in_space(points)),
        };
        counts_of(&points, Some(Until::Graph), &spec)
    }

    /// Returns the counts of runs, one for each sample and seed. A second call with the same name returns the same runs.
    pub(super) fn counted(
        &mut self,
        runs: &Runs<'_>,
        change: impl Fn(Spec) -> Spec,
    ) -> Result<Rc<Vec<Counted>>, ClaimError> {
        let Runs { name, samples, seeds, until } = *runs;
        if let Some(runs) = self.counted.get(name) {
            return Ok(runs.clone());
        }
        let mut runs = Vec::new();
        for &sample in samples {
            for seed in self.seeds(seeds) {
                let counts = self.counts(sample, seed, until, &change)?;
                runs.push(Counted::of(sample, seed, &counts));
            }
        }
        let runs = Rc::new(runs);
        self.counted.insert(name.to_string(), runs.clone());
        Ok(runs)
    }

    /// Returns a set together with its run, graph and separators.
    pub(super) fn specimen(&mut self, sample: Sample, seed: u64) -> Result<Rc<Specimen>, ClaimError> {
        let key = format!("{} seed {seed}", sample.name());
        if let Some(specimen) = self.specimens.get(&key) {
            return Ok(specimen.clone());
        }
        let run = self.run(sample, seed, |spec| {
            spec.with(|c| {
                c.keep.graph = true;
                c.keep.view = Some(MOST_POINTS);
            })
        })?;
        let set = self.set(sample, seed)?;
        let points = coordinates(&set.points);
        let specimen = Rc::new(Specimen {
            name: sample.name(),
            seed,
            d: sample.d,
            nearest2: kth_nearest2(&points, 1),
            points,
            spacing: set.spacing,
            alpha: set.spacing.map_or(DEFAULT_ALPHA, |s| alpha_of_spacing(s.lipschitz)),
            run,
        });
        self.specimens.insert(key, specimen.clone());
        Ok(specimen)
    }

    /// Returns the specimens of several samples, each with `seeds` seeds.
    pub(super) fn specimens(
        &mut self,
        samples: &[Sample],
        seeds: u64,
    ) -> Result<Vec<Rc<Specimen>>, ClaimError> {
        let mut all = Vec::new();
        for &sample in samples {
            for seed in self.seeds(seeds) {
                all.push(self.specimen(sample, seed)?);
            }
        }
        Ok(all)
    }
}

/// Returns the points and the centre of the unit cube or square.
fn with_centre<P: Point>(points: &[P]) -> Vec<P> {
    [points, &[P::splat(0.5)]].concat()
}

fn with_weights<P: Position>(points: &[P], weights: &[f64]) -> Vec<Weighted<P>> {
    points.iter().zip(weights).map(|(&point, &weight)| Weighted::new(point, weight)).collect()
}

fn counts_of(points: &Points, until: Option<Until>, spec: &Spec) -> Result<Outcome, ClaimError> {
    Ok(match points {
        Points::Plane(points) => count(points, until, spec)?,
        Points::Space(points) => count(points, until, spec)?,
        Points::Higher(HigherPoints::Four(points)) => count(points, until, spec)?,
        Points::Higher(HigherPoints::Five(points)) => count(points, until, spec)?,
        Points::Higher(HigherPoints::Six(points)) => count(points, until, spec)?,
    })
}

fn coordinates(points: &Points) -> Vec<X> {
    match points {
        Points::Plane(points) => points.iter().map(|p| [p.x, p.y, 0.0]).collect(),
        Points::Space(points) => points.iter().map(|p| [p.x, p.y, p.z]).collect(),
        // No claim is about these points.
        Points::Higher(_) => Vec::new(),
    }
}

/// Returns the error for points of a dimension that no claim is about.
fn not_in_space(points: &HigherPoints) -> ClaimError {
    let dimension = points.slice().dimension();
    Error::from(SpecError::OnlySpace { what: "claims", dimension }).into()
}
