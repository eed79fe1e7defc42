"""Equality with scipy.spatial."""

from __future__ import annotations

import numpy as np
import pytest
import septet
from conftest import rows_of
from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator
from scipy.spatial import ConvexHull
from scipy.spatial import Delaunay as Scipy
from scipy.spatial import Voronoi as ScipyVoronoi
from scipy.spatial import cKDTree


def test_simplices(cloud: np.ndarray) -> None:
    assert rows_of(septet.Delaunay(cloud).simplices) == rows_of(Scipy(cloud).simplices)


def test_neighbors_are_opposite_and_mutual(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    simplices, neighbors = tri.simplices, tri.neighbors
    for k in range(tri.ndim + 1):
        inner = np.flatnonzero(neighbors[:, k] >= 0)
        other = neighbors[inner, k]
        facet = np.delete(simplices[inner], k, axis=1)
        assert all(set(f) <= set(s) for f, s in zip(facet.tolist(), simplices[other].tolist()))
        assert (neighbors[other] == inner[:, None]).any(axis=1).all()
    assert (neighbors == -1).sum() == len(tri.convex_hull)


def test_convex_hull(cloud: np.ndarray) -> None:
    tri = septet.Delaunay(cloud)
    assert rows_of(tri.convex_hull) == rows_of(ConvexHull(cloud).simplices)
    corners = cloud[tri.convex_hull]
    middle = cloud.mean(axis=0)
    if tri.ndim == 2:
        # Counter-clockwise: the middle is to the left of each edge.
        (u, v) = (corners[:, 1] - corners[:, 0], middle - corners[:, 0])
        assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0).all()
    else:
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert ((normals * (middle - corners[:, 0])).sum(axis=1) < 0).all()


def test_vertices(cloud: np.ndarray) -> None:
    tri, other = septet.Delaunay(cloud), Scipy(cloud)
    indptr, indices = tri.vertex_neighbor_vertices
    ours = [sorted(indices[indptr[v] : indptr[v + 1]].tolist()) for v in range(len(cloud))]
    indptr, indices = other.vertex_neighbor_vertices
    assert ours == [sorted(indices[indptr[v] : indptr[v + 1]].tolist()) for v in range(len(cloud))]
    first = tri.vertex_to_simplex
    assert (tri.simplices[first] == np.arange(len(cloud))[:, None]).any(axis=1).all()
    smallest = [int(np.flatnonzero((tri.simplices == v).any(axis=1))[0]) for v in range(50)]
    assert first[:50].tolist() == smallest


def test_find_simplex(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri, other = septet.Delaunay(cloud), Scipy(cloud)
    x = rng.random((5000, tri.ndim)) * 1.2 - 0.1
    ours, theirs = tri.find_simplex(x), other.find_simplex(x)
    assert ((ours < 0) == (theirs < 0)).all()
    inside = ours >= 0
    assert 1000 < inside.sum() < 5000
    rows, expected = np.sort(tri.simplices[ours[inside]], axis=1), np.sort(other.simplices[theirs[inside]], axis=1)
    assert (rows == expected).all()
    assert tri.find_simplex(x.reshape(50, 100, -1)).tolist() == ours.reshape(50, 100).tolist()
    assert tri.find_simplex(x[0]).shape == () and int(tri.find_simplex(x[0])) == ours[0]
    with pytest.raises(ValueError):
        tri.find_simplex(x[:, :1])


def test_transform_and_circumcenters(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri, d = septet.Delaunay(cloud), cloud.shape[1]
    x = rng.random((300, d)) * 0.8 + 0.1
    at = tri.find_simplex(x)
    transform = tri.transform[at]
    c = np.einsum("ijk,ik->ij", transform[:, :d], x - transform[:, d])
    expected = np.concatenate([c, 1 - c.sum(axis=1, keepdims=True)], axis=1)
    simplex, coordinates = tri.barycentric(x)
    assert (simplex == at).all() and np.abs(coordinates - expected).max() < 1e-8
    vertices = ScipyVoronoi(cloud).vertices
    gap = cKDTree(vertices).query(tri.circumcenters)[0]
    assert (gap < 1e-6 * np.maximum(1, tri.circumradii)).all()


def test_nearest_vertex(cloud: np.ndarray, rng: np.random.Generator) -> None:
    x = rng.random((3000, cloud.shape[1])) * 3 - 1
    assert (septet.Delaunay(cloud).nearest_vertex(x) == cKDTree(cloud).query(x)[1]).all()


def test_volumes_fill_the_hull(cloud: np.ndarray) -> None:
    volumes = septet.Delaunay(cloud).volumes
    assert (volumes > 0).all() and abs(volumes.sum() / ConvexHull(cloud).volume - 1) < 1e-13


def test_linear_interpolation(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(cloud)
    x, values = rng.random((2000, tri.ndim)), rng.random((len(cloud), 4))
    ours, theirs = tri.interpolate(values, x), LinearNDInterpolator(Scipy(cloud), values)(x)
    assert (np.isnan(ours) == np.isnan(theirs)).all() and np.nanmax(np.abs(ours - theirs)) < 1e-9


def test_to_scipy(cloud: np.ndarray, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(cloud)
    other = tri.to_scipy()
    assert isinstance(other, Scipy) and (other.simplices == tri.simplices).all()
    x, values = rng.random((1000, tri.ndim)), np.sin(5 * cloud[:, 0])
    assert (other.find_simplex(x) == tri.find_simplex(x)).all()
    ours, theirs = LinearNDInterpolator(other, values)(x), LinearNDInterpolator(Scipy(cloud), values)(x)
    assert (np.isnan(ours) == np.isnan(theirs)).all() and np.nanmax(np.abs(ours - theirs)) < 1e-9
    if tri.ndim == 2:
        inner = x[((x > 0.1) & (x < 0.9)).all(axis=1)]
        smooth = CloughTocher2DInterpolator(other, values)(inner)
        assert np.abs(smooth - CloughTocher2DInterpolator(Scipy(cloud), values)(inner)).max() < 1e-4
    assert other.convex_hull.shape == tri.convex_hull.shape
    other.simplices[0] = 0
    assert (tri.simplices[0] != 0).any()
