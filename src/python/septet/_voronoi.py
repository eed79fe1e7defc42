"""The class Voronoi."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple, Union

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._delaunay import Delaunay
from ._errors import OptionError
from ._lazy import Lazy
from ._ragged import Ragged

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Period


class Voronoi(Lazy):
    """The Voronoi diagram of points, unbounded, clipped to a box, or in a periodic box.

    Names of `scipy.spatial.Voronoi` hold where both have them.

    Parameters
    ----------
    points : array_like of shape (n, 2) or (n, 3), or Delaunay
        The points, or their triangulation, with weights or a periodic box if it has them.
    box : tuple of array_like, optional
        The corners (low, high) of a box, which must contain all vertices. All results are then those of the parts in the
        box. Points with weights need it. A periodic box needs it only if an axis is not periodic; its ends along periodic
        axes are not used.
    weights, period, origin, wrap : optional
        See `Delaunay`. They are not allowed if `points` is a Delaunay, which has its own. With weights, the cells are those
        of the power diagram: ``weights=r**2`` for balls of radius r. In a periodic box, the volumes add up to it. Cells are
        then made one by one: `vertices` are the corners of each, and there are no ridges.
    threads : int, optional
        Number of threads; all cores by default.

    Raises
    ------
    PointError
        If a point is not finite or lies outside of the box.
    OptionError
        If cells, ridges or volumes of flat points are requested: they have no simplices. If points with weights have no box, if
        a box is given although all axes are periodic, or if ridges are requested with weights or in a periodic box.
    MemoryLimitError
        If the cells of points with weights or in a periodic box have 2**32 - 1 corners or more.

    Attributes
    ----------
    vertices : ndarray of shape (v, d)
        The circumcentres of the simplices. With a box, the corners of the parts of the cells in it.
    ridge_points : ndarray of int of shape (r, 2)
        The two points of each ridge, smaller first, sorted. With a box, -1 - k for side k of the box.
    ridge_vertices : Ragged
        The vertices of each ridge in order around it, -1 for infinity.
    volumes : ndarray of shape (n,)
        Areas or volumes of the cells; inf if unbounded, 0 for duplicates.

    Examples
    --------
    >>> import septet
    >>> cells = septet.Voronoi([[1, 1], [3, 1], [1, 3], [3, 3]], box=([0, 0], [4, 4]))
    >>> cells.volumes
    array([4., 4., 4., 4.])
    >>> septet.Voronoi([[1, 1], [3, 1], [1, 3], [3, 3]]).volumes
    array([inf, inf, inf, inf])
    >>> septet.Voronoi([[0.5, 0.5], [2.5, 0.5]], period=(4, 1)).volumes
    array([2., 2.])
    """

    __module__ = "septet"
    __slots__ = ("_delaunay", "_box", "_threads")
    _delaunay: Delaunay
    _box: Optional[Tuple[Any, Any]]
    _threads: Optional[int]

    def __init__(
        self,
        points: Union[npt.ArrayLike, Delaunay],
        *,
        box: Optional[Tuple[npt.ArrayLike, npt.ArrayLike]] = None,
        weights: Optional[npt.ArrayLike] = None,
        period: Optional[Period] = None,
        origin: Optional[npt.ArrayLike] = None,
        wrap: bool = False,
        threads: Optional[int] = None,
    ) -> None:
        self._begin()
        threads = arguments.threads(threads)
        if not isinstance(points, Delaunay):
            delaunay = Delaunay(
                points, weights=weights, period=period, origin=origin, wrap=wrap, threads=threads
            )
        elif weights is None and period is None and origin is None and not wrap:
            delaunay = points
        else:
            raise OptionError("weights, period, origin and wrap are those of the triangulation; pass them to Delaunay")
        corners = None if box is None else _corners(box, delaunay.ndim)
        self._set("_delaunay", delaunay)
        self._set("_box", corners)
        self._set("_threads", threads)
        if corners is not None or self._has_power_cells():
            # Points outside of the box are errors of this call.
            self._cache["volumes"] = self._make_volumes()

    def __reduce__(self) -> Any:
        return _restored, (self._delaunay, self._box)

    def __copy__(self) -> Voronoi:
        return self

    def __deepcopy__(self, memo: Any) -> Voronoi:
        return self

    def __repr__(self) -> str:
        if self._delaunay._core.is_periodic:
            where = "in a periodic box"
        else:
            where = "unbounded" if self._box is None else "in a box"
        return f"<septet.Voronoi: {len(self.points)} points, {self._delaunay.ndim} dimensions, {where}>"

    @property
    def points(self) -> Any:
        """(n, d). A copy of the argument."""
        return self._delaunay.points

    @property
    def delaunay(self) -> Delaunay:
        """The triangulation of the points."""
        return self._delaunay

    def _has_power_cells(self) -> bool:
        """Whether the cells are made one by one: those of points with weights or in a periodic box."""
        core = self._delaunay._core
        return core.has_weights or core.is_periodic

    def _power_cells(self) -> Tuple[Any, Ragged]:
        """Corners of the power cells, and those of each point."""

        def make() -> Tuple[Any, Ragged]:
            corners, offsets, rows = _septet.power_cells(self._delaunay._core, self._box, self._threads)
            return corners, Ragged._of(offsets, rows)

        made: Tuple[Any, Ragged] = self._made("power_cells", make)
        return made

    def _diagram(self) -> Tuple[Any, Any, Ragged, Any]:
        """Vertices, points of the ridges, their vertices, and their areas."""

        def make() -> Tuple[Any, Any, Ragged, Any]:
            core = self._delaunay._core
            if self._box is None:
                vertices = self._delaunay.circumcenters
                points, offsets, rows, areas = _septet.voronoi_ridges(core, self._threads)
            else:
                vertices, points, offsets, rows, areas = _septet.voronoi_in(core, *self._box, self._threads)
            return vertices, points, Ragged._of(offsets, rows), areas

        made: Tuple[Any, Any, Ragged, Any] = self._made("diagram", make)
        return made

    @property
    def vertices(self) -> Any:
        """(v, d). Without a box: the circumcentres, in the order of the simplices, each once.

        With weights or a periodic box: the corners of the cells, one cell after the other.
        """
        if self._has_power_cells():
            return self._power_cells()[0]
        return self._delaunay.circumcenters if self._box is None else self._diagram()[0]

    @property
    def ridge_points(self) -> Any:
        """(r, 2). The two points of each ridge, smaller first, sorted. With a box, -1 - k for side k of the box.

        The sides are x low, x high, y low, and so on.
        """
        return self._diagram()[1]

    @property
    def ridge_vertices(self) -> Ragged:
        """The vertices of each ridge in order around it, -1 for infinity."""
        return self._diagram()[2]

    @property
    def ridge_areas(self) -> Any:
        """(r,). Lengths or areas; inf if unbounded."""
        return self._diagram()[3]

    @property
    def regions(self) -> Ragged:
        """The vertices of each region, sorted, -1 for infinity.

        With weights or a periodic box, a region has vertices of its own: in the plane counter-clockwise.
        """

        def make() -> Ragged:
            if self._has_power_cells():
                return self._power_cells()[1]
            if self._box is None:
                return Ragged._of(*_septet.voronoi_regions(self._delaunay._core, self._threads))
            return _regions(len(self.points), self.ridge_points, self.ridge_vertices)

        made: Ragged = self._made("regions", make)
        return made

    @property
    def point_region(self) -> Any:
        """(n,). The region of each point: that of its vertex for a duplicate.

        -1 for a skipped or hidden point, and for a duplicate of a hidden one.
        """

        def make() -> Any:
            duplicates = self._delaunay.duplicates
            regions = np.arange(len(self.points), dtype=duplicates.dtype)
            regions[self._delaunay.skipped] = -1
            regions[self._delaunay.hidden] = -1
            # A point that others hide may have duplicates.
            regions[duplicates[:, 0]] = regions[duplicates[:, 1]]
            return arguments.frozen(regions)

        return self._made("point_region", make)

    def _make_volumes(self) -> Any:
        return _septet.voronoi_volumes(self._delaunay._core, self._box, self._threads)

    @property
    def volumes(self) -> Any:
        """(n,). Areas or volumes of the cells; inf if unbounded, 0 for duplicates. With a box, they add up to its volume.

        With weights: those of the power cells, 0 for hidden points. In a periodic box, they add up to it.
        """
        return self._made("volumes", self._make_volumes)

    @property
    def centroids(self) -> Any:
        """(n, d). Centroids of the cells; NaN if unbounded, and for points without a cell.

        In a periodic box, a cell lies around its point, also if a part of it lies outside of the box.
        """
        return self._made(
            "centroids", lambda: _septet.voronoi_centroids(self._delaunay._core, self._box, self._threads)
        )

    def to_meshio(self) -> Any:
        """Return a meshio.Mesh with the bounded ridges: lines or polygons. Needs meshio."""
        from ._convert import ridges_to_meshio

        return ridges_to_meshio(self)

    def to_pyvista(self) -> Any:
        """Return a pyvista.PolyData with the bounded ridges, and their points and areas as cell data. Needs pyvista."""
        from ._convert import ridges_to_pyvista

        return ridges_to_pyvista(self)


def _corners(box: Any, ndim: int) -> Tuple[Any, Any]:
    """Checks the corners of a box."""
    try:
        low, high = box
    except (TypeError, ValueError):
        raise ValueError("box must be the pair (low, high) of its corners") from None
    corners = arguments.floats(low, "box"), arguments.floats(high, "box")
    if any(corner.shape != (ndim,) for corner in corners):
        raise ValueError(f"the corners of box must have the shape ({ndim},)")
    return corners


def _regions(n: int, points: Any, rows: Ragged) -> Ragged:
    """Collects the vertices of the ridges at each point."""
    lengths = np.diff(rows.offsets)
    ends = np.concatenate([points[:, 0], points[:, 1]]).astype(np.int64)
    ends, vertices = np.repeat(ends, np.tile(lengths, 2)), np.tile(rows.values, 2).astype(np.int64)
    # One number for a point and a vertex sorts much faster than a pair. There are no vertices at infinity in a box.
    width = int(vertices.max(initial=0)) + 1
    keys = np.unique((ends * width + vertices)[ends >= 0])
    offsets = np.searchsorted(keys, np.arange(n + 1, dtype=np.int64) * width)
    return Ragged._of(offsets.astype(np.int64), (keys % width).astype(rows.values.dtype))


def _restored(delaunay: Delaunay, box: Any) -> Voronoi:
    return Voronoi(delaunay, box=box)
