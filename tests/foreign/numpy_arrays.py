"""Reads an array of septet with numpy, and saves arrays for septet to read.

Usage: numpy_arrays.py DIRECTORY

`ours.npy` in the directory must hold AWKWARD, bit for bit. Then AWKWARD is saved as doubles in each version of the format and both
orders, and WHOLE in each type and both orders. Python package: numpy.
"""

import sys
from pathlib import Path

import numpy as np

AWKWARD = [[0.1, -2.5e300, 7.0], [1e-5, 0.0, 1.0], [-3.3e-310, 1.0 / 3.0, 5e-324]]
WHOLE = [[0, 1, 2], [3, 4, 5], [6, 7, 100], [9, 10, 11]]


def save(path, array, version):
    with open(path, "wb") as file:
        np.lib.format.write_array(file, array, version=version)


def main():
    root = Path(sys.argv[1])
    ours = np.load(root / "ours.npy")
    assert ours.dtype == np.dtype("<f8") and ours.flags.c_contiguous, ours.dtype
    assert ours.tobytes() == np.array(AWKWARD, "<f8").tobytes(), ours
    for order in "CF":
        for major in (1, 2, 3):
            save(root / f"awkward-{order}-{major}.npy", np.array(AWKWARD, "<f8", order=order), (major, 0))
        for kind in ("<f8", "<f4", "<i8", "<u8", "<i4", "<u4", "<i2", "<u2", "|i1", "|u1"):
            name = f"whole-{order}-{kind[1:]}.npy"
            save(root / name, np.array(WHOLE, kind, order=order), (1, 0))


main()
