//! The report of a verification: its levels, with the faults of each.

use serde::Serialize;

use super::fault::Fault;

/// The largest number of faults that a level keeps.
pub const KEPT: usize = 10;

/// One level of the verification.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LevelReport {
    /// `structure`, `orientation`, `manifold`, `hull`, `empty spheres` or `single cover`; with weights, also `hidden sites`.
    pub name: &'static str,
    /// Whether the level ran and found no fault.
    pub passed: bool,
    /// The number of items checked. The items of the levels are, in order: points and cells; cells; facets and, without a
    /// periodic box, vertices; boundary ridges; interior facets; cells and boundary facets; places of hidden points.
    pub checked: u64,
    /// The first faults, at most [`KEPT`].
    pub faults: Vec<Fault>,
    /// The number of all faults.
    pub fault_count: u64,
    /// The earlier level whose failure prevented this one, or `None` if it ran.
    pub stopped_by: Option<&'static str>,
}

/// The outcome of [`super::verify`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Report {
    /// The levels, in order.
    pub levels: Vec<LevelReport>,
    /// 2 to 6.
    pub dimension: usize,
    /// Whether the lexicographic perturbation was required.
    pub perturbed: bool,
    /// Number of points.
    pub points: u64,
    /// Number of cells.
    pub cells: u64,
    /// Number of facets with one cell.
    pub hull_facets: u64,
    /// Number of facets with two cells.
    pub interior_facets: u64,
    /// Number of interior facets whose two cells are exactly cospherical.
    pub ties: u64,
    /// Number of points that are vertices.
    pub vertices_used: u64,
    /// Number of points that coincide with a point of smaller index. With weights, both have the largest weight at that place.
    pub duplicates: u64,
    /// Number of hidden points, or `None` without weights. They are neither vertices nor duplicates. Without cells, only
    /// points that are lighter than another at their place count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hidden: Option<u64>,
    /// The dimension of the affine hull of the points, or -1 without points.
    pub dimension_of_points: i32,
}

impl Report {
    /// Returns `true` if every level ran without a fault.
    pub fn passed(&self) -> bool {
        self.levels.iter().all(|level| level.passed)
    }

    /// Returns the level of this name.
    pub fn level(&self, name: &str) -> Option<&LevelReport> {
        self.levels.iter().find(|level| level.name == name)
    }
}

/// The faults found so far.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// The first faults, at most [`KEPT`].
    pub faults: Vec<Fault>,
    /// The number of all faults.
    pub count: u64,
    /// The number of items checked.
    pub checked: u64,
    /// The number of ties among them.
    pub ties: u64,
}

impl Tally {
    /// Adds a fault.
    pub fn fault(&mut self, fault: Fault) {
        self.count += 1;
        if self.faults.len() < KEPT {
            self.faults.push(fault);
        }
    }

    /// Appends the tally of later items.
    pub fn append(&mut self, later: Tally) {
        self.count += later.count;
        self.checked += later.checked;
        self.ties += later.ties;
        let room = KEPT - self.faults.len();
        self.faults.extend(later.faults.into_iter().take(room));
    }

    /// Returns the report of the level.
    pub fn level(self, name: &'static str) -> LevelReport {
        LevelReport {
            name,
            passed: self.count == 0,
            checked: self.checked,
            faults: self.faults,
            fault_count: self.count,
            stopped_by: None,
        }
    }
}
