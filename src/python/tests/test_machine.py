"""Runs of the counted machine."""

from __future__ import annotations

import json
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import septet

# What a report says of its process, and not of the run.
OTHER = {"version", "input", "seconds", "rss_before_bytes", "peak_rss_bytes", "view", "processes"}
OTHER_PARAMETERS = {"input", "outputs", "command", "threads", "view"}


def program() -> str:
    """The program of the wheel."""
    found = shutil.which("septet", path=str(Path(sys.executable).parent))
    assert found is not None, "the wheel has no program"
    return found


def counts(report: Any) -> Any:
    """A report without times, memory, files and threads."""

    def clean(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: clean(v) for k, v in value.items() if not k.endswith("seconds") and not k.endswith("_bytes_measured")}
        return [clean(v) for v in value] if isinstance(value, list) else value

    kept = {k: v for k, v in report.items() if k not in OTHER}
    kept["parameters"] = {k: v for k, v in kept["parameters"].items() if k not in OTHER_PARAMETERS}
    kept["settled"] = {k: v for k, v in kept.get("settled", {}).items() if k not in OTHER_PARAMETERS}
    return clean(kept)


@pytest.mark.parametrize("options", [{"workers": 4}, {"workers": "leaves", "leaf": 100}, {"workers": 3, "supergraph": "knn", "k": 12},
                                     {"workers": 2, "alpha": 2.5, "seed": 5, "separator_sets": "both"}])
def test_report_equals_that_of_the_program(cloud: np.ndarray, tmp_path: Path, options: Any) -> None:
    np.save(tmp_path / "points.npy", cloud)
    words = [word for key, value in options.items() for word in (f"--{key.replace('_', '-')}", str(value))]
    subprocess.run([program(), "simulate", "points.npy", "--json", "run.json", *words], cwd=tmp_path, check=True,
                   capture_output=True)
    expected = json.loads((tmp_path / "run.json").read_text())
    run = septet.simulate(cloud, **options)
    assert set(run.report) ^ set(expected) <= OTHER
    ours, theirs = counts(run.report), counts(expected)
    for key in theirs:
        assert ours[key] == theirs[key], key


def test_triangulation_and_tables(cloud: np.ndarray) -> None:
    run = septet.simulate(cloud, workers=4)
    report = run.report
    assert (run.delaunay.simplices == septet.Delaunay(cloud).simplices).all() and run.delaunay is run.delaunay
    assert len(run.phases) == len(report["phases"]) and len(run.rounds) == len(report["rounds"])
    assert set(run.phases.dtype.names) == {name for row in report["phases"] for name in row}
    assert {"name", "paper", "rounds", "work", "depth", "critical_depth", "messages", "bytes"} <= set(run.phases.dtype.names)
    for table, rows in [(run.phases, report["phases"]), (run.rounds, report["rounds"])]:
        for name in ("messages", "bytes"):
            assert table[name].tolist() == [row[name] for row in rows]
        assert not table.flags.writeable
    assert len(run.levels) == len(report["tree"]["by_level"]) > 1


def test_claims(cloud: np.ndarray) -> None:
    run = septet.simulate(cloud, workers="leaves", leaf=50)
    run.check("levels(3, 0)")
    run.check("merges(5, 50)")
    run.check(" rounds('merge', 5, 50) ")
    with pytest.raises(AssertionError, match="above the bound"):
        run.check("levels(0, 1)")
    with pytest.raises(AssertionError):
        run.check("rounds('merge', 0, 0)")
    for wrong in ["levels", "levels(1)", "levels('a', 1, 2)", "os.system('x')", "levels(x, 1)", "", "nothing(1, 2)", "levels(1,"]:
        with pytest.raises(septet.OptionError):
            run.check(wrong)


def test_files_of_runs(cloud: np.ndarray, tmp_path: Path) -> None:
    run = septet.simulate(cloud, workers=2)
    run.write(tmp_path / "run.json")
    run.write(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert page.lstrip().lower().startswith("<!doctype html") and len(page) > 10_000
    again = septet.read_run(tmp_path / "run.json")
    assert again.report == run.report and (again.rounds == run.rounds).all()
    for call in [lambda: again.delaunay, lambda: again.check("no_repair()")]:
        with pytest.raises(septet.Error):
            call()
    with pytest.raises(septet.OptionError):
        run.write(tmp_path / "run.txt")
    with pytest.raises(FileNotFoundError):
        septet.read_run(tmp_path / "none.json")
    (tmp_path / "bad.json").write_text('{\n"phases": [')
    with pytest.raises(septet.InputError) as error:
        septet.read_run(tmp_path / "bad.json")
    assert error.value.line == 2 and error.value.path == str(tmp_path / "bad.json")
    (tmp_path / "other.json").write_text("[1]")
    with pytest.raises(septet.InputError):
        septet.read_run(tmp_path / "other.json")
    kept = pickle.loads(pickle.dumps(run))
    assert kept.report == run.report and (kept.delaunay.simplices == run.delaunay.simplices).all()


def test_options_of_runs(cloud: np.ndarray) -> None:
    wrong: "list[Any]" = [{"workers": 0}, {"workers": "many"}, {"workers": 2**21}, {"threads": 0}, {"leaf": 0}, {"alpha": 0.5},
                          {"supergraph": "none"}, {"k": 3}, {"supergraph": "knn", "alpha": 2}, {"separator_sets": "all"}, {"seed": -1}]
    for options in wrong:
        with pytest.raises(septet.OptionError):
            septet.simulate(cloud, **options)
    with pytest.raises(septet.PointError):
        septet.simulate([[np.nan, 0]])
    assert septet.simulate(cloud, separator_sets="none", threads=1).delaunay.dimension == cloud.shape[1]


def test_counts_of_a_triangulation(cloud: np.ndarray) -> None:
    stats = septet.Delaunay(cloud).stats
    assert stats["points"]["used"] == len(cloud) and stats["certificate"] == "passed"
    assert stats["parameters"]["command"] == "triangulate" and stats["simplices"] > 0


def test_program_of_the_wheel(tmp_path: Path) -> None:
    done = subprocess.run([program(), "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.split()[-1] == septet.__version__
