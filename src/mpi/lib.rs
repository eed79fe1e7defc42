//! septet-mpi: MPI as a connection of processes.
//!
//! [`MpiWire`] moves parcels between the processes of a communicator. Only the main thread may call it.

pub mod idle;

pub mod wire;

pub use wire::MpiWire;

mod parts;
