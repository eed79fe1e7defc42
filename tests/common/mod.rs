//! What the whole-system tests and those over pipes share.

pub mod sets;

use septet::Config;
use septet::config::{Alpha, GraphKind, Neighbours, SeparatorSets, Transport, Workers};
use septet::protocol::ledger::Ledger;

/// `workers` in the simulator.
pub fn simulated(workers: Workers, delivery_seed: u64, leaf: u64) -> Config {
    Config { workers, leaf: Some(leaf), transport: Transport::Sim { delivery_seed }, ..base() }
}

/// The defaults, free of the number of cores.
pub fn base() -> Config {
    Config {
        workers: Workers::Count(2),
        threads: 2,
        transport: Transport::Channel { threads: 2 },
        ..Config::default()
    }
}

/// The supergraphs with the rules for separator sets that are valid for them; `auto` or fixed parameters.
pub fn combinations(auto: bool) -> Vec<(GraphKind, SeparatorSets, Alpha, Neighbours)> {
    use SeparatorSets::{Both, Ghost, Smaller};
    let alpha = if auto { Alpha::Auto } else { Alpha::Value(2.5) };
    let k = if auto { Neighbours::Auto } else { Neighbours::Count(20) };
    let mut all = Vec::new();
    for sets in [Ghost, Both, Smaller] {
        all.push((GraphKind::Density, sets, alpha, Neighbours::Auto));
    }
    for sets in [Ghost, Both] {
        all.push((GraphKind::Overlap, sets, alpha, Neighbours::Auto));
        all.push((GraphKind::Knn, sets, Alpha::Auto, k));
    }
    all
}

/// The configuration with another supergraph.
pub fn with_graph(config: &Config, choice: (GraphKind, SeparatorSets, Alpha, Neighbours)) -> Config {
    let (graph, sets, alpha, k) = choice;
    Config { graph, sets, alpha, k, ..config.clone() }
}

/// Panics unless everything that may not depend on workers or transport is equal.
pub fn assert_same_counts(a: &Ledger, b: &Ledger, what: &str) {
    for (key, charge) in &a.part.charges {
        assert_eq!(Some(charge), b.part.charges.get(key), "{what}: charge {key:?}");
    }
    assert_eq!(a.part.charges.len(), b.part.charges.len(), "{what}: charges");
    for (key, facts) in &a.part.nodes {
        assert_eq!(Some(facts), b.part.nodes.get(key), "{what}: facts {key:?}");
    }
    assert_eq!(a.part.nodes.len(), b.part.nodes.len(), "{what}: nodes");
    assert_eq!(a.part.edge_hash, b.part.edge_hash, "{what}: graph");
    assert_eq!(a.paper, b.paper, "{what}: the paper's phases");
    assert_eq!(a.repair, b.repair, "{what}: repair");
    assert_eq!(a.critical_path, b.critical_path, "{what}: critical path");
}
