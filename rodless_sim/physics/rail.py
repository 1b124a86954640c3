# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rail's tilt: its share of gravity on the carriage, m g sin θ."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.force import Force
from rodless_sim.physics.state import Motion

STANDARD_GRAVITY = 9.80665  # m/s²

PARAMETERS = declare(
    Parameter(
        "rail.tilt",
        0.0,
        "rad",
        "tilt θ of the rail, positive with chamber B's end up",
        "level, as in the paper's photograph",
        -math.pi / 2.0,
        math.pi / 2.0,
    )
)


class Rail(NamedTuple):
    """Constants of the rail."""

    weight: float  # N, along the rail toward chamber A's end


def of(parameters: ParameterSet) -> Rail:
    """Return the constants for ``parameters``."""
    mass, tilt = parameters.number("cylinder.moving_mass"), parameters.number("rail.tilt")
    return Rail(mass * STANDARD_GRAVITY * math.sin(tilt))


@kernel
def force(rail: Rail, state: Motion) -> Force:  # noqa: ARG001
    """Force on the carriage, positive toward chamber B's end: the same wherever it is."""
    return Force(-rail.weight, 0.0, 0.0)
