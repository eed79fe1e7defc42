//! What a run has to say: one documented, versioned schema, and tables for people.
//!
//! [`Report`] is what `--json` writes: everything that was settled, certified, counted and measured. Counts
//! belong to the modelled machine and repeat exactly; fields whose names end in `seconds` or `bytes` of
//! memory are measured and do not. Nothing here prints.

mod build;
pub(crate) mod json;
pub mod mesh;
mod parameters;
mod schema;
mod setting;
mod summary;
pub(crate) mod tables;
mod traffic;
mod tree;
mod verdict;

pub use parameters::Parameters;
pub use schema::{
    Fallback, GraphReport, HowProved, LevelReport, MachineReport, NodeReport, PathReport, PhaseReport,
    PointsReport, RepairReport, Report, RoundReport, SCHEMA, Seconds, SupergraphReport, TotalReport,
    TreeReport,
};
pub use setting::Setting;
pub use tables::TableFormat;
pub use traffic::{BinReport, LinkReport, MOST_BINS, SenderReport, TimelineReport, TrafficReport};
pub use verdict::{VERIFY_SCHEMA, Verdict};
