"""The command `bench/peers/scaling`: the cost of septet by number of points, workers and threads, and by phase."""
import csv
import json
import statistics
import sys

from lib import machine, plots, programs, rounds, run, sets, tables, targets

SIZES = "1e3,4e3,1.6e4,6.4e4,2.5e5,1e6,4e6,1.6e7"
# Workers and threads; the last pair shows the cost of many workers.
PAIRS = [(1, 1), (2, 2), (64, 2)]
# Sizes with 64 workers.
MANY = range(100_000, 4_000_001)
# Phases in which workers triangulate their subdomains and certify stars. The others belong to the machine: partition,
# ghost layer, interface exchange, comparison of fingerprints, splaying, merging.
KERNEL = {"pieces", "certificate"}
COLUMNS = ["set", "points", "workers", "threads", "runs", "disturbed", "seconds", "least", "most", "ns_per_point", "speed_up",
           "cells", "growth_bytes", "bytes_per_cell", "peak_bytes", "messages", "bytes", "machine_percent",
           "outside_phases_percent"]


def parsed():
    parser = run.arguments(("bench/peers/scaling", "septet's cost against points, workers and threads, by phase."), "scaling")
    parser.add_argument("--sizes", default=SIZES, help=f"numbers of points with commas between (default {SIZES})")
    parser.add_argument("--kind", default="uniform", help="kind of set (default uniform)")
    parser.add_argument("-d", "--dimension", type=int, choices=(2, 3), default=3)
    parser.add_argument("--simulate", default="1e6", metavar="N",
                        help="points of `simulate --workers 64`, 0 for none (default 1e6)")
    options = run.checked(parser, parser.parse_args())
    if options.smoke:
        options.sizes, options.simulate = "1e3,1e4", "1e4"
    ending = "-2d" if options.dimension == 2 else ""
    try:
        options.asked = [sets.named(f"{options.kind}-{size}{ending}") for size in options.sizes.split(",")]
        options.simulated = sets.named(f"{options.kind}-{options.simulate}{ending}")
    except sets.Unknown as error:
        parser.error(str(error))
    return options


def one_run(one, pair, options):
    """A timed run of one set with (workers, threads)."""
    machine.settle(options.wait, options.busy)
    record = {"set": one.name, "workers": pair[0], "threads": pair[1]}
    try:
        with machine.Others() as others:
            report = programs.triangulate(options.binary, one.path, pair, options.limit)
    except (programs.Failed, programs.TooLong) as error:
        return record | {"stopped": str(error)}
    return record | {"points": report["points"]["used"], "seconds": report["seconds"]["triangulate"],
                     "cells": report["simplices"], "messages": report["machine"]["messages"],
                     "bytes": report["machine"]["bytes"], "rss_before": report["rss_before_bytes"],
                     "rss_peak": report["peak_rss_bytes"], "others": round(others.processors, 3),
                     "phases": {phase["name"]: phase["seconds"] for phase in report["phases"]}}


def measure(options, facts, runs):
    """Facts of the sets and all runs, sizes in order, pairs in turn within a round."""
    for one in options.asked:
        sets.make(one, options.binary)
        facts.append(sets.facts(one))
        pairs = [pair for pair in PAIRS if pair[0] <= 2 or one.number in MANY or options.smoke]
        for number in range(options.repeat):
            for pair in list(pairs):
                made = one_run(one, pair, options) | {"round": number}
                runs.append(made)
                if "stopped" in made:
                    pairs.remove(pair)
                rounds.say(f"{one.name}: round {number + 1}: {pair[0]} workers on {pair[1]} threads:",
                           made.get("stopped") or f"{made['seconds']:.3f} s, others {made['others']:.2f}")


def simulate(options, simulation):
    """Processor seconds of `simulate --workers 64` on one set, reading included, a run each."""
    if options.simulated.number == 0:
        return
    sets.make(options.simulated, options.binary)
    used = []
    for _ in range(options.repeat):
        machine.settle(options.wait, options.busy)
        before = machine.children_seconds()
        command = [options.binary, "-q", "simulate", options.simulated.path, "--workers", 64, "--json", "-"]
        report = json.loads(programs.execute(command, options.limit))
        used.append(machine.children_seconds() - before)
        if report["certificate"] != "passed":
            raise programs.Failed(f"simulate: certificate {report['certificate']}")
        rounds.say(f"{options.simulated.name}: simulate, 64 workers: {used[-1]:.2f} processor seconds")
    points = report["points"]["used"]
    simulation |= {"points": points, "processor_seconds": used, "us_per_point": 1e6 * statistics.median(used) / points}


def row(fact, pair, runs):
    """Returns a row of medians for a set and a pair of workers and threads, or None if that pair did not run."""
    mine = [r for r in runs if r["set"] == fact["name"] and (r["workers"], r["threads"]) == pair]
    if not mine:
        return None
    done = [r for r in mine if "stopped" not in r]
    made = {"set": fact["name"], "points": fact["points"], "workers": pair[0], "threads": pair[1], "runs": len(done),
            "stopped": next((r["stopped"] for r in mine if "stopped" in r), "")}
    if not done:
        return made
    seconds = [r["seconds"] for r in done]
    phases = {name: statistics.median(r["phases"][name] for r in done) for name in done[0]["phases"]}
    total = sum(phases.values())
    made |= {"seconds": statistics.median(seconds), "least": min(seconds), "most": max(seconds), "cells": done[0]["cells"],
             "messages": done[0]["messages"], "bytes": done[0]["bytes"],
             "disturbed": sum(r["others"] > machine.DISTURBED for r in done), "phases": phases,
             "outside_phases_percent": statistics.median(100 * (1 - sum(r["phases"].values()) / r["seconds"]) for r in done),
             "machine_percent": 100 * sum(s for name, s in phases.items() if name not in KERNEL) / total}
    made["ns_per_point"] = 1e9 * made["seconds"] / fact["points"]
    grown = [r["rss_peak"] - r["rss_before"] for r in done if r["rss_peak"] is not None]
    if grown:
        made |= {"growth_bytes": statistics.median(grown), "bytes_per_cell": statistics.median(grown) / made["cells"],
                 "peak_bytes": max(r["rss_peak"] for r in done)}
    return made


def folded(facts, runs):
    rows = [made for fact in facts for pair in PAIRS if (made := row(fact, pair, runs))]
    for one in rows:
        alone = next(r for r in rows if r["set"] == one["set"] and (r["workers"], r["threads"]) == PAIRS[0])
        if one["runs"] and alone["runs"]:
            one["speed_up"] = alone["seconds"] / one["seconds"]
    return rows


def faults(rows):
    """Returns the rows without figures, and the sets whose number of cells depends on the workers."""
    found = [f"{one['set']}, {one['workers']} workers: {one['stopped']}" for one in rows if one["stopped"]]
    for name in dict.fromkeys(one["set"] for one in rows):
        counts = {one["cells"] for one in rows if one["set"] == name and one["runs"]}
        if len(counts) > 1:
            found.append(f"{name}: the number of cells depends on the workers: {sorted(counts)}")
    return found


def compared(rows, simulation):
    """Returns the targets of this command, which are for uniform points in space."""
    found = {(one["set"], one["workers"]): one for one in rows if one["runs"]}
    large, small = found.get(("uniform-4e6", 2)), found.get(("uniform-1e6", 2))
    many, largest = found.get(("uniform-1e6", 64)), found.get(("uniform-1.6e7", 2))
    lines = []

    def add(what, value, must, aim, unit, more=False):
        lines.append({"what": what, "value": value, "must": must, "aim": aim, "unit": unit,
                      "reached": "not measured" if value is None else targets.rated(value, must, aim, more)})

    add("speed-up, 2 workers on 2 threads, 1e6", small and small.get("speed_up"), 1.6, 1.6, "", more=True)
    growth = large["ns_per_point"] / small["ns_per_point"] if large and small else None
    add("time per point, 4e6 to 1e6", growth, 1.15, 1.15, "")
    add("the machine's share, 2 workers, 1e6", small and small["machine_percent"], 20, 20, "%")
    add("the machine's share, 64 workers, 1e6", many and many["machine_percent"], 40, 40, "%")
    add("memory growth, 1e6", small and small.get("bytes_per_cell"), 80, 50, "bytes a cell")
    add("memory growth, 4e6", large and large.get("bytes_per_cell"), 80, 50, "bytes a cell")
    peak = largest and largest.get("peak_bytes")
    add("peak memory, 1.6e7, which has to finish", peak / 2**30 if peak else None, 24, 24, "GiB")
    at_target = simulation and simulation["points"] == 1_000_000
    add("`simulate --workers 64`, 1e6", simulation["us_per_point"] if at_target else None, 10, 7, "µs of processor a point")
    return lines


def markdown(record):
    rows = [one for one in record["rows"] if one["runs"]]
    name = lambda one: f"{one['workers']} on {one['threads']}"
    cost = [[one["points"], name(one), tables.seconds(one["seconds"]), tables.spread(one), tables.runs(one),
             f"{one['ns_per_point']:.0f}", tables.number(one.get("speed_up"), ".2f"),
             tables.number(one.get("bytes_per_cell"), ".0f"), one["messages"], f"{one['bytes'] / one['points']:.0f}",
             f"{one['machine_percent']:.0f}", f"{one['outside_phases_percent']:.0f}"] for one in rows]
    head = ["points", "workers on threads", "s (median)", "least to most", "runs", "ns a point", "speed-up", "bytes a cell",
            "messages", "bytes sent a point", "machine %", "outside phases %"]
    phases = list(dict.fromkeys(phase for one in rows for phase in one["phases"]))
    percent = lambda one, phase: f"{100 * one['phases'].get(phase, 0) / sum(one['phases'].values()):.1f}"
    share = [[one["points"], name(one)] + [percent(one, phase) for phase in phases] for one in rows]
    faults = "".join(f"**Fault:** {fault}.\n\n" for fault in record["faults"])
    text = f"""# septet by points, workers and threads

{tables.described(record)}

{record['kind']} points in {record['dimension']} dimensions, `septet triangulate`, `seconds.triangulate`, medians; rounds in
turn: {record['options']['repeat']}. The machine's share is that of all phases but {' and '.join(sorted(KERNEL))}:
partition, messages, seams, exchange, merging.

{faults}{tables.table(head, cost)}
## Share of each phase, %

{tables.table(['points', 'workers on threads'] + phases, share)}"""
    if record["targets"]:
        text += f"\n## Targets\n\n{tables.other_targets({'targets': {'others': record['targets']}})}"
    return text


def write(record, out):
    out.mkdir(parents=True, exist_ok=True)
    (out / "scaling.json").write_text(json.dumps(record, indent=1) + "\n")
    (out / "scaling.md").write_text(markdown(record))
    rows = [one for one in record["rows"] if one["runs"]]
    phases = list(dict.fromkeys(phase for one in rows for phase in one["phases"]))
    plain = [{k: v for k, v in one.items() if k != "phases"} | one["phases"] for one in rows]
    with open(out / "scaling.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS + phases, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(plain)
    labelled = [one | {"label": sets.named(one["set"]).label, "program": f"septet-{one['workers']}",
                       "program_label": f"workers: {one['workers']}, threads: {one['threads']}"} for one in rows]
    plots.against_size(labelled, out / "size.svg")
    bars = [(f"{one['label']}, {one['workers']} on {one['threads']}", one["phases"]) for one in labelled]
    plots.shares(bars, out / "phases.svg")


def main():
    options = parsed()
    described = machine.described()
    facts, runs, simulation = [], [], {}
    ended = rounds.until_stopped(lambda: machine.start_quiet(options.wait, options.busy))
    ended = ended or rounds.until_stopped(lambda: measure(options, facts, runs))
    ended = ended or rounds.until_stopped(lambda: simulate(options, simulation))
    if not runs:
        sys.exit(f"bench/peers/scaling: {ended}")
    rows = folded(facts, runs)
    aimed_at = (options.kind, options.dimension) == ("uniform", 3)
    record = {"schema": "septet-scaling/1", "machine": described, "kind": options.kind, "dimension": options.dimension,
              "ended_early": ended, "sets": facts,
              "options": {"repeat": options.repeat, "busy": options.busy, "limit": options.limit},
              "faults": faults(rows), "rows": rows, "simulate": simulation,
              "targets": compared(rows, simulation) if aimed_at else [], "runs": runs}
    write(record, options.out)
    print(markdown(record))
    print(f"in {options.out}: scaling.md, scaling.csv, scaling.json, size.svg, phases.svg")
    if record["faults"]:
        sys.exit(4)
    if ended:
        sys.exit(f"bench/peers/scaling: ended early: {ended}")


if __name__ == "__main__":
    main()
