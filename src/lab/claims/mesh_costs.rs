//! Section 5: work and depth of generating points for a mesh.
//!
//! **Statement.** Every stage of generation is charged where the ranks pay: trees of cells, sizes, candidates, conflicts,
//! independent sets, and the triangulations of completion, which run by the paper's recursion. `T_n` of a mesh with n points
//! is [`RunLog::brent`](septet_core::mesh::run_log::RunLog::brent) for n processors. The cube is graded towards its centre.
//!
//! **Source.** Section 5 of the paper. **Work.** Five meshes, about 7 million operations in evaluations.

use glam::DVec3;
use septet_meshing::distance::Features;
use septet_meshing::generate::{GenerationError, Rules, StageCounts, generate};
use septet_meshing::size::cones::Cone;
use septet_meshing::size::{SizeFunction, SizeOptions};

use septet_core::generate::unit::Unit;
use septet_core::mesh::machine::CountedMachine;
use septet_core::mesh::run_log::{RunLog, StagePhase};
use septet_protocol::ids::Phase;

use super::generation::spec;
use super::lab::Lab;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The slope of the sizes.
const SLOPE: f64 = 0.5;

/// Number of doublings of the number of points.
const OCTAVES: i32 = 4;

/// Number of doublings of the number of points that halve the sizes. Every tree of cells then has one more level. The
/// depth of a tree is constant in between, because levels are whole numbers.
const HALVING: usize = 3;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "mesh-brent",
    role: Role::Test,
    statistics: None,
    source: "Section 5, algorithm sketch",
    statement: "the point set for a mesh is obtained in parallel",
    reading: Reading::AsRead {
        instead: "in T_n = O(log n) steps for each round of completion, with rounds that do not grow with n",
        because: "the paper gives no time for the sketch, and its other parts take O(log n)",
    },
    experiment: "A cube whose sizes fall to a tenth at its centre, L = 0.5, in sizes that double the points four times: the growth of \
                 T_n over log2 n, and, from each size to its half, of the depth of the trees of cells over log2 n; the most rounds of \
                 completion in a stage; for each of the five phases of generation, the least work for each point",
    bound: "growth of 10 %, as for `depth-law`: a tree has O(log n) levels, and one more level for each half of the sizes; 6 rounds; \
             1 operation, because each point was a candidate in a cell, with a size, and tested for conflicts",
    check: costs,
}];

/// The counts of one mesh.
struct Costs {
    points: u64,
    log: RunLog,
    stages: Vec<StageCounts>,
}

impl Costs {
    /// Returns `T_n` over log2 n.
    fn ratio(&self) -> f64 {
        self.log.brent(self.points) as f64 / (self.points as f64).log2()
    }

    /// Returns the work of a phase in all stages.
    fn work(&self, phase: Phase) -> u64 {
        let rows = self.log.phases.iter().filter(|row: &&StagePhase| row.phase == phase.name());
        rows.map(|row| row.work).sum()
    }

    /// Returns the depth of the trees of cells over log2 n.
    fn tree_ratio(&self) -> f64 {
        let rows = self.log.phases.iter().filter(|row| row.phase == Phase::Octree.name());
        rows.map(|row| row.depth).sum::<u64>() as f64 / (self.points as f64).log2()
    }

    /// Returns the largest number of rounds of completion of a stage.
    fn rounds(&self) -> u32 {
        self.stages.iter().map(|stage| stage.completion).max().unwrap_or(0)
    }
}

fn costs(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let first = if lab.brief() { 0.16 } else { lab.by_extent(0.1, 0.08) };
    let made: Vec<Costs> = (0..=OCTAVES)
        .map(|octave| of_cube(lab, first * 0.5f64.powf(f64::from(octave) / 3.0)))
        .collect::<Result<_, _>>()?;
    let name = "graded cube L=0.5";
    let seed = lab.seed();
    let mut figures = Vec::new();
    if let [first, .., last] = made.as_slice() {
        let what = format!("growth of T_n over log2 n, {} to {} points", first.points, last.points);
        figures.push(Figure::at_most(what, name, seed, last.ratio() / first.ratio(), 1.1));
        let ratios: Vec<f64> = made.iter().map(Costs::tree_ratio).collect();
        let growth = ratios.iter().zip(&ratios[HALVING..]).map(|(coarse, fine)| fine / coarse);
        let what = "growth of the depth of trees over log2 n, from one size to its half".to_string();
        figures.push(Figure::at_most(what, name, seed, growth.fold(0.0, f64::max), 1.1));
    }
    for mesh in &made {
        let what = format!("rounds of completion of a stage, {} points", mesh.points);
        figures.push(Figure::at_most(what, name, seed, f64::from(mesh.rounds()), 6.0));
    }
    for phase in Phase::OF_MESHES {
        // Each point was a candidate, in a cell of its own, and its size was evaluated and its conflicts were tested.
        let least = made.iter().map(|mesh| mesh.work(phase) as f64 / mesh.points as f64);
        let what = format!("least work of {} for each point", phase.name());
        figures.push(Figure::at_least(what, name, seed, least.fold(f64::INFINITY, f64::min), 1.0));
    }
    Ok(figures)
}

/// Makes a mesh of the unit cube, with this size at its boundary, and counts everything.
fn of_cube(lab: &Lab, size: f64) -> Result<Costs, ClaimError> {
    let refused = |reason: String| ClaimError::Mesh { reason };
    let domain = DVec3::domain().map_err(|defects| refused(format!("{} defects", defects.len())))?;
    let mut options = SizeOptions::new(SLOPE);
    options.constraints.most = Some(size);
    options.constraints.field = vec![Cone { at: DVec3::splat(0.5), size: 0.1 * size }];
    let mut machine = CountedMachine::new(spec(lab)).with_recursion(true);
    let features = Features::new(&domain);
    let f = SizeFunction::of_features(&domain, &features, &options, &machine)?;
    let f = f.map_err(|e| refused(e.to_string()))?;
    let rules = Rules { size: &f, lipschitz: SLOPE, seed: lab.seed(), most: 1 << 24 };
    let generated = generate(&domain, rules, &mut machine).map_err(|failure| match failure {
        GenerationError::Machine(error) => error.into(),
        failure => refused(format!("{failure:?}")),
    })?;
    let points = generated.vertices.points.len() as u64;
    Ok(Costs { points, stages: generated.stages, log: machine.into_log() })
}
