"""Estimates the density of galaxies from the volumes of their Voronoi cells.

Usage: python src/guide/gallery/galaxies.py [OUTPUT.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import septet

# A catalogue in the unit cube: clusters of galaxies with Gaussian profiles, and a uniform background.
rng = np.random.default_rng(3)
clusters, members, background = 40, 300, 8_000
centres = rng.uniform(0.1, 0.9, (clusters, 3))
radii = rng.uniform(0.012, 0.03, clusters)
offsets = rng.normal(size=(clusters, members, 3)) * radii[:, None, None]
catalogue = np.concatenate([(centres[:, None] + offsets).reshape(-1, 3), rng.random((background, 3))])

# Galaxies per unit of volume: one over the volume of each cell.
cells = septet.Voronoi(catalogue, box=(np.zeros(3), np.ones(3)))
density = 1 / cells.volumes

# The density of the model at each galaxy.
squared = ((catalogue[:, None] - centres) ** 2).sum(axis=2) / radii**2
model = background + members * (np.exp(-squared / 2) / (np.sqrt(2 * np.pi) * radii) ** 3).sum(axis=1)
ratio = density / model
low, middle, high = np.quantile(ratio, [0.16, 0.5, 0.84])

# Half of the galaxies are in the densest cells. These fill a small part of the box.
order = np.argsort(-density)
half = cells.volumes[order[: len(catalogue) // 2]].sum()
print(f"galaxies:                          {len(catalogue):,}")
print(f"sum of the volumes:                {cells.volumes.sum():.12f}")
print(f"estimate over model, median:       {middle:.2f}")
print(f"estimate over model, 68 % are in:  {low:.2f} to {high:.2f}")
print(f"largest over mean density:         {density.max() / len(catalogue):.0f}")
print(f"volume of half of the galaxies:    {half:.1%}")

assert abs(cells.volumes.sum() - 1) < 1e-12
assert 0.9 < middle < 1.1 and 0.5 < low < high < 2
assert half < 0.05

# A slice: each pixel has the density of the cell that contains it.
axis = (np.arange(320) + 0.5) / 320
height = float(np.median(centres[:, 2]))
pixels = np.stack([*np.meshgrid(axis, axis), np.full((320, 320), height)], axis=-1)
galaxy = cells.delaunay.nearest_vertex(pixels)
near = catalogue[np.abs(catalogue[:, 2] - height) < 0.02]

figure, axes = plt.subplots(1, 2, figsize=(6.4, 3.5), layout="constrained", sharey=True)
axes[0].plot(near[:, 0], near[:, 1], "k.", markersize=1)
axes[0].set(title="galaxies near the slice", xlim=(0, 1), ylim=(0, 1), aspect="equal")
shown = axes[1].imshow(np.log10(density[galaxy]), origin="lower", extent=(0, 1, 0, 1), cmap=plt.get_cmap("magma", 12))
axes[1].set(title="density in the slice")
figure.colorbar(shown, ax=axes, location="bottom", aspect=50, shrink=0.6, label="log10 of galaxies per unit of volume")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "galaxies.png", dpi=100)
