"""Checks a mesh of a .poly file, or of a closed surface in an .off file, by the files that TetGen and Triangle would
write, with Python's integers alone.

Usage: check_mesh.py DOMAIN.poly MESH MEASURE [FACETS]
       check_mesh.py DOMAIN.off MESH
with MESH.node, MESH.ele, MESH.edge and in space MESH.face, the volume (area) of the domain, and the numbers, from 1,
of facets that lie outside of it. A surface says its volume itself. It shares no code with septet, not even a reader.

Exact: every cell is positive; two cells that share a facet lie on opposite sides of it; no facet has three; a facet of
one cell is a face of the mesh (in the plane: lies on a segment), and cells with different attributes share faces only.
To 1e-9: faces lie on facets of the input and tile each, every edge of them being in two or on the facet's border; edges tile each
segment of the input without gap or overlap; the cells fill the volume.
"""
import sys
from collections import Counter, defaultdict
from fractions import Fraction

import numpy as np

NEAR = 1e-9


def rows(path):
    """The numbers of every line, without comments and empty lines."""
    with open(path) as lines:
        words = (line.split("#")[0].split() for line in lines)
        return [row for row in words if row]


def fail(what):
    print(f"failed: {what}")
    sys.exit(1)


def integers(points):
    """Coordinates times one power of two that makes them whole."""
    ratios = [[x.as_integer_ratio() for x in p] for p in points]
    scale = max(q for p in ratios for _, q in p)
    return [[n * (scale // q) for n, q in p] for p in ratios], scale


def determinant(m):
    if len(m) == 1:
        return m[0][0]
    return sum((-1) ** i * m[0][i] * determinant([r[:i] + r[i + 1:] for r in m[1:]]) for i in range(len(m)))


def read_nodes(table):
    """Points by id, and the number of rows read."""
    count, dimension = int(table[0][0]), int(table[0][1])
    return {int(r[0]): [float(x) for x in r[1:1 + dimension]] for r in table[1:1 + count]}, dimension, count + 1


class Domain:
    """Facets as lists of loops, segments as pairs of ids."""

    def __init__(self, path):
        table = rows(path)
        if path.endswith(".off"):
            self.read_surface(table)
            return
        self.points, self.dimension, at = read_nodes(table)
        if not self.points:
            self.points, self.dimension, _ = read_nodes(rows(path[:-4] + "node"))
        self.facets, self.segments = [], []
        count = int(table[at][0])
        at += 1
        for _ in range(count):
            if self.dimension == 2:
                self.segments.append(tuple(map(int, table[at][1:3])))
                at += 1
                continue
            polygons, holes = int(table[at][0]), int((table[at] + ["0"])[1]) if len(table[at]) > 1 else 0
            at += 1
            loops = []
            for _ in range(polygons):
                corners = int(table[at][0])
                loop = list(map(int, table[at][1:]))
                # A long polygon may go on in the next lines.
                while len(loop) < corners:
                    at += 1
                    loop += list(map(int, table[at]))
                loops.append(loop[:corners])
                at += 1
            at += holes
            self.facets.append([loop for loop in loops if len(loop) > 2])
            for loop in loops:
                if len(loop) > 1:
                    ends = loop[1:] + loop[:1] if len(loop) > 2 else loop[1:]
                    self.segments += list(zip(loop, ends))


    def read_surface(self, table):
        """Triangles, those of one plane that share an edge being one facet; edges of one line in a row one segment. `volume` is what they enclose."""
        self.dimension = 3
        header = table[0][1:] or table[1]
        at = 1 if table[0][1:] else 2
        count, faces = int(header[0]), int(header[1])
        self.points = {i: [float(x) for x in row[:3]] for i, row in enumerate(table[at:at + count])}
        triangles = [tuple(map(int, row[1:4])) for row in table[at + count:at + count + faces]]
        whole, scale = integers(list(self.points.values()))
        six = sum(determinant([whole[v] for v in t]) for t in triangles)
        self.volume = Fraction(abs(six), 6 * scale**3)
        beside = defaultdict(list)
        for number, t in enumerate(triangles):
            for i in range(3):
                beside[tuple(sorted((t[i], t[i - 1])))].append(number)
        group = list(range(len(triangles)))

        def leader(i):
            while group[i] != i:
                i = group[i]
            return i

        for a, b in beside.values():
            corners = list(dict.fromkeys(triangles[a] + triangles[b]))
            first = whole[corners[0]]
            if determinant([[x - y for x, y in zip(whole[v], first)] for v in corners[1:]]) == 0:
                group[max(leader(a), leader(b))] = min(leader(a), leader(b))
        borders = defaultdict(list)
        for number, t in enumerate(triangles):
            for i in range(3):
                ends = beside[tuple(sorted((t[i - 1], t[i])))]
                if leader(ends[0]) != leader(ends[1]):
                    borders[leader(number)].append((t[i - 1], t[i]))
        self.facets = [loops_of(edges) for edges in borders.values()]
        edges = {tuple(sorted(edge)) for edges in borders.values() for edge in edges}
        self.segments = joined(edges, whole)


def joined(edges, whole):
    """Segments: edges in a row on one line, where no other edge ends, are one."""
    at = defaultdict(set)
    for a, b in edges:
        at[a].add(b)
        at[b].add(a)
    for v in list(at):
        if len(at[v]) != 2:
            continue
        a, b = at[v]
        p, q = ([x - y for x, y in zip(whole[end], whole[v])] for end in (a, b))
        cross = [p[i - 2] * q[i - 1] - p[i - 1] * q[i - 2] for i in range(3)]
        if not any(cross) and b not in at[a]:
            for end, other in ((a, b), (b, a)):
                at[end].remove(v)
                at[end].add(other)
            del at[v]
    return sorted({tuple(sorted((a, b))) for a in at for b in at[a]})


def loops_of(edges):
    """Directed edges, joined to closed loops."""
    after = defaultdict(list)
    for a, b in edges:
        after[a].append(b)
    loops = []
    for start in list(after):
        while after[start]:
            loop = [start]
            while (to := after[loop[-1]].pop()) != start:
                loop.append(to)
            loops.append(loop)
    return loops


class Mesh:
    def __init__(self, stem, dimension):
        self.points, found, _ = read_nodes(rows(stem + ".node"))
        if found != dimension:
            fail(f"the mesh has dimension {found}")
        whole, self.scale = integers(list(self.points.values()))
        self.whole = dict(zip(self.points, whole))
        table = rows(stem + ".ele")
        size = dimension + 1
        self.cells = [tuple(map(int, r[1:1 + size])) for r in table[1:]]
        self.attributes = [r[1 + size] if len(r) > 1 + size else "" for r in table[1:]]
        if len(self.cells) != int(table[0][0]):
            fail("the .ele file does not have as many rows as it says")
        self.edges = [tuple(map(int, r[1:3])) for r in rows(stem + ".edge")[1:]]
        self.faces = [tuple(map(int, r[1:4])) for r in rows(stem + ".face")[1:]] if dimension == 3 else self.edges


def check_cells(mesh, d):
    """Signs, facets, and the exact measure times a factorial."""
    total, sides = 0, defaultdict(list)
    for number, cell in enumerate(mesh.cells):
        corners = [mesh.whole[v] for v in cell]
        size = determinant([[x - y for x, y in zip(p, corners[0])] for p in corners[1:]])
        if size <= 0:
            fail(f"cell {cell} is not positive")
        total += size
        for i in range(d + 1):
            rest = cell[:i] + cell[i + 1:]
            # The parity of the facet's order, as the cell turns it.
            order = sorted(range(d), key=lambda k: rest[k])
            inversions = sum(order[a] > order[b] for a in range(d) for b in range(a + 1, d))
            sides[tuple(sorted(rest))].append(((i + inversions) % 2, number))
    used = set(v for cell in mesh.cells for v in cell)
    if d == 3 and used != set(mesh.points):
        isolated = set(mesh.points) - used
        fail(f"points {sorted(isolated)[:5]} are in no cell")
    for facet, found in sides.items():
        if len(found) > 2 or len(found) == 2 and found[0][0] == found[1][0]:
            fail(f"facet {facet} has {len(found)} cells, or two on one side")
    factorial = 2 if d == 2 else 6
    return sides, Fraction(total, factorial * mesh.scale**d)


def check_borders(mesh, sides, faces):
    for facet, found in sides.items():
        beside = {mesh.attributes[number] for _, number in found}
        if (len(found) == 1 or len(beside) == 2) and facet not in faces:
            fail(f"facet {facet} of one cell, or between two regions, is no face")
    for face in faces:
        if face not in sides:
            fail(f"face {face} is in no cell")


def along(p, q, x):
    """How far x lies along the segment pq, from 0 to 1, or nothing if it is off it."""
    pq, px = np.subtract(q, p), np.subtract(x, p)
    length = float(np.dot(pq, pq))
    t = float(np.dot(pq, px)) / length
    off = np.linalg.norm(px - t * pq)
    return t if off <= NEAR * length**0.5 and -NEAR <= t <= 1 + NEAR else None


def check_segments(domain, mesh, edges):
    """The edges that lie on each segment are a chain from end to end. The edges that lie on any."""
    places = np.array(list(mesh.points.values()))
    ids = list(mesh.points)
    taken = set()
    for a, b in domain.segments:
        p, q = (np.array(domain.points[v]) for v in (a, b))
        pq = q - p
        t = (places - p) @ pq / (pq @ pq)
        off = np.linalg.norm(places - p - np.outer(t, pq), axis=1)
        on = np.nonzero((off <= NEAR * np.linalg.norm(pq)) & (t >= -NEAR) & (t <= 1 + NEAR))[0]
        chain = [ids[i] for i in on[np.argsort(t[on])]]
        if len(chain) < 2 or abs(min(t[on])) > NEAR or abs(max(t[on]) - 1) > NEAR:
            fail(f"segment {a}-{b} has no points at its ends")
        for pair in zip(chain, chain[1:]):
            key = tuple(sorted(pair))
            if key not in edges:
                fail(f"segment {a}-{b} has no edge {key}")
            taken.add(key)
    return taken


def project(points, normal):
    """Drops the axis along which the normal is longest."""
    axis = int(np.argmax(np.abs(normal)))
    return np.delete(np.atleast_2d(points), axis, axis=1), abs(normal[axis])


def shoelace(loop):
    x, y = loop[:, 0], loop[:, 1]
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def inside(point, loops):
    """Even-odd."""
    odd = False
    for loop in loops:
        for (x, y), (u, v) in zip(loop, np.roll(loop, -1, axis=0)):
            if (y > point[1]) != (v > point[1]) and point[0] < x + (point[1] - y) / (v - y) * (u - x):
                odd = not odd
    return odd


def check_facets(domain, mesh, taken, outside):
    corners = np.array([[mesh.points[v] for v in face] for face in mesh.faces])
    extent = np.ptp(np.array(list(domain.points.values())), axis=0).max()
    owned = Counter()
    for number, loops in enumerate(domain.facets):
        if not loops:
            continue
        rings = [np.array([domain.points[v] for v in loop]) for loop in loops]
        # Newell's normal of the largest loop.
        normals = [np.cross(r, np.roll(r, -1, axis=0)).sum(axis=0) for r in rings]
        normal = max(normals, key=np.linalg.norm)
        normal = normal / np.linalg.norm(normal)
        flat = [project(r, normal)[0] for r in rings]
        shrink = project(rings[0], normal)[1]
        depth = lambda i: sum(inside(flat[i][0], [other]) for j, other in enumerate(flat) if j != i)
        area = sum((-1) ** depth(i) * shoelace(loop) for i, loop in enumerate(flat)) / shrink
        off = np.abs((corners - rings[0][0]) @ normal).max(axis=1)
        found, tiles = 0.0, Counter()
        for i in np.nonzero(off <= NEAR * extent)[0]:
            if inside(project(corners[i].mean(axis=0), normal)[0][0], flat):
                owned[i] += 1
                a, b, c = corners[i]
                found += np.linalg.norm(np.cross(b - a, c - a)) / 2
                v = sorted(mesh.faces[i])
                tiles.update([(v[0], v[1]), (v[0], v[2]), (v[1], v[2])])
        area = 0.0 if number + 1 in outside else area
        if abs(found - area) > NEAR * area:
            fail(f"facet {number} has {found!r} of {area!r} in faces")
        for edge, count in tiles.items():
            if count > 2 or count == 1 and edge not in taken:
                fail(f"edge {edge} has {count} faces of facet {number}")
    if len(owned) != len(mesh.faces) or max(owned.values()) != 1:
        fail("a face lies on no facet, or on two")


def main():
    path, stem = sys.argv[1:3]
    outside = {int(number) for number in sys.argv[4:]}
    domain = Domain(path)
    d = domain.dimension
    mesh = Mesh(stem, d)
    sides, found = check_cells(mesh, d)
    expected = Fraction(sys.argv[3]) if len(sys.argv) > 3 else domain.volume
    if abs(found - expected) > expected * Fraction(1, 10**9):
        fail(f"the cells have {float(found)!r} in place of {float(expected)!r}")
    edges = {tuple(sorted(e)) for e in mesh.edges}
    taken = check_segments(domain, mesh, edges if d == 3 else set(sides))
    if d == 3:
        check_borders(mesh, sides, {tuple(sorted(f)) for f in mesh.faces})
        check_facets(domain, mesh, taken, outside)
        if edges != taken:
            fail("an edge lies on no segment")
    else:
        check_borders(mesh, sides, taken)
    print(f"ok {len(mesh.points)} points, {len(mesh.cells)} cells, {len(taken)} edges on segments")


if __name__ == "__main__":
    main()
