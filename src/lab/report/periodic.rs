//! The periodic box of a run in its report.

use serde::Serialize;

use septet_core::{Outcome, Spec};

/// A periodic box, and the triangulation in it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PeriodicReport {
    /// Length along each axis; null for an axis that is not periodic.
    #[serde(rename = "box")]
    pub lengths: Vec<Option<f64>>,
    /// Lower corner of the box.
    pub origin: Vec<f64>,
    /// Whether the triangulation is a simplicial complex: no point is joined to its own image, and no two points are joined
    /// twice.
    pub simplicial: bool,
    /// The smallest number of boxes along each axis whose triangulation is a simplicial complex.
    pub sheets: Vec<u32>,
    /// Number of images of points that the machine triangulated besides the points.
    pub images_sent: u64,
}

impl PeriodicReport {
    /// Returns the part of the report of a run in a periodic box.
    pub(super) fn of(run: &Outcome, spec: &Spec) -> Option<Self> {
        let (part, periodic) = (run.kept.periodic.as_ref()?, spec.input.periodic.as_ref()?);
        let lengths = periodic.lengths.clone();
        let origin =
            if periodic.origin.is_empty() { vec![0.0; lengths.len()] } else { periodic.origin.clone() };
        let (simplicial, sheets) = (part.is_simplicial, part.sheets.clone());
        Some(PeriodicReport { lengths, origin, simplicial, sheets, images_sent: part.images })
    }

    /// Returns `true` if all axes are periodic.
    pub fn is_closed(&self) -> bool {
        self.lengths.iter().all(Option::is_some)
    }
}
