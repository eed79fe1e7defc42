#!/usr/bin/env python3
"""Compares the processor time of point sets with and without far points, and checks that the other cells are the same.

    bench/accept/far_points.py target/release/septet [RUNS]

Prints the ratio of the least user times of RUNS runs (default 2), for 1 and 8 workers. Needs NumPy. Exits with 1 if a cell of
near points that no far point can change differs.
"""
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

SIZES = [(2, 50_000), (2, 400_000), (3, 50_000)]


def sets(points, rng):
    """Yields the names and points of the sets with far points."""
    n, d = points.shape
    for power in (3, 6, 9, 12, 15, 20):
        yield f"1e{power}", np.vstack([points, [[10.0**power] * d]])
    yield "ten at 1e20", np.vstack([points, rng.random((10, d)) * 1e20])
    yield "ten at 1e6", np.vstack([points, rng.random((10, d)) * 1e6])
    yield "-3.4e38 on one axis", np.vstack([points, [[0.5] * (d - 1) + [-3.4e38]]])
    yield "two clusters", np.where(np.arange(n)[:, None] < n // 2, points, points + 1e6)


def least_seconds(command, runs):
    """Returns the least user time of some runs of a command."""
    def seconds():
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(command, check=True)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return min(seconds() for _ in range(runs))


def inner_cells(cells, points):
    """Returns the sorted cells whose vertices are all in the middle of the unit cube."""
    is_inner = ((points > 0.25) & (points < 0.75)).all(axis=1)
    inside = np.sort(cells[is_inner[cells].all(axis=1)], axis=1)
    return inside[np.lexsort(inside.T)]


def main(program, runs=2):
    rng = np.random.default_rng(1)
    differences = 0
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "points.npy"), Path(folder, "cells.npy")
        for d, n in SIZES:
            points = rng.random((n, d))
            for workers in (1, 8):
                command = [program, "triangulate", source, "--workers", str(workers), "-q", "-o", target]
                np.save(source, points)
                alone = least_seconds(command, runs)
                cells = inner_cells(np.load(target), points)
                for name, with_far in sets(points, rng):
                    np.save(source, with_far)
                    ratio = least_seconds(command, runs) / alone
                    same = name == "two clusters" or np.array_equal(cells, inner_cells(np.load(target), with_far))
                    differences += not same
                    print(f"{d}D {n} points, {workers} workers, {name}: {ratio:.2f}{'' if same else ', other cells'}", flush=True)
    sys.exit(differences > 0)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
