#!/usr/bin/env python3
"""Checks rounds, levels, depth, splits and separators of runs with one worker per leaf against their bounds.

    for e in 12 14 16 18 20; do septet simulate sample:uniform:$((2**e)) --workers leaves --json u-$e.json; done
    bench/accept/leaves.py u-*.json

Prints a Markdown table. Exit code 4 if a bound is violated. |B_O| is the number of owned points, on both sides, whose
separator ball meets the separator. Its bound 5 alpha n^(1-1/d) applies to density graphs.
"""
import json
import math
import sys


def table_of(path):
    run = json.load(open(path))
    d, n, leaf = run["space"], run["points"]["used"], run["parameters"]["leaf"]
    phases = {p["name"]: p for p in run["phases"]}
    rounds = lambda *names: sum(phases[p]["rounds"] for p in names if p in phases)
    tree, alpha = run["tree"], run["supergraph"]["alpha"]
    levels = 1.5 * math.log2(max(n / leaf, 1)) + 2
    split = (d + 1) / (d + 2) + 0.05
    size = tree["largest_separator_ratio"] or 0
    depths = {k: [row[k] for row in tree["by_level"] if row[k]] for k in ("partition_depth", "neighbours_depth", "merge_depth")}
    span = lambda k: f"{min(depths[k])}-{max(depths[k])}" if depths[k] else "-"
    checks = [
        tree["levels"] <= levels,
        (tree["largest_split_ratio"] or 0) <= split,
        alpha is None or size <= 5 * alpha,
    ]
    row = [
        run["parameters"]["input"].removeprefix("sample:"), n, tree["leaves"], f"{tree['levels']} ({levels:.1f})",
        rounds("partition"), rounds("neighbours", "probe", "knn", "knn-probe"), rounds("merge"), run["repair"]["rounds"],
        span("partition_depth"), span("neighbours_depth"), span("merge_depth"),
        f"{tree['largest_split_ratio'] or 0:.3f} ({split:.2f})",
        f"{size:.1f} ({5 * alpha:.1f})" if alpha else f"{size:.1f} (k = {run['supergraph']['k']})",
        f"{tree['mean_attempts'] or 0:.2f}, {tree['largest_attempts'] or 0}", "yes" if all(checks) else "NO",
    ]
    return row, all(checks)


head = ["set", "n", "leaves", "levels (bound)", "rounds: partition", "balls", "merge", "repair", "depth a node: partition",
        "balls", "merge", "largest split (bound)", "largest |B_O| / m^(1-1/d) (bound)", "attempts: mean, most", "within"]
print("| " + " | ".join(head) + " |\n" + "|---" * len(head) + "|")
good = True
for path in sys.argv[1:]:
    row, passed = table_of(path)
    good &= passed
    print("| " + " | ".join(map(str, row)) + " |")
sys.exit(0 if good else 4)
