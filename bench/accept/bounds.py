#!/usr/bin/env python3
"""Prints the tables of src/lab/claims/bounds.rs: the largest value over the seeds of the reports, times 1.15 or 1.5.

    for s in 1 2 3; do
        septet reproduce brent level-depth replication --seed $s --json c$s.json
    done
    bench/accept/bounds.py c*.json
"""
import json
import math
import re
import sys

SLACK = 1.15
# On thin sets, bytes vary by up to 21 % between seeds. Other counts vary by at most 7 %.
VARIABLE = ["bytes of lists"]
SLACK_OF_VARIABLE = 1.5
# Probes process few balls. Their work may reach this share of the work of the descent that follows.
DESCENTS = {"probe": "neighbours", "knn-probe": "knn"}
SHARE_OF_PROBES = 0.1
CLAIMS = ["brent", "level-depth", "replication"]
LEVELS = "partition probe neighbours summaries knn-probe knn separator-sets".split()
KINDS = {
    "uniform": "Uniform", "jittered": "Jittered", "grid": "Grid", "sphere": "Sphere", "slab": "Slab",
    "clusters": "Clusters", "line": "Line", "well-spaced": "WellSpaced", "graded": "GradedPoint",
}
QUANTITIES = ["density graph", "overlap graph", "items of lists", "visits of lists", "bytes of lists"]


def largest(paths):
    """Returns the largest value of each figure of these claims, by claim, quantity, kind and dimension."""
    found = {}
    for path in paths:
        with open(path) as file:
            claims = json.load(file)["claims"]
        for claim in (claim for claim in claims if claim["name"] in CLAIMS):
            for figure in claim["figures"]:
                kind, dimension = re.match(r"([a-z-]+).* ([23])D", figure["on"]).groups()
                key = (claim["name"], figure["what"], kind, int(dimension))
                found[key] = max(found.get(key, 0.0), figure["value"] or 0.0)
    return found


def rounded(value, what):
    """Returns the bound: the value with slack, rounded up to three digits."""
    value *= SLACK_OF_VARIABLE if any(variable in what for variable in VARIABLE) else SLACK
    if value == 0:
        return "0.0"
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    digits = max(1, 2 - math.floor(math.log10(value)))
    return f"{math.ceil(value / unit) * unit:.{digits}f}"


def bound(found, claim, what, kind=None):
    """Returns a bound in Rust, over all kinds if no kind is given."""
    def of(dimension):
        keys = (k for k in found if k[0] == claim and what in k[1] and k[3] == dimension)
        return max((found[k] for k in keys if kind in (None, k[2])), default=0.0)
    return f"Bound::new({rounded(of(2), what)}, {rounded(of(3), what)})"


def main():
    found = largest(sys.argv[1:])
    print(f"pub(super) const T_N: Bound = {bound(found, 'brent', 'T_n over')};\n")
    works = [k[1] for k in found if k[0] == "brent" and k[1].startswith("work of")]
    for phase in dict.fromkeys(work.split()[2] for work in works):
        row = "of_lists" if phase.startswith("knn") else "phase"
        work = bound(found, "brent", f"work of {DESCENTS.get(phase, phase)} over")
        if phase in DESCENTS:
            work = re.sub(r"[\d.]+", lambda w: f"{SHARE_OF_PROBES * float(w.group()):.2f}", work)
        depth = bound(found, "brent", f"depth of {phase} over")
        print(f'    {row}("{phase}", {work}, {depth}),')
    print()
    for phase in LEVELS:
        row = "of_probe" if "probe" in phase else "level"
        print(f'    {row}("{phase}", {bound(found, "level-depth", f"steps of {phase} at a node")}),')
    print()
    for name, kind in KINDS.items():
        print(f"    of_kind(Kind::{kind}, [")
        for what in QUANTITIES:
            print(f"        {bound(found, 'replication', what, name)},")
        print("    ]),")


if __name__ == "__main__":
    main()
