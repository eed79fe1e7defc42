"""Meshes a box domain with Gmsh: gmsh_mesh.py DOMAIN ALGORITHM SIZE THREADS OUT, ALGORITHM delaunay or hxt.

Writes OUT.points.npy and OUT.cells.npy after the clock has stopped, and the seconds of the 3D mesh with its surface.
"""
import sys
import time

import gmsh
import numpy as np

domain, algorithm, size, threads, out = sys.argv[1:]
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("General.NumThreads", int(threads))
gmsh.option.setNumber("Mesh.Algorithm3D", {"delaunay": 1, "hxt": 10}[algorithm])
gmsh.option.setNumber("Mesh.MeshSizeMin", float(size))
gmsh.option.setNumber("Mesh.MeshSizeMax", float(size))
corners = {"cube": [(0, 0), (1, 0), (1, 1), (0, 1)], "l": [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]}[domain]
points = [gmsh.model.geo.addPoint(x, y, 0) for x, y in corners]
lines = [gmsh.model.geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
base = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
gmsh.model.geo.extrude([(2, base)], 0, 0, 1)
gmsh.model.geo.synchronize()
start = time.perf_counter()
gmsh.model.mesh.generate(3)
seconds = time.perf_counter() - start
tags, coordinates, _ = gmsh.model.mesh.getNodes()
position = np.zeros(int(tags.max()) + 1, dtype=np.int64)
position[tags.astype(np.int64)] = np.arange(len(tags))
cells = gmsh.model.mesh.getElementsByType(4)[1].astype(np.int64).reshape(-1, 4)
np.save(out + ".points.npy", coordinates.reshape(-1, 3))
np.save(out + ".cells.npy", position[cells])
print(f"{seconds:.6f}")
