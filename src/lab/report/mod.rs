//! The report of a run: a documented, versioned schema, and tables.
//!
//! [`RunReport`] is the output of `--json`: all decisions, certificates, counts and measurements of a run. Counts
//! belong to the modelled machine and repeat exactly. Times (fields whose names end in `seconds`) and memory sizes are
//! measured and do not repeat. This module does not print.

mod build;
mod context;
mod cost_trace;
mod input;
pub(crate) mod json;
pub mod mesh;
mod parameters;
mod periodic;
mod processes;
mod schema;
mod stats;
mod summary;
pub(crate) mod tables;
mod traffic;
mod tree;
mod verify;

pub use context::RunContext;
pub use cost_trace::{CostHeader, CostLine, ledger_counts, write_cost_trace};
pub use input::InputReport;
pub use parameters::{Parameters, Requested, SettledReport};
pub use periodic::PeriodicReport;
pub use processes::ProcessReport;
pub use schema::{
    Fallback, GraphReport, HowProved, LevelDepths, MachineReport, PointsReport, RepairReport, RunReport,
    RunSeconds, SCHEMA, SupergraphReport, TreeReport,
};
pub use stats::{HullReport, StatsReport};
pub use tables::TableFormat;
pub use traffic::{BinReport, LinkReport, MOST_BINS, SenderReport, TimelineReport, TrafficReport, bin_ranks};
pub use verify::{VERIFY_SCHEMA, VerifiedBox, VerifyReport};
