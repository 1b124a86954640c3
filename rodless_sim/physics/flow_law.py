# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How the flow through an orifice of the valve follows from the pressures, in one of several laws.

A law is one module of ``flow_laws`` with ``NAME``, ``MEANING``, its own ``PARAMETERS``, its
constants ``of(parameters)``, and a kernel ``function(constants, air, ratio)``: the dimensionless
flow ψ = ṁ √(R T) / (C_v S P_1) at ``ratio`` r = P_2/P_1 ≤ 1, and dψ/dr. Where it has
``check(parameters)``, that raises ParameterError for values that contradict each other.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from rodless_base.kernels import dispatch, kernel
from rodless_base.parameters import ParameterSet, collect
from rodless_base.sockets import choices, chooser
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow, pressure_ratio, throttled
from rodless_sim.physics.sources import PAPER

LAWS = choices(
    "rodless_sim.physics.flow_laws",
    (
        "nozzle",
        "iso_6358",
    ),
    kernels=("function",),
)

PARAMETERS = collect(
    chooser("valve.flow_law", LAWS, f"{PAPER}, eq. (6)"),
    *(law.PARAMETERS for law in LAWS),
)


class FlowLaw(NamedTuple):
    """The law in use."""

    code: int  # its place in LAWS
    own: tuple[Any, ...]  # each law's own constants

    @classmethod
    def of(cls, parameters: ParameterSet) -> "FlowLaw":
        """Return the constants for ``parameters``."""
        return cls(
            code=parameters.choice("valve.flow_law"),
            own=tuple(law.of(parameters) for law in LAWS),
        )


function: Callable[..., tuple[float, float]] = dispatch([law.function for law in LAWS])


@kernel
def orifice(law: FlowLaw, air: Air, area: float, pressure_1: float, pressure_2: float) -> Flow:
    """Flow from side 1 to side 2 of an orifice of the valve; ``area`` is C_v·S in m²."""
    if area == 0.0:
        return Flow(0.0, 0.0, 0.0)
    ratio = pressure_ratio(pressure_1, pressure_2)
    found, slope = function(law.code, law.own, air, ratio)
    return throttled(air, area, pressure_1, pressure_2, found, slope)
