"""Point sets that tests share."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest


@pytest.fixture(params=[2, 3])
def ndim(request: Any) -> int:
    """Each dimension."""
    value: int = request.param
    return value


@pytest.fixture
def rng() -> np.random.Generator:
    """A stream of numbers that is the same in each run."""
    return np.random.default_rng(7)


@pytest.fixture
def cloud(rng: np.random.Generator, ndim: int) -> Any:
    """1,000 points in a box."""
    return rng.random((1000, ndim))


def rows_of(simplices: Any) -> "set[tuple[int, ...]]":
    """Simplices as a set of sorted rows."""
    return {tuple(row) for row in np.sort(np.asarray(simplices), axis=1).tolist()}


def grid(side: int, ndim: int) -> Any:
    """A grid of whole numbers, in which all spheres have ties."""
    axes = np.meshgrid(*[np.arange(float(side))] * ndim, indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)
