# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The values of Table 2 for one direction of motion, and the dry friction all forms share."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import PAPER

SOURCE = f"{PAPER}, Table 2"


class Direction(NamedTuple):
    """Magnitudes for one direction of motion."""

    static: float  # N
    coulomb: float  # N
    stribeck_velocity: float  # m/s
    viscous: float  # N·s/m

    @classmethod
    def of(cls, parameters: ParameterSet, side: str) -> "Direction":
        """Return the constants of ``side``, forward or reverse."""
        return cls(*(parameters.number(f"friction.{side}.{name}") for name in cls._fields))


def declare_direction(side: str, default: Direction) -> dict[str, Parameter]:
    """Declare the parameters of ``side``, forward or reverse."""
    prefix, motion = f"friction.{side}", f"{side} motion"
    static, coulomb, velocity, viscous = default
    return declare(
        Parameter(
            f"{prefix}.static",
            static,
            "N",
            f"breakaway force F_s, {motion}",
            SOURCE,
            0.0,
            1e4,
        ),
        Parameter(
            f"{prefix}.coulomb",
            coulomb,
            "N",
            f"Coulomb force F_c, {motion}",
            SOURCE,
            0.0,
            1e4,
        ),
        Parameter(
            f"{prefix}.stribeck_velocity",
            velocity,
            "m/s",
            f"Stribeck velocity v_s, {motion}",
            SOURCE,
            1e-4,
            1.0,
        ),
        Parameter(
            f"{prefix}.viscous",
            viscous,
            "N·s/m",
            f"viscous coefficient B, {motion}",
            SOURCE,
            0.0,
            1e5,
        ),
    )


def check_direction(parameters: ParameterSet, side: str) -> None:
    """Refuse a breakaway force below the Coulomb force."""
    found = Direction.of(parameters, side)
    if found.static < found.coulomb:
        raise ParameterError(
            f"friction.{side}.static: {found.static:g} N refused, below "
            f"friction.{side}.coulomb ({found.coulomb:g} N)"
        )


class Drag(NamedTuple):
    """A friction force, and how it changes with the speed."""

    force: float  # N
    by_speed: float  # N·s/m


@kernel
def dry(side: Direction, speed: float) -> Drag:
    """Dry part of eq. (29) at ``speed`` >= 0 (m/s): from F_s down to F_c."""
    ratio = speed / side.stribeck_velocity
    drop = (side.static - side.coulomb) * math.exp(-(ratio**2))
    return Drag(side.coulomb + drop, -2.0 * ratio / side.stribeck_velocity * drop)
