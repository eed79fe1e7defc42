//! The final decision on the stars.

use crate::result::merge::{Instance, OwnedCells};
use crate::share::Certificate;

/// The final decision of the coordinator on the stars.
#[derive(Debug)]
pub(crate) struct Certified {
    instance: Instance,
    passed: bool,
    owned_cells: OwnedCells,
    certificate: Certificate,
}

impl Certified {
    /// Creates the decision. `certificate` is empty except on the coordinator.
    pub(crate) fn new(
        instance: Instance,
        passed: bool,
        owned_cells: OwnedCells,
        certificate: Certificate,
    ) -> Self {
        Certified { instance, passed, owned_cells, certificate }
    }

    /// Returns the properties of the run.
    pub(crate) fn instance(&self) -> Instance {
        self.instance
    }

    /// Returns `true` if the certificate passed.
    pub(crate) fn has_passed(&self) -> bool {
        self.passed
    }

    /// Returns the cells that belong to this rank.
    pub(crate) fn owned_cells(&self) -> &OwnedCells {
        &self.owned_cells
    }

    /// Returns the certificate. It is empty except on the coordinator.
    pub(crate) fn into_certificate(self) -> Certificate {
        self.certificate
    }
}
