//! The Python module `septet._septet`: the part of the package `septet` that is written in Rust.
//!
//! The package checks arguments and documents its names. This module takes arrays of float64 and int64 in C order, runs the
//! library without the interpreter, and returns arrays that own the buffers of the library.
//!
//! | what | module |
//! | --- | --- |
//! | signals, progress | `watch` |
//! | arrays; exceptions | `arrays`, `errors` |
//! | triangulations and their queries | `delaunay` |
//! | alpha complexes; Voronoi diagrams | `alpha`, `voronoi` |
//! | runs of the counted machine; meshes; readers and the verifier | `machine`, `mesh`, `files` |

#![expect(clippy::needless_pass_by_value, reason = "functions for Python own their arguments")]

mod alpha;
mod arrays;
mod delaunay;
mod errors;
mod files;
mod machine;
mod mesh;
mod voronoi;
mod watch;

use pyo3::prelude::*;

/// The module.
#[pymodule(gil_used = false)]
mod _septet {
    #[pymodule_export]
    use super::alpha::{alpha_filtration, alpha_shape};
    #[pymodule_export]
    use super::delaunay::Core;
    #[pymodule_export]
    use super::files::{read_file, verify};
    #[pymodule_export]
    use super::machine::{Machine, write_report};
    #[pymodule_export]
    use super::mesh::Meshed;
    #[pymodule_export]
    use super::voronoi::{
        power_cells, voronoi_centroids, voronoi_in, voronoi_regions, voronoi_ridges, voronoi_volumes,
    };

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
