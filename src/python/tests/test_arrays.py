"""The conventions of arrays: types, layout, ownership, immutability."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest
import septet

INDICES = ["simplices", "neighbors", "convex_hull", "duplicates", "coplanar", "skipped", "vertex_to_simplex", "edges"]
REALS = ["points", "volumes", "circumcenters", "circumradii", "transform"]


def arrays_of(tri: septet.Delaunay) -> "dict[str, Any]":
    """All arrays of a triangulation, and of its calls."""
    x = tri.points[:5] * 0.5
    found = {name: getattr(tri, name) for name in INDICES + REALS}
    found["indptr"], found["neighbours"] = tri.vertex_neighbor_vertices
    found["located"], found["nearest"] = tri.find_simplex(x), tri.nearest_vertex(x)
    found["barycentric"], found["coordinates"] = tri.barycentric(x)
    found["weights.indptr"], found["weights.indices"], found["weights.data"] = tri.weights(x)
    found["interpolated"] = tri.interpolate(tri.points, x)
    found["gradients"] = tri.gradients(tri.points[:, 0])
    filtration, shape = tri.alpha_filtration(), tri.alpha_shape(0.2)
    found.update({f"filtration.{name}": array for name, array in filtration._asdict().items()})
    found.update({f"shape.{name}": array for name, array in shape._asdict().items() if name != "volume"})
    cells = septet.Voronoi(tri)
    for name in ["vertices", "ridge_points", "ridge_areas", "point_region", "volumes", "centroids"]:
        found[f"voronoi.{name}"] = getattr(cells, name)
    found["regions.offsets"], found["regions.values"] = cells.regions.offsets, cells.regions.values
    return found


def test_types_and_layout(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    for name, array in arrays_of(tri).items():
        assert type(array) is np.ndarray and array.flags.c_contiguous and array.flags.aligned, name
        assert array.dtype.isnative, name
    for name in INDICES:
        assert getattr(tri, name).dtype == np.int32, name
    for name in REALS:
        assert getattr(tri, name).dtype == np.float64, name
    assert tri.vertex_neighbor_vertices[0].dtype == np.int64
    assert tri.weights(cloud[:3]).indptr.dtype == np.int64
    assert tri.find_simplex(cloud).dtype == np.int32


def test_arrays_are_read_only(cloud: np.ndarray) -> None:
    for name, array in arrays_of(septet.Delaunay(cloud)).items():
        assert not array.flags.writeable, name
        with pytest.raises(ValueError):
            array[...] = 0


def test_arrays_of_the_library_stay_read_only(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    for name in INDICES[:4] + REALS:
        with pytest.raises(ValueError):
            getattr(tri, name).flags.writeable = True


def test_arrays_are_made_once(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    for name in INDICES + REALS:
        assert getattr(tri, name) is getattr(tri, name), name


def test_arrays_stay_valid_without_their_object(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    kept = arrays_of(tri)
    copies = {name: array.copy() for name, array in kept.items()}
    del tri
    gc.collect()
    waste = [septet.Delaunay(cloud[:500]).simplices for _ in range(20)]
    assert len(waste) == 20
    for name, array in kept.items():
        assert np.array_equal(array, copies[name], equal_nan=array.dtype.kind == "f"), name


def test_arrays_share_no_memory_with_arguments(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    for name, array in arrays_of(tri).items():
        assert not np.shares_memory(array, cloud), name


@pytest.mark.parametrize("name", INDICES + REALS + ["dimension", "ndim", "stats", "other"])
def test_attributes_cannot_be_assigned(name: str) -> None:
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    with pytest.raises(AttributeError):
        setattr(tri, name, 0)
    with pytest.raises(AttributeError):
        delattr(tri, name)


def test_order_of_simplices(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    rows = tri.simplices
    assert (rows[:, 0] == rows.min(axis=1)).all()
    assert rows.tolist() == sorted(rows.tolist())
    corners = tri.points[rows]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    assert tri.edges.tolist() == sorted(tri.edges.tolist()) and (tri.edges[:, 0] < tri.edges[:, 1]).all()
    assert tri.convex_hull.tolist() == sorted(tri.convex_hull.tolist())


def test_ragged_rows(cloud: np.ndarray) -> None:
    rows = septet.Voronoi(cloud).regions
    lists = rows.tolist()
    assert len(rows) == len(lists) == len(cloud)
    assert [row.tolist() for row in rows] == lists
    assert rows[-1].tolist() == lists[-1] and rows[3:40:7].tolist() == lists[3:40:7]
    assert rows[::-1].tolist() == lists[::-1] and rows[5:2].tolist() == []
    assert rows[2:4] == rows[2:4] and rows[2:4] != rows[3:5]
    for wrong in [len(lists), -len(lists) - 1]:
        with pytest.raises(IndexError):
            rows[wrong]
    with pytest.raises(AttributeError):
        rows.values = None  # type: ignore[misc]
