#!/usr/bin/env python3
"""Measures `--max-memory`: the least limit that a run accepts, against its peak without a limit and at that limit.

    bench/accept/memory.py [--program target/release/septet] [--commands triangulate,simulate] [--dimensions 2,3]
        [--kinds uniform,ball] [--sizes 20000,100000] [--options "--workers 4"] [--output cells.vtu]

Two bounds must hold in every row. No accepted run peaks above its limit. No run is refused above three times its peak
and 16 MiB. The program bisects the least accepted limit to 5 percent. A row that breaks a bound ends it with status 1.
"""
import argparse
import os
import subprocess
import sys
import tempfile
import time

KINDS = "uniform ball sphere grid fcc clusters slab line moment-curve shells body graded".split()
SIZES = {"triangulate": [20_000, 100_000, 300_000], "simulate": [4_000, 20_000, 60_000]}
# The moment curve has a quadratic number of cells in space, and shells exceed the range of exact coordinates.
SMALLER = {
    ("moment-curve", 3): {"triangulate": [1_000, 2_000, 4_000], "simulate": [300, 600, 1_200]},
    ("shells", 2): {"triangulate": [5_000, 10_000, 20_000], "simulate": [1_000, 4_000, 20_000]},
    ("shells", 3): {"triangulate": [5_000, 10_000, 20_000], "simulate": [1_000, 4_000, 20_000]},
}
MIB = 1 << 20
LIMITED = 5
PRECISION = 1.05


def run(command):
    """Runs a command. Returns its status, its peak in bytes, its seconds and its last line of standard error."""
    start = time.time()
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        text = errors.read().decode(errors="replace").strip()
    return process.returncode, usage.ru_maxrss * 1024, time.time() - start, text


class Case:
    """A run: a command over a file."""

    def __init__(self, args, command, path, folder):
        self.output = os.path.join(folder, args.output) if args.output else None
        self.command = [args.program, command, path, "-q", *args.options.split()]
        self.command += ["-o", self.output] if self.output else []
        self.has_left = False

    def limited(self, limit):
        """Runs with a limit. Returns the peak if the run was accepted, and otherwise `None`."""
        status, peak, seconds, text = run([*self.command, "--max-memory", str(int(limit))])
        left = self.output and os.path.exists(self.output)
        if left:
            os.remove(self.output)
        self.has_left |= status == LIMITED and bool(left)
        if status not in (0, LIMITED):
            sys.exit(f"status {status} at {limit}: {' '.join(self.command)}\n{text}")
        return (peak if status == 0 else None), seconds

    def free(self):
        """Runs without a limit. Returns the peak and the seconds."""
        status, peak, seconds, text = run(self.command)
        if status != 0:
            sys.exit(f"status {status}: {' '.join(self.command)}\n{text}")
        if self.output:
            os.remove(self.output)
        return peak, seconds


def least_limit(case, peak):
    """Returns the least accepted limit, its peak, the largest ratio of a peak to its limit, and the longest refusal."""
    low, high = peak / 8, 3 * peak + 16 * MIB
    worst, longest, at_high, accepted = 0.0, 0.0, None, None
    while accepted is None and high < 64 * peak + 1024 * MIB:
        accepted, seconds = case.limited(high)
        if accepted is None:
            low, high, longest = high, 1.5 * high, max(longest, seconds)
    at_high = accepted
    while at_high is not None and high > low * PRECISION:
        middle = (low * high) ** 0.5
        accepted, seconds = case.limited(middle)
        if accepted is None:
            low, longest = middle, max(longest, seconds)
        else:
            high, at_high, worst = middle, accepted, max(worst, accepted / middle)
    return high, at_high or 0, worst, longest


def row(args, command, kind, dimension, size, folder):
    """Measures one row and prints it. Returns `True` if it keeps both bounds."""
    path = os.path.join(folder, "points.npy")
    generate = [args.program, "generate", kind, "-n", str(size), "-d", str(dimension), "-o", path, "-q"]
    status, _, _, text = run(generate)
    if status != 0:
        sys.exit(f"{' '.join(generate)}: {text}")
    case = Case(args, command, path, folder)
    peak, seconds = case.free()
    limit, at_limit, worst, longest = least_limit(case, peak)
    is_low = limit <= (3 * peak + 16 * MIB) * PRECISION
    is_kept = worst <= 1.0
    broken = {"PEAK ABOVE LIMIT": not is_kept, "REFUSED TOO EARLY": not is_low, "OUTPUT LEFT": case.has_left}
    verdict = ", ".join(name for name, is_broken in broken.items() if is_broken)
    print(f"{command:11} {kind:12} {dimension}D {size:7} {peak / MIB:8.1f} {limit / MIB:8.1f} {limit / peak:6.2f} "
          f"{at_limit / MIB:8.1f} {worst:6.2f} {seconds:6.2f} {longest:6.2f} {verdict or 'ok'}", flush=True)
    return not verdict


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="target/release/septet")
    parser.add_argument("--commands", default="triangulate,simulate")
    parser.add_argument("--dimensions", default="2,3")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--sizes", help="numbers of points, in the place of the usual three")
    parser.add_argument("--options", default="", help="options of every run")
    parser.add_argument("--output", default="cells.vtu", help="output of every run; empty for none")
    args = parser.parse_args()
    print(f"{'command':11} {'kind':12}  d       n     peak    limit  ratio  at limit  worst      s  refused s   (MiB)")
    kept = True
    with tempfile.TemporaryDirectory() as folder:
        for command in args.commands.split(","):
            for dimension in map(int, args.dimensions.split(",")):
                for kind in args.kinds.split(","):
                    usual = SMALLER.get((kind, dimension), SIZES)[command]
                    sizes = map(int, args.sizes.split(",")) if args.sizes else usual
                    for size in sizes:
                        kept &= row(args, command, kind, dimension, size, folder)
    sys.exit(0 if kept else 1)


if __name__ == "__main__":
    main()
