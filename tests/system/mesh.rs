//! `septet mesh` by library calls: small meshes of all kinds of domains, checked by counts.
//!
//! [`domains`] has the domains and what is known of them, [`sameness`] that meshes do not depend on the machine.

mod domains;
mod sameness;
mod sets;

use domains::{AnyDomain, Known, Problem};
use septet_core::mesh::{self, Boundary, MeshError, MeshSpec, generate, measure};
use septet_core::spec::Workers;
use septet_geometry::point::Point;
use septet_meshing::conformity;
use septet_meshing::constrain::Constrain;
use septet_meshing::domain::Domain;
use septet_meshing::mesh::{Mesh, OUTSIDE, StageLine};
use septet_meshing::quality::Quality;

/// The Lipschitz constants at which the promises are checked.
const CONSTANTS: [f64; 4] = [0.06, 0.12, 0.25, 0.5];

/// How far sums may be off, relative to the whole.
const SUMS: f64 = 1e-9;

/// Returns a request with a size and two workers.
fn request(lipschitz: f64, size: Option<f64>) -> MeshSpec {
    MeshSpec::default().with(|mesh| {
        mesh.boundary = Some(Boundary::Exact);
        // The promises are those of Section 5.
        (mesh.conforming, mesh.improve) = (true, false);
        (mesh.sizes.most, mesh.sizes.lipschitz) = (size, lipschitz);
        let m = &mut mesh.run.machine;
        (m.workers, m.threads) = (Workers::Count(2), Some(2));
    })
}

/// A mesh with what the machine did.
fn made<P: Constrain>(
    domain: &Domain<P>,
    request: &MeshSpec,
) -> Result<(Mesh<P>, Vec<StageLine>), MeshError> {
    generate(domain, &mesh::sizes(domain, request)?, request)
}

/// The sum of the cells' measures and of the faces' towards the outside, by plain determinants.
fn sums<P: Point>(mesh: &Mesh<P>) -> [f64; 2] {
    let at = |v: u32, i: usize| mesh.points[v as usize].coord(i);
    let simplex = |row: &[u32]| -> f64 {
        let edge = |k: usize, i: usize| at(row[k], i) - at(row[0], i);
        let minor = |k: usize, l: usize, i: usize, j: usize| {
            edge(k, i % P::DIM) * edge(l, j % P::DIM) - edge(k, j % P::DIM) * edge(l, i % P::DIM)
        };
        match (P::DIM, row.len()) {
            (2, 2) => (0..2).map(|i| edge(1, i).powi(2)).sum::<f64>().sqrt(),
            (2, _) => minor(1, 2, 0, 1) / 2.0,
            (_, 3) => (0..3).map(|i| minor(1, 2, i, i + 1).powi(2)).sum::<f64>().sqrt() / 2.0,
            _ => (0..3).map(|i| edge(1, i) * minor(2, 3, i + 1, i + 2)).sum::<f64>() / 6.0,
        }
    };
    let outer = mesh.faces.iter().filter(|face| face.cells.contains(&OUTSIDE));
    let outer = outer.filter(|face| face.cells != [OUTSIDE; 2]);
    [
        mesh.cells.iter().map(|c| simplex(c.as_ref())).sum(),
        outer.map(|face| simplex(face.vertices.as_ref())).sum(),
    ]
}

fn assert_sum(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= SUMS * expected, "{what}: {found} in place of {expected}");
}

/// The mesh tiles its domain: by the library's own check, and by sums of this file's own.
fn assert_conforms<P: Constrain>(domain: &Domain<P>, mesh: &Mesh<P>, known: &Known, what: &str) {
    let found = conformity::check(domain, mesh);
    assert!(found.is_clean(), "{what}: {:?}", &found.defects[..found.defects.len().min(5)]);
    assert!(!mesh.cells.is_empty(), "{what}: no cells");
    let [measure, boundary] = sums(mesh);
    assert_sum(measure, known.measure, what);
    if let Some(expected) = known.boundary {
        assert_sum(boundary, expected, what);
        assert_sum(found.boundary[1], expected, what);
    }
    assert_sum(boundary, found.boundary[0], what);
    let regions: std::collections::BTreeSet<u32> = mesh.regions.iter().copied().collect();
    assert_eq!(regions.len(), known.regions, "{what}: components with cells");
}

/// Sizes are Lipschitz on edges; where no features meet at less than 90 degrees both bounds hold without exception
/// and all circumcentres lie in the domain, and elsewhere a cell beyond a bound is near a feature that is named.
fn assert_promises<P: Constrain>(quality: &Quality<P>, lipschitz: f64, known: &Known, what: &str) {
    let steepest = quality.steepest.slope;
    assert!(steepest <= lipschitz * (1.0 + 1e-9), "{what}: f has slope {steepest}");
    let [free, near, above, outside] = &quality.places;
    assert!(free.promised.is_some_and(|b| (b - 1.0 / (1.0 - lipschitz)).abs() < 1e-12), "{what}");
    for promised in [near.promised, above.promised] {
        assert_eq!(promised.is_some(), lipschitz < 0.4, "{what}: {promised:?}");
    }
    let over = free.over + near.over + above.over;
    if known.right_angles {
        let worst = [free, near, above].map(|place| place.worst.first());
        assert_eq!(over, 0, "{what}: over the bound, {worst:?}");
        assert_eq!(outside.cells, 0, "{what}: circumcentres outside, {:?}", outside.worst.first());
    } else {
        let named: u64 = quality.features.iter().map(|f| f.over).sum();
        assert_eq!(named, near.over + above.over, "{what}: cells over the bound with no feature");
        assert_eq!(free.over, 0, "{what}: {:?}", free.worst.first());
    }
}

/// Rounds of independent sets: each stage has one set and one for each round of completion.
fn assert_rounds(stages: &[StageLine], what: &str) {
    for stage in stages.iter().filter(|s| s.candidates > 0) {
        let most = (stage.candidates as f64).log2() + 2.0;
        let sets = 1 + stage.completion_rounds;
        assert!(stage.set_rounds as f64 <= most * sets as f64, "{what}: {stage:?}");
        assert!(stage.set_rounds > 0 && stage.points <= stage.candidates, "{what}: {stage:?}");
    }
}

/// Makes the mesh and checks it.
fn check_request<P: Constrain>(domain: &Domain<P>, known: &Known, request: &MeshSpec, what: &str) {
    assert_eq!(domain.small_angles(90.0).is_empty(), known.right_angles, "{what}: angles");
    let size = mesh::sizes(domain, request).unwrap();
    let (mesh, stages) = generate(domain, &size, request).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_conforms(domain, &mesh, known, what);
    let quality = measure(domain, &mesh, &size, 3);
    assert_promises(&quality, request.sizes.lipschitz, known, what);
    assert_rounds(&stages, what);
    let placed: u64 = stages.iter().map(|s| s.points).sum();
    let placed = placed as usize + domain.corners.len();
    // Points that have driven out a piece at a small angle are taken away again.
    assert!(placed == mesh.points.len() || placed > mesh.points.len() && !known.right_angles, "{what}");
    println!(
        "{what}: {} points, {} cells, R/l {:.3} free, {:.3} near, slope {:.3}",
        mesh.points.len(),
        mesh.cells.len(),
        quality.places[0].most.upper,
        quality.places[1].most.upper,
        quality.steepest.slope
    );
}

/// Checks a domain at each constant, with a largest size and with nothing but the domain's own.
fn check_problem(problem: &Problem, constants: &[f64]) {
    for (&lipschitz, size) in constants.iter().flat_map(|l| [(l, Some(problem.size)), (l, None)]) {
        let what = format!("{}, L = {lipschitz}, {size:?}", problem.name);
        let request = request(lipschitz, size);
        match &problem.domain {
            AnyDomain::Plane(domain) => check_request(domain, &problem.known, &request, &what),
            AnyDomain::Space(domain) => check_request(domain, &problem.known, &request, &what),
        }
    }
}

#[test]
fn a_mesh_keeps_its_promises_in_a_cube() {
    check_problem(&domains::cube(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_an_l_shape() {
    check_problem(&domains::l_shape(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_cube_with_a_cubic_hole() {
    check_problem(&domains::cubic_hole(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_cube_with_a_tunnel() {
    check_problem(&domains::tunnel(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_two_regions_with_a_facet_between() {
    check_problem(&domains::two_regions(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_dangling_pieces() {
    check_problem(&domains::dangling_squarely(), &CONSTANTS);
    check_problem(&domains::dangling(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_slanted_box() {
    check_problem(&domains::slanted_box(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_wedge_of_ten_degrees() {
    check_problem(&domains::wedge(), &CONSTANTS);
}

#[test]
#[ignore = "needs the test data"]
fn a_mesh_keeps_its_promises_in_the_example_of_tetgen() {
    check_problem(&domains::example(), &[0.25, 0.5]);
}

#[test]
fn a_mesh_keeps_its_promises_in_an_airfoil_with_holes() {
    check_problem(&domains::airfoil(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_map_with_regions() {
    check_problem(&domains::map(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_plate_with_square_holes() {
    check_problem(&domains::plate(), &CONSTANTS);
}

#[test]
fn a_mesh_keeps_its_promises_in_a_torus_of_triangles() {
    check_problem(&domains::torus(), &[0.5]);
}

/// Figure 1: sizes fall towards a point or a line of the cube.
#[test]
fn sizes_fall_towards_singularities() {
    use septet_core::mesh::{SingularityRequest, SingularityShape};
    let problem = domains::cube();
    let AnyDomain::Space(domain) = &problem.domain else { unreachable!() };
    for (shape, least) in [(SingularityShape::Point, 0.01), (SingularityShape::Line, 0.03)] {
        for lipschitz in [0.25, 0.5] {
            let singularity = Some(SingularityRequest { shape, at: Vec::new() });
            let asked = request(lipschitz, Some(problem.size));
            let asked = asked.with(|m| (m.sizes.singularity, m.sizes.least) = (singularity, Some(least)));
            let what = format!("{shape:?} singularity, L = {lipschitz}");
            check_request(domain, &problem.known, &asked, &what);
            let (mesh, _) = made(domain, &asked).unwrap();
            let smallest = mesh.sizes.iter().copied().fold(f64::INFINITY, f64::min);
            let largest = mesh.sizes.iter().copied().fold(0.0, f64::max);
            assert!(smallest < 4.0 * least && largest > 12.0 * least, "{what}: {smallest} to {largest}");
        }
    }
}
