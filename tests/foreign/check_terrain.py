"""Checks that meshio reads the points and the triangles of a terrain from every format.

Usage: check_terrain.py POINTS.csv CELLS.npy FILE...
POINTS.csv has the columns x, y and z, and CELLS.npy the triangles.
"""
import sys

import meshio
import numpy as np

points = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
cells = np.load(sys.argv[2])
for name in sys.argv[3:]:
    mesh = meshio.read(name)
    found = np.asarray(mesh.cells_dict["triangle"])
    if mesh.points.shape != points.shape or (mesh.points != points).any():
        sys.exit(f"{name}: other points")
    if found.shape != cells.shape or (found != cells).any():
        sys.exit(f"{name}: other triangles")
print(f"ok {len(sys.argv) - 3} files")
