//! Section 4.5: random points.

use septet_workers::config::cores::map;

use crate::experiment::{Line, of_run};
use septet_core::generate::Kind;
use septet_core::spec::{Graph, Neighbours};

use super::lab::{Lab, Specimen};
use super::measure::{distance2, edges, shapes, stars};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "random-neighbours",
        role: Role::Test,
        statistics: None,
        source: "Section 4.5",
        statement: "with high probability DT(P) is a subgraph of the (c log n)-nearest-neighbour graph",
        reading: Reading::AsRead {
            instead: "the edges at vertices whose circumspheres lie in the domain are, with c = 14 in space and 7 in the plane",
            because: "hull edges of a finite set join points of any rank",
        },
        experiment: "Poisson sets; the smaller of the two ranks of an edge over ln n, maximal over the edges: at interior \
                     vertices, and as printed at all vertices",
        bound: "14 in space and 7 in the plane: 10.9 and 4.8 measured up to n = 10^6",
        check: neighbours,
    },
    Claim {
        name: "random-depth",
        role: Role::Test,
        statistics: None,
        source: "Section 4.5",
        statement: "DT(P) of n random points takes O(log^(d/2) n) time with n processors",
        reading: Reading::AsPrinted,
        experiment: "Depth of the local hulls over log2(n)^(d/2), with ceil(10 ln n) neighbours, in the plane 5 ln n: the value \
                     at the largest size over the value at the smallest",
        bound: "1.15: hulls of c log n points by vector steps take O(log n)",
        check: depth,
    },
];

fn neighbours(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let sizes = lab.by_extent(&[1000, 4000, 16_000][..], &[1000, 4000, 16_000, 64_000]);
    let mut figures = Vec::new();
    for (d, most) in [(2, 7.0), (3, 14.0)] {
        for &n in sizes {
            let specimen = lab.specimen(Sample::new(Kind::Poisson, n, d), lab.seed())?;
            let (interior, all) = ranks(&specimen);
            let (log, name, seed) = ((specimen.points.len() as f64).ln(), &specimen.name, specimen.seed);
            let what = format!("rank of a neighbour over ln n at interior vertices (rank {interior})");
            figures.push(Figure::at_most(what, name, seed, interior as f64 / log, most));
            let what = format!("rank of a neighbour over ln n at all vertices (rank {all})");
            figures.push(Figure::at_most(what, name, seed, all as f64 / log, most).printed());
        }
    }
    Ok(figures)
}

/// For each edge, ranks either end among all points by the distance from the other end, and takes the smaller of both
/// ranks. Returns the maximum over the edges with an interior end, and over all edges. The circumspheres of all cells
/// at an interior vertex lie in the unit square or cube.
fn ranks(specimen: &Specimen) -> (u64, u64) {
    let Specimen { points, run, d, .. } = specimen;
    let shapes = shapes(points, run.cells(), *d);
    let within = |cell: u32| {
        let shape = &shapes[cell as usize];
        shape.centre[..*d].iter().all(|x| x - shape.radius >= 0.0 && x + shape.radius <= 1.0)
    };
    let interior: Vec<bool> = stars(points.len(), run.cells(), *d)
        .iter()
        .map(|star| star.iter().all(|&cell| within(cell)))
        .collect();
    let rank = |from: u64, to: u64| {
        let (p, reach) = (&points[from as usize], distance2(&points[from as usize], &points[to as usize]));
        // The count includes the point `p` itself but not the neighbour, so it is the neighbour's rank.
        points.iter().filter(|q| distance2(p, q) < reach).count() as u64
    };
    let of = |&(i, j): &(u64, u64)| {
        let smaller = rank(i, j).min(rank(j, i));
        let inside = interior[i as usize] || interior[j as usize];
        (if inside { smaller } else { 0 }, smaller)
    };
    let larger = |a: (u64, u64), b: (u64, u64)| (a.0.max(b.0), a.1.max(b.1));
    map(&edges(run.cells(), *d), of).into_iter().fold((0, 0), larger)
}

fn depth(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let sizes = lab.by_extent(&[1000u64, 4000, 16_000][..], &[1000, 4000, 16_000, 64_000, 256_000]);
    let seeds = lab.by_extent(2, 5);
    let mut figures = Vec::new();
    for (d, c) in [(2, 5.0), (3, 10.0)] {
        let mut means = Vec::new();
        for &n in sizes {
            let mut sum = 0.0;
            for seed in lab.seeds(seeds) {
                let run = lab.run(Sample::new(Kind::Poisson, n, d), seed, |spec| {
                    spec.with(|spec| {
                        spec.recursion.graph = Graph::Knn { k: Neighbours::Log(c) };
                    })
                })?;
                let line: Line = of_run(&run);
                let depth = line.phase("hulls").map_or(f64::NAN, |p| p.total.depth as f64);
                sum += depth / (line.n as f64).log2().powf(d as f64 / 2.0);
            }
            means.push(sum / seeds as f64);
        }
        let (first, last) = (means[0], means[means.len() - 1]);
        let what = format!("depth of the hulls over log2(n)^(d/2): {last:.1} over {first:.1}");
        let on = format!("poisson {d}D n={}..{}", sizes[0], sizes[sizes.len() - 1]);
        figures.push(Figure::at_most(what, on, lab.seed(), last / first, 1.15));
    }
    Ok(figures)
}
