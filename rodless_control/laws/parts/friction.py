# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What overcomes friction: a force, or a voltage, in the direction of the move that is wanted.

    f = static·tanh(e / static_width) + coulomb·tanh(ρ / coulomb_width) + viscous·ρ
    ρ = ṙ + lead·r̈   while ṙ ≠ 0, otherwise 0

The first term breaks a carriage loose that sticks off its target; it acts on the error e, since at
rest there is no velocity to go by. The others go with the reference's velocity, which is free of
noise, and ahead of it by the time that valve and air take: where the motion reverses, friction
changes its sign at once, and a force does not.

Armstrong-Hélouvry, Dupont, Canudas de Wit, "A survey of models, analysis tools and compensation
methods for the control of machines with friction", *Automatica* 30(7), 1994, 1083-1138, section 5.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare


class Friction(NamedTuple):
    """Constants of the compensation, in the unit of force or voltage of the law."""

    static: float
    static_width: float  # m
    coulomb: float
    coulomb_width: float  # m/s
    viscous: float  # per m/s
    lead: float  # s

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Friction":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(
            parameters.number(f"{law}.static_friction"),
            parameters.number(f"{law}.static_width"),
            parameters.number(f"{law}.coulomb_friction"),
            parameters.number(f"{law}.coulomb_width"),
            parameters.number(f"{law}.viscous_friction"),
            parameters.number(f"{law}.friction_lead"),
        )


def declared(law: str, unit: str, friction: Friction, source: str) -> dict[str, Parameter]:
    """Return the part's parameters as those of ``law``, in its ``unit``: N or V."""
    return declare(
        Parameter(
            f"{law}.static_friction",
            friction.static,
            unit,
            "compensation of static friction, in the direction of the error",
            source,
            0.0,
            200.0,
        ),
        Parameter(
            f"{law}.static_width",
            friction.static_width,
            "m",
            "error at which three quarters of it act",
            source,
            1e-6,
            0.1,
        ),
        Parameter(
            f"{law}.coulomb_friction",
            friction.coulomb,
            unit,
            "compensation of Coulomb friction, in the direction of the reference's velocity",
            source,
            0.0,
            200.0,
        ),
        Parameter(
            f"{law}.coulomb_width",
            friction.coulomb_width,
            "m/s",
            "velocity of the reference at which three quarters of it act",
            source,
            1e-5,
            1.0,
        ),
        Parameter(
            f"{law}.viscous_friction",
            friction.viscous,
            f"{unit}·s/m",
            "compensation of viscous friction, by the reference's velocity",
            source,
            0.0,
            1e4,
        ),
        Parameter(
            f"{law}.friction_lead",
            friction.lead,
            "s",
            "how far ahead of the reference Coulomb and viscous friction are compensated",
            source,
            0.0,
            0.1,
        ),
    )


@kernel
def compensation(friction: Friction, error: float, velocity: float, acceleration: float) -> float:
    """Force or voltage for ``error`` (m) and the reference's ``velocity`` and ``acceleration``."""
    coming = velocity + friction.lead * acceleration if velocity != 0.0 else 0.0
    return (
        friction.static * math.tanh(error / friction.static_width)
        + friction.coulomb * math.tanh(coming / friction.coulomb_width)
        + friction.viscous * coming
    )
