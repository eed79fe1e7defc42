"""Results as Markdown and CSV."""
import csv

COLUMNS = ["set", "points", "program", "threads", "version", "runs", "disturbed", "seconds", "least", "most", "ns_per_point",
           "ratio", "cells", "verdict", "reason", "growth_bytes", "bytes_per_cell", "stopped"]


def table(head, lines):
    lines = [head, ["---"] * len(head)] + [["" if cell is None else cell for cell in line] for line in lines]
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)


def number(value, form):
    return "–" if value is None else format(value, form)


def seconds(value):
    """Formats a number with three digits."""
    if value is None:
        return "–"
    return f"{value:.{2 if value >= 1 else 3 if value >= 0.1 else 5}f}"


def spread(row):
    return f"{seconds(row['least'])} to {seconds(row['most'])}"


def runs(row):
    return f"{row['runs']}" + (f" ({row['disturbed']} disturbed)" if row["disturbed"] else "")


def described(record):
    machine = record["machine"]
    options = record["options"]
    text = (f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}, "
            f"{machine['compiler']}; {machine['date']}.")
    if options["busy"]:
        text += " **The machine was not asked to be quiet: these times are of no worth.**"
    if record["ended_early"]:
        text += f" **Ended early: {record['ended_early']}.**"
    return text


def targets(record):
    lines = [[row["label"], seconds(row["cgal_seconds"]), seconds(row["septet_seconds"]), number(row["ratio"], ".2f"),
              f"{row['fastest']} {row['fastest_ratio']:.2f}" if row["fastest"] else "–", row["fastest_known"], row["must"],
              row["aim"], row["reached"]] for row in record["targets"]["ratios"]]
    head = ["set", "CGAL s", "septet 2 x 2 s", "ratio", "fastest other here", "known before", "must", "aim", "reached"]
    return table(head, lines)


def other_targets(record):
    lines = [[row["what"], f"{number(row['value'], '.2f')} {row['unit']}".strip(), row["must"], row["aim"], row["reached"]]
             for row in record["targets"]["others"]]
    return table(["what", "measured", "must", "aim", "reached"], lines)


def all_rows(record):
    lines = []
    for row in record["rows"]:
        if not row["runs"]:
            lines.append([row["label"], row["program_label"], row["stopped"]] + [""] * 6)
            continue
        lines.append([row["label"], row["program_label"], seconds(row["seconds"]), spread(row), runs(row),
                      number(row["ns_per_point"], ".0f"), number(row.get("ratio"), ".2f"),
                      number(row.get("bytes_per_cell"), ".0f"), row["verdict"]])
    head = ["set", "program", "s (median)", "least to most", "runs", "ns a point", "to CGAL", "bytes a cell", "cells"]
    return table(head, lines)


def notes(record):
    """Lists versions, omitted programs, and the reasons for different cells."""
    lines = []
    versions = {row["program_label"]: row["version"] for row in record["rows"] if row["runs"]}
    lines.append("- Versions: " + "; ".join(f"{label}: {version}" for label, version in versions.items()) + ".")
    lines += [f"- Left out: {label}: {why}." for label, why in record["left_out"].items()]
    reasons = {}
    for row in record["rows"]:
        if row.get("reason"):
            more = f" ({row['more_cells']:+d})" if "more_cells" in row else ""
            reasons.setdefault((row["program_label"], row["verdict"], row["reason"]), []).append(row["label"] + more)
        if row["runs"] and row["stopped"]:
            lines.append(f"- {row['label']}, {row['program_label']}: {row['stopped']}.")
    lines += [f"- {program}: {verdict}: {reason}: {', '.join(of)}." for (program, verdict, reason), of in reasons.items()]
    return "\n".join(lines) + "\n"


def markdown(record):
    faults = "".join(f"**Fault:** {fault}.\n\n" for fault in record["faults"])
    return f"""# septet and other programs

{described(record)}

Points in memory to triangulation in memory, wall time; rounds in turn: {record['options']['repeat']}; a run
is *disturbed* if others used more than a tenth of a processor. Memory is the peak of resident memory less what it was
with the points read, over the number of finite cells. Cells are compared with CGAL's by an order-free hash of their
coordinates, outside the timed part.

{faults}## Targets

Ratios are to CGAL on one thread, same set, same rounds. The fastest other program here is the fastest of those that give
the Delaunay triangulation, on one or two threads.

{targets(record)}
{other_targets(record)}
## All

{all_rows(record)}
{notes(record)}"""


def write_csv(record, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(record["rows"])
