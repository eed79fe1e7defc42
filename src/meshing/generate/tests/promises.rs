//! Meshes keep the promises: conformity for wedges, and radius-edge ratios for domains without small angles.

use glam::{DMat3, DVec3};

use crate::generate::{Alone, Rules, generate};
use crate::input::{DomainKind, Input};
use crate::mesh::Mesh;
use crate::quality::balls::BoundaryBalls;
use crate::quality::{Measure, quality};
use crate::size::{SizeFunction, SizeOptions};
use crate::tests::shapes::{add_box, cube, facet};

/// The faces of a wedge with its edge along z.
fn add_wedge(input: &mut Input<DVec3>, degrees: f64) {
    let (x, y) = (degrees.to_radians().cos() * 2.0, degrees.to_radians().sin() * 2.0);
    let base = input.points.len() as u32;
    for z in [1.0, 3.0] {
        input.points.extend([[1., 1., z], [3., 1., z], [1. + x, 1. + y, z]].map(DVec3::from));
    }
    for f in [&[0, 1, 2][..], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]] {
        let f: Vec<u32> = f.iter().map(|v| v + base).collect();
        facet(input, &[&f]);
    }
}

/// Generates meshes of a domain for some seeds and checks each.
fn meshes(input: &Input<DVec3>, lipschitz: f64, most: Option<f64>, seeds: u64) -> Vec<Mesh<DVec3>> {
    let domain = crate::check(input).unwrap();
    let mut options = SizeOptions::new(lipschitz);
    options.constraints.most = most;
    let size = SizeFunction::new(&domain, &options).unwrap();
    let at = |x| size.at(x);
    let made = (1..=seeds).map(|seed| {
        let rules = Rules { size: &at, lipschitz, seed, most: 1 << 24 };
        let mesh = generate(&domain, rules, &mut Alone { seed }).unwrap().into_mesh(&domain);
        let found = crate::conformity::check(&domain, &mesh);
        assert!(found.is_clean(), "L {lipschitz}, most {most:?}, seed {seed}: {found:?}");
        mesh
    });
    made.collect()
}

/// On the slanted facet, the shells of corners have points on a common circle, off the plane by rounding. They form a
/// flat cell with a different diagonal on either side.
#[test]
fn wedges_inside_a_box_are_matched() {
    for (lipschitz, most) in [(0.25, None), (0.5, None), (0.25, Some(0.4)), (0.5, Some(0.3)), (0.12, None)] {
        let mut input = cube();
        add_wedge(&mut input, 10.0);
        for mesh in meshes(&input, lipschitz, most, 12) {
            assert_eq!(mesh.dropped, 0);
        }
    }
}

#[test]
fn wedges_alone_conform() {
    for (lipschitz, most, degrees) in [(0.25, None, 10.0), (0.5, Some(0.3), 10.0), (0.5, None, 5.0)] {
        let mut input = Input::new(DomainKind::Complex, Vec::new());
        add_wedge(&mut input, degrees);
        let made = meshes(&input, lipschitz, most, 12);
        // Outside the slanted facet, flat cells are harmless.
        assert!(made.iter().all(|mesh| mesh.dropped > 0));
    }
}

#[test]
fn sharp_wedges_conform() {
    for degrees in [1.0, 2.0] {
        let mut input = cube();
        add_wedge(&mut input, degrees);
        meshes(&input, 0.5, None, 2);
    }
}

/// A corner of seven facets between four segments: two in the plane z = 0, on either side of x, one above and one
/// below it.
fn corner(opening: f64, rise: f64) -> Input<DVec3> {
    let points = [[0., 0., 0.], [1., opening, 0.], [1., -opening, 0.], [2.5, 0., rise], [2.5, 0., -rise]];
    let mut input = Input::new(DomainKind::Complex, points.map(DVec3::from).to_vec());
    for triangle in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3], [0, 1, 4], [0, 2, 4], [1, 2, 4]] {
        facet(&mut input, &[&triangle]);
    }
    input
}

#[test]
fn sharp_corners_terminate() {
    for degrees in [2.5f64, 5.0, 10.0, 20.0, 30.0] {
        for rise in [0.2, 0.5] {
            meshes(&corner((0.5 * degrees).to_radians().tan(), rise), 0.5, None, 2);
        }
    }
}

/// The facet in the plane is blunt, and others are within 12 degrees of it. Subfacets at the corner recur at half the
/// size until the corner is enclosed.
#[test]
fn blunt_corners_between_facets_terminate() {
    for (opening, rise) in [(2.0, 0.1), (2.5, 0.5), (3.0, 0.5)] {
        let mesh = &meshes(&corner(opening, rise), 0.5, None, 1)[0];
        assert!(mesh.points.len() < 30_000, "{opening} {rise}: {} points", mesh.points.len());
    }
}

/// A prism with an angle of 270 degrees.
fn ell() -> Input<DVec3> {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    let base = [[0., 0.], [4., 0.], [4., 2.], [2., 2.], [2., 4.], [0., 4.]];
    input.points.extend([0.0, 4.0].iter().flat_map(|&z| base.map(|[x, y]| DVec3::new(x, y, z))));
    facet(&mut input, &[&[0, 1, 2, 3, 4, 5]]);
    facet(&mut input, &[&[6, 7, 8, 9, 10, 11]]);
    for i in 0..6 {
        let j = (i + 1) % 6;
        facet(&mut input, &[&[i, j, j + 6, i + 6]]);
    }
    input
}

fn hole() -> Input<DVec3> {
    let mut input = cube();
    add_box(&mut input, DVec3::splat(1.0), DVec3::splat(3.0));
    input.holes.push(DVec3::splat(2.0));
    input
}

/// Three times a rotation, in integers, so that its facets are exact planes.
fn slanted() -> Input<DVec3> {
    let mut input = cube();
    let turn = DMat3::from_cols(DVec3::new(1., 2., 2.), DVec3::new(2., 1., -2.), DVec3::new(2., -2., 1.));
    input.points.iter_mut().for_each(|p| *p = turn * *p);
    input
}

fn regions() -> Input<DVec3> {
    let mut input = cube();
    input.points.extend([[0., 0., 2.], [4., 0., 2.], [4., 4., 2.], [0., 4., 2.]].map(DVec3::from));
    facet(&mut input, &[&[8, 9, 10, 11]]);
    input
}

fn dangling() -> Input<DVec3> {
    let mut input = cube();
    input.points.extend([[1., 1., 3.], [2., 1., 3.], [2., 2., 3.], [1., 2., 3.]].map(DVec3::from));
    facet(&mut input, &[&[8, 9, 10, 11]]);
    input.points.extend([[3., 3., 2.], [3., 3., 1.]].map(DVec3::from));
    facet(&mut input, &[&[12, 13]]);
    input
}

/// Checks that a mesh keeps its promise. Returns the numbers of cells that are free, near, and above subfacets larger
/// than f.
fn keeps(name: &str, input: &Input<DVec3>, lipschitz: f64, seed: u64) -> [u64; 3] {
    let domain = crate::check(input).unwrap();
    assert!(domain.small_angles(90.0).is_empty(), "{name}");
    let size = SizeFunction::new(&domain, &SizeOptions::new(lipschitz)).unwrap();
    let at = |x| size.at(x);
    let rules = Rules { size: &at, lipschitz, seed, most: 1 << 24 };
    let mesh = generate(&domain, rules, &mut Alone { seed }).unwrap().into_mesh(&domain);
    assert!(crate::conformity::check(&domain, &mesh).is_clean());
    let features = crate::distance::Features::new(&domain);
    let balls = BoundaryBalls::new(&domain, &features, &mesh, &at, lipschitz);
    // The bound for a subfacet whose centre lies in the ball of a subsegment.
    assert!(balls.widest() <= 2f64.sqrt() / (1.0 - lipschitz), "{}", balls.widest());
    let promised = balls.promise(lipschitz).all();
    let place = |centre, radius| balls.place(centre, radius);
    let measure = Measure { place: &place, local_size: None, promised, worst: 1 };
    let found = quality(&domain, &mesh, &measure);
    let most = [0, 1, 2].map(|i| (found.places[i].cells, found.places[i].most.upper));
    eprintln!("{name} L {lipschitz} seed {seed}: {most:.4?} of {promised:.4?}, r/f {:.4}", balls.widest());
    for kind in &found.places {
        assert_eq!(kind.over, 0, "{name}, L {lipschitz}, seed {seed}: {:?}", kind.worst);
    }
    assert_eq!(found.places[3].cells, 0, "centres outside");
    [0, 1, 2].map(|i| found.places[i].cells)
}

#[test]
fn ratios_keep_their_bounds() {
    let domains = [
        ("cube", cube()),
        ("L", ell()),
        ("hole", hole()),
        ("slanted", slanted()),
        ("regions", regions()),
        ("dangling", dangling()),
    ];
    let mut cells = [0; 3];
    for (name, input) in &domains {
        for (lipschitz, seeds) in [(0.06, 1), (0.12, 1), (0.25, 3), (0.5, 3)] {
            for seed in 1..=seeds {
                let found = keeps(name, input, lipschitz, seed);
                cells = [0, 1, 2].map(|i| cells[i] + found[i]);
            }
        }
    }
    // Every case occurs.
    assert!(cells.iter().all(|&n| n > 100), "{cells:?}");
}
