#!/usr/bin/env python3
"""Measures the pairs of planted faults and claims at full size, and prints them as a Markdown table.

    bench/accept/faults.py target/release/septet [--seed 1] [--jobs 2] [--only WORD] [--more]

Every row runs `septet reproduce CLAIMS --fault FAULT`. Seconds are processor time. With --more, claims run that may fail,
too. Exit code 1 if a claim passes that must fail.
"""
import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

PAPER = ("octree sizes candidates conflicts completion "
         "partition radii probe neighbours summaries knn-radii knn-probe knn separator-sets own-sets graph independent hulls "
         "merge").split()
# Only meshes have these phases. No second account prices them.
MESHES = PAPER[:5]
# The results do not need the probes.
BOUNDED = [phase for phase in PAPER if "probe" not in phase and phase not in MESHES]
# Claims that share the sweeps of the recursion, so they run in one call.
SWEEPS = ["brent", "depth-law", "level-depth"]


def pairs():
    """Yields each fault, the claims that must fail, and the claims that may fail."""
    yield "slow:partition:log", ["level-depth"], ["brent", "depth-law"]
    yield "slow:partition:log2", ["level-depth"], ["brent", "depth-law"]
    yield "slow:hulls:root3", ["depth-law"], ["brent"]
    yield "sequential-leaf", ["brent"], []
    yield "free-loop", ["lower-bounds"], []
    yield "one-clock", ["brent", "free-of-workers", "level-depth"], ["depth-law"]
    yield "flood", ["brent", "replication"], []
    yield "far-ghosts:3", ["brent", "replication"], []
    yield "half-ghosts", ["graph-exact"], ["lower-bounds"]
    yield "half-separators", ["graph-exact"], []
    yield "halve-alpha", ["graph-exact", "local-hulls", "supergraph", "weights"], []
    yield "blind-probes", ["distance"], []
    yield "first-ball", ["overlap-k"], []
    yield "worst-choice", ["choice-near-best"], []
    yield "free:choice", ["whole-sum"], []
    yield "always-punt", ["neighbours-published"], []
    yield "slow-hub", ["hubs"], []
    yield "old-spheres", ["own-spheres"], []
    yield "free:sizes", ["mesh-brent"], []
    yield "slow:octree:log2", ["mesh-brent"], []
    yield "work:hulls:1.1", ["exact-counts"], ["brent"]
    yield "small-sphere", ["levels", "separator-split"], []
    for ablation in ["random-planes", "median-planes", "no-centrepoint"]:
        yield ablation, ["separator-exponent"], []
    for ablation in ["no-map", "no-scoring"]:
        yield ablation, [], ["separator-exponent"]
    for phase in [phase for phase in PAPER if phase not in MESHES]:
        bounds = ["lower-bounds"] if phase in BOUNDED else []
        yield f"free:{phase}", ["accounts", *bounds], []
        yield f"work:{phase}:0.5", ["accounts", *bounds], []
        yield f"work:{phase}:2", ["accounts"], ["brent"]
        yield f"slow:{phase}:log", ["accounts"], SWEEPS
        yield f"slow:{phase}:root3", ["accounts"], SWEEPS


def measured(septet, seed, fault, claims):
    """Returns the claims that failed, and the seconds of processor time."""
    with tempfile.NamedTemporaryFile(suffix=".json") as report:
        command = [septet, "reproduce", *claims, "--fault", fault, "--seed", str(seed), "--threads", "1", "-q",
                   "--json", report.name]
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        said = child.stderr.read()
        _, status, usage = os.wait4(child.pid, 0)
        code = os.waitstatus_to_exitcode(status)
        # A failed claim has exit code 4. Any other failure is not a result.
        if code not in (0, 4):
            raise RuntimeError(f"{' '.join(command)}: exit code {code}\n{said}")
        with open(report.name) as file:
            failed = [claim["name"] for claim in json.load(file)["claims"] if not claim["passed"]]
        return failed, usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="run only the faults whose text contains this word")
    parser.add_argument("--more", action="store_true", help="also run the claims that may fail")
    options = parser.parse_args()
    escaped = []
    print("| fault | claims run | claims that failed | seconds |\n| --- | --- | --- | --- |", flush=True)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        rows = [(fault, must, must + may * options.more) for fault, must, may in pairs() if options.only in fault]
        # Without claims, `reproduce` would run all of them.
        rows = [row for row in rows if row[2]]
        done = [pool.submit(measured, options.binary, options.seed, fault, run) for fault, _, run in rows]
        for (fault, must, run), result in zip(rows, done):
            failed, seconds = result.result()
            print(f"| `{fault}` | {' '.join(run)} | {' '.join(failed) or '-'} | {seconds:.0f} |", flush=True)
            escaped += [(fault, claim) for claim in must if claim not in failed]
    for fault, claim in escaped:
        print(f"{fault} escapes {claim}", file=sys.stderr)
    sys.exit(1 if escaped else 0)


if __name__ == "__main__":
    main()
