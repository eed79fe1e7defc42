"""Objects of other packages, which are imported when they are needed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Dict, Optional

import numpy as np

if TYPE_CHECKING:
    from ._delaunay import Delaunay
    from ._voronoi import Voronoi

# Names of simplices in meshio, and their types in VTK.
_NAMES = {2: "line", 3: "triangle", 4: "tetra"}
_TYPES = {2: 3, 3: 5, 4: 10}


def to_scipy(tri: Delaunay) -> Any:
    """Returns a scipy.spatial.Delaunay whose attributes are those of a triangulation."""
    of_scipy: Any = import_module("scipy.spatial").Delaunay
    made = of_scipy.__new__(of_scipy)
    points = np.array(tri.points)
    simplices = np.array(tri.simplices, dtype=np.int32)
    finite = points[np.isfinite(points).all(axis=1)]
    bounds = (finite.min(axis=0), finite.max(axis=0)) if len(finite) else (np.zeros(tri.ndim), np.zeros(tri.ndim))
    attributes: Dict[str, Any] = {
        "_points": points,
        "ndim": tri.ndim,
        "npoints": len(points),
        "nsimplex": len(simplices),
        "min_bound": bounds[0],
        "max_bound": bounds[1],
        "simplices": simplices,
        "neighbors": np.array(tri.neighbors, dtype=np.int32),
        "coplanar": np.array(tri.coplanar, dtype=np.int32),
        "good": np.array([], dtype=np.int32),
        "furthest_site": False,
        "_qhull": None,
        "_transform": np.array(tri.transform),
        "_vertex_to_simplex": np.array(tri.vertex_to_simplex, dtype=np.int32),
        "_vertex_neighbor_vertices": tuple(np.array(a, dtype=np.int32) for a in tri.vertex_neighbor_vertices),
    }
    # The search of scipy walks on the paraboloid, whose hyperplanes it takes from here.
    attributes.update(_paraboloid(tri, bounds))
    for name, value in attributes.items():
        setattr(made, name, value)
    return made


def _paraboloid(tri: Delaunay, bounds: Any) -> Dict[str, Any]:
    """Returns the lower hyperplanes (normal and offset) of the lifted simplices, as scipy does."""
    d = tri.ndim
    equations = np.empty((len(tri.simplices), d + 2))
    centers = np.array(tri.circumcenters)
    power = (centers**2).sum(axis=1) - np.array(tri.circumradii) ** 2
    # A lifted point has z = |p|^2, and the hyperplane of a simplex is z = 2 c.p - (|c|^2 - r^2).
    length = np.sqrt(4 * (centers**2).sum(axis=1) + 1)
    equations[:, :d] = 2 * centers / length[:, None]
    equations[:, d] = -1 / length
    equations[:, d + 1] = -power / length
    return {"equations": equations, "paraboloid_scale": 1.0, "paraboloid_shift": 0.0}


def in_space(points: Any) -> Any:
    """Returns points with three coordinates."""
    points = np.array(points, dtype=np.float64)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return points


def to_meshio(points: Any, simplices: Any, cell_data: Optional[Dict[str, Any]] = None) -> Any:
    """Returns a meshio.Mesh."""
    meshio: Any = import_module("meshio")

    data = {name: [np.array(values)] for name, values in (cell_data or {}).items()}
    return meshio.Mesh(np.array(points), [(_NAMES[simplices.shape[1]], np.array(simplices))], cell_data=data)


def to_pyvista(points: Any, simplices: Any, cell_data: Optional[Dict[str, Any]] = None) -> Any:
    """Returns a pyvista.UnstructuredGrid."""
    pyvista: Any = import_module("pyvista")

    grid = pyvista.UnstructuredGrid({_TYPES[simplices.shape[1]]: np.array(simplices)}, in_space(points))
    for name, values in (cell_data or {}).items():
        grid.cell_data[name] = np.array(values)
    return grid


def _bounded(cells: Voronoi) -> Any:
    """Returns the numbers of the ridges that do not end at infinity, and their vertices."""
    rows = cells.ridge_vertices
    bounded = [i for i, row in enumerate(rows) if len(row) and row[0] != -1]
    return np.array(bounded, dtype=np.int64), [np.array(rows[i]) for i in bounded]


def ridges_to_meshio(cells: Voronoi) -> Any:
    """Returns a meshio.Mesh of the bounded ridges."""
    meshio: Any = import_module("meshio")

    numbers, rows = _bounded(cells)
    blocks, areas = [], []
    name = "line" if cells.delaunay.ndim == 2 else "polygon"
    for length in sorted({len(row) for row in rows}):
        chosen = [i for i, row in enumerate(rows) if len(row) == length]
        blocks.append((name, np.stack([rows[i] for i in chosen])))
        areas.append(cells.ridge_areas[numbers[chosen]])
    return meshio.Mesh(np.array(cells.vertices), blocks, cell_data={"area": areas})


def ridges_to_pyvista(cells: Voronoi) -> Any:
    """Returns a pyvista.PolyData of the bounded ridges."""
    pyvista: Any = import_module("pyvista")

    numbers, rows = _bounded(cells)
    flat = np.concatenate([[len(row), *row] for row in rows]) if rows else np.zeros(0, dtype=np.int64)
    shape = {"lines": flat} if cells.delaunay.ndim == 2 else {"faces": flat}
    made = pyvista.PolyData(in_space(cells.vertices), **shape)
    made.cell_data["area"] = cells.ridge_areas[numbers]
    made.cell_data["points"] = cells.ridge_points[numbers]
    return made
