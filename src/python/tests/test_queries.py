"""Location, nearest vertices and interpolation, exactly."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, List

import numpy as np
import pytest
import septet
from conftest import grid


def sign(corners: Any) -> int:
    """The exact orientation of points."""
    rows = [[Fraction(float(a)) - Fraction(float(b)) for a, b in zip(p, corners[0])] for p in corners[1:]]
    value = determinant(rows)
    return (value > 0) - (value < 0)


def determinant(m: List[List[Fraction]]) -> Fraction:
    """An exact determinant of 2 or 3 rows."""
    if len(m) == 2:
        return m[0][0] * m[1][1] - m[0][1] * m[1][0]
    return sum(
        (m[0][i] * determinant([[row[j] for j in range(3) if j != i] for row in m[1:]]) * (-1) ** i for i in range(3)),
        Fraction(0),
    )


def first_that_contains(tri: septet.Delaunay, x: Any) -> int:
    """The smallest simplex whose closure contains a query, by brute force."""
    for at, row in enumerate(tri.simplices):
        corners = tri.points[row]
        if all(sign([*corners[:k], x, *corners[k + 1 :]]) >= 0 for k in range(len(row))):
            return at
    return -1


def test_location_on_ties_is_exact(ndim: int, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(grid(4 if ndim == 2 else 3, ndim))
    corners = tri.points[tri.simplices]
    mixed = rng.integers(0, 4, (40, ndim + 1))
    mixed[mixed.sum(axis=1) == 0] = 1
    # Points on faces of all dimensions: whole weights with a power of two as their sum would be exact, halves are.
    halves = (tri.points[tri.edges[:, 0]] + tri.points[tri.edges[:, 1]]) / 2
    quarters = (corners[:40, 0] + corners[:40, 1]) / 4 + corners[:40, 2] / 2
    outside = np.nextafter(tri.points.max(axis=0), np.inf)
    x = np.concatenate([tri.points, halves, quarters, [outside, tri.points.max(axis=0)]])
    assert tri.find_simplex(x).tolist() == [first_that_contains(tri, q) for q in x]


def test_location_near_facets_is_exact(ndim: int, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(rng.random((40, ndim)))
    middles = tri.points[tri.convex_hull].mean(axis=1)
    x = np.concatenate([middles, np.nextafter(middles, 9), np.nextafter(middles, -9)])
    assert tri.find_simplex(x).tolist() == [first_that_contains(tri, q) for q in x]


def test_queries_that_are_not_finite(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    x = np.full((3, tri.ndim), 0.5)
    x[0, 0], x[1, 1] = np.nan, np.inf
    assert tri.find_simplex(x)[:2].tolist() == [-1, -1] and tri.find_simplex(x)[2] >= 0
    assert tri.nearest_vertex(x)[0] == -1
    simplex, coordinates = tri.barycentric(x)
    assert simplex[:2].tolist() == [-1, -1] and np.isnan(coordinates[:2]).all()
    assert np.isnan(tri.interpolate(np.ones(len(cloud)), x)[:2]).all()


def test_queries_far_away_and_close_by(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    d = tri.ndim
    far = np.array([[1e300] * d, [-1e300] * d, [5e-324] * d])
    assert tri.find_simplex(far).tolist() == [-1, -1, -1]
    inside = np.full((1, d), 0.5) + 5e-324
    assert tri.find_simplex(inside)[0] >= 0
    centred = septet.Delaunay(cloud - 0.5)
    assert centred.find_simplex([[5e-324] * d])[0] >= 0


def test_nearest_of_several_is_the_smallest(ndim: int) -> None:
    points = grid(5, ndim)
    tri = septet.Delaunay(points)
    middles = points[(points < 4).all(axis=1)] + 0.5
    squares = ((middles[:, None] - points[None]) ** 2).sum(axis=2)
    assert tri.nearest_vertex(middles).tolist() == squares.argmin(axis=1).tolist()
    assert tri.nearest_vertex(points).tolist() == list(range(len(points)))


def test_nearest_of_flat_points() -> None:
    tri = septet.Delaunay(np.column_stack([np.arange(9.0), np.zeros(9), np.zeros(9)]))
    assert tri.nearest_vertex([[3.2, 5, 5], [3.5, 1, 1], [-9, 0, 0]]).tolist() == [3, 3, 0]


def test_barycentric_coordinates(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(cloud)
    x = rng.random((3000, tri.ndim)) * 1.1 - 0.05
    simplex, c = tri.barycentric(x)
    assert (simplex == tri.find_simplex(x)).all()
    inside = simplex >= 0
    assert np.isnan(c[~inside]).all() and (c[inside] >= 0).all()
    assert np.abs(c[inside].sum(axis=1) - 1).max() < 1e-14
    back = np.einsum("ij,ijk->ik", c[inside], cloud[tri.simplices[simplex[inside]]])
    assert np.abs(back - x[inside]).max() < 1e-10
    _, vertex = tri.barycentric(cloud)
    assert ((vertex == 0) | (vertex == 1)).all() and (vertex.sum(axis=1) == 1).all()
    given, own = tri.barycentric(x[inside], simplex[inside])
    assert (given == simplex[inside]).all() and np.abs(own - c[inside]).max() < 1e-9
    for wrong in [[0], simplex[inside] + 10**6]:
        with pytest.raises(ValueError):
            tri.barycentric(x[inside], wrong)


@pytest.mark.parametrize("method", ["linear", "sibson", "laplace"])
def test_weights_reproduce_linear_functions(cloud: np.ndarray, rng: np.random.Generator, method: Any) -> None:
    tri = septet.Delaunay(cloud)
    n, d = cloud.shape
    x = rng.random((1000, d))
    indptr, indices, data = tri.weights(x, method)
    assert indptr.shape == (1001,) and indptr[-1] == len(indices) == len(data)
    rows = [slice(a, b) for a, b in zip(indptr, indptr[1:])]
    inside = tri.find_simplex(x) >= 0
    assert [b > a for a, b in zip(indptr, indptr[1:])] == inside.tolist()
    assert (data >= 0).all() and max(abs(data[r].sum() - 1) for r, i in zip(rows, inside) if i) < 1e-14
    slope = rng.random(d)
    values = cloud @ slope + 3
    found = tri.interpolate(values, x, method)
    assert np.abs(found[inside] - (x @ slope + 3)[inside]).max() < 1e-9
    by_rows = np.array([data[r] @ values[indices[r]] if i else np.nan for r, i in zip(rows, inside)])
    assert np.nanmax(np.abs(found - by_rows)) < 1e-12
    assert np.abs(tri.interpolate(values, cloud, method) - values).max() < 1e-14


def test_shapes_of_values(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(cloud)
    x = np.full((4, 5, tri.ndim), 0.5)
    for rest in [(), (3,), (2, 3), (0,)]:
        values = rng.random((len(cloud), *rest))
        assert tri.interpolate(values, x).shape == (4, 5, *rest)
        assert tri.gradients(values).shape == (len(tri.simplices), tri.ndim, *rest)
    outside = tri.interpolate(np.ones((len(cloud), 2)), np.full((1, tri.ndim), 9.0), fill_value=-7)
    assert outside.tolist() == [[-7, -7]]
    values = np.ones(len(cloud))
    values[0] = np.nan
    assert np.isfinite(tri.interpolate(values, cloud[5:9])).all()
    for wrong in [np.ones(3), np.ones(len(cloud) + 1), 1.0]:
        with pytest.raises(ValueError):
            tri.interpolate(wrong, x)
    with pytest.raises(septet.OptionError, match="sibson"):
        tri.interpolate(values, x, "cubic")  # type: ignore[arg-type]


def test_values_at_duplicates_are_ignored() -> None:
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1], [1, 0]])
    assert tri.interpolate([0, 1, 2, np.nan], [[1, 0], [0.5, 0.5]]).tolist() == [1, 1.5]


def test_gradients(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    slope = np.arange(1.0, tri.ndim + 1)
    well = tri.volumes > np.median(tri.volumes)
    assert np.abs(tri.gradients(cloud @ slope + 1)[well] - slope).max() < 1e-8


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_results_do_not_depend_on_threads(ndim: int, threads: int) -> None:
    points = np.random.default_rng(3).random((30_000, ndim))
    x = np.random.default_rng(4).random((30_000, ndim))
    one, several = septet.Delaunay(points, threads=1), septet.Delaunay(points, threads=threads, seed=99)
    assert (one.simplices == several.simplices).all() and (one.neighbors == several.neighbors).all()
    assert (one.find_simplex(x, threads=1) == several.find_simplex(x, threads=threads)).all()
    values = points[:, 0] ** 2
    for method in ("linear", "sibson", "laplace"):
        a = one.interpolate(values, x, method, threads=1)
        assert np.array_equal(a, several.interpolate(values, x, method, threads=threads), equal_nan=True)


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True])
def test_numbers_of_threads_are_checked(threads: Any) -> None:
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    for call in [lambda: septet.Delaunay([[0, 0]], threads=threads), lambda: tri.find_simplex([0, 0], threads=threads)]:
        with pytest.raises(septet.OptionError):
            call()


def test_options_are_checked() -> None:
    points = [[0, 0], [1, 0], [0, 1]]
    for options in [{"seed": -1}, {"seed": 2**64}, {"on_invalid": "drop"}, {"max_memory": -1}, {"progress": 3}]:
        with pytest.raises(septet.OptionError):
            septet.Delaunay(points, **options)  # type: ignore[arg-type]


def test_memory_limit() -> None:
    with pytest.raises(septet.MemoryLimitError) as error:
        septet.Delaunay(np.random.default_rng(1).random((100_000, 3)), max_memory=1000)
    assert error.value.limit == 1000 < error.value.forecast and "max_memory" in str(error.value)
    assert isinstance(error.value, MemoryError)
