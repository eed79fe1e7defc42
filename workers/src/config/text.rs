//! The parameters as one line of text, for workers that are started as processes.

use std::fmt;
use std::str::FromStr;

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::Phase;
use thiserror::Error;

use super::{Correction, GraphRules, Partition, SetRule, Shown, Stop, Task, TreeRules, Wanted, WorkerConfig};

/// Why a line is no configuration: the field, counted from zero.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{line}` is not a worker's configuration: field {field}")]
pub struct ConfigTextError {
    /// The line.
    pub line: String,
    /// The field that is wrong.
    pub field: usize,
}

/// Fields separated by spaces, but for what is the process's own; floating-point numbers by their bits.
impl fmt::Display for WorkerConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WorkerConfig { run, seed, task, workers, counted, tree, graph, shown, .. } = self;
        let WorkerConfig { until, exchange_cap, fault, .. } = self;
        let TreeRules { leaf, balanced, partition } = tree;
        let GraphRules { wanted, sets, correction } = graph;
        let Shown { collect_graph, with_leaves, view, record_tasks } = shown;
        write!(f, "{run} {seed} {workers} {leaf} {counted} ")?;
        match wanted {
            Wanted::Fixed(Supergraph::Density { alpha }) => write!(f, "density {}", alpha.to_bits())?,
            Wanted::Fixed(Supergraph::Overlap { alpha }) => write!(f, "overlap {}", alpha.to_bits())?,
            Wanted::Fixed(Supergraph::Knn { k }) => write!(f, "knn {k}")?,
            Wanted::AutoDensity => f.write_str("density auto")?,
            Wanted::AutoOverlap => f.write_str("overlap auto")?,
        }
        let sets = match sets {
            SetRule::Both => "both",
            SetRule::Smaller => "smaller",
            SetRule::Ghost => "ghost",
        };
        write!(f, " {sets} {collect_graph} ")?;
        match until {
            Some(phase) => write!(f, "{}", *phase as u8)?,
            None => f.write_str("-")?,
        }
        write!(f, " {with_leaves} {view} ")?;
        match exchange_cap {
            Some(cap) => write!(f, "{cap}")?,
            None => f.write_str("-")?,
        }
        match fault {
            Some(fault) => write!(f, " {fault}")?,
            None => f.write_str(" -")?,
        }
        write!(f, " {} {} {record_tasks}", partition.name(), correction.name())?;
        match task {
            Task::Delaunay => f.write_str(" -")?,
            Task::Independent { fixed } => write!(f, " {fixed}")?,
        }
        write!(f, " {balanced}")
    }
}

impl FromStr for WorkerConfig {
    type Err = ConfigTextError;

    fn from_str(line: &str) -> Result<Self, ConfigTextError> {
        let fields: Vec<&str> = line.split(' ').collect();
        let fail = |field: usize| ConfigTextError { line: line.to_string(), field };
        if fields.len() != 19 {
            return Err(fail(fields.len()));
        }
        let parameter = fields[6];
        let alpha = || parameter.parse().map(f64::from_bits).map_err(|_| fail(6));
        let wanted = match (fields[5], parameter) {
            ("density", "auto") => Wanted::AutoDensity,
            ("overlap", "auto") => Wanted::AutoOverlap,
            ("density", _) => Wanted::Fixed(Supergraph::Density { alpha: alpha()? }),
            ("overlap", _) => Wanted::Fixed(Supergraph::Overlap { alpha: alpha()? }),
            ("knn", _) => Wanted::Fixed(Supergraph::Knn { k: parse(&fields, 6).ok_or_else(|| fail(6))? }),
            _ => return Err(fail(5)),
        };
        let sets = match fields[7] {
            "both" => SetRule::Both,
            "smaller" => SetRule::Smaller,
            "ghost" => SetRule::Ghost,
            _ => return Err(fail(7)),
        };
        let until = match fields[9] {
            "-" => None,
            _ => Some(parse(&fields, 9).and_then(Phase::from_number).ok_or_else(|| fail(9))?),
        };
        let exchange_cap = match fields[12] {
            "-" => None,
            _ => Some(parse(&fields, 12).ok_or_else(|| fail(12))?),
        };
        let fault = match fields[13] {
            "-" => None,
            _ => Some(parse(&fields, 13).ok_or_else(|| fail(13))?),
        };
        let task = match fields[17] {
            "-" => Task::Delaunay,
            _ => Task::Independent { fixed: parse(&fields, 17).ok_or_else(|| fail(17))? },
        };
        let partition = match fields[14] {
            "sphere" => Partition::Sphere,
            "kd" => Partition::Kd,
            _ => return Err(fail(14)),
        };
        let correction = match fields[15] {
            "descent" => Correction::Descent,
            "naive" => Correction::Naive,
            _ => return Err(fail(15)),
        };
        Ok(WorkerConfig {
            run: parse(&fields, 0).ok_or_else(|| fail(0))?,
            seed: parse(&fields, 1).ok_or_else(|| fail(1))?,
            task,
            workers: parse(&fields, 2).ok_or_else(|| fail(2))?,
            counted: parse(&fields, 4).ok_or_else(|| fail(4))?,
            tree: TreeRules {
                leaf: parse(&fields, 3).ok_or_else(|| fail(3))?,
                balanced: parse(&fields, 18).ok_or_else(|| fail(18))?,
                partition,
            },
            graph: GraphRules { wanted, sets, correction },
            shown: Shown {
                collect_graph: parse(&fields, 8).ok_or_else(|| fail(8))?,
                with_leaves: parse(&fields, 10).ok_or_else(|| fail(10))?,
                view: parse(&fields, 11).ok_or_else(|| fail(11))?,
                record_tasks: parse(&fields, 16).ok_or_else(|| fail(16))?,
            },
            until,
            exchange_cap,
            fault,
            stop: Stop::default(),
        })
    }
}

fn parse<T: FromStr>(fields: &[&str], field: usize) -> Option<T> {
    fields.get(field)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Fault;

    #[test]
    fn every_configuration_survives_the_line() {
        let wanted = [
            Wanted::AutoDensity,
            Wanted::AutoOverlap,
            Wanted::Fixed(Supergraph::Density { alpha: 0.1 + 0.2 }),
            Wanted::Fixed(Supergraph::Overlap { alpha: 2.5 }),
            Wanted::Fixed(Supergraph::Knn { k: 64 }),
        ];
        for (i, wanted) in wanted.into_iter().enumerate() {
            let odd = i % 2 == 1;
            let config = WorkerConfig {
                run: 3,
                seed: u64::MAX,
                task: if odd { Task::Delaunay } else { Task::Independent { fixed: 7 } },
                workers: 8,
                counted: odd,
                tree: TreeRules {
                    leaf: 1000,
                    balanced: i % 3 == 1,
                    partition: [Partition::Sphere, Partition::Kd][i % 2],
                },
                graph: GraphRules {
                    wanted,
                    sets: [SetRule::Both, SetRule::Smaller, SetRule::Ghost][i % 3],
                    correction: [Correction::Naive, Correction::Descent][i % 2],
                },
                shown: Shown { collect_graph: !odd, with_leaves: odd, view: 20_000, record_tasks: odd },
                until: odd.then_some(Phase::Partition),
                exchange_cap: (!odd).then_some(9),
                fault: odd.then_some(Fault::SpoilStar { rank: 2 }),
                stop: Stop::default(),
            };
            let line = config.to_string();
            let back: WorkerConfig = line.parse().unwrap();
            assert_eq!(format!("{back:?}"), format!("{config:?}"), "{line}");
            let cut = line.rsplit_once(' ').unwrap().0;
            assert_eq!(cut.parse::<WorkerConfig>().unwrap_err().field, 18);
            let torn =
                line.replacen("density", "dense", 1).replacen("knn", "k", 1).replacen("overlap", "o", 1);
            assert_eq!(torn.parse::<WorkerConfig>().unwrap_err().field, 5);
        }
    }
}
