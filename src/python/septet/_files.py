"""Files, and the verifier."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, List, NamedTuple, Optional

from . import _arguments as arguments
from . import _septet

if TYPE_CHECKING:
    import numpy.typing as npt


class Cells(NamedTuple):
    """The contents of a file."""

    points: Any
    """(n, d)."""
    cells: Any
    """(m, d + 1), or None for a file of points."""


class Verdict(NamedTuple):
    """The verdict of the independent verifier."""

    ok: bool
    """Whether the simplices are a Delaunay triangulation of the points."""
    faults: List[str]
    """The first faults of each level."""
    simplices: Any
    """The simplices that the faults name."""


Cells.__module__ = Verdict.__module__ = "septet"


def read(
    path: "str | os.PathLike[str]", *, columns: Optional[Sequence[str]] = None, ndim: Optional[int] = None
) -> Cells:
    """Read any format of ``septet triangulate`` or ``septet verify``.

    Parameters
    ----------
    path : str or path
        A file of points, or of points with their cells.
    columns : sequence of str, optional
        Columns of the coordinates in a text table: names from the header row, or 1-based numbers.
    ndim : int, optional
        Number of coordinates; 2 keeps the first two.

    Returns
    -------
    Cells

    Raises
    ------
    InputError
        If the file cannot be read as what it should be.
    OSError
        If there is no such file, or if it cannot be opened.
    """
    names = None if columns is None else [str(column) for column in columns]
    dimension = None if ndim is None else arguments.whole(ndim, "ndim", 2, 6)
    return Cells(*_septet.read_file(os.fspath(path), names, dimension))


def verify(
    points: npt.ArrayLike,
    simplices: npt.ArrayLike,
    *,
    threads: Optional[int] = None,
    progress: Optional[Any] = None,
) -> Verdict:
    """Check whether simplices of any program are a Delaunay triangulation of the points, in exact arithmetic.

    Parameters
    ----------
    points : array_like of shape (n, 2) or (n, 3)
        The points.
    simplices : array_like of int of shape (m, d + 1)
        Indices of points, in any order.
    threads : int, optional
        Number of threads; all cores by default.
    progress : callable, optional
        Called with the level of the check, its position, and the number of levels, on the caller's thread.

    Returns
    -------
    Verdict

    Examples
    --------
    >>> import septet
    >>> septet.verify([[0, 0], [2, 0], [0, 2], [1, 3]], [[0, 1, 2], [1, 3, 2]]).ok
    True
    >>> verdict = septet.verify([[0, 0], [2, 0], [0, 2], [0.5, 0.5]], [[0, 1, 2]])
    >>> verdict.ok, verdict.faults
    (False, ['structure: point 3 is not a vertex and coincides with none'])
    """
    rows, cells = arguments.points(points), arguments.indices(simplices, "simplices")
    if cells.ndim != 2 or cells.shape[1] != rows.shape[1] + 1:
        raise ValueError(f"simplices must have the shape (m, {rows.shape[1] + 1}), not {cells.shape}")
    found = _septet.verify(rows, cells, arguments.threads(threads), arguments.progress(progress))
    return Verdict(*found)
