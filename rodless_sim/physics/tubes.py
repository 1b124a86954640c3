# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The tubes between valve and chambers, as parameters and constants.

What they do is in :mod:`~rodless_sim.physics.air_in_tubes`.
"""

import math
from typing import NamedTuple

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

DELAY = "delay"

PARAMETERS = declare(
    Parameter(
        "tubes.model",
        "none",
        "",
        "tubes between valve and chambers: none: air arrives at once; delay: it arrives after the "
        "time of sound, and loses pressure on the way",
        "docs/options/tubes.md",
        choices=("none", DELAY),
        fixed=True,
    ),
    Parameter(
        "tubes.length",
        0.6,
        "m",
        f"length of each tube ({DELAY})",
        JUDGEMENT,
        0.05,
        20.0,
        fixed=True,
    ),
    Parameter(
        "tubes.diameter",
        4e-3,
        "m",
        f"inner diameter of each tube ({DELAY})",
        JUDGEMENT,
        1e-3,
        2e-2,
        fixed=True,
    ),
)


class Tube(NamedTuple):
    """Constants of each tube."""

    length: float  # m
    diameter: float  # m
    delay: float  # s, that sound takes


def of(parameters: ParameterSet) -> Tube | tuple[()]:
    """Return the constants for ``parameters``; none without tubes."""
    if parameters.text("tubes.model") != DELAY:
        return ()
    number = parameters.number
    sound = math.sqrt(
        number("air.isentropic_index") * number("air.gas_constant") * number("supply.temperature")
    )
    length = number("tubes.length")
    return Tube(length, number("tubes.diameter"), length / sound)


def check(parameters: ParameterSet) -> None:
    """Refuse tubes that hold more than the dead volume they are part of.

    What leaves a chamber is on its way for the time of sound, whatever becomes of the chamber: one
    much smaller than its tube would be emptied below vacuum.
    """
    if parameters.text("tubes.model") != DELAY:
        return
    length, diameter = parameters.number("tubes.length"), parameters.number("tubes.diameter")
    held = 0.25 * math.pi * diameter**2 * length
    for name in ("cylinder.dead_volume_a", "cylinder.dead_volume_b"):
        volume = parameters.number(name)
        if volume < held:
            raise ParameterError(
                f"{name}: {volume:g} m³ refused, the tube is part of it and holds {held:.3g} m³ "
                f"(tubes.length {length:g} m, tubes.diameter {diameter:g} m): raise it, or give a "
                "smaller tube"
            )
