"""Objects are independent of their arguments, and keep their threads."""

from __future__ import annotations

import signal
import threading
import time

import numpy as np
import pytest

import septet


def test_arguments_may_change_during_a_call() -> None:
    points = np.random.default_rng(0).random((200_000, 3))
    given = points.copy()

    def change() -> None:
        time.sleep(0.05)
        points[:] = points[::-1].copy()

    thread = threading.Thread(target=change)
    thread.start()
    made = septet.Delaunay(points)
    thread.join()
    assert np.array_equal(made.points, given)
    assert made.volumes.min() > 0
    assert (made.find_simplex(given[:1000]) >= 0).all()


def test_a_box_is_copied() -> None:
    low, high = np.zeros(2), np.ones(2)
    cells = septet.Voronoi(np.random.default_rng(1).random((50, 2)), box=(low, high))
    high[:] = 3
    assert cells.vertices.max() <= 1
    assert cells.volumes.sum() == pytest.approx(1, abs=1e-12)


def test_an_object_is_made_once() -> None:
    made = septet.Delaunay(np.random.default_rng(2).random((20, 2)))
    with pytest.raises(AttributeError):
        made.__init__(np.zeros((3, 2)))  # type: ignore[misc]
    cells = septet.Voronoi(made)
    with pytest.raises(AttributeError):
        cells.__init__(np.zeros((3, 2)))  # type: ignore[misc]
    assert made.points.shape == (20, 2)


def test_counts_are_those_of_the_request() -> None:
    stats = septet.Delaunay(np.random.default_rng(3).random((50, 3)), seed=7, threads=1).stats
    assert stats["parameters"]["seed"] == 7
    assert stats["machine"]["workers"] == 1


def test_flat_points_have_no_cells() -> None:
    cells = septet.Voronoi([[0, 0], [1, 1]])
    with pytest.raises(septet.OptionError):
        cells.volumes


def test_many_threads_are_no_more_than_some_for_each_core() -> None:
    points = np.random.default_rng(4).random((5000, 2))
    start = time.monotonic()
    made = septet.Delaunay(points, threads=8192)
    assert time.monotonic() - start < 20
    assert np.array_equal(made.simplices, septet.Delaunay(points, threads=1).simplices)


class Alarm(Exception):
    """Raised by the handler of a signal."""


def test_slow_queries_hear_signals() -> None:
    line = np.linspace(0, 1, 100_000)
    flat = septet.Delaunay(np.column_stack([line, line]))
    queries = np.random.default_rng(5).random((30_000, 2))

    def ring(*_: object) -> None:
        raise Alarm

    old = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    start = time.monotonic()
    try:
        with pytest.raises(Alarm):
            flat.nearest_vertex(queries, threads=1)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)
    assert time.monotonic() - start < 1.3
