"""Files, and the verifier."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, List, NamedTuple, Optional

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._errors import OptionError

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Period


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
    """The faults, each with its level: at most 10 of a level, then the number of the others."""
    simplices: Any
    """The simplices that the entries of `faults` name, ascending, each once. Faults that are only counted name none, so a list
    of 10 faults of a level may leave out simplices."""


Cells.__module__ = Verdict.__module__ = "septet"


def read(
    path: "str | os.PathLike[str]", *, columns: Optional[Sequence[str]] = None, ndim: Optional[int] = None
) -> Cells:
    """Read any format of ``septet triangulate`` or ``septet verify``.

    Weights, offsets and other data of points are not read. The points of a file of a periodic box include the images that are
    vertices, after those of the input.

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
        If the file cannot be read as what it should be, or if it has integers that float64 does not hold exactly.
    OSError
        If there is no such file, or if it cannot be opened.
    """
    names = None if columns is None else [str(column) for column in columns]
    dimension = None if ndim is None else arguments.whole(ndim, "ndim", 2, 6)
    return Cells(*_septet.read_file(os.fsdecode(path), names, dimension))


def verify(
    points: npt.ArrayLike,
    simplices: npt.ArrayLike,
    *,
    weights: Optional[npt.ArrayLike] = None,
    period: Optional[Period] = None,
    offsets: Optional[npt.ArrayLike] = None,
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
    weights : array_like of shape (n,), optional
        Weights of the points: the simplices must be the regular triangulation, and all points that are not vertices must be
        hidden, or coincide with a vertex of the same weight or with a hidden point.
    period : float or array_like of shape (d,), optional
        Lengths of a periodic box, None along an axis that is not periodic. A point that is more than 2**26 lengths away from
        the box at 0 is a fault. (`Delaunay` admits up to 2**20 lengths with `wrap`.)
    offsets : array_like of int of shape (m, d + 1, d), optional
        The whole numbers of lengths to the image of each vertex, as `Delaunay.offsets`. A periodic box needs them.
        A number above 2**26 is a fault.
    threads : int, optional
        Number of threads; all cores by default.
    progress : callable, optional
        Called with the stage of the check, the position of its level, and the number of levels, on the caller's thread.
        Positions do not decrease; the last call names the last level.

    Returns
    -------
    Verdict
        Whether the check passes, its faults, and the simplices that they name.

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
    w = None if weights is None else arguments.weights(weights, len(rows))
    if (period is None) != (offsets is None):
        raise OptionError("a periodic box needs both period and offsets; add the other one, or omit both")
    lengths = steps = None
    if offsets is not None:
        lengths, steps = arguments.lengths(period, rows.shape[1]), arguments.indices(offsets, "offsets")
        if steps.shape != cells.shape + (rows.shape[1],):
            raise ValueError(f"offsets must have the shape {cells.shape + (rows.shape[1],)}, not {steps.shape}")
        if steps.size and not -(2**31) <= int(steps.min()) <= int(steps.max()) < 2**31:
            raise ValueError("offsets must fit into int32")
        steps = steps.reshape(-1).astype(np.int32)
    found = _septet.verify(
        rows, cells, (w, lengths, steps), arguments.threads(threads), arguments.progress(progress)
    )
    return Verdict(*found)
