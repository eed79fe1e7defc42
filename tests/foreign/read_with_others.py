#!/usr/bin/env python3
"""Reads the files of septet with other programs' readers and compares them bit for bit.

Usage: read_with_others.py DIRECTORY

Every directory below DIRECTORY (or DIRECTORY itself) that holds an `expected.json` is one mesh in
all formats, all files named `mesh.*`. `expected.json` gives `dimension`, `points`, `cells`, `hull`
(number of hull facets), `coordinate_sum` and `first_id`; `coordinates.f64` and `cells.i64` hold the
arrays as little-endian numbers, row after row.

Python packages: vtk meshio gmsh numpy (from PyPI).
The wheel of gmsh loads shared libraries of these Debian packages (those of vtk need none of them
to read files):
  libglu1-mesa libgl1 libxrender1 libxcursor1 libxfixes3 libxext6 libxft2 libfontconfig1
  libxinerama1 libx11-6 libgomp1 zlib1g
Tried on Debian 12 with vtk 9.7.2, meshio 5.3.5, gmsh 4.15.2, numpy 2.4.6.
"""

import json
import sys
import traceback
from pathlib import Path

import numpy as np


class Mesh:
    """What the files of one directory must hold."""

    def __init__(self, directory):
        self.directory = directory
        meta = json.loads((directory / "expected.json").read_text())
        self.dimension = meta["dimension"]
        self.hull = meta["hull"]
        self.first_id = meta["first_id"]
        d = self.dimension
        self.points = np.fromfile(directory / "coordinates.f64", "<f8").reshape(-1, d)
        self.cells = np.fromfile(directory / "cells.i64", "<i8").reshape(-1, d + 1)
        assert len(self.points) == meta["points"], "number of points"
        assert len(self.cells) == meta["cells"], "number of cells"
        total = 0.0
        for value in self.points.ravel():
            total += float(value)
        assert total == meta["coordinate_sum"], "sum of coordinates"
        self.cell_name = "tetra" if d == 3 else "triangle"
        self.facet_name = "triangle" if d == 3 else "line"

    def path(self, extension):
        return self.directory / f"mesh{extension}"

    def in_space(self):
        if self.dimension == 3:
            return self.points
        return np.column_stack([self.points, np.zeros(len(self.points))])


def same_bits(found, expected, what):
    found = np.ascontiguousarray(found, dtype="<f8")
    expected = np.ascontiguousarray(expected, dtype="<f8")
    assert found.shape == expected.shape, f"{what}: shape {found.shape}, not {expected.shape}"
    differ = np.flatnonzero(found.view("<u8").ravel() != expected.view("<u8").ravel())
    assert len(differ) == 0, (
        f"{what}: {len(differ)} numbers differ, first {found.ravel()[differ[0]]!r} "
        f"for {expected.ravel()[differ[0]]!r}"
    )


def same_integers(found, expected, what):
    found, expected = np.asarray(found), np.asarray(expected)
    if expected.size == 0:
        assert found.size == 0, f"{what}: {found.size} numbers, none expected"
        return
    assert found.shape == expected.shape, f"{what}: shape {found.shape}, not {expected.shape}"
    assert np.array_equal(found.astype(np.int64), expected), f"{what} differ"


def hull_of(mesh):
    """The hull facets, sorted vertices in sorted rows, found without septet."""
    d, seen = mesh.dimension, {}
    for cell in mesh.cells:
        for i in range(d + 1):
            key = tuple(sorted(np.delete(cell, i).tolist()))
            seen[key] = seen.get(key, 0) + 1
    rows = sorted(key for key, count in seen.items() if count == 1)
    return np.array(rows, dtype=np.int64).reshape(-1, d)


def check_hull(mesh, facets, what):
    facets = np.asarray(facets, dtype=np.int64).reshape(-1, mesh.dimension)
    assert len(facets) == mesh.hull, f"{what}: {len(facets)} hull facets, not {mesh.hull}"
    rows = np.array(sorted(tuple(sorted(row)) for row in facets.tolist()), dtype=np.int64)
    same_integers(rows.reshape(-1, mesh.dimension), hull_of(mesh), what)
    if mesh.dimension == 3 and len(facets):
        volumes = signed_volumes(mesh.points, mesh.cells)
        a, b, c = (mesh.points[facets[:, i]] for i in range(3))
        inside = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        assert np.isclose(inside, volumes.sum()), f"{what}: not oriented outward"


def signed_volumes(points, cells):
    p = points[cells]
    u, v, w = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], p[:, 3] - p[:, 0]
    return np.einsum("ij,ij->i", np.cross(u, v), w) / 6


def ratios(mesh):
    """Circumradius by shortest edge, by a linear system for the centre."""
    result = []
    for cell in mesh.cells:
        p = mesh.points[cell]
        e = p[1:] - p[0]
        centre = np.linalg.solve(2 * e, (e * e).sum(axis=1))
        edges = [np.linalg.norm(p[i] - p[j]) for i in range(len(p)) for j in range(i)]
        result.append(np.linalg.norm(centre) / min(edges))
    return np.array(result)


def check_numpy(mesh):
    cells = np.load(mesh.path(".npy"))
    assert cells.dtype == np.dtype("<i8") and cells.flags.c_contiguous
    assert cells.shape == mesh.cells.shape
    same_integers(cells, mesh.cells, "cells")


def check_tables(mesh):
    """The files of TetGen as plain tables."""

    def table(extension):
        path = mesh.path(extension)
        count = int(path.read_text().split(maxsplit=1)[0])
        rows = np.loadtxt(path, skiprows=1, ndmin=2) if count else np.zeros((0, 0))
        assert len(rows) == count, f"{extension}: {len(rows)} rows, not {count}"
        if count:
            ids = np.arange(count) + mesh.first_id
            same_integers(rows[:, 0], ids, f"{extension}: ids")
        return rows[:, 1:]

    same_bits(table(".node"), mesh.points, "points")
    same_integers(table(".ele"), mesh.cells + mesh.first_id, "cells")
    if not len(mesh.cells):
        return
    edges = table(".edge")
    hull_edges = edges[edges[:, 2] == 1, :2].astype(np.int64) - mesh.first_id
    if mesh.dimension == 3:
        faces = table(".face")
        assert np.all(faces[:, 3] == 1)
        check_hull(mesh, faces[:, :3].astype(np.int64) - mesh.first_id, "faces")
    else:
        check_hull(mesh, hull_edges, "hull edges")
    neighbours = table(".neigh").astype(np.int64)
    assert (neighbours == -1).sum() == mesh.hull
    for cell, row in zip(mesh.cells, neighbours):
        for vertex, other in zip(cell, row):
            if other >= 0:
                shared = set(cell) & set(mesh.cells[other - mesh.first_id])
                assert shared == set(cell) - {vertex}, "neighbours"


def check_vtk(mesh):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    errors = []
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("reader error"))
    reader.SetFileName(str(mesh.path(".vtu")))
    reader.Update()
    assert not errors and reader.GetErrorCode() == 0, "VTK reports an error"
    grid = reader.GetOutput()
    n, m, corners = len(mesh.points), len(mesh.cells), mesh.dimension + 1
    assert grid.GetNumberOfPoints() == n and grid.GetNumberOfCells() == m
    if n:
        same_bits(vtk_to_numpy(grid.GetPoints().GetData()), mesh.in_space(), "points")
        ids = grid.GetPointData().GetGlobalIds()
        assert ids is not None and ids.GetName() == "GlobalPointIds"
        same_integers(vtk_to_numpy(ids), np.arange(n), "point ids")
    if m:
        found = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, corners)
        same_integers(found, mesh.cells, "cells")
        kind = vtk.VTK_TETRA if mesh.dimension == 3 else vtk.VTK_TRIANGLE
        assert all(grid.GetCellType(i) == kind for i in range(m))
        data = grid.GetCellData()
        ids = data.GetGlobalIds()
        assert ids is not None and ids.GetName() == "GlobalCellIds"
        same_integers(vtk_to_numpy(ids), np.arange(m), "cell ids")
        found = vtk_to_numpy(data.GetArray("radius_edge_ratio"))
        assert np.allclose(found, ratios(mesh), rtol=1e-9), "radius-edge ratios"
        same_integers(vtk_to_numpy(data.GetArray("owner")), np.arange(m) % 3, "owners")
        leaf = vtk_to_numpy(data.GetArray("home_leaf"))
        same_integers(leaf, np.arange(m) << 33, "home leaves")


def meshio_cells(found, name, width):
    blocks = [block.data for block in found.cells if block.type == name and len(block.data)]
    return np.concatenate(blocks) if blocks else np.zeros((0, width), dtype=np.int64)


def check_meshio(extension, file_format, flat=False):
    """`flat`: the reader keeps the dimension of the file, else it is always space."""

    def check(mesh):
        import meshio

        found = meshio.read(mesh.path(extension), file_format=file_format)
        same_bits(found.points, mesh.points if flat else mesh.in_space(), "points")
        cells = meshio_cells(found, mesh.cell_name, mesh.dimension + 1)
        same_integers(cells, mesh.cells, "cells")
        if file_format == "medit":
            facets = meshio_cells(found, mesh.facet_name, mesh.dimension)
            check_hull(mesh, facets, "hull")

    return check


def check_meshio_off(mesh):
    import meshio

    found = meshio.read(mesh.path(".off"), file_format="off")
    triangles = meshio_cells(found, "triangle", 3)
    if mesh.dimension == 2:
        same_bits(found.points, mesh.in_space(), "points")
        same_integers(triangles, mesh.cells, "cells")
        return
    used = np.unique(hull_of(mesh))
    same_bits(found.points, mesh.points[used], "points")
    check_hull(mesh, used[triangles], "hull")


def check_gmsh(extension):
    def check(mesh):
        import gmsh

        gmsh.initialize(["gmsh", "-nopopup"], readConfigFiles=False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.logger.start()
            gmsh.open(str(mesh.path(extension)))
            log = [line for line in gmsh.logger.get() if line.startswith(("Error", "Warning"))]
            assert not log, f"gmsh says {log}"
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
            order = np.argsort(tags)
            tags = tags[order].astype(np.int64) - 1
            coordinates = coordinates.reshape(-1, 3)[order]
            # Version 2.2 has no place for points outside all cells; gmsh drops them.
            used = np.unique(mesh.cells)
            assert np.all(np.isin(used, tags)), "points are missing"
            assert len(tags) == len(np.unique(tags))
            if len(tags):
                same_bits(coordinates, mesh.in_space()[tags], "points")
            kind = 4 if mesh.dimension == 3 else 2
            _, nodes = gmsh.model.mesh.getElementsByType(kind)
            cells = nodes.astype(np.int64).reshape(-1, mesh.dimension + 1) - 1
            same_integers(cells, mesh.cells, "cells")
            if extension == ".mesh":
                _, nodes = gmsh.model.mesh.getElementsByType(2 if mesh.dimension == 3 else 1)
                check_hull(mesh, nodes.astype(np.int64) - 1, "hull")
            elif len(mesh.cells):
                groups = gmsh.model.getPhysicalGroups()
                assert list(groups) == [(mesh.dimension, 1)], f"physical groups {groups}"
                version = 2.2 if "2" in extension else 4.1
                head = mesh.path(extension).read_text().split("\n", 2)[1]
                assert head == f"{version} 0 8", head
        finally:
            gmsh.logger.stop()
            gmsh.finalize()

    return check


def checks(mesh):
    yield "numpy .npy", check_numpy
    yield "numpy .node .ele .face .edge .neigh", check_tables
    yield "vtk .vtu", check_vtk
    yield "meshio .mesh", check_meshio(".mesh", "medit", flat=True)
    yield "meshio .msh22", check_meshio(".msh22", "gmsh")
    yield "meshio .off", check_meshio_off
    for extension in [".msh", ".msh41", ".msh22", ".mesh"]:
        yield f"gmsh {extension}", check_gmsh(extension)
    yield "meshio .msh41", check_meshio(".msh41", "gmsh")
    if len(mesh.cells):  # meshio 5.3.5 reads no .vtu without cells, whoever wrote it
        yield "meshio .vtu", check_meshio(".vtu", "vtu")
    if mesh.dimension == 3:
        yield "meshio .ele", check_meshio(".ele", "tetgen")


def main():
    root = Path(sys.argv[1])
    passed = failed = 0
    for expected in sorted(root.rglob("expected.json")):
        mesh = Mesh(expected.parent)
        for name, check in checks(mesh):
            label = f"{expected.parent.name}: {name}"
            try:
                check(mesh)
            except (Exception, SystemExit) as error:  # any way of not reading the file counts
                failed += 1
                print(f"FAILED {label}: {type(error).__name__}: {error}")
                traceback.print_exc()
            else:
                passed += 1
                print(f"ok     {label}")
    if passed + failed == 0:
        print(f"no expected.json below {root}")
        failed = 1
    print(f"{passed} passed, {failed} failed", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
