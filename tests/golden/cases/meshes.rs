//! Meshes of domains.

use super::Case;
use crate::calls::{MeshOrder, Wire, mesh};
use crate::domains::{Problem, complexes, surfaces};
use crate::record::Record;

const WORKERS: [u32; 3] = [1, 3, 16];

/// One case a domain.
pub fn cases() -> Vec<Case> {
    let complexes = complexes().into_iter().map(|problem| {
        Case::new(format!("mesh-{}", problem.0), move |record| {
            made(record, &problem, false, false);
        })
    });
    let surfaces = surfaces().into_iter().map(|problem| {
        Case::new(format!("mesh-{}", problem.0), move |record| {
            made(record, &problem, false, false);
            made(record, &problem, true, false);
        })
    });
    let improved = Case::new("mesh-improved", |record| {
        let problems = [complexes_named("l-shape"), complexes_named("map")];
        for problem in &problems {
            made(record, problem, false, true);
        }
    });
    complexes.chain([improved]).chain(surfaces).collect()
}

fn complexes_named(name: &str) -> Problem {
    complexes().into_iter().find(|problem| problem.0 == name).expect("a complex of this name")
}

/// With every number of workers, the odd ones over channels.
fn made(record: &mut Record, (name, shape, size): &Problem, remesh: bool, improve: bool) {
    for (i, workers) in WORKERS.into_iter().enumerate() {
        let wire = if i == 1 { Wire::Threads(2) } else { Wire::Sim(7) };
        let order = MeshOrder { workers, wire, size: *size, remesh, improve };
        let mode = if remesh { "remesh" } else { "exact" };
        record.mesh(&format!("{name}/{mode}/{workers}"), mesh(shape, &order).as_ref());
    }
}
