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

pub use septet_core::{Accounting, Run, Settled, Start, Traffic, run_on, simulate, triangulate};
pub use septet_core::{Config, Counts, Ending, Error, IndependentRun, Refutation, count, independent};
pub use septet_core::{config, generate, mesh, model, result, run};
pub use septet_io as io;
pub use septet_lab::{assert_counts, assertions, claims, experiment, predict, report, rival, trace};
pub use septet_verify as verify;
