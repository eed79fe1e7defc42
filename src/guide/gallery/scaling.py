"""Measures how the depth and the work of the paper's algorithm grow with the number of points.

Usage: python src/guide/gallery/scaling.py [OUTPUT.png]

Each leaf of the partition tree has a worker of its own. Counts depend on points and seeds only, so each computer prints the same.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import septet

sizes, seeds = 2 ** np.arange(8, 14), (1, 2, 3)
depth, work = np.zeros((2, len(sizes), len(seeds)))
for row, n in enumerate(sizes):
    for column, seed in enumerate(seeds):
        points = np.random.default_rng(seed).random((n, 3))
        run = septet.simulate(points, workers="leaves", seed=seed)
        total = run.report["machine"]["total"]
        depth[row, column], work[row, column] = total["depth"], total["work"]
        run.check("levels(1.5, -5)")

# depth = factor (log2 n)^exponent: a line in logarithms. The residual is the largest relative distance from a mean.
doublings, mean = np.log2(sizes), depth.mean(axis=1)


def fitted(x: septet.Floats) -> tuple[septet.Floats, float, float]:
    """The values of the fit factor x^exponent to the means, its exponent, and its residual."""
    exponent, constant = np.polyfit(np.log(x), np.log(mean), 1)
    values: septet.Floats = np.exp(constant) * x**exponent
    return values, float(exponent), float(np.abs(values / mean - 1).max())


curve, exponent, residual = fitted(doublings)
power, other, worse = fitted(sizes.astype(float))
per_point = work.mean(axis=1) / sizes
print("log2 n    depth  work per point")
for values in zip(doublings, mean, per_point):
    print("{:6.0f} {:>8,.0f} {:>15,.0f}".format(*values))
print(f"depth grows like (log2 n)^{exponent:.2f}, residual {residual:.1%}")
print(f"depth grows like n^{other:.2f}, residual {worse:.1%}")
print(f"largest over smallest work per point: {per_point.max() / per_point.min():.2f}")

assert 1 < exponent < 2 and other < 1 / 3 and max(residual, worse) < 0.05
assert per_point.max() / per_point.min() < 1.15

figure, axes = plt.subplots(1, 2, figsize=(6.4, 3.2), layout="constrained")
axes[0].plot(doublings, depth, "k.", markersize=4)
axes[0].plot(doublings, curve, "r-", label=f"(log2 n)^{exponent:.2f}")
axes[0].plot(doublings, power, "b:", label=f"n^{other:.2f}")
axes[0].set(title="depth", xlabel="log2 n", ylim=(0, 3000))
axes[0].legend()
axes[1].plot(doublings, work / sizes[:, None], "k.", markersize=4)
axes[1].plot(doublings, per_point, "r-")
axes[1].set(title="work per point", xlabel="log2 n", ylim=(0, 12_000))
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "scaling.png", dpi=100)
