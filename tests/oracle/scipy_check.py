"""Compares cells with Qhull's (scipy.spatial.Delaunay): points in general position only.

Usage: scipy_check.py DIMENSION POINTS CELLS

POINTS holds little-endian doubles, CELLS little-endian 64-bit indices. Qhull rounds: a cell that only one side
has must be thinner than its rounding, and there may be few of them, all at the hull.
"""

import sys

import numpy as np
from scipy.spatial import Delaunay


def rows(cells):
    return {tuple(sorted(row)) for row in cells.tolist()}


def thickness(points, row):
    """Volume over the longest edge's power: 0 for a flat cell."""
    corners = points[list(row)]
    edges = corners[1:] - corners[0]
    return abs(np.linalg.det(edges)) / np.linalg.norm(edges, axis=1).max() ** points.shape[1]


def main():
    d = int(sys.argv[1])
    points = np.fromfile(sys.argv[2], "<f8").reshape(-1, d)
    ours = rows(np.fromfile(sys.argv[3], "<i8").reshape(-1, d + 1))
    theirs = rows(Delaunay(points).simplices)
    differ = ours ^ theirs
    thick = [row for row in differ if thickness(points, row) > 1e-9]
    assert not thick, f"{len(thick)} of {len(ours)} cells differ, first {thick[0]}"
    assert len(differ) <= 1e-3 * len(ours), f"{len(differ)} flat cells differ"
    print(f"ok {len(ours)} cells, {len(theirs)} by Qhull, {len(differ)} flat ones differ")


main()
