"""Alpha complexes: values are those of gudhi."""

from __future__ import annotations

from typing import Any, Dict, Tuple

import gudhi
import numpy as np
import pytest
import septet
from conftest import grid


def values_of(points: Any) -> Dict[Tuple[int, ...], float]:
    """The values of all simplices by gudhi."""
    tree = gudhi.AlphaComplex(points=points.tolist(), precision="exact").create_simplex_tree()
    return {tuple(sorted(simplex)): value for simplex, value in tree.get_filtration()}


def test_values_are_those_of_gudhi(cloud: np.ndarray) -> None:
    points = cloud[:300]
    tri, expected = septet.Delaunay(points), values_of(points)
    found = tri.alpha_filtration()
    faces = [(tri.simplices, found.cells), (found.facets, found.facet_values), (found.edges, found.edge_values)]
    count = len(points)
    for rows, values in faces if tri.ndim == 3 else faces[:2]:
        assert len(rows) == len(values)
        count += len(rows)
        for row, value in zip(np.sort(rows, axis=1).tolist(), values):
            assert abs(value - expected[tuple(row)]) <= 1e-9 * expected[tuple(row)], row
    assert count == len(expected)
    if tri.ndim == 2:
        assert (found.edges == found.facets).all() and (found.edge_values == found.facet_values).all()


def test_faces_have_no_larger_values(ndim: int) -> None:
    tri = septet.Delaunay(grid(4, ndim))
    found = tri.alpha_filtration()
    value = {tuple(row): v for row, v in zip(found.facets.tolist(), found.facet_values)}
    for row, cell in zip(np.sort(tri.simplices, axis=1).tolist(), found.cells):
        for k in range(ndim + 1):
            assert value[tuple(row[:k] + row[k + 1 :])] <= cell


@pytest.mark.parametrize("radius", [0.0, 0.03, 0.08, 0.2, 10.0])
def test_shape_of_a_radius(cloud: np.ndarray, radius: float) -> None:
    tri = septet.Delaunay(cloud)
    found, shape = tri.alpha_filtration(), tri.alpha_shape(radius)
    assert shape.cells.dtype == np.bool_ and (shape.cells == (found.cells <= radius**2)).all()
    assert abs(shape.volume - tri.volumes[shape.cells].sum()) < 1e-12
    # Facets between a simplex of the complex and the rest.
    inside = np.concatenate([shape.cells, [False]])
    ends = {tuple(sorted(np.delete(row, k).tolist())) for row, near, is_in in zip(tri.simplices, tri.neighbors, shape.cells)
            for k in range(tri.ndim + 1) if is_in and not inside[near[k]]}
    assert {tuple(sorted(row)) for row in shape.boundary.tolist()} == ends and len(shape.boundary) == len(ends)
    of_cells = {tuple(sorted(np.delete(row, k).tolist())) for row in tri.simplices[shape.cells] for k in range(tri.ndim + 1)}
    alone = {tuple(row) for row, v in zip(found.facets.tolist(), found.facet_values) if v <= radius**2} - of_cells
    assert {tuple(sorted(row)) for row in shape.singular.tolist()} == alone


def test_boundary_is_oriented_outward(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    shape = tri.alpha_shape(0.15)
    corners = tri.points[shape.boundary]
    # By the theorem of Gauss, the boundary encloses the volume with the right sign.
    if tri.ndim == 2:
        enclosed = 0.5 * (corners[:, 0, 0] * corners[:, 1, 1] - corners[:, 0, 1] * corners[:, 1, 0]).sum()
    else:
        enclosed = np.linalg.det(corners).sum() / 6
    assert abs(enclosed - shape.volume) < 1e-12 and shape.volume > 0.3


def test_radius_is_checked() -> None:
    tri = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    for radius in [-1.0, float("nan"), "wide"]:
        with pytest.raises(septet.OptionError):
            tri.alpha_shape(radius)  # type: ignore[arg-type]
