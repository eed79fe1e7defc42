"""Queries of a triangulation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._lazy import Lazy
from ._ragged import Weights

if TYPE_CHECKING:
    import numpy.typing as npt

METHODS = ("linear", "sibson", "laplace")


class Queries(Lazy):
    """Location, interpolation and nearest vertices: the methods of `Delaunay` that take queries."""

    __module__ = "septet"
    __slots__ = ("_core",)
    _core: _septet.Core

    @property
    def ndim(self) -> int:
        """Number of coordinates of a point: 2 or 3."""
        return self._core.ndim

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
