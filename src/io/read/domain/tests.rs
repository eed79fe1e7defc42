//! Tests of the readers of domains.
