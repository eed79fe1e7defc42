//! Cells that ask for a point in their circumsphere: the cells are those of splaying, and no count depends on the workers.

use septet_core::generate::Kind;
use septet_core::spec::{Graph, Neighbours, Repair, Workers};
use septet_core::{Outcome, Spec, simulate};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

use crate::common::sets::{plane, space};
use crate::common::{assert_same_counts, assert_verified, simulated};

fn run<P: Point>(points: &[P], workers: u32, repair: Repair, fault: Option<&str>) -> Outcome {
    let spec: Spec = simulated(Workers::Count(workers), 0, 30).with(|c| {
        c.recursion.graph = Graph::Knn { k: Neighbours::Count(8) };
        c.recursion.repair = repair;
        c.planted.fault = fault.map(|text| text.parse().unwrap());
    });
    simulate(points, &spec).unwrap()
}

/// Returns the numbers of cells that asked and of leaves that they visited.
fn asked(run: &Outcome) -> (u64, u64) {
    let rounds = || run.ledger.part.rounds.values();
    (rounds().map(|tally| tally.probes).sum(), rounds().map(|tally| tally.probe_visits).sum())
}

fn check<P: Point>(points: &[P], what: &str) {
    let splayed = run(points, 1, Repair::Splay, None);
    assert_eq!(asked(&splayed), (0, 0), "{what}");
    assert!(splayed.ledger.phases.iter().all(|total| total.phase != Phase::ProbeCells || total.work == 0));
    let probed = run(points, 1, Repair::Probe, None);
    assert_verified(points, &probed);
    let (asks, visits) = asked(&probed);
    assert!(asks > 0 && asks <= visits, "{what}: {asks} cells visited {visits} leaves");
    for workers in [1, 3, 16] {
        let what = format!("{what}, {workers} workers");
        let other = run(points, workers, Repair::Probe, None);
        assert!(other.cells() == splayed.cells(), "{what}: cells");
        assert_eq!(
            (asked(&other), other.exchange_rounds),
            ((asks, visits), probed.exchange_rounds),
            "{what}"
        );
        assert_same_counts(&other.ledger, &probed.ledger, &what);
        // Without answers, cells are only told.
        let blind = run(points, workers, Repair::Probe, Some("blind-probes"));
        assert!(blind.exchange_rounds >= probed.exchange_rounds, "{what}");
        assert!(blind.cells() == splayed.cells(), "{what}: cells without answers");
    }
}

#[test]
fn probes_find_the_cells_of_splaying() {
    for kind in [Kind::Body, Kind::Uniform, Kind::Grid, Kind::Sphere, Kind::Line] {
        check(&space(kind, 700, 3), &format!("{kind} in space"));
    }
    // Cells of a moment curve ask all leaves that their balls meet, in the later rounds.
    check(&space(Kind::MomentCurve, 150, 3), "moment curve in space");
    for kind in [Kind::Body, Kind::Uniform, Kind::Clusters] {
        check(&plane(kind, 900, 3), &format!("{kind} in the plane"));
    }
}

#[test]
fn bodies_need_few_rounds() {
    let points = space(Kind::Body, 3000, 1);
    let [probed, splayed] = [Repair::Probe, Repair::Splay].map(|repair| run(&points, 1, repair, None));
    let rounds = (probed.exchange_rounds, splayed.exchange_rounds);
    assert!(3 * rounds.0 < rounds.1, "{rounds:?}");
}
