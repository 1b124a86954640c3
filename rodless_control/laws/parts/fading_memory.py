# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Position, velocity and acceleration from positions, without lag in position.

The fading-memory filter of second degree predicts with constant acceleration over the interval T
and corrects by the innovation ε, with a triple pole at p = exp(−bandwidth·T):

    y⁻ = ŷ + T·v̂ + ½T²·(â + k)      ε = y − y⁻
    ŷ  = y⁻ + (1 − p³)·ε
    v̂ ← v̂ + T·(â + k) + 1.5·(1 − p)²·(1 + p)/T·ε
    â ← â + (1 − p)³/T²·ε

Along constant acceleration all three come to be exact. k is an acceleration that is known, such as
that of a measured force; â is then what it does not explain: the disturbance. With it this is the
extended state observer in discrete time, current form.

Morrison, *Introduction to Sequential Smoothing and Prediction*, 1969, chapter 13 (the filter);
Miklosovic, Radke, Gao, "Discrete implementation and generalization of the extended state observer",
American Control Conference 2006 (the same gains).
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, declare
from rodless_control.laws.parts.saturation import within

# No estimate is larger, in its unit. Wild readings at wild intervals would let it grow for ever.
LARGEST = 1e9


class Motion(NamedTuple):
    """What is estimated of the carriage."""

    position: float  # m
    velocity: float  # m/s
    acceleration: float  # m/s², beyond what is known


def declared(law: str, bandwidth: float, source: str) -> dict[str, Parameter]:
    """Return the part's parameter as that of ``law``."""
    return declare(
        Parameter(
            f"{law}.filter_bandwidth",
            bandwidth,
            "rad/s",
            "bandwidth of the filter that estimates position, velocity and acceleration",
            source,
            1.0,
            1e5,
        )
    )


@kernel
def at_rest(position: float) -> Motion:
    """Motion of a carriage at rest at ``position`` (m)."""
    return Motion(position, 0.0, 0.0)


@kernel
def estimated(
    bandwidth: float, motion: Motion, position: float, known: float, interval: float
) -> Motion:
    """Estimates after a ``position`` (m) read ``interval`` s after the one before.

    ``known`` is k in m/s². An interval of 0 changes nothing.
    """
    if interval <= 0.0:
        return motion
    pole = math.exp(-bandwidth * interval)
    rest = -math.expm1(-bandwidth * interval)
    acceleration = motion.acceleration + known
    predicted = motion.position + interval * (motion.velocity + 0.5 * interval * acceleration)
    innovation = position - predicted
    velocity = motion.velocity + interval * acceleration
    velocity += 1.5 * rest * rest * (1.0 + pole) / interval * innovation
    unknown = motion.acceleration + rest * rest * rest / (interval * interval) * innovation
    return Motion(
        within(predicted + (1.0 - pole * pole * pole) * innovation, -LARGEST, LARGEST),
        within(velocity, -LARGEST, LARGEST),
        within(unknown, -LARGEST, LARGEST),
    )
