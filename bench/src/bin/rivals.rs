//! Sphere separators against k-d planes, by counts alone: balance, separators, replication, depth, rounds,
//! messages and bytes, on one distribution after the other. See `README.md`.

use septet::config::{Partition, Transport, Workers};
use septet::geometry::graph::Supergraph;
use septet::geometry::point::Point;
use septet::model::Points;
use septet::protocol::ids::Phase;
use septet::{Config, Run, simulate};

/// Arguments, in order, with what they are by default.
const USAGE: &str =
    "rivals [SIZES=10000] [WORKERS=16,64] [SEEDS=3] [KINDS=uniform,graded,clusters,slab,sphere] [D=3]";

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_string());
    let kinds = word(3, "uniform,graded,clusters,slab,sphere");
    let seeds: u64 = word(2, "3").parse().expect(USAGE);
    println!("{}", header());
    for n in word(0, "10000").split(',') {
        for kind in kinds.split(',') {
            for workers in word(1, "16,64").split(',') {
                for partition in [Partition::Sphere, Partition::Kd] {
                    let mut sum = Counts::default();
                    for seed in 1..=seeds {
                        let spec = format!("{kind}:{n},d={},seed={seed}", word(4, "3"));
                        sum.add(&count(&spec, workers.parse().expect(USAGE), seed, partition));
                    }
                    println!("{}", sum.row(kind, n, workers, partition, seeds));
                }
            }
        }
    }
}

fn count(spec: &str, workers: u32, seed: u64, partition: Partition) -> Run {
    let request = septet::generate::parse_sample(spec).expect("a known kind");
    let set = septet::generate::generate(&request, &mut |_, _, _| {}).expect("points");
    let config = Config {
        workers: Workers::Count(workers),
        threads: 2,
        transport: Transport::Channel { threads: 2 },
        spacing: set.spacing.map(|s| s.lipschitz),
        seed,
        partition,
        ..Config::default()
    };
    match &set.points {
        Points::Plane(points) => counted(points, &config),
        Points::Space(points) => counted(points, &config),
    }
}

fn counted<P: Point>(points: &[P], config: &Config) -> Run {
    simulate(points, config).expect("a certified result")
}

/// What is compared, summed over the seeds; largest values are the largest over the seeds.
#[derive(Default)]
struct Counts {
    supergraphs: Vec<String>,
    levels: u64,
    leaves: u64,
    split_sum: f64,
    splits: f64,
    split_largest: f64,
    attempts: u64,
    crossing_sum: f64,
    crossing_largest: f64,
    separator_points: u64,
    members: u64,
    points: u64,
    depth: u64,
    work: u64,
    rounds: u64,
    messages: u64,
    bytes: u64,
    exchange_rounds: u64,
    gathered: u64,
}

impl Counts {
    fn add(&mut self, run: &Run) {
        let name = match run.settled.supergraph {
            Some(Supergraph::Density { alpha }) => format!("density {alpha:.3}"),
            Some(Supergraph::Overlap { alpha }) => format!("overlap {alpha:.3}"),
            Some(Supergraph::Knn { k }) => format!("knn {k}"),
            None => "none".to_string(),
        };
        if !self.supergraphs.contains(&name) {
            self.supergraphs.push(name);
        }
        let nodes = &run.ledger.part.nodes;
        self.levels += u64::from(nodes.keys().map(|node| node.level()).max().unwrap_or(0));
        let power = 1.0 - 1.0 / run.space as f64;
        for facts in nodes.values() {
            self.members += facts.members;
            if facts.is_leaf() {
                self.leaves += 1;
                continue;
            }
            let m = facts.population as f64;
            let split = facts.inside.max(facts.population - facts.inside) as f64 / m;
            let crossing = facts.crossing_inside + facts.crossing_outside;
            let ratio = crossing as f64 / m.powf(power);
            self.splits += 1.0;
            self.split_sum += split;
            self.split_largest = self.split_largest.max(split);
            self.attempts += facts.attempts;
            self.crossing_sum += ratio;
            self.crossing_largest = self.crossing_largest.max(ratio);
            self.separator_points += crossing;
        }
        self.points += run.points.used;
        self.depth += run.ledger.paper.depth;
        self.work += run.ledger.paper.work;
        // Reading and collecting are the same for both.
        let sent = run.ledger.phases.iter().filter(|p| !matches!(p.phase, Phase::Load | Phase::Collect));
        for phase in sent {
            self.rounds += phase.rounds;
            self.messages += phase.messages;
            self.bytes += phase.bytes;
        }
        self.exchange_rounds += run.exchange_rounds;
        self.gathered += run.fallback.as_ref().map_or(0, |f| f.1);
    }

    fn row(&self, kind: &str, n: &str, workers: &str, partition: Partition, seeds: u64) -> String {
        let mean = |x: u64| format!("{:.1}", x as f64 / seeds as f64);
        let splits = self.splits.max(1.0);
        let points = self.points.max(1) as f64;
        let cells = [
            kind.to_string(),
            n.to_string(),
            workers.to_string(),
            partition.name().to_string(),
            self.supergraphs.join(", "),
            mean(self.levels),
            mean(self.leaves),
            format!("{:.3} ({:.3})", self.split_sum / splits, self.split_largest),
            format!("{:.2}", self.attempts as f64 / splits),
            format!("{:.2} ({:.2})", self.crossing_sum / splits, self.crossing_largest),
            format!("{:.2}", self.separator_points as f64 / points),
            format!("{:.2}", self.members as f64 / points),
            mean(self.depth),
            format!("{:.3e}", self.work as f64 / seeds as f64),
            mean(self.rounds),
            mean(self.messages),
            format!("{:.2}", self.bytes as f64 / seeds as f64 / 1e6),
            format!("{}, {}", mean(self.exchange_rounds), mean(self.gathered)),
        ];
        format!("| {} |", cells.join(" | "))
    }
}

/// The head of the table, in Markdown.
fn header() -> String {
    let names = [
        "set",
        "n",
        "p",
        "cut",
        "supergraph",
        "levels",
        "leaves",
        "split mean (max)",
        "attempts",
        "separator / m^(1-1/d) mean (max)",
        "separator points / n",
        "members / n",
        "depth",
        "work",
        "rounds",
        "messages",
        "MB",
        "exchange rounds, gathered",
    ];
    format!("| {} |\n|{}", names.join(" | "), "---|".repeat(names.len()))
}
