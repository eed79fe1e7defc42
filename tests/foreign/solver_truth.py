"""The truth about a mesh from its files of TetGen, and the comparison of elements with it."""

import re
from collections import defaultdict

import numpy as np


def table(path, width):
    """The integers of the first columns after the id, and the last column."""
    rows = [line.split() for line in path.read_text().splitlines()[1:] if line and line[0] != "#"]
    return [(tuple(int(float(x)) for x in row[1 : 1 + width]), int(float(row[-1]))) for row in rows]


def grouped(rows, first):
    """The sets of points of each number."""
    found = defaultdict(set)
    for corners, number in rows:
        found[number].add(frozenset(v - first for v in corners))
    return dict(found)


class Truth:
    def __init__(self, directory):
        self.directory = directory
        self.points = np.loadtxt(directory / "m.1.node", skiprows=1, ndmin=2)
        self.first = int(self.points[0, 0])
        head = (directory / "m.1.node").read_text().split()
        self.d = int(head[1])
        self.points = self.points[:, 1 : 1 + self.d]
        if self.d == 2:
            self.points = np.column_stack([self.points, np.zeros(len(self.points))])
        d, first = self.d, self.first
        self.cells = grouped(table(directory / "m.1.ele", d + 1), first)
        if d == 3:
            self.faces = grouped(table(directory / "m.1.face", 3), first)
            self.edges = grouped(table(directory / "m.1.edge", 2), first)
        else:
            # The file has all edges. Those on segments stand in the .msh file of version 2, whose reader is Gmsh's.
            self.faces, self.edges = None, {}

    def markers(self):
        return {n for n in self.faces if n > 0}


# Corners of each type, and the pairs of corners of the midpoints after them.
VTK_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
CORNERS = {
    "tetra": 4, "triangle": 3, "line": 2, "tetra10": 4, "triangle6": 3, "line3": 2,
    # Types of VTK; 4 is a polyline, which in XDMF is the only line of two points.
    10: 4, 5: 3, 3: 2, 4: 2, 24: 4, 22: 3, 21: 2,
}  # fmt: skip


def same_groups(found, expected, what):
    assert set(found) == set(expected), f"{what}: groups {sorted(found)}, not {sorted(expected)}"
    for number, rows in expected.items():
        assert found[number] == rows, f"{what} {number}: {len(found[number])} elements, not {len(rows)}"


def check_points(truth, points, quadratic):
    points = np.asarray(points)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    n = len(truth.points)
    assert (len(points) > n) == quadratic, f"{len(points)} points of {n}"
    assert np.array_equal(points[:n], truth.points), "points"
    return points


def check_midpoints(points, nodes, corners):
    """The nodes after the corners are midpoints, in the order of VTK."""
    for row in nodes:
        for node, (i, j) in zip(row[corners:], VTK_EDGES):
            middle = (points[row[i]] + points[row[j]]) / 2
            assert np.allclose(points[node], middle, rtol=0, atol=1e-12), "midpoint"


def check_positive(points, cells, d):
    e = points[cells[:, 1 : d + 1]] - points[cells[:, :1]]
    size = np.linalg.det(e[:, :, :d])
    assert np.all(size > 0), "a cell is not positive"


class Found:
    """Elements by dimension and number of the group."""

    def __init__(self, truth, points, quadratic):
        self.truth, self.quadratic = truth, quadratic
        self.points = check_points(truth, points, quadratic)
        self.groups = {1: defaultdict(set), 2: defaultdict(set), 3: defaultdict(set)}

    def add(self, kind, nodes, numbers):
        nodes, corners = np.asarray(nodes), CORNERS[kind]
        width = corners + corners * (corners - 1) // 2 if self.quadratic else corners
        assert nodes.shape[1] == width, f"{kind} of {nodes.shape[1]} nodes"
        check_midpoints(self.points, nodes, corners)
        if corners == self.truth.d + 1:
            check_positive(self.points, nodes, self.truth.d)
        for row, number in zip(nodes, numbers):
            self.groups[corners - 1][int(number)].add(frozenset(int(v) for v in row[:corners]))

    def check(self, faces=True, edges=False, cells=True):
        d = self.truth.d
        if cells:
            same_groups(self.groups[d], self.truth.cells, "region")
        if faces:
            same_groups(self.groups[d - 1], self.truth.faces, "marker")
        if edges and d == 3:
            same_groups(self.groups[1], self.truth.edges, "segment")


def number_of(name):
    """The number at the end of a name such as region-10 or marker--1."""
    return int(re.fullmatch(r"(?:region|marker|segment)-(-?\d+)", name, re.IGNORECASE).group(1))
