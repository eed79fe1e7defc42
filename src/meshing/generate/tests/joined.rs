//! Domains whose coplanar triangles are joined for the sizes.

use glam::{DMat3, DVec3};

use super::{is_sound, meshed};
use crate::distance::Features;
use crate::domain::Feature;
use crate::input::{DomainKind, Input, InputFacet};

/// A unit cube with `n` by `n` squares of two triangles on each side, turned, with this many decimals.
fn grid_cube(kind: DomainKind, n: u32, decimals: Option<i32>) -> Input<DVec3> {
    let turn = match decimals {
        None => DMat3::IDENTITY,
        Some(_) => DMat3::from_rotation_z(0.4) * DMat3::from_rotation_y(1.1) * DMat3::from_rotation_x(0.3),
    };
    let round = |x: f64| decimals.map_or(x, |k| (x * 10f64.powi(k)).round() / 10f64.powi(k));
    let mut input = Input::new(kind, Vec::new());
    let mut lattice = std::collections::BTreeMap::new();
    let mut vertex = |input: &mut Input<DVec3>, at: [u32; 3]| {
        *lattice.entry(at).or_insert_with(|| {
            let p = turn * (DVec3::from(at.map(f64::from)) / f64::from(n));
            input.points.push(DVec3::from(p.to_array().map(round)));
            input.points.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let at = |u: u32, v: u32| {
                    let mut at = [0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, i + u, j + v);
                    at
                };
                let mut square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(u, v)| vertex(&mut input, at(u, v)));
                if side == 0 {
                    square.reverse();
                }
                let [a, b, c, d] = square;
                for t in [vec![a, b, c], vec![a, c, d]] {
                    input.facets.push(InputFacet { polygons: vec![t], holes: Vec::new(), marker: 0 });
                }
            }
        }
    }
    input
}

#[test]
fn sides_of_a_cube_are_one_feature_each() {
    for (kind, decimals) in
        [(DomainKind::Complex, None), (DomainKind::Complex, Some(6)), (DomainKind::Surface, Some(6))]
    {
        let domain = crate::check(&grid_cube(kind, 4, decimals)).unwrap();
        let features = Features::new(&domain);
        let mut all: Vec<Feature> =
            (0..features.item_count()).map(|i| features.feature(features.feature_of(i))).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 8 + 12 + 6, "{kind:?} {decimals:?}");
        // The triangles and their edges are still there.
        if kind == DomainKind::Complex {
            assert_eq!(domain.facets.len(), 6 * 4 * 4 * 2);
        }
        assert_eq!(domain.corners.len(), 6 * 4 * 4 + 2);
        let local = features.local_size((domain.points()[0] + domain.points()[1]) * 0.5).radius;
        assert!(local > 0.1, "{local}");
    }
    let mut marked = grid_cube(DomainKind::Complex, 4, None);
    marked.facets[0].marker = 7;
    let domain = crate::check(&marked).unwrap();
    let of = |f: usize| domain.flats.flats[f];
    assert!(of(0) != of(1) && of(2) == of(3), "a marker is a border");
}

#[test]
fn coplanar_triangles_need_few_cells() {
    for (kind, decimals) in
        [(DomainKind::Complex, None), (DomainKind::Complex, Some(6)), (DomainKind::Surface, Some(6))]
    {
        let (domain, made) = meshed(&grid_cube(kind, 6, decimals), 0.5, None);
        is_sound(&domain, &made);
        let cells = made.clone().into_mesh(&domain).cells.len();
        assert!(cells < 4000, "{kind:?} {decimals:?}: {cells}");
    }
}

#[test]
fn a_fold_or_a_step_is_not_flat() {
    // A corner of the top is raised by a hundred steps of the digits.
    let mut input = grid_cube(DomainKind::Surface, 2, None);
    let raised = input.points.iter().position(|&p| p == DVec3::new(0.5, 0.5, 1.0)).unwrap();
    input.points[raised].z += 0.001;
    let domain = crate::check(&input).unwrap();
    assert!(!domain.flats.joints[domain.corners.binary_search(&(raised as u32)).unwrap()]);
}
