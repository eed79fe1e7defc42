"""Files and the verifier."""

from __future__ import annotations

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
    assert seen and all(0 <= position < count for _, position, count in seen)


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
