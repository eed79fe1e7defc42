"""Exact Delaunay triangulations, Voronoi diagrams and meshes in the plane and in space.

Conventions, for all calls:

Points. Anything that numpy.asarray takes, of shape (n, 2) or (n, 3): float16, float32, float64, bool, integers, F-ordered,
strided, read-only, memory-mapped. The points are copied once, while the lock is held. float16 and
float32 are converted exactly. An int64 or uint64 that float64 cannot hold, longdouble, complex and object raise
TypeError or ValueError: nothing is rounded silently. Byte-swapped float64 is converted. n = 0 is allowed.

Invalid points. NaN and infinity raise PointError with the row in `index`. `on_invalid="skip"` drops and lists them.

Weights. `weights=` are squared lengths, one for each point: pass `weights=r**2` for balls of radius r. The triangulation is the
regular one; points that weights hide are in `hidden`.

Periodic boxes. `period=` has the length along each axis, or one for all; None along an axis that is not periodic. The box
begins at `origin=` (0 by default), and points outside raise PointError unless `wrap=True`. Simplices are one of each class of
translated simplices, and a vertex lies at its point plus `offsets` times the lengths. Queries that have no meaning with weights or
in a box raise OptionError, which names those that have.

Flat points. Points on a line, or in a plane of space, and fewer than d + 1 points, are no error: no simplices, `dimension < d`.

Arrays. Every array is C-contiguous, owns its memory (it stays valid without its object, and never shares memory with an
argument), is made at the first access, and is read-only, because queries depend on it. Attributes cannot be assigned.

Indices. int32 if n and the number of simplices are below 2**31, and int64 otherwise; one type for all arrays of an object. -1
means none.

Order. Simplices are positively oriented (counter-clockwise; a right-handed triple of edges in space), start with their smallest
vertex, and are sorted. All results depend on the arguments only, and not on threads.

Threads. `threads=None` takes all cores that the process may use, 1 computes on one thread. Calls release the interpreter's lock. Objects are immutable
and may be shared by threads. The module declares support of the free-threaded build.

Interrupt. Ctrl-C (any signal handler that raises) ends a call within 1 s (2 s in `mesh`), and its exception is raised. Nothing is left behind.

Copies. Objects can be pickled and copied. A pickle holds points and simplices, and is checked when it is loaded.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal, NamedTuple, overload

import numpy as np
import numpy.typing as npt

__version__: str

__all__ = [
    "AlphaFiltration",
    "AlphaShape",
    "Cells",
    "Delaunay",
    "DomainError",
    "Error",
    "Floats",
    "Ids",
    "InputError",
    "MemoryLimitError",
    "Mesh",
    "Method",
    "OptionError",
    "Period",
    "PointError",
    "Progress",
    "Ragged",
    "Run",
    "RunError",
    "Verdict",
    "Voronoi",
    "Weights",
    "__version__",
    "mesh",
    "read",
    "read_run",
    "simulate",
    "verify",
]

Ids = npt.NDArray[np.int32] | npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Period = float | Sequence[float | None] | Floats
"""The length of a periodic box along all axes, or along each; None along an axis that is not periodic."""
Method = Literal["linear", "sibson", "laplace"]
Progress = Callable[[str, int, int], None]
"""Called with the phase, its position, and the number of phases, at most every 0.1 s, on the caller's thread."""

# Errors. Each is also the built-in class that a caller would expect.

class Error(Exception):
    """The base of all errors of the package."""

class PointError(Error, ValueError):
    """A point that cannot be used: not finite, or digits that spread over more than 410 positions."""
    index: int
    """The row of the argument."""

class OptionError(Error, ValueError):
    """An option, or a combination of options, that is not valid."""

class InputError(Error, ValueError):
    """A file that cannot be read as what it should be."""
    path: str
    line: int | None

class MemoryLimitError(Error, MemoryError):
    """The forecast is above max_memory. No memory was taken."""
    forecast: int
    limit: int

class DomainError(Error, ValueError):
    """A domain that has no mesh."""
    defects: list[str]

class RunError(Error, RuntimeError):
    """A worker failed, or the certificate was refused. Please report it with the points."""

# Ragged arrays: rows of different lengths in two arrays.

class Ragged(Sequence[Ids]):
    """Row i is values[offsets[i]:offsets[i + 1]]."""
    def __init__(self, offsets: npt.ArrayLike, values: npt.ArrayLike) -> None:
        """Copies and checks the arrays: ValueError or TypeError if they are no rows."""
    @property
    def offsets(self) -> npt.NDArray[np.int64]: ...
    @property
    def values(self) -> Ids: ...
    @overload
    def __getitem__(self, i: int) -> Ids: ...
    @overload
    def __getitem__(self, i: slice) -> Ragged: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Ids]: ...
    def tolist(self) -> list[list[int]]: ...

class Weights(NamedTuple):
    """Rows of a sparse matrix: scipy.sparse.csr_array((data, indices, indptr), shape=(queries, n)) @ values interpolates.

    A query outside of the hull has an empty row. Each other row adds up to 1 to rounding and has no negative weight.
    """
    indptr: npt.NDArray[np.int64]
    indices: Ids
    data: Floats

# Triangulations.

class Delaunay:
    """The exact Delaunay triangulation of points in the plane or in space.

    Names and rules of scipy.spatial.Delaunay hold where both have them. The option qhull_options does not exist.
    """
    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        weights: npt.ArrayLike | None = None,
        period: Period | None = None,
        origin: npt.ArrayLike | None = None,
        wrap: bool = False,
        threads: int | None = None,
        seed: int = 1,
        on_invalid: Literal["raise", "skip"] = "raise",
        max_memory: int | None = None,
        progress: Progress | None = None,
    ) -> None: ...
    @property
    def points(self) -> Floats:
        """(n, d). A copy of the argument, so that later changes of the argument do not matter."""
    @property
    def ndim(self) -> int: ...
    @property
    def dimension(self) -> int:
        """Dimension of the affine hull of the points, from -1 (no points) to ndim."""
    @property
    def simplices(self) -> Ids:
        """(m, d + 1)."""
    @property
    def neighbors(self) -> Ids:
        """(m, d + 1). neighbors[i, k] is across the facet opposite simplices[i, k]; -1 outside of the hull."""
    @property
    def convex_hull(self) -> Ids:
        """(h, d). Facets of the hull, seen counter-clockwise from outside, sorted. Coplanar hull points are vertices."""
    @property
    def duplicates(self) -> Ids:
        """(k, 2). Each coincident point and the first point at its place, which is the vertex. With weights, it is the first of the heaviest."""
    @property
    def coplanar(self) -> Ids:
        """(k, 3). As in scipy: a point that is not a vertex, a simplex at it, the vertex at its place. Only duplicates occur. A duplicate of a
        hidden point has -1 for both."""
    @property
    def hidden(self) -> Ids:
        """(k,). Points that weights hide, ascending: they are not vertices. Empty without weights."""
    @property
    def offsets(self) -> npt.NDArray[np.int32] | None:
        """(m, d + 1, d). In a periodic box, the vertices lie at points[simplices] + offsets * period, with 0 in the place of None in
        `period`. None without a box."""
    @property
    def simplicial(self) -> bool:
        """Whether the simplices are a simplicial complex. In a box, they are not if a point is joined to itself or twice to another."""
    @property
    def sheets(self) -> tuple[int, ...] | None:
        """In a periodic box, the smallest numbers of boxes along each axis whose triangulation is a simplicial complex."""
    @property
    def skipped(self) -> Ids:
        """Rows that on_invalid="skip" dropped."""
    @property
    def vertex_to_simplex(self) -> Ids:
        """(n,). The first simplex of each vertex; that of its vertex for a duplicate; -1 if there is none."""
    @property
    def vertex_neighbor_vertices(self) -> tuple[npt.NDArray[np.int64], Ids]:
        """(indptr, indices). indices[indptr[v]:indptr[v + 1]] are the neighbours of v, sorted."""
    @property
    def edges(self) -> Ids:
        """(e, 2). All edges, smaller vertex first, sorted."""
    @property
    def volumes(self) -> Floats:
        """(m,). Areas or volumes of the simplices: positive, with a relative error below 1e-15; in a box, of edges that are rounded."""
    @property
    def circumcenters(self) -> Floats:
        """(m, d)."""
    @property
    def circumradii(self) -> Floats:
        """(m,). With a relative error below 1e-14, also for slivers."""
    @property
    def transform(self) -> Floats:
        """(m, d + 1, d). As in scipy: c = transform[i, :d] @ (x - transform[i, d]) are barycentric coordinates, the last is 1 - c.sum()."""
    def find_simplex(self, x: npt.ArrayLike, *, threads: int | None = None) -> Ids:
        """Shape x.shape[:-1]. The simplex that contains each query, exactly: on common faces, the one with the smallest
        index; -1 strictly outside of the hull, and for a query that is not finite.

        No tolerance: every point of the set is inside, also each hull vertex. Raises PointError for a query whose digits
        do not fit those of the points (see PointError).
        """
    def barycentric(self, x: npt.ArrayLike, simplex: npt.ArrayLike | None = None, *, threads: int | None = None) -> tuple[Ids, Floats]:
        """Simplex and barycentric coordinates of each query; NaN outside. Coordinates are at least 0 and add up to 1; the
        coordinate of a vertex is 0 if the query lies on the facet opposite it."""
    def nearest_vertex(self, x: npt.ArrayLike, *, threads: int | None = None) -> Ids:
        """Shape x.shape[:-1]. The vertex nearest to each query, exactly; the smallest index if several are."""
    def weights(self, x: npt.ArrayLike, method: Method = "linear", *, threads: int | None = None) -> Weights:
        """The weights of the points in an interpolation, for reuse with many values."""
    def interpolate(
        self,
        values: npt.ArrayLike,
        x: npt.ArrayLike,
        method: Method = "linear",
        *,
        fill_value: float = ...,
        threads: int | None = None,
    ) -> Floats:
        """Shape x.shape[:-1] + values.shape[1:]. Outside of the hull, fill_value (NaN). Values at duplicates are ignored."""
    def gradients(self, values: npt.ArrayLike) -> Floats:
        """(m, d) + values.shape[1:]. The gradient of the linear interpolant in each simplex."""
    def alpha_filtration(self) -> AlphaFiltration: ...
    def alpha_shape(self, radius: float) -> AlphaShape: ...
    def to_scipy(self) -> Any:
        """A scipy.spatial.Delaunay with these simplices, for example for CloughTocher2DInterpolator. Needs scipy."""
    def to_meshio(self) -> Any:
        """A meshio.Mesh. Needs meshio."""
    def to_pyvista(self) -> Any:
        """A pyvista object. Needs pyvista."""
    def __copy__(self) -> Delaunay: ...
    def __deepcopy__(self, memo: dict[int, Any]) -> Delaunay: ...
    @property
    def stats(self) -> dict[str, Any]:
        """The counts of the run, as `septet triangulate --json` writes them."""
    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes any format of `septet triangulate -o`, by the ending."""

class AlphaFiltration(NamedTuple):
    """The alpha complex: the squared radius from which on each simplex belongs to it, as in CGAL and gudhi.

    A face has at most the value of each simplex that it belongs to. Vertices have the value 0.
    """
    cells: Floats
    """(m,). For the rows of simplices."""
    facets: Ids
    """(f, d). All facets, sorted."""
    facet_values: Floats
    edges: Ids
    """(e, 2). In the plane, edges are the facets."""
    edge_values: Floats

class AlphaShape(NamedTuple):
    """The alpha complex of a radius."""
    cells: npt.NDArray[np.bool_]
    """(m,). Whether each simplex belongs to it."""
    boundary: Ids
    """(b, d). Facets between a simplex that belongs to it and one that does not, seen counter-clockwise from outside."""
    singular: Ids
    """(s, d). Facets of the complex without a simplex of the complex on either side."""
    volume: float

class Voronoi:
    """The Voronoi diagram of points, unbounded, clipped to a box, or in a periodic box. With weights, the power diagram.

    Names of scipy.spatial.Voronoi hold where both have them.
    """
    def __init__(
        self,
        points: npt.ArrayLike | Delaunay,
        *,
        box: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        weights: npt.ArrayLike | None = None,
        period: Period | None = None,
        origin: npt.ArrayLike | None = None,
        wrap: bool = False,
        threads: int | None = None,
    ) -> None:
        """`box` is (low, high). Vertices outside of it raise PointError. Points with weights need a box. A periodic box needs one only if an
        axis is not periodic; its ends along periodic axes are not used. `weights`, `period`, `origin` and `wrap` are not allowed if `points`
        is a Delaunay, which has its own."""
    def __copy__(self) -> Voronoi: ...
    def __deepcopy__(self, memo: dict[int, Any]) -> Voronoi: ...
    @property
    def points(self) -> Floats: ...
    @property
    def delaunay(self) -> Delaunay: ...
    @property
    def vertices(self) -> Floats:
        """(v, d). Without a box: the circumcentres, in the order of the simplices, each once. With weights or a periodic box: the corners of
        the cells, one cell after the other."""
    @property
    def ridge_points(self) -> Ids:
        """(r, 2). The two points of each ridge, smaller first, sorted. With a box, -1 - k for side k of the box (x low, x high, y low, ...)."""
    @property
    def ridge_vertices(self) -> Ragged:
        """The vertices of each ridge in order around it, -1 for infinity."""
    @property
    def ridge_areas(self) -> Floats:
        """(r,). Lengths or areas; inf if unbounded."""
    @property
    def regions(self) -> Ragged:
        """The vertices of each region, sorted, -1 for infinity."""
    @property
    def point_region(self) -> Ids:
        """(n,). The region of each point: that of its vertex for a duplicate; -1 for a skipped or hidden point and its duplicates."""
    @property
    def volumes(self) -> Floats:
        """(n,). Areas or volumes of the cells; inf if unbounded, 0 for duplicates. With a box, they add up to its volume."""
    @property
    def centroids(self) -> Floats:
        """(n, d). Centroids of the cells; NaN if unbounded."""
    def to_meshio(self) -> Any:
        """A meshio.Mesh. Needs meshio."""
    def to_pyvista(self) -> Any:
        """A pyvista object. Needs pyvista."""

# The machine.

class Run:
    """A run of the paper's algorithm with its counts."""
    @property
    def delaunay(self) -> Delaunay: ...
    @property
    def report(self) -> dict[str, Any]:
        """The JSON of `septet simulate --json`, with the same keys."""
    @property
    def phases(self) -> npt.NDArray[np.void]:
        """The rows `phases` of the report, with its names: name, paper, rounds, work, depth, critical_depth, messages, bytes, seconds."""
    @property
    def rounds(self) -> npt.NDArray[np.void]:
        """The rows `rounds` of the report, with its names: round, phase, active, messages, bytes, largest, and so on."""
    @property
    def levels(self) -> npt.NDArray[np.void]:
        """The rows `tree.by_level` of the report, with its names."""
    def check(self, claim: str) -> None:
        """Raises AssertionError if a claim about the counts, such as "levels(1.5, -5.0)", does not hold."""
    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the report: `.json`, or `.html` for the page."""

def simulate(
    points: npt.ArrayLike,
    *,
    weights: npt.ArrayLike | None = None,
    period: Period | None = None,
    origin: npt.ArrayLike | None = None,
    wrap: bool = False,
    workers: int | Literal["auto", "leaves"] = "auto",
    threads: int | None = None,
    seed: int = 1,
    leaf: int | None = None,
    supergraph: Literal["auto", "density", "overlap", "knn"] = "auto",
    alpha: float | None = None,
    k: int | None = None,
    separator_sets: Literal["none", "ghost", "own", "smaller", "both"] = "ghost",
    progress: Progress | None = None,
) -> Run: ...

def read_run(path: str | os.PathLike[str]) -> Run:
    """A run from its JSON report. Its triangulation is not in the report."""

# Meshes.

class Mesh:
    """A mesh of a domain."""
    def __copy__(self) -> Mesh: ...
    def __deepcopy__(self, memo: dict[int, Any]) -> Mesh: ...
    @property
    def points(self) -> Floats: ...
    @property
    def cells(self) -> Ids: ...
    @property
    def cell_regions(self) -> Ids: ...
    @property
    def facets(self) -> Ids: ...
    @property
    def facet_markers(self) -> Ids: ...
    @property
    def quality(self) -> dict[str, Any]: ...
    def write(self, path: str | os.PathLike[str], *, order: int = 1) -> None: ...
    def to_meshio(self) -> Any:
        """A meshio.Mesh. Needs meshio."""
    def to_pyvista(self) -> Any:
        """A pyvista object. Needs pyvista."""

def mesh(
    domain: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | tuple[npt.ArrayLike, npt.ArrayLike],
    *,
    size: float | Literal["none"] | None = None,
    min_size: float | None = None,
    size_field: str | os.PathLike[str] | tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    boundary: Literal["exact", "remesh"] | None = None,
    keep_surface: bool = False,
    max_distance: float | None = None,
    feature_angle: float = 60.0,
    conforming: bool = False,
    improve: bool = True,
    weld: float | None = None,
    repair: bool = False,
    strict: bool = False,
    threads: int | None = None,
    seed: int = 1,
    max_memory: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """`domain` is a file, files of closed surfaces, or the points and the polygons of one. Raises DomainError."""

# Files and checks.

class Cells(NamedTuple):
    points: Floats
    cells: Ids | None
    """None for a file of points."""

def read(path: str | os.PathLike[str], *, columns: Sequence[str] | None = None, ndim: int | None = None) -> Cells:
    """Reads any format of `septet triangulate` or `septet verify`. Weights, offsets and data of points are not read. The points of a file of a
    periodic box include the images that are vertices. Raises InputError."""

class Verdict(NamedTuple):
    """The verdict of the independent verifier."""
    ok: bool
    faults: list[str]
    simplices: Ids
    """The simplices that the entries of faults name, ascending, each once. A level lists at most 10 faults and counts the others."""

def verify(
    points: npt.ArrayLike,
    simplices: npt.ArrayLike,
    *,
    weights: npt.ArrayLike | None = None,
    period: Period | None = None,
    offsets: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Verdict:
    """Whether the simplices of any program are a Delaunay triangulation of the points, in exact arithmetic: with weights, the regular
    triangulation; in a periodic box, whose vertices have offsets, that of all images. Points and offsets may be up to 2**26 lengths away."""
