"""Verifies two triangulations of the same grid in exact arithmetic: that of scipy, and that of septet.

Usage: python src/guide/gallery/verify.py [OUTPUT.png]
"""

import sys
from collections import Counter

import matplotlib.pyplot as plt
import numpy as np
import septet
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import Delaunay

# The corners of each cube of the grid lie on a sphere. Many of them lie in a plane.
grid = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
programs = {"scipy": Delaunay(grid).simplices, "septet": septet.Delaunay(grid).simplices}

verdicts, sixths = {}, {}
for name, simplices in programs.items():
    verdicts[name] = septet.verify(grid, simplices)
    # Six times the volume of each simplex is a whole number here.
    edges = grid[simplices[:, 1:]] - grid[simplices[:, :1]]
    sixths[name] = np.abs(np.rint(np.linalg.det(edges))).astype(int)
    flat = int((sixths[name] == 0).sum())
    result = "passes" if verdicts[name].ok else "fails"
    print(f"{name} {result}: {len(simplices)} simplices, {flat} flat, volume {sixths[name].sum() / 6:.0f}")
    for fault in verdicts[name].faults:
        print(f"    {fault}")

assert verdicts["septet"].ok and (sixths["septet"] > 0).all()
assert not verdicts["scipy"].ok and (sixths["scipy"][verdicts["scipy"].simplices] == 0).all()
assert sixths["scipy"].sum() == sixths["septet"].sum() == 6 * 4**3

figure = plt.figure(figsize=(6.4, 3.4), layout="constrained")
space = figure.add_subplot(1, 2, 1, projection="3d")
named = programs["scipy"][verdicts["scipy"].simplices]
# The four faces of a flat simplex cover its square twice.
faces = grid[named[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]]].reshape(-1, 3, 3)
space.add_collection3d(Poly3DCollection(faces, facecolor="tomato", edgecolor="darkred", linewidth=0.5))
space.scatter(*grid.T, color="black", s=2)
space.set_title("flat simplices of scipy", fontsize=10)

bars = figure.add_subplot(1, 2, 2)
for offset, (name, volumes) in zip((-0.2, 0.2), sixths.items()):
    counts = Counter(volumes.tolist())
    shown = bars.bar([volume + offset for volume in counts], list(counts.values()), width=0.4, label=name)
    bars.bar_label(shown, fontsize=8)
bars.set_xticks([0, 1], ["0", "1/6"])
bars.set_title("simplices by volume", fontsize=10)
bars.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "verify.png", dpi=100)
