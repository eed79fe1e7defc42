//! septet-core: what septet does with points and domains, without files, reports or a command line.
//!
//! The modules follow the flow: configuration, input, the run and the machine as its coordinator sees it, the
//! result; then meshes of domains and generated point sets, which start runs of their own.

pub mod config;

pub mod model;

pub mod options;

pub mod error;

pub mod input;

pub mod coordinator;

pub mod run;

pub mod result;

pub mod mesh;

pub mod generate;

pub use config::Config;
pub use error::{Error, Refutation};
pub use run::count::{Counts, Ending, count};
pub use run::independent::{IndependentRun, independent};
pub use run::{Accounting, Run, Settled, Start, Traffic, run_on, simulate, triangulate};
