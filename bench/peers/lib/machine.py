"""The computer: its description, its load, and the other processes during a run."""
import os
import pathlib
import platform
import resource
import subprocess
import sys
import time

# The largest load average at which a measurement starts.
QUIET = 0.5
# A run counts as disturbed if other processes use more processors than this.
DISTURBED = 0.1
# Seconds of observation of the processors before a run, and of the pause after they were busy.
GLANCE, PAUSE = 0.3, 2.0
# Smallest time in seconds that a run waits for idle processors. A measurement takes hours, and load varies.
PATIENCE = 120
TICK = os.sysconf("SC_CLK_TCK")


class Busy(Exception):
    """Other processes use the computer."""


def busy_seconds():
    """Processor seconds of all processes since the start of the computer, and those taken by the host (Linux)."""
    counts = pathlib.Path("/proc/stat").read_text().split("\n")[0].split()
    user, nice, system, _, _, irq, softirq, steal = map(int, counts[1:9])
    return (user + nice + system + irq + softirq + steal) / TICK


def children_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime + own.ru_utime + own.ru_stime


class Others:
    """Measures how many processors other processes use within the block, to a few hundredths."""

    def __enter__(self):
        self.start, self.all, self.own = time.perf_counter(), busy_seconds(), children_seconds()
        return self

    def __exit__(self, *_):
        self.seconds = time.perf_counter() - self.start
        used = busy_seconds() - self.all - (children_seconds() - self.own)
        # The kernel counts ticks, so that one or two may be assigned to the wrong side.
        self.processors = max(0.0, used - 2 / TICK) / self.seconds


def start_quiet(wait, busy):
    """Waits up to `wait` seconds for a load below QUIET. Otherwise raises an error, unless load is allowed."""
    end = time.monotonic() + wait
    while (load := os.getloadavg()[0]) > QUIET and not busy:
        if time.monotonic() > end:
            raise Busy(f"the load is {load:.2f}, above {QUIET}: wait (--wait SECONDS), or --busy for figures of no worth")
        print(f"load {load:.2f}, waiting", file=sys.stderr)
        time.sleep(min(10, max(0.1, end - time.monotonic())))


def settle(wait, busy):
    """Waits for idle processors before a run. The load average includes the runs before it, so it is not used here."""
    end = time.monotonic() + max(wait, PATIENCE)
    while not busy:
        with Others() as others:
            time.sleep(GLANCE)
        if others.processors <= DISTURBED:
            return
        if time.monotonic() > end:
            raise Busy(f"others have used {others.processors:.2f} processors for long")
        time.sleep(PAUSE)


def first_line(*command):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.splitlines()[0]
    except (OSError, IndexError):
        return "unknown"


def described():
    """Facts that accompany every figure."""
    info = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    model = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), platform.machine())
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {"processor": model, "cores": os.cpu_count(), "memory_gib": round(memory / 2**30, 1),
            "system": platform.freedesktop_os_release().get("PRETTY_NAME", platform.system()), "kernel": platform.release(),
            "compiler": first_line("g++", "--version"), "load_at_start": round(os.getloadavg()[0], 2),
            "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())}
