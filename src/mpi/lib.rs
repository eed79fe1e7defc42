//! septet-mpi: MPI as a connection of processes, and the start and the end of an MPI program.
//!
//! [`MpiWire`] moves parcels between the processes of a communicator. [`launch::run`] starts MPI, and ends all
//! processes if one of them fails. Only the main thread calls MPI.

pub mod launch;

#[doc(hidden)]
pub mod self_test;

pub mod wire;

pub use wire::MpiWire;

mod idle;
mod parts;
