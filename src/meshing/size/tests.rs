//! Tests of the size function against all pairs and all cones.

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use septet_geometry::hash::Draw;

use super::*;
use crate::check;
use crate::domain::Feature;
use crate::executor::Executor;
use crate::input::{DomainKind, Input, InputSegment};
use crate::octree::CellKey;
use crate::tests::shapes::{add_box, cube, cube_surface, facet, segment};

/// Computes the local feature size from its definition, over all pairs of disjoint features.
fn by_pairs<P: Space>(domain: &Domain<P>, features: &Features<P>, x: P) -> f64 {
    let all: Vec<(Feature, f64)> = domain.features().map(|f| (f, features.distance(f, x))).collect();
    let pairs = all.iter().enumerate().flat_map(|(i, a)| all[i + 1..].iter().map(move |b| (a, b)));
    let disjoint = pairs.filter(|(a, b)| domain.are_disjoint(a.0, b.0));
    disjoint.map(|(a, b)| a.1.max(b.1)).fold(f64::INFINITY, f64::min)
}

/// A cube with a small box near a corner, a dangling facet and a dangling segment.
fn busy() -> Domain<DVec3> {
    let mut input = cube();
    add_box(&mut input, DVec3::new(0.5, 0.5, 0.25), DVec3::new(0.75, 1.0, 0.5));
    let base = input.points.len() as u32;
    input.points.extend([[1., 1., 3.], [2.25, 1., 3.], [2., 2., 3.5], [3., 3., 1.]].map(DVec3::from));
    facet(&mut input, &[&[base, base + 1, base + 2]]);
    segment(&mut input, [7, base + 3]);
    check(&input).unwrap()
}

/// A polygon of the plane with a narrow slit and a hole.
pub(crate) fn slit() -> Domain<DVec2> {
    let outer = [[0., 0.], [8., 0.], [8., 4.], [4.125, 4.], [4.0625, 1.], [4., 4.], [0., 4.]];
    let inner = [[1., 1.], [2., 1.], [1.5, 1.75]];
    let points = outer.iter().chain(&inner).map(|&p| DVec2::from(p)).collect();
    let mut input = Input::new(DomainKind::Complex, points);
    for (from, to) in [(0, 7), (7, 10)] {
        for i in from..to {
            let next = if i + 1 == to { from } else { i + 1 };
            input.segments.push(InputSegment { ends: [i, next], marker: 0 });
        }
    }
    check(&input).unwrap()
}

/// Points of the domain's bounding box, some of them on features.
fn places<P: Space>(domain: &Domain<P>, count: usize) -> Vec<P> {
    let bounds = Features::new(domain).bounds();
    let mut draw = Draw::new(1);
    let mut all: Vec<P> = (0..count)
        .map(|_| {
            let mut p = bounds.low;
            (0..P::DIM).for_each(|i| p.set_coord(i, p.coord(i) + draw.unit() * bounds.extent().coord(i)));
            p
        })
        .collect();
    for wall in domain.walls() {
        let corners = P::corners(domain.points(), wall);
        let sum = corners.iter().fold(P::splat(0.0), |s, &c| s + c);
        all.extend([corners[0], (corners[0] + corners[1]) * 0.5, sum / corners.len() as f64]);
    }
    all
}

fn lfs_is_right<P: Space>(domain: &Domain<P>) {
    let features = Features::new(domain);
    for x in places(domain, 60) {
        let (found, expected) = (features.local_size(x).radius, by_pairs(domain, &features, x));
        assert_eq!(found, expected, "{x:?}");
    }
}

#[test]
fn local_feature_size_is_that_of_all_pairs() {
    lfs_is_right(&busy());
    lfs_is_right(&slit());
    lfs_is_right(&check(&cube_surface()).unwrap());
}

/// Checks the inequalities of the statement at cones, at points and for pairs of points.
fn bounds_hold<P: Space>(domain: &Domain<P>, lipschitz: f64, loss: f64) {
    let options = SizeOptions { loss, ..SizeOptions::new(lipschitz) };
    let size = SizeFunction::new(domain, &options).unwrap();
    let features = Features::new(domain);
    let lfs = |x| features.local_size(x).radius;
    for cone in size.cones() {
        let there = lfs(cone.at);
        assert!(cone.size >= (1.0 - loss) * there * (1.0 - 1e-12), "{cone:?}: {there}");
    }
    let places = places(domain, 400);
    let sizes: Vec<f64> = places.iter().map(|&x| lfs(x)).collect();
    for (&x, &here) in places.iter().zip(&sizes) {
        let f = size.at(x);
        assert!(f > 0.0 && f <= here * (1.0 + 1e-12), "{x:?}: {f} above {here}");
        assert!(f >= (1.0 - loss) * lipschitz * here * (1.0 - 1e-12), "{x:?}: {f} far below {here}");
        for (&y, &there) in places.iter().zip(&sizes) {
            assert!(f <= (there + lipschitz * (x - y).norm2().sqrt()) * (1.0 + 1e-12));
        }
    }
}

#[test]
fn proved_bounds_hold() {
    for lipschitz in [0.06, 0.25, 0.5, 0.9] {
        bounds_hold(&slit(), lipschitz, (1.0 + lipschitz) / 3.0);
    }
    bounds_hold(&slit(), 0.25, 0.1);
    bounds_hold(&busy(), 0.25, 1.25 / 3.0);
    bounds_hold(&busy(), 0.5, 0.25);
}

/// The terms of a tree without drops.
fn undropped<'a, P: Space>(
    features: &'a Features<P>,
    options: &SizeOptions<P>,
    user: &'a User<P>,
) -> Terms<'a, P> {
    let (slope, loss) = (options.lipschitz, options.loss);
    Terms { features, domain: None, user, slope, loss, drops: false }
}

/// Without drops, the tree is balanced and complete, and lfs is within its bounds relative to the side.
fn whole_tree<P: Space>(domain: &Domain<P>, lipschitz: f64) {
    let options = SizeOptions::new(lipschitz);
    let features = Features::new(domain);
    let user = always(User::new(lipschitz, &Constraints::default(), &Uncounted(Sequential)));
    let cube = Cube::around(&features.bounds());
    let grown =
        always(tree(undropped(&features, &options, &user), options.cells, &Uncounted(Sequential))).unwrap().0;
    let cells: Vec<_> = grown.leaves.iter().map(|&(key, _)| cube.cell(key)).collect();
    let side = |key: CellKey| 0.5f64.powi(i32::from(key.level));
    let volume: f64 = cells.iter().map(|c| side(c.key).powi(P::DIM as i32)).sum();
    assert_eq!(volume, 1.0);
    let d = (P::DIM as f64).sqrt();
    let k = (1.0 + lipschitz) * d / (2.0 * options.loss);
    for (cell, x) in cells.iter().flat_map(|c| spots(c).into_iter().map(move |x| (c, x))) {
        let lfs = features.local_size(x).radius / cell.side;
        let (low, high) = ((k - 0.5 * d) * (1.0 - 1e-12), (2.0 * k + 1.5 * d) * (1.0 + 1e-12));
        assert!(cell.key.level == 0 || (low..=high).contains(&lfs), "{cell:?}: {lfs}");
    }
    for (i, a) in cells.iter().enumerate() {
        for b in cells[i..].iter().filter(|b| a.key.level.abs_diff(b.key.level) > 1) {
            let reach = 0.5 * (a.side + b.side);
            let touch = (0..P::DIM).all(|i| (a.centre.coord(i) - b.centre.coord(i)).abs() <= reach);
            assert!(!touch, "{a:?} and {b:?}");
        }
    }
    let split: u64 = grown.levels.iter().map(|l| l.split).sum();
    let leaves: u64 = grown.levels.iter().map(|l| l.kept + l.dropped).sum();
    assert_eq!((leaves, leaves), (split * ((1 << P::DIM) - 1) + 1, cells.len() as u64));
}

/// The centre of a cell and two of its corners.
fn spots<P: Space>(cell: &crate::octree::Cell<P>) -> [P; 3] {
    let half = P::splat(0.5 * cell.side);
    [cell.centre, cell.centre - half, cell.centre + half]
}

#[test]
fn the_whole_tree_is_balanced_and_close() {
    whole_tree(&slit(), 0.25);
    let mut input = cube();
    input.points.extend([DVec3::splat(1.0), DVec3::new(1.0, 1.0, 1.5)]);
    segment(&mut input, [8, 9]);
    whole_tree(&check(&input).unwrap(), 0.5);
}

#[test]
fn drops_and_filters_lose_nothing() {
    let domain = slit();
    let options = SizeOptions::new(0.25);
    let features = Features::new(&domain);
    let user = always(User::new(0.25, &Constraints::default(), &Uncounted(Sequential)));
    let size = SizeFunction::new(&domain, &options).unwrap();
    let whole =
        always(tree(undropped(&features, &options, &user), options.cells, &Uncounted(Sequential))).unwrap().0;
    let all: Vec<_> = whole.leaves.iter().map(|(_, cone)| *cone).collect();
    assert!(size.cones().len() * 2 < all.len(), "{} of {}", size.cones().len(), all.len());
    // Both satisfy the statement, so they differ by at most one loss.
    let whole = Cones::new(0.25, all);
    for x in places(&domain, 300) {
        let (f, g) = (size.at(x), whole.at(x));
        let least = 1.0 - options.loss;
        assert!(f >= least * g * (1.0 - 1e-12) && g >= least * f * (1.0 - 1e-12), "{x:?}: {f} and {g}");
    }
}

#[test]
fn constraints_are_satisfied() {
    let domain = slit();
    let make = |constraints: Constraints<DVec2>| {
        SizeFunction::new(&domain, &SizeOptions { constraints, ..SizeOptions::new(0.25) }).unwrap()
    };
    let plain = make(Constraints::default());
    let place = DVec2::new(6.5, 2.5);
    let most = make(Constraints { most: Some(0.125), ..Constraints::default() });
    let cells = |s: &SizeFunction<DVec2>| s.levels().iter().map(|l| l.split).sum::<u64>();
    assert!(plain.at(place) > 0.5 && most.at(place) == 0.125 && cells(&most) < cells(&plain));
    let least = make(Constraints { least: Some(0.25), ..Constraints::default() });
    assert_eq!(least.at(DVec2::new(4.03125, 3.75)), 0.25);
    assert!(plain.at(DVec2::new(4.03125, 3.75)) < 0.125 && cells(&least) < cells(&plain));
    let field = vec![Cone { at: place, size: 0.01 }, Cone { at: DVec2::new(7.0, 1.0), size: 0.5 }];
    let field = make(Constraints { field, ..Constraints::default() });
    assert_eq!(field.at(place), 0.01);
    assert_eq!(field.at(place + DVec2::new(0.5, 0.0)), 0.01 + 0.25 * 0.5);
    let line = Singularity::Line(DVec2::new(5.0, 1.0), DVec2::new(7.0, 1.0));
    let singularities = vec![(Singularity::Point(place), 1e-3), (line, 1e-2)];
    let singular = make(Constraints { singularities, ..Constraints::default() });
    assert_eq!(singular.at(place), 1e-3);
    assert_eq!(singular.at(DVec2::new(6.0, 1.5)), 1e-2 + 0.25 * 0.5);
    assert_eq!(singular.at(DVec2::new(7.25, 1.0)), 1e-2 + 0.25 * 0.25);
}

#[test]
fn invalid_options_are_rejected() {
    let domain = slit();
    let with = |change: &dyn Fn(&mut SizeOptions<DVec2>)| {
        let mut options = SizeOptions::new(0.25);
        change(&mut options);
        SizeFunction::new(&domain, &options).err()
    };
    assert_eq!(with(&|o| o.lipschitz = 1.0), Some(SizeError::Lipschitz(1.0)));
    assert_eq!(with(&|o| o.lipschitz = 0.0), Some(SizeError::Lipschitz(0.0)));
    assert!(matches!(with(&|o| o.loss = 0.5), Some(SizeError::Loss { .. })));
    assert_eq!(with(&|o| o.constraints.most = Some(-1.0)), Some(SizeError::Size(-1.0)));
    assert_eq!(with(&|o| o.cells = 50), Some(SizeError::TooFine(TooFine::Cells { limit: 50 })));
    let nowhere = Cone { at: DVec2::new(f64::NAN, 0.0), size: 1.0 };
    assert_eq!(with(&|o| o.constraints.field.push(nowhere)), Some(SizeError::Place));
}

#[test]
fn collisions_are_found_before_generation() {
    let domain = slit();
    let size = SizeFunction::new(&domain, &SizeOptions::new(0.25)).unwrap();
    let found = size.collisions(&domain, 90.0);
    // The slit opens by 1/8 over a length of 3, that is 1.2 + 1.2 degrees, so the sine is less than L.
    assert!((found[0].angle.degrees() - 2.386).abs() < 1e-3 && found[0].reach.is_none());
    assert_eq!(domain.points()[found[0].angle.at as usize], DVec2::new(4.0625, 1.0));
    let hole = found.iter().find(|c| (c.angle.degrees() - 56.31).abs() < 0.01).unwrap();
    let reach = hole.reach.unwrap();
    assert!((reach - hole.size / (56.31f64.to_radians().sin() - 0.25)).abs() < 1e-4);
    let square = SizeFunction::new(&check(&cube()).unwrap(), &SizeOptions::new(0.25)).unwrap();
    assert!(square.collisions(&check(&cube()).unwrap(), 90.0).is_empty());
}

/// Coordinates and sizes of any scale.
fn cones() -> impl Strategy<Value = Vec<Cone<DVec3>>> {
    let cone = (-9.0..9.0f64, -9.0..9.0f64, -9.0..9.0f64, 1e-3..4.0f64);
    prop::collection::vec(cone.prop_map(|(x, y, z, size)| Cone { at: DVec3::new(x, y, z), size }), 1..200)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// The tree returns the minimum of all cones to the last bit. Filtering changes only roundings.
    #[test]
    fn trees_of_cones(cones in cones(), slope in 0.01..0.99f64, at in prop::collection::vec(
        (-20.0..20.0f64, -20.0..20.0f64, -20.0..20.0f64), 20)) {
        let tree = Cones::new(slope, cones.clone());
        let filtered = tree.clone().filtered(&Uncounted(Sequential)).unwrap();
        prop_assert!(filtered.all().len() <= cones.len());
        let at: Vec<DVec3> = at.into_iter().map(DVec3::from).chain(cones.iter().map(|c| c.at)).collect();
        for &x in &at {
            let all = cones.iter().map(|c| c.size + slope * (x - c.at).length_squared().sqrt());
            let expected = all.fold(f64::INFINITY, f64::min);
            prop_assert_eq!(tree.at(x), expected);
            prop_assert!((filtered.at(x) - expected).abs() <= 1e-14 * (1.0 + expected));
        }
        for pair in at.windows(2) {
            let rise = (tree.at(pair[0]) - tree.at(pair[1])).abs();
            prop_assert!(rise <= slope * pair[0].distance(pair[1]) * (1.0 + 1e-12) + 1e-13);
        }
    }

    /// The size function of a domain with constraints is L-Lipschitz.
    #[test]
    fn lipschitz(slope in 0.05..0.95f64, most in 0.05..2.0f64, least in 0.01..0.2f64,
                 x in (0.0..8.0f64, 0.0..4.0f64), y in (0.0..8.0f64, 0.0..4.0f64), near in 1e-6..1.0f64) {
        let constraints = Constraints {
            most: Some(most),
            least: Some(least),
            singularities: vec![(Singularity::Point(DVec2::new(1.0, 0.5)), 0.02)],
            ..Constraints::default()
        };
        let size = SizeFunction::new(&slit(), &SizeOptions { constraints, ..SizeOptions::new(slope) }).unwrap();
        let (x, y) = (DVec2::from(x), DVec2::from(y));
        for y in [y, x + (y - x) * near] {
            let rise = (size.at(x) - size.at(y)).abs();
            prop_assert!(rise <= slope * x.distance(y) * (1.0 + 1e-12) + 1e-14);
        }
    }
}

/// Maps items from the last one to the first.
struct Backwards;

impl Executor for Backwards {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        let mut mapped: Vec<U> = items.iter().rev().map(f).collect();
        mapped.reverse();
        mapped
    }
}

#[test]
fn sizes_do_not_depend_on_the_executor() {
    let domain = busy();
    let (features, options) = (Features::new(&domain), SizeOptions::new(0.5));
    let one =
        always(SizeFunction::of_features(&domain, &features, &options, &Uncounted(Sequential))).unwrap();
    let other =
        always(SizeFunction::of_features(&domain, &features, &options, &Uncounted(Backwards))).unwrap();
    assert_eq!(one.cones(), other.cones());
    assert_eq!(one.levels(), other.levels());
}

/// Only cells without any part of the domain are left out, and such cells exist.
#[test]
fn elements_outside_are_left_out() {
    let domain = slit();
    let features = Features::new(&domain);
    let user = always(User::new(0.25, &Constraints::default(), &Uncounted(Sequential)));
    let options = SizeOptions::new(0.25);
    let terms = Terms { drops: true, ..undropped(&features, &options, &user) };
    let cells = |grown: &Grown<Cone<DVec2>>| grown.levels.iter().map(|l| l.split).sum::<u64>();
    let everywhere = always(tree(terms, options.cells, &Uncounted(Sequential))).unwrap().0;
    let within =
        always(tree(Terms { domain: Some(&domain), ..terms }, options.cells, &Uncounted(Sequential)))
            .unwrap()
            .0;
    assert!(cells(&within) < cells(&everywhere), "{} of {}", cells(&within), cells(&everywhere));
    let cube = Cube::around(&features.bounds());
    let far = |key: CellKey| {
        let cell = cube.cell(key);
        let nearest = domain.features().map(|f| features.distance(f, cell.centre));
        !domain.is_inside(cell.centre) && nearest.fold(f64::INFINITY, f64::min) > cell.radius() * 1.001
    };
    assert!(everywhere.leaves.iter().any(|&(key, _)| far(key)));
    assert!(!within.leaves.iter().any(|&(key, _)| far(key)));
    // In the domain, the two functions differ only by the loss.
    let [narrow, wide] = [within, everywhere].map(|grown| grown.leaves.into_iter().map(|(_, cone)| cone));
    let (narrow, wide) = (Cones::new(0.25, narrow.collect()), Cones::new(0.25, wide.collect()));
    for x in places(&domain, 300).into_iter().filter(|&x| domain.is_inside(x)) {
        assert!(narrow.at(x) >= wide.at(x) * (1.0 - 1e-12), "{x:?}");
    }
}
