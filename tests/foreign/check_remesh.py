"""Checks a mesh of the volume in a closed surface with a remeshed boundary. It reads files in TetGen's formats.

Usage: check_remesh.py DOMAIN.off MESH DISTANCE
with MESH.node, MESH.ele, MESH.edge, MESH.face. It shares no code with septet, not even a reader.

Exact: every cell is positive; two cells that share a facet lie on opposite sides of it; the faces are the facets of one cell; they are
a closed manifold (every edge in two, turned against each other; one fan at every vertex) with the surface's Euler characteristic.
In floating point: vertices, thirds of edges and middles of faces (some 10,000 of them) are no farther than the distance from the surface, and the surface's
vertices (likewise) no farther from the faces; the edges of the mesh on ridges lie on segments of the surface; the volumes differ by no more than the
area times the distance.
"""
import sys
from collections import Counter, defaultdict
from fractions import Fraction

import numpy as np

from check_mesh import Domain, Mesh, check_borders, check_cells, fail, rows

# Places whose distance is looked at.
MOST = 10_000


def triangles_of(path):
    table = rows(path)
    header = table[0][1:] or table[1]
    at = 1 if table[0][1:] else 2
    count, faces = int(header[0]), int(header[1])
    return [tuple(map(int, row[1:4])) for row in table[at + count:at + count + faces]]


def euler(triangles):
    edges = {tuple(sorted((t[i], t[i - 1]))) for t in triangles for i in range(3)}
    return len({v for t in triangles for v in t}) - len(edges) + len(triangles)


def outwards(mesh, sides):
    """The facets of one cell, turned so that the cell is behind."""
    faces = []
    for facet, found in sides.items():
        if len(found) == 1:
            cell = mesh.cells[found[0][1]]
            apex = next(v for v in cell if v not in facet)
            rest = [v for v in cell if v != apex]
            # Of a positive cell (a, b, c, d) the facets seen from outside are (b, c, d), (a, d, c), (a, b, d), (a, c, b).
            faces.append(tuple(rest if cell.index(apex) % 2 == 0 else (rest[0], rest[2], rest[1])))
    return faces


def check_manifold(faces):
    directed = Counter((f[i - 1], f[i]) for f in faces for i in range(3))
    for (a, b), count in directed.items():
        if count != 1 or directed[(b, a)] != 1:
            fail(f"edge {(a, b)} of the boundary has other than two faces")
    after = defaultdict(dict)
    for a, b, c in faces:
        for v, x, y in ((a, b, c), (b, c, a), (c, a, b)):
            after[v][x] = y
    for v, ring in after.items():
        start = at = next(iter(ring))
        steps = 0
        while steps == 0 or at != start:
            at, steps = ring[at], steps + 1
        if steps != len(ring):
            fail(f"vertex {v} has several fans of faces")


def distances(places, corners):
    """From each place to the nearest of some triangles."""
    a, b, c = (corners[:, i] for i in range(3))
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # Across each edge, inwards.
    sides = [(p, q - p, np.cross(normal, q - p)) for p, q in ((a, b), (b, c), (c, a))]
    found = []
    for x in places:
        height = np.abs(np.einsum("ij,ij->i", x - a, normal))
        above = np.ones(len(a), bool)
        nearest = np.full(len(a), np.inf)
        for p, along, across in sides:
            d = x - p
            above &= np.einsum("ij,ij->i", d, across) >= 0
            t = np.clip(np.einsum("ij,ij->i", d, along) / np.einsum("ij,ij->i", along, along), 0, 1)
            nearest = np.minimum(nearest, np.linalg.norm(d - t[:, None] * along, axis=1))
        found.append(np.where(above, height, nearest).min())
    return np.array(found)


def some(places):
    """Each place once; of many so few, evenly, that they are no more than MOST."""
    places = np.unique(places, axis=0)
    return places[:: 1 + len(places) // MOST]


def check_distance(what, places, corners, limit):
    worst = distances(places, corners).max()
    if worst > limit:
        fail(f"{what} are up to {worst!r} off, farther than {limit!r}")
    return worst


def check_ridges(domain, mesh, extent):
    ends = np.array([[domain.points[v] for v in s] for s in domain.segments])
    p, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    for v in {v for edge in mesh.edges for v in edge}:
        d = np.array(mesh.points[v]) - p
        t = np.clip(np.einsum("ij,ij->i", d, along) / np.einsum("ij,ij->i", along, along), 0, 1)
        if np.linalg.norm(d - t[:, None] * along, axis=1).min() > 1e-9 * extent:
            fail(f"vertex {v} of a ridge lies on no segment")


def main():
    path, stem, limit = sys.argv[1], sys.argv[2], float(sys.argv[3])
    domain, surface = Domain(path), triangles_of(path)
    mesh = Mesh(stem, 3)
    sides, found = check_cells(mesh, 3)
    check_borders(mesh, sides, {tuple(sorted(f)) for f in mesh.faces})
    faces = outwards(mesh, sides)
    if len(faces) != len(mesh.faces):
        fail("a face lies between two cells")
    check_manifold(faces)
    if euler(faces) != euler(surface):
        fail(f"Euler characteristic {euler(faces)} in place of {euler(surface)}")
    corners = np.array([[mesh.points[v] for v in f] for f in faces])
    walls = np.array([[domain.points[v] for v in t] for t in surface])
    extent = np.ptp(walls.reshape(-1, 3), axis=0).max()
    a, b, c = (corners[:, i] for i in range(3))
    thirds = [(2 * p + q) / 3 for p, q in ((a, b), (b, a), (b, c), (c, b), (c, a), (a, c))]
    places = np.concatenate([a, b, c, *thirds, (a + b + c) / 3])
    worst = check_distance("faces", some(places), walls, limit)
    back = check_distance("vertices of the surface", some(walls.reshape(-1, 3)), corners, limit)
    check_ridges(domain, mesh, extent)
    area = np.linalg.norm(np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0]), axis=1).sum() / 2
    if abs(found - domain.volume) > Fraction(1.1 * area * max(worst, back) + 1e-9 * float(domain.volume)):
        fail(f"the cells have {float(found)!r} in place of {float(domain.volume)!r}")
    print(f"ok {len(mesh.points)} points, {len(mesh.cells)} cells, {len(faces)} faces, {worst:.3g} and {back:.3g} apart")


main()
