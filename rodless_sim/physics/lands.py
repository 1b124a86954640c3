"""The openings of the valve's four land edges."""

from typing import NamedTuple


class Edge(NamedTuple):
    """One land edge."""

    orifice_area: float  # m², C_v·S of its orifice
    gap: float  # kg/(s·Pa²), conductance of its gap


class Lands(NamedTuple):
    """The edges at one spool position: one pair opens, the other closes."""

    forward: bool  # A's supply and B's exhaust open
    opening: Edge
    closing: Edge
