//! The calls that make meshes.

use std::path::Path;

use glam::DVec3;
use septet_core::mesh::run_log::{RunLine, RunLog, StagePhase};
use septet_core::mesh::{Boundary, Dimension, Made, MakeError, MeshKeep, MeshSpec, check, make_of};
use septet_core::spec::Workers;
use septet_io::read::{AnyInput, read_domain};
use septet_meshing::input::Input;
use septet_meshing::mesh::{Carrier, Edge, StageLine};

use super::{Wire, wire};
use crate::record::Section;

/// A domain.
#[derive(Clone, Debug)]
pub enum Shape {
    /// In a file beside the tests.
    File(&'static str),
    /// A closed surface.
    Surface { points: Vec<[f64; 3]>, faces: Vec<Vec<u32>> },
}

/// The options of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshOrder {
    pub workers: u32,
    pub wire: Wire,
    pub size: f64,
    /// Whether the boundary is remeshed.
    pub remesh: bool,
    pub improve: bool,
}

/// A mesh as numbers.
#[derive(Clone, Debug, Default)]
pub struct MeshOutcome {
    /// Bits of coordinates and sizes.
    pub points: Vec<u64>,
    /// The feature of each point.
    pub carriers: Vec<u64>,
    /// Cells and their regions.
    pub cells: Vec<u64>,
    /// Faces on facets: points, facet, marker, cells.
    pub faces: Vec<u64>,
    /// Edges on segments.
    pub edges: Vec<u64>,
    /// Single numbers with their names.
    pub facts: Vec<(&'static str, u64)>,
    /// Stages, runs of the machine, phases.
    pub counts: Vec<Section>,
}

/// Makes a mesh and compares it with its domain. Returns `None` if the mesh cannot be made.
pub fn mesh(shape: &Shape, order: &MeshOrder) -> Option<MeshOutcome> {
    match shape {
        Shape::File(file) => {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good").join(file);
            let read = read_domain(&path, &mut |_, _| {}).unwrap_or_else(|e| panic!("{file}: {e}"));
            match read.input {
                AnyInput::Plane(input) => mesh_in(&input, order),
                AnyInput::Space(input) => mesh_in(&input, order),
            }
        }
        Shape::Surface { points, faces } => {
            let points = points.iter().map(|&p| DVec3::from(p)).collect();
            mesh_in(&Input::surface(points, faces.iter().cloned()), order)
        }
    }
}

fn mesh_in<P: Dimension>(input: &Input<P>, order: &MeshOrder) -> Option<MeshOutcome> {
    let domain = check(input).unwrap_or_else(|defects| panic!("not a domain: {defects:?}"));
    let (transport, threads) = wire(order.wire);
    let request = MeshSpec::default().with(|mesh| {
        mesh.boundary = Some(if order.remesh { Boundary::Remesh } else { Boundary::Exact });
        mesh.sizes.most = Some(order.size);
        mesh.improve = order.improve;
        mesh.conforming = !order.improve;
        mesh.run.tree.leaf = Some(60);
        let m = &mut mesh.run.machine;
        (m.workers, m.threads) = (Workers::Count(order.workers), Some(threads));
        m.transport = transport;
    });
    let keep = MeshKeep { owned: usize::MAX, ..MeshKeep::default() };
    let made = match make_of(&domain, &request, keep) {
        Ok(made) => made,
        Err(MakeError::NotConforming(made)) => *made,
        Err(_) => return None,
    };
    Some(mesh_outcome(&made))
}

fn mesh_outcome<P: Dimension>(made: &Made<P>) -> MeshOutcome {
    let mesh = &made.mesh;
    let coordinates = mesh.points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i)).collect::<Vec<_>>());
    let on = |feature: u64, number: u32| [feature, u64::from(number)];
    let carrier = |carrier: &Carrier| match *carrier {
        Carrier::Corner(i) => on(0, i),
        Carrier::Segment(i) => on(1, i),
        Carrier::Facet(i) => on(2, i),
        Carrier::Volume => on(3, 0),
    };
    let wide = |numbers: &[u32]| numbers.iter().map(|&v| u64::from(v)).collect::<Vec<_>>();
    let mut faces = Vec::new();
    for face in &mesh.faces {
        faces.extend(wide(face.vertices.as_ref()));
        faces.extend([u64::from(face.facet), face.marker as u64]);
        faces.extend(wide(&face.cells));
    }
    let edge = |e: &Edge| {
        [u64::from(e.vertices[0]), u64::from(e.vertices[1]), u64::from(e.segment), e.marker as u64]
    };
    MeshOutcome {
        points: coordinates.chain(mesh.sizes.iter().copied()).map(f64::to_bits).collect(),
        carriers: mesh.carriers.iter().flat_map(carrier).collect(),
        cells: mesh.cells.iter().flat_map(|c| wide(c.as_ref())).chain(wide(&mesh.regions)).collect(),
        faces,
        edges: mesh.edges.iter().flat_map(edge).collect(),
        facts: vec![
            ("points", mesh.points.len() as u64),
            ("cells", mesh.cells.len() as u64),
            ("dropped", mesh.dropped),
            ("defects", made.conformity.defects.len() as u64),
            ("owned", made.owners.as_ref().map_or(0, |owners| owners.len() as u64)),
        ],
        counts: counts(&made.stages, &made.run_log),
    }
}

/// Stages, runs and phases without the measured seconds.
fn counts(stages: &[StageLine], log: &RunLog) -> Vec<Section> {
    let RunLog { runs, phases } = log;
    vec![
        Section::new("stages", stages.iter().map(|s| StageLine { seconds: 0.0, ..s.clone() })),
        Section::new("runs", runs.iter().map(|r| RunLine { seconds: 0.0, ..r.clone() })),
        Section::new("phases", phases.iter().map(|p| StagePhase { seconds: 0.0, ..p.clone() })),
    ]
}
