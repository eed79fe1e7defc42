//! The exit codes of the program for the errors of this crate.

/// The run failed, or an output cannot be written.
pub const FAILED: u8 = 1;

/// The options are invalid.
pub const USAGE: u8 = 2;

/// The input data are invalid.
pub const INPUT: u8 = 3;

/// A limit was reached.
pub const LIMIT: u8 = 5;

/// The user interrupted the run.
pub const INTERRUPTED: u8 = 130;
