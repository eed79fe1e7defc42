//! Meshes by one processor.

mod labels;
mod promises;

use glam::{DVec2, DVec3};
use septet_geometry::measure::{circumcentre, circumradius2, shortest_edge2};

use super::{Alone, Generated, Labels, Machine, Rules, Triangulation, generate};
use crate::domain::Domain;
use crate::improve::{Target, improve, least_sine};
use crate::input::Input;
use crate::mesh::Mesh;
use crate::points::conflicts::Site;
use crate::points::independent::Independent;
use crate::size::tests::slit;
use crate::size::{SizeFunction, SizeOptions};
use crate::space::Space;
use crate::tests::shapes::{add_box, cube, facet};

/// The mesh of a domain with a size, and what its worst cell has: circumradius over size at the centre and
/// over the shortest edge.
fn meshed<P: Space + crate::facet::Triangulate>(
    input: &Input<P>,
    lipschitz: f64,
    most: Option<f64>,
) -> (Domain<P>, Generated<P>) {
    let domain = crate::check(input).unwrap();
    let mut options = SizeOptions::new(lipschitz);
    options.constraints.most = most;
    let size = SizeFunction::new(&domain, &options).unwrap();
    let at = |x| size.at(x);
    let rules = Rules { size: &at, lipschitz, seed: 1, most: 1 << 24 };
    let made = generate(&domain, rules, &mut Alone { seed: 1 }).unwrap();
    let worst =
        made.delaunay.cells.iter().zip(&made.labels.of).filter(|(_, l)| **l < Labels::FLAT).map(|(c, _)| {
            let corners: Vec<P> = c.as_ref().iter().map(|&v| made.vertices.points[v as usize]).collect();
            let radius = circumradius2(&corners).sqrt();
            (radius / at(circumcentre(&corners)), radius / shortest_edge2(&corners).sqrt())
        });
    let worst = worst.fold((0.0f64, 0.0f64), |w, x| (w.0.max(x.0), w.1.max(x.1)));
    let inside = made.labels.of.iter().filter(|l| **l < Labels::FLAT).count();
    eprintln!("{} vertices, {inside} cells, R/f {:.4}, R/l {:.4}", made.vertices.len(), worst.0, worst.1);
    for stage in &made.stages {
        eprintln!("  {stage:?}");
    }
    (domain, made)
}

/// The independent checks pass.
fn is_sound<P: Space>(domain: &Domain<P>, made: &Generated<P>) {
    let found = crate::conformity::check(domain, &made.clone().into_mesh(domain));
    assert!(found.is_clean(), "{found:?}");
}

#[test]
fn a_cube() {
    for (lipschitz, most) in [(0.25, None), (0.25, Some(0.5)), (0.5, Some(0.25)), (0.12, None)] {
        let (domain, made) = meshed(&cube(), lipschitz, most);
        is_sound(&domain, &made);
    }
}

#[test]
fn a_cube_with_a_cubic_hole() {
    let mut input = cube();
    add_box(&mut input, DVec3::splat(1.0), DVec3::splat(3.0));
    input.holes.push(DVec3::splat(2.0));
    let (domain, made) = meshed(&input, 0.25, None);
    is_sound(&domain, &made);
}

#[test]
fn a_slanted_box() {
    let mut input = cube();
    // A rotation with rounded entries: no facet lies on an axis, and most points are rounded off theirs.
    let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    input.points.iter_mut().for_each(|p| *p = turn * *p);
    let walls = input.facets.clone();
    input.facets.clear();
    let mut surface = Input::surface(input.points, Vec::<Vec<u32>>::new());
    surface.kind = crate::input::Kind::Complex;
    for f in walls {
        let [a, b, c, d] = f.polygons[0][..] else { panic!("a square") };
        facet(&mut surface, &[&[a, b, c]]);
        facet(&mut surface, &[&[a, c, d]]);
    }
    let (domain, made) = meshed(&surface, 0.25, Some(0.7));
    is_sound(&domain, &made);
}

#[test]
fn internal_and_dangling_pieces() {
    let mut input = cube();
    input.points.extend([[0., 0., 2.], [4., 0., 2.], [4., 4., 2.], [0., 4., 2.]].map(DVec3::from));
    facet(&mut input, &[&[8, 9, 10, 11]]);
    input.points.extend([[1., 1., 3.], [2., 1., 3.], [2., 2., 3.], [1., 2., 3.]].map(DVec3::from));
    facet(&mut input, &[&[12, 13, 14, 15]]);
    input.points.extend([[3., 3., 2.], [3., 3., 1.], [3.5, 3.5, 3.5]].map(DVec3::from));
    facet(&mut input, &[&[16, 17]]);
    let (domain, made) = meshed(&input, 0.25, None);
    assert_eq!(domain.components.iter().filter(|c| c.inside).count(), 2);
    is_sound(&domain, &made);
}

#[test]
fn a_slit_square_of_the_plane() {
    let domain = slit();
    let size = SizeFunction::new(&domain, &SizeOptions::new(0.25)).unwrap();
    let at = |x| size.at(x);
    let rules = Rules { size: &at, lipschitz: 0.25, seed: 1, most: 1 << 24 };
    let made = generate(&domain, rules, &mut Alone { seed: 1 }).unwrap();
    is_sound(&domain, &made);
    assert!(made.vertices.len() > 20);
}

#[test]
fn a_wedge_of_ten_degrees() {
    // Inside of a box, so that the wedge's facets are not on the hull.
    let mut input = cube();
    let (x, y) = (10f64.to_radians().cos() * 2.0, 10f64.to_radians().sin() * 2.0);
    let base = input.points.len() as u32;
    for z in [1.0, 3.0] {
        input.points.extend([[1., 1., z], [3., 1., z], [1. + x, 1. + y, z]].map(DVec3::from));
    }
    for f in [&[0, 1, 2][..], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]] {
        let f: Vec<u32> = f.iter().map(|v| v + base).collect();
        facet(&mut input, &[&f]);
    }
    let (domain, made) = meshed(&input, 0.25, None);
    is_sound(&domain, &made);
    let alone = crate::input::Input { facets: input.facets.split_off(6), ..input };
    let (domain, made) = meshed(&alone, 0.25, None);
    is_sound(&domain, &made);
}

/// The largest R / l of the cells.
fn worst_ratio(made: &Generated<DVec3>) -> f64 {
    let inside = made.delaunay.cells.iter().zip(&made.labels.of).filter(|(_, l)| **l < Labels::FLAT);
    let ratio = |c: &[u32; 4]| {
        let corners = c.map(|v| made.vertices.points[v as usize]);
        (circumradius2(&corners) / shortest_edge2(&corners)).sqrt()
    };
    inside.map(|(c, _)| ratio(c)).fold(0.0, f64::max)
}

/// Points on which nothing lies on an axis, and what is flat is so but for rounding.
fn turned(points: &mut [DVec3]) {
    let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    for p in points {
        *p = turn * *p;
    }
}

/// A torus of quadrangles, each two triangles that are coplanar but for rounding: no angle between facets is small,
/// plane angles are.
fn torus(u: u32, v: u32) -> Input<DVec3> {
    let angle = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for (i, j) in (0..u).flat_map(|i| (0..v).map(move |j| (i, j))) {
        let (a, b) = (angle(i, u), angle(j, v));
        let r = 2.0 + 0.7 * b.cos();
        points.push(DVec3::new(r * a.cos(), r * a.sin(), 0.7 * b.sin()));
        let at = |i: u32, j: u32| i % u * v + j % v;
        let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        faces.extend([vec![p, q, r], vec![p, r, s]]);
    }
    Input::surface(points, faces)
}

/// A disc with `n` corners, whose top is a fan from one of them and whose bottom is a fan from the next: needles that lie
/// in one plane but for rounding.
fn fans(n: u32) -> Input<DVec3> {
    let corner = |i: u32, z: f64| {
        let a = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        DVec3::new(a.cos(), a.sin(), z)
    };
    let mut points: Vec<DVec3> = (0..2 * n).map(|i| corner(i % n, if i < n { 0.0 } else { 0.4 })).collect();
    turned(&mut points);
    let mut faces = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        faces.extend([vec![i, j, n + j], vec![i, n + j, n + i]]);
    }
    for i in 1..n - 1 {
        faces.extend([vec![n, n + i, n + i + 1], vec![1, (i + 2) % n, i + 1]]);
    }
    Input::surface(points, faces)
}

#[test]
fn a_torus_whatever_the_slope() {
    for (lipschitz, most) in [(0.06, 6.0), (0.12, 6.0), (0.25, 6.0), (0.5, 6.0)] {
        let (domain, made) = meshed(&torus(12, 8), lipschitz, None);
        is_sound(&domain, &made);
        assert!(worst_ratio(&made) < most, "{lipschitz}: {}", worst_ratio(&made));
        let forced = made.stages.iter().find(|s| s.name == "force").unwrap();
        assert!(forced.completion <= 12, "{forced:?}");
    }
}

#[test]
fn fans_of_needles() {
    let (domain, made) = meshed(&fans(16), 0.5, None);
    assert!(domain.small_angles(12.0).len() > 20);
    is_sound(&domain, &made);
    assert!(worst_ratio(&made) < 40.0, "{}", worst_ratio(&made));
}

#[test]
fn without_small_angles_nothing_is_forced() {
    let (_, made) = meshed(&cube(), 0.25, Some(0.5));
    assert!(made.stages.iter().all(|s| s.name != "force"), "{:?}", made.stages);
}

#[test]
fn slivers_are_taken_out() {
    for (input, size) in [(cube(), 0.35), (cube(), 0.2)] {
        let (domain, made) = meshed(&input, 0.5, Some(size));
        let mut mesh = made.into_mesh(&domain);
        let least = |mesh: &Mesh<DVec3>| {
            let sines = (0..mesh.cells.len() as u32).map(|c| least_sine(&mesh.corners(c)));
            sines.fold(1.0f64, f64::min).asin().to_degrees()
        };
        let before = least(&mesh);
        let done = improve(&domain, &mut mesh, &Target::default());
        eprintln!("{} cells, {before} to {} degrees, {done:?}", mesh.cells.len(), least(&mesh));
        assert!(crate::conformity::check(&domain, &mesh).is_clean());
        assert!(least(&mesh) >= 14.0, "{} degrees", least(&mesh));
    }
}

/// What a machine may do to a triangulation: cells in another order, and their vertices turned.
struct Shuffled(Alone);

impl Machine<DVec3> for Shuffled {
    type Error = <Alone as Machine<DVec3>>::Error;

    fn independent(&mut self, sites: &[Site<DVec3>], fixed: usize) -> Result<Independent, Self::Error> {
        self.0.independent(sites, fixed)
    }

    fn delaunay(&mut self, points: &[DVec3]) -> Result<Triangulation<[u32; 4]>, Self::Error> {
        let Triangulation { mut cells, mut neighbours } = self.0.delaunay(points)?;
        let last = cells.len() as u32 - 1;
        cells.reverse();
        neighbours.reverse();
        for row in cells.iter_mut().chain(&mut neighbours) {
            // An even permutation.
            row.rotate_left(1);
            row.swap(0, 1);
        }
        for code in neighbours.iter_mut().flatten().filter(|c| **c != u32::MAX) {
            *code = last - *code;
        }
        Ok(Triangulation { cells, neighbours })
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Self::Error> {
        let mut made = Machine::<DVec3>::planar(&mut self.0, sets)?;
        for subfacets in &mut made {
            subfacets.reverse();
            for t in subfacets.iter_mut() {
                t.rotate_left(1);
            }
        }
        Ok(made)
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}

#[test]
fn the_order_of_a_machines_cells_does_not_matter() {
    let domain = crate::check(&cube()).unwrap();
    let mut options = SizeOptions::new(0.25);
    options.constraints.most = Some(0.6);
    let size = SizeFunction::new(&domain, &options).unwrap();
    let at = |x| size.at(x);
    let rules = Rules { size: &at, lipschitz: 0.25, seed: 3, most: 1 << 24 };
    let alone = generate(&domain, rules, &mut Alone { seed: 3 }).unwrap().into_mesh(&domain);
    let other = generate(&domain, rules, &mut Shuffled(Alone { seed: 3 })).unwrap().into_mesh(&domain);
    assert!(alone.cells.len() > 1000);
    assert!(alone == other);
}

/// A facet with a blunt corner, at which a segment on either side comes close to its middle: from the corner the arc between
/// the facet's edges has no cap without an end of a segment, on spheres of any radius.
#[test]
fn a_corner_with_segments_on_both_sides_of_a_facet() {
    for (opening, rise) in [(0.9, 0.2), (1.4, 0.5), (1.4, 0.9)] {
        let points = [[0., 0., 0.], [1., opening, 0.], [1., -opening, 0.], [2.5, 0., rise], [2.5, 0., -rise]];
        let mut input = Input::new(crate::input::Kind::Complex, points.map(DVec3::from).to_vec());
        for triangle in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3], [0, 1, 4], [0, 2, 4], [1, 2, 4]] {
            facet(&mut input, &[&triangle]);
        }
        let (domain, made) = meshed(&input, 0.5, None);
        is_sound(&domain, &made);
        let shortest =
            made.delaunay.cells.iter().map(|c| shortest_edge2(&c.map(|v| made.vertices.points[v as usize])));
        assert!(shortest.fold(f64::INFINITY, f64::min) > 1e-6);
    }
}

/// Far from a facet's border centres in its balls are lifted, and no ball is left wider than 5/4 of the size.
#[test]
fn balls_above_a_facet_are_at_most_five_quarters_wide() {
    let domain = crate::check(&cube()).unwrap();
    let size = 0.25;
    let mut checked = 0;
    for seed in 1..4 {
        let rules = Rules { size: &|_| size, lipschitz: 0.0, seed, most: 1 << 24 };
        let made = generate(&domain, rules, &mut Alone { seed }).unwrap();
        for cell in &made.delaunay.cells {
            let corners = cell.map(|v| made.vertices.points[v as usize]);
            let (centre, radius) = (circumcentre(&corners), circumradius2(&corners).sqrt());
            let mut gaps = centre.to_array().map(|x| x.min(4.0 - x));
            gaps.sort_unstable_by(f64::total_cmp);
            if gaps[1] < 3.0 * size {
                continue;
            }
            let most = if gaps[0] > size { 1.0 } else { 1.25 };
            assert!(radius <= most * size * (1.0 + 1e-6), "{radius} at {centre}");
            checked += usize::from(gaps[0] <= size);
        }
    }
    assert!(checked > 2000, "{checked} cells");
}
