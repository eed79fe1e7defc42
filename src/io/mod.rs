//! Files: reading point sets and cell lists, writing triangulations.

pub mod read;
