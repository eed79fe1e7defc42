//! Smoke.
use glam::{DVec2, DVec3};
use septet::config::*;
use septet::verify::{VerifyOptions, verify};
use septet::*;

fn rng(seed: u64) -> impl FnMut() -> f64 {
    let mut s = seed;
    move || {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn smoke() {
    let mut r = rng(5);
    let pts: Vec<DVec3> = (0..3000).map(|_| DVec3::new(r(), r(), r())).collect();
    let grid: Vec<DVec3> =
        (0..1000).map(|i| DVec3::new((i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64)).collect();
    let flat: Vec<DVec2> = (0..2000).map(|_| DVec2::new(r(), r())).collect();
    go(&pts);
    go(&grid);
    go(&flat);
}

fn go<P: geometry::point::Point>(pts: &[P]) {
    let mut reference: Option<Run> = None;
    let mut counts = None;
    for (graph, sets) in [
        (GraphKind::Density, SeparatorSets::Ghost),
        (GraphKind::Density, SeparatorSets::Both),
        (GraphKind::Density, SeparatorSets::Smaller),
        (GraphKind::Overlap, SeparatorSets::Ghost),
        (GraphKind::Overlap, SeparatorSets::Both),
        (GraphKind::Knn, SeparatorSets::Ghost),
        (GraphKind::Knn, SeparatorSets::Both),
    ] {
        for p in [1u32, 2, 3, 8, 64] {
            for sim in [false, true] {
                for counted in [false, true] {
                    let config = Config {
                        workers: Workers::Count(p),
                        leaf: Some(60),
                        graph,
                        sets,
                        keep_graph: true,
                        threads: 2,
                        transport: if sim {
                            Transport::Sim { delivery_seed: p as u64 }
                        } else {
                            Transport::Channel { threads: 2 }
                        },
                        ..Config::default()
                    };
                    let t = std::time::Instant::now();
                    let run = if counted { simulate(pts, &config) } else { triangulate(pts, &config) };
                    let run =
                        run.unwrap_or_else(|e| panic!("{graph:?} {sets:?} p{p} sim {sim} {counted}: {e}"));
                    if p == 3 && !sim {
                        println!(
                            "{graph:?} {sets:?} {counted} {:?} rounds {} repaired {} fallback {:?} {:?} work {} depth {} {:?}",
                            run.settled.supergraph,
                            run.exchange_rounds,
                            run.stars_repaired,
                            run.fallback,
                            t.elapsed(),
                            run.ledger.paper.work,
                            run.ledger.paper.depth,
                            run.ledger.repair
                        );
                    }
                    if let Some(a) = &reference {
                        assert_eq!(a.cells.len(), run.cells.len());
                        assert!(a.cells == run.cells, "{graph:?} {sets:?} p{p} sim {sim} {counted}");
                    } else {
                        let coords: Vec<f64> = pts
                            .iter()
                            .flat_map(|q| (0..P::DIM).map(|i| q.coord(i)).collect::<Vec<_>>())
                            .collect();
                        let report = verify(
                            &run.view(&coords),
                            &VerifyOptions { perturbed: true, ..Default::default() },
                            &mut |_, _, _| {},
                        );
                        assert!(report.passed(), "{report:?}");
                        reference = Some(run.clone());
                    }
                    if counted {
                        let c = (
                            run.ledger.paper,
                            run.ledger.repair,
                            run.graph.clone(),
                            run.ledger.part.edge_hash,
                            run.ledger.clone(),
                        );
                        match &counts {
                            Some((g, c0)) if *g == (graph, sets) => {
                                let c0: &(_, _, _, _, septet::protocol::ledger::Ledger) = c0;
                                for (k, v) in &c0.4.part.charges {
                                    if run.ledger.part.charges.get(k) != Some(v) {
                                        println!("{k:?} {v:?} {:?}", run.ledger.part.charges.get(k));
                                    }
                                }
                                for (k, v) in &c0.4.part.nodes {
                                    if run.ledger.part.nodes.get(k) != Some(v) {
                                        println!("{k:?} {v:?} {:?}", run.ledger.part.nodes.get(k));
                                    }
                                }
                                assert_eq!(c0.0, c.0, "{graph:?} {sets:?} p{p} sim {sim}");
                                assert_eq!(c0.1, c.1, "{graph:?} {sets:?} p{p} sim {sim}");
                                assert!(c0.2 == c.2);
                                assert_eq!(c0.3, c.3);
                            }
                            _ => counts = Some(((graph, sets), c)),
                        }
                    }
                }
            }
        }
    }
}
