"""Checks cells in exact integer arithmetic, with nothing but Python's integers.

Usage: exact_check.py DIMENSION POINTS CELLS

Every cell is positive, no point lies inside its sphere, the facets that belong to one cell have all points on
one side, every other facet belongs to two cells, all points are vertices or coincide with one, and the cells
fill the hull's volume, which Qhull measures by itself.
"""

import sys
from collections import Counter

import numpy as np
from scipy.spatial import ConvexHull


def integers(values):
    """The numbers times a power of two that makes them whole."""
    ratios = [float(v).as_integer_ratio() for v in values.ravel()]
    scale = max(q for _, q in ratios)
    return np.array([p * (scale // q) for p, q in ratios], dtype=object).reshape(values.shape), scale


def determinant(m):
    if len(m) == 1:
        return m[0][0]
    minors = ([row[:i] + row[i + 1 :] for row in m[1:]] for i in range(len(m)))
    return sum((-1) ** i * m[0][i] * determinant(minor) for i, minor in enumerate(minors))


def normal(vectors):
    """Coefficients n with n . q = det(vectors.., q)."""
    d = len(vectors) + 1
    columns = ([v[:i] + v[i + 1 :] for v in vectors] for i in range(d))
    return [(-1) ** (d - 1 + i) * determinant(c) for i, c in enumerate(columns)]


def side(vectors, offset):
    """det(vectors.., q) for every row q of an array of integers."""
    return sum(n * offset[:, i] for i, n in enumerate(normal(vectors)))


def main():
    d = int(sys.argv[1])
    rough = np.fromfile(sys.argv[2], "<f8").reshape(-1, d)
    cells = np.fromfile(sys.argv[3], "<i8").reshape(-1, d + 1).tolist()
    points, scale = integers(rough)
    norms = (points * points).sum(axis=1)
    lifted = np.column_stack([points, norms])

    volume, facets = 0, Counter()
    for cell in cells:
        base = points[cell[0]]
        edges = [(points[v] - base).tolist() for v in cell[1:]]
        size = determinant(edges)
        assert size > 0, f"cell {cell} is not positive"
        volume += size
        # The lifted points below the cell's hyperplane are those inside its sphere.
        shifted = lifted - lifted[cell[0]]
        below = side([shifted[v].tolist() for v in cell[1:]], shifted)
        assert not np.any(below < 0), f"the sphere of {cell} is not empty"
        for i in range(d + 1):
            facets[tuple(sorted(cell[:i] + cell[i + 1 :]))] += 1
    assert max(facets.values()) <= 2, "a facet in three cells"
    for facet, count in facets.items():
        if count == 1:
            shifted = points - points[facet[0]]
            sides = side([shifted[v].tolist() for v in facet[1:]], shifted)
            assert np.all(sides >= 0) or np.all(sides <= 0), f"{facet} is not on the hull"
    vertices = {v for cell in cells for v in cell}
    places = {tuple(points[v]) for v in vertices}
    assert len(places) == len(vertices), "coincident vertices"
    assert all(tuple(p) in places for p in points), "a point is no vertex"
    measured = volume / scale**d / (2 if d == 2 else 6)
    expected = ConvexHull(rough).volume
    assert abs(measured / expected - 1) < 1e-9, f"volume {measured}, the hull has {expected}"
    print(f"ok {len(cells)} cells, volume {measured}")


main()
