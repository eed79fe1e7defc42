#!/usr/bin/env python3
"""Counts the seeds at which a claim detects a fault, and the seeds at which it passes without one.

    bench/accept/power.py target/release/septet level-depth slow:partition:log slow:partition:log:0.6
"""
import json
import subprocess
import sys
import tempfile

SEEDS = range(1, 21)


def passes(septet, claim, seed, fault):
    """Returns whether the claim passes at this seed, on a machine with the fault if there is one."""
    with tempfile.NamedTemporaryFile(suffix=".json") as report:
        planted = ["--fault", fault] if fault else []
        command = [septet, "reproduce", claim, "--seed", str(seed), "-q", "--json", report.name, *planted]
        code = subprocess.run(command, stdout=subprocess.DEVNULL).returncode
        # A failed claim has exit code 4. Any other failure is not a result.
        if code not in (0, 4):
            sys.exit(f"{' '.join(command)}: exit code {code}")
        with open(report.name) as file:
            return json.load(file)["passed"]


def main():
    septet, claim, *faults = sys.argv[1:]
    for fault in [None, *faults]:
        passed = sum(passes(septet, claim, seed, fault) for seed in SEEDS)
        what = f"detects {fault} at {len(SEEDS) - passed}" if fault else f"passes at {passed}"
        print(f"{claim} {what} of {len(SEEDS)} seeds", flush=True)


if __name__ == "__main__":
    main()
