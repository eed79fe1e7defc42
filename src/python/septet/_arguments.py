"""Conversion of arguments. Nothing is rounded silently."""

from __future__ import annotations

import operator
from typing import Any, List, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._errors import InputError, OptionError

_EXACT = 2**53


def _integers_fit(a: npt.NDArray[Any]) -> bool:
    """Whether float64 holds all integers of an array exactly."""
    large = a > _EXACT
    if a.dtype.kind == "i":
        large |= a < -_EXACT
    return all(int(float(v)) == v for v in a[large].ravel().tolist())


def floats(a: Any, name: str) -> npt.NDArray[np.float64]:
    """Copies real numbers as float64 in C order, without rounding: other threads may change the argument."""
    if np.ma.isMaskedArray(a) and np.ma.getmaskarray(a).any():
        raise ValueError(f"{name} has masked entries; drop these rows, or fill them")
    array = np.asarray(a)
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind not in "fiub" or size > 8:
        raise TypeError(f"{name} must be real numbers that float64 holds exactly, not {array.dtype}")
    if kind in "iu" and size == 8 and not _integers_fit(array):
        raise ValueError(f"{name} has integers that float64 does not hold exactly; round or shift them first")
    return np.array(array, dtype=np.float64, order="C", subok=False)


def points(a: Any, name: str = "points") -> npt.NDArray[np.float64]:
    """Converts points of shape (n, 2) or (n, 3)."""
    array = floats(a, name)
    if array.ndim != 2:
        raise ValueError(f"{name} must have the shape (n, 2) or (n, 3), not {array.shape}")
    columns = array.shape[1]
    if columns in (4, 5, 6):
        raise ValueError(
            f"{name} have {columns} columns, and the package takes 2 or 3; "
            "the command `septet triangulate` takes 2 to 6, in a build with the feature `dimensions`"
        )
    if columns not in (2, 3):
        raise ValueError(f"{name} must have 2 or 3 columns, not {columns}; see the command `septet triangulate`")
    return array


def queries(x: Any, ndim: int) -> npt.NDArray[np.float64]:
    """Converts queries of shape (..., ndim)."""
    array = floats(x, "x")
    if array.ndim == 0 or array.shape[-1] != ndim:
        raise ValueError(f"x must have the shape (..., {ndim}), not {array.shape}")
    return array


def rows(array: npt.NDArray[np.float64], columns: int) -> npt.NDArray[np.float64]:
    """Returns an array as rows, also if it is empty."""
    return array.reshape(int(np.prod(array.shape[:-1], dtype=np.int64)), columns)


def values(v: Any, n: int) -> npt.NDArray[np.float64]:
    """Converts values of shape (n, ...)."""
    array = floats(v, "values")
    if array.ndim == 0 or array.shape[0] != n:
        raise ValueError(f"values must have the shape ({n}, ...), one entry for each point, not {array.shape}")
    return array


def weights(w: Any, n: int) -> npt.NDArray[np.float64]:
    """Converts a weight for each point."""
    array = floats(w, "weights")
    if array.shape != (n,):
        raise ValueError(f"weights must have the shape ({n},), one for each point, not {array.shape}")
    return array


def lengths(period: Any, ndim: int) -> List[Optional[float]]:
    """Converts the lengths of a periodic box: None along an axis that is not periodic."""
    if period is None or isinstance(period, (str, bytes)) or np.ndim(period) == 0:
        given = [period] * ndim
    else:
        given = list(period)
    if len(given) != ndim:
        raise OptionError(f"period must have {ndim} lengths, one for each axis, not {len(given)}")
    made: List[Optional[float]] = []
    for length in given:
        value = None if length is None else floats(length, "period")
        if value is not None and (value.ndim > 0 or not value > 0):
            raise OptionError(f"period must have positive lengths, or None along an axis that is not periodic, not {length!r}")
        made.append(None if value is None or np.isinf(value) else float(value))
    if all(length is None for length in made):
        raise OptionError("period must have a length along one axis at least; omit period if no axis is periodic")
    return made


def sites(
    rows: npt.NDArray[np.float64], w: Any, period: Any, origin: Any, wrap: Any
) -> Tuple[Any, Optional[Tuple[List[Optional[float]], List[float], bool]]]:
    """Converts weights, and a periodic box: its lengths, its lower corner, and whether points outside are admitted."""
    n, ndim = rows.shape
    w = None if w is None else weights(w, n)
    if not isinstance(wrap, (bool, np.bool_)):
        raise OptionError(f"wrap must be True or False, not {wrap!r}")
    if period is None:
        if origin is not None or wrap:
            raise OptionError("origin and wrap need a periodic box; add period, or omit them")
        return w, None
    corner = np.zeros(0) if origin is None else floats(origin, "origin")
    if origin is not None and (corner.shape != (ndim,) or not np.isfinite(corner).all()):
        raise OptionError(f"origin must have {ndim} finite numbers, one for each axis, not {origin!r}")
    return w, (lengths(period, ndim), corner.tolist(), bool(wrap))


def stored(sites: Any) -> Any:
    """Checks the weights and the periodic box of a pickle."""
    try:
        w, box = sites
        w = None if w is None else floats(w, "weights").reshape(-1)
        if box is not None:
            of, corner, wrap = box
            box = [None if x is None else float(x) for x in of], [float(x) for x in corner], bool(wrap)
    except (TypeError, ValueError, OverflowError):
        raise InputError("the pickle holds no weights or no periodic box; make it again") from None
    return w, box


def indices(a: Any, name: str) -> npt.NDArray[np.int64]:
    """Copies indices of any integer type."""
    array = np.asarray(a)
    if array.size == 0 and array.dtype.kind == "f":
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} must be integers, not {array.dtype}")
    if array.dtype.kind == "u" and array.size and int(array.max()) >= 2**63:
        raise ValueError(f"{name} has an index of {int(array.max())}, which is out of range")
    return np.array(array, dtype=np.int64, order="C", subok=False)


def whole(value: Any, name: str, least: int, most: int) -> int:
    """Checks a whole number."""
    try:
        number = operator.index(value)
    except TypeError:
        raise OptionError(f"{name} must be a whole number, not {value!r}") from None
    if isinstance(value, (bool, np.bool_)) or not least <= number <= most:
        raise OptionError(f"{name} must be between {least} and {most}, not {value!r}")
    return number


def threads(value: Optional[int]) -> Optional[int]:
    """Checks a number of threads."""
    if value is None:
        return None
    try:
        return whole(value, "threads", 1, 1 << 16)
    except OptionError as error:
        raise OptionError(f"{error}; use threads=1, or None for all cores") from None


def memory(value: Optional[int]) -> Optional[int]:
    """Checks a limit of memory in bytes."""
    return None if value is None else whole(value, "max_memory", 0, 2**63 - 1)


def number(value: Any, name: str) -> float:
    """Checks a real number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise OptionError(f"{name} must be a number, not {value!r}") from None


def word(value: Any, name: str, words: "tuple[str, ...]") -> str:
    """Checks a word."""
    if not isinstance(value, str) or value not in words:
        known = ", ".join(repr(w) for w in words)
        raise OptionError(f"{name} must be one of {known}, not {value!r}")
    return value


def progress(value: Any) -> Any:
    """Checks a callback."""
    if value is not None and not callable(value):
        raise OptionError(f"progress must be callable, not {value!r}")
    return value


def frozen(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns a read-only array with the same memory. Its flag cannot be set back, unless it holds objects or nothing."""
    array.flags.writeable = False
    owner = array
    while isinstance(owner.base, np.ndarray):
        owner = owner.base
    if not owner.flags.owndata or array.size == 0 or array.dtype.hasobject:
        # An array of the library is a view of memory that numpy does not own.
        return array
    memory = np.ascontiguousarray(array).reshape(-1).view(np.uint8).data.toreadonly()
    return np.frombuffer(memory, dtype=array.dtype).reshape(array.shape)
