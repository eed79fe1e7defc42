//! What is run: sizes, seeds, workers, kinds, dimensions.

use std::error::Error;

use septet_core::Config;
use septet_core::config::{Transport, Workers};
use septet_core::generate::{Generated, Kind, Request, generate};
use septet_lab::experiment::parse_sizes;

/// Sets to count, and on how many workers.
pub struct Plan {
    /// Numbers of points.
    pub sizes: Vec<u64>,
    /// Seeds, from 1 on.
    pub seeds: u64,
    /// Workers of the machine.
    pub workers: u32,
    /// Kinds of sets, where kinds are compared.
    pub kinds: Vec<Kind>,
    /// 2, 3 or both.
    pub dimensions: Vec<usize>,
}

impl Plan {
    /// From words, in order; what is missing is by default.
    pub fn parse(words: &[String]) -> Result<Self, Box<dyn Error>> {
        let word = |at: usize, default: &'static str| words.get(at).map_or(default, String::as_str);
        Ok(Plan {
            sizes: parse_sizes(word(0, "2^12,2^14,2^16"))?,
            seeds: word(1, "2").parse()?,
            workers: word(2, "16").parse()?,
            kinds: word(3, "uniform,graded,clusters,slab,sphere")
                .split(',')
                .map(str::parse)
                .collect::<Result<_, _>>()?,
            dimensions: word(4, "2,3").split(',').map(str::parse).collect::<Result<_, _>>()?,
        })
    }

    /// The sets of one kind, size and dimension, each with its seed and a machine to count them on.
    pub fn sets(
        &self,
        kind: Kind,
        n: u64,
        dimension: usize,
    ) -> Result<Vec<(Generated, Config)>, Box<dyn Error>> {
        let mut sets = Vec::new();
        for seed in 1..=self.seeds {
            let request = Request { kind, n, dimension, seed, lipschitz: None };
            let set = generate(&request, &mut |_, _, _| {})?;
            let config = Config::default().with(|c| {
                c.machine.workers = Workers::Count(self.workers);
                c.machine.threads = 2;
                c.machine.transport = Transport::Channel;
                c.spacing = set.spacing.map(|s| s.lipschitz);
                c.machine.seed = seed;
            });
            sets.push((set, config));
        }
        Ok(sets)
    }
}

/// Tells on standard error what is at work.
pub fn tell(what: &str, kind: Kind, n: u64, dimension: usize) {
    eprintln!("{what}: {kind}, {n} points, {dimension}D");
}
