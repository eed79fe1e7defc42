"""Voronoi diagrams."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import septet
from conftest import grid
from scipy.spatial import ConvexHull
from scipy.spatial import Voronoi as Scipy


def test_diagram_is_that_of_scipy(cloud: np.ndarray) -> None:
    ours, theirs = septet.Voronoi(cloud), Scipy(cloud)
    pairs = [tuple(sorted(pair)) for pair in theirs.ridge_points.tolist()]
    assert ours.ridge_points.tolist() == ours.delaunay.edges.tolist()
    lengths = {pair: (len(row), -1 in row) for pair, row in zip(pairs, theirs.ridge_vertices)}
    for pair, row in zip(ours.ridge_points.tolist(), ours.ridge_vertices.tolist()):
        # scipy lists no ridge in space with one finite vertex.
        expected = lengths.pop(tuple(pair)) if len(row) >= ours.delaunay.ndim else (len(row), True)
        assert (len(row), -1 in row) == expected
    assert not lengths
    assert len(ours.vertices) == len(theirs.vertices) == len(ours.delaunay.simplices)
    for v in range(0, len(cloud), 50):
        region = theirs.regions[theirs.point_region[v]]
        row = ours.regions[int(ours.point_region[v])].tolist()
        assert row == sorted(row) and (len(row), -1 in row) == (len(region), -1 in region)


def test_volumes_of_inner_cells(cloud: np.ndarray) -> None:
    cells = septet.Voronoi(cloud)
    theirs = Scipy(cloud)
    for v in range(0, len(cloud), 20):
        region = theirs.regions[theirs.point_region[v]]
        if -1 in region:
            assert cells.volumes[v] == np.inf and np.isnan(cells.centroids[v]).all()
        else:
            expected = ConvexHull(theirs.vertices[region]).volume
            assert abs(cells.volumes[v] / expected - 1) < 1e-9


@pytest.mark.parametrize("move", [0, 1e-3])
def test_volumes_add_up_to_the_box(ndim: int, rng: np.random.Generator, move: float) -> None:
    for points in [rng.random((2000, ndim)), (grid(8, ndim) + 0.5 + move * rng.random((8**ndim, ndim))) / 9]:
        box = (np.zeros(ndim), np.ones(ndim))
        cells = septet.Voronoi(points, box=box)
        assert (cells.volumes > 0).all() and abs(cells.volumes.sum() - 1) < 1e-12
        middle = (cells.volumes[:, None] * cells.centroids).sum(axis=0)
        assert np.abs(middle - 0.5).max() < 1e-12
        inside = (cells.centroids > 0) & (cells.centroids < 1)
        assert inside.all()


def test_cells_of_a_grid_are_cubes(ndim: int) -> None:
    points = grid(6, ndim)
    cells = septet.Voronoi(points, box=(np.full(ndim, -0.5), np.full(ndim, 5.5)))
    assert np.abs(cells.volumes - 1).max() < 1e-14 and np.abs(cells.centroids - points).max() < 1e-14
    inner = (cells.ridge_points >= 0).all(axis=1)
    areas = cells.ridge_areas[inner]
    assert np.abs(cells.ridge_areas[~inner] - 1).max() < 1e-12 and (~inner).sum() == 2 * ndim * 6 ** (ndim - 1)
    assert set(np.round(areas, 12).tolist()) <= {0.0, 1.0} and (areas > 0.5).sum() == ndim * 5 * 6 ** (ndim - 1)


def test_duplicates_have_no_cell() -> None:
    cells = septet.Voronoi([[1, 1], [3, 1], [1, 3], [3, 3], [1, 1]], box=([0, 0], [4, 4]))
    assert cells.volumes.tolist() == [4, 4, 4, 4, 0] and cells.point_region.tolist() == [0, 1, 2, 3, 0]
    assert cells.regions[4].tolist() == []


def test_boxes_are_checked(cloud: np.ndarray) -> None:
    d = cloud.shape[1]
    with pytest.raises(septet.PointError) as error:
        septet.Voronoi(cloud, box=(np.zeros(d), np.full(d, 0.9)))
    outside = int(np.flatnonzero((cloud > 0.9).any(axis=1))[0])
    assert error.value.index == outside
    boxes: "list[Any]" = [([1] * d, [0] * d), ([0] * d, [np.inf] * d), ([0] * d,), 3, ([0], [1]), ([np.nan] * d, [1] * d)]
    for box in boxes:
        with pytest.raises((ValueError, TypeError)):
            septet.Voronoi(cloud, box=box)


def test_diagram_of_a_triangulation(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    cells = septet.Voronoi(tri)
    assert cells.delaunay is tri and cells.points is tri.points
    assert (cells.vertices == tri.circumcenters).all()


def test_diagram_in_a_box(cloud: np.ndarray) -> None:
    n, d = cloud.shape
    cells = septet.Voronoi(cloud, box=(np.zeros(d), np.ones(d)))
    pairs, areas = cells.ridge_points, cells.ridge_areas
    assert pairs.tolist() == sorted(pairs.tolist()) and (pairs[:, 1] >= 0).all() and pairs.min() == -2 * d
    for k in range(2 * d):
        assert abs(areas[pairs[:, 0] == -1 - k].sum() - 1) < 1e-12
    assert np.isfinite(areas).all() and ((cells.vertices > -1e-12) & (cells.vertices < 1 + 1e-12)).all()
    for (a, b), row in zip(pairs.tolist(), cells.ridge_vertices):
        x = cells.vertices[row]
        if a < 0:
            assert (x[:, (-1 - a) // 2] == (-1 - a) % 2).all()
        else:
            assert np.abs(((x - cloud[a]) ** 2 - (x - cloud[b]) ** 2).sum(axis=1)).max() < 1e-9
    for v in range(0, n, 40):
        assert abs(ConvexHull(cells.vertices[cells.regions[v]]).volume / cells.volumes[v] - 1) < 1e-9
