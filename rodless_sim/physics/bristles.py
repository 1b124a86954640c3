# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction with a memory: the LuGre model of the contact, in place of stick and slip as states.

The surfaces meet in elastic bristles of the mean deflection z. At small motion they are a spring;
at a steady speed they slip, and carry what eq. (29) gives:

    dz/dt = v − σ₀ |v| z / g(v)               F = σ₀ z + σ₁(v) dz/dt + F_v(v)
    g(v) = F_c + (F_s − F_c) e^(−(v/v_s)²)    σ₁(v) = σ₁ e^(−(v/v_d)²)

g and F_v, the viscous rest, are those of ``friction.form`` in the direction of the motion. The
damping σ₁ of the bristles fades with speed: with a constant one, dz/dt < 0 while the carriage
accelerates would make friction drive it (Olsson and Åström).

Canudas de Wit, Olsson, Åström and Lischinsky, *A new model for control of systems with friction*,
IEEE Transactions on Automatic Control 40, 1995.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.friction import Friction, form_force, side_of
from rodless_sim.physics.friction_forms.direction import Direction, dry
from rodless_sim.physics.sources import JUDGEMENT

LUGRE = "lugre"
SOURCE = "Canudas de Wit et al. 1995"

PARAMETERS = declare(
    Parameter(
        "friction.dynamics",
        "static",
        "",
        "what friction remembers: static: nothing, eq. (28); lugre: the deflection of bristles",
        "docs/options/lugre.md",
        choices=("static", LUGRE),
        fixed=True,
    ),
    Parameter(
        "friction.bristle_stiffness",
        2e5,
        "N/m",
        f"stiffness σ₀ of the bristles ({LUGRE})",
        f"{JUDGEMENT}: seals that slip after 0.15 mm",
        1e3,
        1e8,
    ),
    Parameter(
        "friction.bristle_damping",
        600.0,
        "N·s/m",
        f"damping σ₁ of the bristles at rest ({LUGRE})",
        f"{JUDGEMENT}: damping ratio 0.67 with 1 kg",
        0.0,
        1e5,
    ),
    Parameter(
        "friction.bristle_damping_speed",
        0.01,
        "m/s",
        f"speed v_d at which σ₁ has faded to 1/e ({LUGRE})",
        f"{JUDGEMENT}: some Stribeck velocities",
        1e-4,
        10.0,
    ),
)

# Where there is no dry friction the bristles slip at this force: they carry nothing.
LEAST = 1e-9  # N


class Bristles(NamedTuple):
    """Constants of the bristles."""

    acting: bool
    stiffness: float  # N/m
    damping: float  # N·s/m
    damping_speed: float  # m/s

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Bristles":
        """Return the constants for ``parameters``."""
        return cls(
            parameters.text("friction.dynamics") == LUGRE,
            *(parameters.number(f"friction.bristle_{name}") for name in cls._fields[1:]),
        )


class Contact(NamedTuple):
    """What bristles do to a body, and what becomes of them."""

    force: float  # N, against the motion
    rate: float  # m/s, of their deflection


@kernel
def contact(bristles: Bristles, friction: Friction, velocity: float, deflection: float) -> Contact:
    """Friction on a body of this ``velocity`` (m/s), its bristles deflected by so much (m)."""
    speed = abs(velocity)
    direction = 1 if velocity >= 0.0 else -1
    side = side_of(friction, direction)
    level = dry(side, speed).force
    viscous = form_force(friction.form, friction.own, side, speed).force - level
    slip = bristles.stiffness * speed / max(level, LEAST)
    rate = velocity - slip * deflection
    faded = math.exp(-((speed / bristles.damping_speed) ** 2))
    force = bristles.stiffness * deflection + bristles.damping * faded * rate
    return Contact(force + direction * viscous, rate)


@kernel
def growth(bristles: Bristles, side: Direction, speed: float, slope: float) -> float:
    """Return how fast (1/s) motion at ``speed`` (m/s) runs away where friction falls with it.

    Rigid, it would by ``slope`` (1/s). Bristles that must bend first are slower: about steady
    sliding λ² + a λ = a · slope, a = σ₀ v/g(v).
    """
    bend = bristles.stiffness * speed / max(dry(side, speed).force, LEAST)
    if slope <= 0.0 or bend <= 0.0:
        return min(slope, 0.0)
    return 2.0 * bend * slope / (bend + math.sqrt(bend * (bend + 4.0 * slope)))
