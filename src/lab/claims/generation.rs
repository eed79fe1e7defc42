//! Section 5: points for meshes, generated for the unit cube and square.
//!
//! The size function f is a tenth of the largest size at the centre. From there, it grows with slope L up to the
//! largest size. Its values are below the local feature size everywhere, so f is known in advance. The measurements
//! recompute circumspheres and sizes.

use glam::{DVec2, DVec3};
use septet_geometry::point::Simplex;
use septet_meshing::generate::{GenerationError, Rules, StageCounts, generate};
use septet_meshing::mesh::Mesh;
use septet_meshing::size::cones::Cone;
use septet_meshing::size::{SizeFunction, SizeOptions};

use septet_core::Spec;
use septet_core::generate::unit::Unit;
use septet_core::mesh::Promise;
use septet_core::mesh::machine::CountedMachine;
use septet_core::simulate;
use septet_core::spec::{Graph, Workers};

use super::lab::Lab;
use super::measure::{CellShape, X, shapes};
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "f-spaced-ratio",
        role: Role::Test,
        statistics: None,
        source: "Theorem 5.3",
        statement: "a maximal f-spaced set with an L-Lipschitz f has radius-edge ratios of at most 1/(1-L)",
        reading: Reading::AsRead {
            instead: "distances of at least min(f(P), f(Q)) in Definition 5.2, and cells with circumcentres farther than \
                      sqrt(2) times the largest f from the boundary",
            because: "the printed definition bounds distances from above; and a centre beyond the boundary, or in a ball that \
                      protects it, cannot be added",
        },
        experiment: "Generated points of a square and a cube, L = 0.12, 0.25, 0.5: the largest R/l, over 1/(1-L)",
        bound: "1, a theorem; 1e-9 for rounding",
        check: |lab| ratios(lab, true),
    },
    Claim {
        name: "approximate-ratio",
        role: Role::Test,
        statistics: None,
        source: "Section 5, after Theorem 5.3",
        statement: "a similar theorem is true for a set that is an approximation to the maximal",
        reading: Reading::AsPrinted,
        experiment: "The sets of `f-spaced-ratio`, which are only maximal within g near the boundary; all cells, L = 0.06 and 0.12: the \
                     largest R/l over g/(1-gL), in space g = max sqrt(4-2d^2)/(1-L sqrt(3+2d)) over d, in the plane \
                     sqrt(2)/(1-L)",
        bound: "1, a theorem (the generator's documentation proves it); 1e-9 for rounding",
        check: |lab| ratios(lab, false),
    },
    Claim {
        name: "size-optimal",
        role: Role::Test,
        statistics: None,
        source: "Section 5, property (1)",
        statement: "the point set's density is bounded by the size function",
        reading: Reading::AsPrinted,
        experiment: "The number of points over the integral of dx/f^d over the cells, at two sizes that differ by a factor of two",
        bound: "2^d (2+2L)^d / v_d, v_d the unit ball: balls of radius f/(2+L) around points are disjoint, and a corner keeps \
                1/2^d of its own; growth by at most 1.25 from one size to the other",
        check: density,
    },
    Claim {
        name: "set-rounds",
        role: Role::Test,
        statistics: None,
        source: "Section 5, algorithm sketch, last step",
        statement: "the maximal independent set is obtained in parallel",
        reading: Reading::AsRead {
            instead: "in at most log2 m + 2 rounds of local priorities for m candidates",
            because: "the paper gives no number of rounds",
        },
        experiment: "Rounds minus log2 of the candidates, for the independent set with the most rounds, over all stages of these sets",
        bound: "2: for a random order, the rounds of the greedy set grow like log m (Fischer and Noever 2018)",
        check: rounds,
    },
    Claim {
        name: "generated-density",
        role: Role::Test,
        statistics: None,
        source: "Sections 3 and 5",
        statement: "the density graph of generated points contains their Delaunay triangulation",
        reading: Reading::AsRead {
            instead: "with alpha = 1.25 * 2(1+L)/(1-L)",
            because: "the proof of the claim `alpha` has a constant of hundreds of digits",
        },
        experiment: "Stars that splaying changed, and rounds of splaying, in the recursion over generated points, \
                     L = 0.12 and 0.25",
        bound: "0",
        check: stars,
    },
];

/// Tolerance for rounding, for bounds that can be attained.
const ROUNDING: f64 = 1e-9;

/// A generated set with its cells.
struct MeshSample {
    name: String,
    d: usize,
    lipschitz: f64,
    size: f64,
    points: Vec<X>,
    cells: Vec<u64>,
    stages: Vec<StageCounts>,
}

impl MeshSample {
    /// Returns the value of the size function at `x`.
    fn f(&self, x: &X) -> f64 {
        let away = (0..self.d).map(|i| (x[i] - 0.5) * (x[i] - 0.5)).sum::<f64>().sqrt();
        self.size.min(0.1 * self.size + self.lipschitz * away)
    }

    fn shapes(&self) -> Vec<CellShape> {
        shapes(&self.points, &self.cells, self.d)
    }

    /// Returns `true` if `x` is inside and farther from the boundary than the radius of every protecting ball. These
    /// radii are at most f for subsegments, and at most `sqrt(2)` times as large for subfacets.
    fn is_free(&self, x: &X) -> bool {
        let gap = (0..self.d).map(|i| x[i].min(1.0 - x[i])).fold(f64::INFINITY, f64::min);
        gap > std::f64::consts::SQRT_2 * self.size
    }
}

fn made<P: Unit>(lab: &Lab, lipschitz: f64, size: f64) -> Result<MeshSample, ClaimError> {
    let refused = |reason: String| ClaimError::Mesh { reason };
    let domain = P::domain().map_err(|defects| refused(format!("{} defects", defects.len())))?;
    let mut options = SizeOptions::new(lipschitz);
    options.constraints.most = Some(size);
    options.constraints.field = vec![Cone { at: P::splat(0.5), size: 0.1 * size }];
    let f = SizeFunction::new(&domain, &options).map_err(|e| refused(e.to_string()))?;
    let at = |x| f.at(x);
    let rules = Rules { size: &at, lipschitz, seed: lab.seed(), most: 1 << 24 };
    let mut machine = CountedMachine::new(spec(lab));
    let generated = generate(&domain, rules, &mut machine).map_err(|failure| match failure {
        GenerationError::Machine(error) => error.into(),
        failure => refused(format!("{failure:?}")),
    })?;
    let stages = generated.stages.clone();
    let mesh: Mesh<P> = generated.into_mesh(&domain);
    let coordinate = |p: &P, i: usize| if i < P::DIM { p.coord(i) } else { 0.0 };
    debug_assert_eq!(P::Cell::LEN, P::DIM + 1);
    Ok(MeshSample {
        name: format!("mesh {}D L={lipschitz} h={size}", P::DIM),
        d: P::DIM,
        lipschitz,
        size,
        points: mesh.points.iter().map(|p| [0, 1, 2].map(|i| coordinate(p, i))).collect(),
        cells: mesh.cells.iter().flat_map(AsRef::as_ref).map(|&v| u64::from(v)).collect(),
        stages,
    })
}

pub(super) fn spec(lab: &Lab) -> Spec {
    Spec::default().with(|c| {
        c.machine.workers = Workers::Count(lab.options.threads as u32);
        c.machine.threads = Some(lab.options.threads);
        c.machine.seed = lab.seed();
        c.planted.fault = lab.options.fault;
        c.control.cancel.clone_from(&lab.options.cancel);
    })
}

/// Generates the sets at `shrink` times the largest size of this extent.
fn samples(lab: &Lab, slopes: &[f64], shrink: f64) -> Result<Vec<MeshSample>, ClaimError> {
    let [plane, space] = if lab.brief() { [0.06, 0.15] } else { lab.by_extent([0.02, 0.08], [0.004, 0.03]) };
    let mut all = Vec::new();
    for &lipschitz in slopes {
        all.push(made::<DVec2>(lab, lipschitz, plane * shrink)?);
        all.push(made::<DVec3>(lab, lipschitz, space * shrink)?);
    }
    Ok(all)
}

fn ratios(lab: &mut Lab, free: bool) -> Result<Vec<Figure>, ClaimError> {
    let slopes: &[f64] = if free { &[0.12, 0.25, 0.5] } else { &[0.06, 0.12] };
    let of = |sample: MeshSample| {
        let slope = sample.lipschitz;
        let promise = Promise::of(slope);
        let all = if sample.d == 2 { promise.near } else { promise.above };
        let bound = if free { promise.free } else { all.unwrap_or(f64::NAN) };
        let shapes = sample.shapes();
        let checked: Vec<f64> =
            shapes.iter().filter(|s| !free || sample.is_free(&s.centre)).map(CellShape::ratio).collect();
        let worst = checked.iter().copied().fold(0.0, f64::max);
        let what = format!("largest R/l of {} of {} cells, over the bound", checked.len(), shapes.len());
        let value = if checked.is_empty() { f64::NAN } else { worst / bound };
        Figure::at_most(what, &sample.name, lab.seed(), value, 1.0 + ROUNDING)
    };
    Ok(samples(lab, slopes, 1.0)?.into_iter().map(of).collect())
}

fn density(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let over = |sample: &MeshSample| {
        let rows = sample.cells.chunks_exact(sample.d + 1);
        let integral: f64 = rows.map(|row| integral(sample, row)).sum();
        sample.points.len() as f64 / integral
    };
    let (coarse, fine) = (samples(lab, &[0.25], 1.0)?, samples(lab, &[0.25], 0.5)?);
    let mut figures = Vec::new();
    for (coarse, fine) in coarse.iter().zip(&fine) {
        let d = coarse.d as i32;
        let unit = if d == 2 { std::f64::consts::PI } else { 4.0 / 3.0 * std::f64::consts::PI };
        let bound = (2.0 * (2.0 + 2.0 * coarse.lipschitz)).powi(d) / unit;
        let (a, b) = (over(coarse), over(fine));
        for (sample, value) in [(coarse, a), (fine, b)] {
            let what = format!("{} points over the integral of dx/f^{d}", sample.points.len());
            figures.push(Figure::at_most(what, &sample.name, lab.seed(), value, bound));
        }
        figures.push(Figure::at_most("growth at half of the size", &fine.name, lab.seed(), b / a, 1.25));
    }
    Ok(figures)
}

/// Approximates the integral of `f^-d` over a cell by the measure of the cell times the mean over its corners.
fn integral(sample: &MeshSample, row: &[u64]) -> f64 {
    let corners: Vec<X> = row.iter().map(|&v| sample.points[v as usize]).collect();
    let side = |i: usize| [0, 1, 2].map(|k| corners[i][k] - corners[0][k]);
    let (u, v) = (side(1), side(2));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let measure = if sample.d == 2 {
        0.5 * n[2].abs()
    } else {
        let w = side(3);
        (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]).abs() / 6.0
    };
    let mean = corners.iter().map(|x| sample.f(x).powi(-(sample.d as i32))).sum::<f64>();
    measure * mean / corners.len() as f64
}

fn rounds(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for sample in samples(lab, &[0.12, 0.25, 0.5], 1.0)? {
        let of = |stage: &StageCounts| {
            let (rounds, candidates) = stage.longest;
            (f64::from(rounds) - (candidates.max(1) as f64).log2(), rounds, candidates)
        };
        let most = sample.stages.iter().map(of).max_by(|a, b| a.0.total_cmp(&b.0));
        let (value, rounds, candidates) = most.unwrap_or((f64::NAN, 0, 0));
        let what = format!("{rounds} rounds for {candidates} candidates, minus log2");
        figures.push(Figure::at_most(what, &sample.name, lab.seed(), value, 2.0));
    }
    Ok(figures)
}

fn stars(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for sample in samples(lab, &[0.12, 0.25], 1.0)? {
        let spec = spec(lab).with(|c| {
            c.recursion.spacing = Some(sample.lipschitz);
            c.recursion.graph = Graph::default();
        });
        let run = match sample.d {
            2 => simulate(&sample.points.iter().map(|x| DVec2::new(x[0], x[1])).collect::<Vec<_>>(), &spec)?,
            _ => simulate(&sample.points.iter().map(|x| DVec3::from(*x)).collect::<Vec<_>>(), &spec)?,
        };
        let what = format!("stars changed, of {}, and rounds of splaying", sample.points.len());
        let value = (run.stars_repaired + run.exchange_rounds) as f64;
        figures.push(Figure::at_most(what, &sample.name, lab.seed(), value, 0.0));
    }
    Ok(figures)
}
