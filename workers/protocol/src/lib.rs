//! septet-protocol: the messages of the machine, their transport and the ledger of costs.
//!
//! Messages are one closed enum with a version. A [`transport::Transport`] moves them in rounds, and the [`ledger`] counts
//! them. This crate computes no geometry and contains no transport.

pub mod ids;

pub mod codec;

pub mod checksum;

pub mod message;

pub mod outcome;

pub mod transport;

pub mod wire;

pub mod ledger;
