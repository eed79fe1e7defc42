//! Every call into the library, those for meshes in a file of their own. Cases ask in the types of these files, plain
//! vectors and numbers, and get such back: when the library's paths or types change, these files do, and no golden line.

mod meshes;

use glam::{DVec2, DVec3};
pub use meshes::{MeshOrder, MeshOutcome, Shape, mesh};
pub use septet_common::sets::Draw;
use septet_core::independent;
use septet_core::spec::{
    Alpha, Correction, Graph, Neighbours, Partition, SeparatorSets, Spec, Transport, Until, Workers,
};
use septet_core::{Error, count, simulate, triangulate};
use septet_geometry::point::Point;
use septet_lab::baselines;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::{Ledger, LedgerPart};

use crate::record::Section;

/// Points, one coordinate after the other.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// 2 or 3.
    pub dimension: usize,
    /// Of all points.
    pub coordinates: Vec<f64>,
}

/// The number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crew {
    /// This number.
    Of(u32),
    /// One per leaf.
    Leaves,
}

/// The transport of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wire {
    /// Through the simulator, with this seed of the order of delivery.
    Sim(u64),
    /// Over channels between this number of threads.
    Threads(usize),
}

/// A supergraph and its parameter.
#[derive(Clone, Copy, Debug)]
pub enum Supergraph {
    /// With alpha, or by a sample.
    Density(Option<f64>),
    /// With alpha, or by a sample.
    Overlap(Option<f64>),
    /// With k, or by default.
    Knn(Option<u32>),
    /// With k as a factor of the logarithm.
    KnnLog(f64),
}

/// The sharing of separator points.
#[derive(Clone, Copy, Debug)]
pub enum Sharing {
    Ghost,
    Both,
    Smaller,
}

/// The options of a run.
#[derive(Clone, Debug)]
pub struct Order {
    pub crew: Crew,
    pub wire: Wire,
    pub leaf: u64,
    pub supergraph: Supergraph,
    pub sharing: Sharing,
    /// Whether k-d planes replace the spheres.
    pub planes: bool,
    /// Whether balls are corrected bottom-up.
    pub naive: bool,
    /// Rounds of exchange before points are gathered.
    pub cap: Option<u32>,
    /// Number of points in the picture.
    pub picture: u32,
    /// A fault as text.
    pub fault: Option<&'static str>,
}

/// The result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// In canonical order, by input index.
    pub cells: Vec<u64>,
    /// Worker and leaf of each cell.
    pub owners: Vec<u64>,
    /// Edges of the supergraph.
    pub graph: Vec<u64>,
    /// The picture as numbers.
    pub picture: Vec<u64>,
    /// Single numbers with their names.
    pub facts: Vec<(&'static str, u64)>,
    /// The ledger.
    pub counts: Vec<Section>,
    /// Draws of separators beyond the first of each node. With a worker for every leaf, only groups draw separators.
    pub retries: u64,
}

/// A phase after which a run stops.
#[derive(Clone, Copy, Debug)]
pub enum Last {
    Partition,
    Neighbours,
}

fn spec(order: &Order) -> Spec {
    let of = |alpha: Option<f64>| alpha.map_or(Alpha::Auto, Alpha::Value);
    let graph = match order.supergraph {
        Supergraph::Density(alpha) => Graph::Density { alpha: of(alpha) },
        Supergraph::Overlap(alpha) => Graph::Overlap { alpha: of(alpha), k: Neighbours::Auto },
        Supergraph::Knn(k) => Graph::Knn { k: k.map_or(Neighbours::Auto, Neighbours::Count) },
        Supergraph::KnnLog(factor) => Graph::Knn { k: Neighbours::Log(factor) },
    };
    let (transport, threads) = wire(order.wire);
    Spec::default().with(|c| {
        c.machine.workers = crew(order.crew);
        c.machine.threads = Some(threads);
        c.machine.seed = 1;
        c.recursion.graph = graph;
        c.recursion.sets = match order.sharing {
            Sharing::Ghost => SeparatorSets::Ghost,
            Sharing::Both => SeparatorSets::Both,
            Sharing::Smaller => SeparatorSets::Smaller,
        };
        c.tree.leaf = Some(order.leaf);
        c.machine.transport = transport;
        c.keep.graph = true;
        c.keep.owner = true;
        c.keep.view = Some(order.picture);
        c.planted.exchange_cap = order.cap;
        c.tree.partition = if order.planes { Partition::Kd } else { Partition::Sphere };
        c.recursion.neighbours = if order.naive { Correction::BottomUp } else { Correction::Descent };
        c.planted.fault = order.fault.map(|text| text.parse().expect("a fault"));
    })
}

fn crew(crew: Crew) -> Workers {
    match crew {
        Crew::Of(workers) => Workers::Count(workers),
        Crew::Leaves => Workers::Leaves,
    }
}

fn wire(wire: Wire) -> (Transport, usize) {
    match wire {
        Wire::Sim(delivery_seed) => (Transport::Sim { delivery_seed }, 1),
        Wire::Threads(threads) => (Transport::Channel, threads),
    }
}

fn points<P: Point>(cloud: &Cloud) -> Vec<P> {
    cloud.coordinates.chunks_exact(P::DIM).map(P::from_coords).collect()
}

/// Triangulates, counted or not. Returns `None` for an error, because its text is not golden.
pub fn run(cloud: &Cloud, order: &Order, counted: bool) -> Option<Outcome> {
    match cloud.dimension {
        2 => run_in(&points::<DVec2>(cloud), order, counted),
        _ => run_in(&points::<DVec3>(cloud), order, counted),
    }
}

fn run_in<P: Point>(points: &[P], order: &Order, counted: bool) -> Option<Outcome> {
    let spec = spec(order);
    let run = if counted { simulate(points, &spec) } else { triangulate(points, &spec) };
    match run {
        Ok(run) => Some(outcome(&run)),
        Err(Error::NotCertified { .. } | Error::Machine(_)) => None,
        Err(error) => panic!("{order:?}: {error}"),
    }
}

fn outcome(run: &septet_core::Outcome) -> Outcome {
    let owners = run.owner().unwrap_or_default().iter().map(|&rank| u64::from(rank));
    let mut facts = vec![
        ("dimension+1", (run.dimension + 1) as u64),
        ("cells", run.cell_count() as u64),
        ("input", run.points.input),
        ("used", run.points.used),
        ("duplicates", run.left_out.duplicates.len() as u64),
        ("hull", run.hull_facets),
        ("local", run.stars_local),
        ("repaired", run.stars_repaired),
        ("exchange-rounds", run.exchange_rounds),
        ("gathered", run.fallback.as_ref().map_or(0, |f| f.1)),
        ("workers", u64::from(run.settled.workers)),
        ("leaf", run.settled.leaf),
    ];
    if let Some(plan) = &run.plan {
        facts.extend([("plan-rounds", plan.rounds), ("plan-messages", plan.messages)]);
        facts.push(("plan-bytes", plan.bytes));
    }
    Outcome {
        cells: run.cells().to_vec(),
        owners: owners.chain(run.owning_leaf().unwrap_or_default().iter().copied()).collect(),
        graph: run.kept.graph.iter().flatten().flat_map(|e| [e.0, e.1]).collect(),
        picture: picture(run),
        facts,
        counts: sections(&run.ledger, &run.times.phases),
        retries: retries(&run.ledger),
    }
}

fn picture(run: &septet_core::Outcome) -> Vec<u64> {
    let Some(view) = &run.kept.picture else { return Vec::new() };
    let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let words = |numbers: &[u32]| numbers.iter().map(|&x| u64::from(x)).collect::<Vec<_>>();
    let mut all = vec![view.of, view.points, view.ghosts_omitted, view.separators_omitted];
    for part in [&view.low, &view.high, &view.positions] {
        all.extend(bits(part));
    }
    for part in [&view.leaves, &view.crossing, &view.flags] {
        all.extend(part);
    }
    for part in [&view.owner, &view.leaf, &view.ghost, &view.ghost_leaf] {
        all.extend(words(part));
    }
    for separator in &view.separators {
        all.extend([separator.node, u64::from(separator.level), separator.number.to_bits()]);
        all.extend(bits(&separator.vector));
        all.extend(bits(&separator.low));
        all.extend(bits(&separator.high));
    }
    all
}

/// Checks that every phase with work belongs to the total of its group.
fn check_groups(ledger: &Ledger) {
    for (group, sums) in ledger.totals.each() {
        let of_phases: u64 = ledger.phases.iter().filter(|p| p.phase.group() == group).map(|p| p.work).sum();
        assert_eq!(of_phases, sums.work, "the phases of {} add up to its total", group.name());
    }
    let of_phases: u64 = ledger.phases.iter().map(|p| p.work).sum();
    assert_eq!(of_phases, ledger.totals.sum().work, "every phase with work belongs to a total");
}

/// The ledger, section by section. Every field is named, so that none is left out.
fn sections(ledger: &Ledger, phases: &[(Phase, f64)]) -> Vec<Section> {
    let Ledger { part, tree, totals: groups, phases: totals, critical_path } = ledger;
    let LedgerPart { rounds, links, ranks, charges, nodes, edge_hash, balance } = part;
    let order: Vec<&str> = phases.iter().map(|(phase, _)| phase.name()).collect();
    check_groups(ledger);
    vec![
        Section::new("charges", charges),
        Section::new("links", links),
        Section::new("nodes", nodes).and_all(tree.levels()),
        Section::new("path", critical_path),
        Section::new("ranks", ranks),
        Section::new("rounds", rounds),
        Section::new("totals", totals).and_all(groups.each()).and([edge_hash, balance]).and(order),
    ]
}

fn retries(ledger: &Ledger) -> u64 {
    let rounds = ledger.part.rounds.iter();
    rounds.filter(|(key, _)| key.phase == Phase::Partition).map(|(_, tally)| tally.retries).sum()
}

/// The ledger of a run that stops after a phase.
pub fn count_until(cloud: &Cloud, order: &Order, last: Last) -> Vec<Section> {
    let until = match last {
        Last::Partition => Until::Partition,
        Last::Neighbours => Until::Neighbours,
    };
    let spec = spec(order).with(|c| {
        c.keep.graph = false;
        c.keep.owner = false;
    });
    let counts = match cloud.dimension {
        2 => count(&points::<DVec2>(cloud), Some(until), &spec),
        _ => count(&points::<DVec3>(cloud), Some(until), &spec),
    };
    let counts = counts.unwrap_or_else(|e| panic!("{order:?}: {e}"));
    sections(&counts.ledger, &counts.times.phases)
}

/// An independent set of sites with these sizes, `fixed` of them in it from the start.
pub fn independent_set(cloud: &Cloud, sizes: &[f64], fixed: usize, order: &Order) -> Outcome {
    let spec = spec(order);
    let run = match cloud.dimension {
        2 => independent(&points::<DVec2>(cloud), sizes, fixed, &spec),
        _ => independent(&points::<DVec3>(cloud), sizes, fixed, &spec),
    };
    let run = run.unwrap_or_else(|e| panic!("{order:?}: {e}"));
    let mut counts = sections(&run.ledger, &run.times.phases);
    let set = run.kept.selected.as_ref().expect("a set");
    counts.push(Section::new("undecided", &set.undecided));
    Outcome { cells: set.members.iter().map(|&member| member as u64).collect(), counts, ..Outcome::default() }
}

/// The baseline of incremental insertions in rounds.
pub fn incremental(cloud: &Cloud) -> Outcome {
    let spec = Spec::default();
    let made = match cloud.dimension {
        2 => baselines::incremental(&points::<DVec2>(cloud), &spec),
        _ => baselines::incremental(&points::<DVec3>(cloud), &spec),
    };
    let made = made.unwrap_or_else(|e| panic!("incremental insertion: {e}"));
    let facts = vec![("hull", made.hull_facets), ("used", made.points.used)];
    let counts =
        vec![Section::new("clock", [made.clock]).and(made.brent), Section::new("insertions", &made.rounds)];
    Outcome { cells: made.cells, facts, counts, ..Outcome::default() }
}
