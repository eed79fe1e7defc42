//! septet-core: runs over points and meshes of domains, without files, reports or a command line.
//!
//! The modules follow the flow of a run: specification, input, the coordinator, the run, and the result. Meshes of
//! domains and generated point sets start their own runs.

#[macro_use]
pub mod spec;

pub mod model;

mod code;

pub mod error;

mod periodic_error;

pub mod remedy;

pub mod input;

pub mod coordinator;

pub mod run;

pub mod result;

pub mod mesh;

pub mod generate;

pub use code::Code;
pub use error::{Error, Refutation};
pub use remedy::{Door, Remedy};
pub use result::outcome::{
    Accounting, Ending, Facts, Kept, LeftOut, Outcome, Selection, SetMember, Settled, Times, TrafficTotal,
};
pub use result::share::{Neighbour, WorkerShare};
pub use result::stats::Stats;
pub use run::Start;
pub use run::calls::{count, independent, perform, run_on, simulate, triangulate};
pub use septet_workers::config::cores;
pub use septet_workers::host::{Host, Job, Unwatched, Watch, serve};
pub use septet_workers::share::Share;
pub use septet_workers::transport::process::channels;
pub use septet_workers::transport::{Machine, MachineError, OneHost};
pub use spec::Spec;
