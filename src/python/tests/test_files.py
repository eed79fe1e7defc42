"""Files and the verifier."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import septet
from conftest import rows_of
from scipy.spatial import Delaunay as Scipy


@pytest.mark.parametrize("ending", ["vtu", "vtk", "msh", "mesh", "ply"])
def test_written_triangulations_are_read(cloud: np.ndarray, tmp_path: Path, ending: str) -> None:
    if ending == "ply":
        # In space, the format holds the hull.
        cloud = np.ascontiguousarray(cloud[:, :2])
    tri = septet.Delaunay(cloud)
    path = tmp_path / f"tri.{ending}"
    tri.write(path)
    found = septet.read(path, ndim=tri.ndim)
    assert np.abs(found.points - cloud).max() < 1e-15
    if found.cells is not None:
        assert rows_of(found.cells) == rows_of(tri.simplices) and found.cells.dtype == np.int32


def test_meshio_reads_what_is_written(cloud: np.ndarray, tmp_path: Path) -> None:
    tri = septet.Delaunay(cloud)
    tri.write(str(tmp_path / "tri.vtu"))
    cells = meshio.read(tmp_path / "tri.vtu").cells[0].data
    assert rows_of(cells) == rows_of(tri.simplices)


def test_files_of_points(cloud: np.ndarray, tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", cloud)
    assert (septet.read(tmp_path / "points.npy").points == cloud).all()
    assert septet.read(tmp_path / "points.npy").cells is None
    (tmp_path / "table.csv").write_text("id,lon,lat,h\n1,2.5,3,9\n2,4,5,9\n")
    found = septet.read(tmp_path / "table.csv", columns=["lon", "lat"])
    assert found.points.tolist() == [[2.5, 3], [4, 5]] and not found.points.flags.writeable


def test_errors_of_files(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as missing:
        septet.read(tmp_path / "none.csv")
    assert missing.value.errno == 2 and missing.value.filename == str(tmp_path / "none.csv")
    with pytest.raises(IsADirectoryError):
        septet.read(tmp_path)
    (tmp_path / "bad.csv").write_text("x,y\n1,2\n3,four\n")
    with pytest.raises(septet.InputError) as error:
        septet.read(tmp_path / "bad.csv")
    assert error.value.line == 3 and error.value.path == str(tmp_path / "bad.csv")
    assert isinstance(error.value, ValueError)
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    with pytest.raises(FileNotFoundError):
        tri.write(tmp_path / "none" / "tri.vtu")
    with pytest.raises(septet.OptionError):
        tri.write(tmp_path / "tri.docx")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv"]


def test_integers_are_not_rounded(tmp_path: Path) -> None:
    path = tmp_path / "points.npy"
    points = np.array([[0, 0], [2**60, 0], [0, 5], [7, 2**53]])
    np.save(path, points)
    assert (septet.read(path).points == points).all()
    for value, dtype in ((2**53 + 1, "i8"), (-(2**53) - 1, "i8"), (2**63 + 1, "u8")):
        wrong = np.zeros((3, 2), dtype=dtype)
        wrong[1, 1] = value
        np.save(path, wrong)
        with pytest.raises(septet.InputError, match="1 of the integers") as caught:
            septet.read(path)
        assert caught.value.path == str(path) and caught.value.line is None


@pytest.mark.skipif(sys.platform == "win32", reason="names of files are Unicode")
def test_names_that_are_not_utf_8(cloud: np.ndarray, tmp_path: Path) -> None:
    name = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9")
    tri, run = septet.Delaunay(cloud), septet.simulate(cloud, workers=2)
    path: Any
    for path in (name + ".vtu", Path(name + ".vtu"), os.fsencode(name + ".vtu")):
        tri.write(path)
        assert os.path.exists(path)
        found = septet.read(path, ndim=tri.ndim)
        assert found.cells is not None and septet.verify(found.points, found.cells).ok
        os.remove(path)
    run.write(name + ".json")
    run.write(name + ".html")
    assert septet.read_run(name + ".json").report == run.report
    square = septet.mesh(([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]]), size=0.5)
    square.write(name + ".vtk")
    assert len(septet.read(name + ".vtk", ndim=2).points) == len(square.points)
    with open(name + ".poly", "w") as file:
        file.write("4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n")
    assert len(septet.mesh(name + ".poly", size=0.5).cells) > 1
    for call, ending in ((septet.read, ".csv"), (septet.read_run, ".json2"), (septet.mesh, ".stl")):
        with pytest.raises(FileNotFoundError) as missing:
            call(name + ending)  # type: ignore[operator]
        assert missing.value.filename == name + ending
    with open(name + ".csv", "w") as file:
        file.write("1,2\n1,x\n")
    for call in (septet.read, septet.read_run):
        with pytest.raises(septet.InputError) as caught:
            call(name + ".csv")  # type: ignore[operator]
        assert caught.value.path == name + ".csv"
    with pytest.raises(FileNotFoundError) as missing:
        tri.write(name + "/tri.vtu")


@pytest.mark.parametrize("contents", [
    b"", b"{", b"[]", b"3", b"null", b"\xff\xfe", b"{}", b'{"machine": {}, "points": {}, "phases": [], "rounds": []}', b"[" * 100_000,
    b'{"machine": 1, "points": 2, "phases": 3, "rounds": 4}', b'{"machine": null, "phases": [], "rounds": []}',
    b'{"machine": {"workers": 1}, "points": {"used": 1}, "phases": [1], "rounds": []}',
    b'{"machine": {"workers": 1}, "points": {"used": 1}, "phases": [], "rounds": [], "tree": {"by_level": 3}}',
    b'{"machine": {"workers": 1}, "points": {"used": 1}, "phases": [], "rounds": [], "tree": 7}',
])
def test_files_that_are_no_reports_of_runs(tmp_path: Path, contents: bytes) -> None:
    path = tmp_path / "run.json"
    path.write_bytes(contents)
    with pytest.raises(septet.InputError, match="not the report of a run") as caught:
        septet.read_run(path)
    assert caught.value.path == str(path)


def test_remedies_name_options_that_exist(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("1,2\n3,nan\n")
    with pytest.raises(septet.InputError) as caught:
        septet.read(path)
    assert "on_invalid" not in str(caught.value) and "correct it" in str(caught.value)
    for name in ("points.obj", "points.xyz"):
        (tmp_path / name).write_text("v 1 2 3\nv 1 2\n" if name.endswith("obj") else "1 2 3\n1 2\n")
        with pytest.raises(septet.InputError) as caught:
            septet.read(tmp_path / name)
        assert "--" not in str(caught.value) and "dimension=" not in str(caught.value)


def test_verdicts(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    verdict = septet.verify(cloud, tri.simplices)
    assert verdict.ok is True and verdict.faults == [] and verdict.simplices.tolist() == []
    assert septet.verify(cloud, Scipy(cloud).simplices, threads=1).ok
    rows = np.delete(tri.simplices, 17, axis=0)
    assert not septet.verify(cloud, rows).ok
    flipped = np.array(tri.simplices)
    flipped[5, 0] = (flipped[5, 0] + 500) % len(cloud)
    verdict = septet.verify(cloud, flipped)
    assert not verdict.ok and verdict.faults and len(verdict.simplices)
    wrong: "list[Any]" = [10**6, -1]
    for index in wrong:
        bad = np.array(tri.simplices, dtype=np.int64)
        bad[3, 1] = index
        verdict = septet.verify(cloud, bad)
        assert not verdict.ok and 3 in verdict.simplices
    moved = cloud.copy()
    moved[::3] += 0.4
    assert not septet.verify(moved, tri.simplices).ok
    for shape in [tri.simplices[:, :-1], tri.simplices.ravel(), tri.simplices.astype(float)]:
        with pytest.raises((ValueError, TypeError)):
            septet.verify(cloud, shape)


def test_progress_of_the_verifier() -> None:
    points = np.random.default_rng(1).random((30_000, 3))
    seen: "list[Any]" = []
    assert septet.verify(points, septet.Delaunay(points).simplices, progress=lambda *level: seen.append(level)).ok
    positions = [position for _, position, _ in seen]
    assert positions == sorted(positions) and seen[-1] == ("single cover", 5, 6)
    assert all(0 <= position < count for _, position, count in seen)
    tri = septet.Delaunay(points[:300], weights=np.arange(300) * 1e-5)
    seen.clear()
    septet.verify(points[:300], tri.simplices, weights=np.arange(300) * 1e-5, progress=lambda *level: seen.append(level))
    assert seen[-1] == ("hidden sites", 6, 7)


def test_conversions(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    mesh = tri.to_meshio()
    assert mesh.cells[0].type == ("triangle" if tri.ndim == 2 else "tetra")
    assert (mesh.cells[0].data == tri.simplices).all()
    grid = tri.to_pyvista()
    assert grid.n_cells == len(tri.simplices) and grid.n_points == len(cloud)
    hull = tri.volumes.sum()
    measured = grid.compute_cell_sizes()["Area" if tri.ndim == 2 else "Volume"].sum()
    assert abs(measured / hull - 1) < 1e-9
    cells = septet.Voronoi(cloud)
    bounded = int(np.isfinite(cells.ridge_areas).sum())
    assert sum(len(block.data) for block in cells.to_meshio().cells) == bounded
    assert cells.to_pyvista().n_cells == bounded
    square = septet.mesh(([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2, 3]]), size=0.5)
    assert square.to_pyvista().n_cells == len(square.cells) and len(square.to_meshio().cells[0].data) == len(square.cells)
