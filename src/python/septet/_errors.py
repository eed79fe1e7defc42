"""The errors of the package. Each is also the built-in class that a caller would expect."""

from __future__ import annotations

from typing import List, Optional


class Error(Exception):
    """The base of all errors of the package."""

    __module__ = "septet"


class PointError(Error, ValueError):
    """A point that cannot be used: not finite, or digits that spread over more than 410 positions.

    Attributes
    ----------
    index : int
        The row of the argument, or -1 if the error has no row.
    """

    __module__ = "septet"
    index: int = -1


class OptionError(Error, ValueError):
    """An option, or a combination of options, that is not valid."""

    __module__ = "septet"


class InputError(Error, ValueError):
    """A file that cannot be read as what it should be.

    Attributes
    ----------
    path : str
        The file.
    line : int or None
        The line of a text file, from 1.
    """

    __module__ = "septet"
    path: str = ""
    line: Optional[int] = None


class MemoryLimitError(Error, MemoryError):
    """The forecast is above ``max_memory``. No memory was taken.

    Attributes
    ----------
    forecast, limit : int
        Bytes.
    """

    __module__ = "septet"
    forecast: int = 0
    limit: int = 0


class DomainError(Error, ValueError):
    """A domain that has no mesh.

    Attributes
    ----------
    defects : list of str
        The defects of the domain, or the features that cannot be recovered.
    """

    __module__ = "septet"
    defects: List[str] = []


class RunError(Error, RuntimeError):
    """A worker failed, or the certificate was refused. Please report it with the points."""

    __module__ = "septet"
