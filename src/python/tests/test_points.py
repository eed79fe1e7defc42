"""The conventions of points: types, layouts, invalid, flat, duplicate and empty points."""

from __future__ import annotations

import numpy as np
import pytest
import septet


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", ">f8", ">f4", "i1", "u1", "i4", "u4", "i8", "u8", "?"])
def test_types_are_converted_exactly(dtype: str) -> None:
    points = np.array([[0, 0], [1, 0], [0, 1]]).astype(dtype)
    tri = septet.Delaunay(points)
    assert tri.points.dtype == np.float64 and tri.points.dtype.isnative
    assert (tri.points == points.astype("f8")).all() and tri.simplices.tolist() == [[0, 1, 2]]


def test_float32_is_exact() -> None:
    points = np.array([[0.1, 0.2], [0.7, 0.3], [0.4, 0.9]], dtype=np.float32)
    assert (septet.Delaunay(points).points == points.astype(np.float64)).all()


@pytest.mark.parametrize("value", [2**53 + 1, -(2**53) - 1, 2**63 - 1])
def test_large_integers_are_refused(value: int) -> None:
    with pytest.raises((TypeError, ValueError)):
        septet.Delaunay(np.array([[0, 0], [value, 0], [0, 1]], dtype=np.int64))
    assert septet.Delaunay(np.array([[0, 0], [2**60, 0], [0, 1]], dtype=np.int64)).dimension == 2


def test_large_unsigned_integers_are_refused() -> None:
    with pytest.raises((TypeError, ValueError)):
        septet.Delaunay(np.array([[0, 0], [2**64 - 1, 0], [0, 1]], dtype=np.uint64))
    with pytest.raises((TypeError, ValueError)):
        septet.Delaunay([[0, 0], [2**70 + 1, 0], [0, 1]])


@pytest.mark.parametrize("dtype", ["c8", "c16", "O", "U3", "S3", "M8[s]", "m8[s]"])
def test_other_types_are_refused(dtype: str) -> None:
    points = np.zeros((3, 2), dtype=dtype)
    with pytest.raises((TypeError, ValueError)):
        septet.Delaunay(points)


def test_longdouble_is_refused() -> None:
    if np.dtype(np.longdouble).itemsize == 8:
        pytest.skip("longdouble is float64 here")
    with pytest.raises((TypeError, ValueError)):
        septet.Delaunay(np.zeros((3, 2), dtype=np.longdouble))


def test_masked_entries_are_refused() -> None:
    masked = np.ma.masked_invalid([[0, 0], [1, np.nan], [0, 1]])
    with pytest.raises(ValueError, match="masked"):
        septet.Delaunay(masked)


@pytest.mark.parametrize("shape", [(3,), (), (3, 1), (3, 4), (3, 5), (3, 6), (3, 7), (2, 3, 2)])
def test_shapes_are_refused(shape: "tuple[int, ...]") -> None:
    with pytest.raises(ValueError) as error:
        septet.Delaunay(np.zeros(shape))
    if len(shape) == 2 and shape[1] > 3:
        assert "septet triangulate" in str(error.value)


def test_layouts_do_not_matter(cloud: np.ndarray, tmp_path: object) -> None:
    expected = septet.Delaunay(cloud).simplices
    n, d = cloud.shape
    strided = np.zeros((2 * n, 2 * d))
    strided[::2, ::2] = cloud
    reversed_ = np.ascontiguousarray(cloud[::-1, ::-1])[::-1, ::-1]
    locked = cloud.copy()
    locked.flags.writeable = False
    path = f"{tmp_path}/points.npy"
    np.save(path, cloud)
    mapped = np.load(path, mmap_mode="r")
    for points in [np.asfortranarray(cloud), strided[::2, ::2], reversed_, locked, mapped, cloud.tolist()]:
        assert (septet.Delaunay(points).simplices == expected).all()


def test_points_are_copied(cloud: np.ndarray) -> None:
    kept = cloud.copy()
    tri = septet.Delaunay(cloud)
    cloud[:] = 0
    assert (tri.points == kept).all() and not np.shares_memory(tri.points, cloud)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite(cloud: np.ndarray, value: float) -> None:
    cloud[[17, 400], 1] = value
    with pytest.raises(septet.PointError) as error:
        septet.Delaunay(cloud)
    assert error.value.index == 17 and "17" in str(error.value) and "on_invalid" in str(error.value)
    tri = septet.Delaunay(cloud, on_invalid="skip")
    assert tri.skipped.tolist() == [17, 400] and tri.skipped.dtype == np.int32
    assert not np.isin(tri.simplices, [17, 400]).any()
    assert tri.vertex_to_simplex[17] == -1 and len(tri.points) == 1000
    assert np.isin(np.arange(1000), tri.simplices).sum() == 998


def test_digits_that_spread_too_far() -> None:
    with pytest.raises(septet.PointError):
        septet.Delaunay([[0, 0], [1e-300, 0], [0, 1e300], [1, 1]])


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_few_points(n: int, ndim: int) -> None:
    points = np.eye(4, ndim)[:n]
    tri = septet.Delaunay(points)
    m = 1 if n == ndim + 1 else 0
    assert tri.dimension == n - 1 and tri.ndim == ndim
    assert tri.simplices.shape == (m, ndim + 1) and tri.neighbors.shape == (m, ndim + 1)
    assert tri.convex_hull.shape == (3 if m else 0, ndim) and tri.volumes.shape == (m,)
    assert tri.circumcenters.shape == (m, ndim) and tri.transform.shape == (m, ndim + 1, ndim)
    assert tri.vertex_to_simplex.shape == (n,) and tri.edges.shape == (3 if m else 0, 2)
    assert tri.find_simplex(np.zeros((5, ndim)) + 2).tolist() == [-1] * 5
    assert tri.find_simplex(np.zeros((0, ndim))).shape == (0,)
    nearest = tri.nearest_vertex(np.zeros((2, ndim)))
    assert nearest.tolist() == ([-1, -1] if n == 0 else nearest.tolist()) and (nearest < max(n, 1)).all()
    assert np.isnan(tri.interpolate(np.ones(n), np.zeros((1, ndim)) + 2)).all()
    assert tri.alpha_filtration().cells.shape == (m,)


def test_flat_points_are_no_error(rng: np.random.Generator) -> None:
    line = np.outer(np.arange(50), [1, 2, 3])
    plane = np.column_stack([rng.integers(0, 9, (50, 2)), np.zeros(50)])
    assert septet.Delaunay(line).dimension == 1 and septet.Delaunay(line[:, :2]).dimension == 1
    assert septet.Delaunay(plane).dimension == 2 and septet.Delaunay(np.ones((9, 3))).dimension == 0
    assert septet.Delaunay(plane).simplices.shape == (0, 4)
    assert septet.Delaunay(line).find_simplex(line).tolist() == [-1] * 50


def test_duplicates_have_vertices(cloud: np.ndarray) -> None:
    points = np.concatenate([cloud, cloud[[5, 3, 5]]])
    tri = septet.Delaunay(points)
    assert tri.duplicates.tolist() == [[1000, 5], [1001, 3], [1002, 5]]
    assert tri.vertex_to_simplex[1000] == tri.vertex_to_simplex[5] >= 0
    assert tri.coplanar[:, [0, 2]].tolist() == tri.duplicates.tolist()
    assert (tri.simplices[tri.coplanar[:, 1]] == tri.coplanar[:, 2:]).any(axis=1).all()
    assert (tri.find_simplex(points) >= 0).all()
    zeros = septet.Delaunay([[0.0, 0], [-0.0, 0], [1, 0], [0, 1]])
    assert zeros.duplicates.tolist() == [[1, 0]]


def test_pandas_like_objects_are_points() -> None:
    class Table:
        def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
            return np.array([[0.0, 0], [1, 0], [0, 1]])

    assert septet.Delaunay(Table()).simplices.tolist() == [[0, 1, 2]]

