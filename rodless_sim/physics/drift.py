# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction that changes slowly by itself, as the paper's first cause of errors has it.

F_s, F_c and B of both directions each have a factor e^w. Their w are walks of their own, pulled
back to where they began,

    dw = −w/τ dt + s dW

in steps of 10 ms of plant time, exact for any τ: after a time t well below τ the spread of w is
s √t, in the end s √(τ/2). The numbers are those of ``friction.drift_seed``, and so begin anew with
each reset.

The generator is that of Wichmann and Hill, *Algorithm AS 183*, Applied Statistics 31, 1982: three
small whole numbers, which one float can hold, so that the dice are a state as any other.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.friction import Friction
from rodless_sim.physics.friction_forms.direction import Direction
from rodless_sim.physics.sources import JUDGEMENT, PAPER

PARAMETERS = declare(
    Parameter(
        "friction.drift",
        0.0,
        "1/√s",
        "how far friction drifts: spread of ln F_s, ln F_c and ln B after 1 s; 0 for not at all",
        f"{PAPER} names variable friction; {JUDGEMENT}: 0.02",
        0.0,
        1.0,
        fixed=True,
    ),
    Parameter(
        "friction.drift_time",
        60.0,
        "s",
        "time τ in which the drift forgets what it was",
        JUDGEMENT,
        1.0,
        1e6,
    ),
    Parameter(
        "friction.drift_seed",
        1,
        "",
        "draws the drift, from each reset on",
        "interface",
        0,
        2**31 - 1,
    ),
)

STEP = 0.01  # s
# A step that ends within this of the next instant ends there.
ROUNDING = 1e-9  # s

# Moduli and multipliers.
PRIMES = (30269, 30307, 30323)
MULTIPLIERS = (171, 172, 170)

Array = npt.NDArray[np.float64]


class Drift(NamedTuple):
    """Constants of the drift."""

    acting: bool
    seed: int
    keeps: float  # what is left of a deviation after STEP
    spread: float  # of what a step adds

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Drift":
        """Return the constants for ``parameters``."""
        size, time = (parameters.number(f"friction.{name}") for name in ("drift", "drift_time"))
        return cls(
            acting=size > 0.0,
            seed=int(parameters.number("friction.drift_seed")),
            keeps=math.exp(-STEP / time),
            spread=size * math.sqrt(-0.5 * time * math.expm1(-2.0 * STEP / time)),
        )


def first_dice(seed: int) -> float:
    """Return the dice that ``seed`` stands for: seeds near each other give others altogether."""
    words = np.random.SeedSequence(seed).generate_state(len(PRIMES))
    found = [1 + int(word) % (prime - 1) for word, prime in zip(words, PRIMES, strict=True)]
    return float(found[0] + PRIMES[0] * (found[1] + PRIMES[1] * found[2]))


@kernel
def thrown(dice: float) -> tuple[float, float]:
    """Throw the dice: return them as they lie then, and a number from 0 to 1."""
    packed = int(dice)
    first = MULTIPLIERS[0] * (packed % PRIMES[0]) % PRIMES[0]
    rest = packed // PRIMES[0]
    second = MULTIPLIERS[1] * (rest % PRIMES[1]) % PRIMES[1]
    third = MULTIPLIERS[2] * (rest // PRIMES[1]) % PRIMES[2]
    total = first / PRIMES[0] + second / PRIMES[1] + third / PRIMES[2]
    return float(first + PRIMES[0] * (second + PRIMES[1] * third)), total % 1.0


@kernel
def stepped(drift: Drift, dice: float, deviations: Array) -> float:
    """Write the deviations one STEP later, and return the dice as they lie then."""
    for k in range(deviations.size):
        dice, one = thrown(dice)
        dice, other = thrown(dice)
        # Box and Muller. No throw is 0: the primes have no common multiple so small.
        normal = math.sqrt(-2.0 * math.log(max(one, 1e-12))) * math.cos(2.0 * math.pi * other)
        deviations[k] = drift.keeps * deviations[k] + drift.spread * normal
    return dice


@kernel
def drifted_side(side: Direction, static: float, coulomb: float, viscous: float) -> Direction:
    """Return the values of one direction times e to these; F_s is never below F_c."""
    dry = math.exp(coulomb) * side.coulomb
    return Direction(
        max(math.exp(static) * side.static, dry),
        dry,
        side.stribeck_velocity,
        math.exp(viscous) * side.viscous,
    )


@kernel
def drifted_friction(friction: Friction, static: float, coulomb: float, viscous: float) -> Friction:
    """Return the friction that has drifted so far."""
    return Friction(
        friction.form,
        friction.own,
        drifted_side(friction.forward, static, coulomb, viscous),
        drifted_side(friction.reverse, static, coulomb, viscous),
        friction.capture_velocity,
    )
