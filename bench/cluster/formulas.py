"""The formulas of `bench/cluster-model`: rounds, messages, bytes and memory of `triangulate` on p workers.

Limits and parameters come from the source. Lengths of messages are derived from their fields.
"""
import collections
import functools
import math
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NODE_MEMORY = 64 << 30
# Cells per point of uniform points in space.
CELLS = 6.77
# Exchanges outside of the machine in which each process sends to all: agreements on errors, names and counts. They were
# counted in the calls of a process without workers (`strace`), which takes part in no exchange of the machine.
OUTSIDE = 43


def constant(path, name):
    """Returns a constant of the source."""
    with open(os.path.join(ROOT, path)) as file:
        found = re.search(rf"\bconst {name}: \w+ = ([^;]+);", file.read())
    if not found or not re.fullmatch(r"[\d_.<*+\- ]+", found[1]):
        sys.exit(f"{path}: there is no number {name}")
    return eval(found[1].replace("_", ""))


FAN = constant("workers/src/machine/group_tree.rs", "FAN")
SHARE = constant("workers/geometry/src/separator/bisect.rs", "SHARE")
LEAST_SAMPLES = constant("workers/geometry/src/separator/sampler.rs", "SAMPLE_TARGET")
MOST_SAMPLES = constant("workers/geometry/src/separator/bisect.rs", "MOST")
MOST_IN_A_PIECE = constant("workers/src/config.rs", "MOST_IN_A_PIECE")
MOST_POINTS = constant("workers/geometry/src/incremental/triangulation.rs", "MOST_POINTS")
MOST_WORKERS = constant("src/core/spec/groups.rs", "MOST_WORKERS")
MOST_COUNT = constant("workers/protocol/src/message/defects.rs", "MOST")
FRAME_LIMIT = constant("workers/protocol/src/codec.rs", "FRAME_LIMIT")
GROUPED = constant("src/lab/report/traffic.rs", "MOST_BINS")
ROW_SAMPLES = constant("src/io/write/shared/sort.rs", "SAMPLES")

# Bytes of messages. The envelope has 42 bytes with the kind of the body, and the length of an array has 8.
ENVELOPE, LENGTH, PLACE, PAIR = 42, 8, 24, 12
POINT = 8 + PLACE + 4 + 8  # index, coordinates, owner, radius
MOVED = 8 + PLACE
BATCH = ENVELOPE + 4 * LENGTH
SURVEY = ENVELOPE + 65
START = BATCH + 16 + 4 * POINT
SPHERE = ENVELOPE + LENGTH + 9 * 8
SPLIT = 8 + 4 + 9 * 8 + 4 * PLACE  # node, ranks of a child, separator, corners of two boxes
COUNTS = ENVELOPE + 2 * 8 + LENGTH + 4 * PLACE
DECISION = ENVELOPE + 38 + LENGTH + 4 * PLACE
FINGERPRINT = ENVELOPE + 32
MERGED = ENVELOPE + 80
OUTCOME = ENVELOPE + 1
TOTALS = ENVELOPE + 120
FIXED = {("load", SURVEY), ("load", START), ("partition", SPHERE), ("partition", COUNTS), ("check", FINGERPRINT),
         ("merge", MERGED), ("merge", OUTCOME), ("collect", TOTALS)}
# A row of a link and a row of a rank in a round, in the ledger that process 0 gathers.
LINK_ROW, RANK_ROW = 6 * 8, 10 * 8
# Memory of a process for each other process: the lists of its hashes, its region, and twice the rows of the ledger.
OTHER_PROCESS = 48 + 2 * SPLIT + 2 * (LINK_ROW + RANK_ROW)


def surface(h):
    """Returns the area of the faces of a subdomain, as a multiple of the last face.

    A separator above k levels splits 2^(k+1) m points. Its area grows like (2^k m)^(2/3), and 2^k subdomains on each side
    share it. So it adds 2^(-k/3) to the faces of a subdomain.
    """
    return sum(2 ** (-k / 3) for k in range(h))


def levels(p):
    """Returns the levels of the tree of all ranks: t."""
    level, rank = 0, p
    while rank > 0:
        level, rank = level + 1, (rank - 1) // FAN
    return level


def height(ranks):
    """Returns the height of the tree of a group."""
    h = 0
    while ranks > 1:
        h, ranks = h + 1, -(-(ranks - 1) // FAN)
    return h


@functools.cache
def branches(ranks):
    """Returns the members of a group except its leader: {(level, members of the branch): number}."""
    found = collections.Counter()
    parts = min(FAN, ranks - 1)
    for i in range(parts):
        size = (ranks - 1) * (i + 1) // parts - (ranks - 1) * i // parts
        found[1, size] += 1
        for (level, members), number in branches(size).items():
            found[level + 1, members] += number
    return found


def samples(points):
    """Returns the expected number of samples of a separator."""
    return min(points, max(LEAST_SAMPLES, min(MOST_SAMPLES, SHARE * points ** (2 / 3))))


def groups(p):
    """Returns the groups of each shared level: (number of groups, ranks of a group, their height, that of the parent)."""
    shared = [(1 << level, p >> level) for level in range(p.bit_length() - 1)]
    return [(number, ranks, height(ranks), height(2 * ranks) if number > 1 else 0) for number, ranks in shared]


def partition(n, p):
    """Returns rounds, messages and bytes of phase partition, for separators that are accepted at once."""
    rounds, messages, sent = 1, 0, 0.0
    for number, ranks, tall, above in groups(p):
        points, others, tree = n / number, ranks - 1, branches(ranks)
        if above == 1:  # Samples travel with the points, from the members of the parent to both leaders.
            rounds += 1 + 3 * tall
            of_samples, hops = 2 * ranks - 1, 1 - 1 / (2 * ranks)
        else:
            rounds += (above > 1) + 4 * tall
            of_samples, hops = others, sum(level * count for (level, _), count in tree.items()) / ranks
        routes = (3 * ranks - 2) / ranks  # Most members send to two others, and keep points.
        own = sum(count * (COUNTS + DECISION + 4 * LENGTH + PAIR * routes if members == 1 else
                           COUNTS + 16 * members + DECISION + 3 * LENGTH + (8 + PAIR * routes) * members)
                  for (_, members), count in tree.items())
        messages += number * (of_samples + 3 * others + 2 * others)
        sent += number * (of_samples * (ENVELOPE + LENGTH) + PLACE * samples(points) * hops + others * SPHERE + own
                          + 2 * others * BATCH + MOVED * points / 2)
    return {"rounds": rounds, "messages": messages, "bytes": sent}


def dense(n, p):
    """Returns the number of pairs of workers that exchange hashes of coordinates."""
    return p * (p - 1) * -math.expm1(n / p * math.log1p(-1 / p))


def equal_hashes(n):
    """Returns the expected number of pairs of different points whose hashes of 64 bits are equal."""
    return n * n / 2**65


def largest_share(n, p):
    """Returns the points of the largest subdomain: each median of s samples is off by 1/sqrt(s) of a side."""
    spread = math.sqrt(sum(1 / samples(n / number) for number, *_ in groups(p)))
    z = math.sqrt(2 * math.log(p))
    z -= (math.log(math.log(p)) + math.log(4 * math.pi)) / (2 * z)
    return n / p * (1 + z * spread)


def thick(terms):
    """A layer of constant width: its second term has the edges, which are m^(-1/3) of the faces."""
    return lambda h, m: [t * m ** (2 / 3) * edge for t in terms(h) for edge in (1, m ** (-1 / 3))]


# Laws per worker, by number of shared levels h and points per worker m: the terms, whose constants are fitted.
LAWS = {
    "halo points": thick(lambda h: [surface(h)]),
    "seam points": thick(lambda h: [surface(h)]),
    "facets": thick(lambda h: [surface(h)]),
    "halo messages": lambda h, m: [1, surface(h)],
    "neighbours": lambda h, m: [1, surface(h)],
    "facet messages": lambda h, m: [1, surface(h)],
}


def splits(p):
    """Returns rounds, messages and bytes in which all workers learn the splits of all shared nodes.

    At each level, every worker sends the splits below its child to one worker of the other child.
    """
    children = [p >> level for level in range(1, p.bit_length() - 1)]
    return len(children), p * len(children), p * sum(BATCH + SPLIT * (ranks - 1) for ranks in children)


class Model:
    """The formulas of a run with fitted constants."""

    def __init__(self, fitted):
        self.fitted = fitted

    def law(self, name, n, p):
        terms = LAWS[name](p.bit_length() - 1, n / p)
        return p * sum(c * t for c, t in zip(self.fitted[name], terms))

    def seam_messages(self, p):
        """Returns the messages of the interface exchange. A worker at the surface of the cube has cells with large conflict
        regions, which reach many workers at the surface. Two workers are a pair with this probability."""
        return p * (p - 1) * -math.expm1(-self.fitted["seam pairs"][0] * p ** (-2 / 3))

    def phases(self, n, p):
        """Returns rounds, messages and bytes of each phase."""
        h, t = p.bit_length() - 1, levels(p)
        keys, alike = dense(n, p), equal_hashes(n)
        asked = min(2 * alike, p * (p - 1))
        halo, near, seam = self.law("halo messages", n, p), self.law("neighbours", n, p), self.seam_messages(p)
        # The leader of two ranks is one of them, and no other leader leads a child of its node.
        merged = sum(number * min(2, ranks - 1) for number, ranks, *_ in groups(p)) + 1
        facets, pairs = self.law("facets", n, p), self.law("facet messages", n, p)
        check = {"rounds": 1, "messages": near, "bytes": FINGERPRINT * near}
        return {
            "load": {"rounds": 4 * t + (3 if alike >= 1 else 1), "messages": 4 * p + keys + 2 * asked,
                     "bytes": 2 * p * (SURVEY + START) + (ENVELOPE + LENGTH) * keys + 8 * n * (1 - 1 / p)
                     + asked * (ENVELOPE + LENGTH + BATCH) + alike * 2 * (4 + MOVED)},
            "partition": partition(n, p),
            "halo": {"rounds": splits(p)[0] + 1 + t, "messages": halo + splits(p)[1] + p + 4, "bytes": splits(p)[2]
                     + MOVED * self.law("halo points", n, p) + BATCH * halo + (BATCH + 4 * POINT) * p},
            "seam": {"rounds": 1, "messages": seam, "bytes": MOVED * self.law("seam points", n, p) + BATCH * seam},
            "check": check, "certificate": check,
            "merge": {"rounds": h + 1 + t, "messages": merged + p, "bytes": MERGED * merged + OUTCOME * p},
            "collect": {"rounds": 2 + 2 * t, "messages": 2 * pairs + 2 * p,
                        "bytes": 40 * facets + (2 * ENVELOPE + 5 * LENGTH) * pairs + 2 * p * TOTALS},
        }

    def total(self, n, p, count):
        return sum(phase[count] for phase in self.phases(n, p).values())

    def root_leader(self, n, p):
        """Returns the bytes that the leader of the root receives in phase partition."""
        return self.phases(n, p)["partition"]["bytes"] / p + PLACE * samples(n) * (1 - 1 / p)

    def largest_sent(self, n, p):
        """Returns the bytes of the largest sender: surfaces of subdomains differ, and the difference adds up by level."""
        phases, uneven = self.phases(n, p), self.fitted["uneven"][0] * (p.bit_length() - 1)
        near = sum(phases[name]["bytes"] for name in ("halo", "seam", "collect"))
        return (self.total(n, p, "bytes") + uneven * near) / p

    def ghosts(self, n, p):
        h, m = p.bit_length() - 1, n / p
        return sum(c * t for c, t in zip(self.fitted["ghosts"], thick(lambda h: [surface(h)])(h, m)))

    def memory(self, n, p):
        """Returns the memory of the largest process, before process 0 gathers the ledgers."""
        base, each = self.fitted["memory"]
        return base + each * (largest_share(n, p) + self.ghosts(n, p)) + OTHER_PROCESS * p

    def ledger(self, n, p):
        """Returns the memory in which process 0 gathers the ledgers, as parcels and as words at the same time.

        A message adds a row of its link and a row of its receiver in the round, unless an earlier message has added it.
        """
        rounds, messages = self.total(n, p, "rounds"), self.total(n, p, "messages")
        return 2 * ((LINK_ROW + RANK_ROW) * messages + RANK_ROW * p * rounds)


LIMITS = f"""Limits: `workers`: more than {MOST_WORKERS:,} workers. `piece`: n/p is above {MOST_IN_A_PIECE:,}, or points and ghosts
of a worker above {MOST_POINTS:,}. `counts`: more than 2^44 cells. `message`: a move of all points of a worker is above 4 GiB.
`memory`: a process needs more than 64 GiB. `ledgers`: process 0 needs more than 64 GiB with the ledgers of all processes.
`rows`: for one output file, the samples of rows need more memory than the piece."""


def limits(model, n, p):
    """Returns the limits that a run exceeds, as a list of the names in `LIMITS`."""
    memory, points = model.memory(n, p), largest_share(n, p) + model.ghosts(n, p)
    return [name for name, is_above in {
        "workers": p > MOST_WORKERS,
        "piece": n // p > MOST_IN_A_PIECE or points > MOST_POINTS,
        "counts": CELLS * n >= MOST_COUNT,
        "message": MOVED * n / p > FRAME_LIMIT,
        "memory": memory > NODE_MEMORY,
        "ledgers": memory <= NODE_MEMORY < memory + model.ledger(n, p),
        "rows": 2 * row_samples(p) > memory,
    }.items() if is_above]


def row_samples(p):
    """Returns the bytes of the samples that every process receives before it sorts the rows of one output file."""
    return ROW_SAMPLES * p * 4 * 8
