use crate::point::Point;
use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::cost::{Cost, ceil_log2};

/// Number of great circles in a draw.
const TRIES: u32 = 10;

fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * (f64::EPSILON / 2.0)
}

fn vector<P: Point>(mut coord: impl FnMut(usize) -> f64) -> P {
    let mut p = P::splat(0.0);
    for i in 0..P::DIM {
        p.set_coord(i, coord(i));
    }
    p
}

pub(super) fn uniform<P: Point>(n: usize, seed: u64) -> Vec<P> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| vector(|_| unit(&mut rng))).collect()
}

fn grid<P: Point>(side: usize) -> Vec<P> {
    (0..side.pow(P::DIM as u32)).map(|k| vector(|i| (k / side.pow(i as u32) % side) as f64)).collect()
}

pub(super) fn key(seed: u64) -> DrawKey {
    DrawKey { seed, node: 7, attempt: 0 }
}

fn draw_at<P: Point>(key: DrawKey, points: &[P]) -> Drawn<P> {
    let n = points.len() as u64;
    let sampler = Sampler::new(key, n, 400);
    let samples: Vec<P> = points.iter().copied().filter(|&x| sampler.accepts(x)).collect();
    draw(key, n, TRIES, &samples, &mut Cost::default())
}

pub(super) fn ratio<P: Point>(s: &Separator<P>, points: &[P]) -> f64 {
    let inside = points.iter().filter(|&&x| s.side(x) == Side::Interior).count();
    inside.max(points.len() - inside) as f64 / points.len() as f64
}

/// Nearest-neighbour distances by all pairs.
fn nearest<P: Point>(points: &[P]) -> Vec<f64> {
    points
        .iter()
        .map(|&p| {
            let d = points.iter().map(|&q| crate::point::dist2(p, q)).filter(|&d| d > 0.0);
            d.fold(f64::INFINITY, f64::min).sqrt()
        })
        .collect()
}

fn split_ratios<P: Point>(bound: f64) {
    let points = uniform::<P>(10_000, 1);
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for seed in 0..200 {
        let drawn = draw_at(key(seed), &points);
        assert_eq!(drawn.kind, DrawKind::Sphere);
        assert_eq!(drawn.means, 0);
        let r = ratio(&drawn.separator.unwrap(), &points);
        sum += r;
        worst = worst.max(r);
    }
    println!("dim {}: mean {:.4} max {worst:.4}", P::DIM, sum / 200.0);
    assert!(worst <= bound && sum / 200.0 <= 0.62);
}

#[test]
fn uniform_points_split_evenly() {
    split_ratios::<DVec2>(0.80);
    split_ratios::<DVec3>(0.85);
}

fn separator_sizes<P: Point>(name: &str, points: &[P]) {
    let radii = nearest(points);
    let n = points.len() as f64;
    let unit = n / if P::DIM == 2 { n.sqrt() } else { n.cbrt() };
    let (mut sums, mut worst, mut estimates) = ([0.0; 2], [0.0_f64; 2], 0.0);
    for seed in 0..50 {
        let drawn = draw_at(key(seed), points);
        let s = drawn.separator.unwrap();
        estimates += drawn.estimated_crossing * n / unit / 50.0;
        for (slot, alpha) in [1.0, 2.5].into_iter().enumerate() {
            let across = points.iter().zip(&radii).filter(|&(&x, r)| s.crosses(x, alpha * r)).count();
            let size = across as f64 / (alpha * unit);
            assert!(size <= 5.0, "{name}: {size}");
            sums[slot] += size / 50.0;
            worst[slot] = worst[slot].max(size);
        }
    }
    println!("{name} dim {}: mean {sums:.2?} max {worst:.2?} (estimate {estimates:.2})", P::DIM);
    assert!((0.4..2.5).contains(&(estimates / sums[0])));
}

#[test]
fn separator_sets_are_small() {
    separator_sizes("uniform", &uniform::<DVec2>(4096, 3));
    separator_sizes("uniform", &uniform::<DVec3>(4096, 3));
    separator_sizes("grid", &grid::<DVec2>(64));
    separator_sizes("grid", &grid::<DVec3>(16));
}

/// Sample sets that defeat a naive choice of separators.
pub(super) fn nasty<P: Point>() -> Vec<(&'static str, Vec<P>)> {
    let base = uniform::<P>(400, 5);
    let map = |f: &dyn Fn(usize, f64) -> f64| -> Vec<P> {
        base.iter().map(|p| vector(|i| f(i, p.coord(i)))).collect()
    };
    let line: Vec<P> = base.iter().map(|p| vector(|i| (i as f64 + 1.0) * p.coord(0))).collect();
    let clusters = (0..400).map(|k| base[k] * 1e-9 + base[k % 7]).collect();
    let graded = base.iter().map(|&p| p * (p.norm2() * p.norm2() * p.norm2())).collect();
    let circle = base.iter().map(|&p| (p - P::splat(0.5)) / (p - P::splat(0.5)).norm2().sqrt()).collect();
    vec![
        ("uniform", base.clone()),
        ("grid", grid::<P>(if P::DIM == 2 { 20 } else { 7 })),
        ("flat", map(&|i, x| if i + 1 == P::DIM { 3.0 } else { x })),
        ("axis", map(&|i, x| if i == 0 { x } else { 0.25 })),
        ("line", line),
        ("clusters", clusters),
        ("graded", graded),
        ("circle", circle),
        ("far", map(&|_, x| x + 1e9)),
        ("tiny", map(&|_, x| x * 1e-120)),
        ("huge", map(&|_, x| x * 1e120)),
        ("thin", map(&|i, x| if i == 0 { x * 1e12 } else { x })),
        ("mixed", map(&|i, x| if i == 0 { x * 1e60 } else { x * 1e-60 })),
        ("two", base[..2].to_vec()),
        ("three", base[..3].to_vec()),
        ("doubled", base.iter().chain(&base).copied().collect()),
        ("heavy", base.iter().enumerate().map(|(k, &p)| if k < 300 { base[0] } else { p }).collect()),
    ]
}

fn nasty_sets_split<P: Point>() {
    for (name, points) in nasty::<P>() {
        let mut planes = 0;
        let mut worst = 0.0_f64;
        for seed in 0..20 {
            let drawn = draw(key(seed), 1 << 20, TRIES, &points, &mut Cost::default());
            let s = drawn.separator.unwrap();
            planes += usize::from(drawn.kind != DrawKind::Sphere);
            worst = worst.max(ratio(&s, &points));
            assert_eq!(ratio(&s, &points), drawn.estimated_ratio, "{name}");
            assert_eq!(Separator::from_array(s.to_array().as_ref()), Some(s), "{name}");
        }
        println!("{name} dim {}: worst {worst:.3}, planes {planes} of 20", P::DIM);
        assert!(worst <= split_bound::<P>(), "{name}: {worst}");
    }
}

#[test]
fn nasty_sets_are_split() {
    nasty_sets_split::<DVec2>();
    nasty_sets_split::<DVec3>();
}

#[test]
fn coincident_samples_have_no_separator() {
    let drawn = draw(key(1), 9, TRIES, &[DVec3::ONE; 9], &mut Cost::default());
    assert_eq!(drawn.kind, DrawKind::None { why: NoneReason::Coincident });
    let drawn = draw::<DVec2>(key(1), 9, TRIES, &[], &mut Cost::default());
    assert_eq!((drawn.kind, drawn.separator), (DrawKind::None { why: NoneReason::NoSamples }, None));
    // A thousand coincident points and one other point are cut by a plane, although no split is balanced.
    let mut lopsided = vec![DVec2::ONE; 1000];
    lopsided.push(DVec2::new(1.0, 1.0 + f64::EPSILON));
    let drawn = draw(key(1), 1001, TRIES, &lopsided, &mut Cost::default());
    assert_eq!(ratio(&drawn.separator.unwrap(), &lopsided), 1000.0 / 1001.0);
}

fn progression<P: Point>() {
    let all: Vec<P> = (0..=400).map(|k| P::splat(f64::from_bits((1023 - k) << 52))).collect();
    let mut stack = vec![(all.clone(), 0)];
    let mut depth = 0;
    while let Some((points, level)) = stack.pop() {
        depth = depth.max(level);
        if points.len() < 2 {
            continue;
        }
        let drawn = draw(key(points.len() as u64), points.len() as u64, TRIES, &points, &mut Cost::default());
        let s = drawn.separator.unwrap();
        let (inside, outside): (Vec<P>, Vec<P>) = points.iter().partition(|&&x| s.side(x) == Side::Interior);
        assert!(!inside.is_empty() && !outside.is_empty());
        assert!(ratio(&s, &points) <= split_bound::<P>(), "{} of {}", inside.len(), points.len());
        stack.extend([(inside, level + 1), (outside, level + 1)]);
    }
    println!("progression: {depth} levels for {} points", all.len());
    assert!(depth <= 24);
}

#[test]
fn geometric_progressions_split_at_all_sizes() {
    progression::<DVec2>();
    progression::<DVec3>();
}

#[test]
fn draws_are_functions_of_key_and_sample_set() {
    let points = uniform::<DVec3>(400, 9);
    let mut turned = points.clone();
    turned.reverse();
    turned.rotate_left(123);
    let (mut one, mut two) = (Cost::default(), Cost::default());
    assert_eq!(draw(key(4), 5000, TRIES, &points, &mut one), draw(key(4), 5000, TRIES, &turned, &mut two));
    assert_eq!(one, two);
    let other = DrawKey { attempt: 1, ..key(4) };
    assert_ne!(draw(other, 5000, TRIES, &points, &mut one), draw(key(4), 5000, TRIES, &points, &mut two));
    let many = uniform::<DVec3>(100_000, 2);
    let count = |key| {
        let sampler = Sampler::new(key, 100_000, 400);
        many.iter().filter(|&&x| sampler.accepts(x)).count()
    };
    assert!((300..500).contains(&count(key(4))) && (300..500).contains(&count(other)));
}

#[test]
fn depth_is_logarithmic_in_the_samples_alone() {
    for m in [50, 100, 200, 400, 800] {
        let points = uniform::<DVec3>(m, 9);
        let run = |population: u64| {
            let mut cost = Cost::default();
            draw(key(4), population, TRIES, &points, &mut cost);
            cost
        };
        let cost = run(1 << 40);
        println!(
            "{m} samples: work {} depth {} log {}",
            cost.work(),
            cost.depth(),
            cost.price().depth_log_scan(m as u64)
        );
        assert_eq!(cost, run(1 << 20));
        assert_eq!(cost.price().scans(), 0);
        assert!(cost.depth() <= 50 + 5 * ceil_log2(m as u64));
        assert!(cost.work() <= 6 * (m * m) as u64 + 300 * m as u64);
    }
}

/// A surface of a given radius around a centre at a given distance from the origin.
fn sphere<P: Point>(rng: &mut ChaCha8Rng, radius: f64, far: f64) -> Option<Quadric<P>> {
    let centre: P = direction::<P>(rng) * far;
    let c = (far - radius) * (far + radius);
    Quadric::from_coefficients(P::splat(0.0), 1.0, 1.0, centre * -2.0, c)
}

fn direction<P: Point>(rng: &mut ChaCha8Rng) -> P {
    let v: P = vector(|_| 2.0 * unit(rng) - 1.0);
    v / v.norm2().sqrt()
}

/// Bisects from `x` towards `to`, down to the last float on the side of `x` and the first float beyond. The smallest
/// ball that contains the latter must cross. If the coefficients are well conditioned, a ball that ends clearly before
/// that float must not cross.
fn check_segment<P: Point>(s: &Quadric<P>, x: P, to: P) -> Option<f64> {
    let side = s.side(x);
    if s.side(to) == side {
        return None;
    }
    let at = |t: f64| x + (to - x) * t;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if s.side(at(middle)) == side { low = middle } else { high = middle }
    }
    let radius = crate::point::dist2(at(high), x).sqrt();
    assert!(s.crosses(x, radius), "{s:?} {x:?} {radius}");
    assert!(s.reaches(x, radius, side) && s.reaches(x, radius, side.opposite()));
    Some(radius)
}

fn crossings<P: Point>() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut tried, mut tight) = (0, 0);
    for round in 0..3000 {
        let radius = [1.0, 1e-3, 1e3, 1e6, 0.3][round % 5];
        let far = [0.0, 1.0, 0.5, 1e3, 1e6][round / 5 % 5];
        let s = match round % 7 {
            0 => Some(Quadric::plane(round % P::DIM, unit(&mut rng) - 0.5)),
            1 => {
                let n = direction::<P>(&mut rng);
                Quadric::from_coefficients(P::splat(1e9), 1.0, 0.0, n, unit(&mut rng))
            }
            _ => sphere::<P>(&mut rng, radius, far),
        };
        // In other cases, the coefficients lose digits. A path that starts inside may lead through the centre.
        let well = far <= 1.0 && radius >= 0.3 && round % 7 != 1;
        // A small sphere too far from the frame has no coefficients.
        let Some(s) = s else { continue };
        let origin = if round % 7 == 1 { P::splat(1e9) } else { P::splat(0.0) };
        let start = s.centre().map_or(origin, |c| c + direction::<P>(&mut rng) * s.radius().unwrap());
        for scale in [1.0, 1e-3, 1e-9, 1e-14] {
            let x = start + direction::<P>(&mut rng) * (scale * unit(&mut rng));
            // The starting points are in random directions, and the paths follow the gradient.
            let gradient = s.local(x) * (2.0 * s.a) + s.b;
            let step = gradient * (3.0 * scale / gradient.norm2().sqrt());
            for to in [x + step, x - step] {
                let Some(radius) = check_segment(&s, x, to) else { continue };
                tried += 1;
                let slack = 1e-12 * (1.0 + x.norm2().sqrt() + s.radius().unwrap_or(0.0));
                if well && s.side(x) == Side::Exterior && radius > slack {
                    assert!(!s.crosses(x, radius - slack), "{s:?} {x:?} {radius}");
                    tight += 1;
                }
            }
            for _ in 0..8 {
                tried += i32::from(check_segment(&s, x, x + direction::<P>(&mut rng) * scale).is_some());
            }
        }
        assert!(s.crosses(start, f64::INFINITY) && s.crosses(start, f64::NAN) && s.crosses(start, f64::MAX));
    }
    println!("crossings dim {}: {tried} segments, {tight} tight", P::DIM);
    assert!(tried > 20_000 && tight > 300);
}

#[test]
fn crossings_round_towards_crossing() {
    crossings::<DVec2>();
    crossings::<DVec3>();
}

#[test]
fn balls_that_hold_a_side_cross() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let s = sphere::<DVec3>(&mut rng, 1.0, 0.0).unwrap();
    let x = DVec3::new(3.0, 0.0, 0.0);
    assert_eq!((s.side(x), s.side(DVec3::ZERO)), (Side::Exterior, Side::Interior));
    for (radius, crosses) in [(1.9, false), (2.0, true), (3.5, true), (4.5, true), (100.0, true)] {
        assert_eq!(s.crosses(x, radius), crosses, "{radius}");
    }
    for (radius, crosses) in [(0.9, false), (1.0, true), (100.0, true)] {
        assert_eq!(s.crosses(DVec3::ZERO, radius), crosses, "{radius}");
    }
    assert_eq!(s.side(DVec3::X), Side::Exterior);
    assert!(s.crosses(DVec3::X, 0.0) && s.is_sphere());
    assert!((s.radius().unwrap() - 1.0).abs() < 1e-15 && s.centre().unwrap().length() < 1e-15);
}

#[test]
fn planes_cut_exactly() {
    for at in [0.0, 0.1, -1e120, 1e200, 5e-324, 1.0 + f64::EPSILON] {
        let s = Quadric::<DVec3>::plane(1, at);
        let x = |y: f64| DVec3::new(1e250, y, -1e-250);
        assert_eq!(s.side(x(at.next_down())), Side::Interior);
        assert_eq!((s.side(x(at)), s.side(x(at.next_up()))), (Side::Exterior, Side::Exterior));
        assert!(s.crosses(x(at), 0.0) && !s.is_sphere() && s.centre().is_none() && s.radius().is_none());
    }
    let s = Quadric::<DVec2>::plane(0, 1.0);
    assert!(s.crosses(DVec2::new(0.5, 1e9), 0.5) && !s.crosses(DVec2::new(0.5, 1e9), 0.5 - 1e-12));
    assert!(s.reaches(DVec2::ZERO, 0.1, Side::Interior) && !s.reaches(DVec2::ZERO, 0.1, Side::Exterior));
}

#[test]
fn malformed_encodings_are_rejected() {
    let good = Quadric::<DVec3>::plane(2, 4.0).to_array();
    assert!(Quadric::<DVec3>::from_array(&good).is_some());
    for (slot, value) in [(3, 0.0), (3, 3.0), (3, -1.0), (0, f64::NAN), (8, f64::INFINITY), (7, 0.0)] {
        let mut bad = good;
        bad[slot] = value;
        assert_eq!(Quadric::<DVec3>::from_array(&bad), None, "{slot} {value}");
    }
}

/// The first attempt cuts the longest side at its median, and further attempts cut the other sides. Points with equal
/// coordinates stay together. Steps that only spheres need are not charged.
#[test]
fn cuts_are_medians_of_the_longest_side() {
    let mut slab = uniform::<DVec3>(399, 4);
    for p in &mut slab {
        *p = DVec3::new(p.x, 9.0 * p.y, 0.5 * p.z);
    }
    let attempt = |attempt| DrawKey { attempt, ..key(1) };
    for (i, axis) in [1, 0, 2, 1].into_iter().enumerate() {
        let mut cost = Cost::default();
        let drawn = cut(attempt(i as u32), &slab, &mut cost);
        let plane = drawn.separator.unwrap();
        assert_eq!(drawn.kind, DrawKind::Plane { why: PlaneReason::AskedFor });
        assert_eq!(plane.to_array()[5 + axis], 1.0, "attempt {i}");
        assert_eq!(slab.iter().filter(|&&p| plane.side(p) == Side::Interior).count().abs_diff(199), 0);
        assert_eq!(drawn.estimated_ratio, 200.0 / 399.0);
        let sphere = &mut Cost::default();
        draw(attempt(i as u32), 399, TRIES, &slab, sphere);
        assert!(cost.depth() < 40 && 5 * cost.work() < sphere.work(), "{cost:?} {sphere:?}");
    }
    // Three of every four points lie on one plane, so they form one side.
    let sheets: Vec<DVec2> =
        (0..40u8).map(|i| DVec2::new(f64::from(i % 4 / 3), f64::from(i) / 99.0)).collect();
    let drawn = cut(key(1), &sheets, &mut Cost::default());
    assert_eq!(drawn.estimated_ratio, 0.75);
    let one = [DVec2::ONE; 3];
    assert_eq!(cut(key(1), &one, &mut Cost::default()).kind, DrawKind::None { why: NoneReason::Coincident });
    assert_eq!(cut(key(1), &one[..0], &mut Cost::default()).separator, None);
}
