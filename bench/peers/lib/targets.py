"""The targets of septet, and their comparison with a measurement."""
from lib import programs, sets

# Set, time of the fastest program on two threads in earlier measurements, required time, aim: as ratios to CGAL on one
# thread.
RATIOS = [
    ("uniform-1e6", "HXT 0.30", 0.45, 0.25),
    ("uniform-4e6", "HXT 0.28", 0.42, 0.26),
    ("jittered-1e6", "HXT ~0.30", 0.45, 0.27),
    ("radial-1e6", "HXT 0.35", 0.45, 0.30),
    ("sphere-1e5", "CGAL 1.0", 1.0, 0.5),
    ("grid-1e6", "CGAL 0.57", 0.6, 0.3),
    ("uniform-1e6-2d", "CGAL 1.0", 0.8, 0.55),
]


def rated(value, must, aim, more=False):
    """Smaller is better, unless `aim` is above `must` or `more` is set."""
    sign = -1 if more or aim > must else 1
    if sign * value <= sign * aim:
        return "aim"
    return "must" if sign * value <= sign * must else "no"


def ratios(rows):
    """Returns the table of ratios. Sets without measurements have empty rows."""
    by_key = {(row["set"], row["program"]): row for row in rows if row["runs"]}
    table = []
    for name, known, must, aim in RATIOS:
        ours = by_key.get((name, programs.SEPTET[2]), {})
        reference = by_key.get((name, programs.REFERENCE), {})
        peers = [row for (of, program), row in by_key.items() if of == name and programs.BY_NAME[program].driver
                  and not programs.BY_NAME[program].caveat and "ratio" in row]
        fastest = min(peers, key=lambda row: row["ratio"], default={})
        ratio = ours.get("ratio")
        table.append({"set": name, "label": sets.named(name).label, "cgal_seconds": reference.get("seconds"),
                      "septet_seconds": ours.get("seconds"), "ratio": ratio, "fastest": fastest.get("program_label"),
                      "fastest_ratio": fastest.get("ratio"),
                      "fastest_known": known, "must": must, "aim": aim,
                      "reached": "not measured" if ratio is None else rated(ratio, must, aim)})
    return table


def others(rows):
    """Returns the other targets of these runs."""
    by_key = {(row["set"], row["program"]): row for row in rows if row["runs"]}
    one, two = ({name: by_key.get((name, programs.SEPTET[threads])) for name in ("uniform-1e6", "uniform-4e6")}
                for threads in (1, 2))
    table = []

    def add(what, value, must, aim, unit="", more=False):
        table.append({"what": what, "value": value, "must": must, "aim": aim, "unit": unit,
                      "reached": "not measured" if value is None else rated(value, must, aim, more)})

    small, large = two["uniform-1e6"], two["uniform-4e6"]
    alone = one["uniform-1e6"]
    add("speed-up from 1 worker on 1 thread to 2 on 2, uniform 1e6",
        alone["seconds"] / small["seconds"] if alone and small else None, 1.6, 1.6, more=True)
    add("1 worker on 1 thread to CGAL, uniform 1e6", alone.get("ratio") if alone else None, 0.85, 0.55)
    for row, size in ((small, "1e6"), (large, "4e6")):
        add(f"memory growth, uniform {size}", row.get("bytes_per_cell") if row else None, 80, 50, "bytes a tetrahedron")
    add("time per point, uniform 4e6 to 1e6", large["ns_per_point"] / small["ns_per_point"] if small and large else None, 1.15,
        1.15)
    return table
