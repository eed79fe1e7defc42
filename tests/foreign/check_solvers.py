#!/usr/bin/env python3
"""Reads the files of meshes of domains with other programs' readers, and compares cells and groups.

Usage: check_solvers.py DIRECTORY...

Each directory has a mesh in all formats that hold groups: `m.*` with linear cells, `q.*` with quadratic ones, and in
space the folder `polyMesh`. The files of TetGen `m.1.node`, `m.1.ele`, `m.1.face` and `m.1.edge` are the truth.

The readers: meshio, VTK, PyVista, Gmsh, scipy and netCDF4 (through meshio); parsers below for the markers of SU2, the
surfaces of Abaqus and the folder of OpenFOAM.

Python packages: meshio netCDF4 h5py gmsh numpy pyvista scipy vtk (from PyPI).
"""

import re
import sys
import traceback
from collections import defaultdict
from pathlib import Path

import numpy as np

from solver_truth import CORNERS, VTK_EDGES, Found, Truth, check_points, number_of, same_groups


def meshio_elements(truth, path, quadratic, numbers, faces=True, edges=False):
    import meshio

    mesh = meshio.read(path)
    found = Found(truth, mesh.points, quadratic)
    for at, block in enumerate(mesh.cells):
        if len(block.data):
            found.add(block.type, block.data, numbers(mesh, at, block.type))
    found.check(faces, edges)
    return mesh


def is_cell(truth, kind):
    return CORNERS[kind] == truth.d + 1


def by_name(truth):
    """Numbers of the physical groups of Gmsh, by their names, which stand for numbers that are not positive as well."""

    def numbers(mesh, at, kind):
        dimension = CORNERS[kind] - 1
        names = {int(t): name for name, (t, d) in mesh.field_data.items() if d == dimension}
        return [number_of(names[int(t)]) for t in mesh.cell_data["gmsh:physical"][at]]

    return numbers


def by_arrays(truth):
    def numbers(mesh, at, kind):
        return mesh.cell_data["region" if is_cell(truth, kind) else "marker"][at]

    return numbers


def check_meshio(extension, numbers, edges=True, faces=True):
    def check(truth, quadratic):
        path = truth.directory / f"{'q' if quadratic else 'm'}.{extension}"
        mesh = meshio_elements(truth, path, quadratic, numbers(truth), faces, edges)
        # The tag of a positive number is the number.
        if "gmsh:physical" in mesh.cell_data:
            for name, (tag, _) in mesh.field_data.items():
                assert tag > 0 and (number_of(name) <= 0 or tag == number_of(name)), name

    return check


def check_nastran(truth, quadratic):
    import meshio

    path = truth.directory / f"{'q' if quadratic else 'm'}.bdf"
    mesh = meshio.read(path)
    # The fields have sixteen characters.
    assert np.allclose(mesh.points[: len(truth.points)], truth.points, rtol=1e-9, atol=1e-12)
    n = len(truth.points)
    points = mesh.points.copy()
    points[:n] = truth.points
    found = Found(truth, points, quadratic)
    names = {}
    for line in path.read_text().split("BEGIN BULK")[0].splitlines():
        if line.startswith("$ property"):
            _, _, tag, _, card, name = line.split()
            names[card.rstrip(":"), int(tag)] = number_of(name)
    for block, tags in zip(mesh.cells, mesh.cell_data["nastran:ref"]):
        cards = {"tetra": "CTETRA", "tetra10": "CTETRA", "triangle": "CTRIA3", "triangle6": "CTRIA6", "line": "CROD"}
        numbers = [names[cards[block.type], int(tag)] for tag in tags]
        if block.type == "line" and quadratic:
            for row, number in zip(block.data, numbers):
                found.groups[1][number].add(frozenset(int(v) for v in row))
            continue
        data = np.asarray(block.data)
        found.points = np.where(np.isfinite(points), points, 0)
        corners = CORNERS[block.type]
        for row in data:
            for node, (i, j) in zip(row[corners:], VTK_EDGES):
                assert np.allclose(points[node], (points[row[i]] + points[row[j]]) / 2, atol=1e-9)
        for row, number in zip(data, numbers):
            found.groups[corners - 1][number].add(frozenset(int(v) for v in row[:corners]))
    found.check()


ABAQUS_SIDES = {3: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)], 2: [(0, 1), (1, 2), (2, 0)]}


def check_abaqus(truth, quadratic):
    import meshio

    path = truth.directory / f"{'q' if quadratic else 'm'}.inp"
    if truth.d == 2 and quadratic:
        # meshio 5.3.5 does not know CPS6. STRI65 has the same nodes.
        text = path.read_text()
        assert "TYPE=CPS6" in text
        path = path.with_name("stri65.inp")
        path.write_text(text.replace("CPS6", "STRI65"))
    mesh = meshio.read(path)
    found = Found(truth, mesh.points, quadratic)
    (block,) = mesh.cells
    for name, (rows,) in mesh.cell_sets.items():
        assert name.lower().startswith("region-")
        found.add(block.type, block.data[rows], [number_of(name)] * len(rows))
    # Surfaces of element faces.
    surface = None
    for line in path.read_text().splitlines():
        if line.startswith("*"):
            named = re.fullmatch(r"\*SURFACE, NAME=(.*), TYPE=ELEMENT", line)
            surface = number_of(named.group(1)) if named else None
        elif surface is not None:
            cell, side = line.split(", ")
            corners = ABAQUS_SIDES[truth.d][int(side[1:]) - 1]
            row = block.data[int(cell) - 1]
            found.groups[truth.d - 1][surface].add(frozenset(int(row[i]) for i in corners))
    found.check()
    for name, nodes in mesh.point_sets.items():
        if name.lower().startswith("marker-"):
            corners = {v for face in truth.faces[number_of(name)] for v in face}
            assert corners == {int(v) for v in nodes if v < len(truth.points)}, name


def check_su2(truth, _):
    import meshio

    path = truth.directory / "m.su2"
    mesh = meshio.read(path)
    kind = "tetra" if truth.d == 3 else "triangle"
    check_points(truth, mesh.points, False)
    cells = {frozenset(int(v) for v in row) for row in mesh.cells_dict[kind]}
    assert cells == set().union(*truth.cells.values())
    found, marker, left = defaultdict(set), None, 0
    for line in path.read_text().splitlines():
        if left:
            words = line.split()
            assert words[0] == ("5" if truth.d == 3 else "3")
            found[marker].add(frozenset(map(int, words[1:])))
            left -= 1
        elif line.startswith("MARKER_TAG="):
            marker = number_of(line.split("= ")[1])
        elif line.startswith("MARKER_ELEMS="):
            left = int(line.split("= ")[1])
    same_groups(found, truth.faces, "marker")


EXODUS_SIDES = {3: [(0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)], 2: [(0, 1), (1, 2), (2, 0)]}


def names_of(variable):
    return [bytes(row).rstrip(b"\0").decode() for row in variable[:]]


def check_exodus(truth, quadratic):
    import meshio
    from scipy.io import netcdf_file

    path = truth.directory / f"{'q' if quadratic else 'm'}.exo"
    with netcdf_file(path, mmap=False) as file:
        data = {name: variable[:].copy() for name, variable in file.variables.items() if name != "time_whole"}
        blocks, sets = names_of(data["eb_names"]), names_of(data["ss_names"])
        assert all(tag > 0 for name in ("eb_prop1", "ss_prop1") for tag in data[name])
        axes = [data[f"coord{axis}"] for axis in "xyz"[: truth.d]]
    found = Found(truth, np.column_stack(axes), quadratic)
    kind, cells = ("tetra" if truth.d == 3 else "triangle"), []
    for at, name in enumerate(blocks):
        rows = data[f"connect{at + 1}"] - 1
        found.add(kind, rows, [number_of(name)] * len(rows))
        cells += list(rows)
    for at, name in enumerate(sets):
        for cell, side in zip(data[f"elem_ss{at + 1}"], data[f"side_ss{at + 1}"]):
            corners = EXODUS_SIDES[truth.d][side - 1]
            face = frozenset(int(cells[cell - 1][i]) for i in corners)
            found.groups[truth.d - 1][number_of(name)].add(face)
    found.check()
    mesh = meshio.read(path)
    assert sum(len(block.data) for block in mesh.cells) == len(cells)
    assert np.array_equal(np.concatenate([block.data for block in mesh.cells]), cells)
    check_exodus_of_vtk(truth, path, quadratic)


def check_exodus_of_vtk(truth, path, quadratic):
    """The library of Exodus itself, which VTK carries."""
    import vtk

    reader = vtk.vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    kinds = [reader.ELEM_BLOCK, reader.SIDE_SET]
    counts = []
    for kind in kinds:
        for at in range(reader.GetNumberOfObjects(kind)):
            reader.SetObjectStatus(kind, at, 1)
            counts.append((reader.GetObjectName(kind, at).split()[0], reader.GetNumberOfEntriesInObject(kind, at)))
    expected = [(f"region-{n}", len(rows)) for n, rows in truth.cells.items()]
    expected += [(f"marker-{n}", len(rows)) for n, rows in truth.faces.items()]
    assert sorted(counts) == sorted(expected), f"VTK reads {counts}"
    reader.Update()
    total, it = 0, reader.GetOutput().NewIterator()
    while not it.IsDoneWithTraversal():
        total += it.GetCurrentDataObject().GetNumberOfCells()
        it.GoToNextItem()
    assert total == sum(count for _, count in expected), total


def vtk_grid(truth, grid, quadratic, faces=True, edges=True):
    """A PyVista grid with the arrays region and marker."""
    found = Found(truth, grid.points, quadratic)
    for kind, rows in grid.cells_dict.items():
        at = np.flatnonzero(grid.celltypes == kind)
        array = "region" if is_cell(truth, kind) else "marker"
        found.add(kind, rows, np.asarray(grid.cell_data[array])[at])
    found.check(faces, edges)


def check_pyvista(extension, faces=True):
    def check(truth, quadratic):
        import pyvista

        grid = pyvista.read(truth.directory / f"{'q' if quadratic else 'm'}.{extension}")
        vtk_grid(truth, grid, quadratic, faces, faces)
        assert len(grid.point_data["size"]) == grid.n_points
        markers = np.asarray(grid.point_data["marker"])
        for number, rows in truth.faces.items():
            if number:
                assert {int(markers[v]) for face in rows for v in face} <= set(truth.faces) | set(truth.edges)

    return check


def check_pyvista_msh(truth, quadratic):
    import pyvista

    grid = pyvista.read(truth.directory / f"{'q' if quadratic else 'm'}.msh")
    found = Found(truth, grid.points, quadratic)
    for kind, rows in grid.cells_dict.items():
        at = np.flatnonzero(grid.celltypes == kind)
        if is_cell(truth, kind):
            found.add(kind, rows, np.asarray(grid.cell_data["gmsh:physical"])[at])
    same_groups(found.groups[truth.d], truth.cells, "region")


def check_xdmf_of_vtk(truth, quadratic):
    import pyvista
    import vtk

    reader = vtk.vtkXdmfReader()
    reader.SetFileName(str(truth.directory / f"{'q' if quadratic else 'm'}.xdmf"))
    reader.Update()
    grid = pyvista.wrap(reader.GetOutputDataObject(0))
    while isinstance(grid, pyvista.MultiBlock):
        grid = grid[0]
    vtk_grid(truth, grid, quadratic)


def check_gmsh(extension):
    def check(truth, quadratic):
        import gmsh

        gmsh.initialize(["gmsh", "-nopopup"], readConfigFiles=False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.logger.start()
            gmsh.open(str(truth.directory / f"{'q' if quadratic else 'm'}.{extension}"))
            log = [line for line in gmsh.logger.get() if line.startswith(("Error", "Warning"))]
            assert not log, f"gmsh says {log}"
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
            places = np.zeros((len(tags), 3))
            places[tags.astype(int) - 1] = coordinates.reshape(-1, 3)
            found = Found(truth, places, quadratic)
            for dimension, group in gmsh.model.getPhysicalGroups():
                number = number_of(gmsh.model.getPhysicalName(dimension, group))
                for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
                    kinds, _, nodes = gmsh.model.mesh.getElements(dimension, entity)
                    for kind, nodes in zip(kinds, nodes):
                        width = gmsh.model.mesh.getElementProperties(kind)[3]
                        rows = nodes.astype(int).reshape(-1, width) - 1
                        if kind == 11:
                            rows = rows[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
                        names = {4: "tetra", 2: "triangle", 1: "line", 11: "tetra", 9: "triangle", 8: "line"}
                        found.add(names[kind], rows, [number] * len(rows))
            if truth.faces is None:
                truth.faces = dict(found.groups[1])
            found.check(edges=True)
            if not quadratic:
                qualities = gmsh.model.mesh.getElementQualities(
                    gmsh.model.mesh.getElements(truth.d)[1][0], "minSJ"
                )
                assert qualities.min() > 0
        finally:
            gmsh.logger.stop()
            gmsh.finalize()

    return check


def foam_list(path):
    """The text of the list of a file of OpenFOAM, after its header."""
    text = path.read_text()
    head, body = text.split("}\n\n", 1)
    assert head.startswith("FoamFile") and f"object      {path.name};" in head
    return body


def check_foam(truth, _):
    folder = truth.directory / "polyMesh"
    numbers = lambda name: np.array(foam_list(folder / name).replace("(", " ").replace(")", " ").split()[1:], dtype=float)
    points = numbers("points").reshape(-1, 3)
    check_points(truth, points, False)
    faces = numbers("faces").astype(int).reshape(-1, 4)
    assert np.all(faces[:, 0] == 3)
    faces = faces[:, 1:]
    owner, neighbour = numbers("owner").astype(int), numbers("neighbour").astype(int)
    inner = len(neighbour)
    assert len(owner) == len(faces) and np.all(owner[:inner] < neighbour)
    pairs = list(zip(owner[:inner], neighbour))
    assert pairs == sorted(pairs), "the faces are not in the order of OpenFOAM"
    # Cells from their faces, and the direction of each face.
    cells = defaultdict(set)
    for at, face in enumerate(faces):
        cells[owner[at]].update(face)
        if at < inner:
            cells[neighbour[at]].update(face)
    centres = {cell: points[list(corners)].mean(axis=0) for cell, corners in cells.items()}
    for at, (a, b, c) in enumerate(faces):
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        assert normal @ (points[a] - centres[owner[at]]) > 0, "a face points into its owner"
        if at < inner:
            assert normal @ (centres[neighbour[at]] - points[a]) > 0, "a face points out of its neighbour"
    found = defaultdict(set)
    zones = re.findall(r"region-(-?\d+)\s*{.*?List<label>\s*\d+\s*\((.*?)\)", foam_list(folder / "cellZones"), re.S)
    for number, members in zones:
        found[int(number)] |= {frozenset(map(int, cells[int(cell)])) for cell in members.split()}
    same_groups(found, truth.cells, "region")
    markers = defaultdict(set)
    total = inner
    patches = re.findall(r"marker-(-?\d+)\s*{.*?nFaces\s+(\d+);\s*startFace\s+(\d+);", foam_list(folder / "boundary"), re.S)
    for number, count, start in patches:
        assert int(start) == total
        total += int(count)
        markers[int(number)] |= {frozenset(map(int, face)) for face in faces[int(start) : total]}
    assert total == len(faces)
    zones = re.findall(r"marker-(-?\d+)\s*{.*?List<label>\s*\d+\s*\((.*?)\)", foam_list(folder / "faceZones"), re.S)
    for number, members in zones:
        markers[int(number)] |= {frozenset(map(int, faces[int(at)])) for at in members.split()}
    same_groups(markers, truth.faces, "marker")
    check_foam_of_vtk(truth, folder, len(cells), {f"marker-{n}": int(c) for n, c, _ in patches})


def check_foam_of_vtk(truth, folder, count, patches):
    import pyvista

    case = truth.directory / "case"
    (case / "constant").mkdir(parents=True)
    (case / "system").mkdir()
    (case / "constant/polyMesh").symlink_to(folder, target_is_directory=True)
    head = "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class dictionary;\n    object controlDict;\n}\n"
    (case / "system/controlDict").write_text(head + "startTime 0;\nendTime 1;\ndeltaT 1;\nwriteInterval 1;\n")
    (case / "case.foam").write_text("")
    reader = pyvista.POpenFOAMReader(str(case / "case.foam"))
    reader.enable_all_patch_arrays()
    mesh = reader.read()
    assert mesh["internalMesh"].n_cells == count
    boundary = mesh["boundary"]
    assert {name: boundary[name].n_cells for name in boundary.keys()} == patches


def checks(truth):
    for quadratic in (False, True):
        # The first gives the truth of edges in the plane.
        yield "gmsh .msh22", check_gmsh("msh22"), quadratic
        yield "gmsh .msh", check_gmsh("msh"), quadratic
        yield "meshio .msh", check_meshio("msh", by_name), quadratic
        yield "meshio .v2.msh", check_meshio("v2.msh", by_name), quadratic
        yield "meshio .vtu", check_meshio("vtu", by_arrays), quadratic
        yield "meshio .vtk", check_meshio("vtk", by_arrays, faces=False, edges=False), quadratic
        yield "pyvista .vtu", check_pyvista("vtu"), quadratic
        yield "pyvista .vtk", check_pyvista("vtk", faces=False), quadratic
        yield "pyvista .msh", check_pyvista_msh, quadratic
        yield "vtk .xdmf", check_xdmf_of_vtk, quadratic
        yield "abaqus .inp", check_abaqus, quadratic
        yield "meshio .bdf", check_nastran, quadratic
        yield "exodus .exo", check_exodus, quadratic
    # meshio 5.3.5 reads no quadratic cells in a topology of mixed types.
    yield "meshio .xdmf", check_meshio("xdmf", by_arrays), False
    yield "su2 .su2", check_su2, False
    if truth.d == 3:
        yield "foam polyMesh", check_foam, False


def main():
    passed = failed = 0
    for directory in map(Path, sys.argv[1:]):
        truth = Truth(directory)
        for name, check, quadratic in checks(truth):
            label = f"{directory.name}: {name}{' of order 2' if quadratic else ''}"
            try:
                check(truth, quadratic)
            except (Exception, SystemExit) as error:  # any way of not reading the file counts
                failed += 1
                print(f"FAILED {label}: {type(error).__name__}: {error}")
                traceback.print_exc()
            else:
                passed += 1
                print(f"ok     {label}")
    print(f"{passed} passed, {failed} failed", flush=True)
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()
