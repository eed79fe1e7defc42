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


def slope(heights: septet.Floats) -> septet.Floats:
    """The gradient by central differences."""
    return np.stack([np.gradient(heights, axis, axis=k) for k in (0, 1)])


def mean(error: septet.Floats) -> float:
    """The root mean square."""
    return float(np.sqrt(np.mean(error**2)))


results = {"linear": linear, "Sibson": sibson}
errors = {name: (mean(found - truth), mean(slope(found) - slope(truth))) for name, found in results.items()}
print(f"nodes inside the hull:           {inside.sum():,} of {inside.size:,}")
print(f"largest difference to griddata:  {difference:.12f}")
for name, (value, gradient) in errors.items():
    print(f"root mean square errors, {name}:  values {value:.4f}, slopes {gradient:.3f}")

assert inside.all() and difference < 1e-12
assert max(errors["linear"][0], errors["Sibson"][0]) < 0.01
assert errors["Sibson"][1] < 0.85 * errors["linear"][1]

figure, axes = plt.subplots(1, 3, figsize=(6.4, 2.9), layout="constrained", sharey=True)
extent = (0.05, 0.95, 0.05, 0.95)
axes[0].imshow(truth, origin="lower", extent=extent, cmap=plt.get_cmap("viridis", 24))
axes[0].plot(*places[((places > 0.05) & (places < 0.95)).all(axis=1)].T, "w.", markersize=1.5)
axes[0].set_title("function, points", fontsize=9)
for panel, (name, found) in zip(axes[1:], results.items()):
    steepness = np.hypot(*slope(found))
    shown = panel.imshow(steepness, origin="lower", extent=extent, cmap=plt.get_cmap("magma", 16), vmin=0, vmax=6)
    panel.set_title(f"steepness, {name}", fontsize=9)
figure.colorbar(shown, ax=axes, location="bottom", aspect=50, shrink=0.6)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "grid.png", dpi=100)
