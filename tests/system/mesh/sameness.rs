//! The same mesh, bit for bit, from every machine.

use septet_core::mesh::{Boundary, MeshSpec};
use septet_core::spec::{Transport, Workers};
use septet_geometry::point::Point;
use septet_meshing::constrain::Constrain;
use septet_meshing::domain::Domain;
use septet_meshing::mesh::{Mesh, StageLine};

use super::domains::{self, AnyDomain, Problem};
use super::{made, request};

/// All that a mesh is, to the bit: `==` holds for 0 and -0.
fn bits<P: Point>(mesh: &Mesh<P>) -> (Vec<u64>, Vec<u64>) {
    let coordinates = mesh.points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).to_bits()));
    (coordinates.collect(), mesh.sizes.iter().map(|f| f.to_bits()).collect())
}

/// The part of a stage that does not depend on the machine.
fn counts(stages: &[StageLine]) -> Vec<(&str, [u64; 4])> {
    let of = |s: &StageLine| [s.candidates, s.points, s.completion_rounds, s.set_rounds];
    stages.iter().map(|s| (s.name.as_str(), of(s))).collect()
}

fn machines(base: &MeshSpec) -> Vec<MeshSpec> {
    let mut all = Vec::new();
    for (workers, delivery_seed) in [(1, 1), (2, 0), (5, 7), (8, 2), (64, 3)] {
        let workers = Workers::Count(workers);
        for (threads, transport) in [(2, Transport::Channel), (1, Transport::Sim { delivery_seed })] {
            all.push(base.clone().with(|mesh| {
                let m = &mut mesh.run.machine;
                (m.workers, m.threads, m.transport) = (workers, Some(threads), transport);
            }));
        }
    }
    all
}

fn same<P: Constrain>(domain: &Domain<P>, name: &str, base: &MeshSpec, machines: &[MeshSpec]) {
    let (first, stages) = made(domain, base).unwrap();
    let bytes = |stages: &[StageLine]| stages.iter().map(|s| s.bytes).sum::<u64>();
    let mut sent = 0;
    for machine in machines {
        let what = format!("{name}, {:?}, {:?}", machine.run.machine.workers, machine.run.machine.transport);
        let (mesh, lines) = made(domain, machine).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(bits(&mesh) == bits(&first), "{what}: other points or sizes");
        assert!(mesh.cells == first.cells && mesh.regions == first.regions, "{what}: other cells");
        assert!(mesh.faces == first.faces, "{what}: other faces");
        assert!(mesh.edges == first.edges, "{what}: other edges");
        assert!(mesh == first, "{what}: other carriers");
        assert_eq!(counts(&lines), counts(&stages), "{what}");
        sent = sent.max(bytes(&lines));
    }
    // Else it would be one machine under many names.
    assert!(sent > bytes(&stages), "{name}: {sent} bytes at most");
    println!("{name}: {} points, {} cells, {sent} bytes", first.points.len(), first.cells.len());
}

/// The request on one worker.
fn alone(base: MeshSpec) -> MeshSpec {
    base.with(|mesh| mesh.run.machine.workers = Workers::Count(1))
}

fn check_problem(problem: &Problem, lipschitz: f64, size: f64) {
    let base = alone(request(lipschitz, Some(size)));
    on(problem, &base);
}

fn on(problem: &Problem, base: &MeshSpec) {
    match &problem.domain {
        AnyDomain::Plane(domain) => same(domain, problem.name, base, &machines(base)),
        AnyDomain::Space(domain) => same(domain, problem.name, base, &machines(base)),
    }
}

/// Remeshed boundaries do not depend on the machine. They consist of projections of circumcentres, which every machine must
/// round in the same way. The points then move in the order of the mesh.
#[test]
fn remeshed_surfaces_do_not_depend_on_the_machine() {
    let base = alone(request(0.5, Some(0.5)));
    let remesh = base.with(|mesh| (mesh.boundary, mesh.improve) = (Some(Boundary::Remesh), true));
    on(&domains::torus(), &remesh);
}

#[test]
fn workers_and_transports_make_one_mesh() {
    check_problem(&domains::two_regions(), 0.5, 0.5);
    check_problem(&domains::slanted_box(), 0.25, 0.8);
    check_problem(&domains::dangling(), 0.25, 0.8);
    check_problem(&domains::map(), 0.5, 0.15);
    check_problem(&domains::airfoil(), 0.12, 0.01);
}

/// Large enough that one facet's points are more than a leaf, and the volume's many leaves.
#[test]
fn a_mesh_of_many_leaves() {
    let problem = domains::cube();
    let AnyDomain::Space(domain) = &problem.domain else { unreachable!() };
    let base = alone(request(0.5, Some(0.17)));
    let some: Vec<MeshSpec> = machines(&base)
        .into_iter()
        .filter(|m| m.run.machine.workers != Workers::Count(1))
        .step_by(2)
        .collect();
    same(domain, problem.name, &base, &some);
}
