//! Tests of the whole system in one program, so that the code of the machine is compiled once.
//!
//! `cargo test --release --test system equality::` runs the tests of one file.

use septet_common as common;

mod accounts;

mod assertions;

mod baselines;

mod claims;

mod constants;

mod degenerate;

#[cfg(feature = "dimensions")]
mod dimensions;

mod distributed;

mod equality;

mod exclusive;

mod experiment;

mod faults;

mod flips;

mod graphs;

mod halves;

mod independent;

mod ledger;

mod levelling;
mod mesh;

mod messages;

mod oracle;

mod parts;

mod periodic;

mod pieces;

mod planted;

mod predict;

mod probes;

mod proptest_small;

mod real;

mod scaling;

mod transports;

mod weights;
