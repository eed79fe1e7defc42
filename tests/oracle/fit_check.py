"""Computes with numpy and scipy what `fit` says of the lines of a sweep.

Usage: fit_check.py LINES ANSWER

LINES is a file of `septet scale`, ANSWER a report `septet-fit/2` about it.
"""

import json
import math
import sys

import numpy as np
from scipy import optimize, stats

LAWS = {
    "log n": lambda x, d: np.log2(x),
    "log^1.5 n": lambda x, d: np.log2(x) ** 1.5,
    "log^2 n": lambda x, d: np.log2(x) ** 2,
    "n^(1/d)": lambda x, d: x ** (1 / d),
    "n^(1-1/d)": lambda x, d: x ** (1 - 1 / d),
    "n": lambda x, d: x,
    "n log n": lambda x, d: x * np.log2(x),
    "n log^2 n": lambda x, d: x * np.log2(x) ** 2,
}
checked = 0


def close(what, ours, theirs, tolerance=1e-6):
    global checked
    checked += 1
    assert math.isclose(ours, theirs, rel_tol=tolerance, abs_tol=1e-9), f"{what}: {ours}, here {theirs}"


def least_squares(columns, y, w):
    """Coefficients, errors, inverse normal matrix, residual sum, freedom."""
    x = np.column_stack([np.ones_like(y), *columns])
    s = np.sqrt(w)
    beta, *_ = np.linalg.lstsq(x * s[:, None], y * s, rcond=None)
    rss = float((w * (y - x @ beta) ** 2).sum())
    freedom = len(y) - x.shape[1]
    scale = np.abs(x).max(axis=0)
    z = x / scale
    inverse = np.linalg.inv(z.T @ (z * w[:, None])) / np.outer(scale, scale)
    return beta, np.sqrt(np.diag(inverse) * rss / freedom), inverse, rss, freedom


def interval(what, ours, value, error, freedom, p=0.975):
    half = stats.t.ppf(p, freedom) * error
    for key, theirs in [("value", value), ("error", error), ("low", value - half), ("high", value + half)]:
        close(f"{what}.{key}", ours[key], theirs, 1e-5)


def count(line, request):
    if request["y"] == "levels":
        return line["tree"]["levels"]
    return next(p for p in line["phases"] if p["name"] == request["phase"])[request["y"]]


def shares(x, y, w, d, series):
    """The shares that are not excluded: the upper 95 % end of a higher law's coefficient, over the fitted count."""
    verdict = series["verdict"]
    base = {"law": [verdict.get("law")], "cannot-tell": verdict.get("laws", [])}.get(verdict["says"], [])
    own = [LAWS[min(base, key=list(LAWS).index)](x, d)] if base else []
    top = int(np.argmax(x))
    for entry in series["not_excluded"]:
        column = LAWS[entry["law"]](x, d)
        beta, error, _, _, freedom = least_squares([*own, column], y, w)
        high = beta[-1] + stats.t.ppf(0.975, freedom) * error[-1]
        fitted = beta[0] + sum(b * c[top] for b, c in zip(beta[1:], [*own, column]))
        close(f"share of {entry['law']}", entry["share"], max(0, high) * column[top] / fitted, 1e-4)
    falling = [entry["share"] for entry in series["not_excluded"]]
    assert falling == sorted(falling, reverse=True)


def power(x, y, w, ours):
    """The free exponent, by a bounded minimiser and a root finder on the profile."""
    z = np.log(x) - np.log(x).mean()

    def residual(e):
        return least_squares([np.expm1(e * z) / e if abs(e) > 1e-9 else z], y, w)[3]

    grid = np.linspace(-2, 4, 601)
    start = min(grid, key=residual)
    best = optimize.minimize_scalar(residual, bounds=(start - 0.02, start + 0.02), method="bounded",
                                    options={"xatol": 1e-10})
    freedom = len(y) - 3
    limit = best.fun * (1 + stats.t.ppf(0.975, freedom) ** 2 / freedom)
    inside = [e for e in grid if residual(e) <= limit] or [best.x]
    if ours is None:
        assert inside[0] == grid[0] and inside[-1] == grid[-1], f"exponents {inside[0]} to {inside[-1]}"
        return
    assert residual(ours["exponent"]) <= best.fun * (1 + 1e-9), f"exponent {ours['exponent']}, here {best.x}"
    for key, end, step in [("low", inside[0], -0.01), ("high", inside[-1], 0.01)]:
        if ours[key] is None:
            assert end in (grid[0], grid[-1]), f"{key}: beyond the range, here {end}"
        else:
            close(key, ours[key], optimize.brentq(lambda e: residual(e) - limit, end, end + step), 1e-4)


def growth(lines, request, series):
    ours = series["growth"]
    d = lines[0]["dimension"]
    sizes = {}
    for line in lines:
        sizes.setdefault(line["asked"], []).append((line["n"], count(line, request)))
    table = [np.array(sizes[n], float) for n in sorted(sizes)]
    x, y = (np.array([rows[:, i].mean() for rows in table]) for i in (0, 1))
    w = np.array([len(rows) for rows in table], float)
    if request["y"] == "work":
        w = w / y**2
    n = len(y)
    shares(x, y, w, d, series)
    power(x, y, w, series["power"])
    criteria = {}
    for fit in ours["laws"]:
        beta, error, _, rss, freedom = least_squares([LAWS[fit["law"]](x, d)], y, w)
        for name, i in [("constant", 0), ("slope", 1)]:
            interval(f"{fit['law']} {name}", fit[name], beta[i], error[i], freedom)
        criteria[fit["law"]] = n * math.log(rss / n) + 6 + 24 / (n - 4)
    best = min(criteria.values())
    for fit in ours["laws"]:
        close(f"{fit['law']} behind", fit["behind"], criteria[fit["law"]] - best, 1e-5)
    log = np.log2(x)
    _, _, _, straight, _ = least_squares([log], y, w)
    beta, error, _, bent, freedom = least_squares([log, log**2], y, w)
    f = (straight - bent) / (bent / freedom)
    close("F", ours["curvature"]["f"], f, 1e-5)
    close("p", ours["curvature"]["p"], stats.f.sf(f, 1, freedom), 1e-5)
    interval("quadratic", ours["curvature"]["quadratic"], beta[2], error[2], freedom)
    seen = (stats.t.ppf(0.995, freedom) + stats.t.ppf(0.95, freedom)) * error[2]
    close("smallest seen", ours["curvature"]["smallest_seen"], seen, 1e-5)
    # What was said to be seen in 95 % of repetitions is, by the exact distribution.
    seen_in = stats.nct.sf(stats.t.ppf(0.995, freedom), freedom, seen / error[2])
    assert 0.9 < seen_in < 0.99, f"power {seen_in} at {freedom} degrees of freedom"
    runs = np.array([len(rows) for rows in table], float)
    beta, error, _, _, freedom = least_squares([np.log(x)], np.log(y), runs)
    interval("exponent", ours["exponent"], beta[1], error[1], freedom)


def levels(lines, request, ours):
    rows = []
    for run, line in enumerate(lines):
        for level in line["levels"]:
            depth = level["depth"].get(request["phase"])
            if depth:
                size = level["split_points"] / level["splits"]
                rows.append((run, math.log2(size), depth["sum"] / depth["nodes"]))
    run, x, y = (np.array(c, float) for c in zip(*rows))
    beta, _, inverse, _, _ = least_squares([x], y, np.ones_like(y))
    residual = y - beta[0] - beta[1] * x
    design = np.column_stack([np.ones_like(x), x])
    meat = np.zeros((2, 2))
    groups = np.unique(run)
    for g in groups:
        score = design[run == g].T @ residual[run == g]
        meat += np.outer(score, score)
    g, n = len(groups), len(y)
    covariance = inverse @ meat @ inverse * g / (g - 1) * (n - 1) / (n - 2)
    error, margin = math.sqrt(covariance[1, 1]), request["margin"] * y.mean()
    interval("slope", ours["slope"], beta[1], error, g - 1, 0.95)
    below = stats.t.sf((margin - beta[1]) / error, g - 1)
    above = stats.t.sf((margin + beta[1]) / error, g - 1)
    close("p", ours["p"], max(below, above), 1e-4)
    assert ours["flat"] == (max(below, above) < 0.05)


def main():
    lines = [json.loads(line) for line in open(sys.argv[1])]
    answer = json.load(open(sys.argv[2]))
    (series,) = answer["series"]
    if answer["request"]["y"] == "level-depth":
        levels(lines, answer["request"], series["levels"])
    else:
        growth(lines, answer["request"], series)
    print(f"ok {checked} numbers: {series['words']}")


main()
