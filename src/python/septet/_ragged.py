"""Rows of different lengths, and sparse rows of weights."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from typing import Any, List, NamedTuple, Union, overload

import numpy as np
import numpy.typing as npt

from ._arguments import frozen
from ._types import Ids


class Ragged(Sequence[Any]):
    """Rows of different lengths in two arrays: row i is ``values[offsets[i]:offsets[i + 1]]``.

    Examples
    --------
    >>> import septet
    >>> rows = septet.Voronoi([[0, 0], [1, 0], [0, 1]]).regions
    >>> len(rows)
    3
    >>> rows[0].tolist()
    [-1, 0]
    """

    __module__ = "septet"
    __slots__ = ("_offsets", "_values")
    _offsets: npt.NDArray[np.int64]
    _values: Any

    def __init__(self, offsets: npt.NDArray[np.int64], values: Ids) -> None:
        object.__setattr__(self, "_offsets", frozen(offsets))
        object.__setattr__(self, "_values", frozen(values))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a Ragged cannot be changed: {name}")

    @property
    def offsets(self) -> npt.NDArray[np.int64]:
        """(rows + 1,). The position of the first entry of each row, and the number of all entries."""
        return self._offsets

    @property
    def values(self) -> Any:
        """The entries of all rows."""
        return self._values

    @overload
    def __getitem__(self, i: int) -> Any: ...
    @overload
    def __getitem__(self, i: slice) -> Ragged: ...
    def __getitem__(self, i: Union[int, slice]) -> Any:
        if isinstance(i, slice):
            starts, ends = self._offsets[:-1][i], self._offsets[1:][i]
            lengths = ends - starts
            offsets = np.zeros(len(lengths) + 1, dtype=np.int64)
            np.cumsum(lengths, out=offsets[1:])
            places = np.arange(offsets[-1]) + np.repeat(starts - offsets[:-1], lengths)
            return Ragged(offsets, self._values[places])
        at = operator.index(i)
        at += len(self) if at < 0 else 0
        if not 0 <= at < len(self):
            raise IndexError(f"row {i} of {len(self)} rows")
        return self._values[self._offsets[at] : self._offsets[at + 1]]

    def __len__(self) -> int:
        return len(self._offsets) - 1

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(len(self)))

    def tolist(self) -> List[List[int]]:
        """Returns the rows as lists."""
        flat, ends = self._values.tolist(), self._offsets.tolist()
        return [flat[a:b] for a, b in zip(ends, ends[1:])]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Ragged):
            return NotImplemented
        return np.array_equal(self._offsets, other._offsets) and np.array_equal(self._values, other._values)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<septet.Ragged: {len(self)} rows, {len(self._values)} entries>"

    def __reduce__(self) -> Any:
        return Ragged, (self._offsets, self._values)


class Weights(NamedTuple):
    """Rows of a sparse matrix, one for each query.

    ``scipy.sparse.csr_array((data, indices, indptr), shape=(queries, n)) @ values`` interpolates.

    A query outside of the hull has an empty row. Each other row adds up to 1 to rounding and has no negative weight.
    """

    indptr: npt.NDArray[np.int64]
    indices: Ids
    data: npt.NDArray[np.float64]


Weights.__module__ = "septet"
