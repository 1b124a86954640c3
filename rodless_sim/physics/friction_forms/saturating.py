# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Eq. (29) with a viscous term that bends above creep speed."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.friction_forms.direction import Direction, Drag, dry
from rodless_sim.physics.sources import JUDGEMENT

NAME = "saturating"
MEANING = "its viscous term bends above creep speed"
PARAMETERS = declare(
    Parameter(
        "friction.high_speed_viscous",
        80.0,
        "N·s/m",
        "viscous coefficient B_2 well above the saturation velocity (saturating form)",
        f"{JUDGEMENT}: maker's speed range 50-500 mm/s",
        0.0,
        1e5,
    ),
    Parameter(
        "friction.saturation_velocity",
        5e-3,
        "m/s",
        "speed v_k over which the viscous term bends (saturating form)",
        JUDGEMENT,
        1e-4,
        1.0,
    ),
)


class Saturating(NamedTuple):
    """Constants of the bend, the same in both directions."""

    high_speed_viscous: float  # N·s/m
    saturation_velocity: float  # m/s


def of(parameters: ParameterSet) -> Saturating:
    """Return the constants for ``parameters``."""
    return Saturating(
        parameters.number("friction.high_speed_viscous"),
        parameters.number("friction.saturation_velocity"),
    )


@kernel
def force(constants: Saturating, side: Direction, speed: float) -> Drag:
    """Friction at ``speed`` >= 0 (m/s): B falls to its high-speed value."""
    knee = constants.saturation_velocity
    fading = math.exp(-speed / knee)
    high = constants.high_speed_viscous
    found = dry(side, speed)
    return Drag(
        found.force + (high * speed + (side.viscous - high) * (knee * (1.0 - fading))),
        found.by_speed + (high + (side.viscous - high) * fading),
    )
