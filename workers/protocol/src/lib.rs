//! septet-protocol: what crosses the wire of the machine, and what it costs.
//!
//! Messages are one closed enum with a version; a [`transport::Transport`] moves them in rounds; the
//! [`ledger`] counts them. Nothing here computes geometry, and nothing here sends.

pub mod ids;

pub mod codec;

pub mod message;

pub mod outcome;

pub mod transport;

pub mod ledger;

pub mod tasks;
