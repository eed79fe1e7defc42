"""The class Delaunay."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._alpha import AlphaFiltration, AlphaShape
from ._errors import InputError
from ._lazy import Lazy
from ._ragged import Weights

if TYPE_CHECKING:
    import numpy.typing as npt

METHODS = ("linear", "sibson", "laplace")


class Delaunay(Lazy):
    """The exact Delaunay triangulation of points in the plane or in space.

    Names and rules of `scipy.spatial.Delaunay` hold where both have them. No decision uses a tolerance, so that no
    point of the set is lost, no simplex is flat, and all simplices are positively oriented.

    Parameters
    ----------
    points : array_like of shape (n, 2) or (n, 3)
        Real numbers that float64 holds exactly, in any layout. n = 0 is allowed. Points on a line, or in a plane of
        space, are no error: there are no simplices, and `dimension` is less than `ndim`.
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
        If a point is not finite, or if digits of the coordinates spread over more than 410 positions.
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
        Each coincident point, and the first point at its place, which is the vertex.

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
    """

    __module__ = "septet"
    __slots__ = ("_core",)
    _core: _septet.Core

    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        threads: Optional[int] = None,
        seed: int = 1,
        on_invalid: str = "raise",
        max_memory: Optional[int] = None,
        progress: Optional[Any] = None,
    ) -> None:
        self._begin()
        core = _septet.Core(
            arguments.points(points),
            arguments.threads(threads),
            arguments.whole(seed, "seed", 0, 2**64 - 1),
            arguments.word(on_invalid, "on_invalid", ("raise", "skip")) == "skip",
            arguments.memory(max_memory),
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
        return _restored, (np.asarray(self.points), np.asarray(self.simplices), self._stats)

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
    def ndim(self) -> int:
        """Number of coordinates of a point: 2 or 3."""
        return self._core.ndim

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
        """(k, 2). Each coincident point and the first point at its place, which is the vertex."""
        return self._made("duplicates", self._core.duplicates)

    @property
    def coplanar(self) -> Any:
        """(k, 3). As in scipy: a point that is no vertex, a simplex at it, the vertex at its place. Only duplicates occur."""

        def make() -> Any:
            pairs = self.duplicates
            columns = (pairs[:, 0], self.vertex_to_simplex[pairs[:, 0]], pairs[:, 1])
            return arguments.frozen(np.ascontiguousarray(np.stack(columns, axis=1)))

        return self._made("coplanar", make)

    @property
    def skipped(self) -> Any:
        """Rows that on_invalid="skip" dropped."""
        return self._made("skipped", self._core.skipped)

    @property
    def vertex_to_simplex(self) -> Any:
        """(n,). The first simplex of each vertex; that of its vertex for a duplicate; -1 if there is none."""
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
        """(m,). Areas or volumes of the simplices: positive, with a relative error below 1e-15."""
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

    def find_simplex(self, x: npt.ArrayLike, *, threads: Optional[int] = None) -> Any:
        """Find the simplex that contains each query, exactly.

        Parameters
        ----------
        x : array_like of shape (..., d)
            Queries.
        threads : int, optional
            Number of threads; all cores by default.

        Returns
        -------
        ndarray of int of shape x.shape[:-1]
            On common faces, the simplex with the smallest index; -1 strictly outside of the hull, and for a query that
            is not finite. No tolerance is used: every point of the set is inside, also each hull vertex.

        Examples
        --------
        >>> import septet
        >>> tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
        >>> tri.find_simplex(tri.points)
        array([0, 0, 0], dtype=int32)
        """
        q = arguments.queries(x, self.ndim)
        found = self._core.locate(arguments.rows(q, self.ndim), arguments.threads(threads))
        return arguments.frozen(found.reshape(q.shape[:-1]))

    def barycentric(
        self, x: npt.ArrayLike, simplex: Optional[npt.ArrayLike] = None, *, threads: Optional[int] = None
    ) -> Tuple[Any, Any]:
        """Simplex and barycentric coordinates of each query.

        Parameters
        ----------
        x : array_like of shape (..., d)
            Queries.
        simplex : array_like of int of shape x.shape[:-1], optional
            The simplex of each query, from `find_simplex`. By default, it is found. A query outside of its simplex has
            the coordinates of its own simplex.
        threads : int, optional
            Number of threads; all cores by default.

        Returns
        -------
        simplex : ndarray of int of shape x.shape[:-1]
            The simplex with the smallest index; -1 outside of the hull.
        coordinates : ndarray of shape x.shape[:-1] + (d + 1,)
            Coordinates are at least 0 and add up to 1; NaN outside. The coordinate of a vertex is 0 if the query lies on
            the facet opposite it.

        Examples
        --------
        >>> import septet
        >>> tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
        >>> tri.barycentric([0.25, 0.5])[1]
        array([0.25, 0.25, 0.5 ])
        """
        q = arguments.queries(x, self.ndim)
        given = None
        if simplex is not None:
            given = arguments.indices(simplex, "simplex")
            if given.shape != q.shape[:-1]:
                raise ValueError(f"simplex must have the shape {q.shape[:-1]}, not {given.shape}")
            m = self._core.simplex_count
            if given.size and not (-1 <= int(given.min()) and int(given.max()) < m):
                raise ValueError(f"simplex must have indices from -1 to {m - 1}")
            given = given.reshape(-1)
        cells, coordinates = self._core.barycentric(arguments.rows(q, self.ndim), given, arguments.threads(threads))
        shape = q.shape[:-1]
        return arguments.frozen(cells.reshape(shape)), arguments.frozen(coordinates.reshape(shape + (self.ndim + 1,)))

    def nearest_vertex(self, x: npt.ArrayLike, *, threads: Optional[int] = None) -> Any:
        """Find the vertex nearest to each query, exactly.

        Parameters
        ----------
        x : array_like of shape (..., d)
            Queries, also outside of the hull.
        threads : int, optional
            Number of threads; all cores by default.

        Returns
        -------
        ndarray of int of shape x.shape[:-1]
            The smallest index if several are nearest; -1 without points, and for a query that is not finite.
        """
        q = arguments.queries(x, self.ndim)
        found = self._core.nearest(arguments.rows(q, self.ndim), arguments.threads(threads))
        return arguments.frozen(found.reshape(q.shape[:-1]))

    def weights(self, x: npt.ArrayLike, method: str = "linear", *, threads: Optional[int] = None) -> Weights:
        """The weights of the points in an interpolation, for reuse with many values.

        Parameters
        ----------
        x : array_like of shape (..., d)
            Queries, of which each has a row.
        method : {'linear', 'sibson', 'laplace'}, optional
            Linear in each simplex, or natural neighbours by the weights of Sibson or of Laplace.
        threads : int, optional
            Number of threads; all cores by default.

        Returns
        -------
        Weights
            The arrays indptr, indices and data of a sparse matrix.
        """
        q = arguments.rows(arguments.queries(x, self.ndim), self.ndim)
        method = arguments.word(method, "method", METHODS)
        return Weights(*self._core.weights(q, method, arguments.threads(threads)))

    def interpolate(
        self,
        values: npt.ArrayLike,
        x: npt.ArrayLike,
        method: str = "linear",
        *,
        fill_value: float = float("nan"),
        threads: Optional[int] = None,
    ) -> Any:
        """Interpolate values at the points.

        Parameters
        ----------
        values : array_like of shape (n, ...)
            Values at the points. Those at duplicates are ignored.
        x : array_like of shape (..., d)
            Queries.
        method : {'linear', 'sibson', 'laplace'}, optional
            See `weights`.
        fill_value : float, optional
            The value outside of the hull.
        threads : int, optional
            Number of threads; all cores by default.

        Returns
        -------
        ndarray of shape x.shape[:-1] + values.shape[1:]

        Examples
        --------
        >>> import septet
        >>> tri = septet.Delaunay([[0, 0], [4, 0], [0, 4]])
        >>> tri.interpolate([10, 14, 18], [[1, 1], [4, 0], [3, 3]])
        array([13., 14., nan])
        """
        v = arguments.values(values, self._core.point_count)
        q = arguments.queries(x, self.ndim)
        rest = v.shape[1:]
        columns = v.reshape(len(v), int(np.prod(rest, dtype=np.int64)))
        method = arguments.word(method, "method", METHODS)
        fill = arguments.number(fill_value, "fill_value")
        if columns.shape[1] == 0:
            return arguments.frozen(np.empty(q.shape[:-1] + rest))
        found = self._core.interpolate(
            columns, arguments.rows(q, self.ndim), method, fill, arguments.threads(threads)
        )
        return arguments.frozen(found.reshape(q.shape[:-1] + rest))

    def gradients(self, values: npt.ArrayLike) -> Any:
        """The gradient of the linear interpolant in each simplex.

        Parameters
        ----------
        values : array_like of shape (n, ...)
            Values at the points.

        Returns
        -------
        ndarray of shape (m, d) + values.shape[1:]
        """
        v = arguments.values(values, self._core.point_count)
        rest = v.shape[1:]
        columns = v.reshape(len(v), int(np.prod(rest, dtype=np.int64)))
        shape = (self._core.simplex_count, self.ndim) + rest
        if columns.shape[1] == 0:
            return arguments.frozen(np.empty(shape))
        found = self._core.gradients(columns)
        return arguments.frozen(found.reshape(shape))

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

        return to_scipy(self)

    def to_meshio(self) -> Any:
        """Return a meshio.Mesh with these points and simplices. Needs meshio."""
        from ._convert import to_meshio

        return to_meshio(self.points, self.simplices)

    def to_pyvista(self) -> Any:
        """Return a pyvista.UnstructuredGrid with these points and simplices. Needs pyvista."""
        from ._convert import to_pyvista

        return to_pyvista(self.points, self.simplices)

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
            The file. It appears under its name when it is complete.
        """
        self._core.write(os.fspath(path))


def _restored(points: Any, simplices: Any, stats: str) -> Delaunay:
    """Checks the contents of a pickle, and returns its triangulation."""
    rows = arguments.indices(simplices, "simplices")
    if rows.ndim != 2 or not isinstance(stats, str):
        raise InputError("the pickle holds no triangulation; make it again")
    return Delaunay._of(_septet.Core.restored(arguments.points(points), rows, stats))
