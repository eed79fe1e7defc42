"""The common code of the drivers in Python, as in driver.hpp for C++: clock, resident memory, hash of the cells, output."""
import json
import pathlib
import resource
import sys
import time

import numpy as np

# Cells hashed at a time.
CHUNK = 1 << 19


def mix(x):
    """The last steps of splitmix64 (Steele, Lea and Flood 2014) on an array of uint64."""
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def corners(points):
    """Returns a hash for each row of coordinates. -0 counts as 0."""
    bits = (points + 0.0).view(np.uint64)
    hashes = np.full(len(points), points.shape[1], dtype=np.uint64)
    for axis in range(points.shape[1]):
        hashes = mix(hashes ^ bits[:, axis])
    return hashes


def hash_cells(points, cells):
    """The order-free hash of cells (m, d + 1) over points (n, d), 16 hexadecimal digits."""
    of_corner = corners(points)
    total = 0
    for start in range(0, len(cells), CHUNK):
        rows = np.sort(of_corner[cells[start:start + CHUNK]], axis=1)
        hashes = np.full(len(rows), rows.shape[1], dtype=np.uint64)
        for corner in range(rows.shape[1]):
            hashes = mix(hashes ^ rows[:, corner])
        total += int(np.sum(hashes, dtype=np.uint64))
    return f"{total % 2**64:016x}"


def memory(key):
    """A line of /proc/self/status, in bytes."""
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return 1024 * int(line.split()[1])
    raise SystemExit("the system does not tell resident memory")


def processor():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def measure(call):
    """Times one call, with the peak of resident memory reset before it. Returns the result of the call and the figures."""
    pathlib.Path("/proc/self/clear_refs").write_text("5")
    before, used, start = memory("VmRSS"), processor(), time.perf_counter()
    result = call()
    seconds = time.perf_counter() - start
    return result, {"seconds": seconds, "processor_seconds": processor() - used, "rss_before": before,
                    "rss_peak": memory("VmHWM")}


def points():
    """Returns the points of the command line. These drivers have one thread only."""
    if len(sys.argv) != 3 or sys.argv[2] != "1":
        raise SystemExit("usage: driver POINTS.npy 1")
    return np.load(sys.argv[1])


def answer(measured, of_points, cells, version):
    print(json.dumps(measured | {"cells": len(cells), "hash": hash_cells(of_points, cells), "version": version}))
