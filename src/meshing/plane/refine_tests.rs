//! Refinement of domains in the plane.

use glam::DVec2;

use super::{as_it_is, refined};
use crate::conformity;
use crate::domain::Domain;
use crate::generate::{Alone, GeneratedMesh, Rules};
use crate::input::{DomainKind, Input, InputSegment, Region};
use crate::mesh::Mesh;

fn ring(points: &[[f64; 2]]) -> Input<DVec2> {
    let n = points.len() as u32;
    let mut input = Input::new(DomainKind::Complex, points.iter().map(|&p| p.into()).collect());
    input.segments =
        (0..n).map(|i| InputSegment { ends: [i, (i + 1) % n], marker: i64::from(i) + 1 }).collect();
    input
}

fn mesh(domain: &Domain<DVec2>, size: f64, degrees: f64) -> Mesh<DVec2> {
    let size = move |_| size;
    let rules = Rules { size: &size, lipschitz: 0.5, seed: 1, most: 100_000 };
    let (made, _) = refined(domain, rules, degrees, &mut Alone { seed: 1 }).unwrap();
    conforming(domain, made)
}

fn conforming(domain: &Domain<DVec2>, made: GeneratedMesh<DVec2>) -> Mesh<DVec2> {
    let mesh = made.into_mesh(domain);
    let found = conformity::check(domain, &mesh);
    assert!(found.is_clean(), "{:?}", found.defects);
    mesh
}

fn least_angle(mesh: &Mesh<DVec2>) -> f64 {
    let angles = mesh.cells.iter().flat_map(|cell| {
        let p = cell.map(|v| mesh.points[v as usize]);
        [0, 1, 2].map(|i| {
            let (u, v) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            u.angle_to(v).abs().to_degrees()
        })
    });
    angles.fold(180.0, f64::min)
}

#[test]
fn simple_domains_need_few_cells() {
    let square = crate::check(&ring(&[[0., 0.], [4., 0.], [4., 4.], [0., 4.]])).unwrap();
    assert_eq!(mesh(&square, 1e9, 20.0).cells.len(), 2);
    let ell = ring(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]);
    assert_eq!(mesh(&crate::check(&ell).unwrap(), 1e9, 20.0).cells.len(), 4);
    // A size bounds the circumradii.
    let fine = mesh(&square, 0.25, 20.0);
    assert!(fine.cells.len() > 150 && fine.cells.len() < 700, "{}", fine.cells.len());
    assert!(least_angle(&fine) >= 20.0);
}

#[test]
fn holes_regions_and_slits() {
    let mut input = ring(&[[0., 0.], [8., 0.], [8., 8.], [0., 8.]]);
    let n = input.points.len() as u32;
    input
        .points
        .extend([[2., 2.], [4., 2.], [4., 4.], [2., 4.], [5., 1.], [6.5, 7.], [7., 3.]].map(DVec2::from));
    let hole = (0..4).map(|i| [n + i, n + (i + 1) % 4]);
    let slit = [[n + 4, n + 5]];
    input.segments.extend(hole.chain(slit).map(|ends| InputSegment { ends, marker: 7 }));
    input.holes.push(DVec2::new(3., 3.));
    input.regions.push(Region { at: DVec2::new(1., 1.), attribute: 5.0, limit: None });
    let domain = crate::check(&input).unwrap();
    let plain = conforming(&domain, as_it_is(&domain, &mut Alone { seed: 1 }).unwrap().0);
    assert_eq!((plain.points.len(), plain.faces.len()), (11, 9));
    let refined = mesh(&domain, 1e9, 20.0);
    assert!(least_angle(&refined) >= 20.0);
    assert!(refined.faces.iter().filter(|f| f.marker == 7).count() >= 5);
}

/// Small angles of the input stay, and refinement ends.
#[test]
fn small_angles_of_the_input() {
    for degrees in [1.0_f64, 5.0, 15.0, 40.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let domain = crate::check(&ring(&[[0., 0.], [10., 0.], [10. * c, 10. * s]])).unwrap();
        let made = mesh(&domain, 1e9, 20.0);
        assert!(made.cells.len() < 400, "{degrees}: {}", made.cells.len());
    }
    // A fan of needles around a corner inside.
    let mut input = ring(&[[-8., -8.], [8., -8.], [8., 8.], [-8., 8.]]);
    input.points.push(DVec2::ZERO);
    for i in 0..24 {
        let angle = 0.1 + f64::from(i) * 0.04;
        input.points.push(DVec2::new(angle.cos(), angle.sin()) * (3.0 + 0.1 * f64::from(i % 5)));
        input.segments.push(InputSegment { ends: [4, 5 + i as u32], marker: 0 });
    }
    let made = mesh(&crate::check(&input).unwrap(), 1e9, 20.0);
    assert!(made.cells.len() < 6000, "{}", made.cells.len());
}

#[test]
fn a_limit_ends_refinement() {
    let domain = crate::check(&ring(&[[0., 0.], [1., 0.], [0., 1.]])).unwrap();
    let size = |_: DVec2| 1e-3;
    let rules = Rules { size: &size, lipschitz: 0.5, seed: 1, most: 500 };
    let made = refined(&domain, rules, 20.0, &mut Alone { seed: 1 });
    assert!(matches!(made, Err(crate::generate::GenerationError::TooMany(500))));
}
