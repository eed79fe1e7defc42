//! A run: from points and a configuration to a certified triangulation and its counts.

mod auto_workers;
pub mod count;
pub mod distributed;
mod finish;
pub mod independent;
pub mod memory;
pub mod processes;
mod settings;
mod transport;
mod triangulation;

pub use crate::result::cost_trace::{CostRow, CostTrace};
pub use crate::result::run::{Accounting, Run, SetMember, Settled, TrafficTotal};
pub use transport::Start;
pub use triangulation::{run_on, simulate, triangulate};
