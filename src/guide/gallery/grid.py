"""Interpolates scattered values on a grid by linear weights and by those of Sibson, and compares the errors.

Usage: python src/guide/gallery/grid.py [OUTPUT.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import septet
from scipy.interpolate import griddata


def hills(x: septet.Floats, y: septet.Floats) -> septet.Floats:
    """Two hills, a hollow and a ridge."""
    bumps = [(0.75, 0.22, 0.22, 0.20), (0.5, 0.78, 0.33, 0.18), (-0.2, 0.44, 0.78, 0.11), (0.75, 0.1, 0.1, 0.45)]
    heights = [a * np.exp(-((x - u) ** 2 + (y - v) ** 2) / s**2) for a, u, v, s in bumps]
    total: septet.Floats = np.sum(heights, axis=0)
    return total


# The input: 400 measurements at random places.
places = np.random.default_rng(7).random((400, 2))
values = hills(*places.T)

# The output: a grid of 200 by 200 nodes in the middle of the square.
axis = np.linspace(0.05, 0.95, 200)
grid = np.stack(np.meshgrid(axis, axis), axis=-1)
truth = hills(grid[..., 0], grid[..., 1])

tri = septet.Delaunay(places)
linear = tri.interpolate(values, grid)
sibson = tri.interpolate(values, grid, "sibson")
scipy = griddata(places, values, grid, method="linear")

inside = tri.find_simplex(grid) >= 0
difference = np.abs(linear - scipy)[inside].max()
error = {name: np.sqrt(np.mean((found - truth)[inside] ** 2)) for name, found in [("linear", linear), ("sibson", sibson)]}
gain = error["linear"] / error["sibson"]
print(f"nodes inside the hull:             {inside.sum():,} of {inside.size:,}")
print(f"largest difference from griddata:  {difference:.12f}")
print(f"root mean square error, linear:    {error['linear']:.5f}")
print(f"root mean square error, Sibson:    {error['sibson']:.5f}")
print(f"linear error over Sibson error:    {gain:.2f}")

assert difference < 1e-12
assert np.array_equal(np.isnan(linear), ~inside) and np.array_equal(np.isnan(sibson), ~inside)
assert error["sibson"] < 0.9 * error["linear"] < 0.01

figure, axes = plt.subplots(1, 3, figsize=(6.4, 3.1), layout="constrained", sharey=True)
extent = (0.05, 0.95, 0.05, 0.95)
axes[0].imshow(sibson, origin="lower", extent=extent, cmap=plt.get_cmap("viridis", 24))
axes[0].plot(*places[((places > 0.05) & (places < 0.95)).all(axis=1)].T, "w.", markersize=1.5)
axes[0].set_title("Sibson, points", fontsize=9)
for panel, name, found in [(axes[1], "linear", linear), (axes[2], "Sibson", sibson)]:
    shown = panel.imshow(found - truth, origin="lower", extent=extent, cmap=plt.get_cmap("RdBu", 15), vmin=-0.03, vmax=0.03)
    panel.set_title(f"error, {name}", fontsize=9)
figure.colorbar(shown, ax=axes, location="bottom", aspect=50, shrink=0.6)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "grid.png", dpi=100)
