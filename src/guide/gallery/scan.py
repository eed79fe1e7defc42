"""Reconstructs a solid from the points of a scan: the alpha shape with its cavities filled.

Usage: python src/guide/gallery/scan.py [OUTPUT.png [SCAN.off]]
The default is bunny00.off in the folder SEPTET_DATA or, without this variable, in tests/data. `tests/run --data` fetches it.
"""

import os
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import septet
from matplotlib.collections import PolyCollection
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

folder = Path(os.environ.get("SEPTET_DATA", Path(__file__).resolve().parents[3] / "tests" / "data"))
path = Path(sys.argv[2]) if len(sys.argv) > 2 else folder / "bunny00.off"
points, triangles = septet.read(path)
n, tri = len(points), septet.Delaunay(points)

# A ball with this radius, six times the median distance of nearest neighbours, cannot pass between the points of the surface.
nearest = np.full(n, np.inf)
lengths = np.linalg.norm(points[tri.edges[:, 0]] - points[tri.edges[:, 1]], axis=1)
np.minimum.at(nearest, tri.edges, lengths[:, None])
shape = tri.alpha_shape(6 * np.median(nearest))

# The outside and the cavities: components of the simplices that are not in the alpha complex. Its singular facets are walls.
opposite = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
code = np.array([n**2, n, 1])
free = np.append(~shape.cells, True)  # The last entry, which is also entry -1, is the outside of the hull.
cell, side = np.nonzero(free[:-1, None] & free[tri.neighbors])
facets = np.sort(tri.simplices[cell[:, None], opposite[side]], axis=1)
passes = ~np.isin(facets @ code, np.sort(shape.singular, axis=1) @ code)
links = np.stack([cell, tri.neighbors[cell, side] % len(free)])[:, passes]
_, part = connected_components(coo_array((np.ones(links.shape[1]), links), shape=(len(free), len(free))), directed=False)
solid = part != part[-1]

# The surface of the solid: facets between a simplex inside and one outside, counter-clockwise seen from outside.
cell, side = np.nonzero(solid[:-1, None] & ~solid[tri.neighbors])
surface = tri.simplices[cell[:, None], opposite[side]]
edges = surface[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
there, back = np.sort(edges @ code[1:]), np.sort(edges[:, ::-1] @ code[1:])


def enclosed(facets: septet.Ids) -> float:
    """The volume inside of an oriented surface, by the divergence theorem."""
    a, b, c = (points[facets[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


assert triangles is not None, f"{path} needs triangles"
volume, scanned = tri.volumes[solid[:-1]].sum(), enclosed(triangles)
print(f"points, all and on the surface:      {n:,} and {len(np.unique(surface)):,}")
print(f"tetrahedra, alpha shape and filled:  {shape.cells.sum():,} and {solid.sum():,}")
print(f"triangles of the surface:            {len(surface):,}")
print(f"edges without a reverse edge:        {(there != back).sum()}")
print(f"enclosed volume over tetrahedra:     {enclosed(surface) / volume:.12f}")
print(f"volume over that of the scan:        {volume / scanned:.3f}")

assert np.array_equal(there, back)
assert abs(enclosed(surface) / volume - 1) < 1e-12 and 1 < volume / scanned < 1.05

# The picture: triangles that face the viewer, from back to front, with light from the upper left.
corners = points[surface]
normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
normals /= np.linalg.norm(normals, axis=1)[:, None]
seen = np.flatnonzero(normals[:, 2] > 0)
seen = seen[np.argsort(corners[seen, :, 2].mean(axis=1))]
shade = np.round(12 * np.clip(normals[seen] @ [-0.48, 0.6, 0.64], 0, 1)) / 12

figure, axes = plt.subplots(figsize=(6.4, 6), layout="constrained")
colours = plt.get_cmap("copper")(0.2 + 0.8 * shade)
axes.add_collection(PolyCollection(corners[seen][:, :, :2], facecolors=colours, edgecolors="face", antialiaseds=False))
axes.autoscale_view()
axes.set(aspect="equal", title=f"alpha shape of {path.name}, filled")
axes.axis("off")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "scan.png", dpi=100)
