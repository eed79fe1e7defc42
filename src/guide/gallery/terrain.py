"""Triangulates a terrain from scattered heights, and shades it by the gradient of each triangle.

Usage: python src/guide/gallery/terrain.py [OUTPUT.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import septet
from matplotlib.tri import Triangulation


def terrain(x: septet.Floats, y: septet.Floats) -> tuple[septet.Floats, septet.Floats]:
    """Heights of waves of random directions in metres, and their gradients."""
    rng = np.random.default_rng(11)
    height, gradient = np.full(len(x), 900.0), np.zeros((len(x), 2))
    for octave in range(4):
        for _ in range(5):
            angle, phase = rng.uniform(0, 2 * np.pi, 2)
            wave = 2**octave / 1500 * np.array([np.cos(angle), np.sin(angle)])
            amplitude = 150 / 2 ** (1.2 * octave)
            height += amplitude * np.sin(x * wave[0] + y * wave[1] + phase)
            gradient += amplitude * np.cos(x * wave[0] + y * wave[1] + phase)[:, None] * wave
    return height, gradient


# Surveyed points: 20,000 at random in a square of 10 km, and the border every 100 m.
side = 10_000.0
border = np.arange(0, side, 100)
edge, other = np.zeros_like(border), np.full_like(border, side)
loop = [(border, edge), (other, border), (side - border, other), (edge, side - border)]
rows = [np.stack(pair, axis=1) for pair in loop]
points = np.concatenate([*rows, np.random.default_rng(5).uniform(0, side, (20_000, 2))])
heights, _ = terrain(*points.T)

tri = septet.Delaunay(points)
gradients = tri.gradients(heights)
slopes = np.hypot(*gradients.T)
surface = (tri.volumes * np.hypot(1, slopes)).sum()

# The exact gradients at the centres of the triangles, weighted by area.
middle = points[tri.simplices].mean(axis=1)
_, exact = terrain(*middle.T)
error = np.sqrt(((gradients - exact) ** 2).sum(axis=1) @ tri.volumes / ((exact**2).sum(axis=1) @ tri.volumes))
expected = (tri.volumes * np.hypot(1, np.hypot(*exact.T))).sum()
print(f"points and triangles:         {len(points):,} and {len(tri.simplices):,}")
print(f"sum of the areas:             {tri.volumes.sum() / 1e6:.6f} square kilometres")
print(f"area of the surface:          {surface / 1e6:.3f} square kilometres")
print(f"difference to the true area:  {surface / expected - 1:+.3%}")
print(f"error of the gradients:       {error:.1%}")
print(f"area steeper than 20 degrees: {tri.volumes[slopes > np.tan(np.radians(20))].sum() / side**2:.1%}")

assert abs(tri.volumes.sum() / side**2 - 1) < 1e-12
assert abs(surface / expected - 1) < 1e-3
assert error < 0.1

# Light from the north-west, 45 degrees above the horizon, on the normal of each triangle.
normals = np.concatenate([-gradients, np.ones((len(gradients), 1))], axis=1) / np.hypot(1, slopes)[:, None]
shade = np.clip(normals @ np.array([-0.5, 0.5, np.sqrt(0.5)]), 0, 1)

triangulation = Triangulation(points[:, 0] / 1000, points[:, 1] / 1000, tri.simplices)
figure, axes = plt.subplots(figsize=(6.4, 5.6), layout="constrained")
axes.tripcolor(triangulation, shade, cmap=plt.get_cmap("gray", 12), vmin=0.3, vmax=1)
lines = axes.tricontour(triangulation, heights, levels=12, cmap="autumn", linewidths=0.9)
axes.clabel(lines, fontsize=7, fmt="%d m")
axes.set(aspect="equal", xlabel="km", ylabel="km", title="hillshade and contour lines")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "terrain.png", dpi=100)
