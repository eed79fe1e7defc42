//! Requests for the point sets of experiments.

use septet_core::generate::{GRADED_LIPSCHITZ, Kind};

/// The request for a point set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) kind: Kind,
    pub(super) n: u64,
    pub(super) d: usize,
    /// The Lipschitz constant of graded kinds.
    pub(super) lipschitz: Option<f64>,
}

impl Sample {
    pub(super) fn new(kind: Kind, n: u64, d: usize) -> Sample {
        Sample { kind, n, d, lipschitz: kind.is_graded().then_some(GRADED_LIPSCHITZ) }
    }

    /// Returns the common size of sites at the points: `n^(-1/d)`, their mean distance in the unit square or cube.
    pub(super) fn site_size(&self) -> f64 {
        (self.n as f64).powf(-1.0 / self.d as f64)
    }

    pub(super) fn name(&self) -> String {
        let graded = self.lipschitz.map_or_else(String::new, |l| format!(" L={l}"));
        format!("{}{graded} {}D n={}", self.kind.name(), self.d, self.n)
    }
}
