"""Meshes of domains."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._errors import InputError, OptionError
from ._lazy import Lazy

if TYPE_CHECKING:
    import numpy.typing as npt


class Mesh(Lazy):
    """A mesh of a domain. `mesh` makes it.

    Attributes
    ----------
    points : ndarray of shape (n, d)
        The vertices.
    cells : ndarray of int of shape (m, d + 1)
        The triangles or tetrahedra, positively oriented.
    cell_regions : ndarray of int of shape (m,)
        The component of the domain of each cell, from 1.
    facets : ndarray of int of shape (f, d)
        Faces on the boundary and on inner features, oriented outward from their first cell.
    facet_markers : ndarray of int of shape (f,)
        The marker of the feature of each facet.
    quality : dict
        Shapes, sizes and angles of the cells, as in the report of ``septet mesh --json``.
    """

    __module__ = "septet"
    __slots__ = ("_core",)
    _core: _septet.Meshed

    def __init__(self) -> None:
        raise TypeError("septet.mesh makes a Mesh")

    @classmethod
    def _of(cls, core: _septet.Meshed) -> Mesh:
        made = cls.__new__(cls)
        made._set("_core", core)
        made._set("_cache", {})
        return made

    def __reduce__(self) -> Any:
        return _restored, self._core.state()

    def __copy__(self) -> Mesh:
        return self

    def __deepcopy__(self, memo: Any) -> Mesh:
        return self

    def __repr__(self) -> str:
        return f"<septet.Mesh: {len(self.points)} points, {len(self.cells)} cells, {self.points.shape[1]} dimensions>"

    @property
    def points(self) -> Any:
        """(n, d). The vertices."""
        return self._made("points", self._core.points)

    @property
    def cells(self) -> Any:
        """(m, d + 1). The triangles or tetrahedra."""
        return self._made("cells", self._core.cells)

    @property
    def cell_regions(self) -> Any:
        """(m,). The component of the domain of each cell, from 1."""
        return self._made("cell_regions", self._core.cell_regions)

    @property
    def facets(self) -> Any:
        """(f, d). Faces on the boundary and on inner features, oriented outward from their first cell."""
        return self._made("facets", self._core.facets)

    @property
    def facet_markers(self) -> Any:
        """(f,). The marker of the feature of each facet."""
        return self._made("facet_markers", self._core.facet_markers)

    @property
    def quality(self) -> Dict[str, Any]:
        """Shapes, sizes and angles of the cells, as in the report of ``septet mesh --json``."""
        made: Dict[str, Any] = json.loads(self._core.quality())
        return made

    def write(self, path: "str | os.PathLike[str]", *, order: int = 1) -> None:
        """Write any format of ``septet mesh -o``, by the ending.

        Cells of order 2 have a node at the midpoint of each edge. Not every format has them.
        """
        self._core.write(os.fsdecode(path), arguments.whole(order, "order", 1, 2))

    def to_meshio(self) -> Any:
        """Return a meshio.Mesh with the regions as cell data. Needs meshio."""
        from ._convert import to_meshio

        return to_meshio(self.points, self.cells, {"region": self.cell_regions})

    def to_pyvista(self) -> Any:
        """Return a pyvista.UnstructuredGrid with the regions as cell data. Needs pyvista."""
        from ._convert import to_pyvista

        return to_pyvista(self.points, self.cells, {"region": self.cell_regions})


def mesh(
    domain: "str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | Tuple[npt.ArrayLike, Any]",
    *,
    size: Union[float, str, None] = None,
    min_size: Optional[float] = None,
    size_field: "Optional[str | os.PathLike[str] | Tuple[npt.ArrayLike, npt.ArrayLike]]" = None,
    boundary: Optional[str] = None,
    keep_surface: bool = False,
    max_distance: Optional[float] = None,
    feature_angle: float = 60.0,
    conforming: bool = False,
    improve: bool = True,
    weld: Optional[float] = None,
    repair: bool = False,
    strict: bool = False,
    threads: Optional[int] = None,
    seed: int = 1,
    max_memory: Optional[int] = None,
    progress: Optional[Any] = None,
) -> Mesh:
    """Mesh a domain.

    Parameters
    ----------
    domain : str, path, list of paths, or tuple
        A file of ``septet mesh``, files of closed surfaces, each of which is a region, or the points and the polygons of a closed
        surface. In the plane, polygons are the closed loops of the boundary.
    size : float or 'none', optional
        Upper limit of the size. With 'none', the domain is triangulated as it is, without sizes and without quality. Points are
        added, in space, only on edges that cannot be kept otherwise.
    min_size : float, optional
        Lower limit of the size. It overrides every other size.
    size_field : str, path, or tuple of array_like, optional
        A file of ``septet mesh --size-field``, or points of shape (n, d) and the size at each.
    boundary : {'exact', 'remesh'}, optional
        Whether all facets are kept, or only corners and ridges of a surface. By default, 'remesh' for surfaces.
    keep_surface : bool, optional
        Whether no point is placed on the boundary for sizes and shapes. The boundary is then exact.
    max_distance : float, optional
        Largest distance between a surface and its remeshed boundary.
    feature_angle : float, optional
        Edges whose faces turn by more degrees are ridges.
    conforming : bool, optional
        Whether points are placed by Section 5 of the paper. By default, the constrained triangulation is refined: in the plane
        until no angle is below 20 degrees, except between segments of the domain, and in space until no circumradius exceeds
        1.46 times the shortest edge, except near small angles.
    improve : bool, optional
        Whether cells with small angles are removed.
    weld : float, optional
        Points within this distance are joined. Points with equal coordinates always count as one.
    repair : bool, optional
        Whether edges are divided at points on them (T-junctions), double and flat facets are dropped, small holes are closed, and
        bent polygons of surfaces are divided into triangles.
    strict : bool, optional
        Whether equal points, facets that are planar only within the digits of their coordinates, and edges of surfaces with four
        facets are refused.
    threads : int, optional
        Number of threads; all cores by default.
    seed : int, optional
        Seed of the random draws.
    max_memory : int, optional
        The most memory that the process may use, in bytes.
    progress : callable, optional
        Called with the stage, its position, and the number of stages, on the caller's thread.

    Returns
    -------
    Mesh

    Raises
    ------
    DomainError
        If the domain has defects, or if features cannot be recovered.

    Examples
    --------
    >>> import septet
    >>> square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> made = septet.mesh((square, [[0, 1, 2, 3]]), size=0.5)
    >>> sorted(set(made.cell_regions.tolist()))
    [1]
    """
    flags = {"conforming": conforming, "keep-surface": keep_surface, "repair": repair, "strict": strict}
    for name, flag in {**flags, "improve": improve}.items():
        if not isinstance(flag, (bool, np.bool_)):
            raise OptionError(f"{name.replace('-', '_')} must be True or False, not {flag!r}")
    if strict and (repair or weld is not None):
        raise OptionError("strict refuses what weld and repair change: omit it, or them")
    if keep_surface and boundary == "remesh":
        raise OptionError("keep_surface keeps the boundary: omit it, or boundary='remesh'")
    if keep_surface and conforming:
        raise OptionError("keep_surface adds no points on the boundary: omit it, or conforming")
    as_it_is = isinstance(size, str)
    if as_it_is:
        others = {"min_size": min_size, "size_field": size_field}
        without = [name for name, value in others.items() if value is not None]
        without += [name for name, flag in (("conforming", conforming), ("keep_surface", keep_surface)) if flag]
        without += ["boundary='remesh'"] if boundary == "remesh" else []
        if without:
            raise OptionError(f"{without[0]} has no effect with size='none'; omit one of them")
    options: List[Tuple[str, str]] = [("seed", str(arguments.whole(seed, "seed", 0, 2**64 - 1)))]
    given = {
        "weld": weld,
        "size": size,
        "min-size": min_size,
        "max-distance": max_distance,
        "feature-angle": feature_angle,
    }
    for name, value in given.items():
        if name == "size" and as_it_is:
            options.append((name, arguments.word(size, name, ("none",))))
        elif value is not None:
            options.append((name, repr(arguments.number(value, name.replace("-", "_")))))
    if not as_it_is and size is not None and min_size is not None and float(min_size) > float(size):
        raise OptionError("min_size is larger than size and would override it everywhere; reduce min_size, or omit it")
    if boundary is not None:
        options.append(("boundary", arguments.word(boundary, "boundary", ("exact", "remesh"))))
    options.extend((name, "true") for name, flag in flags.items() if flag)
    if not improve:
        options.append(("no-improve", "true"))
    count = arguments.threads(threads)
    if count is not None:
        options.append(("threads", str(count)))
    limit = arguments.memory(max_memory)
    if limit is not None:
        options.append(("max-memory", str(limit)))
    field = None if size_field is None else _field(size_field)
    core = _septet.Meshed(_domain(domain), options, field, count, arguments.progress(progress))
    return Mesh._of(core)


def _domain(domain: Any) -> Union[List[str], Tuple[Any, Any, Any]]:
    """Converts a domain: paths, or points with polygons as offsets and vertices."""
    if isinstance(domain, (str, bytes, os.PathLike)):
        return [os.fsdecode(domain)]
    if isinstance(domain, (list, tuple)) and domain and all(isinstance(path, (str, bytes, os.PathLike)) for path in domain):
        return [os.fsdecode(path) for path in domain]
    try:
        points, polygons = domain
    except (TypeError, ValueError):
        raise ValueError("domain must be a file, or the pair (points, polygons) of a closed surface") from None
    rows = arguments.points(points)
    loops = [arguments.indices(polygon, "polygons").reshape(-1) for polygon in polygons]
    offsets = np.zeros(len(loops) + 1, dtype=np.int64)
    np.cumsum([len(loop) for loop in loops], out=offsets[1:])
    flat = np.concatenate(loops) if loops else np.zeros(0, dtype=np.int64)
    if flat.size and not (0 <= int(flat.min()) and int(flat.max()) < len(rows)):
        raise ValueError(f"polygons must have indices from 0 to {len(rows) - 1}")
    return rows, offsets, flat


def _field(size_field: Any) -> Union[str, Tuple[Any, Any]]:
    if isinstance(size_field, (str, os.PathLike)):
        path = os.fspath(size_field)
        return path if isinstance(path, str) else os.fsdecode(path)
    try:
        places, sizes = size_field
    except (TypeError, ValueError):
        raise ValueError("size_field must be a file, or the pair (points, sizes)") from None
    rows, values = arguments.points(places, "size_field"), arguments.floats(sizes, "size_field")
    if values.shape != (len(rows),):
        raise ValueError(f"size_field must have one size for each of its {len(rows)} points")
    return rows, values


# The types of the arrays of a pickle: points, cells; regions, attributes; faces, sides, edges; markers, sizes and features of points.
_TYPES = ("f8", "u8", "u4", "f8", "u8", "u4", "i8", "u4", "u8", "u4", "i8", "i8", "f8", "i4")


def _restored(ndim: int, first: int, quality: str, arrays: Any) -> Mesh:
    """Checks the contents of a pickle, and returns its mesh."""
    try:
        if len(arrays) != len(_TYPES) or not isinstance(quality, str):
            raise ValueError
        rows = [np.ascontiguousarray(array).reshape(-1) for array in arrays]
        if any(row.dtype != np.dtype(kind) for row, kind in zip(rows, _TYPES)):
            raise ValueError
        head = (arguments.whole(ndim, "ndim", 2, 3), arguments.whole(first, "first", 0, 2**63 - 1), quality)
    except (TypeError, ValueError):
        raise InputError("the pickle holds no mesh; make it again") from None
    points, cells, regions, attributes = rows[:4]
    faces, sides, edges = tuple(rows[4:7]), rows[7], tuple(rows[8:11])
    made = _septet.Meshed.restored(head, (points, cells), (regions, attributes), (faces, sides, edges), tuple(rows[11:]))
    return Mesh._of(made)
