"""Summaries of the runs: a row for each set and program."""
import statistics

from lib import programs


def agreement(program, fact, figures, reference):
    """Compares the cells with the reference. Returns a verdict, and the reason if they are not simply equal."""
    if figures["hash"] is None and program.driver:
        return "no cells to compare", program.caveat
    if reference is None:
        return "not compared", f"{programs.REFERENCE} did not run"
    if figures["hash"] == reference["hash"] and figures["cells"] == reference["cells"]:
        return "same cells", ""
    more = figures["cells"] - reference["cells"]
    # septet breaks ties like CGAL, by the lexicographic order of coordinates, so its cells must be equal.
    if fact["ties"] and not program.caveat and program.driver:
        ties = f"ties ({fact['ties']}) are broken by a rule of each program's own"
        return ("same count" if more == 0 else f"{more:+d} cells"), ties
    return "differs", program.caveat or "without a reason known"


def hashed(program, runs, check):
    """Returns count and hash of the cells of a program. If its runs differ or its check failed, returns None and a reason."""
    if program.driver:
        if len({(run["cells"], run["hash"]) for run in runs}) > 1:
            return None, "its runs differ from each other"
        return {"cells": runs[0]["cells"], "hash": runs[0]["hash"]}, ""
    if "stopped" in check:
        return None, check["stopped"]
    if any(run["cells"] != check["cells"] for run in runs):
        return None, "the timed runs and the checked one differ in their number of cells"
    return check, ""


def row(program, fact, runs, check, reference):
    """Returns a row of medians. `stopped` is the reason for missing figures."""
    done = [run for run in runs if "stopped" not in run]
    stopped = next((run["stopped"] for run in runs if "stopped" in run), "")
    made = {"set": fact["name"], "label": fact["label"], "points": fact["points"], "program": program.name,
            "program_label": program.label, "threads": program.threads, "runs": len(done), "stopped": stopped}
    if not done:
        return made
    figures, contradiction = hashed(program, done, check)
    verdict, reason = ("differs", contradiction) if contradiction else agreement(program, fact, figures, reference)
    seconds = [run["seconds"] for run in done]
    median, cells = statistics.median(seconds), done[0]["cells"]
    growth = [run["rss_peak"] - run["rss_before"] for run in done if run["rss_peak"] is not None]
    made |= {"version": done[0]["version"], "seconds": median, "least": min(seconds), "most": max(seconds),
             "disturbed": sum(run["disturbed"] for run in done), "ns_per_point": 1e9 * median / fact["points"],
             "cells": cells, "verdict": verdict, "reason": reason}
    if reference and verdict == "differs":
        made["more_cells"] = cells - reference["cells"]
    if growth:
        made["growth_bytes"] = statistics.median(growth)
        if verdict != "no cells to compare":
            made["bytes_per_cell"] = made["growth_bytes"] / cells
    return made


def folded(chosen, facts, runs, checks):
    """Rows in the order of sets and programs, with the ratio of each median to the reference's."""
    rows = []
    for fact in facts:
        name = fact["name"]
        of_set = {p.name: [r for r in runs if r["set"] == name and r["program"] == p.name] for p in chosen}
        known = [r for r in of_set.get(programs.REFERENCE, []) if "stopped" not in r]
        reference = known[0] if known else None
        made = [row(p, fact, of_set[p.name], checks.get(name, {}).get(p.name, {}), reference) for p in chosen
                if of_set[p.name]]
        base = next((r["seconds"] for r in made if r["program"] == programs.REFERENCE and r["runs"]), None)
        for one in made:
            if one["runs"] and base:
                one["ratio"] = one["seconds"] / base
        rows += made
    return rows


def faults(rows):
    """Returns the errors: wrong or missing cells of septet, or unexplained differences of an exact program."""
    found = []
    for one in rows:
        program = programs.BY_NAME[one["program"]]
        if one["runs"] and one["verdict"] == "differs" and not program.caveat:
            found.append(f"{one['label']}: {one['program_label']}: {one.get('more_cells', 0):+d} cells, {one['reason']}")
        if not program.driver and one["stopped"]:
            found.append(f"{one['label']}: {one['program_label']}: {one['stopped']}")
    return found
