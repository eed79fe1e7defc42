"""Meshes of domains."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

import numpy as np
import pytest
import septet

CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
TRIANGLES = [t for a, b, c, d in SIDES for t in ([a, b, c], [a, c, d])]


def volume(mesh: septet.Mesh) -> float:
    corners = mesh.points[mesh.cells]
    factor = 2 if mesh.points.shape[1] == 2 else 6
    measures = np.linalg.det(corners[:, 1:] - corners[:, :1]) / factor
    assert (measures > 0).all()
    return float(measures.sum())


def test_mesh_of_a_surface() -> None:
    made = septet.mesh((CUBE, TRIANGLES), size=0.5)
    assert abs(volume(made) - 1) < 1e-9
    assert made.cells.dtype == np.int32 and made.cells.shape[1] == 4 and made.facets.shape[1] == 3
    assert len(made.cell_regions) == len(made.cells) and len(made.facet_markers) == len(made.facets)
    assert set(made.cell_regions.tolist()) == {1}
    for name in ["points", "cells", "cell_regions", "facets", "facet_markers"]:
        assert not getattr(made, name).flags.writeable and getattr(made, name) is getattr(made, name)
    assert made.quality["radius_edge"] and made.quality["angles"]
    fine = septet.mesh((CUBE, np.array(TRIANGLES)), size=0.25, threads=1)
    assert len(fine.cells) > 2 * len(made.cells)
    again = septet.mesh((CUBE, TRIANGLES), size=0.25, threads=2)
    assert (again.points == fine.points).all() and (again.cells == fine.cells).all()


def test_mesh_of_a_polygon() -> None:
    outer = [[0, 0], [4, 0], [4, 4], [0, 4]]
    made = septet.mesh((outer, [[0, 1, 2, 3]]), size=0.5, improve=True)
    assert abs(volume(made) - 16) < 1e-9 and made.facets.shape[1] == 2
    field = septet.mesh((outer, [[0, 1, 2, 3]]), size_field=([[0, 0]], [0.05]))
    near = field.points[np.hypot(*field.points.T) < 0.5]
    far = field.points[np.hypot(*(field.points - 4).T) < 0.5]
    assert len(near) > 3 * len(far)


def test_files(tmp_path: Path) -> None:
    text = "OFF\n8 12 0\n" + "".join(f"{x} {y} {z}\n" for x, y, z in CUBE) + "".join(f"3 {a} {b} {c}\n" for a, b, c in TRIANGLES)
    (tmp_path / "cube.off").write_text(text)
    made = septet.mesh(tmp_path / "cube.off", size=0.5)
    assert (made.points == septet.mesh((CUBE, TRIANGLES), size=0.5).points).all()
    made.write(tmp_path / "mesh.vtu")
    again = septet.read(tmp_path / "mesh.vtu")
    assert (again.points == made.points).all() and len(again.cells) == len(made.cells)
    again = septet.mesh((CUBE, TRIANGLES), size_field=tmp_path / "mesh.vtu")
    # The sizes of the first mesh give about as many cells, and the default sizes give far more.
    assert 0.5 < len(again.cells) / len(made.cells) < 2
    made.write(tmp_path / "mesh.msh", order=2)
    assert "\n3 1 11 " in (tmp_path / "mesh.msh").read_text()
    made.write(tmp_path / "polyMesh")
    assert (tmp_path / "polyMesh" / "boundary").is_file()
    for name, order in [("mesh.stl", 2), ("mesh.vtu", 3)]:
        with pytest.raises((septet.OptionError, ValueError)):
            made.write(tmp_path / name, order=order)
    (tmp_path / "next.off").write_text(text.replace("\n0.0 ", "\n2.0 "))
    both = septet.mesh([tmp_path / "cube.off", tmp_path / "next.off"], size=0.5)
    assert abs(volume(both) - 2) < 1e-9 and set(both.cell_regions.tolist()) == {1, 2}
    with pytest.raises(FileNotFoundError):
        septet.mesh(tmp_path / "none.off")
    (tmp_path / "bad.off").write_text("OFF\n8 12 0\n0 0 zero\n")
    with pytest.raises(septet.InputError) as error:
        septet.mesh(tmp_path / "bad.off")
    assert error.value.line == 3 and error.value.path.endswith("bad.off")
    with pytest.raises(septet.OptionError):
        made.write(tmp_path / "mesh.unknown")
    with pytest.raises(OSError):
        made.write(tmp_path / "none" / "mesh.vtu")


def test_domains_are_checked() -> None:
    with pytest.raises(septet.DomainError) as error:
        septet.mesh((CUBE, TRIANGLES[1:]))
    assert error.value.defects and all(isinstance(defect, str) for defect in error.value.defects)
    wrong: "List[Any]" = [(CUBE, [[0, 1, 99]]), (CUBE, [[0, -1, 2]]), (CUBE,), 7, (CUBE, [[0.5, 1, 2]])]
    for domain in wrong:
        with pytest.raises((ValueError, TypeError)):
            septet.mesh(domain)


def test_options_are_checked() -> None:
    wrong: "List[Any]" = [{"size": -1}, {"size": "x"}, {"size": 1, "min_size": 2}, {"boundary": "keep"}, {"feature_angle": 181},
                          {"threads": 0}, {"max_distance": 0}, {"improve": 2}, {"size_field": [1]}, {"size": float("nan")},
                          {"keep_surface": True, "boundary": "remesh"}, {"size": "none", "boundary": "remesh"}]
    for options in wrong:
        with pytest.raises((septet.OptionError, ValueError)):
            septet.mesh((CUBE, TRIANGLES), **options)


def test_progress_and_memory() -> None:
    seen: List[Any] = []
    septet.mesh((CUBE, TRIANGLES), size=0.1, progress=lambda *stage: seen.append(stage))
    assert seen and all(0 <= position < count for _, position, count in seen)

    class Stop(Exception):
        pass

    def stop(*_: Any) -> None:
        raise Stop

    with pytest.raises(Stop):
        septet.mesh((CUBE, TRIANGLES), size=0.02, progress=stop)
    with pytest.raises(septet.MemoryLimitError):
        septet.mesh((CUBE, TRIANGLES), size=0.01, max_memory=1_000_000)
