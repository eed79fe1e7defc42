//! The whole-system tests, one program: the machine's code is compiled once for all of them.
//!
//! `cargo test --release --test system equality::` runs one file's.

use septet_common as common;

mod assertions;

mod claims;

mod degenerate;

mod equality;

mod exclusive;

mod experiment;

mod faults;

mod graphs;

mod halves;

mod independent;

mod ledger;

mod mesh;

mod oracle;

mod pieces;

mod predict;

mod proptest_small;

mod rivals;

mod real;

mod scaling;

mod transports;
