//! Counts of meshes.

use glam::{DVec2, DVec3};

use super::pipeline::{Dimension, Made, MeshKeep, make_of};
use super::run_log::{EVALUATION, RunPhase, TRIANGULATION};
use super::{MeshSpec, Sizes};
use crate::generate::unit::Unit;
use crate::spec::Workers;

fn request(workers: u32, size: f64, by_recursion: bool) -> MeshSpec {
    let mut request = MeshSpec { by_recursion, conforming: true, improve: false, ..MeshSpec::default() };
    request.sizes = Sizes { most: Some(size), ..Sizes::default() };
    request.run.machine.workers = Workers::Count(workers);
    request
}

fn made<P: Dimension + Unit>(request: &MeshSpec) -> Made<P> {
    make_of(&P::domain().unwrap(), request, MeshKeep::default()).unwrap()
}

/// Returns the counts of the runs: their tasks, and work and depth of their phases.
fn counts<P: Dimension>(made: &Made<P>, without: &str) -> Vec<(&'static str, Vec<RunPhase>)> {
    let runs = made.run_log.runs.iter().filter(|run| run.task != without);
    let phases = |phases: &[RunPhase]| phases.iter().filter(|p| p.work > 0).cloned().collect();
    runs.map(|run| (run.task, phases(&run.phases))).collect()
}

fn check<P: Dimension + Unit>(size: f64) {
    let one = made::<P>(&request(1, size, true));
    assert!(one.run_log.runs.iter().all(|run| run.work > 0 && run.depth > 0));
    let direct = made::<P>(&request(1, size, false));
    assert!(direct.mesh == one.mesh);
    assert!(direct.run_log.runs.iter().all(|run| run.work > 0 && run.depth > 0));
    for workers in [3, 16] {
        let other = made::<P>(&request(workers, size, true));
        assert!(other.mesh == one.mesh, "{workers} workers");
        assert_eq!(counts(&other, ""), counts(&one, ""), "{workers} workers");
        // The direct path triangulates the subdomains of the workers.
        let other = made::<P>(&request(workers, size, false));
        assert_eq!(counts(&other, TRIANGULATION), counts(&direct, TRIANGULATION), "{workers} workers");
        let moved = other.run_log.runs.iter().filter(|run| run.task == EVALUATION);
        assert!(moved.map(|run| run.messages).sum::<u64>() > 100);
    }
}

#[test]
fn counts_do_not_depend_on_the_number_of_workers() {
    check::<DVec2>(0.04);
    check::<DVec3>(0.2);
}

#[test]
fn phases_and_runs_add_up_to_the_stages() {
    let made = made::<DVec3>(&request(3, 0.3, false));
    for stage in &made.stages {
        let phases = made.run_log.phases.iter().filter(|line| line.stage == stage.name);
        let runs = made.run_log.runs.iter().filter(|line| line.stage == stage.name);
        let sums = phases.fold([0; 5], |[a, b, c, d, e], p| {
            [a + p.work, b + p.depth, c + p.rounds, d + p.messages, e + p.bytes]
        });
        let of_runs = runs.fold([0; 5], |[a, b, c, d, e], p| {
            [a + p.work, b + p.depth, c + p.rounds, d + p.messages, e + p.bytes]
        });
        let expected = [stage.work, stage.depth, stage.rounds, stage.messages, stage.bytes];
        assert_eq!((sums, of_runs), (expected, expected), "{}", stage.name);
    }
    assert_eq!(made.stages[0].name, super::machine::FIRST_STAGE);
}
