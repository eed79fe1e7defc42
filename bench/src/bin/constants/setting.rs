//! The settings that are compared.

use std::error::Error;
use std::fmt;
use std::str::FromStr;

const SAMPLES: [u64; 4] = [64, 100, 200, 400];
const TRIES: [u32; 2] = [5, 10];
const LEAVES: [u64; 5] = [40, 60, 125, 300, 1000];

/// The algorithm of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// The recursion with sphere separators.
    Spheres,
    /// The recursion with k-d planes.
    Planes,
    /// Parallel randomized incremental insertion.
    Insertion,
}

impl Method {
    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Method::Spheres => "spheres",
            Method::Planes => "planes",
            Method::Insertion => "insertion",
        }
    }
}

/// An algorithm with its constants. Constants that it does not use are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Setting {
    /// The algorithm.
    pub method: Method,
    /// Largest expected number of samples of a draw.
    pub samples: u64,
    /// Number of great circles of a draw.
    pub tries: u32,
    /// Largest leaf, in points.
    pub leaf: u64,
}

impl Setting {
    /// Returns the setting of the baseline.
    pub fn insertion() -> Self {
        Setting { method: Method::Insertion, samples: 0, tries: 0, leaf: 0 }
    }

    /// Returns the setting with planes instead of spheres.
    pub fn by_planes(self) -> Self {
        Setting { method: Method::Planes, tries: 0, ..self }
    }

    /// Returns `true` if [`grid`] contains this setting.
    pub fn is_in_grid(self) -> bool {
        grid().contains(&self)
    }
}

/// Returns all combinations of the constants, for spheres and for planes.
pub fn grid() -> Vec<Setting> {
    let mut all = Vec::new();
    for samples in SAMPLES {
        for leaf in LEAVES {
            let spheres = TRIES.map(|tries| Setting { method: Method::Spheres, samples, tries, leaf });
            all.extend(spheres);
            all.push(spheres[0].by_planes());
        }
    }
    all
}

/// Writes the fields of the journal.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Setting { method, samples, tries, leaf } = self;
        write!(f, "{},{samples},{tries},{leaf}", method.name())
    }
}

impl FromStr for Setting {
    type Err = Box<dyn Error>;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let fields: Vec<&str> = text.split(',').collect();
        let &[name, samples, tries, leaf] = fields.as_slice() else {
            return Err(format!("`{text}` is not a setting").into());
        };
        let methods = [Method::Spheres, Method::Planes, Method::Insertion];
        let method = methods.into_iter().find(|method| method.name() == name);
        let method = method.ok_or_else(|| format!("`{name}` is not an algorithm"))?;
        Ok(Setting { method, samples: samples.parse()?, tries: tries.parse()?, leaf: leaf.parse()? })
    }
}
