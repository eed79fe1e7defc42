"""Exact Delaunay triangulations, Voronoi diagrams and meshes in the plane and in space.

========================  =======================================================================================
`Delaunay`                triangulation, location, interpolation, alpha shapes
`Voronoi`                 cells and ridges, unbounded or in a box
`mesh`                    a mesh of a domain
`simulate`, `read_run`    the paper's algorithm on a counted machine
`verify`                  an independent check of any triangulation
`read`                    points and cells of a file
========================  =======================================================================================

Conventions
-----------
Points have the shape (n, 2) or (n, 3), and any real type that float64 holds exactly; nothing is rounded silently. Arrays
are C-contiguous and read-only. Indices are int32, or int64 from 2**31 points or simplices on; -1 means none. Results depend
on the arguments only, and not on threads. Calls release the interpreter's lock, and end soon after Ctrl-C.
"""

from ._alpha import AlphaFiltration, AlphaShape
from ._delaunay import Delaunay
from ._errors import DomainError, Error, InputError, MemoryLimitError, OptionError, PointError, RunError
from ._files import Cells, Verdict, read, verify
from ._machine import Run, read_run, simulate
from ._mesh import Mesh, mesh
from ._ragged import Ragged, Weights
from ._septet import VERSION as __version__
from ._types import Floats, Ids, Method, Period, Progress
from ._voronoi import Voronoi

__all__ = [
    "AlphaFiltration",
    "AlphaShape",
    "Cells",
    "Delaunay",
    "DomainError",
    "Error",
    "Floats",
    "Ids",
    "InputError",
    "MemoryLimitError",
    "Mesh",
    "Method",
    "OptionError",
    "Period",
    "PointError",
    "Progress",
    "Ragged",
    "Run",
    "RunError",
    "Verdict",
    "Voronoi",
    "Weights",
    "__version__",
    "mesh",
    "read",
    "read_run",
    "simulate",
    "verify",
]
