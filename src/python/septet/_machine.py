"""Runs of the paper's algorithm on a counted machine."""

from __future__ import annotations

import ast
import json
import os
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union

import numpy as np

from . import _arguments as arguments
from . import _septet
from ._delaunay import Delaunay
from ._errors import InputError, OptionError
from ._lazy import Lazy

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Period

SUPERGRAPHS = ("density", "overlap", "knn")
SETS = ("ghost", "own", "smaller", "both")


class Run(Lazy):
    """A run of the paper's algorithm with its counts.

    `simulate` makes it, and `read_run` reads it from a report.

    Attributes
    ----------
    delaunay : Delaunay
        The triangulation. A run that was read has none.
    report : dict
        The JSON of ``septet simulate --json``, with the same keys.
    phases, rounds, levels : ndarray
        Tables of the report: structured arrays with the names of its rows.

    Examples
    --------
    >>> import numpy as np
    >>> import septet
    >>> run = septet.simulate(np.random.default_rng(1).random((500, 2)), workers=4)
    >>> run.report["machine"]["workers"]
    4
    >>> int(run.phases["messages"].sum()) == run.report["machine"]["messages"]
    True
    >>> run.check("levels(1.5, 0)")
    """

    __module__ = "septet"
    __slots__ = ("_text", "_machine")
    _text: str
    _machine: Optional[_septet.Machine]

    def __init__(self) -> None:
        raise TypeError("septet.simulate or septet.read_run make a Run")

    @classmethod
    def _of(cls, text: str, machine: Optional[_septet.Machine]) -> Run:
        made = cls.__new__(cls)
        made._set("_text", text)
        made._set("_machine", machine)
        made._set("_cache", {})
        return made

    def __reduce__(self) -> Any:
        return _restored, (self._text, None if self._machine is None else self.delaunay)

    def __repr__(self) -> str:
        report = self.report
        return f"<septet.Run: {report['points']['used']} points, {report['machine']['workers']} workers>"

    @property
    def delaunay(self) -> Delaunay:
        """The triangulation. A run that was read from a report has none, which is an error."""
        made: Optional[Delaunay] = self._cache.get("delaunay")
        if made is not None:
            return made
        machine = self._machine
        if machine is None:
            raise InputError("a report has no triangulation; call septet.simulate with the points")
        core = machine.core()
        made = self._made("delaunay", lambda: Delaunay._of(core))
        assert made is not None
        return made

    @property
    def report(self) -> Dict[str, Any]:
        """The JSON of ``septet simulate --json``, with the same keys. Each access returns a new dict."""
        made: Dict[str, Any] = json.loads(self._text)
        return made

    @property
    def phases(self) -> Any:
        """The rows `phases` of the report, with its names: phase, rounds, messages, bytes, work, depth, and so on."""
        return self._made("phases", lambda: _table(self.report["phases"]))

    @property
    def rounds(self) -> Any:
        """The rows `rounds` of the report, with its names: round, phase, messages, bytes, and so on."""
        return self._made("rounds", lambda: _table(self.report["rounds"]))

    @property
    def levels(self) -> Any:
        """The rows `tree.by_level` of the report, with its names."""
        return self._made("levels", lambda: _table((self.report.get("tree") or {}).get("by_level") or []))

    def check(self, claim: str) -> None:
        """Check a claim about the counts, and raise AssertionError with a table of the counts if it does not hold.

        Parameters
        ----------
        claim : str
            One of the checks of septet's assertions with its bounds. n is the number of points:

            - ``levels(slope, constant)``: the tree has at most slope log2 n + constant levels below its root
            - ``levels_over_leaf(slope, constant)``: the same with n over the size of a leaf
            - ``rounds('phase', slope, constant)``: the phase sends messages in at most so many rounds
            - ``merges(slope, constant)``: results are merged in at most so many rounds
            - ``messages_per_worker('phase', slope, constant)``
            - ``bytes('phase', factor)``: at most factor n^(1 - 1/d) bytes
            - ``depth_of_levels('phase', most)``
            - ``no_repair()``: no star changed after the local hulls

        Raises
        ------
        AssertionError
            If the claim does not hold.
        OptionError
            If there is no such claim, or if the run was read from a report.
        """
        name, words, numbers = _claim(claim)
        if self._machine is None:
            raise OptionError("only a run of septet.simulate in this process can be checked")
        broken = self._machine.check(name, words, numbers)
        if broken is not None:
            raise AssertionError(f"{claim}: {broken}")

    def write(self, path: "str | os.PathLike[str]") -> None:
        """Write the report: `.json`, or `.html` for the page.

        Parameters
        ----------
        path : str or path
            The file. It appears under its name when it is complete.
        """
        _septet.write_report(os.fsdecode(path), self._text)


def simulate(
    points: npt.ArrayLike,
    *,
    weights: Optional[npt.ArrayLike] = None,
    period: Optional[Period] = None,
    origin: Optional[npt.ArrayLike] = None,
    wrap: bool = False,
    workers: Union[int, str] = "auto",
    threads: Optional[int] = None,
    seed: int = 1,
    leaf: Optional[int] = None,
    supergraph: str = "auto",
    alpha: Optional[float] = None,
    k: Optional[int] = None,
    separator_sets: str = "ghost",
    progress: Optional[Any] = None,
) -> Run:
    """Run the paper's algorithm on a machine that counts rounds, messages, bytes, work and depth.

    Parameters
    ----------
    points : array_like of shape (n, 2) or (n, 3)
        See `Delaunay`.
    weights, period, origin, wrap : optional
        See `Delaunay`. In a periodic box, the machine also triangulates images of points.
    workers : int, 'auto' or 'leaves', optional
        Number of workers, or one for each leaf of the partition tree.
    threads : int, optional
        Number of threads; all cores by default. No count depends on it.
    seed : int, optional
        Seed of the random draws.
    leaf : int, optional
        Largest number of points in a leaf.
    supergraph : {'auto', 'density', 'overlap', 'knn'}, optional
        The graph that is expected to contain the triangulation; 'auto' is the density graph.
    alpha : float, optional
        Parameter of a density or overlap graph, at least 1.
    k : int, optional
        Parameter of a nearest-neighbour or overlap graph.
    separator_sets : {'ghost', 'own', 'smaller', 'both'}, optional
        How the children of a node share the points near their separator. 'none' is another name of 'ghost'.
    progress : callable, optional
        See `Delaunay`.

    Returns
    -------
    Run
    """
    options: List[Tuple[str, str]] = []
    if isinstance(workers, str):
        options.append(("workers", arguments.word(workers, "workers", ("auto", "leaves"))))
    else:
        options.append(("workers", str(arguments.whole(workers, "workers", 1, 1 << 20))))
    options.append(("seed", str(arguments.whole(seed, "seed", 0, 2**64 - 1))))
    count = arguments.threads(threads)
    if count is not None:
        options.append(("threads", str(count)))
    if supergraph != "auto":
        options.append(("supergraph", arguments.word(supergraph, "supergraph", SUPERGRAPHS)))
    if alpha is not None:
        options.append(("alpha", repr(arguments.number(alpha, "alpha"))))
    if k is not None:
        options.append(("k", str(arguments.whole(k, "k", 1, 2**32 - 1))))
    sets = "ghost" if separator_sets == "none" else arguments.word(separator_sets, "separator_sets", SETS)
    options.append(("separator-sets", sets))
    if leaf is not None:
        options.append(("leaf", str(arguments.whole(leaf, "leaf", 1, 2**63 - 1))))
    rows = arguments.points(points)
    given = arguments.sites(rows, weights, period, origin, wrap)
    machine = _septet.Machine(rows, options, given, arguments.progress(progress))
    return Run._of(machine.report(), machine)


def read_run(path: "str | os.PathLike[str]") -> Run:
    """Read a run from its JSON report. Its triangulation is not in the report.

    Parameters
    ----------
    path : str or path
        A report of ``septet simulate --json``, or of `Run.write`.

    Raises
    ------
    InputError
        If the file is no report of a run.
    """
    name = os.fsdecode(path)
    with open(name, "rb") as file:
        contents = file.read()
    try:
        text = contents.decode("utf-8")
        report = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _not_a_report(name, f"{error}", getattr(error, "lineno", None)) from None
    fault = _fault_of(report)
    if fault is not None:
        raise _not_a_report(name, fault, None)
    return Run._of(text, None)


def _fault_of(report: Any) -> Optional[str]:
    """Returns what a report of a run must have and this one has not."""
    if not isinstance(report, dict):
        return "it is not a JSON object"
    for name, kind in (("machine", dict), ("points", dict), ("phases", list), ("rounds", list)):
        if not isinstance(report.get(name), kind):
            return f"it has no {name}"
    if "workers" not in report["machine"] or "used" not in report["points"]:
        return "it has no numbers of workers and points"
    tree = report.get("tree")
    levels = tree.get("by_level") if isinstance(tree, dict) else tree
    tables = [report["phases"], report["rounds"], [] if levels is None else levels]
    if not all(isinstance(table, list) and all(isinstance(row, dict) for row in table) for table in tables):
        return "a table has no rows of names and values"
    return None


def _not_a_report(path: str, reason: str, line: Optional[int]) -> InputError:
    shown = path.encode("utf-8", "backslashreplace").decode()
    error = InputError(f"{shown}: not the report of a run: {reason}; give a file from `septet simulate --json`")
    error.path, error.line = path, line
    return error


def _restored(text: str, delaunay: Optional[Delaunay]) -> Run:
    made = Run._of(text, None)
    if delaunay is not None:
        made._cache["delaunay"] = delaunay
    return made


def _claim(claim: str) -> Tuple[str, List[str], List[float]]:
    """Splits a claim into its name, its words and its numbers."""
    wrong = OptionError(f"the claim {claim!r} is unknown; write it as 'levels(1.5, -5.0)', see help(septet.Run.check)")
    try:
        call = ast.parse(claim.strip(), mode="eval").body
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name) or call.keywords:
            raise wrong
        values = [ast.literal_eval(argument) for argument in call.args]
    except (SyntaxError, ValueError, AttributeError, TypeError):
        raise wrong from None
    words = [value for value in values if isinstance(value, str)]
    numbers = [float(value) for value in values if isinstance(value, (int, float))]
    if len(words) + len(numbers) != len(values):
        raise wrong
    return call.func.id, words, numbers


def _table(rows: List[Dict[str, Any]]) -> Any:
    """Returns rows as a structured array: whole numbers as int64, others as float64 with NaN for null, words as str."""
    names: List[str] = []
    for row in rows:
        names.extend(name for name in row if name not in names)
    columns = [(name, _column([row.get(name) for row in rows])) for name in names]
    table = np.empty(len(rows), dtype=[(name, column.dtype) for name, column in columns])
    for name, column in columns:
        table[name] = column
    return arguments.frozen(table)


def _column(values: List[Any]) -> Any:
    kinds = {type(value) for value in values}
    if kinds <= {int}:
        return np.array(values, dtype=np.int64)
    if kinds <= {bool}:
        return np.array(values, dtype=np.bool_)
    if kinds <= {int, float, type(None)}:
        return np.array([float("nan") if value is None else value for value in values], dtype=np.float64)
    if kinds <= {str, type(None)}:
        return np.array(["" if value is None else value for value in values])
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column
