//! septet-lab: experiments with septet's machine, and reports of its runs.

pub mod accounts;

pub mod report;

pub mod rows;

pub mod trace;

pub mod baselines;

pub mod predict;

pub mod experiment;

pub mod assertions;

pub mod claims;

#[cfg(feature = "schema")]
mod option_schema;
