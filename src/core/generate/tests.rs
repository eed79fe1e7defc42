//! Determinism, counts, spacing, completion and quality of the generated sets.

use septet_geometry::incremental::{Incremental, facet_without};
use septet_geometry::measure::{circumcentre, shortest_edge2};
use septet_geometry::point::{Point, Simplex, dist2};
use septet_geometry::range::Digits;

use super::sizing::Sizing;
use super::*;

/// The measured quantities of the theorems.
#[derive(Debug, Default)]
struct Quality {
    /// The number of cells with centres farther than `f/(1-L)` from the boundary.
    free: usize,
    /// The largest `R / f(c)` over these cells, and over all.
    gap: [f64; 2],
    /// The largest radius-edge ratio over these cells, and over all.
    ratio: [f64; 2],
    /// The largest `|uv| / min(nn_u, nn_v)` over Delaunay edges.
    alpha: f64,
    /// The largest distance of a centre outside the domain.
    outside: f64,
    /// The largest depth of a point in the smallest ball of a hull face, relative to its radius.
    depth: f64,
}

fn quality<P: Point>(points: &[P], sizing: &Sizing) -> Quality {
    let dt = Incremental::new(points.to_vec()).unwrap();
    let mut nearest = vec![f64::MAX; points.len()];
    let mut out = Quality::default();
    for pass in 0..2 {
        for cell in dt.complex().live_cells() {
            if let Some(slot) = dt.complex().infinite_slot(cell) {
                if pass == 0 {
                    let face =
                        facet_without::<P>(dt.complex().cell(cell), dt.complex().cell(cell).as_ref()[slot]);
                    out.depth = out.depth.max(depth(points, face.as_ref()));
                }
                continue;
            }
            for_edges::<P>(points, dt.complex().cell(cell), |u, v, length| {
                if pass == 0 {
                    nearest[u] = nearest[u].min(length);
                    nearest[v] = nearest[v].min(length);
                } else {
                    out.alpha = out.alpha.max(length / nearest[u].min(nearest[v]));
                }
            });
            if pass == 0 {
                out.add(&dt.corners(cell)[..P::Cell::LEN], sizing);
            }
        }
    }
    out
}

fn for_edges<P: Point>(points: &[P], cell: &P::Cell, mut visit: impl FnMut(usize, usize, f64)) {
    for (i, &u) in cell.as_ref().iter().enumerate() {
        for &v in &cell.as_ref()[..i] {
            let (u, v) = (u as usize, v as usize);
            visit(u, v, dist2(points[u], points[v]).sqrt());
        }
    }
}

/// Returns the depth of a point in the smallest ball through a hull face, relative to its radius.
fn depth<P: Point>(points: &[P], face: &[u32]) -> f64 {
    let at = |i: usize| points[face[i] as usize];
    let (u, v) = (at(1) - at(0), at(P::DIM - 1) - at(0));
    let (uu, vv, uv) = (u.norm2(), v.norm2(), u.dot(v));
    let offset = if P::DIM == 2 {
        u * 0.5
    } else {
        u * (vv * (uu - uv) / (2.0 * (uu * vv - uv * uv)))
            + v * (uu * (vv - uv) / (2.0 * (uu * vv - uv * uv)))
    };
    let (centre, radius) = (at(0) + offset, offset.norm2().sqrt());
    points.iter().map(|&p| 1.0 - dist2(p, centre).sqrt() / radius).fold(0.0, f64::max)
}

impl Quality {
    fn add<P: Point>(&mut self, corners: &[P], sizing: &Sizing) {
        let centre = circumcentre(corners);
        let radius = dist2(centre, corners[0]).sqrt();
        let ratio = radius / shortest_edge2(corners).sqrt();
        let inside = (0..P::DIM).map(|i| centre.coord(i).min(1.0 - centre.coord(i))).fold(1.0, f64::min);
        self.outside = self.outside.max(-inside);
        let gap = radius / sizing.at(&centre);
        let free = inside > sizing.at(&centre) / (1.0 - sizing.slope);
        self.free += usize::from(free);
        for all in usize::from(!free)..2 {
            self.gap[all] = self.gap[all].max(gap);
            self.ratio[all] = self.ratio[all].max(ratio);
        }
    }
}

fn request(kind: Kind, n: u64, dimension: usize, lipschitz: Option<f64>) -> Request {
    Request { kind, n, dimension, seed: 1, lipschitz, ratio: None }
}

fn made(request: &Request) -> Generated {
    generate(request, &mut |_, _, _| {}).unwrap()
}

/// Checks spacing, completion and quality of the set of a request. Returns its number of points.
fn check_spaced<P: unit::Unit>(request: &Request) -> usize {
    let found = search::spaced_set::<P>(request, &mut |_, _, _| {}).unwrap();
    let (points, sizing) = (found.points, found.sizing);
    for (i, p) in points.iter().enumerate() {
        assert!((0..P::DIM).all(|i| (0.0..=1.0).contains(&p.coord(i))));
        for q in &points[..i] {
            let apart = sizing.at(p).min(sizing.at(q));
            assert!(dist2(*p, *q) >= apart * apart, "{p:?} {q:?} {apart}");
        }
    }
    let slope = sizing.slope;
    let q = quality(&points, &sizing);
    let what = format!("{request:?}: {} points, {q:?}", points.len());
    let g = std::f64::consts::SQRT_2 / (1.0 - slope);
    assert!(q.free > 0 || points.len() < 500, "{what}");
    assert!(q.depth <= 1e-9 && q.outside <= 1e-9, "{what}");
    assert!(q.gap[0] <= 1.0 && q.gap[1] <= g, "{what}");
    assert!(q.ratio[0] <= 1.0 / (1.0 - slope), "{what}");
    assert!(g * slope >= 1.0 || q.ratio[1] <= g / (1.0 - g * slope), "{what}");
    assert!(q.alpha <= 2.5 * (1.0 + slope) / (1.0 - slope), "{what}");
    points.len()
}

#[test]
fn well_spaced_sets_are_spaced_complete_and_well_shaped() {
    for n in [9, 100, 1000, 3000] {
        let request = request(Kind::WellSpaced, n, 3, None);
        let count = check_spaced::<DVec3>(&request) as f64;
        assert!(n < 1000 || (count / n as f64 - 1.0).abs() <= 0.05);
        let count = check_spaced::<DVec2>(&request) as f64;
        assert!(n < 1000 || (count / n as f64 - 1.0).abs() <= 0.05);
    }
}

#[test]
fn graded_sets_are_spaced_complete_and_well_shaped() {
    for kind in [Kind::GradedPoint, Kind::GradedLine] {
        for lipschitz in [0.06, 0.25, 0.5] {
            let request = request(kind, 1500, 3, Some(lipschitz));
            let count = check_spaced::<DVec3>(&request) as f64;
            assert!((count / 1500.0 - 1.0).abs() <= 0.05, "{kind} {lipschitz}: {count}");
            let count = check_spaced::<DVec2>(&request) as f64;
            assert!((count / 1500.0 - 1.0).abs() <= 0.05, "{kind} {lipschitz}: {count}");
        }
    }
}

#[test]
fn larger_spaced_sets_have_the_requested_number() {
    for kind in [Kind::WellSpaced, Kind::GradedPoint, Kind::GradedLine] {
        let set = made(&request(kind, 50_000, 3, None));
        let count = set.points.len() as f64;
        assert!((count / 50_000.0 - 1.0).abs() <= 0.05, "{kind}: {count}");
        let spacing = set.spacing.unwrap();
        assert!(spacing.lipschitz <= 0.25);
        // Only the set graded to a point cannot have that many points at the requested slope.
        assert_eq!(set.notes.is_empty(), kind != Kind::GradedPoint, "{:?}", set.notes);
    }
}

#[test]
fn every_kind_is_repeatable_and_inside_its_cube() {
    for kind in Kind::all() {
        for dimension in [2, 3] {
            let ask = request(kind, 700, dimension, None);
            let set = made(&ask);
            assert_eq!(set, made(&ask), "{kind}");
            assert_eq!(set.points.dimension(), dimension);
            let inside = if kind == Kind::Shells { -0.5..=0.5 } else { 0.0..=1.0 };
            assert!(set.points.coordinates().iter().all(|x| inside.contains(x)), "{kind}");
            let count = set.points.len() as f64;
            assert!((count / 700.0 - 1.0).abs() < 0.35, "{kind}: {count}");
            let seeded = !matches!(kind, Kind::Grid | Kind::Fcc | Kind::MomentCurve);
            let other = made(&Request { seed: 2, ..ask });
            assert_eq!(set.points != other.points, seeded, "{kind}");
            let none = made(&Request { n: 0, ..ask });
            assert!(none.points.is_empty(), "{kind}");
            let one = made(&Request { n: 1, ..ask });
            // A shell has 24 points.
            let may_be_empty = matches!(kind, Kind::Poisson | Kind::Shells);
            assert!(!one.points.is_empty() || may_be_empty, "{kind}");
            assert_eq!(kind.name().parse::<Kind>().unwrap(), kind);
        }
    }
}

/// The rows of any cut are those of the whole set, bit for bit.
#[test]
fn rows_are_generated_separately() {
    let separate = [
        Kind::Uniform,
        Kind::Poisson,
        Kind::Grid,
        Kind::Fcc,
        Kind::Jittered,
        Kind::Clusters,
        Kind::Slab,
        Kind::MomentCurve,
    ];
    let bits = |points: &Points| points.coordinates().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for kind in Kind::all() {
        let usual = [2, 3].into_iter().flat_map(|d| [0, 1, 2, 9, 40, 700].map(|n| (d, n)));
        let higher = if kind.is_of_any_dimension() { &[(4, 40), (5, 9), (6, 40)][..] } else { &[] };
        for (dimension, n) in usual.chain(higher.iter().copied()) {
            let ask = Request { seed: n + 5, ..request(kind, n, dimension, None) };
            let found = SeparateRows::of(&ask).unwrap();
            assert_eq!(found.is_some(), separate.contains(&kind), "{kind}");
            let Some(rows) = found else { continue };
            let whole = made(&ask);
            let (count, what) = (rows.count(), format!("{kind}:{n},d={dimension}"));
            assert_eq!((count, rows.notes(&ask)), (whole.points.len() as u64, whole.notes), "{what}");
            for parts in [1, 2, 3, 5, 8, count.max(1)] {
                let cut = |part: u64| count * part / parts;
                let joined: Vec<u64> =
                    (0..parts).flat_map(|part| bits(&rows.points(cut(part)..cut(part + 1)))).collect();
                assert!(joined == bits(&whole.points), "{what} in {parts} parts");
            }
            assert!(rows.points(count..count + 3).is_empty(), "{what}");
            assert_eq!(bits(&rows.points(0..u64::MAX)), bits(&whole.points), "{what}");
        }
    }
}

#[test]
fn lattices_are_exact() {
    let grid = made(&request(Kind::Grid, 1000, 3, None));
    assert_eq!((grid.points.len(), grid.notes.len()), (1000, 0));
    assert!(grid.points.coordinates().iter().all(|x| (x * 16.0).fract() == 0.0));
    let near = made(&request(Kind::Grid, 30, 3, None));
    assert_eq!((near.points.len(), near.notes.len()), (27, 1));
    let Points::Space(fcc) = made(&request(Kind::Fcc, 2048, 3, None)).points else {
        panic!("not in space");
    };
    assert_eq!(fcc.len(), 2048);
    let nearest = |p: &DVec3| {
        let others = fcc.iter().filter(|q| *q != p);
        others.map(|q| dist2(*p, *q)).fold(f64::MAX, f64::min)
    };
    assert!(fcc.iter().all(|p| nearest(p) == 2.0 / 256.0));
    let Points::Space(curve) = made(&request(Kind::MomentCurve, 100, 3, None)).points else {
        panic!("not in space");
    };
    assert_eq!(curve[64], DVec3::new(0.5, 0.25, 0.125));
    let dt = Incremental::new(curve).unwrap();
    // Every two points of the curve are neighbours, so each point has n - 1 neighbours.
    let mut star = Vec::new();
    dt.star(50, &mut star);
    let mut around: Vec<u32> = star.iter().flat_map(|&cell| *dt.complex().cell(cell)).collect();
    around.sort_unstable();
    around.dedup();
    assert!(around.len() >= 100);
}

#[test]
fn samples_are_parsed() {
    let read = |spec| parse_sample(spec).unwrap();
    let plain = Request { seed: 0, ..request(Kind::Uniform, 1000, 3, None) };
    assert_eq!(read("uniform:1000"), plain);
    let full = Request { seed: 7, ..request(Kind::GradedPoint, 1_000_000, 2, Some(0.5)) };
    assert_eq!(read("graded:1e6,d=2,seed=7,lipschitz=0.5"), full);
    assert_eq!(read("graded-point:1e6, d=2,seed=7 ,lipschitz=0.5"), full);
    let message = |spec| parse_sample(spec).unwrap_err().to_string();
    let unknown = parse_sample("cube:10").unwrap_err();
    assert_eq!(unknown.to_string(), "unknown kind of point set `cube`");
    assert!(unknown.remedy().unwrap().to_string().contains("moment-curve"));
    assert!(message("uniform").contains("KIND:N"));
    assert!(message("uniform:many").contains("`many`"));
    assert!(message("uniform:1e30").contains("`1e30`"));
    assert!(message("uniform:10,d").contains("KEY=VALUE"));
    assert!(message("uniform:10,d=x").contains("`x`"));
    assert!(message("uniform:10,size=3").contains("`size`"));
}

#[test]
fn impossible_requests_are_rejected() {
    let refusal = |request: Request| generate(&request, &mut |_, _, _| {}).unwrap_err();
    let dimension = refusal(request(Kind::Uniform, 10, 7, None));
    assert!(matches!(dimension, GenerateError::Dimension(7)));
    for kind in Kind::all() {
        for dimension in 4..=6 {
            let ask = request(kind, 60, dimension, None);
            if kind.is_of_any_dimension() {
                let set = made(&ask);
                assert_eq!(set.points.dimension(), dimension, "{kind}");
                assert!(set.points.coordinates().iter().all(|x| (0.0..=1.0).contains(x)), "{kind}");
            } else {
                assert!(matches!(refusal(ask), GenerateError::KindOfSpace { .. }), "{kind}");
            }
        }
    }
    for constant in [0.0, 1.0, -0.5, 2.0, f64::NAN] {
        let refused = refusal(request(Kind::GradedLine, 10, 3, Some(constant)));
        assert!(matches!(refused, GenerateError::Lipschitz(_)));
    }
    let unused = refusal(request(Kind::Grid, 10, 3, Some(0.5)));
    assert!(matches!(unused, GenerateError::LipschitzUnused(Kind::Grid)));
    let many = refusal(request(Kind::MomentCurve, 1 << 20, 3, None));
    assert!(matches!(many, GenerateError::TooMany { limit: 131_072, .. }));
}

#[test]
fn shells_have_24_points_and_radii_of_one_ratio() {
    let Points::Space(points) = made(&request(Kind::Shells, 2400, 3, None)).points else {
        panic!("not in space");
    };
    assert_eq!(points.len(), 2400);
    let radius = |p: &DVec3| p.length();
    for (i, shell) in points.chunks_exact(24).enumerate() {
        let expected = 0.5 / SHELL_RATIO.powi(i32::try_from(i).unwrap());
        assert!(shell.iter().all(|p| (radius(p) / expected - 1.0).abs() < 1e-12), "shell {i}");
    }
    let flat = made(&Request { ratio: Some(2.0), ..request(Kind::Shells, 100, 2, None) });
    assert_eq!((flat.points.len(), flat.notes.len()), (96, 1));
    let Points::Plane(flat) = flat.points else { panic!("not in the plane") };
    assert!((flat[95].length() - 0.0625).abs() < 1e-14);
}

/// The largest set has exact signs, and one more shell is refused with the largest number of points.
#[test]
fn shells_end_with_the_exact_range() {
    for (dimension, ratio, most) in [(3, 1.3, 900), (2, 1.3, 900), (3, 2.0, 341), (2, 16.0, 85)] {
        let ask = Request { ratio: Some(ratio), ..request(Kind::Shells, 24 * most, dimension, None) };
        let exact = match made(&ask).points {
            Points::Plane(points) => Digits::of(&points).unwrap().exponent(&points).is_ok(),
            Points::Space(points) => Digits::of(&points).unwrap().exponent(&points).is_ok(),
            Points::Higher(_) => unreachable!("shells are in space"),
        };
        assert!(exact, "{ratio}");
        let more = generate(&Request { n: 24 * most + 1, ..ask }, &mut |_, _, _| {}).unwrap_err();
        assert!(matches!(more, GenerateError::TooManyShells { limit, .. } if limit == 24 * most), "{more}");
        assert!(more.to_string().contains(&format!("at most {} points", 24 * most)), "{more}");
    }
}

#[test]
fn impossible_ratios_are_rejected() {
    let refusal = |request: Request| generate(&request, &mut |_, _, _| {}).unwrap_err();
    for ratio in [1.0, 0.5, -2.0, f64::INFINITY, f64::NAN] {
        let refused = refusal(Request { ratio: Some(ratio), ..request(Kind::Shells, 48, 3, None) });
        assert!(matches!(refused, GenerateError::Ratio(_)), "{ratio}");
    }
    let unused = refusal(Request { ratio: Some(1.5), ..request(Kind::Grid, 48, 3, None) });
    assert!(matches!(unused, GenerateError::RatioUnused(Kind::Grid)));
    assert_eq!(parse_sample("shells:48,ratio=1.5").unwrap().ratio, Some(1.5));
}
