#!/usr/bin/env python3
"""Triangulates every kind of input at full size, verifies the results with septet and checks them with CGAL.

    bench/accept/run.py [--binary target/release/septet] [--only WORD] [--meshes DIRECTORY] [--markdown FILE]

Needs numpy, g++ and libcgal-dev (`bash tests/run --setup`, then target/venv/bin/python). All files are
written to target/accept. Exit code 4 if a step fails.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
WORK = HERE.parent.parent / "target" / "accept" / str(os.getpid())
# Sets without ties, except with probability zero. CGAL must give the same cells.
GENERAL = {"uniform", "poisson", "ball", "clusters", "slab", "line", "jittered"}
MAY_FALL_BACK = {"moment-curve 300", "skew-lines 300"}


def rotated(points, seed):
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(points.shape[1],) * 2))
    return points @ rotation.T


def lattice(side, dimension):
    axes = np.meshgrid(*[np.arange(side, dtype=float)] * dimension, indexing="ij")
    return np.stack([a.ravel() for a in axes], axis=1)


def made():
    """Sets that septet does not generate: name, function."""
    uniform = np.random.default_rng(1).random((100_000, 3))
    plane = np.random.default_rng(2).random((100_000, 2))
    t = np.linspace(0.1, 1, 150)
    skew = np.concatenate([np.c_[t, 0 * t, 0 * t], np.c_[0 * t, t, 0 * t + 1]])
    yield "skew-lines 300", lambda: skew
    yield "rotated grid 20^3", lambda: rotated(lattice(20, 3), 3)
    yield "rotated grid 300^2", lambda: rotated(lattice(300, 2), 4)
    for name, points in [("uniform 1e5", uniform), ("uniform 1e5 d=2", plane)]:
        yield f"{name} scaled 1e-120", lambda p=points: p * 1e-120
        yield f"{name} scaled 1e+120", lambda p=points: p * 1e120
        yield f"{name} offset 1e9", lambda p=points: p + 1e9
    yield "rotated grid 100^3", lambda: rotated(lattice(100, 3), 5)


def generated():
    """Sets that septet generates: kind, number, dimension."""
    for n in [1_000, 10_000, 100_000, 1_000_000]:
        for d in [3, 2]:
            for kind in ["uniform", "well-spaced", "graded", "graded-line", "poisson", "ball", "clusters", "slab", "line",
                         "jittered"]:
                if not (d == 2 and kind == "graded-line"):
                    yield kind, n, d
    yield from [("grid", 8_000, 3), ("fcc", 8_000, 3), ("grid", 90_000, 2), ("moment-curve", 300, 3),
                ("sphere", 100_000, 2), ("sphere", 100_000, 3), ("fcc", 100_000, 3), ("grid", 1_000_000, 3)]


def run(command, log):
    with open(log, "w") as out:
        return subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=out, text=True)


def check(binary, name, points, dimension, general):
    """One row: name, points, cells, seconds, results."""
    cells, report = WORK / "cells.npy", WORK / "report.json"
    for old in (cells, report):
        old.unlink(missing_ok=True)
    done = run([binary, "triangulate", points, "-o", cells, "--json", report], WORK / "log.txt")
    if done.returncode != 0:
        printed = (WORK / "log.txt").read_text().strip().splitlines()
        return [name, "", "", "", f"exit {done.returncode}: {printed[0] if printed else ''}", "", ""]
    run_report = json.loads(report.read_text())
    verified = run([binary, "verify", points, cells, "--perturbed"], WORK / "verify.txt")
    ours = "passed" if verified.returncode == 0 else f"exit {verified.returncode}"
    if points.suffix == ".npy":
        theirs = run([WORK.parent / "cgal_large", dimension, points, cells] + ["general"] * general, WORK / "cgal.txt")
        outside = theirs.stdout.strip() or f"exit {theirs.returncode}"
    else:
        outside = ""
    fallback = run_report["fallback"]
    fell = "" if fallback is None else f"{fallback['points']} points"
    if fallback is not None and name not in MAY_FALL_BACK:
        fell += " FAILED"
    if not outside.startswith("passed"):
        outside += " FAILED"
    return [name, run_report["points"]["used"], run_report["simplices"], f"{run_report['seconds']['triangulate']:.2f}", ours, outside, fell]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", type=pathlib.Path, default=HERE.parent.parent / "target/release/septet")
    parser.add_argument("--only", default="")
    parser.add_argument("--meshes", type=pathlib.Path)
    parser.add_argument("--kinds", default="generated,made,meshes", help="which groups of sets")
    parser.add_argument("--markdown", type=pathlib.Path)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    program = WORK.parent / "cgal_large"
    if not program.exists():
        subprocess.run(["g++", "-O2", "-DNDEBUG", "-frounding-math", "-w", HERE / "cgal_large.cpp", "-o", program, "-lgmp",
                        "-lmpfr"], check=True)
    jobs = []
    for kind, n, d in generated() if "generated" in options.kinds else []:
        def make(path, kind=kind, n=n, d=d):
            subprocess.run([options.binary, "-q", "generate", kind, "-n", str(n), "-d", str(d), "-o", path], check=True)
        jobs.append((f"{kind} {n}" + " d=2" * (d == 2), make, d, kind in GENERAL))
    for name, function in made() if "made" in options.kinds else []:
        jobs.append((name, lambda path, f=function: np.save(path, f()), function().shape[1] if "100^3" not in name else 3, False))
    if options.meshes:
        for mesh in sorted(options.meshes.iterdir(), key=lambda p: p.stat().st_size):
            if mesh.suffix in {".off", ".ply", ".xyz", ".obj", ".stl"}:
                jobs.append((mesh.name, mesh, None, False))
    rows, failed = [], False
    for name, make, d, general in jobs:
        if options.only not in name:
            continue
        start = time.time()
        points = WORK / "points.npy"
        if callable(make):
            make(points)
        else:
            # CGAL also reads the vertices as septet reads them.
            read = run([options.binary, "-q", "triangulate", make, "-o", WORK / "read.node"], WORK / "log.txt")
            if read.returncode == 0:
                table = np.loadtxt(WORK / "read.node", skiprows=1, comments="#", ndmin=2)
                d = int((WORK / "read.node").read_text().split(maxsplit=2)[1])
                np.save(points, np.ascontiguousarray(table[:, 1:1 + d]))
            else:
                printed = (WORK / "log.txt").read_text().strip().splitlines()
                rows.append([name, "", "", "", f"refused, exit {read.returncode}: {printed[0] if printed else ''}", "", ""])
                print(*rows[-1], sep=" | ", flush=True)
                continue
        row = check(options.binary, name, points, d, general)
        rows.append(row)
        failed |= any("FAILED" in str(c) or "exit" in str(c) for c in row)
        print(*row, f"{time.time() - start:.0f} s in all", sep=" | ", flush=True)
    head = ["set", "points", "cells", "s", "septet verify", "CGAL", "fallback"]
    if options.markdown:
        lines = [head, ["---"] * len(head)] + rows
        options.markdown.write_text("".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines))
    sys.exit(4 if failed else 0)


main()
