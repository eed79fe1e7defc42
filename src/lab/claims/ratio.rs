//! Section 3: the consequences of a bounded radius-edge ratio for edges, radii, angles and degrees.
//!
//! The cells come from certified runs. Circumspheres, edges and angles are recomputed.

use std::f64::consts::PI;
use std::rc::Rc;

use septet_core::generate::Kind;

use super::figure::smallest;
use super::lab::{Lab, Specimen};
use super::measure::{
    CellShape, X, degrees, density, distance2, dot, edges, minus, pairs, shapes, smallest_angle, stars,
};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// Tolerance for rounding, for bounds that can be attained.
const ROUNDING: f64 = 1e-9;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "smallest-angle",
        role: Role::Illustration,
        statistics: None,
        source: "Section 3, after Definition 3.1",
        statement: "in the plane the smallest angle is at least asin(1/(2C))",
        reading: Reading::AsPrinted,
        experiment: "Angles, from their sides, of triangles with free circumcentres, farther than f/(1-L) from the \
                     boundary; C = 1/(1-L), known in advance",
        bound: "1 for the quotient: R <= f(c) and edges of at least f(c) - L R give C, and C the angle",
        check: angle,
    },
    Claim {
        name: "alpha",
        role: Role::Test,
        statistics: None,
        source: "Theorem 3.2",
        statement: "P is an alpha-density embedding of DT(P) for an alpha of d and C alone",
        reading: Reading::AsRead {
            instead: "alpha = 2(1+L)/(1-L) for maximal f-spaced sets with an L-Lipschitz f where circumcentres lie in \
                      the domain, outside of the balls that protect its boundary; 1.25 times that at the boundary",
            because: "the proof's constant D^K has hundreds of digits",
        },
        experiment: "Longest edge over nearest neighbour, at vertices with all circumcentres free, farther than f/(1-L) \
                     from the boundary, and at all vertices",
        bound: "2(1+L)/(1-L) in the interior, a theorem; 1.25 times that at all vertices, an observation with 6 % to \
                spare",
        check: alpha,
    },
    Claim {
        name: "radius-vectors",
        role: Role::Illustration,
        statistics: None,
        source: "Lemma 3.3",
        statement: "radius vectors from p at an angle below alpha_0 have lengths within a factor C_1",
        reading: Reading::AsPrinted,
        experiment: "Pairs of cells at a vertex, circumcentres free, alpha_0 = asin(1/(2C))/2, C = 1/(1-L) \
                     known in advance; the largest R / r",
        bound: "C_1 = 2 cos alpha_0: the lemma's L >= 1/C and the law of sines give it",
        check: radius_vectors,
    },
    Claim {
        name: "edges-of-radii",
        role: Role::Illustration,
        statistics: None,
        source: "Lemma 3.4",
        statement: "cells whose radii are within C_1 have edges within 2 C_1 C",
        reading: Reading::AsPrinted,
        experiment: "Pairs of cells at a vertex, circumcentres free, C = 1/(1-L), known in advance: E/e over 2 C R/r",
        bound: "1, a theorem; 1e-9 for rounding",
        check: |lab| edge_ratios(lab, false),
    },
    Claim {
        name: "neighbouring-edges",
        role: Role::Illustration,
        statistics: None,
        source: "Lemma 3.5",
        statement: "edges of neighbouring cells are within 4 C^2",
        reading: Reading::AsPrinted,
        experiment: "Pairs of cells that share an edge, circumcentres free, C = 1/(1-L), known in advance: E/e over 4 C^2",
        bound: "1, a theorem; 1e-9 for rounding",
        check: |lab| edge_ratios(lab, true),
    },
    Claim {
        name: "degree",
        role: Role::Illustration,
        statistics: None,
        source: "Lemma 3.7",
        statement: "an alpha-density graph has degrees bounded by a constant of alpha and d",
        reading: Reading::AsPrinted,
        experiment: "Largest degree of the alpha-density graph by all pairs, for any set; alpha 2, and 4 in the plane",
        bound: "(2 alpha^2 + 1)^d - 1: the balls of the lemma's proof, packed by volume; below n",
        check: degree,
    },
];

/// Returns f-spaced sets, whose radius-edge ratios are bounded away from the boundary.
fn specimens(lab: &mut Lab) -> Result<Vec<Rc<Specimen>>, ClaimError> {
    let n = lab.size(8000, 40_000);
    let mut samples = Vec::new();
    for d in [2, 3] {
        samples.push(Sample::new(Kind::WellSpaced, n, d));
        samples.push(Sample::new(Kind::GradedPoint, n, d));
        samples.push(Sample { lipschitz: Some(0.5), ..Sample::new(Kind::GradedLine, n, d) });
    }
    lab.specimens(&samples, lab.by_extent(1, 3))
}

fn ratio_of(shapes: &[CellShape]) -> f64 {
    shapes.iter().map(CellShape::ratio).fold(0.0, f64::max)
}

/// Returns `1 / (1 - L)`, with a tolerance for rounding. This bounds the radius-edge ratio of the cells with free
/// circumcentres ([`Specimen::is_free`]) in a maximal set with an L-Lipschitz spacing. It is known before any
/// measurement.
fn known_ratio(specimen: &Specimen) -> f64 {
    specimen.spacing.map_or(f64::NAN, |s| 1.0 / (1.0 - s.lipschitz) * (1.0 + ROUNDING))
}

fn angle(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)?.into_iter().filter(|s| s.d == 2) {
        let Specimen { points, run, .. } = &*specimen;
        let shapes = shapes(points, run.cells(), 2);
        let free =
            run.cells().chunks_exact(3).zip(&shapes).filter(|(_, shape)| specimen.is_free(&shape.centre));
        let angles: Vec<f64> = free
            .map(|(row, _)| smallest_angle(&row.iter().map(|&v| points[v as usize]).collect::<Vec<X>>()))
            .collect();
        let least = smallest(angles.iter().copied());
        let (constant, degrees) = (known_ratio(&specimen), least * 180.0 / PI);
        let count = angles.len();
        let what = format!(
            "smallest angle of {count} triangles, {degrees:.2} degrees, over asin(1/(2C)), C = {constant:.3}"
        );
        let quotient = least / (0.5 / constant).asin();
        figures.push(Figure::at_least(what, &specimen.name, specimen.seed, quotient, 1.0 - ROUNDING));
        let largest = ratio_of(&shapes);
        let what = "smallest angle over asin(1/(2C)), all triangles, C the largest measured";
        let at_all = run
            .cells()
            .chunks_exact(3)
            .map(|row| smallest_angle(&row.iter().map(|&v| points[v as usize]).collect::<Vec<X>>()));
        let quotient = smallest(at_all) / (0.5 / largest).asin();
        figures.push(Figure::at_least(what, &specimen.name, specimen.seed, quotient, 1.0 - ROUNDING));
    }
    Ok(figures)
}

/// Returns a lower bound on the number of caps of opening angle `alpha_0` that cover the sphere of directions: the area
/// of the sphere over the area of a cap.
fn caps(alpha_0: f64, d: usize) -> f64 {
    let half = alpha_0 / 2.0;
    if d == 2 { (PI / half).ceil() } else { (2.0 / (1.0 - half.cos())).ceil() }
}

fn alpha(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let Specimen { points, nearest2, run, d, seed, .. } = &*specimen;
        // A set without a spacing has no bound.
        let lipschitz = specimen.spacing.map_or(f64::NAN, |s| s.lipschitz);
        let shapes = shapes(points, run.cells(), *d);
        let interior: Vec<bool> = stars(points.len(), run.cells(), *d)
            .iter()
            .map(|star| star.iter().all(|&cell| specimen.is_free(&shapes[cell as usize].centre)))
            .collect();
        let (mut needed, mut at_all) = (0.0f64, 0.0f64);
        for (i, j) in edges(run.cells(), *d) {
            for (v, w) in [(i as usize, j as usize), (j as usize, i as usize)] {
                let own = (distance2(&points[v], &points[w]) / nearest2[v]).sqrt();
                at_all = at_all.max(own);
                if interior[v] {
                    needed = needed.max(own);
                }
            }
        }
        let theorem = 2.0 * (1.0 + lipschitz) / (1.0 - lipschitz);
        let constant = ratio_of(&shapes);
        let count = interior.iter().filter(|&&is| is).count();
        let what = format!("alpha needed at {count} interior vertices (C = {constant:.3})");
        let needed = if count == 0 { f64::NAN } else { needed };
        figures.push(Figure::at_most(what, &specimen.name, *seed, needed, theorem));
        let what = format!("alpha needed at all {} vertices", points.len());
        figures.push(Figure::at_most(what, &specimen.name, *seed, at_all, 1.25 * theorem));
        let alpha_0 = 0.5 * (0.5 / constant).asin();
        let step = (4.0 * constant * alpha_0.cos()).max(4.0 * constant * constant);
        let digits = caps(alpha_0, *d) * step.log10();
        let what = "digits of alpha needed, against those of the proof's D^K";
        figures.push(Figure::at_most(what, &specimen.name, *seed, at_all.log10(), digits).printed());
    }
    Ok(figures)
}

/// At every vertex, calls `f` with the vertex and each pair of its cells with free circumcentres.
fn at_vertices(specimen: &Specimen, shapes: &[CellShape], mut f: impl FnMut(usize, u32, u32)) {
    let d = specimen.d;
    for (v, mut star) in stars(specimen.points.len(), specimen.run.cells(), d).into_iter().enumerate() {
        star.retain(|&cell| specimen.is_free(&shapes[cell as usize].centre));
        for (k, &a) in star.iter().enumerate() {
            for &b in &star[..k] {
                f(v, a, b);
            }
        }
    }
}

fn radius_vectors(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let shapes = shapes(&specimen.points, specimen.run.cells(), specimen.d);
        let constant = known_ratio(&specimen);
        let alpha_0 = 0.5 * (0.5 / constant).asin();
        let (mut largest, mut narrow) = (0.0f64, 0u64);
        at_vertices(&specimen, &shapes, |v, a, b| {
            let (a, b) = (&shapes[a as usize], &shapes[b as usize]);
            let (u, w) = (minus(&a.centre, &specimen.points[v]), minus(&b.centre, &specimen.points[v]));
            let cosine = dot(&u, &w) / (a.radius * b.radius);
            if cosine > alpha_0.cos() {
                narrow += 1;
                largest = largest.max(a.radius.max(b.radius) / a.radius.min(b.radius));
            }
        });
        let degrees = alpha_0 * 180.0 / PI;
        let what = format!("largest R/r of {narrow} pairs below alpha_0 = {degrees:.1} degrees");
        let (name, seed) = (&specimen.name, specimen.seed);
        figures.push(Figure::at_most(what, name, seed, largest, 2.0 * alpha_0.cos() * (1.0 + ROUNDING)));
        figures.push(Figure::at_least("pairs below alpha_0", name, seed, narrow as f64, 1000.0));
    }
    Ok(figures)
}

fn edge_ratios(lab: &mut Lab, neighbouring: bool) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let Specimen { points, run, d, .. } = &*specimen;
        let shapes = shapes(points, run.cells(), *d);
        let constant = known_ratio(&specimen);
        let row = |cell: u32| &run.cells()[cell as usize * (d + 1)..][..d + 1];
        let (mut largest, mut checked) = (0.0f64, 0u64);
        at_vertices(&specimen, &shapes, |_, a, b| {
            if neighbouring && row(a).iter().filter(|v| row(b).contains(v)).count() < 2 {
                return;
            }
            let (x, y) = (&shapes[a as usize], &shapes[b as usize]);
            let edges = x.longest.max(y.longest) / x.shortest.min(y.shortest);
            let radii = x.radius.max(y.radius) / x.radius.min(y.radius);
            let bound = if neighbouring { 4.0 * constant * constant } else { 2.0 * constant * radii };
            (largest, checked) = (largest.max(edges / bound), checked + 1);
        });
        let of = if neighbouring { "4 C^2" } else { "(2 C R/r)" };
        let what = format!("E/e over {of}, largest of {checked} pairs, C = {constant:.3}");
        let largest = if checked == 0 { f64::NAN } else { largest };
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, largest, 1.0 + ROUNDING));
    }
    Ok(figures)
}

fn degree(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(8000, 40_000);
    let kinds = [Kind::WellSpaced, Kind::Uniform, Kind::GradedPoint, Kind::Clusters];
    let samples = kinds.iter().flat_map(|&kind| [2, 3].map(|d| Sample::new(kind, n, d)));
    let samples: Vec<Sample> = samples.collect();
    let mut figures = Vec::new();
    for specimen in lab.specimens(&samples, lab.by_extent(1, 3))? {
        for alpha in [2.0f64, 4.0].into_iter().take(4 - specimen.d) {
            let edges = pairs(&specimen.points, &specimen.nearest2, density(alpha));
            let largest = degrees(specimen.points.len(), &edges).into_iter().max();
            let bound = (2.0 * alpha * alpha + 1.0).powi(specimen.d as i32) - 1.0;
            let what = format!("largest degree, alpha = {alpha}");
            let largest = largest.map_or(f64::NAN, |most| most as f64);
            figures.push(Figure::at_most(what, &specimen.name, specimen.seed, largest, bound));
        }
    }
    Ok(figures)
}
