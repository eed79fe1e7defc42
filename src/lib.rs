//! septet: Delaunay triangulation by sphere separators, density graphs and local convex hulls.
//!
//! The parallel algorithm of *Delaunay Tetrahedralization and Parallel Three Dimensional Mesh Generation*, run as a message-passing machine whose rounds, messages,
//! bytes, work and depth are counted; exact for every input, and the same bytes for any number of workers.
//!
//! ```
//! use glam::DVec3;
//! use septet::{Config, simulate, triangulate};
//!
//! // The corners of a cube: all eight on one sphere. Ties are broken in one canonical way.
//! let cube: Vec<DVec3> =
//!     (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
//! let run = triangulate(&cube, &Config::default())?;
//! assert_eq!(run.points.used, 8);
//! assert_eq!(run.hull_facets, 12);
//!
//! // The same triangulation by the paper's recursion, with work and depth counted.
//! let counted = simulate(&cube, &Config::default())?;
//! assert_eq!(counted.cells(), run.cells());
//! assert!(counted.ledger.paper.depth > 0 && counted.ledger.paper.depth < counted.ledger.paper.work);
//! # Ok::<(), septet::Error>(())
//! ```
//!
//! The modules stand in the order of the flow: configuration and input, the machine seen from its
//! coordinator, the result and what is made of it.

pub mod config;

pub mod model;

pub mod generate;

pub mod mesh;

mod error;

mod prepare;

mod coincide;

mod coordinator;

mod canonical;

pub mod pieces;

pub mod view;

pub mod memory;

mod run;

mod record;
mod sizing;

mod count;

pub mod independent;

pub mod predict;

pub mod report;

pub mod rival;

pub mod trace;

pub mod experiment;

pub mod assertions;

pub mod claims;

pub mod verify;

pub mod io;

pub use config::Config;
pub use count::{Counts, Ending, count};
pub use error::{Error, Refutation};
pub use independent::{IndependentRun, independent};
pub use run::{Accounting, Run, Settled, Start, Traffic, run_on, simulate, triangulate};

pub use septet_geometry as geometry;
pub use septet_meshing as meshing;
pub use septet_protocol as protocol;
pub use septet_workers as workers;
