"""Meshes boxes with TetGen, Gmsh and septet at equal numbers of cells: see bench/README.md."""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import time

import numpy as np

import quality

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORK = ROOT / "target/mesh"
# Outline of the prism of height 1, volume, area.
DOMAINS = {
    "cube": ([(0, 0), (1, 0), (1, 1), (0, 1)], 1.0, 6.0),
    "l": ([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 3.0, 14.0),
}
PROGRAMS = ["septet", "septet-improve", "tetgen", "gmsh-delaunay", "gmsh-hxt"]
# Largest load average at which a measurement starts.
QUIET = 3.0
# Relative tolerance for the number of cells, and largest number of corrections of the size.
WITHIN, TRIES = 0.05, 6


class Failed(Exception):
    """A program failed or wrote no mesh."""


def write_domain(name):
    outline, _, _ = DOMAINS[name]
    n = len(outline)
    lines = [f"{2 * n} 3 0 0"]
    lines += [f"{i + 1 + z * n} {x} {y} {z}" for z in (0, 1) for i, (x, y) in enumerate(outline)]
    facets = [list(range(n, 0, -1)), list(range(n + 1, 2 * n + 1))]
    facets += [[i + 1, (i + 1) % n + 1, (i + 1) % n + 1 + n, i + 1 + n] for i in range(n)]
    lines.append(f"{len(facets)} 0")
    for facet in facets:
        lines += ["1", f"{len(facet)} " + " ".join(map(str, facet))]
    path = WORK / f"{name}.poly"
    path.write_text("\n".join(lines + ["0", "0"]) + "\n")
    return path


def run(command, limit):
    """Runs a process. Returns its standard output, wall seconds and peak resident bytes."""
    timed = ["/usr/bin/env", "python3", "-c", WRAPPER, *map(str, command)]
    try:
        done = subprocess.run(timed, capture_output=True, text=True, timeout=limit, cwd=WORK)
    except subprocess.TimeoutExpired as late:
        raise Failed(f"stopped after {limit:g} s") from late
    if done.returncode:
        printed = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise Failed(f"exit {done.returncode}: {printed[-1] if printed else 'without a word'}")
    seconds, peak = done.stderr.strip().splitlines()[-1].split()[-2:]
    return done.stdout, float(seconds), int(peak) * 1024


WRAPPER = """
import resource, subprocess, sys, time
start = time.perf_counter()
done = subprocess.run(sys.argv[1:], stderr=subprocess.PIPE, text=True)
seconds = time.perf_counter() - start
sys.stderr.write(done.stderr)
if done.returncode:
    sys.exit(done.returncode if done.returncode > 0 else 1)
print("measured", seconds, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, file=sys.stderr)
"""


def tables(stem):
    """Points and cells of a .node and .ele file."""
    def numbers(path, columns):
        with open(path) as file:
            count = int(file.readline().split()[0])
            rows = np.loadtxt(file, comments="#", max_rows=count, usecols=range(columns), ndmin=2)
        return rows
    nodes, cells = numbers(f"{stem}.node", 4), numbers(f"{stem}.ele", 5)
    return nodes[:, 1:], (cells[:, 1:] - nodes[0, 0]).astype(np.int64)


def mesh(program, domain, size, args):
    """Makes a mesh. Returns points, cells, seconds of meshing by the program, seconds of the process, and peak bytes."""
    poly = WORK / f"{domain}.poly"
    if program.startswith("septet"):
        out = WORK / "septet.ele"
        command = [args.binary, "mesh", poly, "-o", out, "--size", repr(size), "--workers", 2, "--threads", 2]
        command += ["--conforming", "--radius-edge", 2, "--json", "-"] + ([] if program.endswith("improve") else ["--no-improve"])
        printed, wall, peak = run(command, args.limit)
        return *tables(WORK / "septet"), json.loads(printed)["seconds"]["mesh_seconds"], wall, peak
    if program == "tetgen":
        # The largest volume is the volume of the regular tetrahedron with this edge.
        volume = size**3 / (6 * 2**0.5)
        printed, wall, peak = run(["tetgen", f"-pq1.414/14a{volume:.12f}", poly.name], args.limit)
        found = re.search(r"Total running seconds:\s*([0-9.]+)", printed)
        output = re.search(r"Writing output.*?seconds:\s*([0-9.]+)", printed) or re.search(r"Output seconds:\s*([0-9.]+)", printed)
        seconds = float(found[1]) - (float(output[1]) if output else 0.0) if found else wall
        return *tables(WORK / f"{domain}.1"), seconds, wall, peak
    out = WORK / "gmsh"
    threads = 2 if program == "gmsh-hxt" else 1
    command = [sys.executable, HERE / "gmsh_mesh.py", domain, program[5:], size, threads, out]
    printed, wall, peak = run(command, args.limit)
    return np.load(f"{out}.points.npy"), np.load(f"{out}.cells.npy"), float(printed.split()[-1]), wall, peak


def matched(program, domain, target, args):
    """Makes a mesh of about `target` cells. Sizes are corrected by the cube root of the ratio."""
    _, volume, area = DOMAINS[domain]
    size = (volume / target * 8.5) ** (1 / 3)
    for _ in range(TRIES):
        points, cells, seconds, wall, peak = mesh(program, domain, size, args)
        if abs(len(cells) / target - 1) <= WITHIN:
            break
        size *= (len(cells) / target) ** (1 / 3)
    times = [(seconds, wall, peak)] + [mesh(program, domain, size, args)[2:] for _ in range(args.repeat - 1)]
    cells = quality.check(points, cells, volume, area)
    found = quality.measure(points, cells)
    best = [min(column) for column in zip(*times)]
    return {**found, "size": size, "seconds": best[0], "process_seconds": best[1], "peak_bytes": max(t[2] for t in times)}


COLUMNS = [
    ("cells", "cells", "{:,}"), ("points", "points", "{:,}"), ("R/l median", "ratio_median", "{:.3f}"),
    ("99 %", "ratio_99", "{:.3f}"), ("most", "ratio_most", "{:.3f}"), ("least angle", "angle_least", "{:.2f}"),
    ("1 % of cells below", "angle_1", "{:.1f}"), ("cells < 10", "below_10", "{:,}"), ("< 14", "below_14", "{:,}"),
    ("largest angle", "angle_most", "{:.1f}"), ("s", "seconds", "{:.2f}"), ("s of the process", "process_seconds", "{:.2f}"),
]


def line(label, found):
    row = [template.format(found[key]) for _, key, template in COLUMNS]
    return f"| {label} | " + " | ".join(row) + f" | {found['peak_bytes'] / 2**20:,.0f} |"


def main():
    parser = argparse.ArgumentParser(prog="bench/mesh/run", description=__doc__)
    parser.add_argument("--binary", default=ROOT / "target/release/septet", help="septet's program")
    parser.add_argument("--cells", default="1e5,1e6", help="targets, separated by commas")
    parser.add_argument("--domains", default="cube,l")
    parser.add_argument("--programs", default="septet,tetgen,gmsh-delaunay,gmsh-hxt", help=", ".join(PROGRAMS))
    parser.add_argument("--repeat", type=int, default=3, help="the best time of so many runs")
    parser.add_argument("--limit", type=float, default=900, help="seconds after which a program is stopped")
    parser.add_argument("--busy", action="store_true", help="times although the machine is at work: of no worth")
    parser.add_argument("--json", type=pathlib.Path, help="all figures")
    args = parser.parse_args()
    args.binary = pathlib.Path(args.binary).resolve()
    programs, domains = args.programs.split(","), args.domains.split(",")
    for name in programs:
        if name not in PROGRAMS:
            parser.error(f"{name} is none of {', '.join(PROGRAMS)}")
    load = os.getloadavg()[0]
    if load > QUIET and not args.busy:
        sys.exit(f"the load is {load:.2f}, above {QUIET}: wait, or --busy for figures of no worth")
    WORK.mkdir(parents=True, exist_ok=True)
    everything, failed = [], False
    for domain in domains:
        write_domain(domain)
        for target in (round(float(t)) for t in args.cells.split(",")):
            print(f"\n{domain}, about {target:,} cells\n")
            print("| program | " + " | ".join(c[0] for c in COLUMNS) + " | MiB |\n" + "|---" * (len(COLUMNS) + 2) + "|")
            for program in programs:
                try:
                    found = matched(program, domain, target, args)
                except (Failed, quality.Wrong) as why:
                    print(f"| {program} | {why} |", flush=True)
                    failed |= program.startswith("septet")
                    continue
                print(line(program, found), flush=True)
                everything.append({"program": program, "domain": domain, "target": target, **found})
    if args.json:
        loads = {"load_before": load, "load_after": os.getloadavg()[0], "at": time.strftime("%Y-%m-%d")}
        args.json.write_text(json.dumps({**loads, "runs": everything}, indent=1) + "\n")
    sys.exit(4 if failed else 0)


main()
