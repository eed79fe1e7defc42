#!/usr/bin/env python3
"""Ends runs of several processes in every way, and checks that all processes end with no output left.

    bench/accept/ends.py target/release/septet [--mpi target/release/septet-mpi] [--command simulate] [--kills 20]
        [--points 300000]

Each row kills a process (KILL, TERM or INT) at random times, or plants a panic or the end of a rank in a phase. A run that ends
must have the exit code of the row, all its processes must be gone within five seconds, and no file may be under the name of
an output, unless all outputs are complete. A signal may arrive after the end of the run. Such a run is repeated. Exit code 1 if
a check fails.
"""
import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROCESSES = 4
SECONDS = 5.0
PHASES = {
    "triangulate": "load partition halo pieces seam hulls check certificate merge collect".split(),
    "simulate": "load partition choice radii neighbours summaries separator-sets graph hulls check certificate merge "
                "collect".split(),
}


class Program:
    """A way to start several processes."""

    def __init__(self, name, command, task, after):
        self.name, self.command, self.task, self.after = name, command, task, after

    def start(self, points, folder, *extra):
        outputs = [word for name in ("c.npy", "m.vtu", "m.pvtu") for word in ("-o", str(folder / name))]
        command = [*self.command, self.task, str(points), "--workers", "8", "-q", *outputs, *self.after, *extra]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def processes(folder, program):
    """The ids of the processes of a run, in the order of their start. Their arguments name the folder of the outputs."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            started = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[19])
        except (OSError, IndexError):
            continue
        if words and Path(os.fsdecode(words[0])).name == program and any(os.fsencode(folder) in w for w in words):
            found.append((started, int(entry.name)))
    return [pid for _, pid in sorted(found)]


def running(pids):
    return [pid for pid in pids if " Z " not in status(pid)]


def any_ended(pids):
    return len(running(pids)) < len(pids)


def status(pid):
    try:
        return (Path("/proc") / str(pid) / "stat").read_text()
    except OSError:
        return " Z "


def left(folder):
    """The outputs under their names, with their bytes. Temporary files may remain after a process was killed."""
    files = (path for path in folder.rglob("*") if path.is_file())
    names = ((str(path.relative_to(folder)), path) for path in files)
    return {name: path.read_bytes() for name, path in names if ".partial" not in name}


def finish(child, pids, folder, codes, whole):
    """Waits for the end of a run. Returns the defects, and the seconds from the first end of a process to the last."""
    while child.poll() is None and not any_ended(pids):
        time.sleep(0.005)
    begin = time.monotonic()
    try:
        _, said = child.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        child.kill()
        return [f"the run did not end: {sorted(running(pids))}"], 60.0
    while running(pids) and time.monotonic() - begin < SECONDS:
        time.sleep(0.02)
    seconds, defects = time.monotonic() - begin, []
    if running(pids) or seconds > SECONDS:
        defects.append(f"after {seconds:.1f} s, {len(running(pids))} processes are left")
    if child.returncode not in codes:
        defects.append(f"exit code {child.returncode}, not {codes}: {said.strip()[:200]}")
    # A process may be lost after the outputs got their names.
    if (found := left(folder)) and found != whole:
        defects.append(f"files are left: {sorted(found)}")
    return defects, seconds


def signalled(program, points, victim, sent, codes, seconds, whole):
    """One run, of which a process receives a signal. Returns `None` if the run ended before."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        child = program.start(points, folder)
        time.sleep(random.uniform(0.02, 0.95) * seconds)
        pids = processes(folder, program.name)
        if child.poll() is not None or len(pids) <= victim:
            child.communicate()
            return None
        try:
            os.kill(pids[victim], sent)
        except ProcessLookupError:
            child.communicate()
            return None
        defects, took = finish(child, pids, folder, codes, whole)
        # The signal may have arrived when the outputs already had their names.
        return None if child.returncode == 0 else (defects, took)


def planted(program, points, fault, codes, whole):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        child = program.start(points, folder, "--fault", fault)
        pids = []
        while child.poll() is None and len(pids) < PROCESSES:
            pids = processes(folder, program.name) or pids
            time.sleep(0.005)
        return finish(child, pids, folder, codes, whole)


def row(name, results):
    defects = [defect for found, _ in results for defect in found]
    longest = max((seconds for _, seconds in results), default=0.0)
    print(f"| {name} | {len(results)} | {longest:.2f} | {'; '.join(defects) or 'none'} |", flush=True)
    return bool(defects)


def check(program, points, kills):
    with tempfile.TemporaryDirectory() as name:
        begin = time.monotonic()
        _, said = (child := program.start(points, Path(name))).communicate()
        seconds = time.monotonic() - begin
        whole = left(Path(name))
        if child.returncode != 0 or len(whole) != 11:
            sys.exit(f"{program.name}: a run without a signal fails: {said}")
    print(f"\n{program.name} {program.task}, {PROCESSES} processes, {seconds:.1f} s without a signal\n\n"
          "| end | runs | seconds until all are gone, at most | defects |\n| --- | --- | --- | --- |", flush=True)
    failed = False
    lost = [code for code in range(1, 256)] + [-9]
    # A signal that arrives before the program handles it has the usual exit code of the signal.
    rows = [("KILL", signal.SIGKILL, lost, kills), ("TERM", signal.SIGTERM, [130, 143], max(2, kills // 5)),
            ("INT", signal.SIGINT, [130], max(2, kills // 5))]
    for name, sent, codes, runs in rows:
        for victim in range(PROCESSES):
            results = []
            for _ in range(10 * runs):
                if (result := signalled(program, points, victim, sent, codes, seconds, whole)) is not None:
                    results.append(result)
                if len(results) == runs:
                    break
            failed |= row(f"{name} of process {victim}", results) or len(results) < runs
    for phase in PHASES[program.task]:
        for fault, codes in ((f"panic:3:{phase}", [101, 6]), (f"die:5:{phase}", [6])):
            failed |= row(fault, [planted(program, points, fault, codes, whole)])
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("septet")
    parser.add_argument("--mpi", help="also check this septet-mpi")
    parser.add_argument("--mpirun", default="mpirun --oversubscribe --bind-to none")
    parser.add_argument("--command", default="triangulate", choices=sorted(PHASES))
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--points", type=int, default=300_000)
    options = parser.parse_args()
    task = options.command
    programs = [Program("septet", [options.septet], task, ["--transport", "processes", "--processes", str(PROCESSES)])]
    if options.mpi:
        programs.append(Program("septet-mpi", [*options.mpirun.split(), "-n", str(PROCESSES), options.mpi], task, []))
    with tempfile.TemporaryDirectory() as name:
        points = Path(name) / "points.npy"
        subprocess.run([options.septet, "generate", "uniform", "-n", str(options.points), "-o", str(points), "-q"], check=True)
        failed = [check(program, points, options.kills) for program in programs]
    sys.exit(any(failed))


if __name__ == "__main__":
    main()
