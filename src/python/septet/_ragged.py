"""Rows of different lengths, and sparse rows of weights."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from typing import Any, List, NamedTuple, Union, overload

import numpy as np
import numpy.typing as npt

from ._arguments import frozen, indices
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

    def __init__(self, offsets: npt.ArrayLike, values: npt.ArrayLike) -> None:
        ends, entries = indices(offsets, "offsets"), np.array(values)
        if entries.size == 0 and entries.dtype.kind == "f":
            entries = entries.astype(np.int64)
        if ends.ndim != 1 or len(ends) == 0 or ends[0] != 0 or (np.diff(ends) < 0).any():
            raise ValueError("offsets must start with 0 and not decrease, with one entry more than there are rows")
        if entries.ndim != 1 or ends[-1] != len(entries):
            raise ValueError(f"values must have one dimension and {ends[-1]} entries, as offsets say, not {entries.shape}")
        if entries.dtype not in (np.int32, np.int64):
            entries = indices(entries, "values")
        self._set(ends, entries)

    @classmethod
    def _of(cls, offsets: npt.NDArray[np.int64], values: Any) -> Ragged:
        """Takes arrays of the library without a copy."""
        made = cls.__new__(cls)
        made._set(offsets, values)
        return made

    def _set(self, offsets: npt.NDArray[np.int64], values: Any) -> None:
        if hasattr(self, "_offsets"):
            raise AttributeError("a Ragged cannot be changed: make a new one")
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
            return Ragged._of(offsets, self._values[places])
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
