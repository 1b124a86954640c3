# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The openings of the valve's four land edges."""

from typing import Any, NamedTuple

from rodless_sim.physics.spool import Spool


class Edge(NamedTuple):
    """One land edge."""

    orifice_area: float  # m², C_v·S of its orifice
    gap: float  # kg/(s·Pa²), conductance of its gap


class Lands(NamedTuple):
    """The edges at one spool position: one pair opens, the other closes."""

    forward: bool  # A's supply and B's exhaust open
    opening: Edge
    closing: Edge


class Course(NamedTuple):
    """The openings of a valve whose spool moves, at one instant: :mod:`course` lets it go on."""

    spool: Spool
    lands: Lands
    horizon: float  # s, how far a step may reach
    passes: bool  # whether the spool passes the closed position there


class Arriving(NamedTuple):
    """What comes out of tubes into the chambers: what the valve's openings are without any."""

    a: float  # kg/s
    b: float  # kg/s


class Timed(NamedTuple):
    """A valve's openings or their course, where the equations change with plant time, too."""

    time: float  # s, since the start or the last reset
    supply: float  # Pa, at the valve
    valve: Any  # Lands or Course
    tubes: Any  # air_in_tubes.Tubes, () without any


AnyCourse = Lands | Course | Arriving | Timed
