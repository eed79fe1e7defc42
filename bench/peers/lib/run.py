"""The command `bench/peers/run`."""
import argparse
import json
import pathlib
import sys

from lib import machine, places, plots, programs, rounds, sets, summary, tables, targets


def arguments(text, default_out, **more):
    """Options that both commands have."""
    parser = argparse.ArgumentParser(prog=text[0], description=text[1], **more)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="rounds (default 5)")
    parser.add_argument("--out", type=pathlib.Path, default=places.WORK / default_out, metavar="DIR", help="where results go")
    parser.add_argument("--binary", type=pathlib.Path, default=places.SEPTET, help="septet (default target/release/septet)")
    parser.add_argument("--limit", type=float, default=120, metavar="SECONDS", help="stop a run after this (default 120)")
    parser.add_argument("--wait", type=float, default=0, metavar="SECONDS",
                        help="wait for a quiet machine that long (default 0)")
    parser.add_argument("--busy", action="store_true", help="measure on a busy machine: to try the command out")
    parser.add_argument("--smoke", action="store_true", help="1 round, few points, machine busy or not: does everything run?")
    return parser


def checked(parser, options):
    if options.smoke:
        options.repeat, options.busy = 1, True
    if options.repeat < 1:
        parser.error("--repeat: at least 1")
    if not options.binary.exists():
        parser.error(f"no {options.binary}: cargo build --release, or --binary")
    options.binary = options.binary.resolve()
    return options


def parsed():
    parser = arguments(("bench/peers/run", "septet and other programs on the same sets in turn."), "results",
                       epilog=f"Sets: KIND-N, KIND-N-2d, scan-MESH, or groups: {', '.join(sets.GROUPS)}. "
                       f"Programs: {', '.join(programs.BY_NAME)}.")
    parser.add_argument("--sets", default="all", help="names or groups with commas between (default all)")
    parser.add_argument("--peers", default="all", help="programs with commas between (default all); septet's are always in")
    options = checked(parser, parser.parse_args())
    try:
        options.asked = sets.parsed(options.sets)
        options.chosen = programs.parsed(options.peers)
    except (sets.Unknown, programs.Failed) as error:
        parser.error(str(error))
    ours = [p for p in programs.ALL if not p.driver and p not in options.chosen]
    options.chosen = ours + options.chosen
    if options.smoke:
        options.asked = sets.smaller(options.asked, 10_000)
        options.limit = min(options.limit, 30)
    return options


def main():
    options = parsed()
    left_out = {p.label: p.missing for p in options.chosen if p.missing}
    chosen = [p for p in options.chosen if not p.missing]
    described = machine.described()
    facts, runs, checks = [], [], {}
    ended = rounds.until_stopped(lambda: machine.start_quiet(options.wait, options.busy))
    ended = ended or rounds.until_stopped(lambda: rounds.measure(chosen, options, facts, runs, checks))
    if not runs:
        sys.exit(f"bench/peers/run: {ended}")
    for run in runs:
        run["disturbed"] = run.get("others", 0) > machine.DISTURBED
    rows = summary.folded(chosen, facts, runs, checks)
    record = {"schema": "septet-peers/1", "machine": described,
              "ended_early": ended,
              "options": {"repeat": options.repeat, "busy": options.busy, "limit": options.limit},
              "sets": facts, "left_out": left_out, "faults": summary.faults(rows),
              "targets": {"ratios": targets.ratios(rows), "others": targets.others(rows)}, "rows": rows, "runs": runs,
              "checks": checks}
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "peers.json").write_text(json.dumps(record, indent=1) + "\n")
    (options.out / "peers.md").write_text(tables.markdown(record))
    tables.write_csv(record, options.out / "peers.csv")
    plots.against_size(rows, options.out / "size.svg")
    plots.ratios(rows, options.out / "ratios.svg")
    print(tables.all_rows(record))
    print(f"in {options.out}: peers.md, peers.csv, peers.json, size.svg, ratios.svg")
    if record["faults"]:
        print(*record["faults"], sep="\n", file=sys.stderr)
        sys.exit(4)
    if ended:
        sys.exit(f"bench/peers/run: ended early: {ended}")


if __name__ == "__main__":
    main()
