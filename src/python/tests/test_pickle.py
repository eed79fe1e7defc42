"""Copies and pickles."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
import septet


def test_round_trip(cloud: np.ndarray) -> None:
    points = np.concatenate([cloud, cloud[:3], [[np.nan] * cloud.shape[1]]])
    tri = septet.Delaunay(points, on_invalid="skip")
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(tri, protocol))
        assert np.array_equal(again.points, tri.points, equal_nan=True)
        for name in ["simplices", "neighbors", "duplicates", "skipped", "convex_hull", "vertex_to_simplex", "edges"]:
            a, b = getattr(tri, name), getattr(again, name)
            assert a.dtype == b.dtype and np.array_equal(a, b) and not b.flags.writeable, name
        assert (again.find_simplex(cloud) == tri.find_simplex(cloud)).all()
        assert again.dimension == tri.dimension and again.stats == tri.stats


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.zeros((1, 3)), np.eye(3), [[0, 0], [1, 1], [2, 2]]])
def test_round_trip_of_flat_points(points: Any) -> None:
    tri = septet.Delaunay(points)
    again = pickle.loads(pickle.dumps(tri))
    assert again.dimension == tri.dimension and again.simplices.shape == tri.simplices.shape
    assert (again.nearest_vertex(tri.points) == tri.nearest_vertex(tri.points)).all()


def test_copies_are_the_same_object(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    assert copy.copy(tri) is tri and copy.deepcopy([tri])[0] is tri


def test_other_objects() -> None:
    cells = septet.Voronoi([[1, 1], [3, 1], [1, 3], [3, 3]], box=([0, 0], [4, 4]))
    again = pickle.loads(pickle.dumps(cells))
    assert (again.volumes == cells.volumes).all()
    rows = pickle.loads(pickle.dumps(cells.regions))
    assert rows == cells.regions and not rows.values.flags.writeable
    error = septet.PointError("text")
    error.index = 5
    assert pickle.loads(pickle.dumps(error)).index == 5
    filtration = pickle.loads(pickle.dumps(cells.delaunay.alpha_filtration()))
    assert type(filtration) is septet.AlphaFiltration


def tampered(tri: septet.Delaunay, change: Any) -> Any:
    """Makes the object of a pickle whose simplices are changed."""
    make, (points, simplices, stats) = tri.__reduce__()
    rows = np.array(simplices)
    points = np.array(points)
    changed = change(points, rows)
    return make(points, rows if changed is None else changed, stats)


def exchanged(points: Any, rows: Any) -> None:
    rows[0, 1:3] = rows[0, 2:0:-1]


def missing(points: Any, rows: Any) -> Any:
    return rows[1:]


def twice(points: Any, rows: Any) -> Any:
    return np.concatenate([rows[:1], rows])


def out_of_range(points: Any, rows: Any) -> None:
    rows[3, 1] = 10**6


def negative(points: Any, rows: Any) -> None:
    rows[3, 1] = -1


def unsorted(points: Any, rows: Any) -> Any:
    return rows[::-1]


def moved(points: Any, rows: Any) -> None:
    points[7] += 0.3


def narrow(points: Any, rows: Any) -> Any:
    return rows[:, :-1]


def none(points: Any, rows: Any) -> Any:
    return rows[:0]


@pytest.mark.parametrize(
    "change", [exchanged, missing, twice, out_of_range, negative, unsorted, moved, narrow, none]
)
def test_tampered_pickles_are_refused(cloud: np.ndarray, change: Any) -> None:
    tri = septet.Delaunay(cloud)
    assert (tampered(tri, lambda points, rows: None).simplices == tri.simplices).all()
    with pytest.raises((septet.Error, ValueError, TypeError)):
        tampered(tri, change)


def test_meshes(tmp_path: Any) -> None:
    square = ([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]])
    mesh = septet.mesh(square, size=0.3)
    same = pickle.loads(pickle.dumps(mesh))
    for name in ("points", "cells", "cell_regions", "facets", "facet_markers"):
        ours, theirs = getattr(mesh, name), getattr(same, name)
        assert (ours == theirs).all() and ours.dtype == theirs.dtype, name
    assert same.quality == mesh.quality and copy.deepcopy(mesh) is mesh and copy.copy(mesh) is mesh
    for i, each in enumerate((mesh, same)):
        each.write(tmp_path / f"{i}.vtu")
    assert (tmp_path / "0.vtu").read_bytes() == (tmp_path / "1.vtu").read_bytes()
    rebuild, (ndim, first, quality, arrays) = mesh.__reduce__()
    short = [array[:-1] for array in arrays]
    far = [np.array(array) for array in arrays]
    far[1][3] = 10**6
    nan = [np.array(array) for array in arrays]
    nan[0][3] = np.nan

    def with_array(at: int, array: Any) -> "list[Any]":
        return [array if i == at else each for i, each in enumerate(arrays)]

    odd = [with_array(at, np.append(arrays[at], arrays[at].dtype.type(1))) for at in (7, 13)]
    large = with_array(5, np.full_like(arrays[5], 2**32 - 1))
    without_regions = with_array(2, arrays[2][:0])
    for contents in (*odd, large, without_regions):
        with pytest.raises(septet.InputError, match="the pickle holds no mesh"):
            rebuild(ndim, first, quality, contents)
    wrong: Any
    for wrong in ((3, first, quality, arrays), (7, first, quality, arrays), (ndim, first, "no", arrays), (ndim, first, 3, arrays),
                  (ndim, first, quality, arrays[:-1]), (ndim, first, quality, short), (ndim, first, quality, far),
                  (ndim, first, quality, nan), (ndim, first, quality, [array.astype("f4") for array in arrays])):
        with pytest.raises((septet.InputError, septet.OptionError)):
            rebuild(*wrong)
