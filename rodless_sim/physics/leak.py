# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Leaks that the paper leaves out: past the piston's seal, and from each chamber to ambient.

Each is an orifice, eqs. (6), (7), at the temperature of the air.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import orifice
from rodless_sim.physics.sources import JUDGEMENT

# What an orifice of this size passes empties a chamber in a fraction of a second.
LARGEST = 1e-5  # m²


def _declared(name: str, where: str, source: str) -> dict[str, Parameter]:
    meaning = f"effective area of the leak {where}"
    return declare(Parameter(f"leak.{name}", 0.0, "m²", meaning, source, 0.0, LARGEST))


PARAMETERS = {
    **_declared("across", "between the chambers", f"{JUDGEMENT}: 5e-9 m² for a worn seal"),
    **_declared("a", "from chamber A to ambient", JUDGEMENT),
    **_declared("b", "from chamber B to ambient", JUDGEMENT),
}


class Leak(NamedTuple):
    """Effective areas of the leaks."""

    open: bool  # whether there is any
    across: float  # m², between the chambers
    a: float  # m², from chamber A to ambient
    b: float  # m², from chamber B to ambient

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Leak":
        """Return the constants for ``parameters``."""
        areas = [parameters.number(f"leak.{name}") for name in ("across", "a", "b")]
        return cls(any(areas), *areas)


class Leaking(NamedTuple):
    """What leaks out of a chamber, and how it changes with both pressures."""

    mass_flow: float  # kg/s
    by_pressure: float  # kg/(s·Pa), with the chamber's own
    by_other: float  # kg/(s·Pa), with the other chamber's


@kernel
def leaking(
    leak: Leak, air: Air, ambient: float, pressure_a: float, pressure_b: float
) -> tuple[Leaking, Leaking]:
    """What leaks out of chambers A and B; pressures in Pa."""
    across = orifice(air, leak.across, pressure_a, pressure_b)
    a = orifice(air, leak.a, pressure_a, ambient)
    b = orifice(air, leak.b, pressure_b, ambient)
    return (
        Leaking(
            a.mass_flow + across.mass_flow,
            a.by_pressure_1 + across.by_pressure_1,
            across.by_pressure_2,
        ),
        Leaking(
            b.mass_flow - across.mass_flow,
            b.by_pressure_1 - across.by_pressure_2,
            -across.by_pressure_1,
        ),
    )
