//! septet-lab: experiments with septet's machine, and what is written about its runs.

pub mod report;

pub mod trace;

pub mod rival;

pub mod predict;

pub mod experiment;

pub mod assertions;

pub mod claims;
