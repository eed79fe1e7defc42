"""Weights and periodic boxes against their definitions in fractions, the program, and brute force."""

from __future__ import annotations

import itertools
import json
import pickle
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest
import septet

from conftest import grid

Row = Tuple[int, ...]


def determinant(m: List[List[Fraction]]) -> Fraction:
    if len(m) == 1:
        return m[0][0]
    return sum(((-1) ** j * m[0][j] * determinant([r[:j] + r[j + 1:] for r in m[1:]]) for j in range(len(m))), Fraction(0))


def exact(points: Any) -> List[List[Fraction]]:
    return [[Fraction(x) for x in row] for row in np.asarray(points, dtype=float).tolist()]


def lifted(points: List[List[Fraction]], weights: List[Fraction]) -> List[List[Fraction]]:
    return [row + [sum((x * x for x in row), Fraction(0)) - w] for row, w in zip(points, weights)]


def height_above(lifts: List[List[Fraction]], cell: Any, v: int) -> int:
    """The sign of the height of a lift above the hyperplane through those of a positively oriented cell."""
    base = lifts[cell[0]]
    rows = [[x - b for x, b in zip(lifts[u], base)] for u in [*cell[1:], v]]
    flat = determinant([row[:-1] for row in rows[:-1]])
    above = determinant(rows)
    return (above > 0) - (above < 0) if flat > 0 else (above < 0) - (above > 0)


def volume(points: List[List[Fraction]]) -> Fraction:
    rows = [[x - b for x, b in zip(p, points[0])] for p in points[1:]]
    return determinant(rows) / (2 if len(rows) == 2 else 6)


def is_lower_hull(points: Any, weights: Any, tri: septet.Delaunay) -> None:
    """Each lift is on or above the hyperplane of each cell, the cells fill the hull, and others are strictly above."""
    at = exact(points)
    lifts = lifted(at, [Fraction(w) for w in np.asarray(weights, dtype=float).tolist()])
    used = set(np.unique(tri.simplices).tolist())
    assert not used & set(tri.hidden.tolist())
    for cell in tri.simplices.tolist():
        assert volume([at[v] for v in cell]) > 0
        assert all(height_above(lifts, cell, v) >= 0 for v in range(len(at)) if v not in cell)
    total = sum((volume([at[v] for v in cell]) for cell in tri.simplices.tolist()), Fraction(0))
    assert total == sum((volume([at[v] for v in cell]) for cell in septet.Delaunay(points).simplices.tolist()), Fraction(0))
    for v in tri.hidden.tolist():
        # Strictly above the cell that contains it, or under a heavier one at its place.
        cell = tri.simplices[tri.find_simplex(tri.points[v])].tolist()
        assert height_above(lifts, cell, v) > 0
    others = set(range(len(at))) - used - set(tri.hidden.tolist())
    assert others == set(tri.duplicates[:, 0].tolist())


@pytest.mark.parametrize("kind", ["random", "ties", "equal", "duplicates"])
def test_weights_give_the_lower_hull(ndim: int, rng: np.random.Generator, kind: str) -> None:
    points = rng.random((25 if ndim == 2 else 16, ndim))
    weights = rng.random(len(points)) * 0.3 - 0.1
    if kind == "ties":
        points = grid(5 if ndim == 2 else 3, ndim)
        weights = rng.integers(0, 2, len(points)).astype(float)
    elif kind == "equal":
        weights = np.full(len(points), 2.5)
    elif kind == "duplicates":
        points[5], weights[5] = points[2], weights[2]
        points[7], weights[7] = points[3], weights[3] + 1
    tri = septet.Delaunay(points, weights=weights)
    is_lower_hull(points, weights, tri)
    if kind == "equal":
        assert (tri.simplices == septet.Delaunay(points).simplices).all() and len(tri.hidden) == 0
    if kind == "duplicates":
        assert tri.duplicates.tolist() == [[5, 2]] or 2 in tri.hidden
        assert 3 in tri.hidden


Image = Tuple[int, Row]


def moved(cell: Any) -> Tuple[Image, ...]:
    """The member of a class of translated cells whose least vertex has the offset 0."""
    vertices = sorted((int(v), tuple(int(k) for k in step)) for v, step in cell)
    base = vertices[0][1]
    return tuple((v, tuple(a - b for a, b in zip(step, base))) for v, step in vertices)


def neighbors_share_facets(tri: septet.Delaunay) -> None:
    """Each class of translated facets belongs to two simplices, which are neighbours across it."""
    facets: Dict[Any, List[Tuple[int, int]]] = {}
    for i, (cell, step) in enumerate(zip(tri.simplices.tolist(), tri.offsets.tolist())):
        for k in range(len(cell)):
            rest = [(v, s) for j, (v, s) in enumerate(zip(cell, step)) if j != k]
            facets.setdefault(moved(rest), []).append((i, k))
    for slots in facets.values():
        (a, i), (b, j) = slots
        assert tri.neighbors[a, i] == b and tri.neighbors[b, j] == a


def is_periodic_hull(points: Any, period: Any, weights: Any, tri: septet.Delaunay) -> None:
    """Cells lie below the lifts of all 3^d images around them, and fill the box once."""
    lengths = [Fraction(x) for x in period]
    at, w = exact(points), [Fraction(x) for x in np.asarray(weights, dtype=float).tolist()]
    ndim = len(lengths)

    def place(v: int, step: Any) -> List[Fraction]:
        return [x + int(k) * length for x, k, length in zip(at[v], step, lengths)]

    images = [(v, step) for v in range(len(at)) for step in itertools.product(range(-2, 3), repeat=ndim)]
    total, classes = Fraction(0), set()
    for cell, steps in zip(tri.simplices.tolist(), tri.offsets.tolist()):
        assert steps[0] == [0] * ndim
        corners = [place(v, step) for v, step in zip(cell, steps)]
        total += volume(corners)
        assert volume(corners) > 0
        classes.add(moved(zip(cell, steps)))
        lifts = lifted(corners, [w[v] for v in cell])
        for v, step in images:
            lifts.append(lifted([place(v, step)], [w[v]])[0])
            assert height_above(lifts, range(ndim + 1), ndim + 1) >= 0
            lifts.pop()
    assert len(classes) == len(tri.simplices)
    neighbors_share_facets(tri)
    box = Fraction(1)
    for length in lengths:
        box *= length
    assert total == box


@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize("with_weights", [False, True])
def test_boxes_hold_all_images(ndim: int, rng: np.random.Generator, n: int, with_weights: bool) -> None:
    n = n if ndim == 2 else min(n, 4)
    period = [1.0, 0.75, 1.25][:ndim]
    points = np.round(rng.random((n, ndim)) * period, 3)
    weights = np.round(rng.random(n) * 0.05, 3) if with_weights else np.zeros(n)
    tri = septet.Delaunay(points, period=period, weights=weights if with_weights else None)
    is_periodic_hull(points, period, weights, tri)
    assert tri.offsets.dtype == np.int32 and tri.offsets.shape == tri.simplices.shape + (ndim,)
    assert tri.dimension == ndim and not tri.offsets.flags.writeable


def test_ties_in_a_box(ndim: int) -> None:
    points = grid(2, ndim)
    is_periodic_hull(points, [2.0] * ndim, np.zeros(len(points)), septet.Delaunay(points, period=2))


def test_neighbors_in_a_box_share_facets(ndim: int, rng: np.random.Generator) -> None:
    tri = septet.Delaunay(rng.random((40, ndim)), period=1)
    neighbors_share_facets(tri)
    assert abs(tri.volumes.sum() - 1) < 1e-12 and (tri.volumes > 0).all()
    assert (tri.vertex_to_simplex >= 0).all()


def test_boxes_that_are_open_along_an_axis(ndim: int, rng: np.random.Generator) -> None:
    points = rng.random((60, ndim))
    period: List[Any] = [1.0] + [None] * (ndim - 1)
    tri = septet.Delaunay(points, period=period)
    assert (tri.offsets[:, :, 1:] == 0).all() and (tri.neighbors == -1).any()
    assert septet.verify(points, tri.simplices, period=period, offsets=tri.offsets).ok
    box = ([0.0] * ndim, [1.0] * ndim)
    assert abs(septet.Voronoi(tri, box=box).volumes.sum() - 1) < 1e-12
    with pytest.raises(septet.OptionError, match=r"box=\(low, high\)"):
        septet.Voronoi(tri)
    same = septet.Delaunay(points, period=[1.0] + [np.inf] * (ndim - 1))
    assert (same.simplices == tri.simplices).all() and (same.offsets == tri.offsets).all()


def test_vertices_with_a_whole_period(ndim: int, rng: np.random.Generator) -> None:
    points = rng.integers(0, 200, (12, ndim)).astype(float)
    points[1:4] += [[200], [-400], [30000]]
    tri = septet.Delaunay(points, period=200, wrap=True)
    assert tri.offsets.dtype == np.int32
    corners = tri.points[tri.simplices] + tri.offsets * 200
    sides = corners[:, 1:] - corners[:, :1]
    assert abs(sides).max() <= 800
    volumes = np.linalg.det(sides) / (2 if ndim == 2 else 6)
    assert (volumes > 0).all() and abs(volumes.sum() / 200**ndim - 1) < 1e-12
    assert np.allclose(tri.volumes, volumes, rtol=1e-9, atol=1e-6)


def test_far_points_share_the_box(ndim: int) -> None:
    row = np.full((3, ndim), 0.5)
    row[:, 0] = [0.1, 1e6 + 0.4, 0.85]
    cells = septet.Voronoi(row, period=1, wrap=True)
    assert abs(cells.volumes.sum() - 1) < 1e-12
    middle = row[1, 0] - 1e6
    assert np.allclose(cells.volumes, [(middle + 0.15) / 2, 0.375, (1.1 - middle) / 2], rtol=0, atol=1e-13)
    assert abs(cells.centroids[1, 0] - 1e6 - 0.4375) < 1e-9
    assert abs(cells.delaunay.volumes.sum() - 1) < 1e-14
    assert repr(cells).endswith("in a periodic box>")


def test_duplicates_of_hidden_points(ndim: int) -> None:
    corners = np.vstack([np.zeros(ndim), 4 * np.eye(ndim)])
    points = np.vstack([corners, np.full((3, ndim), 0.5), corners[:1]])
    weights = np.array([1.0] * (ndim + 1) + [-9.0, -9.0, -10.0] + [1.0])
    n = len(corners)
    tri = septet.Delaunay(points, weights=weights)
    assert tri.hidden.tolist() == [n, n + 2] and tri.duplicates.tolist() == [[n + 1, n], [n + 3, 0]]
    assert tri.vertex_to_simplex[n:].tolist() == [-1, -1, -1, 0]
    assert tri.coplanar.tolist() == [[n + 1, -1, -1], [n + 3, 0, 0]]
    cells = septet.Voronoi(tri, box=([-1] * ndim, [5] * ndim))
    assert cells.point_region.tolist() == [*range(n), -1, -1, -1, 0]
    assert septet.verify(points, tri.simplices, weights=weights).ok


def test_simplicial_boxes(rng: np.random.Generator) -> None:
    few, many = septet.Delaunay([[0.5, 0.5]], period=1), septet.Delaunay(rng.random((300, 2)), period=1)
    assert not few.simplicial and few.sheets == (3, 3)
    assert many.simplicial and many.sheets == (1, 1)
    plain = septet.Delaunay([[0, 0], [1, 0], [0, 1]])
    assert plain.simplicial and plain.sheets is None and plain.offsets is None and len(plain.hidden) == 0


def program() -> str:
    found = shutil.which("septet", path=str(Path(sys.executable).parent))
    assert found, "the wheel has the program"
    return found


@pytest.mark.parametrize("case", ["weights", "box", "both"])
def test_arrays_are_those_of_the_program(ndim: int, rng: np.random.Generator, tmp_path: Path, case: str) -> None:
    points, weights = rng.random((500, ndim)), rng.random(500) * 0.01
    np.save(tmp_path / "p.npy", points)
    np.save(tmp_path / "w.npy", weights)
    options: Dict[str, Any] = {}
    command = [program(), "triangulate", "p.npy", "-o", "cells.npy", "--quiet"]
    if case != "box":
        options["weights"] = weights
        command += ["--weights", "w.npy", "--hidden", "hidden.csv"]
    if case != "weights":
        options["period"], options["origin"] = [1.5] * ndim, [-0.25] * ndim
        command += ["--periodic", ",".join(["1.5"] * ndim), "--origin=" + ",".join(["-0.25"] * ndim)]
        command += ["--offsets", "offsets.npy"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=120)
    tri = septet.Delaunay(points, **options)
    assert (tri.simplices == np.load(tmp_path / "cells.npy")).all()
    if case != "box":
        rows = [int(line) for line in (tmp_path / "hidden.csv").read_text().split() if line.isdigit()]
        assert tri.hidden.tolist() == rows and rows
    if case != "weights":
        assert (tri.offsets == np.load(tmp_path / "offsets.npy").reshape(tri.offsets.shape)).all()
    run = septet.simulate(points, workers=4, **options)
    command[1] = "simulate"
    subprocess.run(command + ["--workers", "4", "--json", "run.json"], cwd=tmp_path, check=True, timeout=120)
    theirs = json.loads((tmp_path / "run.json").read_text())
    for part in ("points", "phases", "periodic"):
        ours = run.report.get(part)
        drop = lambda rows: [{k: v for k, v in row.items() if "seconds" not in k} for row in rows]
        assert (drop(ours) == drop(theirs[part])) if part == "phases" else ours == theirs.get(part)
    assert (run.delaunay.simplices == tri.simplices).all()
    if case == "weights":
        box = ",".join(["-0.5"] * ndim + ["1.5"] * ndim)
        asked, cells = ["--weights", "w.npy", "--box=" + box], septet.Voronoi(tri, box=([-0.5] * ndim, [1.5] * ndim))
    else:
        asked, cells = command[-4:], septet.Voronoi(tri)
        asked = [word for word in command if word.startswith("--origin")] + ["--periodic", ",".join(["1.5"] * ndim)]
        asked += ["--weights", "w.npy"] if case == "both" else []
    subprocess.run([program(), "voronoi", "p.npy", *asked, "-o", "v.csv"], cwd=tmp_path, check=True, timeout=120)
    volumes = [float(line.split(",")[1]) for line in (tmp_path / "v.csv").read_text().split()[1:]]
    assert np.allclose(cells.volumes, volumes, rtol=1e-13, atol=0)


@pytest.mark.parametrize("case", ["weights", "box", "both"])
def test_power_cells(ndim: int, rng: np.random.Generator, case: str) -> None:
    points = rng.random((80, ndim))
    options: Dict[str, Any] = {}
    corners = None
    if case != "box":
        options["weights"] = rng.random(80) * 0.05
    if case == "weights":
        corners = (np.zeros(ndim), np.ones(ndim))
    else:
        options["period"] = 1
    cells = septet.Voronoi(points, box=corners, **options)
    hidden = cells.delaunay.hidden
    assert abs(cells.volumes.sum() - 1) < 1e-12
    assert (cells.volumes[hidden] == 0).all() and (cells.point_region[hidden] == -1).all()
    assert len(cells.regions) == 80 and len(cells.regions.values) == len(cells.vertices)
    # Each place belongs to the site with the least power, also at its images.
    weights = options.get("weights", np.zeros(80))
    shifts = [0] if case == "weights" else [-1, 0, 1]
    steps = np.array(list(itertools.product(shifts, repeat=ndim)), dtype=float)
    for v in range(80):
        rows = cells.regions[v]
        if len(rows) == 0:
            assert np.isnan(cells.centroids[v]).all()
            continue
        places = np.vstack([cells.vertices[rows], cells.centroids[v]])
        own = ((places - points[v]) ** 2).sum(axis=1) - weights[v]
        for step in steps:
            others = ((places[:, None] - (points + step)) ** 2).sum(axis=2) - weights
            assert (own[:, None] <= others + 1e-9).all()
    for name in ("ridge_points", "ridge_vertices", "ridge_areas"):
        with pytest.raises(septet.OptionError, match="septet.Voronoi"):
            getattr(cells, name)
    copy = pickle.loads(pickle.dumps(cells))
    assert (copy.volumes == cells.volumes).all() and (copy.vertices == cells.vertices).all()


def test_queries_without_meaning_name_those_that_have_one(cloud: np.ndarray) -> None:
    q, values = cloud[:3] * 0.9, np.zeros(len(cloud))
    heavy = septet.Delaunay(cloud, weights=np.linspace(0, 1e-4, len(cloud)))
    assert (heavy.find_simplex(cloud) >= 0).all()
    assert abs(heavy.interpolate(cloud[:, 0], q) - q[:, 0]).max() < 1e-9
    assert heavy.gradients(values).shape == (len(heavy.simplices), heavy.ndim)
    assert abs(heavy.volumes.sum() / septet.Delaunay(cloud).volumes.sum() - 1) < 1e-12
    calls: Dict[str, Any] = {
        "nearest_vertex": lambda t: t.nearest_vertex(q),
        "sibson": lambda t: t.weights(q, "sibson"),
        "laplace": lambda t: t.interpolate(values, q, "laplace"),
        "alpha_shape": lambda t: t.alpha_shape(1.0),
        "alpha_filtration": lambda t: t.alpha_filtration(),
    }
    for name, call in calls.items():
        with pytest.raises(septet.OptionError, match=f"{name}.*with weights; use .*hidden, find_simplex"):
            call(heavy)
    box = septet.Delaunay(cloud, period=1)
    calls.update({
        "find_simplex": lambda t: t.find_simplex(q),
        "barycentric": lambda t: t.barycentric(q),
        "linear": lambda t: t.interpolate(values, q),
        "gradients": lambda t: t.gradients(values),
        "transform": lambda t: t.transform,
        "circumcenters": lambda t: t.circumcenters,
        "circumradii": lambda t: t.circumradii,
        "convex_hull": lambda t: t.convex_hull,
        "edges": lambda t: t.edges,
        "vertex_neighbor_vertices": lambda t: t.vertex_neighbor_vertices,
    })
    for name, call in calls.items():
        with pytest.raises(septet.OptionError, match=f"{name}.*in a periodic box; use simplices, neighbors, offsets, volumes"):
            call(box)
    for tri in (heavy, box):
        with pytest.raises(septet.OptionError, match="scipy"):
            tri.to_scipy()
    with pytest.raises(septet.OptionError, match=r"need a box; pass box=\(low, high\)"):
        septet.Voronoi(heavy)
    with pytest.raises(septet.OptionError, match=r"omit box=\(low, high\)"):
        septet.Voronoi(box, box=([0] * box.ndim, [1] * box.ndim))
    with pytest.raises(septet.OptionError, match="pass them to Delaunay"):
        septet.Voronoi(box, period=1)


def test_arguments_are_checked(cloud: np.ndarray) -> None:
    n, ndim = cloud.shape
    for wrong in (np.zeros(n - 1), np.zeros((n, 1)), 1.0, np.zeros((1, n))):
        with pytest.raises(ValueError, match=f"weights must have the shape \\({n},\\)"):
            septet.Delaunay(cloud, weights=wrong)
    for dtype in ("c16", "O", "U3"):
        with pytest.raises((TypeError, ValueError), match="weights"):
            septet.Delaunay(cloud, weights=np.zeros(n).astype(dtype))
    with pytest.raises(ValueError, match="weights has integers"):
        septet.Delaunay(cloud, weights=np.full(n, 2**53 + 1))
    for dtype in ("f2", "f4", "i4", "u1", "?", ">f8"):
        tri = septet.Delaunay(cloud, weights=np.ones(n, dtype=dtype))
        assert (tri.simplices == septet.Delaunay(cloud).simplices).all()
    for value in (np.nan, np.inf):
        weights = np.zeros(n)
        weights[17] = value
        with pytest.raises(septet.PointError, match="weight.*on_invalid") as caught:
            septet.Delaunay(cloud, weights=weights)
        assert caught.value.index == 17
        tri = septet.Delaunay(cloud, weights=weights, on_invalid="skip")
        assert tri.skipped.tolist() == [17] and 17 not in tri.simplices
        assert (tri.points == cloud).all()
    boxes: List[Any] = [0, -1, np.nan, [1] * (ndim + 1), [None] * ndim, None, "one"]
    for period in boxes[:-2]:
        with pytest.raises(septet.OptionError, match="period"):
            septet.Delaunay(cloud, period=period)
    with pytest.raises((TypeError, ValueError), match="period"):
        septet.Delaunay(cloud, period="one")  # type: ignore[arg-type]
    for options in ({"origin": [0] * ndim}, {"wrap": True}, {"period": 1, "origin": [0]}, {"period": 1, "wrap": 1}):
        with pytest.raises(septet.OptionError):
            septet.Delaunay(cloud, **options)
    far = cloud.copy()
    far[3, 0] += 1
    with pytest.raises(septet.PointError, match="origin=.*wrap=True") as caught:
        septet.Delaunay(far, period=1)
    assert caught.value.index == 3
    tri, near = septet.Delaunay(far, period=1, wrap=True), septet.Delaunay(cloud, period=1)
    assert len(tri.simplices) == len(near.simplices) and (tri.points == far).all()


def test_results_do_not_depend_on_threads(ndim: int, rng: np.random.Generator) -> None:
    points, weights = rng.random((3000, ndim)), rng.random(3000) * 1e-3
    for options in ({"weights": weights}, {"period": 1}, {"period": 1, "weights": weights}):
        a, b = (septet.Delaunay(points, threads=threads, **options) for threads in (1, 2))  # type: ignore[arg-type]
        for name in ("simplices", "neighbors", "hidden", "volumes", "vertex_to_simplex", "duplicates"):
            assert (getattr(a, name) == getattr(b, name)).all(), name
        assert a.offsets is b.offsets is None or (a.offsets == b.offsets).all()
        corners = None if "period" in options else ([0] * ndim, [1] * ndim)
        cells = [septet.Voronoi(t, box=corners, threads=threads) for t, threads in ((a, 1), (b, 2))]
        assert (cells[0].volumes == cells[1].volumes).all()
        assert np.array_equal(cells[0].centroids, cells[1].centroids, equal_nan=True)


def test_flat_sets(ndim: int) -> None:
    line = np.zeros((5, ndim))
    line[:, 0] = np.arange(5) / 10
    for points in (line, line[:1], line[:0]):
        tri = septet.Delaunay(points, weights=np.arange(len(points)))
        assert tri.simplices.shape == (0, ndim + 1) and tri.dimension < ndim
        assert tri.find_simplex(np.zeros(ndim)) == -1
        with pytest.raises(septet.Error):
            septet.Voronoi(tri, box=([-1] * ndim, [1] * ndim))
    empty = septet.Delaunay(line[:0], period=1)
    assert empty.simplices.shape == (0, ndim + 1) and empty.offsets.shape == (0, ndim + 1, ndim)
    assert empty.dimension == -1
    # The images of a point span the space.
    assert septet.Delaunay(line, period=1).dimension == ndim
    flat = septet.Delaunay(line, period=[1] + [None] * (ndim - 1))
    assert flat.simplices.shape == (0, ndim + 1) and flat.dimension == 1


@pytest.mark.parametrize("case", ["weights", "box", "both"])
def test_pickles(cloud: np.ndarray, case: str) -> None:
    options: Dict[str, Any] = {}
    if case != "box":
        options["weights"] = np.linspace(0, 0.01, len(cloud))
    if case != "weights":
        options.update(period=2, origin=[-0.5] * cloud.shape[1])
    tri = septet.Delaunay(cloud, **options)
    copy = pickle.loads(pickle.dumps(tri))
    for name in ("points", "simplices", "neighbors", "hidden"):
        assert (getattr(copy, name) == getattr(tri, name)).all(), name
    assert case == "weights" or (copy.offsets == tri.offsets).all()
    assert copy.stats == tri.stats and copy.sheets == tri.sheets
    corners = ([0] * tri.ndim, [1] * tri.ndim) if case == "weights" else None
    assert (septet.Voronoi(copy, box=corners).volumes == septet.Voronoi(tri, box=corners).volumes).all()
    rebuild, contents = tri.__reduce__()
    points, rows, stats, (weights, box) = contents
    for sites in ((None, None), (weights, [1]), ("x", box), 3, (np.zeros(3), box), (weights, ([10**400] * tri.ndim, [], False))):
        with pytest.raises((septet.InputError, ValueError)):
            rebuild(points, rows, stats, sites)


def test_verdicts(ndim: int, rng: np.random.Generator) -> None:
    points, weights = rng.random((200, ndim)), rng.random(200) * 0.05
    tri = septet.Delaunay(points, weights=weights)
    assert len(tri.hidden) and septet.verify(points, tri.simplices, weights=weights).ok
    assert not septet.verify(points, tri.simplices).ok
    assert not septet.verify(points, septet.Delaunay(points).simplices, weights=weights).ok
    for options in ({}, {"weights": weights}):
        box = septet.Delaunay(points, period=1, **options)  # type: ignore[arg-type]
        assert septet.verify(points, box.simplices, period=1, offsets=box.offsets, **options).ok  # type: ignore[arg-type]
        bad = np.array(box.offsets)
        bad[3, 1, 0] += 1
        verdict = septet.verify(points, box.simplices, period=1, offsets=bad, **options)  # type: ignore[arg-type]
        assert not verdict.ok and verdict.faults
    for wrong in ({"period": 1}, {"offsets": box.offsets}):
        with pytest.raises(septet.OptionError):
            septet.verify(points, box.simplices, **wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="offsets must have the shape"):
        septet.verify(points, box.simplices, period=1, offsets=box.offsets[1:])
    with pytest.raises(ValueError, match="weights must have the shape"):
        septet.verify(points, tri.simplices, weights=weights[1:])


def test_files_and_pictures(ndim: int, rng: np.random.Generator, tmp_path: Path) -> None:
    points = rng.random((50, ndim))
    box = septet.Delaunay(points, period=1)
    for ending in ("vtu", "ply"):
        box.write(tmp_path / f"box.{ending}")
    back = septet.read(tmp_path / "box.vtu", ndim=ndim)
    assert back.cells is not None and len(back.cells) == len(box.simplices) and len(back.points) > len(points)
    assert (back.points[: len(points)] == points).all()
    grid_of_vtk = box.to_pyvista()
    assert grid_of_vtk.n_cells == len(box.simplices) and grid_of_vtk.n_points == len(back.points)
    assert len(box.to_meshio().points) == len(back.points)
    box.write(tmp_path / "cells.npy")
    assert (np.load(tmp_path / "cells.npy") == box.simplices).all()
