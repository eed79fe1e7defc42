"""The class Delaunay."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._alpha import AlphaFiltration, AlphaShape
from ._errors import InputError, OptionError
from ._queries import Queries

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Period


class Delaunay(Queries):
    """The exact Delaunay triangulation of points in the plane or in space.

    Names and rules of `scipy.spatial.Delaunay` hold where both have them. No decision uses a tolerance, so that no
    point of the set is lost, no simplex is flat, and all simplices are positively oriented.

    Parameters
    ----------
    points : array_like of shape (n, 2) or (n, 3)
        Real numbers that float64 holds exactly, in any layout. n = 0 is allowed. Points on a line, or in a plane of
        space, are no error: there are no simplices, and `dimension` is less than `ndim`.
    weights : array_like of shape (n,), optional
        Weights of the points, which are squared lengths: the triangulation is then the regular one, the dual of the power
        diagram. For balls of radius r, pass ``weights=r**2``. Points whose lifts lie above the lower hull are not vertices;
        they are listed in `hidden`. Queries of nearest points, natural neighbours and alpha shapes raise OptionError.
    period : float or array_like of shape (d,), optional
        Lengths of a box that repeats, from `origin` on; None for an axis that is not periodic. The simplices are one of
        each class of translated simplices, and `offsets` has the images that are their vertices. Only arrays of simplices
        have a meaning then; location, interpolation, hull and edges raise OptionError.
    origin : array_like of shape (d,), optional
        The lower corner of the periodic box. By default, 0.
    wrap : bool, optional
        Whether points outside of the periodic box are admitted, as images of points in it, up to 2**20 lengths away. Otherwise,
        they raise PointError.
    threads : int, optional
        Number of threads. By default, all cores that the process may use. Results do not depend on it.
    seed : int, optional
        Seed of the random draws. Results do not depend on it; counts in `stats` do.
    on_invalid : {'raise', 'skip'}, optional
        Whether a point with a NaN or an infinity raises PointError, or is dropped and listed in `skipped`.
    max_memory : int, optional
        The most memory that the process may use, in bytes.
    progress : callable, optional
        Called with the phase, its position, and the number of phases, at most every 0.1 s, on the caller's thread. An
        exception ends the call.

    Raises
    ------
    PointError
        If a point or a weight is not finite, if a point lies outside of the periodic box, or if digits of the coordinates
        spread over more than 410 positions.
    MemoryLimitError
        If more than `max_memory` is needed.

    Attributes
    ----------
    points : ndarray of shape (n, d)
        A copy of the argument.
    simplices : ndarray of int of shape (m, d + 1)
        Vertices of the simplices: positively oriented, with the smallest vertex first, and sorted.
    neighbors : ndarray of int of shape (m, d + 1)
        The simplex across the facet opposite each vertex; -1 outside of the hull.
    convex_hull : ndarray of int of shape (h, d)
        Facets of the hull, seen counter-clockwise from outside, sorted.
    duplicates : ndarray of int of shape (k, 2)
        Each coincident point, and the first point at its place, which is the vertex. With weights, it is the first of the
        heaviest points at its place; lighter ones are in `hidden`.
    hidden : ndarray of int of shape (k,)
        The points that weights hide, ascending.
    offsets : ndarray of int32 of shape (m, d + 1, d), or None
        In a periodic box, the whole numbers of lengths to the image of each vertex:
        ``points[simplices] + offsets * period``, with 0 in the place of None in `period`.

    Notes
    -----
    All arrays are read-only and C-contiguous. Indices are int32, or int64 if there are 2**31 points or simplices. The
    object may be shared by threads, pickled and copied.

    Examples
    --------
    >>> import numpy as np
    >>> import septet
    >>> points = np.array([[0, 0], [0, 1.1], [1, 0], [1, 1]])
    >>> tri = septet.Delaunay(points)
    >>> tri.simplices
    array([[0, 2, 3],
           [0, 3, 1]], dtype=int32)
    >>> tri.neighbors[1]
    array([-1, -1,  0], dtype=int32)
    >>> tri.find_simplex([[0.1, 0.2], [1.5, 0.5]])
    array([ 1, -1], dtype=int32)

    Balls of different radii, of which the last one is hidden:

    >>> radii = np.array([2.0, 1.0, 1.0, 0.1])
    >>> septet.Delaunay([[0, 0], [2, 0], [0, 2], [0.5, 0.5]], weights=radii**2).hidden
    array([3], dtype=int32)

    A periodic box of one point, whose images are the vertices of two triangles:

    >>> box = septet.Delaunay([[0.5, 0.5]], period=1)
    >>> box.simplices.tolist(), box.offsets[:, 0].tolist()
    ([[0, 0, 0], [0, 0, 0]], [[0, 0], [0, 0]])
    """

    __module__ = "septet"
    __slots__ = ()

    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        weights: Optional[npt.ArrayLike] = None,
        period: Optional[Period] = None,
        origin: Optional[npt.ArrayLike] = None,
        wrap: bool = False,
        threads: Optional[int] = None,
        seed: int = 1,
        on_invalid: str = "raise",
        max_memory: Optional[int] = None,
        progress: Optional[Any] = None,
    ) -> None:
        self._begin()
        rows = arguments.points(points)
        core = _septet.Core(
            rows,
            arguments.sites(rows, weights, period, origin, wrap),
            arguments.threads(threads),
            (
                arguments.whole(seed, "seed", 0, 2**64 - 1),
                arguments.word(on_invalid, "on_invalid", ("raise", "skip")) == "skip",
                arguments.memory(max_memory),
            ),
            arguments.progress(progress),
        )
        self._set("_core", core)

    @classmethod
    def _of(cls, core: _septet.Core) -> Delaunay:
        made = cls.__new__(cls)
        made._set("_core", core)
        made._set("_cache", {})
        return made

    def __reduce__(self) -> Any:
        contents = (np.asarray(self.points), np.asarray(self.simplices), self._stats)
        core = self._core
        return _restored, contents + ((core.sites(),) if core.has_weights or core.is_periodic else ())

    def __copy__(self) -> Delaunay:
        return self

    def __deepcopy__(self, memo: Dict[int, Any]) -> Delaunay:
        return self

    def __repr__(self) -> str:
        n, m = self._core.point_count, self._core.simplex_count
        return f"<septet.Delaunay: {n} points, {m} simplices, {self.ndim} dimensions>"

    @property
    def points(self) -> Any:
        """(n, d). A copy of the argument, so that later changes of the argument do not matter."""
        return self._made("points", self._core.points)

    @property
    def dimension(self) -> int:
        """Dimension of the affine hull of the points, from -1 (no points) to ndim."""
        return self._core.dimension

    @property
    def simplices(self) -> Any:
        """(m, d + 1). Positively oriented, with the smallest vertex first, and sorted."""
        return self._made("simplices", self._core.simplices)

    @property
    def neighbors(self) -> Any:
        """(m, d + 1). neighbors[i, k] is across the facet opposite simplices[i, k]; -1 outside of the hull."""
        return self._made("neighbors", self._core.neighbors)

    @property
    def convex_hull(self) -> Any:
        """(h, d). Facets of the hull, seen counter-clockwise from outside, sorted. Coplanar hull points are vertices."""
        return self._made("convex_hull", self._core.convex_hull)

    @property
    def duplicates(self) -> Any:
        """(k, 2). Each coincident point and the first point at its place, which is the vertex.

        With weights, it is the first of the heaviest points at its place; lighter ones are in `hidden`. If others hide it, it is in
        `hidden`, too.
        """
        return self._made("duplicates", self._core.duplicates)

    @property
    def coplanar(self) -> Any:
        """(k, 3). As in scipy: a point that is not a vertex, a simplex at it, the vertex at its place. Only duplicates occur.

        A duplicate of a hidden point has -1 for both.
        """

        def make() -> Any:
            pairs = self.duplicates
            vertices = np.where(np.isin(pairs[:, 1], self.hidden), pairs.dtype.type(-1), pairs[:, 1])
            columns = (pairs[:, 0], self.vertex_to_simplex[pairs[:, 0]], vertices)
            return arguments.frozen(np.ascontiguousarray(np.stack(columns, axis=1)))

        return self._made("coplanar", make)

    @property
    def hidden(self) -> Any:
        """(k,). Points that weights hide, ascending: they are not vertices. Empty without weights."""
        return self._made("hidden", self._core.hidden)

    @property
    def offsets(self) -> Any:
        """(m, d + 1, d). In a periodic box, the whole numbers of lengths to each vertex; None without a box.

        The vertices lie at ``points[simplices] + offsets * period``, with 0 in the place of None in `period`. The first one of a
        simplex has the offset 0. The type is int32.
        """
        return self._made("offsets", self._core.offsets)

    @property
    def simplicial(self) -> bool:
        """Whether the simplices are a simplicial complex: in a periodic box, no point is joined to itself, or twice to another."""
        return self._core.is_simplicial

    @property
    def sheets(self) -> Optional[Tuple[int, ...]]:
        """The smallest numbers of boxes along each axis whose triangulation is a simplicial complex; None without a box."""
        sheets = self._core.sheets()
        return None if sheets is None else tuple(sheets)

    @property
    def skipped(self) -> Any:
        """Rows that on_invalid="skip" dropped."""
        return self._made("skipped", self._core.skipped)

    @property
    def vertex_to_simplex(self) -> Any:
        """(n,). The first simplex of each vertex; that of its vertex for a duplicate; -1 if there is none, as for a hidden point."""
        return self._made("vertex_to_simplex", self._core.vertex_to_simplex)

    @property
    def vertex_neighbor_vertices(self) -> Tuple[Any, Any]:
        """(indptr, indices). indices[indptr[v]:indptr[v + 1]] are the neighbours of v, sorted."""
        made: Tuple[Any, Any] = self._made("vertex_neighbor_vertices", self._core.vertex_neighbors)
        return made

    @property
    def edges(self) -> Any:
        """(e, 2). All edges, smaller vertex first, sorted."""
        return self._made("edges", self._core.edges)

    @property
    def volumes(self) -> Any:
        """(m,). Areas or volumes of the simplices: positive, with a relative error below 1e-15, also in a periodic box."""
        return self._made("volumes", self._core.volumes)

    @property
    def circumcenters(self) -> Any:
        """(m, d)."""
        return self._made("circumcenters", self._core.circumcenters)

    @property
    def circumradii(self) -> Any:
        """(m,). With a relative error below 1e-14, also for slivers."""
        return self._made("circumradii", self._core.circumradii)

    @property
    def transform(self) -> Any:
        """(m, d + 1, d). As in scipy: c = transform[i, :d] @ (x - transform[i, d]) are barycentric coordinates.

        The last coordinate is 1 - c.sum().
        """
        return self._made("transform", self._core.transform)

    def alpha_filtration(self) -> AlphaFiltration:
        """The alpha complex: the squared radius from which on each simplex belongs to it.

        Values are those of CGAL and gudhi. A face has at most the value of each simplex that it belongs to.
        """
        made: AlphaFiltration = self._made(
            "alpha_filtration", lambda: AlphaFiltration(*_septet.alpha_filtration(self._core))
        )
        return made

    def alpha_shape(self, radius: float) -> AlphaShape:
        """The alpha complex of a radius.

        Parameters
        ----------
        radius : float
            The largest radius of an empty ball. The parameter of the package alphashape is 1 / radius, and that of CGAL
            and gudhi is radius ** 2.

        Examples
        --------
        >>> import septet
        >>> tri = septet.Delaunay([[0, 0], [1, 0], [0, 1], [5, 5]])
        >>> shape = tri.alpha_shape(1)
        >>> shape.volume
        0.5
        >>> shape.boundary
        array([[0, 1],
               [1, 2],
               [2, 0]], dtype=int32)
        """
        return AlphaShape(*_septet.alpha_shape(self._core, arguments.number(radius, "radius")))

    def to_scipy(self) -> Any:
        """Return a scipy.spatial.Delaunay with these simplices, for example for CloughTocher2DInterpolator. Needs scipy."""
        from ._convert import to_scipy

        if self._core.has_weights or self._core.is_periodic:
            raise OptionError("scipy has no triangulations with weights or in a periodic box; use to_meshio or to_pyvista")
        return to_scipy(self)

    def to_meshio(self) -> Any:
        """Return a meshio.Mesh with these points and simplices. Needs meshio.

        In a periodic box, images that are vertices follow the points.
        """
        from ._convert import to_meshio

        return to_meshio(*self._picture())

    def to_pyvista(self) -> Any:
        """Return a pyvista.UnstructuredGrid with these points and simplices. Needs pyvista.

        In a periodic box, images that are vertices follow the points.
        """
        from ._convert import to_pyvista

        return to_pyvista(*self._picture())

    def _picture(self) -> Tuple[Any, Any]:
        """Points and simplices without offsets."""
        unfolded = self._core.unfolded()
        return (self.points, self.simplices) if unfolded is None else unfolded

    @property
    def _stats(self) -> str:
        return self._core.stats()

    @property
    def stats(self) -> Dict[str, Any]:
        """The counts of the run, as ``septet triangulate --json`` writes them."""
        made: Dict[str, Any] = json.loads(self._stats)
        return made

    def write(self, path: "str | os.PathLike[str]") -> None:
        """Write any format of ``septet triangulate -o``, by the ending.

        Parameters
        ----------
        path : str or path
            The file. It appears under its name when it is complete. In a periodic box, it has the images that are vertices as
            points, with their rows and offsets if the format holds data of points.
        """
        self._core.write(os.fsdecode(path))


def _restored(points: Any, simplices: Any, stats: str, sites: Any = (None, None)) -> Delaunay:
    """Checks the contents of a pickle, and returns its triangulation."""
    rows = arguments.indices(simplices, "simplices")
    if rows.ndim != 2 or not isinstance(stats, str):
        raise InputError("the pickle holds no triangulation; make it again")
    return Delaunay._of(_septet.Core.restored(arguments.points(points), rows, arguments.stored(sites), stats))
