"""Requests and complaints of users of other packages: one test for each, named after its row in the table of requests."""

from __future__ import annotations

import inspect
import pickle
import threading
import time
from pathlib import Path
from typing import Any, List

import numpy as np
import pytest
import septet
from conftest import grid
from scipy.sparse import csr_array
from scipy.spatial import Delaunay as Scipy


def clock(call: Any) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def test_complaint_01_construction_is_slow() -> None:
    points = np.random.default_rng(1).random((30_000, 3))
    septet.Delaunay(points[:1000], threads=1)
    ours = min(clock(lambda: septet.Delaunay(points, threads=1).simplices) for _ in range(2))
    assert ours < clock(lambda: Scipy(points).simplices)


def test_complaint_02_queries_use_cores_and_agree() -> None:
    rng = np.random.default_rng(1)
    tri = septet.Delaunay(rng.random((5000, 2)))
    x, values = rng.random((100_000, 2)), rng.random(5000)
    one = tri.interpolate(values, x, threads=1)
    for threads in (2, 16):
        assert np.array_equal(one, tri.interpolate(values, x, threads=threads), equal_nan=True)
    for name in ["find_simplex", "barycentric", "nearest_vertex", "weights", "interpolate"]:
        assert "threads" in inspect.signature(getattr(tri, name)).parameters


@pytest.mark.parametrize("method", ["linear", "sibson", "laplace"])
def test_complaint_03_weights_are_reused(cloud: np.ndarray, rng: np.random.Generator, method: Any) -> None:
    tri = septet.Delaunay(cloud)
    x = rng.random((500, tri.ndim)) * 0.6 + 0.2
    indptr, indices, data = tri.weights(x, method)
    matrix = csr_array((data, indices, indptr), shape=(500, len(cloud)))
    for _ in range(3):
        values = rng.random((len(cloud), 2))
        assert np.abs(matrix @ values - tri.interpolate(values, x, method)).max() < 1e-13


def test_complaint_04_points_of_the_hull_are_inside(rng: np.random.Generator) -> None:
    for ndim in (2, 3):
        for points in [rng.random((500, ndim)) * 1e6 + 1e6, grid(6, ndim) * 0.1]:
            tri = septet.Delaunay(points)
            assert (tri.find_simplex(points) >= 0).all()
            hull = np.unique(tri.convex_hull)
            assert (tri.find_simplex(points[hull]) >= 0).all()


def test_complaint_05_simplices_cannot_be_deleted_behind_queries(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    with pytest.raises(ValueError):
        tri.simplices[0] = 0
    with pytest.raises(AttributeError):
        tri.simplices = tri.simplices[1:]  # type: ignore[misc]
    small = tri.circumradii < np.median(tri.circumradii)
    at = tri.find_simplex(cloud)
    # The documented mask: a query in a simplex that is left out counts as outside.
    assert np.where(small[at], at, -1).shape == at.shape


@pytest.mark.parametrize("offset", [0.0, 1e6, 1e12])
def test_complaint_06_grids_have_no_flat_cells(ndim: int, offset: float) -> None:
    points = grid(7, ndim) + offset
    tri = septet.Delaunay(points)
    assert (tri.volumes > 0).all() and tri.volumes.sum() == 6**ndim
    assert len(np.unique(tri.simplices)) == len(points) and septet.verify(points, tri.simplices).ok


def test_complaint_07_flat_and_small_input_is_no_error() -> None:
    assert septet.Delaunay(np.zeros((0, 3))).dimension == -1
    assert septet.Delaunay([[1, 2, 3]]).dimension == 0
    assert septet.Delaunay([[0, 0], [1, 1], [2, 2]]).simplices.shape == (0, 3)
    assert "joggle" not in str(inspect.signature(septet.Delaunay)).lower()


def test_complaint_08_duplicates_do_not_hang(ndim: int) -> None:
    points = np.repeat(np.random.default_rng(1).random((100, ndim)), 300, axis=0)
    tri = septet.Delaunay(points)
    assert len(tri.duplicates) == 29_900 and (tri.duplicates[:, 1] == tri.duplicates[:, 0] // 300 * 300).all()
    assert septet.Delaunay(np.ones((10_000, ndim))).dimension == 0


def test_complaint_09_volumes_of_voronoi_cells(ndim: int) -> None:
    cells = septet.Voronoi(grid(5, ndim))
    inner = (grid(5, ndim) > 0).all(axis=1) & (grid(5, ndim) < 4).all(axis=1)
    assert np.abs(cells.volumes[inner] - 1).max() < 1e-14 and np.isinf(cells.volumes[~inner]).all()


def test_complaint_10_cells_are_clipped_to_a_box(cloud: np.ndarray) -> None:
    d = cloud.shape[1]
    cells = septet.Voronoi(cloud, box=(np.full(d, -1.0), np.full(d, 2.0)))
    assert np.isfinite(cells.volumes).all() and abs(cells.volumes.sum() / 3**d - 1) < 1e-12


def test_complaint_11_edges_and_neighbours_of_cells(cloud: np.ndarray) -> None:
    cells = septet.Voronoi(cloud)
    assert (cells.ridge_points == cells.delaunay.edges).all()
    assert len(cells.ridge_areas) == len(cells.ridge_vertices) == len(cells.ridge_points)
    assert isinstance(cells.ridge_vertices, septet.Ragged) and cells.ridge_vertices.values.dtype == np.int32


def test_complaint_12_natural_neighbours_in_both_dimensions(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(cloud)
    # Also on edges, on the hull and at vertices.
    edges = cloud[tri.edges[:200]].mean(axis=1)
    hull = cloud[tri.convex_hull[:, :2]].mean(axis=1)
    for x in [cloud, edges, hull, rng.random((300, tri.ndim)) * 0.5 + 0.25]:
        inside = tri.find_simplex(x) >= 0
        for method in ("sibson", "laplace"):
            found = tri.interpolate(cloud, x, method)
            assert np.abs(found - x)[inside].max() < 1e-9
            assert np.isnan(found[~inside]).all()


def test_complaint_13_alpha_shapes_scale() -> None:
    tri = septet.Delaunay(np.random.default_rng(1).random((20_000, 3)))
    start = time.perf_counter()
    shape = tri.alpha_shape(0.05)
    assert time.perf_counter() - start < 20 and 0.7 < shape.volume < 1
    assert len(tri.alpha_filtration().cells) == len(tri.simplices)


def test_complaint_14_boundary_of_an_alpha_shape_is_a_surface(rng: np.random.Generator) -> None:
    points = rng.normal(size=(3000, 3))
    points *= (0.5 + rng.random((3000, 1)) / 2) / np.linalg.norm(points, axis=1, keepdims=True)
    boundary = septet.Delaunay(points).alpha_shape(0.2).boundary
    directed = [(a, b) for row in boundary.tolist() for a, b in zip(row, row[1:] + row[:1])]
    # Each directed edge has its opposite as often: the surface is closed and oriented.
    assert sorted(directed) == sorted((b, a) for a, b in directed) and len(boundary) > 1000


def test_complaint_15_large_input_ends_with_an_error_at_most() -> None:
    points = np.random.default_rng(1).random((400_000, 3))
    assert len(septet.Delaunay(points).simplices) > 2_000_000
    with pytest.raises(septet.MemoryLimitError):
        septet.Delaunay(points, max_memory=10_000_000)


def test_complaint_16_progress_is_reported() -> None:
    seen: List[Any] = []
    septet.Delaunay(np.random.default_rng(1).random((100_000, 3)), progress=lambda *stage: seen.append(stage))
    assert seen and all(len(stage) == 3 for stage in seen)


def test_complaint_17_calls_at_the_same_time() -> None:
    points = np.random.default_rng(1).random((3000, 3))
    expected, found = septet.Delaunay(points).simplices, []  # type: Any, List[Any]
    threads = [threading.Thread(target=lambda: found.append(septet.Delaunay(points).simplices)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 8 and all((rows == expected).all() for rows in found)


def test_complaint_18_pickles_answer_queries(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    again = pickle.loads(pickle.dumps(tri))
    x = cloud * 0.5 + 0.2
    assert (again.find_simplex(x) == tri.find_simplex(x)).all()
    assert np.array_equal(again.interpolate(cloud, x), tri.interpolate(cloud, x), equal_nan=True)


def test_complaint_19_meaning_of_results_is_documented() -> None:
    folder = Path(septet.__file__).parent
    page = (folder / "__init__.pyi").read_text()
    for word in ["-1\nmeans none", "int32", "duplicates", "counter-clockwise", "NaN"]:
        assert word in page, word
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    assert tri.find_simplex([0, 0]) == 0 and (tri.neighbors == -1).all()


def test_complaint_20_periodic_boxes(cloud: np.ndarray) -> None:
    for of in (septet.Delaunay, septet.Voronoi, septet.simulate):
        assert {"weights", "period", "origin"} <= set(inspect.signature(of).parameters)
    tri = septet.Delaunay(cloud, period=1)
    assert septet.verify(cloud, tri.simplices, period=1, offsets=tri.offsets).ok
    assert abs(septet.Voronoi(tri).volumes.sum() - 1) < 1e-12
