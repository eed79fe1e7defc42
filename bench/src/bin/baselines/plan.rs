//! The plan of the runs: sizes, seeds, workers, kinds and dimensions.

use std::error::Error;

use septet_core::Spec;
use septet_core::generate::{Generated, Kind, Request, generate};
use septet_core::spec::{Transport, Workers};
use septet_lab::experiment::parse_sizes;

/// The point sets, and the number of workers.
pub struct Plan {
    /// Numbers of points.
    pub sizes: Vec<u64>,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Number of workers.
    pub workers: u32,
    /// Kinds of sets, for the comparison of separators.
    pub kinds: Vec<Kind>,
    /// Dimensions: 2, 3 or both.
    pub dimensions: Vec<usize>,
}

impl Plan {
    /// Parses the arguments in order. Missing arguments have defaults.
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

    /// Generates the sets of a kind, size and dimension, one per seed, each with its configuration.
    pub fn sets(
        &self,
        kind: Kind,
        n: u64,
        dimension: usize,
    ) -> Result<Vec<(Generated, Spec)>, Box<dyn Error>> {
        let mut sets = Vec::new();
        for seed in 1..=self.seeds {
            let request = Request { kind, n, dimension, seed, lipschitz: None, ratio: None };
            let set = generate(&request, &mut |_, _, _| {})?;
            let spec = Spec::default().with(|c| {
                c.machine.workers = Workers::Count(self.workers);
                c.machine.threads = Some(2);
                c.machine.transport = Transport::Channel;
                c.recursion.spacing = set.spacing.map(|s| s.lipschitz);
                c.machine.seed = seed;
            });
            sets.push((set, spec));
        }
        Ok(sets)
    }
}

/// Announces a step on standard error.
pub fn announce(what: &str, kind: Kind, n: u64, dimension: usize) {
    eprintln!("{what}: {kind}, {n} points, {dimension}D");
}
