//! septet-protocol.
