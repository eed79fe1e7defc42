"""Solves Poisson's equation on a plate with two pipes by linear finite elements, and measures the order of convergence.

Usage: python src/guide/gallery/heat.py [OUTPUT.png]
The plate is heated evenly, and two pipes have other temperatures: -laplace(u) = 1. The exact solution is known.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import septet
from matplotlib.tri import Triangulation
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

# A plate of 2 by 1 with two octagonal holes: points and closed loops. The regions of a mesh are the plate, 1, and the holes.
hot, cold = np.array([0.55, 0.5]), np.array([1.45, 0.5])
turn = np.arange(8) * np.pi / 4
octagon = 0.2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
corners = np.concatenate([[[0, 0], [2, 0], [2, 1], [0, 1]], hot + octagon, cold + octagon])
loops = [np.arange(4), np.arange(4, 12), np.arange(12, 20)]


def exact(x: septet.Floats) -> septet.Floats:
    """A source in the middle of one hole, a sink in the other, and a heated plate. Its negative Laplacian is 1."""
    source, sink = (np.log(np.linalg.norm(x - centre, axis=-1)) for centre in (hot, cold))
    temperature: septet.Floats = (sink - source) / 2 - ((x - [1, 0.5]) ** 2).sum(axis=-1) / 4
    return temperature


def solve(points: septet.Floats, cells: septet.Ids, boundary: septet.Ids) -> septet.Floats:
    """Linear finite elements: -laplace(u) = 1, with the exact values on the boundary."""
    a, b, c = (points[cells[:, corner]] for corner in range(3))
    opposite = np.stack([c - b, a - c, b - a], axis=1)
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    local = np.einsum("tid,tjd->tij", opposite, opposite) / (4 * area[:, None, None])
    rows, columns = np.repeat(cells, 3, axis=1).ravel(), np.tile(cells, 3).ravel()
    matrix = coo_array((local.ravel(), (rows, columns)), shape=(len(points), len(points))).tocsr()
    load = np.bincount(cells.ravel(), np.repeat(area / 3, 3), len(points))
    u, free = np.zeros(len(points)), np.setdiff1d(cells, boundary)
    u[boundary] = exact(points[boundary])
    u[free] = spsolve(matrix[free][:, free].tocsc(), (load - matrix @ u)[free])
    return u


def distance(points: septet.Floats, cells: septet.Ids, u: septet.Floats) -> float:
    """The L2 norm of u minus the exact solution, by the midpoints of the edges of each triangle."""
    area = np.abs(np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]])) / 2
    ends = cells[:, [[0, 1], [1, 2], [2, 0]]]
    error = u[ends].mean(axis=2) - exact(points[ends].mean(axis=2))
    return float(np.sqrt((error**2).sum(axis=1) @ area / 3))


plates, lengths, errors = [], [], []
for size in (0.1, 0.05, 0.025, 0.0125):
    mesh = septet.mesh((corners, loops), size=size)
    cells = mesh.cells[mesh.cell_regions == 1]
    plates.append(Triangulation(mesh.points[:, 0], mesh.points[:, 1], cells))
    edges = mesh.points[cells] - mesh.points[np.roll(cells, 1, axis=1)]
    lengths.append(np.sqrt((edges**2).sum(axis=2).mean()))
    u = solve(mesh.points, cells, mesh.facets)
    errors.append(distance(mesh.points, cells, u))
    print(f"size {size:<7} {len(cells):>7,} triangles   L2 error {errors[-1]:.2e}")
order = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
area = np.linalg.det(edges[:, 1:]).sum() / 2
print(f"area of the plate:     {area:.6f}")
print(f"order of convergence:  {order:.2f}")

assert 1.8 < order < 2.3 and abs(area + 0.16 * np.sqrt(2) - 2) < 1e-12

figure, axes = plt.subplots(2, 1, figsize=(6.4, 5.6), height_ratios=[3, 2], layout="constrained")
shown = axes[0].tricontourf(plates[-1], u, levels=20, cmap="coolwarm")
axes[0].triplot(plates[0], color="black", linewidth=0.3)
axes[0].set(aspect="equal", title="temperature, and the coarsest mesh")
figure.colorbar(shown, ax=axes[0], shrink=0.8)
axes[1].loglog(lengths, errors, "ko-", label="error in L2")
axes[1].loglog(lengths, errors[0] * (np.array(lengths) / lengths[0]) ** 2, "r--", label="order 2")
axes[1].legend(title="by the length of the edges")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "heat.png", dpi=100)
