"""The sets of points. A name is KIND-N or KIND-N-2d, as `uniform-1e6` or `grid-1e6-2d`, or scan-MESH.

KIND is one of `septet generate` (seed 1), or `radial`: random directions from the origin with radius u^4, u uniform in
[0, 1), which crowds points about the origin. A scan is the vertices of one of CGAL's meshes, each place once.
"""
import dataclasses
import hashlib
import re
import subprocess

import numpy as np

from lib import places

SEED = 1
# The sets of the main table, in order.
ALL = ["uniform-1e6", "uniform-4e6", "jittered-1e6", "radial-1e6", "well-spaced-1e6", "sphere-1e5", "grid-1e6", "clusters-1e6",
       "slab-1e6", "scan-bunny00", "scan-armadillo", "scan-camel", "uniform-1e6-2d", "grid-1e6-2d"]
GROUPS = {
    "all": ALL,
    "targets": ["uniform-1e6", "uniform-4e6", "jittered-1e6", "radial-1e6", "sphere-1e5", "grid-1e6", "uniform-1e6-2d"],
    "scans": [name for name in ALL if name.startswith("scan-")],
    "sizes": ["uniform-1e3", "uniform-1e4", "uniform-1e5", "uniform-1e6", "uniform-4e6"],
}
LABELS = {"radial": "graded r = u^4", "well-spaced": "f-spaced", "sphere": "sphere surface"}
# Sets with more than d + 1 points on an empty sphere, where each program breaks ties by a rule of its own.
TIES = {"grid": "the corners of each cell lie on one sphere", "fcc": "the corners of each octahedron lie on one sphere",
        "scan": "coordinates of few digits, so some spheres pass through five points"}


class Unknown(Exception):
    """The name of a set is unknown, or the set cannot be generated."""


@dataclasses.dataclass(frozen=True)
class Set:
    name: str
    kind: str
    number: int | None
    dimension: int

    @property
    def ties(self):
        """Returns the reason for ties, or None."""
        return TIES.get(self.kind, "")

    @property
    def label(self):
        if self.kind == "scan":
            return f"scan: {self.name.removeprefix('scan-')}"
        return f"{'2D ' * (self.dimension == 2)}{LABELS.get(self.kind, self.kind)} {written(self.number)}"

    @property
    def path(self):
        return places.WORK / "sets" / f"{self.name}.npy"


def written(number):
    """Formats a number of points for names and labels: 1e6, 1.6e7, 12345."""
    for digits in (0, 1):
        text = f"{number:.{digits}e}".replace("e+0", "e").replace("e+", "e")
        if float(text) == number:
            return text
    return str(number)


def of(kind, number, dimension):
    return Set(f"{kind}-{written(number)}{'-2d' * (dimension == 2)}", kind, number, dimension)


def named(name):
    if name.startswith("scan-"):
        return Set(name, "scan", None, 3)
    match = re.fullmatch(r"([a-z-]+?)-(\d[\d.]*(?:e\d+)?)(-2d)?", name)
    if not match:
        raise Unknown(f"no set is called {name}: KIND-N, KIND-N-2d, scan-MESH, or a group ({', '.join(GROUPS)})")
    return of(match[1], round(float(match[2])), 2 if match[3] else 3)


def parsed(text):
    """Parses names of sets and groups, separated by commas, without repetitions."""
    names = [name for word in text.split(",") for name in GROUPS.get(word, [word])]
    return list(dict.fromkeys(named(name) for name in names))


def smaller(asked, number):
    """The same kinds with that many points; scans stay as they are."""
    made = []
    for one in asked:
        small = one if one.kind == "scan" else of(one.kind, number, one.dimension)
        if small not in made:
            made.append(small)
    return made


def radial(number, dimension):
    draw = np.random.default_rng(SEED)
    directions = draw.normal(size=(number, dimension))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return directions * draw.random((number, 1)) ** 4


def scan(mesh):
    """Vertices of an .off file, each place once, in the file's order."""
    path = places.MESHES / f"{mesh}.off"
    if not path.exists():
        raise Unknown(f"no mesh {mesh} in {places.MESHES.relative_to(places.ROOT)}")
    lines = [line for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    number = int(lines[1].split()[0])
    points = np.array([line.split()[:3] for line in lines[2:2 + number]], dtype=np.float64)
    _, first = np.unique(points, axis=0, return_index=True)
    return points[np.sort(first)]


def make(one, binary):
    """Writes the file if it does not exist."""
    if one.path.exists():
        return
    one.path.parent.mkdir(parents=True, exist_ok=True)
    part = one.path.with_suffix(".part.npy")
    if one.kind == "scan":
        np.save(part, scan(one.name.removeprefix("scan-")))
    elif one.kind == "radial":
        np.save(part, radial(one.number, one.dimension))
    else:
        done = subprocess.run([binary, "-q", "generate", one.kind, "-n", str(one.number), "-d", str(one.dimension),
                               "--seed", str(SEED), "-o", part], stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise Unknown(f"{one.name}: {done.stderr.strip()}")
    part.rename(one.path)


def facts(one):
    """Returns the facts of a set: its numbers, and a digest that identifies its points."""
    with open(one.path, "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    points = np.load(one.path, mmap_mode="r")
    return {"name": one.name, "label": one.label, "points": len(points), "dimension": points.shape[1], "ties": one.ties,
            "sha256": digest}
