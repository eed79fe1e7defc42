"""Plots as SVG, the same bytes for the same figures."""
import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

matplotlib.rcParams |= {"svg.hashsalt": "septet", "svg.fonttype": "none", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3}
MARKERS = "osD^v<>Ph*X"


def save(figure, path):
    figure.savefig(path, metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


def style(program, order):
    place = order.index(program)
    return {"color": f"C{place % 10}", "marker": MARKERS[place % len(MARKERS)],
            "linewidth": 2.2 if program.startswith("septet") else 1.1, "markersize": 5}


def panels_of(rows):
    """Groups rows by kind of set. Kinds with one size are dropped, unless all have one size."""
    kinds = {}
    for row in rows:
        if not row["set"].startswith("scan-"):
            kinds.setdefault(row["label"].rsplit(" ", 1)[0], []).append(row)
    several = {kind: members for kind, members in kinds.items() if len({row["points"] for row in members}) > 1}
    return several or kinds


def against_size(rows, path):
    """Time per point against the number of points: a panel for each kind in each dimension."""
    rows = [row for row in rows if row["runs"]]
    order = list(dict.fromkeys(row["program"] for row in rows))
    panels = panels_of(rows)
    if not panels:
        return
    columns = min(3, len(panels))
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(4.2 * columns, 3.2 * lines), squeeze=False)
    for axis in axes.flat[len(panels):]:
        axis.remove()
    for axis, (kind, members) in zip(axes.flat, panels.items()):
        for program in dict.fromkeys(row["program"] for row in members):
            mine = sorted((row for row in members if row["program"] == program), key=lambda row: row["points"])
            middle = [row["ns_per_point"] / 1e3 for row in mine]
            spread = [[1e6 * (row["seconds"] - row["least"]) / row["points"] for row in mine],
                      [1e6 * (row["most"] - row["seconds"]) / row["points"] for row in mine]]
            axis.errorbar([row["points"] for row in mine], middle, yerr=spread, label=mine[0]["program_label"], capsize=2,
                          **style(program, order))
        axis.set(xscale="log", yscale="log", title=kind, xlabel="points", ylabel="µs a point")
    handles = {}
    for axis in figure.axes:
        handles |= dict(zip(*reversed(axis.get_legend_handles_labels())))
    figure.tight_layout()
    figure.legend(handles.values(), handles.keys(), loc="upper center", bbox_to_anchor=(0.5, 0), ncols=4, frameon=False)
    save(figure, path)


def ratios(rows, path):
    """Ratio to CGAL on one thread, a line for each set, with bars from the smallest to the largest."""
    rows = [row for row in rows if row.get("ratio")]
    if not rows:
        return
    order = list(dict.fromkeys(row["program"] for row in rows))
    labels = list(dict.fromkeys(row["label"] for row in rows))
    figure, axis = plt.subplots(figsize=(7.5, 0.45 * len(labels) + 1.6))
    for program in order:
        mine = [row for row in rows if row["program"] == program]
        places = [labels.index(row["label"]) + 0.05 * (order.index(program) - len(order) / 2) for row in mine]
        base = [row["seconds"] / row["ratio"] for row in mine]
        spread = [[(row["seconds"] - row["least"]) / b for row, b in zip(mine, base)],
                  [(row["most"] - row["seconds"]) / b for row, b in zip(mine, base)]]
        axis.errorbar([row["ratio"] for row in mine], places, xerr=spread, label=mine[0]["program_label"],
                      **(style(program, order) | {"linestyle": "none", "linewidth": 1}))
    axis.axvline(1, color="black", linewidth=0.8)
    axis.set(xscale="log", xlabel="time, CGAL on one thread = 1", yticks=range(len(labels)))
    axis.set_yticklabels(labels)
    axis.invert_yaxis()
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=3, frameon=False)
    save(figure, path)


def shares(rows, path):
    """Stacked share of each phase: `rows` are (label, {phase: seconds})."""
    phases = list(dict.fromkeys(phase for _, parts in rows for phase in parts))
    figure, axis = plt.subplots(figsize=(7.5, 0.35 * len(rows) + 1.6))
    left = [0.0] * len(rows)
    for place, phase in enumerate(phases):
        widths = [100 * parts.get(phase, 0) / (sum(parts.values()) or 1) for _, parts in rows]
        axis.barh(range(len(rows)), widths, left=left, label=phase, color=plt.get_cmap("tab20")(place % 20))
        left = [a + b for a, b in zip(left, widths)]
    axis.set(xlabel="% of the phases' time", yticks=range(len(rows)), xlim=(0, 100))
    axis.set_yticklabels([label for label, _ in rows])
    axis.invert_yaxis()
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=5, frameon=False)
    save(figure, path)
