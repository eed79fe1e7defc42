"""Checks that a mesh fills its domain and measures its quality, for all programs, with NumPy only."""
import numpy as np

BLOCK = 200_000


class Wrong(Exception):
    """The mesh does not fill its domain."""


def check(points, cells, volume, area):
    """Checks that cells have a volume, that facets have one or two cells, and that volume and boundary equal those of the domain to 1e-9.

    Returns the cells with positive orientation."""
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    sizes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6
    cells = cells.copy()
    turned = sizes < 0
    cells[turned, 2], cells[turned, 3] = cells[turned, 3].copy(), cells[turned, 2].copy()
    if turned.any() and not turned.all():
        raise Wrong(f"{turned.sum()} cells are turned over")
    sizes = np.abs(sizes)
    if not sizes.min() > 0:
        raise Wrong("a cell has no volume")
    if abs(sizes.sum() - volume) > 1e-9 * volume:
        raise Wrong(f"volume {sizes.sum()!r} in place of {volume}")
    facets = np.sort(np.concatenate([np.delete(cells, i, axis=1) for i in range(4)]), axis=1)
    keys = (facets[:, 0] * len(points) + facets[:, 1]) * len(points) + facets[:, 2]
    _, first, counts = np.unique(keys, return_index=True, return_counts=True)
    if counts.max() > 2:
        raise Wrong("a facet has three cells")
    border = points[facets[first[counts == 1]]]
    normals = np.cross(border[:, 1] - border[:, 0], border[:, 2] - border[:, 0])
    found = np.linalg.norm(normals, axis=1).sum() / 2
    if abs(found - area) > 1e-9 * area:
        raise Wrong(f"boundary {found!r} in place of {area}")
    return cells


def measure(points, cells):
    """Returns percentiles of radius-edge ratios, and the ends of the histogram of dihedral angles, in degrees."""
    parts = [block(points, cells[i:i + BLOCK]) for i in range(0, len(cells), BLOCK)]
    ratios, least, most = (np.concatenate(column) for column in zip(*parts))
    return {
        "cells": len(cells),
        "points": len(np.unique(cells)),
        "ratio_median": float(np.median(ratios)),
        "ratio_99": float(np.percentile(ratios, 99)),
        "ratio_most": float(ratios.max()),
        "angle_least": float(least.min()),
        "angle_1": float(np.percentile(least, 1)),
        "below_10": int((least < 10).sum()),
        "below_14": int((least < 14).sum()),
        "angle_most": float(most.max()),
    }


def block(points, cells):
    p = points[cells]
    a, u, v, w = p[:, 0], p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], p[:, 3] - p[:, 0]
    square = lambda x: np.einsum("ij,ij->i", x, x)[:, None]
    six = np.einsum("ij,ij->i", u, np.cross(v, w))[:, None]
    centre = (square(u) * np.cross(v, w) + square(v) * np.cross(w, u) + square(w) * np.cross(u, v)) / (2 * six)
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    shortest = np.min([np.linalg.norm(p[:, j] - p[:, i], axis=1) for i, j in pairs], axis=0)
    ratio = np.linalg.norm(centre, axis=1) / shortest
    angles = []
    for i, j in pairs:
        k, l = (m for m in range(4) if m not in (i, j))
        edge = p[:, j] - p[:, i]
        m, n = np.cross(edge, p[:, k] - p[:, i]), np.cross(edge, p[:, l] - p[:, i])
        # The angle between the two half-planes at the edge.
        sine = np.linalg.norm(np.cross(m, n), axis=1)
        angles.append(np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", m, n))))
    return ratio, np.min(angles, axis=0), np.max(angles, axis=0)
