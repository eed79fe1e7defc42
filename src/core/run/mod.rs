//! A run: points and parameters in, a certified triangulation and its counts out.

pub mod count;
mod finish;
pub mod independent;
pub mod memory;
mod record;
mod sizing;
mod start;
mod transport;
mod triangulation;

pub use crate::result::run::{Accounting, Run, Settled, Traffic};
pub use transport::Start;
pub use triangulation::{run_on, simulate, triangulate};
