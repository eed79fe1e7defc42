#!/usr/bin/env python3
"""Reads a .pvtu file with VTK, as one and as three update pieces, and compares it with the .vtu file of the same points.

Usage: check_pieces.py WHOLE.vtu LIST.pvtu USED

USED is the number of points that are vertices. Prints `ok` and the numbers that it found, or fails.

Python packages: vtk numpy (from PyPI). Tried with vtk 9.7.2, numpy 2.4.6.
"""

import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

GHOST = "vtkGhostType"


def read(reader, path, piece=None):
    """The grid of a file. `piece`: the update piece and the number of pieces."""
    errors = []
    for event in ["ErrorEvent", "WarningEvent"]:
        reader.AddObserver(event, lambda *_: errors.append(event))
    reader.SetFileName(path)
    if piece is None:
        reader.Update()
    else:
        reader.UpdatePiece(*piece, 0)
    assert not errors and reader.GetErrorCode() == 0, f"VTK reports {errors} for {path}"
    grid = vtk.vtkUnstructuredGrid()
    grid.DeepCopy(reader.GetOutput())
    return grid


def arrays(grid, corners):
    """Ids and ghost types of points and cells, and the cells as rows of point ids."""
    found = []
    for data, name in [(grid.GetPointData(), "GlobalPointIds"), (grid.GetCellData(), "GlobalCellIds")]:
        if data.GetNumberOfTuples() == 0:
            found += [np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.uint8)]
            continue
        ids = data.GetGlobalIds()
        assert ids is not None and ids.GetName() == name, f"no {name}"
        types = data.GetArray(GHOST)
        assert types.GetDataType() == vtk.VTK_UNSIGNED_CHAR, "type of the ghost types"
        found += [vtk_to_numpy(ids).astype(np.int64), vtk_to_numpy(types)]
    rows = np.zeros((0, corners), dtype=np.int64)
    if grid.GetNumberOfCells():
        rows = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
        rows = found[0][rows]
    return (*found, rows)


def measures(points, rows):
    """The volumes of tetrahedra, or the areas of triangles."""
    edges = points[rows[:, 1:]] - points[rows[:, :1]]
    d = rows.shape[1] - 1
    return np.linalg.det(edges[:, :, :d]) / (6 if d == 3 else 2)


def surface_measure(grid, d):
    """The volume inside the hull, or its area, from its facets alone."""
    if d == 2:
        rows = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
        edges = np.concatenate([rows[:, [0, 1]], rows[:, [1, 2]], rows[:, [2, 0]]])
        low, high = edges.min(axis=1), edges.max(axis=1)
        _, first, count = np.unique(np.stack([low, high], 1), axis=0, return_index=True, return_counts=True)
        points = vtk_to_numpy(grid.GetPoints().GetData())
        a, b = (points[edges[first[count == 1], i]] for i in [0, 1])
        return abs((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / 2
    surface = vtk.vtkDataSetSurfaceFilter()
    surface.SetInputData(grid)
    mass = vtk.vtkMassProperties()
    mass.SetInputConnection(surface.GetOutputPort())
    mass.Update()
    return mass.GetVolume()


def check_sum(found, expected, what):
    assert abs(found - expected) <= 1e-9 * abs(expected), f"{what}: {found}, not {expected}"


def contour(grid, centre, values):
    """The contours of the squared distance from a point, without the polygons of ghost cells."""
    squares = ((vtk_to_numpy(grid.GetPoints().GetData()) - centre) ** 2).sum(axis=1)
    array = numpy_to_vtk(squares, deep=True)
    array.SetName("squares")
    grid.GetPointData().AddArray(array)
    filtered = vtk.vtkContourFilter()
    filtered.SetInputData(grid)
    filtered.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "squares")
    for at, value in enumerate(values):
        filtered.SetValue(at, value)
    filtered.Update()
    polygons = vtk.vtkPolyData()
    polygons.DeepCopy(filtered.GetOutput())
    polygons.RemoveGhostCells()
    polygons.GetPointData().Initialize()
    polygons.GetCellData().Initialize()
    return polygons


def figures(parts):
    """The numbers of polygons, regions and open edges of contours together."""
    joined = vtk.vtkAppendPolyData()
    for part in parts:
        joined.AddInputData(part)
    # A point of a contour on an edge between pieces is rounded in each of them.
    clean = vtk.vtkCleanPolyData()
    clean.SetInputConnection(joined.GetOutputPort())
    clean.ToleranceIsAbsoluteOn()
    clean.SetAbsoluteTolerance(1e-13)
    clean.Update()
    polygons = clean.GetOutput().GetNumberOfCells()
    if polygons == 0:
        return 0, 0, 0
    regions = vtk.vtkPolyDataConnectivityFilter()
    regions.SetInputConnection(clean.GetOutputPort())
    regions.SetExtractionModeToAllRegions()
    regions.Update()
    edges = vtk.vtkFeatureEdges()
    edges.SetInputConnection(clean.GetOutputPort())
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.Update()
    return polygons, regions.GetNumberOfExtractedRegions(), edges.GetOutput().GetNumberOfCells()


class Whole:
    """The single file: its points, its cells by their vertices, and the number of cells at each point."""

    def __init__(self, path):
        self.grid = read(vtk.vtkXMLUnstructuredGridReader(), path)
        self.points = vtk_to_numpy(self.grid.GetPoints().GetData())
        cells = vtk_to_numpy(self.grid.GetCells().GetConnectivityArray())
        self.corners = 4 if self.grid.GetCellType(0) == vtk.VTK_TETRA else 3
        self.rows = cells.reshape(-1, self.corners)
        self.degrees = np.bincount(cells, minlength=len(self.points))
        self.measure = surface_measure(self.grid, self.corners - 1)


def check_grid(whole, grid):
    """Checks one update piece. Returns the ids of its own points and cells, and the rows of its own cells."""
    points, point_types, cells, cell_types, rows = arrays(grid, whole.corners)
    assert set(point_types) | set(cell_types) <= {0, 1}, "other ghost types"
    if len(points):
        found = vtk_to_numpy(grid.GetPoints().GetData())
        assert np.array_equal(found, whole.points[points]), "coordinates"
    own = points[point_types == 0]
    # Several pieces of the file in one update piece: a ghost cell occurs again, with the same id.
    _, first = np.unique(cells, return_index=True)
    found = np.bincount(rows[first].ravel(), minlength=len(whole.points))
    assert np.array_equal(found[own], whole.degrees[own]), "a point does not have all its cells"
    return own, cells[cell_types == 0], rows[cell_types == 0]


def check_all(whole, grids, used):
    """Checks update pieces together. Returns the measure of their cells."""
    own = [check_grid(whole, grid) for grid in grids]
    points, cells, rows = (np.concatenate([part[i] for part in own]) for i in range(3))
    assert len(points) == len(np.unique(points)) == used, f"{len(points)} points, not {used}"
    assert np.array_equal(np.sort(cells), np.arange(len(whole.rows))), "cell ids are not complete"
    # Rows are sorted in the single file.
    order = np.lexsort(rows.T[::-1])
    assert np.array_equal(rows[order], whole.rows), "other cells"
    return measures(whole.points, rows).sum()


def main():
    whole, path, used = Whole(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    one = read(vtk.vtkXMLPUnstructuredGridReader(), path)
    three = [read(vtk.vtkXMLPUnstructuredGridReader(), path, (i, 3)) for i in range(3)]
    for grids in [[one], three]:
        check_sum(check_all(whole, grids, used), whole.measure, "measure")
    # Spheres in the hull of a cube are closed. Spheres through some of the points may be open.
    low, high = whole.points.min(axis=0), whole.points.max(axis=0)
    centre, radius = (low + high) / 2, 0.3 * (high - low)[: whole.corners - 1].min()
    squares = ((whole.points - centre) ** 2).sum(axis=1)
    print(f"ok {len(whole.rows)} cells", end="")
    for values in [(0.4 * radius) ** 2, radius**2], [np.quantile(squares, 0.31), np.quantile(squares, 0.62)]:
        expected = figures([contour(whole.grid, centre, values)])
        for grids in [[one], three]:
            found = figures([contour(grid, centre, values) for grid in grids if grid.GetNumberOfCells()])
            assert found == expected, f"contours: {found}, not {expected}"
        print("; {} polygons, {} regions, {} open edges".format(*expected), end="")
    print()


if __name__ == "__main__":
    main()
