//! Quality compared with direct formulas.

use glam::DVec3;
use num_bigint::BigInt;
use septet_geometry::hash::Draw;

use super::meshes::{kuhn, mesh_of};
use super::shapes::cube;
use crate::distance::Features;
use crate::domain::{Domain, Feature};
use crate::mesh::Mesh;
use crate::quality::histogram::Histogram;
use crate::quality::ratio::{Bracket, at_most, ratio};
use crate::quality::zones::Zones;
use crate::quality::{CentrePlace, Measure, Quality, angles, quality};

fn lattice() -> (Domain<DVec3>, Mesh<DVec3>) {
    let domain = crate::check(&cube()).unwrap();
    let (points, cells) = kuhn(4);
    let mesh = mesh_of(&domain, &points, cells);
    (domain, mesh)
}

fn measured(promised: [Option<f64>; 3], zone: f64) -> Quality<DVec3> {
    let (domain, mesh) = lattice();
    let features = Features::new(&domain);
    let zones = Zones { domain: &domain, features: &features, size: &|_| 1.0, zone };
    let measure = Measure {
        place: &|c, r| zones.place(c, r),
        local_size: Some(&|p| features.local_size(p).radius),
        promised,
        worst: 5,
    };
    quality(&domain, &mesh, &measure)
}

#[test]
fn a_lattice_has_the_known_numbers() {
    let q = measured([Some(0.8), None, None], 0.6);
    // Each cell is a path along the three axes. Its dihedral angles are 45, 60 and 90 degrees.
    let exact = 0.75f64.sqrt();
    assert!(q.ratios.least > exact - 1e-12 && q.ratios.most < exact + 1e-12);
    assert_eq!((q.ratios.total(), q.angles.total()), (384, 6 * 384));
    assert!((q.least_angles.least - 45.0).abs() < 1e-9 && (q.largest_angles.most - 90.0).abs() < 1e-9);
    assert!((q.volume - 64.0).abs() < 1e-12 && (q.integral - 64.0).abs() < 1e-12);
    assert!((q.volumes[0] - 1.0 / 6.0).abs() < 1e-15 && (q.volumes[1] - 1.0 / 6.0).abs() < 1e-15);
    assert_eq!((q.slivers, q.points, q.steepest.slope), ([0; 3], 125, 0.0));
    assert!((q.lengths.least - 1.0).abs() < 1e-15 && (q.lengths.most - 3f64.sqrt()).abs() < 1e-12);
    // Centres are the middles of cubes: 8 of 64 are farther than 0.6 from the boundary.
    assert_eq!([0, 1, 2, 3].map(|i| q.places[i].cells), [8 * 6, 56 * 6, 0, 0]);
    assert_eq!((q.places[0].over, q.places[1].over), (48, 0));
    let Bracket { lower, upper } = q.places[0].most;
    assert!(lower <= exact && exact <= upper && upper - lower < 1e-13);
    assert_eq!(q.places[0].worst.len(), 5);
    assert_eq!(q.features.iter().map(|f| f.cells).sum::<u64>(), 56 * 6);
    let grading = q.grading.unwrap();
    assert_eq!(grading.total(), 125);
    assert!((grading.least - 0.25).abs() < 1e-12 && (grading.most - 0.5).abs() < 1e-12);
    assert_eq!(measured([Some(0.9), Some(0.9), None], 0.6).places[0].over, 0);
}

#[test]
fn centres_outside_differ_from_near_ones() {
    let domain = crate::check(&cube()).unwrap();
    let features = Features::new(&domain);
    let zones = Zones { domain: &domain, features: &features, size: &|_| 1.0, zone: 0.5 };
    assert_eq!(zones.place(DVec3::splat(2.0), 1.0), CentrePlace::Free);
    assert_eq!(zones.place(DVec3::splat(2.0), 9.0), CentrePlace::Free);
    let CentrePlace::Near(Feature::Facet(_)) = zones.place(DVec3::new(2.0, 2.0, 0.4), 1.0) else { panic!() };
    let CentrePlace::Outside(Some(Feature::Facet(_))) = zones.place(DVec3::new(2.0, 2.0, -0.4), 1.0) else {
        panic!()
    };
}

/// Splits `x = m 2^e` with the standard library only.
fn whole(x: f64, shift: i32) -> BigInt {
    let scaled = x * 2f64.powi(shift);
    assert_eq!(scaled.trunc(), scaled);
    BigInt::from(scaled as i128)
}

/// `(R/l)^2` as a fraction, from the linear system of the circumcentre by Cramer's rule.
fn squared(cell: &[DVec3; 4], shift: i32) -> (BigInt, BigInt) {
    let at = cell.map(|p| p.to_array().map(|x| whole(x, shift)));
    let minus = |a: &[BigInt; 3], b: &[BigInt; 3]| [0, 1, 2].map(|i| &a[i] - &b[i]);
    let dot = |a: &[BigInt; 3], b: &[BigInt; 3]| (0..3).map(|i| &a[i] * &b[i]).sum::<BigInt>();
    let rows = [1, 2, 3].map(|i| minus(&at[i], &at[0]));
    let right = [0, 1, 2].map(|i| dot(&rows[i], &rows[i]));
    let det = |m: &[[BigInt; 3]; 3]| {
        let minor = |i: usize, j: usize| &m[1][i] * &m[2][j] - &m[1][j] * &m[2][i];
        &m[0][0] * minor(1, 2) - &m[0][1] * minor(0, 2) + &m[0][2] * minor(0, 1)
    };
    let replaced = |k: usize| {
        let mut m = rows.clone();
        (0..3).for_each(|i| m[i][k] = right[i].clone());
        det(&m)
    };
    let x = [0, 1, 2].map(replaced);
    let w = det(&rows);
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
    let shortest = pairs.map(|(i, j)| minus(&at[i], &at[j])).map(|d| dot(&d, &d)).min().unwrap();
    // The centre is x / (2 w).
    (dot(&x, &x), BigInt::from(4) * &w * &w * shortest)
}

/// The next number in `[0, 1)` with 24 bits.
fn number(draw: &mut Draw) -> f64 {
    draw.below(1 << 24) as f64 / f64::from(1 << 24)
}

#[test]
fn bounds_hold_and_decisions_are_exact() {
    let mut draw = Draw::new(5);
    let (mut open, mut checked) = (0, 0);
    for round in 0..400 {
        let mut cell = [0; 4].map(|_| DVec3::new(number(&mut draw), number(&mut draw), number(&mut draw)));
        // Increasingly flat cells.
        let flatness = 2f64.powi(-(round % 30));
        for p in &mut cell {
            p.z = (p.z * flatness * 2f64.powi(50)).round() * 2f64.powi(-50);
        }
        let Bracket { lower, upper } = ratio(&cell);
        let (n, d) = squared(&cell, 50);
        if d == BigInt::ZERO {
            continue;
        }
        let below = |x: f64| {
            // x^2 <= n / d, for x of at most 53 bits.
            let (m, e) = crate::exact::split(x);
            let left = BigInt::from(m) * m * &d;
            if e < 0 { left <= &n << (-2 * e) } else { left << (2 * e) <= n }
        };
        assert!(below(lower), "{cell:?}");
        open += i32::from(upper == f64::INFINITY);
        assert!(upper == f64::INFINITY || !below(upper.next_up()), "{cell:?}");
        if upper - lower < 1e-6 * lower {
            checked += 1;
        }
        let mut bounds = vec![lower, upper.min(1e9), f64::midpoint(lower, upper.min(1e9)), 2.0];
        bounds.push((n.to_string().parse::<f64>().unwrap() / d.to_string().parse::<f64>().unwrap()).sqrt());
        for bound in bounds.into_iter().filter(|b| *b > 0.0) {
            let (m, e) = crate::exact::split(bound);
            let right = BigInt::from(m) * m * &d;
            let expected = if e < 0 { &n << (-2 * e) <= right } else { n <= right << (2 * e) };
            assert_eq!(at_most(&cell, bound), expected, "{cell:?} {bound}");
        }
    }
    assert!(checked > 300 && open < 20, "{checked} {open}");
}

#[test]
fn ratios_equal_to_the_bound_satisfy_it() {
    use glam::DVec2;
    // With legs 3 and 4, the ratio is 2.5 / 3. With legs 1 and 1, it is half the root of 2.
    let right = |a: f64, b: f64| [DVec2::ZERO, DVec2::new(a, 0.0), DVec2::new(0.0, b)];
    assert!(
        at_most(&right(1.0, 1.0), 0.5f64.sqrt()) || !at_most(&right(1.0, 1.0), 0.5f64.sqrt().next_down())
    );
    assert!(!at_most(&right(3.0, 4.0), 2.5 / 3.0) || 2.5 / 3.0 * 3.0 >= 2.5);
    // The right triangle with sides 8, 15 and 17 has the ratio 17/16 exactly.
    let t = [DVec2::ZERO, DVec2::new(8.0, 0.0), DVec2::new(0.0, 15.0)];
    assert!(at_most(&t, 17.0 / 16.0) && !at_most(&t, (17.0f64 / 16.0).next_down()));
    assert!(!at_most(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0], 1e9));
    assert!(at_most(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0], f64::INFINITY));
}

#[test]
fn angles_of_known_cells() {
    let regular = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(DVec3::from);
    let expected = (1.0f64 / 3.0).acos().to_degrees();
    assert!(angles::angles(&regular).iter().all(|a| (a - expected).abs() < 1e-12));
    let flat = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
    assert!(angles::angles(&flat).iter().all(|&a| a == 0.0 || a == 180.0));
    let triangle = [[0., 0.], [4., 0.], [0., 3.]].map(glam::DVec2::from);
    let a = angles::angles(&triangle);
    assert!((a.iter().sum::<f64>() - 180.0).abs() < 1e-12 && (a[0] - 90.0).abs() < 1e-12);
    assert!((a[1] - 0.75f64.atan().to_degrees()).abs() < 1e-12);
    assert_eq!(angles::measure(&triangle), 6.0);
    assert!((angles::measure(&regular).abs() - 8.0 / 3.0).abs() < 1e-15);
}

#[test]
fn histograms_count_everything() {
    let mut h = Histogram::new(1.0, 3.0, 4);
    for x in [0.5, 1.0, 1.5, 2.99, 3.0, f64::INFINITY, f64::NAN] {
        h.add(x);
    }
    assert_eq!((h.below, h.above, h.counts.clone()), (1, 3, vec![1, 1, 0, 1]));
    assert_eq!((h.total(), h.bin(3)), (7, [2.5, 3.0]));
}

#[test]
fn slivers_and_slopes_are_reported() {
    let (domain, mut mesh) = lattice();
    let inner = mesh.points.iter().position(|&p| p == DVec3::splat(2.0)).unwrap();
    mesh.sizes[inner] = 1.5;
    let place = |_: DVec3, _: f64| CentrePlace::Free;
    let measure = Measure { place: &place, local_size: None, promised: [None; 3], worst: 3 };
    let q = quality(&domain, &mesh, &measure);
    assert_eq!(q.steepest.slope, 0.5);
    assert!(q.steepest.edge.contains(&(inner as u32)) && q.grading.is_none());
    assert!(q.integral < 64.0);
    // Four points nearly on a circle: a sliver.
    let t = 0.03;
    let sliver = [[1.0, 0.0, t], [-1.0, 0.0, t], [0.0, 1.0, -t], [0.0, -1.0, -t]].map(DVec3::from);
    let mesh = Mesh {
        points: sliver.to_vec(),
        sizes: vec![1.0; 4],
        carriers: vec![crate::mesh::Carrier::Volume; 4],
        cells: super::meshes::canonical(&sliver, vec![[0, 1, 2, 3]]),
        regions: vec![1],
        ..Mesh::default()
    };
    let q = quality(&domain, &mesh, &measure);
    // Its angle is near 2 t sqrt 2.
    assert_eq!(q.slivers, [1, 1, 1]);
    assert!(q.ratios.most < 1.0 && q.least_angles.most < 5.0 && q.largest_angles.least > 170.0);
    assert_eq!(q.thinnest[0].vertices.len(), 4);
}
