//! Section 2: sphere separators of overlap, density and nearest-neighbour graphs; ply and overlap of the balls.
//!
//! The separators come from runs. The measurements recompute sides, crossings, sizes and edges from points and
//! surfaces.

use std::rc::Rc;

use septet_core::Outcome;
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::result::view::{MOST_POINTS, SeparatorView};
use septet_core::spec::{Alpha, Graph, Neighbours, SeparatorSets};

use super::figure::largest;
use super::lab::{Lab, Specimen};
use super::measure::{X, degrees, density, distance2, kth_nearest2, nearest, overlap, pairs, ply};
use super::own_sets::{OwnSets, Place, place};
use super::sample::Sample;
use super::surfaces::{Tree, height, meets};
use super::{Claim, ClaimError, Figure, Reading, Role};

/// Returns `(d+1)/(d+2)`.
fn quotient(d: usize) -> f64 {
    (d + 1) as f64 / (d + 2) as f64
}

/// The epsilon of Section 4.3, step 2.
const EPSILON: f64 = 0.05;

const NO_EDGES: &str = "Edges by definition, from all pairs; surfaces and separator sets P_O are the machine's own; \
                        an edge counts if a surface separates its ends and P_O contains neither";

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "no-edges-density",
        role: Role::Test,
        statistics: None,
        source: "Definition 2.1, Section 2 (3), Section 4.3 step 2",
        statement: "no edge of the alpha-density graph joins P_I and P_E",
        reading: Reading::AsRead {
            instead: "B_O contains every ball whose alpha-fold enlargement meets the sphere",
            because: "edges are lost if B_O contains only the balls that meet the sphere without the enlargement",
        },
        experiment: NO_EDGES,
        bound: "0 edges, a theorem",
        check: |lab| no_edges(lab, Claimed::Density),
    },
    Claim {
        name: "no-edges-overlap",
        role: Role::Test,
        statistics: None,
        source: "Definition 2.1, Section 2 (3)",
        statement: "no edge of the (alpha, k)-overlap graph joins a ball of B_I with one of B_E",
        reading: Reading::AsRead {
            instead: "B_O contains every ball whose alpha-fold enlargement meets the sphere",
            because: "edges are lost if B_O contains only the balls that meet the sphere without the enlargement",
        },
        experiment: NO_EDGES,
        bound: "0 edges, a theorem",
        check: |lab| no_edges(lab, Claimed::Overlap),
    },
    Claim {
        name: "no-edges-knn",
        role: Role::Test,
        statistics: None,
        source: "Definition 2.1, Section 4.5",
        statement: "no edge of the k-nearest-neighbour graph joins P_I and P_E",
        reading: Reading::AsPrinted,
        experiment: "Edges of the graph of 12 nearest neighbours; surfaces and sets as for the density graph",
        bound: "0 edges, a theorem",
        check: |lab| no_edges(lab, Claimed::Nearest),
    },
    Claim {
        name: "separator-split",
        role: Role::Test,
        statistics: None,
        source: "Section 2 (2), Section 4.3 step 2",
        statement: "|B_I|, |B_E| <= (1 - (d+1)/(d+2) + eps) n",
        reading: Reading::AsRead {
            instead: "at most ((d+1)/(d+2) + eps) n, and every node above the leaf size is split",
            because: "two sides of a fifth cannot hold all points",
        },
        experiment: "For every node of the tree, the points on both sides of its surface; and nodes left unsplit",
        bound: "(d+1)/(d+2) + 0.05, from the separator theorem with eps = 0.05; 0 nodes left unsplit",
        check: split,
    },
    Claim {
        name: "separator-attempts",
        role: Role::Test,
        statistics: None,
        source: "Section 2",
        statement: "such a separator is found in random constant time with n processors",
        reading: Reading::AsPrinted,
        experiment: "Mean number of attempts per split, over all nodes",
        bound: "1.5: each attempt succeeds with probability at least 2/3",
        check: attempts,
    },
    Claim {
        name: "ply",
        role: Role::Illustration,
        statistics: None,
        source: "Section 2, Section 4.2",
        statement: "nearest-neighbour balls are a k-ply system for a constant k",
        reading: Reading::AsPrinted,
        experiment: "Balls that contain a location in their interior, for locations at half of the radius of a ball \
                     and just inside its boundary",
        bound: "5 in the plane, 12 in space: from a common location, any two centres are more than 60 degrees apart",
        check: plies,
    },
    Claim {
        name: "overlap",
        role: Role::Illustration,
        statistics: None,
        source: "Section 2, Section 4.4",
        statement: "the alpha-fold enlargement of a ball meets a bounded number of balls that are not smaller",
        reading: Reading::AsPrinted,
        experiment: "Neighbours of a ball in the alpha-overlap graph whose radius is not smaller; the maximum over all balls",
        bound: "ply (alpha + 2)^d: each contains a ball of the smaller radius within alpha + 2 radii",
        check: overlaps,
    },
];

/// Returns sets of all kinds, because the separator theorem makes no assumption about the points.
fn sampled(lab: &mut Lab) -> Result<Vec<(Sample, Rc<Specimen>)>, ClaimError> {
    // For the full extent, this is the largest set for which the picture of a run shows every point.
    let n = lab.size(8000, 20_000);
    let kinds = [Kind::WellSpaced, Kind::Uniform, Kind::GradedPoint, Kind::Clusters];
    let samples = kinds.iter().flat_map(|&kind| [2, 3].map(|d| Sample::new(kind, n, d)));
    let samples: Vec<Sample> = samples.collect();
    let mut all = Vec::new();
    for sample in samples {
        for seed in lab.seeds(lab.by_extent(1, 3)) {
            all.push((sample, lab.specimen(sample, seed)?));
        }
    }
    Ok(all)
}

fn specimens(lab: &mut Lab) -> Result<Vec<Rc<Specimen>>, ClaimError> {
    Ok(sampled(lab)?.into_iter().map(|(_, specimen)| specimen).collect())
}

/// The graph of a claim.
#[derive(Clone, Copy)]
enum Claimed {
    Density,
    Overlap,
    Nearest,
}

/// k of the nearest-neighbour graph.
const NEAREST: usize = 12;

/// alpha of the overlap graph.
const OVERLAP: f64 = 2.0;

/// Runs the machine on the points of the specimen with this graph. The picture of the run shows all points.
fn with_graph(lab: &mut Lab, of: &(Sample, Rc<Specimen>), graph: Claimed) -> Result<Outcome, ClaimError> {
    let seen = |spec: Spec| {
        spec.with(|c| {
            c.recursion.sets = SeparatorSets::Both;
            c.keep.view = Some(MOST_POINTS);
            c.keep.sets = true;
        })
    };
    let (sample, seed) = (of.0, of.1.seed);
    let with = |graph: Graph| move |spec: Spec| seen(spec).with(|c| c.recursion.graph = graph);
    match graph {
        Claimed::Density => lab.run(sample, seed, seen),
        Claimed::Overlap => {
            lab.run(sample, seed, with(Graph::Overlap { alpha: Alpha::Value(OVERLAP), k: Neighbours::Auto }))
        }
        Claimed::Nearest => lab.run(sample, seed, with(Graph::Knn { k: Neighbours::Count(NEAREST as u32) })),
    }
}

fn no_edges(lab: &mut Lab, graph: Claimed) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    let (mut all_parted, first_seed) = (0, lab.seed());
    for of in sampled(lab)? {
        let run = with_graph(lab, &of, graph)?;
        let specimen = &of.1;
        let (points, nearest2) = (&specimen.points, &specimen.nearest2);
        let (edges, own) = match graph {
            Claimed::Density => (pairs(points, nearest2, density(specimen.alpha)), Some(nearest2)),
            Claimed::Overlap => (pairs(points, nearest2, overlap(OVERLAP)), Some(nearest2)),
            Claimed::Nearest => (pairs(points, &kth_nearest2(points, NEAREST), nearest()), None),
        };
        let tree = Tree::of_run(&run, points);
        let parted: Vec<(usize, usize, &SeparatorView)> =
            edges.iter().filter_map(|&(i, j)| Some((i as usize, j as usize, tree.parting(i, j)?))).collect();
        let sets = OwnSets(run.kept.sets.as_deref().unwrap_or_default()).nodes(points.len());
        let of = |v: usize, s: &SeparatorView| place(&sets[v], s.node);
        let divided: Vec<_> = parted
            .iter()
            .filter(|(i, j, s)| of(*i, s) != Place::Undivided && of(*j, s) != Place::Undivided)
            .collect();
        let lost = divided
            .iter()
            .filter(|(i, j, s)| of(*i, s) == Place::OneSide && of(*j, s) == Place::OneSide)
            .count() as f64;
        let what = format!("edges from P_I to P_E, of {} that a surface separates", divided.len());
        let (name, seed) = (&specimen.name, specimen.seed);
        figures.push(Figure::at_most(what, name, seed, lost, 0.0));
        all_parted += divided.len();
        if let Some(radii2) = own {
            let free = |v: usize, s: &SeparatorView| !meets(s, &points[v], radii2[v].sqrt());
            let lost = parted.iter().filter(|&&(i, j, s)| free(i, s) && free(j, s)).count();
            let what = "edges from P_I to P_E, with the balls themselves";
            figures.push(Figure::at_most(what, name, seed, lost as f64, 0.0).printed());
        }
    }
    let what = "edges whose ends a surface separates; the claim needs at least this many";
    figures.push(Figure::at_least(what, "all sets", first_seed, all_parted as f64, 1000.0));
    Ok(figures)
}

fn split(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let tree = Tree::of(&specimen);
        let (points, d) = (&specimen.points, specimen.d);
        let larger = |(separator, members): &(&SeparatorView, Vec<u32>)| {
            let inside = members.iter().filter(|&&i| height(separator, &points[i as usize]) < 0.0).count();
            inside.max(members.len() - inside) as f64 / members.len().max(1) as f64
        };
        let most = largest(tree.nodes.iter().map(larger));
        let (name, seed) = (&specimen.name, specimen.seed);
        let what = format!("larger side of {} splits", tree.nodes.len());
        figures.push(Figure::at_most(&*what, name, seed, most, quotient(d) + EPSILON));
        let nodes = specimen.run.ledger.part.nodes.values();
        let unsplit = nodes.filter(|f| f.is_leaf() && f.population > specimen.run.settled.leaf).count();
        figures.push(Figure::at_most(
            "nodes above the leaf size left unsplit",
            name,
            seed,
            unsplit as f64,
            0.0,
        ));
        figures.push(Figure::at_most(what, name, seed, most, 1.0 - quotient(d) + EPSILON).printed());
    }
    Ok(figures)
}

fn attempts(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let nodes = specimen.run.ledger.part.nodes.values().filter(|f| f.attempts > 0);
        let (sum, tried) = nodes.fold((0, 0u32), |(sum, count), f| (sum + f.attempts, count + 1));
        let mean = sum as f64 / f64::from(tried);
        let what = format!("attempts per separator, mean of {tried}");
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, mean, 1.5));
    }
    Ok(figures)
}

/// Returns the bound on the ply: the largest number of directions with pairwise angles above 60 degrees.
fn most_ply(d: usize) -> f64 {
    if d == 2 { 5.0 } else { 12.0 }
}

fn plies(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let Specimen { points, nearest2, d, .. } = &*specimen;
        // The locations lie in the ball of a point, in the direction of another point: at half of its radius, and just
        // inside its boundary.
        let places = points.iter().zip(nearest2).enumerate().flat_map(|(i, (p, r2))| {
            let other = &points[(i * 7919 + 1) % points.len()];
            let length = distance2(p, other).sqrt().max(f64::MIN_POSITIVE);
            [0.5, 0.999].map(|share| {
                let step = share * r2.sqrt() / length;
                [0, 1, 2].map(|axis| p[axis] + step * (other[axis] - p[axis]))
            })
        });
        let places: Vec<X> = places.collect();
        let most = ply(points, nearest2, &places) as f64;
        let what = format!("balls that contain a location, maximum over {} locations", places.len());
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, most, most_ply(*d)));
    }
    Ok(figures)
}

fn overlaps(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let alpha = 2.0;
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let (points, radii2) = (&specimen.points, &specimen.nearest2);
        let edges = pairs(points, radii2, overlap(alpha));
        let mut larger = vec![0u64; points.len()];
        for &(i, j) in &edges {
            let (a, b) = (radii2[i as usize], radii2[j as usize]);
            larger[i as usize] += u64::from(a <= b);
            larger[j as usize] += u64::from(b <= a);
        }
        let most = larger.iter().max().map_or(f64::NAN, |&most| most as f64);
        let largest = degrees(points.len(), &edges).into_iter().max().unwrap_or(0);
        let what = format!(
            "balls that are not smaller and meet an alpha-fold ball, alpha = 2 (largest degree {largest})"
        );
        let bound = most_ply(specimen.d) * (alpha + 2.0).powi(specimen.d as i32);
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, most, bound));
    }
    Ok(figures)
}
