"""Results of alpha complexes."""

from __future__ import annotations

from typing import Any, NamedTuple


class AlphaFiltration(NamedTuple):
    """The alpha complex: the squared radius from which on each simplex belongs to it, as in CGAL and gudhi.

    A face has at most the value of each simplex that it belongs to. Vertices have the value 0.
    """

    cells: Any
    """(m,). For the rows of simplices."""
    facets: Any
    """(f, d). All facets, sorted."""
    facet_values: Any
    """(f,)."""
    edges: Any
    """(e, 2). In the plane, edges are the facets."""
    edge_values: Any
    """(e,)."""


class AlphaShape(NamedTuple):
    """The alpha complex of a radius."""

    cells: Any
    """(m,). Whether each simplex belongs to it."""
    boundary: Any
    """(b, d). Facets between a simplex that belongs to it and one that does not, seen counter-clockwise from outside."""
    singular: Any
    """(s, d). Facets of the complex without a simplex of the complex on either side."""
    volume: float
    """The area or volume of the simplices of the complex."""


AlphaFiltration.__module__ = AlphaShape.__module__ = "septet"
