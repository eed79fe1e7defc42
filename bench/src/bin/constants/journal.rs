//! The rows, in a CSV file to which every finished run is appended.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

use super::setting::{Method, Setting};

const HEADER: &str = "method,samples,tries,leaf,n,seed,points,work,repair work,depth,repair depth,T_n";

/// The identity of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The algorithm and its constants.
    pub setting: Setting,
    /// Number of points requested.
    pub n: u64,
    /// Seed of the set and of the run.
    pub seed: u64,
}

/// The counts of a run.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    /// Number of points.
    pub points: u64,
    /// Operations of the paper's phases.
    pub work: u64,
    /// Operations of agreement and repair.
    pub repair_work: u64,
    /// Depth of the paper's phases.
    pub depth: u64,
    /// Depth of agreement and repair.
    pub repair_depth: u64,
    /// `T_n`: Brent's bound on the steps with as many processors as points, repair included.
    pub steps: u64,
}

/// Means over the seeds.
#[derive(Clone, Copy, Debug)]
pub struct Means {
    /// All operations, divided by the number of points.
    pub work: f64,
    /// The share of agreement and repair in `work`.
    pub repair_work: f64,
    /// All steps on the longest chains.
    pub depth: f64,
    /// `T_n`.
    pub steps: f64,
}

/// The file and its rows.
pub struct Journal {
    file: File,
    rows: BTreeMap<Key, Counts>,
}

impl Journal {
    /// Opens the file, or creates it. An incomplete last line is removed.
    pub fn open(path: &Path) -> Result<Self, Box<dyn Error>> {
        let old = if path.exists() { std::fs::read_to_string(path)? } else { String::new() };
        let whole = old.rfind('\n').map_or("", |end| &old[..=end]);
        let mut lines = whole.lines();
        if lines.next().is_some_and(|first| first != HEADER) {
            return Err(format!("{} has other columns: remove it", path.display()).into());
        }
        let rows = lines.map(parse).collect::<Result<_, _>>()?;
        let text = if whole.is_empty() { format!("{HEADER}\n") } else { whole.to_owned() };
        std::fs::write(path, text)?;
        Ok(Journal { file: OpenOptions::new().append(true).open(path)?, rows })
    }

    /// Returns `true` if the file has this run.
    pub fn has(&self, key: Key) -> bool {
        self.rows.contains_key(&key)
    }

    /// Appends a run.
    pub fn push(&mut self, key: Key, c: Counts) -> Result<(), Box<dyn Error>> {
        let Key { setting, n, seed } = key;
        let Counts { points, work, repair_work, depth, repair_depth, steps } = c;
        writeln!(
            self.file,
            "{setting},{n},{seed},{points},{work},{repair_work},{depth},{repair_depth},{steps}"
        )?;
        self.rows.insert(key, c);
        Ok(())
    }

    /// Returns the means of the runs of a setting. Returns `None` if there are none.
    pub fn means(&self, setting: Setting, n: u64) -> Option<Means> {
        let is_of = |key: &&Key| key.setting == setting && key.n == n;
        let counts: Vec<&Counts> = self.rows.keys().filter(is_of).map(|key| &self.rows[key]).collect();
        let mean =
            |of: &dyn Fn(&Counts) -> f64| counts.iter().map(|c| of(c)).sum::<f64>() / counts.len() as f64;
        (!counts.is_empty()).then(|| Means {
            work: mean(&|c| (c.work + c.repair_work) as f64 / c.points as f64),
            repair_work: mean(&|c| c.repair_work as f64 / c.points as f64),
            depth: mean(&|c| (c.depth + c.repair_depth) as f64),
            steps: mean(&|c| c.steps as f64),
        })
    }

    /// Returns the settings of an algorithm with the fewest steps, the best first.
    pub fn best(&self, method: Method, n: u64, count: usize) -> Vec<Setting> {
        let mut settings: Vec<Setting> = self.rows.keys().map(|key| key.setting).collect();
        settings.dedup();
        let mut ranked: Vec<(f64, Setting)> = settings
            .into_iter()
            .filter(|setting| setting.method == method)
            .filter_map(|setting| Some((self.means(setting, n)?.steps, setting)))
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        ranked.into_iter().take(count).map(|r| r.1).collect()
    }
}

fn parse(line: &str) -> Result<(Key, Counts), Box<dyn Error>> {
    let fields: Vec<&str> = line.split(',').collect();
    if fields.len() != HEADER.split(',').count() {
        return Err(format!("`{line}` is not a row").into());
    }
    let number = |at: usize| fields[at].parse::<u64>();
    let key = Key { setting: fields[..4].join(",").parse()?, n: number(4)?, seed: number(5)? };
    let counts = Counts {
        points: number(6)?,
        work: number(7)?,
        repair_work: number(8)?,
        depth: number(9)?,
        repair_depth: number(10)?,
        steps: number(11)?,
    };
    Ok((key, counts))
}
