"""The measured programs and their commands."""
import dataclasses
import json
import pathlib
import re
import subprocess

import numpy as np

from drivers import driver
from lib import places

REFERENCE = "cgal"


class Failed(Exception):
    """A program ended with an error."""


class TooLong(Exception):
    """A program was stopped at the time or memory limit."""


@dataclasses.dataclass(frozen=True)
class Program:
    name: str
    label: str
    threads: int
    dimensions: tuple
    # A compiled driver's file, a Python driver's, or nothing for septet itself.
    driver: str = ""
    # A note for sets on which its cells differ from those of the others.
    caveat: str = ""

    def command(self, points):
        if self.driver.endswith(".py"):
            return [places.PYTHON, places.HERE / "drivers" / self.driver, points, self.threads]
        return [places.WORK / "bin" / self.driver, points, self.threads]

    @property
    def missing(self):
        """Returns the reason why it cannot run, or None."""
        if not self.driver or self.driver.endswith(".py") or (places.WORK / "bin" / self.driver).exists():
            return ""
        printed = places.WORK / "missing" / self.driver
        return printed.read_text().strip() if printed.exists() else "its driver is not compiled: bench/peers/setup"


SEPTET = {1: "septet-1", 2: "septet-2"}
ALL = [
    Program("septet-2", "septet, 2 workers on 2 threads", 2, (2, 3)),
    Program("septet-1", "septet, 1 worker on 1 thread", 1, (2, 3)),
    Program("cgal", "CGAL", 1, (2, 3), "cgal"),
    Program("cgal-2", "CGAL Parallel_tag, 2 threads", 2, (3,), "cgal-parallel"),
    Program("hxt", "HXT", 1, (3,), "hxt"),
    Program("hxt-2", "HXT, 2 threads", 2, (3,), "hxt"),
    Program("tetgen", "TetGen", 1, (3,), "tetgen"),
    Program("qhull", "Qhull (scipy)", 1, (2, 3), "qhull.py",
            "decides in floating point and merges what it cannot tell apart"),
    Program("gmsh", "Gmsh's algorithm API", 1, (2, 3), "gmsh_points.py",
            "meant to start a mesh from; its cells are not held to the Delaunay property"),
    Program("voro", "Voro++ (cells only)", 1, (3,), "voro", "gives Voronoi cells, no tetrahedra"),
]
BY_NAME = {program.name: program for program in ALL}


def execute(command, limit):
    """Runs a command and returns its standard output."""
    command = [str(word) for word in command]
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=limit)
    except subprocess.TimeoutExpired as late:
        raise TooLong(f"stopped after {limit:g} s") from late
    if done.returncode != 0:
        printed = done.stderr.strip().splitlines()
        ended = f"exit {done.returncode}" if done.returncode > 0 else f"signal {-done.returncode}"
        raise Failed(f"{ended}: {printed[-1] if printed else 'without a word'}")
    return done.stdout


def triangulate(binary, points, pair, limit, *more):
    """The report of one `septet triangulate` with `pair` of workers and threads."""
    workers, threads = pair
    command = [binary, "-q", "triangulate", points, "--workers", workers, "--threads", threads, *more, "--json", "-"]
    report = json.loads(execute(command, limit))
    if report["certificate"] != "passed":
        raise Failed(f"certificate {report['certificate']}")
    return report


def run(program, binary, points, limit):
    """Returns the figures of a timed run. Those of septet have no hash, because its cells are not written."""
    if program.driver:
        return json.loads(execute(program.command(points), limit))
    report = triangulate(binary, points, (program.threads, program.threads), limit)
    return {"seconds": report["seconds"]["triangulate"], "rss_before": report["rss_before_bytes"],
            "rss_peak": report["peak_rss_bytes"], "cells": report["simplices"], "hash": None, "version": report["version"],
            "phases": {phase["name"]: phase["seconds"] for phase in report["phases"]}}


def septet_cells(binary, points, threads, limit):
    """Returns number and hash of the cells of septet, from a separate run, because writing them needs memory."""
    written = places.WORK / "cells.npy"
    try:
        triangulate(binary, points, (threads, threads), limit, "-o", written)
        cells = np.load(written, mmap_mode="r")
        return {"cells": len(cells), "hash": driver.hash_cells(np.load(points), cells)}
    finally:
        pathlib.Path(written).unlink(missing_ok=True)


def parsed(text):
    """Parses names of programs, separated by commas. A name without a number of threads means all its variants."""
    chosen = []
    for word in ALL if text == "all" else text.split(","):
        found = [word] if isinstance(word, Program) else [p for p in ALL if word in (p.name, re.sub(r"-\d$", "", p.name))]
        if not found:
            raise Failed(f"no program is called {word}: {', '.join(BY_NAME)}")
        chosen += [program for program in found if program not in chosen]
    return chosen
