# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The equations without their contradictions: continuous through the closed position.

Every port has two edges. The opening edge passes the orifice flow and, fading out as the land
clears, its gap; the closing edge passes the gap, which lengthens with the spool's travel from
closed.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics import flow
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.sources import JUDGEMENT
from rodless_sim.physics.valve import SPOOL_GAIN, Valve, centred_area, flow_coefficient

NAME = "reconciled"
MEANING = "reconciled"
PARAMETERS = declare(
    Parameter(
        "valve.gap_fade_voltage",
        0.2,
        "V",
        "deflection at which the opening edge's gap flow has faded by e (Gaussian)",
        f"{JUDGEMENT}: force on a held piston monotone, 5.24 V creeps as in Fig. 13",
        0.01,
        5.0,
    )
)


class Reconciled(NamedTuple):
    """Constants of the blend."""

    gap_fade_voltage: float  # V


def of(parameters: ParameterSet) -> Reconciled:
    """Return the constants for ``parameters``."""
    return Reconciled(parameters.number("valve.gap_fade_voltage"))


@kernel
def lands(constants: Reconciled, air: Air, valve: Valve, voltage: float) -> Lands:
    """Openings at ``voltage`` (V).

    The fade is flat at the closed position: the orifice opens with the square of the deflection,
    and a gap that faded linearly there would close the edge first and push a held piston backwards.
    """
    deflection = voltage - valve.closed_voltage
    perimeter = math.pi * valve.spool_diameter
    overlap = valve.gap_length + abs(SPOOL_GAIN * deflection)
    area = flow_coefficient(valve, deflection) * centred_area(valve, deflection)
    fade = math.exp(-((deflection / constants.gap_fade_voltage) ** 2))
    opening_gap = fade * flow.gap_conductance(air, perimeter, valve.gap_height, valve.gap_length)
    closing_gap = flow.gap_conductance(air, perimeter, valve.gap_height, overlap)
    return Lands(deflection >= 0.0, Edge(area, opening_gap), Edge(0.0, closing_gap))


@kernel
def gap(
    constants: Reconciled,  # noqa: ARG001
    air: Air,  # noqa: ARG001
    edge: Edge,
    pressure_1: float,
    pressure_2: float,
) -> Flow:
    """Flow through the gap of an edge, its density following the pressure."""
    return flow.gap(edge.gap, pressure_1, pressure_2)
