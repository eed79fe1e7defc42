//! septet: Delaunay triangulation by sphere separators, density graphs and local convex hulls.
//!
//! septet implements the parallel algorithm of *Delaunay Tetrahedralization and Parallel Three Dimensional Mesh
//! Generation*. The algorithm runs on a message-passing machine, which counts rounds, messages, bytes, work and depth.
//! Results are exact for every input, and the same, byte for byte, for any number of workers.
//!
//! ```
//! // The corners of a cube: all eight lie on one sphere. Ties are broken in one canonical way.
//! let cube: Vec<[f64; 3]> =
//!     (0..8).map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)]).collect();
//! let run = septet::triangulate(&cube, &Default::default())?;
//! assert_eq!(run.points.used, 8);
//! assert_eq!(run.hull_facets, 12);
//!
//! // The same triangulation by the paper's recursion, with work and depth counted.
//! let mut spec = septet::Spec::default();
//! spec.machine.workers = septet::spec::Workers::Leaves;
//! let counted = septet::simulate(&cube, &spec)?;
//! assert_eq!(counted.cells(), run.cells());
//! assert!(counted.ledger.totals.paper.depth > 0 && counted.ledger.totals.paper.depth < counted.ledger.totals.paper.work);
//! # Ok::<(), septet::Error>(())
//! ```
//!
//! The algorithms are compiled in the crates on which this one depends. A program that calls them does not compile them
//! again.

#[doc(inline)]
pub use septet_core::model::{HigherPoints, Points};
#[doc(inline)]
pub use septet_core::{
    Accounting, Code, Door, Error, Outcome, Refutation, Remedy, Spec, independent, simulate, triangulate,
};
#[doc(inline)]
pub use septet_geometry::coordinates::Coordinates;
#[doc(inline)]
pub use septet_geometry::higher::VecN;
#[doc(inline)]
pub use septet_geometry::site::Weighted;
#[doc(inline)]
pub use septet_lab::assert_counts;

/// Triangulations by several processes, each of which holds a part of the points.
///
/// Every process of a program, for example every rank of an MPI code, calls [`distributed::triangulate`] with
/// its own points. The points move to workers that share them in equal parts, so a process gets the cells of another part of
/// the space than its points occupy. No process ever holds all points. The union of the parts of all processes has the cells
/// that [`crate::triangulate`] computes from all points.
///
/// The transport connects the processes. [`channels`](distributed::channels) connects threads of one program. For other
/// connections, implement [`Transport`](distributed::Transport) and
/// [`ProcessTransport`](distributed::ProcessTransport).
///
/// ```
/// use septet::Spec;
/// use septet::distributed::{channels, triangulate};
///
/// // Two processes, with the lower and the upper corners of a cube.
/// let corner = |i: u32, z: f64| [f64::from(i & 1), f64::from(i >> 1), z];
/// let parts = std::thread::scope(|scope| {
///     let start = |(mut transport, (z, first_id))| {
///         scope.spawn(move || {
///             let points: Vec<[f64; 3]> = (0..4).map(|i| corner(i, z)).collect();
///             triangulate(&mut transport, &points, first_id, &Spec::default())
///         })
///     };
///     let inputs = [(0.0, 0), (1.0, 4)];
///     let threads: Vec<_> = channels::<[f64; 3]>(2).into_iter().zip(inputs).map(start).collect();
///     threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Result<Vec<_>, _>>()
/// })?;
/// let cells: usize = parts.iter().flat_map(|part| &part.shares).map(|share| share.cell_count()).sum();
/// assert_eq!((cells, parts[0].hull_facets), (parts[0].cell_count(), 12));
/// # Ok::<(), septet::Error>(())
/// ```
pub mod distributed {
    #[doc(inline)]
    pub use septet_core::run::distributed::{ProcessPoint, simulate, triangulate};
    #[doc(inline)]
    pub use septet_protocol::message::Message;
    #[doc(inline)]
    pub use septet_protocol::transport::{Delivery, HostState, Placement, ProcessTransport, Transport};

    /// Returns transports between threads of one program, one for each process of a run. If a transport is dropped during a
    /// run, the run ends with an error on all processes.
    pub fn channels<C: ProcessPoint>(processes: u32) -> Vec<impl ProcessTransport<C::Point> + Send> {
        septet_core::channels::<C::Point>(processes)
    }
}

/// The groups of a [`Spec`], and the values of their fields.
pub mod spec {
    #[doc(inline)]
    pub use septet_core::spec::{
        Alpha, Constants, Control, Correction, Graph, InputRules, Keep, Machine, Neighbours, Nodes,
        Partition, Periodic, Progress, ProgressFn, Purpose, Recursion, Registers, SeparatorSets, SpecError,
        Task, Transport, Tree, Until, Workers,
    };
}

/// The contents of an [`Outcome`]: facts, shares of workers with their cells, counts, and pictures.
pub mod result {
    #[doc(inline)]
    pub use septet_core::error::PeriodicError;
    #[doc(inline)]
    pub use septet_core::error::SiteError;
    #[doc(inline)]
    pub use septet_core::result::own_counts::OwnCounts;
    #[doc(inline)]
    pub use septet_core::result::periodic::PeriodicCells;
    #[doc(inline)]
    pub use septet_core::result::view::{SeparatorView, View};
    #[doc(inline)]
    pub use septet_core::{
        Ending, Facts, Kept, LeftOut, Neighbour, Selection, SetMember, Settled, Stats, Times, TrafficTotal,
        WorkerShare,
    };
    #[doc(inline)]
    pub use septet_geometry::graph::Supergraph;
    #[doc(inline)]
    pub use septet_geometry::range::RangeError;
    #[doc(inline)]
    pub use septet_meshing::quality::histogram::Histogram;
    #[doc(inline)]
    pub use septet_protocol::ids::{NodeId, Phase};
    #[doc(inline)]
    pub use septet_protocol::ledger::{
        Ledger, LedgerPart, LevelSums, NodeFacts, PathStep, PhaseTotal, Ratios, RoundTally, Total, TreeSums,
    };
    #[doc(inline)]
    pub use septet_protocol::transport::TransportError;
}

/// Readers and writers of files.
///
/// A terrain is triangulated in the plane, and its heights are z in the outputs:
///
/// ```
/// use septet::io::{Format, MeshView};
/// use septet::io::read::{ReadOptions, read_from};
/// use septet::io::write::{WriteOptions, write_to};
/// use septet::{Points, Spec, triangulate};
///
/// let table = "x,y,z\n0,0,410\n9,0,415\n0,9,420\n9,8,430\n";
/// let options = ReadOptions { terrain: true, ..ReadOptions::default() };
/// let file = read_from(table.as_bytes(), "survey.csv".as_ref(), None, &options, &mut |_, _| {})?;
/// let Points::Plane(points) = &file.points else { unreachable!("a terrain lies in the plane") };
/// let run = triangulate(points, &Spec::default())?;
///
/// let view = run.view(file.points.coordinates());
/// let view = MeshView { heights: file.heights.as_deref(), ..view };
/// let mut tin = Vec::new();
/// let obj = WriteOptions { format: Some(Format::Obj), ..WriteOptions::default() };
/// write_to(&mut tin, &view, &obj, &mut |_, _| {})?;
/// assert!(String::from_utf8(tin)?.contains("v 9 8 430\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod io {
    #[doc(inline)]
    pub use septet_core::model::{Labels, MeshView, Patches};
    #[doc(inline)]
    pub use septet_io::{Format, Role, UnknownFormatName};

    /// Readers of points, cells, domains and sizes.
    pub mod read {
        #[doc(inline)]
        pub use septet_io::read::{
            AnyInput, CellFile, CellOptions, Column, CoordinateType, DomainFile, EntryFault, Extent,
            FileList, FileReading, InputError, ListError, ListedFile, Place, PointFile, PointList, RawRows,
            ReadOptions, ReadProgress, UnknownRawRows, WeightOption, WeightSource, read, read_cells,
            read_cells_from, read_domain, read_from, read_list, read_mesh, read_sizes,
        };
    }

    /// Writers of triangulations, meshes and points.
    ///
    /// A `.pvtu` file has a piece for each worker, made from the shares of a run ([`MeshView::run`]).
    pub mod write {
        #[doc(inline)]
        pub use septet_io::write::{
            MshVersion, Order, OutputError, WriteOptions, check_output, check_points_output, write,
            write_points, write_points_to, write_to,
        };
    }
}

/// An independent verifier of Delaunay and regular triangulations from any source. It shares no code with the builder.
pub mod verify {
    #[doc(inline)]
    pub use septet_verify::{
        Fault, HIDDEN_SITES, LEVELS, LevelReport, PeriodicBox, Report, Sites, Triangulation, VerifyOptions,
        verify,
    };
}

/// Questions about a triangulation: neighbours, exact location, nearest vertices, interpolation, Voronoi cells in a box, power
/// cells, alpha shapes.
///
/// ```
/// use glam::DVec2;
/// use septet::queries::{Method, NONE, Tessellation};
///
/// // Three stations and the temperatures there.
/// let stations = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]].map(DVec2::from_array);
/// let run = septet::triangulate(&stations, &Default::default())?;
/// let tessellation = Tessellation::new(&stations, &run)?;
///
/// let places = [[1.0, 1.0], [4.0, 0.0], [3.0, 3.0]].map(DVec2::from_array);
/// assert_eq!(tessellation.locate(&places), [0, 0, NONE]);
/// assert_eq!(tessellation.nearest(&places), [0, 1, 1]);
/// let weights = tessellation.weights(&places, Method::Sibson);
/// let temperatures = weights.interpolate(&[10.0, 14.0, 18.0])?;
/// assert!((temperatures[0] - 13.0).abs() < 1e-12 && temperatures[1] == 14.0 && temperatures[2].is_nan());
///
/// let areas = tessellation.voronoi_volumes_in(DVec2::ZERO, DVec2::splat(4.0))?;
/// assert!((areas[0] - 4.0).abs() < 1e-12 && (areas.iter().sum::<f64>() - 16.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod queries {
    #[doc(inline)]
    pub use septet_meshing::quality::shapes::{Shape, Shapes};
    #[doc(inline)]
    pub use septet_queries::{
        AlphaFiltration, AlphaShape, Barycentric, Clipped, Dimension, Method, NONE, Polytope, QueryError,
        Ragged, Region, Ridges, Tessellation, Weights, power_cells, power_centroids, power_volumes,
    };
}

/// Meshes of domains.
///
/// ```
/// use septet::mesh::{Input, InputSegment, DomainKind, MeshSpec, make};
///
/// let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
/// let mut triangle = Input::new(DomainKind::Complex, corners.map(glam::DVec2::from).to_vec());
/// for ends in [[0, 1], [1, 2], [2, 0]] {
///     triangle.segments.push(InputSegment { ends, marker: 0 });
/// }
/// let mut spec = MeshSpec::default();
/// spec.sizes.most = Some(0.25);
/// let made = make(&triangle, &spec)?;
/// assert_eq!(made.mesh.cells.len(), 17);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod mesh {
    #[doc(inline)]
    pub use septet_core::mesh::field::SizeField;
    #[doc(inline)]
    pub use septet_core::mesh::labelled::Labelled;
    #[doc(inline)]
    pub use septet_core::mesh::{
        Boundary, Dimension, Made, MakeError, MeshError, MeshSpec, SingularityRequest, SingularityShape,
        Sizes, accept, check, make,
    };
    #[doc(inline)]
    pub use septet_meshing::Accepted;
    #[doc(inline)]
    pub use septet_meshing::conformity::{Conformity, MeshDefect};
    #[doc(inline)]
    pub use septet_meshing::defect::Defect;
    #[doc(inline)]
    pub use septet_meshing::domain::Domain;
    #[doc(inline)]
    pub use septet_meshing::input::{DomainKind, Input, InputFacet, InputSegment, Region};
    #[doc(inline)]
    pub use septet_meshing::mesh::{Carrier, Edge, Face, Mesh, OUTSIDE, StageLine};
    #[doc(inline)]
    pub use septet_meshing::quality::Quality;
    #[doc(inline)]
    pub use septet_meshing::repair::{Change, Tolerance};

    /// Makes a mesh, as [`make`] does, of a domain whose input has already been checked.
    ///
    /// # Errors
    /// See [`MakeError`].
    pub fn make_of<P: Dimension>(domain: &Domain<P>, spec: &MeshSpec) -> Result<Made<P>, MakeError<P>> {
        septet_core::mesh::make_of(domain, spec, septet_core::mesh::MeshKeep::default())
    }
}

/// Generated point sets.
pub mod generate {
    #[doc(inline)]
    pub use septet_core::generate::{
        GenerateError, GenerateProgress, Generated, Kind, Request, SeparateRows, Spacing, generate,
        parse_sample,
    };
}

/// Sweeps of runs, and fits of the growth of their counts.
pub mod experiment {
    #[doc(inline)]
    pub use septet_lab::experiment::fit::{
        Abscissa, Conclusion, FitError, FitReport, FitRequest, Growth, Key, Law, NotExcluded, Power, Series,
        fit,
    };
    #[doc(inline)]
    pub use septet_lab::experiment::{
        Job, JournalError, Line, Lines, RunError, Runner, SweepError, of_run, read_lines,
    };
    #[doc(inline)]
    pub use septet_lab::rows::{GroupTotal, LevelRow, PhaseRow};
}

/// A second account of work and depth: the calls of primitives of a run without prices, and a fold that prices them. It
/// shares no code with the ledger.
///
/// ```
/// use septet::accounts::{CostHeader, fold, ledger_counts, write_cost_trace};
///
/// let cube: Vec<[f64; 3]> =
///     (0..8).map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)]).collect();
/// let mut spec = septet::Spec::default();
/// spec.keep.costs = true;
/// let run = septet::simulate(&cube, &spec)?;
///
/// let header = CostHeader::of(&spec, &run.settled, run.points.used, run.space);
/// let mut text = Vec::new();
/// write_cost_trace(&mut text, header, run.kept.costs.as_ref().expect("kept"))?;
/// let accounts = fold(text.as_slice())?;
/// assert_eq!(accounts.paper.depth, run.ledger.totals.paper.depth);
/// assert!(accounts.differences(&ledger_counts(&run.ledger)).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod accounts {
    #[doc(inline)]
    pub use septet_core::run::{CostRow, CostTrace};
    #[doc(inline)]
    pub use septet_geometry::cost::{Call, LaneStep, Primitive, Step, Tape};
    #[doc(inline)]
    pub use septet_lab::accounts::{
        AccountError, Accounts, Difference, PhaseAccount, ReportError, ReportedCounts, ReportedPhase,
        ReportedRun, ReportedTotal, ReportedTotals, TotalAccount, fold,
    };
    #[doc(inline)]
    pub use septet_lab::report::{CostHeader, ledger_counts, write_cost_trace};
}

/// The paper's claims as experiments with bounds that are stated before the run.
pub mod claims {
    #[doc(inline)]
    pub use septet_lab::claims::{
        CheckedClaim, Claim, ClaimError, ClaimJournal, ClaimReport, Extent, Figure, Lab, LabOptions, Reading,
        Relation, Role, Statistics, registry, select,
    };
}

/// Assertions on counts, for tests. See [`assert_counts!`](crate::assert_counts).
#[doc(inline)]
pub use septet_lab::assertions;

/// A layer for `tracing` that writes the work of the machine as a trace.
#[doc(inline)]
pub use septet_lab::trace;

/// The guide: the paper step by step, terms, the machine and its counts, options, formats, exit codes, reports, traces,
/// experiments, clusters, and for Python a comparison with scipy and a gallery.
pub mod guide {
    #[doc = include_str!("guide/paper.md")]
    pub mod paper {}

    #[doc = include_str!("guide/terms.md")]
    pub mod terms {}

    #[doc = include_str!("guide/machine.md")]
    pub mod machine {}

    #[doc = include_str!("guide/options.md")]
    pub mod options {}

    #[doc = include_str!("guide/formats.md")]
    pub mod formats {}

    #[doc = include_str!("guide/exit_codes.md")]
    pub mod exit_codes {}

    #[doc = include_str!("guide/report.md")]
    pub mod report {}

    #[doc = include_str!("guide/traces.md")]
    pub mod traces {}

    #[doc = include_str!("guide/experiments.md")]
    pub mod experiments {}

    #[doc = include_str!("guide/cluster.md")]
    pub mod cluster {}

    #[doc = include_str!("guide/scipy.md")]
    pub mod scipy {}

    #[doc = include_str!("guide/gallery.md")]
    pub mod gallery {}
}

/// Support for tests of machines: planted faults, and machines that the caller starts.
#[doc(hidden)]
pub mod testing {
    pub use septet_core::spec::{Fault, Planted};
    pub use septet_core::{
        Host, Job, Machine, MachineError, OneHost, Share, Start, Unwatched, Watch, run_on, serve,
    };
}

/// The examples in README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
