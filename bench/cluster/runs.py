"""The runs of `bench/cluster-model`, and the constants that are fitted to them."""
import collections
import json
import math
import os
import subprocess
import sys
import tempfile

from formulas import (ENVELOPE, FIXED, GROUPED, LAWS, LENGTH, OTHER_PROCESS, TOTALS, Model, largest_share, splits, surface,
                      thick)

FIT = [(n, p) for n in (100_000, 300_000) for p in (8, 16, 32, 64)]
SEEDS = (1, 2, 3, 4)
MEMORY_FIT = [(n, p) for n in (100_000, 300_000) for p in (2, 4, 8)]
MOST_PROCESSES = 8


def run(options, name, arguments):
    """Returns the report of a run. Runs septet unless the directory has the report."""
    path = os.path.join(options.reports, name + ".json")
    if not os.path.exists(path):
        os.makedirs(options.reports, exist_ok=True)
        part = path + ".part"
        subprocess.run([options.septet, "triangulate", *arguments, "-q", "--json", part], check=True)
        os.rename(part, path)
    with open(path) as file:
        report = json.load(file)
    if report["certificate"] != "passed" or report["points"]["used"] != report["points"]["input"]:
        sys.exit(f"{path}: the run has no certificate, or left points out")
    for count in ("rounds", "messages", "bytes"):
        if sum(phase[count] for phase in report["phases"]) != report["machine"][count]:
            sys.exit(f"{path}: the {count} of the phases do not add up")
    if sum(row["bytes"] for row in report["traffic"]["rows"]) != report["machine"]["bytes"]:
        sys.exit(f"{path}: the bytes of the links do not add up")
    return report


def counted(options, n, p, seed=1):
    """Returns the counts of a run on the transport sim."""
    report = run(options, f"sim-{n}-{p}-{seed}", [f"sample:uniform:{n}", "--workers", str(p), "--seed", str(seed),
                                                  "--transport", "sim", "--threads", "1"])
    if n / p <= report["parameters"]["leaf"] / 2:
        sys.exit(f"{n} points, {p} workers: some subdomains are not split")
    rounds, phases = report["rounds"], {phase["name"]: phase for phase in report["phases"]}
    of = lambda phase, count: sum(row[count] for row in rounds if row["phase"] == phase)
    pairs = (phases["collect"]["messages"] - 2 * p) / 2
    sums = lambda end, phase: max(by_rank(report, end, phase).values()) if p <= GROUPED else None
    last = max(row["round"] for row in rounds if row["largest_load"])
    return {
        "simplices": report["simplices"], "phases": phases, "retries": sum(row["retries"] for row in rounds),
        "lengths": len(FIXED & {(row["phase"], row["largest"]) for row in rounds
                                if row["bytes"] == row["messages"] * row["largest"]}),
        "halo points": of("halo", "points"), "seam points": of("seam", "points"),
        "facets": (phases["collect"]["bytes"] - 2 * p * TOTALS - (2 * ENVELOPE + 5 * LENGTH) * pairs) / 40,
        "halo messages": phases["halo"]["messages"] - splits(p)[1] - p - 4, "seam messages": phases["seam"]["messages"],
        "neighbours": phases["check"]["messages"], "facet messages": pairs,
        "largest share": max(row["largest_load"] for row in rounds if row["round"] == last),
        "largest sent": sums("from", None), "root leader": sums("to", "partition"),
    }


def averaged(runs):
    """Returns the means of the counts of runs with different separators."""
    mean = lambda values: None if None in values else sum(values) / len(values)
    phases = {name: {count: mean([found["phases"][name][count] for found in runs]) for count in
                     ("rounds", "messages", "bytes")} for name in runs[0]["phases"]}
    return {"phases": phases} | {name: mean([found[name] for found in runs]) for name in runs[0] if name != "phases"}


def by_rank(report, end, phase):
    """Returns the bytes by sender or receiver, in one phase or in all."""
    sums = collections.Counter()
    for row in report["traffic"]["rows"]:
        if phase in (None, row["phase"]):
            sums[row[end]] += row["bytes"]
    return sums


def held(options, n, p):
    """Returns the mean of the ghosts of a worker, and the memory of the largest process, of a run on several processes."""
    points = os.path.join(options.reports, f"uniform-{n}.npy")
    if not os.path.exists(points):
        os.makedirs(options.reports, exist_ok=True)
        subprocess.run([options.septet, "generate", "uniform", "-n", str(n), "-o", points, "-q"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        report = run(options, f"processes-{n}-{p}", [points, "--workers", str(p), "--transport", "processes", "--processes",
                     str(min(p, MOST_PROCESSES)), "--threads", "1", "-o", os.path.join(folder, "mesh.pvtu")])
    rows = report["processes"]
    return {"ghosts": sum(row["ghosts"] for row in rows) / p, "memory": max(row["peak_rss_bytes"] for row in rows)}


def solved(rows):
    """Returns the constants of the least squares of relative errors. A row has the terms of a sum, the sum, and its weight."""
    width = len(rows[0][0])
    terms = [([t / total for t in row], weight) for row, total, weight in rows]
    table = [[sum(w * t[i] * t[j] for t, w in terms) for j in range(width)] + [sum(w * t[i] for t, w in terms)]
             for i in range(width)]
    for i in range(width):
        at = max(range(i, width), key=lambda row: abs(table[row][i]))
        table[i], table[at] = table[at], table[i]
        for j in (j for j in range(width) if j != i):
            factor = table[j][i] / table[i][i]
            table[j] = [a - factor * b for a, b in zip(table[j], table[i])]
    return [table[i][width] / table[i][i] for i in range(width)]


def fit(options):
    """Fits all constants to the small runs. A run has p - 1 separators, and this is its weight."""
    runs = {(n, p, seed): counted(options, n, p, seed) for n, p in FIT for seed in SEEDS}
    fitted = {name: solved([(terms(p.bit_length() - 1, n / p), found[name] / p, p - 1) for (n, p, _), found in runs.items()])
              for name, terms in LAWS.items()}
    pairs = lambda p, messages: -math.log1p(-messages / (p * (p - 1)))
    fitted["seam pairs"] = solved([([p ** (-2 / 3)], pairs(p, found["seam messages"]), p - 1)
                                   for (n, p, _), found in runs.items() if found["seam messages"] < p * (p - 1)])
    model, rows = Model(fitted), []
    for (n, p, _), found in runs.items():
        near = sum(found["phases"][name]["bytes"] for name in ("halo", "seam", "collect"))
        excess = found["largest sent"] * p - sum(phase["bytes"] for phase in found["phases"].values())
        rows.append(([(p.bit_length() - 1) * near], excess, 1))
    model.fitted["uneven"] = solved(rows)
    ghosts = thick(lambda h: [surface(h)])
    model.fitted["ghosts"] = solved([(ghosts(p.bit_length() - 1, n / p), held(options, n, p)["ghosts"], p - 1) for n, p in FIT])
    model.fitted["memory"] = solved([([1, largest_share(n, p) + model.ghosts(n, p)],
                                      held(options, n, p)["memory"] - OTHER_PROCESS * p, 1) for n, p in MEMORY_FIT])
    return model, runs
