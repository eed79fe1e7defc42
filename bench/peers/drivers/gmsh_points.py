"""Gmsh's Delaunay triangulation of points: gmsh.algorithm of its Python package. The time includes copying into NumPy arrays."""
import gmsh
import numpy as np

import driver

points = driver.points()
gmsh.initialize(interruptible=False)
gmsh.option.set_number("General.Terminal", 0)
if points.shape[1] == 3:
    (found, steiner), measured = driver.measure(lambda: gmsh.algorithm.tetrahedralize(points.ravel()))
    if len(steiner):
        raise SystemExit(f"Gmsh added {len(steiner) // 3} points")
else:
    found, measured = driver.measure(lambda: gmsh.algorithm.triangulate(points.ravel()))
cells = np.asarray(found, dtype=np.int64).reshape(-1, points.shape[1] + 1) - 1
driver.answer(measured, points, cells, gmsh.__version__)
