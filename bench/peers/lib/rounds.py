"""The measurement: in each round, all programs run on a set in turn, so that drift affects all equally."""
import signal
import sys

from lib import machine, programs, sets


def say(*words):
    print(*words, file=sys.stderr, flush=True)


def one_run(program, one, options):
    """A record of a run: figures and `others`, or `stopped` with the reason."""
    machine.settle(options.wait, options.busy)
    record = {"set": one.name, "program": program.name, "threads": program.threads}
    try:
        with machine.Others() as others:
            figures = programs.run(program, options.binary, one.path, options.limit)
    except (programs.Failed, programs.TooLong) as error:
        return record | {"stopped": str(error)}
    return record | figures | {"others": round(others.processors, 3)}


def septet_checks(chosen, one, options):
    """Returns the cells of septet on a set, by program, from runs that are not timed."""
    checks = {}
    for program in chosen:
        if not program.driver and one.dimension in program.dimensions:
            try:
                checks[program.name] = programs.septet_cells(options.binary, one.path, program.threads, options.limit)
            except (programs.Failed, programs.TooLong) as error:
                checks[program.name] = {"stopped": str(error)}
            say(f"{one.name}: cells of {program.name}: {checks[program.name]}")
    return checks


def until_stopped(work):
    """Runs the measurement. Returns the reason for an early end, or None. Earlier results are kept."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        work()
    except (machine.Busy, sets.Unknown, programs.Failed, programs.TooLong) as error:
        return str(error)
    except KeyboardInterrupt:
        return "interrupted"
    return ""


def measure(chosen, options, facts, runs, checks):
    """All rounds on all sets, into `facts` of the sets, `runs`, and septet's `checks` by set and program."""
    for one in options.asked:
        sets.make(one, options.binary)
        facts.append(sets.facts(one))
        checks[one.name] = septet_checks(chosen, one, options)
        taking_part = [p for p in chosen if one.dimension in p.dimensions]
        for number in range(options.repeat):
            for program in list(taking_part):
                run = one_run(program, one, options) | {"round": number}
                runs.append(run)
                if "stopped" in run:
                    # A program that exceeded the limit once would exceed it again.
                    taking_part.remove(program)
                    say(f"{one.name}: {program.name}: {run['stopped']}")
                else:
                    say(f"{one.name}: round {number + 1}: {program.name} {run['seconds']:.3f} s, others {run['others']:.2f}")
