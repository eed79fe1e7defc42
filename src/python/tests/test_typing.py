"""The stub, the documentation, and the types of a caller."""

from __future__ import annotations

import doctest
import inspect
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import septet

CALLER = '''
import numpy as np
import septet

tri = septet.Delaunay(np.zeros((3, 2)), threads=2, on_invalid="skip")
count: int = tri.dimension + tri.ndim
simplices: septet.Ids = tri.find_simplex([0.5, 0.5])
weights: septet.Weights = tri.weights([[0.5, 0.5]], "sibson")
volume: float = tri.alpha_shape(1.0).volume
row: list[list[int]] = septet.Voronoi(tri, box=([0, 0], [1, 1])).regions.tolist()
box = septet.Delaunay(tri.points, weights=[1.0] * 3, period=[1.0, None], origin=(0, 0), wrap=True)
hidden: septet.Ids = box.hidden
sheets: tuple[int, ...] | None = box.sheets
cells: septet.Floats = septet.Voronoi(tri.points, period=2).volumes
ok: bool = septet.verify(tri.points, tri.simplices).ok
run: septet.Run = septet.simulate(tri.points, workers="leaves")
made: septet.Mesh = septet.mesh("part.poly", size=0.5)
try:
    septet.read("points.csv", columns=["x", "y"])
except septet.InputError as error:
    line: int | None = error.line
'''
# Types of arguments and results, which are no classes.
TYPES = ("Floats", "Ids", "Method", "Period", "Progress")
WRONG = '''
import septet

septet.Delaunay([[0, 0]], qhull_options="QJ")
septet.Delaunay([[0, 0]]).weights([0, 0], "cubic")
septet.Delaunay([[0, 0]]).simplices = 3
'''


def mypy(path: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(path.parent / "cache"), str(path)],
                          capture_output=True, text=True, check=False)


def test_a_caller_has_types(tmp_path: Path) -> None:
    (tmp_path / "caller.py").write_text(CALLER)
    done = mypy(tmp_path / "caller.py")
    assert done.returncode == 0, done.stdout
    (tmp_path / "wrong.py").write_text(WRONG)
    lines = {line.split(":")[1] for line in mypy(tmp_path / "wrong.py").stdout.splitlines() if "error:" in line}
    assert lines == {"4", "5", "6"}


def test_stub_fits_the_package(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "septet", "--ignore-disjoint-bases"], capture_output=True, text=True, check=False,
                          cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_names_are_those_of_the_stub() -> None:
    assert all(hasattr(septet, name) for name in septet.__all__)
    assert sorted(septet.__all__) == septet.__all__
    assert septet.Delaunay.__module__ == septet.Voronoi.__module__ == septet.PointError.__module__ == "septet"


@pytest.mark.parametrize("name", ["Delaunay", "Queries", "Voronoi", "Ragged", "Run", "mesh", "verify"])
def test_examples_run(name: str) -> None:
    # Delaunay inherits the methods that take queries.
    of = septet.Delaunay.__mro__[1] if name == "Queries" else getattr(septet, name)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    finder = doctest.DocTestFinder(exclude_empty=True)
    # The module `False` stands for any: the functions of a class are in a file of their own.
    for example in finder.find(of, name, module=False, globs={}):  # type: ignore[arg-type]
        runner.run(example)
    assert runner.failures == 0 and runner.tries > 0


def members(of: Any) -> Any:
    return [(name, member) for name, member in vars(of).items() if not name.startswith("_")]


def test_all_names_are_documented() -> None:
    for name in septet.__all__:
        if name.startswith("__") or name in TYPES:
            continue
        value = getattr(septet, name)
        assert inspect.getdoc(value), name
        if inspect.isclass(value) and not issubclass(value, (Exception, tuple)):
            for member, content in members(value):
                assert inspect.getdoc(content), f"{name}.{member}"
    page = inspect.getdoc(septet.Delaunay) or ""
    for heading in ["Parameters\n---", "Attributes\n---", "Examples\n---", "Raises\n---"]:
        assert heading in page


def test_files_are_short() -> None:
    folder = Path(septet.__file__).parent
    assert (folder / "py.typed").exists()
    for path in [*folder.glob("*.py"), *folder.glob("*.pyi")]:
        assert len(path.read_text().splitlines()) < 500, path
