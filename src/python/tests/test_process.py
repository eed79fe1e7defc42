"""Threads, forks, signals, progress and memory."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from typing import Any, List

import numpy as np
import pytest
import septet


def run(script: str, seconds: float = 60) -> "subprocess.CompletedProcess[str]":
    """Runs a script in a process of its own."""
    command = [sys.executable, "-c", textwrap.dedent(script)]
    return subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_fork_after_a_call() -> None:
    script = """
        import os, warnings
        warnings.simplefilter("ignore")
        import numpy as np, septet
        points = np.random.default_rng(1).random((30_000, 3))
        tri = septet.Delaunay(points)
        before = tri.find_simplex(points, threads=2)
        child = os.fork()
        if child == 0:
            again = septet.Delaunay(points)
            same = (again.simplices == tri.simplices).all() and (tri.find_simplex(points) == before).all()
            cells = septet.Voronoi(tri).volumes
            verdict = septet.verify(points, again.simplices).ok
            os._exit(0 if same and len(cells) == 30_000 and verdict else 1)
        print(os.waitpid(child, 0)[1])
    """
    done = run(script)
    assert done.stdout.strip() == "0", done.stderr


# The calls take longer than the time until the signal and the time in which they must end.
CALLS = {
    "triangulate": "septet.Delaunay(np.random.default_rng(1).random((3_000_000, 3)))",
    "one_thread": "septet.Delaunay(np.random.default_rng(1).random((3_000_000, 3)), threads=1)",
    "weights": "tri.weights(np.random.default_rng(2).random((3_000_000, 3)), 'sibson')",
    "simulate": "septet.simulate(np.random.default_rng(1).random((400_000, 3)))",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Windows")
@pytest.mark.parametrize("name", CALLS)
def test_interrupt_ends_a_call(name: str) -> None:
    script = f"""
        import sys, time
        import numpy as np, septet
        tri = septet.Delaunay(np.random.default_rng(1).random((20_000, 3)))
        rng = np.random.default_rng(1)
        print("ready", flush=True)
        try:
            {CALLS[name]}
            print("ended")
        except KeyboardInterrupt:
            print(time.time())
        assert len(septet.Delaunay(rng.random((100, 2))).points) == 100
    """
    child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline().strip() == "ready"
    time.sleep(1.5)
    sent = time.time()
    child.send_signal(signal.SIGINT)
    out = child.communicate(timeout=60)[0].strip()
    assert child.returncode == 0 and out != "ended", out
    assert float(out) - sent < 1.0


def test_other_threads_run_meanwhile() -> None:
    points = np.random.default_rng(1).random((200_000, 3))
    done: List[Any] = []
    thread = threading.Thread(target=lambda: done.append(septet.Delaunay(points)))
    turns, latest, longest = 0, time.perf_counter(), 0.0
    thread.start()
    while thread.is_alive():
        time.sleep(0.001)
        now = time.perf_counter()
        turns, longest, latest = turns + 1, max(longest, now - latest), now
    thread.join()
    assert len(done) == 1 and turns > 20 and longest < 1.0


def test_threads_share_an_object() -> None:
    rng = np.random.default_rng(1)
    points, x = rng.random((30_000, 3)), rng.random((30_000, 3))
    tri = septet.Delaunay(points)
    expected = [tri.find_simplex(x), tri.nearest_vertex(x)]
    fresh = septet.Delaunay(points)
    found: List[Any] = [None] * 4
    seen: List[Any] = [None] * 4

    def work(i: int) -> None:
        found[i] = [fresh.find_simplex(x), fresh.nearest_vertex(x)]
        seen[i] = fresh.simplices

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((a == b).all() for pair in found for a, b in zip(pair, expected))
    assert all(array is seen[0] for array in seen)


def test_two_constructions_at_once() -> None:
    sets = [np.random.default_rng(i).random((30_000, 2)) for i in range(3)]
    expected = [septet.Delaunay(points).simplices for points in sets]
    found: List[Any] = [None] * 3

    def work(i: int) -> None:
        found[i] = septet.Delaunay(sets[i]).simplices

    threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((a == b).all() for a, b in zip(found, expected))


def test_progress_is_called_on_the_thread_of_the_caller() -> None:
    seen: List[Any] = []

    def progress(phase: str, position: int, phases: int) -> None:
        seen.append((threading.get_ident(), time.perf_counter(), phase, position, phases))

    septet.Delaunay(np.random.default_rng(1).random((100_000, 3)), progress=progress)
    assert seen and {entry[0] for entry in seen} == {threading.get_ident()}
    assert all(isinstance(phase, str) and 0 <= position <= phases for _, _, phase, position, phases in seen)
    times = [entry[1] for entry in seen]
    # The last call may follow at once.
    assert all(b - a > 0.09 for a, b in zip(times[:-2], times[1:-1]))
    seen.clear()
    septet.Delaunay([[0, 0], [1, 0], [0, 1]], progress=progress)
    assert seen


def test_an_exception_of_progress_ends_the_call() -> None:
    class Stop(Exception):
        pass

    def progress(phase: str, position: int, phases: int) -> None:
        raise Stop(phase)

    points = np.random.default_rng(1).random((500_000, 3))
    start = time.perf_counter()
    with pytest.raises(Stop):
        septet.Delaunay(points, progress=progress)
    assert time.perf_counter() - start < 10
    with pytest.raises(Stop):
        septet.simulate(points[:50_000], progress=progress)
    with pytest.raises(Stop):
        septet.verify(points[:20_000], septet.Delaunay(points[:20_000]).simplices, progress=progress)


def test_calls_leak_no_memory() -> None:
    script = """
        import gc, os
        import numpy as np, septet
        points = np.random.default_rng(1).random((1000, 3))
        def call():
            tri = septet.Delaunay(points, threads=1)
            tri.simplices, tri.neighbors, tri.edges, tri.find_simplex(points), tri.weights(points[:50], "sibson")
            try:
                septet.Delaunay([[np.nan, 0]])
            except septet.PointError:
                pass
        def rss():
            gc.collect()
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        for _ in range(100):
            call()
        before = rss()
        for _ in range(1000):
            call()
        print(rss() - before)
    """
    if not os.path.exists("/proc/self/statm"):
        pytest.skip("this system has no /proc")
    done = run(script, 300)
    assert int(done.stdout) < 8_000_000, done.stderr


def test_import_takes_only_numpy() -> None:
    script = """
        import sys, septet
        print([name for name in ("scipy", "meshio", "pyvista", "gudhi") if name in sys.modules])
    """
    assert run(script).stdout.strip() == "[]"
