"""The conventions of arrays: types, layout, ownership, immutability."""

from __future__ import annotations

import gc
import pickle
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


def settable(array: np.ndarray) -> bool:
    """Whether the flag of an array, or of an array whose memory it shows, can be set back."""
    at: Any = array
    while isinstance(at, np.ndarray):
        if at.size == 0:
            return False
        try:
            at.flags.writeable = True
            return True
        except ValueError:
            at = at.base
    return False


def test_no_array_becomes_writeable_again(cloud: np.ndarray, tmp_path: Any) -> None:
    tri = septet.Delaunay(np.vstack([cloud, cloud[:3]]))
    x = cloud[:7] * 0.9
    cells = septet.Voronoi(tri, box=(np.zeros(tri.ndim), np.ones(tri.ndim)))
    run = septet.simulate(cloud, workers=2)
    square = septet.mesh(([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]]), size=0.5)
    box = septet.Delaunay(cloud, period=1, weights=np.zeros(len(cloud)))
    tri.write(tmp_path / "tri.vtu")
    made = [*arrays_of(tri).values(), tri.coplanar, tri.find_simplex(x), tri.nearest_vertex(x), *tri.barycentric(x)]
    made += [*tri.weights(x), tri.interpolate(cells.volumes, x), tri.gradients(cells.volumes), *tri.alpha_filtration()]
    made += [*tri.alpha_shape(0.1)[:3], cells.volumes, cells.centroids, cells.vertices, cells.ridge_points]
    made += [cells.regions.values, cells.regions.offsets, cells.regions[3], cells.regions[2:9].values, cells.point_region]
    made += [run.rounds, run.levels, box.offsets, box.hidden, septet.Voronoi(box).regions.values]
    made += [square.points, square.cells, square.cell_regions, square.facets, square.facet_markers]
    made += [*septet.read(tmp_path / "tri.vtu"), septet.verify(cloud, tri.simplices[1:]).simplices]
    made += [septet.Ragged([0, 2, 3], [5, 6, 7]).values, pickle.loads(pickle.dumps(cells.regions)).values]
    for i, array in enumerate(array for array in made if not array.dtype.hasobject):
        assert not array.flags.writeable, i
        assert not settable(array), i


def test_ragged_arrays_are_checked() -> None:
    offsets, values = np.array([0, 2, 2, 3]), np.array([4, 5, 6])
    rows = septet.Ragged(offsets, values)
    values[0] = 9
    assert rows.tolist() == [[4, 5], [], [6]] and offsets.flags.writeable and values.flags.writeable
    assert len(septet.Ragged([0], [])) == 0
    for wrong in ([], [1, 3], [0, 2], [0, 4], [0, 2, 1, 3], [[0, 3]], [-1, 3]):
        with pytest.raises(ValueError):
            septet.Ragged(wrong, values)
    with pytest.raises((TypeError, ValueError)):
        septet.Ragged([0.0, 3.0], values)
    with pytest.raises((TypeError, ValueError)):
        septet.Ragged([0, 3], ["a", "b", "c"])
    with pytest.raises(ValueError):
        septet.Ragged([0, 3], [[1, 2, 3]])
    with pytest.raises(AttributeError):
        rows.__init__([0, 1], [1])  # type: ignore[misc]


def test_negative_zeros_stay(ndim: int) -> None:
    points = np.eye(ndim + 1, ndim) * 2 - 0.0
    points[points == 0] = -0.0
    points = np.vstack([points, np.full(ndim, np.nan), np.full(ndim, 1e300)])
    points[-1, 0] = np.inf
    for options in ({}, {"weights": np.zeros(len(points))}):
        tri = septet.Delaunay(points, on_invalid="skip", **options)  # type: ignore[arg-type]
        copy = pickle.loads(pickle.dumps(tri))
        for kept in (tri.points, copy.points):
            assert np.array_equal(kept, points, equal_nan=True)
            assert (np.signbit(kept[:-2]) == np.signbit(points[:-2])).all()
