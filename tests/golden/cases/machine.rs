//! Runs of the machine: sets, workers, supergraphs, transports, baselines, faults.

use super::Case;
use crate::calls::{
    Cloud, Crew, Last, Order, Sharing, Supergraph, Wire, count_until, incremental, independent_set, run,
};
use crate::record::Record;
use crate::sets::{KINDS, cloud, sunken};

const CREWS: [Crew; 5] = [Crew::Of(1), Crew::Of(3), Crew::Of(16), Crew::Of(64), Crew::Leaves];

/// Points of a set in the plane and in space.
fn number(dimension: usize) -> usize {
    if dimension == 2 { 900 } else { 700 }
}

fn order(crew: Crew, wire: Wire) -> Order {
    Order {
        crew,
        wire,
        leaf: 40,
        supergraph: Supergraph::Density(None),
        sharing: Sharing::Ghost,
        planes: false,
        naive: false,
        cap: None,
        picture: 0,
        fault: None,
    }
}

/// Channels for the odd ones, the simulator for the others.
fn wire_of(i: usize) -> Wire {
    if i % 2 == 1 { Wire::Threads(2) } else { Wire::Sim(7) }
}

fn crew_name(crew: Crew) -> String {
    match crew {
        Crew::Of(workers) => workers.to_string(),
        Crew::Leaves => "leaves".to_owned(),
    }
}

/// Every case of the machine.
pub fn cases() -> Vec<Case> {
    let mut cases = transports();
    cases.extend(supergraphs());
    cases.extend(baselines());
    cases.extend(others());
    for dimension in [2, 3] {
        for kind in KINDS {
            cases.extend(set(kind, dimension));
        }
    }
    cases
}

/// `triangulate` and `simulate` with all crews, and with separators refused.
fn set(kind: &'static str, dimension: usize) -> [Case; 3] {
    let points = move || cloud(kind, dimension, number(dimension));
    let all = move |record: &mut Record, counted: bool| {
        let points = points();
        for (i, crew) in CREWS.into_iter().enumerate() {
            let made = run(&points, &order(crew, wire_of(i)), counted);
            record.run(&crew_name(crew), made.as_ref());
        }
        if kind == "flat" {
            let made = run(&sunken(dimension, 200), &order(Crew::Of(3), Wire::Sim(1)), counted);
            record.run("sunken", made.as_ref());
        }
    };
    let name = |what: &str| format!("{what}-{kind}-{dimension}d");
    let refused = move |record: &mut Record| {
        let points = points();
        for (i, fault) in ["refuse-draws:2", "refuse-draws:3"].into_iter().enumerate() {
            for crew in [Crew::Of(3), Crew::Of(16), Crew::Leaves] {
                refuse(record, &points, &Order { fault: Some(fault), ..order(crew, wire_of(i)) });
            }
        }
    };
    let mut refused = Case::new(name("refuse-draws"), refused);
    refused.retries = true;
    [
        Case::new(name("triangulate"), move |record| all(record, false)),
        Case::new(name("simulate"), move |record| all(record, true)),
        refused,
    ]
}

/// Both ways of running with refused draws.
fn refuse(record: &mut Record, points: &Cloud, order: &Order) {
    for (what, counted) in [("triangulate", false), ("simulate", true)] {
        let made = run(points, order, counted);
        if let (Some(made), Crew::Leaves) = (&made, order.crew) {
            record.retries += made.retries;
        }
        let fault = order.fault.unwrap_or_default();
        record.run(&format!("{what}/{fault}/{}", crew_name(order.crew)), made.as_ref());
    }
}

/// One case a supergraph and rule.
fn supergraphs() -> Vec<Case> {
    use Sharing::{Both, Ghost, Smaller};
    use Supergraph::{Density, Knn, KnnLog, Overlap};
    let all = [
        ("density-ghost", Density(Some(2.5)), Ghost),
        ("density-both", Density(Some(2.5)), Both),
        ("density-smaller", Density(Some(2.5)), Smaller),
        ("density-auto-both", Density(None), Both),
        ("overlap-ghost", Overlap(None), Ghost),
        ("overlap-both", Overlap(Some(2.5)), Both),
        ("knn-ghost", Knn(Some(20)), Ghost),
        ("knn-both", Knn(None), Both),
        ("knn-log-ghost", KnnLog(3.0), Ghost),
    ];
    let case = |(name, supergraph, sharing)| {
        Case::new(format!("supergraph-{name}"), move |record| {
            let sets =
                [("uniform", 3, Crew::Of(16)), ("clusters", 2, Crew::Of(3)), ("grid", 3, Crew::Leaves)];
            for (i, (kind, dimension, crew)) in sets.into_iter().enumerate() {
                let order = Order { supergraph, sharing, ..order(crew, wire_of(i)) };
                let made = run(&cloud(kind, dimension, number(dimension)), &order, true);
                record.run(&format!("{kind}-{dimension}d/{}", crew_name(crew)), made.as_ref());
            }
        })
    };
    all.into_iter().map(case).collect()
}

/// Other ways to cut, to correct, and to triangulate.
fn baselines() -> Vec<Case> {
    let with = |record: &mut Record, counted: bool, change: &dyn Fn(Order) -> Order| {
        for (kind, dimension) in [("uniform", 3), ("clusters", 2), ("duplicates", 3)] {
            let points = cloud(kind, dimension, number(dimension));
            for (i, crew) in [Crew::Of(1), Crew::Of(3), Crew::Leaves].into_iter().enumerate() {
                let made = run(&points, &change(order(crew, wire_of(i))), counted);
                record.run(&format!("{kind}-{dimension}d/{}", crew_name(crew)), made.as_ref());
            }
        }
    };
    let planes = |order: Order| Order { planes: true, ..order };
    let naive = |order: Order| Order { naive: true, ..order };
    vec![
        Case::new("baseline-planes-triangulate", move |record| with(record, false, &planes)),
        Case::new("baseline-planes-simulate", move |record| with(record, true, &planes)),
        Case::new("baseline-bottom-up", move |record| with(record, true, &naive)),
        Case::new("baseline-incremental", |record| {
            for kind in KINDS {
                for dimension in [2, 3] {
                    let made = incremental(&cloud(kind, dimension, number(dimension)));
                    record.run(&format!("{kind}-{dimension}d"), Some(&made));
                }
            }
        }),
    ]
}

/// The same set over every transport.
fn transports() -> Vec<Case> {
    let over = |record: &mut Record, wires: &[(&str, Wire)]| {
        for (kind, dimension, crew) in
            [("uniform", 3, Crew::Of(8)), ("clusters", 2, Crew::Of(3)), ("grid", 2, Crew::Leaves)]
        {
            let points = cloud(kind, dimension, number(dimension));
            for (name, wire) in wires {
                for (what, counted) in [("triangulate", false), ("simulate", true)] {
                    let made = run(&points, &order(crew, *wire), counted);
                    record.run(&format!("{what}/{kind}-{dimension}d/{name}"), made.as_ref());
                }
            }
        }
    };
    let sim = [("sim-0", Wire::Sim(0)), ("sim-1", Wire::Sim(1)), ("sim-99", Wire::Sim(99))];
    let threads =
        [("threads-1", Wire::Threads(1)), ("threads-2", Wire::Threads(2)), ("threads-5", Wire::Threads(5))];
    vec![
        Case::new("transport-sim", move |record| over(record, &sim)),
        Case::new("transport-channel", move |record| over(record, &threads)),
    ]
}

/// Gathered regions, pictures, records, runs that stop, independent sets, planted faults.
fn others() -> Vec<Case> {
    let on = |record: &mut Record, orders: &[(&str, Order)]| {
        for (kind, dimension) in [("uniform", 3), ("clusters", 2)] {
            let points = cloud(kind, dimension, number(dimension));
            for (name, order) in orders {
                let made = run(&points, order, true);
                record.run(&format!("{kind}-{dimension}d/{name}"), made.as_ref());
            }
        }
    };
    let base = order(Crew::Of(7), Wire::Threads(2));
    let small = |cap| Order { cap, supergraph: Supergraph::Density(Some(1.1)), ..base.clone() };
    let repaired = [("repaired", small(None)), ("capped-0", small(Some(0))), ("capped-2", small(Some(2)))];
    let pictures = [
        ("of-50", Order { picture: 50, ..base.clone() }),
        ("of-all", Order { picture: 20_000, crew: Crew::Leaves, ..base.clone() }),
    ];
    let fault =
        |fault| Order { fault: Some(fault), supergraph: Supergraph::Density(Some(2.5)), ..base.clone() };
    let faults = [
        "refuse:1",
        "refuse:2-3",
        "refuse:4-7",
        "small-sphere",
        "halve-alpha",
        "spoil:1",
        "one-clock",
        "free-loop",
    ]
    .map(|text| (text, fault(text)));
    vec![
        Case::new("repair", move |record| on(record, &repaired)),
        Case::new("picture", move |record| on(record, &pictures)),
        Case::new("faults", move |record| on(record, &faults)),
        Case::new("until", |record| {
            for (kind, dimension, crew) in [("uniform", 3, Crew::Leaves), ("clusters", 2, Crew::Of(5))] {
                let points = cloud(kind, dimension, 3 * number(dimension));
                for (name, last) in [("partition", Last::Partition), ("neighbours", Last::Neighbours)] {
                    let counts = count_until(&points, &order(crew, Wire::Threads(2)), last);
                    record.counts(&format!("{kind}-{dimension}d/{name}"), &counts);
                }
            }
        }),
        Case::new("independent-sets", |record| {
            for (kind, dimension) in [("uniform", 2), ("uniform", 3), ("clusters", 3)] {
                let points = cloud(kind, dimension, number(dimension));
                let n = points.coordinates.len() / dimension;
                let sizes: Vec<f64> = (0..n).map(|i| 0.05 + 0.02 * (i % 5) as f64).collect();
                for (i, crew) in CREWS.into_iter().enumerate() {
                    let made = independent_set(&points, &sizes, 0, &order(crew, wire_of(i)));
                    record.run(&format!("{kind}-{dimension}d/{}", crew_name(crew)), Some(&made));
                }
            }
        }),
    ]
}
